//! Which colour stands for which number: steps for counts, an even ramp for all else.
//!
//! The tables go to the graphics card as they are here, and the shader looks numbers up in them as [`Scale`] does.

use eframe::egui::Color32;

use crate::app::theme;
use crate::palette;

/// How many colours the ramp has.
pub(super) const RAMP: usize = 255;

/// The colour of what has no number, such as how long ago something was that never was.
pub(super) const NEVER: Color32 = Color32::from_rgb(26, 28, 32);

/// The colours of counts: white for none, dark for one, brighter for more, warm for many; the last for all that are
/// greater.
pub(super) const STEPS: [Color32; 6] = [
    Color32::from_rgb(255, 255, 255),
    Color32::from_rgb(38, 50, 72),
    Color32::from_rgb(52, 104, 190),
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(213, 94, 0),
];

/// How numbers become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// A step of its own for each count.
    Steps,
    /// The ramp from `low` to `high`.
    Linear { low: f32, high: f32 },
    /// The ramp over the logarithm of the number plus `offset`; it runs backwards where `low` is greater than `high`.
    Log { offset: f32, low: f32, high: f32 },
}

impl Scale {
    /// Where a number lies on the ramp, 0 to 1; nowhere, if it is infinite.
    pub(super) fn share(self, value: f32) -> Option<f32> {
        let share = match self {
            Self::Steps => value / (STEPS.len() - 1) as f32,
            Self::Linear { low, high } => (value - low) / (high - low),
            Self::Log { offset, low, high } => {
                let log = |value: f32| (value + offset).log2();
                (log(value) - log(low)) / (log(high) - log(low))
            }
        };
        value.is_finite().then_some(share.clamp(0.0, 1.0))
    }

    /// The colour of a number.
    pub(super) fn colour(self, value: f32) -> Color32 {
        if self == Self::Steps {
            return STEPS[(value.max(0.0) as usize).min(STEPS.len() - 1)];
        }
        self.share(value).map_or(NEVER, |share| ramp((share * (RAMP - 1) as f32).round() as usize))
    }

    /// The shader's: 0 for steps, 1 for a line, 2 for a logarithm; what is added; both ends.
    pub(super) fn values(self) -> [f32; 4] {
        match self {
            Self::Steps => [0.0; 4],
            Self::Linear { low, high } => [1.0, 0.0, low, high],
            Self::Log { offset, low, high } => [2.0, offset, (low + offset).log2(), (high + offset).log2()],
        }
    }
}

/// One of the ramp's colours, from dark to bright.
pub(super) fn ramp(step: usize) -> Color32 {
    theme::rgb(palette::ramp(step.min(RAMP - 1) as f32 / (RAMP - 1) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness, 0 to 100.
    fn lightness(colour: Color32) -> f32 {
        let [r, g, b, _] = colour.to_array().map(|channel| (f32::from(channel) / 255.0).powf(2.2));
        116.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt() - 16.0
    }

    #[test]
    fn the_ramp_grows_lighter_evenly() {
        let all: Vec<f32> = (0..RAMP).map(|step| lightness(ramp(step))).collect();
        let whole = all[RAMP - 1] - all[0];
        assert!(whole > 70.0, "{whole}");
        for (from, to) in all.iter().zip(&all[32..]) {
            let share = (to - from) / whole / (32.0 / (RAMP - 1) as f32);
            assert!((0.7..1.4).contains(&share), "{share}");
        }
    }

    #[test]
    fn a_scale_reaches_from_one_end_to_the_other() {
        let line = Scale::Linear { low: 0.0, high: 1.0 };
        assert_eq!((line.colour(-3.0), line.colour(7.0)), (ramp(0), ramp(RAMP - 1)));
        let log = Scale::Log { offset: 0.0, low: 4.0, high: 64.0 };
        assert_eq!([4.0, 16.0, 64.0, 1e4].map(|value| log.share(value)), [0.0, 0.5, 1.0, 1.0].map(Some));
        let ago = Scale::Log { offset: 1.0, low: 1023.0, high: 0.0 };
        assert_eq!([0.0, 31.0, 1023.0].map(|value| ago.share(value)), [1.0, 0.5, 0.0].map(Some));
        assert_eq!((ago.share(f32::INFINITY), ago.colour(f32::INFINITY)), (None, NEVER));
        assert_eq!([0.0, 1.0, 5.0, 8.0].map(|n| Scale::Steps.colour(n)), [0, 1, 5, 5].map(|n| STEPS[n]));
    }
}
