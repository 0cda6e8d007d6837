//! From key presses to actions, by the table.

use eframe::egui::{Context, Event, Key, Modifiers, Popup};

use super::command::{ACTIONS, Command};
use super::state::Model;
use super::top_bar;

/// While it is held, the other settings are in view.
pub(crate) const FLIP: Key = Key::X;

/// The actions that make sense now and whose keys were pressed. None while text is typed, and none of the keys that move
/// or press a control while one has the focus.
pub(crate) fn pressed(ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
    if ctx.text_edit_focused() {
        return;
    }
    if let Some(slot) = model.held.filter(|_| !ctx.input(|input| input.key_down(FLIP))) {
        commands.push(Command::LetGo(slot));
    }
    let focused = ctx.memory(|memory| memory.focused().is_some());
    let menu = Popup::is_any_open(ctx);
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let Event::Key { key, pressed: true, repeat, modifiers, .. } = event else { return true };
            // Esc shuts an open menu before it does anything else.
            if menu && *key == Key::Escape {
                return true;
            }
            if focused && belongs_to_focus(*key, *modifiers) {
                return true;
            }
            let called = ACTIONS
                .iter()
                .find(|entry| entry.shortcuts.iter().any(|shortcut| shortcut.matches(*key, *modifiers)))
                // A key that has nothing to do is left to others.
                .filter(|entry| top_bar::allowed(model, entry));
            if let Some(entry) = called
                && (!repeat || entry.repeats)
            {
                commands.push(Command::Act(entry.action));
            }
            called.is_none()
        });
    });
}

fn belongs_to_focus(key: Key, modifiers: Modifiers) -> bool {
    modifiers.is_none()
        && matches!(
            key,
            Key::Space | Key::Enter | Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown
        )
}
