//! The status bar: the pixel under the pointer, the worker's progress, failures.

use std::time::Duration;

use eframe::egui::{Align, Button, Layout, RichText, Ui, vec2};
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::playback::SPEEDS;
use crate::app::theme;

/// The processing times of the last frame.
#[derive(Clone, Copy)]
pub(crate) struct FrameTiming {
    /// Time of the window's thread, in seconds.
    pub(crate) frame_seconds: Option<f32>,
    /// Time of the upload thread, and the number of uploaded bytes.
    pub(crate) upload: Option<(Duration, u64)>,
}

/// Draws the status bar. `value` is the value of the pixel under the pointer.
pub(crate) fn ui(
    ui: &mut Ui,
    model: &Model,
    value: Option<String>,
    timing: FrameTiming,
    commands: &mut Vec<Command>,
) {
    let colours = theme::colours(ui.visuals());
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0 * theme::SPACE;
        if let Some(shown) = model.worker.shown() {
            let seconds = shown.frame.time;
            let speed = SPEEDS[model.playback.speed];
            let speed = if model.playback.playing { format!("  ×{speed}") } else { String::new() };
            let text = format!("#{}  {seconds:.2} s{speed}", shown.frame.number);
            ui.label(RichText::new(text).monospace().color(colours.weak));
        }
        if let Some((hover, value)) = model.selection.hovered.zip(value) {
            let (x, y) = model.worker.source_pixel(hover.pixel);
            ui.label(RichText::new(format!("{x}, {y}")).monospace());
            ui.label(
                RichText::new(format!("{}  {value}", hover.view.label(&model.edits.ab_settings))).monospace(),
            );
            ui.label(RichText::new(format!("{:.0} %", hover.scale * 100.0)).monospace().color(colours.weak));
        } else if model.worker.is_ready() {
            let hint = "Click a pixel to inspect it  ·  wheel zooms, drag pans, F fits  ·  ? lists all keys";
            ui.label(RichText::new(hint).size(theme::SMALL_TEXT).color(colours.weak));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 3.0 * theme::SPACE;
            right(ui, model, timing, commands);
        });
    });
}

/// The button that pauses or resumes the analysis, beside its progress.
fn stop_or_go_on(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let action = Action::AnalyseAhead;
    let (icon, name, text) = if model.worker.is_busy() {
        let text = "Pause: analyse only the displayed frames";
        (m::ICON_STOP_CIRCLE, "Pause analysis", text)
    } else {
        (m::ICON_PLAY_CIRCLE, "Resume analysis", "Analyse the remaining frames in the background")
    };
    let keys =
        action.entry().and_then(|entry| entry.shortcuts.first()).map_or_else(String::new, |key| key.text());
    let button = Button::new(icon.rich_text().size(theme::ICON_SIZE)).frame_when_inactive(false);
    let response = ui.scope(|ui| {
        ui.spacing_mut().button_padding = vec2(2.0, 0.0);
        ui.spacing_mut().interact_size.y = theme::ICON_SIZE;
        ui.add(button)
    });
    let response = response.inner.accessible_name(name).on_hover_text(format!("{text} ({keys})"));
    if response.clicked() {
        commands.push(Command::Act(action));
    }
}

fn right(ui: &mut Ui, model: &Model, timing: FrameTiming, commands: &mut Vec<Command>) {
    let Some(state) = &model.worker.state else { return };
    let colours = theme::colours(ui.visuals());
    if state.analysis_fps > 0.0 {
        let text = format!("analysis {:.0} fps", state.analysis_fps);
        ui.label(RichText::new(text).size(theme::SMALL_TEXT).color(colours.weak)).on_hover_ui(|ui| {
            ui.label("Analysis rate in frames per second, over the last second of work");
            if let Some((worked, (took, bytes))) = timing.frame_seconds.zip(timing.upload) {
                let (worked, took) = (worked * 1e3, took.as_secs_f32() * 1e3);
                ui.weak(format!("Window: {worked:.1} ms per frame"));
                ui.weak(format!("Texture upload: {took:.1} ms, {:.1} MB", bytes as f32 / 1e6));
            }
        });
    }
    let stopped = !model.worker.analyses_ahead && !model.worker.is_all_analysed();
    // Opening has its own button, in the middle of the window.
    if model.worker.shown().is_some() && (state.busy.is_some() || stopped) {
        stop_or_go_on(ui, model, commands);
    }
    if let Some(busy) = &state.busy {
        if let Some(total) = busy.total.filter(|&total| total > 0) {
            let share = busy.done as f32 / total as f32;
            theme::progress(ui, share, 120.0).accessible_name(&*busy.what);
        }
        let count = busy.total.map_or_else(String::new, |total| format!("  {} / {total}", busy.done));
        ui.label(RichText::new(format!("{}{count}", busy.what)).size(theme::SMALL_TEXT).color(colours.text));
    } else if stopped {
        let text = format!("paused  {} / {}", state.timeline.analysed, model.worker.frames());
        ui.label(RichText::new(text).size(theme::SMALL_TEXT).color(colours.warn));
    }
    if !state.warnings.is_empty() {
        let warnings = &state.warnings;
        let text = format!("{} warning{}", warnings.len(), if warnings.len() == 1 { "" } else { "s" });
        let text = RichText::new(text).size(theme::SMALL_TEXT).color(colours.warn);
        let icon = icons::coloured(m::ICON_WARNING, colours.warn).size(14.0);
        let button = Button::new((icon, text)).frame_when_inactive(false);
        let response = ui.add(button).accessible_name("Warnings").on_hover_ui(|ui| {
            for warning in warnings.iter().take(20) {
                ui.label(warning);
            }
        });
        if response.clicked() {
            commands.push(Command::Act(Action::Messages));
        }
    }
}
