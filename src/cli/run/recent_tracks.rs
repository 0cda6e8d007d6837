//! The tracks of the latest frames, for the trails in annotated frames.

use crate::export::annotate::ANNOTATED_SECONDS;
use crate::tracking::FrameTracks;

/// The tracks of the frames that are to be annotated next, and of those before them that their annotations show.
#[derive(Default)]
pub(super) struct RecentTracks {
    frames: Vec<FrameTracks>,
}

impl RecentTracks {
    /// Adds the next frame.
    pub(super) fn push(&mut self, frame: FrameTracks) {
        self.frames.push(frame);
    }

    /// All frames that are held, in order.
    pub(super) fn frames(&self) -> &[FrameTracks] {
        &self.frames
    }

    /// Drops what no frame after the last one shows.
    pub(super) fn forget(&mut self) {
        let Some(last) = self.frames.last() else { return };
        let since = last.time - f64::from(ANNOTATED_SECONDS);
        // The frame before is always shown.
        let end = self.frames.partition_point(|frame| frame.time < since).min(self.frames.len() - 1);
        self.frames.drain(..end);
    }
}
