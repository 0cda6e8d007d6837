//! Annotated frames of a camera: the online result, drawn during the analysis.

use super::annotated_output::AnnotatedOutput;
use super::recent_tracks::RecentTracks;
use crate::export::annotate::{FrameAnnotations, annotate};
use crate::frame::Frame;
use crate::occlusion::Event;
use crate::pipeline::Analysis;
use crate::source::SourceInfo;
use crate::tracking::FrameTracks;

/// Draws the online result onto each frame.
pub(super) struct LiveAnnotation<'a> {
    output: &'a mut AnnotatedOutput,
    tracks: RecentTracks,
    events: Vec<Event>,
}

impl<'a> LiveAnnotation<'a> {
    /// `None` if the source is no camera, or no annotated frames are requested.
    pub(super) fn new(info: &SourceInfo, output: &'a mut AnnotatedOutput) -> Option<Self> {
        let is_wanted = info.live && output.is_open();
        is_wanted.then(|| Self { output, tracks: RecentTracks::default(), events: Vec::new() })
    }

    /// Writes the next frame with its results.
    pub(super) fn write(&mut self, frame: &Frame, analysis: &Analysis) -> anyhow::Result<()> {
        self.tracks.forget();
        self.tracks.push(FrameTracks {
            number: analysis.number,
            time: analysis.time,
            tracks: analysis.tracks.to_vec(),
        });
        let tracks = self.tracks.frames();
        self.events.extend(analysis.events.iter().cloned());
        // An event can be decided some frames after it happened.
        self.events.sort_by_key(|event| event.frame);
        let oldest = tracks.first().map_or(0, |frame| frame.number);
        self.events.retain(|event| event.frame >= oldest);
        let mut frame = frame.clone();
        annotate(&mut frame, &FrameAnnotations::at(tracks.len() - 1, tracks, &self.events));
        self.output.write(&[frame])
    }
}
