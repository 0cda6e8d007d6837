//! What is compared with what is in view.

use std::sync::Arc;

use super::lane::Lane;
use super::{Shown, same};
use crate::settings::Settings;

/// Another choice of settings on the same frames.
#[derive(Default)]
pub(super) struct Rival {
    /// The settings, `None` while nothing is compared.
    pub(super) settings: Option<Settings>,
    /// Their way through the sequence; none while they are equal to those in view, whose way is theirs.
    pub(super) lane: Option<Lane>,
    /// The frame that was last looked at.
    pub(super) shown: Option<Arc<Shown>>,
}

impl Rival {
    /// Whether these are its settings.
    pub(super) fn is(&self, settings: &Settings) -> bool {
        self.settings.as_ref() == Some(settings)
    }

    /// Gives up its way.
    pub(super) fn give_up(&mut self) -> Option<Lane> {
        self.shown = None;
        self.lane.take()
    }

    /// Whether the frame at a position has been analysed but is not at hand.
    pub(super) fn lags_behind(&self, position: u32) -> bool {
        let Some(lane) = &self.lane else { return false };
        lane.run.front() > position && !self.shown.as_ref().is_some_and(|shown| of(shown, lane, position))
    }

    /// Whether all that can be had of it is beside a frame in view.
    pub(super) fn is_beside(&self, shown: &Shown) -> bool {
        match (&self.settings, &self.lane) {
            (Some(_), None) => shown.beside.as_ref().is_some_and(|beside| beside.settings == shown.settings),
            (Some(_), Some(lane)) if lane.run.front() > shown.position => {
                shown.beside.as_ref().is_some_and(|beside| of(beside, lane, shown.position))
            }
            _ => shown.beside.is_none(),
        }
    }

    /// What stands beside a frame in view, as far as it is at hand.
    pub(super) fn beside(&mut self, shown: &Shown) -> Option<Arc<Shown>> {
        self.settings.as_ref()?;
        let Some(lane) = &mut self.lane else {
            return Some(Arc::new(Shown { beside: None, ..shown.clone() }));
        };
        let mine = self.shown.take_if(|mine| of(mine, lane, shown.position))?;
        let pixel = lane.inspector.covering(shown.position);
        let mine = if same(mine.pixel.as_ref(), pixel.as_ref()) {
            mine
        } else {
            Arc::new(Shown { pixel, ..Shown::clone(&mine) })
        };
        self.shown = Some(Arc::clone(&mine));
        Some(mine)
    }

    /// Whether the chosen pixel's history has come and is not yet in the frame at hand.
    pub(super) fn takes_pixel(&mut self, at: Option<(u32, u32)>) -> bool {
        let Some((lane, shown)) = self.lane.as_mut().zip(self.shown.as_ref()) else { return false };
        let of = |shown: &Shown| shown.pixel.as_ref().map(|history| history.at);
        of(shown) != at && lane.inspector.covering(shown.position).is_some()
    }
}

/// Whether a frame is the one at a position as a lane has it now.
fn of(shown: &Shown, lane: &Lane, position: u32) -> bool {
    shown.position == position && Arc::ptr_eq(&shown.settings, lane.settings())
}
