//! A single output file: the complete file or nothing.

use std::io;
use std::path::{Path, PathBuf};

use super::Staging;
use super::staging::{IsFolder, Replace};
use super::write_failure::{describe, refused};

/// A file that is written beside its path and moved there by [`SingleFile::publish`].
///
/// Dropping it before that removes it. Where the path is a link, the file that it leads to is replaced. All errors name the
/// file and a remedy.
#[derive(Debug)]
pub struct SingleFile {
    staging: Staging,
    name: PathBuf,
}

impl SingleFile {
    /// Fails if the file could not be written at the end.
    pub fn new(path: &Path) -> io::Result<Self> {
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let Some(name) = target.file_name().map(PathBuf::from) else {
            let why = "it is the name of no file; choose another place";
            return Err(refused(io::ErrorKind::InvalidInput, path, why.to_owned()));
        };
        let folder =
            target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let staging = Staging::new(folder).map_err(|error| describe(path, error))?;
        staging.check([(name.as_path(), IsFolder::No)])?;
        Ok(Self { staging, name })
    }

    /// The temporary path to write to.
    pub fn staged(&self) -> PathBuf {
        self.staging.path(&self.name)
    }

    /// Waits until the file is on the disk and moves it to its path.
    pub fn publish(self, replace: Replace) -> io::Result<()> {
        self.staging.publish_as(&self.name, replace)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fs;

    use super::*;

    #[test]
    fn an_existing_file_is_replaced_only_where_it_may_be() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for (text, replace, is_written) in
            [("one", Replace::No, true), ("two", Replace::No, false), ("three", Replace::Yes, true)]
        {
            let before = fs::read_to_string(&path).unwrap_or_default();
            let file = SingleFile::new(&path).unwrap();
            fs::write(file.staged(), text).unwrap();
            let published = file.publish(replace);
            assert_eq!(published.is_ok(), is_written);
            if let Err(error) = published {
                assert_eq!(error.kind(), io::ErrorKind::AlreadyExists);
            }
            assert_eq!(fs::read_to_string(&path).unwrap(), if is_written { text } else { &before });
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real/a.txt"), folder.path().join("link"));
        fs::create_dir(folder.path().join("real")).unwrap();
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let file = SingleFile::new(&link).unwrap();
        fs::write(file.staged(), "new").unwrap();
        file.publish(Replace::Yes).unwrap();
        assert!(link.is_symlink() && fs::read_to_string(real).unwrap() == "new");
    }

    #[test]
    fn a_folder_is_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let line = SingleFile::new(folder.path()).unwrap_err().to_string();
        assert!(line.contains("cannot be written: it is a folder"), "{line}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
