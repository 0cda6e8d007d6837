//! Frame numbers of ground truth that fit the results better than its own.

use std::collections::{BTreeMap, BTreeSet};
use std::iter;
use std::path::PathBuf;

use rayon::prelude::*;

use super::TruthError;
use super::boxes::{Bounds, Boxes, shifted_number, span};
use super::decisions::Decisions;
use super::mask_score::{MaskResults, decide};
use super::masks::MaskFiles;

/// Offsets up to this one are tried.
const REACH: i64 = 5;
/// Largest number of frames of boxes that are compared, at equal steps.
const BOX_FRAMES: usize = 400;
/// Largest number of masks that are compared, at equal steps.
const MASK_FRAMES: usize = 16;
/// Least IoU of a match.
const MIN_IOU: f64 = 0.3;
/// Least ratio of the mean IoU of boxes, and of its sum, at a better offset. Of 55 ranges of TUD-Campus, KITTI-17, vtest and
/// zebrafish with right numbers no offset gains more than 1 %; numbers off by three lose at least 11 %, those off by one
/// mostly 5 to 30 %.
const BOX_GAIN: f64 = 1.08;
/// Least gain of the sum of IoU, so that few boxes prove nothing.
const MIN_BOX_GAIN: f64 = 1.5;
/// Number of parts of a sequence in most of which a better offset must fit better.
const PARTS: usize = 8;
/// Largest ratio of 1 − F of masks at a better offset. Of canoe, office and HallAndMonitor with right numbers no offset lowers
/// it; from numbers off by one the right ones lower it by 3 to 13 %.
const MASK_GAIN: f64 = 0.95;

/// How well boxes fit at an offset: the sum of the IoU of the matches of each frame, and the number of its true boxes.
struct Fit(Vec<(f64, usize)>);

impl Fit {
    fn sum(&self) -> f64 {
        self.0.iter().map(|frame| frame.0).sum()
    }

    fn mean(&self) -> f64 {
        self.sum() / self.0.iter().map(|frame| frame.1).sum::<usize>().max(1) as f64
    }

    /// Whether it is better than another by more than right numbers ever lose, and not in one part of the sequence alone.
    fn is_clearly_better(&self, other: &Self) -> bool {
        let gains: Vec<f64> = self.0.iter().zip(&other.0).map(|(ours, others)| ours.0 - others.0).collect();
        let parts = gains.chunks(gains.len().div_ceil(PARTS).max(1));
        let gains: Vec<f64> = parts.map(|part| part.iter().sum()).collect();
        let (better, worse) = better_and_worse(&gains);
        self.sum() >= BOX_GAIN * other.sum() + MIN_BOX_GAIN
            && self.mean() >= BOX_GAIN * other.mean()
            && better >= 3 * worse
    }
}

/// The numbers of gains and of losses.
fn better_and_worse(gains: &[f64]) -> (usize, usize) {
    let count = |is: fn(f64) -> bool| gains.iter().filter(|gain| is(**gain)).count();
    (count(|gain| gain > 1e-9), count(|gain| gain < -1e-9))
}

/// The number to add to the frame numbers of `truth` so that `found`, known of the frames from the first to the last in
/// `analysed`, fits better: clearly, or at all where the truth then has just these frames, and where one more leaves no
/// frame 0 that the results do not have. `None` if there is no such number. Tried are those up to 5, and the one that
/// makes the first numbers equal.
pub fn better_offset(truth: &Boxes, found: &Boxes, analysed: (u32, u32)) -> Option<i64> {
    let step = found.len().div_ceil(BOX_FRAMES).max(1);
    let sample: Vec<_> = found.iter().step_by(step).collect();
    let fit = |offset: i64| {
        let of_frame = |(number, boxes): &(&u32, &BTreeMap<u32, Bounds>)| {
            let true_boxes = shifted_number(**number, -offset).and_then(|number| truth.get(&number));
            let best = |place: &Bounds| boxes.values().map(|other| place.iou(other)).fold(0.0, f64::max);
            let ious = true_boxes.into_iter().flat_map(BTreeMap::values).map(best);
            (ious.filter(|iou| *iou >= MIN_IOU).sum(), true_boxes.map_or(0, BTreeMap::len))
        };
        Fit(sample.iter().map(of_frame).collect())
    };
    let (true_first, true_last) = span(truth)?;
    let own = fit(0);
    let aligning = i64::from(analysed.0) - i64::from(true_first);
    let fills = i64::from(true_last) + aligning == i64::from(analysed.1);
    if aligning != 0 && fills && fit(aligning).sum() > own.sum() {
        return Some(aligning);
    }
    let firsts = [span(found)?.0, analysed.0];
    let fits = candidates(true_first, &firsts).map(|offset| (fit(offset), offset));
    let (best, offset) =
        fits.reduce(|best, other| if other.0.sum() > best.0.sum() { other } else { best })?;
    if best.is_clearly_better(&own) {
        return Some(offset);
    }
    (true_first == 0 && analysed.0 > 0 && fit(1).sum() > own.sum()).then_some(1)
}

/// The number to add to the frame numbers of `truth` so that `found` fits clearly better, or at all where both then have the
/// same numbers; `None` if there is none. Tried are those up to 5, and the one that makes the first numbers equal.
pub fn better_offset_of_masks(truth: &MaskFiles, found: &MaskResults) -> Result<Option<i64>, TruthError> {
    let step = found.len().div_ceil(MASK_FRAMES).max(1);
    let sample: Vec<_> = found.iter().skip(step / 2).step_by(step).collect();
    let numbers: BTreeSet<u32> = truth.numbers().collect();
    let Some((true_first, found_first)) = numbers.first().zip(found.keys().next()) else { return Ok(None) };
    let offsets: Vec<i64> = iter::once(0).chain(candidates(*true_first, &[*found_first])).collect();
    // Of each frame the decisions at each offset.
    let of_frame = |(number, path): &(&u32, &PathBuf)| {
        let at = |offset: &i64| {
            let number = shifted_number(**number, -offset).filter(|number| numbers.contains(number));
            number.map(|number| decide(truth, number, path)).transpose()
        };
        offsets.iter().map(at).collect::<Result<Vec<_>, _>>()
    };
    let decisions: Vec<Vec<Option<Decisions>>> =
        sample.par_iter().map(of_frame).collect::<Result<_, TruthError>>()?;
    let f_of = |at: usize, is_in: &dyn Fn(&[Option<Decisions>]) -> bool| {
        let frames = decisions.iter().filter(|frame| is_in(frame));
        frames.filter_map(|frame| frame[at]).sum::<Decisions>().f_measure()
    };
    let mut best = (0.0, None);
    for (at, &offset) in offsets.iter().enumerate().skip(1) {
        let frames = decisions.iter().filter(|frame| frame[at].is_some()).count();
        let common: Vec<_> = decisions.iter().filter_map(|frame| Some((frame[0]?, frame[at]?))).collect();
        if 2 * frames < sample.len() {
            continue;
        }
        // Where few frames have a mask at both, those of each are compared.
        let has_common = 2 * common.len() >= sample.len();
        let in_common =
            |frame: &[Option<Decisions>]| !has_common || frame[0].is_some() && frame[at].is_some();
        let (own, moved) = (f_of(0, &in_common), f_of(at, &in_common));
        let errors = |decisions: &Decisions| (decisions.fp + decisions.fn_) as f64;
        let gains: Vec<f64> = common.iter().map(|(own, moved)| errors(own) - errors(moved)).collect();
        let (better, worse) = better_and_worse(&gains);
        let aligns = numbers.len() == found.len()
            && numbers
                .iter()
                .map(|number| shifted_number(*number, offset))
                .eq(found.keys().copied().map(Some));
        let is_better = if has_common {
            1.0 - moved < MASK_GAIN * (1.0 - own) && better >= 2 * worse || aligns && moved > own
        } else {
            moved > 1.5 * own + 0.05
        };
        let gain = moved - own;
        if is_better && gain > best.0 {
            best = (gain, Some(offset));
        }
    }
    Ok(best.1)
}

/// Offsets from the nearest on, then those that move the first number of the truth to the first of the results.
fn candidates(true_first: u32, firsts: &[u32]) -> impl Iterator<Item = i64> {
    let aligning = firsts.iter().map(move |first| i64::from(*first) - i64::from(true_first));
    let aligning: Vec<i64> = aligning.filter(|offset| offset.abs() > REACH).collect();
    (1..=REACH).flat_map(|offset| [offset, -offset]).chain(aligning)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::boxes::shifted;

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
            assert_eq!(better_offset(&truth, &found, (1, 70)), Some(offset));
        }
        assert_eq!(better_offset(&found, &shifted(&found, 469), (470, 900)), Some(469));
        assert_eq!(better_offset(&found, &found, (1, 59)), None);
        assert_eq!(better_offset(&found, &walk(1..60, 9.0), (1, 59)), None);
        assert_eq!(better_offset(&found, &Boxes::new(), (1, 59)), None);
    }

    #[test]
    fn slow_objects_show_their_frames_by_the_ends_of_the_truth() {
        // Off by one, a person who hardly moves matches nearly as well.
        let slow = walk(1..60, 0.1);
        assert_eq!(better_offset(&shifted(&slow, -1), &slow, (1, 90)), Some(1), "the truth has a frame 0");
        assert_eq!(
            better_offset(&shifted(&slow, 2), &slow, (1, 59)),
            Some(-2),
            "it has frames after the last"
        );
        assert_eq!(better_offset(&shifted(&slow, 1), &slow, (1, 90)), None);
        assert_eq!(better_offset(&walk(5..60, 0.1), &slow, (1, 59)), None, "it begins later");
        // Some frames off, it does not.
        let slow = walk(1..60, 0.5);
        assert_eq!(better_offset(&shifted(&slow, 3), &slow, (1, 90)), Some(-3));
    }

    #[test]
    fn an_offset_that_fits_in_a_part_of_the_sequence_only_is_a_coincidence() {
        let still = walk(12..72, 0.5);
        let crowd = |frames: std::ops::Range<u32>, start: u32| {
            let place = move |number: u32, row: u32| {
                Bounds([f64::from(number - start) * 9.0, f64::from(row) * 50.0, 10.0, 20.0])
            };
            frames.map(move |number| (number, (2..7).map(move |row| (row, place(number, row))).collect()))
        };
        let (mut truth, mut found): (Boxes, Boxes) = (crowd(1..9, 1).collect(), crowd(4..12, 4).collect());
        assert_eq!(better_offset(&truth, &found, (1, 90)), Some(3));
        truth.extend(still.clone());
        found.extend(still);
        assert_eq!(better_offset(&truth, &found, (1, 90)), None);
    }
}
