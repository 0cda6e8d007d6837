//! Panels, text size and theme, in the View menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::{Action, UiScale};
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::ctrl;

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::View,
        Action::SettingsPanel,
        m::ICON_TUNE,
        "Settings panel",
        &[],
        "Show or hide the settings panel on the left",
    )
    .after_line()
    .always(),
    entry(
        Menu::View,
        Action::InspectorPanel,
        m::ICON_FRAME_INSPECT,
        "Inspector and events",
        &[],
        "Show or hide the panel on the right",
    )
    .always(),
    entry(
        Menu::View,
        Action::Scale(UiScale::Larger),
        m::ICON_TEXT_INCREASE,
        "Larger text",
        &[ctrl(Key::Plus), ctrl(Key::Equals)],
        "Increase the size of text and controls",
    )
    .within("Text size")
    .always()
    .repeats(),
    entry(
        Menu::View,
        Action::Scale(UiScale::Smaller),
        m::ICON_TEXT_DECREASE,
        "Smaller text",
        &[ctrl(Key::Minus)],
        "Decrease the size of text and controls",
    )
    .within("Text size")
    .always()
    .repeats(),
    entry(
        Menu::View,
        Action::Scale(UiScale::Usual),
        m::ICON_FORMAT_SIZE,
        "Default text size",
        &[ctrl(Key::Num0)],
        "Reset text and controls to the system's size",
    )
    .within("Text size")
    .always(),
    entry(
        Menu::View,
        Action::Theme,
        m::ICON_CONTRAST,
        "Dark or light theme",
        &[],
        "Switch between the dark and the light theme",
    )
    .always(),
];
