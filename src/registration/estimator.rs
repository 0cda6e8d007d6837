//! Estimates the alignment of each frame in sequence.

use std::collections::VecDeque;

use super::alignment::LevelChange;
use super::geometry::{self, Pyramid};
use super::plane::{Plane, reduction};
use super::robust;
use super::{Alignment, CorrectionChoice, Light, Motion, light};
use crate::frame::{Frame, Size};
use crate::settings::{LightCorrection, Stabilise};

/// Least side of an image in which motion is estimated, in pixels at the scale of the estimate.
const MIN_SIDE_PX: usize = 48;
/// Number of frames of the beginning: the motion of each is estimated, and a shake detected in them applies from the
/// first frame on.
pub(super) const BEGINNING_FRAMES: u32 = 50;
/// Interval of samples after the beginning, in frames.
const SAMPLE_INTERVAL_FRAMES: u32 = 6;
/// Window of samples, in frames: a camera that moved has to stay in its new position for as long.
const SAMPLE_WINDOW_FRAMES: u32 = 96;
/// Least number of samples from which a shake is detected.
const MIN_SAMPLES: usize = 16;
/// Frames over which the reference is averaged.
const AVERAGE_MEMORY_FRAMES: f32 = 100.0;
/// The average is updated in each of the first frames, this many; then once in every interval, which is shorter where
/// the camera shakes.
const INITIAL_AVERAGE_FRAMES: u32 = 16;
const RENEWAL_INTERVAL_FRAMES: u32 = 24;
const RENEWAL_INTERVAL_SHAKEN_FRAMES: u32 = 12;
/// Number of frames after which the reference is good enough for an estimate at its points alone.
const MIN_REFERENCE_FRAMES: u32 = 8;
/// Least distance from rest, in pixels, of the image's centre or edge in a shaken frame.
const MIN_SHAKE_PX: f32 = 0.7;
/// Least share of shaken samples of a shaking camera.
const MIN_SHAKEN_SHARE: f32 = 0.3;
/// Least correlation of a frame with the reference; below it the frame shows something else.
const MIN_CORRELATION: f32 = 0.35;
/// Least distance of a new rest of the camera from the old one, as a share of the width.
const MIN_MOVED_SHARE: f32 = 0.012;

/// For which frames the motion is estimated. Samples are always among them, and the rest, the light and the report
/// that the camera moved depend on samples alone.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MeasuredFrames {
    /// For all frames.
    All,
    /// For all frames once a shake is detected.
    Shaken,
    /// For samples only.
    Samples,
}

/// The motion estimate of a sample.
struct MotionSample {
    motion: Motion,
    correlation: f32,
    /// Whether the motion explains the frame far better than no motion.
    is_clear: bool,
    number: u32,
    /// The index of its frame.
    at: u32,
}

/// Estimates the alignment of the frames of a sequence in order. Each result depends only on its frame and earlier
/// ones.
pub struct Estimator {
    size: Size,
    factor: usize,
    measured: MeasuredFrames,
    frames: u32,
    average: Plane,
    reference: Option<geometry::MotionReference>,
    light: Option<light::LightReference>,
    /// The recent samples.
    window: VecDeque<MotionSample>,
    rest: Option<Motion>,
    /// The last known rest position of the camera.
    settled: Motion,
    /// The usual residual of the motion estimate, in levels.
    usual: f32,
}

impl Estimator {
    /// An estimator for frames of this size that measures everything in each frame.
    pub fn new(size: Size) -> Self {
        Self {
            size,
            factor: reduction(size.width as usize, size.height as usize),
            measured: MeasuredFrames::All,
            frames: 0,
            average: Plane::default(),
            reference: None,
            light: Some(light::LightReference::new(size)),
            window: VecDeque::new(),
            rest: None,
            settled: Motion::NONE,
            usual: f32::MAX,
        }
    }

    /// An estimator that measures only what `choice` corrects and, in samples, whether the camera moved for good.
    pub fn of(size: Size, choice: CorrectionChoice) -> Self {
        let no_light = choice.light == LightCorrection::Off;
        let measured = match choice.stabilise {
            Stabilise::Off if no_light => MeasuredFrames::Samples,
            // Light is compared at corresponding points, which a shake displaces.
            Stabilise::Off | Stabilise::Auto => MeasuredFrames::Shaken,
            Stabilise::Shift | Stabilise::Similarity => MeasuredFrames::All,
        };
        let all = Self::new(size);
        Self { measured, light: all.light.filter(|_| !no_light), ..all }
    }

    /// The rest motion around which the camera shakes, once a shake is detected.
    pub const fn rest(&self) -> Option<Motion> {
        self.rest
    }

    /// Estimates the alignment of the next frame.
    pub fn step(&mut self, frame: &Frame) -> Alignment {
        if frame.size != self.size {
            return Alignment::default();
        }
        let (width, height) =
            (self.size.width as usize / self.factor, self.size.height as usize / self.factor);
        if width.min(height) < MIN_SIDE_PX {
            return Alignment { light: self.light_of(frame, &Motion::NONE), ..Alignment::default() };
        }
        self.frames += 1;
        let is_sample = self.frames <= BEGINNING_FRAMES || self.frames.is_multiple_of(SAMPLE_INTERVAL_FRAMES);
        let is_wanted = match self.measured {
            MeasuredFrames::All => true,
            MeasuredFrames::Shaken => self.rest.is_some(),
            MeasuredFrames::Samples => false,
        };
        let mut motion = Motion::NONE;
        let mut moved_since = None;
        if is_sample || is_wanted {
            let mut pyramid = None;
            let found = self.find(frame, &mut pyramid);
            let factor = self.factor as f32;
            motion = Motion { dx: found.motion.dx * factor, dy: found.motion.dy * factor, ..found.motion };
            if is_sample {
                moved_since = self.take_sample(frame, &found, &motion, pyramid);
            }
        }
        // Between samples motion is known only where it is needed.
        let is_known = self.rest.is_some() || self.frames <= BEGINNING_FRAMES;
        let place = if is_known { motion } else { Motion::NONE };
        let light = self.light_of(frame, &place);
        Alignment { motion, light, rest: self.rest, moved_since }
    }

    fn light_of(&mut self, frame: &Frame, motion: &Motion) -> Light {
        self.light.as_mut().map_or(Light::SAME, |light| light.step(frame, motion))
    }

    /// The motion estimate of a frame, at the scale of the estimate. Changes no state.
    fn find(&self, frame: &Frame, pyramid: &mut Option<Pyramid>) -> geometry::MotionEstimate {
        let usable = self.reference.as_ref().filter(|reference| reference.is_usable());
        let Some(reference) = usable else {
            return geometry::MotionEstimate::NOTHING;
        };
        let calm = self.frames > MIN_REFERENCE_FRAMES
            && self.rest.is_none()
            && self.window.iter().all(|seen| seen.motion == Motion::NONE);
        let still = if calm { reference.find_still(frame, self.factor, self.usual) } else { None };
        still.unwrap_or_else(|| {
            let frame = pyramid.insert(Pyramid::new(Plane::luma(frame, self.factor)));
            reference.find(frame, self.rest.is_some())
        })
    }

    /// Updates the state from a sample; returns the frame since which the camera has moved, if that is now certain.
    fn take_sample(
        &mut self,
        frame: &Frame,
        found: &geometry::MotionEstimate,
        motion: &Motion,
        pyramid: Option<Pyramid>,
    ) -> Option<u32> {
        self.usual = found.cost.min(1.01 * self.usual);
        let &geometry::MotionEstimate { correlation, is_clear, .. } = found;
        let renewal =
            if self.rest.is_some() { RENEWAL_INTERVAL_SHAKEN_FRAMES } else { RENEWAL_INTERVAL_FRAMES };
        let renews = self.frames <= INITIAL_AVERAGE_FRAMES || self.frames.is_multiple_of(renewal);
        if renews && (correlation >= MIN_CORRELATION || self.frames == 1) {
            let plane = pyramid.map_or_else(|| Plane::luma(frame, self.factor), |Pyramid([.., plane])| plane);
            self.learn(plane, found, if self.frames <= INITIAL_AVERAGE_FRAMES { 1 } else { renewal });
        }
        let at = self.frames;
        self.window.push_back(MotionSample {
            motion: *motion,
            correlation,
            is_clear,
            number: frame.number,
            at,
        });
        while self.window.front().is_some_and(|seen| seen.at + SAMPLE_WINDOW_FRAMES <= at) {
            self.window.pop_front();
        }
        let moved_since = self.moved_since(frame);
        let enough = if at <= BEGINNING_FRAMES { BEGINNING_FRAMES as usize / 2 } else { MIN_SAMPLES };
        if self.rest.is_none() && self.window.len() >= enough {
            self.rest = self.shakes_around();
        }
        moved_since
    }

    /// Averages the frame into the reference, with the weight of `frames` frames.
    fn learn(&mut self, plane: Plane, found: &geometry::MotionEstimate, frames: u32) {
        if self.average.data.len() == plane.data.len() {
            let rate = (frames as f32 / AVERAGE_MEMORY_FRAMES).max(1.0 / self.frames as f32);
            blend(&mut self.average, &plane, found, rate);
        } else {
            self.average = plane;
        }
        self.reference = Some(geometry::MotionReference::new(&self.average));
    }

    /// The median motion of the samples, if enough of them deviate from it.
    fn shakes_around(&self) -> Option<Motion> {
        let rest = self.middle();
        let half = 0.5 * self.size.width as f32;
        let shaken = |seen: &&MotionSample| {
            let motion = &seen.motion;
            let away = Motion { dx: motion.dx - rest.dx, dy: motion.dy - rest.dy, ..*motion };
            let far =
                away.length() > MIN_SHAKE_PX || half * (motion.turn - rest.turn).abs() > 2.0 * MIN_SHAKE_PX;
            far && (seen.is_clear || motion.length() < MIN_SHAKE_PX)
        };
        let count = self.window.iter().filter(shaken).count();
        (count as f32 > MIN_SHAKEN_SHARE * self.window.len() as f32).then_some(rest)
    }

    /// The median of each parameter over the samples.
    fn middle(&self) -> Motion {
        let median = |number: fn(&Motion) -> f32| {
            let mut all: Vec<f32> = self.window.iter().map(|seen| number(&seen.motion)).collect();
            robust::median(&mut all)
        };
        Motion {
            dx: median(|motion| motion.dx),
            dy: median(|motion| motion.dy),
            turn: median(|motion| motion.turn),
            zoom: median(|motion| motion.zoom),
        }
    }

    /// Whether all samples show that the camera moved, and the frame of the first of them.
    fn moved_since(&mut self, frame: &Frame) -> Option<u32> {
        if self.frames <= BEGINNING_FRAMES {
            self.settled = self.middle();
            return None;
        }
        let first = self.window.front().map_or(0, |seen| seen.number);
        if self.window.iter().all(|seen| seen.correlation < MIN_CORRELATION) {
            // The old reference is no longer in view; the current frame becomes the reference.
            self.average = Plane::luma(frame, self.factor);
            self.reference = Some(geometry::MotionReference::new(&self.average));
            (self.frames, self.settled, self.usual) = (1, Motion::NONE, f32::MAX);
            self.rest = self.rest.map(|_| Motion::NONE);
            if let Some(light) = &mut self.light {
                light.restart();
            }
            self.window.clear();
            return Some(first);
        }
        let middle = self.middle();
        let width = self.size.width as f32;
        let far = |one: &Motion, other: &Motion| {
            let shift = Motion { dx: one.dx - other.dx, dy: one.dy - other.dy, ..Motion::NONE }.length();
            let edge = 0.5 * width * ((one.turn - other.turn).abs() + (one.zoom - other.zoom).abs());
            shift.max(edge)
        };
        let away = far(&middle, &self.settled);
        let settled_elsewhere = |seen: &MotionSample| {
            far(&seen.motion, &self.settled) > 0.5 * away && far(&seen.motion, &middle) < 0.25 * away
        };
        let moved = away > (MIN_MOVED_SHARE * width).max(2.0) && self.window.iter().all(settled_elsewhere);
        if moved {
            self.settled = middle;
        }
        moved.then_some(first)
    }
}

/// Blends a frame, aligned by `found` and in the average's light, into the average.
fn blend(average: &mut Plane, frame: &Plane, found: &geometry::MotionEstimate, rate: f32) {
    let geometry::MotionEstimate { motion, light: LevelChange { gain, offset }, .. } = found;
    let relit = |value: f32| (value - offset) / gain;
    if *motion == Motion::NONE {
        for (mean, value) in average.data.iter_mut().zip(&frame.data) {
            *mean += rate * (relit(*value) - *mean);
        }
        return;
    }
    let (centre_x, centre_y) = (0.5 * (frame.width as f32 - 1.0), 0.5 * (frame.height as f32 - 1.0));
    for (y, row) in average.data.chunks_exact_mut(frame.width.max(1)).enumerate() {
        for (x, mean) in row.iter_mut().enumerate() {
            let (x, y) = motion.apply(x as f32 - centre_x, y as f32 - centre_y);
            if let Some(value) = frame.at(x + centre_x, y + centre_y) {
                *mean += rate * (relit(value) - *mean);
            }
        }
    }
}
