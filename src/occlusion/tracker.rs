//! Takes one frame's regions through tracking and occlusion reasoning (§VIII, Algorithms 1–3).
//!
//! The pool of Kalman models follows *blobs*: moving things with one region each. An *object* is what gets an
//! identity; a blob has one object as its member, or several while they share its region (an occlusion group). Events
//! are the changes of this partition from frame to frame.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use nalgebra::Vector3;

use super::assign::{self, AssociationScore, SplitRegion};
use super::coherence::FragmentVerdict;
use super::demerges::PendingDemerge;
use super::event::{Comparison, Counters, Episode, Event, EventKind, Evidence};
use super::group_episodes::GroupEpisodes;
use super::groups::{GroupChange, OcclusionGroups};
use super::object::{Detection, Object, clamp_around};
use super::occluded::{self, OccludedObject, PendingReappearance};
use super::partition::{self, Cluster, ExpectedRegion, Extent};
use super::perspective::Perspective;
use crate::frame::Size;
use crate::regions::{Rect, Region};
use crate::settings::{Settings, Switch};
use crate::tracking::fragments::group_fragments;
use crate::tracking::kalman::KalmanModel;
use crate::tracking::pool::{Blob, Observation, PoolSettings};
use crate::tracking::seed_finder::{SeedFinder, UnexplainedDetection};
use crate::tracking::{Identity, IdentityMap, Track, TrackKey};

/// A group member without visible pixels for more frames than this is not kept inside its group's region.
const MAX_COAST_FRAMES: u32 = 2;

/// The evidence of a new object lists at most this many occluded objects that it was not matched to.
const MAX_REJECTED_MATCHES: usize = 3;

/// Identities of ended objects are dropped once they exceed those of active objects by this many.
const MIN_PRUNED_IDENTITIES: usize = 64;

/// A region of at least this share of `track_min_area` can be a fragment of a detection.
const MIN_FRAGMENT_SHARE: f32 = 0.3;

/// An object's number, from its first region on; never reused.
pub type ObjectId = u32;

/// A blob and its members: one object, or the objects of an occlusion group.
#[derive(Clone, Debug)]
pub(super) struct TrackedBlob {
    pub(super) blob: Blob,
    /// Index of the detection that the pool's joint matching assigns to it in this frame.
    pub(super) matched: Option<usize>,
    /// By rising number; several while they share the region.
    pub(super) members: Vec<ObjectId>,
    /// Its detection in this frame, `None` while it is lost.
    pub(super) detection: Option<Detection>,
    /// The frame's number and t of the first frame without a region.
    pub(super) lost_from: Option<(u32, u32)>,
    /// Consecutive frames in which its region was larger than all its members together by `MAX_AREA_RATIO`.
    pub(super) oversized: u32,
}

impl TrackedBlob {
    /// A blob with its detection.
    const fn new(blob: Blob, members: Vec<ObjectId>, detection: Detection) -> Self {
        Self { blob, matched: None, members, detection: Some(detection), lost_from: None, oversized: 0 }
    }
}

/// Detections of one object, joined.
struct JoinedDetection {
    indices: Vec<usize>,
    /// The joined detection.
    detection: Detection,
}

impl JoinedDetection {
    /// Whether it consists of the one detection that the pool matched.
    fn is_just(&self, matched: Option<usize>) -> bool {
        matches!((&self.indices[..], matched), ([only], Some(matched)) if *only == matched)
    }
}

/// The times and lengths of `settings` in frames and pixels of this video.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) min_area_px: f32,
    pub(super) border_px: f32,
    pub(super) min_track_frames: u32,
    pub(super) max_hidden_frames: u32,
    pub(super) same_episode_frames: u32,
    /// Frames without a region after which the region is taken to be absent.
    pub(super) max_gap_frames: u32,
    /// Frames in which a region has to show more heads than it has members.
    pub(super) head_count_frames: u32,
    /// Frames after which a partly visible object's appearance is learnt anew: what seemed a part is taken for the
    /// whole.
    pub(super) relearn_frames: u32,
    /// Frames after which an object that the image edge cuts off is confirmed.
    pub(super) edge_wait_frames: u32,
    /// Frames for which an occluded object is reported at its predicted place (coasting).
    pub(super) max_coast_frames: u32,
    /// Frames a second.
    pub(super) fps: f32,
}

/// The results of one frame.
#[derive(Clone, Debug, Default)]
pub struct FrameResult {
    /// Confirmed objects, by identity: the online result.
    pub tracks: Vec<Track>,
    /// Tentative objects.
    pub tentative: Vec<Track>,
    /// All objects under their keys.
    pub objects: Vec<Track>,
    /// Events decided in this frame, by frame and kind.
    pub events: Vec<Event>,
    /// Results about earlier frames that were settled in this frame.
    pub settled: SettledResults,
}

/// Results that later frames cannot change; each is returned once.
#[derive(Clone, Debug, Default)]
pub struct SettledResults {
    /// Identities assigned to track keys; a later assignment replaces an earlier one.
    pub names: Vec<(TrackKey, Identity)>,
    /// Episodes that have ended.
    pub episodes: Vec<Episode>,
    /// Tracks of new objects in the frames before their detection was confirmed by a seed, with those frames'
    /// numbers.
    pub earlier: Vec<(u32, Track)>,
}

/// The results that are settled at the end of a sequence.
#[derive(Clone, Debug, Default)]
pub struct FinalResult {
    /// Events decided after the last frame, by frame and kind.
    pub events: Vec<Event>,
    /// Everything else that was pending until then.
    pub settled: SettledResults,
}

/// Follows objects through a sequence.
#[derive(Clone)]
pub struct Tracker {
    pub(super) settings: Settings,
    pub(super) pool: PoolSettings,
    pub(super) limits: Limits,
    pub(super) size: Size,
    /// Frames processed so far, and the present frame's number.
    pub(super) t: u32,
    pub(super) number: u32,
    pub(super) blobs: Vec<TrackedBlob>,
    pub(super) objects: BTreeMap<ObjectId, Object>,
    pub(super) occluded: Vec<OccludedObject>,
    pub(super) pending_reappearances: Vec<PendingReappearance>,
    /// Places where an object was occluded by the scene and reappeared.
    pub(super) occluders: Vec<Rect>,
    pub(super) pending_demerges: Vec<PendingDemerge>,
    pub(super) groups: OcclusionGroups,
    pub(super) group_episodes: GroupEpisodes,
    /// Ended occlusions by the scene, not returned yet.
    pub(super) episodes: Vec<Episode>,
    pub(super) identity_map: IdentityMap,
    /// Tracks of new objects in earlier frames, not returned yet.
    earlier: Vec<(u32, Track)>,
    /// Identities of the objects that events or episodes can still refer to.
    identities: BTreeMap<ObjectId, u32>,
    pub(super) events: Vec<Event>,
    perspective: Perspective,
    seeds: SeedFinder,
    counters: Counters,
    last_id: u32,
    /// For each recent frame its number and how many regions contained confirmed objects: the paper's counters.
    region_counts: VecDeque<(u32, u32)>,
    /// Numbers of the last three frames.
    recent: [u32; 3],
}

impl Tracker {
    /// A tracker before the first frame, for frames of `size` at `fps` frames a second.
    pub fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        let limits = Limits {
            min_area_px: settings.track_min_area / 100.0 * size.pixels() as f32,
            border_px: settings.border / 100.0 * size.shorter_side() as f32,
            min_track_frames: settings.min_track.frames(fps),
            max_hidden_frames: settings.max_hidden.frames(fps),
            same_episode_frames: settings.same_episode.frames(fps),
            max_gap_frames: ((0.2 * fps).round() as u32).max(3),
            head_count_frames: ((0.3 * fps).round() as u32).max(3),
            relearn_frames: ((1.5 * fps).round() as u32).max(10),
            max_coast_frames: settings.predict_for.frames(fps),
            fps: fps.max(1.0),
            edge_wait_frames: (fps.round() as u32).max(settings.min_track.frames(fps)),
        };
        Self {
            settings: settings.clone(),
            pool: PoolSettings::new(settings, fps),
            limits,
            size,
            t: 0,
            number: 0,
            blobs: Vec::new(),
            objects: BTreeMap::new(),
            occluded: Vec::new(),
            pending_reappearances: Vec::new(),
            occluders: Vec::new(),
            pending_demerges: Vec::new(),
            groups: OcclusionGroups::default(),
            group_episodes: GroupEpisodes::default(),
            episodes: Vec::new(),
            identity_map: IdentityMap::default(),
            earlier: Vec::new(),
            identities: BTreeMap::new(),
            events: Vec::new(),
            perspective: Perspective::default(),
            seeds: SeedFinder::default(),
            counters: Counters::default(),
            last_id: 0,
            region_counts: VecDeque::new(),
            recent: [0; 3],
        }
    }

    /// Processes the regions of the next frame, whose number is `number`.
    pub fn step(&mut self, number: u32, regions: &[Region]) -> FrameResult {
        self.t += 1;
        self.number = number;
        self.recent = [self.recent[1], self.recent[2], number];
        self.predict();
        let detections = self.detections(regions);
        self.match_blobs(&detections);
        let mut unexplained = Vec::new();
        for cluster in self.cluster(&detections) {
            self.resolve_cluster(&cluster, &detections, &mut unexplained);
        }
        self.blobs.retain(|tracked| !tracked.members.is_empty());
        self.match_manoeuvred_blobs(&detections, &mut unexplained);
        self.seed(&detections, &unexplained);
        self.record_region_count();
        self.update_objects();
        if self.settings.count_heads == Switch::On {
            self.count_heads();
        }
        if self.settings.find_again == Switch::On {
            self.reidentify_unseen_members();
        }
        self.correct_member_sizes();
        self.update_member_existence();
        self.resolve_lost_blobs();
        self.confirm_objects();
        self.update_occluded();
        self.update_pending_demerges();
        self.emit_group_changes();
        self.update_group_episodes();
        let seen = self.emit_frame_result();
        self.prune_identities();
        seen
    }

    /// Decides what is pending after the last frame: demerges, reappearances, and objects lost shortly before the
    /// end.
    pub fn finish(&mut self) -> FinalResult {
        while let Some(members) = self.pending_demerges.first().map(|demerge| demerge.members.clone()) {
            for id in members {
                self.settle_demerges_of(id);
            }
        }
        let pending: Vec<ObjectId> = self.pending_reappearances.iter().map(|pending| pending.id).collect();
        for id in pending {
            self.emit_reappearance(id);
        }
        self.resolve_lost_blobs_at_end();
        self.emit_group_changes();
        self.group_episodes.close_all();
        FinalResult { events: self.take_counted_events(), settled: self.take_settled() }
    }

    /// Takes the results settled since the previous call.
    pub(super) fn take_settled(&mut self) -> SettledResults {
        let identities = &self.identities;
        let mut episodes = self.group_episodes.take_closed(|id| identities.get(&id).copied());
        episodes.append(&mut self.episodes);
        SettledResults {
            names: self.identity_map.take_decided(),
            episodes,
            earlier: std::mem::take(&mut self.earlier),
        }
    }

    /// Drops identities that no event or episode can refer to any more, once there are many.
    fn prune_identities(&mut self) {
        if self.identities.len() > 2 * self.objects.len() + MIN_PRUNED_IDENTITIES {
            let (objects, episodes, demerges) = (&self.objects, &self.group_episodes, &self.pending_demerges);
            let open = |id: ObjectId| demerges.iter().any(|demerge| demerge.members.contains(&id));
            self.identities.retain(|&id, _| objects.contains_key(&id) || episodes.contains(id) || open(id));
        }
        if self.identity_map.len() > 2 * self.objects.len() + MIN_PRUNED_IDENTITIES {
            let keys: BTreeSet<TrackKey> = self.objects.values().map(|object| object.key).collect();
            self.identity_map.retain(|key| keys.contains(&key));
        }
    }

    /// Events so far, by kind.
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Number of retained items of all kinds: must not grow with time.
    pub fn retained_items(&self) -> usize {
        let scene = self.objects.len() + self.blobs.len() + self.occluded.len() + self.occluders.len();
        let open = self.pending_reappearances.len()
            + self.pending_demerges.len()
            + self.groups.len()
            + self.group_episodes.len();
        let untold = self.events.len() + self.episodes.len() + self.earlier.len();
        let names = self.identities.len() + self.identity_map.len();
        scene + open + untold + names + self.region_counts.len() + self.seeds.len()
    }

    /// The identity of an object, also of an ended one that events can still refer to.
    pub(super) fn identity(&self, id: ObjectId) -> Option<u32> {
        self.identities.get(&id).copied()
    }

    /// The objects with these numbers, in order.
    pub(super) fn objects_of<'a>(&'a self, ids: &'a [ObjectId]) -> impl Iterator<Item = &'a Object> + Clone {
        ids.iter().filter_map(|id| self.objects.get(id))
    }

    /// Whether an object is confirmed: it has an identity.
    pub(super) fn is_confirmed(&self, id: ObjectId) -> bool {
        self.objects.get(&id).is_some_and(|object| object.confirmed)
    }

    /// Whether a box is near the image edge.
    pub(super) fn is_near_border(&self, bbox: &Rect) -> bool {
        bbox.distance_to_edge(self.size) <= self.limits.border_px
    }

    pub(super) const fn new_key(&mut self) -> u32 {
        self.last_id += 1;
        self.last_id
    }

    /// Removes an object and every reference to it. Members of blobs always exist because this is the only way in
    /// which a followed object is removed.
    pub(super) fn end_object(&mut self, id: ObjectId) -> Option<Object> {
        for tracked in &mut self.blobs {
            tracked.members.retain(|member| *member != id);
        }
        self.leave_group(id);
        self.occluded.retain(|occluded| occluded.id != id);
        self.objects.remove(&id)
    }

    fn predict(&mut self) {
        for tracked in &mut self.blobs {
            tracked.detection = None;
            tracked.blob.predict();
        }
        let shared: Vec<ObjectId> = self
            .blobs
            .iter()
            .filter(|tracked| tracked.members.len() > 1)
            .flat_map(|tracked| tracked.members.iter().copied())
            .chain(self.occluded.iter().map(|occluded| occluded.id))
            .collect();
        for id in shared {
            if let Some(object) = self.objects.get_mut(&id) {
                object.predict();
            }
        }
        for tracked in &self.blobs {
            if let [alone] = tracked.members[..]
                && let Some(object) = self.objects.get_mut(&alone)
            {
                if object.partial_frames > 0 {
                    object.predict();
                } else {
                    object.set_model(&tracked.blob.shown().model);
                }
            }
        }
        if self.settings.perspective == Switch::On {
            for object in self.objects.values_mut() {
                object.update_scale(&self.perspective);
            }
        }
    }

    /// The frame's detections: its regions, with the fragments of one object joined.
    fn detections(&self, regions: &[Region]) -> Vec<Detection> {
        let fragments: Vec<Detection> = regions
            .iter()
            .filter(|region| region.shape.area as f32 >= MIN_FRAGMENT_SHARE * self.limits.min_area_px)
            .map(detection)
            .collect();
        let observed: Vec<(Rect, f32)> =
            fragments.iter().map(|detection| (detection.bbox, detection.area)).collect();
        let predicted: Vec<Rect> = self
            .blobs
            .iter()
            .map(|tracked| {
                let boxes = self.objects_of(&tracked.members).map(Object::predicted_box);
                boxes.reduce(|a, b| a.union(&b)).unwrap_or(tracked.blob.bbox)
            })
            .collect();
        let owner = |(bbox, _): &(Rect, f32)| {
            let held =
                predicted.iter().map(|expected| partition::contained_share(bbox, expected)).enumerate();
            held.filter(|(_, share)| *share >= 0.5).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
        };
        let owners: Vec<Option<usize>> = observed.iter().map(owner).collect();
        let groups = group_fragments(&observed, &owners, self.settings.fragment_gap);
        let joined = groups.iter().map(|group| {
            let parts: Vec<&Detection> = group.iter().filter_map(|&index| fragments.get(index)).collect();
            Detection::join(&parts)
        });
        joined.filter(|detection| detection.area >= self.limits.min_area_px).collect()
    }

    /// Matches blobs to detections by the pool's joint matching.
    fn match_blobs(&mut self, detections: &[Detection]) {
        let observations: Vec<Observation> = detections.iter().map(Detection::observation).collect();
        let mut blobs: Vec<Blob> = self.blobs.iter().map(|tracked| tracked.blob.clone()).collect();
        let matched = self.pool.match_observations(&mut blobs, &observations);
        for ((tracked, blob), matched) in self.blobs.iter_mut().zip(blobs).zip(matched) {
            tracked.blob = blob;
            tracked.matched = matched;
        }
    }

    fn cluster(&self, detections: &[Detection]) -> Vec<Cluster> {
        let expected: Vec<ExpectedRegion> = self
            .blobs
            .iter()
            .map(|tracked| {
                let group = tracked.members.len() > 1;
                let members = self.objects_of(&tracked.members);
                let predicted = members.clone().map(Object::predicted_box).reduce(|a, b| a.union(&b));
                let predicted = predicted.unwrap_or(tracked.blob.bbox);
                ExpectedRegion {
                    bbox: match (group, tracked.matched) {
                        (false, None) => predicted,
                        _ => tracked.blob.bbox.union(&predicted),
                    },
                    area: members.map(Object::area).fold(0.0, f32::max),
                    matched: tracked.matched,
                    group,
                }
            })
            .collect();
        let observed: Vec<(Rect, f32)> =
            detections.iter().map(|detection| (detection.bbox, detection.area)).collect();
        partition::clusters(&expected, &observed, self.settings.size_step)
    }

    /// Assigns the cluster's objects to its regions.
    fn resolve_cluster(&mut self, cluster: &Cluster, detections: &[Detection], unexplained: &mut Vec<usize>) {
        if cluster.blobs.is_empty() || cluster.observations.is_empty() {
            unexplained.extend(&cluster.observations);
            return;
        }
        let joined_detections = self.joined_detections(cluster, detections);
        let cluster = &self.without_unconfirmed(cluster, joined_detections.len());
        let members = self.members_of(&cluster.blobs);
        if cluster.blobs.len() > 1 || (joined_detections.len() > 1 && members.len() > 1) {
            self.settle_before_merge(&members, joined_detections.len());
        }
        let members = self.members_of(&cluster.blobs);
        let mut joined_detections =
            if members.len() == 1 { self.joined_detections(cluster, detections) } else { joined_detections };
        match (&members[..], &cluster.blobs[..], joined_detections.len()) {
            (&[only], &[blob], _) => self.update_single(blob, only, joined_detections, unexplained),
            (_, _, 1) => {
                if let Some(joined) = joined_detections.pop() {
                    self.merge_group(cluster, members, &joined);
                }
            }
            _ => self.split_group(cluster, &members, joined_detections, unexplained),
        }
    }

    /// Updates a lone object with its own detection; the others stay unexplained.
    fn update_single(
        &mut self,
        blob: usize,
        id: ObjectId,
        mut joined_detections: Vec<JoinedDetection>,
        unexplained: &mut Vec<usize>,
    ) {
        let Some(best) = self.own_detection(blob, &joined_detections) else { return };
        let mine = joined_detections.remove(best);
        self.update_with_detection(blob, vec![id], &mine);
        let extent = self.extent(&[id]);
        let size = |joined: &JoinedDetection| (joined.detection.bbox, joined.detection.area);
        let beside = joined_detections
            .iter()
            .any(|other| partition::are_side_by_side(&size(&mine), &size(other), extent));
        if let Some(object) = self.objects.get_mut(&id) {
            object.record_side_by_side(beside);
        }
        unexplained.extend(joined_detections.into_iter().flat_map(|other| other.indices));
    }

    /// The cluster's detections, with the fragments of one object joined.
    fn joined_detections(&self, cluster: &Cluster, detections: &[Detection]) -> Vec<JoinedDetection> {
        let members = self.members_of(&cluster.blobs);
        let local: Vec<(usize, &Detection)> =
            cluster.observations.iter().filter_map(|&index| Some((index, detections.get(index)?))).collect();
        let observed: Vec<(Rect, f32)> =
            local.iter().map(|(_, detection)| (detection.bbox, detection.area)).collect();
        let only = match members[..] {
            [only] => self.blobs_at(&cluster.blobs).next().map(|tracked| (only, tracked.blob.bbox)),
            _ => None,
        };
        let inside =
            only.and_then(|(only, bbox)| Some(self.objects.get(&only)?.predicted_box().union(&bbox)));
        let whole = |joined: Vec<usize>| {
            let parts = || joined.iter().filter_map(|&index| local.get(index));
            let detections: Vec<&Detection> = parts().map(|(_, detection)| *detection).collect();
            JoinedDetection {
                indices: parts().map(|(index, _)| *index).collect(),
                detection: Detection::join(&detections),
            }
        };
        partition::join_fragments(&observed, self.extent(&members), inside).into_iter().map(whole).collect()
    }

    /// The blobs at these indices.
    fn blobs_at<'a>(&'a self, blobs: &'a [usize]) -> impl Iterator<Item = &'a TrackedBlob> {
        blobs.iter().filter_map(|&blob| self.blobs.get(blob))
    }

    /// The members of the blobs at these indices, by rising number.
    fn members_of(&self, blobs: &[usize]) -> Vec<ObjectId> {
        let mut members: Vec<ObjectId> =
            self.blobs_at(blobs).flat_map(|tracked| tracked.members.iter().copied()).collect();
        members.retain(|id| self.objects.contains_key(id));
        members.sort_unstable();
        members
    }

    /// The confirmed ones of some objects that come to share a region, or the oldest where none is confirmed. Contact
    /// of a tentative object with a confirmed one is no merge.
    fn confirmed_or_oldest(&self, members: &[ObjectId]) -> Vec<ObjectId> {
        let named: Vec<ObjectId> = members.iter().copied().filter(|&id| self.is_confirmed(id)).collect();
        if named.is_empty() { members.iter().take(1).copied().collect() } else { named }
    }

    /// The cluster without unconfirmed objects: where there are fewer joined detections than blobs, tentative objects
    /// are ended.
    fn without_unconfirmed(&mut self, cluster: &Cluster, joined_detections: usize) -> Cluster {
        let mut cluster = cluster.clone();
        if cluster.blobs.len() < 2 || joined_detections >= cluster.blobs.len() {
            return cluster;
        }
        let members = self.members_of(&cluster.blobs);
        let keep = self.confirmed_or_oldest(&members);
        for &id in members.iter().filter(|id| !keep.contains(id)) {
            self.end_object(id);
        }
        cluster.blobs.retain(|&blob| self.blobs.get(blob).is_some_and(|it| !it.members.is_empty()));
        cluster
    }

    fn extent(&self, members: &[ObjectId]) -> Extent {
        self.objects_of(members).fold(
            Extent { w: 0.0, h: 0.0, least_area: f32::INFINITY },
            |extent, object| {
                let (w, h) = object.size();
                Extent {
                    w: extent.w.max(w),
                    h: extent.h.max(h),
                    least_area: extent.least_area.min(object.area()),
                }
            },
        )
    }

    /// Which joined detection belongs to a lone object: the one that contains the pool's match, else the one with the
    /// greatest overlap.
    fn own_detection(&self, blob: usize, joined_detections: &[JoinedDetection]) -> Option<usize> {
        let tracked = self.blobs.get(blob)?;
        let holds_match = joined_detections
            .iter()
            .position(|it| tracked.matched.is_some_and(|at| it.indices.contains(&at)));
        holds_match.or_else(|| {
            let expected = self.objects.get(tracked.members.first()?)?.predicted_box();
            let overlaps = joined_detections
                .iter()
                .map(|joined| expected.intersection(&joined.detection.bbox).area())
                .enumerate();
            overlaps.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|(at, _)| at)
        })
    }

    /// Assigns members and a detection to a blob. Where the pool matched exactly this detection its hypotheses stay;
    /// otherwise the model is corrected and the competing hypotheses are dropped.
    fn update_with_detection(&mut self, blob: usize, members: Vec<ObjectId>, joined: &JoinedDetection) {
        let detection = &joined.detection;
        let measured = detection.observation();
        let whole = match members[..] {
            [only] => self.objects.get(&only).is_none_or(|object| object.is_nearly_whole(detection)),
            _ => true,
        };
        let cut_off = self.is_near_border(&detection.bbox);
        let Some(tracked) = self.blobs.get_mut(blob) else { return };
        tracked.members = members;
        tracked.detection = Some(detection.clone());
        if joined.is_just(tracked.matched) {
            return;
        }
        let fits =
            tracked.blob.shown().model.distance_squared(&measured.measurement()) <= 4.0 * self.pool.gate;
        tracked.blob.settle(&measured, |model| {
            if fits && whole && !cut_off {
                model.update(&measured.measurement(), 2.0);
            } else {
                // Only a part of it is visible, or the image edge cuts it off: the box's centre moves differently
                // from the whole, so the velocity stays at its last clear value.
                let velocity = model.velocity();
                model.restart_at(&measured.measurement());
                model.set_velocity(Vector3::new(velocity.x, velocity.y, 0.0));
            }
        });
    }

    /// All of the cluster's objects are in one region: an occlusion group continues, or objects have merged.
    fn merge_group(&mut self, cluster: &Cluster, members: Vec<ObjectId>, joined: &JoinedDetection) {
        let Some((&first, others)) = cluster.blobs.split_first() else { return };
        if others.is_empty() {
            self.update_with_detection(first, members, joined);
            return;
        }
        let detection = &joined.detection;
        self.record_merge_cause(&cluster.blobs, &members, detection);
        self.clear_members(others);
        let model = self.merged_model(&members, detection);
        if let Some(tracked) = self.blobs.get_mut(first) {
            tracked.blob = Blob::new(model, &detection.observation());
            tracked.members = members;
            tracked.detection = Some(detection.clone());
        }
    }

    /// Removes all members from these blobs; they are members of others.
    fn clear_members(&mut self, blobs: &[usize]) {
        for &blob in blobs {
            if let Some(tracked) = self.blobs.get_mut(blob) {
                tracked.members.clear();
            }
        }
    }

    fn merged_model(&self, members: &[ObjectId], detection: &Detection) -> KalmanModel {
        let mean = self.objects_of(members).map(|object| object.model.velocity()).sum::<Vector3<f32>>()
            / members.len().max(1) as f32;
        let velocity = Vector3::new(mean.x, mean.y, 0.0);
        KalmanModel::new(
            detection.observation().measurement(),
            velocity,
            self.pool.noise.measurement,
            self.pool.noise,
        )
    }

    /// Records why the members of these blobs share a region.
    fn record_merge_cause(&mut self, blobs: &[usize], members: &[ObjectId], detection: &Detection) {
        let largest = |tracked: &TrackedBlob| {
            self.objects_of(&tracked.members).map(|object| object.last_detection.area).fold(0.0, f32::max)
        };
        let before: f32 = self.blobs_at(blobs).map(largest).fold(0.0, f32::max);
        let grown = detection.area / before.max(1.0) - 1.0;
        let step = self.settings.size_step;
        let mut evidence = Evidence::of_branch(format!(
            "{} objects with separate regions now share one of {:.0} pixels, {:+.0} % relative to the \
             largest of them",
            blobs.len(),
            detection.area,
            100.0 * grown,
        ));
        evidence.at_least("region growth", grown, step);
        for &id in members {
            let Some(object) = self.objects.get(&id) else { continue };
            let held = partition::contained_share(&object.predicted_box(), &detection.bbox);
            let whose = self.identity(id).unwrap_or_default();
            evidence.at_least(format!("share of the predicted box of {whose} inside the region"), held, 0.5);
        }
        let cause = GroupChange { frame: self.number, at: detection.bbox.centre(), evidence };
        for &id in members {
            self.groups.record_joining(id, cause.clone());
        }
    }

    /// Assigns several objects to several joined detections, and records the merges and demerges that follow.
    fn split_group(
        &mut self,
        cluster: &Cluster,
        members: &[ObjectId],
        joined_detections: Vec<JoinedDetection>,
        unexplained: &mut Vec<usize>,
    ) {
        let before: Vec<(usize, Vec<ObjectId>)> = cluster
            .blobs
            .iter()
            .filter_map(|&blob| Some((blob, self.blobs.get(blob)?.members.clone())))
            .collect();
        let in_group: Vec<bool> = members
            .iter()
            .map(|id| before.iter().any(|(_, group)| group.len() > 1 && group.contains(id)))
            .collect();
        let objects: Vec<&Object> = self.objects_of(members).collect();
        let position_sigmas: Vec<f32> =
            members.iter().zip(&in_group).map(|(&id, &group)| self.position_sigma(id, group)).collect();
        let parts: Vec<SplitRegion> =
            joined_detections.iter().map(|joined| split_region(&joined.detection)).collect();
        let fits = assign::association_scores(&objects, &position_sigmas, &parts, &self.settings);
        let assigned = assign::assign_to_regions(&fits, &objects, &parts, &in_group);

        let mut blobs: Vec<(usize, TrackedBlob)> = Vec::new();
        for (number, joined) in joined_detections.into_iter().enumerate() {
            let here: Vec<ObjectId> =
                members.iter().zip(&assigned).filter(|(_, at)| **at == number).map(|(&id, _)| id).collect();
            if here.is_empty() {
                unexplained.extend(&joined.indices);
                continue;
            }
            let known = self.confirmed_or_oldest(&here);
            for &id in here.iter().filter(|id| !known.contains(id)) {
                self.end_object(id);
            }
            let (here, detection) = (known, joined.detection);
            let observed = detection.observation();
            let alone = match here[..] {
                [only] => self.objects.get(&only).map(|object| object.model.clone()),
                _ => None,
            };
            let model = alone.map_or_else(
                || self.merged_model(&here, &detection),
                |mut model| {
                    model.restart_at(&observed.measurement());
                    model
                },
            );
            let blob = Blob::new(model, &observed);
            blobs.push((number, TrackedBlob::new(blob, here, detection)));
        }
        for (_, joined) in &blobs {
            let from = before.iter().filter(|(_, group)| joined.members.iter().any(|id| group.contains(id)));
            let from: Vec<usize> = from.map(|(blob, _)| *blob).collect();
            if from.len() > 1
                && let Some(detection) = &joined.detection
            {
                self.record_merge_cause(&from, &joined.members, detection);
            }
        }
        let fits: BTreeMap<ObjectId, Vec<AssociationScore>> = members.iter().copied().zip(fits).collect();
        for (_, group) in before.iter().filter(|(_, group)| group.len() > 1) {
            self.start_demerge(group, &blobs, &fits);
        }
        self.clear_members(&cluster.blobs);
        self.blobs.extend(blobs.into_iter().map(|(_, tracked)| tracked));
    }

    /// Standard deviation of an object's predicted place, in pixels; larger the longer it has been in a group.
    pub(super) fn position_sigma(&self, id: ObjectId, in_group: bool) -> f32 {
        let Some(object) = self.objects.get(&id) else { return 0.0 };
        let (_, height) = object.size();
        let apart = match object.template {
            _ if !in_group => 0.0,
            Some(_) => object.unseen_frames as f32,
            None => self.group_episodes.duration_of(id, self.t) as f32,
        };
        let velocity = object.model.velocity();
        0.15 * height + 0.25 * velocity.x.hypot(velocity.y) * apart
    }

    /// Matches blobs that are lost in this frame to unexplained detections within reach of a manoeuvre.
    fn match_manoeuvred_blobs(&mut self, detections: &[Detection], unexplained: &mut Vec<usize>) {
        let lost = |tracked: &&mut TrackedBlob| tracked.detection.is_none() && tracked.members.len() == 1;
        let mut lost: Vec<&mut TrackedBlob> = self.blobs.iter_mut().filter(lost).collect();
        let free: Vec<(usize, &Detection, Observation)> = unexplained
            .iter()
            .filter_map(|&index| {
                detections.get(index).map(|detection| (index, detection, detection.observation()))
            })
            .collect();
        let blobs: Vec<&Blob> = lost.iter().map(|tracked| &tracked.blob).collect();
        let observations: Vec<&Observation> = free.iter().map(|(.., observed)| observed).collect();
        let mut taken = Vec::new();
        for (row, column) in self.pool.match_manoeuvres(&blobs, &observations) {
            let (Some(tracked), Some((index, detection, observed))) = (lost.get_mut(row), free.get(column))
            else {
                continue;
            };
            PoolSettings::update_after_manoeuvre(&mut tracked.blob, observed);
            tracked.detection = Some(Detection::clone(detection));
            taken.push(*index);
        }
        unexplained.retain(|index| !taken.contains(index));
    }

    /// Starts new objects from unexplained detections.
    fn seed(&mut self, detections: &[Detection], unexplained: &[usize]) {
        let candidate = |&index: &usize| {
            let detection = detections.get(index)?;
            Some(UnexplainedDetection {
                index,
                observation: detection.observation(),
                labels: detection.labels.clone(),
            })
        };
        for seed in self.seeds.step(&self.pool, unexplained.iter().filter_map(candidate).collect()) {
            let Some(detection) = detections.get(seed.index).cloned() else { continue };
            let id = self.new_key();
            let birth = (self.recent[0], seed.earlier[0].observation.bbox);
            let mut object = Object::new(id, birth, seed.model.clone(), detection.clone());
            // The two earlier frames; this one is counted when its blob is updated below.
            object.seen_frames = 2;
            for (number, earlier) in self.recent.into_iter().zip(&seed.earlier) {
                // At the image edge the first visible part is often a foot or an arm.
                if earlier.observation.bbox.distance_to_edge(self.size) <= 1.0 {
                    continue;
                }
                let track = self.earlier_track(&object, earlier);
                self.earlier.push((number, track));
            }
            self.objects.insert(id, object);
            let blob = Blob::new(seed.model, &detection.observation());
            self.blobs.push(TrackedBlob::new(blob, vec![id], detection));
        }
    }

    fn record_region_count(&mut self) {
        let stands_for_objects = |tracked: &&TrackedBlob| {
            tracked.detection.is_some() && tracked.members.iter().any(|&id| self.is_confirmed(id))
        };
        let now = self.blobs.iter().filter(stands_for_objects).count();
        // No event is emitted later than `max_hidden` frames after the frame it belongs to.
        if self.region_counts.len() > self.limits.max_hidden_frames as usize + 1 {
            self.region_counts.pop_front();
        }
        self.region_counts.push_back((self.number, now as u32));
    }

    /// How many regions contained confirmed objects in the frame before the frame with this number, and in that
    /// frame.
    fn region_counts_at(&self, number: u32) -> (u32, u32) {
        let at = self.region_counts.partition_point(|(counted, _)| *counted < number);
        let count =
            |at: Option<usize>| at.and_then(|at| self.region_counts.get(at)).map_or(0, |(_, count)| *count);
        (count(at.checked_sub(1)), count(Some(at)))
    }

    /// Updates each object's own motion and appearance from its blob's detection.
    fn update_objects(&mut self) {
        for index in 0..self.blobs.len() {
            let Some(tracked) = self.blobs.get(index) else { break };
            if let [alone] = tracked.members[..] {
                let model = tracked.blob.shown().model.clone();
                let detection = tracked.detection.clone();
                let cut_off =
                    detection.as_ref().is_some_and(|detection| self.is_near_border(&detection.bbox));
                let undecided = self.pending_demerges.iter().any(|demerge| demerge.is_undecided(alone));
                let (relearn_appearance, at_last) =
                    (self.limits.relearn_frames, self.limits.max_hidden_frames);
                let mut part = None;
                if let Some(object) = self.objects.get_mut(&alone) {
                    match detection {
                        Some(detection)
                            if !object.is_nearly_whole(&detection)
                                && (object.partial_frames < relearn_appearance
                                    || !object.has_moved_while_partial(&detection)
                                        && object.partial_frames < at_last) =>
                        {
                            object.update_partial(&detection);
                            part = Some(detection);
                        }
                        Some(detection) => {
                            object.set_model(&model);
                            if object.partial_frames >= relearn_appearance {
                                object.relearn_appearance(&detection, &self.settings);
                            } else if let Some(clear) = &object.appearance
                                && !cut_off
                            {
                                let [_, y] = detection.bbox.centre();
                                self.perspective.update(y, detection.bbox.h, clear.y, clear.h);
                            }
                            if undecided {
                                object.seen_frames += 1;
                                object.partial_frames = 0;
                            } else {
                                object.update_appearance(&detection, cut_off, &self.settings);
                            }
                        }
                        None => object.coast(),
                    }
                }
                if let Some(detection) = part {
                    self.localise_members(&[alone], &detection);
                }
            } else if let Some(detection) = tracked.detection.clone() {
                let members = tracked.members.clone();
                self.constrain_to_region(&members, &detection.bbox);
                self.localise_members(&members, &detection);
            }
        }
    }

    /// Keeps the predicted boxes of a group's members inside its region. Where the region is wider than its widest
    /// member, its left and right edges belong to the outermost members.
    fn constrain_to_region(&mut self, members: &[ObjectId], region: &Rect) {
        let widest = self.objects_of(members).map(|object| object.size().0).fold(0.0, f32::max);
        let across: Vec<(f32, ObjectId)> = members
            .iter()
            .filter_map(|&id| self.objects.get(&id).map(|object| (object.model.centre()[0], id)))
            .collect();
        let leftmost = across.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| *id);
        let rightmost = across.iter().rev().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| *id);
        let spread = region.w > 1.15 * widest && leftmost != rightmost;
        for &id in members {
            let Some(object) = self.objects.get_mut(&id) else { continue };
            object.seen_frames += 1;
            if object.unseen_frames > MAX_COAST_FRAMES {
                object.damp_velocity();
                continue;
            }
            let (w, h) = object.size();
            let [x, y] = object.model.centre();
            let [middle_x, middle_y] = region.centre();
            let mut centre = [
                clamp_around(middle_x, (region.w - w) / 2.0, x),
                clamp_around(middle_y, (region.h - h) / 2.0, y),
            ];
            if spread && Some(id) == leftmost {
                centre[0] = f32::midpoint(centre[0], region.x + w / 2.0);
            }
            if spread && Some(id) == rightmost {
                centre[0] = f32::midpoint(centre[0], region.right() - w / 2.0);
            }
            object.constrain_centre(centre);
        }
    }

    /// Removes tentative objects within the full extent of a partly visible object: they are fragments of it.
    fn absorb_fragments(&mut self) {
        let extents: Vec<Rect> = self
            .blobs
            .iter()
            .filter_map(|tracked| match tracked.members[..] {
                [alone] => self.objects.get(&alone),
                _ => None,
            })
            .filter(|object| object.confirmed && object.partial_frames > 0)
            .map(Object::predicted_box)
            .collect();
        let objects = &mut self.objects;
        self.blobs.retain(|tracked| {
            let (&[id], Some(detection)) = (&tracked.members[..], &tracked.detection) else { return true };
            let part = objects.get(&id).is_some_and(|object| !object.confirmed)
                && extents.iter().any(|extent| partition::contained_share(&detection.bbox, extent) >= 0.5);
            if part {
                objects.remove(&id);
            }
            !part
        });
    }

    /// Confirms objects that were detected in enough frames, and emits their first events.
    fn confirm_objects(&mut self) {
        self.absorb_fragments();
        let due: Vec<ObjectId> = self
            .objects
            .iter()
            .filter(|(_, object)| !object.confirmed && object.seen_frames >= self.limits.min_track_frames)
            // At the image edge the first visible part is often a foot or an arm, with another one beside it.
            .filter(|(_, object)| {
                object.seen_frames >= self.limits.edge_wait_frames
                    || object.last_detection.bbox.distance_to_edge(self.size) > 1.0
            })
            .map(|(&id, _)| id)
            .collect();
        for id in due {
            // An earlier iteration may have ended or confirmed it.
            let open = self.objects.get(&id).is_some_and(|object| !object.confirmed);
            if !open || self.needs_clearer_view(id) {
                continue;
            }
            match self.fragment_verdict(id) {
                Some(FragmentVerdict::Undecided) => {}
                Some(FragmentVerdict::Of { whole, detection, evidence }) => {
                    self.join_fragment(id, whole, detection, evidence);
                }
                None if self.objects.get(&id).is_some_and(Object::has_moved) => self.confirm_object(id),
                // A re-identified object may stand still.
                None => {
                    self.reidentify(id);
                }
            }
        }
    }

    /// Matches a tentative object to an occluded object or to an unseen group member; on success it continues as that
    /// one.
    fn reidentify(&mut self, id: ObjectId) -> bool {
        let known = self.match_reappearance(id) || self.match_split_member(id);
        if known {
            self.absorb_fragments();
        }
        known
    }

    /// Assigns an identity to an object, and emits its first event where the identity is new.
    pub(super) fn confirm_object(&mut self, id: ObjectId) {
        if self.reidentify(id) {
            return;
        }
        let Some(object) = self.objects.get_mut(&id) else { return };
        object.confirmed = true;
        let identity = self.identity_map.assign_new(object.key);
        self.identities.insert(id, identity);
        let (born, birthplace) = (object.first_frame, object.first_bbox);
        let fragments = std::mem::take(&mut object.fragments);
        let distance = birthplace.distance_to_edge(self.size);
        let near = distance <= self.limits.border_px;
        let kind = if near { EventKind::Enter } else { EventKind::Appear };
        let branch = if near {
            "new object, first detected near the image edge"
        } else {
            "new object away from the image edge; no occluded object matches and no group shrank"
        };
        let mut evidence = Evidence::of_branch(branch);
        if near {
            evidence.at_most("distance to image edge, pixels", distance, self.limits.border_px);
        } else {
            evidence.at_least("distance to image edge, pixels", distance, self.limits.border_px);
            self.note_rejected_matches(&birthplace, &mut evidence);
        }
        evidence.comparisons.extend(fragments);
        let event = Event::of_one(born, kind, identity, birthplace.centre(), evidence);
        self.emit_event(&[id], event);
    }

    /// Records which occluded objects a new one was not matched to, the nearest first: distance and radius of each.
    fn note_rejected_matches(&self, birthplace: &Rect, evidence: &mut Evidence) {
        let mut refused: Vec<(f32, f32, u32)> = self
            .occluded
            .iter()
            .filter_map(|occluded| {
                let past = self.objects.get(&occluded.id)?;
                let distance = assign::distance_outside(&past.predicted_box(), birthplace);
                Some((
                    distance,
                    occluded::reappearance_radius(past, self.t - occluded.since.1),
                    self.identity(occluded.id)?,
                ))
            })
            .collect();
        refused.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (distance, reach, identity) in refused.into_iter().take(MAX_REJECTED_MATCHES) {
            let place = Comparison::at_least(
                format!("distance to predicted position of occluded {identity}, pixels"),
                distance,
                reach,
            );
            evidence.comparisons.push(place.of_alternative(false));
        }
    }

    /// Records which objects share a region in this frame.
    fn update_group_episodes(&mut self) {
        let groups: Vec<(Vec<(ObjectId, f32)>, bool)> = self
            .blobs
            .iter()
            .filter(|tracked| tracked.members.len() > 1)
            .map(|tracked| {
                let boxes: Vec<Rect> = self.objects_of(&tracked.members).map(Object::predicted_box).collect();
                let overlapping = boxes.iter().enumerate().any(|(index, a)| {
                    boxes.iter().skip(index + 1).any(|b| partition::contained_share(a, b) >= 0.3)
                });
                let shares = tracked
                    .members
                    .iter()
                    .map(|&id| (id, self.visible_share_in_group(id, tracked)))
                    .collect();
                (shares, overlapping)
            })
            .collect();
        for (members, overlapping) in groups {
            self.group_episodes.record_sharing(&members, self.number, self.t, overlapping);
        }
        self.group_episodes.close(self.t, self.limits.same_episode_frames);
    }

    /// The visible share of a member in its group: the share of its own colours that the region contains.
    pub(super) fn visible_share_in_group(&self, id: ObjectId, tracked: &TrackedBlob) -> f32 {
        let clear = self.objects.get(&id).and_then(|object| object.appearance.as_ref());
        match (clear, &tracked.detection) {
            (Some(clear), Some(detection)) => detection.histogram.holds(&clear.histogram, clear.area),
            _ => 1.0,
        }
    }

    pub(super) fn identities(&self, members: &[ObjectId]) -> Vec<u32> {
        let mut identities: Vec<u32> = members.iter().filter_map(|&id| self.identity(id)).collect();
        identities.sort_unstable();
        identities
    }

    pub(super) fn take_counted_events(&mut self) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.events);
        events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
        for event in &mut events {
            self.counters.count(event.kind);
            (event.evidence.objects_before, event.evidence.objects_now) = self.region_counts_at(event.frame);
        }
        events
    }
}

fn detection(region: &Region) -> Detection {
    Detection {
        bbox: region.shape.bbox,
        area: region.shape.area as f32,
        histogram: region.histogram.clone(),
        labels: vec![region.label],
        mosaic: Arc::clone(&region.mosaic),
    }
}

fn split_region(detection: &Detection) -> SplitRegion {
    SplitRegion { bbox: detection.bbox, area: detection.area, histogram: detection.histogram.clone() }
}
