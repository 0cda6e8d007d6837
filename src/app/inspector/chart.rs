//! Primitives of the inspector's own plots: axis, ticks, frame, filled columns.

use eframe::egui::{Align2, Color32, Mesh, Painter, Pos2, Rangef, Rect, Shape, Visuals};

use super::style;
pub(super) use crate::export::figure::axis::ticks;

/// Width of the label column on the left of a plot.
pub(super) const GUTTER_WIDTH: f32 = 34.0;
/// Distance between a label and the plot.
pub(super) const LABEL_GAP: f32 = 4.0;
/// Margin on the right of a plot, so that the last tick label stays inside.
pub(super) const RIGHT_MARGIN: f32 = 8.0;
/// Height of a row of tick labels.
pub(super) const TICKS_HEIGHT: f32 = 13.0;

/// A linear map from data to the screen; `screen` may be reversed, as for y.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChartAxis {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) screen: (f32, f32),
}

impl ChartAxis {
    pub(super) fn x(min: f64, max: f64, rect: Rect) -> Self {
        Self { min, max, screen: (rect.left(), rect.right()) }
    }

    pub(super) fn y(min: f64, max: f64, rect: Rect) -> Self {
        Self { min, max, screen: (rect.bottom(), rect.top()) }
    }

    /// The screen position of `value`.
    pub(super) fn at(&self, value: f64) -> f32 {
        let share = (value - self.min) / (self.max - self.min).max(f64::MIN_POSITIVE);
        self.screen.0 + (share as f32) * (self.screen.1 - self.screen.0)
    }

    /// The screen position of `value`, clamped to the ends of the axis.
    pub(super) fn clamped(&self, value: f64) -> f32 {
        self.at(value.clamp(self.min, self.max))
    }

    /// The value at a screen position.
    pub(super) fn value(&self, screen: f32) -> f64 {
        let share = f64::from((screen - self.screen.0) / (self.screen.1 - self.screen.0));
        self.min + share * (self.max - self.min)
    }
}

/// The plot area of a row: without the label column and the right margin.
pub(super) fn inner(row: Rect) -> Rect {
    Rect::from_x_y_ranges(
        Rangef::new(
            row.left() + GUTTER_WIDTH,
            (row.right() - RIGHT_MARGIN).max(row.left() + GUTTER_WIDTH + 1.0),
        ),
        row.y_range(),
    )
}

/// The frame of a small plot: base line and left edge.
pub(super) fn frame(painter: &Painter, rect: Rect, visuals: &Visuals) {
    let stroke = style::faint(visuals);
    painter.hline(rect.x_range(), rect.bottom(), stroke);
    painter.vline(rect.left(), rect.y_range(), stroke);
}

/// Labels on the left of a plot, as `(position, text)`.
pub(super) fn y_labels(painter: &Painter, left: f32, labels: &[(f32, String)], visuals: &Visuals) {
    for (y, label) in labels {
        painter.text(
            Pos2::new(left - LABEL_GAP, *y),
            Align2::RIGHT_CENTER,
            label,
            style::tick_font(),
            style::muted(visuals),
        );
    }
}

/// Tick labels and marks under a plot, as `(position, text)`. A label that would touch its left neighbour is skipped.
pub(super) fn x_labels(painter: &Painter, rect: Rect, labels: &[(f32, String)], visuals: &Visuals) {
    let mut free = f32::NEG_INFINITY;
    for (x, label) in labels {
        painter.vline(*x, Rangef::new(rect.bottom(), rect.bottom() + 3.0), style::faint(visuals));
        let galley = painter.layout_no_wrap(label.clone(), style::tick_font(), style::muted(visuals));
        let width = galley.size().x;
        let left = (x - width / 2.0).min(rect.right() + RIGHT_MARGIN - width);
        if left > free {
            free = left + width + 6.0;
            painter.galley(Pos2::new(left, rect.bottom() + 3.0), galley, style::muted(visuals));
        }
    }
}

/// Many filled rectangles in one shape.
#[derive(Default)]
pub(super) struct Columns(Mesh);

impl Columns {
    pub(super) fn add(&mut self, x: Rangef, y0: f32, y1: f32, colour: Color32) {
        let y = Rangef::new(y0.min(y1), y0.max(y1));
        self.0.add_colored_rect(Rect::from_x_y_ranges(x, y), colour);
    }

    pub(super) fn paint(self, painter: &Painter) {
        if !self.0.is_empty() {
            painter.add(Shape::mesh(self.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_maps_values_to_the_screen_and_back() {
        let rect = Rect::from_min_max(Pos2::new(30.0, 10.0), Pos2::new(330.0, 70.0));
        let axis = ChartAxis::x(0.0, 255.0, rect);
        assert_eq!(axis.at(0.0), 30.0);
        assert_eq!(axis.at(255.0), 330.0);
        assert!((axis.value(axis.at(100.0)) - 100.0).abs() < 1e-3);
        assert_eq!(ChartAxis::y(0.0, 1.0, rect).at(1.0), 10.0);
        assert_eq!(axis.clamped(400.0), 330.0);
    }
}
