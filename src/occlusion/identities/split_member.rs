//! Re-identification of a new object as a member that left a group (Algorithm 3).

use crate::occlusion::event::Evidence;
use crate::occlusion::events::assign;
use crate::occlusion::events::demerges::settle_demerges_of;
use crate::occlusion::state::comparable_colours::ComparableColours;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::groups::GroupChange;
use crate::occlusion::state::object::Object;
use crate::occlusion::state::object_table::ObjectTable;
use crate::occlusion::state::split_region::AssociationScore;
use crate::tracking::ObjectId;

/// A member left at most this many standard deviations from its predicted place.
const MAX_DISTANCE_SIGMAS: f32 = 3.0;

/// A group's member that a new object may be.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    member: ObjectId,
    score: AssociationScore,
    /// The group's area relative to the expected one of its members.
    filled: f32,
    /// Number of members of the group.
    members: usize,
}

/// Matches a new object to a member of a group that shrank: it left where the group's region no longer is
/// (Algorithm 3). On success that member continues in its place. Whether it was matched.
pub(super) fn try_match_split_member(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) -> bool {
    let (candidate, frame, at) = loop {
        let Some(new) = table.get(id) else { return false };
        let Some(candidate) = best_candidate(context, table, decisions, id, new) else { return false };
        if !decisions.has_demerge_of(candidate.member) {
            break (candidate, new.first_frame.number, new.first_bbox.centre());
        }
        // The identities within the group were undecided until now: another member may fit better.
        settle_demerges_of(context, table, decisions, candidate.member);
    };
    let evidence = split_evidence(context, candidate);
    table.merge_track_into(id, candidate.member);
    table.groups_mut().record_leaving(candidate.member, GroupChange { frame, at, evidence });
    true
}

fn best_candidate(
    context: &Context,
    table: &ObjectTable,
    decisions: &Decisions,
    id: ObjectId,
    new: &Object,
) -> Option<Candidate> {
    let colours = ComparableColours::new(&new.last_detection.histogram, &context.settings);
    let mut best: Option<(f32, Candidate)> = None;
    for group in table.blobs().iter().filter(|it| it.is_shared() && !it.members().contains(&id)) {
        let due: f32 = table.objects_of(group.members()).map(Object::area).sum();
        let seen = group.detection.as_ref().map_or(0.0, |detection| detection.area);
        let shrunk = seen <= (1.0 - context.settings.size_step) * due;
        let known = group.members().iter().filter_map(|&id| Some((id, table.get(id)?)));
        for (member, object) in known.filter(|(_, object)| shrunk || object.unseen_frames > 0) {
            if !new.may_match(object) || !events_allow(context, new, object) {
                continue;
            }
            let sigma = object.position_sigma(Some(decisions.group_episodes.duration_of(member, context.t)));
            if object.predicted_box().distance_outside(&new.first_bbox) > MAX_DISTANCE_SIGMAS * sigma {
                continue;
            }
            let similarity =
                object.comparable_colours(&context.settings).similarity(&colours, &context.settings);
            let score = assign::association_score(object, sigma, &new.first_bbox, similarity);
            let value = assign::total_nats(score);
            if best.is_none_or(|(most, _)| value > most) {
                let members = group.members().len();
                best = Some((value, Candidate { member, score, filled: seen / due, members }));
            }
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// Whether a new object can have been this member since its first frame according to the emitted events, which stay: at
/// most `same_episode` later is an event by which the member was in the group.
fn events_allow(context: &Context, new: &Object, member: &Object) -> bool {
    let age = context.t - new.first_frame.t;
    let latest_event = member.last_event.map_or(0, |(frame, _)| frame);
    age <= context.number.saturating_sub(latest_event) + context.limits.same_episode_frames
}

fn split_evidence(context: &Context, Candidate { score, filled, members, .. }: Candidate) -> Evidence {
    let step = context.settings.size_step;
    let why = if filled <= 1.0 - step { "that shrank" } else { "in which it was not visible" };
    let mut evidence = Evidence::of_branch(format!(
        "unassociated region next to one shared by {members} objects, {why}; assigned to the best-matching \
         group member",
    ));
    evidence.at_most("group area relative to the expected area of its members", filled, 1.0 - step);
    evidence.note("colour similarity, 0 to 1.2", score.colour);
    evidence.note("distance to the member's prediction, pixels", score.distance);
    evidence
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::event::EventKind;
    use crate::occlusion::fixtures::{
        BLUE, RED, context, detection, object, person, start_group, start_tentative,
    };
    use crate::occlusion::state::object::Appearance;
    use crate::occlusion::state::object_table::TrackedBlob;
    use crate::regions::Rect;
    use crate::settings::Settings;

    /// A group of a red and a blue person, of which only the red one's region is left, and a new blue object.
    fn match_new(x: f32) -> (bool, ObjectTable, [ObjectId; 2]) {
        let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(9));
        let members = start_group(&context(1), &mut table, person(120.0, 80.0), person(140.0, 80.0));
        table.blob_mut(0).unwrap().detection = Some(detection(person(120.0, 80.0), RED));
        let new = start_tentative(&now, &mut table, person(x, 80.0), BLUE, [0.0; 2]);
        let matched = try_match_split_member(&now, &mut table, &mut decisions, new);
        assert_eq!(table.check(), None);
        (matched, table, members)
    }

    #[test]
    fn a_new_object_beside_a_group_that_shrank_is_the_member_of_its_colours() {
        let (matched, table, [red, blue]) = match_new(152.0);
        assert!(matched);
        assert_eq!(table.blobs().iter().map(TrackedBlob::members).collect::<Vec<_>>(), [[red], [blue]]);
        assert!(table.groups().cause_of_leaving(&[blue].into()).is_some());
    }

    #[test]
    fn a_new_object_far_from_the_group_is_none_of_its_members() {
        assert!(!match_new(240.0).0);
    }

    /// The match of a new blue object at `x` with a group whose region has this width.
    fn matched(x: f32, width: f32, change: impl FnOnce(&mut ObjectTable, [ObjectId; 2])) -> Option<Evidence> {
        let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(9));
        let members = start_group(&context(1), &mut table, person(120.0, 80.0), person(140.0, 80.0));
        table.blob_mut(0).unwrap().detection = Some(detection(Rect::new(120.0, 80.0, width, 60.0), RED));
        change(&mut table, members);
        let new = start_tentative(&now, &mut table, person(x, 80.0), BLUE, [0.0; 2]);
        let matched = try_match_split_member(&now, &mut table, &mut decisions, new);
        let cause = table.groups().cause_of_leaving(&[members[1]].into());
        assert_eq!(matched, cause.is_some());
        cause.map(|cause| cause.evidence.clone())
    }

    #[test]
    fn a_member_leaves_a_group_that_shrank_or_in_which_it_was_not_visible() {
        let step = Settings::default().size_step;
        let evidence = matched(152.0, 20.0, |_, _| {}).unwrap();
        assert!(evidence.branch.contains("that shrank"), "{}", evidence.branch);
        let [area, colour, distance] = &evidence.comparisons[..] else { panic!("{evidence:?}") };
        assert_eq!((area.value, area.threshold, area.holds), (0.5, Some(1.0 - step), true));
        assert!((colour.value - 1.2).abs() < 1e-4);
        assert_eq!(distance.value, 12.0);
        // Both are 40 pixels wide.
        let whole = 2.0 * (20.0 * (1.0 - step)).floor();
        assert!(matched(152.0, whole, |_, _| {}).is_some());
        assert!(matched(152.0, whole + 2.0, |_, _| {}).is_none(), "as large as before");
        let unseen =
            matched(152.0, 40.0, |table, [_, blue]| table.get_mut(blue).unwrap().unseen_frames = 1).unwrap();
        assert!(unseen.branch.contains("not visible"), "{}", unseen.branch);
        assert_eq!((unseen.comparisons[0].value, unseen.comparisons[0].holds), (1.0, false));
    }

    #[test]
    fn a_member_is_within_three_standard_deviations() {
        // .15 of the height of 60 pixels.
        assert!(matched(140.0 + 27.0, 20.0, |_, _| {}).is_some());
        assert!(matched(140.0 + 28.0, 20.0, |_, _| {}).is_none());
    }

    #[test]
    fn an_object_that_began_long_before_an_event_of_a_member_is_another_one() {
        let gap = context(1).limits.same_episode_frames;
        let new = object(&context(9), 1, &detection(person(152.0, 80.0), BLUE), [0.0; 2]);
        let allowed = |event: u32| {
            let member = Object { last_event: Some((event, EventKind::Merge)), ..new.clone() };
            events_allow(&context(30 + gap), &new, &member)
        };
        assert!(allowed(3) && allowed(9) && allowed(9 + gap));
        assert!(!allowed(10 + gap));
    }

    #[test]
    fn of_two_members_the_one_of_its_colours_is_matched() {
        for order in [[RED, BLUE], [BLUE, RED]] {
            let (mut table, mut decisions, now) = (ObjectTable::default(), Decisions::default(), context(9));
            let members = start_group(&context(1), &mut table, person(120.0, 80.0), person(130.0, 80.0));
            for (id, colour) in members.into_iter().zip(order) {
                let seen = detection(person(120.0, 80.0), colour);
                table.get_mut(id).unwrap().appearance = Some(Appearance::new(&seen, [0.0; 2]));
            }
            table.blob_mut(0).unwrap().detection = Some(detection(person(120.0, 80.0), RED));
            let new = start_tentative(&now, &mut table, person(127.0, 80.0), BLUE, [0.0; 2]);
            assert!(try_match_split_member(&now, &mut table, &mut decisions, new));
            let left = members[order.iter().position(|&colour| colour == BLUE).unwrap()];
            assert!(table.groups().cause_of_leaving(&[left].into()).is_some());
        }
    }
}
