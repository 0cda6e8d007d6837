//! A loupe beside the pointer: the enlarged surroundings of a pixel, with its value and verdict.

use eframe::egui::{
    Align2, Color32, FontId, Id, LayerId, Order, Pos2, Rect, Stroke, StrokeKind, Ui, Vec2, pos2, vec2,
};

use super::agreement;
use super::composition::Composition;
use super::contents::{content, pixel_value};
use super::pane::Pane;
use crate::app::model::Model;
use crate::app::model::view::View;
use crate::app::theme;
use crate::mixture::Quantity;
use crate::palette::verdict_colour;
use crate::replay::ShownFrame;

/// Side of the loupe, in points.
const LOUPE_SIDE_PT: f32 = 143.0;
/// Magnification relative to the view, before clamping to [`PIXEL_RANGE_PT`].
const LOUPE_ZOOM: f32 = 3.0;
/// Minimum and maximum size of an image pixel in the loupe, in points.
const PIXEL_RANGE_PT: (f32, f32) = (13.0, 47.0);
/// Height of a line of text, in points.
const LINE_HEIGHT_PT: f32 = 15.0;
/// Number of lines of text.
const TEXT_LINES: f32 = 3.0;
/// Distance from the pointer, in points.
const POINTER_DISTANCE: f32 = 22.0;

/// The colour of values.
const VALUE_INK: Color32 = Color32::from_rgb(236, 240, 246);
/// The colour of other text.
const WEAK_INK: Color32 = Color32::from_rgb(170, 178, 190);

/// The loupe's rectangle: below and to the right of the pointer, or on the opposite side at the window's edge.
pub(crate) fn place(pointer: Pos2, window: Rect) -> Rect {
    let size = vec2(LOUPE_SIDE_PT + 8.0, LOUPE_SIDE_PT + TEXT_LINES * LINE_HEIGHT_PT + 12.0);
    let along = |at: f32, size: f32, end: f32| {
        if at + POINTER_DISTANCE + size > end { at - POINTER_DISTANCE - size } else { at + POINTER_DISTANCE }
    };
    let corner = pos2(
        along(pointer.x, size.x, window.right()).max(window.left()),
        along(pointer.y, size.y, window.bottom()).max(window.top()),
    );
    Rect::from_min_size(corner, size)
}

/// The part of the rectangle that shows the image.
pub(crate) fn picture(place: Rect) -> Rect {
    Rect::from_min_size(place.min + Vec2::splat(4.0), Vec2::splat(LOUPE_SIDE_PT))
}

/// Draws the loupe over everything else.
pub(super) fn paint(ui: &Ui, pane: &Pane<'_>, pointer: Pos2, pixel: (u32, u32)) {
    let place = place(pointer, ui.ctx().content_rect());
    let layer = LayerId::new(Order::Tooltip, Id::unique("loupe"));
    let painter = ui.ctx().layer_painter(layer);
    painter.rect(
        place,
        5.0,
        Color32::from_rgb(14, 16, 20),
        (1.0, Color32::from_white_alpha(70)),
        StrokeKind::Inside,
    );
    let picture = picture(place);
    let scale = (pane.canvas.scale * LOUPE_ZOOM).clamp(PIXEL_RANGE_PT.0, PIXEL_RANGE_PT.1);
    let canvas = pane.canvas.around(picture, pixel, scale);
    let inside = painter.with_clip_rect(picture);
    if let Some(style) = content(pane.view).compose_style(pane)
        && let Some(shape) = Composition::loupe(pane.composer, pane.set, style, canvas)
    {
        inside.add(shape);
    }
    let middle = canvas.place_pixel(pixel);
    inside.rect_stroke(
        middle.expand(1.0),
        0.0,
        Stroke::new(3.0, Color32::from_black_alpha(170)),
        StrokeKind::Middle,
    );
    inside.rect_stroke(middle.expand(1.0), 0.0, Stroke::new(1.5, Color32::WHITE), StrokeKind::Middle);

    let mut at = pos2(picture.left() + 2.0, picture.bottom() + 3.0 + LINE_HEIGHT_PT / 2.0);
    for (text, ink) in words(pane.view, pane.model, pane.shown, pixel) {
        painter.text(at, Align2::LEFT_CENTER, text, FontId::monospace(theme::SMALL_TEXT), ink);
        at.y += LINE_HEIGHT_PT;
    }
}

/// The text of the loupe: the pixel's position, its value in the view, and its verdict under the settings of the view.
pub(crate) fn words(
    view: View,
    model: &Model,
    shown: &ShownFrame,
    pixel: (u32, u32),
) -> [(String, Color32); 3] {
    let (x, y) = model.worker.source_pixel(pixel);
    let value = pixel_value(view, model, shown, pixel);
    [(format!("{x}, {y}"), WEAK_INK), (value, VALUE_INK), verdict(view, model, shown, pixel)]
}

fn verdict(view: View, model: &Model, shown: &ShownFrame, pixel: (u32, u32)) -> (String, Color32) {
    let (x, y) = pixel;
    let colour = |foreground| theme::rgb(verdict_colour(foreground, true));
    if shown.roi.as_ref().is_some_and(|roi| !roi.contains(x, y)) {
        return ("ignored".to_owned(), WEAK_INK);
    }
    let shown = match (view, &shown.compared) {
        (View::Agreement, _) => {
            let both = agreement::of_pixel(shown, model.edits.ab_settings.in_view, pixel);
            let where_it_is = both.map(|both| match both {
                [true, true] => "in A and B",
                [true, false] => "in A only",
                [false, true] => "in B only",
                [false, false] => "in neither",
            });
            let text = where_it_is.map_or_else(String::new, |words| format!("foreground {words}"));
            return (text, colour(both.is_some_and(|both| both.contains(&true))));
        }
        (View::ComparedBackground | View::ComparedForeground | View::ComparedTracks, Some(compared)) => {
            compared
        }
        (View::ComparedBackground | View::ComparedForeground | View::ComparedTracks, None) => {
            return (String::new(), WEAK_INK);
        }
        _ => shown,
    };
    let foreground = shown.analysis.mask.is_foreground(x, y);
    let decided = if foreground { "foreground" } else { "background" };
    let text = match matched(model, shown, pixel) {
        Some(0) => format!("{decided}, no match"),
        Some(rank) => format!("{decided}, rank {rank}"),
        None => decided.to_owned(),
    };
    (text, colour(foreground))
}

/// The rank of the component that the pixel's value matched, 0 for none. Known for all pixels while they are mapped,
/// else for the chosen and the pinned pixels.
fn matched(model: &Model, shown: &ShownFrame, pixel: (u32, u32)) -> Option<u8> {
    if let Some(map) = shown.map.as_ref().filter(|map| map.quantity == Quantity::Matched) {
        let index = shown.frame.size.index(pixel.0, pixel.1)?;
        return map.values.get(index).map(|&rank| rank as u8);
    }
    let pins = model.worker.state.as_ref().map_or(&[][..], |state| &state.pins);
    let mut known = shown.pixel.iter().chain(pins);
    let history =
        known.find(|history| history.at == pixel && history.parameters.equal_settings(&shown.settings))?;
    history.states.get(shown.position as usize).map(|state| state.outcome.matched)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loupe_never_covers_the_pointer_nor_leaves_the_window() {
        let window = Rect::from_min_size(Pos2::ZERO, vec2(800.0, 560.0));
        for x in (0..800).step_by(50) {
            for y in (0..560).step_by(40) {
                let pointer = pos2(x as f32, y as f32);
                let place = place(pointer, window);
                assert!(window.contains_rect(place), "{pointer:?} {place:?}");
                assert!(!place.expand(POINTER_DISTANCE - 1.0).contains(pointer), "{pointer:?} {place:?}");
            }
        }
    }
}
