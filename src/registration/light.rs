//! How the light has changed: a gain and an offset of the whole image, by consensus of all its parts.

use super::{Light, Motion};
use crate::frame::{Frame, Size};

/// About so many places of the image are compared.
const PLACES: usize = 1600;
/// Frames over which the reference follows the light: longer than the mixture takes to learn a new level.
const MEMORY: f32 = 1000.0;
/// So many frames are averaged alike at first.
const FIRST: u32 = 50;
/// Parts of the image that have to agree on a change, across and down.
const PARTS: (usize, usize) = (6, 4);
/// Of the parts that can be judged, so many have to agree.
const AGREEING: f32 = 0.75;
/// A part agrees where the median of its places is off by no more levels.
const CLOSE: f32 = 5.0;
/// Fewer places do not judge.
const LEAST_PLACES: usize = 8;
/// Where nearly all places have changed by less, nothing has.
const ALIKE: f32 = 5.0;
/// Levels that are cut off, or nearly, tell nothing.
const DARKEST: f32 = 6.0;
const BRIGHTEST: f32 = 249.0;
/// Smaller changes are left to the mixture, whose band is wider.
const LEAST_GAIN: f32 = 0.1;
const LEAST_OFFSET: f32 = 10.0;

/// The light of the recent past at some places of the image.
pub(super) struct Reference {
    size: Size,
    /// Column and row of each place, part of the image.
    places: Vec<(u32, u32, usize)>,
    colours: Vec<[f32; 3]>,
    light: Light,
    frames: u32,
}

/// A place of the reference as the frame shows it.
#[derive(Clone, Copy)]
struct Pair {
    part: usize,
    before: [f32; 3],
    now: [f32; 3],
}

impl Pair {
    fn luma(&self) -> (f32, f32) {
        let luma = |[r, g, b]: [f32; 3]| (0.299 * r + 0.587 * g) + 0.114 * b;
        (luma(self.before), luma(self.now))
    }
}

impl Reference {
    pub(super) fn new(size: Size) -> Self {
        let step = ((size.pixels() as f32 / PLACES as f32).sqrt() as u32).max(1);
        let (across, down) = PARTS;
        let mut places = Vec::new();
        for y in (step / 2..size.height).step_by(step as usize) {
            for x in (step / 2..size.width).step_by(step as usize) {
                let column = x as usize * across / size.width as usize;
                let row = y as usize * down / size.height as usize;
                places.push((x, y, row * across + column));
            }
        }
        Self { size, places, colours: Vec::new(), light: Light::SAME, frames: 0 }
    }

    /// Begins anew with the next frame.
    pub(super) fn restart(&mut self) {
        (self.colours, self.light, self.frames) = (Vec::new(), Light::SAME, 0);
    }

    /// How the light of the frame, moved by `motion`, differs from the reference, which then follows it.
    pub(super) fn step(&mut self, frame: &Frame, motion: &Motion) -> Light {
        let (centre_x, centre_y) =
            (0.5 * (self.size.width as f32 - 1.0), 0.5 * (self.size.height as f32 - 1.0));
        let colour = |&(x, y, _): &(u32, u32, usize)| {
            let (x, y) = motion.apply(x as f32 - centre_x, y as f32 - centre_y);
            let (x, y) = ((x + centre_x).round(), (y + centre_y).round());
            let inside = x >= 0.0 && y >= 0.0;
            inside.then(|| frame.pixel(x as u32, y as u32)).flatten().map(|rgb| rgb.map(f32::from))
        };
        let now: Vec<_> = self.places.iter().map(colour).collect();
        self.frames += 1;
        if self.colours.is_empty() {
            self.colours = now.into_iter().map(|colour| colour.unwrap_or([0.0; 3])).collect();
            return Light::SAME;
        }
        let seen = self.places.iter().zip(&self.colours).zip(&now);
        let pairs: Vec<_> = seen
            .filter_map(|((&(_, _, part), &before), now)| Some(Pair { part, before, now: (*now)? }))
            .filter(|pair| {
                let (before, now) = pair.luma();
                [before, now].iter().all(|level| (DARKEST..BRIGHTEST).contains(level))
            })
            .collect();
        self.light = self.measure(&pairs);
        let rate = if self.frames <= FIRST { 1.0 / self.frames as f32 } else { 1.0 / MEMORY };
        for (colour, now) in self.colours.iter_mut().zip(now) {
            let Some(now) = now else { continue };
            for (level, now) in colour.iter_mut().zip(now) {
                *level += rate * (now - *level);
            }
        }
        if is_slight(&self.light) { Light::SAME } else { self.light }
    }

    /// The new light where the parts of the image agree on it; else that of the frame before.
    fn measure(&self, pairs: &[Pair]) -> Light {
        if pairs.len() < self.places.len() / 4 {
            return self.light;
        }
        let levels: Vec<_> = pairs.iter().map(Pair::luma).collect();
        // In most frames nothing has changed, and that is known for little.
        let alike = levels.iter().filter(|(before, now)| (now - before).abs() < ALIKE).count();
        if alike as f32 > 0.9 * levels.len() as f32 {
            return Light::SAME;
        }
        let Some((gain, offset)) = fit(&levels) else { return self.light };
        let mut parts = vec![Vec::new(); PARTS.0 * PARTS.1];
        for (pair, level) in pairs.iter().zip(&levels) {
            parts[pair.part].push(*level);
        }
        let judged: Vec<_> = parts.iter().filter(|levels| levels.len() >= LEAST_PLACES).collect();
        let agreeing = |gain: f32, offset: f32| {
            let agree = |levels: &&&Vec<(f32, f32)>| {
                let off = levels.iter().map(|(before, now)| now - (gain * before + offset));
                median(off.collect()).abs() < CLOSE
            };
            judged.iter().filter(agree).count()
        };
        let (changed, same) = (agreeing(gain, offset), agreeing(1.0, 0.0));
        if same >= changed {
            return Light::SAME;
        }
        if (changed as f32) < AGREEING * judged.len() as f32 {
            return self.light;
        }
        let mut light = Light::SAME;
        for channel in 0..3 {
            let levels: Vec<_> = pairs.iter().map(|pair| (pair.before[channel], pair.now[channel])).collect();
            let (gain, offset) = fit(&levels).unwrap_or((gain, offset));
            (light.gain[channel], light.offset[channel]) = (gain, offset);
        }
        light
    }
}

fn is_slight(light: &Light) -> bool {
    let slight = |(gain, offset): (&f32, &f32)| {
        (gain - 1.0).abs() < LEAST_GAIN
            && offset.abs() < LEAST_OFFSET
            && (gain * 128.0 + offset - 128.0).abs() < 128.0 * LEAST_GAIN
    };
    light.gain.iter().zip(&light.offset).all(slight)
}

fn median(mut numbers: Vec<f32>) -> f32 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() { 0.0 } else { *numbers.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// Gain and offset from levels before and now, by robust least squares.
fn fit(levels: &[(f32, f32)]) -> Option<(f32, f32)> {
    let mut ratios: Vec<f32> =
        levels.iter().filter(|(before, _)| *before > 12.0).map(|(before, now)| now / before).collect();
    if ratios.len() < 32 {
        return None;
    }
    let middle = ratios.len() / 2;
    let (mut gain, mut offset) = (*ratios.select_nth_unstable_by(middle, f32::total_cmp).1, 0.0);
    let mut sizes = Vec::with_capacity(levels.len());
    for _ in 0..6 {
        sizes.clear();
        sizes.extend(levels.iter().map(|(before, now)| (now - (gain * before + offset)).abs()));
        let middle = sizes.len() / 2;
        let median = *sizes.select_nth_unstable_by(middle, f32::total_cmp).1;
        let reach = (4.685 * 1.4826 * median).clamp(6.0, 30.0);
        let mut sums = [0.0_f64; 5];
        for &(before, now) in levels {
            let share = (now - (gain * before + offset)) / reach;
            if share.abs() < 1.0 {
                let weight = f64::from((1.0 - share * share) * (1.0 - share * share));
                let (before, now) = (f64::from(before), f64::from(now));
                let terms = [1.0, before, now, before * before, before * now];
                for (sum, term) in sums.iter_mut().zip(terms) {
                    *sum += weight * term;
                }
            }
        }
        let [n, b, f, bb, bf] = sums;
        // An image of one level tells gain and offset apart no more: then the offset stays small.
        let n = 1.25 * n;
        let determinant = n * bb - b * b;
        if determinant <= f64::EPSILON {
            return None;
        }
        gain = ((n * bf - b * f) / determinant) as f32;
        offset = ((bb * f - b * bf) / determinant) as f32;
    }
    let sound = (0.2..=5.0).contains(&gain) && offset.abs() < 64.0;
    sound.then_some((gain, offset))
}
