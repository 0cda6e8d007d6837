//! The file of the rows that are complete, from which a stopped sweep goes on.
//!
//! A row is kept under the hash of everything that it follows from: a row of other files, options, settings or of another
//! version of the program is not taken.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use anyhow::bail;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::cli::run::hexadecimal;
use crate::export::write_failure::describe;
use crate::truth::measures::Measures;

/// The name of the file.
pub(super) const FILE: &str = "rows.jsonl";

/// A complete row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LoggedRow {
    key: String,
    /// The sequence and the combination, for the reader of the file.
    sequence: String,
    settings: String,
    pub seconds: f64,
    pub measures: Measures,
}

/// The beginning of every row.
const ROW_START: &[u8] = b"{\"key\":\"";

impl LoggedRow {
    fn is_possible(&self) -> bool {
        self.measures.is_possible() && self.seconds.is_finite() && self.seconds >= 0.0
    }
}

/// The complete rows in the file of an output folder, which is locked against other sweeps.
pub(super) struct RowLog {
    rows: HashMap<String, LoggedRow>,
    path: PathBuf,
    file: File,
    /// The length of the file, in bytes.
    length: u64,
}

impl RowLog {
    /// Reads the rows in `folder`, which must exist. A foreign or impossible line is no row, and a cut one at the end is
    /// removed: it is computed again. Fails where another sweep writes rows there. All errors name the file.
    pub(super) fn open(folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(FILE);
        let failed = |error| describe(&path, error);
        if path.exists() && !path.is_file() {
            bail!("{} is not a file; move it away, or choose another --out", path.display());
        }
        let file = loop {
            let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let file = file.map_err(failed)?;
            match file.try_lock() {
                // Without locks on this disk there is no protection.
                Ok(()) | Err(TryLockError::Error(_)) => {}
                Err(TryLockError::WouldBlock) => bail!(
                    "another sweep writes into {}; wait until it is done, or choose another --out",
                    folder.display()
                ),
            }
            // The other sweep has removed an empty file in the moment before the lock.
            if is_at(&file, &path) {
                break file;
            }
        };
        let mut bytes = Vec::new();
        (&file).read_to_end(&mut bytes).map_err(failed)?;
        if !is_of_sweep(&bytes) {
            bail!("{} is not of a sweep; move it away, or choose another --out", path.display());
        }
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        let lines = bytes[..whole].split(|&byte| byte == b'\n');
        let rows = lines.filter_map(|line| serde_json::from_slice::<LoggedRow>(line).ok());
        let rows = rows.filter(LoggedRow::is_possible);
        let rows = rows.map(|row| (row.key.clone(), row)).collect();
        let log = Self { rows, path, file, length: whole as u64 };
        if whole < bytes.len() {
            log.cut().map_err(|error| describe(&log.path, error))?;
        }
        Ok(log)
    }

    /// Removes what is behind the last whole row.
    fn cut(&self) -> io::Result<()> {
        self.file.set_len(self.length)
    }

    /// The row of this key, if it is complete.
    pub(super) fn row(&self, key: &str) -> Option<&LoggedRow> {
        self.rows.get(&hash(key))
    }

    /// Where rows are, as the end of a message: ` in FILE`; empty without rows.
    pub(super) fn place(&self) -> String {
        if self.length == 0 { String::new() } else { format!(" in {}", self.path.display()) }
    }

    /// Adds complete rows and waits until they are on the disk. `rows` have a key, the name of the sequence and of the
    /// combination, seconds and measures.
    pub(super) fn add(
        &mut self,
        rows: impl IntoIterator<Item = (String, String, String, f64, Measures)>,
    ) -> io::Result<()> {
        let (mut text, mut added) = (Vec::new(), Vec::new());
        for (key, sequence, settings, seconds, measures) in rows {
            let row = LoggedRow { key: hash(&key), sequence, settings, seconds, measures };
            serde_json::to_writer(&mut text, &row)?;
            text.push(b'\n');
            added.push((row.key.clone(), row));
        }
        let written = self.file.seek(SeekFrom::Start(self.length)).and_then(|_| {
            self.file.write_all(&text)?;
            self.file.sync_data()
        });
        if let Err(error) = written {
            // Where this fails too, the next sweep does it.
            let _ = self.cut();
            return Err(describe(&self.path, error));
        }
        self.length += text.len() as u64;
        self.rows.extend(added);
        Ok(())
    }
}

impl Drop for RowLog {
    fn drop(&mut self) {
        // A sweep that fails on its input leaves no file.
        let is_empty = self.file.metadata().is_ok_and(|file| file.len() == 0);
        if is_empty && is_at(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Whether a file of rows is one, perhaps a damaged one: cut, or of zeros after a loss of power.
fn is_of_sweep(bytes: &[u8]) -> bool {
    let is_row = |line: &[u8]| serde_json::from_slice::<LoggedRow>(line).is_ok();
    bytes.starts_with(ROW_START)
        || ROW_START.starts_with(bytes)
        || bytes.iter().all(|byte| matches!(byte, 0 | b'\n'))
        || bytes.split(|&byte| byte == b'\n').any(is_row)
}

/// Whether an open file is the one at a path.
fn is_at(file: &File, path: &Path) -> bool {
    same_file::Handle::from_path(path)
        .and_then(|at| Ok(at == same_file::Handle::from_file(file.try_clone()?)?))
        .unwrap_or(false)
}

fn hash(key: &str) -> String {
    hexadecimal(&Sha256::digest(key.as_bytes()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::truth::mask_measures::MaskMeasures;

    #[test]
    fn rows_are_found_again_by_their_key_and_a_cut_line_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let masks = MaskMeasures { f: 0.1 + 0.2, pwc: 1.0 / 3.0, ..MaskMeasures::default() };
        let measures = Measures { masks: Some(masks), ..Measures::default() };
        let row = |key: &str| (key.to_owned(), "a/b".to_owned(), "k=3".to_owned(), 1.25, measures);
        RowLog::open(path).unwrap().add([row("one"), row("two")]).unwrap();
        let log = fs::read(path.join(FILE)).unwrap();
        fs::write(path.join(FILE), &log[..log.len() - 20]).unwrap();

        let mut log = RowLog::open(path).unwrap();
        assert!(fs::read(path.join(FILE)).unwrap().ends_with(b"\n"), "the cut line is gone");
        let one = log.row("one").unwrap();
        assert_eq!((one.measures, one.seconds), (measures, 1.25));
        assert_eq!(log.row("two"), None);
        log.add([row("two")]).unwrap();
        let refused = RowLog::open(path).map(drop).unwrap_err().to_string();
        assert!(refused.starts_with("another sweep writes into "), "{refused}");
        drop(log);
        assert!(RowLog::open(path).unwrap().row("two").is_some());
        assert_eq!(RowLog::open(path).unwrap().row("three"), None);
    }

    #[test]
    fn without_rows_there_is_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut log = RowLog::open(folder.path()).unwrap();
        assert_eq!(log.place(), "");
        drop(log);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        log = RowLog::open(folder.path()).unwrap();
        log.add([("one".to_owned(), "a".to_owned(), "k=3".to_owned(), 1.0, Measures::default())]).unwrap();
        assert_eq!(log.place(), format!(" in {}", folder.path().join(FILE).display()));
    }

    #[test]
    fn a_row_that_cannot_be_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let masks = MaskMeasures { f: 0.5, pwc: 12.5, ..MaskMeasures::default() };
        let measures = Measures { masks: Some(masks), ..Measures::default() };
        let row = |key: &str| (key.to_owned(), "a".to_owned(), "k=3".to_owned(), 1.25, measures);
        RowLog::open(folder.path()).unwrap().add([row("one")]).unwrap();
        let log = fs::read_to_string(folder.path().join(FILE)).unwrap();
        for (from, to) in [
            ("0.5", "5.0"),
            ("0.5", "-0.5"),
            ("12.5", "101"),
            ("1.25", "-1"),
            ("0.5", "\"0.5\""),
            ("0.5", "1e999"),
            ("0.5", "null"),
        ] {
            assert!(log.contains(from));
            fs::write(folder.path().join(FILE), log.replacen(from, to, 1)).unwrap();
            let kept = RowLog::open(folder.path()).unwrap();
            assert!(kept.row("one").is_none_or(|row| row.measures.masks.is_none()), "{from} as {to}");
        }
        fs::write(folder.path().join(FILE), log).unwrap();
        assert!(RowLog::open(folder.path()).unwrap().row("one").is_some());
    }
}
