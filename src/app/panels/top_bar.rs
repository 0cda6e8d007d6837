//! The menus, made from the table of actions, and information about the open video.

use std::path::Path;

use eframe::egui::{Align, Button, DragValue, Layout, MenuBar, RichText, Ui};
use egui_material_icons::icons as m;

use crate::app::commands::command::{ACTIONS, Action, Command, Entry, Menu};
use crate::app::icons;
use crate::app::model::Model;
use crate::app::model::overlays::Drawn;
use crate::app::theme;
use crate::replay::Start;
use crate::source::{FPS_RANGE, FpsFrom};

/// Draws the bar.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.name(), |ui| {
                ui.set_min_width(250.0);
                let entries: Vec<_> = ACTIONS.iter().filter(|entry| entry.menu == menu).collect();
                for group in entries.chunk_by(|a, b| a.submenu.is_some() && a.submenu == b.submenu) {
                    items(ui, model, group, commands);
                }
            });
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(theme::SPACE);
            opened(ui, model, commands);
        });
    });
}

/// One action, or a submenu of several.
fn items(ui: &mut Ui, model: &Model, group: &[&'static Entry], commands: &mut Vec<Command>) {
    if group.first().is_some_and(|entry| entry.line_before) {
        ui.separator();
    }
    match group.first().and_then(|entry| entry.submenu) {
        Some(name) => {
            ui.menu_button(name, |ui| {
                ui.set_min_width(220.0);
                for entry in group {
                    item(ui, model, entry, commands);
                }
            });
        }
        None => {
            for entry in group {
                item(ui, model, entry, commands);
                if entry.action == Action::OpenSample {
                    recent(ui, model, commands);
                }
            }
        }
    }
}

/// The submenu of recent videos.
fn recent(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    if model.recent.is_empty() {
        return;
    }
    ui.menu_button("Open recent", |ui| {
        for name in &model.recent {
            if ui.button(short(name)).on_hover_text(name).clicked() {
                commands.push(Command::Open(name.clone(), Start::First));
                ui.close();
            }
        }
    });
}

/// The last part of a path.
pub(crate) fn short(name: &str) -> &str {
    Path::new(name).file_name().and_then(|last| last.to_str()).unwrap_or(name)
}

/// One action in a menu, with a check mark while it is on.
pub(crate) fn item(ui: &mut Ui, model: &Model, entry: &'static Entry, commands: &mut Vec<Command>) {
    let shortcut = entry.shortcuts.first().map_or_else(String::new, |shortcut| shortcut.text());
    let on = is_on(model, entry.action);
    let icon = if on == Some(true) { m::ICON_CHECK } else { entry.icon };
    let button = Button::selectable(on == Some(true), (icons::text(icon), entry.text));
    let button = button.shortcut_text(shortcut);
    let response = ui.add_enabled(allowed(model, entry), button).accessible_name(entry.text);
    if response.on_hover_text(entry.tooltip).clicked() {
        commands.push(Command::Act(entry.action));
        ui.close();
    }
}

/// Whether a switch is on; `None` for actions that are not switches.
fn is_on(model: &Model, action: Action) -> Option<bool> {
    match action {
        Action::Open(view) => Some(model.open[view.place()]),
        Action::Maximise(view) => Some(model.maximised == Some(view)),
        Action::Draw(what) => Some(model.drawn.has(what)),
        Action::Map(quantity) => Some(model.mapped.is_some() && model.quantity == quantity),
        Action::Overlay => Some(model.overlay.on),
        Action::Loupe => Some(model.loupe),
        Action::StartHere => Some(model.marks.start == Some(model.position())),
        Action::EndHere => Some(model.marks.end == Some(model.position())),
        Action::Bookmark => Some(model.marks.bookmarks.contains(&model.position())),
        Action::Pin => Some(model.chosen.is_some_and(|at| model.marks.pins.number_of(at).is_some())),
        Action::SettingsPanel => Some(model.settings_panel),
        Action::InspectorPanel => Some(model.inspector_panel),
        Action::AbSlot(slot) => Some(model.ab_settings.in_view == slot),
        Action::DrawArea(purpose) => {
            Some(model.areas.draft.as_ref().is_some_and(|draft| draft.purpose == purpose))
        }
        _ => None,
    }
}

/// Whether an action is available.
pub(crate) fn allowed(model: &Model, entry: &Entry) -> bool {
    match entry.action {
        Action::Undo => model.history.can().0,
        Action::Redo => model.history.can().1,
        Action::AbSlot(slot) => model.ab_settings.in_view != slot,
        Action::FlipSettings => model.ab_settings.other.is_some() && model.held.is_none(),
        Action::CopySettings | Action::SwapSettings => {
            model.ab_settings.other.as_ref().is_some_and(|other| *other != model.settings)
        }
        Action::KeepSettings => model.ab_settings.other.is_some(),
        Action::ClearPixel | Action::Pin => model.chosen.is_some(),
        Action::ClearPins => !model.marks.pins.is_empty(),
        Action::ClearObject => model.object.is_some(),
        Action::Draw(Drawn::Truth) => model.truth.as_ref().is_some_and(|truth| truth.boxes.is_some()),
        Action::CloseVideo => model.player.is_some(),
        // The last open view cannot be closed.
        Action::Open(view) => {
            let more = model.open.iter().filter(|open| **open).count() > 1;
            model.shown().is_some() && (more || !model.open[view.place()])
        }
        Action::CloseArea | Action::UndoCorner => model.areas.draft.is_some(),
        Action::CancelArea => model.areas.draft.is_some() || model.areas.chosen.is_some(),
        Action::DeleteArea => model.areas.chosen.is_some(),
        Action::NextBookmark => model.marks.adjacent_bookmark(model.position(), true).is_some(),
        Action::PreviousBookmark => model.marks.adjacent_bookmark(model.position(), false).is_some(),
        Action::WholeTimeline | Action::ZoomTimeline(false) => model.span.is_some(),
        Action::AnalyseAhead => model.shown().is_some() && (model.is_busy() || !model.is_all_analysed()),
        Action::ClearAreas => !model.areas.is_empty(),
        Action::SaveMask => model.areas.roi.is_some(),
        _ => entry.always || model.shown().is_some(),
    }
}

/// The frame rate, with a field to type it where the source does not specify it.
fn rate(ui: &mut Ui, rounded: f32, from: FpsFrom, commands: &mut Vec<Command>) {
    let label = ui.weak(if from == FpsFrom::Assumed { "fps, assumed" } else { "fps" });
    let mut fps = f64::from(rounded);
    let (least, greatest) = FPS_RANGE;
    // Another rate restarts the analysis: it can be typed but not dragged.
    let typed = DragValue::new(&mut fps)
        .range(f64::from(least)..=f64::from(greatest))
        .speed(0.0)
        .max_decimals(2)
        .update_while_editing(false);
    let hover = "Frames per second; settings in seconds depend on it. Click to edit; the video is analysed \
     again.";
    if ui.add(typed).labelled_by(label.id).on_hover_text(hover).changed() {
        commands.push(Command::Rate(fps as f32));
    }
}

/// Name, size, frame rate and number of frames, from right to left.
fn opened(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(name) = &model.opened else { return };
    if let Some(info) = model.state.as_ref().and_then(|state| state.info.as_ref()) {
        let complete = model.timeline().is_some_and(|timeline| timeline.complete);
        let about = if complete { "" } else { "about " };
        let frames = match (model.frames(), info.live) {
            (_, true) => "live".to_owned(),
            (0, _) => "frames unknown".to_owned(),
            (frames, _) => format!("{about}{frames} frames"),
        };
        let rounded = (info.fps * 100.0).round() / 100.0;
        match info.fps_from {
            FpsFrom::Video | FpsFrom::SeqInfo => {
                ui.weak(format!("·  {}  ·  {rounded} fps  ·  {frames}", info.size));
            }
            FpsFrom::Given | FpsFrom::Assumed => {
                ui.weak(format!("·  {frames}"));
                rate(ui, rounded, info.fps_from, commands);
                ui.weak(format!("·  {}  ·", info.size));
            }
        }
    }
    ui.label(RichText::new(short(name)).strong()).on_hover_text(name);
}
