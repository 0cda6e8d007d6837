//! The history of the chosen pixel.

use std::sync::Arc;

use crate::explain::pixel::PixelHistory;
use crate::frame::Frame;
use crate::mixture::Parameters;
use crate::registration::{CorrectionChoice, ObservedColour};
use crate::replay::tasks::gather::frame_consumer::FrameConsumer;
use crate::settings::{BackgroundModel, Settings};
use crate::source::SourceInfo;

/// Follows one pixel through all known frames, analysed or not.
///
/// It reads each frame once, to learn from and to classify, so the number of colours is its progress. A pass reads the
/// first frames twice and counts both with `PassProgress`.
#[derive(Clone, Default)]
pub(crate) struct PixelFollower {
    history: Option<Arc<PixelHistory>>,
    /// Number of each frame and the pixel's colour as the mixture's input. `history` can be shorter: it is extended
    /// on request, because it has to be copied while the previous one is shared.
    colours: Vec<(u32, ObservedColour)>,
    /// Number of first frames that are learned from before classification.
    to_learn: u32,
    /// Whether `colours` covers all frames of the source.
    complete: bool,
    /// The pixel whose history is unavailable.
    lost: Option<(u32, u32)>,
}

impl PixelFollower {
    /// Chooses a pixel, or none. The colours of the same pixel are kept, and the mixture runs over them again if its
    /// parameters differ.
    pub(crate) fn choose(&mut self, at: Option<(u32, u32)>, settings: &Settings, info: &SourceInfo) {
        let at = at.filter(|_| settings.background_model == BackgroundModel::Mixture);
        self.lost = None;
        let registration = CorrectionChoice::new(settings);
        let seen = |history: &Arc<PixelHistory>| (history.at, history.parameters.registration);
        if self.history.as_ref().map(seen) != at.map(|at| (at, registration)) {
            self.colours.clear();
            self.complete = false;
        }
        self.to_learn = info.bootstrap(settings);
        let same = |history: &Arc<PixelHistory>| {
            Some(history.at) == at && history.parameters.equal_settings(settings)
        };
        if !self.history.as_ref().is_some_and(same) {
            self.history = at.map(|at| {
                let history = PixelHistory::new(at, Parameters::new(settings));
                Arc::new(PixelHistory { placement: info.placement(), ..history })
            });
        }
    }

    /// The pixel whose history is unavailable, because the first frames are lost.
    pub(crate) const fn lost(&self) -> Option<(u32, u32)> {
        self.lost
    }

    /// Copies additional colours of the same pixel from another follower; returns whether there were any.
    pub(crate) fn copy_colours_from(&mut self, other: &Self) -> bool {
        let seen = |history: &Arc<PixelHistory>| (history.at, history.parameters.registration);
        let at = |pixel_follower: &Self| pixel_follower.history.as_ref().map(seen);
        let known = self.colours.len();
        if at(self).is_none() || at(self) != at(other) || other.colours.len() <= known {
            return false;
        }
        self.colours.extend_from_slice(&other.colours[known..]);
        self.complete = other.complete;
        true
    }

    /// Number of known frames; `None` when no pixel is chosen.
    pub(crate) fn frames(&self) -> Option<u32> {
        self.history.as_ref().map(|_| self.colours.len() as u32)
    }

    /// The number of known frames, and of those that the history needs to cover `position`; `None` when no pixel is
    /// chosen or all of them are known.
    pub(crate) fn progress_to(&self, position: u32) -> Option<(u32, u32)> {
        let known = self.frames()?;
        let to_learn = if self.complete { 0 } else { self.to_learn };
        let needed = to_learn.max(position.saturating_add(1));
        (known < needed).then_some((known, needed))
    }

    /// The history, extended if it does not contain `position`; `None` while that is unknown.
    pub(crate) fn history_covering(&mut self, position: u32) -> Option<Arc<PixelHistory>> {
        if self.frames()? <= position || !self.has_learnt() {
            return None;
        }
        if self.history.as_ref()?.states.len() as u32 <= position {
            self.latest()
        } else {
            self.history.clone()
        }
    }

    /// Whether all frames before the first classified one are known.
    const fn has_learnt(&self) -> bool {
        self.complete || self.colours.len() >= self.to_learn as usize
    }

    /// The history of all known frames.
    pub(crate) fn latest(&mut self) -> Option<Arc<PixelHistory>> {
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

impl FrameConsumer for PixelFollower {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Size;
    use crate::replay::tests::info_of;
    use crate::settings::{LightCorrection, Span, Stabilise};

    #[test]
    fn there_is_a_history_when_all_frames_to_learn_from_are_known() {
        let size = Size::new(1, 1);
        let settings = Settings { bootstrap: Span::Frames(3), ..Settings::default() };
        let mut follower = PixelFollower::default();
        follower.choose(Some((0, 0)), &settings, &info_of(size));
        let states = |history: Option<Arc<PixelHistory>>| history.map(|history| history.states.len());
        for position in 0..3 {
            assert_eq!(states(follower.history_covering(0)), None, "{position} frames");
            follower.push(position, &Frame::new(position + 1, size, vec![90; 3]));
        }
        assert_eq!(states(follower.history_covering(2)), Some(3));
        assert_eq!(states(follower.history_covering(3)), None);
        // A source with fewer frames than there are to learn from.
        let longer = Settings { bootstrap: Span::Frames(10), ..settings };
        follower.choose(Some((0, 0)), &longer, &info_of(size));
        assert_eq!(states(follower.history_covering(2)), None);
        assert!(follower.end());
        assert_eq!(states(follower.history_covering(2)), Some(3));
        assert!(!follower.end(), "nothing changes");
        follower.lose();
        assert_eq!((follower.lost(), follower.next()), (Some((0, 0)), None));
    }

    #[test]
    fn colours_are_taken_from_another_pass_where_the_correction_is_the_same() {
        let size = Size::new(1, 1);
        let settings =
            Settings { stabilise: Stabilise::Off, light: LightCorrection::Off, ..Settings::default() };
        let mut one = PixelFollower::default();
        assert!(!PixelFollower::default().copy_colours_from(&one), "no pixel is chosen");
        one.choose(Some((0, 0)), &settings, &info_of(size));
        for position in 0..2 {
            one.push(position, &Frame::new(position + 1, size, vec![90; 3]));
        }
        let mixture = Settings { alpha: 0.1, ..settings.clone() };
        let corrected = Settings { light: LightCorrection::Gain, ..settings.clone() };
        for (settings, at, frames) in
            [(&settings, (0, 0), 2), (&mixture, (0, 0), 2), (&corrected, (0, 0), 0), (&settings, (1, 0), 0)]
        {
            let mut other = PixelFollower::default();
            other.choose(Some(at), settings, &info_of(size));
            assert_eq!(other.copy_colours_from(&one), frames > 0);
            assert_eq!(other.frames(), Some(frames));
            assert!(!other.copy_colours_from(&one), "nothing is left");
        }
    }

    #[test]
    fn the_progress_counts_the_frames_to_learn_from_and_those_up_to_the_frame_in_view() {
        let size = Size::new(1, 1);
        let info = info_of(size);
        let settings = Settings { bootstrap: Span::Frames(3), ..Settings::default() };
        let mut follower = PixelFollower::default();
        assert_eq!(follower.progress_to(0), None, "no pixel is chosen");
        follower.choose(Some((0, 0)), &settings, &info);
        for position in 0..2 {
            follower.push(position, &Frame::new(position + 1, size, vec![90; 3]));
        }
        assert_eq!((follower.progress_to(0), follower.progress_to(4)), (Some((2, 3)), Some((2, 5))));
        follower.push(2, &Frame::new(3, size, vec![90; 3]));
        assert_eq!((follower.progress_to(2), follower.progress_to(3)), (None, Some((3, 4))));

        // A source with fewer frames than there are to learn from.
        let longer = Settings { bootstrap: Span::Frames(10), ..settings };
        follower.choose(Some((0, 0)), &longer, &info);
        assert_eq!(follower.progress_to(2), Some((3, 10)));
        follower.end();
        assert_eq!(follower.progress_to(2), None);
    }
}
