//! Outlines of the areas to analyse or to ignore, and of the area that is being drawn.

use eframe::egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Vec2};

use super::canvas::ViewCanvas;
use super::draw;
use crate::app::model::areas::Areas;
use crate::app::theme;
use crate::regions::roi::{Area, Purpose};

/// A click within this distance of the first corner closes the area, in points.
const CLOSING_REACH_PT: f32 = 9.0;

/// Draws the areas. `pointer` is the position of the next corner, `drag` the start of a rectangle.
pub(super) fn paint(
    painter: &Painter,
    canvas: &ViewCanvas,
    areas: &Areas,
    pointer: Option<Pos2>,
    drag: Option<Pos2>,
) {
    for (place, area) in areas.drawn.iter().enumerate() {
        let chosen = areas.chosen == Some(place);
        let points = corners(canvas, area);
        line(painter, &points, theme::area_colour(area.purpose), if chosen { 2.5 } else { 1.5 }, true);
        if chosen {
            for at in points {
                handle(painter, at, theme::area_colour(area.purpose));
            }
        }
    }
    let Some(draft) = &areas.draft else { return };
    let colour = theme::area_colour(draft.purpose);
    if let Some((from, to)) = drag.zip(pointer) {
        let rect = Rect::from_two_pos(from, to);
        let points = [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom()];
        line(painter, &points, colour, 2.0, true);
        return;
    }
    let mut points = corners(canvas, draft);
    for (place, at) in points.iter().enumerate() {
        let closes = place == 0 && pointer.is_some_and(|pointer| closes(canvas, draft, pointer));
        handle(painter, *at, if closes { Color32::WHITE } else { colour });
    }
    if !points.is_empty() {
        points.extend(pointer);
        line(painter, &points, colour, 2.0, false);
        if points.len() > 2 {
            painter.extend(Shape::dashed_line(
                &[points[points.len() - 1], points[0]],
                Stroke::new(1.0, colour),
                4.0,
                4.0,
            ));
        }
    }
}

/// A hint on drawing at the bottom of the view.
pub(super) fn hint(painter: &Painter, canvas: &ViewCanvas, draft: &Area) {
    let what = match draft.purpose {
        Purpose::Analyse => "Analysis area",
        Purpose::Ignore => "Ignore area",
    };
    let text =
        format!("{what}: click corners, close with Enter or double click; drag for a rectangle; Esc cancels");
    draw::note(painter, canvas, text);
}

/// Whether a click here closes the area.
pub(super) fn closes(canvas: &ViewCanvas, draft: &Area, at: Pos2) -> bool {
    draft.corners.len() > 2 && canvas.screen(draft.corners[0]).distance(at) < CLOSING_REACH_PT
}

fn corners(canvas: &ViewCanvas, area: &Area) -> Vec<Pos2> {
    area.corners.iter().map(|&corner| canvas.screen(corner)).collect()
}

fn line(painter: &Painter, points: &[Pos2], colour: Color32, width: f32, closed: bool) {
    for stroke in [Stroke::new(width + 2.0, Color32::from_black_alpha(130)), Stroke::new(width, colour)] {
        let points = points.to_vec();
        painter.add(if closed { Shape::closed_line(points, stroke) } else { Shape::line(points, stroke) });
    }
}

fn handle(painter: &Painter, at: Pos2, colour: Color32) {
    let square = Rect::from_center_size(at, Vec2::splat(7.0));
    painter.rect_filled(square.expand(1.0), 1.0, Color32::from_black_alpha(160));
    painter.rect_filled(square, 1.0, colour);
}
