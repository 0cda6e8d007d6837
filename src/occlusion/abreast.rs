//! More heads in a region than objects: who came in side by side with somebody, or was taken for gone.

use std::sync::Arc;

use super::event::Evidence;
use super::groups::Cause;
use super::lobes::lobes;
use super::object::{Appearance, Object, View, template_of};
use super::reasoner::{Carried, ObjectId, Reasoner};
use crate::regions::Rect;
use crate::tracking::kalman::Model;

/// What was learnt of somebody this much wider than they now seem to be was learnt of two.
const AS_WIDE_AS_TWO: f32 = 1.3;

/// What a frame with more heads than objects adds to the count of such frames, and what one without takes away. Two heads are
/// seen in about half the frames of two who walk abreast, as arms and legs swing, and seldom of one. Tried: 1 and 2, 4 and
/// 1, 8 and 1, on 180 drawn scenes of people who mill about and on 28 real ones.
const MORE_HEADS: u32 = 4;
const FEWER_HEADS: u32 = 1;

impl Reasoner {
    /// Counts the heads of every region. Where there have been more than objects for a while,
    /// there is one more.
    pub(super) fn count_heads(&mut self) {
        for index in 0..self.carried.len() {
            let Some(Carried { members, view: Some(view), .. }) = self.carried.get(index) else { continue };
            let Some(&first) = members.first() else { continue };
            let seen = self.objects_of(members).filter(|object| object.unseen == 0).count().max(1);
            let cut_off = view.bbox.distance_to_edge(self.size) <= 1.0;
            let heads = if cut_off { Vec::new() } else { lobes(&view.mosaic) };
            let Some(object) = self.objects.get_mut(&first) else { continue };
            if heads.len() <= seen || !object.named {
                object.crowded = object.crowded.saturating_sub(FEWER_HEADS);
                continue;
            }
            object.crowded += MORE_HEADS;
            if object.crowded > MORE_HEADS * self.limits.heads {
                object.crowded = 0;
                let bodies = heads.iter().filter_map(|columns| body(view, columns)).collect();
                let members = members.clone();
                self.seat(index, &members, bodies);
            }
        }
    }

    /// Gives one of a region's bodies to the member that was not seen, or to somebody new.
    fn seat(&mut self, index: usize, members: &[ObjectId], mut bodies: Vec<View>) {
        if bodies.len() < 2 {
            return;
        }
        let heads = bodies.len();
        let objects: Vec<&Object> = self.objects_of(members).collect();
        let taken = |view: &View| {
            // Both bodies are where the only member is; the other's is the newcomer's.
            if let [only] = objects[..] {
                return only.agreement(&view.histogram, &self.settings).0;
            }
            let seen = objects.iter().filter(|object| object.unseen == 0);
            seen.map(|object| object.predicted_box().iou(&view.bbox)).fold(0.0, f32::max)
        };
        let free = bodies.iter().map(taken).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((free, _)) = free else { return };
        let free = bodies.remove(free);
        let centre = free.bbox.centre();
        let frames_unseen = |id: &ObjectId| self.objects.get(id).map_or(0, |object| object.unseen);
        let unseen = members.iter().copied().filter(|id| frames_unseen(id) > 0);
        if let Some(id) = unseen.max_by_key(frames_unseen) {
            if let Some(object) = self.objects.get_mut(&id) {
                object.stand_at(centre);
                object.unseen = 0;
            }
            return;
        }
        let Some(known) = members.first().and_then(|id| self.objects.get(id)).cloned() else { return };
        let was_two = members.len() == 1 && known.size().0 >= AS_WIDE_AS_TWO * free.bbox.w;
        let velocity = known.model.velocity();
        let id = self.new_key();
        let model = |view: &View| {
            let [x, y] = view.bbox.centre();
            let measured = nalgebra::Vector3::new(x, y, view.area.sqrt());
            Model::new(measured, velocity, self.pool.noise.measurement, self.pool.noise)
        };
        let look = |view: &View| {
            let speed = [velocity.x, velocity.y];
            (Some(Appearance::first(view, speed)), template_of(view, &self.settings))
        };
        let (clear, template) = look(&free);
        let birth = if was_two { (known.born, known.birthplace) } else { (self.number, free.bbox) };
        let newcomer = Object { clear, template, ..Object::new(id, birth, model(&free), free) };
        if was_two && let Some(mine) = bodies.first() {
            let (clear, template) = look(mine);
            let model = model(mine);
            if let Some(object) = members.first().and_then(|id| self.objects.get_mut(id)) {
                object.clear = clear;
                object.template = template;
                object.scale = 1.0;
                object.model = model;
                object.partial = 0;
                object.last = mine.clone();
            }
        }
        self.objects.insert(id, newcomer);
        let Some(carried) = self.carried.get_mut(index) else { return };
        carried.members.push(id);
        carried.members.sort_unstable();
        let mut evidence = Evidence::of_branch("more heads than objects in a region: one object added");
        evidence.note("heads", heads as f32);
        evidence.note("objects", members.len() as f32);
        if let Some(&first) = members.first() {
            self.groups.note_joining(first, Cause { frame: self.number, at: centre, evidence });
        }
        self.name_object(id);
    }
}

/// What these columns show of a region.
fn body(view: &View, columns: &std::ops::Range<u32>) -> Option<View> {
    let mosaic = view.mosaic.part(columns);
    let bbox: Rect = mosaic.bbox()?.intersection(&view.bbox);
    let histogram = mosaic.histogram();
    let labels = view.labels.clone();
    Some(View { bbox, area: histogram.total(), histogram, labels, mosaic: Arc::new(mosaic) })
}
