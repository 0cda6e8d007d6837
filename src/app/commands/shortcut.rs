//! Keys with modifiers.

use eframe::egui::{Key, Modifiers};

/// While this key is held, the other slot is in view.
pub(crate) const FLIP_KEY: Key = Key::X;

/// A key with its modifiers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shortcut {
    /// Ctrl, or Command on a Mac.
    pub(crate) ctrl: bool,
    /// Shift, where the key itself does not require it.
    pub(crate) shift: bool,
    /// Alt, or Option on a Mac.
    pub(crate) alt: bool,
    /// The key.
    pub(crate) key: Key,
}

impl Shortcut {
    /// Whether a key press is this shortcut.
    pub(crate) fn matches(self, key: Key, modifiers: Modifiers) -> bool {
        let needs_shift = matches!(self.key, Key::Questionmark | Key::Plus);
        key == self.key
            && modifiers.command == self.ctrl
            && modifiers.alt == self.alt
            && (needs_shift || modifiers.shift == self.shift)
    }

    /// The shortcut as written in menus: `Ctrl+Shift+Z`.
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

/// A key without modifiers.
pub(crate) const fn key(key: Key) -> Shortcut {
    Shortcut { ctrl: false, shift: false, alt: false, key }
}

/// A key with Ctrl.
pub(crate) const fn ctrl(k: Key) -> Shortcut {
    Shortcut { ctrl: true, ..key(k) }
}

/// A key with Shift.
pub(crate) const fn shift(k: Key) -> Shortcut {
    Shortcut { shift: true, ..key(k) }
}

/// A key with Ctrl and Shift.
pub(crate) const fn ctrl_shift(k: Key) -> Shortcut {
    Shortcut { ctrl: true, shift: true, ..key(k) }
}

/// A key with Alt.
pub(crate) const fn alt(k: Key) -> Shortcut {
    Shortcut { alt: true, ..key(k) }
}
