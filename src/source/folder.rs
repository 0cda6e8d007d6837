//! The images in a folder, or those that match a pattern.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::numbering::{NumberedFiles, number_frames};
use super::pattern::Pattern;
use super::{SourceError, image_file};

/// The images of `folder` in the natural order of their names; other files are ignored. `name` is for errors.
pub(super) fn images(name: &str, folder: &Path) -> Result<NumberedFiles, SourceError> {
    let mut files = list(name, folder)?;
    let anything = !files.is_empty();
    files.retain(|path| image_file::has_image_name(path) && is_file_or_broken_link(path));
    if files.is_empty() {
        let why = if anything { "the folder holds no images" } else { "the folder is empty" };
        return Err(SourceError::unusable(
            name,
            format!("{why}; give a video, or a folder of png, jpg, bmp, tif, webp, gif or pnm images"),
        ));
    }
    files.sort_by(|a, b| {
        let (a, b) = (a.to_string_lossy(), b.to_string_lossy());
        natord::compare(&a, &b).then_with(|| a.cmp(&b))
    });
    number_frames(files).map_err(|why| SourceError::unusable(name, why))
}

/// The folder of the pattern `name`, such as `in%06d.png`, and the files whose names match it, by number.
pub(super) fn matches(name: &str) -> Result<(&Path, NumberedFiles), SourceError> {
    let path = Path::new(name);
    let folder = path.parent().unwrap_or(Path::new(""));
    let pattern = path
        .file_name()
        .and_then(|file| Pattern::parse(&file.to_string_lossy()))
        .filter(|_| !folder.to_string_lossy().contains('%') || folder.is_dir())
        .ok_or_else(|| {
            SourceError::unusable(
                name,
                "no such file, and not a pattern; a pattern has one number in the file name, as in \
                 in%06d.png",
            )
        })?;
    if !folder.as_os_str().is_empty() && !folder.is_dir() {
        return Err(SourceError::Missing(folder.display().to_string()));
    }
    let mut files: Vec<(PathBuf, u32)> = list(name, folder)?
        .into_iter()
        .filter_map(|path| {
            let number = pattern.number_in(&path.file_name()?.to_string_lossy())?;
            is_file_or_broken_link(&path).then_some((path, number))
        })
        .collect();
    if files.is_empty() {
        return Err(SourceError::unusable(name, "no file matches the pattern; check its number of digits"));
    }
    files.sort_by_key(|&(_, number)| number);
    Ok((folder, NumberedFiles { files, warnings: Vec::new() }))
}

/// Whether a file is there, or a link that leads to nothing, which is a frame that is missing.
fn is_file_or_broken_link(path: &Path) -> bool {
    fs::metadata(path).map_or_else(|_| path.is_symlink(), |metadata| metadata.is_file())
}

fn list(name: &str, folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let shown = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let fail = |error: std::io::Error| {
        SourceError::unusable(name, format!("the folder cannot be listed ({error}); check its permissions"))
    };
    let names: Result<Vec<OsString>, _> =
        fs::read_dir(shown).map_err(fail)?.map(|entry| entry.map(|entry| entry.file_name())).collect();
    Ok(names.map_err(fail)?.into_iter().map(|file| folder.join(file)).collect())
}
