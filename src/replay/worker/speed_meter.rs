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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_is_that_of_the_last_second_of_work() {
        let mut meter = SpeedMeter::default();
        assert_eq!(meter.frames_a_second(), 0.0, "unknown");
        let half = Duration::from_millis(500);
        for (took, frames, expected) in
            [(half, 5, 10.0), (half, 10, 15.0), (half, 20, 30.0), (Duration::from_secs(4), 2, 0.5)]
        {
            meter.add(took, frames);
            assert_eq!(meter.frames_a_second(), expected, "{frames} frames in {took:?}");
        }
    }
}
