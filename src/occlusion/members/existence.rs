//! Existence of group members: how long a member that is not visible is believed to be in its group's region.

use crate::occlusion::event::Evidence;
use crate::occlusion::events::demerges::settle_demerges_of;
use crate::occlusion::events::emission::{can_leave, emit_exit, mark_occluded};
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::{ObjectTable, TrackedBlob};
use crate::tracking::ObjectId;

/// Upper limit of the log odds of existence.
const MAX_EXISTENCE_NATS: f32 = 4.0;
/// Gain of log odds a second while visible.
const EXISTENCE_GAIN_NATS_PER_SECOND: f32 = 20.0;
/// Loss of log odds a second while unseen inside the group's region, where others can hide it.
const COVERED_LOSS_NATS_PER_SECOND: f32 = 3.0;
/// Loss of log odds a second while unseen outside the group's region.
const UNCOVERED_LOSS_NATS_PER_SECOND: f32 = 12.0;
/// A group's region of more pixels than this multiple of all its members together indicates wrong sizes. A third
/// object that joined two like it unseen makes 1.5. Tried: 1.7 and 2, with the same result on people and fish.
const MAX_AREA_RATIO: f32 = 1.7;
/// A region of fewer pixels than this multiple of its largest member shows one object only.
const MAX_SINGLE_AREA_RATIO: f32 = 1.15;

/// Updates the existence of each group member by its visibility. A member below even odds leaves the group and
/// becomes occluded, or exits.
pub(crate) fn update_member_existence(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    for id in update_log_odds(context, table) {
        let key = table.get(id).map(|object| object.key);
        settle_demerges_of(context, table, decisions, id);
        if table.get(id).map(|object| object.key) != key {
            // Identities were swapped; the other object is handled in the next frame.
            continue;
        }
        if !can_leave(context, table, id) {
            continue;
        }
        decisions.group_episodes.mark_member_lost(id);
        let Some(bbox) = table.get(id).map(Object::predicted_box) else { continue };
        if context.is_near_border(&bbox) {
            let mut evidence = Evidence::of_branch("not visible in its group's region, at the image edge");
            let distance = bbox.distance_to_edge(context.size);
            evidence.at_most("distance to image edge, pixels", distance, context.limits.border_px);
            emit_exit(context, table, decisions, id, context.number, evidence);
        } else {
            mark_occluded(context, table, decisions, id, context.now());
        }
    }
}

/// Updates the log odds of existence of each object with a region. Gives the members that are below even odds; the
/// most visible one of a group stays.
fn update_log_odds(context: &Context, table: &mut ObjectTable) -> Vec<ObjectId> {
    let mut leaving = Vec::new();
    for index in 0..table.blobs().len() {
        let Some(tracked) = table.blob(index) else { break };
        let Some(detection) = &tracked.detection else { continue };
        let only = tracked.only_member();
        let shows_one = only.is_some() || shows_one_object(table, tracked, detection);
        let best = most_visible_member(table, tracked, detection);
        let region = detection.bbox;
        let members = tracked.members().to_vec();
        let mut left = members.len();
        for id in members {
            let Some(object) = table.get_mut(id) else { continue };
            let seen = if shows_one { Some(id) == best } else { object.unseen_frames == 0 };
            let covered = object.predicted_box().share_within(&region) >= 0.5;
            let rate = match (seen, covered) {
                (true, _) => EXISTENCE_GAIN_NATS_PER_SECOND,
                (false, true) => -COVERED_LOSS_NATS_PER_SECOND,
                (false, false) => -UNCOVERED_LOSS_NATS_PER_SECOND,
            };
            object.existence = (object.existence + rate / context.limits.fps).min(MAX_EXISTENCE_NATS);
            if object.existence < 0.0 && left > 1 && Some(id) != best {
                left -= 1;
                leaving.push(id);
            }
        }
    }
    leaving
}

/// The member with the greatest visible share at the last localisation; on a tie the one with more of its colours in
/// the region, then the older one.
fn most_visible_member(
    table: &ObjectTable,
    tracked: &TrackedBlob,
    detection: &Detection,
) -> Option<ObjectId> {
    let share = |&id: &ObjectId| table.get(id).map_or(0.0, |object| object.visible_share_in_group);
    let colours = |&id: &ObjectId| table.get(id).map_or(1.0, |object| object.visible_share_in(detection));
    let best = tracked.members().iter().max_by(|a, b| {
        share(a).total_cmp(&share(b)).then_with(|| colours(a).total_cmp(&colours(b))).then(b.cmp(a))
    });
    best.copied()
}

/// Whether a region is too small to show more than one of its members.
pub(super) fn shows_one_object(table: &ObjectTable, tracked: &TrackedBlob, detection: &Detection) -> bool {
    let largest = table.objects_of(tracked.members()).map(Object::area).fold(0.0, f32::max);
    detection.area < MAX_SINGLE_AREA_RATIO * largest
}

/// Corrects sizes learnt from fragments: where a group's region stays far larger than all its members, the largest
/// member gets the whole region as its size. The others then leave, as the region has room for one only.
pub(crate) fn correct_member_sizes(context: &Context, table: &mut ObjectTable) {
    let (blobs, objects) = table.blobs_and_objects();
    for tracked in blobs {
        let area = |id: &ObjectId| objects.get(*id).map_or(0.0, Object::area);
        let Some(detection) = tracked.detection.as_ref().filter(|_| tracked.is_shared()) else { continue };
        let oversized = detection.area > MAX_AREA_RATIO * tracked.members().iter().map(area).sum::<f32>();
        let largest = tracked.members().iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(b.cmp(a)));
        let largest = largest.copied();
        let frames = if oversized { tracked.oversized + 1 } else { 0 };
        if frames >= context.limits.head_count_frames
            && let Some(object) = largest.and_then(|id| objects.get_mut(id))
        {
            object.last_detection = detection.clone();
            object.reset_appearance();
        }
        tracked.oversized = frames;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::event::EventKind;
    use crate::occlusion::fixtures::{context, person, start_group};

    /// A group of which the second member was not visible in the last frame, with these log odds of existence.
    fn group_with_unseen(existence: f32) -> (ObjectTable, [ObjectId; 2]) {
        let mut table = ObjectTable::default();
        let members = start_group(&context(1), &mut table, person(100.0, 80.0), person(120.0, 80.0));
        let object = table.get_mut(members[1]).unwrap();
        (object.unseen_frames, object.visible_share_in_group, object.existence) = (1, 0.0, existence);
        (table, members)
    }

    #[test]
    fn an_unseen_member_below_even_odds_is_occluded_with_an_event() {
        // The loss in one frame is 3 nats a second over 25 frames a second.
        let (mut table, [_, unseen]) = group_with_unseen(0.11);
        let mut decisions = Decisions::default();
        update_member_existence(&context(2), &mut table, &mut decisions);
        assert!(table.occlusion_of(unseen).is_some());
        let kinds: Vec<EventKind> = decisions.events.iter().map(|event| event.kind).collect();
        assert_eq!(kinds, [EventKind::Disappear]);
        assert_eq!(table.check(), None);
    }

    #[test]
    fn an_unseen_member_above_even_odds_stays() {
        let (mut table, members) = group_with_unseen(0.13);
        update_member_existence(&context(2), &mut table, &mut Decisions::default());
        assert_eq!(table.blobs()[0].members(), members);
        assert!(table.get(members[0]).unwrap().existence > 0.5, "the visible one gains");
    }

    #[test]
    fn the_size_of_a_group_that_stays_too_large_is_given_to_its_largest_member() {
        let (mut table, [first, _]) = group_with_unseen(4.0);
        let context = context(2);
        let whole = crate::occlusion::fixtures::detection(
            crate::regions::Rect::new(80.0, 80.0, 80.0, 60.0),
            crate::occlusion::fixtures::RED,
        );
        table.blob_mut(0).unwrap().detection = Some(whole.clone());
        for _ in 1..context.limits.head_count_frames {
            correct_member_sizes(&context, &mut table);
        }
        assert_eq!(table.get(first).unwrap().size().0, 20.0, "not yet");
        correct_member_sizes(&context, &mut table);
        assert_eq!(table.get(first).unwrap().size().0, whole.bbox.w);
    }

    #[test]
    fn a_region_hardly_larger_than_one_member_shows_one() {
        let (table, _) = group_with_unseen(4.0);
        let tracked = &table.blobs()[0];
        let shows = |area: f32| {
            let detection = Detection { area, ..tracked.detection.clone().unwrap() };
            shows_one_object(&table, tracked, &detection)
        };
        assert!(shows(1379.0) && !shows(1381.0), "1.15 of 1200 pixels");
    }

    #[test]
    fn in_a_region_that_shows_one_object_only_the_most_visible_member_gains() {
        let (mut table, [first, second]) = group_with_unseen(1.0);
        table.get_mut(second).unwrap().unseen_frames = 0;
        table.get_mut(first).unwrap().existence = 1.0;
        let small =
            crate::occlusion::fixtures::detection(person(100.0, 80.0), crate::occlusion::fixtures::RED);
        table.blob_mut(0).unwrap().detection = Some(small);
        assert!(update_log_odds(&context(2), &mut table).is_empty());
        let existence = |id: ObjectId| table.get(id).unwrap().existence;
        assert!((existence(first) - 1.8).abs() < 1e-5, "20 nats a second: {}", existence(first));
        assert!(
            (existence(second) - (1.0 - 0.48)).abs() < 1e-5,
            "12 outside the region: {}",
            existence(second)
        );
    }
}
