//! Shapes that several views draw.

use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Vec2, pos2, vec2,
};

use super::canvas::Canvas;
use crate::app::theme;

/// From this size on, in points, a pixel's value is written into it.
const VALUES_FROM: f32 = 40.0;

/// An outline of dashes.
pub(crate) fn dashed_rect(painter: &Painter, rect: Rect, stroke: Stroke, dash: f32) {
    let corners =
        [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom(), rect.left_top()];
    painter.extend(Shape::dashed_line(&corners, stroke, dash, dash * 0.7));
}

/// An outline with a dark edge, to be seen on any picture.
pub(crate) fn outlined_rect(painter: &Painter, rect: Rect, stroke: Stroke) {
    let edge = Stroke::new(stroke.width + 2.0, Color32::from_black_alpha(110));
    painter.rect_stroke(rect, 1.0, edge, StrokeKind::Middle);
    painter.rect_stroke(rect, 1.0, stroke, StrokeKind::Middle);
}

/// Diagonal lines within a rectangle.
pub(crate) fn hatch(painter: &Painter, rect: Rect, stroke: Stroke, step: f32) {
    let (w, h) = (rect.width(), rect.height());
    let mut along = step;
    while along < w + h {
        let from = rect.min + vec2((along - h).max(0.0), along.min(h));
        let to = rect.min + vec2(along.min(w), (along - w).max(0.0));
        painter.line_segment([from, to], stroke);
        along += step;
    }
}

/// A dotted ellipse with half axes and an angle.
pub(crate) fn ellipse(painter: &Painter, centre: Pos2, axes: Vec2, angle: f32, stroke: Stroke) {
    let turned = |t: f32| {
        let (sin, cos) = angle.sin_cos();
        let (x, y) = (axes.x * t.cos(), axes.y * t.sin());
        centre + vec2(x * cos - y * sin, x * sin + y * cos)
    };
    let points: Vec<Pos2> = (0..=64).map(|step| turned(step as f32 / 64.0 * std::f32::consts::TAU)).collect();
    painter.extend(Shape::dashed_line(&points, stroke, 2.0, 3.0));
}

/// A word on a filled ground, its lower left corner at `at`, kept within `bounds`. Returns its place.
pub(crate) fn tag(painter: &Painter, at: Pos2, text: &str, fill: Color32, bounds: Rect) -> Rect {
    let mut taken = Vec::new();
    free_tag(painter, at, text, fill, bounds, &mut taken)
}

/// The same, a little higher or lower where it would cover what is `taken`; its place is taken from then on.
pub(crate) fn free_tag(
    painter: &Painter,
    at: Pos2,
    text: &str,
    fill: Color32,
    bounds: Rect,
    taken: &mut Vec<Rect>,
) -> Rect {
    let ink = theme::ink_on(fill);
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(theme::MONO), ink);
    let size = galley.size() + vec2(8.0, 2.0);
    let mut rect = Rect::from_min_size(pos2(at.x, at.y - size.y), size);
    let shift = vec2(
        (bounds.left() - rect.left()).max(0.0) - (rect.right() - bounds.right()).max(0.0),
        (bounds.top() - rect.top()).max(0.0) - (rect.bottom() - bounds.bottom()).max(0.0),
    );
    rect = free_place(rect.translate(shift), bounds, taken);
    taken.push(rect);
    painter.rect_filled(rect, 2.0, fill);
    painter.galley(rect.min + vec2(4.0, 1.0), galley, ink);
    rect
}

/// The place nearest to `rect`, above or below, that covers nothing `taken`; itself where a crowd leaves none.
fn free_place(rect: Rect, bounds: Rect, taken: &[Rect]) -> Rect {
    let step = rect.height() / 4.0;
    (0..48)
        .flat_map(|steps| [-step * steps as f32, step * steps as f32])
        .map(|down| rect.translate(vec2(0.0, down)))
        // Tags that merely touch are told apart by their colours.
        .find(|place| bounds.contains_rect(*place) && !taken.iter().any(|t| t.shrink(0.5).intersects(*place)))
        .unwrap_or(rect)
}

/// The cross through the chosen pixel, in all views.
pub(crate) fn cross(painter: &Painter, canvas: &Canvas, pixel: (u32, u32), accent: Color32) {
    let place = canvas.place_pixel(pixel);
    let centre = place.center();
    let gap = (place.width() / 2.0).max(5.0);
    let (view, shadow) =
        (canvas.whole().intersect(canvas.rect), Stroke::new(3.0, Color32::from_black_alpha(60)));
    for stroke in [shadow, Stroke::new(1.0, accent.gamma_multiply(0.6))] {
        painter.hline(view.left()..=centre.x - gap, centre.y, stroke);
        painter.hline(centre.x + gap..=view.right(), centre.y, stroke);
        painter.vline(centre.x, view.top()..=centre.y - gap, stroke);
        painter.vline(centre.x, centre.y + gap..=view.bottom(), stroke);
        let least = Rect::from_center_size(centre, Vec2::splat(2.0 * gap));
        painter.rect_stroke(
            if place.width() > 10.0 { place } else { least },
            0.0,
            stroke,
            StrokeKind::Outside,
        );
    }
}

/// Values written into pixels, where they are large enough.
pub(crate) fn values(
    painter: &Painter,
    canvas: &Canvas,
    value: impl Fn((u32, u32)) -> String,
    ground: impl Fn((u32, u32)) -> Color32,
) {
    if canvas.scale < VALUES_FROM {
        return;
    }
    let font = FontId::monospace((canvas.scale / 5.0).clamp(8.0, 15.0));
    let (columns, rows) = canvas.visible();
    for y in rows {
        for x in columns.clone() {
            let at = (x, y);
            let text = value(at).replace(' ', "\n");
            painter.text(
                canvas.place_pixel(at).center(),
                Align2::CENTER_CENTER,
                text,
                font.clone(),
                theme::ink_on(ground(at)),
            );
        }
    }
}

/// A sentence in the middle of a view that has nothing to show.
pub(crate) fn message(painter: &Painter, canvas: &Canvas, text: &str, colour: Color32) {
    painter.text(
        canvas.rect.center(),
        Align2::CENTER_CENTER,
        text,
        FontId::proportional(theme::BODY),
        colour,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_move_up_or_down_until_they_cover_nothing() {
        let bounds = Rect::from_min_size(Pos2::ZERO, vec2(100.0, 100.0));
        let wanted = Rect::from_min_size(pos2(10.0, 20.0), vec2(30.0, 15.0));
        let mut taken = Vec::new();
        for _ in 0..5 {
            let place = free_place(wanted, bounds, &taken);
            assert!(bounds.contains_rect(place));
            assert!(
                taken.iter().all(|other: &Rect| !other.shrink(0.5).intersects(place)),
                "{place} {taken:?}"
            );
            taken.push(place);
        }
        assert_eq!(taken[0], wanted);
        assert!(taken[1].top() < wanted.top() && taken[2].top() > wanted.top());
    }
}
