//! Foreground ratio, camera motion and light over time, and the analysis progress.

use eframe::egui::{Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke, pos2};

use super::axis::TimeAxis;
use crate::app::theme;
use crate::registration::{Alignment, Motion};
use crate::replay::Timeline;

/// Height of the bar of the analysis progress, in points.
pub(super) const PROGRESS_HEIGHT: f32 = 3.0;

/// The foreground ratio of the image, as a curve in the background.
pub(super) fn draw_foreground(
    painter: &Painter,
    timeline: &Timeline,
    axis: &TimeAxis,
    ground: Rect,
    colour: Color32,
) {
    let shares = &timeline.foreground_share;
    let most = shares.iter().copied().fold(0.01_f32, f32::max);
    let columns = (ground.width() as u32).max(1);
    let per_column = f64::from(axis.span.1 - axis.span.0) / f64::from(columns);
    let mut points: Vec<Pos2> = Vec::new();
    if per_column <= 1.0 {
        let seen = axis.visible();
        // One more position on either side extends the curve to the edges.
        for position in seen.start.saturating_sub(1)..seen.end.saturating_add(1) {
            let Some(share) = shares.get(position as usize) else { break };
            points.push(pos2(axis.x(position), height_of(*share, most, ground)));
        }
    } else {
        for column in 0..columns {
            let from = f64::from(axis.span.0);
            let first = (from + f64::from(column) * per_column) as usize;
            let last = ((from + f64::from(column + 1) * per_column) as usize).max(first + 1);
            let Some(part) = shares.get(first..last.min(shares.len())).filter(|part| !part.is_empty()) else {
                break;
            };
            // The maximum of a column: an average would hide a short burst.
            let share = part.iter().copied().fold(0.0, f32::max);
            points.push(pos2(ground.left() + column as f32 + 0.5, height_of(share, most, ground)));
        }
    }
    let mut area = Mesh::default();
    for point in &points {
        area.colored_vertex(*point, colour.gamma_multiply(0.28));
        area.colored_vertex(pos2(point.x, ground.bottom()), colour.gamma_multiply(0.10));
    }
    for pair in 0..points.len().saturating_sub(1) as u32 {
        area.add_triangle(2 * pair, 2 * pair + 1, 2 * pair + 2);
        area.add_triangle(2 * pair + 1, 2 * pair + 2, 2 * pair + 3);
    }
    painter.add(Shape::mesh(area));
    painter.add(Shape::line(points, Stroke::new(1.0, colour.gamma_multiply(0.7))));
}

/// Minimum motion that fills the plot, in pixels.
const MIN_MOTION_SCALE_PX: f32 = 3.0;

/// Minimum change of illumination that fills the plot, as a ratio.
const MIN_LIGHT_SCALE: f32 = 0.3;

/// The camera's displacement from its reference, and the change of illumination relative to the recent past: one line
/// each, if there is anything to show.
pub(super) fn draw_alignments(
    painter: &Painter,
    timeline: &Timeline,
    axis: &TimeAxis,
    ground: Rect,
    colours: &theme::Colours,
) {
    type Number = fn(&Alignment) -> f32;
    let lines: [(Number, f32, Color32); 2] =
        [(motion_of, MIN_MOTION_SCALE_PX, colours.accent), (light_of, MIN_LIGHT_SCALE, colours.warn)];
    for (number, least, colour) in lines {
        let most = timeline.alignments.iter().map(number).fold(0.0, f32::max);
        if most == 0.0 {
            continue;
        }
        let seen = axis.visible();
        let columns = ground.width().max(1.0) as u32;
        let step = (seen.len() as u32 / columns).max(1);
        let mut points = Vec::new();
        for first in seen.step_by(step as usize) {
            let last = (first + step) as usize;
            let last = last.min(timeline.alignments.len());
            let Some(part) = timeline.alignments.get(first as usize..last).filter(|part| !part.is_empty())
            else {
                break;
            };
            let value = part.iter().map(number).fold(0.0, f32::max);
            points.push(pos2(axis.x(first), height_of(value, most.max(least), ground)));
        }
        // Fainter than the tracks, which it may overlap.
        painter.add(Shape::line(points, Stroke::new(1.0, colour.gamma_multiply(0.4))));
    }
}

fn motion_of(alignment: &Alignment) -> f32 {
    let rest = alignment.rest.unwrap_or_default();
    Motion { dx: alignment.motion.dx - rest.dx, dy: alignment.motion.dy - rest.dy, ..Motion::NONE }.length()
}

fn light_of(alignment: &Alignment) -> f32 {
    (alignment.light.luma_gain() - 1.0).abs()
}

/// Motion and illumination change of a frame in words, if there are any.
pub(super) fn alignment_words(alignment: &Alignment) -> Option<String> {
    let rest = alignment.rest.unwrap_or_default();
    let (dx, dy) = (alignment.motion.dx - rest.dx, alignment.motion.dy - rest.dy);
    let moved = (motion_of(alignment) > 0.0).then(|| format!("camera {dx:+.1}, {dy:+.1} px"));
    let light = (light_of(alignment) > 0.0).then(|| format!("light gain {:.2}", alignment.light.luma_gain()));
    let words: Vec<_> = [moved, light].into_iter().flatten().collect();
    (!words.is_empty()).then(|| words.join(", "))
}

fn height_of(share: f32, most: f32, ground: Rect) -> f32 {
    ground.bottom() - PROGRESS_HEIGHT - share / most * (ground.height() - PROGRESS_HEIGHT - 4.0)
}

/// The analysis progress; brighter where decoded frames are cached, too.
pub(super) fn draw_progress(
    painter: &Painter,
    timeline: &Timeline,
    axis: &TimeAxis,
    ground: Rect,
    colours: &theme::Colours,
) {
    let part = |from: u32, to: u32, colour: Color32| {
        let x = |at: u32| axis.edge(at as f32).clamp(axis.rect.left(), axis.rect.right());
        let rect =
            Rect::from_x_y_ranges(x(from)..=x(to), ground.bottom() - PROGRESS_HEIGHT..=ground.bottom());
        painter.rect_filled(rect, 0.0, colour);
    };
    part(0, timeline.analysed, colours.accent.gamma_multiply(0.4));
    for &(first, last) in &timeline.decoded {
        let known = first < timeline.analysed;
        let colour = if known { colours.accent } else { colours.weak.gamma_multiply(0.6) };
        part(first, last + 1, colour);
    }
}
