//! Where frames come from: video files, folders and patterns of images, cameras.
//!
//! Every later stage sees only [`Frame`]s, 8-bit RGB, in order.

use crate::frame::{Frame, Size};

/// What is known of a source before its frames are read.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceInfo {
    /// As the user named it: a path, a pattern, `camera:0`.
    pub name: String,
    /// Width and height of every frame.
    pub size: Size,
    /// Frames a second; 25 where the source does not say.
    pub fps: f32,
    /// How many frames it says it has: exact for images, an estimate for videos, none for cameras.
    pub frames: Option<u32>,
    /// Whether frames come as time passes and never again.
    pub live: bool,
}

/// A sequence of frames, read once from the first to the last.
pub trait Source: Send {
    /// What is known of it.
    fn info(&self) -> &SourceInfo;

    /// The next frame, `None` after the last. All frames have the size of [`SourceInfo::size`].
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError>;

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
