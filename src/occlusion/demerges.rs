//! Demerges of occlusion groups: the identities of the resulting regions (Algorithm 3), decided after the regions
//! were observed for some frames.

use std::collections::BTreeMap;

use super::assign::{self, AssociationScore, SplitRegion};
use super::event::{Comparison, Evidence};
use super::groups::GroupChange;
use super::object::Object;
use super::tracker::{ObjectId, TrackedBlob, Tracker};
use crate::regions::{Histogram, Rect};

/// A decision about identities waits at most this many frames for a clearer view.
const MAX_WAIT_FRAMES: u32 = 10;

/// A demerge that is not emitted yet.
#[derive(Clone, Debug)]
pub(super) struct PendingDemerge {
    /// Number and t of the demerge's frame.
    frame: u32,
    t: u32,
    pub(super) members: Vec<ObjectId>,
    /// For each member the region that it is in.
    region_of: Vec<usize>,
    regions: Vec<SplitRegion>,
    /// Scores by member and region, at the demerge.
    fits: Vec<Vec<AssociationScore>>,
    decided: bool,
}

impl PendingDemerge {
    /// Whether this object's identity is undecided.
    pub(super) fn is_undecided(&self, id: ObjectId) -> bool {
        !self.decided && self.members.contains(&id)
    }

    /// The region that a member is in.
    pub(super) fn region_of_member(&self, id: ObjectId) -> Option<usize> {
        let member = self.members.iter().zip(&self.region_of).find(|(member, _)| **member == id);
        member.map(|(_, &region)| region)
    }

    fn members_in(&self, region: usize) -> Vec<ObjectId> {
        self.members.iter().zip(&self.region_of).filter(|(_, at)| **at == region).map(|(&id, _)| id).collect()
    }
}

impl Tracker {
    /// Records a demerge, if the group's members are now in several of `blobs`, each with the number of its region in
    /// the rows of `fits`.
    pub(super) fn start_demerge(
        &mut self,
        group: &[ObjectId],
        blobs: &[(usize, TrackedBlob)],
        fits: &BTreeMap<ObjectId, Vec<AssociationScore>>,
    ) {
        let present: Vec<ObjectId> =
            group.iter().copied().filter(|id| self.objects.contains_key(id)).collect();
        let regions: Vec<&(usize, TrackedBlob)> = blobs
            .iter()
            .filter(|(_, tracked)| tracked.members.iter().any(|id| present.contains(id)))
            .collect();
        if regions.len() < 2 {
            return;
        }
        for &id in &present {
            self.settle_demerges_of(id);
        }
        let region_of = present
            .iter()
            .map(|id| regions.iter().position(|(_, tracked)| tracked.members.contains(id)).unwrap_or(0))
            .collect();
        let fits = present
            .iter()
            .filter_map(|id| fits.get(id))
            .map(|row| regions.iter().filter_map(|(number, _)| row.get(*number).copied()).collect())
            .collect();
        let empty = |bbox: Rect, area: f32| SplitRegion { bbox, area, histogram: Histogram::default() };
        let regions = regions
            .iter()
            .map(|(_, tracked)| {
                let detection = tracked.detection.as_ref();
                detection.map_or_else(
                    || empty(Rect::default(), 0.0),
                    |detection| empty(detection.bbox, detection.area),
                )
            })
            .collect();
        // From here on their tracks have new keys: if the assignment turns out to be reversed, only the identities of
        // the keys change.
        for &id in &present {
            let key = self.new_key();
            if let Some(object) = self.objects.get_mut(&id) {
                self.identity_map.link(key, object.key);
                object.key = key;
            }
        }
        self.pending_demerges.push(PendingDemerge {
            frame: self.number,
            t: self.t,
            members: present,
            region_of,
            regions,
            fits,
            decided: false,
        });
    }

    /// Matches a new object to a member of a group that shrank: it left where the group's region no longer is
    /// (Algorithm 3). On success it takes that member's identity.
    pub(super) fn match_split_member(&mut self, id: ObjectId) -> bool {
        let Some(new) = self.objects.get(&id) else { return false };
        if new.first_bbox.distance_to_edge(self.size) <= self.limits.border_px {
            return false;
        }
        let region = SplitRegion {
            bbox: new.first_bbox,
            area: new.last_detection.area,
            histogram: new.last_detection.histogram.clone(),
        };
        let mut best: Option<(f32, usize, ObjectId, AssociationScore, f32)> = None;
        for (index, group) in
            self.blobs.iter().enumerate().filter(|(_, it)| it.members.len() > 1 && !it.members.contains(&id))
        {
            let due: f32 = self.objects_of(&group.members).map(Object::area).sum();
            let seen = group.detection.as_ref().map_or(0.0, |detection| detection.area);
            let shrunk = seen <= (1.0 - self.settings.size_step) * due;
            let known = group.members.iter().filter_map(|id| Some((*id, self.objects.get(id)?)));
            for (member, object) in known.filter(|(_, object)| shrunk || object.unseen_frames > 0) {
                if !new.may_match(object) {
                    continue;
                }
                let position_sigma = self.position_sigma(member, true);
                let fits = assign::association_scores(
                    &[object],
                    &[position_sigma],
                    std::slice::from_ref(&region),
                    &self.settings,
                );
                let Some(&fit) = fits.first().and_then(|row| row.first()) else { continue };
                if fit.distance > 3.0 * position_sigma {
                    continue;
                }
                let value = assign::total_nats(fit);
                if best.is_none_or(|(most, ..)| value > most) {
                    best = Some((value, index, member, fit, seen / due));
                }
            }
        }
        let Some((_, index, member, fit, filled)) = best else { return false };
        if self.pending_demerges.iter().any(|demerge| demerge.members.contains(&member)) {
            // The identities within the group were undecided until now.
            self.settle_demerges_of(member);
            return self.match_split_member(id);
        }
        let objects = self.blobs.get(index).map_or(0, |group| group.members.len());
        let step = self.settings.size_step;
        let why = if filled <= 1.0 - step { "that shrank" } else { "in which it was not visible" };
        let mut evidence = Evidence::of_branch(format!(
            "unassociated region next to one shared by {objects} objects, {why}; assigned to the \
             best-matching group member",
        ));
        evidence.at_most("group area relative to the expected area of its members", filled, 1.0 - step);
        evidence.note("colour similarity, 0 to 1.2", fit.colour);
        evidence.note("distance to the member's prediction, pixels", fit.distance);
        let frame = new.first_frame;
        if let Some(group) = self.blobs.get_mut(index) {
            group.members.retain(|&other| other != member);
        }
        self.merge_track_into(id, member);
        self.groups.record_leaving(member, GroupChange { frame, at: region.bbox.centre(), evidence });
        true
    }

    /// Decides the pending demerges of objects before they are assigned to `pieces` new regions; identities may be
    /// swapped. A demerge whose members all share one region again is dropped: they never parted.
    pub(super) fn settle_before_merge(&mut self, members: &[ObjectId], regions: usize) {
        let together =
            |demerge: &PendingDemerge| regions == 1 && demerge.members.iter().all(|id| members.contains(id));
        self.pending_demerges.retain(|demerge| !together(demerge));
        for &id in members {
            self.settle_demerges_of(id);
        }
    }

    /// Decides and emits the pending demerges of an object at once.
    pub(super) fn settle_demerges_of(&mut self, id: ObjectId) {
        while let Some(index) = self.pending_demerges.iter().position(|demerge| demerge.members.contains(&id))
        {
            let demerge = self.pending_demerges.remove(index);
            self.settle_demerge(demerge);
        }
    }

    fn settle_demerge(&mut self, mut demerge: PendingDemerge) {
        self.decide_demerge(&mut demerge);
        self.emit_pending_demerge(&demerge);
    }

    /// Accumulates the regions' colours; decides and emits demerges that waited long enough.
    pub(super) fn update_pending_demerges(&mut self) {
        let same_episode = self.limits.same_episode_frames;
        for mut demerge in std::mem::take(&mut self.pending_demerges) {
            self.accumulate_histograms(&mut demerge);
            let waited = self.t - demerge.t;
            if waited >= MAX_WAIT_FRAMES.min(same_episode.max(3)) {
                self.decide_demerge(&mut demerge);
            }
            if waited > same_episode {
                self.settle_demerge(demerge);
            } else {
                self.pending_demerges.push(demerge);
            }
        }
    }

    fn accumulate_histograms(&self, demerge: &mut PendingDemerge) {
        let members: Vec<Vec<ObjectId>> =
            (0..demerge.regions.len()).map(|region| demerge.members_in(region)).collect();
        for (region, members) in demerge.regions.iter_mut().zip(members) {
            let tracked = self.blobs.iter().find(|tracked| tracked.members == members);
            if let Some(detection) = tracked.and_then(|tracked| tracked.detection.as_ref()) {
                region.histogram.add_scaled(&detection.histogram, 1.0 / detection.area.max(1.0));
            }
        }
    }

    /// Assigns members to regions again, by the colours accumulated since and the motion at the demerge. Where the
    /// result differs from the first assignment, identities are swapped.
    fn decide_demerge(&mut self, demerge: &mut PendingDemerge) {
        if std::mem::replace(&mut demerge.decided, true) {
            return;
        }
        if demerge.regions.iter().any(|region| region.histogram.total() <= 0.0)
            || demerge.members.iter().any(|id| !self.objects.contains_key(id))
        {
            return;
        }
        let mut fits = demerge.fits.clone();
        for (row, object) in fits.iter_mut().zip(self.objects_of(&demerge.members)) {
            for (fit, region) in row.iter_mut().zip(&demerge.regions) {
                (fit.colour, fit.delta_e) = object.colour_similarity(&region.histogram, &self.settings);
            }
        }
        let assigned = assign::reassign_to_regions(&fits, &demerge.region_of, demerge.regions.len());
        let mut takes_place_of = BTreeMap::new();
        for region in 0..demerge.regions.len() {
            let new =
                demerge.members.iter().zip(&assigned).filter(|(_, at)| **at == region).map(|(&id, _)| id);
            takes_place_of.extend(new.zip(demerge.members_in(region)));
        }
        self.swap_identities(&takes_place_of);
        demerge.fits = fits;
        demerge.region_of = assigned;
    }

    /// Swaps identities: each object (key) takes the track key, motion, last detection and blob of another (value).
    fn swap_identities(&mut self, takes_place_of: &BTreeMap<ObjectId, ObjectId>) {
        if takes_place_of.iter().all(|(id, place)| id == place) {
            return;
        }
        let identities: BTreeMap<ObjectId, Option<u32>> =
            takes_place_of.keys().map(|&id| (id, self.identity(id))).collect();
        let places: BTreeMap<ObjectId, Object> =
            takes_place_of.values().filter_map(|id| Some((*id, self.objects.get(id)?.clone()))).collect();
        for (id, place) in takes_place_of {
            if let (Some(object), Some(place)) = (self.objects.get_mut(id), places.get(place)) {
                object.key = place.key;
                object.model = place.model.clone();
                object.last_detection = place.last_detection.clone();
                if let Some(identity) = identities.get(id).copied().flatten() {
                    self.identity_map.set(place.key, identity);
                }
            }
        }
        let who: BTreeMap<ObjectId, ObjectId> =
            takes_place_of.iter().map(|(&id, &place)| (place, id)).collect();
        for tracked in &mut self.blobs {
            for member in &mut tracked.members {
                *member = who.get(member).copied().unwrap_or(*member);
            }
            tracked.members.sort_unstable();
        }
    }

    fn emit_pending_demerge(&mut self, demerge: &PendingDemerge) {
        let area: f32 = demerge.regions.iter().map(|region| region.area).sum();
        let mut evidence = Evidence::of_branch(format!(
            "region shared by {} objects split into {} fragments, {area:.0} pixels in total; decided after \
             {} frames",
            self.identities(&demerge.members).len(),
            demerge.regions.len(),
            self.t - demerge.t,
        ));
        for (member, (row, &chosen)) in
            demerge.members.iter().zip(demerge.fits.iter().zip(&demerge.region_of))
        {
            let identity = self.identity(*member).unwrap_or_default();
            for (region, fit) in row.iter().enumerate() {
                let name = region + 1;
                let taken = region == chosen;
                let delta_e = if fit.delta_e.is_finite() { fit.delta_e } else { 999.0 };
                let alternatives = [
                    Comparison::at_most(
                        format!("ΔE of {identity} and fragment {name}"),
                        delta_e,
                        self.settings.same_colour,
                    ),
                    Comparison::note(
                        format!("colour similarity of {identity} and fragment {name}, 0 to 1.2"),
                        fit.colour,
                    ),
                    Comparison::note(
                        format!("distance of fragment {name} to the prediction of {identity}, pixels"),
                        fit.distance,
                    ),
                ];
                evidence.comparisons.extend(alternatives.map(|it| it.of_alternative(taken)));
            }
        }
        let around =
            demerge.regions.iter().map(|region| region.bbox).reduce(|a, b| a.union(&b)).unwrap_or_default();
        let regions: Vec<Vec<ObjectId>> =
            (0..demerge.regions.len()).map(|region| demerge.members_in(region)).collect();
        self.emit_demerge(&regions, &GroupChange { frame: demerge.frame, at: around.centre(), evidence });
    }
}
