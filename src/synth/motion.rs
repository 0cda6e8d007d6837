//! Moving background objects: a flag, a lamp, a monitor, glints on water.

use serde::{Deserialize, Serialize};

use super::texture::{Colour, fractal_noise, lit, mix_colour, salted, smoothstep, value_noise};
use crate::frame::Size;

/// Samples per pixel along each axis.
const SAMPLES: u32 = 2;

/// A background object that changes repeatedly. It is not part of the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BackgroundMotion {
    /// Its kind.
    pub kind: MotionKind,
    /// Its centre, in pixels.
    pub at: [f32; 2],
    /// Its width in pixels.
    pub width: f32,
    /// Its height in pixels.
    pub height: f32,
    /// Its period in frames; glints, which are not periodic, last about half as long.
    pub period: f32,
}

/// Kinds of [`BackgroundMotion`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionKind {
    /// A striped flag that waves to the right of its pole.
    Flag,
    /// A lamp that is on for one half of its period and off for the other.
    Lamp,
    /// A computer monitor with a dark bar that moves down the screen.
    Monitor,
    /// A pond with glints of light on its water.
    Glints,
}

impl BackgroundMotion {
    /// Draws it as of a frame.
    pub(super) fn draw(&self, image: &mut [Colour], size: Size, seed: u64, frame: f32) {
        let turn = frame / self.period;
        for (at, colour) in image.iter_mut().enumerate() {
            let (column, row) = ((at % size.width as usize) as f32, (at / size.width as usize) as f32);
            let (dx, dy) = (column - self.at[0], row - self.at[1]);
            if dx.abs() > self.reach() * self.width || dy.abs() > self.reach() * self.height {
                continue;
            }
            let under = *colour;
            let mut sum = [0.0; 3];
            for sample in 0..SAMPLES * SAMPLES {
                let inside = |index: u32| (index as f32 + 0.5) / SAMPLES as f32;
                let (x, y) = (dx + inside(sample % SAMPLES), dy + inside(sample / SAMPLES));
                let over = match self.kind {
                    MotionKind::Flag => self.flag(x, y, turn),
                    MotionKind::Lamp => self.lamp(x, y, turn, under),
                    MotionKind::Monitor => self.monitor(x, y, turn, seed),
                    MotionKind::Glints => self.glints(x, y, turn, under, seed),
                };
                let over = over.unwrap_or(under);
                sum = [sum[0] + over[0], sum[1] + over[1], sum[2] + over[2]];
            }
            *colour = lit(sum, 1.0 / (SAMPLES * SAMPLES) as f32);
        }
    }

    /// The largest distance from its centre at which it is drawn, in widths and heights.
    const fn reach(&self) -> f32 {
        match self.kind {
            MotionKind::Flag => 4.0,
            MotionKind::Lamp => 3.0,
            MotionKind::Monitor => 1.7,
            MotionKind::Glints => 0.55,
        }
    }

    /// Its colour at `x` to the right of its centre and `y` below, after `turn` periods; `None` outside. The other
    /// kinds are alike.
    fn flag(&self, x: f32, y: f32, turn: f32) -> Option<Colour> {
        let along = x / self.width + 0.5;
        let pole = (x + self.width / 2.0) / (0.035 * self.width);
        if pole.abs() < 1.0 && y > -0.62 * self.height {
            return Some(lit([188.0, 190.0, 192.0], 0.95 - 0.35 * (pole + 0.3).powi(2)));
        }
        if !(0.0..1.0).contains(&along) {
            return None;
        }
        let wave = std::f32::consts::TAU * (1.2 * along - turn);
        let down = (y - 0.16 * self.height * along * wave.sin()) / self.height + 0.5;
        let stripe = match down {
            0.0..0.334 => [186.0, 40.0, 44.0],
            0.334..0.667 => [226.0, 222.0, 212.0],
            0.667..1.0 => [38.0, 62.0, 128.0],
            _ => return None,
        };
        Some(lit(stripe, 0.88 + 0.20 * along * wave.cos()))
    }

    fn lamp(&self, x: f32, y: f32, turn: f32, under: Colour) -> Option<Colour> {
        let on = turn.rem_euclid(1.0) < 0.5;
        let away = (x / self.width).hypot(y / self.height) * 2.0;
        if away < 1.0 {
            let glass = if on { [252.0, 214.0, 120.0] } else { [112.0, 66.0, 24.0] };
            return Some(lit(glass, 1.02 - 0.18 * away * away));
        }
        if away < 1.25 || x.abs() < 0.12 * self.width && y > 0.0 {
            return Some([46.0, 48.0, 50.0]);
        }
        // It lights its surroundings.
        on.then(|| lit(under, 1.0 + 0.5 * smoothstep(6.0, 1.0, away)))
    }

    fn monitor(&self, x: f32, y: f32, turn: f32, seed: u64) -> Option<Colour> {
        let (s, t) = (2.0 * x / self.width, 2.0 * y / self.height);
        if s.abs() > 1.0 || t.abs() > 1.0 {
            let foot = s.abs() < 0.16 && (1.0..1.3).contains(&t) || s.abs() < 0.5 && (1.3..1.4).contains(&t);
            let top = s.abs() < 1.8 && (1.4..1.6).contains(&t);
            let legs = (1.55..1.7).contains(&s.abs()) && (1.6..3.2).contains(&t);
            return match (foot, top, legs) {
                (true, ..) => Some([52.0, 52.0, 56.0]),
                (_, true, _) => Some(lit([236.0, 232.0, 224.0], 1.6 - 0.5 * t)),
                (.., true) => Some([196.0, 192.0, 186.0]),
                _ => None,
            };
        }
        if s.abs() > 0.93 || t.abs() > 0.91 {
            return Some([38.0, 38.0, 42.0]);
        }
        // Lines of text on a light page.
        let line = (7.0 * (t + 1.0)).fract();
        let word = value_noise(salted(seed, 101), 9.0 * s, (7.0 * (t + 1.0)).floor());
        let text = smoothstep(0.3, 0.4, line) * smoothstep(0.8, 0.7, line) * smoothstep(0.42, 0.46, word);
        let page =
            mix_colour([206.0, 214.0, 222.0], [84.0, 92.0, 108.0], text * smoothstep(0.86, 0.82, s.abs()));
        let bar = (0.5 * (t + 1.0) - turn).rem_euclid(1.0);
        Some(lit(page, 1.0 - 0.5 * smoothstep(0.0, 0.02, bar) * smoothstep(0.34, 0.32, bar)))
    }

    fn glints(&self, x: f32, y: f32, turn: f32, under: Colour, seed: u64) -> Option<Colour> {
        let scale = 40.0 / self.height;
        let shore = fractal_noise(salted(seed, 102), x * 0.08 * scale, y * 0.2 * scale, 3);
        let away = (2.0 * x / self.width).hypot(2.0 * y / self.height) + 0.3 * (shore - 0.5);
        if away > 1.0 {
            return None;
        }
        // Two wave trains; where both are high the water reflects the sun.
        let train = |salt, speed: f32| {
            value_noise(
                salted(seed, salt),
                (0.22 * x) * scale + 2.0 * speed * turn,
                (0.75 * y) * scale + speed * turn,
            )
        };
        let height = 0.5 * (train(103, 1.0) + train(104, -1.3));
        let water = mix_colour([58.0, 84.0, 92.0], [98.0, 124.0, 130.0], 0.5 + 0.5 * y / self.height);
        let water = lit(water, 0.88 + 0.24 * height);
        let water = mix_colour(water, [250.0, 250.0, 238.0], smoothstep(0.66, 0.72, height));
        Some(mix_colour(water, under, smoothstep(0.97, 1.0, away)))
    }
}
