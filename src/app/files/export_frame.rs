//! Export of the frame in view as an image.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::files::atomic_write;
use crate::app::model::Model;
use crate::export::annotate::{FrameAnnotations, annotate};
use crate::export::picture;
use crate::frame::Frame;
use crate::occlusion::Event;
use crate::replay::ShownFrame;
use crate::tracking::FrameTracks;

/// A frame with its annotations, retained while a path is chosen.
pub(crate) struct FrameExport {
    shown: Arc<ShownFrame>,
    recent: Vec<FrameTracks>,
    events: Vec<Event>,
}

impl FrameExport {
    /// The frame in view.
    pub(crate) fn of(model: &Model) -> Option<Self> {
        let frame = model.worker.in_view.as_deref()?;
        let shown = Arc::clone(&frame.shown);
        let timeline = model.worker.timeline()?;
        let recent = frame
            .trails
            .range(..=shown.position)
            .map(|(&position, (number, tracks))| FrameTracks {
                number: *number,
                time: timeline.times.get(position as usize).copied().unwrap_or_default(),
                tracks: tracks.as_ref().clone(),
            })
            .collect();
        let here = timeline.events.iter().filter(|(position, _)| *position == shown.position);
        let events = here.map(|(_, event)| event.clone()).collect();
        Some(Self { shown, recent, events })
    }

    /// The proposed file name.
    pub(crate) fn name(&self) -> String {
        format!("frame-{:06}.png", self.shown.frame.number)
    }

    /// The frame with its annotations drawn.
    pub(crate) fn drawn(&self) -> Frame {
        let mut frame = Frame::clone(&self.shown.frame);
        annotate(&mut frame, &FrameAnnotations { recent: &self.recent, events: &self.events });
        frame
    }

    /// Writes the image. Returns the path, or an error in a sentence.
    pub(crate) fn write(&self, path: PathBuf) -> Result<PathBuf, String> {
        let frame = self.drawn();
        atomic_write::write(path, "png", |at| picture::write_frame(at, &frame))
    }
}
