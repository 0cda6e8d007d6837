//! From mask to moving regions: cleaning, two-pass connected components, shape, dominant colour (§VII, Algorithm 1).

use std::sync::Arc;

pub mod cleaning;
pub mod colour;
pub mod components;
pub mod mosaic;
pub mod roi;
pub mod shape;

pub use cleaning::Cleaning;
pub use colour::{Histogram, Rgb};
pub use components::{LabelRun, Labels, find_regions};
pub use mosaic::Mosaic;
pub use roi::Roi;
pub use shape::{Rect, Shape};

/// A connected region of the foreground mask.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its number in the frame, from 1, in raster order of the regions' first pixels.
    pub label: u32,
    /// Position and shape.
    pub shape: Shape,
    /// The most frequent colour of its own pixels (Algorithm 1).
    pub colour: Rgb,
    /// The colour histogram of its pixels.
    pub histogram: Histogram,
    /// The spatial distribution of its colours.
    pub mosaic: Arc<Mosaic>,
}

impl Region {
    /// Approximate size in memory, in bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.mosaic.bytes() + self.histogram.bins().count() * 2 * size_of::<colour::Bin>()
    }
}
