//! Decisions about objects: those that wait for later frames, and the events and episodes that are decided and not
//! returned yet.

use super::context::FrameRef;
use super::group_episodes::GroupEpisodes;
use super::object::Object;
use super::split_region::{AssociationScore, SplitRegion};
use crate::occlusion::event::{Episode, Event};
use crate::regions::Rect;
use crate::tracking::ObjectId;

/// Number of remembered places of occlusion by the scene; the oldest are dropped first.
const MAX_OCCLUDERS: usize = 64;

/// A demerge that is not emitted yet.
#[derive(Clone, Debug)]
pub(crate) struct PendingDemerge {
    /// The frame of the demerge.
    pub(crate) at: FrameRef,
    pub(crate) members: Vec<ObjectId>,
    /// For each member the region that it is in.
    pub(crate) region_of: Vec<usize>,
    pub(crate) regions: Vec<SplitRegion>,
    /// Scores by member and region, at the demerge.
    pub(crate) scores: Vec<Vec<AssociationScore>>,
    /// Whether the identities are decided.
    pub(crate) decided: bool,
}

impl PendingDemerge {
    /// Whether this object's identity is undecided.
    pub(crate) fn is_undecided(&self, id: ObjectId) -> bool {
        !self.decided && self.members.contains(&id)
    }

    /// The region that a member is in.
    pub(crate) fn region_of_member(&self, id: ObjectId) -> Option<usize> {
        let member = self.members.iter().zip(&self.region_of).find(|(member, _)| **member == id);
        member.map(|(_, &region)| region)
    }

    /// The members in a region.
    pub(crate) fn members_in(&self, region: usize) -> Vec<ObjectId> {
        self.members.iter().zip(&self.region_of).filter(|(_, at)| **at == region).map(|(&id, _)| id).collect()
    }
}

/// A reappearance that is not emitted yet: the object may be occluded again at once.
#[derive(Clone, Debug)]
pub(crate) struct PendingReappearance {
    pub(crate) id: ObjectId,
    /// The first frame of the occlusion.
    pub(crate) since: FrameRef,
    /// The time of its first region after the occlusion, in frame periods.
    pub(crate) t: u32,
    pub(crate) event: Event,
    /// Its last box before the occlusion.
    pub(crate) from: Rect,
}

/// Pending decisions, and the results of those made.
#[derive(Clone, Debug, Default)]
pub(crate) struct Decisions {
    /// In the order of their frames.
    pub(crate) demerges: Vec<PendingDemerge>,
    /// At most one of each object.
    pub(crate) reappearances: Vec<PendingReappearance>,
    /// Places where an object was occluded by the scene and reappeared.
    occluders: Vec<Rect>,
    pub(crate) group_episodes: GroupEpisodes,
    /// Ended occlusions by the scene, not returned yet.
    pub(crate) scene_episodes: Vec<Episode>,
    /// Not returned yet.
    pub(crate) events: Vec<Event>,
}

impl Decisions {
    /// Takes the first pending demerge that an object takes part in.
    pub(crate) fn take_demerge_of(&mut self, id: ObjectId) -> Option<PendingDemerge> {
        let index = self.demerges.iter().position(|demerge| demerge.members.contains(&id))?;
        Some(self.demerges.remove(index))
    }

    /// Whether an object takes part in a pending demerge.
    pub(crate) fn has_demerge_of(&self, id: ObjectId) -> bool {
        self.demerges.iter().any(|demerge| demerge.members.contains(&id))
    }

    /// Takes the pending reappearance of an object.
    pub(crate) fn take_reappearance_of(&mut self, id: ObjectId) -> Option<PendingReappearance> {
        let index = self.reappearances.iter().position(|pending| pending.id == id)?;
        Some(self.reappearances.remove(index))
    }

    /// The known occluders: places where an object disappeared and reappeared.
    pub(crate) fn occluders(&self) -> &[Rect] {
        &self.occluders
    }

    /// Whether an object without a region is behind a known occluder.
    pub(crate) fn is_behind_known_occluder(&self, object: &Object) -> bool {
        let bbox = object.predicted_box();
        self.occluders.iter().any(|occluder| bbox.share_within(occluder) >= 0.5)
    }

    /// Remembers a place where an object was occluded by the scene.
    pub(crate) fn remember_occluder(&mut self, place: Rect) {
        if self.occluders.len() >= MAX_OCCLUDERS {
            self.occluders.remove(0);
        }
        self.occluders.push(place);
    }

    /// Whether an event or episode that is not returned yet can refer to an object.
    pub(crate) fn has_reference_to(&self, id: ObjectId) -> bool {
        self.group_episodes.contains(id) || self.has_demerge_of(id)
    }

    /// Number of retained items of all kinds.
    pub(crate) fn len(&self) -> usize {
        let pending = self.demerges.len() + self.reappearances.len() + self.group_episodes.len();
        pending + self.occluders.len() + self.scene_episodes.len() + self.events.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_can_refer_to_the_members_of_open_episodes_and_pending_demerges() {
        let mut decisions = Decisions::default();
        decisions.group_episodes.record_sharing(&[(1, 1.0), (2, 1.0)], 5, 5, false);
        decisions.demerges.push(PendingDemerge {
            at: FrameRef { number: 5, index: 5, t: 5 },
            members: vec![3, 4],
            region_of: vec![0, 1],
            regions: Vec::new(),
            scores: Vec::new(),
            decided: false,
        });
        let referred = [1, 2, 3, 4, 5].map(|id| decisions.has_reference_to(id));
        assert_eq!(referred, [true, true, true, true, false]);
        assert_eq!([2, 3].map(|id| decisions.has_demerge_of(id)), [false, true]);
    }
}
