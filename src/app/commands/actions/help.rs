//! The Help menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{ctrl, key};

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::Help,
        Action::Palette,
        m::ICON_SEARCH,
        "Command palette…",
        &[ctrl(Key::K)],
        "Find an action or a setting by name",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Help,
        m::ICON_KEYBOARD,
        "Keyboard and mouse",
        &[key(Key::Questionmark), key(Key::F1)],
        "List all keyboard and mouse controls",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Messages,
        m::ICON_LIST_ALT,
        "Messages",
        &[],
        "All messages since the program started",
    )
    .always(),
    entry(
        Menu::Help,
        Action::About,
        m::ICON_INFO,
        "About Occluscope",
        &[],
        "Version, graphics card, OpenCV and threads, for bug reports",
    )
    .after_line()
    .always(),
];
