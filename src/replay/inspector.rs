//! The chosen pixel through time.

use std::sync::Arc;

use super::gather::Follower;
use crate::frame::Frame;
use crate::mixture::{Parameters, PixelHistory};
use crate::settings::{BackgroundModel, Settings};

/// Follows one pixel through all frames that are known, whether they are analysed or not.
#[derive(Clone, Default)]
pub(super) struct Inspector {
    history: Option<Arc<PixelHistory>>,
    /// The pixel's number and colour in each frame. `history` may be behind: it is extended when
    /// somebody wants to see it, as others hold the last one and it has to be copied then.
    colours: Vec<(u32, [u8; 3])>,
    /// The pixel that cannot be followed.
    lost: Option<(u32, u32)>,
}

impl Inspector {
    /// Chooses a pixel, or none; of the same pixel what was seen stays, and is taken through the
    /// mixture anew where the parameters are others.
    pub(super) fn choose(&mut self, at: Option<(u32, u32)>, settings: &Settings) {
        let at = at.filter(|_| settings.background_model == BackgroundModel::Mixture);
        self.lost = None;
        let parameters = Parameters::new(settings);
        if self.history.as_ref().map(|history| history.at) != at {
            self.colours.clear();
        }
        let same = |history: &Arc<PixelHistory>| Some(history.at) == at && history.parameters == parameters;
        if !self.history.as_ref().is_some_and(same) {
            self.history = at.map(|at| Arc::new(PixelHistory::new(at, parameters)));
        }
    }

    /// The pixel whose history cannot be known, as the first frames are gone.
    pub(super) const fn lost(&self) -> Option<(u32, u32)> {
        self.lost
    }

    /// Takes in what another one has seen of the same pixel; whether that was more.
    pub(super) fn catch_up(&mut self, other: &Self) -> bool {
        let at = |inspector: &Self| inspector.history.as_ref().map(|history| history.at);
        let known = self.colours.len();
        if at(self).is_none() || at(self) != at(other) || other.colours.len() <= known {
            return false;
        }
        self.colours.extend_from_slice(&other.colours[known..]);
        true
    }

    /// How many frames are known, `None` when no pixel is chosen.
    pub(super) fn frames(&self) -> Option<u32> {
        self.history.as_ref().map(|_| self.colours.len() as u32)
    }

    /// The history, brought up to date if `position` is not in it yet; `None` while that is not known.
    pub(super) fn covering(&mut self, position: u32) -> Option<Arc<PixelHistory>> {
        if self.frames()? <= position {
            return None;
        }
        if self.history.as_ref()?.states.len() as u32 <= position {
            self.latest()
        } else {
            self.history.clone()
        }
    }

    /// The history brought up to date.
    pub(super) fn latest(&mut self) -> Option<Arc<PixelHistory>> {
        let history = self.history.as_mut()?;
        if history.states.len() < self.colours.len() {
            let history = Arc::make_mut(history);
            for &(number, colour) in &self.colours[history.states.len()..] {
                history.push_colour(number, colour);
            }
        }
        Some(Arc::clone(history))
    }
}

impl Follower for Inspector {
    fn next(&self) -> Option<u32> {
        self.frames()
    }

    fn push(&mut self, position: u32, frame: &Frame) {
        if let Some(history) = &self.history
            && self.frames() == Some(position)
            && let Some(colour) = frame.pixel(history.at.0, history.at.1)
        {
            self.colours.push((frame.number, colour));
        }
    }

    fn lose(&mut self) {
        let lost = self.history.as_ref().map(|history| history.at);
        *self = Self { lost, ..Self::default() };
    }
}
