//! The objects of a video: where each is, and who they are.
//!
//! An object is in exactly one place: alone in a blob, a member of a blob with others (an occlusion group), or
//! occluded. Only the methods of [`ObjectTable`] move and remove objects, and each keeps that; `check` states it in
//! full.

use std::collections::{BTreeMap, BTreeSet};

use super::context::FrameRef;
use super::groups::OcclusionGroups;
use super::object::{Detection, Object};
use crate::tracking::pool::Blob;
use crate::tracking::{Identity, IdentityMap, ObjectId};

/// Identities of ended objects are dropped once they exceed those of live objects by this many.
const MIN_PRUNED_IDENTITIES: usize = 64;

/// A blob and its members: one object, or the objects of an occlusion group.
#[derive(Clone, Debug)]
pub(crate) struct TrackedBlob {
    pub(crate) blob: Blob,
    /// Index of the detection that the pool's joint matching assigns to it in this frame.
    pub(crate) matched: Option<usize>,
    /// Its detection in this frame, `None` while it is lost.
    pub(crate) detection: Option<Detection>,
    /// The first frame without a region, `None` while it has one.
    pub(crate) lost_from: Option<FrameRef>,
    /// Consecutive frames in which its region was larger than all its members together by `MAX_AREA_RATIO`.
    pub(crate) oversized: u32,
    /// By rising number; several while they share the region.
    members: Vec<ObjectId>,
}

impl TrackedBlob {
    const fn new(blob: Blob, members: Vec<ObjectId>, detection: Detection) -> Self {
        Self { blob, matched: None, members, detection: Some(detection), lost_from: None, oversized: 0 }
    }

    /// The members by rising number.
    pub(crate) fn members(&self) -> &[ObjectId] {
        &self.members
    }

    /// Its only member, `None` where there are several.
    pub(crate) fn only_member(&self) -> Option<ObjectId> {
        match self.members[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// Whether it has several members.
    pub(crate) fn is_shared(&self) -> bool {
        self.members.len() > 1
    }

    /// The visible share of a member in its region, 1 while it has no detection.
    pub(crate) fn visible_share_of(&self, member: &Object) -> f32 {
        self.detection.as_ref().map_or(1.0, |detection| member.visible_share_in(detection))
    }
}

/// An object that the scene occludes: the paper's past object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OccludedObject {
    pub(crate) id: ObjectId,
    /// The first frame without a region.
    pub(crate) since: FrameRef,
}

/// A blob that stands for a part of a group's region after a split.
#[derive(Clone, Debug)]
pub(crate) struct SplitPart {
    pub(crate) blob: Blob,
    pub(crate) members: Vec<ObjectId>,
    pub(crate) detection: Detection,
}

/// The objects by number. Only the table adds and removes some.
#[derive(Clone, Debug, Default)]
pub(crate) struct Objects(BTreeMap<ObjectId, Object>);

impl Objects {
    /// An object, `None` after its end.
    pub(crate) fn get(&self, id: ObjectId) -> Option<&Object> {
        self.0.get(&id)
    }

    /// An object to be changed, `None` after its end.
    pub(crate) fn get_mut(&mut self, id: ObjectId) -> Option<&mut Object> {
        self.0.get_mut(&id)
    }
}

/// All objects that are followed, their blobs, groups and identities.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectTable {
    objects: Objects,
    blobs: Vec<TrackedBlob>,
    occluded: Vec<OccludedObject>,
    groups: OcclusionGroups,
    identities: IdentityMap,
    last_id: ObjectId,
}

impl ObjectTable {
    /// An object, `None` after its end.
    pub(crate) fn get(&self, id: ObjectId) -> Option<&Object> {
        self.objects.get(id)
    }

    /// An object to be changed, `None` after its end.
    pub(crate) fn get_mut(&mut self, id: ObjectId) -> Option<&mut Object> {
        self.objects.get_mut(id)
    }

    /// Whether an object has not ended.
    pub(crate) fn contains(&self, id: ObjectId) -> bool {
        self.objects.0.contains_key(&id)
    }

    /// All objects by rising number.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (ObjectId, &Object)> {
        self.objects.0.iter().map(|(&id, object)| (id, object))
    }

    /// All objects to be changed, by rising number.
    pub(crate) fn objects_mut(&mut self) -> impl Iterator<Item = &mut Object> {
        self.objects.0.values_mut()
    }

    /// The objects with these numbers, in order.
    pub(crate) fn objects_of<'a>(&'a self, ids: &'a [ObjectId]) -> impl Iterator<Item = &'a Object> + Clone {
        ids.iter().filter_map(|&id| self.objects.get(id))
    }

    /// The blobs, the oldest first.
    pub(crate) fn blobs(&self) -> &[TrackedBlob] {
        &self.blobs
    }

    /// The blobs to be changed, except their members.
    pub(crate) fn blobs_mut(&mut self) -> impl Iterator<Item = &mut TrackedBlob> {
        self.blobs.iter_mut()
    }

    /// The blobs with their objects, both to be changed.
    pub(crate) fn blobs_and_objects(&mut self) -> (&mut [TrackedBlob], &mut Objects) {
        (&mut self.blobs, &mut self.objects)
    }

    /// The blob at an index.
    pub(crate) fn blob(&self, index: usize) -> Option<&TrackedBlob> {
        self.blobs.get(index)
    }

    /// The blob at an index to be changed, except its members.
    pub(crate) fn blob_mut(&mut self, index: usize) -> Option<&mut TrackedBlob> {
        self.blobs.get_mut(index)
    }

    /// The blobs at these indices.
    pub(crate) fn blobs_at<'a>(&'a self, indices: &'a [usize]) -> impl Iterator<Item = &'a TrackedBlob> {
        indices.iter().filter_map(|&index| self.blobs.get(index))
    }

    /// The members of the blobs at these indices, by rising number.
    pub(crate) fn members_at(&self, indices: &[usize]) -> Vec<ObjectId> {
        let mut members: Vec<ObjectId> =
            self.blobs_at(indices).flat_map(|tracked| tracked.members.iter().copied()).collect();
        members.sort_unstable();
        members
    }

    /// The blobs with one member, each with that object.
    pub(crate) fn lone_objects(&self) -> impl Iterator<Item = (ObjectId, &Object, &TrackedBlob)> + Clone {
        self.blobs.iter().filter_map(|tracked| {
            let id = tracked.only_member()?;
            Some((id, self.objects.get(id)?, tracked))
        })
    }

    /// The index of the blob that an object is a member of; `None` while it is occluded.
    pub(crate) fn blob_of(&self, id: ObjectId) -> Option<usize> {
        self.blobs.iter().position(|tracked| tracked.members.contains(&id))
    }

    /// The occluded objects, in the order in which they were last occluded.
    pub(crate) fn occluded(&self) -> &[OccludedObject] {
        &self.occluded
    }

    /// The occlusion of an object, `None` while it is a member of a blob.
    pub(crate) fn occlusion_of(&self, id: ObjectId) -> Option<OccludedObject> {
        self.occluded.iter().copied().find(|occluded| occluded.id == id)
    }

    /// The groups according to the emitted events.
    pub(crate) const fn groups(&self) -> &OcclusionGroups {
        &self.groups
    }

    /// The groups to be changed by events.
    pub(crate) const fn groups_mut(&mut self) -> &mut OcclusionGroups {
        &mut self.groups
    }

    /// Whether an object is confirmed: it has an identity.
    pub(crate) fn is_confirmed(&self, id: ObjectId) -> bool {
        self.objects.get(id).is_some_and(|object| object.confirmed)
    }

    /// The identity of an object, also of an ended one that events can still refer to.
    pub(crate) fn identity(&self, id: ObjectId) -> Option<Identity> {
        self.identities.of(id)
    }

    /// The identities of some objects, by rising number.
    pub(crate) fn identities_of(&self, members: &[ObjectId]) -> Vec<Identity> {
        let mut identities: Vec<Identity> = members.iter().filter_map(|&id| self.identity(id)).collect();
        identities.sort_unstable();
        identities
    }

    /// The identities of all numbers: of objects and of their keys.
    pub(crate) const fn identity_map(&self) -> &IdentityMap {
        &self.identities
    }

    /// Takes the identities assigned since the previous call, in order.
    pub(crate) fn take_assigned_identities(&mut self) -> Vec<(ObjectId, Identity)> {
        self.identities.take_assigned()
    }

    /// The number of the next new object or key.
    const fn new_id(&mut self) -> ObjectId {
        self.last_id += 1;
        self.last_id
    }

    /// Starts a tentative object alone in a blob of its own. `object` gets its number.
    pub(crate) fn start_alone(
        &mut self,
        object: impl FnOnce(ObjectId) -> Object,
        blob: Blob,
        detection: Detection,
    ) -> ObjectId {
        let id = self.new_id();
        self.objects.0.insert(id, object(id));
        self.blobs.push(TrackedBlob::new(blob, vec![id], detection));
        id
    }

    /// Starts a tentative object as another member of the blob at an index. `object` gets its number. The caller
    /// confirms or merges it at once.
    pub(crate) fn start_in_blob(
        &mut self,
        index: usize,
        object: impl FnOnce(ObjectId) -> Object,
    ) -> Option<ObjectId> {
        let id = self.new_id();
        let tracked = self.blobs.get_mut(index)?;
        self.objects.0.insert(id, object(id));
        tracked.members.push(id);
        tracked.members.sort_unstable();
        Some(id)
    }

    /// Confirms an object under a new identity.
    pub(crate) fn confirm(&mut self, id: ObjectId) -> Option<Identity> {
        let object = self.objects.get_mut(id)?;
        object.confirmed = true;
        Some(self.identities.assign_new(id))
    }

    /// Ends an object: it is removed from its blob, its group and the occluded ones. A blob without members stays
    /// until [`Self::drop_empty_blobs`], so that indices of blobs stay valid.
    pub(crate) fn end_object(&mut self, id: ObjectId) -> Option<Object> {
        self.detach(id);
        self.groups.leave(id);
        self.objects.0.remove(&id)
    }

    /// Drops the blobs without members.
    pub(crate) fn drop_empty_blobs(&mut self) {
        self.blobs.retain(|tracked| !tracked.members.is_empty());
    }

    /// Marks an object as occluded; it leaves its blob and its group.
    pub(crate) fn occlude(&mut self, id: ObjectId, since: FrameRef) {
        if !self.contains(id) {
            return;
        }
        self.detach(id);
        self.groups.leave(id);
        self.occluded.push(OccludedObject { id, since });
    }

    /// Moves an object, occluded or a member of another blob, into the blob at an index. Gives its occlusion, if that
    /// ends.
    pub(crate) fn move_to_blob(&mut self, id: ObjectId, index: usize) -> Option<OccludedObject> {
        if !self.contains(id) || index >= self.blobs.len() {
            return None;
        }
        let occlusion = self.detach(id);
        if let Some(tracked) = self.blobs.get_mut(index) {
            tracked.members.push(id);
            tracked.members.sort_unstable();
        }
        occlusion
    }

    /// Merges the track of a new object into a known one, which takes the new one's place. Gives the known one's
    /// occlusion, if that ends.
    pub(crate) fn merge_track_into(&mut self, new: ObjectId, known: ObjectId) -> Option<OccludedObject> {
        if new == known || !self.contains(known) {
            return None;
        }
        let seen = self.objects.0.remove(&new)?;
        self.groups.leave(new);
        let occlusion = self.detach(known);
        let object = self.objects.get_mut(known)?;
        self.identities.link(seen.key, object.key);
        object.continue_as(seen);
        for tracked in &mut self.blobs {
            for member in tracked.members.iter_mut().filter(|member| **member == new) {
                *member = known;
            }
            tracked.members.sort_unstable();
        }
        occlusion
    }

    /// Gives the tracks of an ended object the identity of another key.
    pub(crate) fn link_ended_key(&mut self, ended: ObjectId, key: ObjectId) {
        self.identities.link(ended, key);
    }

    /// Moves all members of several blobs into the first of them, which gets a new motion model and detection. The
    /// others are left without members.
    pub(crate) fn merge_blobs(&mut self, blobs: &[usize], blob: Blob, detection: Detection) {
        let members = self.members_at(blobs);
        self.clear_members(blobs);
        if let Some(tracked) = blobs.first().and_then(|&first| self.blobs.get_mut(first)) {
            tracked.blob = blob;
            tracked.members = members;
            tracked.detection = Some(detection);
        }
    }

    /// Moves all members of these blobs into new ones, one for each part. The parts hold the same members together.
    pub(crate) fn split_blobs(&mut self, blobs: &[usize], parts: Vec<SplitPart>) {
        self.clear_members(blobs);
        let new = |part: SplitPart| TrackedBlob::new(part.blob, part.members, part.detection);
        self.blobs.extend(parts.into_iter().map(new));
    }

    /// Records the tracks of an object under a new key from now on, with the same identity.
    pub(crate) fn renew_key(&mut self, id: ObjectId) {
        let key = self.new_id();
        if let Some(object) = self.objects.get_mut(id) {
            self.identities.link(key, object.key);
            object.key = key;
        }
    }

    /// Swaps the places of members of blobs whose keys were renewed: each (key) takes the track key, motion, last
    /// detection and blob of another (value). Keys and values are the same objects.
    pub(crate) fn swap_places(&mut self, takes_place_of: &BTreeMap<ObjectId, ObjectId>) {
        if takes_place_of.iter().all(|(id, place)| id == place) {
            return;
        }
        let place = |id: &ObjectId| {
            let object = self.objects.get(*id)?;
            Some((*id, (object.key, object.model.clone(), object.last_detection.clone())))
        };
        let places: BTreeMap<_, _> = takes_place_of.values().filter_map(place).collect();
        for (id, place) in takes_place_of {
            if let (Some(object), Some((key, model, detection))) =
                (self.objects.get_mut(*id), places.get(place))
            {
                object.key = *key;
                object.model = model.clone();
                object.last_detection = detection.clone();
                if let Some(identity) = self.identities.of(*id) {
                    self.identities.set(*key, identity);
                }
            }
        }
        let takers: BTreeMap<ObjectId, ObjectId> =
            takes_place_of.iter().map(|(&id, &place)| (place, id)).collect();
        for tracked in &mut self.blobs {
            for member in &mut tracked.members {
                *member = takers.get(member).copied().unwrap_or(*member);
            }
            tracked.members.sort_unstable();
        }
    }

    /// Drops the identities of ended objects, once there are many; `is_needed` says which ones events can still refer
    /// to.
    pub(crate) fn prune_identities(&mut self, is_needed: impl Fn(ObjectId) -> bool) {
        // A live object counts twice: with its number and its key.
        if self.identities.len() <= 4 * self.objects.0.len() + MIN_PRUNED_IDENTITIES {
            return;
        }
        let keys: BTreeSet<ObjectId> = self.objects.0.values().map(|object| object.key).collect();
        let objects = &self.objects.0;
        self.identities.retain(|id| keys.contains(&id) || objects.contains_key(&id) || is_needed(id));
    }

    /// Number of retained items of all kinds.
    pub(crate) fn len(&self) -> usize {
        let places = self.objects.0.len() + self.blobs.len() + self.occluded.len();
        places + self.groups.len() + self.identities.len()
    }

    /// Removes an object from its blob and from the occluded ones; gives its occlusion.
    fn detach(&mut self, id: ObjectId) -> Option<OccludedObject> {
        for tracked in &mut self.blobs {
            tracked.members.retain(|member| *member != id);
        }
        let at = self.occluded.iter().position(|occluded| occluded.id == id)?;
        Some(self.occluded.remove(at))
    }

    fn clear_members(&mut self, blobs: &[usize]) {
        for &index in blobs {
            if let Some(tracked) = self.blobs.get_mut(index) {
                tracked.members.clear();
            }
        }
    }

    /// The first invariant that does not hold, in words; `None` where all hold, as they do after every frame.
    pub(crate) fn check(&self) -> Option<String> {
        let mut placed: Vec<ObjectId> = self.occluded.iter().map(|occluded| occluded.id).collect();
        for (index, tracked) in self.blobs.iter().enumerate() {
            if tracked.members.is_empty() {
                return Some(format!("blob {index} has no member"));
            }
            if !tracked.members.is_sorted() {
                return Some(format!("the members {:?} of blob {index} are not in order", tracked.members));
            }
            if tracked.is_shared() && !tracked.members.iter().all(|&id| self.is_confirmed(id)) {
                return Some(format!("a member of {:?} is not confirmed", tracked.members));
            }
            placed.extend(&tracked.members);
        }
        placed.sort_unstable();
        if !placed.iter().eq(self.objects.0.keys()) {
            let objects: Vec<&ObjectId> = self.objects.0.keys().collect();
            return Some(format!("objects {objects:?} are not each in one place: {placed:?}"));
        }
        if let Some(occluded) = self.occluded.iter().find(|occluded| !self.is_confirmed(occluded.id)) {
            return Some(format!("{} is occluded and not confirmed", occluded.id));
        }
        for (&id, object) in &self.objects.0 {
            let (identity, of_key) = (self.identity(id), self.identities.of(object.key));
            if object.confirmed != identity.is_some() || identity != of_key {
                return Some(format!("{id} has identity {identity:?}, its key {} {of_key:?}", object.key));
            }
            if !object.confirmed && object.key != id {
                return Some(format!("{id} is tentative and has the key {}", object.key));
            }
        }
        let mut grouped = BTreeSet::new();
        for group in self.groups.iter() {
            if group.len() < 2 || !group.iter().all(|&id| grouped.insert(id) && self.blob_of(id).is_some()) {
                return Some(format!(
                    "{group:?} is no group of members of blobs, or shares one with another"
                ));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use proptest::prelude::*;

    use super::*;
    use crate::occlusion::fixtures::{
        BLUE, RED, context, detection, object, person, start_confirmed, start_tentative,
    };

    const NOW: FrameRef = FrameRef { number: 1, index: 1, t: 1 };

    fn blob(detection: &Detection) -> Blob {
        Blob::new(object(&context(1), 0, detection, [0.0; 2]).model, &detection.observation())
    }

    /// Makes a move as the stages do: with the objects for which it is meant. `pick` chooses among those.
    fn make_move(table: &mut ObjectTable, kind: u8, pick: [usize; 2]) {
        let of = |ids: Vec<ObjectId>, pick: usize| ids.get(pick % ids.len().max(1)).copied();
        let ids =
            |confirmed: bool| table.iter().filter(|it| it.1.confirmed == confirmed).map(|it| it.0).collect();
        let (known, new): (Vec<ObjectId>, Vec<ObjectId>) = (ids(true), ids(false));
        let (a, b, new) = (of(known.clone(), pick[0]), of(known, pick[1]), of(new, pick[0]));
        let seen = detection(person(100.0, 80.0), RED);
        match (kind, a, b, new) {
            (0, ..) => drop(start_tentative(&context(1), table, person(100.0, 80.0), BLUE, [0.0; 2])),
            (1, _, _, Some(new)) => drop(table.confirm(new)),
            (2, Some(a), ..) => table.occlude(a, NOW),
            (3, Some(a), _, Some(new)) => drop(table.merge_track_into(new, a)),
            (4, Some(a), Some(b), _) => {
                if let Some(index) = table.blob_of(b).filter(|index| Some(*index) != table.blob_of(a)) {
                    table.move_to_blob(a, index);
                }
            }
            (5, Some(a), Some(b), _) => {
                if let (Some(one), Some(other)) = (table.blob_of(a), table.blob_of(b))
                    && one != other
                {
                    table.merge_blobs(&[one, other], blob(&seen), seen);
                    let members = table.members_at(&[one]);
                    table.groups.merge(&members);
                }
            }
            (6, Some(a), ..) => {
                if let Some(index) = table.blob_of(a) {
                    let members = table.members_at(&[index]);
                    let part = |&id: &ObjectId| SplitPart {
                        blob: blob(&seen),
                        members: vec![id],
                        detection: seen.clone(),
                    };
                    table.split_blobs(&[index], members.iter().map(part).collect());
                    for id in members {
                        table.renew_key(id);
                    }
                }
            }
            (7, Some(a), Some(b), _) => {
                let may_swap = |id| table.blob_of(id).is_some() && table.get(id).unwrap().key != id;
                if may_swap(a) && may_swap(b) {
                    table.swap_places(&[(a, b), (b, a)].into());
                }
            }
            (8, Some(a), ..) => drop(table.end_object(a)),
            (9, _, _, Some(new)) => drop(table.end_object(new)),
            _ => table.prune_identities(|_| false),
        }
        table.drop_empty_blobs();
    }

    proptest! {
        #[test]
        fn every_object_stays_in_one_place_with_one_identity(
            moves in prop::collection::vec((0_u8..11, [0_usize..9, 0_usize..9]), 1..120),
        ) {
            let mut table = ObjectTable::default();
            for (kind, pick) in moves {
                make_move(&mut table, kind, pick);
                prop_assert_eq!(table.check(), None, "after move {}", kind);
            }
        }
    }

    #[test]
    fn the_check_names_what_is_wrong() {
        let context = context(1);
        let table = || {
            let mut table = ObjectTable::default();
            start_confirmed(&context, &mut table, person(100.0, 80.0), RED, [0.0; 2]);
            start_confirmed(&context, &mut table, person(150.0, 80.0), BLUE, [0.0; 2]);
            table
        };
        let fault = |change: fn(&mut ObjectTable)| {
            let mut table = table();
            change(&mut table);
            table.check().unwrap_or_default()
        };
        assert_eq!(fault(|_| ()), "");
        assert!(fault(|table| table.blobs[0].members.clear()).contains("no member"));
        assert!(fault(|table| table.blobs[0].members = vec![2, 1]).contains("not in order"));
        assert!(fault(|table| table.blobs[0].members.push(2)).contains("not each in one place"));
        assert!(fault(|table| drop(table.objects.0.remove(&2))).contains("not each in one place"));
        assert!(fault(|table| table.objects.get_mut(2).unwrap().confirmed = false).contains("identity"));
        assert!(fault(|table| table.objects.get_mut(2).unwrap().key = 9).contains("identity"));
        assert!(fault(|table| table.groups.merge(&[1])).contains("no group"));
    }

    #[test]
    fn a_merged_track_takes_the_place_of_the_new_object_and_its_key() {
        let (mut table, context) = (ObjectTable::default(), context(1));
        let known = start_confirmed(&context, &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        table.occlude(known, NOW);
        table.drop_empty_blobs();
        let new = start_tentative(&context, &mut table, person(150.0, 80.0), RED, [0.0; 2]);
        assert_eq!(table.merge_track_into(new, known).map(|it| it.since), Some(NOW));
        assert_eq!(table.blobs[0].members(), [known]);
        let object = table.get(known).unwrap();
        assert_eq!((object.key, object.last_detection.bbox), (new, person(150.0, 80.0)));
        assert_eq!(table.take_assigned_identities(), [(known, 1), (new, 1)]);
    }

    #[test]
    fn identities_of_ended_objects_are_dropped_once_there_are_many() {
        use crate::occlusion::fixtures::{RED, context, person, start_confirmed};
        let (mut table, context) = (ObjectTable::default(), context(1));
        let start =
            |table: &mut ObjectTable| start_confirmed(&context, table, person(100.0, 80.0), RED, [0.0; 2]);
        let (alive, renewed) = (start(&mut table), start(&mut table));
        table.renew_key(renewed);
        let key = table.get(renewed).unwrap().key;
        let ended: Vec<ObjectId> = (0..MIN_PRUNED_IDENTITIES + 6)
            .map(|_| {
                let id = start(&mut table);
                table.end_object(id);
                id
            })
            .collect();
        table.drop_empty_blobs();
        // Four of each living object, and 64, may stay.
        let before = table.identities.len();
        assert!(before > 8 + MIN_PRUNED_IDENTITIES);
        let needed = ended[3];
        table.prune_identities(|id| id == needed);
        let known = |id: ObjectId| table.identities.of(id).is_some();
        assert!(known(alive) && known(renewed) && known(key) && known(needed));
        assert!(!ended.iter().any(|&id| id != needed && known(id)));
    }
}
