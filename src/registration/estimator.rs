//! The alignment of each frame, one after the other.

use std::collections::VecDeque;

use super::geometry::{self, Pyramid};
use super::plane::{Plane, reduction};
use super::{Alignment, Motion, light};
use crate::frame::{Frame, Size};

/// Least sides of an image in which motion is looked for, on the size of the estimate.
const LEAST_SIDE: usize = 48;
/// Frames over which the reference is averaged.
const MEMORY: f32 = 100.0;
/// The average takes in each of so many frames, and then one of [`EVERY`].
const FIRST: u32 = 16;
const EVERY: u32 = 8;
/// Frames in which it is decided whether the camera shakes, and whether it stays where it moved.
const WINDOW: usize = 50;
/// A frame is shaken where the image's centre or edge is so many pixels from rest.
const SHAKEN: f32 = 0.7;
/// The camera shakes where so large a share of the window's frames is shaken.
const SHAKES: f32 = 0.3;
/// Below this correlation the frame shows something else than the reference.
const LOST: f32 = 0.35;
/// The camera has moved for good where it rests so far from where it was, as a share of the width.
const MOVED: f32 = 0.012;

/// What was found in a frame.
struct Seen {
    motion: Motion,
    correlation: f32,
    /// Whether the motion explains far more than none does.
    is_clear: bool,
    number: u32,
}

/// Measures every frame of a sequence, in order; each frame's result depends on it and those before it alone.
pub struct Estimator {
    size: Size,
    factor: usize,
    frames: u32,
    average: Plane,
    reference: Option<geometry::Reference>,
    light: light::Reference,
    /// What was seen in the last frames.
    window: VecDeque<Seen>,
    rest: Option<Motion>,
    /// Where the camera was last known to rest.
    settled: Motion,
    /// What the motion usually leaves unexplained of a frame, in levels.
    usual: f32,
}

impl Estimator {
    /// Nothing seen yet of frames of this size.
    pub fn new(size: Size) -> Self {
        Self {
            size,
            factor: reduction(size.width as usize, size.height as usize),
            frames: 0,
            average: Plane::default(),
            reference: None,
            light: light::Reference::new(size),
            window: VecDeque::new(),
            rest: None,
            settled: Motion::NONE,
            usual: 0.0,
        }
    }

    /// Measures the next frame.
    pub fn step(&mut self, frame: &Frame) -> Alignment {
        if frame.size != self.size {
            return Alignment::default();
        }
        let (width, height) =
            (self.size.width as usize / self.factor, self.size.height as usize / self.factor);
        if width.min(height) < LEAST_SIDE {
            return Alignment { light: self.light.step(frame, &Motion::NONE), ..Alignment::default() };
        }
        self.frames += 1;
        let usable = self.reference.as_ref().filter(|reference| reference.is_usable());
        let renews = self.frames <= FIRST || self.frames.is_multiple_of(EVERY);
        let still = usable
            .filter(|_| self.frames > WINDOW as u32 && !renews && !self.is_restless())
            .and_then(|reference| reference.find_still(frame, self.factor, self.usual));
        let mut pyramid = None;
        let found = match (still, usable) {
            (Some(still), _) => still,
            (None, Some(reference)) => {
                let frame = pyramid.insert(Pyramid::new(Plane::luma(frame, self.factor)));
                reference.find(frame, self.rest.is_some())
            }
            (None, None) => {
                geometry::Found { motion: Motion::NONE, correlation: 1.0, cost: 0.0, is_clear: false }
            }
        };
        self.usual =
            if self.frames <= WINDOW as u32 { found.cost } else { found.cost.min(1.01 * self.usual) };
        let geometry::Found { motion, correlation, is_clear, .. } = found;
        if renews && (correlation >= LOST || self.frames == 1) {
            let plane = pyramid.map_or_else(|| Plane::luma(frame, self.factor), |Pyramid([.., plane])| plane);
            self.learn(plane, &motion);
        }
        let factor = self.factor as f32;
        let motion = Motion { dx: motion.dx * factor, dy: motion.dy * factor, ..motion };
        self.window.push_back(Seen { motion, correlation, is_clear, number: frame.number });
        if self.window.len() > WINDOW {
            self.window.pop_front();
        }
        let moved_since = self.moved_since(frame);
        if self.rest.is_none() && self.window.len() >= WINDOW / 2 {
            self.rest = self.shakes_around();
        }
        let light = self.light.step(frame, &motion);
        Alignment { motion, light, rest: self.rest, moved_since }
    }

    /// Whether the camera shakes or moved a little while ago.
    fn is_restless(&self) -> bool {
        self.rest.is_some() || self.window.iter().any(|seen| seen.motion != Motion::NONE)
    }

    /// Takes the frame into the average.
    fn learn(&mut self, plane: Plane, motion: &Motion) {
        if self.average.data.len() == plane.data.len() {
            let every = if self.frames > FIRST { EVERY as f32 } else { 1.0 };
            let rate = (every / MEMORY).max(1.0 / self.frames as f32);
            blend(&mut self.average, &plane, motion, rate);
        } else {
            self.average = plane;
        }
        self.reference = Some(geometry::Reference::new(&self.average));
    }

    /// The middle of the window's motions, if enough of them are away from it.
    fn shakes_around(&self) -> Option<Motion> {
        let rest = self.middle(0..self.window.len());
        let half = 0.5 * self.size.width as f32;
        let shaken = |seen: &&Seen| {
            let motion = &seen.motion;
            let away = Motion { dx: motion.dx - rest.dx, dy: motion.dy - rest.dy, ..*motion };
            let far = away.length() > SHAKEN || half * (motion.turn - rest.turn).abs() > 2.0 * SHAKEN;
            far && (seen.is_clear || motion.length() < SHAKEN)
        };
        let count = self.window.iter().filter(shaken).count();
        (count as f32 > SHAKES * self.window.len() as f32).then_some(rest)
    }

    /// The median of each number over some of the window's frames.
    fn middle(&self, frames: std::ops::Range<usize>) -> Motion {
        let median = |number: fn(&Motion) -> f32| {
            let mut all: Vec<f32> =
                self.window.range(frames.clone()).map(|seen| number(&seen.motion)).collect();
            let middle = all.len() / 2;
            if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(middle, f32::total_cmp).1 }
        };
        Motion {
            dx: median(|motion| motion.dx),
            dy: median(|motion| motion.dy),
            turn: median(|motion| motion.turn),
            zoom: median(|motion| motion.zoom),
        }
    }

    /// Whether the whole window shows that the camera looks elsewhere, and since which frame.
    fn moved_since(&mut self, frame: &Frame) -> Option<u32> {
        if self.window.len() < WINDOW {
            return None;
        }
        let first = self.window.front().map_or(0, |seen| seen.number);
        if self.window.iter().all(|seen| seen.correlation < LOST) {
            // What was there before is no longer in view: what is now becomes the reference.
            self.average = Plane::luma(frame, self.factor);
            self.reference = Some(geometry::Reference::new(&self.average));
            (self.frames, self.settled) = (1, Motion::NONE);
            self.light.restart();
            self.window.clear();
            return Some(first);
        }
        let middle = self.middle(0..WINDOW);
        if self.frames <= WINDOW as u32 {
            self.settled = middle;
        }
        let width = self.size.width as f32;
        let far = |one: &Motion, other: &Motion| {
            let shift = Motion { dx: one.dx - other.dx, dy: one.dy - other.dy, ..Motion::NONE }.length();
            let edge = 0.5 * width * ((one.turn - other.turn).abs() + (one.zoom - other.zoom).abs());
            shift.max(edge)
        };
        let away = far(&middle, &self.settled);
        let settled_elsewhere = |seen: &Seen| {
            far(&seen.motion, &self.settled) > 0.5 * away && far(&seen.motion, &middle) < 0.25 * away
        };
        let moved = away > (MOVED * width).max(2.0) && self.window.iter().all(settled_elsewhere);
        if moved {
            self.settled = middle;
        }
        moved.then_some(first)
    }
}

/// Moves the average towards a frame that is moved by `motion`.
fn blend(average: &mut Plane, frame: &Plane, motion: &Motion, rate: f32) {
    if *motion == Motion::NONE {
        for (mean, value) in average.data.iter_mut().zip(&frame.data) {
            *mean += rate * (value - *mean);
        }
        return;
    }
    let (centre_x, centre_y) = (0.5 * (frame.width as f32 - 1.0), 0.5 * (frame.height as f32 - 1.0));
    for (y, row) in average.data.chunks_exact_mut(frame.width.max(1)).enumerate() {
        for (x, mean) in row.iter_mut().enumerate() {
            let (x, y) = motion.apply(x as f32 - centre_x, y as f32 - centre_y);
            if let Some(value) = frame.at(x + centre_x, y + centre_y) {
                *mean += rate * (value - *mean);
            }
        }
    }
}
