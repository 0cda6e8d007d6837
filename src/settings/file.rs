//! Reads the text of settings files.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// The greatest size of a settings file, in bytes.
pub const MAX_BYTES: u64 = 1 << 20;

/// The text of a settings file, or of a pipe. Fails if it is not text or larger than [`MAX_BYTES`]: a video, chosen by
/// mistake, is not read to its end.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let read = File::open(path)?.take(MAX_BYTES + 1).read_to_string(&mut text);
    read.map_err(|error| match error.kind() {
        ErrorKind::InvalidData => io::Error::other("it is not a text file"),
        _ => error,
    })?;
    if text.len() as u64 > MAX_BYTES {
        return Err(io::Error::other("it is too large for a settings file"));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn text_is_read_and_what_is_no_settings_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        let read = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read_text(&path).map_err(|error| error.to_string())
        };
        assert_eq!(read(b"k = 3"), Ok("k = 3".to_owned()));
        assert_eq!(read(b"\xff\xfe"), Err("it is not a text file".to_owned()));
        let most = MAX_BYTES as usize;
        assert_eq!(read(&vec![b'#'; most]).map(|text| text.len()), Ok(most));
        assert_eq!(read(&vec![b'#'; most + 1]), Err("it is too large for a settings file".to_owned()));
    }
}
