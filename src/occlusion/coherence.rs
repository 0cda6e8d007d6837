//! Two regions that come in one above the other and move as one are one object.
//!
//! Where the middle of an object has the colour of the background, the mask has a gap there from the first frame on, and
//! each part would become an object. What tells fragments of one object from two objects is motion (Bose, Wang and
//! Grimson, "Multi-class object tracking algorithm that handles fragmentation and grouping", CVPR 2007).

use super::object::View;
use super::reasoner::{ObjectId, Reasoner, join, observation};
use crate::regions::Rect;

/// The regions share at least this part of the narrower one's columns.
const MIN_SHARED_COLUMNS: f32 = 0.5;
/// The gap between them is at most this part of their heights together.
const MAX_GAP: f32 = 0.5;
/// Their velocities differ by at most this part of the faster one's.
const MAX_VELOCITY_DIFFERENCE: f32 = 0.25;
/// Each has moved by at least this part of its width: of what stands still nothing can be said.
const MIN_TRAVEL: f32 = 0.5;

impl Reasoner {
    /// Joins an object that is about to get an identity to one of the same age above or below that moves as it does, and
    /// names that one. Gives whether it did: the object is no more.
    pub(super) fn join_fragment(&mut self, id: ObjectId) -> bool {
        let Some(other) = self.coherent_with(id) else { return false };
        let seen = |id: ObjectId| {
            let carried = self.carried.iter().find(|carried| carried.members == [id])?;
            carried.view.clone()
        };
        let (Some(mine), Some(others)) = (seen(id), seen(other)) else { return false };
        let view = join(&[&others, &mine]);
        let Some(ended) = self.end_object(id) else { return false };
        self.carried.retain(|carried| !carried.members.is_empty());
        let Some(carried) = self.carried.iter_mut().find(|carried| carried.members == [other]) else {
            return true;
        };
        let measured = observation(&view);
        carried.blob.settle(&measured, |model| model.stand_at(&measured.measurement()));
        let model = carried.blob.shown().model.clone();
        carried.view = Some(view.clone());
        if let Some(object) = self.objects.get_mut(&other) {
            object.birthplace = object.birthplace.union(&ended.birthplace);
            object.follow(&model);
            object.last = view;
            object.forget_looks();
            let key = object.key;
            if !object.named {
                self.name_object(other);
            }
            // Before this frame, too, both were one.
            self.naming.same(ended.key, key);
        }
        true
    }

    /// The object that this one, seen alone, is a fragment of.
    fn coherent_with(&self, id: ObjectId) -> Option<ObjectId> {
        let alone = |id: ObjectId| {
            let carried = self.carried.iter().find(|carried| carried.members == [id])?;
            Some((self.objects.get(&id)?, carried.view.as_ref()?))
        };
        let (mine, my_view) = alone(id)?;
        let candidates = self.carried.iter().filter_map(|carried| match carried.members[..] {
            [other] if other != id => Some((other, alone(other)?)),
            _ => None,
        });
        let mut fragments = candidates.filter(|(_, (other, view))| {
            let age = mine.born.abs_diff(other.born);
            let [a, b] = [mine, *other].map(|object| object.model.velocity().fixed_rows::<2>(0).into_owned());
            let moved = |view: &View, birthplace: &Rect| {
                let ([x, y], [from_x, from_y]) = (view.bbox.centre(), birthplace.centre());
                (x - from_x).hypot(y - from_y) >= MIN_TRAVEL * view.bbox.w
            };
            age <= self.limits.at_edge
                && is_above(&my_view.bbox, &view.bbox)
                && (a - b).norm() <= MAX_VELOCITY_DIFFERENCE * a.norm().max(b.norm())
                && moved(my_view, &mine.birthplace)
                && moved(view, &other.birthplace)
        });
        fragments.next().map(|(other, _)| other)
    }
}

/// Whether one of two regions is above the other with a small gap.
fn is_above(a: &Rect, b: &Rect) -> bool {
    let shared = a.right().min(b.right()) - a.x.max(b.x);
    let gap = a.y.max(b.y) - a.bottom().min(b.bottom());
    shared >= MIN_SHARED_COLUMNS * a.w.min(b.w) && gap <= MAX_GAP * (a.h + b.h)
}
