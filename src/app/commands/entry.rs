//! An entry of the table of actions: name, shortcuts, icon, menu.

use crate::app::commands::action::Action;
use crate::app::commands::shortcut::Shortcut;
use crate::app::icons::Icon;

/// The menu of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Menu {
    /// Open and save.
    File,
    /// Views and overlays.
    View,
    /// Settings, playback and navigation.
    Analysis,
    /// Help and information.
    Help,
}

impl Menu {
    /// All menus, in order.
    pub(crate) const ALL: [Self; 4] = [Self::File, Self::View, Self::Analysis, Self::Help];

    /// The menu's name.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::View => "View",
            Self::Analysis => "Analysis",
            Self::Help => "Help",
        }
    }
}

/// The description of an action.
#[derive(Clone, Copy)]
pub(crate) struct ActionEntry {
    /// The action.
    pub(crate) action: Action,
    /// Its name in menus, command palette and help.
    pub(crate) text: &'static str,
    /// What it does, in a sentence.
    pub(crate) tooltip: &'static str,
    /// Its shortcuts.
    pub(crate) shortcuts: &'static [Shortcut],
    /// Its icon.
    pub(crate) icon: Icon,
    /// Its menu.
    pub(crate) menu: Menu,
    /// Its submenu, if any.
    pub(crate) submenu: Option<&'static str>,
    /// Whether a separator precedes it in its menu.
    pub(crate) line_before: bool,
    /// Whether it is available without an open video.
    pub(crate) always: bool,
    /// Whether it repeats while the key is held.
    pub(crate) repeats: bool,
}

/// An entry with default options.
pub(crate) const fn entry(
    menu: Menu,
    action: Action,
    icon: Icon,
    text: &'static str,
    shortcuts: &'static [Shortcut],
    tooltip: &'static str,
) -> ActionEntry {
    ActionEntry {
        action,
        text,
        tooltip,
        shortcuts,
        icon,
        menu,
        submenu: None,
        line_before: false,
        always: false,
        repeats: false,
    }
}

impl ActionEntry {
    /// Puts a separator before the entry.
    pub(crate) const fn after_line(mut self) -> Self {
        self.line_before = true;
        self
    }

    /// Puts the entry into a submenu.
    pub(crate) const fn within(mut self, submenu: &'static str) -> Self {
        self.submenu = Some(submenu);
        self
    }

    /// Makes the action available without an open video.
    pub(crate) const fn always(mut self) -> Self {
        self.always = true;
        self
    }

    /// Lets the action repeat while its key is held.
    pub(crate) const fn repeats(mut self) -> Self {
        self.repeats = true;
        self
    }

    /// The tooltip with the shortcuts in brackets: `One frame on (Right or .)`.
    pub(crate) fn tooltip_with_keys(&self) -> String {
        let keys: Vec<String> = self.shortcuts.iter().map(|shortcut| shortcut.text()).collect();
        if keys.is_empty() {
            return self.tooltip.to_owned();
        }
        format!("{} ({})", self.tooltip, keys.join(" or "))
    }
}
