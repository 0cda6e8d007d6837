//! CLEAR-MOT (Bernardin & Stiefelhagen 2008) and IDF1 (Ristani et al. 2016).

use std::collections::{BTreeMap, BTreeSet};

use pathfinding::matrix::Matrix;
use pathfinding::prelude::kuhn_munkres;
use serde::Serialize;

use super::boxes::Boxes;
use super::share::share_or_zero;

/// Tracking accuracy, for matches from some IoU on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClearMot {
    /// 1 − (false negatives + false positives + identity switches) / true boxes.
    pub mota: f64,
    /// The mean of 1 − IoU over all matches; smaller is better.
    pub motp: f64,
    /// The harmonic mean of identity precision and recall.
    pub idf1: f64,
    /// Matched boxes / found boxes.
    pub precision: f64,
    /// Matched boxes / true boxes.
    pub recall: f64,
    /// IDSW, the number of identity switches.
    pub num_switches: usize,
    /// Number of times that an object's track is interrupted and resumed.
    pub num_fragmentations: usize,
    /// Number of true objects that are matched in at least four fifths of their frames.
    pub mostly_tracked: usize,
    /// Number of true objects.
    pub num_unique_objects: usize,
}

/// Scores `found` against `truth`; boxes can match if their IoU is at least `threshold`, 0..=1.
///
/// # Examples
/// An object in four frames that is missed in frame 2 and has another identity in frame 4:
///
/// ```
/// use occluscope::truth::boxes::{Bounds, Boxes};
/// use occluscope::truth::clear_mot;
///
/// // The frame, identity and left edge of boxes of 10 × 10 pixels.
/// let boxes = |rows: &[(u32, u32, f64)]| {
///     let mut boxes = Boxes::new();
///     for &(frame, identity, x) in rows {
///         boxes.entry(frame).or_default().insert(identity, Bounds([x, 0.0, 10.0, 10.0]));
///     }
///     boxes
/// };
/// let truth = boxes(&[(1, 1, 0.0), (2, 1, 4.0), (3, 1, 8.0), (4, 1, 12.0)]);
/// let found = boxes(&[(1, 5, 0.0), (3, 5, 8.0), (4, 6, 12.0)]);
///
/// let score = clear_mot::score(&truth, &found, 0.5);
/// assert_eq!((score.precision, score.recall), (1.0, 0.75));
/// assert_eq!((score.num_switches, score.num_fragmentations), (1, 1));
/// assert_eq!(score.mota, 1.0 - 2.0 / 4.0, "one false negative and one switch");
/// assert_eq!(score.idf1, 2.0 * 2.0 / (4.0 + 3.0), "identity 5 is the object in two frames");
/// ```
pub fn score(truth: &Boxes, found: &Boxes, threshold: f64) -> ClearMot {
    let frames: BTreeSet<u32> = truth.keys().chain(found.keys()).copied().collect();
    let no_boxes = BTreeMap::new();
    let mut last_match: BTreeMap<u32, u32> = BTreeMap::new();
    // For each true object whether it was matched, frame by frame.
    let mut matches_of: BTreeMap<u32, Vec<bool>> = BTreeMap::new();
    let mut overlaps: BTreeMap<(u32, u32), i64> = BTreeMap::new();
    let (mut matched, mut false_positives, mut switches, mut distance_sum) = (0_usize, 0, 0, 0.0);
    for frame in frames {
        let (true_boxes, found_boxes) =
            (truth.get(&frame).unwrap_or(&no_boxes), found.get(&frame).unwrap_or(&no_boxes));
        let mut distances: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for (object, a) in true_boxes {
            for (identity, b) in found_boxes {
                let iou = a.iou(b);
                if iou >= threshold {
                    distances.insert((*object, *identity), 1.0 - iou);
                    *overlaps.entry((*object, *identity)).or_default() += 1;
                }
            }
        }
        let mut pairs: BTreeMap<u32, u32> = BTreeMap::new();
        // A match of the previous frame is kept if possible.
        for object in true_boxes.keys() {
            if let Some(&identity) = last_match.get(object)
                && distances.contains_key(&(*object, identity))
                && !pairs.values().any(|taken| *taken == identity)
            {
                pairs.insert(*object, identity);
            }
        }
        let unmatched_objects: Vec<u32> =
            true_boxes.keys().filter(|object| !pairs.contains_key(object)).copied().collect();
        let taken: BTreeSet<u32> = pairs.values().copied().collect();
        let unmatched_identities: Vec<u32> =
            found_boxes.keys().filter(|identity| !taken.contains(identity)).copied().collect();
        // The largest number of matches first, then the largest IoU.
        let weight = |object: &u32, identity: &u32| {
            distances
                .get(&(*object, *identity))
                .map_or(0, |distance| 1_000_000_000_000 - (distance * 1e8) as i64)
        };
        for (object, identity) in assign(&unmatched_objects, &unmatched_identities, weight) {
            if last_match.get(&object).is_some_and(|last| *last != identity) {
                switches += 1;
            }
            pairs.insert(object, identity);
        }
        for object in true_boxes.keys() {
            matches_of.entry(*object).or_default().push(pairs.contains_key(object));
        }
        for (object, identity) in &pairs {
            distance_sum += distances[&(*object, *identity)];
            last_match.insert(*object, *identity);
        }
        matched += pairs.len();
        false_positives += found_boxes.len() - pairs.len();
    }
    let boxes = |all: &Boxes| all.values().map(BTreeMap::len).sum::<usize>();
    let (true_count, found_count) = (boxes(truth), boxes(found));
    let identities: BTreeSet<u32> = found.values().flat_map(BTreeMap::keys).copied().collect();
    let (objects, identities): (Vec<u32>, Vec<u32>) =
        (matches_of.keys().copied().collect(), identities.into_iter().collect());
    let overlap = |object: &u32, identity: &u32| overlaps.get(&(*object, *identity)).copied().unwrap_or(0);
    let same: i64 = assign(&objects, &identities, overlap).iter().map(|(a, b)| overlap(a, b)).sum();
    let missed = true_count - matched;
    let share = |part: usize, whole: usize| share_or_zero(part as u64, whole as u64);
    ClearMot {
        mota: 1.0 - (missed + false_positives + switches) as f64 / true_count.max(1) as f64,
        motp: distance_sum / matched.max(1) as f64,
        idf1: share(2 * same as usize, true_count + found_count),
        precision: share(matched, found_count),
        recall: share(matched, true_count),
        num_switches: switches,
        num_fragmentations: matches_of.values().map(|matches| fragmentations(matches)).sum(),
        mostly_tracked: matches_of
            .values()
            .filter(|matches| share(matches.iter().filter(|matched| **matched).count(), matches.len()) >= 0.8)
            .count(),
        num_unique_objects: matches_of.len(),
    }
}

/// The assignment of the greatest total weight; pairs of weight 0 are not assigned.
pub(crate) fn assign(rows: &[u32], columns: &[u32], weight: impl Fn(&u32, &u32) -> i64) -> Vec<(u32, u32)> {
    if rows.is_empty() || columns.is_empty() {
        return Vec::new();
    }
    // The library needs at least as many columns as rows; additional columns are dummies.
    let width = columns.len().max(rows.len());
    let value = |(row, column): (usize, usize)| columns.get(column).map_or(0, |it| weight(&rows[row], it));
    let (_, chosen) = kuhn_munkres(&Matrix::from_fn(rows.len(), width, value));
    let pairs = rows.iter().zip(chosen).filter_map(|(row, column)| Some((*row, *columns.get(column)?)));
    pairs.filter(|(row, column)| weight(row, column) > 0).collect()
}

/// Number of changes from matched to not matched, without the last one if it is final.
fn fragmentations(matches: &[bool]) -> usize {
    let last = matches.iter().rposition(|matched| *matched).unwrap_or(0);
    matches[..=last.min(matches.len().saturating_sub(1))]
        .windows(2)
        .filter(|pair| pair[0] && !pair[1])
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::boxes::Bounds;

    /// Boxes from `(frame, identity, left)`, all 10×10 at the top.
    fn boxes(rows: &[(u32, u32, f64)]) -> Boxes {
        let mut boxes = Boxes::new();
        for &(frame, id, x) in rows {
            boxes.entry(frame).or_default().insert(id, Bounds([x, 0.0, 10.0, 10.0]));
        }
        boxes
    }

    #[test]
    fn perfect_tracks_score_one() {
        let truth = boxes(&[(1, 1, 0.0), (2, 1, 5.0), (2, 2, 50.0)]);
        let score = score(&truth, &truth, 0.5);
        assert_eq!((score.mota, score.idf1, score.motp), (1.0, 1.0, 0.0));
        assert_eq!((score.precision, score.recall, score.mostly_tracked), (1.0, 1.0, 2));
        assert_eq!((score.num_switches, score.num_fragmentations, score.num_unique_objects), (0, 0, 2));
    }

    #[test]
    fn scores_equal_values_computed_by_hand() {
        let truth = boxes(&[(1, 1, 0.0), (2, 1, 0.0), (3, 1, 0.0), (4, 1, 0.0), (5, 1, 0.0)]);
        // A false negative in frame 2, a false positive in 3, another identity from 4 on; IoU of a shift by 2:
        // 80/120.
        let found = boxes(&[(1, 7, 0.0), (3, 7, 2.0), (3, 9, 60.0), (4, 8, 0.0), (5, 8, 0.0)]);
        let score = score(&truth, &found, 0.5);
        assert_eq!(score.mota, 1.0 - 3.0 / 5.0);
        assert!((score.motp - (1.0 / 3.0) / 4.0).abs() < 1e-12);
        assert_eq!((score.precision, score.recall), (0.8, 0.8));
        assert_eq!((score.num_switches, score.num_fragmentations, score.mostly_tracked), (1, 1, 1));
        assert_eq!(score.idf1, 2.0 * 2.0 / 10.0);
    }

    #[test]
    fn a_match_is_kept_although_another_box_is_nearer() {
        let truth = boxes(&[(1, 1, 0.0), (2, 1, 0.0)]);
        let found = boxes(&[(1, 7, 0.0), (2, 7, 3.0), (2, 8, 0.0)]);
        let score = score(&truth, &found, 0.5);
        assert_eq!((score.num_switches, score.mota), (0, 0.5));
    }

    #[test]
    fn empty_truth_or_result_is_scored() {
        let some = boxes(&[(1, 1, 0.0)]);
        let missed = score(&some, &Boxes::new(), 0.5);
        assert_eq!((missed.mota, missed.recall, missed.idf1), (0.0, 0.0, 0.0));
        assert_eq!(score(&Boxes::new(), &some, 0.5).precision, 0.0);
        // Without true boxes each false positive counts as for one true box.
        assert_eq!(score(&Boxes::new(), &some, 0.5).mota, 0.0);
    }

    #[test]
    fn of_equally_many_matches_those_of_largest_overlap_are_taken() {
        let truth = boxes(&[(1, 1, 0.0), (1, 2, 3.0)]);
        let found = boxes(&[(1, 7, 1.0), (1, 8, 4.0)]);
        // An IoU of 90/110 for both, or of 60/140 and 80/120.
        let score = score(&truth, &found, 0.4);
        assert_eq!(score.mota, 1.0);
        assert!((score.motp - 20.0 / 110.0).abs() < 1e-12, "{}", score.motp);
    }
}
