//! The results of a sweep: its table, and the settings beside it.

use std::path::Path;

use crate::app::files::settings_file;
use crate::app::model::opened_sweep::{OpenedSweep, TABLE_NAME};
use crate::export::sweep_csv;

/// Reads the table of a sweep, or the one in its folder, and the settings beside it if there are any. Returns an error in
/// a sentence if one of them cannot be used.
pub(crate) fn read(path: &Path) -> Result<OpenedSweep, String> {
    let path = if path.is_dir() { path.join(TABLE_NAME) } else { path.to_owned() };
    let table =
        sweep_csv::read(&path).map_err(|error| format!("{error}; choose the {TABLE_NAME} of a sweep"))?;
    let settings = path.with_file_name(settings_file::FILE_NAME);
    let base = settings.exists().then(|| settings_file::read(&settings)).transpose()?;
    Ok(OpenedSweep { path, table, base })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::fs;

    use super::*;
    use crate::settings::Settings;

    #[test]
    fn a_folder_or_its_table_is_read_with_the_settings_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join(TABLE_NAME);
        fs::write(&table, "sequence,k,seconds\na,3,1\na,4,1\n").unwrap();
        let alone = read(folder.path()).unwrap();
        assert_eq!((&alone.path, alone.base, alone.table.rows.len()), (&table, None, 2));
        let settings = folder.path().join("settings.toml");
        fs::write(&settings, "alpha = 0.01\n").unwrap();
        let with = read(&table).unwrap();
        assert_eq!(with.base, Some(Settings { alpha: 0.01, ..Settings::default() }));
        fs::write(&settings, "alpha = 7\n").unwrap();
        assert!(read(&table).unwrap_err().contains("settings.toml"));
    }

    #[test]
    fn an_error_names_the_file_and_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join(TABLE_NAME);
        fs::write(&table, "sequence,k,seconds\na,3,1\na,4\n").unwrap();
        let why = read(folder.path()).unwrap_err();
        assert!(why.contains(&table.display().to_string()) && why.contains("line 3"), "{why}");
        assert!(why.ends_with("choose the sweep.csv of a sweep") && !why.contains('\n'), "{why}");
    }
}
