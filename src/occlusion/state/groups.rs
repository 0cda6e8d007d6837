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
    /// The members of each, two at least, under rising numbers in the order in which the groups began.
    emitted: BTreeMap<u64, BTreeSet<ObjectId>>,
    /// The number of each member's group; no object is in two.
    number_of: BTreeMap<ObjectId, u64>,
    last_number: u64,
    /// Causes of objects' merges and demerges, by object, until the event is emitted.
    joined: BTreeMap<ObjectId, GroupChange>,
    left: BTreeMap<ObjectId, GroupChange>,
}

impl OcclusionGroups {
    /// The members of each group.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &BTreeSet<ObjectId>> {
        self.emitted.values()
    }

    /// Those of any of these objects, in the order in which they began.
    pub(crate) fn of_any<'a>(&self, ids: impl IntoIterator<Item = &'a ObjectId>) -> Vec<BTreeSet<ObjectId>> {
        let numbers: BTreeSet<u64> =
            ids.into_iter().filter_map(|id| self.number_of.get(id)).copied().collect();
        numbers.iter().filter_map(|number| self.emitted.get(number)).cloned().collect()
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

    /// The group of an object according to the events so far, `None` while it is alone.
    fn group_of(&self, id: ObjectId) -> Option<&BTreeSet<ObjectId>> {
        self.emitted.get(self.number_of.get(&id)?)
    }

    /// Objects and all members of their groups.
    pub(crate) fn with_group_members(&self, ids: &[ObjectId]) -> BTreeSet<ObjectId> {
        let mut all: BTreeSet<ObjectId> = ids.iter().copied().collect();
        all.extend(ids.iter().filter_map(|&id| self.group_of(id)).flatten());
        all
    }

    /// Whether one group has all of these members.
    pub(crate) fn has_group_of(&self, members: &[ObjectId]) -> bool {
        let group = members.first().and_then(|&id| self.group_of(id));
        group.is_some_and(|group| members.iter().all(|id| group.contains(id)))
    }

    /// Makes one group of these members; the groups that they were in end.
    pub(crate) fn merge(&mut self, members: &[ObjectId]) {
        for id in members {
            if let Some(&number) = self.number_of.get(id) {
                self.end(number);
            }
        }
        self.begin(members.iter().copied().collect());
    }

    /// Replaces a group by those of its parts that have several members.
    pub(crate) fn split(
        &mut self,
        group: &BTreeSet<ObjectId>,
        parts: impl IntoIterator<Item = Vec<ObjectId>>,
    ) {
        if let Some(&number) = group.first().and_then(|id| self.number_of.get(id)) {
            self.end(number);
        }
        for part in parts.into_iter().filter(|part| part.len() > 1) {
            self.begin(part.into_iter().collect());
        }
    }

    /// Removes an object from its group, which ends with its last but one.
    pub(crate) fn leave(&mut self, id: ObjectId) {
        if let Some(number) = self.number_of.remove(&id)
            && let Some(group) = self.emitted.get_mut(&number)
        {
            group.remove(&id);
            if group.len() < 2 {
                self.end(number);
            }
        }
        self.joined.remove(&id);
        self.left.remove(&id);
    }

    fn begin(&mut self, members: BTreeSet<ObjectId>) {
        self.last_number += 1;
        self.number_of.extend(members.iter().map(|&id| (id, self.last_number)));
        self.emitted.insert(self.last_number, members);
    }

    fn end(&mut self, number: u64) {
        for id in self.emitted.remove(&number).unwrap_or_default() {
            self.number_of.remove(&id);
        }
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
    fn an_object_is_in_the_group_of_the_last_event_of_it() {
        let mut groups = OcclusionGroups::default();
        let all = |groups: &OcclusionGroups| groups.iter().cloned().map(Vec::from_iter).collect::<Vec<_>>();
        groups.merge(&[1, 2]);
        groups.merge(&[3, 4, 5]);
        assert_eq!(all(&groups), [vec![1, 2], vec![3, 4, 5]]);
        assert_eq!(Vec::from_iter(groups.with_group_members(&[2, 7])), [1, 2, 7]);
        assert!(groups.has_group_of(&[5, 3]) && !groups.has_group_of(&[2, 3]) && !groups.has_group_of(&[7]));

        groups.merge(&[2, 3, 6, 8]);
        assert_eq!(all(&groups), [[2, 3, 6, 8]], "the groups before it have ended");
        assert!(groups.of_any(&[1, 4]).is_empty());
        groups.split(&[2, 3, 6, 8].into(), [vec![2, 6], vec![3], vec![8]]);
        assert_eq!(groups.of_any(&[3, 6, 2]), [[2, 6].into()]);
        groups.leave(6);
        assert_eq!(all(&groups), [] as [Vec<ObjectId>; 0], "one alone is no group");
        assert!(groups.of_any(&[2]).is_empty());
    }

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
