//! Assignment of group members to the regions after a demerge (Algorithms 1 and 3).

use crate::regions::{Histogram, Rect};
use crate::settings::Settings;

use super::object::Object;

/// Weight of full colour similarity against predicted motion, in nats. Large, as Algorithm 3 compares colours first;
/// where they are similar to all alike, motion decides.
const MAX_COLOUR_NATS: f32 = 20.0;
/// Lower limit of the motion term, in nats.
const MIN_MOTION_NATS: f32 = -10.0;
/// With more combinations than this, each object takes its best region.
const MAX_COMBINATIONS: usize = 20_000;

/// A region of a group after a demerge.
#[derive(Clone, Debug)]
pub struct SplitRegion {
    /// Its box.
    pub bbox: Rect,
    /// Its pixels.
    pub area: f32,
    /// Its colours.
    pub histogram: Histogram,
}

/// The score of one object for one region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AssociationScore {
    /// Colour similarity, 0..=1.2.
    pub colour: f32,
    /// Least ΔE between two dominant colours.
    pub delta_e: f32,
    /// Distance in pixels by which the object's predicted box lies outside the region.
    pub distance: f32,
    /// Log-likelihood of that distance in nats, at most 0.
    pub motion: f32,
}

/// The score of an object for a region. `position_sigma` is the standard deviation of its predicted place, in pixels.
pub fn association_score(
    object: &Object,
    position_sigma: f32,
    region: &SplitRegion,
    settings: &Settings,
) -> AssociationScore {
    let (colour, delta_e) = object.colour_similarity(&region.histogram, settings);
    let distance = distance_outside(&object.predicted_box(), &region.bbox);
    let motion = (-0.5 * (distance / position_sigma).powi(2)).max(MIN_MOTION_NATS);
    AssociationScore { colour, delta_e, distance, motion }
}

/// The score of each object (row) for each region (column). `position_sigma` is for each object the standard
/// deviation of its predicted place, in pixels.
pub fn association_scores(
    objects: &[&Object],
    position_sigma: &[f32],
    regions: &[SplitRegion],
    settings: &Settings,
) -> Vec<Vec<AssociationScore>> {
    let row = |(object, &sigma): (&&Object, &f32)| {
        regions.iter().map(|region| association_score(object, sigma, region, settings)).collect()
    };
    objects.iter().zip(position_sigma).map(row).collect()
}

/// The distance that one box would have to move to lie inside the other (or to contain it, where it is larger).
pub fn distance_outside(a: &Rect, b: &Rect) -> f32 {
    let axis = |low: f32, high: f32, other_low: f32, other_high: f32| {
        let (below, above) = (other_low - low, high - other_high);
        if high - low <= other_high - other_low {
            below.max(above).max(0.0)
        } else {
            (-below).max(-above).max(0.0)
        }
    };
    axis(a.x, a.right(), b.x, b.right()).hypot(axis(a.y, a.bottom(), b.y, b.bottom()))
}

/// For each object the index of its region, with the best total score. With at most as many regions as objects no
/// region stays empty. `by_colour` says for each object whether its colours are compared: not for one that was alone
/// until now, whose place is known.
pub fn assign_to_regions(
    association_scores: &[Vec<AssociationScore>],
    objects: &[&Object],
    regions: &[SplitRegion],
    by_colour: &[bool],
) -> Vec<usize> {
    let value = |fit: &AssociationScore, by_colour: bool| {
        fit.motion + if by_colour { MAX_COLOUR_NATS * fit.colour } else { 0.0 }
    };
    let rows = association_scores.iter().zip(by_colour);
    let values: Vec<Vec<f32>> =
        rows.map(|(row, &by_colour)| row.iter().map(|fit| value(fit, by_colour)).collect()).collect();
    let sizes = |assigned: &[usize]| -> f32 {
        let misfit = regions.iter().enumerate().map(|(region, it)| {
            let due: f32 =
                assigned.iter().zip(objects).filter(|(at, _)| **at == region).map(|(_, it)| it.area()).sum();
            if due > 0.0 { -0.5 * ((it.area / due).ln() / 0.6).powi(2) } else { 0.0 }
        });
        misfit.sum()
    };
    let total =
        |assigned: &[usize]| -> f32 { assigned_entries(&values, assigned).sum::<f32>() + sizes(assigned) };
    let own_detection = |values: &Vec<f32>| {
        let best_combination =
            values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
        best_combination.map_or(0, |(region, _)| region)
    };
    best_combination(objects.len(), regions.len(), total)
        .unwrap_or_else(|| values.iter().map(own_detection).collect())
}

/// For each object (row) the entry of the region (column) that it is assigned to.
fn assigned_entries<'a, T: Copy>(rows: &'a [Vec<T>], assigned: &'a [usize]) -> impl Iterator<Item = T> + 'a {
    rows.iter().zip(assigned).filter_map(|(row, &region)| row.get(region).copied())
}

/// Colour and motion terms together, in nats.
pub fn total_nats(fit: AssociationScore) -> f32 {
    MAX_COLOUR_NATS * fit.colour + fit.motion
}

/// The best assignment with as many objects in each region as `present` has: it changes which objects, not how many.
/// Only colours and the motion at the demerge count.
pub fn reassign_to_regions(
    association_scores: &[Vec<AssociationScore>],
    present: &[usize],
    regions: usize,
) -> Vec<usize> {
    let count = |assigned: &[usize], region| assigned.iter().filter(|&&at| at == region).count();
    let total = |assigned: &[usize]| {
        if (0..regions).any(|region| count(assigned, region) != count(present, region)) {
            return f32::NEG_INFINITY;
        }
        assigned_entries(association_scores, assigned).map(total_nats).sum()
    };
    best_combination(present.len(), regions, total).unwrap_or_else(|| present.to_vec())
}

/// The assignment of `objects` to `regions` with the greatest total, the first on a tie; `None` when there are too
/// many combinations.
fn best_combination(objects: usize, regions: usize, total: impl Fn(&[usize]) -> f32) -> Option<Vec<usize>> {
    let combinations = regions.checked_pow(objects as u32).filter(|&count| count <= MAX_COMBINATIONS)?;
    let mut best_combination: Option<(f32, Vec<usize>)> = None;
    for number in 0..combinations {
        let mut rest = number;
        let assigned: Vec<usize> = (0..objects)
            .map(|_| {
                let region = rest % regions;
                rest /= regions;
                region
            })
            .collect();
        let empty = (0..regions).filter(|region| !assigned.contains(region)).count();
        if empty > regions.saturating_sub(objects) {
            continue;
        }
        let total = total(&assigned);
        if best_combination.as_ref().is_none_or(|(most, _)| total > *most) {
            best_combination = Some((total, assigned));
        }
    }
    best_combination.map(|(_, assigned)| assigned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_inside_another_is_at_no_distance() {
        let large = Rect::new(0.0, 0.0, 50.0, 60.0);
        assert_eq!(distance_outside(&Rect::new(10.0, 0.0, 20.0, 60.0), &large), 0.0);
        assert_eq!(distance_outside(&Rect::new(33.0, 0.0, 20.0, 60.0), &large), 3.0);
        assert_eq!(distance_outside(&large, &Rect::new(-4.0, 3.0, 20.0, 20.0)), 4.0);
    }

    fn fit(colour: f32, motion: f32) -> AssociationScore {
        AssociationScore { colour, motion, ..AssociationScore::default() }
    }

    #[test]
    fn colours_overrule_motion_and_motion_decides_where_they_cannot() {
        let crossed = [vec![fit(0.2, 0.0), fit(0.8, -4.0)], vec![fit(0.8, -4.0), fit(0.2, 0.0)]];
        assert_eq!(reassign_to_regions(&crossed, &[0, 1], 2), [1, 0]);
        let alike = [vec![fit(0.7, 0.0), fit(0.7, -4.0)], vec![fit(0.7, -4.0), fit(0.7, 0.0)]];
        assert_eq!(reassign_to_regions(&alike, &[1, 0], 2), [0, 1]);
    }
}
