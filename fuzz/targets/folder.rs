//! Folders for the files of an input: the parsers are called as the program does it.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A folder that is removed at the end, in memory where the system has such a place.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let builder = tempfile::Builder::new();
        let folder = if memory.is_dir() { builder.tempdir_in(memory) } else { builder.tempdir() };
        Self(folder.unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, content: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, content).unwrap();
        path
    }

    /// Writes a file if `name` is a file name that the system accepts, not in use, and without folders.
    pub fn write_any(&self, name: &[u8], content: &[u8]) {
        if name.is_empty() || name.contains(&b'/') || name.contains(&0) || name == b"." || name == b".." {
            return;
        }
        let path = self.path().join(OsStr::from_bytes(name));
        // A name that is too long for the system is left out.
        if !path.exists() {
            let _ = fs::write(path, content);
        }
    }
}
