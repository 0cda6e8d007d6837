//! Re-identification of unseen group members and occluded objects in the regions of others.

use super::existence::shows_one_object;
use super::localisation;
use super::member_localisation::{localisation_input, localisation_inputs};
use crate::occlusion::event::{Event, EventKind, Evidence};
use crate::occlusion::events::demerges::settle_demerges_of;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::{Decisions, PendingReappearance};
use crate::occlusion::state::groups::GroupChange;
use crate::occlusion::state::object_table::{ObjectTable, TrackedBlob};
use crate::settings::Switch;
use crate::tracking::ObjectId;

/// An unseen object is re-identified in a region where at least this share of it is visible.
const MIN_REIDENTIFIED_SHARE: f32 = 0.4;

/// Searches unseen members and occluded objects in the regions near their predicted places.
pub(crate) fn reidentify_unseen_members(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
) {
    let in_groups = table.blobs().iter().filter(|tracked| tracked.is_shared());
    let is_missing = |&id: &ObjectId| table.get(id).is_some_and(|object| object.unseen_frames > 1);
    let mut missing: Vec<ObjectId> =
        in_groups.flat_map(TrackedBlob::members).copied().filter(is_missing).collect();
    missing.extend(table.occluded().iter().map(|occluded| occluded.id));
    for id in missing {
        if let Some((index, centre)) = find_in_groups(context, table, id) {
            add_to_group(context, table, decisions, id, index, centre);
        }
    }
}

/// Re-identifies a confirmed object that lost its own region in the region of others; whether it was.
pub(crate) fn try_reidentify_in_group(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) -> bool {
    if !table.is_confirmed(id) || context.settings.find_again != Switch::On {
        return false;
    }
    let Some((index, centre)) = find_in_groups(context, table, id) else { return false };
    add_to_group(context, table, decisions, id, index, centre);
    true
}

/// The blob and the place in it where an unexplained part matches this object's template.
fn find_in_groups(context: &Context, table: &ObjectTable, id: ObjectId) -> Option<(usize, [f32; 2])> {
    let object = table.get(id)?;
    let reach = object.reappearance_radius(frames_unseen(context, table, id));
    let predicted = object.predicted_box();
    let mut best: Option<(f32, usize, [f32; 2])> = None;
    for (index, tracked) in table.blobs().iter().enumerate() {
        let Some(detection) = &tracked.detection else { continue };
        // The distance first: it excludes most of many regions at little cost.
        if predicted.distance_outside(&detection.bbox) > reach
            || tracked.members().contains(&id)
            || !tracked.members().iter().any(|&member| table.is_confirmed(member))
            || shows_one_object(table, tracked, detection)
        {
            continue;
        }
        let inputs = localisation_inputs(context, table, tracked.members(), detection);
        let Some((_, mut localised, field)) = inputs else { continue };
        let Some(mut last) = localisation_input(object) else { continue };
        last.position_sigma = reach.max(last.position_sigma);
        let Some(start) = localisation::unexplained_centre(&localised, &field) else { continue };
        last.centre = start;
        localised.push(last);
        localisation::localise_last(&mut localised, &field);
        let Some(last) = localised.last() else { continue };
        if last.visible_share >= MIN_REIDENTIFIED_SHARE
            && best.is_none_or(|(most, ..)| last.visible_share > most)
        {
            best = Some((last.visible_share, index, last.centre));
        }
    }
    best.map(|(_, index, centre)| (index, centre))
}

/// For how many frames an object has been occluded, or else not visible in its group's region.
fn frames_unseen(context: &Context, table: &ObjectTable, id: ObjectId) -> u32 {
    match table.occlusion_of(id) {
        Some(occluded) => context.t - occluded.since.t,
        None => table.get(id).map_or(0, |object| object.unseen_frames),
    }
}

fn add_to_group(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
    index: usize,
    centre: [f32; 2],
) {
    let key = table.get(id).map(|object| object.key);
    settle_demerges_of(context, table, decisions, id);
    if table.get(id).map(|object| object.key) != key {
        // Identities were swapped; the other object is searched in the next frame.
        return;
    }
    let mut evidence =
        Evidence::of_branch("object visible in a region that other objects do not fully explain");
    evidence.note("frames without detection", frames_unseen(context, table, id) as f32);
    table.groups_mut().record_joining(id, GroupChange { frame: context.number, at: centre, evidence });
    let occlusion = table.move_to_blob(id, index);
    let Some(object) = table.get_mut(id) else { return };
    let from = object.last_detection.bbox;
    object.set_centre(centre);
    object.unseen_frames = 0;
    object.partial_frames = 0;
    let (Some(occluded), Some(identity)) = (occlusion, table.identity(id)) else { return };
    let mut evidence =
        Evidence::of_branch("occluded object visible in a region that other objects do not fully explain");
    evidence.note("frames occluded", (context.t - occluded.since.t) as f32);
    let event = Event::of_one(context.number, EventKind::Reappear, identity, centre, evidence);
    decisions.reappearances.push(PendingReappearance {
        id,
        since: occluded.since,
        t: context.t,
        event,
        from,
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{
        BLUE, RED, context, person, shared_detection, start_confirmed, start_group,
    };
    use crate::occlusion::state::context::FrameRef;
    use crate::regions::{Rect, Rgb};

    /// Searches for an occluded blue person beside a visible red one, whose region shows these boxes.
    fn search_in(seen: &[(crate::regions::Rect, Rgb)]) -> (ObjectTable, Decisions) {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let blue = start_confirmed(&context(1), &mut table, person(124.0, 80.0), BLUE, [0.0; 2]);
        table.occlude(blue, FrameRef { number: 2, index: 2, t: 2 });
        table.drop_empty_blobs();
        table.blob_mut(0).unwrap().detection = Some(shared_detection(seen));
        reidentify_unseen_members(&context(6), &mut table, &mut decisions);
        assert_eq!(table.check(), None);
        (table, decisions)
    }

    #[test]
    fn an_occluded_object_is_found_in_the_part_of_a_region_that_nothing_explains() {
        let (table, decisions) = search_in(&[(person(100.0, 80.0), RED), (person(120.0, 80.0), BLUE)]);
        assert_eq!(table.blobs()[0].members(), [1, 2]);
        assert!((table.get(2).unwrap().model.centre()[0] - 130.0).abs() < 3.0);
        assert_eq!(decisions.reappearances[0].since.number, 2);
    }

    #[test]
    fn a_region_that_its_object_explains_shows_no_occluded_object() {
        let (table, decisions) = search_in(&[(person(100.0, 80.0), RED)]);
        assert_eq!(table.blobs()[0].members(), [1]);
        assert!(decisions.reappearances.is_empty());
    }

    #[test]
    fn the_evidence_says_for_how_long_an_object_was_occluded() {
        let (table, decisions) = search_in(&[(person(100.0, 80.0), RED), (person(120.0, 80.0), BLUE)]);
        let evidence = &decisions.reappearances[0].event.evidence;
        assert_eq!(evidence.comparisons[0].value, 4.0);
        let cause = table.groups().cause_of_joining(&[2]).unwrap();
        assert_eq!(cause.evidence.comparisons[0].value, 4.0);
    }

    /// Whether a blue person that lost its region is found in one that a red person shares.
    fn is_found(change: impl FnOnce(&mut ObjectTable, &mut Context, [ObjectId; 2])) -> bool {
        let (mut table, mut decisions, mut now) = (ObjectTable::default(), Decisions::default(), context(6));
        let red = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let blue = start_confirmed(&context(1), &mut table, person(124.0, 80.0), BLUE, [0.0; 2]);
        let seen = [(person(100.0, 80.0), RED), (person(120.0, 80.0), BLUE)];
        table.blob_mut(0).unwrap().detection = Some(shared_detection(&seen));
        table.blob_mut(1).unwrap().detection = None;
        change(&mut table, &mut now, [red, blue]);
        let found = try_reidentify_in_group(&now, &mut table, &mut decisions, blue);
        assert_eq!(table.blob_of(blue) == table.blob_of(red), found);
        found
    }

    #[test]
    fn an_object_that_lost_its_region_is_found_in_that_of_a_confirmed_one_within_reach() {
        assert!(is_found(|_, _, _| {}));
        assert!(!is_found(|_, now, _| now.settings.find_again = Switch::Off));
        assert!(!is_found(|table, _, [red, _]| table.get_mut(red).unwrap().confirmed = false));
        assert!(!is_found(|table, _, [_, blue]| table.get_mut(blue).unwrap().set_centre([300.0, 110.0])));
        // A region as large as one of them shows one.
        assert!(!is_found(|table, _, _| {
            let seen = [(person(100.0, 80.0), RED), (Rect::new(120.0, 80.0, 2.0, 60.0), BLUE)];
            table.blob_mut(0).unwrap().detection = Some(shared_detection(&seen));
        }));
    }

    /// An unseen member of one group in the region of another person that it is beside.
    #[test]
    fn a_member_that_was_not_visible_for_two_frames_is_found_in_another_region() {
        for (unseen_frames, found) in [(1, false), (2, true)] {
            let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
            let [red, blue] = start_group(&context(1), &mut table, person(100.0, 80.0), person(124.0, 80.0));
            let other = start_confirmed(&context(1), &mut table, person(144.0, 80.0), RED, [0.0; 2]);
            table.blob_mut(0).unwrap().detection = Some(shared_detection(&[(person(100.0, 80.0), RED)]));
            let seen = [(person(124.0, 80.0), BLUE), (person(144.0, 80.0), RED)];
            table.blob_mut(1).unwrap().detection = Some(shared_detection(&seen));
            table.get_mut(blue).unwrap().unseen_frames = unseen_frames;
            reidentify_unseen_members(&context(6), &mut table, &mut decisions);
            let joined = if found { other } else { red };
            assert_eq!(table.blob_of(blue), table.blob_of(joined), "{unseen_frames}");
            assert!(decisions.reappearances.is_empty(), "it was in a group");
        }
    }
}
