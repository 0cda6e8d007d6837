//! Whether a file or folder of this name can be written, asked before the work and before the first file is replaced.

use std::fs::{self, Metadata};
use std::io::{self, ErrorKind};
use std::path::Path;

use super::is_numbered_picture;
use crate::export::write_failure::{describe, refused};

/// Whether a file can be created at `path` or replaced by one. `own` is of a folder of this process on the same disk.
pub(super) fn check_file(path: &Path, own: &Metadata) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(describe(path, error)),
        Ok(_) if path.is_dir() => Err(describe(path, ErrorKind::IsADirectory.into())),
        Ok(there) if is_protected(path, &there, own) => Err(refused(
            ErrorKind::PermissionDenied,
            path,
            "it belongs to someone else, and only its owner can replace it in this folder; choose another place".into(),
        )),
        Ok(_) => Ok(()),
    }
}

/// Whether files can be moved into the folder at `path`, or a folder be created there; whether those in it that `is_ours`
/// can be replaced. `own` is of a folder of this process on the disk from which they come.
pub(super) fn check_folder(path: &Path, own: &Metadata, is_ours: impl Fn(&str) -> bool) -> io::Result<()> {
    let there = match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound && fs::symlink_metadata(path).is_err() => {
            return Ok(());
        }
        Err(error) => return Err(describe(path, error)),
        Ok(there) => there,
    };
    if !there.is_dir() {
        return Err(describe(path, ErrorKind::NotADirectory.into()));
    }
    if !is_same_disk(&there, own) {
        let why = "it is on another disk than the folder that holds it; choose a folder on that disk";
        return Err(refused(ErrorKind::CrossesDevices, path, why.into()));
    }
    // A file without a name tells whether names can be added, and leaves nothing.
    tempfile::tempfile_in(path).map_err(|error| describe(path, error))?;
    for entry in fs::read_dir(path).map_err(|error| describe(path, error))? {
        let entry = entry.map_err(|error| describe(path, error))?;
        if is_ours(&entry.file_name().to_string_lossy()) {
            check_file(&entry.path(), own)?;
        }
    }
    Ok(())
}

/// Fails if there are numbered pictures in the folder at `path`.
pub(super) fn check_pictures(path: &Path) -> io::Result<()> {
    let is_picture = |entry: &fs::DirEntry| {
        is_numbered_picture(&entry.file_name().to_string_lossy()) && entry.path().is_file()
    };
    let Some(picture) = fs::read_dir(path).into_iter().flatten().flatten().find(is_picture) else {
        return Ok(());
    };
    let why = format!(
        "it has pictures that this program did not write there, as {}; move them away, or choose another place",
        Path::new(&picture.file_name()).display()
    );
    Err(refused(ErrorKind::AlreadyExists, path, why))
}

/// Whether `there` at `path` is another user's in a folder in which only owners can remove files.
#[cfg(unix)]
fn is_protected(path: &Path, there: &Metadata, own: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(folder) = fs::metadata(folder) else { return false };
    let me = own.uid();
    folder.mode() & STICKY != 0 && me != 0 && me != there.uid() && me != folder.uid()
}

#[cfg(not(unix))]
fn is_protected(_: &Path, _: &Metadata, _: &Metadata) -> bool {
    false
}

#[cfg(unix)]
fn is_same_disk(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    a.dev() == b.dev()
}

#[cfg(not(unix))]
fn is_same_disk(_: &Metadata, _: &Metadata) -> bool {
    true
}
