//! Where frames come from: video files, folders and patterns of images, cameras.
//!
//! Every later stage sees only [`Frame`]s, 8-bit RGB, in order.

mod ahead;
pub mod cache;
mod image_file;
mod images;
mod numbering;
mod pattern;
mod quiet;
mod rate;
mod video;

#[cfg(test)]
mod tests;

use std::fs;
use std::io::ErrorKind;

use crate::frame::{Frame, Size};
use crate::settings::Settings;

pub use quiet::silence_libraries;
pub use rate::{FPS_RANGE, FpsFrom, parse_fps};

/// What is known of a source before its frames are read.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceInfo {
    /// As the user named it: a path, a pattern, `camera:0`.
    pub name: String,
    /// Width and height of every frame.
    pub size: Size,
    /// Frames a second; 25 where nothing says how many.
    pub fps: f32,
    /// What says how many.
    pub fps_from: FpsFrom,
    /// How many frames it says it has: exact for images, an estimate for videos, none for cameras.
    pub frames: Option<u32>,
    /// Whether frames come as time passes and never again.
    pub live: bool,
}

impl SourceInfo {
    /// How many of the first frames are learnt from before they are judged, where there are so many: none of a camera,
    /// whose frames come once.
    pub fn bootstrap(&self, settings: &Settings) -> u32 {
        if self.live { 0 } else { settings.bootstrap.frames(self.fps) }
    }
}

/// What is chosen of a source besides its name. None of it is a setting: it is as much a part of the input as the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// How many frames a second there are, where that is not for the source to say.
    pub fps: Option<f32>,
}

/// A sequence of frames, read once from the first to the last.
pub trait Source: Send {
    /// What is known of it.
    fn info(&self) -> &SourceInfo;

    /// The next frame, `None` after the last. All frames have the size of [`SourceInfo::size`].
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError>;

    /// Jumps to about the frame at this position, from 0; whether it can jump at all. Where it lands
    /// only the frames tell that come next, whose numbers count from elsewhere. Before any of them
    /// was read.
    fn seek(&mut self, _position: u32) -> bool {
        false
    }

    /// What went wrong without ending the sequence since this was last asked (an image that could
    /// not be read and was skipped, a video that broke off), a sentence each.
    fn take_warnings(&mut self) -> Vec<String>;
}

/// Why a source cannot be used. Each message names what, which file, why, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// Nothing stands there.
    #[error("{0} does not exist; check the path")]
    Missing(String),
    /// There, but not to be read as video or images.
    #[error("{path} cannot be used: {why}")]
    Unusable {
        /// The file, folder, pattern or camera.
        path: String,
        /// Why, and what to do.
        why: String,
    },
}

impl SourceError {
    pub(crate) fn unusable(path: &str, why: impl Into<String>) -> Self {
        // Libraries like to break their messages; a message of ours is one line.
        let why = why.into().split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Unusable { path: path.to_owned(), why }
    }
}

/// Opens what `name` names: a video file, a folder of images, a printf pattern such as
/// `in%06d.png`, or a camera as `camera:0`.
///
/// The first frame is decoded already, so that what cannot be read fails here. A folder's images
/// are all measured here: when they differ in size, it fails before any is analysed.
pub fn open(name: &str, options: Options) -> Result<Box<dyn Source>, SourceError> {
    silence_libraries();
    if let Some(index) = name.strip_prefix("camera:") {
        return Ok(Box::new(video::open_camera(name, index, options)?));
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
        Ok(Box::new(video::open_file(name, options)?))
    } else {
        Err(SourceError::unusable(
            name,
            "it is neither a file nor a folder; cameras are camera:0, camera:1, …",
        ))
    }
}
