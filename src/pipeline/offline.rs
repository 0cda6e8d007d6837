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
    // Pending decisions at the last frame are made in a copy, because the pipeline may continue.
    let last = pipeline.tracker.clone().finish();
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
    let mut identity_map = IdentityMap::default();
    let mut result = OfflineResult::default();
    let mut earlier: BTreeMap<u32, Vec<&Track>> = BTreeMap::new();
    for settled in frames.iter().map(|frame| frame.settled).chain([&last.settled]) {
        for &(key, identity) in &settled.identities {
            identity_map.set(key, identity);
        }
        result.episodes.extend(settled.episodes.iter().cloned());
        for (number, track) in &settled.earlier {
            earlier.entry(*number).or_default().push(track);
        }
    }
    result.episodes.sort_by(|a, b| (a.start, &a.objects).cmp(&(b.start, &b.objects)));
    for frame in frames {
        let mut before = earlier.remove(&frame.number).unwrap_or_default();
        // An object tracked in this frame has no earlier track here.
        before.retain(|track| {
            let same = |followed: &Track| identity_map.of(followed.key) == identity_map.of(track.key);
            !frame.objects.iter().any(same)
        });
        let objects = before.into_iter().chain(frame.objects.iter());
        let tracks = identity_map.apply(objects);
        result.tracks.push(FrameTracks { number: frame.number, time: frame.time, tracks });
        result.events.extend(frame.events.iter().cloned());
    }
    result.events.extend(last.events.iter().cloned());
    result.events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
    for event in &mut result.events {
        result.counters.count(event.kind);
        if event.kind == EventKind::Merge {
            // The object in front is known while they are merged, after the event.
            event.front = result
                .episodes
                .iter()
                .filter(|episode| (episode.start..=episode.end).contains(&event.frame))
                .find(|episode| event.objects.iter().all(|id| episode.objects.contains(id)))
                .and_then(|episode| episode.front)
                .filter(|front| event.objects.contains(front));
        }
    }
    result
}
