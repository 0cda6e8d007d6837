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

/// The settings of a video's tracking, and the present frame's number and size.
#[derive(Clone, Debug)]
pub(crate) struct Context {
    pub(crate) settings: Settings,
    pub(crate) matcher: HypothesisMatcher,
    pub(crate) limits: Limits,
    pub(crate) size: Size,
    /// Frames processed so far, the present one included.
    pub(crate) t: u32,
    /// The present frame's number.
    pub(crate) number: u32,
    /// Numbers of the last three frames, the present one last; 0 before the first.
    pub(crate) recent: [u32; 3],
}

impl Context {
    /// Before the first frame, for frames of `size` at `fps` frames a second.
    pub(crate) fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        Self {
            settings: settings.clone(),
            matcher: HypothesisMatcher::new(settings, fps),
            limits: Limits::new(settings, size, fps),
            size,
            t: 0,
            number: 0,
            recent: [0; 3],
        }
    }

    /// Goes on to the next frame, whose number is `number`.
    pub(crate) const fn advance(&mut self, number: u32) {
        self.t += 1;
        self.number = number;
        self.recent = [self.recent[1], self.recent[2], number];
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
