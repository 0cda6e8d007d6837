//! Undo and redo of settings.

use super::slots::Slot;
use crate::settings::Settings;

/// How many changes can be taken back.
const DEPTH: usize = 200;

/// One change of the settings in a slot.
#[derive(Clone, Debug)]
struct Change {
    slot: Slot,
    before: Settings,
    after: Settings,
}

/// Changes that were made, and those that were taken back.
#[derive(Clone, Debug)]
pub(crate) struct History {
    /// The slot in view and what was last noted of it.
    present: (Slot, Settings),
    past: Vec<Change>,
    future: Vec<Change>,
}

impl History {
    /// A history that starts here.
    pub(crate) const fn new(present: Settings) -> Self {
        Self { present: (Slot::A, present), past: Vec::new(), future: Vec::new() }
    }

    /// Notes settings of the slot in view that have come to rest; nothing when they are those that
    /// were last noted.
    pub(crate) fn note(&mut self, settings: &Settings) {
        let (slot, present) = &mut self.present;
        if settings == present {
            return;
        }
        let before = std::mem::replace(present, settings.clone());
        self.past.push(Change { slot: *slot, before, after: settings.clone() });
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// Another slot has come into view, with these settings. To look elsewhere is no change.
    pub(crate) fn look(&mut self, slot: Slot, settings: &Settings) {
        self.present = (slot, settings.clone());
    }

    /// The slot that was last changed, and its settings before.
    pub(crate) fn undo(&mut self) -> Option<(Slot, Settings)> {
        let change = self.past.pop()?;
        self.present = (change.slot, change.before.clone());
        self.future.push(change);
        Some(self.present.clone())
    }

    /// The slot whose change was last taken back, and its settings after it.
    pub(crate) fn redo(&mut self) -> Option<(Slot, Settings)> {
        let change = self.future.pop()?;
        self.present = (change.slot, change.after.clone());
        self.past.push(change);
        Some(self.present.clone())
    }

    /// Whether there is something to take back, and to make again.
    pub(crate) fn can(&self) -> (bool, bool) {
        (!self.past.is_empty(), !self.future.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_taken_back_and_made_again_until_another_is_made() {
        let start = Settings::default();
        let (two, five) = (Settings { k: 2, ..start.clone() }, Settings { k: 5, ..start.clone() });
        let mut history = History::new(start.clone());
        history.note(&start);
        assert_eq!(history.can(), (false, false));
        history.note(&two);
        history.note(&five);
        assert_eq!(history.undo(), Some((Slot::A, two.clone())));
        assert_eq!(history.undo(), Some((Slot::A, start.clone())));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some((Slot::A, two)));
        history.note(&start);
        assert_eq!(history.redo(), None);
    }

    #[test]
    fn a_change_is_taken_back_in_the_slot_where_it_was_made() {
        let start = Settings::default();
        let (two, five) = (Settings { k: 2, ..start.clone() }, Settings { k: 5, ..start.clone() });
        let mut history = History::new(start.clone());
        history.look(Slot::B, &start);
        history.note(&five);
        history.look(Slot::A, &start);
        history.note(&two);
        history.look(Slot::B, &five);
        history.note(&five);
        assert_eq!(history.undo(), Some((Slot::A, start.clone())));
        assert_eq!(history.undo(), Some((Slot::B, start)));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some((Slot::B, five)));
        assert_eq!(history.redo(), Some((Slot::A, two)));
    }
}
