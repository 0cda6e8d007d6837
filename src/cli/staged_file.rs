//! Staged output files, whose errors name them.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use crate::export::Staging;
use crate::export::write_failure::describe;

/// Writes one staged file.
pub(super) fn write_file(
    staging: &Staging,
    name: &str,
    content: impl FnOnce(&mut StagedFile) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = StagedFile::create(staging, name)?;
    content(&mut out)?;
    out.flush()
}

/// A staged file. Its errors name it, the cause, and a remedy.
pub(super) struct StagedFile {
    path: PathBuf,
    out: BufWriter<File>,
}

impl StagedFile {
    /// Creates the file of this name.
    pub(super) fn create(staging: &Staging, name: &str) -> io::Result<Self> {
        let path = staging.path(name);
        let file = File::create(&path).map_err(|error| describe(&path, error))?;
        Ok(Self { path, out: BufWriter::new(file) })
    }
}

impl Write for StagedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes).map_err(|error| describe(&self.path, error))
    }

    // Several times faster than by `write`.
    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes).map_err(|error| describe(&self.path, error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush().map_err(|error| describe(&self.path, error))
    }
}
