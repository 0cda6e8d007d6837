//! Translation of key presses to actions, by the table of actions.

use eframe::egui::{Context, Event, Key, Modifiers, Popup};

use crate::app::commands::actions::ACTIONS;
use crate::app::commands::availability::is_available;
use crate::app::commands::command::Command;
use crate::app::commands::shortcut::FLIP_KEY;
use crate::app::model::Model;

/// The available actions whose shortcuts were pressed. None while text is edited. While a control has the focus, none
/// whose key moves or activates it.
pub(crate) fn pressed(ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
    if ctx.text_edit_focused() {
        return;
    }
    if let Some(slot) = model.edits.held_slot.filter(|_| !ctx.input(|input| input.key_down(FLIP_KEY))) {
        commands.push(Command::ReleaseSlot(slot));
    }
    let focused = ctx.memory(|memory| memory.focused().is_some());
    let menu = Popup::is_any_open(ctx);
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let Event::Key { key, pressed: true, repeat, modifiers, .. } = event else { return true };
            // Esc first closes an open menu.
            if menu && *key == Key::Escape {
                return true;
            }
            if focused && belongs_to_focus(*key, *modifiers) {
                return true;
            }
            let called = ACTIONS
                .iter()
                .find(|entry| entry.shortcuts.iter().any(|shortcut| shortcut.matches(*key, *modifiers)))
                // A key without an available action is left to other controls.
                .filter(|entry| is_available(model, entry));
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
