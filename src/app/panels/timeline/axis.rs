//! The map from positions to the screen.

use std::ops::Range;

use eframe::egui::Rect;

use crate::app::model::timeline_span::moved_span;

/// The map from positions to the screen's x axis.
#[derive(Clone, Copy)]
pub(super) struct TimeAxis {
    /// The place on the screen.
    pub(super) rect: Rect,
    /// The number of frames.
    pub(super) frames: u32,
    /// The visible positions, from and to.
    pub(super) span: (f32, f32),
}

impl TimeAxis {
    /// The centre of a position's column.
    pub(super) fn x(&self, position: u32) -> f32 {
        self.edge(position as f32 + 0.5)
    }

    /// The left edge of a position's column.
    pub(super) fn edge(&self, at: f32) -> f32 {
        let (from, to) = self.span;
        self.rect.left() + (at - from) / (to - from).max(1.0) * self.rect.width()
    }

    /// The position under a point.
    pub(super) fn position(&self, x: f32) -> u32 {
        let share = ((x - self.rect.left()) / self.rect.width()).clamp(0.0, 1.0);
        let (from, to) = self.span;
        ((from + share * (to - from)) as u32).min(self.frames.saturating_sub(1))
    }

    /// The visible positions, end excluded.
    pub(super) fn visible(&self) -> Range<u32> {
        self.span.0.floor() as u32..(self.span.1.ceil() as u32).min(self.frames)
    }

    /// The visible positions after zooming around `at` and panning by `by` points; `None` for all.
    pub(super) fn moved(&self, at: f32, zoom: f32, by: f32) -> Option<(f32, f32)> {
        let share = (at - self.rect.left()) / self.rect.width();
        moved_span(self.span, self.frames, share, zoom, by / self.rect.width())
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::{pos2, vec2};

    use super::*;
    use crate::app::model::timeline_span::MIN_SHOWN_FRAMES;

    #[test]
    fn every_position_maps_to_the_screen_and_back() {
        let rect = Rect::from_min_size(pos2(20.0, 0.0), vec2(777.0, 50.0));
        for span in [(0.0, 795.0), (100.0, 180.5), (780.0, 795.0)] {
            let axis = TimeAxis { rect, frames: 795, span };
            for position in span.0 as u32..span.1 as u32 {
                assert_eq!(axis.position(axis.x(position)), position);
            }
            assert_eq!(axis.position(-50.0), span.0 as u32);
            assert_eq!(axis.position(5000.0), (span.1 as u32).min(794));
        }
    }

    #[test]
    fn zooming_keeps_the_position_under_the_pointer_and_never_leaves_the_video() {
        let rect = Rect::from_min_size(pos2(20.0, 0.0), vec2(777.0, 50.0));
        let whole = TimeAxis { rect, frames: 795, span: (0.0, 795.0) };
        let near = TimeAxis { span: whole.moved(300.0, 4.0, 0.0).unwrap_or_default(), ..whole };
        assert_eq!(near.position(300.0), whole.position(300.0));
        assert!((near.span.1 - near.span.0 - 795.0 / 4.0).abs() < 0.01);
        let left = near.moved(300.0, 1.0, 1e6).unwrap_or_default();
        assert_eq!(left.0, 0.0);
        let right = near.moved(300.0, 1.0, -1e6).unwrap_or_default();
        assert_eq!(right.1, 795.0);
        assert_eq!(near.moved(300.0, 0.01, 0.0), None, "all positions are visible");
        let nearest = near.moved(300.0, 1e6, 0.0).unwrap_or_default();
        assert_eq!(nearest.1 - nearest.0, MIN_SHOWN_FRAMES);
        let short = TimeAxis { rect, frames: 3, span: (0.0, 3.0) };
        assert_eq!(short.moved(300.0, 10.0, 0.0), None);
    }
}
