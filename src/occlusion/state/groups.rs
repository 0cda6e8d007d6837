//! Occlusion groups according to the emitted events.

use std::collections::{BTreeMap, BTreeSet};

use crate::occlusion::event::Evidence;
use crate::tracking::ObjectId;

/// When, where and why an object joined or left a group.
#[derive(Clone, Debug)]
pub(crate) struct GroupChange {
    /// The first frame of the change.
    pub(crate) frame: u32,
    /// Where, in pixels.
    pub(crate) at: [f32; 2],
    pub(crate) evidence: Evidence,
}

/// The occlusion groups according to the emitted events, and the causes of the next events.
#[derive(Clone, Debug, Default)]
pub(crate) struct OcclusionGroups {
    /// The members of each, two at least; no object is in two.
    emitted: Vec<BTreeSet<ObjectId>>,
    /// Causes of objects' merges and demerges, by object, until the event is emitted.
    joined: BTreeMap<ObjectId, GroupChange>,
    left: BTreeMap<ObjectId, GroupChange>,
}

impl OcclusionGroups {
    /// The members of each group.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &BTreeSet<ObjectId>> {
        self.emitted.iter()
    }

    /// Records why an object joined the region of others.
    pub(crate) fn record_joining(&mut self, id: ObjectId, cause: GroupChange) {
        self.joined.insert(id, cause);
    }

    /// Records why an object left the region of others.
    pub(crate) fn record_leaving(&mut self, id: ObjectId, cause: GroupChange) {
        self.left.insert(id, cause);
    }

    /// The recorded cause of joining of the first of these objects that has one.
    pub(crate) fn cause_of_joining(&self, ids: &[ObjectId]) -> Option<&GroupChange> {
        ids.iter().find_map(|id| self.joined.get(id))
    }

    /// The recorded cause of leaving of the first member of a group that has one.
    pub(crate) fn cause_of_leaving(&self, group: &BTreeSet<ObjectId>) -> Option<&GroupChange> {
        group.iter().find_map(|id| self.left.get(id))
    }

    /// Drops the causes of earlier frames than this.
    pub(crate) fn drop_causes_before(&mut self, frame: u32) {
        self.joined.retain(|_, cause| cause.frame >= frame);
        self.left.retain(|_, cause| cause.frame >= frame);
    }

    /// The group of an object according to the events so far, the object included.
    pub(super) fn group_of(&self, id: ObjectId) -> BTreeSet<ObjectId> {
        self.iter().find(|group| group.contains(&id)).cloned().unwrap_or_else(|| BTreeSet::from([id]))
    }

    /// Objects and all members of their groups.
    pub(crate) fn with_group_members(&self, ids: &[ObjectId]) -> BTreeSet<ObjectId> {
        ids.iter().flat_map(|&id| self.group_of(id)).collect()
    }

    /// Whether one group has all of these members.
    pub(crate) fn has_group_of(&self, members: &[ObjectId]) -> bool {
        self.iter().any(|group| members.iter().all(|id| group.contains(id)))
    }

    /// Makes one group of these members; the groups that they were in end.
    pub(crate) fn merge(&mut self, members: &[ObjectId]) {
        self.emitted.retain(|group| !group.iter().any(|id| members.contains(id)));
        self.emitted.push(members.iter().copied().collect());
    }

    /// Replaces a group by those of its parts that have several members.
    pub(crate) fn split(
        &mut self,
        group: &BTreeSet<ObjectId>,
        parts: impl IntoIterator<Item = Vec<ObjectId>>,
    ) {
        self.emitted.retain(|other| other != group);
        let rest = parts.into_iter().filter(|part| part.len() > 1);
        self.emitted.extend(rest.map(|part| part.into_iter().collect::<BTreeSet<_>>()));
    }

    /// Removes an object from its group.
    pub(crate) fn leave(&mut self, id: ObjectId) {
        for group in &mut self.emitted {
            group.remove(&id);
        }
        self.emitted.retain(|group| group.len() > 1);
        self.joined.remove(&id);
        self.left.remove(&id);
    }

    /// Number of retained objects and causes.
    pub(crate) fn len(&self) -> usize {
        self.iter().map(BTreeSet::len).sum::<usize>() + self.joined.len() + self.left.len()
    }
}

/// `members` grouped by place, those without a place together. Places are in the order of their first member.
pub(crate) fn partition_by(
    members: &BTreeSet<ObjectId>,
    place: impl Fn(ObjectId) -> Option<usize>,
) -> Vec<(Option<usize>, Vec<ObjectId>)> {
    let mut parts: Vec<(Option<usize>, Vec<ObjectId>)> = Vec::new();
    for &id in members {
        let at = place(id);
        match parts.iter_mut().find(|(known, _)| *known == at) {
            Some((_, part)) => part.push(id),
            None => parts.push((at, vec![id])),
        }
    }
    parts
}

/// The groups of [`partition_by`] without their places.
pub(crate) fn partition(
    members: &BTreeSet<ObjectId>,
    place: impl Fn(ObjectId) -> Option<usize>,
) -> Vec<Vec<ObjectId>> {
    partition_by(members, place).into_iter().map(|(_, part)| part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_kept_from_a_frame_on() {
        let mut groups = OcclusionGroups::default();
        let cause = |frame: u32| GroupChange { frame, at: [0.0; 2], evidence: Evidence::of_branch("some") };
        for (id, frame) in [(1, 4), (2, 5), (3, 6)] {
            groups.record_joining(id, cause(frame));
            groups.record_leaving(id + 10, cause(frame));
        }
        groups.drop_causes_before(5);
        let joined = [1, 2, 3].map(|id| groups.cause_of_joining(&[id]).is_some());
        let left = [11, 12, 13].map(|id| groups.cause_of_leaving(&BTreeSet::from([id])).is_some());
        assert_eq!((joined, left), ([false, true, true], [false, true, true]));
    }
}
