//! Undo, and the settings A and B, in the Analysis menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{FLIP_KEY, ctrl, ctrl_shift, key};
use crate::app::model::ab_settings::AbSlot;

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::Analysis,
        Action::Undo,
        m::ICON_UNDO,
        "Undo",
        &[ctrl(Key::Z)],
        "Undo the last change of settings or areas",
    )
    .after_line()
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Redo,
        m::ICON_REDO,
        "Redo",
        &[ctrl_shift(Key::Z), ctrl(Key::Y)],
        "Redo the last undone change",
    )
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::DefaultSettings,
        m::ICON_RESTART_ALT,
        "Reset all settings",
        &[],
        "Set all settings to the preset `default`",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::AbSlot(AbSlot::A),
        m::ICON_COMPARE,
        "Settings A",
        &[key(Key::A)],
        "Show results under settings A",
    )
    .after_line()
    .always(),
    entry(
        Menu::Analysis,
        Action::AbSlot(AbSlot::B),
        m::ICON_COMPARE,
        "Settings B",
        &[key(Key::B)],
        "Show results under settings B; B starts as a copy of A",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::FlipSettings,
        m::ICON_SYNC_ALT,
        "Swap A and B while held",
        &[key(FLIP_KEY)],
        "Show the other settings while the key is held",
    ),
    entry(
        Menu::Analysis,
        Action::CopySettings,
        m::ICON_CONTENT_COPY,
        "Copy to other settings",
        &[],
        "Set both A and B to the current settings",
    ),
    entry(
        Menu::Analysis,
        Action::SwapSettings,
        m::ICON_SWAP_HORIZ,
        "Swap A and B",
        &[],
        "Exchange A and B; the current slot stays",
    ),
    entry(
        Menu::Analysis,
        Action::KeepSettings,
        m::ICON_DONE,
        "Keep current settings only",
        &[],
        "Keep the current settings as A and discard the others",
    ),
];
