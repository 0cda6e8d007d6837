//! From mask to moving regions (§VII, Algorithm 1): a foreground mask and its frame → [`Region`]s.
//!
//! [`cleaning`] filters the mask, [`components`] finds its connected components in two passes, [`shape`] and
//! [`colour`] describe each of them, and [`mosaic`] holds its colours by position. [`roi`] is the part of the image
//! that is analysed. Coordinates are pixels of the frame, y down.

use std::sync::Arc;

pub(crate) mod box_index;
pub mod cleaning;
pub mod colour;
pub mod components;
pub mod mosaic;
pub(crate) mod rle;
pub mod roi;
pub mod shape;

pub use cleaning::Cleaning;
pub use colour::{Histogram, Rgb, SmoothedHistogram};
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
