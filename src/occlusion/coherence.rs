//! Two regions that come in one above the other and move as one are one object.
//!
//! Where the middle of an object has the colour of the background, the mask has a gap there from the first frame on, and
//! each part would become an object. What tells fragments of one object from two objects is motion (Bose, Wang and
//! Grimson, "Multi-class object tracking algorithm that handles fragmentation and grouping", CVPR 2007).

use super::object::{Object, View};
use super::reasoner::{ObjectId, Reasoner};
use crate::regions::Rect;
use crate::tracking::fragments::MIN_SHARED_COLUMNS;

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
        let Some((other, whole)) = self.whole_of(id) else { return false };
        let Some(ended) = self.end_object(id) else { return false };
        self.carried.retain(|carried| !carried.members.is_empty());
        let carried = self.carried.iter_mut().find(|carried| carried.members == [other]);
        let (Some(carried), Some(object)) = (carried, self.objects.get_mut(&other)) else { return true };
        let measured = whole.observation();
        carried.blob.settle(&measured, |model| model.stand_at(&measured.measurement()));
        carried.view = Some(whole.clone());
        object.follow(&carried.blob.shown().model);
        object.birthplace = object.birthplace.union(&ended.birthplace);
        object.last = whole;
        object.forget_looks();
        let (named, key) = (object.named, object.key);
        if !named {
            self.name_object(other);
        }
        // Before this frame, too, both were one.
        self.naming.same(ended.key, key);
        true
    }

    /// The object that this one is a fragment of, and both as one.
    fn whole_of(&self, id: ObjectId) -> Option<(ObjectId, View)> {
        let mut alone = self.carried.iter().filter_map(|carried| match carried.members[..] {
            [only] => Some((only, self.objects.get(&only)?, carried.view.as_ref()?)),
            _ => None,
        });
        let (_, mine, my_view) = alone.clone().find(|(only, ..)| *only == id)?;
        let (other, _, view) = alone.find(|(only, other, view)| {
            *only != id
                && mine.born.abs_diff(other.born) <= self.limits.at_edge
                && are_stacked(&my_view.bbox, &view.bbox)
                && move_as_one((mine, my_view), (other, view))
        })?;
        Some((other, View::join(&[view, my_view])))
    }
}

/// Whether one of two regions is above the other with a small gap.
fn are_stacked(a: &Rect, b: &Rect) -> bool {
    let [_, gap] = a.gap(b);
    a.shared_columns(b) >= MIN_SHARED_COLUMNS && gap <= MAX_GAP * (a.h + b.h)
}

/// Whether both have moved since they were first seen, with the same velocity.
fn move_as_one((a, a_view): (&Object, &View), (b, b_view): (&Object, &View)) -> bool {
    let moved = |object: &Object, view: &View| {
        let ([x, y], [from_x, from_y]) = (view.bbox.centre(), object.birthplace.centre());
        (x - from_x).hypot(y - from_y) >= MIN_TRAVEL * view.bbox.w
    };
    let [one, other] = [a, b].map(|object| object.model.velocity().xy());
    moved(a, a_view)
        && moved(b, b_view)
        && (one - other).norm() <= MAX_VELOCITY_DIFFERENCE * one.norm().max(other.norm())
}
