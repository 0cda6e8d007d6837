//! Occlusion groups according to the emitted events. Merges and demerges are the difference between these and the
//! regions of a frame; they are made here only.

use std::collections::{BTreeMap, BTreeSet};

use super::demerges::PendingDemerge;
use super::event::{Event, EventKind, Evidence};
use super::tracker::{ObjectId, Tracker};

/// When, where and why an object joined or left a group.
#[derive(Clone, Debug)]
pub(super) struct GroupChange {
    /// The first frame of the change.
    pub(super) frame: u32,
    /// Where, in pixels.
    pub(super) at: [f32; 2],
    pub(super) evidence: Evidence,
}

/// The occlusion groups according to the emitted events.
#[derive(Clone, Debug, Default)]
pub(super) struct OcclusionGroups {
    /// The members of each, two at least.
    emitted: Vec<BTreeSet<ObjectId>>,
    /// Causes of objects' merges and demerges, by object, until the event is emitted.
    joined: BTreeMap<ObjectId, GroupChange>,
    left: BTreeMap<ObjectId, GroupChange>,
}

impl OcclusionGroups {
    /// Records why an object joined the region of others.
    pub(super) fn record_joining(&mut self, id: ObjectId, cause: GroupChange) {
        self.joined.insert(id, cause);
    }

    /// Records why an object left the region of others.
    pub(super) fn record_leaving(&mut self, id: ObjectId, cause: GroupChange) {
        self.left.insert(id, cause);
    }

    /// The group of an object according to the events so far, the object included.
    fn group_of(&self, id: ObjectId) -> BTreeSet<ObjectId> {
        self.emitted.iter().find(|group| group.contains(&id)).cloned().unwrap_or_else(|| BTreeSet::from([id]))
    }

    fn share_group(&self, members: &[ObjectId]) -> bool {
        self.emitted.iter().any(|group| members.iter().all(|id| group.contains(id)))
    }

    /// Number of retained objects and causes.
    pub(super) fn len(&self) -> usize {
        self.emitted.iter().map(BTreeSet::len).sum::<usize>() + self.joined.len() + self.left.len()
    }

    fn leave(&mut self, id: ObjectId) {
        for group in &mut self.emitted {
            group.remove(&id);
        }
        self.emitted.retain(|group| group.len() > 1);
        self.joined.remove(&id);
        self.left.remove(&id);
    }
}

/// `members` grouped by place, those without a place together. Places are in the order of their first member.
fn partition_by(
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
fn partition(members: &BTreeSet<ObjectId>, place: impl Fn(ObjectId) -> Option<usize>) -> Vec<Vec<ObjectId>> {
    partition_by(members, place).into_iter().map(|(_, part)| part).collect()
}

impl Tracker {
    /// Emits an event of some objects. Its frame comes after all emitted events of them and their groups, and is put
    /// off to the next frame where it could not have happened after those.
    pub(super) fn emit_event(&mut self, ids: &[ObjectId], event: Event) {
        let frame = self.earliest_frame(ids, event.frame, event.kind).min(self.number);
        for id in self.with_group_members(ids) {
            if let Some(object) = self.objects.get_mut(&id) {
                object.last_event = object.last_event.max(Some((frame, event.kind)));
            }
        }
        self.events.push(Event { frame, ..event });
    }

    /// The first frame from `frame` on in which an event of `kind` can have happened to these objects.
    fn earliest_frame(&self, ids: &[ObjectId], frame: u32, kind: EventKind) -> u32 {
        let told =
            self.with_group_members(ids).into_iter().filter_map(|id| self.objects.get(&id)?.last_event);
        let after = told.map(|(told, before)| if kind.may_follow(before) { told } else { told + 1 });
        after.fold(frame, u32::max)
    }

    /// Objects and all members of their groups according to the emitted events.
    fn with_group_members(&self, ids: &[ObjectId]) -> BTreeSet<ObjectId> {
        ids.iter().flat_map(|&id| self.groups.group_of(id)).collect()
    }

    /// Whether an object can exit in this frame according to its emitted events.
    pub(super) fn can_leave(&self, id: ObjectId) -> bool {
        self.earliest_frame(&[id], self.number, EventKind::Exit) <= self.number
    }

    /// Removes an object from its group that exited, was occluded, or ended.
    pub(super) fn leave_group(&mut self, id: ObjectId) {
        self.groups.leave(id);
    }

    /// Emits the merges and demerges since the previous frame. Demerges that wait in `splits` are emitted
    /// from there.
    pub(super) fn emit_group_changes(&mut self) {
        while let Some(id) = self.with_changed_partition() {
            self.settle_demerges_of(id);
        }
        self.emit_immediate_demerges();
        // An object that joins another group has left, or rejoined, the groups of its pending demerges.
        for id in self.newly_sharing_region().concat() {
            self.settle_demerges_of(id);
            self.emit_reappearance(id);
        }
        self.emit_immediate_demerges();
        for members in self.newly_sharing_region() {
            self.emit_merge(&members);
        }
        self.groups.joined.retain(|_, cause| cause.frame >= self.number);
        self.groups.left.retain(|_, cause| cause.frame >= self.number);
    }

    /// A member of a pending demerge whose partition no longer holds.
    fn with_changed_partition(&self) -> Option<ObjectId> {
        let stands = |demerge: &PendingDemerge| {
            let members: BTreeSet<ObjectId> = demerge.members.iter().copied().collect();
            partition(&members, |id| self.blob_of(id))
                == partition(&members, |id| demerge.region_of_member(id))
        };
        self.pending_demerges
            .iter()
            .find(|demerge| !stands(demerge))
            .and_then(|demerge| demerge.members.first().copied())
    }

    fn blob_of(&self, id: ObjectId) -> Option<usize> {
        self.blobs.iter().position(|tracked| tracked.members.contains(&id))
    }

    /// The confirmed members of each region that are not yet in one group according to the emitted events.
    fn newly_sharing_region(&self) -> Vec<Vec<ObjectId>> {
        let shared = self.blobs.iter().map(|tracked| -> Vec<ObjectId> {
            tracked.members.iter().copied().filter(|&id| self.is_confirmed(id)).collect()
        });
        shared.filter(|members| members.len() > 1 && !self.groups.share_group(members)).collect()
    }

    /// Emits at once the demerges of members in several regions that have no pending demerge.
    fn emit_immediate_demerges(&mut self) {
        let waits = |group: &BTreeSet<ObjectId>| {
            let in_group =
                |demerge: &PendingDemerge| demerge.members.iter().filter(|id| group.contains(id)).count();
            self.pending_demerges.iter().any(|demerge| in_group(demerge) > 1)
        };
        let open: Vec<BTreeSet<ObjectId>> =
            self.groups.emitted.iter().filter(|group| !waits(group)).cloned().collect();
        for members in open {
            let pieces = partition(&members, |id| self.blob_of(id));
            if pieces.len() < 2 {
                continue;
            }
            let noted = members.iter().find_map(|id| self.groups.left.get(id)).cloned();
            let cause = noted.unwrap_or_else(|| {
                let boxes = members.iter().filter_map(|id| Some(self.objects.get(id)?.last_detection.bbox));
                let around = boxes.reduce(|a, b| a.union(&b)).unwrap_or_default();
                let branch =
                    format!("{} objects of one region are now in {} regions", members.len(), pieces.len());
                GroupChange { frame: self.number, at: around.centre(), evidence: Evidence::of_branch(branch) }
            });
            self.emit_demerge(&pieces, &cause);
        }
    }

    /// Emits the demerge of members of one group that are in several `pieces`.
    pub(super) fn emit_demerge(&mut self, pieces: &[Vec<ObjectId>], cause: &GroupChange) {
        for group in self.groups.emitted.clone() {
            let mut parts = partition_by(&group, |id| pieces.iter().position(|piece| piece.contains(&id)));
            parts.sort();
            let members: Vec<ObjectId> = group.iter().copied().collect();
            let frame = self.earliest_frame(&members, cause.frame, EventKind::Demerge);
            if parts.len() < 2 || frame > self.number {
                continue;
            }
            let alone: Vec<ObjectId> =
                parts.iter().filter(|(_, part)| part.len() == 1).flat_map(|(_, part)| part.clone()).collect();
            let objects = self.identities(&members);
            let event = Event {
                frame,
                kind: EventKind::Demerge,
                becomes: if alone.is_empty() { objects.clone() } else { self.identities(&alone) },
                objects,
                pieces: parts.iter().map(|(_, part)| self.identities(part)).collect(),
                x: cause.at[0],
                y: cause.at[1],
                front: None,
                evidence: cause.evidence.clone(),
            };
            self.emit_event(&members, event);
            self.groups.emitted.retain(|other| *other != group);
            let rest = parts.into_iter().filter(|(_, part)| part.len() > 1);
            self.groups.emitted.extend(rest.map(|(_, part)| part.into_iter().collect::<BTreeSet<_>>()));
        }
    }

    /// Emits the merge of objects that share a region.
    fn emit_merge(&mut self, members: &[ObjectId]) {
        // One of these objects has a pending demerge with others.
        let parted = !self.with_group_members(members).iter().all(|id| members.contains(id));
        if parted || self.earliest_frame(members, self.number, EventKind::Merge) > self.number {
            return;
        }
        let noted = members.iter().find_map(|id| self.groups.joined.get(id)).cloned();
        let cause = noted.unwrap_or_else(|| {
            let shared = self.blob_of(members.first().copied().unwrap_or_default());
            let blob = shared.and_then(|index| self.blobs.get(index)).map(|tracked| tracked.blob.bbox);
            let at = blob.unwrap_or_default().centre();
            let branch = format!("{} objects share one region", members.len());
            GroupChange { frame: self.number, at, evidence: Evidence::of_branch(branch) }
        });
        let identities = self.identities(members);
        let event = Event {
            frame: self.number,
            kind: EventKind::Merge,
            objects: identities.clone(),
            becomes: identities,
            pieces: Vec::new(),
            x: cause.at[0],
            y: cause.at[1],
            front: None,
            evidence: cause.evidence,
        };
        self.emit_event(members, event);
        self.groups.emitted.retain(|group| !group.iter().any(|id| members.contains(id)));
        self.groups.emitted.push(members.iter().copied().collect());
    }
}
