//! Builds the timeline of the sequence incrementally.

use std::collections::BTreeMap;

use crate::occlusion::Event;
use crate::pipeline::{Analysis, OfflineResult};
use crate::replay::{Timeline, TrackTimeline};
use crate::source::cache::FrameCache;
use crate::tracking::{Identity, Track, TrackState};

/// A [`Timeline`] in progress.
#[derive(Clone, Default)]
pub(crate) struct TimelineBuilder {
    foreground_share: Vec<f32>,
    events: Vec<Event>,
    track_spans: TrackSpans,
}

type TrackSpans = BTreeMap<Identity, Vec<(u32, u32, TrackState)>>;

impl TimelineBuilder {
    /// Adds the analysis of the next position.
    pub(crate) fn push(&mut self, analysis: &Analysis, foreground_share: f32) {
        extend_spans(&mut self.track_spans, self.foreground_share.len() as u32, &analysis.tracks);
        self.foreground_share.push(foreground_share);
        self.events.extend(analysis.events.iter().cloned());
    }

    /// Replaces the online results by the offline result.
    pub(crate) fn finish(&mut self, result: OfflineResult) {
        self.track_spans.clear();
        for (position, frame) in (0..).zip(&result.tracks) {
            extend_spans(&mut self.track_spans, position, &frame.tracks);
        }
        self.events = result.events;
    }

    /// The current timeline of the frames of `source`.
    pub(crate) fn timeline(&self, source: &FrameCache) -> Timeline {
        let numbers = source.numbers();
        let position = |frame: u32| numbers.partition_point(|&number| number < frame) as u32;
        let mut events: Vec<_> =
            self.events.iter().map(|event| (position(event.frame), event.clone())).collect();
        events.sort_by_key(|(position, event)| (*position, event.kind));
        Timeline {
            numbers: numbers.to_vec(),
            times: source.times().to_vec(),
            complete: source.is_complete(),
            analysed: self.foreground_share.len() as u32,
            decoded: Vec::new(),
            alignments: Vec::new(),
            foreground_share: self.foreground_share.clone(),
            events,
            track_timelines: self
                .track_spans
                .iter()
                .map(|(&id, spans)| TrackTimeline { id, spans: spans.clone() })
                .collect(),
            score: None,
        }
    }
}

fn extend_spans(track_spans: &mut TrackSpans, position: u32, tracks: &[Track]) {
    for track in tracks {
        let spans = track_spans.entry(track.id).or_default();
        match spans.last_mut() {
            Some((_, last, state)) if *state == track.state && *last + 1 == position => *last = position,
            _ => spans.push((position, position, track.state)),
        }
    }
}
