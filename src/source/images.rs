//! Image sequences from folders, patterns and TIFF files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use image::DynamicImage;

use super::image_file::{self, ImageFile, Page};
use super::levels::{self, LevelRange};
use super::numbering::{NumberClock, NumberedFiles};
use super::random_access::{Fingerprint, RandomAccess, Step, is_same};
use super::rate::ImageRate;
use super::{
    FpsFrom, Options, Source, SourceError, SourceInfo, folder, path_of, rate, scene_folder, tiff_pages,
};
use crate::frame::{Frame, Size};

/// An image sequence; all images have one size.
pub(super) struct ImageSequence {
    info: SourceInfo,
    files: std::vec::IntoIter<ListedImage>,
    clock: NumberClock,
    levels: Option<LevelRange>,
    /// The files of the frames so far.
    read: Arc<Mutex<Vec<ImageFile>>>,
    /// The first frame, decoded at opening to check that there is one.
    first: Option<Frame>,
    /// Whether a file with several pictures has been reported.
    has_reported_further: bool,
    warnings: Vec<String>,
}

struct ListedImage {
    file: ImageFile,
    number: u32,
    /// The error of reading its header.
    unreadable: Option<String>,
}

impl ImageSequence {
    /// The images of `folder` in the natural order of their names; other files are ignored.
    pub(super) fn of_folder(name: &str, folder: &Path, options: Options) -> Result<Self, SourceError> {
        let NumberedFiles { files, mut warnings } = folder::images(name, folder)?;
        let path = path_of(name);
        warnings.extend(scene_folder::missing_images(&path, folder));
        // The folder of images within that of a sequence may be a link.
        let described = if rate::is_described(folder) { folder } else { &path };
        Self::new(
            name,
            options,
            rate_of(options, Some(described)),
            files.into_iter().map(whole_file),
            warnings,
        )
    }

    /// The images whose names match a pattern such as `in%06d.png`, ordered by number.
    pub(super) fn of_pattern(name: &str, options: Options) -> Result<Self, SourceError> {
        let (folder, NumberedFiles { files, warnings }) = folder::matches(name)?;
        Self::new(name, options, rate_of(options, Some(&folder)), files.into_iter().map(whole_file), warnings)
    }

    /// The pages of a TIFF file, numbered from 1.
    pub(super) fn of_pages(name: &str, options: Options) -> Result<Self, SourceError> {
        let path = path_of(name);
        let pages = tiff_pages::pages(&path, u32::MAX as usize)
            .map_err(|error| SourceError::unusable(name, format!("{error}; check that it is complete")))?;
        let mut warnings = Vec::new();
        if pages.is_cut_off {
            let whole = pages.directories.len();
            warnings.push(format!("{name} is truncated; it is read to page {whole}, the last whole one"));
        } else if pages.directories.len() < 2 {
            let why = "it is a single image; give its folder, or a pattern such as in%06d.tif";
            return Err(SourceError::unusable(name, why));
        }
        let files = (1..).zip(pages.directories).map(|(number, directory)| {
            let page = Some(Page { number, directory });
            (ImageFile { path: path.to_path_buf(), page }, number)
        });
        Self::new(name, options, rate_of(options, None), files, warnings)
    }

    fn new(
        name: &str,
        options: Options,
        rate: ImageRate,
        files: impl Iterator<Item = (ImageFile, u32)>,
        mut warnings: Vec<String>,
    ) -> Result<Self, SourceError> {
        let mut first: Option<(Size, ImageFile)> = None;
        let mut listed = Vec::new();
        for (file, number) in files {
            let unreadable = match (image_file::size(&file), &first) {
                (Ok(size), Some((expected, other))) if size != *expected => {
                    return Err(differ(name, (other, *expected), (&file, size)));
                }
                (Ok(size), None) => {
                    first = Some((size, file.clone()));
                    None
                }
                (Ok(_), Some(_)) => None,
                (Err(why), _) => Some(why),
            };
            listed.push(ListedImage { file, number, unreadable });
        }
        let why = listed
            .iter()
            .find_map(|image| Some(format!(" ({}: {})", image.file, image.unreadable.as_ref()?)));
        let why = why.unwrap_or_default();
        let none = || {
            let what = "none of its images can be read";
            SourceError::unusable(
                name,
                format!("{what}{why}; check that they are complete, or convert them to PNG"),
            )
        };
        let (size, _) = first.ok_or_else(&none)?;
        let readable: Vec<_> =
            listed.iter().filter(|image| image.unreadable.is_none()).map(|image| &image.file).collect();
        let frames = Some(readable.len() as u32);
        let levels = options.levels.map(|levels| levels.range(&readable)).transpose();
        let levels = levels.map_err(|why| SourceError::unusable(name, why))?;
        let ImageRate { fps, from: fps_from, warning } = rate;
        let clock = NumberClock::new(listed.iter().map(|image| image.number), fps);
        let info = SourceInfo {
            name: name.to_owned(),
            size,
            pixel_aspect: None,
            fps,
            fps_from,
            frames,
            live: false,
            reduction: None,
        };
        warnings.extend(warning);
        let mut sequence = Self {
            info,
            files: listed.into_iter(),
            clock,
            levels,
            read: Arc::default(),
            first: None,
            has_reported_further: false,
            warnings,
        };
        sequence.first = sequence.decode_next();
        if sequence.first.is_some() { Ok(sequence) } else { Err(none()) }
    }

    /// The next readable image.
    fn decode_next(&mut self) -> Option<Frame> {
        while let Some(ListedImage { file, number, unreadable }) = self.files.next() {
            let decoded = unreadable.map_or_else(|| image_file::decode(&file), Err);
            let why = match decoded {
                Ok(image) if has_size(&image, self.info.size) => {
                    self.report_unusual(&image, &file);
                    let (size, rgb) = image_file::rgb(image, self.levels);
                    self.add_read(file);
                    return Some(Frame::new(number, size, rgb).at_time(self.clock.time(number)));
                }
                Ok(image) => {
                    let size = Size::new(image.width(), image.height());
                    format!("it is {size}, but its header says {}", self.info.size)
                }
                Err(why) => why,
            };
            self.warn_of(number, &file, &why);
        }
        None
    }

    fn add_read(&self, file: ImageFile) {
        self.read.lock().unwrap_or_else(PoisonError::into_inner).push(file);
    }

    fn warn_of(&mut self, number: u32, file: &ImageFile, why: &str) {
        let why = why.split_whitespace().collect::<Vec<_>>().join(" ");
        self.warnings.push(format!("frame {number} is skipped: {file} cannot be read ({why})"));
    }

    /// Warns of levels that are lost, judged by the first image, and of the first file with several pictures.
    fn report_unusual(&mut self, image: &DynamicImage, file: &ImageFile) {
        let is_first = self.read.lock().unwrap_or_else(PoisonError::into_inner).is_empty();
        if is_first && self.levels.is_none() {
            self.warnings.extend(levels::suggestion(image).map(|text| format!("{file} {text}")));
        }
        if !self.has_reported_further
            && file.page.is_none()
            && let Some(text) = image_file::further_pictures(&file.path)
        {
            self.has_reported_further = true;
            self.warnings.push(format!("{file} {text}"));
        }
    }
}

/// Image files carry no frame rate: it is given, or read from a file beside them.
fn rate_of(options: Options, folder: Option<&Path>) -> ImageRate {
    match (options.fps, folder) {
        (Some(fps), _) => ImageRate { fps, from: FpsFrom::Given, warning: None },
        (None, Some(folder)) => rate::of_images(folder),
        (None, None) => ImageRate { fps: rate::ASSUMED, from: FpsFrom::Assumed, warning: None },
    }
}

fn whole_file((path, number): (PathBuf, u32)) -> (ImageFile, u32) {
    (ImageFile { path, page: None }, number)
}

impl Source for ImageSequence {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        Ok(self.first.take().or_else(|| self.decode_next()))
    }

    /// An image with a readable header counts as one that can be read.
    fn skip_frame(&mut self) -> Result<bool, SourceError> {
        if self.first.take().is_some() {
            return Ok(true);
        }
        while let Some(ListedImage { file, number, unreadable }) = self.files.next() {
            let Some(why) = unreadable else {
                self.add_read(file);
                return Ok(true);
            };
            self.warn_of(number, &file, &why);
        }
        Ok(false)
    }

    fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
        let (name, read) = (self.info.name.clone(), Arc::clone(&self.read));
        Some(Box::new(ImageFiles { name, size: self.info.size, levels: self.levels, read }))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}

/// The images of a sequence again, each directly from its file.
struct ImageFiles {
    name: String,
    size: Size,
    levels: Option<LevelRange>,
    read: Arc<Mutex<Vec<ImageFile>>>,
}

impl RandomAccess for ImageFiles {
    fn step(&mut self, _: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        let file = self.read.lock().unwrap_or_else(PoisonError::into_inner).get(goal as usize).cloned();
        let image = file.and_then(|file| image_file::read(&file, self.levels).ok());
        image
            .filter(|(size, _)| *size == self.size)
            .map(|(size, rgb)| Frame::new(goal + 1, size, rgb))
            .filter(|frame| is_same(fingerprints, goal, frame))
            .map(|frame| Step::Frame(goal, frame))
            .ok_or_else(|| SourceError::changed(&self.name))
    }
}

fn has_size(image: &DynamicImage, size: Size) -> bool {
    (image.width(), image.height()) == (size.width, size.height)
}

fn differ(
    name: &str,
    (first, size): (&ImageFile, Size),
    (other, other_size): (&ImageFile, Size),
) -> SourceError {
    let (first, other) = (first.short_name(), other.short_name());
    let is_turned = (size.width, size.height) == (other_size.height, other_size.width);
    SourceError::unusable(
        name,
        if is_turned {
            let [shape, other_shape] = [size, other_size]
                .map(|size| if size.width > size.height { "landscape" } else { "portrait" });
            format!(
                "its images are in both orientations, {first} is {shape} ({size}) and {other} is {other_shape} \
                 ({other_size}); give a folder or a pattern of images of one orientation"
            )
        } else {
            format!(
                "its images differ in size, {first} is {size} and {other} is {other_size}; give a folder or a \
                 pattern of images of one size"
            )
        },
    )
}
