//! Pinned pixels in a view, and the region around the chosen pixel.

use eframe::egui::{Color32, Painter, Rect, Stroke, Vec2, vec2};

use super::canvas::ViewCanvas;
use super::draw;
use crate::app::model::Model;
use crate::app::model::pins::{self, Pins};
use crate::app::theme;
use crate::explain::pixel::region_shares::region_bounds;
use crate::regions;

/// Minimum size of an image pixel for a frame around it, in points.
const MIN_FRAMED_PIXEL_PT: f32 = 8.0;
/// Radius of the ring around a smaller pixel, in points.
const RING_RADIUS_PT: f32 = 4.5;

/// Draws the pins and the region.
pub(super) fn paint(painter: &Painter, canvas: &ViewCanvas, model: &Model) {
    let judged = model.worker.sent.accuracy_region.filter(|_| model.has_true_masks());
    if let Some(region) = model.worker.sent.shares_region.or(judged).filter(|region| region.side > 1) {
        let (columns, rows) = region_bounds(region.centre, region.side, canvas.size);
        let (width, height) = (columns.len() as f32, rows.len() as f32);
        let place = canvas.place(&regions::Rect::new(columns.start as f32, rows.start as f32, width, height));
        draw::dashed_rect(painter, place, Stroke::new(3.0, Color32::from_black_alpha(90)), 4.0);
        draw::dashed_rect(painter, place, Stroke::new(1.0, Color32::WHITE), 4.0);
    }
    pinned(painter, canvas, &model.playback.marks.pins);
}

/// A mark around each pinned pixel, with its number.
fn pinned(painter: &Painter, canvas: &ViewCanvas, pins: &Pins) {
    for (number, (x, y)) in pins.iter().filter(|(_, (x, y))| canvas.size.index(*x, *y).is_some()) {
        let place = canvas.place_pixel((x, y));
        let mark = Rect::from_center_size(place.center(), Vec2::splat(2.0 * RING_RADIUS_PT));
        let mark = if canvas.scale >= MIN_FRAMED_PIXEL_PT { place } else { mark };
        if !canvas.rect.intersects(mark) {
            continue;
        }
        let colour = theme::pin_colour(number);
        if canvas.scale >= MIN_FRAMED_PIXEL_PT {
            draw::outlined_rect(painter, mark, Stroke::new(2.0, colour));
        } else {
            painter.circle_stroke(
                mark.center(),
                RING_RADIUS_PT,
                Stroke::new(4.0, Color32::from_black_alpha(140)),
            );
            painter.circle_stroke(mark.center(), RING_RADIUS_PT, Stroke::new(2.0, colour));
        }
        draw::tag(painter, mark.right_top() + vec2(1.0, -1.0), &pins::name(number), colour, canvas.rect);
    }
}
