//! Files that are no video although FFmpeg may open them.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::super::{SourceError, image_file};

/// Refuses a file that is no video, with the reason.
pub(super) fn check_file(name: &str) -> Result<(), SourceError> {
    let mut start = [0; 4096];
    let length = File::open(name)
        .and_then(|mut file| file.read(&mut start))
        .map_err(|error| SourceError::unusable(name, format!("{error}; check its permissions")))?;
    let why = if length == 0 {
        "the file is empty; check that it was copied completely"
    } else if image_file::has_image_name(Path::new(name)) && !name.to_lowercase().ends_with(".gif") {
        "it is a single image; give its folder, or a pattern such as in%06d.png"
    } else if is_text(&start[..length]) {
        // FFmpeg would render a text file as a video of a terminal.
        "it is text, not a video"
    } else {
        return Ok(());
    };
    Err(SourceError::unusable(name, why))
}

fn is_text(start: &[u8]) -> bool {
    let text = match std::str::from_utf8(start) {
        Ok(text) => text,
        // The end of the buffer may split a character.
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&start[..error.valid_up_to()]).unwrap_or_default()
        }
        Err(_) => return false,
    };
    text.chars().all(|c| !c.is_control() || matches!(c, '\n' | '\r' | '\t' | '\x0c' | '\x1b'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_files_are_distinguished_from_video() {
        assert!(is_text("Grüße\n".as_bytes()));
        assert!(is_text(&"Grüße".as_bytes()[..3]), "cut within a character");
        assert!(!is_text(b"RIFF\x24\x00\x00\x00AVI "));
        assert!(!is_text(b"\x00\x00\x00\x20ftypisom"));
        assert!(!is_text(b"\x1a\x45\xdf\xa3\xff"));
    }
}
