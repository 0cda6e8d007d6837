//! True boxes that are not judged, and what is found at them.

use std::collections::BTreeMap;

use super::boxes::{Bounds, Boxes};
use super::clear_mot::assign;
use crate::placement::Crop;

/// The boxes of each frame in which nothing is found or missed.
pub type Ignored = BTreeMap<u32, Vec<Bounds>>;

/// Least IoU at which a found box belongs to a true one, as in MOTChallenge.
const MIN_IOU: f64 = 0.5;

/// Least share of its area in the analysed part of the image with which a true box is judged.
const MIN_SHARE: f64 = 0.5;

/// Leaves out what lies outside the analysed part of the image, which cannot be found there: boxes are cut to it, and one of
/// which less than half lies in it becomes an ignored one. Returns the number of boxes that are judged no more; their
/// frames stay.
pub fn crop(boxes: &mut Boxes, ignored: &mut Ignored, crop: &Crop) -> usize {
    for places in ignored.values_mut() {
        *places = places.iter().filter_map(|place| place.within(crop)).collect();
    }
    let mut left_out = 0;
    for (number, boxes) in boxes {
        boxes.retain(|_, bounds| {
            let part = bounds.within(crop);
            if let Some(part) = part.filter(|part| part.area() >= MIN_SHARE * bounds.area()) {
                *bounds = part;
                return true;
            }
            if let Some(part) = part {
                ignored.entry(*number).or_default().push(part);
            }
            left_out += 1;
            false
        });
    }
    left_out
}

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
    #![allow(clippy::panic)]

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

    #[test]
    fn boxes_are_cut_to_the_crop_and_ignored_where_less_than_half_is_in_it() {
        let at = |x: f64, y: f64| Bounds([x, y, 10.0, 10.0]);
        let part = Crop { x: 20, y: 10, width: 40, height: 30 };
        let inside = at(30.1, 20.3);
        let places = [inside, at(15.0, 20.0), at(14.9, 20.0), at(10.0, 20.0), at(58.0, 38.0)];
        let mut boxes =
            Boxes::from([(1, (1..).zip(places).collect()), (2, BTreeMap::from([(4, places[3])]))]);
        let mut ignored = Ignored::from([(1, vec![at(55.0, 20.0), at(60.0, 20.0)])]);
        assert_eq!(crop(&mut boxes, &mut ignored, &part), 4);
        let cut = Bounds([20.0, 20.0, 5.0, 10.0]);
        assert_eq!(boxes, Boxes::from([(1, BTreeMap::from([(1, inside), (2, cut)])), (2, BTreeMap::new())]));
        let [ignored_before, mostly_left, mostly_below] = ignored[&1][..] else { panic!("{ignored:?}") };
        assert_eq!(ignored_before, Bounds([55.0, 20.0, 5.0, 10.0]));
        assert!((mostly_left.0[2] - 4.9).abs() < 1e-9 && mostly_left.0[0] == 20.0);
        assert_eq!(mostly_below, Bounds([58.0, 38.0, 2.0, 2.0]));
        // What is found at the part that is in it is no false alarm, as at any ignored box.
        let found = Boxes::from([(1, BTreeMap::from([(7, mostly_below), (8, at(40.0, 20.0))]))]);
        let kept = without_ignored(&boxes, &ignored, &found);
        assert_eq!(kept[&1].keys().collect::<Vec<_>>(), [&8]);
    }
}
