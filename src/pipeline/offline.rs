//! The offline result: later decisions applied to the results of earlier frames.

use std::collections::BTreeMap;

use super::{Analysis, Pipeline};
use crate::occlusion::{Counters, Episode, Event, EventKind, FinalResult, SettledResults};
use crate::tracking::{FrameTracks, IdentityMap, Track};

/// The offline result of a sequence: late decisions applied, short tracks removed.
#[derive(Clone, Debug, Default)]
pub struct OfflineResult {
    /// The confirmed objects of each frame by identity, in order of frames.
    pub tracks: Vec<FrameTracks>,
    /// The events by frame, then by kind.
    pub events: Vec<Event>,
    /// The episodes by start.
    pub episodes: Vec<Episode>,
    /// The events by kind.
    pub counters: Counters,
}

/// What the offline result needs of a frame.
pub(crate) struct TrackedFrame<'a> {
    /// The frame number in the source.
    pub(crate) number: u32,
    /// The frame's time in seconds since the source's first frame.
    pub(crate) time: f64,
    /// All objects by their track keys.
    pub(crate) objects: &'a [Track],
    /// The events decided in this frame.
    pub(crate) events: &'a [Event],
    /// The results about earlier frames that became final in this frame.
    pub(crate) settled: &'a SettledResults,
}

/// The offline result of all `analyses`, in order, after `pipeline` has processed the last of them: identities from
/// each object's first frame on, short tracks removed.
pub fn offline_result<'a>(
    analyses: impl IntoIterator<Item = &'a Analysis>,
    pipeline: &Pipeline,
) -> OfflineResult {
    let last = pipeline.decide_pending();
    let frames = analyses.into_iter().map(|analysis| TrackedFrame {
        number: analysis.number,
        time: analysis.time,
        objects: &analysis.objects,
        events: &analysis.events,
        settled: &analysis.settled,
    });
    offline_result_of(&frames.collect::<Vec<_>>(), &last)
}

/// The offline result of all `frames`, in order, and of what the tracker decided after the last.
pub(crate) fn offline_result_of(frames: &[TrackedFrame<'_>], last: &FinalResult) -> OfflineResult {
    let mut decisions = LateDecisions::default();
    for frame in frames {
        decisions.add(frame.settled, frame.events);
    }
    decisions.finish(last);
    let tracks =
        frames.iter().map(|frame| decisions.tracks_of(frame.number, frame.time, frame.objects)).collect();
    let LateDecisions { events, episodes, counters, .. } = decisions;
    OfflineResult { tracks, events, episodes, counters }
}

/// What is decided about earlier frames, collected over a sequence. The objects of the frames are not held.
#[derive(Debug, Default)]
pub(crate) struct LateDecisions {
    identity_map: IdentityMap,
    /// Tracks of objects in frames before they were followed, by frame number.
    earlier: BTreeMap<u32, Vec<Track>>,
    /// The events; by frame, then by kind, once the sequence has ended.
    pub(crate) events: Vec<Event>,
    /// The episodes; by start, once the sequence has ended.
    pub(crate) episodes: Vec<Episode>,
    /// The events by kind, once the sequence has ended.
    pub(crate) counters: Counters,
}

impl LateDecisions {
    /// Adds the decisions and events of the next frame.
    pub(crate) fn add(&mut self, settled: &SettledResults, events: &[Event]) {
        for &(key, identity) in &settled.identities {
            self.identity_map.set(key, identity);
        }
        self.episodes.extend(settled.episodes.iter().cloned());
        for (number, track) in &settled.earlier {
            self.earlier.entry(*number).or_default().push(track.clone());
        }
        self.events.extend(events.iter().cloned());
    }

    /// Adds what the tracker decided after the last frame, and sorts all events and episodes.
    pub(crate) fn finish(&mut self, last: &FinalResult) {
        self.add(&last.settled, &last.events);
        self.episodes.sort_by(|a, b| (a.start, &a.objects).cmp(&(b.start, &b.objects)));
        self.events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
        for event in &mut self.events {
            self.counters.count(event.kind);
            if event.kind == EventKind::Merge {
                // The object in front is known while they are merged, after the event.
                event.front = self
                    .episodes
                    .iter()
                    .filter(|episode| (episode.start..=episode.end).contains(&event.frame))
                    .find(|episode| event.objects.iter().all(|id| episode.objects.contains(id)))
                    .and_then(|episode| episode.front)
                    .filter(|front| event.objects.contains(front));
            }
        }
    }

    /// The confirmed objects of a frame by identity, from all its `objects` by their track keys.
    pub(crate) fn tracks_of(&self, number: u32, time: f64, objects: &[Track]) -> FrameTracks {
        let identity = |track: &Track| self.identity_map.of(track.key);
        let earlier = self.earlier.get(&number).map_or(&[][..], Vec::as_slice);
        // An object tracked in this frame has no earlier track here.
        let earlier =
            earlier.iter().filter(|track| !objects.iter().any(|object| identity(object) == identity(track)));
        FrameTracks { number, time, tracks: self.identity_map.apply(earlier.chain(objects)) }
    }
}
