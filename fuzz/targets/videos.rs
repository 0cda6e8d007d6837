//! Video files, read in order and backwards. The first byte selects the name's ending and the options.

use occluscope::source::Options;
use occluscope::source::cache::FrameCache;

use super::check_message;
use super::folder::Folder;

const ENDINGS: [&str; 5] = ["mp4", "mkv", "avi", "ts", "webm"];

/// Frames that are read of a video.
const MOST_FRAMES: u32 = 12;
/// Pixels of a frame: a header can claim millions, and to decode so many again and again takes long.
const MOST_PIXELS: usize = 1 << 22;

/// Frames are of the announced size, and a frame that is read again is the same; or that it is not is reported, as FFmpeg
/// fills in what is missing from what happens to be in memory.
pub fn run(data: &[u8]) {
    let Some((&choice, content)) = data.split_first() else { return };
    let choice = usize::from(choice);
    let folder = Folder::new();
    let file = folder.write(&format!("video.{}", ENDINGS[choice % ENDINGS.len()]), content);
    let options = Options { deinterlace: choice / ENDINGS.len() % 2 == 1, ..Options::default() };
    // Without room for frames, each is decoded again.
    let mut cache = match FrameCache::open(file.to_str().unwrap(), options, 0) {
        Ok(cache) => cache,
        Err(error) => return check_message(&error.to_string()),
    };
    let size = cache.info().size;
    if size.pixels() > MOST_PIXELS {
        return;
    }
    let mut frames = Vec::new();
    for position in 0..MOST_FRAMES {
        match cache.get(position) {
            Ok(Some(frame)) => {
                assert_eq!((frame.size, frame.rgb.len()), (size, 3 * size.pixels()));
                frames.push(frame);
            }
            Ok(None) => break,
            Err(error) => {
                check_message(&error.to_string());
                break;
            }
        }
    }
    let mut differs = false;
    for (position, frame) in frames.iter().enumerate().rev() {
        match cache.get(position as u32) {
            Ok(again) => differs |= again.unwrap().rgb != frame.rgb,
            Err(error) => check_message(&error.to_string()),
        }
    }
    let warnings = cache.take_warnings();
    for warning in &warnings {
        check_message(warning);
    }
    assert!(!differs || warnings.iter().any(|warning| warning.contains("look different")), "{warnings:?}");
}
