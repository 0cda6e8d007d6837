//! The timeline of the sequence: analysis progress, foreground ratio, tracks, events.

mod axis;
mod curves;
mod marks;
mod tracks;

use eframe::egui::{
    CursorIcon, EventFilter, Key, Modifiers, Response, Sense, Stroke, Ui, Vec2, WidgetInfo, accesskit::Role,
    vec2,
};

use self::axis::TimeAxis;
use self::curves::{alignment_words, draw_alignments, draw_foreground, draw_progress};
use self::marks::{
    EVENT_ROW_HEIGHT, NUMBER_ROW_HEIGHT, draw_events, draw_marks, draw_numbers, draw_playhead, nearest_event,
};
use self::tracks::draw_tracks;
use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::event_comparison::EventRef;
use crate::app::model::timeline_span::visible_span;
use crate::app::panels::evidence::participants;
use crate::app::theme;
use crate::palette::event_colour;
use crate::replay::Timeline;

/// Draws the timeline.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Timeline"));
    let Some(timeline) = model.worker.timeline() else { return };
    let frames = model.worker.frames().max(1);
    let inner = rect.shrink2(vec2(8.0, 0.0));
    // Not every system keeps to the least size of the window.
    if inner.width() < 1.0 {
        return;
    }
    let axis = TimeAxis { rect: inner, frames, span: visible_span(model, frames) };
    follow(model, &axis, commands);
    let painter = ui.painter().with_clip_rect(rect);
    let colours = theme::colours(ui.visuals());
    let (scale, rest) = axis.rect.split_top_bottom_at_y(axis.rect.top() + NUMBER_ROW_HEIGHT);
    let (marks, lanes) = rest.split_top_bottom_at_y(rest.top() + EVENT_ROW_HEIGHT);
    let ground = lanes.with_max_y(lanes.bottom() - 2.0);
    painter.rect_filled(ground.expand2(vec2(8.0, 0.0)), 4.0, colours.canvas);
    draw_numbers(&painter, model, &axis, scale, colours.weak, colours.line);
    draw_foreground(&painter, timeline, &axis, ground, colours.weak);
    draw_alignments(&painter, timeline, &axis, ground, &colours);
    draw_progress(&painter, timeline, &axis, ground, &colours);
    draw_tracks(&painter, model, timeline, &axis, ground);
    draw_marks(&painter, model, &axis, ground, &colours);
    draw_events(&painter, model, timeline, &axis, marks);
    draw_playhead(&painter, model, &axis, colours.accent, colours.on_accent);
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
        if position != model.worker.position() {
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
        response.on_hover_ui_at_pointer(|ui| tooltip(ui, model, timeline, near, column));
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
    if (wheel != Vec2::ZERO || pinch != 1.0) && span != model.panels.timeline_span {
        commands.push(Command::Span(span));
    }
}

/// Scrolls with the frame in view during playback.
fn follow(model: &Model, axis: &TimeAxis, commands: &mut Vec<Command>) {
    let (from, to) = axis.span;
    let here = model.worker.position() as f32 + 0.5;
    if model.panels.timeline_span.is_some() && model.playback.playing && !(from..to).contains(&here) {
        let length = to - from;
        let first = (here - 0.1 * length).clamp(0.0, axis.frames as f32 - length);
        commands.push(Command::Span(Some((first, first + length))));
    }
}

fn tooltip(ui: &mut Ui, model: &Model, timeline: &Timeline, near: Option<usize>, column: u32) {
    if let Some((_, event)) = near.and_then(|index| timeline.events.get(index)) {
        ui.horizontal(|ui| {
            ui.label(icons::coloured(icons::of_event(event.kind), theme::rgb(event_colour(event.kind))));
            ui.strong(format!("{} {}", event.kind.label(), participants(event)));
            ui.weak(format!("frame {}", event.frame));
        });
        ui.label(&event.evidence.branch);
        return;
    }
    ui.strong(format!("Frame {}", model.worker.number(column)));
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
