//! Camera noise.

use rand::Rng;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

use super::texture::{Colour, hash};

/// Gaussian noise, independent for every channel of every pixel of every frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraNoise {
    /// Standard deviation in gray levels.
    pub sigma: f32,
    /// Whether it grows with the light, as photon noise does: σ at mid gray, 0.4 σ in black, 1.35 σ in white.
    pub signal_dependent: bool,
}

/// The standard normal distribution's quantiles at the middles of 4096 equal shares: a table look-up converts 12
/// random bits to a sample, the same on every machine. The tails end at 3.7 σ.
static QUANTILES: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..4096).map(|i| normal_quantile((f64::from(i) + 0.5) / 4096.0) as f32).collect());

/// x with P(X ≤ x) = p for a standard normal X, 0 < p < 1 (P. J. Acklam's rational approximation, relative error 1.15e-9).
fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969_683_028_665_376e1,
        2.209_460_984_245_205e2,
        -2.759_285_104_469_687e2,
        1.383_577_518_672_69e2,
        -3.066_479_806_614_716e1,
        2.506_628_277_459_239,
    ];
    const B: [f64; 6] = [
        -5.447_609_879_822_406e1,
        1.615_858_368_580_409e2,
        -1.556_989_798_598_866e2,
        6.680_131_188_771_972e1,
        -1.328_068_155_288_572e1,
        1.0,
    ];
    const C: [f64; 6] = [
        -7.784_894_002_430_293e-3,
        -3.223_964_580_411_365e-1,
        -2.400_758_277_161_838,
        -2.549_732_539_343_734,
        4.374_664_141_464_968,
        2.938_163_982_698_783,
    ];
    const D: [f64; 5] = [
        7.784_695_709_041_462e-3,
        3.224_671_290_700_398e-1,
        2.445_134_137_142_996,
        3.754_408_661_907_416,
        1.0,
    ];
    let polynomial = |factors: &[f64], x: f64| factors.iter().fold(0.0, |sum, factor| sum * x + factor);
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    if p < 0.02425 {
        let q = (-2.0 * p.ln()).sqrt();
        return polynomial(&C, q) / polynomial(&D, q);
    }
    let q = p - 0.5;
    polynomial(&A, q * q) * q / polynomial(&B, q * q)
}

/// The nearest level, halves up. `f32::round` would call the C library for each value.
fn nearest_byte(value: f32) -> u8 {
    let value = value.clamp(0.0, 255.0);
    let whole = value as u8;
    whole + u8::from(value - f32::from(whole) >= 0.5)
}

impl CameraNoise {
    /// Converts a row of light to the camera's bytes. The noise depends only on the seed, the frame and the row, so
    /// that rows and frames can be rendered in any order.
    pub fn expose(&self, light: &[Colour], rgb: &mut [u8], seed: u64, frame: u32, row: u32) {
        let key = |salt| u128::from(hash(seed ^ salt, i64::from(frame), i64::from(row)));
        let mut random = Pcg64Mcg::new(key(0x6E6F_6973) << 64 | key(0x65));
        let quantiles = QUANTILES.as_slice();
        for (colour, bytes) in light.iter().zip(rgb.chunks_exact_mut(3)) {
            let bits = random.next_u64();
            for (channel, (value, byte)) in colour.iter().zip(bytes).enumerate() {
                let sample = quantiles[(bits >> (20 * channel + 4)) as usize & 4095];
                let sigma = if self.signal_dependent {
                    self.sigma * (0.16 + 0.84 * value / 128.0).max(0.0).sqrt()
                } else {
                    self.sigma
                };
                *byte = nearest_byte(value + sigma * sample);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(noise: CameraNoise, level: f32) -> (f32, f32) {
        let light = vec![[level; 3]; 20_000];
        let mut rgb = vec![0; 60_000];
        noise.expose(&light, &mut rgb, 1, 2, 3);
        let mean = rgb.iter().map(|&value| f32::from(value)).sum::<f32>() / 60_000.0;
        let variance = rgb.iter().map(|&value| (f32::from(value) - mean).powi(2)).sum::<f32>() / 60_000.0;
        (mean, variance.sqrt())
    }

    #[test]
    fn levels_are_rounded_and_limited() {
        for value in (-600..=3000).map(|tenth| tenth as f32 / 10.0).chain([0.499_999_97, 254.499_98, 254.5]) {
            assert_eq!(nearest_byte(value), value.round().clamp(0.0, 255.0) as u8, "{value}");
        }
    }

    #[test]
    fn noise_has_the_given_standard_deviation() {
        let (mean, sigma) = spread(CameraNoise { sigma: 5.0, signal_dependent: false }, 100.0);
        assert!((mean - 100.0).abs() < 0.1 && (sigma - 5.0).abs() < 0.1, "{mean} {sigma}");
        let by_light = CameraNoise { sigma: 5.0, signal_dependent: true };
        let (dark, bright) = (spread(by_light, 30.0).1, spread(by_light, 200.0).1);
        assert!((dark - 2.99).abs() < 0.1 && (bright - 6.08).abs() < 0.1, "{dark} {bright}");
    }

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        for (p, x) in [(0.5, 0.0), (0.841_344_746, 1.0), (0.022_750_132, -2.0), (0.998_650_102, 3.0)] {
            assert!((normal_quantile(p) - x).abs() < 1e-6, "{p}");
        }
    }

    #[test]
    fn noise_differs_between_frames_and_rows() {
        let noise = CameraNoise { sigma: 5.0, signal_dependent: false };
        let row = |seed, frame, row| {
            let mut rgb = vec![0; 300];
            noise.expose(&[[100.0; 3]; 100], &mut rgb, seed, frame, row);
            rgb
        };
        assert_eq!(row(1, 1, 1), row(1, 1, 1));
        assert!([row(2, 1, 1), row(1, 2, 1), row(1, 1, 2)].iter().all(|other| *other != row(1, 1, 1)));
    }
}
