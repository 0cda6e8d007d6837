//! Who is who: members of a group to the pieces that it fell into (Algorithms 1 and 3).

use crate::regions::{Histogram, Rect};
use crate::settings::Settings;

use super::object::Object;

/// What full agreement of colours is worth against predicted motion, in nats. Large, as Algorithm
/// 3 asks the colours first; where they agree with everybody alike, the motion decides.
const COLOUR_NATS: f32 = 20.0;
/// No distance speaks against an assignment by more than this, in nats.
const WORST_MOTION: f32 = -10.0;
/// More combinations than this are not tried; each object then takes its best piece.
const MOST_COMBINATIONS: usize = 20_000;

/// A part of a group after it split.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Its box.
    pub bbox: Rect,
    /// Its pixels.
    pub area: f32,
    /// Its colours.
    pub histogram: Histogram,
}

/// How well one object fits one piece.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fit {
    /// Agreement of colours, 0..=1.2.
    pub colour: f32,
    /// Least ΔE between two dominant colours.
    pub delta_e: f32,
    /// How far the object's predicted box lies outside the piece, in pixels.
    pub distance: f32,
    /// What that distance says, in nats, 0 or less.
    pub motion: f32,
}

/// How well each object (row) fits each piece (column). `unsure` is for each object how far, in
/// pixels, its prediction may be off.
pub fn fits(objects: &[&Object], unsure: &[f32], pieces: &[Piece], settings: &Settings) -> Vec<Vec<Fit>> {
    let fit = |object: &Object, unsure: f32, piece: &Piece| {
        let (colour, delta_e) = object.agreement(&piece.histogram, settings);
        let distance = outside(&object.predicted_box(), &piece.bbox);
        let motion = (-0.5 * (distance / unsure).powi(2)).max(WORST_MOTION);
        Fit { colour, delta_e, distance, motion }
    };
    let rows = objects.iter().zip(unsure);
    rows.map(|(object, &unsure)| pieces.iter().map(|piece| fit(object, unsure, piece)).collect()).collect()
}

/// How far one box would have to move to lie inside the other (or to hold it, where it is larger).
pub fn outside(a: &Rect, b: &Rect) -> f32 {
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

/// For each object the piece that it is in, such that the total is best. With at most as many
/// pieces as objects no piece stays empty. `by_colour` says for each object whether its colours
/// are asked: not for one that was alone until now, whose place is known.
pub fn assign(fits: &[Vec<Fit>], objects: &[&Object], pieces: &[Piece], by_colour: &[bool]) -> Vec<usize> {
    let value =
        |fit: &Fit, by_colour: bool| fit.motion + if by_colour { COLOUR_NATS * fit.colour } else { 0.0 };
    let rows = fits.iter().zip(by_colour);
    let values: Vec<Vec<f32>> =
        rows.map(|(row, &by_colour)| row.iter().map(|fit| value(fit, by_colour)).collect()).collect();
    let sizes = |assigned: &[usize]| -> f32 {
        let misfit = pieces.iter().enumerate().map(|(piece, it)| {
            let due: f32 =
                assigned.iter().zip(objects).filter(|(at, _)| **at == piece).map(|(_, it)| it.area()).sum();
            if due > 0.0 { -0.5 * ((it.area / due).ln() / 0.6).powi(2) } else { 0.0 }
        });
        misfit.sum()
    };
    let total = |assigned: &[usize]| -> f32 { of(&values, assigned).sum::<f32>() + sizes(assigned) };
    let best_piece = |values: &Vec<f32>| {
        let best = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
        best.map_or(0, |(piece, _)| piece)
    };
    best(objects.len(), pieces.len(), total).unwrap_or_else(|| values.iter().map(best_piece).collect())
}

/// For each object (row) what it has for the piece (column) that it is assigned to.
fn of<'a, T: Copy>(rows: &'a [Vec<T>], assigned: &'a [usize]) -> impl Iterator<Item = T> + 'a {
    rows.iter().zip(assigned).filter_map(|(row, &piece)| row.get(piece).copied())
}

/// What colours and motion say together, in nats.
pub fn nats(fit: Fit) -> f32 {
    COLOUR_NATS * fit.colour + fit.motion
}

/// The best of the assignments that put as many objects into each piece as `present` does: who
/// goes where is asked again, not how many. Only colours and the motion at the split count.
pub fn reassign(fits: &[Vec<Fit>], present: &[usize], pieces: usize) -> Vec<usize> {
    let count = |assigned: &[usize], piece| assigned.iter().filter(|&&at| at == piece).count();
    let total = |assigned: &[usize]| {
        if (0..pieces).any(|piece| count(assigned, piece) != count(present, piece)) {
            return f32::NEG_INFINITY;
        }
        of(fits, assigned).map(nats).sum()
    };
    best(present.len(), pieces, total).unwrap_or_else(|| present.to_vec())
}

/// The assignment of `objects` to `pieces` with the greatest total, the first on a tie; `None`
/// when there are too many to try.
fn best(objects: usize, pieces: usize, total: impl Fn(&[usize]) -> f32) -> Option<Vec<usize>> {
    let combinations = pieces.checked_pow(objects as u32).filter(|&count| count <= MOST_COMBINATIONS)?;
    let mut best: Option<(f32, Vec<usize>)> = None;
    for number in 0..combinations {
        let mut rest = number;
        let assigned: Vec<usize> = (0..objects)
            .map(|_| {
                let piece = rest % pieces;
                rest /= pieces;
                piece
            })
            .collect();
        let empty = (0..pieces).filter(|piece| !assigned.contains(piece)).count();
        if empty > pieces.saturating_sub(objects) {
            continue;
        }
        let total = total(&assigned);
        if best.as_ref().is_none_or(|(most, _)| total > *most) {
            best = Some((total, assigned));
        }
    }
    best.map(|(_, assigned)| assigned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_inside_another_is_at_no_distance() {
        let large = Rect::new(0.0, 0.0, 50.0, 60.0);
        assert_eq!(outside(&Rect::new(10.0, 0.0, 20.0, 60.0), &large), 0.0);
        assert_eq!(outside(&Rect::new(33.0, 0.0, 20.0, 60.0), &large), 3.0);
        assert_eq!(outside(&large, &Rect::new(-4.0, 3.0, 20.0, 20.0)), 4.0);
    }

    fn fit(colour: f32, motion: f32) -> Fit {
        Fit { colour, motion, ..Fit::default() }
    }

    #[test]
    fn colours_overrule_motion_and_motion_decides_where_they_cannot() {
        let crossed = [vec![fit(0.2, 0.0), fit(0.8, -4.0)], vec![fit(0.8, -4.0), fit(0.2, 0.0)]];
        assert_eq!(reassign(&crossed, &[0, 1], 2), [1, 0]);
        let alike = [vec![fit(0.7, 0.0), fit(0.7, -4.0)], vec![fit(0.7, -4.0), fit(0.7, 0.0)]];
        assert_eq!(reassign(&alike, &[1, 0], 2), [0, 1]);
    }
}
