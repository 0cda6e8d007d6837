//! How many stand side by side in one region, by the line of its heads.
//!
//! Two who come in shoulder to shoulder never show as two regions. Seen together they have two
//! heads with a gap between, and each has feet.

use std::ops::Range;

use crate::regions::Mosaic;

/// A cell is a part of the silhouette when so much of it is filled.
const FILLED: f32 = 0.3;
/// The gap between two heads goes down by at least this share of the smaller one's height.
const GAP: f32 = 0.13;
/// Of the columns of a gap, those at least this share as deep as the deepest are tried: the deepest is often beside an arm. Of
/// a gap between head and raised hand a shallower one would cut through the body.
const VALLEY: f32 = 0.8;
/// Nobody is less than this share as tall as the tallest.
const SHORTEST: f32 = 0.6;
/// Nor does anybody have less than this share of the pixels of two.
const LEAST_AREA: f32 = 0.25;
/// Width of one over their height: more than the half of somebody that a pole leaves.
const SLIMMEST: f32 = 0.24;
/// And less than that of a car.
const WIDEST: f32 = 0.8;
/// The feet of all are within this share of the height.
const FEET: f32 = 0.25;
/// Heads cannot be told apart where somebody is fewer cells tall than this.
const LEAST_ROWS: u32 = 10;

/// The columns of a mosaic's grid in which each of those side by side stands, from left to right.
pub fn lobes(mosaic: &Mosaic) -> Vec<Range<u32>> {
    let silhouette = Silhouette::of(mosaic);
    let mut lobes = Vec::new();
    silhouette.split(0..silhouette.columns.len(), &mut lobes);
    let shift = |lobe: Range<usize>| mosaic.left + lobe.start as u32..mosaic.left + lobe.end as u32;
    lobes.into_iter().map(shift).collect()
}

/// Of each column the rows from the highest to below the lowest filled cell, and how many are filled.
struct Silhouette {
    columns: Vec<Option<(Range<u32>, u32)>>,
}

impl Silhouette {
    fn of(mosaic: &Mosaic) -> Self {
        let least = FILLED * (mosaic.side * mosaic.side) as f32;
        let mut columns: Vec<Option<(Range<u32>, u32)>> = vec![None; mosaic.columns as usize];
        for (column, row, _) in mosaic.filled().filter(|(.., cell)| cell.pixels as f32 >= least) {
            let Some(it) = columns.get_mut((column - mosaic.left) as usize) else { continue };
            *it = Some(match it.take() {
                None => (row..row + 1, 1),
                Some((rows, count)) => (rows.start..row + 1, count + 1),
            });
        }
        Self { columns }
    }

    /// The columns of a lobe in which something is filled.
    fn columns_of(&self, lobe: &Range<usize>) -> impl Iterator<Item = &(Range<u32>, u32)> {
        self.columns.get(lobe.clone()).unwrap_or_default().iter().flatten()
    }

    fn filled(&self, lobe: &Range<usize>) -> u32 {
        self.columns_of(lobe).map(|(_, count)| count).sum()
    }

    fn bottom(&self, lobe: &Range<usize>) -> u32 {
        self.columns_of(lobe).map(|(rows, _)| rows.end).max().unwrap_or(0)
    }

    /// How far above `bottom` the silhouette reaches.
    fn height(&self, lobe: &Range<usize>, bottom: u32) -> u32 {
        let tops = self.columns_of(lobe).map(|(rows, _)| rows.start);
        bottom.saturating_sub(tops.min().unwrap_or(bottom))
    }

    fn split(&self, lobe: Range<usize>, into: &mut Vec<Range<usize>>) {
        let bottom = self.bottom(&lobe);
        let middle = lobe.start + lobe.len() / 2;
        let depths: Vec<(usize, u32)> = (lobe.start + 1..lobe.end.saturating_sub(1))
            .map(|at| (at, self.depth(&lobe, at, bottom)))
            .collect();
        let deepest = depths.iter().map(|(_, depth)| *depth).max().unwrap_or(0);
        let in_valley = |depth: u32| depth as f32 >= VALLEY * deepest as f32;
        let gap = depths
            .into_iter()
            .filter(|&(at, depth)| in_valley(depth) && self.is_gap(&lobe, at, depth, bottom))
            .max_by_key(|&(at, depth)| (depth, std::cmp::Reverse(at.abs_diff(middle))))
            .map(|(at, _)| at);
        match gap {
            Some(at) => {
                self.split(lobe.start..at, into);
                self.split(at..lobe.end, into);
            }
            None => into.push(lobe),
        }
    }

    /// How far the line of heads in column `at` lies below the lower of the two on either side.
    fn depth(&self, lobe: &Range<usize>, at: usize, bottom: u32) -> u32 {
        let sides = [lobe.start..at, at + 1..lobe.end];
        let lower = sides.iter().map(|side| self.height(side, bottom)).min().unwrap_or(0);
        let here = self.columns.get(at).and_then(Option::as_ref);
        let here = here.map_or(0, |(rows, _)| bottom.saturating_sub(rows.start));
        lower.saturating_sub(here)
    }

    /// Whether column `at`, `depth` below the heads beside it, lies between two who stand side by side.
    fn is_gap(&self, lobe: &Range<usize>, at: usize, depth: u32, bottom: u32) -> bool {
        let sides = [lobe.start..at, at..lobe.end];
        let heights = [self.height(&sides[0], bottom), self.height(&sides[1], bottom)];
        let (lower, higher) = (heights[0].min(heights[1]), heights[0].max(heights[1]));
        let all = self.filled(lobe) as f32;
        let upright = sides.iter().zip(heights).all(|(side, height)| {
            let slimness = side.len() as f32 / height.max(1) as f32;
            let feet = bottom.saturating_sub(self.bottom(side)) as f32;
            (SLIMMEST..WIDEST).contains(&slimness)
                && self.filled(side) as f32 >= LEAST_AREA * all
                && feet <= FEET * height as f32
        });
        let apart = depth as f32 >= GAP * lower as f32 && depth >= 2;
        let alike = lower as f32 >= SHORTEST * higher as f32 && lower >= LEAST_ROWS;
        apart && alike && upright
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::regions::mosaic::Cell;

    /// A silhouette drawn with `#`, beginning in column 5 and row 3 of the grid.
    fn drawn(rows: &[&str]) -> Mosaic {
        let cell = |byte| Cell { pixels: if byte == b'#' { 16 } else { 0 }, colour: [90; 3] };
        let cells = rows.iter().flat_map(|row| row.bytes()).map(cell).collect();
        Mosaic { side: 4, left: 5, top: 3, columns: rows[0].len() as u32, cells }
    }

    #[test]
    fn two_heads_are_two() {
        let pair = [
            ".##...##.",
            ".##...##.",
            "####.####",
            "#########",
            "#########",
            "#########",
            "#########",
            "####.####",
            "####.####",
            ".###.###.",
            ".#.#.#.#.",
            ".#.#.#.#.",
        ];
        assert_eq!(lobes(&drawn(&pair)), [5..9, 9..14]);
    }

    #[test]
    fn one_head_is_one_however_the_legs_are_spread() {
        let stride = [
            "...##...", "...##...", "..####..", ".######.", ".######.", "..####..", "..####..", "..####..",
            ".##..##.", ".##..##.", "##....##", "##....##",
        ];
        assert_eq!(lobes(&drawn(&stride)).len(), 1);
    }

    #[test]
    fn a_raised_hand_is_nobody() {
        let waves = [
            "..##...#", "..##...#", ".####.##", ".#######", "#######.", "######..", ".####...", ".####...",
            ".####...", ".#..#...", ".#..#...", ".#..#...",
        ];
        assert_eq!(lobes(&drawn(&waves)).len(), 1);
    }

    #[test]
    fn the_halves_beside_a_pole_are_one() {
        let cut = [
            "..#.#..", ".##.##.", ".##.##.", "###.###", "###.###", "###.###", "###.###", "###.###",
            "###.###", "###.###", "###.###", "###.###", "###.###", ".##.##.", ".##.##.", ".##.##.",
        ];
        assert_eq!(lobes(&drawn(&cut)).len(), 1);
    }

    #[test]
    fn nothing_is_nobody() {
        assert!(lobes(&Mosaic::default()).len() <= 1);
    }
}
