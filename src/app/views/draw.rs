//! Shapes that several views draw.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use eframe::egui::{
    Align2, Color32, FontId, Mesh, Painter, Pos2, Rangef, Rect, Shape, Stroke, StrokeKind, Vec2, pos2, vec2,
};

use super::canvas::ViewCanvas;
use crate::app::theme;

/// Width over which an edge fades, in points.
const FEATHER_PT: f32 = 1.0;

/// The message of a view that needs a mixture.
pub(crate) const NO_MIXTURE: &str = "No mixture in this background model.";

/// Minimum size of an image pixel for showing its value, in points.
const MIN_VALUES_PIXEL_PT: f32 = 40.0;

/// A dashed outline. Dashes outside the view are not created: an outline much larger than the view has very many.
pub(crate) fn dashed_rect(painter: &Painter, rect: Rect, stroke: Stroke, dash: f32) {
    painter.extend(dashes(rect, painter.clip_rect().expand(stroke.width), stroke, dash));
}

fn dashes(rect: Rect, seen: Rect, stroke: Stroke, dash: f32) -> Vec<Shape> {
    let gap = dash * 0.7;
    // From the first visible dash to the last.
    let part = |range: Rangef, seen: Rangef| {
        let before = ((seen.min - range.min).max(0.0) / (dash + gap)).floor() * (dash + gap);
        Rangef::new(range.min + before, range.max.min(seen.max))
    };
    let (across, up) = (part(rect.x_range(), seen.x_range()), part(rect.y_range(), seen.y_range()));
    if !rect.is_finite() || across.span() < 0.0 || up.span() < 0.0 {
        return Vec::new();
    }
    let rows = [rect.top(), rect.bottom()].into_iter().filter(|y| seen.y_range().contains(*y));
    let columns = [rect.left(), rect.right()].into_iter().filter(|x| seen.x_range().contains(*x));
    let rows = rows.map(|y| [pos2(across.min, y), pos2(across.max, y)]);
    let columns = columns.map(|x| [pos2(x, up.min), pos2(x, up.max)]);
    rows.chain(columns).flat_map(|side| Shape::dashed_line(&side, stroke, dash, gap)).collect()
}

/// A legend of colours on a dark plate in the lower left corner, if the view has space for it.
pub(crate) fn legend(painter: &Painter, view: Rect, rows: &[([u8; 3], String)]) {
    let font = FontId::proportional(theme::SMALL_TEXT);
    let ink = Color32::from_rgb(228, 232, 238);
    let texts: Vec<_> =
        rows.iter().map(|(_, text)| painter.layout_no_wrap(text.clone(), font.clone(), ink)).collect();
    let wide = texts.iter().map(|text| text.size().x).fold(0.0, f32::max) + 30.0;
    let size = vec2(wide, 16.0 * rows.len() as f32 + 8.0);
    if size.x > view.width() * 0.8 || size.y > view.height() * 0.5 {
        return;
    }
    let corner = view.left_bottom() + vec2(6.0, -6.0 - size.y);
    painter.rect_filled(Rect::from_min_size(corner, size), 4.0, Color32::from_black_alpha(190));
    for (row, ((colour, _), text)) in rows.iter().zip(texts).enumerate() {
        let middle = corner.y + 12.0 + 16.0 * row as f32;
        let swatch = Rect::from_center_size(pos2(corner.x + 13.0, middle), vec2(10.0, 10.0));
        let rim = Stroke::new(1.0, Color32::from_white_alpha(90));
        painter.rect(swatch, 2.0, theme::rgb(*colour), rim, StrokeKind::Inside);
        let at = Align2::LEFT_CENTER.anchor_size(pos2(corner.x + 24.0, middle), text.size()).min;
        painter.galley(at, text, ink);
    }
}

/// An outline with a dark edge, visible on any image.
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

/// Adds a dotted ellipse with semi-axes and an angle to a mesh.
pub(crate) fn add_ellipse(
    mesh: &mut Mesh,
    centre: Pos2,
    axes: Vec2,
    angle: f32,
    pixel: Vec2,
    stroke: Stroke,
) {
    let (sin, cos) = angle.sin_cos();
    let turned = |t: f32| {
        let (x, y) = (axes.x * t.cos(), axes.y * t.sin());
        centre + vec2(x * cos - y * sin, x * sin + y * cos) * pixel
    };
    // Dots of three points with gaps of two and a half.
    let dots = (std::f32::consts::TAU * (axes.length() * pixel.y) / 2.0_f32.sqrt() / 5.5).round().max(6.0);
    let part = std::f32::consts::TAU / dots;
    for dot in 0..dots as u32 {
        let (from, to) = (turned(dot as f32 * part), turned((dot as f32 + 0.55) * part));
        let across = (to - from).normalized().rot90();
        add_column(mesh, from, across, stroke.color, stroke.width, false);
        add_column(mesh, to, across, stroke.color, stroke.width, true);
    }
}

/// Adds a line with a colour per point and antialiased edges to a mesh. Segments shorter than 1.5 points are merged.
///
/// The trails of a crowd have thousands of segments; one shape for each would be tessellated anew in every frame.
pub(crate) fn add_line(mesh: &mut Mesh, points: impl Iterator<Item = (Pos2, Color32)>, width: f32) {
    let mut line: Vec<(Pos2, Color32)> = Vec::new();
    for (at, colour) in points.filter(|(at, _)| at.is_finite()) {
        match line.last_mut() {
            Some(last) if last.0.distance_sq(at) < 1.5 * 1.5 => last.1 = colour,
            _ => line.push((at, colour)),
        }
    }
    let mut before = None;
    for (index, &(at, colour)) in line.iter().enumerate() {
        let after = line.get(index + 1).map(|(next, _)| (*next - at).normalized());
        let (Some(into), Some(out)) = (before.or(after), after.or(before)) else { return };
        let along = (into + out).normalized();
        // Wider at a bend, so that the line keeps its width; limited where it turns back.
        let across = if along == Vec2::ZERO { out.rot90() } else { along.rot90() / along.dot(out).max(0.5) };
        add_column(mesh, at, across, colour, width, index > 0);
        before = after;
    }
}

/// Adds the vertices across a line at one of its points, and, where `on`, the segment from the previous vertices.
fn add_column(mesh: &mut Mesh, at: Pos2, across: Vec2, colour: Color32, width: f32, on: bool) {
    let inside = (width - FEATHER_PT).max(0.0) / 2.0;
    let outside = inside + FEATHER_PT;
    let first = mesh.vertices.len() as u32;
    mesh.colored_vertex(at - across * outside, Color32::TRANSPARENT);
    mesh.colored_vertex(at - across * inside, colour);
    mesh.colored_vertex(at + across * inside, colour);
    mesh.colored_vertex(at + across * outside, Color32::TRANSPARENT);
    if on {
        for corner in first..first + 3 {
            mesh.add_triangle(corner - 4, corner - 3, corner);
            mesh.add_triangle(corner - 3, corner, corner + 1);
        }
    }
}

/// A text on a filled background with its lower left corner at `at`, kept within `bounds`. Returns its rectangle.
pub(crate) fn tag(painter: &Painter, at: Pos2, text: &str, fill: Color32, bounds: Rect) -> Rect {
    let mut taken = OccupiedRects::default();
    free_tag(painter, at, text, fill, bounds, &mut taken)
}

/// A tag, moved up or down where it would overlap a rectangle in `taken`. Adds its rectangle to `taken`.
pub(crate) fn free_tag(
    painter: &Painter,
    at: Pos2,
    text: &str,
    fill: Color32,
    bounds: Rect,
    taken: &mut OccupiedRects,
) -> Rect {
    let ink = theme::ink_on(fill);
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(theme::MONO_TEXT), ink);
    let size = galley.size() + vec2(8.0, 2.0);
    let mut rect = Rect::from_min_size(pos2(at.x, at.y - size.y), size);
    let shift = vec2(
        (bounds.left() - rect.left()).max(0.0) - (rect.right() - bounds.right()).max(0.0),
        (bounds.top() - rect.top()).max(0.0) - (rect.bottom() - bounds.bottom()).max(0.0),
    );
    rect = free_place(rect.translate(shift), bounds, taken);
    taken.add(rect);
    painter.rect_filled(rect, 2.0, fill);
    painter.galley(rect.min + vec2(4.0, 1.0), galley, ink);
    rect
}

/// Occupied rectangles, indexed by horizontal bands of the window, because a crowd has hundreds of tags.
#[derive(Default)]
pub(crate) struct OccupiedRects(HashMap<i32, Vec<Rect>>);

/// Height of a band, in points: about the height of a tag.
const BAND_HEIGHT_PT: f32 = 24.0;

impl OccupiedRects {
    fn bands(rect: Rect) -> RangeInclusive<i32> {
        (rect.top() / BAND_HEIGHT_PT).floor() as i32..=(rect.bottom() / BAND_HEIGHT_PT).floor() as i32
    }

    /// Adds an occupied rectangle.
    pub(crate) fn add(&mut self, rect: Rect) {
        for band in Self::bands(rect) {
            self.0.entry(band).or_default().push(rect);
        }
    }

    /// Whether a rectangle overlaps no occupied one. Tags may touch: their colours separate them.
    pub(crate) fn is_free(&self, rect: Rect) -> bool {
        let near = Self::bands(rect).filter_map(|band| self.0.get(&band)).flatten();
        !near.into_iter().any(|other| other.shrink(0.5).intersects(rect))
    }
}

/// The rectangle nearest to `rect`, above or below, that overlaps nothing in `taken`; `rect` itself if there is none.
fn free_place(rect: Rect, bounds: Rect, taken: &OccupiedRects) -> Rect {
    let step = rect.height() / 4.0;
    (0..48)
        .flat_map(|steps| [-step * steps as f32, step * steps as f32])
        .map(|down| rect.translate(vec2(0.0, down)))
        .find(|place| bounds.contains_rect(*place) && taken.is_free(*place))
        .unwrap_or(rect)
}

/// A cross through the chosen pixel, drawn in all views.
pub(crate) fn cross(painter: &Painter, canvas: &ViewCanvas, pixel: (u32, u32), accent: Color32) {
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

/// The values of pixels, drawn into them where they are large enough.
pub(crate) fn values(
    painter: &Painter,
    canvas: &ViewCanvas,
    value: impl Fn((u32, u32)) -> String,
    ground: impl Fn((u32, u32)) -> Color32,
) {
    let side = canvas.pixel_size().min_elem();
    if side < MIN_VALUES_PIXEL_PT {
        return;
    }
    let font = FontId::monospace((side / 5.0).clamp(8.0, 15.0));
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

/// A note on a dark plate at the bottom of a view.
pub(super) fn note(painter: &Painter, canvas: &ViewCanvas, text: String) {
    let ink = Color32::from_rgb(236, 240, 246);
    let wrap = canvas.rect.width() - 24.0;
    let galley = painter.layout(text, FontId::proportional(theme::MONO_TEXT), ink, wrap.max(40.0));
    let size = galley.size() + vec2(16.0, 8.0);
    let plate =
        Rect::from_center_size(pos2(canvas.rect.center().x, canvas.rect.bottom() - 8.0 - size.y / 2.0), size);
    painter.rect_filled(plate, 4.0, Color32::from_black_alpha(200));
    painter.galley(plate.min + vec2(8.0, 4.0), galley, ink);
}

/// A message in the middle of an empty view.
pub(crate) fn message(painter: &Painter, canvas: &ViewCanvas, text: &str, colour: Color32) {
    painter.text(
        canvas.rect.center(),
        Align2::CENTER_CENTER,
        text,
        FontId::proportional(theme::BODY_TEXT),
        colour,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_visible_dashes_are_created() {
        let seen = Rect::from_min_size(pos2(100.0, 50.0), vec2(800.0, 600.0));
        let stroke = Stroke::new(1.5, Color32::WHITE);
        let whole = |rect: Rect| dashes(rect, Rect::EVERYTHING, stroke, 4.0);
        let inside = Rect::from_min_size(pos2(300.0, 200.0), vec2(90.0, 60.0));
        assert_eq!(dashes(inside, seen, stroke, 4.0), whole(inside));
        // A side that crosses the view has its dashes at the same places as in the whole outline.
        let across = Rect::from_min_size(pos2(-500.0, 100.0), vec2(5000.0, 90.0));
        let (some, all) = (dashes(across, seen, stroke, 4.0), whole(across));
        assert!(some.len() < 260 && some.len() > 200, "{}", some.len());
        let start = |dash: &Shape| match dash {
            Shape::LineSegment { points, .. } => points[0],
            _ => Pos2::ZERO,
        };
        let apart =
            some.iter().filter(|dash| !all.iter().any(|other| start(other).distance(start(dash)) < 0.1));
        assert_eq!(apart.count(), 0);
        for huge in [
            Rect::from_min_size(pos2(200.0, 100.0), vec2(1e9, 1e9)),
            Rect::from_min_size(pos2(-1e9, -1e9), vec2(2e9, 2e9)),
            Rect::from_min_size(pos2(0.0, 0.0), vec2(f32::INFINITY, f32::NAN)),
        ] {
            assert!(dashes(huge, seen, stroke, 4.0).len() < 300);
        }
        let beyond = Rect::from_min_size(pos2(2000.0, 100.0), vec2(50.0, 50.0));
        assert_eq!(dashes(beyond, seen, stroke, 4.0), []);
    }

    #[test]
    fn tags_move_up_or_down_until_they_overlap_nothing() {
        let bounds = Rect::from_min_size(Pos2::ZERO, vec2(100.0, 100.0));
        let wanted = Rect::from_min_size(pos2(10.0, 20.0), vec2(30.0, 15.0));
        let (mut taken, mut places) = (OccupiedRects::default(), Vec::new());
        for _ in 0..5 {
            let place = free_place(wanted, bounds, &taken);
            assert!(bounds.contains_rect(place));
            assert!(
                places.iter().all(|other: &Rect| !other.shrink(0.5).intersects(place)),
                "{place} {places:?}"
            );
            taken.add(place);
            places.push(place);
        }
        assert_eq!(places[0], wanted);
        assert!(places[1].top() < wanted.top() && places[2].top() > wanted.top());
    }

    #[test]
    fn a_line_keeps_its_width_where_it_bends_and_is_finite_where_it_turns_back() {
        let mut mesh = Mesh::default();
        let points = [[0.0, 0.0], [0.1, 0.0], [10.0, 0.0], [10.0, 10.0], [10.0, 2.0]];
        let points = points.map(|[x, y]| (pos2(x, y), Color32::WHITE));
        add_line(&mut mesh, points.into_iter(), 2.0);
        assert!(mesh.is_valid());
        assert_eq!(mesh.vertices.len(), 16, "close points are merged");
        assert!(mesh.vertices.iter().all(|vertex| vertex.pos.x.is_finite() && vertex.pos.y.is_finite()));
        // The outer corner of the bend is as far out as both edges.
        let corner = mesh.vertices[4..8].iter().map(|v| v.pos).find(|p| p.x > 10.1 && p.y < -0.1).unwrap();
        assert!((corner - pos2(10.5, -0.5)).length() < 0.01, "{corner:?}");
    }
}
