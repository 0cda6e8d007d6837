//! What every stage of a frame's tracking reads and none changes: settings, limits and the frame's place in the video.

use crate::frame::Size;
use crate::regions::Rect;
use crate::settings::Settings;
use crate::tracking::pool::HypothesisMatcher;

/// Seconds without a region after which the region is taken to be absent.
const MAX_GAP_SECONDS: f32 = 0.2;
/// Seconds for which a region has to show more heads than it has members.
const HEAD_COUNT_SECONDS: f32 = 0.3;
/// Seconds for which an object is partly visible before its appearance is learnt anew.
const RELEARN_SECONDS: f32 = 1.5;

/// Deviations from a whole number of frame periods up to this are errors of rounding.
const MAX_TIME_ERROR_SECONDS: f64 = 0.001_5;
const MAX_TIME_ERROR_PERIODS: f64 = 0.25;
/// Largest number of frame periods between two frames: no object is followed for so long.
const MAX_PERIODS: f64 = 10_000.0;

/// The times and lengths of the settings in frames and pixels of this video.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Least area in pixels of a region that becomes an object.
    pub(crate) min_area_px: f32,
    /// Distance from the image edge in pixels within which objects enter and exit.
    pub(crate) border_px: f32,
    /// Frames in which an object must have a region before it is confirmed.
    pub(crate) min_track_frames: u32,
    /// Frames after which an occluded object is given up.
    pub(crate) max_hidden_frames: u32,
    /// Frames apart within which the same objects' shared regions are one episode.
    pub(crate) same_episode_frames: u32,
    /// Frames without a region after which the region is taken to be absent.
    pub(crate) max_gap_frames: u32,
    /// Frames in which a region has to show more heads than it has members.
    pub(crate) head_count_frames: u32,
    /// Frames after which a partly visible object's appearance is learnt anew: what seemed a part is taken for the
    /// whole.
    pub(crate) relearn_frames: u32,
    /// Frames after which an object that the image edge cuts off is confirmed.
    pub(crate) edge_wait_frames: u32,
    /// Frames for which an occluded object is reported at its predicted place (coasting).
    pub(crate) max_coast_frames: u32,
    /// Frames a second.
    pub(crate) fps: f32,
}

impl Limits {
    fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        Self {
            min_area_px: settings.track_min_area / 100.0 * size.pixels() as f32,
            border_px: settings.border / 100.0 * size.shorter_side() as f32,
            min_track_frames: settings.min_track.frames(fps),
            max_hidden_frames: settings.max_hidden.frames(fps),
            same_episode_frames: settings.same_episode.frames(fps),
            max_gap_frames: ((MAX_GAP_SECONDS * fps).round() as u32).max(3),
            head_count_frames: ((HEAD_COUNT_SECONDS * fps).round() as u32).max(3),
            relearn_frames: ((RELEARN_SECONDS * fps).round() as u32).max(10),
            max_coast_frames: settings.predict_for.frames(fps),
            fps: fps.max(1.0),
            edge_wait_frames: (fps.round() as u32).max(settings.min_track.frames(fps)),
        }
    }
}

/// A frame of the video.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FrameRef {
    /// Its number.
    pub(crate) number: u32,
    /// Its index among the processed frames, from 1.
    pub(crate) index: u32,
    /// Its time in whole frame periods, 1 in the first processed frame; two frames can have the same. It equals the
    /// index at a constant frame rate without gaps.
    pub(crate) t: u32,
}

/// The time from frame to frame in frame periods.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// Seconds.
    period: f64,
    /// Time of the last frame in seconds.
    last: Option<f64>,
    /// Sum of the periods; 1 in the first frame.
    elapsed: f64,
}

impl Clock {
    fn new(fps: f32) -> Self {
        Self { period: 1.0 / f64::from(fps.max(f32::MIN_POSITIVE)), last: None, elapsed: 0.0 }
    }

    /// Goes on to the next frame, at `time` in seconds. Gives the periods since the frame before it, 1 for the first and
    /// where the time does not rise.
    fn advance(&mut self, time: f64) -> f64 {
        let seconds = self.last.replace(time).map_or(0.0, |last| time - last);
        let periods = if seconds > 0.0 { self.periods(seconds) } else { 1.0 };
        self.elapsed += periods;
        periods
    }

    fn periods(&self, seconds: f64) -> f64 {
        // Whole milliseconds are the finest times in some files.
        let tolerance = (MAX_TIME_ERROR_SECONDS / self.period).min(MAX_TIME_ERROR_PERIODS);
        let periods = seconds / self.period;
        let whole = periods.round().max(1.0);
        let periods = if (periods - whole).abs() <= tolerance { whole } else { periods };
        periods.min(MAX_PERIODS)
    }
}

/// The settings of a video's tracking, and the present frame's number and size.
#[derive(Clone, Debug)]
pub(crate) struct Context {
    pub(crate) settings: Settings,
    pub(crate) matcher: HypothesisMatcher,
    pub(crate) limits: Limits,
    pub(crate) size: Size,
    /// The present frame's index among the processed frames, from 1.
    pub(crate) index: u32,
    /// The present frame's time in whole frame periods, as in [`FrameRef`].
    pub(crate) t: u32,
    /// The present frame's number.
    pub(crate) number: u32,
    /// The last three frames, the present one last; 0 before the first.
    pub(crate) recent: [FrameRef; 3],
    /// Frame periods from the frame before to the present one; 1 at a constant rate.
    pub(crate) periods: f32,
    clock: Clock,
}

impl Context {
    /// Before the first frame, for frames of `size` at `fps` frames a second.
    pub(crate) fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        Self {
            settings: settings.clone(),
            matcher: HypothesisMatcher::new(settings, fps),
            limits: Limits::new(settings, size, fps),
            size,
            index: 0,
            t: 0,
            number: 0,
            recent: [FrameRef::default(); 3],
            periods: 1.0,
            clock: Clock::new(fps),
        }
    }

    /// Goes on to the next frame, whose number is `number`, at `time` in seconds.
    pub(crate) fn advance(&mut self, number: u32, time: f64) {
        self.periods = self.clock.advance(time) as f32;
        self.index += 1;
        self.t = self.clock.elapsed.round() as u32;
        self.number = number;
        self.recent = [self.recent[1], self.recent[2], self.now()];
    }

    /// The present frame.
    pub(crate) const fn now(&self) -> FrameRef {
        FrameRef { number: self.number, index: self.index, t: self.t }
    }

    /// Whether a box is near the image edge.
    pub(crate) fn is_near_border(&self, bbox: &Rect) -> bool {
        bbox.distance_to_edge(self.size) <= self.limits.border_px
    }

    /// Whether a box is cut off by the image edge, as far as that can be seen.
    pub(crate) fn is_cut_off(&self, bbox: &Rect) -> bool {
        bbox.distance_to_edge(self.size) <= 1.0
    }

    /// Whether no part of a box is inside the image.
    pub(crate) fn is_outside(&self, bbox: &Rect) -> bool {
        let image = Rect::new(0.0, 0.0, self.size.width as f32, self.size.height as f32);
        bbox.intersection(&image).area() <= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn context(fps: f32) -> Context {
        Context::new(&Settings::default(), Size::new(320, 240), fps)
    }

    #[test]
    fn times_are_frames_of_the_video() {
        let of = |fps: f32| {
            let limits = context(fps).limits;
            [limits.max_gap_frames, limits.head_count_frames, limits.relearn_frames, limits.edge_wait_frames]
        };
        assert_eq!(of(25.0), [5, 8, 38, 25]);
        assert_eq!(of(50.0), [10, 15, 75, 50]);
        assert_eq!(of(5.0)[..3], [3, 3, 10], "at low rates some frames at least");
    }

    #[test]
    fn errors_of_rounding_are_whole_periods_and_gaps_count_as_long_as_they_are() {
        let mut context = context(25.0);
        // From the first frame on: a period, two, one and a millisecond, one and a half, none, backwards, a day.
        let times = [3.0, 3.04, 3.12, 3.161, 3.221, 3.221, 3.1, 86_400.0];
        let periods = times.map(|time| {
            context.advance(7, time);
            context.periods
        });
        let close = periods.iter().zip([1.0, 1.0, 2.0, 1.0, 1.5, 1.0, 1.0, 10_000.0]);
        assert!(close.clone().all(|(a, b)| (a - b).abs() < 1e-3), "{periods:?}");
        assert_eq!(context.now(), FrameRef { number: 7, index: 8, t: 10_009 });
    }

    #[test]
    fn the_image_edge() {
        let context = context(25.0);
        let at = |x: f32, y: f32| Rect::new(x, y, 20.0, 60.0);
        let outside = [at(-20.0, 90.0), at(320.0, 90.0), at(90.0, -60.0), at(90.0, 240.0)];
        assert!(outside.iter().all(|bbox| context.is_outside(bbox)));
        assert!(
            ![at(-19.0, 90.0), at(319.0, 90.0), at(90.0, 239.0)].iter().any(|bbox| context.is_outside(bbox))
        );
        assert!(context.is_cut_off(&at(1.0, 90.0)) && !context.is_cut_off(&at(2.0, 90.0)));
    }
}
