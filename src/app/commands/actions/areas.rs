//! Areas to analyse or to ignore, in the Analysis menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{key, shift};
use crate::regions::roi::Purpose;

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Ignore),
        m::ICON_DRAW,
        "Draw ignore area",
        &[key(Key::I)],
        "Exclude an area from analysis: click corners or drag a rectangle in any view",
    )
    .within("Areas")
    .after_line(),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Analyse),
        m::ICON_SELECT_ALL,
        "Draw analysis area",
        &[shift(Key::I)],
        "Restrict analysis to such areas",
    )
    .within("Areas"),
    entry(
        Menu::Analysis,
        Action::CloseArea,
        m::ICON_CHECK,
        "Close area outline",
        &[key(Key::Enter)],
        "Connect the last corner to the first",
    )
    .within("Areas"),
    entry(
        Menu::Analysis,
        Action::UndoCorner,
        m::ICON_BACKSPACE,
        "Remove last corner",
        &[key(Key::Backspace)],
        "Remove the last corner of the area being drawn",
    )
    .within("Areas")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::CancelArea,
        m::ICON_CANCEL,
        "Cancel drawing",
        &[key(Key::Escape)],
        "Cancel the area being drawn and clear the area selection",
    )
    .within("Areas"),
    entry(
        Menu::Analysis,
        Action::DeleteArea,
        m::ICON_DELETE,
        "Delete selected area",
        &[key(Key::Delete)],
        "Delete the selected area; select one by clicking its outline or the list",
    )
    .within("Areas"),
    entry(
        Menu::Analysis,
        Action::ClearAreas,
        m::ICON_DELETE_SWEEP,
        "Clear all areas",
        &[],
        "Analyse the whole image again",
    )
    .within("Areas"),
];
