//! Files that appear under their names only when all of them are whole.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A hidden folder inside the folder that is to receive results.
///
/// Files are written into it and, when all went well, moved out by [`Staging::publish`]. Dropped
/// before that, it takes everything with it, and the receiving folder too if it was made for it.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
    // Taken when published or dropped; `None` only then.
    hidden: Option<TempDir>,
    /// Folders that were made for this, the outermost first.
    made: Vec<PathBuf>,
}

impl Staging {
    /// Makes `folder` if it is not there, and the hidden folder within.
    pub fn new(folder: &Path) -> io::Result<Self> {
        let mut staging = Self { folder: folder.to_owned(), hidden: None, made: Vec::new() };
        let missing: Vec<_> = folder
            .ancestors()
            .take_while(|ancestor| !ancestor.as_os_str().is_empty() && !ancestor.exists())
            .collect();
        for ancestor in missing.into_iter().rev() {
            fs::create_dir(ancestor)?;
            staging.made.push(ancestor.to_owned());
        }
        staging.hidden = Some(tempfile::Builder::new().prefix(".occluscope-").tempdir_in(folder)?);
        Ok(staging)
    }

    /// Where a file or folder of this name is to be written for now.
    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.hidden.as_ref().map_or(self.folder.as_path(), |hidden| hidden.path()).join(name)
    }

    /// Makes a folder of this name among the staged files and gives its path.
    pub fn folder(&self, name: &str) -> io::Result<PathBuf> {
        let path = self.path(name);
        fs::create_dir_all(&path)?;
        Ok(path)
    }

    /// Moves everything to its place, `last` at the very end: where it stands, all stands.
    ///
    /// A staged file takes the place of one with its name. A staged folder takes the place of the
    /// numbered pictures of an earlier one; whatever else lies in that folder stays.
    pub fn publish(mut self, last: impl AsRef<Path>) -> io::Result<()> {
        let Some(hidden) = self.hidden.take() else { return Ok(()) };
        self.made.clear();
        let mut names: Vec<_> =
            fs::read_dir(hidden.path())?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<_>>()?;
        names.sort_by_key(|name| (Path::new(name) == last.as_ref(), name.clone()));
        for name in names {
            let (from, to) = (hidden.path().join(&name), self.folder.join(&name));
            if from.is_dir() && to.is_dir() { replace_numbered(&from, &to)? } else { fs::rename(&from, &to)? }
        }
        hidden.close()
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        drop(self.hidden.take());
        for folder in self.made.iter().rev() {
            // Fails where somebody has put something into it meanwhile, which then stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Removes the numbered pictures in `to` and moves those of `from` there.
fn replace_numbered(from: &Path, to: &Path) -> io::Result<()> {
    for entry in fs::read_dir(to)? {
        let entry = entry?;
        if is_numbered_picture(&entry.file_name().to_string_lossy()) {
            fs::remove_file(entry.path())?;
        }
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        fs::rename(entry.path(), to.join(entry.file_name()))?;
    }
    Ok(())
}

/// `000012.png`, `bin000012.png`.
fn is_numbered_picture(name: &str) -> bool {
    name.strip_suffix(".png")
        .map(|stem| stem.strip_prefix("bin").unwrap_or(stem))
        .is_some_and(|digits| digits.len() >= 6 && digits.bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn nothing_is_left_of_what_was_not_published() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("a/b");
        let staging = Staging::new(&folder).unwrap();
        fs::write(staging.path("x.csv"), "half").unwrap();
        assert!(folder.exists());
        drop(staging);
        assert!(names(root.path()).is_empty(), "{:?}", names(root.path()));
    }

    #[test]
    fn a_folder_that_was_there_stays_with_all_that_is_in_it() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("x.csv"), "old").unwrap();
        let staging = Staging::new(root.path()).unwrap();
        fs::write(staging.path("x.csv"), "half").unwrap();
        drop(staging);
        assert_eq!(names(root.path()), ["x.csv"]);
        assert_eq!(fs::read_to_string(root.path().join("x.csv")).unwrap(), "old");
    }

    #[test]
    fn publishing_replaces_its_own_files_only() {
        let root = tempfile::tempdir().unwrap();
        let masks = root.path().join("masks");
        fs::create_dir(&masks).unwrap();
        for name in ["bin000001.png", "bin000009.png", "notes.txt"] {
            fs::write(masks.join(name), "old").unwrap();
        }
        fs::write(root.path().join("x.csv"), "old").unwrap();
        fs::write(root.path().join("mine.txt"), "mine").unwrap();

        let staging = Staging::new(root.path()).unwrap();
        fs::write(staging.path("x.csv"), "new").unwrap();
        let folder = staging.folder("masks").unwrap();
        fs::write(folder.join("bin000001.png"), "new").unwrap();
        staging.publish("x.csv").unwrap();

        assert_eq!(names(root.path()), ["masks", "mine.txt", "x.csv"]);
        assert_eq!(names(&masks), ["bin000001.png", "notes.txt"]);
        assert_eq!(fs::read_to_string(masks.join("bin000001.png")).unwrap(), "new");
        assert_eq!(fs::read_to_string(root.path().join("x.csv")).unwrap(), "new");
    }
}
