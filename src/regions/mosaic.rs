//! A region as a low-resolution image: the number of pixels and the mean colour of each cell.
//!
//! Bounding boxes and histograms do not show where the members of a group are within its region. A mosaic does, in less
//! memory than the pixels.

use std::ops::Range;
use std::sync::Arc;

use super::colour::{Histogram, Rgb};
use super::shape::Rect;
use crate::frame::Size;

/// Number of cells along the shorter side of an image.
const CELLS_A_SIDE: u32 = 144;

/// The side of a cell in pixels, for images of this size.
pub fn cell_side(size: Size) -> u32 {
    ((size.shorter_side() + CELLS_A_SIDE / 2) / CELLS_A_SIDE).max(2)
}

/// A region in square cells; the cells of all regions of a video lie on one grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mosaic {
    /// Side of a cell in pixels.
    pub side: u32,
    /// Leftmost column of cells on the grid.
    pub left: u32,
    /// Topmost row of cells on the grid.
    pub top: u32,
    /// Number of columns.
    pub columns: u32,
    /// The cells, row by row.
    pub cells: Vec<Cell>,
}

/// A cell of a [`Mosaic`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// Number of the region's pixels in it.
    pub pixels: u32,
    /// Their mean colour.
    pub colour: Rgb,
}

impl Mosaic {
    /// Joins several regions. A cell shared by several has the colour of the one with most pixels in it.
    pub fn join(mosaics: &[Arc<Self>]) -> Self {
        let Some(first) = mosaics.first() else { return Self::default() };
        let (mut left, mut top, mut right, mut bottom) = (u32::MAX, u32::MAX, 0, 0);
        for mosaic in mosaics {
            (left, top) = (left.min(mosaic.left), top.min(mosaic.top));
            right = right.max(mosaic.left + mosaic.columns);
            bottom = bottom.max(mosaic.top + mosaic.rows());
        }
        let columns = right - left;
        let mut cells = vec![Cell::default(); (columns * (bottom - top)) as usize];
        for (column, row, cell) in mosaics.iter().flat_map(|mosaic| mosaic.filled()) {
            let here = &mut cells[((row - top) * columns + column - left) as usize];
            if cell.pixels > here.pixels {
                here.colour = cell.colour;
            }
            here.pixels += cell.pixels;
        }
        Self { side: first.side, left, top, columns, cells }
    }

    /// Number of rows.
    pub fn rows(&self) -> u32 {
        (self.cells.len() as u32).checked_div(self.columns).unwrap_or(0)
    }

    /// The part in these columns of the video's grid.
    pub fn part(&self, columns: &Range<u32>) -> Self {
        let mut part = self.clone();
        for (index, cell) in part.cells.iter_mut().enumerate() {
            if !columns.contains(&(self.left + index as u32 % self.columns)) {
                *cell = Cell::default();
            }
        }
        part
    }

    /// The bounding box of its non-empty cells, in pixels; `None` where all are empty.
    pub fn bbox(&self) -> Option<Rect> {
        let side = self.side as f32;
        let cells = self
            .filled()
            .map(|(column, row, _)| Rect::new(column as f32 * side, row as f32 * side, side, side));
        cells.reduce(|a, b| a.union(&b))
    }

    /// The colour histogram; each cell counts with the number of its pixels.
    pub fn histogram(&self) -> Histogram {
        let mut histogram = Histogram::default();
        for (.., cell) in self.filled() {
            histogram.add_many(cell.colour, cell.pixels);
        }
        histogram
    }

    /// The non-empty cells: column and row on the video's grid, and the cell.
    pub fn filled(&self) -> impl Iterator<Item = (u32, u32, Cell)> {
        let place = |index: usize| (index as u32 % self.columns, index as u32 / self.columns);
        self.cells.iter().enumerate().filter(|(_, cell)| cell.pixels > 0).map(move |(index, &cell)| {
            let (column, row) = place(index);
            (self.left + column, self.top + row, cell)
        })
    }

    /// The cell in this column and row of the video's grid, `None` beyond the region.
    pub fn at(&self, column: u32, row: u32) -> Option<Cell> {
        let (column, row) = (column.checked_sub(self.left)?, row.checked_sub(self.top)?);
        let index = (row * self.columns + column) as usize;
        (column < self.columns).then(|| self.cells.get(index).copied()).flatten()
    }

    /// Size in memory, in bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.cells.len() * size_of::<Cell>()
    }
}

/// Sums over a region's pixels from which its [`Mosaic`] is computed.
#[derive(Debug)]
pub(super) struct MosaicSums {
    mosaic: Mosaic,
    /// Of each cell: the number of pixels and their sums of red, green and blue.
    sums: Vec<[u32; 4]>,
}

impl MosaicSums {
    /// Empty sums for a region within these columns and rows of pixels.
    pub(super) fn new(side: u32, columns: Range<u32>, rows: Range<u32>) -> Self {
        let (left, top) = (columns.start / side, rows.start / side);
        let across = columns.end.div_ceil(side) - left;
        let down = rows.end.div_ceil(side) - top;
        let mosaic = Mosaic { side, left, top, columns: across, cells: Vec::new() };
        Self { mosaic, sums: vec![[0; 4]; (across * down) as usize] }
    }

    /// Adds a run of pixels of row `y` from column `start` on; three bytes each.
    pub(super) fn add_run(&mut self, y: u32, start: u32, rgb: &[u8]) {
        let Mosaic { side, left, top, columns, .. } = self.mosaic;
        let row = ((y / side - top) * columns) as usize;
        let mut column = start / side;
        let mut rest = rgb;
        // First to the end of the first cell, then whole cells.
        let mut length = (3 * (side - start % side)) as usize;
        while !rest.is_empty() {
            let (here, after) = rest.split_at(length.min(rest.len()));
            let sums = &mut self.sums[row + (column - left) as usize];
            for pixel in here.chunks_exact(3) {
                sums[0] += 1;
                for (sum, &channel) in sums[1..].iter_mut().zip(pixel) {
                    *sum += u32::from(channel);
                }
            }
            rest = after;
            column += 1;
            length = 3 * side as usize;
        }
    }

    /// The mosaic of the added pixels.
    pub(super) fn mosaic(self) -> Mosaic {
        let cell = |&[pixels, r, g, b]: &[u32; 4]| Cell {
            pixels,
            colour: [r, g, b].map(|sum| (sum + pixels / 2).checked_div(pixels).unwrap_or(0) as u8),
        };
        Mosaic { cells: self.sums.iter().map(cell).collect(), ..self.mosaic }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::super::find_regions;
    use super::*;
    use crate::frame::{Frame, Mask};

    #[test]
    fn the_shorter_side_has_about_144_cells() {
        let sides = [(0, 2), (288, 2), (359, 2), (360, 3), (480, 3), (720, 5), (1080, 8), (2160, 15)];
        for (shorter, side) in sides {
            assert_eq!(cell_side(Size::new(2 * shorter, shorter)), side, "{shorter}");
            assert_eq!(cell_side(Size::new(shorter, shorter + 1)), side, "{shorter}");
        }
    }

    fn cell(pixels: u32, grey: u8) -> Cell {
        Cell { pixels, colour: [grey; 3] }
    }

    #[test]
    fn a_shared_cell_has_the_colour_of_most_of_its_pixels() {
        let mosaic = |left: u32, top: u32, cells: [Cell; 2]| {
            Arc::new(Mosaic { side: 4, left, top, columns: 2, cells: cells.to_vec() })
        };
        let regions = [
            mosaic(5, 7, [cell(3, 10), cell(4, 20)]),
            mosaic(6, 7, [cell(4, 30), cell(2, 40)]),
            mosaic(5, 7, [cell(5, 50), Cell::default()]),
            mosaic(4, 9, [cell(0, 0), cell(1, 60)]),
        ];
        let none = Cell::default();
        let cells =
            [[none, cell(8, 50), cell(8, 20), cell(2, 40)], [none; 4], [none, cell(1, 60), none, none]];
        let joined = Mosaic::join(&regions);
        assert_eq!(joined, Mosaic { side: 4, left: 4, top: 7, columns: 4, cells: cells.concat() });
        assert_eq!(joined.rows(), 3);
        assert_eq!(Mosaic::join(&[]), Mosaic::default());
    }

    #[test]
    fn a_part_has_the_cells_of_its_columns() {
        let cells: Vec<Cell> = (1..=6).map(|pixels| cell(pixels, 9)).collect();
        let whole = Mosaic { side: 2, left: 10, top: 3, columns: 3, cells };
        let filled =
            |mosaic: &Mosaic| mosaic.filled().map(|(x, y, cell)| (x, y, cell.pixels)).collect::<Vec<_>>();
        assert_eq!(filled(&whole.part(&(11..12))), [(11, 3, 2), (11, 4, 5)]);
        assert_eq!(filled(&whole.part(&(0..11))), [(10, 3, 1), (10, 4, 4)]);
        assert_eq!(whole.part(&(11..40)).bbox(), Some(Rect::new(22.0, 6.0, 4.0, 4.0)));
        assert_eq!(whole.part(&(13..40)).bbox(), None);
        assert_eq!(whole.at(12, 4), Some(cell(6, 9)));
        assert_eq!([whole.at(13, 3), whole.at(9, 4), whole.at(12, 5), whole.at(12, 2)], [None; 4]);
    }

    #[test]
    fn a_mosaic_has_no_more_cells_than_its_region_spans() {
        let sums = MosaicSums::new(4, 6..13, 3..9);
        let mosaic = sums.mosaic();
        assert_eq!((mosaic.left, mosaic.top, mosaic.columns, mosaic.rows()), (1, 0, 3, 3));
        let below = MosaicSums::new(4, 6..13, 9..12).mosaic();
        assert_eq!((below.left, below.top, below.columns, below.rows()), (1, 2, 3, 1));
    }

    #[test]
    fn a_cell_counts_with_its_pixels_in_the_histogram() {
        let mosaic = Mosaic { side: 2, left: 0, top: 0, columns: 2, cells: vec![cell(3, 10), cell(2, 200)] };
        let bins: Vec<(f32, Rgb)> =
            mosaic.histogram().bins().map(|(_, bin)| (bin.count, bin.mean())).collect();
        assert_eq!(bins, [(3.0, [10; 3]), (2.0, [200; 3])]);
    }

    proptest! {
        /// Every cell equals a direct count over its pixels, and parts and joins of regions equal those of their
        /// pixels.
        #[test]
        fn cells_equal_counts_over_the_regions_pixels(
            (width, height) in (3u32..40, 3u32..40),
            seed in any::<[u8; 32]>(),
        ) {
            let size = Size::new(width, height);
            let at = |x: u32, y: u32| seed[((x / 3 * 7 + y / 3 * 13) % 32) as usize];
            let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let mask = Mask {
                size,
                data: pixels().map(|(x, y)| if at(x, y) > 128 { Mask::FOREGROUND } else { 0 }).collect(),
            };
            let rgb = pixels().flat_map(|(x, y)| [x as u8 * 3, y as u8 * 5, at(x, y)]).collect();
            let frame = Frame::new(1, size, rgb);
            let (labels, regions) = find_regions(&frame, &mask, 1);
            for region in &regions {
                let mosaic = &region.mosaic;
                prop_assert_eq!(mosaic.side, cell_side(size));
                let mut total = 0;
                for (column, row, cell) in mosaic.filled() {
                    let side = mosaic.side;
                    let inside = |x: u32, y: u32| x / side == column && y / side == row;
                    let of_region = |(x, y): &(u32, u32)| {
                        inside(*x, *y) && labels.at(*x, *y) == Some(region.label)
                    };
                    let here: Vec<_> = pixels().filter(of_region).collect();
                    prop_assert_eq!(here.len() as u32, cell.pixels);
                    let red: u32 = here.iter().map(|(x, _)| 3 * x).sum();
                    let mean = (red + cell.pixels / 2) / cell.pixels;
                    prop_assert_eq!(mean as u8, cell.colour[0]);
                    total += cell.pixels;
                }
                prop_assert_eq!(total, region.shape.area);
                let middle = mosaic.left + mosaic.columns / 2;
                let halves = [mosaic.part(&(0..middle)), mosaic.part(&(middle..u32::MAX))].map(Arc::new);
                let whole = Mosaic::join(&halves);
                prop_assert_eq!(&whole, mosaic.as_ref());
            }
        }
    }
}
