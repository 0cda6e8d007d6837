//! The bundled sample video, unpacked for the decoder.

use std::path::{Path, PathBuf};

use crate::export::SingleFile;
use crate::export::staging::Replace;
use crate::export::write_failure::describe;

/// A video of two people who cross.
const CROSSING_VIDEO: &[u8] = include_bytes!("../../../sample_videos/crossing.mp4");
const FILE_NAME: &str = "crossing.mp4";
/// A pixel on the occluder during the crossing, chosen when the sample opens.
pub(crate) const SAMPLE_PIXEL: (u32, u32) = (160, 137);

/// The path of the sample, which is written if it is missing or differs. Returns an error in a sentence.
pub(crate) fn unpacked() -> Result<PathBuf, String> {
    let mut why = String::new();
    for folder in folders() {
        match unpack_into(&folder) {
            Ok(path) => return Ok(path),
            Err(error) => why = error.to_string(),
        }
    }
    Err(format!("{why}; open another video, or set TMPDIR to a folder that can be written"))
}

/// The candidate folders: the user's cache, then the folder for temporary files.
fn folders() -> Vec<PathBuf> {
    let home = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = home("XDG_CACHE_HOME").or_else(|| home("HOME").map(|home| home.join(".cache")));
    let version = concat!("occluscope-", env!("CARGO_PKG_VERSION"));
    cache.into_iter().chain([std::env::temp_dir()]).map(|folder| folder.join(version)).collect()
}

fn unpack_into(folder: &Path) -> std::io::Result<PathBuf> {
    let path = folder.join(FILE_NAME);
    if std::fs::read(&path).is_ok_and(|there| there == CROSSING_VIDEO) {
        return Ok(path);
    }
    let file = SingleFile::new(&path)?;
    std::fs::write(file.staged(), CROSSING_VIDEO).map_err(|error| describe(&path, error))?;
    file.publish(Replace::Yes)?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_sample_is_written_once_and_a_broken_copy_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = unpack_into(folder.path()).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), CROSSING_VIDEO);
        std::fs::write(&path, b"broken").unwrap();
        assert_eq!(unpack_into(folder.path()).unwrap(), path);
        assert_eq!(std::fs::read(&path).unwrap(), CROSSING_VIDEO);
    }
}
