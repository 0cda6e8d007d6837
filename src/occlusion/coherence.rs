//! Two regions that come in one above the other and move as one are one object.
//!
//! Where the middle of an object has the colour of the background, the mask has a gap there from the first frame on, and
//! each part would become an object. What tells fragments of one object from two objects is motion (Bose, Wang and
//! Grimson, "Multi-class object tracking algorithm that handles fragmentation and grouping", CVPR 2007).

use nalgebra::Vector2;

use super::event::Comparison;
use super::object::{Detection, Object};
use super::tracker::{ObjectId, Tracker};
use crate::regions::Rect;
use crate::tracking::fragments::MIN_SHARED_COLUMNS;

/// The gap between them is at most this part of their heights together.
const MAX_GAP: f32 = 0.5;
/// Both have moved by at least this multiple of their widths, and are still one above the other. Velocities of single
/// frames are less reliable: each leg of a walker stands still at times.
const MIN_TRAVEL: f32 = 1.0;
/// Their mean velocities since then differ by at most this part of the faster one's. Tried: .25 and .4, with the same result
/// on real sequences; without a limit two walkers of a drawn crowd, one behind the other, are joined.
const MAX_VELOCITY_DIFFERENCE: f32 = 0.25;

/// The decision whether a tentative object is a fragment of another one.
pub(super) enum FragmentVerdict {
    /// Undecided: an object of the same age is above or below, and both have not moved far yet.
    Undecided,
    /// It is a fragment of `whole`; `detection` joins both, `evidence` gives the reasons.
    Of { whole: ObjectId, detection: Detection, evidence: [Comparison; 2] },
}

impl Tracker {
    /// Decides whether a lone object is a fragment of another one, `None` where nothing suggests it.
    pub(super) fn fragment_verdict(&self, id: ObjectId) -> Option<FragmentVerdict> {
        let mut alone = self.blobs.iter().filter_map(|tracked| match tracked.members[..] {
            [only] => Some((only, self.objects.get(&only)?, tracked.detection.as_ref()?)),
            _ => None,
        });
        let (_, mine, my_view) = alone.clone().find(|(only, ..)| *only == id)?;
        let (whole, theirs, detection) = alone.find(|(only, other, detection)| {
            *only != id
                && mine.first_frame.abs_diff(other.first_frame) <= self.limits.edge_wait_frames
                && are_stacked(&my_view.bbox, &detection.bbox)
        })?;
        let [my_travel, their_travel] = [(mine, my_view), (theirs, detection)].map(|(object, detection)| {
            let ([x, y], [from_x, from_y]) = (detection.bbox.centre(), object.first_bbox.centre());
            Vector2::new(x - from_x, y - from_y)
        });
        if my_travel.norm() < MIN_TRAVEL * my_view.bbox.w
            || their_travel.norm() < MIN_TRAVEL * detection.bbox.w
        {
            return (mine.seen_frames < self.limits.edge_wait_frames).then_some(FragmentVerdict::Undecided);
        }
        let frames = |object: &Object| self.number.saturating_sub(object.first_frame).max(1) as f32;
        let (mine_per_frame, theirs_per_frame) = (my_travel / frames(mine), their_travel / frames(theirs));
        let faster = mine_per_frame.norm().max(theirs_per_frame.norm());
        let difference = (mine_per_frame - theirs_per_frame).norm() / faster;
        let [_, gap] = my_view.bbox.gap(&detection.bbox);
        let gap = gap / (my_view.bbox.h + detection.bbox.h);
        (difference <= MAX_VELOCITY_DIFFERENCE).then(|| FragmentVerdict::Of {
            whole,
            detection: Detection::join(&[detection, my_view]),
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

    /// Ends an object as a fragment of `whole`, updates that one with the joined detection, and confirms it.
    pub(super) fn join_fragment(
        &mut self,
        id: ObjectId,
        whole: ObjectId,
        detection: Detection,
        evidence: [Comparison; 2],
    ) {
        let Some(ended) = self.end_object(id) else { return };
        self.blobs.retain(|tracked| !tracked.members.is_empty());
        let tracked = self.blobs.iter_mut().find(|tracked| tracked.members == [whole]);
        let (Some(tracked), Some(object)) = (tracked, self.objects.get_mut(&whole)) else { return };
        let measured = detection.observation();
        tracked.blob.settle(&measured, |model| model.restart_at(&measured.measurement()));
        tracked.detection = Some(detection.clone());
        object.set_model(&tracked.blob.shown().model);
        object.first_bbox = object.first_bbox.union(&ended.first_bbox);
        object.last_detection = detection;
        object.fragments.extend(evidence);
        object.reset_appearance();
        let (named, key) = (object.confirmed, object.key);
        if !named {
            self.confirm_object(whole);
        }
        // Before this frame, too, both keys belong to one object.
        self.identity_map.link(ended.key, key);
    }
}

/// Whether one of two regions is above the other with a small gap.
fn are_stacked(a: &Rect, b: &Rect) -> bool {
    let [_, gap] = a.gap(b);
    a.shared_columns(b) >= MIN_SHARED_COLUMNS && gap <= MAX_GAP * (a.h + b.h)
}
