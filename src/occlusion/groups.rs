//! Which objects stand together in one region, as the events have it. Merges and demerges are the difference between
//! that and what a frame shows, and are made here alone.

use std::collections::{BTreeMap, BTreeSet};

use super::event::{Event, EventKind, Evidence};
use super::reasoner::{ObjectId, Reasoner};
use super::splits::Split;

/// Why an object is with others, or no longer.
#[derive(Clone, Debug)]
pub(super) struct Cause {
    /// The first frame in which it was there.
    pub(super) frame: u32,
    /// Where, in pixels.
    pub(super) at: [f32; 2],
    pub(super) evidence: Evidence,
}

/// The occlusion groups that the events tell of.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    /// The members of each, two at least.
    told: Vec<BTreeSet<ObjectId>>,
    /// Causes of objects' merges and demerges, by object, until the event is emitted.
    joined: BTreeMap<ObjectId, Cause>,
    left: BTreeMap<ObjectId, Cause>,
}

impl Groups {
    /// Notes why an object is in the region of others.
    pub(super) fn note_joining(&mut self, id: ObjectId, cause: Cause) {
        self.joined.insert(id, cause);
    }

    /// Notes why an object is no longer in the region of others.
    pub(super) fn note_leaving(&mut self, id: ObjectId, cause: Cause) {
        self.left.insert(id, cause);
    }

    /// The group of an object according to the events so far, the object included.
    fn with(&self, id: ObjectId) -> BTreeSet<ObjectId> {
        self.told.iter().find(|group| group.contains(&id)).cloned().unwrap_or_else(|| BTreeSet::from([id]))
    }

    fn are_together(&self, members: &[ObjectId]) -> bool {
        self.told.iter().any(|group| members.iter().all(|id| group.contains(id)))
    }

    /// How many objects something is known of.
    pub(super) fn len(&self) -> usize {
        self.told.iter().map(BTreeSet::len).sum::<usize>() + self.joined.len() + self.left.len()
    }

    fn leave(&mut self, id: ObjectId) {
        for group in &mut self.told {
            group.remove(&id);
        }
        self.told.retain(|group| group.len() > 1);
        self.joined.remove(&id);
        self.left.remove(&id);
    }
}

/// `members` by the place at which each is, those at no place together. Places come in the order of their first member.
fn by_place(
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

/// Those of `members` who are at one place, in the order of their first.
fn parts(members: &BTreeSet<ObjectId>, place: impl Fn(ObjectId) -> Option<usize>) -> Vec<Vec<ObjectId>> {
    by_place(members, place).into_iter().map(|(_, part)| part).collect()
}

impl Reasoner {
    /// Tells what happened to some objects: after all that has been told of them and their groups, so that it is put off
    /// to the next frame where it could not have happened after that.
    pub(super) fn push_event(&mut self, ids: &[ObjectId], event: Event) {
        let frame = self.frame_after(ids, event.frame, event.kind).min(self.number);
        for id in self.concerned(ids) {
            if let Some(object) = self.objects.get_mut(&id) {
                object.told = object.told.max(Some((frame, event.kind)));
            }
        }
        self.events.push(Event { frame, ..event });
    }

    /// The first frame from `frame` on in which something of `kind` can have happened to these.
    fn frame_after(&self, ids: &[ObjectId], frame: u32, kind: EventKind) -> u32 {
        let told = self.concerned(ids).into_iter().filter_map(|id| self.objects.get(&id)?.told);
        let after = told.map(|(told, before)| if kind.may_follow(before) { told } else { told + 1 });
        after.fold(frame, u32::max)
    }

    /// Objects, and all who are together with them by what the events say.
    fn concerned(&self, ids: &[ObjectId]) -> BTreeSet<ObjectId> {
        ids.iter().flat_map(|&id| self.groups.with(id)).collect()
    }

    /// Whether an object can have left in this frame by what has been told of it.
    pub(super) fn can_leave(&self, id: ObjectId) -> bool {
        self.frame_after(&[id], self.number, EventKind::Exit) <= self.number
    }

    /// Takes an object out of its group that left the image, was hidden, or ended.
    pub(super) fn leave_group(&mut self, id: ObjectId) {
        self.groups.leave(id);
    }

    /// Emits the merges and demerges since the previous frame. Demerges that wait in `splits` are emitted
    /// from there.
    pub(super) fn follow_groups(&mut self) {
        while let Some(id) = self.with_another_parting() {
            self.settle_splits_of(id);
        }
        self.tell_partings();
        // An object that joins another group has left, or rejoined, the groups of its open splits.
        for id in self.newly_together().concat() {
            self.settle_splits_of(id);
            self.tell_return_of(id);
        }
        self.tell_partings();
        for members in self.newly_together() {
            self.tell_meeting(&members);
        }
        self.groups.joined.retain(|_, cause| cause.frame >= self.number);
        self.groups.left.retain(|_, cause| cause.frame >= self.number);
    }

    /// An object of a split whose partition no longer holds.
    fn with_another_parting(&self) -> Option<ObjectId> {
        let stands = |split: &Split| {
            let members: BTreeSet<ObjectId> = split.members.iter().copied().collect();
            parts(&members, |id| self.blob_of(id)) == parts(&members, |id| split.piece(id))
        };
        self.splits.iter().find(|split| !stands(split)).and_then(|split| split.members.first().copied())
    }

    fn blob_of(&self, id: ObjectId) -> Option<usize> {
        self.carried.iter().position(|carried| carried.members.contains(&id))
    }

    /// The members of each region who are not all together yet by what the events say.
    fn newly_together(&self) -> Vec<Vec<ObjectId>> {
        let shared = self.carried.iter().map(|carried| -> Vec<ObjectId> {
            carried.members.iter().copied().filter(|&id| self.is_named(id)).collect()
        });
        shared.filter(|members| members.len() > 1 && !self.groups.are_together(members)).collect()
    }

    /// Tells at once of members who are in several regions without a split that waits.
    fn tell_partings(&mut self) {
        let waits = |group: &BTreeSet<ObjectId>| {
            let in_group = |split: &Split| split.members.iter().filter(|id| group.contains(id)).count();
            self.splits.iter().any(|split| in_group(split) > 1)
        };
        let open: Vec<BTreeSet<ObjectId>> =
            self.groups.told.iter().filter(|group| !waits(group)).cloned().collect();
        for members in open {
            let pieces = parts(&members, |id| self.blob_of(id));
            if pieces.len() < 2 {
                continue;
            }
            let noted = members.iter().find_map(|id| self.groups.left.get(id)).cloned();
            let cause = noted.unwrap_or_else(|| {
                let boxes = members.iter().filter_map(|id| Some(self.objects.get(id)?.last.bbox));
                let around = boxes.reduce(|a, b| a.union(&b)).unwrap_or_default();
                let branch =
                    format!("{} objects of one region are now in {} regions", members.len(), pieces.len());
                Cause { frame: self.number, at: around.centre(), evidence: Evidence::of_branch(branch) }
            });
            self.tell_parting(&pieces, &cause);
        }
    }

    /// The demerge of those who were together and are in several `pieces`.
    pub(super) fn tell_parting(&mut self, pieces: &[Vec<ObjectId>], cause: &Cause) {
        for group in self.groups.told.clone() {
            let mut parts = by_place(&group, |id| pieces.iter().position(|piece| piece.contains(&id)));
            parts.sort();
            let members: Vec<ObjectId> = group.iter().copied().collect();
            let frame = self.frame_after(&members, cause.frame, EventKind::Demerge);
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
            self.push_event(&members, event);
            self.groups.told.retain(|other| *other != group);
            let rest = parts.into_iter().filter(|(_, part)| part.len() > 1);
            self.groups.told.extend(rest.map(|(_, part)| part.into_iter().collect::<BTreeSet<_>>()));
        }
    }

    /// The merge of those who share a region now.
    fn tell_meeting(&mut self, members: &[ObjectId]) {
        // One of these objects has an open split with others.
        let parted = !self.concerned(members).iter().all(|id| members.contains(id));
        if parted || self.frame_after(members, self.number, EventKind::Merge) > self.number {
            return;
        }
        let noted = members.iter().find_map(|id| self.groups.joined.get(id)).cloned();
        let cause = noted.unwrap_or_else(|| {
            let shared = self.blob_of(members.first().copied().unwrap_or_default());
            let blob = shared.and_then(|index| self.carried.get(index)).map(|carried| carried.blob.bbox);
            let at = blob.unwrap_or_default().centre();
            let branch = format!("{} objects share one region", members.len());
            Cause { frame: self.number, at, evidence: Evidence::of_branch(branch) }
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
        self.push_event(members, event);
        self.groups.told.retain(|group| !group.iter().any(|id| members.contains(id)));
        self.groups.told.push(members.iter().copied().collect());
    }
}
