//! The results of a frame.

use std::sync::Arc;

use super::event::{Episode, Event};
use super::state::context::Context;
use super::state::decisions::Decisions;
use super::state::object::Object;
use super::state::object_table::ObjectTable;
use crate::regions::Rect;
use crate::tracking::pool::Blob;
use crate::tracking::seed_finder::UnexplainedDetection;
use crate::tracking::{Identity, ObjectId, Track, TrackState};

/// The box of a partly visible object is extended to its predicted full extent, but not beyond this multiple of its
/// size.
const MAX_EXTENSION: f32 = 1.2;

/// The results of one frame.
#[derive(Clone, Debug, Default)]
pub struct FrameResult {
    /// Confirmed objects, by identity: the online result.
    pub tracks: Vec<Track>,
    /// Tentative objects.
    pub tentative: Vec<Track>,
    /// All objects under their keys.
    pub objects: Vec<Track>,
    /// Events decided in this frame, by frame and kind.
    pub events: Vec<Event>,
    /// Results about earlier frames that were settled in this frame.
    pub settled: SettledResults,
}

/// Results that later frames cannot change; each is returned once.
#[derive(Clone, Debug, Default)]
pub struct SettledResults {
    /// Identities assigned to objects and to the keys of their tracks; a later assignment replaces an earlier one.
    pub identities: Vec<(ObjectId, Identity)>,
    /// Episodes that have ended.
    pub episodes: Vec<Episode>,
    /// Tracks of new objects in the frames before their detection was confirmed by a seed, with those frames'
    /// numbers.
    pub earlier: Vec<(u32, Track)>,
}

/// The results that are settled at the end of a sequence.
#[derive(Clone, Debug, Default)]
pub struct FinalResult {
    /// Events decided after the last frame, by frame and kind.
    pub events: Vec<Event>,
    /// Everything else that was pending until then.
    pub settled: SettledResults,
}

/// The tracks of all objects in this frame, by key.
pub(super) fn object_tracks(context: &Context, table: &ObjectTable, decisions: &Decisions) -> Vec<Track> {
    let mut tracks = Vec::new();
    for tracked in table.blobs() {
        let labels = tracked.detection.as_ref().map(|detection| detection.labels.clone()).unwrap_or_default();
        let group: Vec<ObjectId> = match tracked.only_member() {
            Some(_) => Vec::new(),
            None => table.objects_of(tracked.members()).map(|object| object.key).collect(),
        };
        for &id in tracked.members() {
            let Some(object) = table.get(id) else { continue };
            let (state, bbox, share) = match (&tracked.detection, tracked.is_shared()) {
                (Some(detection), false) => {
                    let bbox = extended_box(context, decisions, object, &detection.bbox);
                    (TrackState::Visible, bbox, object.visible_share(detection.area))
                }
                (Some(_), true) => {
                    (TrackState::Merged, object.predicted_box(), tracked.visible_share_of(object))
                }
                (None, _) if decisions.is_behind_known_occluder(object) => {
                    (TrackState::Hidden, object.predicted_box(), 0.0)
                }
                (None, _) => continue,
            };
            let mut track = track_of(context, object, Some(&tracked.blob), state, bbox, share);
            track.regions.clone_from(&labels);
            track.group.clone_from(&group);
            tracks.push(track);
        }
    }
    for occluded in table.occluded() {
        if let Some(object) = table.get(occluded.id)
            && context.t - occluded.since.t <= context.limits.max_coast_frames
            && decisions.is_behind_known_occluder(object)
        {
            tracks.push(track_of(context, object, None, TrackState::Hidden, object.predicted_box(), 0.0));
        }
    }
    tracks.sort_by_key(|track| track.key);
    tracks
}

/// The track of a new object in a frame before the one that started it.
pub(super) fn track_before_birth(context: &Context, object: &Object, seen: &UnexplainedDetection) -> Track {
    let UnexplainedDetection { observation, labels, .. } = seen;
    Track {
        centre: observation.bbox.centre(),
        regions: labels.clone(),
        ..track_of(context, object, None, TrackState::Visible, observation.bbox, 1.0)
    }
}

/// The box of a lone object: extended to its predicted full extent, if a part of it may be behind a known occluder.
fn extended_box(context: &Context, decisions: &Decisions, object: &Object, seen: &Rect) -> Rect {
    let extended = object.predicted_box().union(seen);
    let (w, h) = object.size();
    let fits = extended.w <= MAX_EXTENSION * w && extended.h <= MAX_EXTENSION * h;
    let hides =
        |occluder: &Rect| occluder.intersection(&extended).area() > occluder.intersection(seen).area();
    let partial = object.partial_frames > 0 && !context.is_cut_off(seen);
    if partial && fits && decisions.occluders().iter().any(hides) { extended } else { *seen }
}

fn track_of(
    context: &Context,
    object: &Object,
    blob: Option<&Blob>,
    state: TrackState,
    bbox: Rect,
    visible_share: f32,
) -> Track {
    let velocity = object.model.velocity();
    let shown = blob.map(Blob::shown);
    let gate = context.matcher.gate;
    Track {
        id: 0,
        key: object.key,
        state,
        bbox,
        centre: object.model.centre(),
        velocity: [velocity.x, velocity.y],
        scale: object.model.scale(),
        gate: object.model.gate_ellipse(gate),
        fitness: shown.map_or(0.0, |shown| shown.fitness.value()),
        hypotheses: blob.map_or_else(Arc::default, |blob| blob.summaries(gate).into()),
        visible_share,
        colours: object.colours(&context.settings),
        regions: Vec::new(),
        group: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occlusion::fixtures::{RED, context, detection, person, start_confirmed, start_group};
    use crate::occlusion::state::context::FrameRef;

    #[test]
    fn a_lone_object_is_visible_members_are_merged_and_a_lost_object_is_left_out() {
        let (mut table, context) = (ObjectTable::default(), context(1));
        let members = start_group(&context, &mut table, person(100.0, 80.0), person(120.0, 80.0));
        let alone = start_confirmed(&context, &mut table, person(200.0, 80.0), RED, [0.0; 2]);
        let lost = start_confirmed(&context, &mut table, person(250.0, 80.0), RED, [0.0; 2]);
        for tracked in table.blobs_mut().filter(|tracked| tracked.members() == [lost]) {
            tracked.detection = None;
        }
        let tracks = object_tracks(&context, &table, &Decisions::default());
        let states: Vec<_> = tracks.iter().map(|track| (track.key, track.state, track.group.len())).collect();
        let merged = members.map(|id| (id, TrackState::Merged, 2));
        assert_eq!(states, [merged[0], merged[1], (alone, TrackState::Visible, 0)]);
    }

    #[test]
    fn an_object_at_a_known_occluder_is_reported_for_a_while() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        table.occlude(id, FrameRef { number: 2, index: 2, t: 2 });
        table.drop_empty_blobs();
        let states = |decisions: &Decisions, t: u32| -> Vec<TrackState> {
            object_tracks(&context(t), &table, decisions).iter().map(|track| track.state).collect()
        };
        assert_eq!(states(&decisions, 4), []);
        decisions.remember_occluder(Rect::new(90.0, 70.0, 60.0, 80.0));
        assert_eq!(states(&decisions, 4), [TrackState::Hidden]);
        assert_eq!(states(&decisions, 3 + context(1).limits.max_coast_frames), []);
    }

    #[test]
    fn the_box_of_a_partly_visible_object_is_extended_behind_a_known_occluder_only() {
        let (mut table, mut decisions, context) = (ObjectTable::default(), Decisions::default(), context(2));
        let id = start_confirmed(&context, &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let upper = Rect::new(100.0, 80.0, 20.0, 40.0);
        if let Some(object) = table.get_mut(id) {
            object.partial_frames = 1;
        }
        for tracked in table.blobs_mut() {
            tracked.detection = Some(detection(upper, RED));
        }
        let bbox =
            |decisions: &Decisions| object_tracks(&context, &table, decisions).first().map(|it| it.bbox);
        assert_eq!(bbox(&decisions), Some(upper));
        decisions.remember_occluder(Rect::new(80.0, 118.0, 60.0, 40.0));
        assert_eq!(bbox(&decisions), Some(person(100.0, 80.0)));
    }

    #[test]
    fn a_box_is_extended_where_the_occluder_hides_more_of_it_and_the_whole_is_not_too_large() {
        let context = context(2);
        let extended = |seen: Rect, partial_frames: u32, occluder: Rect| {
            let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
            let id = start_confirmed(&context, &mut table, person(100.0, 80.0), RED, [0.0; 2]);
            decisions.remember_occluder(occluder);
            let mut object = table.get(id).cloned().unwrap();
            object.partial_frames = partial_frames;
            extended_box(&context, &decisions, &object, &seen)
        };
        let (seen, below) = (Rect::new(100.0, 80.0, 20.0, 40.0), Rect::new(80.0, 118.0, 60.0, 40.0));
        let whole = person(100.0, 80.0);
        assert_eq!(extended(seen, 1, below), whole);
        assert_eq!(extended(seen, 0, below), seen, "it is not partly visible");
        assert_eq!(extended(seen, 1, Rect::new(200.0, 118.0, 60.0, 40.0)), seen, "the occluder is elsewhere");
        assert_eq!(extended(seen, 1, Rect::new(80.0, 70.0, 60.0, 50.0)), seen, "it hides nothing more");
        // The union with the predicted box may be so many times as large in both directions.
        let (w, h) = (20.0 * MAX_EXTENSION, 60.0 * MAX_EXTENSION);
        let wide = |x: f32| Rect::new(100.0, 80.0, x, 40.0);
        assert_eq!(extended(wide(w), 1, below), wide(w).union(&whole));
        assert_eq!(extended(wide(w + 1.0), 1, below), wide(w + 1.0));
        let high = |y: f32| Rect::new(100.0, 140.0 - y, 20.0, y - 20.0);
        assert_eq!(extended(high(h), 1, below), high(h).union(&whole));
        assert_eq!(extended(high(h + 1.0), 1, below), high(h + 1.0));
        let edge = Rect::new(100.0, 0.5, 20.0, 100.0);
        assert_eq!(extended(edge, 1, below), edge, "the image edge cuts it off");
    }
}
