//! Feedback: the past classification of a pixel controls its learning rate and its T.
//!
//! Leaves, water and edges under camera shake flicker: they are repeatedly foreground for a few frames. A person who
//! stands still is foreground continuously. A pixel therefore stores how long it has been foreground, and how often
//! its classification changed recently. Lasting foreground is learned slowly and does not become background within
//! seconds. The first frames of recurring foreground are learned fast, and more components of a restless pixel count
//! as background.

use crate::settings::Settings;

/// Largest share of the learned frames for which a pixel with recurring background shows the same. Values from .06 to
/// .25 were tried: at .06 a lamp is learned too slowly, at .15 people who stand and fidget in the street recur.
const MAX_STAY_SHARE: f32 = 0.1;

/// The past classification of a pixel.
///
/// While frames are only learned from, pixels are not classified. `run` is then the frame of the last change between
/// component 1 and others, `unrest` the longest time in frames between two changes, and `strict` whether the last
/// value matched another component than 1 or none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VerdictMemory {
    /// Number of frames of uninterrupted foreground, at most [`VerdictMemory::MAX_RUN_FRAMES`].
    pub run: f32,
    /// u, the unrest: a moving average of changes of the verdict under T, 0..=1.
    pub unrest: f32,
    /// Whether the last verdict under the parameter T was foreground.
    pub strict: bool,
}

impl VerdictMemory {
    /// Longest run, in frames, that is counted.
    pub const MAX_RUN_FRAMES: f32 = 1000.0;

    /// Records for the `t`-th frame, which is only learned from, whether the value is not of component 1.
    pub(super) fn record_change(&mut self, other: bool, t: u32) {
        if other != self.strict {
            self.unrest = self.unrest.max(t as f32 - self.run);
            self.run = t as f32;
        }
        self.strict = other;
    }

    /// Whether, in the `learnt` frames that were learned from, the pixel repeatedly left component 1 and returned,
    /// and never stayed with either for long.
    pub(super) fn recurs(&self, learnt: u32) -> bool {
        self.unrest.max(learnt as f32 - self.run) <= MAX_STAY_SHARE * learnt as f32
    }

    /// Records whether the pixel is foreground under the parameter T.
    pub(super) fn record_verdict(&mut self, strict: bool, feedback: &Feedback) {
        self.unrest *= feedback.keep();
        if strict != self.strict {
            self.unrest += feedback.gain;
        }
        self.strict = strict;
    }

    /// Records the final verdict.
    pub(super) fn record_final(&mut self, foreground: bool) {
        self.run = if foreground { (self.run + 1.0).min(Self::MAX_RUN_FRAMES) } else { 0.0 };
    }
}

/// The parameters of feedback on a pixel's mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// The factor on α for lasting foreground; 1 has no effect.
    pub hold: f32,
    /// Number of frames after which foreground is lasting.
    pub hold_after: f32,
    /// The factor on α of a restless pixel in the first frames of foreground; 1 has no effect.
    pub learning: f32,
    /// T of a restless pixel; no effect where it is not above T.
    pub t: f32,
    /// The increase of the unrest per change of the verdict: 1 / `unrest_memory`.
    pub gain: f32,
    /// The unrest from which on the restlessness is 1.
    pub full: f32,
}

impl Feedback {
    /// The feedback parameters in `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            hold: settings.hold,
            hold_after: settings.hold_after as f32,
            learning: settings.restless_learning,
            t: settings.restless_t,
            gain: 1.0 / settings.unrest_memory as f32,
            full: settings.unrest_full,
        }
    }

    /// Whether the past has any effect, for any T.
    pub fn is_on(&self) -> bool {
        self.hold != 1.0 || self.learning != 1.0 || self.t > 0.0
    }

    /// The factor by which the unrest decays per frame.
    pub(super) fn keep(&self) -> f32 {
        1.0 - self.gain
    }

    /// q, the restlessness of a pixel, 0..=1.
    pub fn restlessness(&self, past: &VerdictMemory) -> f32 {
        (past.unrest / self.full).min(1.0)
    }

    /// Factor on α for a pixel with this memory.
    pub fn learning_factor(&self, past: &VerdictMemory) -> f32 {
        if past.run <= 0.0 {
            1.0
        } else if past.run <= self.hold_after {
            1.0 + (self.learning - 1.0) * self.restlessness(past)
        } else {
            self.hold
        }
    }

    /// T for a pixel with this memory.
    pub fn raised_t(&self, t: f32, past: &VerdictMemory) -> f32 {
        t + (self.t.max(t) - t) * self.restlessness(past)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_recurs_that_never_stayed_for_more_than_a_tenth_of_the_learned_frames() {
        let recurs = |run: f32, unrest: f32| VerdictMemory { run, unrest, strict: false }.recurs(100);
        assert!(recurs(90.0, 10.0) && recurs(95.0, 0.0));
        assert!(!recurs(89.0, 5.0), "the last stay");
        assert!(!recurs(95.0, 11.0), "one before");
    }

    #[test]
    fn changes_while_learning_are_kept_by_their_longest_distance() {
        let mut past = VerdictMemory::default();
        for (other, t) in [(false, 2), (true, 5), (true, 6), (false, 12), (true, 14)] {
            past.record_change(other, t);
        }
        assert_eq!(past, VerdictMemory { run: 14.0, unrest: 7.0, strict: true });
    }

    #[test]
    fn feedback_is_on_where_any_part_of_it_has_an_effect() {
        let plain = crate::settings::Settings::preset(crate::settings::Preset::Plain);
        let off = Feedback::new(&plain);
        assert!(!off.is_on());
        assert!(Feedback { hold: 0.5, ..off }.is_on());
        assert!(Feedback { learning: 2.0, ..off }.is_on());
        assert!(Feedback { t: 0.1, ..off }.is_on());
    }
}
