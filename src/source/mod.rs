//! Sources of frames: video files, network streams, folders and patterns of images, cameras.
//!
//! [`open`] gives a [`Source`] for a name. It gives [`Frame`]s of 8-bit RGB in order, all of one size, to all later
//! stages; [`cache`] gives them at any position. Frames are numbered from 1, or by the numbers in the images' file
//! names.

pub(crate) mod ahead;
pub mod cache;
mod camera;
mod folder;
mod image_file;
mod images;
mod jpeg;
mod jpeg_data;
mod kind;
mod levels;
mod name;
mod numbering;
mod options;
mod pattern;
mod quiet;
pub mod random_access;
mod rate;
mod reduced;
#[cfg(test)]
mod reopened;
mod scene_folder;
mod step_back;
mod tiff_pages;
mod tiff_samples;
mod video;

#[cfg(test)]
mod tests;

use random_access::RandomAccess;

use crate::frame::{Frame, Size};
use crate::placement::Placement;
use crate::settings::Settings;

pub(crate) use image_file::{MAX_PIXELS, has_image_name};
pub use kind::SourceKind;
pub use levels::{LevelRange, Levels};
pub use name::{name_of, path_of, shown};
pub use options::{Options, SCALE_RANGE, parse_crop, parse_scale};
pub use quiet::silence_libraries;
pub(crate) use rate::sequence_length;
pub use rate::{FPS_RANGE, FpsFrom, parse_fps};
pub use scene_folder::SceneFolder;

/// The endings of the names of videos, besides animations.
pub const VIDEO_ENDINGS: [&str; 17] = [
    "mp4", "avi", "mkv", "mov", "webm", "m4v", "mpg", "mpeg", "ogv", "mts", "m2ts", "ts", "3gp", "wmv",
    "flv", "y4m", "mxf",
];

/// Properties of a source that are known before its frames are read.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceInfo {
    /// The name given by the user: that of a path ([`name_of`]), a pattern, an address (without a password in it),
    /// `camera:0`.
    pub name: String,
    /// Width and height of every frame.
    pub size: Size,
    /// Width and height of a pixel, as a ratio; `None` where pixels are square or their shape is not known.
    pub pixel_aspect: Option<(u32, u32)>,
    /// Frames per second; 25 where no rate is given.
    pub fps: f32,
    /// The origin of the frame rate.
    pub fps_from: FpsFrom,
    /// Number of frames according to the source: exact for images, an estimate for videos, `None` for live sources.
    pub frames: Option<u32>,
    /// Whether the source is live: its frames come in real time and cannot be read again.
    pub live: bool,
    /// How its frames differ from the images of the source, if they do. [`Self::size`], [`Self::fps`] and
    /// [`Self::frames`] are those of the frames.
    pub reduction: Option<Reduction>,
}

/// The reduction of a source's images to fewer or smaller frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Where the frames lie in the images.
    pub placement: Placement,
    /// The distance of the frames in images of the source, at least 1.
    pub every: u32,
    /// Images of the source per second.
    pub fps: f32,
}

impl SourceInfo {
    /// Number of the first frames that the model learns from before it classifies them, if the sequence has that
    /// many. 0 for a live source, whose frames come once.
    pub fn bootstrap(&self, settings: &Settings) -> u32 {
        if self.live { 0 } else { settings.bootstrap.frames(self.fps) }
    }

    /// Where the frames lie in the source's images; `None` where they are these images.
    pub fn placement(&self) -> Option<Placement> {
        self.reduction.map(|reduction| reduction.placement).filter(|placement| !placement.is_identity())
    }

    /// Size of the source's images.
    pub fn source_size(&self) -> Size {
        self.placement().map_or(self.size, |placement| placement.source())
    }

    /// The distance of the frames in images of the source, at least 1.
    pub fn every(&self) -> u32 {
        self.reduction.map_or(1, |reduction| reduction.every)
    }

    /// Images of the source per second.
    pub fn source_fps(&self) -> f32 {
        self.reduction.map_or(self.fps, |reduction| reduction.fps)
    }
}

/// A sequence of frames, read once from the first to the last.
pub trait Source: Send {
    /// Properties of the source.
    fn info(&self) -> &SourceInfo;

    /// The next frame, `None` after the last. All frames have the size of [`SourceInfo::size`].
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError>;

    /// Goes past the next frame without giving it; returns whether there was one.
    fn skip_frame(&mut self) -> Result<bool, SourceError> {
        Ok(self.next_frame()?.is_some())
    }

    /// Another reader of the frames that this one gives. `None` for a live source.
    fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
        None
    }

    /// Takes the warnings since the last call, one sentence each, of problems that did not end the sequence: an image
    /// that could not be read and was skipped, a video that broke off.
    fn take_warnings(&mut self) -> Vec<String>;
}

/// An error of a source. Each message names the file, the problem, its cause and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// There is nothing at this path.
    #[error("{0} does not exist; check the path")]
    Missing(String),
    /// The path exists but cannot be read as video or images.
    #[error("{path} cannot be used: {why}")]
    Unusable {
        /// The file, folder, pattern or camera.
        path: String,
        /// The cause and a remedy.
        why: String,
    },
}

impl SourceError {
    pub(crate) fn unusable(path: &str, why: impl Into<String>) -> Self {
        // Messages of libraries may contain line breaks; ours are one line.
        let why = why.into().split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Unusable { path: shown(path).into_owned(), why: shown(&why).into_owned() }
    }

    pub(crate) fn changed(path: &str) -> Self {
        Self::unusable(path, "it changed while being read; open it again")
    }
}

/// Opens the source of this name ([`name_of`] a path, or an address or camera): a video file, a TIFF file of several pages, a folder of images, a data set's folder of a
/// sequence ([`SceneFolder`]), a printf pattern such as `in%06d.png`, a camera as `camera:0`, or a network stream as an
/// address, `rtsp://…`, `http://…` or `https://…`, which is read once.
///
/// The first frame is decoded, so that an unreadable source fails here. The sizes of all images of a folder are read;
/// it fails here if they differ, or if the crop of `options` reaches beyond them. It fails where an option is given that
/// this kind of source does not have.
pub fn open(name: &str, options: Options) -> Result<Box<dyn Source>, SourceError> {
    reduced::Reduced::of(open_whole(name, options)?, options)
}

/// Opens the source with all its images as they are.
fn open_whole(name: &str, options: Options) -> Result<Box<dyn Source>, SourceError> {
    silence_libraries();
    let kind = SourceKind::of(name)?;
    kind.check(name, options)?;
    Ok(match kind {
        SourceKind::Camera => Box::new(camera::Camera::open(name, options)?),
        SourceKind::Network | SourceKind::Video => Box::new(video::Video::open(name, options)?),
        SourceKind::Pattern => Box::new(images::ImageSequence::of_pattern(name, options)?),
        SourceKind::Folder => {
            let path = path_of(name);
            let scene = SceneFolder::at(&path);
            let folder = scene.as_ref().map_or(&*path, |scene| &scene.images);
            Box::new(images::ImageSequence::of_folder(name, folder, options)?)
        }
        SourceKind::Pages => Box::new(images::ImageSequence::of_pages(name, options)?),
    })
}
