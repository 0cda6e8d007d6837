//! The share of foreground in a square around a pixel, 0..=1 per frame.

use std::ops::Range;

use crate::frame::Size;

/// The `side`×`side` pixels around one, as far as they are inside the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRegion {
    /// The centre pixel: column and row.
    pub centre: (u32, u32),
    /// Side in pixels.
    pub side: u32,
}

impl PixelRegion {
    /// Whether its centre is inside an image of `size`.
    pub fn is_centred_in(self, size: Size) -> bool {
        size.index(self.centre.0, self.centre.1).is_some()
    }
}

/// The share of foreground among the pixels around one, 0..=1, in every analysed frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionShares {
    /// The centre pixel: column and row.
    pub at: (u32, u32),
    /// Side of the region in pixels; it is clipped at the image's edge.
    pub side: u32,
    /// Number of pixels.
    pub pixels: u32,
    /// The share of foreground in the model's mask, before cleaning, by position.
    pub model: Vec<f32>,
    /// The share of foreground after cleaning, by position.
    pub cleaned: Vec<f32>,
}

/// The columns and rows of the `side`×`side` pixels around one, clipped to the image.
pub fn region_bounds((x, y): (u32, u32), side: u32, size: Size) -> (Range<u32>, Range<u32>) {
    let half = side / 2;
    let range = |at: u32, end: u32| at.saturating_sub(half)..at.saturating_add(half + 1).min(end);
    (range(x, size.width), range(y, size.height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_is_clipped_at_the_image_edge() {
        let size = Size::new(10, 6);
        assert_eq!(region_bounds((4, 2), 3, size), (3..6, 1..4));
        assert_eq!(region_bounds((0, 5), 5, size), (0..3, 3..6));
        assert_eq!(region_bounds((9, 0), 1, size), (9..10, 0..1));
    }
}
