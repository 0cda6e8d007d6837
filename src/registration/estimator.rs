//! The alignment of each frame, one after the other.

use std::collections::VecDeque;

use super::geometry::{self, Pyramid};
use super::plane::{Plane, reduction};
use super::robust;
use super::{Alignment, CorrectionChoice, Light, Motion, light};
use crate::frame::{Frame, Size};
use crate::settings::{LightCorrection, Stabilise};

/// Least side of an image in which motion is estimated, in pixels at the scale of the estimate.
const MIN_SIDE_PX: usize = 48;
/// Number of frames of the beginning: the motion of each is estimated, and a shake detected in them holds from the
/// first on.
pub(super) const BEGINNING_FRAMES: u32 = 50;
/// Interval of samples after the beginning, in frames.
const SAMPLE_INTERVAL_FRAMES: u32 = 6;
/// Window of samples, in frames: a camera that moved has to stay there for as long.
const SAMPLE_WINDOW_FRAMES: u32 = 96;
/// Least number of samples from which a shake is detected.
const MIN_SAMPLES: usize = 16;
/// Frames over which the reference is averaged.
const AVERAGE_MEMORY_FRAMES: f32 = 100.0;
/// The average takes in each of so many frames, and then one of so many, fewer where the camera shakes.
const INITIAL_AVERAGE_FRAMES: u32 = 16;
const RENEWAL_INTERVAL_FRAMES: u32 = 24;
const RENEWAL_INTERVAL_SHAKEN_FRAMES: u32 = 12;
/// After so many frames the reference is good enough for a look at its points alone.
const MIN_REFERENCE_FRAMES: u32 = 8;
/// Least distance from rest, in pixels, of the image's centre or edge in a shaken frame.
const MIN_SHAKE_PX: f32 = 0.7;
/// Least share of shaken samples of a shaking camera.
const MIN_SHAKEN_SHARE: f32 = 0.3;
/// Least correlation of a frame with the reference; below it the frame shows something else.
const MIN_CORRELATION: f32 = 0.35;
/// Least distance of a new rest of the camera from the old one, as a share of the width.
const MIN_MOVED_SHARE: f32 = 0.012;

/// Of which frames the motion is found. Samples are among them in any case, and all else follows from samples alone: the
/// rest, the light and the report that the camera moved do not depend on it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extent {
    /// Of all.
    All,
    /// Of all once the camera was seen to shake.
    Shaken,
    /// Of samples.
    Samples,
}

/// The estimate of a sample.
struct MotionSample {
    motion: Motion,
    correlation: f32,
    /// Whether the motion explains far more than none does.
    is_clear: bool,
    number: u32,
    /// Its place among the frames.
    at: u32,
}

/// Estimates the alignment of the frames of a sequence, in order; each result depends on its frame and those before
/// it only.
pub struct Estimator {
    size: Size,
    factor: usize,
    extent: Extent,
    frames: u32,
    average: Plane,
    reference: Option<geometry::Reference>,
    light: Option<light::Reference>,
    /// What was seen lately, in samples.
    window: VecDeque<MotionSample>,
    rest: Option<Motion>,
    /// Where the camera was last known to rest.
    settled: Motion,
    /// What the motion usually leaves unexplained of a frame, in levels.
    usual: f32,
}

impl Estimator {
    /// Nothing seen yet of frames of this size; everything is measured of each.
    pub fn new(size: Size) -> Self {
        Self {
            size,
            factor: reduction(size.width as usize, size.height as usize),
            extent: Extent::All,
            frames: 0,
            average: Plane::default(),
            reference: None,
            light: Some(light::Reference::new(size)),
            window: VecDeque::new(),
            rest: None,
            settled: Motion::NONE,
            usual: f32::MAX,
        }
    }

    /// Measures no more than what is to be taken out, and, in samples, whether the camera moved for good.
    pub fn of(size: Size, choice: CorrectionChoice) -> Self {
        let no_light = choice.light == LightCorrection::Off;
        let extent = match choice.stabilise {
            Stabilise::Off if no_light => Extent::Samples,
            // Light is compared place by place, wherever the places have been shaken to.
            Stabilise::Off | Stabilise::Auto => Extent::Shaken,
            Stabilise::Shift | Stabilise::Similarity => Extent::All,
        };
        let all = Self::new(size);
        Self { extent, light: all.light.filter(|_| !no_light), ..all }
    }

    /// The motion around which the camera shakes, once that was seen.
    pub const fn rest(&self) -> Option<Motion> {
        self.rest
    }

    /// Measures the next frame.
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
        let is_wanted = match self.extent {
            Extent::All => true,
            Extent::Shaken => self.rest.is_some(),
            Extent::Samples => false,
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
        // Between samples motion is known where it is wanted alone.
        let is_known = self.rest.is_some() || self.frames <= BEGINNING_FRAMES;
        let place = if is_known { motion } else { Motion::NONE };
        let light = self.light_of(frame, &place);
        Alignment { motion, light, rest: self.rest, moved_since }
    }

    fn light_of(&mut self, frame: &Frame, motion: &Motion) -> Light {
        self.light.as_mut().map_or(Light::SAME, |light| light.step(frame, motion))
    }

    /// Where the frame lies, on the size of the estimate. Changes nothing.
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

    /// Learns from a frame, which is a sample; since when the camera looks elsewhere, if that is now certain.
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

    /// Takes the frame into the average, for so many.
    fn learn(&mut self, plane: Plane, found: &geometry::MotionEstimate, frames: u32) {
        if self.average.data.len() == plane.data.len() {
            let rate = (frames as f32 / AVERAGE_MEMORY_FRAMES).max(1.0 / self.frames as f32);
            blend(&mut self.average, &plane, found, rate);
        } else {
            self.average = plane;
        }
        self.reference = Some(geometry::Reference::new(&self.average));
    }

    /// The middle of the samples' motions, if enough of them are away from it.
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

    /// The median of each number over the samples.
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

    /// Whether all samples show that the camera looks elsewhere, and since which of them.
    fn moved_since(&mut self, frame: &Frame) -> Option<u32> {
        if self.frames <= BEGINNING_FRAMES {
            self.settled = self.middle();
            return None;
        }
        let first = self.window.front().map_or(0, |seen| seen.number);
        if self.window.iter().all(|seen| seen.correlation < MIN_CORRELATION) {
            // What was there before is no longer in view: what is now becomes the reference.
            self.average = Plane::luma(frame, self.factor);
            self.reference = Some(geometry::Reference::new(&self.average));
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

/// Moves the average towards a frame that was found so, in the average's light.
fn blend(average: &mut Plane, frame: &Plane, found: &geometry::MotionEstimate, rate: f32) {
    let geometry::MotionEstimate { motion, light: (gain, offset), .. } = found;
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
