//! Assignment of group members to the regions after a demerge (Algorithms 1 and 3).

use crate::occlusion::state::comparable_colours::ComparableColours;
use crate::occlusion::state::object::Object;
use crate::occlusion::state::split_region::{AssociationScore, SplitRegion};
use crate::regions::Rect;
use crate::settings::Settings;

/// Weight of full colour similarity against predicted motion, in nats. Large, as Algorithm 3 compares colours first;
/// where they are similar to all alike, motion decides.
const MAX_COLOUR_NATS: f32 = 20.0;
/// Lower limit of the motion term, in nats.
const MIN_MOTION_NATS: f32 = -10.0;
/// Standard deviation of ln(area of a region / area of its objects).
const LOG_AREA_SIGMA: f32 = 0.6;

/// The score of an object for a region with this box. `position_sigma` is the standard deviation of the object's predicted
/// place, in pixels; the similarity of colours and their ΔE are those of [`ComparableColours::similarity`].
pub(crate) fn association_score(
    object: &Object,
    position_sigma: f32,
    bbox: &Rect,
    (colour, delta_e): (f32, f32),
) -> AssociationScore {
    let distance = object.predicted_box().distance_outside(bbox);
    let motion = (-0.5 * (distance / position_sigma).powi(2)).max(MIN_MOTION_NATS);
    AssociationScore { colour, delta_e, distance, motion }
}

/// The score of each object (row) for each region (column). `position_sigma` is for each object the standard
/// deviation of its predicted place, in pixels.
pub(crate) fn association_scores(
    objects: &[&Object],
    position_sigma: &[f32],
    regions: &[SplitRegion],
    settings: &Settings,
) -> Vec<Vec<AssociationScore>> {
    let seen: Vec<ComparableColours> =
        regions.iter().map(|region| ComparableColours::new(&region.histogram, settings)).collect();
    let row = |(object, &sigma): (&&Object, &f32)| {
        let colours = object.comparable_colours(settings);
        let score = |(region, seen): (&SplitRegion, &ComparableColours)| {
            association_score(object, sigma, &region.bbox, colours.similarity(seen, settings))
        };
        regions.iter().zip(&seen).map(score).collect()
    };
    objects.iter().zip(position_sigma).map(row).collect()
}

/// For each object the index of its region, with the best total score: of colours, motion and the regions' areas. With
/// at most as many regions as objects no region stays empty; otherwise no two objects have the same region. `by_colour`
/// says for each object whether its colours are compared: not for one that was alone until now, whose place is known.
/// Where the search takes too long, each object has its own best region.
pub(crate) fn assign_to_regions(
    association_scores: &[Vec<AssociationScore>],
    objects: &[&Object],
    regions: &[SplitRegion],
    by_colour: &[bool],
) -> Vec<usize> {
    let value = |score: &AssociationScore, by_colour: bool| {
        score.motion + if by_colour { MAX_COLOUR_NATS * score.colour } else { 0.0 }
    };
    let rows = association_scores.iter().zip(by_colour);
    let values: Vec<Vec<f32>> =
        rows.map(|(row, &by_colour)| row.iter().map(|score| value(score, by_colour)).collect()).collect();
    let areas: Vec<f32> = objects.iter().map(|object| object.area()).collect();
    let areas = RegionAreas { objects: &areas, regions: regions.iter().map(|region| region.area).collect() };
    let total = |assigned: &[usize]| -> f32 {
        assigned_entries(&values, assigned).sum::<f32>() + areas.nats(assigned)
    };
    let bound = |last: &[usize]| {
        let open = objects.len() - last.len();
        let empty = (0..regions.len()).filter(|region| !last.contains(region)).count();
        let feasible = empty.saturating_sub(open) <= regions.len().saturating_sub(objects.len());
        feasible.then(|| areas.most_nats(last))
    };
    let best_region = |values: &Vec<f32>| {
        let best = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
        best.map_or(0, |(region, _)| region)
    };
    best_assignment(&values, regions.len(), bound, total)
        .unwrap_or_else(|| values.iter().map(best_region).collect())
}

/// The areas of objects and regions in pixels, which should agree.
struct RegionAreas<'a> {
    objects: &'a [f32],
    regions: Vec<f32>,
}

impl RegionAreas<'_> {
    /// Log-likelihood of the regions' areas under an assignment of all objects, in nats, at most 0.
    fn nats(&self, assigned: &[usize]) -> f32 {
        let of_region = |(region, area): (usize, &f32)| {
            let due: f32 =
                assigned.iter().zip(self.objects).filter(|(at, _)| **at == region).map(|it| it.1).sum();
            if due > 0.0 { -0.5 * ((area / due).ln() / LOG_AREA_SIGMA).powi(2) } else { 0.0 }
        };
        self.regions.iter().enumerate().map(of_region).sum()
    }

    /// The most that this can be once only the last objects are assigned: more objects make a region that is too
    /// small for its objects fit worse.
    fn most_nats(&self, last: &[usize]) -> f32 {
        let first = self.objects.len().saturating_sub(last.len());
        let objects = self.objects.get(first..).unwrap_or_default();
        let of_region = |(region, area): (usize, &f32)| {
            let due: f32 = last.iter().zip(objects).filter(|(at, _)| **at == region).map(|it| it.1).sum();
            if due > *area { -0.5 * ((area / due).ln() / LOG_AREA_SIGMA).powi(2) } else { 0.0 }
        };
        self.regions.iter().enumerate().map(of_region).sum()
    }
}

/// For each object (row) the entry of the region (column) that it is assigned to.
fn assigned_entries<'a, T: Copy>(rows: &'a [Vec<T>], assigned: &'a [usize]) -> impl Iterator<Item = T> + 'a {
    rows.iter().zip(assigned).filter_map(|(row, &region)| row.get(region).copied())
}

/// Colour and motion terms together, in nats.
pub(crate) fn total_nats(score: AssociationScore) -> f32 {
    MAX_COLOUR_NATS * score.colour + score.motion
}

/// The best assignment with as many objects in each region as `present` has: it changes which objects, not how many.
/// Only colours and the motion at the demerge count. Where the search takes too long, it is `present`.
pub(super) fn reassign_to_regions(
    association_scores: &[Vec<AssociationScore>],
    present: &[usize],
    regions: usize,
) -> Vec<usize> {
    let count = |assigned: &[usize], region| assigned.iter().filter(|&&at| at == region).count();
    let total =
        |assigned: &[usize]| -> f32 { assigned_entries(association_scores, assigned).map(total_nats).sum() };
    let bound = |last: &[usize]| {
        let feasible = last.iter().all(|&region| count(last, region) <= count(present, region));
        feasible.then_some(0.0)
    };
    let values: Vec<Vec<f32>> =
        association_scores.iter().map(|row| row.iter().copied().map(total_nats).collect()).collect();
    best_assignment(&values, regions, bound, total).unwrap_or_else(|| present.to_vec())
}

/// The assignment of objects (rows of `values`) to `regions` with the greatest total, the first on a tie in the order
/// in which the first object's region changes fastest; `None` where none is allowed or the search takes too long.
///
/// `total` is the sum of the assigned values and a term of the whole assignment. For that term, `bound` gives an upper
/// bound from the regions of the last objects alone, `None` where no assignment with these is allowed.
///
/// It is a branch-and-bound search from the last object to the first. The Hungarian algorithm has no place for the term
/// of the regions' areas, and takes integer weights: rounded, another of nearly equal assignments could be the best.
fn best_assignment(
    values: &[Vec<f32>],
    regions: usize,
    bound: impl Fn(&[usize]) -> Option<f32>,
    total: impl Fn(&[usize]) -> f32,
) -> Option<Vec<usize>> {
    let best_value = |row: &Vec<f32>| row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    // For each number of objects the sum of the best values of so many first ones.
    let best_of_first: Vec<f32> = std::iter::once(0.0)
        .chain(values.iter().map(best_value).scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        }))
        .collect();
    let mut search = Search {
        values,
        regions,
        bound,
        total,
        best_of_first,
        assigned: vec![0; values.len()],
        best: None,
        least: f32::NEG_INFINITY,
        steps: 0,
        max_steps: MAX_SEARCH_STEPS.min(MAX_SEARCH_WORK / (values.len() * regions).max(1)),
    };
    search.least = search.dive()?;
    search.steps = 0;
    let complete = search.extend(values.len(), 0.0);
    search.best.filter(|_| complete).map(|(_, assigned)| assigned)
}

/// A search takes at most so many partial assignments: an exhaustive one over 50 000 assignments takes no more than
/// these, which is some milliseconds.
const MAX_SEARCH_STEPS: usize = 100_000;
/// The time of a step grows with the objects times the regions; the product of this with the steps is at most so much, also
/// some milliseconds. Up to 100 objects times regions it limits nothing.
const MAX_SEARCH_WORK: usize = 100 * MAX_SEARCH_STEPS;
/// A partial assignment is left when its bound is below a total that is reached, by this share of both: more than sums
/// of 32-bit numbers differ in another order.
const BOUND_MARGIN_SHARE: f32 = 1e-3;

/// The state of [`best_assignment`].
struct Search<'a, B, T> {
    values: &'a [Vec<f32>],
    regions: usize,
    bound: B,
    total: T,
    best_of_first: Vec<f32>,
    /// The regions of the objects; those of the first, open ones have no meaning yet.
    assigned: Vec<usize>,
    /// The best total so far and its assignment.
    best: Option<(f32, Vec<usize>)>,
    /// A total that some assignment reaches.
    least: f32,
    steps: usize,
    max_steps: usize,
}

impl<B: Fn(&[usize]) -> Option<f32>, T: Fn(&[usize]) -> f32> Search<'_, B, T> {
    /// The total where each object, the last first, has the best allowed region; −∞ where none is allowed. `None` where
    /// this takes too long.
    fn dive(&mut self) -> Option<f32> {
        for object in (0..self.values.len()).rev() {
            let row = self.values.get(object).map(Vec::as_slice).unwrap_or_default();
            let mut regions: Vec<(usize, f32)> = row.iter().copied().enumerate().collect();
            regions.sort_by(|a, b| b.1.total_cmp(&a.1));
            let mut allowed = false;
            for (region, _) in regions {
                self.steps += 1;
                if self.steps > self.max_steps {
                    return None;
                }
                allowed = self.set(object, region).is_some();
                if allowed {
                    break;
                }
            }
            if !allowed {
                return Some(f32::NEG_INFINITY);
            }
        }
        Some((self.total)(&self.assigned))
    }

    /// Assigns a region to an object, those after it being assigned; gives the bound.
    fn set(&mut self, object: usize, region: usize) -> Option<f32> {
        *self.assigned.get_mut(object)? = region;
        (self.bound)(self.assigned.get(object..)?)
    }

    /// Tries all regions for the `open` first objects, the last of them first; `sum` is the sum of the other objects'
    /// values. Whether the search was completed.
    fn extend(&mut self, open: usize, sum: f32) -> bool {
        let Some(object) = open.checked_sub(1) else {
            let total = (self.total)(&self.assigned);
            if self.best.as_ref().is_none_or(|(most, _)| total > *most) {
                self.best = Some((total, self.assigned.clone()));
                self.least = self.least.max(total);
            }
            return true;
        };
        for region in 0..self.regions {
            self.steps += 1;
            if self.steps > self.max_steps {
                return false;
            }
            let Some(term) = self.set(object, region) else { continue };
            let value = self.values.get(object).and_then(|row| row.get(region)).copied().unwrap_or_default();
            let sum = sum + value;
            let most = sum + term + self.best_of_first.get(object).copied().unwrap_or_default();
            let is_beaten = most + BOUND_MARGIN_SHARE * (1.0 + most.abs() + self.least.abs()) < self.least;
            if !is_beaten && !self.extend(object, sum) {
                return false;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use proptest::prelude::*;

    use super::*;
    use crate::occlusion::fixtures::{RED, context, detection, object, person};
    use crate::regions::{Histogram, Rect};

    fn score(colour: f32, motion: f32) -> AssociationScore {
        AssociationScore { colour, motion, ..AssociationScore::default() }
    }

    #[test]
    fn colours_overrule_motion_and_motion_decides_where_they_cannot() {
        let crossed = [vec![score(0.2, 0.0), score(0.8, -4.0)], vec![score(0.8, -4.0), score(0.2, 0.0)]];
        assert_eq!(reassign_to_regions(&crossed, &[0, 1], 2), [1, 0]);
        let alike = [vec![score(0.7, 0.0), score(0.7, -4.0)], vec![score(0.7, -4.0), score(0.7, 0.0)]];
        assert_eq!(reassign_to_regions(&alike, &[1, 0], 2), [0, 1]);
    }

    #[test]
    fn two_objects_share_the_region_that_is_large_enough_for_both() {
        let context = context(1);
        let three = [1, 2, 3].map(|id| object(&context, id, &detection(person(100.0, 80.0), RED), [0.0; 2]));
        let region =
            |area: f32| SplitRegion { bbox: person(100.0, 80.0), area, histogram: Histogram::default() };
        let alike = vec![vec![AssociationScore::default(); 2]; 3];
        let assign = |regions: [SplitRegion; 2]| {
            assign_to_regions(&alike, &three.iter().collect::<Vec<_>>(), &regions, &[true; 3])
        };
        assert_eq!(assign([region(2400.0), region(1200.0)]), [1, 0, 0]);
        assert_eq!(assign([region(1200.0), region(2400.0)]), [1, 1, 0]);
    }

    #[test]
    fn no_region_stays_empty_even_where_it_fits_none() {
        let context = context(1);
        let two = [1, 2].map(|id| object(&context, id, &detection(person(100.0, 80.0), RED), [0.0; 2]));
        let regions = [2400.0, 20.0].map(|area| SplitRegion {
            bbox: person(100.0, 80.0),
            area,
            histogram: Histogram::default(),
        });
        let alike = vec![vec![AssociationScore::default(); 2]; 2];
        let assigned = assign_to_regions(&alike, &two.iter().collect::<Vec<_>>(), &regions, &[true; 2]);
        assert_eq!(assigned, [1, 0]);
    }

    #[test]
    fn a_large_group_is_assigned_exactly_too() {
        // 6¹² assignments: one after the other is too many.
        let own = |object: usize| {
            (0..6).map(move |region| score(0.0, if region == object / 2 { 0.0 } else { -3.0 }))
        };
        let scores: Vec<Vec<AssociationScore>> = (0..12).map(|object| own(object).collect()).collect();
        let present: Vec<usize> = (0..12).map(|object| object % 6).collect();
        let best: Vec<usize> = (0..12).map(|object| object / 2).collect();
        assert_eq!(reassign_to_regions(&scores, &present, 6), best);
    }

    #[test]
    fn a_search_that_takes_too_long_leaves_the_assignment() {
        let scores = vec![vec![AssociationScore::default(); 6]; 18];
        let present: Vec<usize> = (0..18).map(|object| object % 6).collect();
        assert_eq!(reassign_to_regions(&scores, &present, 6), present);
    }

    #[test]
    fn the_search_of_a_huge_group_is_short() {
        let (objects, regions) = (300, 60);
        let calls = std::cell::Cell::new(0);
        let bound = |_: &[usize]| {
            calls.set(calls.get() + 1);
            Some(0.0)
        };
        assert_eq!(best_assignment(&vec![vec![0.0; regions]; objects], regions, bound, |_| 0.0), None);
        assert!(calls.get() * objects * regions <= 2 * MAX_SEARCH_WORK, "{}", calls.get());
        // Where no assignment is allowed at all, already the first one is given up.
        let refuse = |_: &[usize]| {
            calls.set(calls.get() + 1);
            None
        };
        calls.set(0);
        assert_eq!(best_assignment(&vec![vec![0.0; 2000]; 4000], 2000, refuse, |_| 0.0), None);
        assert!(calls.get() <= 2, "{}", calls.get());
    }

    /// All assignments one after the other: the definition of [`best_assignment`].
    fn best_of_all(
        objects: usize,
        regions: usize,
        total: impl Fn(&[usize]) -> Option<f32>,
    ) -> Option<Vec<usize>> {
        let mut best: Option<(f32, Vec<usize>)> = None;
        for number in 0..regions.pow(objects as u32) {
            let digit = |object: usize| number / regions.pow(object as u32) % regions;
            let assigned: Vec<usize> = (0..objects).map(digit).collect();
            let Some(total) = total(&assigned) else { continue };
            if best.as_ref().is_none_or(|(most, _)| total > *most) {
                best = Some((total, assigned));
            }
        }
        best.map(|(_, assigned)| assigned)
    }

    proptest! {
        #[test]
        fn the_search_finds_the_first_best_of_all_assignments(
            regions in 1_usize..5,
            // In steps, so that there are ties.
            rows in prop::collection::vec((prop::array::uniform4((0_u8..5, 0_u8..5)), 1_u8..6), 1..6),
            region_areas in prop::array::uniform4(1_u8..12),
            present in prop::collection::vec(0_usize..4, 6),
        ) {
            let scores: Vec<Vec<AssociationScore>> = rows
                .iter()
                .map(|(row, _)| row[..regions].iter().map(|&(colour, motion)| {
                    score(f32::from(colour) / 4.0, -f32::from(motion))
                }).collect())
                .collect();
            let context = context(1);
            let objects: Vec<Object> = rows
                .iter()
                .map(|&(_, columns)| {
                    let bbox = Rect::new(100.0, 80.0, 4.0 * f32::from(columns), 60.0);
                    object(&context, 1, &detection(bbox, RED), [0.0; 2])
                })
                .collect();
            let objects: Vec<&Object> = objects.iter().collect();
            let parts: Vec<SplitRegion> = region_areas[..regions]
                .iter()
                .map(|&area| SplitRegion {
                    bbox: person(100.0, 80.0),
                    area: 240.0 * f32::from(area),
                    histogram: Histogram::default(),
                })
                .collect();
            let areas: Vec<f32> = objects.iter().map(|object| object.area()).collect();
            let areas =
                RegionAreas { objects: &areas, regions: parts.iter().map(|part| part.area).collect() };
            let values: Vec<Vec<f32>> = scores
                .iter()
                .map(|row| row.iter().map(|score| score.motion + MAX_COLOUR_NATS * score.colour).collect())
                .collect();
            let expected = best_of_all(objects.len(), regions, |assigned| {
                let empty = (0..regions).filter(|region| !assigned.contains(region)).count();
                let allowed = empty <= regions.saturating_sub(objects.len());
                allowed.then(|| assigned_entries(&values, assigned).sum::<f32>() + areas.nats(assigned))
            });
            let by_colour = vec![true; objects.len()];
            prop_assert_eq!(Some(assign_to_regions(&scores, &objects, &parts, &by_colour)), expected);

            let present: Vec<usize> = present[..objects.len()].iter().map(|at| at % regions).collect();
            let count = |assigned: &[usize], region| assigned.iter().filter(|&&at| at == region).count();
            let expected = best_of_all(objects.len(), regions, |assigned| {
                let same = (0..regions).all(|region| count(assigned, region) == count(&present, region));
                same.then(|| assigned_entries(&scores, assigned).map(total_nats).sum())
            });
            prop_assert_eq!(Some(reassign_to_regions(&scores, &present, regions)), expected);
        }
    }
}
