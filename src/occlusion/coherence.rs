//! Two regions that come in one above the other and move as one are one object.
//!
//! Where the middle of an object has the colour of the background, the mask has a gap there from the first frame on, and
//! each part would become an object. What tells fragments of one object from two objects is motion (Bose, Wang and
//! Grimson, "Multi-class object tracking algorithm that handles fragmentation and grouping", CVPR 2007).

use nalgebra::Vector2;

use super::event::Comparison;
use super::object::{Object, View};
use super::reasoner::{ObjectId, Reasoner};
use crate::regions::Rect;
use crate::tracking::fragments::MIN_SHARED_COLUMNS;

/// The gap between them is at most this part of their heights together.
const MAX_GAP: f32 = 0.5;
/// Both have moved by at least this part of their widths, and still one is above the other. The velocities of one moment say
/// less: of a walker's legs each stands still at times.
const MIN_TRAVEL: f32 = 1.0;
/// Their mean velocities since then differ by at most this part of the faster one's. Tried: .25 and .4, with the same result
/// on real sequences; without a limit two walkers of a drawn crowd, one behind the other, are joined.
const MAX_VELOCITY_DIFFERENCE: f32 = 0.25;

/// What is known of an object that is about to get an identity.
pub(super) enum Fragment {
    /// It may be a fragment: one of the same age is above or below, and both have not moved far yet.
    Open,
    /// It is a fragment of `whole`; both as one are `view`, for the reasons in `evidence`.
    Of { whole: ObjectId, view: View, evidence: [Comparison; 2] },
}

impl Reasoner {
    /// Whether an object that is seen alone is a fragment of another one, `None` where nothing speaks for it.
    pub(super) fn as_fragment(&self, id: ObjectId) -> Option<Fragment> {
        let mut alone = self.carried.iter().filter_map(|carried| match carried.members[..] {
            [only] => Some((only, self.objects.get(&only)?, carried.view.as_ref()?)),
            _ => None,
        });
        let (_, mine, my_view) = alone.clone().find(|(only, ..)| *only == id)?;
        let (whole, theirs, view) = alone.find(|(only, other, view)| {
            *only != id
                && mine.born.abs_diff(other.born) <= self.limits.at_edge
                && are_stacked(&my_view.bbox, &view.bbox)
        })?;
        let [my_travel, their_travel] = [(mine, my_view), (theirs, view)].map(|(object, view)| {
            let ([x, y], [from_x, from_y]) = (view.bbox.centre(), object.birthplace.centre());
            Vector2::new(x - from_x, y - from_y)
        });
        if my_travel.norm() < MIN_TRAVEL * my_view.bbox.w || their_travel.norm() < MIN_TRAVEL * view.bbox.w {
            return (mine.seen < self.limits.at_edge).then_some(Fragment::Open);
        }
        let frames = |object: &Object| self.number.saturating_sub(object.born).max(1) as f32;
        let (mine_per_frame, theirs_per_frame) = (my_travel / frames(mine), their_travel / frames(theirs));
        let faster = mine_per_frame.norm().max(theirs_per_frame.norm());
        let difference = (mine_per_frame - theirs_per_frame).norm() / faster;
        let [_, gap] = my_view.bbox.gap(&view.bbox);
        let gap = gap / (my_view.bbox.h + view.bbox.h);
        (difference <= MAX_VELOCITY_DIFFERENCE).then(|| Fragment::Of {
            whole,
            view: View::join(&[view, my_view]),
            evidence: [
                Comparison::at_most("gap between fragments, relative to their height", gap, MAX_GAP),
                Comparison::at_most(
                    "velocity difference of the fragments, relative to the faster one",
                    difference,
                    MAX_VELOCITY_DIFFERENCE,
                ),
            ],
        })
    }

    /// Ends an object as a fragment of `whole`, which is seen as `view` with it, and names that one.
    pub(super) fn join_fragment(
        &mut self,
        id: ObjectId,
        whole: ObjectId,
        view: View,
        evidence: [Comparison; 2],
    ) {
        let Some(ended) = self.end_object(id) else { return };
        self.carried.retain(|carried| !carried.members.is_empty());
        let carried = self.carried.iter_mut().find(|carried| carried.members == [whole]);
        let (Some(carried), Some(object)) = (carried, self.objects.get_mut(&whole)) else { return };
        let measured = view.observation();
        carried.blob.settle(&measured, |model| model.stand_at(&measured.measurement()));
        carried.view = Some(view.clone());
        object.follow(&carried.blob.shown().model);
        object.birthplace = object.birthplace.union(&ended.birthplace);
        object.last = view;
        object.fragments.extend(evidence);
        object.forget_looks();
        let (named, key) = (object.named, object.key);
        if !named {
            self.name_object(whole);
        }
        // Before this frame, too, both were one.
        self.naming.same(ended.key, key);
    }
}

/// Whether one of two regions is above the other with a small gap.
fn are_stacked(a: &Rect, b: &Rect) -> bool {
    let [_, gap] = a.gap(b);
    a.shared_columns(b) >= MIN_SHARED_COLUMNS && gap <= MAX_GAP * (a.h + b.h)
}
