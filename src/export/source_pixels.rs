//! Results in the pixels of the source, where its images were cropped or scaled for the analysis.
//!
//! A region's area and moments are those of its pixels enlarged to their size in the source. Numbers in the evidence
//! of an event stay as they were compared.

use super::regions_csv::FrameRows;
use crate::occlusion::Event;
use crate::placement::Placement;
use crate::tracking::{FrameTracks, HypothesisSummary, Track};

/// Moves tracks from the pixels of the frames to those of the source; velocities are in the latter per frame.
pub fn move_tracks(frames: &mut [FrameTracks], placement: &Placement) {
    for track in frames.iter_mut().flat_map(|frame| &mut frame.tracks) {
        *track = track_in_source(track, placement);
    }
}

/// A track in the pixels of the source. Lengths without a direction are enlarged by the mean factor of both.
pub fn track_in_source(track: &Track, placement: &Placement) -> Track {
    let [width, height] = placement.pixel_size();
    let mean = (width * height).sqrt();
    let enlarged = |length: f32, factor: f64| (f64::from(length) * factor) as f32;
    let gate = |[major, minor, angle]: [f32; 3]| [enlarged(major, mean), enlarged(minor, mean), angle];
    let hypothesis = |hypothesis: &HypothesisSummary| HypothesisSummary {
        centre: placement.source_point(hypothesis.centre),
        gate: gate(hypothesis.gate),
        ..*hypothesis
    };
    Track {
        bbox: placement.source_rect(&track.bbox),
        centre: placement.source_point(track.centre),
        velocity: [enlarged(track.velocity[0], width), enlarged(track.velocity[1], height)],
        scale: enlarged(track.scale, mean),
        gate: gate(track.gate),
        hypotheses: track.hypotheses.iter().map(hypothesis).collect(),
        ..track.clone()
    }
}

/// Moves regions from the pixels of the frames to those of the source.
pub fn move_regions(frames: &mut [FrameRows], placement: &Placement) {
    for row in frames.iter_mut().flat_map(|frame| &mut frame.rows) {
        row.move_to_source(placement);
    }
}

/// Moves events from the pixels of the frames to those of the source.
pub fn move_events(events: &mut [Event], placement: &Placement) {
    for event in events {
        [event.x, event.y] = placement.source_point([event.x, event.y]);
    }
}
