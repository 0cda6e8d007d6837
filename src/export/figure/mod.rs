//! Figures for publications: described as data, written as SVG and PDF, and rasterised to PNG.
//!
//! A [`Figure`] consists of panels with axes and marks on white, in points of 1/72 inch. Figures of one pixel are
//! made by [`mixture`], [`through_time`], [`scatter`], [`cube`] and [`tuning`], of several by [`pins`] and of a
//! region by [`region`]; [`svg`], `pdf` and `raster` are independent of pixels.

pub mod axis;
pub mod cube;
pub mod mixture;
#[cfg(feature = "gui")]
pub mod pdf;
pub mod pins;
#[cfg(feature = "gui")]
pub mod raster;
pub mod region;
pub mod scatter;
pub mod svg;
#[cfg(test)]
mod tests;
pub mod text;
pub mod through_time;
pub mod tuning;
mod verdicts;

pub use axis::Axis;

use std::ops::Range;

use crate::explain::pixel::PixelHistory;
use crate::palette::component_on_light;
use crate::regions::Rgb;
use crate::settings::{Rate, Space};

/// The width of a page's text, 180 mm.
pub const WIDE: f64 = 510.0;
/// The width of a column, 88 mm.
pub const NARROW: f64 = 250.0;
/// Text size of axis names and of the legend.
pub const TEXT: f64 = 8.0;
/// Text size of tick labels.
pub const SMALL: f64 = 7.0;
/// Colour of data lines.
pub const INK: Rgb = [20, 22, 26];
/// Colour of axes and of other text.
pub const GRAY: Rgb = [88, 92, 100];

/// Space to the left of panels for tick labels and the axis' name.
const LEFT: f64 = 40.0;
/// Space to the right of panels.
const RIGHT: f64 = 10.0;
/// Space below the lowest panel for tick labels and the axis' name.
const BELOW: f64 = 27.0;
/// Vertical space between panels.
const GAP: f64 = 9.0;

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Width and height in points.
    pub size: [f64; 2],
    /// The title, one line above the figure.
    pub title: String,
    /// The parameters and further metadata; not drawn, stored in the file.
    pub description: String,
    /// The legend.
    pub legend: Vec<Key>,
    /// The panels.
    pub panels: Vec<Panel>,
}

/// An entry of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Its sign.
    pub sign: Sign,
    /// Its colour.
    pub colour: Rgb,
    /// Its meaning.
    pub name: String,
}

impl Key {
    /// An entry.
    pub fn new(sign: Sign, colour: Rgb, name: impl Into<String>) -> Self {
        Self { sign, colour, name: name.into() }
    }
}

/// A sign in the legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// A filled rectangle of this opacity.
    Patch(f64),
    /// A line on a pale rectangle.
    Band,
    /// A line.
    Line,
    /// A dashed line.
    Dashed,
    /// A filled dot.
    Dot,
    /// A ring.
    Ring,
    /// A cross.
    Cross,
}

/// A rectangle with two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// A line of text above it; may be empty.
    pub caption: String,
    /// Left, top, width, height within the figure, in points.
    pub place: [f64; 4],
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The marks, in drawing order.
    pub marks: Vec<Mark>,
    /// Which parts of the axes are drawn.
    pub frame: DrawnAxes,
    /// Whether faint horizontal lines are drawn at the ticks of the vertical axis.
    pub grid: bool,
}

/// Which parts of a panel's axes are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnAxes {
    /// Both axes with tick labels.
    Axes,
    /// Both axes, but tick labels on the vertical one only; those of the horizontal axis are in a lower panel.
    UpOnly,
    /// None.
    None,
}

/// A mark within a panel, in coordinates of its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Its meaning, for readers of the file: `value R`, `weight of rank 1`; empty for decorations of another mark.
    pub name: String,
    /// Its shape.
    pub shape: MarkShape,
    /// Its colour.
    pub colour: Rgb,
    /// Its opacity, 0..=1.
    pub opacity: f64,
}

/// The shape of a mark.
#[derive(Clone, Debug, PartialEq)]
pub enum MarkShape {
    /// A polyline.
    Line {
        /// Its points, from left to right.
        points: Vec<[f64; 2]>,
        /// Its width in points.
        width: f64,
        /// Whether it is dashed.
        dashed: bool,
    },
    /// A filled polygon, given by its outline.
    Area(Vec<[f64; 2]>),
    /// Rectangles, as start x, start y, end x, end y.
    Rects(Vec<[f64; 4]>),
    /// Dots.
    Dots {
        /// Their positions.
        places: Vec<[f64; 2]>,
        /// Their radius in points.
        radius: f64,
        /// Their sign: filled, a ring, or a cross.
        sign: Sign,
    },
    /// A text.
    Text {
        /// The position.
        at: [f64; 2],
        /// The text.
        text: String,
        /// The part of the text at the position.
        anchor: Anchor,
    },
}

/// The part of a text that is at its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

impl Figure {
    /// A figure of this width without panels.
    pub fn new(width: f64, title: String, description: String, legend: Vec<Key>) -> Self {
        let mut figure = Self { size: [width, 0.0], title, description, legend, panels: Vec::new() };
        figure.size[1] = figure.top();
        figure
    }

    /// The top of the panels: below the title and the legend.
    pub fn top(&self) -> f64 {
        let lines = self.legend_places().last().map_or(0, |&(_, line)| line + 1);
        text::LEGEND + lines as f64 * text::LINE + 4.0
    }

    /// For each entry of the legend its start, and the index of its line.
    pub fn legend_places(&self) -> Vec<(f64, usize)> {
        let (mut x, mut line) = (text::MARGIN, 0);
        let mut places = Vec::with_capacity(self.legend.len());
        for key in &self.legend {
            let width = text::SIGN + text::width(&key.name, SMALL);
            if x > text::MARGIN && x + width > self.size[0] - text::MARGIN {
                (x, line) = (text::MARGIN, line + 1);
            }
            places.push((x, line));
            x += width + 10.0;
        }
        places
    }

    /// Adds a column of panels, `(panel, height)`, that share the horizontal axis, as column `column` of `columns`.
    pub fn stack(&mut self, column: usize, columns: usize, panels: Vec<(Panel, f64)>) {
        let each = self.size[0] / columns.max(1) as f64;
        let (left, width) = (each * column as f64 + LEFT, each - LEFT - RIGHT);
        let mut y = self.top();
        let last = panels.len().saturating_sub(1);
        for (at, (mut panel, height)) in panels.into_iter().enumerate() {
            if !panel.caption.is_empty() {
                y += TEXT + 3.0;
            }
            panel.place = [left, y, width, height];
            if at < last && panel.frame == DrawnAxes::Axes {
                panel.frame = DrawnAxes::UpOnly;
            }
            y += height + if at < last { GAP } else { BELOW };
            self.panels.push(panel);
        }
        self.size[1] = self.size[1].max(y);
    }
}

impl Panel {
    /// An empty panel, to be positioned by [`Figure::stack`].
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            caption: String::new(),
            place: [0.0; 4],
            x,
            y,
            marks: Vec::new(),
            frame: DrawnAxes::Axes,
            grid: true,
        }
    }

    /// The position of a value in the figure.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, width, height] = self.place;
        [left + width * self.x.share(x), top + height * (1.0 - self.y.share(y))]
    }

    /// Draws a mark over the existing ones.
    pub fn draw(&mut self, name: impl Into<String>, shape: MarkShape, colour: Rgb, opacity: f64) {
        self.marks.push(Mark { name: name.into(), shape, colour, opacity });
    }

    /// Draws a horizontal line at a value, such as T.
    pub fn draw_horizontal(&mut self, name: &str, y: f64, width: f64, dashed: bool) {
        let (from, to) = self.x.ends;
        self.draw(name, MarkShape::Line { points: vec![[from, y], [to, y]], width, dashed }, INK, 1.0);
    }

    /// Draws a vertical line at a value, such as the frame in view.
    pub fn draw_vertical(&mut self, name: &str, x: f64, width: f64, dashed: bool) {
        let (from, to) = self.y.ends;
        self.draw(name, MarkShape::Line { points: vec![[x, from], [x, to]], width, dashed }, INK, 1.0);
    }

    /// Draws a thin gray line at 0.
    fn draw_ground(&mut self, name: &str) {
        let (from, to) = self.x.ends;
        let points = vec![[from, 0.0], [to, 0.0]];
        self.draw(name, MarkShape::Line { points, width: 0.4, dashed: false }, GRAY, 1.0);
    }

    /// Draws a cross, such as at the current value.
    fn draw_cross(&mut self, name: &str, at: [f64; 2], radius: f64) {
        self.draw(name, MarkShape::Dots { places: vec![at], radius, sign: Sign::Cross }, INK, 1.0);
    }
}

/// `pixel (160, 137)`.
fn pixel_name(history: &PixelHistory) -> String {
    let (x, y) = history.source_pixel();
    format!("pixel ({x}, {y})")
}

/// The number of the frame at a position; 0 beyond the end.
fn number_at(history: &PixelHistory, index: usize) -> u32 {
    history.states.get(index).map_or(0, |state| state.number)
}

/// The ends of frames on an axis: from half a frame before the first number to half a frame after the last.
fn frame_span(history: &PixelHistory, frames: &Range<usize>) -> [f64; 2] {
    let from = f64::from(number_at(history, frames.start)) - 0.5;
    [from, f64::from(number_at(history, frames.end.saturating_sub(1))) + 0.5]
}

/// The parameters of a pixel's mixture in the paper's symbols, so that a figure is reproducible.
pub fn parameters(history: &PixelHistory) -> String {
    let parameters = &history.parameters;
    let rate = match parameters.rate {
        Rate::Density => "ρ = α·η",
        Rate::Weight => "ρ = α/w",
        Rate::Constant => "ρ = α",
    };
    let value = match parameters.space {
        Space::Rgb => "X = (R, G, B)",
        Space::Gray => "X = Y, luma",
    };
    let learnt = match parameters.learnt {
        0 => String::new(),
        frames => format!(", initialised from the first {frames} frames"),
    };
    format!(
        "K = {}, α = {}, T = {}, λ = {}, σ₀ = {}, w₀ = {}, σ_min = {}, {rate}, α ≥ 1/t for t ≤ {}, {value}{learnt}",
        parameters.k,
        parameters.alpha,
        parameters.t,
        parameters.lambda,
        parameters.initial_sigma,
        parameters.initial_weight,
        parameters.min_sigma,
        parameters.warm_up
    )
}

/// The colour of a component on white.
fn component(slot: u8) -> Rgb {
    component_on_light(usize::from(slot))
}

/// A frame axis with these ends.
fn frames_axis(ends: (f64, f64)) -> Axis {
    let whole = axis::ticks(ends.0, ends.1, 8).into_iter().filter(|tick| tick.fract() == 0.0);
    Axis::new("frame", ends, 8).with_ticks(whole.map(|tick| (tick, axis::written(tick))).collect())
}
