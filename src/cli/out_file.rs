//! A single output file, which appears under its name when it is complete.

use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::standard_output::own_error;
use crate::export::SingleFile;
use crate::export::staging::Replace;
use crate::export::write_failure::describe;

/// An output file that is begun before the work, so that a path that cannot be written is reported at once.
pub(super) struct OutFile {
    path: PathBuf,
    /// `None` for a device or a pipe, which is written directly.
    file: Option<SingleFile>,
    out: BufWriter<File>,
}

impl OutFile {
    /// Fails if the file cannot be written.
    pub(super) fn begin(path: &Path) -> io::Result<Self> {
        let is_special = path.exists() && !path.is_file() && !path.is_dir();
        let file = if is_special { None } else { Some(SingleFile::new(path)?) };
        let staged = file.as_ref().map_or_else(|| path.to_owned(), SingleFile::staged);
        let out = File::create(staged).map_err(|error| describe(path, error))?;
        Ok(Self { path: path.to_owned(), file, out: BufWriter::new(out) })
    }

    /// Writes the content and moves the file to its path.
    pub(super) fn write(
        self,
        content: impl FnOnce(&mut BufWriter<File>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let Self { path, file, mut out } = self;
        content(&mut out).map_err(|error| match own_error(error) {
            Ok(error) => describe(&path, error).into(),
            Err(other) => other,
        })?;
        out.flush().map_err(|error| describe(&path, error))?;
        drop(out);
        Ok(file.map_or(Ok(()), |file| file.publish(Replace::Yes))?)
    }
}
