//! The frame rate: from the user, the video, or MOTChallenge's `seqinfo.ini` beside images.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

/// Frames per second where no rate is given.
pub(super) const ASSUMED: f32 = 25.0;

/// The accepted range of frame rates.
pub const FPS_RANGE: (f32, f32) = (0.05, 1000.0);

/// The file with a sequence's properties, in the folder of the images or its parent.
pub(super) const SEQINFO: &str = "seqinfo.ini";
/// Maximum number of bytes of it that are read.
const MOST_BYTES: u64 = 1 << 16;

/// The origin of a frame rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FpsFrom {
    /// Given by the user.
    Given,
    /// Read from the video or the camera.
    Video,
    /// Read from `seqinfo.ini`.
    SeqInfo,
    /// Unknown; 25 is assumed.
    Assumed,
}

impl FpsFrom {
    /// The origin as one word, for files.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Given => "--fps",
            Self::Video => "video",
            Self::SeqInfo => SEQINFO,
            Self::Assumed => "assumed",
        }
    }
}

/// Whether a rate in a header is plausible as a frame rate. 1000 and above are clock rates of containers.
pub(super) fn is_plausible(fps: f64) -> bool {
    (0.05..1000.0).contains(&fps)
}

/// The rate given by the user, else the source's own if it is plausible, else the assumed one.
pub(super) fn choose(given: Option<f32>, own: Option<f64>) -> (f32, FpsFrom) {
    match (given, own.filter(|&fps| is_plausible(fps))) {
        (Some(fps), _) => (fps, FpsFrom::Given),
        (None, Some(fps)) => (fps as f32, FpsFrom::Video),
        (None, None) => (ASSUMED, FpsFrom::Assumed),
    }
}

/// Parses a frame rate; `None` where the text is not a number within [`FPS_RANGE`].
pub fn parse_fps(text: &str) -> Option<f32> {
    let (least, greatest) = FPS_RANGE;
    text.trim().parse().ok().filter(|fps| (least..=greatest).contains(fps))
}

/// The frame rate of a sequence of images.
#[derive(Debug, PartialEq)]
pub(super) struct ImageRate {
    /// Frames per second.
    pub(super) fps: f32,
    pub(super) from: FpsFrom,
    /// A warning where `seqinfo.ini` exists but gives no rate.
    pub(super) warning: Option<String>,
}

/// The frame rate in the `seqinfo.ini` in the folder of the images or its parent, else the assumed one.
pub(super) fn of_images(folder: &Path) -> ImageRate {
    let assumed = |warning| ImageRate { fps: ASSUMED, from: FpsFrom::Assumed, warning };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Some(path) = seqinfo(folder) else { return assumed(None) };
    match rate_in(&path) {
        Ok(fps) => ImageRate { fps, from: FpsFrom::SeqInfo, warning: None },
        Err(why) => {
            let text = format!(
                "{} is ignored: {why}; {ASSUMED} frames per second are assumed, set it with --fps",
                path.display()
            );
            assumed(Some(text.split_whitespace().collect::<Vec<_>>().join(" ")))
        }
    }
}

/// Whether there is a `seqinfo.ini` in the folder or its parent.
pub(super) fn is_described(folder: &Path) -> bool {
    seqinfo(folder).is_some()
}

fn seqinfo(folder: &Path) -> Option<PathBuf> {
    let beside = folder.join(SEQINFO);
    if beside.is_file() {
        return Some(beside);
    }
    // The path may be a link or contain dots.
    let whole = fs::canonicalize(folder).ok()?;
    let above = whole.parent()?.join(SEQINFO);
    above.is_file().then_some(above)
}

fn rate_in(path: &Path) -> Result<f32, String> {
    rate_of(&text_of(path).map_err(|error| format!("it cannot be read ({error})"))?)
}

fn text_of(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST_BYTES).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The name of the folder of images that the `seqinfo.ini` of a sequence's folder gives.
pub(super) fn image_folder(sequence: &Path) -> Option<String> {
    entry(&text_of(&sequence.join(SEQINFO)).ok()?, "imDir").map(str::to_owned)
}

/// The number of frames that the `seqinfo.ini` of a sequence's folder gives.
pub(crate) fn sequence_length(sequence: &Path) -> Option<u32> {
    entry(&text_of(&sequence.join(SEQINFO)).ok()?, "seqLength")?.parse().ok()
}

/// The value of a key in the text of a `seqinfo.ini`.
fn entry<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let mut entries = text.trim_start_matches('\u{feff}').lines().filter_map(|line| line.split_once('='));
    let (_, value) = entries.find(|(name, _)| name.trim().eq_ignore_ascii_case(key))?;
    // A semicolon starts a comment.
    Some(value.split(';').next().unwrap_or_default().trim())
}

/// The rate in the text of a `seqinfo.ini`, or why there is none.
fn rate_of(text: &str) -> Result<f32, String> {
    let value = entry(text, "frameRate").ok_or("it has no frameRate")?;
    let (least, greatest) = FPS_RANGE;
    let short: String = value.chars().take(40).collect();
    parse_fps(value).ok_or_else(|| format!("its frameRate `{short}` is not a number in {least}–{greatest}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_rate_of_the_user_precedes_that_of_the_source() {
        assert_eq!(choose(Some(5.0), Some(30.0)), (5.0, FpsFrom::Given));
        assert_eq!(choose(None, Some(29.97)), (29.97, FpsFrom::Video));
        for own in [None, Some(0.0), Some(f64::NAN), Some(90_000.0)] {
            assert_eq!(choose(None, own), (ASSUMED, FpsFrom::Assumed), "{own:?}");
        }
    }

    #[test]
    fn a_rate_is_read_in_every_form_of_the_file() {
        for (text, fps) in [
            ("[Sequence]\nname=KITTI-17\nframeRate=10\nseqLength=145\n", 10.0),
            ("\u{feff}[Sequence]\r\nname=a\r\n  FrameRate = 29.97 \r\n", 29.97),
            ("framerate=7 ; as it was filmed", 7.0),
            ("; a comment\n\n[Sequence]\nnoise\nframeRate\t=\t50", 50.0),
        ] {
            assert_eq!(rate_of(text), Ok(fps), "{text:?}");
        }
        for (text, why) in [
            ("", "no frameRate"),
            ("[Sequence]\nname=a\nframeRates=3\n", "no frameRate"),
            ("frameRate=", "frameRate ``"),
            ("frameRate=fast", "`fast`"),
            ("frameRate=0", "`0`"),
            ("frameRate=-25", "`-25`"),
            ("frameRate=NaN", "`NaN`"),
            ("frameRate=inf", "`inf`"),
            ("frameRate=1e9", "`1e9`"),
        ] {
            let refused = rate_of(text).unwrap_err();
            assert!(refused.contains(why), "{text:?}: {refused}");
        }
    }

    #[test]
    fn the_file_beside_the_images_overrides_the_one_in_the_parent() {
        let folder = tempfile::tempdir().unwrap();
        let images = folder.path().join("img1");
        fs::create_dir(&images).unwrap();
        let assumed = ImageRate { fps: ASSUMED, from: FpsFrom::Assumed, warning: None };
        assert_eq!(of_images(&images), assumed);
        fs::write(folder.path().join(SEQINFO), "frameRate=14").unwrap();
        let read = |fps| ImageRate { fps, from: FpsFrom::SeqInfo, warning: None };
        assert_eq!(of_images(&images), read(14.0));
        fs::write(images.join(SEQINFO), [0xff, 0xfe, 0, b'=', b'\n']).unwrap();
        let ImageRate { from, warning, .. } = of_images(&images);
        let warning = warning.unwrap();
        assert!(
            from == FpsFrom::Assumed && warning.contains("seqinfo.ini is ignored: it has no frameRate"),
            "{warning}"
        );
        assert!(warning.contains("25 frames per second are assumed") && !warning.contains('\n'), "{warning}");
        fs::write(images.join(SEQINFO), "frameRate=12.5").unwrap();
        assert_eq!(of_images(&images), read(12.5));
    }
}
