//! One frame's regions through tracking and occlusion reasoning (§VIII, Algorithms 1–3).
//!
//! The tracker follows *blobs*: things that have a region each. An *object* is somebody with an
//! identity; a blob carries one object, or several while they share its region. Events come from
//! how this partition changes from frame to frame.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use nalgebra::Vector3;

use super::assign::{self, Fit, Piece};
use super::coherence::Fragment;
use super::event::{Comparison, Counters, Episode, Event, EventKind, Evidence};
use super::groups::{Cause, Groups};
use super::hidden::{self, Hidden, Return};
use super::meetings::Meetings;
use super::object::{Object, View, close_to};
use super::partition::{self, Cluster, Expected, Extent};
use super::perspective::Perspective;
use super::splits::Split;
use crate::frame::Size;
use crate::regions::{Rect, Region};
use crate::settings::{Settings, Switch};
use crate::tracking::fragments::group_fragments;
use crate::tracking::kalman::Model;
use crate::tracking::pool::{Blob, Observation, PoolSettings};
use crate::tracking::seeds::{Candidate, Seeds};
use crate::tracking::{Identity, Key, Naming, Track};

/// A member of which nothing was seen for more frames than this need not be in its group's region.
const COASTS: u32 = 2;

/// A new object tells of at most so many hidden ones that it was not taken for.
const MOST_REFUSED: usize = 3;

/// Identities of ended objects are dropped once there are about as many of them as of active ones.
const FORGOTTEN_AT_ONCE: usize = 64;

/// Regions down to this share of `track_min_area` can be fragments of a detection.
const MIN_FRAGMENT_SHARE: f32 = 0.3;

/// An object's number, from its first region on; never used again.
pub type ObjectId = u32;

/// A blob and the objects that it carries.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    pub(super) blob: Blob,
    /// The detection in its gate that the tracker's best reading gives it in this frame.
    pub(super) matched: Option<usize>,
    /// By rising number; several while they share the region.
    pub(super) members: Vec<ObjectId>,
    /// How it is seen in this frame, `None` while it is lost.
    pub(super) view: Option<View>,
    /// The frame's number and t of the first frame without a region.
    pub(super) lost_from: Option<(u32, u32)>,
    /// For how many frames its region has been far larger than all its members together.
    pub(super) oversized: u32,
}

impl Carried {
    /// A blob as it is seen.
    const fn new(blob: Blob, members: Vec<ObjectId>, view: View) -> Self {
        Self { blob, matched: None, members, view: Some(view), lost_from: None, oversized: 0 }
    }
}

/// Detections that are parts of one thing.
struct Parts {
    detections: Vec<usize>,
    /// They together.
    view: View,
}

impl Parts {
    /// Whether they are the one detection that the tracker matched.
    fn is_just(&self, matched: Option<usize>) -> bool {
        matches!((&self.detections[..], matched), ([only], Some(matched)) if *only == matched)
    }
}

/// Times and lengths of `settings` in frames and pixels of this video.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) least_area: f32,
    pub(super) border: f32,
    pub(super) min_track: u32,
    pub(super) max_hidden: u32,
    pub(super) same_episode: u32,
    /// Frames without a region after which it is believed that there is none.
    pub(super) patience: u32,
    /// Frames for which a region has to show more heads than objects.
    pub(super) heads: u32,
    /// Frames after which what seemed a part is believed to be the whole: it walked away, or sat down.
    pub(super) relearn: u32,
    /// Frames after which somebody whom the image edge still cuts off gets an identity.
    pub(super) at_edge: u32,
    /// Frames for which an object of which nothing is seen is told where it is predicted.
    pub(super) told: u32,
    /// Frames a second.
    pub(super) second: f32,
}

/// What is said of one frame.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Objects with an identity, by identity: the causal reading.
    pub tracks: Vec<Track>,
    /// Objects without one yet.
    pub tentative: Vec<Track>,
    /// All objects under their keys.
    pub objects: Vec<Track>,
    /// Events decided in this frame, by frame and kind.
    pub events: Vec<Event>,
    /// What was decided in this frame of those before it.
    pub settled: Settled,
}

/// Results that later frames cannot change, returned once.
#[derive(Clone, Debug, Default)]
pub struct Settled {
    /// Who turned out to be who; a later decision overrules an earlier one.
    pub names: Vec<(Key, Identity)>,
    /// Occlusions that are over.
    pub episodes: Vec<Episode>,
    /// New objects as they were in the frames before the one in which they were found, with these frames' numbers.
    pub earlier: Vec<(u32, Track)>,
}

/// The last of a sequence.
#[derive(Clone, Debug, Default)]
pub struct Ending {
    /// Events decided after the last frame, by frame and kind.
    pub events: Vec<Event>,
    /// What else was open until then.
    pub settled: Settled,
}

/// Follows objects through a sequence.
#[derive(Clone)]
pub struct Reasoner {
    pub(super) settings: Settings,
    pub(super) pool: PoolSettings,
    pub(super) limits: Limits,
    pub(super) size: Size,
    /// Frames taken in so far, and the present frame's number.
    pub(super) t: u32,
    pub(super) number: u32,
    pub(super) carried: Vec<Carried>,
    pub(super) objects: BTreeMap<ObjectId, Object>,
    pub(super) hidden: Vec<Hidden>,
    pub(super) returns: Vec<Return>,
    /// Where the scene has hidden objects that came back.
    pub(super) occluders: Vec<Rect>,
    pub(super) splits: Vec<Split>,
    pub(super) groups: Groups,
    pub(super) meetings: Meetings,
    /// Occlusions by the scene that are over and have not been told yet.
    pub(super) episodes: Vec<Episode>,
    pub(super) naming: Naming,
    /// New objects in the frames before this one, which have not been told yet.
    earlier: Vec<(u32, Track)>,
    /// The identities of the objects of which something may still be told.
    identities: BTreeMap<ObjectId, u32>,
    pub(super) events: Vec<Event>,
    perspective: Perspective,
    seeds: Seeds,
    counters: Counters,
    last_id: u32,
    /// Of the last frames, the number and how many regions stood for objects: the paper's counters.
    with_region: VecDeque<(u32, u32)>,
    /// Frame numbers of the last three frames.
    recent: [u32; 3],
}

impl Reasoner {
    /// A reasoner that has seen nothing, for frames of `size` at `fps` frames a second.
    pub fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        let limits = Limits {
            least_area: settings.track_min_area / 100.0 * size.pixels() as f32,
            border: settings.border / 100.0 * size.shorter_side() as f32,
            min_track: settings.min_track.frames(fps),
            max_hidden: settings.max_hidden.frames(fps),
            same_episode: settings.same_episode.frames(fps),
            patience: ((0.2 * fps).round() as u32).max(3),
            heads: ((0.3 * fps).round() as u32).max(3),
            relearn: ((1.5 * fps).round() as u32).max(10),
            told: settings.predict_for.frames(fps),
            second: fps.max(1.0),
            at_edge: (fps.round() as u32).max(settings.min_track.frames(fps)),
        };
        Self {
            settings: settings.clone(),
            pool: PoolSettings::new(settings, fps),
            limits,
            size,
            t: 0,
            number: 0,
            carried: Vec::new(),
            objects: BTreeMap::new(),
            hidden: Vec::new(),
            returns: Vec::new(),
            occluders: Vec::new(),
            splits: Vec::new(),
            groups: Groups::default(),
            meetings: Meetings::default(),
            episodes: Vec::new(),
            naming: Naming::default(),
            earlier: Vec::new(),
            identities: BTreeMap::new(),
            events: Vec::new(),
            perspective: Perspective::default(),
            seeds: Seeds::default(),
            counters: Counters::default(),
            last_id: 0,
            with_region: VecDeque::new(),
            recent: [0; 3],
        }
    }

    /// Takes in the regions of the next frame, whose number is `number`.
    pub fn step(&mut self, number: u32, regions: &[Region]) -> Seen {
        self.t += 1;
        self.number = number;
        self.recent = [self.recent[1], self.recent[2], number];
        self.predict();
        let views = self.detections(regions);
        self.match_blobs(&views);
        let mut unexplained = Vec::new();
        for cluster in self.cluster(&views) {
            self.resolve(&cluster, &views, &mut unexplained);
        }
        self.carried.retain(|carried| !carried.members.is_empty());
        self.follow_manoeuvres(&views, &mut unexplained);
        self.seed(&views, &unexplained);
        self.count_objects();
        self.follow_objects();
        if self.settings.count_heads == Switch::On {
            self.count_heads();
        }
        if self.settings.find_again == Switch::On {
            self.find_again();
        }
        self.correct_sizes();
        self.judge_members();
        self.judge_lost();
        self.name_objects();
        self.judge_hidden();
        self.follow_splits();
        self.follow_groups();
        self.follow_meetings();
        let seen = self.tell();
        self.forget_names();
        seen
    }

    /// Decides what is still open after the last frame: groups that split, objects that came back, left or were lost a
    /// moment before the end.
    pub fn finish(&mut self) -> Ending {
        while let Some(members) = self.splits.first().map(|split| split.members.clone()) {
            for id in members {
                self.settle_splits_of(id);
            }
        }
        let returned: Vec<ObjectId> = self.returns.iter().map(|returned| returned.id).collect();
        for id in returned {
            self.tell_return_of(id);
        }
        self.judge_lost_at_end();
        self.follow_groups();
        self.meetings.close_all();
        Ending { events: self.count_told(), settled: self.take_settled() }
    }

    /// What was settled since this was last asked.
    pub(super) fn take_settled(&mut self) -> Settled {
        let identities = &self.identities;
        let mut episodes = self.meetings.take_closed(|id| identities.get(&id).copied());
        episodes.append(&mut self.episodes);
        Settled { names: self.naming.take_decided(), episodes, earlier: std::mem::take(&mut self.earlier) }
    }

    /// Forgets the names of those of whom nothing can be told any more, when they are many.
    fn forget_names(&mut self) {
        if self.identities.len() > 2 * self.objects.len() + FORGOTTEN_AT_ONCE {
            let (objects, meetings, splits) = (&self.objects, &self.meetings, &self.splits);
            let open = |id: ObjectId| splits.iter().any(|split| split.members.contains(&id));
            self.identities.retain(|&id, _| objects.contains_key(&id) || meetings.hold(id) || open(id));
        }
        if self.naming.len() > 2 * self.objects.len() + FORGOTTEN_AT_ONCE {
            let keys: BTreeSet<Key> = self.objects.values().map(|object| object.key).collect();
            self.naming.retain(|key| keys.contains(&key));
        }
    }

    /// Events so far, by kind.
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// How much is remembered, in things of all kinds: what must not grow with the time.
    pub fn remembered(&self) -> usize {
        let scene = self.objects.len() + self.carried.len() + self.hidden.len() + self.occluders.len();
        let open = self.returns.len() + self.splits.len() + self.groups.len() + self.meetings.len();
        let untold = self.events.len() + self.episodes.len() + self.earlier.len();
        let names = self.identities.len() + self.naming.len();
        scene + open + untold + names + self.with_region.len() + self.seeds.len()
    }

    /// The memory a copy takes, roughly, in bytes.
    pub fn state_bytes(&self) -> usize {
        size_of::<Self>()
            + self.objects.len() * (size_of::<Object>() + 4096)
            + self.carried.len() * (size_of::<Carried>() + 2048)
            + self.hidden.len() * size_of::<Hidden>()
            + self.returns.len() * (size_of::<Return>() + 512)
            + self.occluders.len() * size_of::<Rect>()
            + self.splits.len() * (size_of::<Split>() + 4096)
            + self.episodes.len() * (size_of::<Episode>() + 16)
            + self.events.len() * (size_of::<Event>() + 512)
            + self.with_region.len() * size_of::<(u32, u32)>()
            + self.seeds.len() * size_of::<Candidate>()
            + (self.identities.len() + self.naming.len()) * 16
            + self.meetings.bytes()
    }

    /// The identity of an object, also of one that is gone and of which something is still to be told.
    pub(super) fn identity(&self, id: ObjectId) -> Option<u32> {
        self.identities.get(&id).copied()
    }

    /// Some objects, in the order of their numbers here.
    pub(super) fn objects_of<'a>(&'a self, ids: &'a [ObjectId]) -> impl Iterator<Item = &'a Object> + Clone {
        ids.iter().filter_map(|id| self.objects.get(id))
    }

    /// Whether an object has an identity.
    pub(super) fn is_named(&self, id: ObjectId) -> bool {
        self.objects.get(&id).is_some_and(|object| object.named)
    }

    /// Whether a box is near the image edge.
    pub(super) fn near_border(&self, bbox: &Rect) -> bool {
        bbox.distance_to_edge(self.size) <= self.limits.border
    }

    pub(super) const fn new_key(&mut self) -> u32 {
        self.last_id += 1;
        self.last_id
    }

    /// Ends an object: nothing that is followed, merged or occluded refers to it any more. Blobs always hold objects that
    /// exist, as this is the only way in which one that is followed is removed.
    pub(super) fn end_object(&mut self, id: ObjectId) -> Option<Object> {
        for carried in &mut self.carried {
            carried.members.retain(|member| *member != id);
        }
        self.leave_group(id);
        self.hidden.retain(|hidden| hidden.id != id);
        self.objects.remove(&id)
    }

    fn predict(&mut self) {
        for carried in &mut self.carried {
            carried.view = None;
            carried.blob.predict();
        }
        let shared: Vec<ObjectId> = self
            .carried
            .iter()
            .filter(|carried| carried.members.len() > 1)
            .flat_map(|carried| carried.members.iter().copied())
            .chain(self.hidden.iter().map(|hidden| hidden.id))
            .collect();
        for id in shared {
            if let Some(object) = self.objects.get_mut(&id) {
                object.go_on();
            }
        }
        for carried in &self.carried {
            if let [alone] = carried.members[..]
                && let Some(object) = self.objects.get_mut(&alone)
            {
                if object.partial > 0 {
                    object.go_on();
                } else {
                    object.follow(&carried.blob.shown().model);
                }
            }
        }
        if self.settings.perspective == Switch::On {
            for object in self.objects.values_mut() {
                object.rescale(&self.perspective);
            }
        }
    }

    /// The frame's detections: its regions, fragments of one object taken together.
    fn detections(&self, regions: &[Region]) -> Vec<View> {
        let fragments: Vec<View> = regions
            .iter()
            .filter(|region| region.shape.area as f32 >= MIN_FRAGMENT_SHARE * self.limits.least_area)
            .map(view)
            .collect();
        let observed: Vec<(Rect, f32)> = fragments.iter().map(|view| (view.bbox, view.area)).collect();
        let predicted: Vec<Rect> = self
            .carried
            .iter()
            .map(|carried| {
                let boxes = self.objects_of(&carried.members).map(Object::predicted_box);
                boxes.reduce(|a, b| a.union(&b)).unwrap_or(carried.blob.bbox)
            })
            .collect();
        let owner = |(bbox, _): &(Rect, f32)| {
            let held = predicted.iter().map(|expected| partition::held_share(bbox, expected)).enumerate();
            held.filter(|(_, share)| *share >= 0.5).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
        };
        let owners: Vec<Option<usize>> = observed.iter().map(owner).collect();
        let groups = group_fragments(&observed, &owners, self.settings.fragment_gap);
        let joined = groups.iter().map(|group| {
            let parts: Vec<&View> = group.iter().filter_map(|&index| fragments.get(index)).collect();
            View::join(&parts)
        });
        joined.filter(|view| view.area >= self.limits.least_area).collect()
    }

    /// The tracker's own matches.
    fn match_blobs(&mut self, views: &[View]) {
        let observations: Vec<Observation> = views.iter().map(View::observation).collect();
        let mut blobs: Vec<Blob> = self.carried.iter().map(|carried| carried.blob.clone()).collect();
        let matched = self.pool.match_observations(&mut blobs, &observations);
        for ((carried, blob), matched) in self.carried.iter_mut().zip(blobs).zip(matched) {
            carried.blob = blob;
            carried.matched = matched;
        }
    }

    fn cluster(&self, views: &[View]) -> Vec<Cluster> {
        let expected: Vec<Expected> = self
            .carried
            .iter()
            .map(|carried| {
                let group = carried.members.len() > 1;
                let members = self.objects_of(&carried.members);
                let predicted = members.clone().map(Object::predicted_box).reduce(|a, b| a.union(&b));
                let predicted = predicted.unwrap_or(carried.blob.bbox);
                Expected {
                    bbox: match (group, carried.matched) {
                        (false, None) => predicted,
                        _ => carried.blob.bbox.union(&predicted),
                    },
                    area: members.map(Object::area).fold(0.0, f32::max),
                    matched: carried.matched,
                    group,
                }
            })
            .collect();
        let observed: Vec<(Rect, f32)> = views.iter().map(|view| (view.bbox, view.area)).collect();
        partition::clusters(&expected, &observed, self.settings.size_step)
    }

    /// Decides which of the cluster's objects are in which of its regions.
    fn resolve(&mut self, cluster: &Cluster, views: &[View], unexplained: &mut Vec<usize>) {
        if cluster.blobs.is_empty() || cluster.observations.is_empty() {
            unexplained.extend(&cluster.observations);
            return;
        }
        let pieces = self.pieces(cluster, views);
        let cluster = &self.without_noise(cluster, pieces.len());
        let members = self.members_of(&cluster.blobs);
        if cluster.blobs.len() > 1 || (pieces.len() > 1 && members.len() > 1) {
            self.settle_before_meeting(&members, pieces.len());
        }
        let members = self.members_of(&cluster.blobs);
        let mut pieces = if members.len() == 1 { self.pieces(cluster, views) } else { pieces };
        match (&members[..], &cluster.blobs[..], pieces.len()) {
            (&[only], &[blob], _) => self.follow_one(blob, only, pieces, unexplained),
            (_, _, 1) => {
                if let Some(piece) = pieces.pop() {
                    self.gather(cluster, members, &piece);
                }
            }
            _ => self.part(cluster, &members, pieces, unexplained),
        }
    }

    /// Gives an object that is alone the piece that it is.
    fn follow_one(
        &mut self,
        blob: usize,
        id: ObjectId,
        mut pieces: Vec<Parts>,
        unexplained: &mut Vec<usize>,
    ) {
        let Some(best) = self.best_piece(blob, &pieces) else { return };
        let mine = pieces.remove(best);
        self.give(blob, vec![id], &mine);
        let extent = self.extent(&[id]);
        let size = |piece: &Parts| (piece.view.bbox, piece.view.area);
        let beside = pieces.iter().any(|other| partition::beside(&size(&mine), &size(other), extent));
        if let Some(object) = self.objects.get_mut(&id) {
            object.note_beside(beside);
        }
        unexplained.extend(pieces.into_iter().flat_map(|other| other.detections));
    }

    /// The cluster's regions, those that are parts of one thing taken together.
    fn pieces(&self, cluster: &Cluster, views: &[View]) -> Vec<Parts> {
        let members = self.members_of(&cluster.blobs);
        let local: Vec<(usize, &View)> =
            cluster.observations.iter().filter_map(|&index| Some((index, views.get(index)?))).collect();
        let observed: Vec<(Rect, f32)> = local.iter().map(|(_, view)| (view.bbox, view.area)).collect();
        let only = match members[..] {
            [only] => self.carried_of(&cluster.blobs).next().map(|carried| (only, carried.blob.bbox)),
            _ => None,
        };
        let inside =
            only.and_then(|(only, bbox)| Some(self.objects.get(&only)?.predicted_box().union(&bbox)));
        let whole = |piece: Vec<usize>| {
            let parts = || piece.iter().filter_map(|&index| local.get(index));
            let views: Vec<&View> = parts().map(|(_, view)| *view).collect();
            Parts { detections: parts().map(|(index, _)| *index).collect(), view: View::join(&views) }
        };
        partition::pieces(&observed, self.extent(&members), inside).into_iter().map(whole).collect()
    }

    /// What some blobs carry.
    fn carried_of<'a>(&'a self, blobs: &'a [usize]) -> impl Iterator<Item = &'a Carried> {
        blobs.iter().filter_map(|&blob| self.carried.get(blob))
    }

    /// The objects of some blobs, by rising number.
    fn members_of(&self, blobs: &[usize]) -> Vec<ObjectId> {
        let mut members: Vec<ObjectId> =
            self.carried_of(blobs).flat_map(|carried| carried.members.iter().copied()).collect();
        members.retain(|id| self.objects.contains_key(id));
        members.sort_unstable();
        members
    }

    /// Who of some objects stays when they come to share a region: those with an identity, and the
    /// oldest where nobody has one. Noise that touches somebody is no meeting.
    fn known_of(&self, members: &[ObjectId]) -> Vec<ObjectId> {
        let named: Vec<ObjectId> = members.iter().copied().filter(|&id| self.is_named(id)).collect();
        if named.is_empty() { members.iter().take(1).copied().collect() } else { named }
    }

    /// The cluster without the blobs of objects that are none. Where there are fewer pieces than
    /// blobs, those without an identity give way.
    fn without_noise(&mut self, cluster: &Cluster, pieces: usize) -> Cluster {
        let mut cluster = cluster.clone();
        if cluster.blobs.len() < 2 || pieces >= cluster.blobs.len() {
            return cluster;
        }
        let members = self.members_of(&cluster.blobs);
        let keep = self.known_of(&members);
        for &id in members.iter().filter(|id| !keep.contains(id)) {
            self.end_object(id);
        }
        cluster.blobs.retain(|&blob| self.carried.get(blob).is_some_and(|it| !it.members.is_empty()));
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

    /// Which piece a lone object is: the one that the tracker took, else the one it overlaps most.
    fn best_piece(&self, blob: usize, pieces: &[Parts]) -> Option<usize> {
        let carried = self.carried.get(blob)?;
        let holds_match =
            pieces.iter().position(|it| carried.matched.is_some_and(|at| it.detections.contains(&at)));
        holds_match.or_else(|| {
            let expected = self.objects.get(carried.members.first()?)?.predicted_box();
            let overlaps =
                pieces.iter().map(|piece| expected.intersection(&piece.view.bbox).area()).enumerate();
            overlaps.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|(at, _)| at)
        })
    }

    /// Gives a blob its region and its members. Where the tracker took just this region its hypotheses stand; otherwise
    /// the model is corrected from outside.
    fn give(&mut self, blob: usize, members: Vec<ObjectId>, piece: &Parts) {
        let view = &piece.view;
        let measured = view.observation();
        let whole = match members[..] {
            [only] => self.objects.get(&only).is_none_or(|object| object.is_nearly_whole(view)),
            _ => true,
        };
        let cut_off = self.near_border(&view.bbox);
        let Some(carried) = self.carried.get_mut(blob) else { return };
        carried.members = members;
        carried.view = Some(view.clone());
        if piece.is_just(carried.matched) {
            return;
        }
        let fits =
            carried.blob.shown().model.distance_squared(&measured.measurement()) <= 4.0 * self.pool.gate;
        carried.blob.settle(&measured, |model| {
            if fits && whole && !cut_off {
                model.update(&measured.measurement(), 2.0);
            } else {
                // A part of it, or cut off by the image edge: the box's centre moves as the whole
                // does not, so that the velocity stays as it was last seen clearly.
                let velocity = model.velocity();
                model.stand_at(&measured.measurement());
                model.set_velocity(Vector3::new(velocity.x, velocity.y, 0.0));
            }
        });
    }

    /// All the cluster's objects are in one region: a group goes on, or objects have merged.
    fn gather(&mut self, cluster: &Cluster, members: Vec<ObjectId>, piece: &Parts) {
        let Some((&first, others)) = cluster.blobs.split_first() else { return };
        if others.is_empty() {
            self.give(first, members, piece);
            return;
        }
        let view = &piece.view;
        self.note_meeting(&cluster.blobs, &members, view);
        self.clear_blobs(others);
        let model = self.group_model(&members, view);
        if let Some(carried) = self.carried.get_mut(first) {
            carried.blob = Blob::new(model, &view.observation());
            carried.members = members;
            carried.view = Some(view.clone());
        }
    }

    /// Takes the objects out of these blobs: they are in others.
    fn clear_blobs(&mut self, blobs: &[usize]) {
        for &blob in blobs {
            if let Some(carried) = self.carried.get_mut(blob) {
                carried.members.clear();
            }
        }
    }

    fn group_model(&self, members: &[ObjectId], view: &View) -> Model {
        let mean = self.objects_of(members).map(|object| object.model.velocity()).sum::<Vector3<f32>>()
            / members.len().max(1) as f32;
        let velocity = Vector3::new(mean.x, mean.y, 0.0);
        Model::new(view.observation().measurement(), velocity, self.pool.noise.measurement, self.pool.noise)
    }

    /// Notes why the objects of these blobs share a region.
    fn note_meeting(&mut self, blobs: &[usize], members: &[ObjectId], view: &View) {
        let largest = |carried: &Carried| {
            self.objects_of(&carried.members).map(|object| object.last.area).fold(0.0, f32::max)
        };
        let before: f32 = self.carried_of(blobs).map(largest).fold(0.0, f32::max);
        let grown = view.area / before.max(1.0) - 1.0;
        let step = self.settings.size_step;
        let mut evidence = Evidence::of_branch(format!(
            "{} objects with separate regions now share one of {:.0} pixels, {:+.0} % relative to the \
             largest of them",
            blobs.len(),
            view.area,
            100.0 * grown,
        ));
        evidence.at_least("region growth", grown, step);
        for &id in members {
            let Some(object) = self.objects.get(&id) else { continue };
            let held = partition::held_share(&object.predicted_box(), &view.bbox);
            let whose = self.identity(id).unwrap_or_default();
            evidence.at_least(format!("share of the predicted box of {whose} inside the region"), held, 0.5);
        }
        let cause = Cause { frame: self.number, at: view.bbox.centre(), evidence };
        for &id in members {
            self.groups.note_joining(id, cause.clone());
        }
    }

    /// Several objects and several pieces: who is where now, and what that says has happened.
    fn part(
        &mut self,
        cluster: &Cluster,
        members: &[ObjectId],
        pieces: Vec<Parts>,
        unexplained: &mut Vec<usize>,
    ) {
        let before: Vec<(usize, Vec<ObjectId>)> = cluster
            .blobs
            .iter()
            .filter_map(|&blob| Some((blob, self.carried.get(blob)?.members.clone())))
            .collect();
        let in_group: Vec<bool> = members
            .iter()
            .map(|id| before.iter().any(|(_, group)| group.len() > 1 && group.contains(id)))
            .collect();
        let objects: Vec<&Object> = self.objects_of(members).collect();
        let unsure: Vec<f32> =
            members.iter().zip(&in_group).map(|(&id, &group)| self.unsureness(id, group)).collect();
        let parts: Vec<Piece> = pieces.iter().map(|piece| piece_of(&piece.view)).collect();
        let fits = assign::fits(&objects, &unsure, &parts, &self.settings);
        let assigned = assign::assign(&fits, &objects, &parts, &in_group);

        let mut blobs: Vec<(usize, Carried)> = Vec::new();
        for (number, piece) in pieces.into_iter().enumerate() {
            let here: Vec<ObjectId> =
                members.iter().zip(&assigned).filter(|(_, at)| **at == number).map(|(&id, _)| id).collect();
            if here.is_empty() {
                unexplained.extend(&piece.detections);
                continue;
            }
            let known = self.known_of(&here);
            for &id in here.iter().filter(|id| !known.contains(id)) {
                self.end_object(id);
            }
            let (here, view) = (known, piece.view);
            let observed = view.observation();
            let alone = match here[..] {
                [only] => self.objects.get(&only).map(|object| object.model.clone()),
                _ => None,
            };
            let model = alone.map_or_else(
                || self.group_model(&here, &view),
                |mut model| {
                    model.stand_at(&observed.measurement());
                    model
                },
            );
            let blob = Blob::new(model, &observed);
            blobs.push((number, Carried::new(blob, here, view)));
        }
        for (_, joined) in &blobs {
            let from = before.iter().filter(|(_, group)| joined.members.iter().any(|id| group.contains(id)));
            let from: Vec<usize> = from.map(|(blob, _)| *blob).collect();
            if from.len() > 1
                && let Some(view) = &joined.view
            {
                self.note_meeting(&from, &joined.members, view);
            }
        }
        let fits: BTreeMap<ObjectId, Vec<Fit>> = members.iter().copied().zip(fits).collect();
        for (_, group) in before.iter().filter(|(_, group)| group.len() > 1) {
            self.start_split(group, &blobs, &fits);
        }
        self.clear_blobs(&cluster.blobs);
        self.carried.extend(blobs.into_iter().map(|(_, carried)| carried));
    }

    /// How far an object's prediction may be off: little while it was alone, more the longer it
    /// has been in a group.
    pub(super) fn unsureness(&self, id: ObjectId, in_group: bool) -> f32 {
        let Some(object) = self.objects.get(&id) else { return 0.0 };
        let (_, height) = object.size();
        let apart = match object.template {
            _ if !in_group => 0.0,
            Some(_) => object.unseen as f32,
            None => self.meetings.duration_of(id, self.t) as f32,
        };
        let velocity = object.model.velocity();
        0.15 * height + 0.25 * velocity.x.hypot(velocity.y) * apart
    }

    /// Gives objects that are lost in this frame the regions that nothing explains, where a manoeuvre can have taken
    /// them there.
    fn follow_manoeuvres(&mut self, views: &[View], unexplained: &mut Vec<usize>) {
        let lost = |carried: &&mut Carried| carried.view.is_none() && carried.members.len() == 1;
        let mut lost: Vec<&mut Carried> = self.carried.iter_mut().filter(lost).collect();
        let free: Vec<(usize, &View, Observation)> = unexplained
            .iter()
            .filter_map(|&index| views.get(index).map(|view| (index, view, view.observation())))
            .collect();
        let blobs: Vec<&Blob> = lost.iter().map(|carried| &carried.blob).collect();
        let observations: Vec<&Observation> = free.iter().map(|(.., observed)| observed).collect();
        let mut taken = Vec::new();
        for (row, column) in self.pool.match_manoeuvres(&blobs, &observations) {
            let (Some(carried), Some((index, view, observed))) = (lost.get_mut(row), free.get(column)) else {
                continue;
            };
            PoolSettings::manoeuvre(&mut carried.blob, observed);
            carried.view = Some(View::clone(view));
            taken.push(*index);
        }
        unexplained.retain(|index| !taken.contains(index));
    }

    /// New models for what nothing explains.
    fn seed(&mut self, views: &[View], unexplained: &[usize]) {
        let candidate = |&index: &usize| {
            let view = views.get(index)?;
            Some(Candidate { index, observation: view.observation(), labels: view.labels.clone() })
        };
        for seed in self.seeds.step(&self.pool, unexplained.iter().filter_map(candidate).collect()) {
            let Some(view) = views.get(seed.index).cloned() else { continue };
            let id = self.new_key();
            let birth = (self.recent[0], seed.earlier[0].observation.bbox);
            let mut object = Object::new(id, birth, seed.model.clone(), view.clone());
            // Two frames before this one, which counts when it is followed below.
            object.seen = 2;
            for (number, earlier) in self.recent.into_iter().zip(&seed.earlier) {
                // What comes in first is often a foot or an arm.
                if earlier.observation.bbox.distance_to_edge(self.size) <= 1.0 {
                    continue;
                }
                let track = self.earlier_track(&object, earlier);
                self.earlier.push((number, track));
            }
            self.objects.insert(id, object);
            let blob = Blob::new(seed.model, &view.observation());
            self.carried.push(Carried::new(blob, vec![id], view));
        }
    }

    fn count_objects(&mut self) {
        let stands_for_objects = |carried: &&Carried| {
            carried.view.is_some() && carried.members.iter().any(|&id| self.is_named(id))
        };
        let now = self.carried.iter().filter(stands_for_objects).count();
        // An event is told at most as long after its frame as who is hidden is waited for.
        if self.with_region.len() > self.limits.max_hidden as usize + 1 {
            self.with_region.pop_front();
        }
        self.with_region.push_back((self.number, now as u32));
    }

    /// How many regions stood for objects in the frame before the frame with this number, and in it.
    fn counted_at(&self, number: u32) -> (u32, u32) {
        let at = self.with_region.partition_point(|(counted, _)| *counted < number);
        let count =
            |at: Option<usize>| at.and_then(|at| self.with_region.get(at)).map_or(0, |(_, count)| *count);
        (count(at.checked_sub(1)), count(Some(at)))
    }

    /// Each object's own motion and looks, from how its blob is seen.
    fn follow_objects(&mut self) {
        for index in 0..self.carried.len() {
            let Some(carried) = self.carried.get(index) else { break };
            if let [alone] = carried.members[..] {
                let model = carried.blob.shown().model.clone();
                let view = carried.view.clone();
                let cut_off = view.as_ref().is_some_and(|view| self.near_border(&view.bbox));
                let undecided = self.splits.iter().any(|split| split.is_undecided(alone));
                let (relearn, at_last) = (self.limits.relearn, self.limits.max_hidden);
                let mut part = None;
                if let Some(object) = self.objects.get_mut(&alone) {
                    match view {
                        Some(view)
                            if !object.is_nearly_whole(&view)
                                && (object.partial < relearn
                                    || !object.went_far(&view) && object.partial < at_last) =>
                        {
                            object.see_part(&view);
                            part = Some(view);
                        }
                        Some(view) => {
                            object.follow(&model);
                            if object.partial >= relearn {
                                object.relearn(&view, &self.settings);
                            } else if let Some(clear) = &object.clear
                                && !cut_off
                            {
                                let [_, y] = view.bbox.centre();
                                self.perspective.see(y, view.bbox.h, clear.y, clear.h);
                            }
                            if undecided {
                                object.seen += 1;
                                object.partial = 0;
                            } else {
                                object.see(&view, cut_off, &self.settings);
                            }
                        }
                        None => object.miss(),
                    }
                }
                if let Some(view) = part {
                    self.place_members(&[alone], &view);
                }
            } else if let Some(view) = carried.view.clone() {
                let members = carried.members.clone();
                self.hold_inside(&members, &view.bbox);
                self.place_members(&members, &view);
            }
        }
    }

    /// Keeps the predictions of a group's members inside its region. Where the region is wider than
    /// anybody in it, its left and right edge are those of the outermost members.
    fn hold_inside(&mut self, members: &[ObjectId], region: &Rect) {
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
            object.seen += 1;
            if object.unseen > COASTS {
                object.slow_down();
                continue;
            }
            let (w, h) = object.size();
            let [x, y] = object.model.centre();
            let [middle_x, middle_y] = region.centre();
            let mut centre =
                [close_to(middle_x, (region.w - w) / 2.0, x), close_to(middle_y, (region.h - h) / 2.0, y)];
            if spread && Some(id) == leftmost {
                centre[0] = f32::midpoint(centre[0], region.x + w / 2.0);
            }
            if spread && Some(id) == rightmost {
                centre[0] = f32::midpoint(centre[0], region.right() - w / 2.0);
            }
            object.hold_at(centre);
        }
    }

    /// Forgets new objects within the full extent of somebody of whom only a part is seen: they are
    /// more of the same.
    fn absorb_parts(&mut self) {
        let extents: Vec<Rect> = self
            .carried
            .iter()
            .filter_map(|carried| match carried.members[..] {
                [alone] => self.objects.get(&alone),
                _ => None,
            })
            .filter(|object| object.named && object.partial > 0)
            .map(Object::predicted_box)
            .collect();
        let objects = &mut self.objects;
        self.carried.retain(|carried| {
            let (&[id], Some(view)) = (&carried.members[..], &carried.view) else { return true };
            let part = objects.get(&id).is_some_and(|object| !object.named)
                && extents.iter().any(|extent| partition::held_share(&view.bbox, extent) >= 0.5);
            if part {
                objects.remove(&id);
            }
            !part
        });
    }

    /// Objects that have been seen often enough get their identity, and their beginning is told.
    fn name_objects(&mut self) {
        self.absorb_parts();
        let due: Vec<ObjectId> = self
            .objects
            .iter()
            .filter(|(_, object)| !object.named && object.seen >= self.limits.min_track)
            // What comes in first is often a foot or an arm, and there is another beside it.
            .filter(|(_, object)| {
                object.seen >= self.limits.at_edge || object.last.bbox.distance_to_edge(self.size) > 1.0
            })
            .map(|(&id, _)| id)
            .collect();
        for id in due {
            // Another one of them may have ended it, or named it.
            let open = self.objects.get(&id).is_some_and(|object| !object.named);
            if !open || self.must_be_seen_better(id) {
                continue;
            }
            match self.as_fragment(id) {
                Some(Fragment::Open) => {}
                Some(Fragment::Of { whole, view, evidence }) => self.join_fragment(id, whole, view, evidence),
                None if self.objects.get(&id).is_some_and(Object::has_moved) => self.name_object(id),
                // Who is already known may stand still.
                None => {
                    self.recognise(id);
                }
            }
        }
    }

    /// Whether an object without an identity is one that was hidden or not seen in its group. It then goes on as that one.
    fn recognise(&mut self, id: ObjectId) -> bool {
        let known = self.reappears(id) || self.comes_out(id);
        if known {
            self.absorb_parts();
        }
        known
    }

    /// Assigns an identity to an object, and emits its first event where the identity is new.
    pub(super) fn name_object(&mut self, id: ObjectId) {
        if self.recognise(id) {
            return;
        }
        let Some(object) = self.objects.get_mut(&id) else { return };
        object.named = true;
        let identity = self.naming.name(object.key);
        self.identities.insert(id, identity);
        let (born, birthplace) = (object.born, object.birthplace);
        let fragments = std::mem::take(&mut object.fragments);
        let distance = birthplace.distance_to_edge(self.size);
        let near = distance <= self.limits.border;
        let kind = if near { EventKind::Enter } else { EventKind::Appear };
        let branch = if near {
            "new object, first detected near the image edge"
        } else {
            "new object away from the image edge; no occluded object matches and no group shrank"
        };
        let mut evidence = Evidence::of_branch(branch);
        if near {
            evidence.at_most("distance to image edge, pixels", distance, self.limits.border);
        } else {
            evidence.at_least("distance to image edge, pixels", distance, self.limits.border);
            self.note_refused(&birthplace, &mut evidence);
        }
        evidence.comparisons.extend(fragments);
        let event = Event::of_one(born, kind, identity, birthplace.centre(), evidence);
        self.push_event(&[id], event);
    }

    /// Notes which hidden objects a new one was not taken for, the nearest first: how far from where each may be.
    fn note_refused(&self, birthplace: &Rect, evidence: &mut Evidence) {
        let mut refused: Vec<(f32, f32, u32)> = self
            .hidden
            .iter()
            .filter_map(|hidden| {
                let past = self.objects.get(&hidden.id)?;
                let distance = assign::outside(&past.predicted_box(), birthplace);
                Some((distance, hidden::reach(past, self.t - hidden.since.1), self.identity(hidden.id)?))
            })
            .collect();
        refused.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (distance, reach, identity) in refused.into_iter().take(MOST_REFUSED) {
            let place = Comparison::at_least(
                format!("distance to predicted position of occluded {identity}, pixels"),
                distance,
                reach,
            );
            evidence.comparisons.push(place.of_alternative(false));
        }
    }

    /// Notes who shares a region with whom.
    fn follow_meetings(&mut self) {
        let groups: Vec<(Vec<(ObjectId, f32)>, bool)> = self
            .carried
            .iter()
            .filter(|carried| carried.members.len() > 1)
            .map(|carried| {
                let boxes: Vec<Rect> = self.objects_of(&carried.members).map(Object::predicted_box).collect();
                let overlapping = boxes.iter().enumerate().any(|(index, a)| {
                    boxes.iter().skip(index + 1).any(|b| partition::held_share(a, b) >= 0.3)
                });
                let shares =
                    carried.members.iter().map(|&id| (id, self.share_in_group(id, carried))).collect();
                (shares, overlapping)
            })
            .collect();
        for (members, overlapping) in groups {
            self.meetings.share(&members, self.number, self.t, overlapping);
        }
        self.meetings.close(self.t, self.limits.same_episode);
    }

    /// How much of a member is seen in its group: the share of its own colours that the region shows.
    pub(super) fn share_in_group(&self, id: ObjectId, carried: &Carried) -> f32 {
        let clear = self.objects.get(&id).and_then(|object| object.clear.as_ref());
        match (clear, &carried.view) {
            (Some(clear), Some(view)) => view.histogram.holds(&clear.histogram, clear.area),
            _ => 1.0,
        }
    }

    pub(super) fn identities(&self, members: &[ObjectId]) -> Vec<u32> {
        let mut identities: Vec<u32> = members.iter().filter_map(|&id| self.identity(id)).collect();
        identities.sort_unstable();
        identities
    }

    pub(super) fn count_told(&mut self) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.events);
        events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
        for event in &mut events {
            self.counters.count(event.kind);
            (event.evidence.objects_before, event.evidence.objects_now) = self.counted_at(event.frame);
        }
        events
    }
}

fn view(region: &Region) -> View {
    View {
        bbox: region.shape.bbox,
        area: region.shape.area as f32,
        histogram: region.histogram.clone(),
        labels: vec![region.label],
        mosaic: Arc::clone(&region.mosaic),
    }
}

fn piece_of(view: &View) -> Piece {
    Piece { bbox: view.bbox, area: view.area, histogram: view.histogram.clone() }
}
