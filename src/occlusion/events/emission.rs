//! Emits events, each at the first frame at which it can have happened after the earlier ones of the same objects,
//! and makes the moves in the table that belong to them.

use crate::occlusion::event::{Episode, EpisodeKind, Event, EventKind, Evidence};
use crate::occlusion::state::context::{Context, FrameRef};
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::groups::{GroupChange, partition_by};
use crate::occlusion::state::object_table::ObjectTable;
use crate::regions::Rect;
use crate::tracking::ObjectId;

/// Emits an event of some objects. Its frame comes after all emitted events of them and their groups, and is put off
/// to the next frame where it could not have happened after those.
pub(crate) fn emit_event(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    ids: &[ObjectId],
    event: Event,
) {
    let frame = earliest_frame(table, ids, event.frame, event.kind).min(context.number);
    for id in table.groups().with_group_members(ids) {
        if let Some(object) = table.get_mut(id) {
            object.last_event = object.last_event.max(Some((frame, event.kind)));
        }
    }
    decisions.events.push(Event { frame, ..event });
}

/// The first frame from `frame` on in which an event of `kind` can have happened to these objects.
fn earliest_frame(table: &ObjectTable, ids: &[ObjectId], frame: u32, kind: EventKind) -> u32 {
    let members = table.groups().with_group_members(ids);
    let emitted = members.into_iter().filter_map(|id| table.get(id)?.last_event);
    let after = emitted.map(|(last, before)| if kind.may_follow(before) { last } else { last + 1 });
    after.fold(frame, u32::max)
}

/// Whether an object can exit in this frame according to its emitted events.
pub(crate) fn can_leave(context: &Context, table: &ObjectTable, id: ObjectId) -> bool {
    earliest_frame(table, &[id], context.number, EventKind::Exit) <= context.number
}

/// Emits the exit of an object and ends it.
pub(crate) fn emit_exit(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
    frame: u32,
    evidence: Evidence,
) {
    emit_reappearance(context, table, decisions, id);
    if let Some(identity) = table.identity(id)
        && let Some(at) = table.get(id).map(|object| object.last_detection.bbox.centre())
    {
        let event = Event::of_one(frame, EventKind::Exit, identity, at, evidence);
        emit_event(context, table, decisions, &[id], event);
    }
    table.end_object(id);
}

/// Marks an object that lost its region inside the image as occluded (a past object), and emits its disappearance.
pub(crate) fn mark_occluded(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
    since: FrameRef,
) {
    let Some(identity) = table.identity(id) else {
        table.end_object(id);
        return;
    };
    if let Some(pending) = decisions.take_reappearance_of(id) {
        // It was visible only through a gap in the occluder: the occlusion continues.
        table.occlude(id, pending.since);
        return;
    }
    let Some(object) = table.get_mut(id) else { return };
    object.restore_clear_velocity();
    let last = object.last_detection.bbox;
    let distance = last.distance_to_edge(context.size);
    let away = distance > context.limits.border_px;
    let place = if away { "away from the image edge" } else { "moving inward at the image edge" };
    let mut evidence = Evidence::of_branch(format!(
        "no region from frame {} on, {place}; no other region grew to contain it",
        since.number
    ));
    evidence.at_least("distance to image edge, pixels", distance, context.limits.border_px);
    let event = Event::of_one(since.number, EventKind::Disappear, identity, last.centre(), evidence);
    emit_event(context, table, decisions, &[id], event);
    table.occlude(id, since);
}

/// Emits the pending reappearance of an object, if it has one, and the episode that it ends.
pub(crate) fn emit_reappearance(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    id: ObjectId,
) {
    let Some(pending) = decisions.take_reappearance_of(id) else { return };
    if let Some(object) = table.get(id) {
        let (w, h) = object.size();
        let back = Rect::around([pending.event.x, pending.event.y], w, h);
        decisions.remember_occluder(pending.from.union(&back));
    }
    decisions.scene_episodes.push(Episode {
        kind: EpisodeKind::Scene,
        objects: pending.event.objects.clone(),
        start: pending.since.number,
        end: pending.event.frame.saturating_sub(1).max(pending.since.number),
        least_visible: 0.0,
        front: None,
        identities_kept: true,
    });
    emit_event(context, table, decisions, &[id], pending.event);
}

/// Emits the demerge of members of one group that are in several `pieces`.
pub(super) fn emit_demerge(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    pieces: &[Vec<ObjectId>],
    cause: &GroupChange,
) {
    for group in table.groups().of_any(pieces.iter().flatten()) {
        let mut parts = partition_by(&group, |id| pieces.iter().position(|piece| piece.contains(&id)));
        parts.sort();
        let members: Vec<ObjectId> = group.iter().copied().collect();
        let frame = earliest_frame(table, &members, cause.frame, EventKind::Demerge);
        if parts.len() < 2 || frame > context.number {
            continue;
        }
        let parts: Vec<Vec<ObjectId>> = parts.into_iter().map(|(_, part)| part).collect();
        let alone: Vec<ObjectId> = parts.iter().filter(|part| part.len() == 1).flatten().copied().collect();
        let objects = table.identities_of(&members);
        let event = Event {
            frame,
            kind: EventKind::Demerge,
            becomes: if alone.is_empty() { objects.clone() } else { table.identities_of(&alone) },
            objects,
            pieces: parts.iter().map(|part| table.identities_of(part)).collect(),
            x: cause.at[0],
            y: cause.at[1],
            front: None,
            evidence: cause.evidence.clone(),
        };
        emit_event(context, table, decisions, &members, event);
        table.groups_mut().split(&group, parts);
    }
}

/// Emits the merge of objects that share a region, unless one of them has a pending demerge with others.
pub(super) fn emit_merge(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    members: &[ObjectId],
) {
    let waits = !table.groups().with_group_members(members).iter().all(|id| members.contains(id));
    if waits || earliest_frame(table, members, context.number, EventKind::Merge) > context.number {
        return;
    }
    let cause = table.groups().cause_of_joining(members).cloned().unwrap_or_else(|| {
        let shared = members.first().and_then(|&id| table.blob(table.blob_of(id)?));
        let at = shared.map(|tracked| tracked.blob.bbox).unwrap_or_default().centre();
        let branch = format!("{} objects share one region", members.len());
        GroupChange { frame: context.number, at, evidence: Evidence::of_branch(branch) }
    });
    let identities = table.identities_of(members);
    let event = Event {
        frame: context.number,
        kind: EventKind::Merge,
        objects: identities.clone(),
        becomes: identities,
        pieces: Vec::new(),
        x: cause.at[0],
        y: cause.at[1],
        front: None,
        evidence: cause.evidence,
    };
    emit_event(context, table, decisions, members, event);
    table.groups_mut().merge(members);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{RED, context, person, start_confirmed, start_group};
    use crate::occlusion::state::decisions::PendingReappearance;

    const SINCE: FrameRef = FrameRef { number: 2, index: 2, t: 2 };

    /// A person that was occluded at x = 60 from frame 2 on and reappeared at x = 100 in frame 8.
    fn reappeared() -> (ObjectTable, Decisions, ObjectId) {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let id = start_confirmed(&context(8), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let event = Event::of_one(8, EventKind::Reappear, 1, [110.0, 110.0], Evidence::default());
        decisions.reappearances.push(PendingReappearance {
            id,
            since: SINCE,
            t: 8,
            event,
            from: person(60.0, 80.0),
        });
        (table, decisions, id)
    }

    #[test]
    fn a_reappearance_ends_an_episode_and_leaves_an_occluder_behind() {
        let (mut table, mut decisions, id) = reappeared();
        emit_reappearance(&context(20), &mut table, &mut decisions, id);
        let [event] = &decisions.events[..] else { panic!("{:?}", decisions.events) };
        assert_eq!((event.kind, event.frame), (EventKind::Reappear, 8));
        let episode = &decisions.scene_episodes[0];
        assert_eq!((episode.kind, episode.start, episode.end), (EpisodeKind::Scene, 2, 7));
        assert_eq!(decisions.occluders(), [Rect::new(60.0, 80.0, 60.0, 60.0)]);
        emit_reappearance(&context(21), &mut table, &mut decisions, id);
        assert_eq!(decisions.events.len(), 1, "once");
    }

    #[test]
    fn an_object_that_is_occluded_again_at_once_never_reappeared() {
        let (mut table, mut decisions, id) = reappeared();
        mark_occluded(
            &context(10),
            &mut table,
            &mut decisions,
            id,
            FrameRef { number: 10, index: 10, t: 10 },
        );
        assert_eq!(table.occlusion_of(id).map(|occluded| occluded.since), Some(SINCE));
        assert!(decisions.events.is_empty() && decisions.reappearances.is_empty());
    }

    #[test]
    fn an_exit_comes_after_the_reappearance_that_was_pending() {
        let (mut table, mut decisions, id) = reappeared();
        emit_exit(&context(12), &mut table, &mut decisions, id, 12, Evidence::default());
        let kinds: Vec<_> = decisions.events.iter().map(|event| (event.kind, event.frame)).collect();
        assert_eq!(kinds, [(EventKind::Reappear, 8), (EventKind::Exit, 12)]);
        assert!(!table.contains(id));
    }

    #[test]
    fn an_event_comes_after_the_last_one_of_the_whole_group() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let [a, b] = start_group(&context(1), &mut table, person(100.0, 80.0), person(120.0, 80.0));
        table.get_mut(b).unwrap().last_event = Some((6, EventKind::Merge));
        assert!(!can_leave(&context(6), &table, a), "an exit comes before a merge of the same frame");
        assert!(can_leave(&context(7), &table, a));
        let event = Event::of_one(3, EventKind::Disappear, 1, [0.0; 2], Evidence::default());
        emit_event(&context(9), &mut table, &mut decisions, &[a], event);
        assert_eq!(decisions.events[0].frame, 6, "after the merge, in the same frame");
        assert_eq!(table.get(b).unwrap().last_event, Some((6, EventKind::Disappear)));
    }
}
