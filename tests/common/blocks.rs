//! Regions of blocks of one colour each, made without images.

use std::ops::Range;
use std::sync::Arc;

use occluscope::frame::Size;
use occluscope::regions::mosaic::{Cell, cell_side};
use occluscope::regions::shape::ShapeSums;
use occluscope::regions::{Histogram, Mosaic, Region, Rgb};

/// A block, in whole cells of a mosaic: columns and rows.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) columns: Range<u32>,
    pub(crate) rows: Range<u32>,
    pub(crate) colour: Rgb,
}

impl Block {
    /// The part inside the image of a block whose upper left cell is at `(left, top)`.
    pub(crate) fn new((left, top): (i32, i32), (w, h): (i32, i32), colour: Rgb, size: Size) -> Option<Self> {
        let side = cell_side(size);
        let clip = |low: i32, high: i32, end: u32| {
            let end = (end / side) as i32;
            low.clamp(0, end) as u32..high.clamp(0, end) as u32
        };
        let (columns, rows) = (clip(left, left + w, size.width), clip(top, top + h, size.height));
        (!columns.is_empty() && !rows.is_empty()).then_some(Self { columns, rows, colour })
    }

    fn touches(&self, other: &Self) -> bool {
        let meet = |a: &Range<u32>, b: &Range<u32>| a.start <= b.end && b.start <= a.end;
        meet(&self.columns, &other.columns) && meet(&self.rows, &other.rows)
    }
}

/// The regions of blocks; earlier ones occlude later ones, and blocks that touch are one region.
pub(crate) fn regions(blocks: &[Block], size: Size) -> Vec<Region> {
    let mut together: Vec<Vec<&Block>> = Vec::new();
    for block in blocks {
        let touched = |group: &Vec<&Block>| group.iter().any(|other| other.touches(block));
        let (joined, apart): (Vec<_>, Vec<_>) = together.into_iter().partition(touched);
        together = apart;
        together.push(joined.into_iter().flatten().chain([block]).collect());
    }
    let labels = 1..;
    together.into_iter().zip(labels).map(|(blocks, label)| region(label, &blocks, cell_side(size))).collect()
}

fn region(label: u32, blocks: &[&Block], side: u32) -> Region {
    let left = blocks.iter().map(|block| block.columns.start).min().unwrap_or(0);
    let right = blocks.iter().map(|block| block.columns.end).max().unwrap_or(0);
    let top = blocks.iter().map(|block| block.rows.start).min().unwrap_or(0);
    let bottom = blocks.iter().map(|block| block.rows.end).max().unwrap_or(0);
    let mut cells = Vec::new();
    let mut sums = ShapeSums::default();
    for row in top..bottom {
        for column in left..right {
            let mut here = blocks.iter().filter(|it| it.columns.contains(&column) && it.rows.contains(&row));
            let Some(block) = here.next() else {
                cells.push(Cell::default());
                continue;
            };
            cells.push(Cell { pixels: side * side, colour: block.colour });
            for line in 0..side {
                sums.add_run(row * side + line, column * side..(column + 1) * side);
            }
        }
    }
    let mosaic = Mosaic { side, left, top, columns: right - left, cells };
    let histogram: Histogram = mosaic.histogram();
    let colour = histogram.dominant().unwrap_or_default();
    Region { label, shape: sums.shape(), colour, histogram, mosaic: Arc::new(mosaic) }
}
