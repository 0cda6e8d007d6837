//! Occluded objects: their end, and their re-identification as a new object (Algorithm 3).

use std::cell::LazyCell;

use crate::occlusion::event::{Event, EventKind, Evidence};
use crate::occlusion::events::emission::emit_reappearance;
use crate::occlusion::state::comparable_colours::ComparableColours;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::{Decisions, PendingReappearance};
use crate::occlusion::state::object::Object;
use crate::occlusion::state::object_table::{ObjectTable, OccludedObject};
use crate::regions::Rect;
use crate::settings::ReappearBy;
use crate::tracking::ObjectId;

/// Least colour similarity of an occluded object and a new one away from the predicted place. In rendered scenes it
/// is up to .95 and more for the same person, and at most .7 for others.
const MIN_COLOUR_SIMILARITY: f32 = 0.8;
/// Number of intervals between the last and the predicted place at whose ends an occluded object may have stopped.
const STOP_POSITIONS: u8 = 8;

/// The place of a new object relative to where an occluded one may reappear.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ReappearancePlace {
    /// Distance from there in pixels, and the largest allowed distance.
    distance: f32,
    reach: f32,
    /// Whether it is at the predicted place, or else between the last place and that.
    predicted: bool,
    /// Whether it is near enough to the predicted place to need no clearer view.
    near: bool,
}

impl ReappearancePlace {
    /// Distance over the largest allowed one.
    fn share(&self) -> f32 {
        self.distance / self.reach
    }
}

/// Ends objects that have been occluded for too long, and emits the reappearances of those that stayed visible.
pub(crate) fn update_occluded(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    let has_ended = |occluded: &OccludedObject| {
        // By position alone no object reappears from outside the image.
        let lost = |object: &Object| {
            context.settings.reappear_by == ReappearBy::Position
                && context.is_outside(&object.predicted_box())
        };
        table.get(occluded.id).is_none_or(lost)
            || context.t - occluded.since.t > context.limits.max_hidden_frames
    };
    let ended: Vec<ObjectId> =
        table.occluded().iter().filter(|occluded| has_ended(occluded)).map(|occluded| occluded.id).collect();
    for id in ended {
        table.end_object(id);
    }
    let stayed: Vec<ObjectId> = decisions
        .reappearances
        .iter()
        .filter(|pending| context.t - pending.t > context.limits.same_episode_frames)
        .map(|pending| pending.id)
        .collect();
    for id in stayed {
        emit_reappearance(context, table, decisions, id);
    }
}

/// Matches a new object to an occluded one; on success that one continues in its place. Whether it was matched.
pub(super) fn try_match_reappearance(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) -> bool {
    let Some(new) = table.get(id) else { return false };
    let settings = &context.settings;
    let colours = LazyCell::new(|| ComparableColours::new(&new.last_detection.histogram, settings));
    let candidate = |occluded: &OccludedObject| {
        let past = table.get(occluded.id).filter(|past| new.may_match(past))?;
        let place = reappearance_place(context, past, occluded, &new.last_detection.bbox)?;
        let (similarity, _) = past.comparable_colours(settings).similarity(&colours, settings);
        (place.predicted || similarity >= MIN_COLOUR_SIMILARITY).then_some((place, similarity, *occluded))
    };
    let candidates: Vec<_> = table.occluded().iter().filter_map(candidate).collect();
    let by_colour = context.settings.reappear_by == ReappearBy::Colour && candidates.len() > 1;
    let chosen = if by_colour {
        candidates.iter().max_by(|a, b| a.1.total_cmp(&b.1))
    } else {
        candidates.iter().min_by(|a, b| a.0.share().total_cmp(&b.0.share()))
    };
    let Some(&(place, similarity, occluded)) = chosen else { return false };
    let evidence = reappearance_evidence(context, place, similarity, occluded, by_colour);
    continue_occluded(table, decisions, id, occluded, evidence);
    true
}

fn reappearance_evidence(
    context: &Context,
    place: ReappearancePlace,
    similarity: f32,
    occluded: OccludedObject,
    by_colour: bool,
) -> Evidence {
    let branch = match (by_colour, place.predicted) {
        (true, _) => {
            "unassociated region within reach of several occluded objects; selected by colour similarity"
        }
        (false, true) => "unassociated region at the predicted position of an occluded object",
        (false, false) => {
            "unassociated region where an occluded object may have stopped or turned; its colours are similar"
        }
    };
    let mut evidence = Evidence::of_branch(branch);
    let from = if place.predicted { "predicted position" } else { "predicted path" };
    evidence.at_most(format!("distance to {from}, pixels"), place.distance, place.reach);
    if place.predicted {
        evidence.note("colour similarity, 0 to 1.2", similarity);
    } else {
        evidence.at_least("colour similarity", similarity, MIN_COLOUR_SIMILARITY);
    }
    evidence.note("frames occluded", (context.t - occluded.since.t) as f32);
    evidence
}

/// Lets an occluded object continue in the place of the new one, with a pending reappearance.
fn continue_occluded(
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    new: ObjectId,
    occluded: OccludedObject,
    evidence: Evidence,
) {
    let Some(from) = table.get(occluded.id).map(|object| object.last_detection.bbox) else { return };
    let Some(seen) = table.get(new) else { return };
    // Its new region may have begun before the old one was given up.
    let frame = seen.first_frame.number.max(occluded.since.number);
    let (t, at) = (seen.first_frame.t.max(occluded.since.t), seen.first_bbox.centre());
    table.merge_track_into(new, occluded.id);
    let Some(identity) = table.identity(occluded.id) else { return };
    let event = Event::of_one(frame, EventKind::Reappear, identity, at, evidence);
    decisions.reappearances.push(PendingReappearance {
        id: occluded.id,
        since: occluded.since,
        t,
        event,
        from,
    });
}

/// Whether a new object needs a clearer view before its colours can be compared with occluded ones.
pub(super) fn needs_clearer_view(context: &Context, table: &ObjectTable, id: ObjectId) -> bool {
    let Some(new) = table.get(id) else { return false };
    let by_colours = |occluded: &OccludedObject| {
        table.get(occluded.id).is_some_and(|past| {
            let place = reappearance_place(context, past, occluded, &new.last_detection.bbox);
            place.is_some_and(|place| !place.near) && !past.is_nearly_whole(&new.last_detection)
        })
    };
    context.settings.reappear_by == ReappearBy::Colour
        && new.seen_frames < context.limits.edge_wait_frames
        && !context.is_near_border(&new.first_bbox)
        && table.occluded().iter().any(by_colours)
}

/// The place of a box relative to an occluded object, if it may be that one's: at the predicted place, or else between
/// the last place and that, as it may have stopped or turned.
fn reappearance_place(
    context: &Context,
    past: &Object,
    occluded: &OccludedObject,
    bbox: &Rect,
) -> Option<ReappearancePlace> {
    let frames = context.t - occluded.since.t;
    let (at_rest, wide) = (past.stationary_radius(frames), past.reappearance_radius(frames));
    let predicted_box = past.predicted_box();
    let distance = predicted_box.distance_outside(bbox);
    if !context.is_outside(&predicted_box) && distance <= wide {
        let near = distance <= at_rest;
        return Some(ReappearancePlace { distance, reach: wide, predicted: true, near });
    }
    if context.settings.reappear_by == ReappearBy::Position {
        return None;
    }
    let ([from_x, from_y], [to_x, to_y]) = (past.last_detection.bbox.centre(), past.model.centre());
    let (w, h) = past.size();
    let outside = |step: u8| {
        let share = f32::from(step) / f32::from(STOP_POSITIONS);
        let at = [from_x + share * (to_x - from_x), from_y + share * (to_y - from_y)];
        Rect::around(at, w, h).distance_outside(bbox)
    };
    let distance = (0..=STOP_POSITIONS).map(outside).fold(f32::INFINITY, f32::min);
    let place = ReappearancePlace { distance, reach: at_rest, predicted: false, near: false };
    (distance <= at_rest).then_some(place)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{BLUE, RED, context, person, start_confirmed, start_tentative};
    use crate::occlusion::state::context::FrameRef;

    /// A red person that is occluded from frame 2 on at x = 100, and a new object in frame 10. Gives the number of
    /// the known one if the new one is matched to it.
    fn match_new(x: f32) -> (Option<ObjectId>, ObjectTable, Decisions) {
        match_new_in(10, x)
    }

    /// The same where the match is tried in frame `t`.
    fn match_new_in(t: u32, x: f32) -> (Option<ObjectId>, ObjectTable, Decisions) {
        let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(t));
        let known = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        table.occlude(known, FrameRef { number: 2, index: 2, t: 2 });
        table.drop_empty_blobs();
        let new = start_tentative(&context(10), &mut table, person(x, 80.0), RED, [0.0; 2]);
        let matched = try_match_reappearance(&now, &mut table, &mut decisions, new);
        assert_eq!(table.check(), None);
        (matched.then_some(known), table, decisions)
    }

    #[test]
    fn a_new_object_at_the_predicted_place_continues_the_occluded_one() {
        let (known, table, decisions) = match_new(106.0);
        assert_eq!(known, Some(1));
        assert_eq!(table.blobs()[0].members(), [1]);
        assert!(table.occluded().is_empty() && !table.contains(2));
        // The tracks of the new one, under its key, have the known one's identity.
        assert_eq!(table.identity_map().of(2), table.identity(1));
        let pending = &decisions.reappearances[0];
        assert_eq!((pending.since.number, pending.event.frame), (2, 10));
        assert_eq!(pending.event.evidence.comparisons[0].threshold, Some(0.6 * 60.0 + 8.0_f32.sqrt()));
    }

    #[test]
    fn a_new_object_beyond_the_radius_is_another_one() {
        let (known, table, _) = match_new(180.0);
        assert_eq!((known, table.occluded().len()), (None, 1));
    }

    #[test]
    fn an_object_ends_after_it_was_occluded_for_too_long() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        table.occlude(id, FrameRef { number: 2, index: 2, t: 2 });
        table.drop_empty_blobs();
        let most = context(1).limits.max_hidden_frames;
        update_occluded(&context(2 + most), &mut table, &mut decisions);
        assert!(table.contains(id));
        update_occluded(&context(3 + most), &mut table, &mut decisions);
        assert!(!table.contains(id));
    }

    /// The place of a box of this centre relative to a person that was seen last at (110, 110), is predicted at
    /// `predicted` and has been occluded for 16 frames: the least radius is 40 pixels.
    fn place(
        predicted: [f32; 2],
        velocity: [f32; 2],
        centre: [f32; 2],
        by: ReappearBy,
    ) -> Option<ReappearancePlace> {
        let mut now = context(18);
        now.settings.reappear_by = by;
        let mut table = ObjectTable::default();
        let known = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, velocity);
        table.get_mut(known).unwrap().set_centre(predicted);
        table.occlude(known, FrameRef { number: 2, index: 2, t: 2 });
        let occluded = table.occlusion_of(known).unwrap();
        let bbox = Rect::around(centre, 20.0, 60.0);
        reappearance_place(&now, table.get(known).unwrap(), &occluded, &bbox)
    }

    #[test]
    fn an_occluded_object_reappears_at_the_predicted_place_or_where_it_may_have_stopped() {
        let at = |distance: f32, reach: f32, predicted: bool, near: bool| {
            Some(ReappearancePlace { distance, reach, predicted, near })
        };
        // At 5 pixels a frame the radius around the predicted place is twice as large.
        let near = |x: f32| place([190.0, 150.0], [3.0, 4.0], [x, 150.0], ReappearBy::Colour);
        assert_eq!(near(230.0), at(40.0, 80.0, true, true));
        assert_eq!(near(231.0), at(41.0, 80.0, true, false));
        assert_eq!(near(270.0), at(80.0, 80.0, true, false));
        assert_eq!(near(271.0), None);
        assert_eq!(near(230.0).unwrap().share(), 0.5);
        // Three eighths of the way, ten pixels above it.
        let on_the_way = |by: ReappearBy| place([310.0, 210.0], [0.0; 2], [185.0, 137.5], by);
        assert_eq!(on_the_way(ReappearBy::Colour), at(10.0, 40.0, false, false));
        assert_eq!(on_the_way(ReappearBy::Position), None);
        let below = |y: f32| place([310.0, 110.0], [0.0; 2], [185.0, y], ReappearBy::Colour);
        assert_eq!(below(150.0), at(40.0, 40.0, false, false));
        assert_eq!(below(151.0), None);
        // Beyond the image edge nothing reappears; half of the way it may have turned.
        assert_eq!(
            place([400.0, 110.0], [0.0; 2], [255.0, 110.0], ReappearBy::Colour),
            at(0.0, 40.0, false, false)
        );
    }

    #[test]
    fn by_position_an_object_predicted_outside_the_image_has_ended() {
        for (by, stays) in [(ReappearBy::Position, false), (ReappearBy::Colour, true)] {
            let (mut table, mut decisions, mut now) =
                (ObjectTable::default(), Decisions::default(), context(4));
            now.settings.reappear_by = by;
            let [outside, inside] = [400.0, 200.0].map(|x| {
                let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
                table.get_mut(id).unwrap().set_centre([x, 110.0]);
                table.occlude(id, FrameRef { number: 2, index: 2, t: 2 });
                id
            });
            table.drop_empty_blobs();
            update_occluded(&now, &mut table, &mut decisions);
            assert_eq!((table.contains(outside), table.contains(inside)), (stays, true), "{by:?}");
        }
    }

    #[test]
    fn a_reappearance_is_emitted_once_the_object_stayed_for_an_episode() {
        let (_, mut table, mut decisions) = match_new(106.0);
        let wait = context(1).limits.same_episode_frames;
        update_occluded(&context(10 + wait), &mut table, &mut decisions);
        assert_eq!((decisions.reappearances.len(), decisions.events.len()), (1, 0));
        update_occluded(&context(11 + wait), &mut table, &mut decisions);
        let kinds: Vec<EventKind> = decisions.events.iter().map(|event| event.kind).collect();
        assert_eq!((decisions.reappearances.len(), &kinds[..]), (0, &[EventKind::Reappear][..]));
        let frames = &decisions.events[0].evidence.comparisons[2];
        assert_eq!((&frames.what[..], frames.value), ("frames occluded", 8.0));
    }

    #[test]
    fn an_object_that_is_recognised_late_has_stayed_since_its_first_region() {
        let wait = context(1).limits.same_episode_frames;
        for (recognised, emitted) in [(10 + wait, false), (11 + wait, true)] {
            let (known, mut table, mut decisions) = match_new_in(recognised, 106.0);
            update_occluded(&context(recognised), &mut table, &mut decisions);
            assert_eq!((known, decisions.events.len()), (Some(1), usize::from(emitted)));
        }
    }

    /// A red and a blue person are occluded 30 pixels apart; a new one of this colour is at the place of the red one.
    fn match_of_two(colour: crate::regions::Rgb, by: ReappearBy) -> Option<ObjectId> {
        let (mut table, mut decisions, mut now) = (ObjectTable::default(), Decisions::default(), context(10));
        now.settings.reappear_by = by;
        let known = [(100.0, RED), (130.0, BLUE)].map(|(x, colour)| {
            let id = start_confirmed(&context(1), &mut table, person(x, 80.0), colour, [0.0; 2]);
            table.occlude(id, FrameRef { number: 2, index: 2, t: 2 });
            id
        });
        table.drop_empty_blobs();
        let new = start_tentative(&now, &mut table, person(100.0, 80.0), colour, [0.0; 2]);
        assert!(try_match_reappearance(&now, &mut table, &mut decisions, new));
        known.into_iter().find(|&id| table.occlusion_of(id).is_none())
    }

    #[test]
    fn of_several_occluded_objects_the_one_of_its_colour_or_the_nearest_reappears() {
        assert_eq!(match_of_two(BLUE, ReappearBy::Colour), Some(2));
        assert_eq!(match_of_two(RED, ReappearBy::Colour), Some(1));
        assert_eq!(match_of_two(BLUE, ReappearBy::Position), Some(1));
    }

    #[test]
    fn away_from_the_predicted_place_the_colours_have_to_be_similar() {
        for (colour, found) in [(RED, true), (BLUE, false)] {
            let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(10));
            let known = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
            table.get_mut(known).unwrap().set_centre([270.0, 110.0]);
            table.occlude(known, FrameRef { number: 2, index: 2, t: 2 });
            table.drop_empty_blobs();
            let new = start_tentative(&now, &mut table, person(150.0, 80.0), colour, [0.0; 2]);
            // It has moved there, so that a small part would do.
            table.get_mut(new).unwrap().first_bbox = person(100.0, 80.0);
            assert_eq!(try_match_reappearance(&now, &mut table, &mut decisions, new), found);
            if let [pending] = &decisions.reappearances[..] {
                assert!(pending.event.evidence.branch.contains("stopped or turned"));
            }
        }
    }

    #[test]
    fn a_part_of_an_object_on_the_way_waits_for_a_clearer_view() {
        let waits = |bbox: Rect, first_bbox: Rect, seen_frames: u32, by: ReappearBy| {
            let (mut table, mut now) = (ObjectTable::default(), context(10));
            now.settings.reappear_by = by;
            let known = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
            table.get_mut(known).unwrap().set_centre([270.0, 110.0]);
            table.occlude(known, FrameRef { number: 2, index: 2, t: 2 });
            table.drop_empty_blobs();
            let new = start_tentative(&now, &mut table, bbox, RED, [0.0; 2]);
            let object = table.get_mut(new).unwrap();
            (object.first_bbox, object.seen_frames) = (first_bbox, seen_frames);
            needs_clearer_view(&now, &table, new)
        };
        let (part, colour) = (Rect::new(180.0, 100.0, 20.0, 30.0), ReappearBy::Colour);
        let most = context(1).limits.edge_wait_frames;
        assert!(waits(part, part, most - 1, colour));
        assert!(!waits(part, part, most, colour), "long enough");
        assert!(!waits(person(180.0, 80.0), part, 1, colour), "the whole of it is seen");
        assert!(!waits(Rect::new(262.0, 100.0, 20.0, 30.0), part, 1, colour), "at the predicted place");
        assert!(!waits(Rect::new(180.0, 180.0, 20.0, 30.0), part, 1, colour), "too far below");
        assert!(!waits(part, Rect::new(0.0, 100.0, 20.0, 30.0), 1, colour), "it entered");
        assert!(!waits(part, part, 1, ReappearBy::Position));
    }
}
