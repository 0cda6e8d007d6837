//! The folder of a sequence as data sets lay it out: images in a folder within it, ground truth beside them.

use std::fs;
use std::path::{Path, PathBuf};

use super::{image_file, rate};

/// The folder of a sequence in the layout of CDnet (`input/`, `groundtruth/`) or MOTChallenge (`img1/`, `gt/gt.txt`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFolder {
    /// The folder of the images.
    pub images: PathBuf,
    /// The path of the ground truth, as [`crate::truth::TruthSource::of`] accepts it.
    pub truth: Option<PathBuf>,
}

impl SceneFolder {
    /// The sequence at `path`; `None` if it is no such folder, or has images of its own.
    pub fn at(path: &Path) -> Option<Self> {
        if !path.is_dir() || has_images(path) {
            return None;
        }
        let named = rate::image_folder(path).filter(|name| !name.is_empty());
        let folders = named.iter().map(String::as_str).chain(["img1", "input"]);
        let images = folders.map(|folder| path.join(folder)).find(|folder| has_images(folder))?;
        let boxes = path.join("gt").join("gt.txt");
        let truth = match () {
            () if path.join("groundtruth").is_dir() => Some(path.to_owned()),
            () if boxes.is_file() => Some(boxes),
            () => None,
        };
        Some(Self { images, truth })
    }
}

/// A warning where the `seqinfo.ini` of the sequence at `path` names another folder of images than `images`, which are read.
pub(super) fn missing_images(path: &Path, images: &Path) -> Option<String> {
    let named = rate::image_folder(path).filter(|name| !name.is_empty() && path != images)?;
    (path.join(&named) != images).then(|| {
        format!(
            "{}: imDir names the folder {named}, which has no images; {} is read in its place",
            path.join(rate::SEQINFO).display(),
            images.display()
        )
    })
}

/// Whether a folder has an image that can be a frame. The region of interest of CDnet lies beside its `input/`.
fn has_images(folder: &Path) -> bool {
    let is_roi =
        |path: &Path| path.file_stem().is_some_and(|stem| stem.to_string_lossy().eq_ignore_ascii_case("roi"));
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    files.into_iter().any(|path| image_file::has_image_name(&path) && !is_roi(&path) && !path.is_dir())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn folder_with(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, if *file == "seqinfo.ini" { "[Sequence]\nimDir=frames ; all\n" } else { "" })
                .unwrap();
        }
        folder
    }

    #[test]
    fn images_and_truth_are_found_in_the_layouts_of_data_sets() {
        for (files, images, truth) in [
            (
                &["input/in000001.jpg", "groundtruth/gt000001.png", "ROI.bmp", "ROI.jpg"][..],
                "input",
                Some(""),
            ),
            (&["input/in000001.jpg", "temporalROI.txt"][..], "input", None),
            (&["img1/000001.jpg", "gt/gt.txt"][..], "img1", Some("gt/gt.txt")),
            (
                &["img1/000001.jpg", "frames/1.png", "seqinfo.ini", "gt/gt.txt"][..],
                "frames",
                Some("gt/gt.txt"),
            ),
            (&["img1/000001.jpg", "frames/notes.txt", "seqinfo.ini"][..], "img1", None),
        ] {
            let folder = folder_with(files);
            let path = folder.path();
            let truth = truth.map(|truth| if truth.is_empty() { path.to_owned() } else { path.join(truth) });
            let expected = SceneFolder { images: path.join(images), truth };
            if let Some(truth) = &expected.truth {
                crate::truth::TruthSource::of(truth).unwrap();
            }
            let warning = missing_images(path, &expected.images);
            assert_eq!(warning.is_some(), files.contains(&"frames/notes.txt"), "{warning:?}");
            assert_eq!(SceneFolder::at(path), Some(expected), "{files:?}");
        }
    }

    #[test]
    fn other_folders_are_what_they_are() {
        for files in [
            &["1.png", "input/2.png"][..],
            &["notes.txt"],
            &["ROI.bmp"],
            &["input/notes.txt", "groundtruth/gt000001.png"],
        ] {
            assert_eq!(SceneFolder::at(folder_with(files).path()), None, "{files:?}");
        }
        assert_eq!(SceneFolder::at(Path::new("/nothing/there")), None);
    }
}
