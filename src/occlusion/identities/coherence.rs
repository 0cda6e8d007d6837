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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occlusion::fixtures::{self, RED, context};
    use crate::occlusion::state::context::FrameRef;
    use crate::tracking::pool::Blob;

    const UPPER: Rect = Rect::new(100.0, 50.0, 20.0, 28.0);
    const LOWER: Rect = Rect::new(102.0, 82.0, 16.0, 30.0);

    /// What is found of two parts: nothing, nothing yet, or one object with the values of its evidence.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Found {
        Nothing,
        Undecided,
        One([f32; 2]),
    }

    /// The verdict on the lower of two objects in frame 21. Of each its first frame, its first box, and how far it is
    /// from there.
    fn verdict(seen_frames: u32, parts: [(u32, Rect, [f32; 2]); 2]) -> Found {
        let (context, mut table) = (context(21), ObjectTable::default());
        let ids = parts.map(|(t, first, [dx, dy])| {
            let detection = fixtures::detection(first.moved(dx, dy), RED);
            let object = |id| {
                let object = fixtures::object(&context, id, &detection, [0.0; 2]);
                let first_frame = FrameRef { number: t, index: t, t };
                Object { first_frame, first_bbox: first, seen_frames, ..object }
            };
            let blob = Blob::new(object(0).model, &detection.observation());
            table.start_alone(object, blob, detection.clone())
        });
        match fragment_verdict(&context, &table, ids[1]) {
            None => Found::Nothing,
            Some(FragmentVerdict::Undecided) => Found::Undecided,
            Some(FragmentVerdict::Of { whole, detection, evidence }) => {
                let [one, other] = parts.map(|(_, first, [dx, dy])| first.moved(dx, dy));
                assert_eq!((whole, detection.bbox), (ids[0], one.union(&other)));
                Found::One(evidence.map(|comparison| comparison.value))
            }
        }
    }

    fn both(upper: Rect, lower: Rect, travels: [[f32; 2]; 2]) -> Found {
        verdict(1, [(1, upper, travels[0]), (1, lower, travels[1])])
    }

    #[test]
    fn parts_that_moved_alike_by_their_widths_are_one() {
        let close = |found: Found, expected: [f32; 2]| {
            let Found::One(values) = found else { panic!("{found:?}") };
            assert!(
                values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5),
                "{values:?} {expected:?}"
            );
        };
        let gap = 4.0 / 58.0;
        close(both(UPPER, LOWER, [[20.0, 0.0], [20.0, 0.0]]), [gap, 0.0]);
        close(both(UPPER, LOWER, [[0.0, 40.0], [0.0, 40.0]]), [gap, 0.0]);
        close(both(UPPER, LOWER, [[40.0, 0.0], [31.0, 0.0]]), [gap, 9.0 / 40.0]);
        close(both(UPPER, LOWER, [[-40.0, 30.0], [-40.0, 40.0]]), [14.0 / 58.0, 10.0 / 3200.0_f32.sqrt()]);
        assert_eq!(both(UPPER, LOWER, [[40.0, 0.0], [29.0, 0.0]]), Found::Nothing, "of different velocities");
        // Twice as far in twice the time.
        let found = verdict(1, [(1, UPPER, [40.0, 0.0]), (11, LOWER.moved(20.0, 0.0), [20.0, 0.0])]);
        close(found, [gap, 0.0]);
    }

    #[test]
    fn parts_that_did_not_move_far_are_undecided_for_some_time() {
        for travels in [
            [[0.0; 2]; 2],
            [[19.0, 0.0], [19.0, 0.0]],
            [[22.0, 0.0], [15.0, 0.0]],
            [[19.0, 0.0], [23.0, 0.0]],
        ] {
            assert_eq!(both(UPPER, LOWER, travels), Found::Undecided, "{travels:?}");
            let later = verdict(25, [(1, UPPER, travels[0]), (1, LOWER, travels[1])]);
            assert_eq!(later, Found::Nothing, "{travels:?}");
        }
    }

    #[test]
    fn parts_are_above_each_other_with_a_small_gap() {
        let far = [[40.0, 0.0], [40.0, 0.0]];
        let decided = |lower: Rect| both(UPPER, lower, far) != Found::Nothing;
        // Half of both heights is 29.
        assert!(decided(Rect::new(102.0, 78.0 + 28.0, 16.0, 30.0)));
        assert!(!decided(Rect::new(102.0, 78.0 + 30.0, 16.0, 30.0)));
        assert!(decided(Rect::new(112.0, 82.0, 16.0, 30.0)), "half of its columns");
        assert!(!decided(Rect::new(114.0, 82.0, 16.0, 30.0)));
        assert!(!decided(Rect::new(130.0, 50.0, 16.0, 30.0)), "side by side");
    }
}
