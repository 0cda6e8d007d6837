//! Appearance template of an object: how often each element of its box is covered, and its colour.

use crate::regions::{Mosaic, Rect};

/// Elements across a template.
const COLUMNS: usize = 8;
/// Elements from top to bottom.
const ROWS: usize = 20;
/// Learning rate of a template, once it has seen a few frames.
const LEARNING_RATE: f32 = 0.1;

/// One element of an object's box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Element {
    /// Probability that a point of it belongs to the object, 0..=1.
    pub(crate) cover: f32,
    /// The mean colour of those points.
    pub(crate) colour: [f32; 3],
}

/// An object as a picture of [`COLUMNS`] by [`ROWS`] elements, whatever its size.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    elements: Vec<Element>,
    frames: u32,
}

impl Template {
    /// From a first detection.
    pub(crate) fn new(mosaic: &Mosaic, bbox: &Rect) -> Self {
        Self { elements: sample(mosaic, bbox), frames: 1 }
    }

    /// Updates it with a detection.
    pub(crate) fn update(&mut self, mosaic: &Mosaic, bbox: &Rect) {
        let rate = LEARNING_RATE.max(1.0 / (self.frames + 1) as f32);
        self.frames += 1;
        for (mine, now) in self.elements.iter_mut().zip(sample(mosaic, bbox)) {
            let cover = mine.cover + rate * (now.cover - mine.cover);
            if now.cover > 0.0 {
                let share = (rate * now.cover / cover.max(f32::MIN_POSITIVE)).min(1.0);
                for (mean, now) in mine.colour.iter_mut().zip(now.colour) {
                    *mean += share * (now - *mean);
                }
            }
            mine.cover = cover;
        }
    }

    /// The element at (u, v), each 0..1 from left and top.
    pub(crate) fn at(&self, u: f32, v: f32) -> Element {
        let column = ((u * COLUMNS as f32) as usize).min(COLUMNS - 1);
        let row = ((v * ROWS as f32) as usize).min(ROWS - 1);
        self.elements.get(row * COLUMNS + column).copied().unwrap_or_default()
    }
}

/// Samples a mosaic at each element of a box.
fn sample(mosaic: &Mosaic, bbox: &Rect) -> Vec<Element> {
    let mut elements = vec![Element::default(); COLUMNS * ROWS];
    for (index, element) in elements.iter_mut().enumerate() {
        let u = ((index % COLUMNS) as f32 + 0.5) / COLUMNS as f32;
        let v = ((index / COLUMNS) as f32 + 0.5) / ROWS as f32;
        let (x, y) = (bbox.x + u * bbox.w, bbox.y + v * bbox.h);
        let side = mosaic.side.max(1);
        let Some(cell) = mosaic.at(x as u32 / side, y as u32 / side) else { continue };
        if cell.pixels > 0 {
            element.cover = (cell.pixels as f32 / (side * side) as f32).min(1.0);
            element.colour = cell.colour.map(f32::from);
        }
    }
    elements
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::regions::mosaic::Cell;

    const BBOX: Rect = Rect::new(80.0, 40.0, 32.0, 80.0);

    /// A region whose cells of 4 pixels are the elements of [`BBOX`].
    fn mosaic(cell: impl Fn(usize) -> Cell) -> Mosaic {
        let cells = (0..COLUMNS * ROWS).map(cell).collect();
        Mosaic { side: 4, left: 20, top: 10, columns: COLUMNS as u32, cells }
    }

    fn even(pixels: u32, grey: u8) -> Mosaic {
        mosaic(|_| Cell { pixels, colour: [grey; 3] })
    }

    #[test]
    fn an_element_has_the_cover_and_the_colour_of_its_cell() {
        let template =
            Template::new(&mosaic(|at| Cell { pixels: at as u32 % 16, colour: [at as u8; 3] }), &BBOX);
        for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
            let at = row * COLUMNS + column;
            let (u, v) = ((column as f32 + 0.9) / COLUMNS as f32, (row as f32 + 0.1) / ROWS as f32);
            let element = template.at(u, v);
            assert_eq!(element.cover, (at % 16) as f32 / 16.0);
            assert_eq!(element.colour, [if at.is_multiple_of(16) { 0.0 } else { at as f32 }; 3]);
        }
        assert_eq!(template.at(1.0, 1.0), template.at(0.99, 0.99), "the last one ends at the edge");
        assert_eq!(template.at(1.0, 0.5), template.at(0.99, 0.5));
        let beside = Template::new(&even(16, 90), &Rect::new(96.0, 40.0, 32.0, 80.0));
        assert_eq!([beside.at(0.4, 0.5).cover, beside.at(0.6, 0.5).cover], [1.0, 0.0]);
    }

    #[test]
    fn cover_and_colour_are_means_of_the_first_frames_and_follow_later_ones_slowly() {
        let mut template = Template::new(&even(16, 100), &BBOX);
        let mut after = |pixels: u32, grey: u8| {
            template.update(&even(pixels, grey), &BBOX);
            let element = template.at(0.5, 0.5);
            (element.cover, element.colour[1])
        };
        let close = |(a, b): (f32, f32), (c, d): (f32, f32)| (a - c).abs() < 1e-4 && (b - d).abs() < 1e-2;
        // A third of all covered points had the second colour.
        assert!(close(after(8, 200), (0.75, 400.0 / 3.0)));
        assert!(close(after(0, 0), (0.5, 400.0 / 3.0)));
        assert!(close(after(16, 40), (0.625, 96.0)));
        for _ in 0..40 {
            after(16, 40);
        }
        let (cover, _) = after(16, 40);
        assert!(close(after(0, 0), (0.9 * cover, after(0, 0).1)));
        let (cover, grey) = after(0, 0);
        let expected = cover + 0.1 * (1.0 - cover);
        assert!(close(after(16, 250), (expected, grey + 0.1 / expected * (250.0 - grey))));
    }
}
