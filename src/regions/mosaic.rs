//! A region as a coarse picture: how full each of its cells is, and of what colour.
//!
//! Boxes and histograms do not say where in a region that several people share each of them
//! stands. A mosaic does, at a hundredth of the size of the pixels.

use std::ops::Range;
use std::sync::Arc;

use super::colour::{Histogram, Rgb};
use super::shape::Rect;
use crate::frame::Size;

/// Cells along the shorter side of an image.
const CELLS_A_SIDE: u32 = 144;

/// The side of a cell in pixels, for images of this size.
pub fn cell_side(size: Size) -> u32 {
    ((size.shorter_side() + CELLS_A_SIDE / 2) / CELLS_A_SIDE).max(2)
}

/// A region's pixels in square cells; the cells of all regions of a video lie on one grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mosaic {
    /// Pixels along a cell's side.
    pub side: u32,
    /// The column of cells in which the region begins.
    pub left: u32,
    /// The row of cells in which it begins.
    pub top: u32,
    /// Cells across.
    pub columns: u32,
    /// Row after row.
    pub cells: Vec<Cell>,
}

/// A cell of a [`Mosaic`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// The region's pixels in it.
    pub pixels: u32,
    /// Their mean colour.
    pub colour: Rgb,
}

impl Mosaic {
    /// Several regions as one picture. A cell of which each has a part has the colour of the larger.
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

    /// Cells from top to bottom.
    pub fn rows(&self) -> u32 {
        (self.cells.len() as u32).checked_div(self.columns).unwrap_or(0)
    }

    /// The part of it in these columns of the video's grid.
    pub fn part(&self, columns: &Range<u32>) -> Self {
        let mut part = self.clone();
        for (index, cell) in part.cells.iter_mut().enumerate() {
            if !columns.contains(&(self.left + index as u32 % self.columns)) {
                *cell = Cell::default();
            }
        }
        part
    }

    /// The box around its filled cells, in pixels; `None` where nothing is filled.
    pub fn bbox(&self) -> Option<Rect> {
        let side = self.side as f32;
        let cells = self
            .filled()
            .map(|(column, row, _)| Rect::new(column as f32 * side, row as f32 * side, side, side));
        cells.reduce(|a, b| a.union(&b))
    }

    /// How often each colour occurs, each cell counting as all its pixels.
    pub fn histogram(&self) -> Histogram {
        let mut histogram = Histogram::default();
        for (.., cell) in self.filled() {
            histogram.add_many(cell.colour, cell.pixels);
        }
        histogram
    }

    /// The cells that hold something: column and row in the video's grid, and what they hold.
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

    /// The memory that it takes, in bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.cells.len() * size_of::<Cell>()
    }
}

/// Sums over a region's pixels from which its [`Mosaic`] follows.
#[derive(Debug)]
pub(super) struct MosaicSums {
    mosaic: Mosaic,
    /// Of each cell: pixels, and their sums of red, green and blue.
    sums: Vec<[u32; 4]>,
}

impl MosaicSums {
    /// For a region within these columns and rows of pixels.
    pub(super) fn new(side: u32, columns: Range<u32>, rows: Range<u32>) -> Self {
        let (left, top) = (columns.start / side, rows.start / side);
        let across = columns.end.div_ceil(side) - left;
        let down = rows.end.div_ceil(side) - top;
        let mosaic = Mosaic { side, left, top, columns: across, cells: Vec::new() };
        Self { mosaic, sums: vec![[0; 4]; (across * down) as usize] }
    }

    /// Takes the pixels of row `y` in, which begin in column `start`; three bytes each.
    pub(super) fn add_run(&mut self, y: u32, start: u32, rgb: &[u8]) {
        let Mosaic { side, left, top, columns, .. } = self.mosaic;
        let row = ((y / side - top) * columns) as usize;
        let mut column = start / side;
        let mut rest = rgb;
        // Up to where the first cell ends; then whole cells.
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

    /// The mosaic of the pixels taken in.
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

    proptest! {
        /// Every cell holds what a count over its pixels gives, and the parts and the join of
        /// regions hold what the regions do.
        #[test]
        fn cells_hold_the_regions_pixels(
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
