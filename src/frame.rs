//! The data shared by all stages: frames, their sizes, and masks.
//!
//! Pixels are (x, y), column and row, from the upper left (0, 0). *Row order* is row by row from the top, each from the
//! left.

use std::fmt;
use std::iter;
use std::ops::Range;

use memchr::{memchr, memchr_iter};

use crate::registration::Alignment;

/// Width and height of an image in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Size {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Size {
    /// A size of `width` columns and `height` rows.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// Number of pixels of an image of this size.
    pub const fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The shorter side, in pixels.
    pub fn shorter_side(self) -> u32 {
        self.width.min(self.height)
    }

    /// The index of pixel (x, y) in row order; `None` outside the image.
    pub fn index(self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}×{}", self.width, self.height)
    }
}

/// An 8-bit RGB image of a sequence, with its frame number and time. Equality ignores the time and the alignment.
#[derive(Clone)]
pub struct Frame {
    /// The frame number that is shown and written to files: from 1, or the number in an image's file name.
    pub number: u32,
    /// Its time of presentation in seconds since the source's first frame, which rises from frame to frame.
    pub time: f64,
    /// Width and height.
    pub size: Size,
    /// Row by row, three bytes per pixel: red, green, blue.
    pub rgb: Vec<u8>,
    /// The alignment to the frames before it, where it was estimated.
    pub alignment: Alignment,
}

impl Frame {
    /// A frame from its bytes, row by row, three per pixel, at time 0.
    ///
    /// # Panics
    /// If the number of bytes does not match the size: a source that decodes wrongly is a bug.
    pub fn new(number: u32, size: Size, rgb: Vec<u8>) -> Self {
        assert_eq!(rgb.len(), size.pixels() * 3, "three bytes for each pixel");
        Self { number, time: 0.0, size, rgb, alignment: Alignment::default() }
    }

    /// The frame at this time, in seconds since the source's first frame.
    #[must_use]
    pub fn at_time(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// The colour at (x, y); `None` outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        let at = self.size.index(x, y)? * 3;
        Some([self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]])
    }

    /// The part within these columns and rows, which must be inside the image.
    pub fn cut(&self, columns: &Range<u32>, rows: &Range<u32>) -> Self {
        let size = Size::new(columns.len() as u32, rows.len() as u32);
        let mut rgb = Vec::with_capacity(size.pixels() * 3);
        for row in rows.clone() {
            let start = (row as usize * self.size.width as usize + columns.start as usize) * 3;
            rgb.extend_from_slice(&self.rgb[start..start + columns.len() * 3]);
        }
        Self::new(self.number, size, rgb).at_time(self.time)
    }
}

impl PartialEq for Frame {
    fn eq(&self, other: &Self) -> bool {
        (self.number, self.size) == (other.number, other.size) && self.rgb == other.rgb
    }
}

impl Eq for Frame {}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Frame {} of {}", self.number, self.size)
    }
}

/// A foreground mask: one byte per pixel in row order, 0 background, 255 foreground.
#[derive(Clone, PartialEq, Eq)]
pub struct Mask {
    /// Width and height.
    pub size: Size,
    /// 0 or 255 for each pixel, row by row.
    pub data: Vec<u8>,
}

impl Mask {
    /// The value of a background pixel.
    pub const BACKGROUND: u8 = 0;
    /// The value of a foreground pixel.
    pub const FOREGROUND: u8 = 255;

    /// A mask without foreground.
    pub fn empty(size: Size) -> Self {
        Self { size, data: vec![Self::BACKGROUND; size.pixels()] }
    }

    /// Whether (x, y) is foreground; `false` outside the image.
    pub fn is_foreground(&self, x: u32, y: u32) -> bool {
        self.size.index(x, y).is_some_and(|at| self.data[at] != Self::BACKGROUND)
    }

    /// The runs of foreground in row order; a run can continue in the next row.
    pub fn runs(&self) -> impl Iterator<Item = Range<usize>> {
        let mut end = 0;
        iter::from_fn(move || {
            let start = end + memchr(Self::FOREGROUND, &self.data[end..])?;
            end = memchr(Self::BACKGROUND, &self.data[start..])
                .map_or(self.data.len(), |length| start + length);
            Some(start..end)
        })
    }

    /// Number of foreground pixels.
    pub fn foreground_pixels(&self) -> usize {
        memchr_iter(Self::FOREGROUND, &self.data).count()
    }

    /// The share of foreground pixels, 0..=1.
    pub fn foreground_share(&self) -> f32 {
        self.foreground_pixels() as f32 / self.size.pixels().max(1) as f32
    }
}

impl fmt::Debug for Mask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Mask of {} with {} foreground pixels", self.size, self.foreground_pixels())
    }
}
