//! Merges and demerges: the difference of two partitions of the objects, the groups according to the emitted events
//! and the regions of this frame. Only this file decides on them.

use std::collections::BTreeSet;

use super::demerges::settle_demerges_of;
use super::emission::{emit_demerge, emit_merge, emit_reappearance};
use crate::occlusion::event::Evidence;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::{Decisions, PendingDemerge};
use crate::occlusion::state::groups::{GroupChange, partition};
use crate::occlusion::state::object_table::ObjectTable;
use crate::tracking::ObjectId;

/// Emits the merges and demerges since the previous frame. A demerge whose identities are undecided is emitted once
/// they are.
pub(crate) fn emit_group_changes(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    while let Some(id) = outdated_demerge(table, decisions) {
        settle_demerges_of(context, table, decisions, id);
    }
    emit_immediate_demerges(context, table, decisions);
    // An object that joins another group has left, or rejoined, the groups of its pending demerges.
    for id in newly_sharing_region(table).concat() {
        settle_demerges_of(context, table, decisions, id);
        emit_reappearance(context, table, decisions, id);
    }
    emit_immediate_demerges(context, table, decisions);
    for members in newly_sharing_region(table) {
        emit_merge(context, table, decisions, &members);
    }
    table.groups_mut().drop_causes_before(context.number);
}

/// A member of a pending demerge whose partition no longer holds.
fn outdated_demerge(table: &ObjectTable, decisions: &Decisions) -> Option<ObjectId> {
    let holds = |demerge: &PendingDemerge| {
        let members: BTreeSet<ObjectId> = demerge.members.iter().copied().collect();
        partition(&members, |id| table.blob_of(id)) == partition(&members, |id| demerge.region_of_member(id))
    };
    let outdated = decisions.demerges.iter().find(|demerge| !holds(demerge));
    outdated.and_then(|demerge| demerge.members.first().copied())
}

/// The confirmed members of each region that are not yet in one group according to the emitted events.
fn newly_sharing_region(table: &ObjectTable) -> Vec<Vec<ObjectId>> {
    let shared = table.blobs().iter().map(|tracked| -> Vec<ObjectId> {
        tracked.members().iter().copied().filter(|&id| table.is_confirmed(id)).collect()
    });
    shared.filter(|members| members.len() > 1 && !table.groups().has_group_of(members)).collect()
}

/// Emits at once the demerges of members in several regions that have no pending demerge.
fn emit_immediate_demerges(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    let waits = |group: &BTreeSet<ObjectId>| {
        let in_group =
            |demerge: &PendingDemerge| demerge.members.iter().filter(|id| group.contains(id)).count();
        decisions.demerges.iter().any(|demerge| in_group(demerge) > 1)
    };
    let open: Vec<BTreeSet<ObjectId>> =
        table.groups().iter().filter(|group| !waits(group)).cloned().collect();
    for members in open {
        let pieces = partition(&members, |id| table.blob_of(id));
        if pieces.len() < 2 {
            continue;
        }
        let cause = table.groups().cause_of_leaving(&members).cloned().unwrap_or_else(|| {
            let boxes = members.iter().filter_map(|&id| Some(table.get(id)?.last_detection.bbox));
            let around = boxes.reduce(|a, b| a.union(&b)).unwrap_or_default();
            let branch =
                format!("{} objects of one region are now in {} regions", members.len(), pieces.len());
            GroupChange { frame: context.number, at: around.centre(), evidence: Evidence::of_branch(branch) }
        });
        emit_demerge(context, table, decisions, &pieces, &cause);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::event::EventKind;
    use crate::occlusion::fixtures::{
        BLUE, RED, context, detection, object, person, shared_detection, start_confirmed,
    };
    use crate::occlusion::state::object_table::SplitPart;
    use crate::tracking::pool::Blob;

    fn blob_of(context: &Context, detection: &crate::occlusion::state::object::Detection) -> Blob {
        Blob::new(object(context, 0, detection, [0.0; 2]).model, &detection.observation())
    }

    fn kinds(decisions: &Decisions) -> Vec<(EventKind, u32)> {
        decisions.events.iter().map(|event| (event.kind, event.frame)).collect()
    }

    #[test]
    fn a_shared_region_is_one_merge_and_separate_regions_are_one_demerge() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let pair = [(person(100.0, 80.0), RED), (person(118.0, 80.0), BLUE)];
        let [a, b] =
            pair.map(|(bbox, colour)| start_confirmed(&context(1), &mut table, bbox, colour, [0.0; 2]));
        emit_group_changes(&context(1), &mut table, &mut decisions);
        assert_eq!(kinds(&decisions), []);

        let shared = shared_detection(&pair);
        table.merge_blobs(&[0, 1], blob_of(&context(2), &shared), shared);
        table.drop_empty_blobs();
        emit_group_changes(&context(2), &mut table, &mut decisions);
        emit_group_changes(&context(3), &mut table, &mut decisions);
        assert_eq!(kinds(&decisions), [(EventKind::Merge, 2)], "once");
        assert!(table.groups().has_group_of(&[a, b]));

        let parts = [(a, pair[0]), (b, pair[1])].map(|(id, (bbox, colour))| {
            let detection = detection(bbox, colour);
            SplitPart { blob: blob_of(&context(5), &detection), members: vec![id], detection }
        });
        table.split_blobs(&[0], parts.into());
        table.drop_empty_blobs();
        emit_group_changes(&context(5), &mut table, &mut decisions);
        emit_group_changes(&context(6), &mut table, &mut decisions);
        assert_eq!(kinds(&decisions), [(EventKind::Merge, 2), (EventKind::Demerge, 5)]);
        assert_eq!(decisions.events[1].pieces, [[1], [2]]);
        assert!(!table.groups().has_group_of(&[a, b]));
        assert_eq!(table.check(), None);
    }

    #[test]
    fn a_merge_comes_a_frame_after_another_event_that_excludes_it() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let pair = [(person(100.0, 80.0), RED), (person(118.0, 80.0), BLUE)];
        let [a, _] =
            pair.map(|(bbox, colour)| start_confirmed(&context(1), &mut table, bbox, colour, [0.0; 2]));
        table.get_mut(a).unwrap().last_event = Some((2, EventKind::Merge));
        let shared = shared_detection(&pair);
        table.merge_blobs(&[0, 1], blob_of(&context(2), &shared), shared);
        table.drop_empty_blobs();
        emit_group_changes(&context(2), &mut table, &mut decisions);
        assert_eq!(kinds(&decisions), []);
        emit_group_changes(&context(3), &mut table, &mut decisions);
        assert_eq!(kinds(&decisions), [(EventKind::Merge, 3)]);
    }
}
