//! CLEAR-MOT (Bernardin & Stiefelhagen 2008) and IDF1 (Ristani et al. 2016).

use std::collections::{BTreeMap, BTreeSet};

use pathfinding::matrix::Matrix;
use pathfinding::prelude::kuhn_munkres;
use serde::Serialize;

use super::boxes::Boxes;

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

/// Scores `found` against `truth`; boxes can match if their IoU is at least `threshold`.
pub fn score(truth: &Boxes, found: &Boxes, threshold: f64) -> ClearMot {
    let frames: BTreeSet<u32> = truth.keys().chain(found.keys()).copied().collect();
    let nothing = BTreeMap::new();
    let mut last_match: BTreeMap<u32, u32> = BTreeMap::new();
    // For each true object whether it was matched, frame by frame.
    let mut lives: BTreeMap<u32, Vec<bool>> = BTreeMap::new();
    let mut overlaps: BTreeMap<(u32, u32), i64> = BTreeMap::new();
    let (mut matched, mut made_up, mut switches, mut distances) = (0_usize, 0, 0, 0.0);
    for frame in frames {
        let (true_ones, found_ones) =
            (truth.get(&frame).unwrap_or(&nothing), found.get(&frame).unwrap_or(&nothing));
        let mut near: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for (object, a) in true_ones {
            for (identity, b) in found_ones {
                let iou = a.iou(b);
                if iou >= threshold {
                    near.insert((*object, *identity), 1.0 - iou);
                    *overlaps.entry((*object, *identity)).or_default() += 1;
                }
            }
        }
        let mut pairs: BTreeMap<u32, u32> = BTreeMap::new();
        // A match of the previous frame is kept if possible.
        for object in true_ones.keys() {
            if let Some(&identity) = last_match.get(object)
                && near.contains_key(&(*object, identity))
                && !pairs.values().any(|taken| *taken == identity)
            {
                pairs.insert(*object, identity);
            }
        }
        let free: Vec<u32> = true_ones.keys().filter(|object| !pairs.contains_key(object)).copied().collect();
        let taken: BTreeSet<u32> = pairs.values().copied().collect();
        let open: Vec<u32> =
            found_ones.keys().filter(|identity| !taken.contains(identity)).copied().collect();
        // The largest number of matches first, then the largest IoU.
        let weight = |object: &u32, identity: &u32| {
            near.get(&(*object, *identity)).map_or(0, |distance| 1_000_000_000_000 - (distance * 1e8) as i64)
        };
        for (object, identity) in assign(&free, &open, weight) {
            if last_match.get(&object).is_some_and(|last| *last != identity) {
                switches += 1;
            }
            pairs.insert(object, identity);
        }
        for object in true_ones.keys() {
            lives.entry(*object).or_default().push(pairs.contains_key(object));
        }
        for (object, identity) in &pairs {
            distances += near[&(*object, *identity)];
            last_match.insert(*object, *identity);
        }
        matched += pairs.len();
        made_up += found_ones.len() - pairs.len();
    }
    let boxes = |all: &Boxes| all.values().map(BTreeMap::len).sum::<usize>();
    let (true_boxes, found_boxes) = (boxes(truth), boxes(found));
    let identities: BTreeSet<u32> = found.values().flat_map(BTreeMap::keys).copied().collect();
    let (objects, identities): (Vec<u32>, Vec<u32>) =
        (lives.keys().copied().collect(), identities.into_iter().collect());
    let overlap = |object: &u32, identity: &u32| overlaps.get(&(*object, *identity)).copied().unwrap_or(0);
    let same: i64 = assign(&objects, &identities, overlap).iter().map(|(a, b)| overlap(a, b)).sum();
    let missed = true_boxes - matched;
    ClearMot {
        mota: 1.0 - share(missed + made_up + switches, true_boxes),
        motp: distances / matched.max(1) as f64,
        idf1: share(2 * same as usize, true_boxes + found_boxes),
        precision: share(matched, found_boxes),
        recall: share(matched, true_boxes),
        num_switches: switches,
        num_fragmentations: lives.values().map(|life| fragmentations(life)).sum(),
        mostly_tracked: lives
            .values()
            .filter(|life| share(life.iter().filter(|matched| **matched).count(), life.len()) >= 0.8)
            .count(),
        num_unique_objects: lives.len(),
    }
}

fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// The assignment of the greatest total weight; pairs of weight 0 are not assigned.
fn assign(rows: &[u32], columns: &[u32], weight: impl Fn(&u32, &u32) -> i64) -> Vec<(u32, u32)> {
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
fn fragmentations(life: &[bool]) -> usize {
    let last = life.iter().rposition(|matched| *matched).unwrap_or(0);
    life[..=last.min(life.len().saturating_sub(1))].windows(2).filter(|pair| pair[0] && !pair[1]).count()
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
    }
}
