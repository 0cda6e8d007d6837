//! Atomic writing of one file at a chosen path: the whole file or nothing.

use std::io;
use std::path::{Path, PathBuf};

/// Lets `write` fill a file beside `path` and puts it there when it is whole, so that what stands
/// there is never replaced by half a file. A name without an ending gets `ending`. Returns where
/// the file stands, or why it does not, in a sentence.
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
    // A temporary file is its owner's alone; this one is to be read by whom the user lets read files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(|error| {
        // The temporary file's own name would only puzzle.
        let why = if folder.is_dir() { error.kind().to_string() } else { "its folder does not exist".into() };
        io::Error::new(error.kind(), why)
    })?;
    write(file.path())?;
    // The dialog asked before replacing the name it was given, not the one with the ending added.
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
    fn a_failure_leaves_what_was_there_and_nothing_beside_it() {
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
    fn an_ending_is_added_but_replaces_nothing_that_nobody_was_asked_about() {
        let folder = tempfile::tempdir().unwrap();
        let (bare, whole) = (folder.path().join("mine"), folder.path().join("mine.toml"));
        assert_eq!(write(bare.clone(), "toml", |at| fs::write(at, "one")), Ok(whole.clone()));
        let why = write(bare, "toml", |at| fs::write(at, "two")).unwrap_err();
        assert!(why.contains("mine.toml was not written: it exists"), "{why}");
        assert_eq!(fs::read_to_string(whole).unwrap(), "one");
    }

    #[cfg(unix)]
    #[test]
    fn it_may_be_read_like_any_other_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let usual = folder.path().join("usual.txt");
        fs::write(&usual, "x").unwrap();
        let path = write(folder.path().join("a.txt"), "txt", |at| fs::write(at, "x")).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&usual));
    }
}
