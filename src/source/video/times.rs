//! The times of a video's frames in seconds.

/// Gives the time of each frame in order, in seconds since the first. Times rise from frame to frame.
#[derive(Debug)]
pub(super) struct PresentationTimes {
    /// Seconds of a tick of the stream's time base; `None` where the user gives the rate.
    tick: Option<f64>,
    /// Average number of frames per second.
    fps: f64,
    /// Presentation time of the first frame, in ticks.
    first: Option<i64>,
    /// Number of times given, and the last of them.
    given: (u32, f64),
}

impl PresentationTimes {
    /// The presentation times of the file in ticks of `tick` seconds. `fps` is the average frame rate.
    pub(super) fn of_ticks(tick: f64, fps: f32) -> Self {
        Self { tick: Some(tick), ..Self::of_rate(fps) }
    }

    /// Times of a constant frame rate.
    pub(super) fn of_rate(fps: f32) -> Self {
        Self { tick: None, fps: f64::from(fps), first: None, given: (0, 0.0) }
    }

    /// The time of the next frame, whose presentation time is `pts`. A frame whose presentation time is not later than
    /// that of the frame before it, as in some damaged videos, follows it after a period.
    pub(super) fn next(&mut self, pts: i64) -> f64 {
        let first = *self.first.get_or_insert(pts);
        let (count, last) = self.given;
        let time = match self.tick {
            _ if count == 0 => 0.0,
            None => f64::from(count) / self.fps,
            Some(tick) => {
                let time = pts.saturating_sub(first) as f64 * tick;
                if time > last { time } else { last + 1.0 / self.fps }
            }
        };
        self.given = (count + 1, time);
        time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(mut times: PresentationTimes, all: &[i64]) -> Vec<f64> {
        all.iter().map(|pts| times.next(*pts)).collect()
    }

    #[test]
    fn times_are_those_of_the_file_from_the_first_frame_on() {
        assert_eq!(times(PresentationTimes::of_ticks(0.5, 1.0), &[7, 8, 12]), [0.0, 0.5, 2.5]);
        assert_eq!(times(PresentationTimes::of_rate(4.0), &[7, 8, 12]), [0.0, 0.25, 0.5], "the user's rate");
    }

    #[test]
    fn a_time_that_does_not_rise_follows_after_a_period() {
        let of_file = PresentationTimes::of_ticks(0.5, 4.0);
        assert_eq!(times(of_file, &[0, 1, 1, 0, 4, i64::MIN]), [0.0, 0.5, 0.75, 1.0, 2.0, 2.25]);
    }
}
