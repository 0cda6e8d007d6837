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
