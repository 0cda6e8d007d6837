//! Counts people side by side in one region by the contour of their heads.
//!
//! Two people who enter shoulder to shoulder never show as two regions. Together they have two heads with a gap
//! between, and each has feet.

use std::ops::Range;

use crate::regions::Mosaic;

/// A cell belongs to the silhouette from this filled share on.
const MIN_CELL_FILL: f32 = 0.3;
/// Depth of the gap between two heads, at least, as a share of the smaller one's height.
const MIN_GAP_DEPTH: f32 = 0.13;
/// Columns of a gap at least this share as deep as the deepest are tried: the deepest is often beside an arm. Of a
/// gap between head and raised hand a shallower one would cut through the body.
const MIN_VALLEY_DEPTH: f32 = 0.8;
/// Height of each at least, as a share of the tallest.
const MIN_HEIGHT_RATIO: f32 = 0.6;
/// Area of each at least, as a share of both.
const MIN_AREA_SHARE: f32 = 0.25;
/// Width over height at least: more than the half of a person that a pole leaves,
const MIN_ASPECT: f32 = 0.24;
/// and at most: less than that of a car.
const MAX_ASPECT: f32 = 0.8;
/// The feet of all are within this share of the height.
const MAX_FEET_OFFSET: f32 = 0.25;
/// Height at least, in cells; heads of smaller silhouettes cannot be separated.
const MIN_HEIGHT_ROWS: u32 = 10;

/// The columns of a mosaic's grid that each person side by side occupies, from left to right.
pub(super) fn head_columns(mosaic: &Mosaic) -> Vec<Range<u32>> {
    let silhouette = Silhouette::of(mosaic);
    let mut heads = Vec::new();
    silhouette.split(0..silhouette.columns.len(), &mut heads);
    let shift = |columns: Range<usize>| mosaic.left + columns.start as u32..mosaic.left + columns.end as u32;
    heads.into_iter().map(shift).collect()
}

/// For each column its rows from the highest to below the lowest filled cell, and how many are filled.
struct Silhouette {
    columns: Vec<Option<(Range<u32>, u32)>>,
}

impl Silhouette {
    fn of(mosaic: &Mosaic) -> Self {
        let least = MIN_CELL_FILL * (mosaic.side * mosaic.side) as f32;
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

    /// The columns of a range with a filled cell.
    fn columns_of(&self, columns: &Range<usize>) -> impl Iterator<Item = &(Range<u32>, u32)> {
        self.columns.get(columns.clone()).unwrap_or_default().iter().flatten()
    }

    fn filled(&self, columns: &Range<usize>) -> u32 {
        self.columns_of(columns).map(|(_, count)| count).sum()
    }

    fn bottom(&self, columns: &Range<usize>) -> u32 {
        self.columns_of(columns).map(|(rows, _)| rows.end).max().unwrap_or(0)
    }

    /// How far above `bottom` the silhouette reaches.
    fn height(&self, columns: &Range<usize>, bottom: u32) -> u32 {
        let tops = self.columns_of(columns).map(|(rows, _)| rows.start);
        bottom.saturating_sub(tops.min().unwrap_or(bottom))
    }

    fn split(&self, columns: Range<usize>, into: &mut Vec<Range<usize>>) {
        let bottom = self.bottom(&columns);
        let middle = columns.start + columns.len() / 2;
        let depths: Vec<(usize, u32)> = (columns.start + 1..columns.end.saturating_sub(1))
            .map(|at| (at, self.depth(&columns, at, bottom)))
            .collect();
        let deepest = depths.iter().map(|(_, depth)| *depth).max().unwrap_or(0);
        let in_valley = |depth: u32| depth as f32 >= MIN_VALLEY_DEPTH * deepest as f32;
        let gap = depths
            .into_iter()
            .filter(|&(at, depth)| in_valley(depth) && self.is_gap(&columns, at, depth, bottom))
            .max_by_key(|&(at, depth)| (depth, std::cmp::Reverse(at.abs_diff(middle))))
            .map(|(at, _)| at);
        match gap {
            Some(at) => {
                self.split(columns.start..at, into);
                self.split(at..columns.end, into);
            }
            None => into.push(columns),
        }
    }

    /// Depth of column `at` below the lower of the highest points on its two sides, in cells.
    fn depth(&self, columns: &Range<usize>, at: usize, bottom: u32) -> u32 {
        let sides = [columns.start..at, at + 1..columns.end];
        let lower = sides.iter().map(|side| self.height(side, bottom)).min().unwrap_or(0);
        let here = self.columns.get(at).and_then(Option::as_ref);
        let here = here.map_or(0, |(rows, _)| bottom.saturating_sub(rows.start));
        lower.saturating_sub(here)
    }

    /// Whether column `at`, `depth` below the heads beside it, separates two people side by side.
    fn is_gap(&self, columns: &Range<usize>, at: usize, depth: u32, bottom: u32) -> bool {
        let sides = [columns.start..at, at..columns.end];
        let heights = [self.height(&sides[0], bottom), self.height(&sides[1], bottom)];
        let (lower, higher) = (heights[0].min(heights[1]), heights[0].max(heights[1]));
        let all = self.filled(columns) as f32;
        let upright = sides.iter().zip(heights).all(|(side, height)| {
            let slimness = side.len() as f32 / height.max(1) as f32;
            let feet = bottom.saturating_sub(self.bottom(side)) as f32;
            (MIN_ASPECT..MAX_ASPECT).contains(&slimness)
                && self.filled(side) as f32 >= MIN_AREA_SHARE * all
                && feet <= MAX_FEET_OFFSET * height as f32
        });
        let apart = depth as f32 >= MIN_GAP_DEPTH * lower as f32 && depth >= 2;
        let alike = lower as f32 >= MIN_HEIGHT_RATIO * higher as f32 && lower >= MIN_HEIGHT_ROWS;
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
    fn two_heads_are_counted_as_two() {
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
        assert_eq!(head_columns(&drawn(&pair)), [5..9, 9..14]);
    }

    #[test]
    fn spread_legs_below_one_head_are_one_person() {
        let stride = [
            "...##...", "...##...", "..####..", ".######.", ".######.", "..####..", "..####..", "..####..",
            ".##..##.", ".##..##.", "##....##", "##....##",
        ];
        assert_eq!(head_columns(&drawn(&stride)).len(), 1);
    }

    #[test]
    fn a_raised_hand_is_not_a_head() {
        let waves = [
            "..##...#", "..##...#", ".####.##", ".#######", "#######.", "######..", ".####...", ".####...",
            ".####...", ".#..#...", ".#..#...", ".#..#...",
        ];
        assert_eq!(head_columns(&drawn(&waves)).len(), 1);
    }

    #[test]
    fn the_halves_beside_a_pole_are_one_person() {
        let cut = [
            "..#.#..", ".##.##.", ".##.##.", "###.###", "###.###", "###.###", "###.###", "###.###",
            "###.###", "###.###", "###.###", "###.###", "###.###", ".##.##.", ".##.##.", ".##.##.",
        ];
        assert_eq!(head_columns(&drawn(&cut)).len(), 1);
    }

    #[test]
    fn an_empty_mosaic_has_at_most_one_head() {
        assert!(head_columns(&Mosaic::default()).len() <= 1);
    }

    /// Two people of these columns and rows, with shoulders that meet, and heads of `head` rows. `feet` is how many
    /// rows the first one's feet are higher.
    fn pair(widths: [usize; 2], heights: [usize; 2], head: usize, feet: usize) -> usize {
        let tallest = (heights[0] + feet).max(heights[1]);
        let rows: Vec<String> = (0..tallest)
            .map(|row| {
                let of = |person: usize, below: usize| {
                    let top = tallest - below - heights[person];
                    let filled = row >= top && row < tallest - below;
                    let width = widths[person];
                    let body = filled && row >= top + head;
                    (0..width).map(move |column| {
                        let is_head = filled && column > 0 && column + 1 < width;
                        if body || is_head { '#' } else { '.' }
                    })
                };
                of(0, feet).chain(of(1, 0)).collect()
            })
            .collect();
        head_columns(&drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>())).len()
    }

    #[test]
    fn two_people_have_similar_heights_widths_and_feet() {
        assert_eq!(pair([5, 5], [15, 15], 3, 0), 2);
        assert_eq!(pair([5, 5], [15, 15], 1, 0), 1, "a gap of one row");
        assert_eq!(pair([6, 6], [24, 24], 3, 0), 1, "a gap of an eighth of the height");
        assert_eq!(pair([6, 6], [24, 24], 4, 0), 2);
        assert_eq!(pair([4, 4], [9, 9], 3, 0), 1, "too small to tell");
        assert_eq!(pair([4, 4], [10, 10], 3, 0), 2);
        assert_eq!(pair([6, 5], [20, 12], 4, 0), 2, "three fifths as tall");
        assert_eq!(pair([6, 5], [20, 11], 4, 0), 1);
        assert_eq!(pair([7, 7], [16, 16], 3, 5), 2, "feet less than a quarter of the height apart");
        assert_eq!(pair([7, 7], [16, 16], 3, 6), 1);
        assert_eq!(pair([3, 3], [15, 15], 3, 0), 1, "as narrow as halves beside a pole");
        assert_eq!(pair([12, 12], [15, 15], 3, 0), 1, "as wide as cars");
        assert_eq!(pair([14, 4], [20, 16], 4, 0), 1, "a fifth of the area");
    }

    #[test]
    fn a_cell_counts_from_three_tenths_of_it_on() {
        let mosaic = |pixels: u32| Mosaic {
            side: 4,
            left: 5,
            top: 3,
            columns: 2,
            cells: [16, 16, 16, pixels, 16, 0].map(|pixels| Cell { pixels, colour: [90; 3] }).to_vec(),
        };
        let columns = |pixels: u32| Silhouette::of(&mosaic(pixels)).columns;
        assert_eq!(columns(5), [Some((3..6, 3)), Some((3..5, 2))]);
        assert_eq!(columns(4), [Some((3..6, 3)), Some((3..4, 1))]);
    }
}
