//! HOTA (Luiten et al. 2021): accuracy of detection, association and localisation, as TrackEval computes it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::assignment;
use super::boxes::{Bounds, Boxes};
use super::share::share_or_zero;

/// Number of least IoUs of a match, 0.05, 0.1 … 0.95.
const THRESHOLDS: usize = 19;

/// Means over the least IoUs 0.05, 0.1 … 0.95 of a match, each 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hota {
    /// The mean of √(DetA·AssA).
    pub hota: f64,
    /// Detection accuracy: matches / (matches + false negatives + false positives).
    pub deta: f64,
    /// Association accuracy: the mean over all matches of the Jaccard index of the two tracks.
    pub assa: f64,
    /// Localisation accuracy: the mean IoU of the matches; 1 without matches.
    pub loca: f64,
}

/// Scores `found` against `truth`.
///
/// # Examples
/// An object in four frames whose identity changes in the middle: all boxes are right, and each track overlaps with
/// the object in half of the frames.
///
/// ```
/// use occluscope::truth::boxes::{Bounds, Boxes};
/// use occluscope::truth::hota;
///
/// let boxes = |identities: [u32; 4]| -> Boxes {
///     let frames = (1..).zip(identities);
///     frames.map(|(frame, identity)| (frame, [(identity, Bounds([0.0, 0.0, 10.0, 20.0]))].into())).collect()
/// };
/// let score = hota::score(&boxes([1; 4]), &boxes([5, 5, 6, 6]));
/// assert_eq!((score.deta, score.loca), (1.0, 1.0));
/// assert!((score.assa - 0.5).abs() < 1e-12 && (score.hota - 0.5_f64.sqrt()).abs() < 1e-12);
/// ```
pub fn score(truth: &Boxes, found: &Boxes) -> Hota {
    let frames_of_objects = frames_of(truth);
    let frames_of_identities = frames_of(found);
    let lengths =
        |(object, identity): &(u32, u32)| (frames_of_objects[object] + frames_of_identities[identity]) as f64;
    let mut alignments = soft_matches(truth, found);
    for (pair, alignment) in &mut alignments {
        *alignment /= lengths(pair) - *alignment;
    }

    // Number of matches of each pair of an object and an identity from each IoU on, and the sum of their IoUs.
    let mut matches: BTreeMap<(u32, u32), [u64; THRESHOLDS]> = BTreeMap::new();
    let mut iou_sums = [0.0; THRESHOLDS];
    for frame in frames_of_both(truth, found) {
        let pairs = frame.pairs();
        let costs: Vec<f64> = pairs
            .iter()
            .zip(&frame.ious)
            .map(|(pair, iou)| if *iou > 0.0 { -alignments[pair] * iou } else { 0.0 })
            .collect();
        for (row, column) in assignment::cheapest(frame.objects.len(), frame.identities.len(), &costs) {
            let at = row * frame.identities.len() + column;
            let iou = frame.ious[at];
            let reached = (0..THRESHOLDS).take_while(|step| iou >= threshold(*step) - f64::EPSILON).count();
            if reached > 0 {
                matches.entry(pairs[at]).or_default()[..reached].iter_mut().for_each(|count| *count += 1);
                iou_sums[..reached].iter_mut().for_each(|sum| *sum += iou);
            }
        }
    }

    let boxes: u64 = frames_of_objects.values().chain(frames_of_identities.values()).sum();
    let mut sums = Hota::default();
    for (step, iou_sum) in iou_sums.into_iter().enumerate() {
        let matched: u64 = matches.values().map(|counts| counts[step]).sum();
        let jaccard_sum: f64 = matches
            .iter()
            .map(|(pair, counts)| {
                let count = counts[step] as f64;
                count * count / (lengths(pair) - count)
            })
            .sum();
        let deta = share_or_zero(matched, boxes - matched);
        let assa = jaccard_sum / matched.max(1) as f64;
        sums.hota += (deta * assa).sqrt();
        sums.deta += deta;
        sums.assa += assa;
        sums.loca += if matched > 0 { iou_sum / matched as f64 } else { 1.0 };
    }
    let mean = |sum: f64| sum / THRESHOLDS as f64;
    Hota { hota: mean(sums.hota), deta: mean(sums.deta), assa: mean(sums.assa), loca: mean(sums.loca) }
}

fn threshold(step: usize) -> f64 {
    0.05 + step as f64 * 0.05
}

/// Number of frames in which each identity has a box.
fn frames_of(boxes: &Boxes) -> BTreeMap<u32, u64> {
    let mut frames = BTreeMap::new();
    for identity in boxes.values().flat_map(BTreeMap::keys) {
        *frames.entry(*identity).or_default() += 1;
    }
    frames
}

/// For pairs of an object and an identity the sum over all frames of their IoU's share of all that the two have.
fn soft_matches(truth: &Boxes, found: &Boxes) -> BTreeMap<(u32, u32), f64> {
    let mut sums = BTreeMap::new();
    for frame in frames_of_both(truth, found) {
        let mut of_objects = vec![0.0; frame.objects.len()];
        let mut of_identities = vec![0.0; frame.identities.len()];
        let columns = frame.identities.len();
        for (at, iou) in frame.ious.iter().enumerate() {
            of_objects[at / columns] += iou;
            of_identities[at % columns] += iou;
        }
        for ((at, iou), pair) in frame.ious.iter().enumerate().zip(frame.pairs()) {
            if *iou > 0.0 {
                let all = of_objects[at / columns] + of_identities[at % columns] - iou;
                *sums.entry(pair).or_default() += iou / all;
            }
        }
    }
    sums
}

/// The boxes of a frame with both true and found ones.
struct FrameOfBoth {
    objects: Vec<u32>,
    identities: Vec<u32>,
    /// The IoU of each object with each identity, by object.
    ious: Vec<f64>,
}

impl FrameOfBoth {
    fn pairs(&self) -> Vec<(u32, u32)> {
        let of = |object: u32| self.identities.iter().map(move |identity| (object, *identity));
        self.objects.iter().copied().flat_map(of).collect()
    }
}

fn frames_of_both(truth: &Boxes, found: &Boxes) -> impl Iterator<Item = FrameOfBoth> {
    truth.iter().filter_map(|(frame, objects)| {
        let identities = found.get(frame)?;
        let ious = |a: &Bounds| identities.values().map(|b| iou(a, b)).collect::<Vec<_>>();
        Some(FrameOfBoth {
            objects: objects.keys().copied().collect(),
            identities: identities.keys().copied().collect(),
            ious: objects.values().flat_map(ious).collect(),
        })
    })
}

/// Intersection over union with areas from the corners, as in TrackEval: in its last digits it decides on matches at a
/// threshold.
fn iou(a: &Bounds, b: &Bounds) -> f64 {
    let [[ax, ay, aw, ah], [bx, by, bw, bh]] = [a.0, b.0];
    let area = |[x, y, w, h]: [f64; 4]| ((x + w) - x) * ((y + h) - y);
    let (area_a, area_b) = (area(a.0), area(b.0));
    if area_a <= f64::EPSILON || area_b <= f64::EPSILON {
        return 0.0;
    }
    let width = (ax + aw).min(bx + bw) - ax.max(bx);
    let height = (ay + ah).min(by + bh) - ay.max(by);
    let shared = width.max(0.0) * height.max(0.0);
    // 0 also for areas beyond the range of numbers.
    (shared / (area_a + area_b - shared)).max(0.0)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    /// The definition, with the best of all assignments of each frame.
    fn reference(truth: &Boxes, found: &Boxes) -> Hota {
        let identities =
            |boxes: &Boxes| -> BTreeSet<u32> { boxes.values().flat_map(BTreeMap::keys).copied().collect() };
        let (objects, identities) = (identities(truth), identities(found));
        let frames: BTreeSet<u32> = truth.keys().chain(found.keys()).copied().collect();
        let similarity = |frame: u32, object: u32, identity: u32| {
            let place = |boxes: &Boxes, of: u32| boxes.get(&frame).and_then(|boxes| boxes.get(&of).copied());
            match (place(truth, object), place(found, identity)) {
                (Some(a), Some(b)) => a.iou(&b),
                _ => 0.0,
            }
        };
        let count =
            |boxes: &Boxes, of: u32| boxes.values().filter(|boxes| boxes.contains_key(&of)).count() as f64;
        let all = |boxes: &Boxes| boxes.values().map(BTreeMap::len).sum::<usize>() as f64;
        let mut alignment = BTreeMap::new();
        for &object in &objects {
            for &identity in &identities {
                let soft = |&frame: &u32| {
                    let own = similarity(frame, object, identity);
                    let of_object: f64 =
                        identities.iter().map(|other| similarity(frame, object, *other)).sum();
                    let of_identity: f64 =
                        objects.iter().map(|other| similarity(frame, *other, identity)).sum();
                    if own > 0.0 { own / (of_object + of_identity - own) } else { 0.0 }
                };
                let soft: f64 = frames.iter().map(soft).sum();
                alignment.insert(
                    (object, identity),
                    soft / (count(truth, object) + count(found, identity) - soft),
                );
            }
        }
        let gain = |frame: u32, object: u32, identity: u32| {
            alignment[&(object, identity)] * similarity(frame, object, identity)
        };
        let objects: Vec<u32> = objects.into_iter().collect();
        let mut assigned: Vec<(u32, u32, u32)> = Vec::new();
        for &frame in &frames {
            let free: Vec<u32> = identities.iter().copied().collect();
            let (_, pairs) = best(&objects, &free, &|object, identity| gain(frame, object, identity));
            assigned.extend(pairs.into_iter().map(|(object, identity)| (frame, object, identity)));
        }
        let mut sums = [0.0; 4];
        for step in 1..=19 {
            let alpha = f64::from(step) / 20.0;
            let matches: Vec<_> =
                assigned.iter().filter(|it| similarity(it.0, it.1, it.2) >= alpha).collect();
            let matched = matches.len() as f64;
            let mean = |sum: f64, of_none: f64| if matches.is_empty() { of_none } else { sum / matched };
            let association = |&&(_, object, identity): &&(u32, u32, u32)| {
                let both = matches.iter().filter(|it| (it.1, it.2) == (object, identity)).count() as f64;
                both / (count(truth, object) + count(found, identity) - both)
            };
            let deta = if matches.is_empty() { 0.0 } else { matched / (all(truth) + all(found) - matched) };
            let assa = mean(matches.iter().map(association).sum(), 0.0);
            let loca = mean(matches.iter().map(|it| similarity(it.0, it.1, it.2)).sum(), 1.0);
            for (sum, value) in sums.iter_mut().zip([(deta * assa).sqrt(), deta, assa, loca]) {
                *sum += value / 19.0;
            }
        }
        let [hota, deta, assa, loca] = sums;
        Hota { hota, deta, assa, loca }
    }

    /// The greatest total gain of all assignments of objects to free identities, and its pairs that gain.
    fn best(objects: &[u32], free: &[u32], gain: &dyn Fn(u32, u32) -> f64) -> (f64, Vec<(u32, u32)>) {
        let Some((&object, others)) = objects.split_first() else { return (0.0, Vec::new()) };
        let mut most = best(others, free, gain);
        for &identity in free {
            let left: Vec<u32> = free.iter().copied().filter(|other| *other != identity).collect();
            let (mut sum, mut pairs) = best(others, &left, gain);
            sum += gain(object, identity);
            if sum > most.0 {
                pairs.push((object, identity));
                most = (sum, pairs);
            }
        }
        most
    }

    fn boxes(identities: u32) -> impl Strategy<Value = Boxes> {
        let place = (0.0..14.0, 0.0..9.0, 4.0..16.0, 4.0..16.0).prop_map(|(x, y, w, h)| Bounds([x, y, w, h]));
        let frame = prop::collection::btree_map(1..=identities, place, 0..=identities as usize);
        prop::collection::btree_map(1_u32..8, frame, 0..7)
    }

    fn assert_near(ours: Hota, expected: Hota) {
        let values = |of: Hota| [of.hota, of.deta, of.assa, of.loca];
        for (a, b) in values(ours).into_iter().zip(values(expected)) {
            assert!((a - b).abs() < 1e-12, "{ours:?}, expected {expected:?}");
        }
    }

    proptest! {
        #[test]
        fn scores_equal_the_definition(truth in boxes(3), found in boxes(4)) {
            assert_near(score(&truth, &found), reference(&truth, &found));
        }
    }

    #[test]
    fn nothing_found_or_nothing_to_find_scores_zero() {
        let some: Boxes = [(1, [(1, Bounds([0.0, 0.0, 10.0, 10.0]))].into())].into();
        let nothing = Hota { hota: 0.0, deta: 0.0, assa: 0.0, loca: 1.0 };
        for (truth, found) in [(&some, &Boxes::new()), (&Boxes::new(), &some), (&Boxes::new(), &Boxes::new())]
        {
            assert_eq!(score(truth, found), nothing);
        }
        let perfect = Hota { hota: 1.0, deta: 1.0, assa: 1.0, loca: 1.0 };
        assert_eq!(score(&some, &some), perfect);
    }

    #[test]
    fn a_box_at_a_threshold_matches() {
        // IoU 1/2 reaches ten of the nineteen thresholds, and 3/20 the first three in spite of rounding.
        for (width, reached) in [(10.0, 10.0), (3.0, 3.0)] {
            let truth: Boxes = [(1, [(1, Bounds([0.0, 0.0, 20.0, 10.0]))].into())].into();
            let found: Boxes = [(1, [(1, Bounds([0.0, 0.0, width, 10.0]))].into())].into();
            assert!((score(&truth, &found).deta - reached / 19.0).abs() < 1e-12, "{width}");
        }
    }

    #[test]
    fn sides_beyond_the_range_of_areas_match_nothing() {
        let huge: Boxes = [(1, [(1, Bounds([0.0, 0.0, 1e300, 1e300]))].into())].into();
        assert_eq!(score(&huge, &huge).deta, 0.0);
    }
}
