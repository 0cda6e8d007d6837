//! The chosen pixel through time.

use std::sync::Arc;

use super::gather::Follower;
use crate::frame::Frame;
use crate::mixture::{Parameters, PixelHistory};
use crate::registration::{Choice, Seen};
use crate::settings::{BackgroundModel, Settings};
use crate::source::SourceInfo;

/// Follows one pixel through all frames that are known, whether they are analysed or not.
#[derive(Clone, Default)]
pub(super) struct Inspector {
    history: Option<Arc<PixelHistory>>,
    /// The pixel's number and colour in each frame, as the mixture sees it. `history` may be behind: it is extended when
    /// somebody wants to see it, as others hold the last one and it has to be copied then.
    colours: Vec<(u32, Seen)>,
    /// So many of the first frames are learnt from before the first is judged.
    to_learn: u32,
    /// Whether `colours` are those of all frames that there are.
    complete: bool,
    /// The pixel that cannot be followed.
    lost: Option<(u32, u32)>,
}

impl Inspector {
    /// Chooses a pixel, or none; of the same pixel what was seen stays, and is taken through the
    /// mixture anew where the parameters are others.
    pub(super) fn choose(&mut self, at: Option<(u32, u32)>, settings: &Settings, info: &SourceInfo) {
        let at = at.filter(|_| settings.background_model == BackgroundModel::Mixture);
        self.lost = None;
        let registration = Choice::new(settings);
        let seen = |history: &Arc<PixelHistory>| (history.at, history.parameters.registration);
        if self.history.as_ref().map(seen) != at.map(|at| (at, registration)) {
            self.colours.clear();
            self.complete = false;
        }
        self.to_learn = info.bootstrap(settings);
        let same =
            |history: &Arc<PixelHistory>| Some(history.at) == at && history.parameters.are_of(settings);
        if !self.history.as_ref().is_some_and(same) {
            self.history = at.map(|at| Arc::new(PixelHistory::new(at, Parameters::new(settings))));
        }
    }

    /// The pixel whose history cannot be known, as the first frames are gone.
    pub(super) const fn lost(&self) -> Option<(u32, u32)> {
        self.lost
    }

    /// Takes in what another one has seen of the same pixel; whether that was more.
    pub(super) fn catch_up(&mut self, other: &Self) -> bool {
        let seen = |history: &Arc<PixelHistory>| (history.at, history.parameters.registration);
        let at = |inspector: &Self| inspector.history.as_ref().map(seen);
        let known = self.colours.len();
        if at(self).is_none() || at(self) != at(other) || other.colours.len() <= known {
            return false;
        }
        self.colours.extend_from_slice(&other.colours[known..]);
        self.complete = other.complete;
        true
    }

    /// How many frames are known, `None` when no pixel is chosen.
    pub(super) fn frames(&self) -> Option<u32> {
        self.history.as_ref().map(|_| self.colours.len() as u32)
    }

    /// The history, brought up to date if `position` is not in it yet; `None` while that is not known.
    pub(super) fn covering(&mut self, position: u32) -> Option<Arc<PixelHistory>> {
        if self.frames()? <= position || !self.has_learnt() {
            return None;
        }
        if self.history.as_ref()?.states.len() as u32 <= position {
            self.latest()
        } else {
            self.history.clone()
        }
    }

    /// Whether all is known that comes before the first frame that is judged.
    const fn has_learnt(&self) -> bool {
        self.complete || self.colours.len() >= self.to_learn as usize
    }

    /// The history brought up to date.
    pub(super) fn latest(&mut self) -> Option<Arc<PixelHistory>> {
        let has_learnt = self.has_learnt();
        let history = self.history.as_mut()?;
        if has_learnt && history.states.len() < self.colours.len() {
            let history = Arc::make_mut(history);
            if history.states.is_empty() && history.parameters.learnt == 0 {
                let first = self.colours.iter().take(self.to_learn as usize);
                history.learn_seen(first.map(|&(_, seen)| seen));
            }
            for &(number, seen) in &self.colours[history.states.len()..] {
                history.push_seen(number, seen);
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
            && let Some(seen) = history.parameters.registration.pixel(frame, history.at)
        {
            self.colours.push((frame.number, seen));
        }
    }

    fn end(&mut self) -> bool {
        let waits = self.history.is_some() && !self.has_learnt();
        self.complete |= self.history.is_some();
        waits
    }

    fn lose(&mut self) {
        let lost = self.history.as_ref().map(|history| history.at);
        *self = Self { lost, ..Self::default() };
    }
}
