//! Output files that appear under their names only when all of them are complete and on the disk.

mod hidden_folder;
mod publication;
mod target;

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

pub use hidden_folder::remove_all;

use super::write_failure::describe;
use hidden_folder::HiddenFolder;

/// Bytes that tell whether the disk is full.
const PROBE_BYTES: usize = 1 << 20;

/// Whether files of the same names are replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Replace {
    /// They are replaced.
    Yes,
    /// They are an error, of the kind [`io::ErrorKind::AlreadyExists`].
    No,
}

/// Files that are written into a hidden folder inside the output folder and, after success, moved out by
/// [`Staging::publish`].
///
/// Dropping it before that removes them, and the output folder as well if it was created here. What a killed process has
/// left is removed by the next one that writes into the same folder. All errors name the file and a remedy.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
    hidden: HiddenFolder,
}

impl Staging {
    /// Creates `folder` if it does not exist, and the hidden folder within.
    pub fn new(folder: &Path) -> io::Result<Self> {
        let mut made = Vec::new();
        let hidden = make_folders(folder, &mut made)
            .and_then(|()| HiddenFolder::new(folder, &made).map_err(|error| describe(folder, error)));
        match hidden {
            Ok(hidden) => Ok(Self { folder: folder.to_owned(), hidden }),
            Err(error) => {
                for folder in made.iter().rev() {
                    let _ = fs::remove_dir(folder);
                }
                Err(error)
            }
        }
    }

    /// Fails if a file or folder of these names could not be written at the end, or if numbered pictures would be replaced
    /// that are beside no file of an earlier command.
    pub fn check<'a>(&self, names: impl IntoIterator<Item = (&'a Path, IsFolder)>) -> io::Result<()> {
        let own = fs::metadata(self.hidden.path()).map_err(|error| describe(self.hidden.path(), error))?;
        let paths: Vec<_> = names.into_iter().map(|(name, kind)| (self.folder.join(name), kind)).collect();
        // Numbered pictures are replaced as a set: only those of an earlier command.
        let has_earlier_files = paths.iter().any(|(path, kind)| *kind == IsFolder::No && path.is_file());
        paths.iter().try_for_each(|(path, kind)| match kind {
            IsFolder::No => {
                if let Some(within) = path.parent().filter(|within| *within != self.folder) {
                    target::check_folder(within, &own, |_| false)?;
                }
                target::check_file(path, &own)
            }
            IsFolder::Yes => {
                if !has_earlier_files {
                    target::check_pictures(path)?;
                }
                target::check_folder(path, &own, is_numbered_picture)
            }
        })
    }

    /// The temporary path of a file or folder of this name.
    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.hidden.new_files().join(name)
    }

    /// Creates a folder of this name among the staged files and returns its path.
    pub fn folder(&self, name: impl AsRef<Path>) -> io::Result<PathBuf> {
        let path = self.path(name);
        fs::create_dir_all(&path).map_err(|error| describe(&path, error))?;
        Ok(path)
    }

    /// Waits until everything is on the disk and moves it to its final path, `last` at the end: where it exists, all files
    /// are complete. On an error everything is as before.
    ///
    /// A staged file replaces one of its name. A staged folder replaces the numbered images in a folder of its name;
    /// other files in that folder stay.
    pub fn publish(self, last: impl AsRef<Path>) -> io::Result<()> {
        self.publish_as(last.as_ref(), Replace::Yes)
    }

    /// As [`Self::publish`]; files that exist can be an error instead.
    pub(super) fn publish_as(self, last: &Path, replace: Replace) -> io::Result<()> {
        publication::publish(self.hidden, &self.folder, last, replace)
    }
}

/// Fails if nothing more can be written into a folder: the cause of an error for which a library gives none.
pub(super) fn probe(folder: &Path) -> io::Result<()> {
    let mut file = tempfile::tempfile_in(folder)?;
    file.write_all(&vec![0; PROBE_BYTES])?;
    file.sync_all()
}

/// Whether a name is that of a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IsFolder {
    /// It is of a folder of numbered pictures.
    Yes,
    /// It is of a file.
    No,
}

/// Creates the missing folders of a path, and adds them to `made`, the outermost first.
fn make_folders(folder: &Path, made: &mut Vec<PathBuf>) -> io::Result<()> {
    let missing: Vec<_> = folder
        .ancestors()
        .take_while(|ancestor| !ancestor.as_os_str().is_empty() && !ancestor.exists())
        .collect();
    for ancestor in missing.into_iter().rev() {
        match fs::create_dir(ancestor) {
            Ok(()) => made.push(ancestor.to_owned()),
            // Another process has created it meanwhile.
            Err(_) if ancestor.is_dir() => {}
            Err(error) => return Err(describe(ancestor, error)),
        }
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

    pub(super) fn names(folder: &Path) -> Vec<String> {
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

    #[test]
    fn nothing_is_published_where_one_file_cannot_be() {
        let root = tempfile::tempdir().unwrap();
        for name in ["a.csv", "z.csv"] {
            fs::write(root.path().join(name), "old").unwrap();
        }
        fs::create_dir_all(root.path().join("m.csv/within")).unwrap();
        let staging = Staging::new(root.path()).unwrap();
        let ahead = staging.check([(Path::new("a.csv"), IsFolder::No), (Path::new("m.csv"), IsFolder::No)]);
        for name in ["a.csv", "b.csv", "m.csv", "z.csv"] {
            fs::write(staging.path(name), "new").unwrap();
        }
        let at_the_end = staging.publish("z.csv");
        for error in [ahead, at_the_end] {
            let line = error.unwrap_err().to_string();
            let path = root.path().join("m.csv");
            assert_eq!(
                line,
                format!(
                    "{} cannot be written: it is a folder; remove it, or choose another place",
                    path.display()
                )
            );
        }
        assert_eq!(names(root.path()), ["a.csv", "m.csv", "z.csv"]);
        for name in ["a.csv", "z.csv"] {
            assert_eq!(fs::read_to_string(root.path().join(name)).unwrap(), "old");
        }
    }

    #[test]
    fn a_file_in_place_of_a_folder_is_told_before() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("masks"), "mine").unwrap();
        let staging = Staging::new(root.path()).unwrap();
        let line = staging.check([(Path::new("masks"), IsFolder::Yes)]).unwrap_err().to_string();
        assert!(line.contains("masks cannot be written: it is a file, not a folder"), "{line}");
    }

    #[test]
    fn a_file_in_place_of_the_folder_of_a_file_is_told_before() {
        let root = tempfile::tempdir().unwrap();
        let staging = Staging::new(root.path()).unwrap();
        let check = || staging.check([(Path::new("truth/gt.txt"), IsFolder::No)]);
        check().unwrap();
        fs::write(root.path().join("truth"), "mine").unwrap();
        let line = check().unwrap_err().to_string();
        assert!(line.contains("truth cannot be written: it is a file, not a folder"), "{line}");
    }

    #[test]
    fn a_single_numbered_picture_leaves_others_alone() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("000001.png"), "mine").unwrap();
        let staging = Staging::new(root.path()).unwrap();
        fs::write(staging.path("000002.png"), "new").unwrap();
        staging.publish("000002.png").unwrap();
        assert_eq!(names(root.path()), ["000001.png", "000002.png"]);
    }

    #[test]
    fn nested_folders_are_merged() {
        let root = tempfile::tempdir().unwrap();
        let images = root.path().join("truth/identities");
        fs::create_dir_all(&images).unwrap();
        for name in ["000007.png", "notes.txt"] {
            fs::write(images.join(name), "old").unwrap();
        }
        fs::write(root.path().join("truth/000001.png"), "mine").unwrap();
        let staging = Staging::new(root.path()).unwrap();
        let folder = staging.folder("truth/identities").unwrap();
        fs::write(folder.join("000001.png"), "new").unwrap();
        fs::write(staging.path("truth/gt.txt"), "new").unwrap();
        staging.publish("truth/gt.txt").unwrap();
        assert_eq!(names(&images), ["000001.png", "notes.txt"]);
        assert_eq!(names(&root.path().join("truth")), ["000001.png", "gt.txt", "identities"]);
        assert_eq!(names(root.path()), ["truth"]);
    }
}
