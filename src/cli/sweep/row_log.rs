//! The file of the rows that are complete, from which a stopped sweep goes on.
//!
//! A row is kept under the hash of everything that it follows from: a row of other files, options, settings or of another
//! version of the program is not taken.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::cli::run::hexadecimal;
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

/// The complete rows in the file of an output folder.
pub(super) struct RowLog {
    rows: HashMap<String, LoggedRow>,
    file: File,
}

impl RowLog {
    /// Reads the rows in `folder`, which is created if it does not exist. A cut or foreign line is no row: it is computed
    /// again.
    pub(super) fn open(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let path = folder.join(FILE);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(error),
        };
        let lines = bytes.split(|&byte| byte == b'\n');
        let rows = lines.filter_map(|line| serde_json::from_slice::<LoggedRow>(line).ok());
        let rows = rows.map(|row| (row.key.clone(), row)).collect();
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        // A killed sweep can leave a line without its end.
        if bytes.last().is_some_and(|&byte| byte != b'\n') {
            file.write_all(b"\n")?;
        }
        Ok(Self { rows, file })
    }

    /// The row of this key, if it is complete.
    pub(super) fn row(&self, key: &str) -> Option<&LoggedRow> {
        self.rows.get(&hash(key))
    }

    /// Adds complete rows and waits until they are on the disk. `rows` have a key, the name of the sequence and of the
    /// combination, seconds and measures.
    pub(super) fn add(
        &mut self,
        rows: impl IntoIterator<Item = (String, String, String, f64, Measures)>,
    ) -> io::Result<()> {
        let mut text = Vec::new();
        for (key, sequence, settings, seconds, measures) in rows {
            let row = LoggedRow { key: hash(&key), sequence, settings, seconds, measures };
            serde_json::to_writer(&mut text, &row)?;
            text.push(b'\n');
            self.rows.insert(row.key.clone(), row);
        }
        self.file.write_all(&text)?;
        self.file.sync_data()
    }
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
        let path = folder.path().join("out");
        let masks = MaskMeasures { f: 0.1 + 0.2, pwc: 1.0 / 3.0, ..MaskMeasures::default() };
        let measures = Measures { masks: Some(masks), ..Measures::default() };
        let row = |key: &str| (key.to_owned(), "a/b".to_owned(), "k=3".to_owned(), 1.25, measures);
        RowLog::open(&path).unwrap().add([row("one"), row("two")]).unwrap();
        let log = fs::read(path.join(FILE)).unwrap();
        fs::write(path.join(FILE), &log[..log.len() - 20]).unwrap();

        let mut log = RowLog::open(&path).unwrap();
        let one = log.row("one").unwrap();
        assert_eq!((one.measures, one.seconds), (measures, 1.25));
        assert_eq!(log.row("two"), None);
        log.add([row("two")]).unwrap();
        assert!(RowLog::open(&path).unwrap().row("two").is_some());
        assert_eq!(RowLog::open(&path).unwrap().row("three"), None);
    }
}
