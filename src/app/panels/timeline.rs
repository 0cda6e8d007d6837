//! The timeline of the sequence: analysis progress, foreground ratio, tracks, events.

use std::ops::{Range, RangeInclusive};

use eframe::egui::{
    Align2, Color32, CursorIcon, EventFilter, FontId, Key, Modifiers, Painter, Pos2, Rect, Response, Sense,
    Shape, Stroke, Ui, Vec2, WidgetInfo, accesskit::Role, pos2, vec2,
};

use crate::app::commands::command::{Action, Command};
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::event_comparison::EventRef;
use crate::app::panels::events_panel;
use crate::app::theme;
use crate::occlusion::EventKind;
use crate::palette::{event_colour, identity_colour};
use crate::registration::{Alignment, Motion};
use crate::replay::Timeline;
use crate::tracking::TrackState;

/// Height of the row of event marks.
const MARKS: f32 = 16.0;
/// Height of the row of frame numbers.
const SCALE: f32 = 14.0;
/// Height of the bar of the analysis progress.
const ANALYSED: f32 = 3.0;

/// Minimum number of visible frames.
const MIN_SHOWN_FRAMES: f32 = 8.0;

/// The map from positions to the screen's x axis.
#[derive(Clone, Copy)]
struct TimeAxis {
    rect: Rect,
    frames: u32,
    /// The visible positions, from and to.
    span: (f32, f32),
}

impl TimeAxis {
    /// The centre of a position's column.
    fn x(&self, position: u32) -> f32 {
        self.edge(position as f32 + 0.5)
    }

    fn edge(&self, at: f32) -> f32 {
        let (from, to) = self.span;
        self.rect.left() + (at - from) / (to - from).max(1.0) * self.rect.width()
    }

    fn position(&self, x: f32) -> u32 {
        let share = ((x - self.rect.left()) / self.rect.width()).clamp(0.0, 1.0);
        let (from, to) = self.span;
        ((from + share * (to - from)) as u32).min(self.frames.saturating_sub(1))
    }

    /// The visible positions, end excluded.
    fn seen(&self) -> Range<u32> {
        self.span.0.floor() as u32..(self.span.1.ceil() as u32).min(self.frames)
    }

    /// The visible positions after zooming around `at` and panning by `by` points; `None` for all.
    fn moved(&self, at: f32, zoom: f32, by: f32) -> Option<(f32, f32)> {
        let (from, to) = self.span;
        let (length, all) = (to - from, self.frames as f32);
        let new = (length / zoom).clamp(MIN_SHOWN_FRAMES.min(all), all);
        let share = ((at - self.rect.left()) / self.rect.width()).clamp(0.0, 1.0);
        let first = from + share * (length - new) - by / self.rect.width() * new;
        let first = first.clamp(0.0, all - new);
        (new < all).then_some((first, first + new))
    }
}

/// The visible positions after zooming by two around the frame in view; `None` for all.
pub(crate) fn zoomed(model: &Model, into: bool) -> Option<(f32, f32)> {
    let frames = model.frames().max(1);
    let unit = Rect::from_min_size(Pos2::ZERO, Vec2::splat(1.0));
    let axis = TimeAxis { rect: unit, frames, span: seen(model, frames) };
    let here = axis.x(model.position());
    axis.moved(here, if into { 2.0 } else { 0.5 }, 0.0)
}

/// The visible positions, from and to.
fn seen(model: &Model, frames: u32) -> (f32, f32) {
    model.span.filter(|span| span.1 <= frames as f32).unwrap_or((0.0, frames as f32))
}

/// Draws the timeline.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Timeline"));
    let Some(timeline) = model.timeline() else { return };
    let frames = model.frames().max(1);
    let axis = TimeAxis { rect: rect.shrink2(vec2(8.0, 0.0)), frames, span: seen(model, frames) };
    follow(model, &axis, commands);
    let painter = ui.painter().with_clip_rect(rect);
    let colours = theme::colours(ui.visuals());
    let (scale, rest) = axis.rect.split_top_bottom_at_y(axis.rect.top() + SCALE);
    let (marks, lanes) = rest.split_top_bottom_at_y(rest.top() + MARKS);
    let ground = lanes.with_max_y(lanes.bottom() - 2.0);
    painter.rect_filled(ground.expand2(vec2(8.0, 0.0)), 4.0, colours.canvas);
    numbers(&painter, model, &axis, scale, colours.weak, colours.line);
    foreground(&painter, timeline, &axis, ground, colours.weak);
    alignments(&painter, timeline, &axis, ground, &colours);
    analysed(&painter, timeline, &axis, ground, &colours);
    draw_track_timelines(&painter, model, timeline, &axis, ground);
    marked(&painter, model, &axis, ground, &colours);
    event_marks(&painter, model, timeline, &axis, marks);
    playhead(&painter, model, &axis, colours.accent, colours.on_accent);
    arrows(ui, &response, commands);
    theme::focus(ui, &response);

    let near = response.hover_pos().and_then(|at| nearest_event(model, timeline, &axis, marks, at));
    if let Some(at) = response.interact_pointer_pos()
        && (response.dragged() || response.clicked() || response.is_pointer_button_down_on())
    {
        let position = match near {
            Some(index) if response.clicked() => {
                commands.push(Command::OpenEvent(Some(EventRef::InView(index))));
                timeline.events[index].0
            }
            _ => axis.position(at.x),
        };
        if position != model.position() {
            commands.push(Command::GoTo(position));
        }
    }
    if response.contains_pointer()
        && let Some(at) = response.hover_pos()
    {
        zoom(ui, model, &axis, at.x, commands);
    }
    if let Some(at) = response.hover_pos() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        let column = axis.position(at.x);
        painter.vline(at.x, ground.y_range(), Stroke::new(1.0, colours.weak.gamma_multiply(0.5)));
        response.on_hover_ui_at_pointer(|ui| hover(ui, model, timeline, near, column));
    }
}

/// The arrow keys step through frames while the timeline has the focus.
fn arrows(ui: &Ui, response: &Response, commands: &mut Vec<Command>) {
    if !response.has_focus() {
        return;
    }
    let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    for (key, by) in [(Key::ArrowLeft, -1), (Key::ArrowRight, 1)] {
        for _ in 0..ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) {
            commands.push(Command::Act(Action::Step(by)));
        }
    }
}

/// The wheel zooms around the pointer; horizontally, or with Shift, it pans.
fn zoom(ui: &Ui, model: &Model, axis: &TimeAxis, at: f32, commands: &mut Vec<Command>) {
    let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta(), input.zoom_delta()));
    let span = axis.moved(at, (wheel.y / 180.0).exp() * pinch, wheel.x);
    if (wheel != Vec2::ZERO || pinch != 1.0) && span != model.span {
        commands.push(Command::Span(span));
    }
}

/// Scrolls with the frame in view during playback.
fn follow(model: &Model, axis: &TimeAxis, commands: &mut Vec<Command>) {
    let (from, to) = axis.span;
    let here = model.position() as f32 + 0.5;
    if model.span.is_some() && model.playback.playing && !(from..to).contains(&here) {
        let length = to - from;
        let first = (here - 0.1 * length).clamp(0.0, axis.frames as f32 - length);
        commands.push(Command::Span(Some((first, first + length))));
    }
}

/// The playback range, the bookmarks, and the visible part of the whole.
fn marked(painter: &Painter, model: &Model, axis: &TimeAxis, ground: Rect, colours: &theme::Colours) {
    let marks = &model.marks;
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
        let (x, top) = (axis.x(bookmark), axis.rect.top() + SCALE - 2.0);
        painter.vline(x, top..=ground.bottom(), Stroke::new(1.0, colours.warn.gamma_multiply(0.6)));
        let flag = vec![pos2(x, top), pos2(x + 7.0, top + 3.5), pos2(x, top + 7.0)];
        painter.add(Shape::convex_polygon(flag, colours.warn, Stroke::NONE));
    }
    if model.span.is_some() {
        let all = axis.frames as f32;
        let x = |at: f32| ground.left() + at / all * ground.width();
        let bar = Rect::from_x_y_ranges(x(axis.span.0)..=x(axis.span.1), ground.top()..=ground.top() + 2.0);
        painter.rect_filled(bar, 1.0, colours.weak);
    }
}

fn hover(ui: &mut Ui, model: &Model, timeline: &Timeline, near: Option<usize>, column: u32) {
    if let Some((_, event)) = near.and_then(|index| timeline.events.get(index)) {
        ui.horizontal(|ui| {
            ui.label(icons::coloured(icons::of_event(event.kind), theme::rgb(event_colour(event.kind))));
            ui.strong(format!("{} {}", event.kind.label(), events_panel::participants(event)));
            ui.weak(format!("frame {}", event.frame));
        });
        ui.label(&event.evidence.branch);
        return;
    }
    ui.strong(format!("frame {}", model.number(column)));
    match timeline.foreground_share.get(column as usize) {
        Some(share) => ui.label(format!("foreground {:.2} %", share * 100.0)),
        None => ui.weak("not analysed yet"),
    };
    if let Some(words) = timeline.alignments.get(column as usize).and_then(alignment_words) {
        ui.weak(words);
    }
    let alive: Vec<String> = timeline
        .track_timelines
        .iter()
        .filter_map(|line| {
            let span = line.spans.iter().find(|(first, last, _)| (*first..=*last).contains(&column))?;
            Some(format!("{} {}", line.id, span.2.name()))
        })
        .collect();
    if !alive.is_empty() {
        ui.weak(alive.join(", "));
    }
}

/// Frame numbers at round intervals.
fn numbers(painter: &Painter, model: &Model, axis: &TimeAxis, row: Rect, text: Color32, line: Color32) {
    let room = (axis.rect.width() / 70.0).max(1.0);
    let rough = ((axis.span.1 - axis.span.0) / room).max(1.0);
    let power = 10_f32.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough);
    let step = (step.unwrap_or(power * 10.0) as u32).max(1);
    let seen = axis.seen();
    let mut position = seen.start / step * step + step - 1;
    while position < seen.end {
        let x = axis.x(position);
        let label = model.number(position).to_string();
        let font = FontId::proportional(theme::SMALL);
        // A number under the playhead's own label would be unreadable.
        if x < axis.rect.right() - 12.0 && (x - axis.x(model.position())).abs() > 26.0 {
            painter.text(pos2(x, row.center().y), Align2::CENTER_CENTER, label, font, text);
        }
        painter.vline(x, row.bottom()..=axis.rect.bottom(), Stroke::new(1.0, line.gamma_multiply(0.5)));
        position += step;
    }
}

/// The foreground ratio of the image, as a curve in the background.
fn foreground(painter: &Painter, timeline: &Timeline, axis: &TimeAxis, ground: Rect, colour: Color32) {
    let shares = &timeline.foreground_share;
    let most = shares.iter().copied().fold(0.01_f32, f32::max);
    let columns = (ground.width() as u32).max(1);
    let per_column = f64::from(axis.span.1 - axis.span.0) / f64::from(columns);
    let mut points: Vec<Pos2> = Vec::new();
    if per_column <= 1.0 {
        let seen = axis.seen();
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
    let mut area = eframe::egui::Mesh::default();
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

/// Minimum motion that fills the plot, in pixels, and minimum change of illumination, as a ratio.
const LEAST_MOTION: f32 = 3.0;
const LEAST_LIGHT: f32 = 0.3;

/// The camera's displacement from its reference, and the change of illumination relative to the recent past: one line
/// each, if there is anything to show.
fn alignments(
    painter: &Painter,
    timeline: &Timeline,
    axis: &TimeAxis,
    ground: Rect,
    colours: &theme::Colours,
) {
    type Number = fn(&Alignment) -> f32;
    let lines: [(Number, f32, Color32); 2] =
        [(motion_of, LEAST_MOTION, colours.accent), (light_of, LEAST_LIGHT, colours.warn)];
    for (number, least, colour) in lines {
        let most = timeline.alignments.iter().map(number).fold(0.0, f32::max);
        if most == 0.0 {
            continue;
        }
        let seen = axis.seen();
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
fn alignment_words(alignment: &Alignment) -> Option<String> {
    let rest = alignment.rest.unwrap_or_default();
    let (dx, dy) = (alignment.motion.dx - rest.dx, alignment.motion.dy - rest.dy);
    let moved = (motion_of(alignment) > 0.0).then(|| format!("camera {dx:+.1}, {dy:+.1} px"));
    let light = (light_of(alignment) > 0.0).then(|| format!("light {:.2}", alignment.light.luma_gain()));
    let words: Vec<_> = [moved, light].into_iter().flatten().collect();
    (!words.is_empty()).then(|| words.join(", "))
}

fn height_of(share: f32, most: f32, ground: Rect) -> f32 {
    ground.bottom() - ANALYSED - share / most * (ground.height() - ANALYSED - 4.0)
}

/// The analysis progress; brighter where decoded frames are cached, too.
fn analysed(painter: &Painter, timeline: &Timeline, axis: &TimeAxis, ground: Rect, colours: &theme::Colours) {
    let part = |from: u32, to: u32, colour: Color32| {
        let x = |at: u32| axis.edge(at as f32).clamp(axis.rect.left(), axis.rect.right());
        let rect = Rect::from_x_y_ranges(x(from)..=x(to), ground.bottom() - ANALYSED..=ground.bottom());
        painter.rect_filled(rect, 0.0, colour);
    };
    part(0, timeline.analysed, colours.accent.gamma_multiply(0.4));
    for &(first, last) in &timeline.decoded {
        let known = first < timeline.analysed;
        let colour = if known { colours.accent } else { colours.weak.gamma_multiply(0.6) };
        part(first, last + 1, colour);
    }
}

/// Assigns each track line to a lane so that lines do not overlap. Returns the lanes and their number.
fn lanes(lives: &[RangeInclusive<u32>]) -> (Vec<usize>, usize) {
    let mut ends: Vec<u32> = Vec::new();
    let taken = lives
        .iter()
        .map(|life| {
            let free = ends.iter().position(|&end| end < *life.start());
            let lane = free.unwrap_or(ends.len());
            if lane == ends.len() {
                ends.push(0);
            }
            ends[lane] = *life.end() + 1;
            lane
        })
        .collect();
    (taken, ends.len())
}

fn draw_track_timelines(
    painter: &Painter,
    model: &Model,
    timeline: &Timeline,
    axis: &TimeAxis,
    ground: Rect,
) {
    let mut lines: Vec<_> = timeline.track_timelines.iter().filter(|line| !line.spans.is_empty()).collect();
    lines.sort_by_key(|line| (line.spans.first().map(|span| span.0), line.id));
    let lives: Vec<_> = lines
        .iter()
        .map(|line| {
            let first = line.spans.iter().map(|span| span.0).min().unwrap_or(0);
            let last = line.spans.iter().map(|span| span.1).max().unwrap_or(0);
            first..=last
        })
        .collect();
    let (taken, count) = lanes(&lives);
    let room = ground.height() - ANALYSED - 6.0;
    let pitch = (room / count.max(1) as f32).min(11.0);
    let thick = (pitch * 0.55).clamp(1.0, 5.0);
    for (line, lane) in lines.iter().zip(taken) {
        // With a chosen object, all other lines are fainter.
        let strength = if model.object.is_none_or(|id| id == line.id) { 1.0 } else { 0.35 };
        let colour = theme::rgb(identity_colour(line.id)).gamma_multiply(strength);
        let y = ground.top() + 4.0 + (lane as f32 + 0.5) * pitch;
        for &(first, last, state) in &line.spans {
            let (from, to) =
                (axis.edge(first as f32), axis.edge(last as f32 + 1.0).max(axis.edge(first as f32) + 1.0));
            match state {
                TrackState::Visible => {
                    painter.hline(from..=to, y, Stroke::new(thick, colour));
                }
                TrackState::Merged => {
                    painter.hline(from..=to, y, Stroke::new(thick, colour.gamma_multiply(0.5)));
                }
                TrackState::Hidden => {
                    let ends = [pos2(from, y), pos2(to, y)];
                    painter.extend(Shape::dashed_line(&ends, Stroke::new(thick.min(2.0), colour), 3.0, 3.0));
                }
            }
        }
    }
}

fn event_marks(painter: &Painter, model: &Model, timeline: &Timeline, axis: &TimeAxis, row: Rect) {
    for (index, (position, event)) in timeline.events.iter().enumerate() {
        if !model.lists(event.kind) {
            continue;
        }
        let read = model.reading == Some(EventRef::InView(index));
        let colour = theme::rgb(event_colour(event.kind));
        mark(
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
fn mark(painter: &Painter, at: Pos2, kind: EventKind, colour: Color32, size: f32) {
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
fn nearest_event(model: &Model, timeline: &Timeline, axis: &TimeAxis, row: Rect, at: Pos2) -> Option<usize> {
    if !row.expand(2.0).contains(at) {
        return None;
    }
    timeline
        .events
        .iter()
        .enumerate()
        .filter(|(_, (_, event))| model.lists(event.kind))
        .map(|(index, (position, _))| (index, (axis.x(*position) - at.x).abs()))
        .filter(|(_, distance)| *distance < 6.0)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

fn playhead(painter: &Painter, model: &Model, axis: &TimeAxis, accent: Color32, ink: Color32) {
    let position = model.position();
    let x = axis.x(position);
    painter.vline(x, axis.rect.top() + SCALE..=axis.rect.bottom(), Stroke::new(2.0, accent));
    let number = model.number(position).to_string();
    let galley = painter.layout_no_wrap(number, FontId::proportional(theme::SMALL), ink);
    let size = galley.size() + vec2(10.0, 1.0);
    let left = (x - size.x / 2.0)
        .clamp(axis.rect.left() - 8.0, (axis.rect.right() + 8.0 - size.x).max(axis.rect.left()));
    let plate = Rect::from_min_size(pos2(left, axis.rect.top()), size);
    painter.rect_filled(plate, 3.0, accent);
    painter.galley(plate.min + vec2(5.0, 0.5), galley, ink);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_track_lines_get_separate_lanes() {
        let (taken, count) = lanes(&[0..=10, 5..=20, 12..=15, 22..=30]);
        assert_eq!((taken, count), (vec![0, 1, 0, 0], 2));
    }

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
