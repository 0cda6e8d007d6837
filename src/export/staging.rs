//! Output files that appear under their names only when all of them are complete.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A hidden folder inside the output folder.
///
/// Files are written into it and, after success, moved out by [`Staging::publish`]. Dropping it before that removes
/// it with its contents, and the output folder as well if it was created here.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
    // `None` only after publishing or dropping.
    hidden: Option<TempDir>,
    /// Folders that were created here, the outermost first.
    made: Vec<PathBuf>,
}

impl Staging {
    /// Creates `folder` if it does not exist, and the hidden folder within.
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

    /// The temporary path of a file or folder of this name.
    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.hidden.as_ref().map_or(self.folder.as_path(), |hidden| hidden.path()).join(name)
    }

    /// Creates a folder of this name among the staged files and returns its path.
    pub fn folder(&self, name: &str) -> io::Result<PathBuf> {
        let path = self.path(name);
        fs::create_dir_all(&path)?;
        Ok(path)
    }

    /// Moves everything to its final path, `last` at the end: where it exists, all files are complete.
    ///
    /// A staged file replaces one of its name. A staged folder replaces the numbered images in a folder of its name;
    /// other files in that folder stay.
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
            // Fails if the folder is not empty, in which case it stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Removes the numbered images in `to` and moves those of `from` there.
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

/// Matches `000012.png`, `bin000012.png`.
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
    fn unpublished_files_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("a/b");
        let staging = Staging::new(&folder).unwrap();
        fs::write(staging.path("x.csv"), "half").unwrap();
        assert!(folder.exists());
        drop(staging);
        assert!(names(root.path()).is_empty(), "{:?}", names(root.path()));
    }

    #[test]
    fn an_existing_folder_stays_with_its_contents() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("x.csv"), "old").unwrap();
        let staging = Staging::new(root.path()).unwrap();
        fs::write(staging.path("x.csv"), "half").unwrap();
        drop(staging);
        assert_eq!(names(root.path()), ["x.csv"]);
        assert_eq!(fs::read_to_string(root.path().join("x.csv")).unwrap(), "old");
    }

    #[test]
    fn publishing_replaces_only_its_own_files() {
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
