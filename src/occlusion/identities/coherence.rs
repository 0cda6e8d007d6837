//! Two regions that appear one above the other and move alike are fragments of one object.
//!
//! Where the middle of an object has the colour of the background, the mask has a gap there from the first frame on,
//! and each part would become an object. Motion distinguishes fragments of one object from two objects (Bose, Wang and
//! Grimson, "Multi-class object tracking algorithm that handles fragmentation and grouping", CVPR 2007).

use nalgebra::Vector2;

use crate::occlusion::event::Comparison;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::ObjectTable;
use crate::regions::Rect;
use crate::tracking::ObjectId;
use crate::tracking::fragments::MIN_SHARED_COLUMNS;

/// The gap between them is at most this part of their heights together.
const MAX_GAP: f32 = 0.5;
/// Both have moved by at least this multiple of their widths, and are still one above the other. Velocities of single
/// frames are less reliable: each leg of a walker stands still at times.
const MIN_TRAVEL: f32 = 1.0;
/// Their mean velocities since then differ by at most this part of the faster one's. Tried: .25 and .4, with the same
/// result on real sequences; without a limit two walkers of a drawn crowd, one behind the other, are joined.
const MAX_VELOCITY_DIFFERENCE: f32 = 0.25;

/// The decision whether a tentative object is a fragment of another one.
#[derive(Clone, Debug)]
pub(super) enum FragmentVerdict {
    /// Undecided: an object of the same age is above or below, and both have not moved far yet.
    Undecided,
    /// It is a fragment of `whole`; `detection` joins both, `evidence` gives the reasons.
    Of { whole: ObjectId, detection: Detection, evidence: [Comparison; 2] },
}

/// Decides whether a lone object is a fragment of another one, `None` where nothing suggests it.
pub(super) fn fragment_verdict(
    context: &Context,
    table: &ObjectTable,
    id: ObjectId,
) -> Option<FragmentVerdict> {
    let mut alone = table
        .lone_objects()
        .filter_map(|(only, object, tracked)| Some((only, object, tracked.detection.as_ref()?)));
    let (_, mine, my_detection) = alone.clone().find(|(only, ..)| *only == id)?;
    let (whole, theirs, detection) = alone.find(|(only, other, detection)| {
        *only != id
            && mine.first_frame.t.abs_diff(other.first_frame.t) <= context.limits.edge_wait_frames
            && are_stacked(&my_detection.bbox, &detection.bbox)
    })?;
    let [my_travel, their_travel] = [(mine, my_detection), (theirs, detection)].map(|(object, detection)| {
        let ([x, y], [from_x, from_y]) = (detection.bbox.centre(), object.first_bbox.centre());
        Vector2::new(x - from_x, y - from_y)
    });
    if my_travel.norm() < MIN_TRAVEL * my_detection.bbox.w
        || their_travel.norm() < MIN_TRAVEL * detection.bbox.w
    {
        return (mine.seen_frames < context.limits.edge_wait_frames).then_some(FragmentVerdict::Undecided);
    }
    let frames = |object: &Object| context.t.saturating_sub(object.first_frame.t).max(1) as f32;
    let (mine_per_frame, theirs_per_frame) = (my_travel / frames(mine), their_travel / frames(theirs));
    let faster = mine_per_frame.norm().max(theirs_per_frame.norm());
    let difference = (mine_per_frame - theirs_per_frame).norm() / faster;
    let [_, gap] = my_detection.bbox.gap(&detection.bbox);
    let gap = gap / (my_detection.bbox.h + detection.bbox.h);
    (difference <= MAX_VELOCITY_DIFFERENCE).then(|| FragmentVerdict::Of {
        whole,
        detection: Detection::join(&[detection, my_detection]),
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

/// Whether one of two regions is above the other with a small gap.
fn are_stacked(a: &Rect, b: &Rect) -> bool {
    let [_, gap] = a.gap(b);
    a.shared_columns(b) >= MIN_SHARED_COLUMNS && gap <= MAX_GAP * (a.h + b.h)
}
