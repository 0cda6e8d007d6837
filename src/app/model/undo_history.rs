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

/// The direction of a step in the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// To the state before the last edit.
    Undo,
    /// To the state after the edit that was undone last.
    Redo,
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
    pub(crate) fn record(&mut self, settings: &Settings) {
        let (slot, present) = &mut self.present;
        if settings == present {
            return;
        }
        let before = Box::new(std::mem::replace(present, settings.clone()));
        let slot = *slot;
        self.add(Edit::Settings { slot, before, after: Box::new(settings.clone()) });
    }

    /// Records a change of the areas.
    pub(crate) fn record_areas(&mut self, before: Areas, after: Areas) {
        self.add(Edit::Areas { before, after });
    }

    /// Records a change of the slots, each with the settings in view.
    pub(crate) fn record_slots(&mut self, before: (AbSettings, Settings), after: (AbSettings, Settings)) {
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
    pub(crate) fn set_present(&mut self, slot: AbSlot, settings: &Settings) {
        self.present = (slot, settings.clone());
    }

    /// Undoes the last edit, or redoes the edit that was undone last.
    pub(crate) fn step(&mut self, direction: Direction) -> Option<RestoredState> {
        let (from, to) = match direction {
            Direction::Undo => (&mut self.past, &mut self.future),
            Direction::Redo => (&mut self.future, &mut self.past),
        };
        let change = from.pop()?;
        to.push(change.clone());
        let undo = direction == Direction::Undo;
        Some(match change {
            Edit::Settings { slot, before, after } => self.settings(slot, *if undo { before } else { after }),
            Edit::Areas { before, after } => RestoredState::Areas(if undo { before } else { after }),
            Edit::AbSettings { before, after } => self.slots(*if undo { before } else { after }),
        })
    }

    fn settings(&mut self, slot: AbSlot, settings: Settings) -> RestoredState {
        self.present = (slot, settings.clone());
        RestoredState::Settings(slot, Box::new(settings))
    }

    fn slots(&mut self, (slots, settings): (AbSettings, Settings)) -> RestoredState {
        self.present = (slots.in_view, settings.clone());
        RestoredState::AbSettings(slots, Box::new(settings))
    }

    /// Whether there is an edit to undo.
    pub(crate) const fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Whether there is an edit to redo.
    pub(crate) const fn can_redo(&self) -> bool {
        !self.future.is_empty()
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
        history.record(&start);
        assert_eq!((history.can_undo(), history.can_redo()), (false, false));
        history.record(&two);
        history.record(&five);
        assert_eq!(
            history.step(Direction::Undo),
            Some(RestoredState::Settings(AbSlot::A, Box::new(two.clone())))
        );
        assert_eq!(
            history.step(Direction::Undo),
            Some(RestoredState::Settings(AbSlot::A, Box::new(start.clone())))
        );
        assert_eq!(history.step(Direction::Undo), None);
        assert_eq!(history.step(Direction::Redo), Some(RestoredState::Settings(AbSlot::A, Box::new(two))));
        history.record(&start);
        assert_eq!(history.step(Direction::Redo), None);
    }

    #[test]
    fn an_edit_is_undone_in_its_own_slot() {
        let start = Settings::default();
        let (two, five) = (Settings { k: 2, ..start.clone() }, Settings { k: 5, ..start.clone() });
        let mut history = UndoHistory::new(start.clone());
        history.set_present(AbSlot::B, &start);
        history.record(&five);
        history.set_present(AbSlot::A, &start);
        history.record(&two);
        history.set_present(AbSlot::B, &five);
        history.record(&five);
        assert_eq!(
            history.step(Direction::Undo),
            Some(RestoredState::Settings(AbSlot::A, Box::new(start.clone())))
        );
        assert_eq!(history.step(Direction::Undo), Some(RestoredState::Settings(AbSlot::B, Box::new(start))));
        assert_eq!(history.step(Direction::Undo), None);
        assert_eq!(history.step(Direction::Redo), Some(RestoredState::Settings(AbSlot::B, Box::new(five))));
        assert_eq!(history.step(Direction::Redo), Some(RestoredState::Settings(AbSlot::A, Box::new(two))));
    }

    #[test]
    fn a_swap_of_slots_is_undone_as_a_whole() {
        let start = Settings::default();
        let five = Settings { k: 5, ..start.clone() };
        let slots = |other: &Settings| AbSettings { in_view: AbSlot::A, other: Some(other.clone()) };
        let mut history = UndoHistory::new(start.clone());
        history.record_slots((slots(&five), start.clone()), (slots(&start), five.clone()));
        history.record(&five);
        assert_eq!(
            history.step(Direction::Undo),
            Some(RestoredState::AbSettings(slots(&five), Box::new(start.clone())))
        );
        history.record(&start);
        assert_eq!(
            history.step(Direction::Redo),
            Some(RestoredState::AbSettings(slots(&start), Box::new(five)))
        );
    }

    #[test]
    fn edits_of_areas_can_be_undone_until_another_video_is_opened() {
        let start = Settings::default();
        let five = Settings { k: 5, ..start.clone() };
        let chosen = Areas { chosen: Some(0), ..Areas::default() };
        let mut history = UndoHistory::new(start.clone());
        history.record_areas(Areas::default(), chosen.clone());
        history.record(&five);
        assert_eq!(history.step(Direction::Undo), Some(RestoredState::Settings(AbSlot::A, Box::new(start))));
        assert_eq!(history.step(Direction::Undo), Some(RestoredState::Areas(Areas::default())));
        assert_eq!(history.step(Direction::Redo), Some(RestoredState::Areas(chosen)));
        history.forget_areas();
        assert_eq!(
            (history.can_undo(), history.can_redo(), history.step(Direction::Redo)),
            (false, true, Some(RestoredState::Settings(AbSlot::A, Box::new(five))))
        );
    }
}
