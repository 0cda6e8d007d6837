//! Images as frames, as masks, as labels and as a region of interest. The first byte selects the name's ending and how the
//! image is read.

use occluscope::regions::Roi;
use occluscope::source::{self, Levels, Options};
use occluscope::truth::formats::{self, Role};
use occluscope::truth::masks::MaskFiles;

use super::check_message;
use super::folder::Folder;

const ENDINGS: [&str; 7] = ["png", "jpg", "bmp", "tif", "webp", "pgm", "gif"];

pub fn run(data: &[u8]) {
    let Some((&choice, content)) = data.split_first() else { return };
    let choice = usize::from(choice);
    let folder = Folder::new();
    let file = folder.write(&format!("000001.{}", ENDINGS[choice % ENDINGS.len()]), content);
    let levels = (choice / ENDINGS.len() % 2 == 1).then_some(Levels::Auto);
    let options = Options { levels, ..Options::default() };
    read(folder.path().to_str().unwrap(), options);
    // The pages of a file.
    if ENDINGS[choice % ENDINGS.len()] == "tif" {
        read(file.to_str().unwrap(), options);
    }
    if let Err(error) = Roi::read(&file) {
        check_message(&error.to_string());
    }
    if let Err(error) = formats::read(folder.path(), Role::Truth) {
        check_message(&error.to_string());
    }
    if let Err(error) = MaskFiles::of_folder(folder.path()).and_then(|files| files.read_all()) {
        check_message(&error.to_string());
    }
}

/// Frames are of the announced size.
fn read(name: &str, options: Options) {
    let mut source = match source::open(name, options) {
        Ok(source) => source,
        Err(error) => return check_message(&error.to_string()),
    };
    let size = source.info().size;
    for _ in 0..4 {
        match source.next_frame() {
            Ok(Some(frame)) => assert_eq!((frame.size, frame.rgb.len()), (size, 3 * size.pixels())),
            Ok(None) => break,
            Err(error) => return check_message(&error.to_string()),
        }
    }
    source.take_warnings().iter().for_each(|warning| check_message(warning));
}
