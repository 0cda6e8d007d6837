//! What can be undone: the settings of both slots and the areas.

use crate::app::model::ab_settings::{AbSettings, AbSlot};
use crate::app::model::areas::{AreaEdit, AreaError, Areas};
use crate::app::model::undo_history::{Direction, RestoredState, UndoHistory};
use crate::frame::Size;
use crate::settings::Settings;

/// The edited state, with its history.
#[derive(Clone, Debug)]
pub(crate) struct Edits {
    /// The requested settings: those of the slot in view.
    pub(crate) settings: Settings,
    /// The slot in view, and the settings of the other slot.
    pub(crate) ab_settings: AbSettings,
    /// The slot to return to when a key is released.
    pub(crate) held_slot: Option<AbSlot>,
    /// The region of interest, and the areas that define it.
    pub(crate) areas: Areas,
    /// The edits, for undo and redo.
    pub(crate) history: UndoHistory,
}

impl Edits {
    /// These settings in slot A, without areas.
    pub(super) fn new(settings: Settings) -> Self {
        Self {
            history: UndoHistory::new(settings.clone()),
            settings,
            ab_settings: AbSettings::new(),
            held_slot: None,
            areas: Areas::default(),
        }
    }

    /// Brings the settings of a slot into view. Returns whether the slot is new.
    pub(crate) fn show_slot(&mut self, slot: AbSlot) -> bool {
        // An uncommitted edit belongs to the slot that is left.
        self.history.record(&self.settings);
        let first = self.ab_settings.other.is_none() && slot != self.ab_settings.in_view;
        self.ab_settings.show(slot, &mut self.settings);
        self.history.set_present(slot, &self.settings);
        first
    }

    /// Changes both slots in one edit.
    pub(crate) fn change_slots(&mut self, change: impl FnOnce(&mut AbSettings, &mut Settings)) {
        self.history.record(&self.settings);
        let before = (self.ab_settings.clone(), self.settings.clone());
        change(&mut self.ab_settings, &mut self.settings);
        self.history.record_slots(before, (self.ab_settings.clone(), self.settings.clone()));
    }

    /// Sets the settings of a slot, in one edit. The slot in view stays in view.
    pub(crate) fn set_slot(&mut self, slot: AbSlot, settings: Settings) {
        self.change_slots(|slots, in_view| {
            if slots.in_view == slot {
                *in_view = settings;
            } else {
                slots.other = Some(settings);
            }
        });
    }

    /// Edits the areas of an image of this size. Returns whether the region of interest changed.
    pub(crate) fn change_areas(&mut self, change: AreaEdit, size: Size) -> Result<bool, AreaError> {
        let before = self.areas.clone();
        let changed = self.areas.change(change, size)?;
        if changed {
            self.history.record_areas(Areas { draft: None, ..before }, self.areas.clone());
        }
        Ok(changed)
    }

    /// Drops the areas with their edits.
    pub(crate) fn forget_areas(&mut self) {
        self.areas = Areas::default();
        self.history.forget_areas();
    }

    /// Undoes or redoes an edit. Returns whether it was one of the areas.
    pub(crate) fn step(&mut self, direction: Direction) -> bool {
        match self.history.step(direction) {
            Some(RestoredState::Settings(slot, settings)) => {
                self.ab_settings.show(slot, &mut self.settings);
                self.settings = *settings;
                false
            }
            Some(RestoredState::AbSettings(slots, settings)) => {
                (self.ab_settings, self.settings) = (slots, *settings);
                false
            }
            Some(RestoredState::Areas(areas)) => {
                self.areas = areas;
                true
            }
            None => false,
        }
    }
}
