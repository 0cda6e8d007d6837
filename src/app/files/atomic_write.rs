//! Writing of one file at a chosen path: the complete file or nothing.

use std::io;
use std::path::{Path, PathBuf};

use crate::export::SingleFile;
use crate::export::staging::Replace;
use crate::export::write_failure::describe;

/// Writes a temporary file with `write` and moves it to `path` when it is complete and on the disk, so that an existing file
/// is never replaced by an incomplete one. A name without an extension gets `ending`. Returns the final path, or an error in
/// a sentence.
pub(crate) fn write(
    path: PathBuf,
    ending: &str,
    write: impl FnOnce(&Path) -> io::Result<()>,
) -> Result<PathBuf, String> {
    // The dialog asked before replacing the name that it was given, not the name with the extension.
    let (path, replace) = match path.extension() {
        Some(_) => (path, Replace::Yes),
        None => (path.with_extension(ending), Replace::No),
    };
    match place(&path, replace, write) {
        Ok(()) => Ok(path),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            Err(format!("{} was not written: it exists; enter its full name to replace it", path.display()))
        }
        Err(error) => Err(describe(&path, error).to_string()),
    }
}

fn place(path: &Path, replace: Replace, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    // A dialog creates no folders: one that is missing was removed, or is on a disk that is not there.
    if path.parent().is_some_and(|folder| !folder.as_os_str().is_empty() && !folder.exists()) {
        return Err(io::ErrorKind::NotFound.into());
    }
    let file = SingleFile::new(path)?;
    write(&file.staged())?;
    file.publish(replace)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::fs;

    use super::*;

    #[test]
    fn a_failure_keeps_the_existing_file_and_leaves_no_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "before").unwrap();
        let half = |at: &Path| fs::write(at, "ha").and_then(|()| Err(io::ErrorKind::StorageFull.into()));
        let why = write(path.clone(), "txt", half).unwrap_err();
        assert!(why.contains("a.txt cannot be written: the disk is full; free some space"), "{why}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "before");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(write(path.clone(), "txt", |at| fs::write(at, "after")), Ok(path.clone()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "after");
        let nowhere = folder.path().join("none").join("a.txt");
        let why = write(nowhere, "txt", |at| fs::write(at, "x")).unwrap_err();
        assert!(why.contains("none/a.txt cannot be written: its folder does not exist; create it"), "{why}");
    }

    #[test]
    fn an_added_extension_replaces_no_existing_file() {
        let folder = tempfile::tempdir().unwrap();
        let (bare, whole) = (folder.path().join("mine"), folder.path().join("mine.toml"));
        assert_eq!(write(bare.clone(), "toml", |at| fs::write(at, "one")), Ok(whole.clone()));
        let why = write(bare, "toml", |at| fs::write(at, "two")).unwrap_err();
        assert!(why.contains("mine.toml was not written: it exists"), "{why}");
        assert_eq!(fs::read_to_string(whole).unwrap(), "one");
    }

    #[cfg(unix)]
    #[test]
    fn the_file_has_default_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let usual = folder.path().join("usual.txt");
        fs::write(&usual, "x").unwrap();
        let path = write(folder.path().join("a.txt"), "txt", |at| fs::write(at, "x")).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&usual));
    }
}
