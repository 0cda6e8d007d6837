//! Files that are no video although FFmpeg may open them.

use std::fs::File;
use std::io::Read;

use image::ImageFormat;

use super::super::{SourceError, image_file, path_of};
use super::playlist;

/// Refuses a file that is no video, with the reason. Returns a warning, if there is one.
pub(super) fn check_file(name: &str) -> Result<Option<String>, SourceError> {
    let path = path_of(name);
    let mut start = [0; 4096];
    let length = File::open(&path)
        .and_then(|mut file| file.read(&mut start))
        .map_err(|error| SourceError::unusable(name, format!("{error}; check its permissions")))?;
    let why = if length == 0 {
        "the file is empty; check that it was copied completely"
    } else if is_single_image(&start[..length])
        || (image_file::has_image_name(&path) && !name.to_lowercase().ends_with(".gif"))
    {
        "it is a single image; give its folder, or a pattern such as in%06d.png"
    } else if playlist::is_playlist(&start[..length]) {
        return playlist::check_parts(name, &path).map_err(|why| SourceError::unusable(name, why));
    } else if is_text(&start[..length]) {
        // FFmpeg would render a text file as a video of a terminal.
        "it is text, not a video"
    } else {
        return Ok(None);
    };
    Err(SourceError::unusable(name, why))
}

/// Whether a file starts as images do, and not as animations and streams of images.
fn is_single_image(start: &[u8]) -> bool {
    let has = |name: &[u8]| start.windows(name.len()).any(|window| window == name);
    match image::guess_format(start) {
        Ok(ImageFormat::Png) => !has(b"acTL"),
        Ok(ImageFormat::WebP) => !has(b"ANIM"),
        Ok(ImageFormat::Bmp) => true,
        _ => false,
    }
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
    fn images_are_distinguished_from_animations() {
        assert!(is_single_image(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"));
        assert!(!is_single_image(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR....acTL"));
        assert!(is_single_image(b"RIFF\0\x10\0\0WEBPVP8L"));
        assert!(!is_single_image(b"RIFF\0\x10\0\0WEBPVP8X....ANIM"));
        assert!(!is_single_image(b"RIFF\x24\0\0\0AVI "));
        assert!(!is_single_image(b"\xff\xd8\xff\xe0"), "a stream of JPEGs");
    }

    #[test]
    fn text_files_are_distinguished_from_video() {
        assert!(is_text("Grüße\n".as_bytes()));
        assert!(is_text(&"Grüße".as_bytes()[..3]), "cut within a character");
        assert!(!is_text(b"RIFF\x24\x00\x00\x00AVI "));
        assert!(!is_text(b"\x00\x00\x00\x20ftypisom"));
        assert!(!is_text(b"\x1a\x45\xdf\xa3\xff"));
    }
}
