//! The controls in the title bar of a view.

use eframe::egui::containers::menu::MenuButton;
use eframe::egui::{Align, Button, DragValue, Layout, RichText, Ui, vec2};
use egui_material_icons::icons as m;

use super::map;
use crate::app::commands::action::Action;
use crate::app::commands::availability::is_available;
use crate::app::commands::command::Command;
use crate::app::menu_item::menu_item;
use crate::app::model::Model;
use crate::app::model::overlays::TrackOverlay;
use crate::app::model::view::{BackgroundDisplay, View};
use crate::app::theme;
use crate::mixture::Quantity;

// Minimum widths in points.

/// Minimum width of a title bar for buttons of all kinds of background.
const MIN_KINDS_WIDTH: f32 = 330.0;

/// Minimum width for the selected kind only; below, the tabs need all the space.
const MIN_KIND_WIDTH: f32 = 230.0;

/// Minimum width for the whole name of the mapped quantity; below, its symbol is shown.
const MIN_QUANTITY_NAME_WIDTH: f32 = 330.0;

/// Minimum width of a title bar per tab for the close button.
const MIN_CLOSE_WIDTH_PER_TAB: f32 = 130.0;

/// Minimum width of a title bar for the switch of the mask overlay.
const MIN_OVERLAY_WIDTH: f32 = 120.0;

/// The controls at the right end of a title bar with this number of tabs.
pub(super) fn controls(ui: &mut Ui, model: &Model, view: View, tabs: usize, commands: &mut Vec<Command>) {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = theme::SPACE / 2.0;
        ui.spacing_mut().button_padding = vec2(theme::SPACE, 0.0);
        ui.add_space(theme::SPACE);
        if model.display.maximised.is_none() && ui.available_width() >= MIN_CLOSE_WIDTH_PER_TAB * tabs as f32
        {
            close(ui, model, view, commands);
        }
        let (icon, name) = if model.display.maximised == Some(view) {
            (m::ICON_FULLSCREEN_EXIT, "Show all views")
        } else {
            (m::ICON_FULLSCREEN, "Show alone")
        };
        let button = Button::new(icon.rich_text().size(theme::ICON_SIZE)).frame_when_inactive(false);
        let text = Action::Maximise(view).entry().map_or_else(
            || name.to_owned(),
            |entry| {
                entry
                    .shortcuts
                    .first()
                    .map_or_else(|| name.to_owned(), |key| format!("{name} ({})", key.text()))
            },
        );
        let response =
            ui.add(button).accessible_name(format!("{name}: {}", view.label(&model.edits.ab_settings)));
        if response.on_hover_text(text).clicked() {
            commands.push(Command::Act(Action::Maximise(view)));
        }
        if view == View::Input && ui.available_width() >= MIN_OVERLAY_WIDTH {
            overlay(ui, model, commands);
        }
        if view == View::Tracks {
            track_overlays(ui, model, commands);
        }
        if view == View::Map {
            quantity(ui, model, commands);
        }
        if view == View::Background && ui.available_width() >= MIN_KIND_WIDTH {
            background(ui, model, commands);
        }
    });
}

/// The kinds of background, or the selected kind where there is no space for all.
fn background(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    if ui.available_width() < MIN_KINDS_WIDTH {
        let kind = model.display.background;
        let button = Button::selectable(true, RichText::new(kind.name()).size(theme::SMALL_TEXT));
        let text = format!("{}. Click for the next display.", kind.meaning());
        if ui.add(button).accessible_name(kind.meaning()).on_hover_text(text).clicked() {
            commands.push(Command::Act(Action::Background));
        }
    } else {
        for kind in BackgroundDisplay::ALL.into_iter().rev() {
            let selected = model.display.background == kind;
            let text = RichText::new(kind.name()).size(theme::SMALL_TEXT);
            let response = ui.add(Button::selectable(selected, text)).on_hover_text(kind.meaning());
            if response.accessible_name(kind.meaning()).clicked() {
                commands.push(Command::ShowBackground(kind));
            }
        }
    }
}

/// The button that closes a view.
fn close(ui: &mut Ui, model: &Model, view: View, commands: &mut Vec<Command>) {
    let action = Action::Open(view);
    let last = action.entry().is_some_and(|entry| !is_available(model, entry));
    let button = Button::new(m::ICON_CLOSE.rich_text().size(14.0)).frame_when_inactive(false);
    let response = ui
        .add_enabled(!last, button)
        .accessible_name(format!("Close: {}", view.label(&model.edits.ab_settings)));
    let text = "Close this view; reopen it with the menu View, Views";
    if response.on_hover_text(text).clicked() {
        commands.push(Command::Act(action));
    }
}

/// The menu of the overlays.
fn track_overlays(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let icon = m::ICON_LAYERS.rich_text().size(theme::ICON_SIZE);
    let button = Button::new(icon).frame_when_inactive(false);
    let (response, _) = MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(190.0);
        for what in TrackOverlay::ALL {
            if let Some(entry) = Action::Draw(what).entry() {
                menu_item(ui, model, entry, commands);
            }
        }
    });
    response.accessible_name("Track overlays").on_hover_text("Select the track overlays");
}

/// The menu of the mapped quantity.
fn quantity(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let chosen = model.display.quantity;
    let narrow = ui.available_width() < MIN_QUANTITY_NAME_WIDTH;
    let name = if narrow { map::symbol(chosen) } else { map::name(chosen) };
    let text = RichText::new(name).size(theme::SMALL_TEXT);
    let button = Button::new((text, m::ICON_ARROW_DROP_DOWN.rich_text().size(theme::ICON_SIZE)));
    let (response, _) = MenuButton::from_button(button.frame_when_inactive(false)).ui(ui, |ui| {
        ui.set_min_width(230.0);
        for quantity in Quantity::ALL {
            if let Some(entry) = Action::Map(quantity).entry() {
                menu_item(ui, model, entry, commands);
            }
        }
    });
    let name = format!("Map of {}", map::name(chosen));
    response.accessible_name(name).on_hover_text("Mapped quantity (Shift+M for the next)");
}

/// The switch of the mask overlay and, while it is on, its opacity.
fn overlay(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let overlay = model.display.overlay;
    if overlay.on {
        let mut opacity = overlay.opacity;
        let drag = DragValue::new(&mut opacity).range(5..=100).suffix(" %").speed(0.5);
        ui.spacing_mut().interact_size = vec2(44.0, theme::ROW_HEIGHT - 6.0);
        let response = ui.add(drag).accessible_name("Mask opacity");
        if response
            .on_hover_text("Opacity of the mask over the input; drag, or click to enter a value")
            .changed()
        {
            commands.push(Command::Overlay(opacity));
        }
    }
    let text = RichText::new("Mask").size(theme::SMALL_TEXT);
    let response = ui.add(Button::selectable(overlay.on, text)).accessible_name("Mask overlay");
    if response.on_hover_text("Show or hide the foreground mask over the input (O)").clicked() {
        commands.push(Command::Act(Action::Overlay));
    }
}
