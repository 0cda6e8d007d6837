//! An action in a menu.

use eframe::egui::{Button, Ui};
use egui_material_icons::icons as m;

use crate::app::commands::availability::{is_available, switch_state};
use crate::app::commands::command::Command;
use crate::app::commands::entry::ActionEntry;
use crate::app::icons;
use crate::app::model::Model;

/// One action in a menu, with a check mark while it is on.
pub(crate) fn menu_item(
    ui: &mut Ui,
    model: &Model,
    entry: &'static ActionEntry,
    commands: &mut Vec<Command>,
) {
    let shortcut = entry.shortcuts.first().map_or_else(String::new, |shortcut| shortcut.text());
    let on = switch_state(model, entry.action);
    let icon = if on == Some(true) { m::ICON_CHECK } else { entry.icon };
    let button = Button::selectable(on == Some(true), (icons::text(icon), entry.text));
    let button = button.shortcut_text(shortcut);
    let response = ui.add_enabled(is_available(model, entry), button).accessible_name(entry.text);
    if response.on_hover_text(entry.tooltip).clicked() {
        commands.push(Command::Act(entry.action));
        ui.close();
    }
}
