//! The images in a folder, or those that match a pattern.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::numbering::{NumberedFiles, number_frames};
use super::pattern::Pattern;
use super::{SourceError, VIDEO_ENDINGS, image_file, name_of, path_of};

/// The images of `folder` in the natural order of their names; other files are ignored. `name` is for errors.
pub(super) fn images(name: &str, folder: &Path) -> Result<NumberedFiles, SourceError> {
    let mut files = list(name, folder)?;
    let anything = !files.is_empty();
    let videos: Vec<PathBuf> = files.iter().filter(|path| has_video_name(path)).cloned().collect();
    files.retain(|path| image_file::has_image_name(path) && is_file_or_broken_link(path));
    check_videos(name, &videos, files.len())?;
    if files.is_empty() {
        let why = if anything { "the folder holds no images" } else { "the folder is empty" };
        return Err(SourceError::unusable(
            name,
            format!("{why}; give a video, or a folder of png, jpg, bmp, tif, webp, gif or pnm images"),
        ));
    }
    files.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()).then_with(|| a.cmp(b)));
    number_frames(files).map_err(|why| SourceError::unusable(name, why))
}

/// Fails for a folder of videos, which can have a picture or an animation beside each of them.
fn check_videos(name: &str, videos: &[PathBuf], images: usize) -> Result<(), SourceError> {
    let Some(first) = videos.first().filter(|_| videos.len() >= images) else { return Ok(()) };
    let of = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let (videos, first) = (of(videos.len(), "video"), first.file_name().unwrap_or_default().display());
    let why = match images {
        0 => format!("the folder holds {videos} and no images; give the video, such as {first} in it"),
        _ => format!(
            "the folder holds {videos} and {}; give the video, such as {first} in it, or a pattern of the images, such as \
             in%06d.png",
            of(images, "image")
        ),
    };
    Err(SourceError::unusable(name, why))
}

fn has_video_name(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| VIDEO_ENDINGS.contains(&ending.as_str())) && path.is_file()
}

/// The folder of the pattern `name`, such as `in%06d.png`, and the files whose names match it, by number.
pub(super) fn matches(name: &str) -> Result<(PathBuf, NumberedFiles), SourceError> {
    let path = path_of(name);
    let folder = path.parent().unwrap_or(Path::new(""));
    let pattern = path
        .file_name()
        .and_then(|file| Pattern::parse(&name_of(file)))
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
            let number = pattern.number_in(&name_of(path.file_name()?))?;
            is_file_or_broken_link(&path).then_some((path, number))
        })
        .collect();
    if files.is_empty() {
        return Err(SourceError::unusable(name, "no file matches the pattern; check its number of digits"));
    }
    files.sort_by_key(|&(_, number)| number);
    Ok((folder.to_owned(), NumberedFiles { files, warnings: Vec::new() }))
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
