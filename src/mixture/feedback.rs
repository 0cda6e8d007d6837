//! Feedback: what was decided about a pixel changes how fast it learns and what is background to it.
//!
//! Leaves, water and the edges of a shaken picture flicker: they are foreground for a few frames, again and
//! again. A person who stands still is foreground without a break. So a pixel remembers for how long it has been
//! foreground, and how often the verdict changed lately. Foreground that lasts is learned slowly, and is not
//! taken for background within seconds; the first frames of a foreground that comes and goes are learned fast,
//! and more of what a restless pixel shows counts as background.

use crate::settings::Settings;

/// Largest share of the learnt frames for which a pixel with recurring background shows the same. Tried from .06 to
/// .25: at .06 a lamp is too slow, at .15 people in the street who stand and fidget recur.
const MAX_STAY_SHARE: f32 = 0.1;

/// Memory of the verdicts about a pixel.
///
/// While frames are only learnt from, nothing is decided: `run` is then the frame in which it last changed between
/// component 1 and anything else, `unrest` the longest time in frames between two changes, and `strict` whether it last
/// showed anything else.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VerdictMemory {
    /// For how many frames it has been foreground without a break, at most [`VerdictMemory::MAX_RUN_FRAMES`].
    pub run: f32,
    /// u, the unrest: the share of recent frames in which the verdict under T changed, 0..=1.
    pub unrest: f32,
    /// Whether the last verdict under T itself was foreground.
    pub strict: bool,
}

impl VerdictMemory {
    /// Longest run, in frames, that is counted.
    pub const MAX_RUN_FRAMES: f32 = 1000.0;

    /// Records for the `t`-th frame, which is only learnt from, whether it shows anything but component 1.
    pub(super) fn record_change(&mut self, other: bool, t: u32) {
        if other != self.strict {
            self.unrest = self.unrest.max(t as f32 - self.run);
            self.run = t as f32;
        }
        self.strict = other;
    }

    /// Whether in the `learnt` frames that were learnt from, the pixel returned to component 1 and left it
    /// repeatedly, never staying with either for long.
    pub(super) fn recurs(&self, learnt: u32) -> bool {
        self.unrest.max(learnt as f32 - self.run) <= MAX_STAY_SHARE * learnt as f32
    }

    /// Records whether the pixel is foreground under T.
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

/// How a pixel's past verdicts act on its mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// The share of α with which foreground is learned that has lasted; 1 is no difference.
    pub hold: f32,
    /// For how many frames foreground has to have lasted.
    pub hold_after: f32,
    /// How many times α is the rate of a restless pixel while foreground is young; 1 is no difference.
    pub learning: f32,
    /// T of a restless pixel, where it is above T.
    pub t: f32,
    /// What one change of the verdict adds to the unrest: 1 / `unrest_memory`.
    pub gain: f32,
    /// The unrest from which on a pixel is restless in full.
    pub full: f32,
}

impl Feedback {
    /// The part of `settings` about feedback.
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

    /// Whether the past makes any difference, whatever T is.
    pub fn is_on(&self) -> bool {
        self.hold != 1.0 || self.learning != 1.0 || self.t > 0.0
    }

    /// By what the unrest is multiplied in each frame.
    pub(super) fn keep(&self) -> f32 {
        1.0 - self.gain
    }

    /// q, how restless a pixel is, 0..=1.
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
