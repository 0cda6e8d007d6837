//! Undo and redo of settings and areas.

use crate::app::model::ab_settings::{AbSettings, AbSlot};
use crate::app::model::areas::Areas;
use crate::settings::Settings;

/// Largest number of edits that can be undone.
const MAX_EDITS: usize = 200;

/// An edit.
#[derive(Clone, Debug)]
enum Edit {
    /// Of the settings of a slot.
    Settings { slot: AbSlot, before: Box<Settings>, after: Box<Settings> },
    /// Of the areas.
    Areas { before: Areas, after: Areas },
    /// Of both slots, with the settings in view.
    AbSettings { before: Box<(AbSettings, Settings)>, after: Box<(AbSettings, Settings)> },
}

/// The state that an undo or redo restores.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RestoredState {
    /// The settings of a slot.
    Settings(AbSlot, Box<Settings>),
    /// The areas.
    Areas(Areas),
    /// Both slots, and the settings in view.
    AbSettings(AbSettings, Box<Settings>),
}

/// The undo stack and the redo stack.
#[derive(Clone, Debug)]
pub(crate) struct UndoHistory {
    /// The slot in view, with the settings recorded last.
    present: (AbSlot, Settings),
    past: Vec<Edit>,
    future: Vec<Edit>,
}

impl UndoHistory {
    /// An empty history.
    pub(crate) const fn new(present: Settings) -> Self {
        Self { present: (AbSlot::A, present), past: Vec::new(), future: Vec::new() }
    }

    /// Records settings of the slot in view once they stop changing; nothing when they equal those recorded last.
    pub(crate) fn note(&mut self, settings: &Settings) {
        let (slot, present) = &mut self.present;
        if settings == present {
            return;
        }
        let before = Box::new(std::mem::replace(present, settings.clone()));
        let slot = *slot;
        self.add(Edit::Settings { slot, before, after: Box::new(settings.clone()) });
    }

    /// Records a change of the areas.
    pub(crate) fn note_areas(&mut self, before: Areas, after: Areas) {
        self.add(Edit::Areas { before, after });
    }

    /// Records a change of the slots, each with the settings in view.
    pub(crate) fn note_slots(&mut self, before: (AbSettings, Settings), after: (AbSettings, Settings)) {
        self.present = (after.0.in_view, after.1.clone());
        self.add(Edit::AbSettings { before: Box::new(before), after: Box::new(after) });
    }

    /// Drops the edits of areas, when their video is closed.
    pub(crate) fn forget_areas(&mut self) {
        for changes in [&mut self.past, &mut self.future] {
            changes.retain(|change| !matches!(change, Edit::Areas { .. }));
        }
    }

    fn add(&mut self, change: Edit) {
        self.past.push(change);
        if self.past.len() > MAX_EDITS {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// Sets the slot in view and its settings. This is no edit.
    pub(crate) fn look(&mut self, slot: AbSlot, settings: &Settings) {
        self.present = (slot, settings.clone());
    }

    /// Undoes the last edit.
    pub(crate) fn undo(&mut self) -> Option<RestoredState> {
        let change = self.past.pop()?;
        let again = match &change {
            Edit::Settings { slot, before, .. } => self.settings(*slot, Settings::clone(before)),
            Edit::Areas { before, .. } => RestoredState::Areas(before.clone()),
            Edit::AbSettings { before, .. } => self.slots((**before).clone()),
        };
        self.future.push(change);
        Some(again)
    }

    /// Redoes the edit that was undone last.
    pub(crate) fn redo(&mut self) -> Option<RestoredState> {
        let change = self.future.pop()?;
        let again = match &change {
            Edit::Settings { slot, after, .. } => self.settings(*slot, Settings::clone(after)),
            Edit::Areas { after, .. } => RestoredState::Areas(after.clone()),
            Edit::AbSettings { after, .. } => self.slots((**after).clone()),
        };
        self.past.push(change);
        Some(again)
    }

    fn settings(&mut self, slot: AbSlot, settings: Settings) -> RestoredState {
        self.present = (slot, settings.clone());
        RestoredState::Settings(slot, Box::new(settings))
    }

    fn slots(&mut self, (slots, settings): (AbSettings, Settings)) -> RestoredState {
        self.present = (slots.in_view, settings.clone());
        RestoredState::AbSettings(slots, Box::new(settings))
    }

    /// Whether there is an edit to undo, and one to redo.
    pub(crate) fn can(&self) -> (bool, bool) {
        (!self.past.is_empty(), !self.future.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_undone_and_redone_until_a_new_edit() {
        let start = Settings::default();
        let (two, five) = (Settings { k: 2, ..start.clone() }, Settings { k: 5, ..start.clone() });
        let mut history = UndoHistory::new(start.clone());
        history.note(&start);
        assert_eq!(history.can(), (false, false));
        history.note(&two);
        history.note(&five);
        assert_eq!(history.undo(), Some(RestoredState::Settings(AbSlot::A, Box::new(two.clone()))));
        assert_eq!(history.undo(), Some(RestoredState::Settings(AbSlot::A, Box::new(start.clone()))));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some(RestoredState::Settings(AbSlot::A, Box::new(two))));
        history.note(&start);
        assert_eq!(history.redo(), None);
    }

    #[test]
    fn an_edit_is_undone_in_its_own_slot() {
        let start = Settings::default();
        let (two, five) = (Settings { k: 2, ..start.clone() }, Settings { k: 5, ..start.clone() });
        let mut history = UndoHistory::new(start.clone());
        history.look(AbSlot::B, &start);
        history.note(&five);
        history.look(AbSlot::A, &start);
        history.note(&two);
        history.look(AbSlot::B, &five);
        history.note(&five);
        assert_eq!(history.undo(), Some(RestoredState::Settings(AbSlot::A, Box::new(start.clone()))));
        assert_eq!(history.undo(), Some(RestoredState::Settings(AbSlot::B, Box::new(start))));
        assert_eq!(history.undo(), None);
        assert_eq!(history.redo(), Some(RestoredState::Settings(AbSlot::B, Box::new(five))));
        assert_eq!(history.redo(), Some(RestoredState::Settings(AbSlot::A, Box::new(two))));
    }

    #[test]
    fn a_swap_of_slots_is_undone_as_a_whole() {
        let start = Settings::default();
        let five = Settings { k: 5, ..start.clone() };
        let slots = |other: &Settings| AbSettings { in_view: AbSlot::A, other: Some(other.clone()) };
        let mut history = UndoHistory::new(start.clone());
        history.note_slots((slots(&five), start.clone()), (slots(&start), five.clone()));
        history.note(&five);
        assert_eq!(history.undo(), Some(RestoredState::AbSettings(slots(&five), Box::new(start.clone()))));
        history.note(&start);
        assert_eq!(history.redo(), Some(RestoredState::AbSettings(slots(&start), Box::new(five))));
    }

    #[test]
    fn edits_of_areas_can_be_undone_until_another_video_is_opened() {
        let start = Settings::default();
        let five = Settings { k: 5, ..start.clone() };
        let chosen = Areas { chosen: Some(0), ..Areas::default() };
        let mut history = UndoHistory::new(start.clone());
        history.note_areas(Areas::default(), chosen.clone());
        history.note(&five);
        assert_eq!(history.undo(), Some(RestoredState::Settings(AbSlot::A, Box::new(start))));
        assert_eq!(history.undo(), Some(RestoredState::Areas(Areas::default())));
        assert_eq!(history.redo(), Some(RestoredState::Areas(chosen)));
        history.forget_areas();
        assert_eq!(
            (history.can(), history.redo()),
            ((false, true), Some(RestoredState::Settings(AbSlot::A, Box::new(five))))
        );
    }
}
