//! The entries that open a view and show it alone, in the View menu. They are made from [`View::ALL`].

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{Shortcut, key};
use crate::app::model::view::View;

/// The keys of the first views.
static VIEW_KEYS: [Shortcut; 9] = [
    key(Key::Num1),
    key(Key::Num2),
    key(Key::Num3),
    key(Key::Num4),
    key(Key::Num5),
    key(Key::Num6),
    key(Key::Num7),
    key(Key::Num8),
    key(Key::Num9),
];

/// An entry for each view that opens or closes it.
pub(super) fn open() -> Vec<ActionEntry> {
    let entry = |view: View| {
        let text = lasting(format!("{} view", view.title()));
        let tooltip = lasting(format!("{}\nShow or hide the view; its position is kept", view.meaning()));
        entry(Menu::View, Action::Open(view), m::ICON_VISIBILITY, text, &[], tooltip).within("Views")
    };
    View::ALL.map(entry).to_vec()
}

/// An entry for each view that maximises it.
pub(super) fn alone() -> Vec<ActionEntry> {
    let entry = |view: View| {
        let text = lasting(format!("{} alone", view.title()));
        let keys = VIEW_KEYS.get(view.index()..=view.index()).unwrap_or_default();
        let tooltip = "Maximise the view, or restore all views";
        entry(Menu::View, Action::Maximise(view), m::ICON_FULLSCREEN, text, keys, tooltip)
            .within("One view alone")
    };
    View::ALL.map(entry).to_vec()
}

/// A text of the table, which is made once and lives as long as the program.
fn lasting(text: String) -> &'static str {
    text.leak()
}
