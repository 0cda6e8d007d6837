//! Frame numbers, bookmarks, events and the playhead.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

use super::axis::TimeAxis;
use crate::app::model::Model;
use crate::app::model::event_comparison::EventRef;
use crate::app::theme;
use crate::occlusion::EventKind;
use crate::palette::event_colour;
use crate::replay::Timeline;

/// Height of the row of event marks, in points.
pub(super) const EVENT_ROW_HEIGHT: f32 = 16.0;

/// Height of the row of frame numbers, in points.
pub(super) const NUMBER_ROW_HEIGHT: f32 = 14.0;

/// The playback range, the bookmarks, and the visible part of the whole.
pub(super) fn draw_marks(
    painter: &Painter,
    model: &Model,
    axis: &TimeAxis,
    ground: Rect,
    colours: &theme::Colours,
) {
    let marks = &model.playback.marks;
    for (place, outside) in [
        (marks.start.map(|start| axis.edge(start as f32)), ground.left() - 8.0),
        (marks.end.map(|end| axis.edge(end as f32 + 1.0)), ground.right() + 8.0),
    ] {
        let Some(x) = place else { continue };
        let away = Rect::from_x_y_ranges(x.min(outside)..=x.max(outside), ground.y_range());
        painter.rect_filled(away, 0.0, colours.panel.gamma_multiply(0.72));
        painter.vline(x, ground.y_range(), Stroke::new(2.0, colours.good));
    }
    for &bookmark in &marks.bookmarks {
        let (x, top) = (axis.x(bookmark), axis.rect.top() + NUMBER_ROW_HEIGHT - 2.0);
        painter.vline(x, top..=ground.bottom(), Stroke::new(1.0, colours.warn.gamma_multiply(0.6)));
        let flag = vec![pos2(x, top), pos2(x + 7.0, top + 3.5), pos2(x, top + 7.0)];
        painter.add(Shape::convex_polygon(flag, colours.warn, Stroke::NONE));
    }
    if model.panels.timeline_span.is_some() {
        let all = axis.frames as f32;
        let x = |at: f32| ground.left() + at / all * ground.width();
        let bar = Rect::from_x_y_ranges(x(axis.span.0)..=x(axis.span.1), ground.top()..=ground.top() + 2.0);
        painter.rect_filled(bar, 1.0, colours.weak);
    }
}

/// Frame numbers at round intervals.
pub(super) fn draw_numbers(
    painter: &Painter,
    model: &Model,
    axis: &TimeAxis,
    row: Rect,
    text: Color32,
    line: Color32,
) {
    let labels = (axis.rect.width() / 70.0).max(1.0);
    let rough = ((axis.span.1 - axis.span.0) / labels).max(1.0);
    let power = 10_f32.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough);
    let step = (step.unwrap_or(power * 10.0) as u32).max(1);
    let seen = axis.visible();
    let mut position = seen.start / step * step + step - 1;
    while position < seen.end {
        let x = axis.x(position);
        let label = model.worker.number(position).to_string();
        let font = FontId::proportional(theme::SMALL_TEXT);
        // A number under the playhead's own label would be unreadable.
        if x < axis.rect.right() - 12.0 && (x - axis.x(model.worker.position())).abs() > 26.0 {
            painter.text(pos2(x, row.center().y), Align2::CENTER_CENTER, label, font, text);
        }
        painter.vline(x, row.bottom()..=axis.rect.bottom(), Stroke::new(1.0, line.gamma_multiply(0.5)));
        position += step;
    }
}

pub(super) fn draw_events(painter: &Painter, model: &Model, timeline: &Timeline, axis: &TimeAxis, row: Rect) {
    for (index, (position, event)) in timeline.events.iter().enumerate() {
        if !model.events.lists(event.kind) {
            continue;
        }
        let read = model.selection.event == Some(EventRef::InView(index));
        let colour = theme::rgb(event_colour(event.kind));
        draw_event(
            painter,
            pos2(axis.x(*position), row.center().y),
            event.kind,
            colour,
            if read { 6.0 } else { 4.0 },
        );
    }
}

/// A shape as well as a colour for each kind: down for merging, up for splitting, rings for disappearing or
/// reappearing, dots for start or end.
fn draw_event(painter: &Painter, at: Pos2, kind: EventKind, colour: Color32, size: f32) {
    let edge = Stroke::new(1.0, Color32::from_black_alpha(140));
    match kind {
        EventKind::Merge | EventKind::Demerge => {
            let tip = if kind == EventKind::Merge { size } else { -size };
            let points = vec![at + vec2(-size, -tip), at + vec2(size, -tip), at + vec2(0.0, tip)];
            painter.add(Shape::convex_polygon(points, colour, edge));
        }
        EventKind::Disappear => {
            painter.circle_stroke(at, size - 0.5, Stroke::new(2.0, colour));
        }
        EventKind::Reappear => {
            painter.circle(at, size, colour, edge);
        }
        EventKind::Appear => {
            let points = vec![
                at + vec2(0.0, -size),
                at + vec2(size, 0.0),
                at + vec2(0.0, size),
                at + vec2(-size, 0.0),
            ];
            painter.add(Shape::convex_polygon(points, colour, edge));
        }
        EventKind::Enter | EventKind::Exit => {
            let bar = Rect::from_center_size(at, vec2(2.0, size * 1.6));
            painter.rect_filled(bar, 0.0, colour);
        }
    }
}

/// The listed event whose mark is under the pointer.
pub(super) fn nearest_event(
    model: &Model,
    timeline: &Timeline,
    axis: &TimeAxis,
    row: Rect,
    at: Pos2,
) -> Option<usize> {
    if !row.expand(2.0).contains(at) {
        return None;
    }
    timeline
        .events
        .iter()
        .enumerate()
        .filter(|(_, (_, event))| model.events.lists(event.kind))
        .map(|(index, (position, _))| (index, (axis.x(*position) - at.x).abs()))
        .filter(|(_, distance)| *distance < 6.0)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

pub(super) fn draw_playhead(
    painter: &Painter,
    model: &Model,
    axis: &TimeAxis,
    accent: Color32,
    ink: Color32,
) {
    let position = model.worker.position();
    let x = axis.x(position);
    painter.vline(x, axis.rect.top() + NUMBER_ROW_HEIGHT..=axis.rect.bottom(), Stroke::new(2.0, accent));
    let number = model.worker.number(position).to_string();
    let galley = painter.layout_no_wrap(number, FontId::proportional(theme::SMALL_TEXT), ink);
    let size = galley.size() + vec2(10.0, 1.0);
    let left = (x - size.x / 2.0)
        .clamp(axis.rect.left() - 8.0, (axis.rect.right() + 8.0 - size.x).max(axis.rect.left()));
    let plate = Rect::from_min_size(pos2(left, axis.rect.top()), size);
    painter.rect_filled(plate, 3.0, accent);
    painter.galley(plate.min + vec2(5.0, 0.5), galley, ink);
}
