//! An image with coverage: one person, car or occluder, before compositing.

use super::texture::Colour;

/// A rectangle of pixels, which may lie partly outside the image.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Column of its left edge; may be negative.
    pub x: i32,
    /// Row of its upper edge; may be negative.
    pub y: i32,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Premultiplied colours, row by row.
    pub colour: Vec<Colour>,
    /// Coverage 0..=1, row by row.
    pub coverage: Vec<f32>,
}

impl Layer {
    /// Coverage from which on a pixel belongs to the silhouette.
    pub const SOLID: f32 = 0.5;

    /// An empty layer.
    pub fn clear(x: i32, y: i32, width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self { x, y, width, height, colour: vec![[0.0; 3]; pixels], coverage: vec![0.0; pixels] }
    }

    /// The layer moved by this many columns and rows.
    #[must_use]
    pub fn moved(mut self, [x, y]: [i32; 2]) -> Self {
        self.x += x;
        self.y += y;
        self
    }

    /// Composites a colour over the pixel at index `at`.
    pub fn paint(&mut self, at: usize, colour: Colour, coverage: f32) {
        for (under, over) in self.colour[at].iter_mut().zip(colour) {
            *under = *under * (1.0 - coverage) + over * coverage;
        }
        self.coverage[at] += (1.0 - self.coverage[at]) * coverage;
    }

    /// Whether image pixel (x, y) belongs to the silhouette; `false` outside the layer.
    pub fn is_solid(&self, x: i32, y: i32) -> bool {
        let (column, row) = (x - self.x, y - self.y);
        column >= 0
            && row >= 0
            && (column as usize) < self.width
            && (row as usize) < self.height
            && self.coverage[row as usize * self.width + column as usize] >= Self::SOLID
    }

    /// The index of each of its pixels, and the column and row in the image.
    pub fn places(&self) -> impl Iterator<Item = (usize, i32, i32)> + use<> {
        let (x, y, width) = (self.x, self.y, self.width);
        (0..self.coverage.len()).map(move |at| (at, x + (at % width) as i32, y + (at / width) as i32))
    }
}
