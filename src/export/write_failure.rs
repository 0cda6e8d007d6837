//! Errors of writing, with the file, the cause and a remedy.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::staged_path::final_path;

/// A file or folder that cannot be written, why, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {why}", path.display())]
struct WriteFailure {
    path: PathBuf,
    why: String,
}

/// The error of writing to `path`, or to what becomes the file at that path, in one line with its cause and a remedy. One
/// that has this form already stays as it is, and so does that of a closed pipe, which is no failure.
pub fn describe(path: &Path, error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|inner| inner.downcast_ref::<WriteFailure>());
    if inner.is_some() || error.kind() == ErrorKind::BrokenPipe {
        return error;
    }
    let elsewhere = "or choose another place";
    let why = match error.kind() {
        ErrorKind::StorageFull => format!("the disk is full; free some space, {elsewhere}"),
        ErrorKind::QuotaExceeded => format!("your quota on the disk is used up; delete files, {elsewhere}"),
        ErrorKind::FileTooLarge => {
            let what = if path.is_dir() { "a temporary file in it" } else { "it" };
            format!("{what} exceeds the largest size of a file here; raise it (ulimit -f), {elsewhere}")
        }
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only; choose another place".to_owned(),
        ErrorKind::PermissionDenied => format!("permission denied; change its permissions, {elsewhere}"),
        ErrorKind::IsADirectory => format!("it is a folder; remove it, {elsewhere}"),
        ErrorKind::NotADirectory if path.exists() => {
            format!("it is a file, not a folder; remove it, {elsewhere}")
        }
        ErrorKind::NotADirectory => "a part of its path is a file; choose another place".to_owned(),
        ErrorKind::InvalidFilename => {
            "its name is too long or not possible here; choose another name".to_owned()
        }
        ErrorKind::AlreadyExists if path.is_symlink() && !path.exists() => {
            "it is a link to a place that does not exist; remove it, or choose another place".to_owned()
        }
        ErrorKind::AlreadyExists => {
            "a file of this name is in its way; remove it, or choose another place".to_owned()
        }
        ErrorKind::NotFound => "its folder does not exist; create it, or choose another place".to_owned(),
        // The name of a temporary file says nothing to a user.
        _ => {
            let why = error.to_string();
            format!("{}; check the disk, {elsewhere}", why.split(" at path ").next().unwrap_or_default())
        }
    };
    refused(error.kind(), path, why)
}

/// As [`describe`]; earlier files that could not be put back are in `kept`.
pub(super) fn describe_with_kept(path: &Path, error: io::Error, kept: &Path) -> io::Error {
    let (kind, error) = (error.kind(), describe(path, error));
    let Some(failure) = error.get_ref().and_then(|inner| inner.downcast_ref::<WriteFailure>()) else {
        return error;
    };
    let why = format!("{}; earlier files that could not be put back are in {}", failure.why, kept.display());
    io::Error::new(kind, WriteFailure { path: failure.path.clone(), why })
}

/// The error of a path that cannot be written for this reason, which ends with a remedy.
pub(super) fn refused(kind: ErrorKind, path: &Path, why: String) -> io::Error {
    io::Error::new(kind, WriteFailure { path: final_path(path), why })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_the_final_file_its_cause_and_a_remedy_once() {
        let staged = Path::new("out/.occluscope-x1/new/masks/a.png");
        let error = describe(staged, io::Error::from(ErrorKind::StorageFull));
        let line =
            "out/masks/a.png cannot be written: the disk is full; free some space, or choose another place";
        assert_eq!((error.to_string().as_str(), error.kind()), (line, ErrorKind::StorageFull));
        assert_eq!(describe(Path::new("other"), error).to_string(), line);
    }

    #[test]
    fn files_that_are_kept_are_named_once() {
        let error = describe(Path::new("a.csv"), io::Error::from(ErrorKind::PermissionDenied));
        let error = describe_with_kept(Path::new("."), error, Path::new("b/old"));
        let line = describe(Path::new("c"), error).to_string();
        assert!(line.starts_with("a.csv cannot be written: permission denied"), "{line}");
        assert!(line.ends_with("; earlier files that could not be put back are in b/old"), "{line}");
    }

    #[test]
    fn a_closed_pipe_stays_one() {
        let error = describe(Path::new("a"), io::Error::from(ErrorKind::BrokenPipe));
        assert!(error.kind() == ErrorKind::BrokenPipe && error.get_ref().is_none());
    }
}
