//! Data of the frames in a temporary file, until the end of the analysis: memory holds that of one frame.

use std::error::Error;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use crate::export::write_failure::describe;

/// The file while it is written. It has no name, so that nothing of it is left after a failure. The data of each frame is
/// the number of its bytes and these. All errors name the folder.
pub(super) struct SpoolWriter {
    file: BufWriter<File>,
    folder: PathBuf,
}

impl SpoolWriter {
    /// An empty file on the disk of `folder`.
    pub(super) fn new(folder: &Path) -> io::Result<Self> {
        let file = tempfile::tempfile_in(folder).map_err(|error| describe(folder, error))?;
        Ok(Self { file: BufWriter::new(file), folder: folder.to_owned() })
    }

    /// Adds the data of the next frame.
    pub(super) fn add(&mut self, data: &[u8]) -> io::Result<()> {
        let length = self.file.write_all(&(data.len() as u64).to_le_bytes());
        length.and_then(|()| self.file.write_all(data)).map_err(|error| describe(&self.folder, error))
    }

    /// The complete file.
    pub(super) fn finish(self) -> io::Result<Spool> {
        let Self { file, folder } = self;
        let file = file.into_inner().map_err(|error| describe(&folder, error.into_error()))?;
        Ok(Spool { file, folder })
    }
}

/// The complete file.
pub(super) struct Spool {
    file: File,
    folder: PathBuf,
}

impl Spool {
    /// An error of data that was read, with the folder.
    pub(super) fn error(&self, why: impl Into<Box<dyn Error + Send + Sync>>) -> io::Error {
        describe(&self.folder, io::Error::other(why))
    }

    /// The data of each frame, in order, without an end: as many are taken as were added. There is one reader at a time, as
    /// all of a file share its position.
    pub(super) fn read(&self) -> io::Result<impl Iterator<Item = io::Result<Vec<u8>>>> {
        let failed = |error| describe(&self.folder, error);
        let mut file = &self.file;
        file.rewind().map_err(failed)?;
        let mut file = BufReader::new(file);
        Ok(std::iter::repeat_with(move || read_one(&mut file).map_err(failed)))
    }
}

fn read_one(file: &mut BufReader<&File>) -> io::Result<Vec<u8>> {
    let mut length = [0; 8];
    file.read_exact(&mut length)?;
    let mut data = vec![0; u64::from_le_bytes(length) as usize];
    file.read_exact(&mut data)?;
    Ok(data)
}
