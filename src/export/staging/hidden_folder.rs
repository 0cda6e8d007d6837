//! The hidden folder of incomplete files. It is removed when it is dropped, when the user insists on an end of the program,
//! and otherwise by the next writer in the same place.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::export::staged_path::{NEW, PREFIX};

/// The folder of the files that are being replaced.
const OLD: &str = "old";
/// The file that is locked as long as its writer lives.
const LOCK: &str = "lock";
/// Tries to create a folder that another process does not take for a left-over, or to remove one into which a thread still
/// writes.
const TRIES: usize = 20;

/// The folders of this process, for [`remove_all`].
static ALIVE: Mutex<Vec<Owned>> = Mutex::new(Vec::new());

/// A hidden folder, and the folders that were created for it, the outermost first.
#[derive(Clone, Debug, PartialEq)]
struct Owned {
    hidden: PathBuf,
    made: Vec<PathBuf>,
}

/// A hidden folder with `new` and `old` within, and a lock as long as it is in use.
#[derive(Debug)]
pub(super) struct HiddenFolder {
    owned: Owned,
    /// Unlocked when it is closed.
    _lock: File,
}

impl HiddenFolder {
    /// Removes what killed writers have left in `folder`, and creates a new hidden folder there. `made` are the folders that
    /// were created for it and are removed with it if nothing is in them.
    pub(super) fn new(folder: &Path, made: &[PathBuf]) -> io::Result<Self> {
        remove_left_over(folder);
        for _ in 0..TRIES {
            match Self::create(folder, made) {
                // In the moment between a folder and its lock another process can remove it as a left-over.
                Err(error) if error.kind() == io::ErrorKind::NotFound && folder.exists() => {}
                result => return result,
            }
        }
        Err(io::Error::other("other programs remove its temporary folder"))
    }

    fn create(folder: &Path, made: &[PathBuf]) -> io::Result<Self> {
        let hidden = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder)?;
        let path = hidden.path().join(LOCK);
        let lock = OpenOptions::new().write(true).create_new(true).open(&path)?;
        match lock.try_lock() {
            // Without locks on this disk no process takes the folder for a left-over.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => return Err(io::ErrorKind::NotFound.into()),
        }
        if !path.exists() {
            return Err(io::ErrorKind::NotFound.into());
        }
        for name in [NEW, OLD] {
            fs::create_dir(hidden.path().join(name))?;
        }
        let owned = Owned { hidden: hidden.keep(), made: made.to_vec() };
        alive().push(owned.clone());
        Ok(Self { owned, _lock: lock })
    }

    pub(super) fn path(&self) -> &Path {
        &self.owned.hidden
    }

    /// Where the files are that are being written.
    pub(super) fn new_files(&self) -> PathBuf {
        self.owned.hidden.join(NEW)
    }

    /// Where the files are kept that are being replaced.
    pub(super) fn old_files(&self) -> PathBuf {
        self.owned.hidden.join(OLD)
    }

    /// Keeps the folder: no process removes it.
    pub(super) fn leave(self) {
        alive().retain(|other| *other != self.owned);
        // Without it the folder is no left-over.
        let _ = fs::remove_file(self.owned.hidden.join(LOCK));
        std::mem::forget(self);
    }
}

impl Drop for HiddenFolder {
    fn drop(&mut self) {
        let mut alive = alive();
        alive.retain(|other| *other != self.owned);
        self.owned.remove();
    }
}

impl Owned {
    fn remove(&self) {
        for _ in 0..TRIES {
            // It fails where a thread creates a file at the same time.
            if remove(&self.hidden).is_ok() || !self.hidden.exists() {
                break;
            }
        }
        for folder in self.made.iter().rev() {
            // Fails if the folder is not empty, in which case it stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The folders of this process. While it is held, none is removed.
fn alive() -> MutexGuard<'static, Vec<Owned>> {
    ALIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does `work`, which [`remove_all`] waits for.
pub(super) fn undisturbed<T>(work: impl FnOnce() -> T) -> T {
    let _alive = alive();
    work()
}

/// Removes the incomplete files of this process, at its end: what still writes them fails.
pub fn remove_all() {
    for owned in alive().drain(..) {
        owned.remove();
    }
}

/// Removes the hidden folders of killed processes.
fn remove_left_over(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_hidden = entry.file_name().to_string_lossy().starts_with(PREFIX)
            && entry.file_type().is_ok_and(|kind| kind.is_dir());
        if !is_hidden {
            continue;
        }
        let path = entry.path();
        // What cannot be removed, as it is another user's, stays.
        let _ = match OpenOptions::new().write(true).open(path.join(LOCK)) {
            // The lock is held until the folder is gone.
            Ok(lock) => lock.try_lock().map_err(io::Error::from).and_then(|()| remove(&path)),
            // Its process ended before it had a lock, or is about to create it.
            Err(error) if error.kind() == io::ErrorKind::NotFound => fs::remove_dir(&path),
            Err(error) => Err(error),
        };
    }
}

/// Removes a hidden folder, the lock after everything else: what is left of it is still a left-over.
fn remove(hidden: &Path) -> io::Result<()> {
    for name in [NEW, OLD] {
        ignore_missing(fs::remove_dir_all(hidden.join(name)))?;
    }
    ignore_missing(fs::remove_file(hidden.join(LOCK)))?;
    ignore_missing(fs::remove_dir(hidden))
}

fn ignore_missing(result: io::Result<()>) -> io::Result<()> {
    result.or_else(|error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::names;
    use super::*;

    #[test]
    fn left_overs_are_removed_but_no_folder_in_use_and_no_foreign_one() {
        let root = tempfile::tempdir().unwrap();
        let alive = HiddenFolder::new(root.path(), &[]).unwrap();
        fs::write(alive.new_files().join("a"), "half").unwrap();
        let killed = root.path().join(".occluscope-killed");
        fs::create_dir_all(killed.join("new/masks")).unwrap();
        fs::write(killed.join("new/masks/a.png"), "half").unwrap();
        fs::write(killed.join("lock"), "").unwrap();
        let early = root.path().join(".occluscope-early");
        fs::create_dir(&early).unwrap();
        // Without a lock it is none of ours, or was left to the user.
        let left = root.path().join(".occluscope-mine");
        fs::create_dir(&left).unwrap();
        fs::write(left.join("notes"), "mine").unwrap();
        fs::write(root.path().join(".occluscope-file"), "mine").unwrap();

        let next = HiddenFolder::new(root.path(), &[]).unwrap();
        assert!(!killed.exists() && !early.exists());
        assert!(alive.new_files().join("a").exists() && next.new_files().exists());
        drop((alive, next));
        assert_eq!(names(root.path()), [".occluscope-file", ".occluscope-mine"]);
    }

    #[test]
    fn what_is_left_to_the_user_stays() {
        let root = tempfile::tempdir().unwrap();
        let hidden = HiddenFolder::new(root.path(), &[]).unwrap();
        let kept = hidden.old_files().join("0");
        fs::write(&kept, "old").unwrap();
        hidden.leave();
        drop(HiddenFolder::new(root.path(), &[]).unwrap());
        assert_eq!(fs::read_to_string(kept).unwrap(), "old");
    }
}
