//! Sources of frames: video files, folders and patterns of images, cameras.
//!
//! [`open`] gives a [`Source`] for a name. It gives [`Frame`]s of 8-bit RGB in order, all of one size, to all later
//! stages; [`cache`] gives them at any position. Frames are numbered from 1, or by the numbers in the images' file
//! names.

pub(crate) mod ahead;
pub mod cache;
mod camera;
mod image_file;
mod images;
mod numbering;
mod options;
mod pattern;
mod quiet;
pub mod random_access;
mod rate;
mod video;

#[cfg(test)]
mod tests;

use std::fs;
use std::io::ErrorKind;

use random_access::RandomAccess;

use crate::frame::{Frame, Size};
use crate::settings::Settings;

pub use options::Options;
pub use quiet::silence_libraries;
pub use rate::{FPS_RANGE, FpsFrom, parse_fps};

/// Properties of a source that are known before its frames are read.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceInfo {
    /// The name given by the user: a path, a pattern, `camera:0`.
    pub name: String,
    /// Width and height of every frame.
    pub size: Size,
    /// Frames per second; 25 where no rate is given.
    pub fps: f32,
    /// The origin of the frame rate.
    pub fps_from: FpsFrom,
    /// Number of frames according to the source: exact for images, an estimate for videos, `None` for cameras.
    pub frames: Option<u32>,
    /// Whether the source is live: its frames come in real time and cannot be read again.
    pub live: bool,
}

impl SourceInfo {
    /// Number of the first frames that the model learns from before it classifies them, if the sequence has that
    /// many. 0 for a live source, whose frames come once.
    pub fn bootstrap(&self, settings: &Settings) -> u32 {
        if self.live { 0 } else { settings.bootstrap.frames(self.fps) }
    }
}

/// A sequence of frames, read once from the first to the last.
pub trait Source: Send {
    /// Properties of the source.
    fn info(&self) -> &SourceInfo;

    /// The next frame, `None` after the last. All frames have the size of [`SourceInfo::size`].
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError>;

    /// A second reader of the frames that this one gives. `None` where opening the source again is the only way.
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
        Self::Unusable { path: path.to_owned(), why }
    }

    pub(crate) fn changed(path: &str) -> Self {
        Self::unusable(path, "it changed while being read; open it again")
    }
}

/// Opens the source `name`: a video file, a folder of images, a printf pattern such as `in%06d.png`, or a camera as
/// `camera:0`.
///
/// The first frame is decoded, so that an unreadable source fails here. The sizes of all images of a folder are read;
/// it fails here if they differ.
pub fn open(name: &str, options: Options) -> Result<Box<dyn Source>, SourceError> {
    silence_libraries();
    if let Some(index) = name.strip_prefix("camera:") {
        return Ok(Box::new(camera::Camera::open(name, index, options)?));
    }
    let metadata = match fs::metadata(name) {
        Ok(metadata) => metadata,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return if name.contains('%') {
                Ok(Box::new(images::ImageSequence::of_pattern(name, options)?))
            } else {
                Err(SourceError::Missing(name.to_owned()))
            };
        }
        Err(error) => return Err(SourceError::unusable(name, format!("{error}; check its permissions"))),
    };
    if metadata.is_dir() {
        Ok(Box::new(images::ImageSequence::of_folder(name, options)?))
    } else if metadata.is_file() {
        Ok(Box::new(video::Video::open(name, options)?))
    } else {
        Err(SourceError::unusable(
            name,
            "it is neither a file nor a folder; cameras are camera:0, camera:1, …",
        ))
    }
}
