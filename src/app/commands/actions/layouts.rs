//! Layouts, in the View menu.

use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::model::layout::ViewLayout;

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::All),
        m::ICON_GRID_VIEW,
        "Default layout",
        &[],
        "Reset all views and panels to their default positions",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Figure),
        m::ICON_VIEW_MODULE,
        "Paper figure",
        &[],
        "Six views of equal size without panels, for a figure in a paper",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Tuning),
        m::ICON_TUNE,
        "Tuning",
        &[],
        "Settings panel with input, foreground and tracks",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Compare),
        m::ICON_COMPARE,
        "Compare",
        &[],
        "Settings panel with masks and tracks under A and B",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Inspect),
        m::ICON_FRAME_INSPECT,
        "Inspect a pixel",
        &[],
        "Large input view with the pixel inspector",
    )
    .within("Layout")
    .always(),
];
