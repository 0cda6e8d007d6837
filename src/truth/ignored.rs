//! True boxes that are not judged, and what is found at them.

use std::collections::BTreeMap;

use super::boxes::{Bounds, Boxes};
use super::clear_mot::assign;

/// The boxes of each frame in which nothing is found or missed.
pub type Ignored = BTreeMap<u32, Vec<Bounds>>;

/// Least IoU at which a found box belongs to a true one, as in MOTChallenge.
const MIN_IOU: f64 = 0.5;

/// The found boxes without those that belong to an ignored box. In each frame they are assigned to the true and the
/// ignored boxes together, as MOTChallenge does, so that a true object beside an ignored one keeps its match.
pub fn without_ignored(truth: &Boxes, ignored: &Ignored, found: &Boxes) -> Boxes {
    let mut kept = found.clone();
    for (frame, ignored) in ignored {
        let Some(boxes) = kept.get_mut(frame) else { continue };
        let identities: Vec<u32> = boxes.keys().copied().collect();
        let mut places: Vec<Bounds> = ignored.clone();
        places.extend(truth.get(frame).into_iter().flat_map(BTreeMap::values));
        let rows: Vec<u32> = (0..places.len() as u32).collect();
        let weight = |row: &u32, identity: &u32| {
            let iou = places[*row as usize].iou(&boxes[identity]);
            if iou >= MIN_IOU { (iou * 1e8) as i64 } else { 0 }
        };
        for (row, identity) in assign(&rows, &identities, weight) {
            if (row as usize) < ignored.len() {
                boxes.remove(&identity);
            }
        }
    }
    kept.retain(|_, boxes| !boxes.is_empty());
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_at_ignored_ones_are_dropped_and_true_objects_keep_theirs() {
        let at = |x: f64| Bounds([x, 0.0, 10.0, 10.0]);
        let truth = Boxes::from([(1, BTreeMap::from([(1, at(0.0))]))]);
        let ignored = Ignored::from([(1, vec![at(2.0), at(50.0)]), (2, vec![at(50.0)])]);
        let found = Boxes::from([
            (1, BTreeMap::from([(7, at(0.5)), (8, at(51.0)), (9, at(100.0))])),
            (2, BTreeMap::from([(8, at(52.0))])),
        ]);
        let kept = without_ignored(&truth, &ignored, &found);
        assert_eq!(kept, Boxes::from([(1, BTreeMap::from([(7, at(0.5)), (9, at(100.0))]))]));
        assert_eq!(without_ignored(&truth, &Ignored::new(), &found), found);
    }
}
