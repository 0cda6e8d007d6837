//! The boxes of external results over ours: outlines of black and white dashes, and identities with a number sign.

use eframe::egui::{Color32, Rect, Stroke, StrokeKind, vec2};

use super::draw::{self, OccupiedRects};
use super::pane::Pane;
use crate::app::model::overlays::TrackOverlay;
use crate::regions;

/// The identity and the place of each external box of the frame; none while they are hidden.
fn boxes(pane: &Pane<'_>) -> Vec<(u32, Rect)> {
    let is_shown = pane.model.display.track_overlays.has(TrackOverlay::External);
    let boxes = pane.model.external_boxes().filter(|_| is_shown);
    let of_frame = boxes.and_then(|boxes| boxes.get(&pane.shown.frame.number));
    let placement = pane.model.worker.placement();
    let place = |bounds: [f64; 4]| {
        let [x, y, w, h] =
            placement.map_or(bounds, |placement| placement.frame_box(bounds)).map(|side| side as f32);
        pane.canvas.place(&regions::Rect::new(x, y, w, h))
    };
    of_frame.into_iter().flatten().map(|(&id, bounds)| (id, place(bounds.0))).collect()
}

/// Draws the outlines.
pub(super) fn outlines(pane: &Pane<'_>) {
    for (_, place) in boxes(pane) {
        pane.painter.rect_stroke(place, 0.0, Stroke::new(2.0, Color32::BLACK), StrokeKind::Middle);
        draw::dashed_rect(pane.painter, place, Stroke::new(2.0, Color32::WHITE), 7.0);
    }
}

/// Draws the identities beside the rectangles in `taken`.
pub(super) fn tags(pane: &Pane<'_>, taken: &mut OccupiedRects) {
    for (id, place) in boxes(pane) {
        let foot = place.left_bottom() + vec2(-1.0, 17.0);
        draw::free_tag(
            pane.painter,
            foot,
            &format!("#{id}"),
            Color32::from_gray(16),
            pane.canvas.rect,
            taken,
        );
    }
}
