//! What is said of an action wherever it can be called: name, keys, picture, menu.

use eframe::egui::{Key, Modifiers};

use super::command::Action;
use super::icons::Icon;

/// Under which menu an action stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Menu {
    /// Opening and writing.
    File,
    /// What is seen.
    View,
    /// Settings, playing and going from frame to frame.
    Analysis,
    /// What there is to know.
    Help,
}

impl Menu {
    /// All menus in order.
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

/// A key with what is held down with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shortcut {
    /// Ctrl (on a Mac, command).
    pub(crate) ctrl: bool,
    /// Shift, where the key itself does not need it.
    pub(crate) shift: bool,
    /// Alt (on a Mac, option).
    pub(crate) alt: bool,
    /// The key.
    pub(crate) key: Key,
}

impl Shortcut {
    /// Whether a key press means this shortcut.
    pub(crate) fn matches(self, key: Key, modifiers: Modifiers) -> bool {
        let needs_shift = matches!(self.key, Key::Questionmark | Key::Plus);
        key == self.key
            && modifiers.command == self.ctrl
            && modifiers.alt == self.alt
            && (needs_shift || modifiers.shift == self.shift)
    }

    /// As it is written in menus: `Ctrl+Shift+Z`.
    pub(crate) fn text(self) -> String {
        let key = match self.key {
            Key::ArrowLeft => "Left",
            Key::ArrowRight => "Right",
            Key::ArrowUp => "Up",
            Key::ArrowDown => "Down",
            Key::OpenBracket => "[",
            Key::CloseBracket => "]",
            Key::Comma => ",",
            Key::Period => ".",
            Key::Questionmark => "?",
            Key::Plus => "+",
            Key::Minus => "-",
            Key::Equals => "=",
            Key::Escape => "Esc",
            key => key.name(),
        };
        let ctrl = if self.ctrl { "Ctrl+" } else { "" };
        let shift = if self.shift { "Shift+" } else { "" };
        let alt = if self.alt { "Alt+" } else { "" };
        format!("{ctrl}{shift}{alt}{key}")
    }
}

/// A key alone.
pub(super) const fn key(key: Key) -> Shortcut {
    Shortcut { ctrl: false, shift: false, alt: false, key }
}

/// A key with Ctrl.
pub(super) const fn ctrl(k: Key) -> Shortcut {
    Shortcut { ctrl: true, ..key(k) }
}

/// A key with Shift.
pub(super) const fn shift(k: Key) -> Shortcut {
    Shortcut { shift: true, ..key(k) }
}

/// A key with both.
pub(super) const fn ctrl_shift(k: Key) -> Shortcut {
    Shortcut { ctrl: true, shift: true, ..key(k) }
}

/// A key with Alt.
pub(super) const fn alt(k: Key) -> Shortcut {
    Shortcut { alt: true, ..key(k) }
}

/// All that is said of an action anywhere.
pub(crate) struct Entry {
    /// What it does.
    pub(crate) action: Action,
    /// Its name in menu, palette and help.
    pub(crate) text: &'static str,
    /// What it does, in a sentence.
    pub(crate) tooltip: &'static str,
    /// The keys that call it.
    pub(crate) shortcuts: &'static [Shortcut],
    /// Its picture.
    pub(crate) icon: Icon,
    /// The menu it stands in.
    pub(crate) menu: Menu,
    /// The menu within that menu, if it stands in one.
    pub(crate) submenu: Option<&'static str>,
    /// Whether a line goes before it in its menu.
    pub(crate) line_before: bool,
    /// Whether it makes sense with nothing opened.
    pub(crate) always: bool,
    /// Whether holding the key down repeats it.
    pub(crate) repeats: bool,
}

/// What is said of most actions; the rest is added to it.
pub(super) const fn entry(
    menu: Menu,
    action: Action,
    icon: Icon,
    text: &'static str,
    shortcuts: &'static [Shortcut],
    tooltip: &'static str,
) -> Entry {
    Entry {
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

impl Entry {
    /// After a line in its menu.
    pub(super) const fn after_line(mut self) -> Self {
        self.line_before = true;
        self
    }

    /// In a menu within its menu.
    pub(super) const fn within(mut self, submenu: &'static str) -> Self {
        self.submenu = Some(submenu);
        self
    }

    /// Also with nothing opened.
    pub(super) const fn always(mut self) -> Self {
        self.always = true;
        self
    }

    /// Again and again while its key is held.
    pub(super) const fn repeats(mut self) -> Self {
        self.repeats = true;
        self
    }

    /// The sentence with the keys behind it: `One frame on (Right or .)`.
    pub(crate) fn tooltip_with_keys(&self) -> String {
        let keys: Vec<String> = self.shortcuts.iter().map(|shortcut| shortcut.text()).collect();
        if keys.is_empty() {
            return self.tooltip.to_owned();
        }
        format!("{} ({})", self.tooltip, keys.join(" or "))
    }
}
