//! Playback by the window's clock, and the marks that bound it.

use crate::app::model::marks::Marks;
use crate::app::model::worker::WorkerLink;

/// The playback speeds.
pub(crate) const SPEEDS: [f32; 8] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// The index of ×1 in [`SPEEDS`].
const NORMAL_SPEED: usize = 4;

/// Playback of the open video.
#[derive(Clone, Debug)]
pub(crate) struct Playback {
    /// Whether it runs.
    pub(crate) playing: bool,
    /// The index of its speed in [`SPEEDS`].
    pub(crate) speed: usize,
    /// When the next frame is due, in seconds of the window's clock.
    next_at: f64,
    /// The marks in the open video.
    pub(crate) marks: Marks,
}

/// The longest that a frame is shown while playing at normal speed, in seconds, however long it was until the next.
const MAX_PAUSE_SECONDS: f64 = 2.0;

impl Playback {
    /// Stopped, at the normal speed, without marks.
    pub(super) fn new() -> Self {
        Self { playing: false, speed: NORMAL_SPEED, next_at: 0.0, marks: Marks::default() }
    }

    /// Starts or stops playing at a time of the window's clock, in seconds. At the end of the video it starts from the
    /// first frame.
    pub(crate) fn toggle(&mut self, worker: &mut WorkerLink, now: f64) {
        self.playing = !self.playing;
        self.next_at = now;
        let at_end = worker.timeline().is_some_and(|timeline| timeline.complete)
            && worker.position() + 1 >= worker.frames();
        if self.playing && at_end {
            worker.go_to(0);
        }
    }

    /// Requests the next frame when it is due and the previous one has arrived. Returns the seconds until the next
    /// call.
    pub(super) fn advance(&mut self, worker: &mut WorkerLink, now: f64) -> Option<f64> {
        if !self.playing {
            return None;
        }
        let position = worker.newest.as_ref()?.shown.position;
        let at_end = worker
            .timeline()
            .is_some_and(|timeline| timeline.complete && position + 1 >= timeline.numbers.len() as u32);
        let restart = self.marks.loop_restart(position, at_end);
        if at_end && restart.is_none() && worker.requested_position.is_none() {
            self.playing = false;
            return None;
        }
        // The worker wakes the window when the frame is published.
        if worker.requested_position.is_some() {
            return None;
        }
        if now < self.next_at {
            return Some(self.next_at - now);
        }
        let next = restart.unwrap_or(position + 1);
        let period = worker.seconds_to(next + 1).min(MAX_PAUSE_SECONDS) / f64::from(SPEEDS[self.speed]);
        let behind = now - self.next_at > period;
        self.next_at = if behind { now + period } else { self.next_at + period };
        worker.go_to(next);
        Some(period)
    }
}
