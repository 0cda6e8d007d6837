//! What is known of the whole sequence, as it grows.

use std::collections::BTreeMap;

use super::{LifeLine, Timeline};
use crate::occlusion::Event;
use crate::pipeline::{Analysis, OfflineResult};
use crate::tracking::{Identity, Track, TrackState};

/// A [`Timeline`] under way.
#[derive(Clone, Default)]
pub(super) struct Growing {
    foreground_share: Vec<f32>,
    events: Vec<Event>,
    lives: Lives,
}

type Lives = BTreeMap<Identity, Vec<(u32, u32, TrackState)>>;

impl Growing {
    /// Takes in the analysis of the next position.
    pub(super) fn push(&mut self, analysis: &Analysis, foreground_share: f32) {
        live_on(&mut self.lives, self.foreground_share.len() as u32, &analysis.tracks);
        self.foreground_share.push(foreground_share);
        self.events.extend(analysis.events.iter().cloned());
    }

    /// Puts the final reading in the place of what was known frame by frame.
    pub(super) fn finish(&mut self, reading: OfflineResult) {
        self.lives.clear();
        for (position, (_, tracks)) in (0..).zip(&reading.tracks) {
            live_on(&mut self.lives, position, tracks);
        }
        self.events = reading.events;
    }

    /// What is known now; `numbers` are the frame numbers of the positions, which rise.
    pub(super) fn timeline(&self, numbers: &[u32], complete: bool) -> Timeline {
        let position = |frame: u32| numbers.partition_point(|&number| number < frame) as u32;
        let mut events: Vec<_> =
            self.events.iter().map(|event| (position(event.frame), event.clone())).collect();
        events.sort_by_key(|(position, event)| (*position, event.kind));
        Timeline {
            numbers: numbers.to_vec(),
            complete,
            analysed: self.foreground_share.len() as u32,
            decoded: Vec::new(),
            alignments: Vec::new(),
            foreground_share: self.foreground_share.clone(),
            events,
            life_lines: self.lives.iter().map(|(&id, spans)| LifeLine { id, spans: spans.clone() }).collect(),
            score: None,
        }
    }
}

fn live_on(lives: &mut Lives, position: u32, tracks: &[Track]) {
    for track in tracks {
        let spans = lives.entry(track.id).or_default();
        match spans.last_mut() {
            Some((_, last, state)) if *state == track.state && *last + 1 == position => *last = position,
            _ => spans.push((position, position, track.state)),
        }
    }
}
