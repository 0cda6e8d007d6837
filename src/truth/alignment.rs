//! Frame numbers of ground truth that fit the results better than its own.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::TruthError;
use super::boxes::{Boxes, shifted_number};
use super::decisions::Decisions;
use super::mask_score::{MaskResults, decide};
use super::masks::MaskFiles;

/// Offsets up to this one are tried.
const REACH: i64 = 5;
/// Largest number of frames of boxes that are compared, at equal steps.
const BOX_FRAMES: usize = 400;
/// Largest number of masks that are compared, at equal steps.
const MASK_FRAMES: usize = 8;
/// Least IoU of a match.
const MIN_IOU: f64 = 0.5;

/// How well boxes fit at an offset.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
struct Fit {
    matched: usize,
    iou: f64,
}

/// The number to add to the frame numbers of `truth` so that clearly more of `found` matches: a quarter and three boxes
/// more, or, where the truth has a frame 0 and the results have none, any better fit of one frame. `None` if there is
/// no such number. Tried are those up to 5, and the one that makes the first numbers equal.
pub fn better_offset(truth: &Boxes, found: &Boxes, first_analysed: u32) -> Option<i64> {
    let step = found.len().div_ceil(BOX_FRAMES).max(1);
    let sample: Vec<_> = found.iter().step_by(step).collect();
    let fit = |offset: i64| {
        let mut fit = Fit::default();
        for (number, boxes) in &sample {
            let Some(true_boxes) = shifted_number(**number, -offset).and_then(|number| truth.get(&number))
            else {
                continue;
            };
            for place in true_boxes.values() {
                let iou = boxes.values().map(|other| place.iou(other)).fold(0.0, f64::max);
                if iou >= MIN_IOU {
                    fit.matched += 1;
                    fit.iou += iou;
                }
            }
        }
        fit
    };
    let (true_first, found_first) = (*truth.keys().next()?, *found.keys().next()?);
    let own = fit(0);
    let (best, offset) = candidates(true_first, &[found_first, first_analysed])
        .map(|offset| (fit(offset), offset))
        .fold((Fit::default(), 0), |best, other| if other.0 > best.0 { other } else { best });
    if best.matched >= own.matched + own.matched / 4 + 3 {
        return Some(offset);
    }
    (true_first == 0 && first_analysed > 0 && fit(1) > own).then_some(1)
}

/// The number to add to the frame numbers of `truth` so that `found` fits clearly better; `None` if there is none. Tried
/// are those up to 5, and the one that makes the first numbers equal.
pub fn better_offset_of_masks(truth: &MaskFiles, found: &MaskResults) -> Result<Option<i64>, TruthError> {
    let step = found.len().div_ceil(MASK_FRAMES).max(1);
    let sample: Vec<_> = found.iter().skip(step / 2).step_by(step).collect();
    let numbers: BTreeSet<u32> = truth.numbers().collect();
    // The share of right foreground, and the number of frames in common.
    let fit = |offset: i64| -> Result<(f64, usize), TruthError> {
        let pairs =
            sample.iter().filter_map(|(number, path)| Some((shifted_number(**number, -offset)?, *path)));
        let pairs: Vec<_> = pairs.filter(|(number, _)| numbers.contains(number)).collect();
        let decisions = pairs.par_iter().map(|(number, path)| decide(truth, *number, path));
        let decisions: Vec<Decisions> = decisions.collect::<Result<_, _>>()?;
        Ok((decisions.into_iter().sum::<Decisions>().f_measure(), pairs.len()))
    };
    let Some((true_first, found_first)) = numbers.first().zip(found.keys().next()) else { return Ok(None) };
    let own = fit(0)?;
    let mut best = (own.0, 0);
    for offset in candidates(*true_first, &[*found_first]) {
        let (share, frames) = fit(offset)?;
        if share > best.0 && 2 * frames >= sample.len() {
            best = (share, offset);
        }
    }
    Ok((best.0 > 1.5 * own.0 + 0.05).then_some(best.1))
}

/// Offsets from the nearest on, then those that move the first number of the truth to the first of the results.
fn candidates(true_first: u32, firsts: &[u32]) -> impl Iterator<Item = i64> {
    let aligning = firsts.iter().map(move |first| i64::from(*first) - i64::from(true_first));
    let aligning: Vec<i64> = aligning.filter(|offset| offset.abs() > REACH).collect();
    (1..=REACH).flat_map(|offset| [offset, -offset]).chain(aligning)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::truth::boxes::{Bounds, shifted};

    /// A person who walks by this many pixels per frame.
    fn walk(frames: std::ops::Range<u32>, step: f64) -> Boxes {
        let place = |number: u32| Bounds([f64::from(number) * step, 0.0, 10.0, 20.0]);
        frames.map(|number| (number, BTreeMap::from([(1, place(number))]))).collect()
    }

    #[test]
    fn a_clearly_better_offset_is_found_and_no_other() {
        let found = walk(1..60, 4.0);
        for offset in [-4, -2, 2, 3, 5] {
            let truth = shifted(&walk(10..60, 4.0), -offset);
            assert_eq!(better_offset(&truth, &found, 1), Some(offset));
        }
        assert_eq!(better_offset(&found, &shifted(&found, 469), 470), Some(469));
        assert_eq!(better_offset(&found, &found, 1), None);
        // A person who hardly moves, off by one: told only where the truth has a frame 0.
        let slow = walk(1..60, 0.5);
        assert_eq!(better_offset(&shifted(&slow, -1), &slow, 1), Some(1));
        assert_eq!(better_offset(&shifted(&slow, 1), &slow, 1), None);
        assert_eq!(better_offset(&slow, &walk(1..60, 9.0), 1), None);
        assert_eq!(better_offset(&slow, &Boxes::new(), 1), None);
    }
}
