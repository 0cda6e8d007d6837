//! Atomic writing of one file at a chosen path: the complete file or nothing.

use std::io;
use std::path::{Path, PathBuf};

/// Writes a temporary file beside `path` with `write`, then renames it to `path` when it is complete, so that an
/// existing file is never replaced by an incomplete one. A name without an extension gets `ending`. Returns the final
/// path, or an error in a sentence.
pub(crate) fn write(
    path: PathBuf,
    ending: &str,
    write: impl FnOnce(&Path) -> io::Result<()>,
) -> Result<PathBuf, String> {
    let (path, given) = match path.extension() {
        Some(_) => (path, true),
        None => (path.with_extension(ending), false),
    };
    match place(&path, given, ending, write) {
        Ok(()) => Ok(path),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            Err(format!("{} was not written: it exists; enter its full name to replace it", path.display()))
        }
        Err(error) => Err(format!("{} was not written: {error}; choose another location", path.display())),
    }
}

fn place(
    path: &Path,
    replace: bool,
    ending: &str,
    write: impl FnOnce(&Path) -> io::Result<()>,
) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let suffix = format!(".{ending}");
    let mut builder = tempfile::Builder::new();
    builder.suffix(&suffix);
    // Temporary files are readable by their owner only; this file gets the default permissions of the user's umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(|error| {
        // The error would name the temporary file, which the user does not know.
        let why = if folder.is_dir() { error.kind().to_string() } else { "its folder does not exist".into() };
        io::Error::new(error.kind(), why)
    })?;
    write(file.path())?;
    // The dialog asked before replacing the name that it was given, not the name with the extension.
    if replace {
        file.persist(path).map_err(|error| error.error)?;
    } else {
        file.persist_noclobber(path).map_err(|error| error.error)?;
    }
    Ok(())
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
        let half = |at: &Path| fs::write(at, "ha").and_then(|()| Err(io::Error::other("the disk is full")));
        let why = write(path.clone(), "txt", half).unwrap_err();
        assert!(why.contains("a.txt was not written: the disk is full"), "{why}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "before");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(write(path.clone(), "txt", |at| fs::write(at, "after")), Ok(path.clone()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "after");
        let nowhere = folder.path().join("none").join("a.txt");
        let why = write(nowhere, "txt", |at| fs::write(at, "x")).unwrap_err();
        assert!(
            why.ends_with("none/a.txt was not written: its folder does not exist; choose another location"),
            "{why}"
        );
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
