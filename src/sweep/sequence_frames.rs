//! The frames of a sequence under one combination, as a report shows them: a measure of each, and the worst as pictures.

use std::collections::BTreeMap;

use super::pass::RecordedMask;
use crate::frame::{Frame, Mask};
use crate::placement::Placement;
use crate::truth::boxes::{Bounds, Boxes};
use crate::truth::clear_mot::assign;
use crate::truth::decisions::Decisions;
use crate::truth::masks::TrueMask;

/// Number of the worst frames that are shown.
const WORST: usize = 6;
/// Least IoU of a match of boxes.
const MIN_IOU: f64 = 0.5;

/// What the values of the frames are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameMeasure {
    /// F of the pixels of the mask.
    Mask,
    /// F of the boxes, matched from an IoU of 0.5 on.
    Boxes,
}

/// The frames of a sequence under one combination.
#[derive(Clone, Debug)]
pub struct SequenceFrames {
    /// The index of the sequence in the table.
    pub sequence: usize,
    /// The index of the combination in the grid.
    pub combination: usize,
    /// What the values are of.
    pub measure: FrameMeasure,
    /// The number of each judged frame that has something true or found in it, and its value, 0..=1, in order.
    pub values: Vec<(u32, f32)>,
    /// The worst of them, the worst first, no two close together.
    pub worst: Vec<ShownFrame>,
}

/// A frame with its ground truth and result, all in the pixels of `input`.
#[derive(Clone, Debug)]
pub struct ShownFrame {
    /// The frame.
    pub input: Frame,
    /// Its value, 0..=1.
    pub value: f32,
    /// The true mask, if there is one.
    pub true_mask: Option<TrueMask>,
    /// The true boxes by identity.
    pub true_boxes: Vec<(u32, Bounds)>,
    /// The mask of the analysis.
    pub mask: Mask,
    /// The boxes of the analysis by identity.
    pub boxes: Vec<(u32, Bounds)>,
}

impl ShownFrame {
    /// The same, reduced to at most this width.
    #[must_use]
    pub fn at_most(self, width: u32) -> Self {
        let scale = f64::from(width) / f64::from(self.input.size.width);
        let Some(placement) =
            Placement::new(self.input.size, None, Some(scale as f32)).filter(|_| scale < 1.0)
        else {
            return self;
        };
        let moved = |boxes: Vec<(u32, Bounds)>| {
            let boxes = boxes.into_iter();
            boxes.map(|(identity, bounds)| (identity, Bounds(placement.frame_box(bounds.0)))).collect()
        };
        Self {
            input: placement.frame(&self.input),
            value: self.value,
            true_mask: self.true_mask.map(|mask| mask.in_frame(&placement)),
            true_boxes: moved(self.true_boxes),
            mask: placement.frame_mask(&self.mask),
            boxes: moved(self.boxes),
        }
    }
}

/// F of the masks of the frames that have a true mask with foreground, or false foreground.
pub fn values_of_masks(masks: &[RecordedMask]) -> Vec<(u32, f32)> {
    let judged = masks.iter().filter_map(|mask| Some((mask.number, mask.decisions?)));
    let judged = judged.filter(|(_, Decisions { tp, fp, fn_, .. })| tp + fp + fn_ > 0);
    judged.map(|(number, decisions)| (number, decisions.f_measure() as f32)).collect()
}

/// F of the boxes of each of these frames that has a true or a found one, matched from an IoU of 0.5 on: twice the
/// matches, by all boxes.
pub fn values_of_boxes(truth: &Boxes, found: &Boxes, frames: impl Iterator<Item = u32>) -> Vec<(u32, f32)> {
    let none = BTreeMap::new();
    let value = |number: u32| {
        let truth = truth.get(&number).unwrap_or(&none);
        let found = found.get(&number).unwrap_or(&none);
        let all = truth.len() + found.len();
        let (objects, identities): (Vec<u32>, Vec<u32>) =
            (truth.keys().copied().collect(), found.keys().copied().collect());
        let weight = |object: &u32, identity: &u32| {
            let iou = truth[object].iou(&found[identity]);
            if iou >= MIN_IOU { 1_000_000 + (iou * 1e3) as i64 } else { 0 }
        };
        let matches = assign(&objects, &identities, weight).len();
        (all > 0).then_some((number, 2.0 * matches as f32 / all as f32))
    };
    frames.filter_map(value).collect()
}

/// The worst of the frames, the worst first, none within a twentieth of the sequence of another.
pub fn worst_frames(values: &[(u32, f32)]) -> Vec<(u32, f32)> {
    let Some(((first, _), (last, _))) = values.first().zip(values.last()) else { return Vec::new() };
    let distance = (last - first) / 20;
    let mut order: Vec<_> = values.to_vec();
    order.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let mut worst: Vec<(u32, f32)> = Vec::new();
    for (number, value) in order {
        if worst.len() < WORST && worst.iter().all(|(other, _)| other.abs_diff(number) > distance) {
            worst.push((number, value));
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Size;

    #[test]
    fn values_are_of_frames_with_something_in_them() {
        let at = |x: f64| Bounds([x, 0.0, 10.0, 10.0]);
        let truth = Boxes::from([(1, [(1, at(0.0)), (2, at(50.0))].into()), (3, [(1, at(0.0))].into())]);
        let found = Boxes::from([(1, [(7, at(1.0)), (8, at(90.0))].into()), (4, [(7, at(0.0))].into())]);
        let values = values_of_boxes(&truth, &found, 1..=4);
        assert_eq!(values, [(1, 0.5), (3, 0.0), (4, 0.0)]);
        let mask = |number, decisions| RecordedMask { number, runs: Box::default(), decisions };
        let of = |tp, fp, fn_| Some(Decisions { tp, fp, fn_, tn: 100 });
        let masks = [mask(1, None), mask(2, of(0, 0, 0)), mask(3, of(1, 1, 1)), mask(4, of(0, 2, 0))];
        assert_eq!(values_of_masks(&masks), [(3, 0.5), (4, 0.0)]);
    }

    #[test]
    fn a_wide_frame_is_reduced_with_its_truth_and_result() {
        let size = Size::new(40, 10);
        let mut mask = Mask::empty(size);
        for row in 0..10 {
            mask.data[40 * row + 20..40 * (row + 1)].fill(Mask::FOREGROUND);
        }
        let place = |x: f64, w: f64| vec![(1, Bounds([x, 2.0, w, 4.0]))];
        let frame = ShownFrame {
            input: Frame::new(7, size, [0, 200].repeat(600)),
            value: 0.5,
            true_mask: Some(TrueMask::of_identities(size, &mask.data)),
            true_boxes: place(20.0, 20.0),
            mask,
            boxes: place(10.0, 8.0),
        };
        let same = frame.clone().at_most(40);
        assert_eq!((same.input.size, &same.boxes), (size, &frame.boxes));
        let half = frame.at_most(20);
        assert_eq!((half.input.size, half.input.number, half.value), (Size::new(20, 5), 7, 0.5));
        assert_eq!(half.boxes, [(1, Bounds([5.0, 1.0, 4.0, 2.0]))]);
        assert_eq!(half.true_boxes, [(1, Bounds([10.0, 1.0, 10.0, 2.0]))]);
        let decisions = half.true_mask.map(|mask| mask.score(&half.mask));
        assert_eq!(decisions, Some(Decisions { tp: 50, fp: 0, fn_: 0, tn: 50 }));
    }

    #[test]
    fn the_worst_frames_are_apart() {
        let mut values: Vec<_> = (1..=501).map(|number| (number, 0.9)).collect();
        for (number, value) in [(100, 0.2), (105, 0.1), (120, 0.3), (131, 0.25), (400, 0.0)] {
            values[number - 1].1 = value;
        }
        let worst = worst_frames(&values);
        assert_eq!(worst[..3], [(400, 0.0), (105, 0.1), (131, 0.25)]);
        assert_eq!(worst.len(), WORST);
        assert!(super::worst_frames(&[]).is_empty());
    }
}
