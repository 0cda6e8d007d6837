//! Estimates changes of light: a gain and an offset of the whole image, by consensus of its parts.

use super::alignment::{LevelChange, luma};
use super::robust;
use super::{Light, Motion};
use crate::frame::{Frame, Size};

/// Approximate number of sample points of the image.
const PLACES: usize = 1600;
/// Time constant, in frames, of the average of the points' colours; the first [`FIRST`] frames have equal weights.
const MEMORY: f32 = 1000.0;
const FIRST: u32 = 50;
/// Number of image parts, across and down, that vote on a change.
const PARTS: (usize, usize) = (6, 4);
/// Share of the parts with enough points that have to agree.
const AGREEING: f32 = 0.75;
/// Largest median deviation, in levels, of the points of a part that agrees.
const CLOSE: f32 = 5.0;
/// Least number of points of a part, and of parts, for a vote.
const LEAST_PLACES: usize = 8;
const LEAST_PARTS: usize = 12;
/// The light is unchanged where the median deviation of one point in [`GLANCE`] is no more than this many levels. It
/// is measured in any case at a fixed interval of frames.
const ALIKE: f32 = 2.0;
const GLANCE: usize = 5;
const EVERY: u32 = 10;
/// Levels at or near the limits are clipped and carry no information.
const DARKEST: f32 = 6.0;
const BRIGHTEST: f32 = 249.0;
/// A fit has converged when a step moves the middle level by less than this.
const SETTLED: f32 = 0.1;
/// Changes are expressed as a share of this level.
const MIDDLE: f32 = 128.0;
/// Largest change per frame that the reference follows, as a share. A mixture with α = .002 and a band of 20 levels
/// adapts to slower changes by itself.
const FOLLOWED: f32 = 0.0003;
/// A change is corrected from this share on, until less than the second share is left.
const STARTS: f32 = 0.04;
const ENDS: f32 = 0.01;

/// A point at which the light is measured.
#[derive(Clone, Copy)]
struct SamplePoint {
    x: u32,
    y: u32,
    /// The index of the part of the image that it is in.
    part: usize,
}

/// The colours of the sample points, and the last estimate of the light.
pub(super) struct LightReference {
    size: Size,
    places: Vec<SamplePoint>,
    /// The colours in the light of the first frames.
    colours: Vec<[f32; 3]>,
    /// The change of light against the first frames: of the current frame, and of the recent past.
    light: Light,
    past: Light,
    /// Whether the light differs from that of the recent past.
    differs: bool,
    frames: u32,
}

/// The colours of a sample point in the reference and in the frame.
#[derive(Clone, Copy)]
struct ColourPair {
    part: usize,
    before: [f32; 3],
    now: [f32; 3],
}

impl ColourPair {
    fn luma(&self) -> LevelPair {
        LevelPair { before: luma(self.before), now: luma(self.now) }
    }

    fn channel(&self, channel: usize) -> LevelPair {
        LevelPair { before: self.before[channel], now: self.now[channel] }
    }
}

/// The level of a sample point in one channel, in the reference and in the frame.
#[derive(Clone, Copy)]
struct LevelPair {
    before: f32,
    now: f32,
}

impl LevelPair {
    /// What `change` does not explain.
    fn residual(self, change: LevelChange) -> f32 {
        self.now - change.apply(self.before)
    }
}

impl LightReference {
    pub(super) fn new(size: Size) -> Self {
        let step = ((size.pixels() as f32 / PLACES as f32).sqrt() as u32).max(1);
        let (across, down) = PARTS;
        let mut places = Vec::new();
        for y in (step / 2..size.height).step_by(step as usize) {
            for x in (step / 2..size.width).step_by(step as usize) {
                let column = x as usize * across / size.width as usize;
                let row = y as usize * down / size.height as usize;
                places.push(SamplePoint { x, y, part: row * across + column });
            }
        }
        Self {
            size,
            places,
            colours: Vec::new(),
            light: Light::SAME,
            past: Light::SAME,
            differs: false,
            frames: 0,
        }
    }

    /// Resets the reference; it starts again with the next frame.
    pub(super) fn restart(&mut self) {
        (self.colours, self.light, self.past) = (Vec::new(), Light::SAME, Light::SAME);
        (self.differs, self.frames) = (false, 0);
    }

    /// The change of light of the frame, moved by `motion`, against the recent past; the latter is then updated.
    pub(super) fn step(&mut self, frame: &Frame, motion: &Motion) -> Light {
        self.frames += 1;
        let is_due = self.frames <= FIRST || self.frames.is_multiple_of(EVERY);
        if !is_due && !self.differs && self.is_alike(frame, motion) {
            return self.follow();
        }
        let now: Vec<_> = self.places.iter().map(|place| self.colour(frame, motion, place)).collect();
        if self.colours.is_empty() {
            self.colours = now.into_iter().map(|colour| colour.unwrap_or([0.0; 3])).collect();
            return Light::SAME;
        }
        let seen = self.places.iter().zip(&self.colours).zip(&now);
        let pairs: Vec<_> = seen
            .filter_map(|((place, &before), now)| Some(ColourPair { part: place.part, before, now: (*now)? }))
            .filter(|pair| {
                let LevelPair { before, now } = pair.luma();
                [before, now].iter().all(|level| (DARKEST..BRIGHTEST).contains(level))
            })
            .collect();
        self.light = self.measure(&pairs);
        if is_due {
            self.learn(&now);
        }
        self.follow()
    }

    /// The frame's colour at a sample point moved by `motion`.
    fn colour(
        &self,
        frame: &Frame,
        motion: &Motion,
        &SamplePoint { x, y, .. }: &SamplePoint,
    ) -> Option<[f32; 3]> {
        let (centre_x, centre_y) =
            (0.5 * (self.size.width as f32 - 1.0), 0.5 * (self.size.height as f32 - 1.0));
        let (x, y) = motion.apply(x as f32 - centre_x, y as f32 - centre_y);
        let (x, y) = ((x + centre_x).round(), (y + centre_y).round());
        let inside = x >= 0.0 && y >= 0.0;
        inside.then(|| frame.pixel(x as u32, y as u32)).flatten().map(|rgb| rgb.map(f32::from))
    }

    /// Whether a few of the points indicate the same light as in the previous frame.
    fn is_alike(&self, frame: &Frame, motion: &Motion) -> bool {
        let change = self.light.luma();
        let pairs = self.places.iter().zip(&self.colours).step_by(GLANCE);
        let off = pairs.filter_map(|(place, &before)| {
            let pair = ColourPair { part: 0, before, now: self.colour(frame, motion, place)? };
            Some(pair.luma().residual(change))
        });
        robust::median(&mut off.collect::<Vec<_>>()).abs() < ALIKE
    }

    /// Averages the points' colours, normalised to the light of the first frames.
    fn learn(&mut self, now: &[Option<[f32; 3]>]) {
        let rate = if self.frames <= FIRST { 1.0 / self.frames as f32 } else { EVERY as f32 / MEMORY };
        for (colour, now) in self.colours.iter_mut().zip(now) {
            let Some(now) = now else { continue };
            for (channel, (level, now)) in colour.iter_mut().zip(now).enumerate() {
                let at_first = (now - self.light.offset[channel]) / self.light.gain[channel];
                *level += rate * (at_first - *level);
            }
        }
    }

    /// Updates the light of the recent past; returns the difference of the current light to it.
    fn follow(&mut self) -> Light {
        let away = away(&self.light, &self.past);
        self.differs = away > if self.differs { ENDS } else { STARTS };
        let difference = if self.differs { self.light.against(&self.past) } else { Light::SAME };
        if away > 0.0 {
            let share = (FOLLOWED / away).min(1.0);
            for channel in 0..3 {
                self.past.gain[channel] += share * (self.light.gain[channel] - self.past.gain[channel]);
                self.past.offset[channel] += share * (self.light.offset[channel] - self.past.offset[channel]);
            }
        }
        difference
    }

    /// The new light where the parts of the image agree on it; else that of the previous frame.
    fn measure(&self, pairs: &[ColourPair]) -> Light {
        if pairs.len() < self.places.len() / 4 {
            return self.light;
        }
        let levels: Vec<_> = pairs.iter().map(ColourPair::luma).collect();
        let Some(change) = fit(&levels) else { return self.light };
        let mut parts = vec![Vec::new(); PARTS.0 * PARTS.1];
        for (pair, level) in pairs.iter().zip(&levels) {
            parts[pair.part].push(*level);
        }
        let judged: Vec<_> = parts.iter().filter(|levels| levels.len() >= LEAST_PLACES).collect();
        if judged.len() < LEAST_PARTS {
            return self.light;
        }
        let agreeing = |change: LevelChange| {
            let agree = |levels: &&&Vec<LevelPair>| {
                let off = levels.iter().map(|pair| pair.residual(change));
                robust::median(&mut off.collect::<Vec<_>>()).abs() < CLOSE
            };
            judged.iter().filter(agree).count()
        };
        let (changed, same) = (agreeing(change), agreeing(self.light.luma()));
        if changed < same || (changed as f32) < AGREEING * judged.len() as f32 {
            return self.light;
        }
        let mut light = Light::SAME;
        for channel in 0..3 {
            let levels: Vec<_> = pairs.iter().map(|pair| pair.channel(channel)).collect();
            let LevelChange { gain, offset } = fit(&levels).unwrap_or(change);
            (light.gain[channel], light.offset[channel]) = (gain, offset);
        }
        light
    }
}

/// The relative difference of a middle level between two lights; the largest over the channels.
fn away(one: &Light, other: &Light) -> f32 {
    let lit = |light: &Light, channel: usize| light.gain[channel] * MIDDLE + light.offset[channel];
    (0..3).map(|channel| (lit(one, channel) - lit(other, channel)).abs() / MIDDLE).fold(0.0, f32::max)
}

/// The change of levels by robust least squares.
fn fit(levels: &[LevelPair]) -> Option<LevelChange> {
    let mut ratios: Vec<f32> =
        levels.iter().filter(|pair| pair.before > 12.0).map(|pair| pair.now / pair.before).collect();
    if ratios.len() < 32 {
        return None;
    }
    let mut change = LevelChange { gain: robust::median(&mut ratios), offset: 0.0 };
    let mut sizes = Vec::with_capacity(levels.len());
    for _ in 0..6 {
        sizes.clear();
        sizes.extend(levels.iter().map(|pair| pair.residual(change).abs()));
        let reach = robust::reach(&mut sizes).clamp(6.0, 30.0);
        let mut sums = [0.0_f64; 5];
        for pair in levels {
            let share = pair.residual(change) / reach;
            if share.abs() < 1.0 {
                let weight = f64::from((1.0 - share * share) * (1.0 - share * share));
                let (before, now) = (f64::from(pair.before), f64::from(pair.now));
                let terms = [1.0, before, now, before * before, before * now];
                for (sum, term) in sums.iter_mut().zip(terms) {
                    *sum += weight * term;
                }
            }
        }
        let [n, b, f, bb, bf] = sums;
        // In an image of one level gain and offset are not separable; the offset is then kept small.
        let n = 1.25 * n;
        let determinant = n * bb - b * b;
        if determinant <= f64::EPSILON {
            return None;
        }
        let before = change.apply(MIDDLE);
        change.gain = ((n * bf - b * f) / determinant) as f32;
        change.offset = ((bb * f - b * bf) / determinant) as f32;
        if (change.apply(MIDDLE) - before).abs() < SETTLED {
            break;
        }
    }
    let sound = (0.2..=5.0).contains(&change.gain) && change.offset.abs() < 64.0;
    sound.then_some(change)
}
