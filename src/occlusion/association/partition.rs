//! Clusters of blobs and detections that interact in a frame, and joining of fragments.

use std::collections::{BTreeMap, BTreeSet};

use crate::regions::Rect;
use crate::regions::box_index::BoxIndex;

/// The expected region of a blob, alone or a group.
#[derive(Clone, Debug)]
pub(super) struct ExpectedRegion {
    /// Its expected box.
    pub(super) bbox: Rect,
    /// Its expected area in pixels.
    pub(super) area: f32,
    /// The observation that the pool matched it with.
    pub(super) matched: Option<usize>,
    /// Whether it has several members.
    pub(super) group: bool,
}

/// Blobs and observations that interact.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cluster {
    /// Indices of blobs.
    pub(super) blobs: Vec<usize>,
    /// Indices of observations.
    pub(super) observations: Vec<usize>,
}

/// A region of at most this share of an object's area may be a separate fragment of it.
const MAX_SMALL_FRAGMENT_SHARE: f32 = 0.4;
/// Largest gap of such a fragment, over the object's height.
const MAX_FRAGMENT_GAP: f32 = 0.15;

/// Fragments of one object together are at most this multiple of its size. Tried from 1.25 to 2.5 on pedestrians far
/// and near and on fish; less loses objects that a post cuts, more joins neighbours.
const MAX_UNION_RATIO: f32 = 1.6;

/// Each of two side by side has at least this share of the height, and this share of the pixels, of the expected
/// object. The heights were tried from .4 to .6, on people near and far, forwards, backwards and mirrored, and on fish.
const MIN_BESIDE_HEIGHT: f32 = 0.5;
const MIN_BESIDE_AREA: f32 = 0.25;
/// And at least this width over its height: half of a person behind a pole has less. Tried: .27 and .35.
const MIN_BESIDE_WIDTH: f32 = 0.27;
/// They share at most this part of the narrower one's columns.
const MAX_SHARED_COLUMNS: f32 = 0.3;

/// Clusters blobs and observations: by the pool's match, and by place where the pool has none. `size_step` is the
/// growth that suggests a merge where the place alone does not decide.
pub(super) fn clusters(
    expected: &[ExpectedRegion],
    observed: &[(Rect, f32)],
    size_step: f32,
) -> Vec<Cluster> {
    let blobs = expected.len();
    let mut sets = DisjointSets::new(blobs + observed.len());
    let mut owners: Vec<Option<&ExpectedRegion>> = vec![None; observed.len()];
    for (blob, it) in expected.iter().enumerate() {
        if let Some(observation) = it.matched {
            sets.join(blob, blobs + observation);
            if let Some(owner) = owners.get_mut(observation) {
                owner.get_or_insert(it);
            }
        }
    }
    let index = BoxIndex::new(expected.iter().map(surroundings));
    for (observation, (region, owner)) in observed.iter().zip(owners).enumerate() {
        let (bbox, area) = region;
        let numbers = index.meeting(bbox).into_iter();
        let near: Vec<(usize, &ExpectedRegion)> =
            numbers.filter_map(|blob| Some((blob, expected.get(blob)?))).collect();
        if owner.is_none()
            && let Some(blob) = owner_of_unclaimed(bbox, *area, &near)
        {
            sets.join(blob, blobs + observation);
        }
        for (blob, it) in near.into_iter().filter(|(_, it)| it.matched.is_none()) {
            let contained = it.bbox.share_within(bbox);
            let belongs = match owner {
                None => lies_inside(bbox, it) || contained >= 0.5,
                Some(owner) => {
                    let grown = *area >= (1.0 + size_step) * owner.area;
                    contained >= 0.5 || (contained >= 0.2 && grown)
                }
            };
            if belongs {
                sets.join(blob, blobs + observation);
            }
        }
    }
    sets.into_clusters(blobs)
}

/// What meets every region that can belong to an expected one: a fragment of it at the largest gap, or a region inside
/// the box that [`lies_inside`] uses.
fn surroundings(expected: &ExpectedRegion) -> Rect {
    let Rect { w, h, .. } = expected.bbox;
    let gap = MAX_FRAGMENT_GAP * h;
    expected.bbox.grown(gap.max(0.1 * w), gap.max(0.1 * h))
}

/// The blob that an unclaimed region is a fragment of: it lies inside the expected box, or is small and close to it.
/// `near` are those near the region, by rising number.
fn owner_of_unclaimed(bbox: &Rect, area: f32, near: &[(usize, &ExpectedRegion)]) -> Option<usize> {
    let is_fragment = |it: &ExpectedRegion| {
        let small = area <= MAX_SMALL_FRAGMENT_SHARE * it.area && it.area > 0.0;
        small && gap(bbox, &it.bbox) <= MAX_FRAGMENT_GAP * it.bbox.h
    };
    let belongs = |it: &ExpectedRegion| lies_inside(bbox, it) || is_fragment(it);
    let candidates = near.iter().filter(|(_, it)| belongs(it));
    let nearer = |a: &ExpectedRegion, b: &ExpectedRegion| {
        let contained = |it: &ExpectedRegion| bbox.share_within(&it.bbox);
        contained(b).total_cmp(&contained(a)).then(gap(bbox, &a.bbox).total_cmp(&gap(bbox, &b.bbox)))
    };
    candidates.min_by(|a, b| nearer(a.1, b.1)).map(|(blob, _)| *blob)
}

/// Whether an unclaimed region lies inside the expected box.
fn lies_inside(bbox: &Rect, expected: &ExpectedRegion) -> bool {
    let (grow, least) = if expected.group { (0.1, 0.3) } else { (0.2, 0.5) };
    let it = expected.bbox;
    let around = Rect::around(it.centre(), it.w * (1.0 + grow), it.h * (1.0 + grow));
    bbox.share_within(&around) >= least
}

/// The sizes of the objects that a set of regions can show.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Width of the widest.
    pub(super) w: f32,
    /// Height of the tallest.
    pub(super) h: f32,
    /// Pixels of the smallest.
    pub(super) least_area: f32,
}

/// Joins regions that are fragments of one object: one above the other within an object's extent (cut by a pole, or a
/// belt of the background's colour), or too small to be an object. `inside` is the box of the only expected object,
/// where there is only one: all regions in it are its own. Two regions [`are_side_by_side`] are never joined, nor by
/// way of a third. Returns detections as lists of indices into `observed`, each by rising index, largest area first.
pub(super) fn join_fragments(
    observed: &[(Rect, f32)],
    extent: Extent,
    inside: Option<Rect>,
) -> Vec<Vec<usize>> {
    let mut joins: Vec<(f32, usize, usize)> = Vec::new();
    let mut sets = DisjointSets::new(observed.len());
    for (i, first) in observed.iter().enumerate() {
        for (j, second) in observed.iter().enumerate().skip(i + 1) {
            let ((a, a_area), (b, b_area)) = (first, second);
            let both = a.union(b);
            let stacked =
                a.shared_columns(b) >= 0.5 && both.h <= 1.25 * extent.h && both.w <= 1.25 * extent.w;
            let fits = both.w <= MAX_UNION_RATIO * extent.w
                && both.h <= MAX_UNION_RATIO * extent.h
                && gap(a, b) <= max_gap(*a_area, *b_area);
            let within = fits
                && inside.is_some_and(|it| {
                    let around = Rect::around(it.centre(), it.w * 1.2, it.h * 1.2);
                    let mine = |it: &(Rect, f32)| {
                        it.0.share_within(&around) >= 0.5
                            || it.1 <= MAX_SMALL_FRAGMENT_SHARE * extent.least_area
                    };
                    mine(first) && mine(second)
                });
            if are_side_by_side(first, second, extent) {
                sets.keep_apart(i, j);
            } else if stacked || within {
                joins.push((gap(a, b), i, j));
            }
        }
    }
    // The nearest first, so that a region between two people side by side goes to the nearer one.
    joins.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    for (_, i, j) in joins {
        sets.join(i, j);
    }
    let mut joined: Vec<Vec<usize>> =
        sets.into_clusters(0).into_iter().map(|cluster| cluster.observations).collect();
    let area = |piece: &[usize]| piece.iter().filter_map(|&at| observed.get(at)).map(|it| it.1).sum::<f32>();
    joined.sort_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
    if inside.is_none() {
        join_small_fragments(&mut joined, observed, 0.3 * extent.least_area);
    }
    joined
}

/// Largest gap in pixels between two fragments of one object: it is limited by their own sizes.
fn max_gap(a_area: f32, b_area: f32) -> f32 {
    let (smaller, larger) = (a_area.min(b_area).sqrt(), a_area.max(b_area).sqrt());
    smaller.max(0.5 * larger)
}

/// Whether two regions look like two objects side by side: each at least half as tall as the expected object, each
/// too wide for the half of a person that a pole leaves, in different columns.
pub(super) fn are_side_by_side((a, a_area): &(Rect, f32), (b, b_area): &(Rect, f32), extent: Extent) -> bool {
    let whole = |it: &Rect, area: f32| {
        it.h >= MIN_BESIDE_HEIGHT * extent.h
            && it.w >= MIN_BESIDE_WIDTH * it.h
            && area >= MIN_BESIDE_AREA * extent.least_area
    };
    whole(a, *a_area) && whole(b, *b_area) && a.shared_columns(b) <= MAX_SHARED_COLUMNS
}

/// Joins detections of fewer than `least` pixels to the nearest larger one.
fn join_small_fragments(joined: &mut Vec<Vec<usize>>, observed: &[(Rect, f32)], least: f32) {
    while let [_, .., fragment] = joined.as_slice() {
        if fragment.iter().filter_map(|&at| observed.get(at)).map(|it| it.1).sum::<f32>() >= least {
            break;
        }
        let fragment_box = bounding_box(fragment, observed);
        let distance = |piece: &Vec<usize>| gap(&bounding_box(piece, observed), &fragment_box);
        let fragment = joined.pop().unwrap_or_default();
        let nearest = joined.iter_mut().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(nearest) = nearest {
            nearest.extend(fragment);
            nearest.sort_unstable();
        }
    }
}

/// The box around several observations.
fn bounding_box(indices: &[usize], observed: &[(Rect, f32)]) -> Rect {
    indices
        .iter()
        .filter_map(|&at| observed.get(at))
        .map(|it| it.0)
        .reduce(|a, b| a.union(&b))
        .unwrap_or_default()
}

/// The free space between two boxes, 0 where they meet.
fn gap(a: &Rect, b: &Rect) -> f32 {
    let [across, down] = a.gap(b);
    across.hypot(down)
}

/// Disjoint sets, some of which must not become one. With that condition the order of the joins matters, so that the
/// sets are no connected components of a graph.
struct DisjointSets {
    /// For each member the first of its set.
    firsts: Vec<usize>,
    /// For each first of a set the firsts of the sets that it must not be joined with.
    apart: Vec<BTreeSet<usize>>,
}

impl DisjointSets {
    fn new(count: usize) -> Self {
        Self { firsts: (0..count).collect(), apart: vec![BTreeSet::new(); count] }
    }

    /// Joins the sets of two members, unless these must not become one.
    fn join(&mut self, a: usize, b: usize) {
        let (Some(&a), Some(&b)) = (self.firsts.get(a), self.firsts.get(b)) else { return };
        if a == b || self.apart.get(a).is_some_and(|apart| apart.contains(&b)) {
            return;
        }
        let (first, last) = (a.min(b), a.max(b));
        for at in self.firsts.iter_mut().filter(|at| **at == last) {
            *at = first;
        }
        let apart = self.apart.get_mut(last).map(std::mem::take).unwrap_or_default();
        for other in apart {
            if let Some(others) = self.apart.get_mut(other) {
                others.remove(&last);
            }
            self.keep_apart(first, other);
        }
    }

    /// Keeps the sets of two members from becoming one.
    fn keep_apart(&mut self, a: usize, b: usize) {
        let (Some(&a), Some(&b)) = (self.firsts.get(a), self.firsts.get(b)) else { return };
        for (one, other) in [(a, b), (b, a)] {
            if let Some(apart) = self.apart.get_mut(one) {
                apart.insert(other);
            }
        }
    }

    /// The sets in the order of their first members; the first `blobs` members are blobs.
    fn into_clusters(self, blobs: usize) -> Vec<Cluster> {
        let mut of_first = BTreeMap::<usize, Cluster>::new();
        for (at, first) in self.firsts.into_iter().enumerate() {
            let cluster = of_first.entry(first).or_default();
            match at.checked_sub(blobs) {
                None => cluster.blobs.push(at),
                Some(observation) => cluster.observations.push(observation),
            }
        }
        of_first.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use proptest::prelude::*;

    use super::*;

    fn person(x: f32, y: f32) -> Rect {
        Rect::new(x, y, 20.0, 60.0)
    }

    fn alone(bbox: Rect, matched: Option<usize>) -> ExpectedRegion {
        ExpectedRegion { bbox, area: 800.0, matched, group: false }
    }

    const PERSON: Extent = Extent { w: 20.0, h: 60.0, least_area: 800.0 };

    #[test]
    fn a_region_that_contains_two_lost_objects_joins_them() {
        let expected = [alone(person(100.0, 50.0), None), alone(person(118.0, 50.0), None)];
        let observed = [(Rect::new(100.0, 50.0, 38.0, 60.0), 1500.0)];
        assert_eq!(
            clusters(&expected, &observed, 0.2),
            [Cluster { blobs: vec![0, 1], observations: vec![0] }]
        );
    }

    #[test]
    fn growth_of_the_region_decides_where_the_overlap_does_not() {
        let expected = [alone(person(100.0, 50.0), Some(0)), alone(person(114.0, 50.0), None)];
        let not_grown = [(Rect::new(100.0, 50.0, 20.0, 60.0), 820.0)];
        let grown = [(Rect::new(100.0, 50.0, 20.0, 60.0), 1100.0)];
        assert_eq!(clusters(&expected, &not_grown, 0.2).len(), 2);
        assert_eq!(clusters(&expected, &grown, 0.2).len(), 1);
    }

    #[test]
    fn a_small_region_beside_an_object_is_its_fragment_and_a_large_one_is_not() {
        let expected = [alone(person(100.0, 50.0), Some(0)), alone(person(160.0, 50.0), Some(1))];
        let bodies = [(person(100.0, 50.0), 800.0), (person(160.0, 50.0), 800.0)];
        let with = |bbox: Rect, area: f32| clusters(&expected, &[bodies[0], bodies[1], (bbox, area)], 0.2);
        let foot = with(Rect::new(126.0, 95.0, 10.0, 14.0), 110.0);
        assert_eq!(foot[0], Cluster { blobs: vec![0], observations: vec![0, 2] });
        assert_eq!(with(Rect::new(126.0, 50.0, 18.0, 60.0), 700.0).len(), 3);
        assert_eq!(with(Rect::new(134.0, 95.0, 10.0, 14.0), 110.0).len(), 3, "too far from both");
    }

    #[test]
    fn two_objects_side_by_side_are_not_joined_and_the_halves_beside_a_pole_are() {
        let pair = Extent { w: 50.0, h: 62.0, least_area: 1600.0 };
        let (left, right) = ((person(100.0, 50.0), 800.0), (person(127.0, 51.0), 780.0));
        assert!(are_side_by_side(&left, &right, pair));
        assert_eq!(
            join_fragments(&[left, right], pair, Some(Rect::new(100.0, 50.0, 47.0, 62.0))),
            [[0], [1]]
        );
        let half = |x: f32| (Rect::new(x, 50.0, 9.0, 60.0), 400.0);
        assert!(!are_side_by_side(&half(100.0), &half(112.0), PERSON), "too narrow for two");
        let low = (Rect::new(127.0, 90.0, 20.0, 22.0), 420.0);
        assert!(!are_side_by_side(&left, &low, pair), "not as tall");
        let cars = Extent { w: 130.0, h: 42.0, least_area: 4000.0 };
        let car = |x: f32| (Rect::new(x, 50.0, 60.0, 40.0), 2000.0);
        assert!(are_side_by_side(&car(100.0), &car(168.0), cars), "wide things are two, too");
    }

    #[test]
    fn a_region_between_two_objects_side_by_side_does_not_join_them() {
        let pair = Extent { w: 50.0, h: 62.0, least_area: 1600.0 };
        let (left, right) = ((person(100.0, 50.0), 800.0), (person(127.0, 51.0), 780.0));
        let shadow = (Rect::new(124.0, 108.0, 30.0, 6.0), 120.0);
        let all = Some(Rect::new(100.0, 50.0, 47.0, 64.0));
        assert_eq!(join_fragments(&[left, right, shadow], pair, all), [vec![1, 2], vec![0]]);
    }

    #[test]
    fn an_unclaimed_region_far_from_an_object_is_a_cluster_of_its_own() {
        let expected = [alone(person(100.0, 50.0), Some(0))];
        let observed = [(person(100.0, 50.0), 800.0), (person(150.0, 50.0), 800.0)];
        assert_eq!(clusters(&expected, &observed, 0.2).len(), 2);
    }

    #[test]
    fn a_person_cut_by_a_pole_is_one_detection_and_two_side_by_side_are_two() {
        let cut = [(Rect::new(100.0, 50.0, 20.0, 25.0), 400.0), (Rect::new(101.0, 80.0, 18.0, 30.0), 350.0)];
        assert_eq!(join_fragments(&cut, PERSON, None), [[0, 1]]);
        let two = [(person(100.0, 50.0), 800.0), (person(125.0, 50.0), 790.0)];
        assert_eq!(join_fragments(&two, PERSON, None), [[0], [1]]);
        let split_lengthwise =
            [(Rect::new(100.0, 50.0, 8.0, 60.0), 400.0), (Rect::new(111.0, 50.0, 8.0, 60.0), 400.0)];
        assert_eq!(join_fragments(&split_lengthwise, PERSON, Some(person(100.0, 50.0))), [[0, 1]]);
    }

    #[test]
    fn very_small_regions_are_joined_to_the_nearest() {
        let observed = [
            (person(100.0, 50.0), 800.0),
            (person(150.0, 50.0), 790.0),
            (Rect::new(145.0, 100.0, 4.0, 4.0), 12.0),
        ];
        assert_eq!(join_fragments(&observed, PERSON, None), [vec![0], vec![1, 2]]);
    }

    fn cluster(blobs: &[usize], observations: &[usize]) -> Cluster {
        Cluster { blobs: blobs.to_vec(), observations: observations.to_vec() }
    }

    #[test]
    fn blobs_and_regions_are_clustered_by_match_and_by_place() {
        // The first two are matched; the third is lost in the middle of the second region, the fourth has no region.
        let expected = [
            alone(person(100.0, 50.0), Some(1)),
            alone(person(200.0, 50.0), Some(2)),
            alone(person(204.0, 50.0), None),
            alone(person(300.0, 50.0), None),
        ];
        let observed = [
            (Rect::new(104.0, 70.0, 8.0, 10.0), 60.0),
            (person(100.0, 50.0), 800.0),
            (Rect::new(200.0, 50.0, 24.0, 60.0), 900.0),
            (person(20.0, 50.0), 800.0),
        ];
        assert_eq!(
            clusters(&expected, &observed, 0.2),
            [cluster(&[0], &[0, 1]), cluster(&[1, 2], &[2]), cluster(&[3], &[]), cluster(&[], &[3])]
        );
        // A matched blob is not joined to another region that its box overlaps.
        let expected = [alone(person(100.0, 50.0), Some(0)), alone(person(112.0, 50.0), Some(1))];
        let observed = [(person(100.0, 50.0), 800.0), (person(108.0, 50.0), 2000.0)];
        assert_eq!(clusters(&expected, &observed, 0.2), [cluster(&[0], &[0]), cluster(&[1], &[1])]);
        // A region of its own beside an expected box, too large for a fragment.
        let beside = [(person(100.0, 50.0), 800.0), (Rect::new(110.0, 50.0, 40.0, 60.0), 1600.0)];
        assert_eq!(clusters(&expected[..1], &beside, 0.2), [cluster(&[0], &[0]), cluster(&[], &[1])]);
    }

    #[test]
    fn a_region_lies_inside_an_expected_box_with_half_of_it_or_a_third_of_a_group() {
        let inside = |group: bool, x: f32, y: f32| {
            let expected = ExpectedRegion { group, ..alone(person(100.0, 50.0), None) };
            lies_inside(&Rect::new(x, y, 10.0, 10.0), &expected)
        };
        // Grown by a fifth around its centre: columns 98 to 122 and rows 44 to 116.
        assert!(inside(false, 93.0, 60.0) && !inside(false, 92.0, 60.0));
        assert!(inside(false, 117.0, 60.0) && !inside(false, 118.0, 60.0));
        assert!(inside(false, 105.0, 39.0) && !inside(false, 105.0, 38.0));
        assert!(inside(false, 105.0, 111.0) && !inside(false, 105.0, 112.0));
        // By a tenth: columns 99 to 121 and rows 47 to 113.
        assert!(inside(true, 92.0, 60.0) && !inside(true, 91.0, 60.0));
        assert!(inside(true, 105.0, 110.0) && !inside(true, 105.0, 111.0));
    }

    #[test]
    fn fragments_are_joined_within_the_extent_of_an_object() {
        let joined = |a: Rect, b: Rect, inside: Option<Rect>| {
            let area = |it: Rect| 0.7 * it.area();
            join_fragments(&[(a, area(a)), (b, area(b))], PERSON, inside).len() == 1
        };
        // One above the other: together at most 1.25 of the height and width.
        let upper = Rect::new(100.0, 50.0, 20.0, 30.0);
        assert!(joined(upper, Rect::new(100.0, 95.0, 20.0, 30.0), None));
        assert!(!joined(upper, Rect::new(100.0, 96.0, 20.0, 30.0), None));
        assert!(joined(upper, Rect::new(105.0, 84.0, 20.0, 30.0), None));
        assert!(!joined(upper, Rect::new(106.0, 84.0, 20.0, 30.0), None));
        // Within the only expected box, in any direction: at most 1.6 of both, with a gap of at most their size.
        let low = Rect::new(100.0, 60.0, 12.0, 16.0);
        let around = |w: f32, h: f32| Some(Rect::new(90.0, 40.0, w, h));
        assert!(joined(low, Rect::new(122.0, 60.0, 10.0, 16.0), around(60.0, 60.0)));
        assert!(!joined(low, Rect::new(123.0, 60.0, 10.0, 16.0), around(60.0, 60.0)), "33 columns");
        assert!(joined(low, Rect::new(114.0, 87.0, 12.0, 16.0), around(60.0, 120.0)));
        assert!(!joined(low, Rect::new(114.0, 88.0, 12.0, 16.0), around(60.0, 120.0)), "a gap of 12 pixels");
        let tall = |x: f32, y: f32, h: f32| Rect::new(x, y, 11.0, h);
        assert!(joined(tall(100.0, 40.0, 44.0), tall(113.0, 92.0, 44.0), around(60.0, 120.0)));
        assert!(!joined(tall(100.0, 40.0, 44.0), tall(113.0, 92.0, 45.0), around(60.0, 120.0)), "97 rows");
        // Half of each is inside the box grown by a fifth, unless it is a small part.
        let (left, right) = (Rect::new(99.0, 60.0, 16.0, 50.0), Rect::new(113.0, 60.0, 18.0, 28.0));
        let inside = |x: f32, y: f32| Some(Rect::new(x, y, 20.0, 60.0));
        assert!(joined(left, right, inside(100.0, 55.0)));
        assert!(!joined(left, right, inside(99.0, 55.0)), "8 of 18 columns of the right one");
        assert!(joined(left, right, inside(109.0, 55.0)));
        assert!(!joined(left, right, inside(110.0, 55.0)), "7 of 16 columns of the left one");
        let small = Rect::new(114.0, 60.0, 14.0, 29.0);
        assert!(joined(left, small, inside(101.0, 91.0)));
        assert!(!joined(left, small, inside(101.0, 92.0)), "24 of 50 rows");
    }

    #[test]
    fn the_gap_between_fragments_is_limited_by_their_sizes() {
        assert_eq!(max_gap(100.0, 900.0), 15.0);
        assert_eq!(max_gap(900.0, 400.0), 20.0);
    }

    #[test]
    fn each_of_two_side_by_side_has_a_quarter_of_the_pixels() {
        let pair =
            |area: f32| are_side_by_side(&(person(100.0, 50.0), area), &(person(130.0, 50.0), 800.0), PERSON);
        assert!(pair(200.0) && !pair(199.0));
    }

    proptest! {
        #[test]
        fn what_can_belong_to_an_expected_region_meets_its_surroundings(
            first in prop::array::uniform4(1.0_f32..60.0),
            second in prop::array::uniform4(1.0_f32..60.0),
            area in 1.0_f32..4000.0,
            group: bool,
        ) {
            let [bbox, seen] = [first, second].map(|[x, y, w, h]| Rect::new(x, y, w, h));
            let expected = ExpectedRegion { bbox, area, matched: None, group };
            let meets = surroundings(&expected).gap(&seen) == [0.0; 2];
            let belongs = owner_of_unclaimed(&seen, seen.area(), &[(0, &expected)]).is_some();
            let contains = bbox.share_within(&seen) >= 0.2;
            prop_assert!(meets || !(belongs || contains));
        }
    }
}
