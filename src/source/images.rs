//! Image sequences from folders and patterns.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::numbering::frame_numbers;
use super::pattern::Pattern;
use super::random_access::{Fingerprint, RandomAccess, Step, fingerprint};
use super::rate::ImageRate;
use super::{FpsFrom, Options, Source, SourceError, SourceInfo, image_file, rate};
use crate::frame::{Frame, Size};

/// An image sequence; all images have one size.
pub(super) struct ImageSequence {
    info: SourceInfo,
    files: std::vec::IntoIter<File>,
    /// The files of the frames so far.
    read: Arc<Mutex<Vec<PathBuf>>>,
    /// The first frame, decoded at opening to check that there is one.
    first: Option<Frame>,
    warnings: Vec<String>,
}

struct File {
    path: PathBuf,
    number: u32,
    /// The error of reading its header.
    unreadable: Option<String>,
}

impl ImageSequence {
    /// The images of a folder in the natural order of their names; other files are ignored.
    pub(super) fn of_folder(name: &str, options: Options) -> Result<Self, SourceError> {
        let mut files = list(name, Path::new(name))?;
        let anything = !files.is_empty();
        files.retain(|path| image_file::has_image_name(path) && path.is_file());
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
        let numbers = frame_numbers(&files);
        Self::new(name, Path::new(name), options, files.into_iter().zip(numbers))
    }

    /// The images whose names match a pattern such as `in%06d.png`, ordered by number.
    pub(super) fn of_pattern(name: &str, options: Options) -> Result<Self, SourceError> {
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
                path.is_file().then_some((path, number))
            })
            .collect();
        if files.is_empty() {
            return Err(SourceError::unusable(
                name,
                "no file matches the pattern; check its number of digits",
            ));
        }
        files.sort_by_key(|&(_, number)| number);
        Self::new(name, folder, options, files.into_iter())
    }

    fn new(
        name: &str,
        folder: &Path,
        options: Options,
        files: impl Iterator<Item = (PathBuf, u32)>,
    ) -> Result<Self, SourceError> {
        let mut first: Option<(Size, PathBuf)> = None;
        let mut listed = Vec::new();
        for (path, number) in files {
            let unreadable = match (image_file::size(&path), &first) {
                (Ok(size), Some((expected, other))) if size != *expected => {
                    return Err(differ(name, (other, *expected), (&path, size)));
                }
                (Ok(size), None) => {
                    first = Some((size, path.clone()));
                    None
                }
                (Ok(_), Some(_)) => None,
                (Err(why), _) => Some(why),
            };
            listed.push(File { path, number, unreadable });
        }
        let none =
            || SourceError::unusable(name, "none of its images can be read; check that they are complete");
        let (size, _) = first.ok_or_else(none)?;
        let frames = listed.iter().filter(|file| file.unreadable.is_none()).count() as u32;
        // Image files carry no frame rate.
        let ImageRate { fps, from: fps_from, warning } = match options.fps {
            Some(fps) => ImageRate { fps, from: FpsFrom::Given, warning: None },
            None => rate::of_images(folder),
        };
        let frames = Some(frames);
        let info = SourceInfo { name: name.to_owned(), size, fps, fps_from, frames, live: false };
        let warnings = warning.into_iter().collect();
        let mut sequence =
            Self { info, files: listed.into_iter(), read: Arc::default(), first: None, warnings };
        sequence.first = sequence.decode_next();
        if sequence.first.is_some() { Ok(sequence) } else { Err(none()) }
    }

    /// The next readable image.
    fn decode_next(&mut self) -> Option<Frame> {
        for file in self.files.by_ref() {
            let read = file.unreadable.map_or_else(|| image_file::read(&file.path), Err);
            let why = match read {
                Ok((size, rgb)) if size == self.info.size => {
                    self.read.lock().unwrap_or_else(PoisonError::into_inner).push(file.path);
                    return Some(Frame::new(file.number, size, rgb));
                }
                Ok((size, _)) => format!("it is {size}, but its header says {}", self.info.size),
                Err(why) => why.split_whitespace().collect::<Vec<_>>().join(" "),
            };
            self.warnings.push(format!(
                "frame {} is skipped: {} cannot be read ({why})",
                file.number,
                file.path.display()
            ));
        }
        None
    }
}

impl Source for ImageSequence {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        Ok(self.first.take().or_else(|| self.decode_next()))
    }

    fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
        let (name, read) = (self.info.name.clone(), Arc::clone(&self.read));
        Some(Box::new(ImageFiles { name, size: self.info.size, read }))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}

/// The images of a sequence again, each directly from its file.
struct ImageFiles {
    name: String,
    size: Size,
    read: Arc<Mutex<Vec<PathBuf>>>,
}

impl RandomAccess for ImageFiles {
    fn step(&mut self, _: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        let path = self.read.lock().unwrap_or_else(PoisonError::into_inner).get(goal as usize).cloned();
        let image = path.and_then(|path| image_file::read(&path).ok());
        image
            .filter(|(size, _)| *size == self.size)
            .map(|(size, rgb)| Frame::new(goal + 1, size, rgb))
            .filter(|frame| fingerprints.get(goal as usize) == Some(&fingerprint(frame)))
            .map(|frame| Step::Frame(goal, frame))
            .ok_or_else(|| SourceError::changed(&self.name))
    }
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

fn differ(name: &str, first: (&Path, Size), other: (&Path, Size)) -> SourceError {
    let file = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    SourceError::unusable(
        name,
        format!(
            "its images differ in size, {} is {} and {} is {}; give a folder or a pattern of images of one \
             size",
            file(first.0),
            first.1,
            file(other.0),
            other.1
        ),
    )
}
