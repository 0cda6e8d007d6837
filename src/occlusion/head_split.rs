//! Splits a region with more heads than members: adds the member that entered side by side with another, or was taken
//! for lost.

use std::sync::Arc;

use super::event::Evidence;
use super::groups::GroupChange;
use super::head_count::head_columns;
use super::object::{Appearance, Detection, Object, template_of};
use super::tracker::{ObjectId, TrackedBlob, Tracker};
use crate::regions::Rect;
use crate::tracking::kalman::KalmanModel;

/// An appearance this much wider than the present body was learnt from two objects.
const MIN_DOUBLE_WIDTH_RATIO: f32 = 1.3;

/// What a frame with more heads than members adds to the score, and what one without subtracts. Two heads are visible
/// in about half the frames of two people who walk abreast, as arms and legs swing, and rarely for one. Tried: 1 and
/// 2, 4 and 1, 8 and 1, on 180 drawn scenes of people who mill about and on 28 real ones.
const EXTRA_HEAD_INCREMENT: u32 = 4;
const EXTRA_HEAD_DECREMENT: u32 = 1;

impl Tracker {
    /// Counts the heads of every region. Where they exceed the members for long enough, adds a member.
    pub(super) fn count_heads(&mut self) {
        for index in 0..self.blobs.len() {
            let Some(TrackedBlob { members, detection: Some(detection), .. }) = self.blobs.get(index) else {
                continue;
            };
            let Some(&first) = members.first() else { continue };
            let seen = self.objects_of(members).filter(|object| object.unseen_frames == 0).count().max(1);
            let cut_off = detection.bbox.distance_to_edge(self.size) <= 1.0;
            let heads = if cut_off { Vec::new() } else { head_columns(&detection.mosaic) };
            let Some(object) = self.objects.get_mut(&first) else { continue };
            if heads.len() <= seen || !object.confirmed {
                object.extra_head_score = object.extra_head_score.saturating_sub(EXTRA_HEAD_DECREMENT);
                continue;
            }
            object.extra_head_score += EXTRA_HEAD_INCREMENT;
            if object.extra_head_score > EXTRA_HEAD_INCREMENT * self.limits.head_count_frames {
                object.extra_head_score = 0;
                let bodies = heads.iter().filter_map(|columns| body_detection(detection, columns)).collect();
                let members = members.clone();
                self.assign_head(index, &members, bodies);
            }
        }
    }

    /// Assigns one of a region's bodies to an unseen member, or to a new object.
    fn assign_head(&mut self, index: usize, members: &[ObjectId], mut bodies: Vec<Detection>) {
        if bodies.len() < 2 {
            return;
        }
        let heads = bodies.len();
        let objects: Vec<&Object> = self.objects_of(members).collect();
        let overlap_with_members = |detection: &Detection| {
            // Both bodies overlap the only member; the less similar one is the new object's.
            if let [only] = objects[..] {
                return only.colour_similarity(&detection.histogram, &self.settings).0;
            }
            let seen = objects.iter().filter(|object| object.unseen_frames == 0);
            seen.map(|object| object.predicted_box().iou(&detection.bbox)).fold(0.0, f32::max)
        };
        let free = bodies.iter().map(overlap_with_members).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((free, _)) = free else { return };
        let free = bodies.remove(free);
        let centre = free.bbox.centre();
        let frames_unseen = |id: &ObjectId| self.objects.get(id).map_or(0, |object| object.unseen_frames);
        let unseen = members.iter().copied().filter(|id| frames_unseen(id) > 0);
        if let Some(id) = unseen.max_by_key(frames_unseen) {
            if let Some(object) = self.objects.get_mut(&id) {
                object.set_centre(centre);
                object.unseen_frames = 0;
            }
            return;
        }
        let Some(known) = members.first().and_then(|id| self.objects.get(id)).cloned() else { return };
        let was_two = members.len() == 1 && known.size().0 >= MIN_DOUBLE_WIDTH_RATIO * free.bbox.w;
        let velocity = known.model.velocity();
        let id = self.new_key();
        let model = |detection: &Detection| {
            let [x, y] = detection.bbox.centre();
            let measured = nalgebra::Vector3::new(x, y, detection.area.sqrt());
            KalmanModel::new(measured, velocity, self.pool.noise.measurement, self.pool.noise)
        };
        let appearance_of = |detection: &Detection| {
            let speed = [velocity.x, velocity.y];
            (Some(Appearance::new(detection, speed)), template_of(detection, &self.settings))
        };
        let (appearance, template) = appearance_of(&free);
        let birth = if was_two { (known.first_frame, known.first_bbox) } else { (self.number, free.bbox) };
        let newcomer = Object { appearance, template, ..Object::new(id, birth, model(&free), free) };
        if was_two && let Some(mine) = bodies.first() {
            let (appearance, template) = appearance_of(mine);
            let model = model(mine);
            if let Some(object) = members.first().and_then(|id| self.objects.get_mut(id)) {
                object.appearance = appearance;
                object.template = template;
                object.scale = 1.0;
                object.model = model;
                object.partial_frames = 0;
                object.last_detection = mine.clone();
            }
        }
        self.objects.insert(id, newcomer);
        let Some(tracked) = self.blobs.get_mut(index) else { return };
        tracked.members.push(id);
        tracked.members.sort_unstable();
        let mut evidence = Evidence::of_branch("more heads than objects in a region: one object added");
        evidence.note("heads", heads as f32);
        evidence.note("objects", members.len() as f32);
        if let Some(&first) = members.first() {
            self.groups.record_joining(first, GroupChange { frame: self.number, at: centre, evidence });
        }
        self.confirm_object(id);
    }
}

/// The detection of these columns of a region.
fn body_detection(detection: &Detection, columns: &std::ops::Range<u32>) -> Option<Detection> {
    let mosaic = detection.mosaic.part(columns);
    let bbox: Rect = mosaic.bbox()?.intersection(&detection.bbox);
    let histogram = mosaic.histogram();
    let labels = detection.labels.clone();
    Some(Detection { bbox, area: histogram.total(), histogram, labels, mosaic: Arc::new(mosaic) })
}
