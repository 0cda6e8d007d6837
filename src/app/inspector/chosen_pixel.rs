//! The chosen pixel in the frame in view, and the slots of its components.

use std::sync::Arc;

use super::frame_times::FrameTimes;
use crate::explain::pixel::component_slots;
use crate::explain::pixel::{PixelHistory, PixelState};
use crate::mixture::pixel::MAX_K;

/// A history with the slots of its components; recomputed only for another history.
#[derive(Clone, Debug, PartialEq)]
pub struct SlottedHistory {
    /// The history.
    pub(super) history: Arc<PixelHistory>,
    /// Slots by rank, one set for each state.
    pub(super) slots: Arc<Vec<[u8; MAX_K]>>,
}

/// The chosen pixel in the frame in view.
#[derive(Clone, Copy)]
pub(super) struct ChosenPixel<'a> {
    /// The history of the pixel.
    pub(super) history: &'a Arc<PixelHistory>,
    /// Slots by rank, one set for each state; a component's slot determines its colour.
    pub(super) slots: &'a Arc<Vec<[u8; MAX_K]>>,
    /// Index of the state of the frame in view.
    pub(super) index: usize,
    /// That state.
    pub(super) state: &'a PixelState,
    /// The times of the frames.
    pub(super) times: FrameTimes<'a>,
}

impl ChosenPixel<'_> {
    /// The history with its slots, with shared ownership.
    pub(super) fn slotted_history(&self) -> SlottedHistory {
        SlottedHistory { history: Arc::clone(self.history), slots: Arc::clone(self.slots) }
    }

    /// Whether the first `end` states equal those of `made_of`, a history from which something was computed. If so,
    /// the present history replaces `made_of`.
    pub(super) fn shares(&self, made_of: &mut Arc<PixelHistory>, end: usize) -> bool {
        if Arc::ptr_eq(made_of, self.history) {
            return true;
        }
        // A history only grows: many times a second during the analysis.
        let shares = end <= made_of.states.len() && self.history.extends(made_of);
        if shares {
            *made_of = Arc::clone(self.history);
        }
        shares
    }

    /// The names of the value's channels, as many as it has.
    pub(super) fn channels(&self) -> &'static [&'static str] {
        self.history.parameters.channel_names()
    }
}

/// The slots of a history's components. Computed only for frames that `known` lacks, which becomes this history.
pub(super) fn slotted(
    known: &mut Option<SlottedHistory>,
    history: &Arc<PixelHistory>,
) -> Arc<Vec<[u8; MAX_K]>> {
    match known {
        // The old history is kept alive, so that equal addresses imply the same history.
        Some(followed) if Arc::ptr_eq(&followed.history, history) => Arc::clone(&followed.slots),
        Some(followed) if history.extends(&followed.history) => {
            component_slots::extend_slots(Arc::make_mut(&mut followed.slots), history);
            followed.history = Arc::clone(history);
            Arc::clone(&followed.slots)
        }
        _ => {
            let slots = Arc::new(component_slots::slots_by_rank(history));
            *known = Some(SlottedHistory { history: Arc::clone(history), slots: Arc::clone(&slots) });
            slots
        }
    }
}
