//! The list of areas, with buttons to draw, load and save them.

use eframe::egui::{Align, Button, CollapsingHeader, Layout, RichText, Ui, vec2};
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::availability::is_available;
use crate::app::commands::command::Command;
use crate::app::icons;
use crate::app::icons::Icon;
use crate::app::model::Model;
use crate::app::model::areas::{AreaEdit, Areas};
use crate::app::theme;
use crate::regions::roi::{Area, Purpose};

/// The label of an area's purpose in the list.
const fn word(purpose: Purpose) -> &'static str {
    match purpose {
        Purpose::Analyse => "Analyse",
        Purpose::Ignore => "Ignore",
    }
}

/// Draws the panel.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let areas = &model.edits.areas;
    let title = match &areas.roi {
        Some(roi) => format!("Areas  ({} % analysed)", percent(roi.share())),
        None => "Areas".to_owned(),
    };
    CollapsingHeader::new(RichText::new(title).strong()).id_salt("areas").default_open(true).show_unindented(
        ui,
        |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = theme::SPACE;
                for purpose in [Purpose::Ignore, Purpose::Analyse] {
                    let action = Action::DrawArea(purpose);
                    act(ui, model, action, m::ICON_DRAW, Some(word(purpose)), commands);
                }
                for (action, icon) in [
                    (Action::LoadMask, m::ICON_UPLOAD_FILE),
                    (Action::SaveMask, m::ICON_SAVE),
                    (Action::ClearAreas, m::ICON_DELETE_SWEEP),
                ] {
                    act(ui, model, action, icon, None, commands);
                }
            });
            if areas.is_empty() {
                ui.weak("The whole image is analysed.");
            }
            list(ui, areas, commands);
            ui.add_space(2.0 * theme::SPACE);
        },
    );
}

fn list(ui: &mut Ui, areas: &Areas, commands: &mut Vec<Command>) {
    if let Some(mask) = &areas.mask {
        let name = format!("Mask file, {} % of the frame", percent(mask.share()));
        if row(ui, m::ICON_IMAGE, ui.visuals().text_color(), &name, false).1 {
            commands.push(Command::Area(AreaEdit::DeleteMask));
        }
    }
    for (place, area) in areas.drawn.iter().enumerate() {
        let name = format!("{} {}", word(area.purpose), place + 1);
        let chosen = areas.chosen == Some(place);
        let (clicked, deleted) = row(ui, icon(area), theme::area_colour(area.purpose), &name, chosen);
        if clicked {
            commands.push(Command::Area(AreaEdit::Choose((!chosen).then_some(place))));
        }
        if deleted {
            commands.push(Command::Area(AreaEdit::Delete(place)));
        }
    }
}

const fn icon(area: &Area) -> Icon {
    match area.purpose {
        Purpose::Analyse => m::ICON_SELECT_ALL,
        Purpose::Ignore => m::ICON_BLOCK,
    }
}

/// The row of one area. Returns whether it was clicked, and whether it is to be deleted.
fn row(ui: &mut Ui, icon: Icon, colour: eframe::egui::Color32, name: &str, chosen: bool) -> (bool, bool) {
    ui.horizontal(|ui| {
        let delete = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = Button::new(m::ICON_CLOSE.rich_text().size(14.0)).frame_when_inactive(false);
            let close = ui.add(close.min_size(vec2(20.0, 18.0))).accessible_name(format!("Delete {name}"));
            let row = Button::selectable(chosen, (icons::coloured(icon, colour).size(14.0), name));
            let row = ui.with_layout(Layout::left_to_right(Align::Center), |ui| ui.add(row).clicked()).inner;
            let text = if chosen { "Delete this area (Delete)" } else { "Delete this area" };
            (row, close.on_hover_text(text).clicked())
        });
        delete.inner
    })
    .inner
}

fn act(
    ui: &mut Ui,
    model: &Model,
    action: Action,
    icon: Icon,
    word: Option<&str>,
    commands: &mut Vec<Command>,
) {
    let Some(entry) = action.entry() else { return };
    let button = match word {
        Some(word) => Button::selectable(
            model.edits.areas.draft.as_ref().is_some_and(|draft| Action::DrawArea(draft.purpose) == action),
            (icons::text(icon), word),
        ),
        None => Button::new(icons::text(icon)).frame_when_inactive(false),
    };
    let response = ui.add_enabled(is_available(model, entry), button).accessible_name(entry.text);
    if response.on_hover_text(entry.tooltip_with_keys()).clicked() {
        commands.push(Command::Act(action));
    }
}

/// A share in per cent. Only the exact shares 0 and 1 are written as 0 and 100.
fn percent(share: f32) -> String {
    let percent = share * 100.0;
    if (0.1..=99.9).contains(&percent) { format!("{percent:.1}") } else { format!("{percent:.2}") }
}
