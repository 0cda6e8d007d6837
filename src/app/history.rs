//! Undo and redo of settings and areas.

use super::areas::Areas;
use super::slots::{Slot, Slots};
use crate::settings::Settings;

/// How many changes can be taken back.
const DEPTH: usize = 200;

/// One change.
#[derive(Clone, Debug)]
enum Change {
    /// Of the settings in a slot.
    Settings { slot: Slot, before: Box<Settings>, after: Box<Settings> },
    /// Of the areas.
    Areas { before: Areas, after: Areas },
    /// Of both slots at once, with the settings in view.
    Slots { before: Box<(Slots, Settings)>, after: Box<(Slots, Settings)> },
}

/// What is to be as it was.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Again {
    /// The settings in a slot.
    Settings(Slot, Box<Settings>),
    /// The areas.
    Areas(Areas),
    /// Both slots, and the settings in view.
    Slots(Slots, Box<Settings>),
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
        let before = Box::new(std::mem::replace(present, settings.clone()));
        let slot = *slot;
        self.add(Change::Settings { slot, before, after: Box::new(settings.clone()) });
    }

    /// Notes other areas.
    pub(crate) fn note_areas(&mut self, before: Areas, after: Areas) {
        self.add(Change::Areas { before, after });
    }

    /// Notes other slots, each with the settings that are in view.
    pub(crate) fn note_slots(&mut self, before: (Slots, Settings), after: (Slots, Settings)) {
        self.present = (after.0.in_view, after.1.clone());
        self.add(Change::Slots { before: Box::new(before), after: Box::new(after) });
    }

    /// Areas belong to a video, and it is no longer there.
    pub(crate) fn forget_areas(&mut self) {
        for changes in [&mut self.past, &mut self.future] {
            changes.retain(|change| !matches!(change, Change::Areas { .. }));
        }
    }

    fn add(&mut self, change: Change) {
        self.past.push(change);
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// Another slot has come into view, with these settings. To look elsewhere is no change.
    pub(crate) fn look(&mut self, slot: Slot, settings: &Settings) {
        self.present = (slot, settings.clone());
    }

    /// What was last changed, as it was before.
    pub(crate) fn undo(&mut self) -> Option<Again> {
        let change = self.past.pop()?;
        let again = match &change {
            Change::Settings { slot, before, .. } => self.settings(*slot, Settings::clone(before)),
            Change::Areas { before, .. } => Again::Areas(before.clone()),
            Change::Slots { before, .. } => self.slots((**before).clone()),
        };
        self.future.push(change);
        Some(again)
    }

    /// What was last taken back, as it was after its change.
    pub(crate) fn redo(&mut self) -> Option<Again> {
        let change = self.future.pop()?;
        let again = match &change {
            Change::Settings { slot, after, .. } => self.settings(*slot, Settings::clone(after)),
            Change::Areas { after, .. } => Again::Areas(after.clone()),
            Change::Slots { after, .. } => self.slots((**after).clone()),
        };
        self.past.push(change);
        Some(again)
    }

    fn settings(&mut self, slot: Slot, settings: Settings) -> Again {
        self.present = (slot, settings.clone());
        Again::Settings(slot, Box::new(settings))
    }

    fn slots(&mut self, (slots, settings): (Slots, Settings)) -> Again {
        self.present = (slots.in_view, settings.clone());
        Again::Slots(slots, Box::new(settings))
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
        assert_eq!(history.undo(), Some(Again::Settings(Slot::A, Box::new(two.clone()))));
        assert_eq!(history.undo(), Some(Again::Settings(Slot::A, Box::new(start.clone()))));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some(Again::Settings(Slot::A, Box::new(two))));
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
        assert_eq!(history.undo(), Some(Again::Settings(Slot::A, Box::new(start.clone()))));
        assert_eq!(history.undo(), Some(Again::Settings(Slot::B, Box::new(start))));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some(Again::Settings(Slot::B, Box::new(five))));
        assert_eq!(history.redo(), Some(Again::Settings(Slot::A, Box::new(two))));
    }

    #[test]
    fn slots_that_changed_places_come_back_together() {
        let start = Settings::default();
        let five = Settings { k: 5, ..start.clone() };
        let slots = |other: &Settings| Slots { in_view: Slot::A, other: Some(other.clone()) };
        let mut history = History::new(start.clone());
        history.note_slots((slots(&five), start.clone()), (slots(&start), five.clone()));
        history.note(&five);
        assert_eq!(history.undo(), Some(Again::Slots(slots(&five), Box::new(start.clone()))));
        history.note(&start);
        assert_eq!(history.redo(), Some(Again::Slots(slots(&start), Box::new(five))));
    }

    #[test]
    fn areas_are_taken_back_between_settings_until_another_video_is_opened() {
        let start = Settings::default();
        let five = Settings { k: 5, ..start.clone() };
        let chosen = Areas { chosen: Some(0), ..Areas::default() };
        let mut history = History::new(start.clone());
        history.note_areas(Areas::default(), chosen.clone());
        history.note(&five);
        assert_eq!(history.undo(), Some(Again::Settings(Slot::A, Box::new(start))));
        assert_eq!(history.undo(), Some(Again::Areas(Areas::default())));
        assert_eq!(history.redo(), Some(Again::Areas(chosen)));
        history.forget_areas();
        assert_eq!(
            (history.can(), history.redo()),
            ((false, true), Some(Again::Settings(Slot::A, Box::new(five))))
        );
    }
}
