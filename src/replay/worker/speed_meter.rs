//! Speed of the analysis in frames per second.

use std::collections::VecDeque;
use std::time::Duration;

/// Speed of the analysis over about its last second of work.
#[derive(Default)]
pub(super) struct SpeedMeter {
    pieces: VecDeque<(Duration, u32)>,
    took: Duration,
    frames: u32,
}

impl SpeedMeter {
    pub(super) fn add(&mut self, took: Duration, frames: u32) {
        self.pieces.push_back((took, frames));
        self.took += took;
        self.frames += frames;
        while self.took > Duration::from_secs(1) && self.pieces.len() > 1 {
            let (took, frames) = self.pieces.pop_front().unwrap_or_default();
            self.took -= took;
            self.frames -= frames;
        }
    }

    pub(super) fn frames_a_second(&self) -> f32 {
        if self.took.is_zero() { 0.0 } else { self.frames as f32 / self.took.as_secs_f32() }
    }
}
