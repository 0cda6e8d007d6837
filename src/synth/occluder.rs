//! Static occluders: trees, poles, walls.

use rand::Rng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::layer::Layer;
use super::texture::{
    Colour, fractal_noise, hash, lit, mix, mix_colour, salted, smoothstep, unit, value_noise,
};
use crate::frame::Size;

/// Samples per pixel along each axis.
const SAMPLES: usize = 3;

/// A stationary occluder, which hides everything behind it: all people whose feet are higher in the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Occluder {
    /// Its kind.
    pub kind: OccluderKind,
    /// The centre of its foot on the ground, in pixels.
    pub at: [f32; 2],
    /// Its width at half height (of a tree: of the trunk), in pixels.
    pub width: f32,
    /// Its height in pixels (of a tree: of the whole tree, most of which may lie above the image).
    pub height: f32,
    /// Its sway in the wind, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sway: Option<Sway>,
}

/// A periodic sway that increases with height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sway {
    /// The amplitude at the top, in pixels.
    pub reach: f32,
    /// The period in frames.
    pub period: f32,
}

/// Kinds of [`Occluder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OccluderKind {
    /// A tree: a trunk with bark, roots and a crown of leaves.
    Tree,
    /// A steel pole.
    Pole,
    /// A low brick wall with a coping.
    Wall,
}

impl Occluder {
    /// Renders it. The layer has the image's size.
    pub fn draw(&self, size: Size, seed: u64) -> Layer {
        let crown = if self.kind == OccluderKind::Tree { self.crown(seed) } else { Vec::new() };
        let colour_at = |x: f32, y: f32| match self.kind {
            OccluderKind::Tree => leaves(&crown, self.leaf(), x, y, seed)
                .or_else(|| self.grass(x, y, seed))
                .or_else(|| self.trunk(x, y, seed)),
            OccluderKind::Pole => self.pole(x, y, seed),
            OccluderKind::Wall => self.wall(x, y, seed),
        };
        let mut layer = Layer::clear(0, 0, size.width as usize, size.height as usize);
        let width = layer.width;
        layer.coverage.par_iter_mut().zip(&mut layer.colour).enumerate().for_each(
            |(at, (coverage, colour))| {
                let (column, row) = ((at % width) as f32, (at / width) as f32);
                let samples = (0..SAMPLES * SAMPLES).filter_map(|sample| {
                    let dx = ((sample % SAMPLES) as f32 + 0.5) / SAMPLES as f32;
                    let dy = ((sample / SAMPLES) as f32 + 0.5) / SAMPLES as f32;
                    colour_at(column + dx, row + dy)
                });
                for sample in samples {
                    *coverage += 1.0 / (SAMPLES * SAMPLES) as f32;
                    for (sum, channel) in colour.iter_mut().zip(sample) {
                        *sum += channel / (SAMPLES * SAMPLES) as f32;
                    }
                }
                // The shadow is not part of the silhouette and must not make a pixel solid.
                if *coverage < Layer::SOLID {
                    let shade = (1.0 - *coverage) * self.contact_shade(column + 0.5, row + 0.5);
                    *coverage = (*coverage + shade).min(Layer::SOLID - 0.01);
                }
            },
        );
        layer
    }

    /// Its layer in a frame, from `drawn`, the layer without wind; `None` if it does not sway.
    pub(super) fn swayed(&self, drawn: &Layer, frame: f32) -> Option<Layer> {
        let Sway { reach, period } = self.sway?;
        let turn = std::f32::consts::TAU * frame / period;
        let mut swayed = drawn.clone();
        let width = drawn.width;
        let rows = swayed.coverage.par_chunks_mut(width).zip(swayed.colour.par_chunks_mut(width));
        rows.enumerate().for_each(|(row, (coverage, colour))| {
            let up = ((self.at[1] - row as f32) / self.height).clamp(0.0, 1.0);
            // Gusts are added, and the top lags behind the trunk.
            let wind = 0.75 * (turn - up).sin() + 0.25 * (2.3 * turn + 2.0 * up).sin();
            let shift = reach * up * up * wind;
            let (whole, part) = (shift.floor() as i32, shift - shift.floor());
            for column in 0..width {
                let from =
                    |back: i32| usize::try_from(column as i32 - whole - back).ok().filter(|&c| c < width);
                let mixed = |channel: &dyn Fn(usize) -> f32| {
                    let at = |back| from(back).map_or(0.0, |column| channel(row * width + column));
                    mix(at(0), at(1), part)
                };
                coverage[column] = mixed(&|at| drawn.coverage[at]);
                colour[column] = [0, 1, 2].map(|c| mixed(&|at| drawn.colour[at][c]));
            }
        });
        Some(swayed)
    }

    /// The size of a leaf, in pixels.
    fn leaf(&self) -> f32 {
        (self.height / 150.0).max(0.8)
    }

    /// The clumps of leaves, from back to front.
    fn crown(&self, seed: u64) -> Vec<Clump> {
        let mut random = Pcg64Mcg::new(u128::from(hash(seed, 61, 0)) << 64 | 1);
        let mut next = || (random.next_u32() >> 8) as f32 / (1 << 24) as f32;
        let middle = [self.at[0], self.at[1] - 0.84 * self.height];
        let reach = [0.40 * self.height, 0.25 * self.height];
        let mut clumps: Vec<Clump> = (0..90)
            .map(|_| {
                let (angle, radius) = (next() * std::f32::consts::TAU, next().sqrt());
                Clump {
                    at: [
                        middle[0] + reach[0] * radius * angle.cos(),
                        middle[1] + reach[1] * radius * angle.sin(),
                    ],
                    radius: (0.055 + 0.05 * next()) * self.height,
                    tone: next(),
                }
            })
            .collect();
        // Lower clumps are in front of higher ones.
        clumps.sort_by(|a, b| (a.at[1] + 30.0 * a.tone).total_cmp(&(b.at[1] + 30.0 * b.tone)));
        clumps
    }

    fn trunk(&self, x: f32, y: f32, seed: u64) -> Option<Colour> {
        let up = (self.at[1] - y) / self.width;
        let across_raw = (x - self.at[0]) / (self.width / 2.0);
        let bumps =
            fractal_noise(salted(seed, 62), up * 2.2 + 9.0, if across_raw < 0.0 { 0.0 } else { 50.0 }, 3)
                - 0.5;
        // The roots spread at the foot; the trunk tapers slowly upwards.
        let spread = 1.0 + 0.46 * (-up.max(0.0) * 4.2).exp() - 0.035 * up + 0.10 * bumps;
        let across = across_raw / spread;
        // The foot is round: its middle is nearer to the camera than its sides.
        let foot = -0.05 * (1.0 - across * across).max(0.0).sqrt() + 0.03 * bumps;
        if across.abs() > 1.0 || up < foot || up * self.width > self.height {
            return None;
        }
        // Bark: irregular vertical furrows, crossed by cracks.
        let round = across.asin();
        let wander = fractal_noise(salted(seed, 63), round * 2.0, up * 2.4, 3) * 0.8;
        let ridge =
            (fractal_noise(salted(seed, 64), (round + wander * 0.35) * 13.0, up * 3.2, 4) - 0.5).abs() * 2.0;
        let fine = fractal_noise(salted(seed, 65), x * 0.55, y * 0.25, 3);
        let moss = smoothstep(0.52, 0.72, fractal_noise(salted(seed, 66), round * 2.1 + 7.0, up * 1.4, 4));
        let bark = mix_colour([52.0, 41.0, 32.0], [139.0, 118.0, 94.0], smoothstep(0.02, 0.42, ridge));
        let bark = mix_colour(bark, [104.0, 108.0, 62.0], 0.40 * moss);
        let light = 0.50 + 0.62 * (1.0 - (across + 0.30).powi(2) / 1.69).max(0.0).sqrt();
        let near_ground = 0.70 + 0.30 * smoothstep(-0.05, 0.25, up);
        Some(lit(bark, light * near_ground * (0.82 + 0.30 * fine)))
    }

    /// Tufts of grass at the foot of the trunk.
    fn grass(&self, x: f32, y: f32, seed: u64) -> Option<Colour> {
        let leaf = self.leaf();
        let away = (x - self.at[0]) / (self.width * 0.78);
        let up = (self.at[1] - y) / self.width + 0.055 * (1.0 - away * away).max(0.0).sqrt();
        // Blades of random inclination.
        let blade = x / (1.5 * leaf) + 2.0 * up;
        let tall =
            unit(salted(seed, 72), blade.floor() as i64, 0) * (1.0 - (2.0 * blade.fract() - 1.0).abs());
        let clump = smoothstep(0.30, 0.75, value_noise(salted(seed, 73), x / (9.0 * leaf), 0.0));
        if away.abs() > 1.0 || up < -0.02 || up > 0.16 * (0.25 + 0.75 * clump) * tall {
            return None;
        }
        let tone = unit(salted(seed, 74), blade.floor() as i64, 1);
        Some(lit(mix_colour([72.0, 98.0, 40.0], [132.0, 150.0, 70.0], tone), 0.72 + 2.6 * up.max(0.0)))
    }

    /// The contact shadow on the ground around its foot, 0 for none.
    fn contact_shade(&self, x: f32, y: f32) -> f32 {
        let reach = match self.kind {
            OccluderKind::Tree => [self.width * 1.05, self.width * 0.11],
            OccluderKind::Pole => [self.width * 2.4, self.width * 0.8],
            OccluderKind::Wall => [self.width * 0.53, self.height * 0.07],
        };
        let away = ((x - self.at[0]) / reach[0]).hypot((y - self.at[1]) / reach[1]);
        0.42 * smoothstep(1.0, 0.35, away)
    }

    fn pole(&self, x: f32, y: f32, seed: u64) -> Option<Colour> {
        let across = (x - self.at[0]) / (self.width / 2.0);
        let up = self.at[1] - y;
        let at_foot = up < self.width * 0.5;
        let across = if at_foot { across / 1.7 } else { across };
        let rim = up + self.width * 0.22 * (1.0 - across * across).max(0.0).sqrt();
        if across.abs() > 1.0 || rim < 0.0 || up > self.height {
            return None;
        }
        let shine = (-(across + 0.38).powi(2) * 9.0).exp();
        let streaks = fractal_noise(salted(seed, 71), x * 0.8, y * 0.06, 3);
        let light = 0.46 + 0.50 * (1.0 - (across + 0.2).powi(2) / 1.44).max(0.0).sqrt() + 0.34 * shine;
        Some(lit([122.0, 128.0, 132.0], light * (0.90 + 0.20 * streaks) * if at_foot { 0.8 } else { 1.0 }))
    }

    fn wall(&self, x: f32, y: f32, seed: u64) -> Option<Colour> {
        let up = self.at[1] - y;
        let coping = 0.13 * self.height;
        let out = if up > self.height - coping { 0.03 * self.height } else { 0.0 };
        if (x - self.at[0]).abs() > self.width / 2.0 + out || !(0.0..self.height).contains(&up) {
            return None;
        }
        let grain = fractal_noise(salted(seed, 81), x * 0.6, y * 0.6, 3);
        let weather = fractal_noise(salted(seed, 82), x * 0.03, y * 0.05, 4);
        if up > self.height - coping {
            let top = smoothstep(self.height - coping * 0.45, self.height - coping * 0.35, up);
            return Some(lit(
                [176.0, 170.0, 160.0],
                0.72 + 0.20 * top + 0.16 * weather + 0.2 * (grain - 0.5),
            ));
        }
        let course = self.height / 9.0;
        let row = (up / course).floor();
        let along = (x - self.at[0]) / (course * 2.4) + 0.5 * row.rem_euclid(2.0);
        let (s, t) = (along - along.floor(), up / course - row);
        let edge = (s.min(1.0 - s) * course * 2.4).min(t.min(1.0 - t) * course);
        let tint = unit(salted(seed, 83), along.floor() as i64, row as i64);
        let brick = mix_colour([120.0, 66.0, 50.0], [166.0, 98.0, 72.0], tint);
        let brick = lit(brick, 0.76 + 0.24 * weather + 0.26 * (grain - 0.4));
        let mortar = lit([164.0, 156.0, 146.0], 0.78 + 0.2 * weather);
        let under_coping = 1.0 - 0.35 * smoothstep(self.height - coping * 1.6, self.height - coping, up);
        Some(lit(mix_colour(mortar, brick, smoothstep(0.05 * course, 0.14 * course, edge)), under_coping))
    }
}

/// A clump of leaves.
struct Clump {
    at: [f32; 2],
    radius: f32,
    tone: f32,
}

fn leaves(crown: &[Clump], leaf: f32, x: f32, y: f32, seed: u64) -> Option<Colour> {
    let ragged = fractal_noise(salted(seed, 67), x / (3.2 * leaf), y / (3.2 * leaf), 3) - 0.5;
    let clump = crown.iter().rev().find(|clump| {
        let distance = (x - clump.at[0]).hypot(y - clump.at[1]);
        distance < clump.radius * (1.0 + 0.75 * ragged)
    })?;
    let (dx, dy) = ((x - clump.at[0]) / clump.radius, (y - clump.at[1]) / clump.radius);
    let facing = (0.78 - 0.38 * dx - 0.55 * dy).clamp(0.0, 1.4);
    let tuft = value_noise(salted(seed, 68), x / (2.0 * leaf), y / (1.6 * leaf));
    let fine = unit(salted(seed, 69), (x / leaf).floor() as i64, (y / (0.8 * leaf)).floor() as i64);
    let green = mix_colour([46.0, 66.0, 26.0], [126.0, 148.0, 58.0], 0.45 * clump.tone + 0.55 * tuft);
    Some(lit(green, (0.42 + 0.50 * facing) * (0.78 + 0.34 * fine)))
}
