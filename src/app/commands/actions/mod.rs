//! The table of actions, from which menus, command palette, shortcuts, tooltips and help are made: one file for each
//! group of entries.

mod areas;
mod display;
mod file;
mod help;
mod layouts;
mod marks;
mod overlays;
mod panels;
mod playback;
mod selection;
mod settings;
#[cfg(test)]
mod tests;
mod views;

use std::sync::LazyLock;

use crate::app::commands::action::Action;
use crate::app::commands::entry::ActionEntry;

/// All actions, in menu order.
pub(crate) static ACTIONS: LazyLock<Vec<ActionEntry>> = LazyLock::new(|| {
    [
        file::ENTRIES,
        views::open().as_slice(),
        layouts::ENTRIES,
        views::alone().as_slice(),
        display::ENTRIES,
        overlays::ENTRIES,
        selection::ENTRIES,
        panels::ENTRIES,
        playback::ENTRIES,
        marks::ENTRIES,
        settings::ENTRIES,
        areas::ENTRIES,
        help::ENTRIES,
    ]
    .concat()
});

impl Action {
    /// The action's entry in the table.
    pub(crate) fn entry(self) -> Option<&'static ActionEntry> {
        ACTIONS.iter().find(|entry| entry.action == self)
    }
}
