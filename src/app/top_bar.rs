//! The menus, made from the table of actions, and a line on what is open.

use eframe::egui::{Align, Button, Layout, MenuBar, RichText, Ui};

use super::command::{ACTIONS, Action, Command, Entry, Menu};
use super::state::Model;
use super::{icons, theme};

/// Shows it.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.name(), |ui| {
                ui.set_min_width(250.0);
                for entry in ACTIONS.iter().filter(|entry| entry.menu == menu) {
                    if entry.line_before {
                        ui.separator();
                    }
                    item(ui, model, entry, commands);
                }
            });
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(theme::SPACE);
            opened(ui, model);
        });
    });
}

fn item(ui: &mut Ui, model: &Model, entry: &'static Entry, commands: &mut Vec<Command>) {
    let shortcut = entry.shortcuts.first().map_or_else(String::new, |shortcut| shortcut.text());
    let button = Button::new((icons::text(entry.icon), entry.text)).shortcut_text(shortcut);
    let response = ui.add_enabled(allowed(model, entry), button).accessible_name(entry.text);
    if response.on_hover_text(entry.tooltip).clicked() {
        commands.push(Command::Act(entry.action));
        ui.close();
    }
}

/// Whether an action makes sense now.
pub(crate) fn allowed(model: &Model, entry: &Entry) -> bool {
    match entry.action {
        Action::Undo => model.history.can().0,
        Action::Redo => model.history.can().1,
        Action::Slot(slot) => model.slots.in_view != slot,
        Action::ClearPixel => model.chosen.is_some(),
        Action::CloseArea | Action::UndoCorner => model.areas.draft.is_some(),
        Action::CancelArea => model.areas.draft.is_some() || model.areas.chosen.is_some(),
        Action::DeleteArea => model.areas.chosen.is_some(),
        Action::ClearAreas => !model.areas.is_empty(),
        Action::SaveMask => model.areas.roi.is_some(),
        _ => entry.always || model.shown().is_some(),
    }
}

/// Name, size, frames a second and number of frames, from right to left.
fn opened(ui: &mut Ui, model: &Model) {
    let Some(name) = &model.opened else { return };
    if let Some(info) = model.state.as_ref().and_then(|state| state.info.as_ref()) {
        let complete = model.timeline().is_some_and(|timeline| timeline.complete);
        let about = if complete { "" } else { "about " };
        let frames = match (model.frames(), info.live) {
            (_, true) => "live".to_owned(),
            (0, _) => "frames unknown".to_owned(),
            (frames, _) => format!("{about}{frames} frames"),
        };
        let rate = (info.fps * 100.0).round() / 100.0;
        ui.weak(format!("·  {}  ·  {rate} fps  ·  {frames}", info.size));
    }
    let short =
        std::path::Path::new(name).file_name().map_or(name.as_str(), |last| last.to_str().unwrap_or(name));
    ui.label(RichText::new(short).strong()).on_hover_text(name);
}
