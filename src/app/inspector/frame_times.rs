//! Times of frames, to show seconds beside frame numbers.

/// The times of a source's frames.
#[derive(Clone, Copy)]
pub struct FrameTimes<'a> {
    /// The average number of frames per second.
    pub fps: f32,
    /// The times of the known positions, in seconds.
    pub times: &'a [f64],
}

impl FrameTimes<'_> {
    /// The time of a position in seconds, with one decimal.
    pub(super) fn text(self, position: usize) -> String {
        let by_rate = || position as f64 / f64::from(self.fps.max(f32::MIN_POSITIVE));
        format!("{:.1}", self.times.get(position).copied().unwrap_or_else(by_rate))
    }
}
