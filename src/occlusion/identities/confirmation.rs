//! Confirmation of tentative objects: re-identified, joined to another one as its fragment, or new.

use super::coherence::{FragmentVerdict, fragment_verdict};
use super::occluded::{needs_clearer_view, try_match_reappearance};
use super::split_member::try_match_split_member;
use crate::occlusion::event::{Comparison, Event, EventKind, Evidence};
use crate::occlusion::events::emission::emit_event;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::ObjectTable;
use crate::regions::Rect;
use crate::tracking::{Identity, ObjectId};

/// The evidence of a new object lists at most this many occluded objects that it was not matched to.
const MAX_REJECTED_MATCHES: usize = 3;

/// Confirms objects that were detected in enough frames, and emits their first events.
pub(crate) fn confirm_objects(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    absorb_fragments(table);
    let due: Vec<ObjectId> =
        table.iter().filter(|(_, object)| is_due(context, object)).map(|(id, _)| id).collect();
    for id in due {
        // An earlier iteration may have ended or confirmed it.
        let open = table.get(id).is_some_and(|object| !object.confirmed);
        if !open || needs_clearer_view(context, table, id) {
            continue;
        }
        match fragment_verdict(context, table, id) {
            Some(FragmentVerdict::Undecided) => {}
            Some(FragmentVerdict::Of { whole, detection, evidence }) => {
                join_fragment(context, table, decisions, id, whole, detection, evidence);
            }
            None if table.get(id).is_some_and(Object::has_moved) => {
                confirm_object(context, table, decisions, id);
            }
            // A re-identified object may stand still.
            None => {
                try_reidentify(context, table, decisions, id);
            }
        }
    }
}

/// Whether a tentative object was detected in enough frames.
fn is_due(context: &Context, object: &Object) -> bool {
    !object.confirmed
        && object.seen_frames >= context.limits.min_track_frames
        // At the image edge the first visible part is often a foot or an arm, with another one beside it.
        && (object.seen_frames >= context.limits.edge_wait_frames
            || !context.is_cut_off(&object.last_detection.bbox))
}

/// Ends tentative objects within the full extent of a partly visible object: they are fragments of it.
fn absorb_fragments(table: &mut ObjectTable) {
    let extents: Vec<Rect> = table
        .lone_objects()
        .filter(|(_, object, _)| object.confirmed && object.partial_frames > 0)
        .map(|(_, object, _)| object.predicted_box())
        .collect();
    let is_fragment = |object: &Object, detection: &Detection| {
        !object.confirmed && extents.iter().any(|extent| detection.bbox.share_within(extent) >= 0.5)
    };
    let fragments: Vec<ObjectId> = table
        .lone_objects()
        .filter(|(_, object, tracked)| tracked.detection.as_ref().is_some_and(|it| is_fragment(object, it)))
        .map(|(id, ..)| id)
        .collect();
    for id in fragments {
        table.end_object(id);
    }
    table.drop_empty_blobs();
}

/// Matches a tentative object to an occluded object or to an unseen group member; on success it continues as that one.
/// One that was first detected near the image edge enters, and is matched to none. Whether it was matched.
fn try_reidentify(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) -> bool {
    let Some(new) = table.get(id) else { return false };
    if context.is_near_border(&new.first_bbox) {
        return false;
    }
    let known = try_match_reappearance(context, table, decisions, id)
        || try_match_split_member(context, table, decisions, id);
    if known {
        absorb_fragments(table);
    }
    known
}

/// Assigns an identity to an object, a known one where it can be re-identified; otherwise emits its first event.
pub(crate) fn confirm_object(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) {
    if try_reidentify(context, table, decisions, id) {
        return;
    }
    let Some(identity) = table.confirm(id) else { return };
    let Some(object) = table.get_mut(id) else { return };
    let (born, birthplace) = (object.first_frame.number, object.first_bbox);
    let fragments = std::mem::take(&mut object.fragments);
    let mut evidence = birth_evidence(context, table, &birthplace);
    evidence.comparisons.extend(fragments);
    let kind = if context.is_near_border(&birthplace) { EventKind::Enter } else { EventKind::Appear };
    let event = Event::of_one(born, kind, identity, birthplace.centre(), evidence);
    emit_event(context, table, decisions, &[id], event);
}

/// The evidence of a new object: where it was first detected, and away from the image edge which occluded objects it
/// was not matched to.
fn birth_evidence(context: &Context, table: &ObjectTable, birthplace: &Rect) -> Evidence {
    let distance = birthplace.distance_to_edge(context.size);
    if context.is_near_border(birthplace) {
        let mut evidence = Evidence::of_branch("new object, first detected near the image edge");
        evidence.at_most("distance to image edge, pixels", distance, context.limits.border_px);
        return evidence;
    }
    let mut evidence = Evidence::of_branch(
        "new object away from the image edge; no occluded object matches and no group shrank",
    );
    evidence.at_least("distance to image edge, pixels", distance, context.limits.border_px);
    evidence.comparisons.extend(rejected_matches(context, table, birthplace));
    evidence
}

/// The occluded objects that a new one was not matched to, the nearest first: distance and radius of each.
fn rejected_matches(context: &Context, table: &ObjectTable, birthplace: &Rect) -> Vec<Comparison> {
    let mut rejected: Vec<(f32, f32, Identity)> = table
        .occluded()
        .iter()
        .filter_map(|occluded| {
            let past = table.get(occluded.id)?;
            let distance = past.predicted_box().distance_outside(birthplace);
            let reach = past.reappearance_radius(context.t - occluded.since.t);
            Some((distance, reach, table.identity(occluded.id)?))
        })
        .collect();
    rejected.sort_by(|a, b| a.0.total_cmp(&b.0));
    rejected.truncate(MAX_REJECTED_MATCHES);
    let comparison = |(distance, reach, identity): (f32, f32, Identity)| {
        let what = format!("distance to predicted position of occluded {identity}, pixels");
        Comparison::at_least(what, distance, reach).of_alternative(false)
    };
    rejected.into_iter().map(comparison).collect()
}

/// Ends an object as a fragment of `whole`, updates that one with the joined detection, and confirms it.
fn join_fragment(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
    whole: ObjectId,
    detection: Detection,
    evidence: [Comparison; 2],
) {
    let Some(ended) = table.end_object(id) else { return };
    table.drop_empty_blobs();
    let Some(tracked) = table.blobs_mut().find(|tracked| tracked.only_member() == Some(whole)) else {
        return;
    };
    let measured = detection.observation();
    tracked.blob.keep_shown(&measured, |model| model.restart_at(&measured.measurement()));
    tracked.detection = Some(detection.clone());
    let model = tracked.blob.shown().model.clone();
    let Some(object) = table.get_mut(whole) else { return };
    object.set_model(&model);
    object.first_bbox = object.first_bbox.union(&ended.first_bbox);
    object.last_detection = detection;
    object.fragments.extend(evidence);
    object.reset_appearance();
    let (confirmed, key) = (object.confirmed, object.key);
    if !confirmed {
        confirm_object(context, table, decisions, whole);
    }
    // Before this frame, too, both keys belong to one object.
    table.link_ended_key(ended.key, key);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::occlusion::fixtures::{RED, context, detection, person, start_confirmed, start_tentative};
    use crate::occlusion::state::context::FrameRef;

    /// A tentative object that moved from `from` to `to` and was detected in so many frames; the kinds of events.
    fn confirm(from: Rect, to: Rect, seen_frames: u32) -> Vec<EventKind> {
        let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(9));
        let id = start_tentative(&context(1), &mut table, from, RED, [0.0; 2]);
        let object = table.get_mut(id).unwrap();
        object.last_detection = detection(to, RED);
        object.seen_frames = seen_frames;
        confirm_objects(&now, &mut table, &mut decisions);
        assert_eq!(table.is_confirmed(id), !decisions.events.is_empty());
        assert_eq!(table.check(), None);
        decisions.events.iter().map(|event| event.kind).collect()
    }

    #[test]
    fn an_object_is_confirmed_after_five_frames_once_it_has_moved() {
        let (here, there) = (person(100.0, 80.0), person(130.0, 80.0));
        assert_eq!(confirm(here, there, 5), [EventKind::Appear]);
        assert_eq!(confirm(here, there, 4), []);
        assert_eq!(confirm(here, here, 5), [], "a ghost stands still");
    }

    #[test]
    fn an_object_that_was_first_detected_near_the_image_edge_enters() {
        assert_eq!(confirm(person(4.0, 80.0), person(40.0, 80.0), 5), [EventKind::Enter]);
        assert_eq!(confirm(person(6.0, 80.0), person(40.0, 80.0), 5), [EventKind::Appear]);
    }

    #[test]
    fn an_object_that_was_first_detected_near_the_image_edge_is_not_the_occluded_one_there() {
        let reidentify = |x: f32| {
            let (mut table, now) = (ObjectTable::default(), context(10));
            let known = start_confirmed(&context(1), &mut table, person(8.0, 80.0), RED, [0.0; 2]);
            table.occlude(known, FrameRef { number: 2, index: 2, t: 2 });
            table.drop_empty_blobs();
            let new = start_tentative(&now, &mut table, person(x, 80.0), RED, [0.0; 2]);
            try_reidentify(&now, &mut table, &mut Decisions::default(), new)
        };
        assert_eq!([2.0, 6.0].map(reidentify), [false, true]);
    }

    #[test]
    fn a_tentative_object_inside_a_partly_visible_one_is_a_fragment_of_it() {
        let (mut table, now) = (ObjectTable::default(), context(3));
        let whole = start_confirmed(&now, &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        table.get_mut(whole).unwrap().partial_frames = 2;
        let foot = start_tentative(&now, &mut table, Rect::new(104.0, 130.0, 8.0, 10.0), RED, [0.0; 2]);
        let beside = start_tentative(&now, &mut table, person(140.0, 80.0), RED, [0.0; 2]);
        confirm_objects(&now, &mut table, &mut Decisions::default());
        assert_eq!([whole, foot, beside].map(|id| table.contains(id)), [true, false, true]);
    }

    #[test]
    fn two_fragments_that_move_alike_are_confirmed_as_one() {
        let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(11));
        for y in [80.0, 112.0] {
            let id = start_tentative(&context(1), &mut table, Rect::new(100.0, y, 20.0, 28.0), RED, [0.0; 2]);
            let moved = detection(Rect::new(130.0, y, 20.0, 28.0), RED);
            table.blobs_mut().last().unwrap().detection = Some(moved.clone());
            let object = table.get_mut(id).unwrap();
            (object.last_detection, object.seen_frames) = (moved, 10);
        }
        confirm_objects(&now, &mut table, &mut decisions);
        let (id, object, _) = table.lone_objects().next().unwrap();
        assert_eq!((table.iter().count(), object.last_detection.bbox), (1, person(130.0, 80.0)));
        assert_eq!(decisions.events.len(), 1);
        let ended = if id == 1 { 2 } else { 1 };
        assert_eq!(table.identity_map().of(ended), table.identity(id), "earlier tracks of both are its own");
    }
}
