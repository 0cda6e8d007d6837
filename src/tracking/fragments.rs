//! Fragments: regions of one frame that are parts of one object, joined to one detection.
//!
//! Where a part of an object has the colour of the background, its mask has a gap. The distance of the fragments is
//! small relative to their size: one is above the other (with a belt, a rail or a bench between them), or a small one
//! (a hand, a foot) is beside a large one. Two objects side by side are neither.

use crate::regions::Rect;
use crate::regions::box_index::BoxIndex;

/// Two regions are one above the other when they share at least this part of the narrower one's columns.
pub const MIN_SHARED_COLUMNS: f32 = 0.5;
/// A region of at most this share of another's pixels may be a small part of it.
const MAX_SMALL_SHARE: f32 = 0.3;

/// Groups regions, `(box, number of pixels)`, into detections. Each is given by the ascending indices of its regions.
///
/// `owners` holds for each region the object that already explains it, if one does: fragments of two different
/// objects are never joined. `max_gap` is the largest gap of two fragments, one above the other, relative to the
/// longest side of both boxes; of a small region beside a large one, relative to √area of the large one. 0 joins
/// nothing.
pub fn group_fragments(regions: &[(Rect, f32)], owners: &[Option<usize>], max_gap: f32) -> Vec<Vec<usize>> {
    let mut groups: Vec<(Vec<usize>, Option<usize>)> =
        (0..regions.len()).map(|index| (vec![index], owners.get(index).copied().flatten())).collect();
    if max_gap <= 0.0 {
        return groups.into_iter().map(|(group, _)| group).collect();
    }
    // The nearest pairs first, so that a fragment between two objects goes to the nearer one.
    let mut pairs: Vec<(f32, usize, usize)> = Vec::new();
    let index = BoxIndex::new(regions.iter().map(|(bbox, _)| *bbox));
    for (first, a) in regions.iter().enumerate() {
        // The larger of two is within its reach of the smaller.
        for second in index.meeting(&within_reach(a, max_gap)) {
            let Some(b) = regions.get(second).filter(|_| second != first) else { continue };
            if let Some(gap) = fragment_gap(a, b).filter(|gap| *gap <= max_gap) {
                pairs.push((gap, first.min(second), first.max(second)));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    pairs.dedup();
    let mut group_of: Vec<usize> = (0..regions.len()).collect();
    for (_, first, second) in pairs {
        let (Some(&a), Some(&b)) = (group_of.get(first), group_of.get(second)) else { continue };
        let (low, high) = (a.min(b), a.max(b));
        let owner_of = |group: usize| groups.get(group).and_then(|(_, owner)| *owner);
        let conflict = matches!((owner_of(low), owner_of(high)), (Some(a), Some(b)) if a != b);
        if low == high || conflict {
            continue;
        }
        let Some((moved, owner)) = groups.get_mut(high).map(std::mem::take) else { continue };
        for &index in &moved {
            if let Some(group) = group_of.get_mut(index) {
                *group = low;
            }
        }
        if let Some((members, kept)) = groups.get_mut(low) {
            members.extend(moved);
            members.sort_unstable();
            *kept = kept.or(owner);
        }
    }
    groups.into_iter().map(|(group, _)| group).filter(|group| !group.is_empty()).collect()
}

/// What is near enough to a region for `max_gap`, if the other one is not larger.
fn within_reach((bbox, area): &(Rect, f32), max_gap: f32) -> Rect {
    let reach = max_gap * bbox.w.max(bbox.h).max(area.sqrt()).max(1.0);
    bbox.grown(reach, reach)
}

/// The gap between two regions relative to their size, `None` where their arrangement is not that of fragments.
fn fragment_gap((a, a_area): &(Rect, f32), (b, b_area): &(Rect, f32)) -> Option<f32> {
    let [across, down] = a.gap(b);
    let stacked = a.shared_columns(b) >= MIN_SHARED_COLUMNS;
    let small = a_area.min(*b_area) <= MAX_SMALL_SHARE * a_area.max(*b_area);
    let stacked_gap = down / a.w.max(a.h).max(b.w).max(b.h).max(1.0);
    let small_gap = across.hypot(down) / a_area.max(*b_area).max(1.0).sqrt();
    match (stacked, small) {
        (true, true) => Some(stacked_gap.min(small_gap)),
        (true, false) => Some(stacked_gap),
        (false, true) => Some(small_gap),
        (false, false) => None,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn region(x: f32, y: f32, w: f32, h: f32) -> (Rect, f32) {
        (Rect::new(x, y, w, h), 0.7 * w * h)
    }

    fn group(regions: &[(Rect, f32)]) -> Vec<Vec<usize>> {
        group_fragments(regions, &vec![None; regions.len()], 0.15)
    }

    #[test]
    fn two_stacked_regions_with_a_small_gap_are_one_detection() {
        let (torso, legs) = (region(100.0, 50.0, 20.0, 28.0), region(101.0, 81.0, 18.0, 30.0));
        assert_eq!(group(&[torso, legs]), [[0, 1]]);
        assert_eq!(group(&[torso, region(101.0, 95.0, 18.0, 30.0)]).len(), 2, "too far below");
    }

    #[test]
    fn two_side_by_side_are_two_and_a_small_region_belongs_to_the_nearer() {
        let (left, right) = (region(100.0, 50.0, 20.0, 60.0), region(124.0, 50.0, 20.0, 60.0));
        assert_eq!(group(&[left, right]).len(), 2);
        let hand = region(147.0, 80.0, 4.0, 5.0);
        assert_eq!(group(&[left, right, hand]), [vec![0], vec![1, 2]]);
    }

    #[test]
    fn fragments_of_two_objects_are_not_joined_by_way_of_a_third() {
        let (upper, lower) = (region(100.0, 20.0, 20.0, 40.0), region(100.0, 70.0, 20.0, 40.0));
        let between = region(105.0, 62.0, 10.0, 6.0);
        let regions = [upper, lower, between];
        assert_eq!(group(&regions), [[0, 1, 2]]);
        let apart = group_fragments(&regions, &[Some(4), Some(7), None], 0.15);
        assert_eq!(apart.len(), 2);
        assert!(apart.iter().all(|group| !(group.contains(&0) && group.contains(&1))));
    }

    #[test]
    fn without_a_gap_every_region_is_a_detection() {
        let regions = [region(100.0, 50.0, 20.0, 28.0), region(100.0, 78.0, 20.0, 28.0)];
        assert_eq!(group_fragments(&regions, &[None, None], 0.0), [[0], [1]]);
    }

    proptest! {
        #[test]
        fn of_two_fragments_one_is_within_reach_of_the_other(
            first in prop::array::uniform4(1.0_f32..60.0),
            second in prop::array::uniform4(1.0_f32..60.0),
            max_gap in 0.01_f32..1.0,
        ) {
            let [a, b] = [first, second].map(|[x, y, w, h]| region(x, y, w, h));
            let reaches = |a: &(Rect, f32), b: &(Rect, f32)| within_reach(a, max_gap).gap(&b.0) == [0.0; 2];
            let fits = fragment_gap(&a, &b).is_some_and(|gap| gap <= max_gap);
            prop_assert!(!fits || reaches(&a, &b) || reaches(&b, &a));
        }
    }
}
