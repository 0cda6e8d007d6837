//! Settings files: the same TOML format as on the command line.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::app::files::atomic_write;
use crate::settings::Settings;
use crate::settings::file::{MAX_BYTES, read_text};

/// The proposed file name.
pub(crate) const FILE_NAME: &str = "settings.toml";
/// The file extension.
pub(crate) const EXTENSION: &str = "toml";

/// Writes settings. Returns the path, or an error in a sentence.
pub(crate) fn write(path: PathBuf, settings: &Settings) -> Result<PathBuf, String> {
    atomic_write::write(path, EXTENSION, |at| fs::write(at, settings.to_toml()))
}

/// Reads settings; a missing key has its default, as on the command line. Returns an error in a sentence if the file
/// cannot be used.
pub(crate) fn read(path: &Path) -> Result<Settings, String> {
    let text = text_of(path).map_err(|error| {
        format!("the settings file {} cannot be read: {error}; choose another file", path.display())
    })?;
    let mut settings = Settings::default();
    settings
        .apply_toml(&text, path)
        .map_err(|error| format!("{error}; correct it or choose another file"))?;
    Ok(settings)
}

fn text_of(path: &Path) -> io::Result<String> {
    // A pipe would block, if chosen by mistake.
    let about = fs::metadata(path)?;
    if !about.is_file() || about.len() > MAX_BYTES {
        return Err(io::Error::other("it is not a settings file"));
    }
    read_text(path)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::settings::Preset;

    #[test]
    fn written_settings_are_read_unchanged() {
        let folder = tempfile::tempdir().unwrap();
        for preset in Preset::ALL {
            let settings = Settings { k: 7, ..Settings::preset(preset) };
            let path = write(folder.path().join(preset.word()), &settings).unwrap();
            assert_eq!(path.extension().unwrap(), EXTENSION);
            assert_eq!(read(&path), Ok(settings));
        }
    }

    #[test]
    fn missing_keys_have_their_defaults() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "k = 6").unwrap();
        assert_eq!(read(&path), Ok(Settings { k: 6, ..Settings::default() }));
    }

    #[test]
    fn an_error_names_the_file_the_cause_and_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        for (bytes, what) in [
            (&b"k = 99"[..], "`k` cannot be `99`; allowed:"),
            (b"kk = 3", "there is no setting `kk`"),
            (b"k = [1]", "`k` is array"),
            (b"k = = 3", "cannot be used"),
            (b"\xff\xfe", "it is not a text file"),
        ] {
            fs::write(&path, bytes).unwrap();
            let why = read(&path).unwrap_err();
            assert!(why.contains(what) && why.contains("a.toml") && why.contains("choose another"), "{why}");
            assert!(!why.contains('\n'), "{why}");
        }
        for path in [folder.path().join("none.toml"), folder.path().to_owned()] {
            let why = read(&path).unwrap_err();
            assert!(why.contains(&path.display().to_string()) && why.contains("cannot be read"), "{why}");
        }
    }
}
