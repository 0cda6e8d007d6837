//! Demerges of occlusion groups: the identities of the resulting regions (Algorithm 3), decided after the regions
//! were observed for some frames.

use std::collections::BTreeMap;

use super::assign;
use super::emission::emit_demerge;
use crate::occlusion::event::{Comparison, Evidence};
use crate::occlusion::state::comparable_colours::ComparableColours;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::{Decisions, PendingDemerge};
use crate::occlusion::state::groups::GroupChange;
use crate::occlusion::state::object_table::{ObjectTable, SplitPart};
use crate::occlusion::state::split_region::{AssociationScore, SplitRegion};
use crate::regions::Histogram;
use crate::tracking::ObjectId;

/// A decision about identities waits at most this many frames for a clearer view.
const MAX_WAIT_FRAMES: u32 = 10;

/// ΔE written to the evidence where one of two has no dominant colour.
const NO_DELTA_E: f32 = 999.0;

/// Records a demerge, if the group's members are now in several of `parts`, each with the number of its region in the
/// rows of `scores`.
pub(crate) fn start_demerge(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    group: &[ObjectId],
    parts: &[(usize, SplitPart)],
    scores: &BTreeMap<ObjectId, Vec<AssociationScore>>,
) {
    let present: Vec<ObjectId> = group.iter().copied().filter(|&id| table.contains(id)).collect();
    let parts: Vec<&(usize, SplitPart)> =
        parts.iter().filter(|(_, part)| part.members.iter().any(|id| present.contains(id))).collect();
    if parts.len() < 2 {
        return;
    }
    for &id in &present {
        settle_demerges_of(context, table, decisions, id);
    }
    let region_of = present
        .iter()
        .map(|id| parts.iter().position(|(_, part)| part.members.contains(id)).unwrap_or(0))
        .collect();
    let scores = present
        .iter()
        .filter_map(|id| scores.get(id))
        .map(|row| parts.iter().filter_map(|(number, _)| row.get(*number).copied()).collect())
        .collect();
    let regions = parts.iter().map(|(_, part)| SplitRegion {
        bbox: part.detection.bbox,
        area: part.detection.area,
        histogram: Histogram::default(),
    });
    let regions = regions.collect();
    // From here on their tracks have new keys: if the assignment turns out to be reversed, only the identities of the
    // keys change.
    for &id in &present {
        table.renew_key(id);
    }
    decisions.demerges.push(PendingDemerge {
        at: context.now(),
        members: present,
        region_of,
        regions,
        scores,
        decided: false,
    });
}

/// Decides the pending demerges of objects before they are assigned to `regions` new regions; identities may be
/// swapped. A demerge whose members all share one region again is dropped: they never parted.
pub(crate) fn settle_before_merge(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    members: &[ObjectId],
    regions: usize,
) {
    let together =
        |demerge: &PendingDemerge| regions == 1 && demerge.members.iter().all(|id| members.contains(id));
    decisions.demerges.retain(|demerge| !together(demerge));
    for &id in members {
        settle_demerges_of(context, table, decisions, id);
    }
}

/// Decides and emits the pending demerges of an object at once; identities may be swapped.
pub(crate) fn settle_demerges_of(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) {
    while let Some(demerge) = decisions.take_demerge_of(id) {
        settle_demerge(context, table, decisions, demerge);
    }
}

fn settle_demerge(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    mut demerge: PendingDemerge,
) {
    decide_demerge(context, table, &mut demerge);
    let regions: Vec<Vec<ObjectId>> =
        (0..demerge.regions.len()).map(|region| demerge.members_in(region)).collect();
    emit_demerge(context, table, decisions, &regions, &cause_of(context, table, &demerge));
}

/// Accumulates the regions' colours; decides and emits demerges that waited long enough.
pub(crate) fn update_pending_demerges(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    let same_episode = context.limits.same_episode_frames;
    for mut demerge in std::mem::take(&mut decisions.demerges) {
        accumulate_histograms(table, &mut demerge);
        let waited = context.t - demerge.at.t;
        if waited >= MAX_WAIT_FRAMES.min(same_episode.max(3)) {
            decide_demerge(context, table, &mut demerge);
        }
        if waited > same_episode {
            settle_demerge(context, table, decisions, demerge);
        } else {
            decisions.demerges.push(demerge);
        }
    }
}

fn accumulate_histograms(table: &ObjectTable, demerge: &mut PendingDemerge) {
    let members: Vec<Vec<ObjectId>> =
        (0..demerge.regions.len()).map(|region| demerge.members_in(region)).collect();
    for (region, members) in demerge.regions.iter_mut().zip(members) {
        let tracked = table.blobs().iter().find(|tracked| tracked.members() == members);
        if let Some(detection) = tracked.and_then(|tracked| tracked.detection.as_ref()) {
            region.histogram.add_scaled(&detection.histogram, 1.0 / detection.area.max(1.0));
        }
    }
}

/// Assigns members to regions again, by the colours accumulated since and the motion at the demerge. Where the result
/// differs from the first assignment, identities are swapped. Without the colours of a region, or after a member's
/// end, the first assignment stands.
fn decide_demerge(context: &Context, table: &mut ObjectTable, demerge: &mut PendingDemerge) {
    if std::mem::replace(&mut demerge.decided, true) {
        return;
    }
    if demerge.regions.iter().any(|region| region.histogram.total() <= 0.0)
        || demerge.members.iter().any(|&id| !table.contains(id))
    {
        return;
    }
    let settings = &context.settings;
    let seen: Vec<ComparableColours> =
        demerge.regions.iter().map(|region| ComparableColours::new(&region.histogram, settings)).collect();
    let mut scores = demerge.scores.clone();
    for (row, object) in scores.iter_mut().zip(table.objects_of(&demerge.members)) {
        let colours = object.comparable_colours(settings);
        for (score, seen) in row.iter_mut().zip(&seen) {
            (score.colour, score.delta_e) = colours.similarity(seen, settings);
        }
    }
    let assigned = assign::reassign_to_regions(&scores, &demerge.region_of, demerge.regions.len());
    let mut takes_place_of = BTreeMap::new();
    for region in 0..demerge.regions.len() {
        let new = demerge.members.iter().zip(&assigned).filter(|(_, at)| **at == region).map(|(&id, _)| id);
        takes_place_of.extend(new.zip(demerge.members_in(region)));
    }
    table.swap_places(&takes_place_of);
    demerge.scores = scores;
    demerge.region_of = assigned;
}

/// When, where and why the members of a demerge parted.
fn cause_of(context: &Context, table: &ObjectTable, demerge: &PendingDemerge) -> GroupChange {
    let area: f32 = demerge.regions.iter().map(|region| region.area).sum();
    let mut evidence = Evidence::of_branch(format!(
        "region shared by {} objects split into {} fragments, {area:.0} pixels in total; decided \
         after {} frames",
        table.identities_of(&demerge.members).len(),
        demerge.regions.len(),
        context.t - demerge.at.t,
    ));
    for (member, (row, &chosen)) in demerge.members.iter().zip(demerge.scores.iter().zip(&demerge.region_of))
    {
        let identity = table.identity(*member).unwrap_or_default();
        for (region, score) in row.iter().enumerate() {
            let name = region + 1;
            let alternatives = [
                Comparison::at_most(
                    format!("ΔE of {identity} and fragment {name}"),
                    if score.delta_e.is_finite() { score.delta_e } else { NO_DELTA_E },
                    context.settings.same_colour,
                ),
                Comparison::note(
                    format!("colour similarity of {identity} and fragment {name}, 0 to 1.2"),
                    score.colour,
                ),
                Comparison::note(
                    format!("distance of fragment {name} to the prediction of {identity}, pixels"),
                    score.distance,
                ),
            ];
            evidence.comparisons.extend(alternatives.map(|it| it.of_alternative(region == chosen)));
        }
    }
    let boxes = demerge.regions.iter().map(|region| region.bbox);
    let around = boxes.reduce(|a, b| a.union(&b)).unwrap_or_default();
    GroupChange { frame: demerge.at.number, at: around.centre(), evidence }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::event::EventKind;
    use crate::occlusion::fixtures::{BLUE, RED, context, detection, object, person, start_group};
    use crate::regions::Rgb;
    use crate::tracking::pool::Blob;

    /// A red and a blue member of a group, which are assigned to a region on the left and one on the right of these
    /// colours.
    fn demerged(left: Rgb, right: Rgb) -> (ObjectTable, Decisions, [ObjectId; 2]) {
        let (mut table, mut decisions, context) = (ObjectTable::default(), Decisions::default(), context(2));
        let members = start_group(&context, &mut table, person(130.0, 80.0), person(150.0, 80.0));
        let part = |(id, x, colour): (ObjectId, f32, Rgb)| {
            let detection = detection(person(x, 80.0), colour);
            let blob = Blob::new(object(&context, id, &detection, [0.0; 2]).model, &detection.observation());
            SplitPart { blob, members: vec![id], detection }
        };
        let parts = [(members[0], 110.0, left), (members[1], 170.0, right)].map(part);
        let scores = members.map(|id| (id, vec![AssociationScore::default(); 2])).into();
        let parts: Vec<(usize, SplitPart)> = parts.into_iter().enumerate().collect();
        start_demerge(&context, &mut table, &mut decisions, &members, &parts, &scores);
        table.split_blobs(&[0], parts.into_iter().map(|(_, part)| part).collect());
        table.drop_empty_blobs();
        (table, decisions, members)
    }

    fn place(table: &ObjectTable, id: ObjectId) -> f32 {
        table.blob(table.blob_of(id).unwrap()).unwrap().blob.bbox.x
    }

    #[test]
    fn identities_are_swapped_where_the_colours_say_so_and_the_event_is_emitted_later() {
        let (mut table, mut decisions, [red, blue]) = demerged(BLUE, RED);
        let keys = [red, blue].map(|id| table.get(id).unwrap().key);
        assert_eq!(table.identity_map().of(keys[0]), table.identity(red), "the new key has its identity");
        for t in 3..=2 + MAX_WAIT_FRAMES {
            assert_eq!([place(&table, red), place(&table, blue)], [110.0, 170.0], "{t}");
            update_pending_demerges(&context(t), &mut table, &mut decisions);
        }
        assert_eq!([place(&table, red), place(&table, blue)], [170.0, 110.0]);
        assert_eq!([red, blue].map(|id| table.get(id).unwrap().key), [keys[1], keys[0]]);
        assert_eq!(table.identity_map().of(keys[0]), table.identity(blue));
        assert_eq!(table.check(), None);
        assert!(decisions.events.is_empty(), "it waits for an end of the episode");
        let last = 3 + context(1).limits.same_episode_frames;
        update_pending_demerges(&context(last), &mut table, &mut decisions);
        let [event] = &decisions.events[..] else { panic!("{:?}", decisions.events) };
        assert_eq!(
            (event.kind, event.frame, &event.pieces),
            (EventKind::Demerge, 2, &vec![vec![2], vec![1]])
        );
        assert!(decisions.demerges.is_empty());
    }

    #[test]
    fn identities_stay_where_the_first_assignment_agrees_with_the_colours() {
        let (mut table, mut decisions, [red, blue]) = demerged(RED, BLUE);
        update_pending_demerges(&context(3), &mut table, &mut decisions);
        settle_demerges_of(&context(4), &mut table, &mut decisions, blue);
        assert_eq!([place(&table, red), place(&table, blue)], [110.0, 170.0]);
        assert_eq!(decisions.events.len(), 1);
    }

    #[test]
    fn a_demerge_whose_members_share_one_region_again_is_dropped() {
        let (mut table, mut decisions, members) = demerged(RED, BLUE);
        settle_before_merge(&context(4), &mut table, &mut decisions, &members, 1);
        assert!(decisions.demerges.is_empty() && decisions.events.is_empty());
    }
}
