//! Playback controls, and the frame in view.

use eframe::egui::{Button, ComboBox, DragValue, RichText, Ui, vec2};
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::icons::Icon;
use crate::app::model::Model;
use crate::app::model::playback::SPEEDS;
use crate::app::theme;

/// Width of the controls, in points.
const WIDTH_PT: f32 = 244.0;

/// Draws the buttons in a row, and frame and speed below.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    ui.vertical(|ui| {
        ui.set_width(WIDTH_PT);
        ui.horizontal(|ui| buttons(ui, model, commands));
        ui.add_space(theme::SPACE);
        ui.horizontal(|ui| place(ui, model, commands));
    });
}

/// The playback buttons.
fn buttons(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    ui.spacing_mut().item_spacing.x = theme::SPACE / 2.0;
    let play = if model.playback.playing { (m::ICON_PAUSE, "Pause") } else { (m::ICON_PLAY_ARROW, "Play") };
    for (action, (icon, name)) in [
        (Action::First, (m::ICON_FIRST_PAGE, "First frame")),
        (Action::PreviousEvent, (m::ICON_SKIP_PREVIOUS, "Previous event")),
        (Action::Step(-1), (m::ICON_CHEVRON_LEFT, "Previous frame")),
        (Action::Play, play),
        (Action::Step(1), (m::ICON_CHEVRON_RIGHT, "Next frame")),
        (Action::NextEvent, (m::ICON_SKIP_NEXT, "Next event")),
        (Action::Last, (m::ICON_LAST_PAGE, "Last frame")),
    ] {
        if button(ui, action, icon, name) {
            commands.push(Command::Act(action));
        }
    }
}

/// The frame in view and the speed.
fn place(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    ui.spacing_mut().item_spacing.x = theme::SPACE;
    frame_field(ui, model, commands);
    ui.add_space(2.0 * theme::SPACE);
    speed(ui, model, commands);
}

fn button(ui: &mut Ui, action: Action, icon: Icon, name: &str) -> bool {
    let main = action == Action::Play;
    let colours = theme::colours(ui.visuals());
    let text = icon.rich_text().size(if main { 22.0 } else { 19.0 });
    let text = if main { text.color(colours.on_accent) } else { text };
    let mut button =
        Button::new(text).min_size(vec2(if main { 40.0 } else { 28.0 }, 28.0)).corner_radius(6.0);
    button = if main { button.fill(colours.accent) } else { button.frame_when_inactive(false) };
    ui.spacing_mut().button_padding = vec2(3.0, 0.0);
    let keys = action.entry().map_or_else(String::new, |entry| {
        entry.shortcuts.iter().map(|shortcut| shortcut.text()).collect::<Vec<_>>().join(" or ")
    });
    ui.add(button).accessible_name(name).on_hover_text(format!("{name} ({keys})")).clicked()
}

fn frame_field(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let label = ui.label("Frame");
    let last = model.worker.number(model.worker.frames().max(1) - 1);
    let first = model.worker.number(0);
    let mut number = model.worker.number(model.worker.position());
    ui.spacing_mut().interact_size.x = 56.0;
    // A typed number applies when the field loses the focus, not digit by digit.
    let drag = DragValue::new(&mut number).range(first..=last.max(first)).update_while_editing(false);
    let response = ui.add(drag).labelled_by(label.id);
    if response.on_hover_text("Drag, or click to enter a frame number").changed() {
        commands.push(Command::GoToNumber(number));
    }
    ui.label(RichText::new(format!("/ {last}")).monospace().color(theme::colours(ui.visuals()).weak));
}

fn speed(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let name = |speed: f32| {
        if speed < 1.0 { format!("×1/{}", (1.0 / speed).round()) } else { format!("×{speed}") }
    };
    let combo = ComboBox::from_id_salt("speed").selected_text(name(SPEEDS[model.playback.speed])).width(62.0);
    let response = combo.show_ui(ui, |ui| {
        for (place, speed) in SPEEDS.into_iter().enumerate() {
            if ui.selectable_label(place == model.playback.speed, name(speed)).clicked() {
                commands.push(Command::Speed(place));
            }
        }
    });
    response.response.accessible_name("Speed").on_hover_text("Playback speed ([ and ])");
}
