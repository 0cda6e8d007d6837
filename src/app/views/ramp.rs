//! Colour scales: steps for counts, a perceptually uniform ramp for other quantities.
//!
//! The shader has the same tables as textures and looks values up as [`ColourScale`] does.

use eframe::egui::Color32;

use crate::app::theme;
use crate::palette;

/// The number of colours of the ramp.
pub(super) const RAMP_COLOURS: usize = 255;

/// The colour of infinite values, such as the frames since foreground of a pixel that was never foreground.
pub(super) const INFINITE_COLOUR: Color32 = Color32::from_rgb(26, 28, 32);

/// The colours of counts: white for zero, dark for one, brighter for more, warm for many. The last is for all larger
/// counts.
pub(super) const COUNT_COLOURS: [Color32; 6] = [
    Color32::from_rgb(255, 255, 255),
    Color32::from_rgb(38, 50, 72),
    Color32::from_rgb(52, 104, 190),
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(213, 94, 0),
];

/// A map from values to colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ColourScale {
    /// A separate colour for each count.
    Steps,
    /// The ramp from `low` to `high`.
    Linear { low: f32, high: f32 },
    /// The ramp over the logarithm of the value plus `offset`. It is reversed where `low` is greater than `high`.
    Log { offset: f32, low: f32, high: f32 },
}

impl ColourScale {
    /// The position of a value on the ramp, 0 to 1; `None` if it is not finite.
    pub(super) fn share(self, value: f32) -> Option<f32> {
        let share = match self {
            Self::Steps => value / (COUNT_COLOURS.len() - 1) as f32,
            Self::Linear { low, high } => (value - low) / (high - low),
            Self::Log { offset, low, high } => {
                let log = |value: f32| (value + offset).log2();
                (log(value) - log(low)) / (log(high) - log(low))
            }
        };
        value.is_finite().then_some(share.clamp(0.0, 1.0))
    }

    /// The colour of a value.
    pub(super) fn colour(self, value: f32) -> Color32 {
        if self == Self::Steps {
            return COUNT_COLOURS[(value.max(0.0) as usize).min(COUNT_COLOURS.len() - 1)];
        }
        self.share(value)
            .map_or(INFINITE_COLOUR, |share| ramp((share * (RAMP_COLOURS - 1) as f32).round() as usize))
    }

    /// The shader's parameters: 0 for steps, 1 for linear, 2 for logarithmic; the offset; both ends.
    pub(super) fn values(self) -> [f32; 4] {
        match self {
            Self::Steps => [0.0; 4],
            Self::Linear { low, high } => [1.0, 0.0, low, high],
            Self::Log { offset, low, high } => [2.0, offset, (low + offset).log2(), (high + offset).log2()],
        }
    }
}

/// A colour of the ramp, from dark to bright.
pub(super) fn ramp(step: usize) -> Color32 {
    theme::rgb(palette::ramp(step.min(RAMP_COLOURS - 1) as f32 / (RAMP_COLOURS - 1) as f32))
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
    fn the_lightness_of_the_ramp_increases_evenly() {
        let all: Vec<f32> = (0..RAMP_COLOURS).map(|step| lightness(ramp(step))).collect();
        let whole = all[RAMP_COLOURS - 1] - all[0];
        assert!(whole > 70.0, "{whole}");
        for (from, to) in all.iter().zip(&all[32..]) {
            let share = (to - from) / whole / (32.0 / (RAMP_COLOURS - 1) as f32);
            assert!((0.7..1.4).contains(&share), "{share}");
        }
    }

    #[test]
    fn a_scale_covers_the_whole_ramp() {
        let line = ColourScale::Linear { low: 0.0, high: 1.0 };
        assert_eq!((line.colour(-3.0), line.colour(7.0)), (ramp(0), ramp(RAMP_COLOURS - 1)));
        let log = ColourScale::Log { offset: 0.0, low: 4.0, high: 64.0 };
        assert_eq!([4.0, 16.0, 64.0, 1e4].map(|value| log.share(value)), [0.0, 0.5, 1.0, 1.0].map(Some));
        let ago = ColourScale::Log { offset: 1.0, low: 1023.0, high: 0.0 };
        assert_eq!([0.0, 31.0, 1023.0].map(|value| ago.share(value)), [1.0, 0.5, 0.0].map(Some));
        assert_eq!((ago.share(f32::INFINITY), ago.colour(f32::INFINITY)), (None, INFINITE_COLOUR));
        assert_eq!(
            [0.0, 1.0, 5.0, 8.0].map(|n| ColourScale::Steps.colour(n)),
            [0, 1, 5, 5].map(|n| COUNT_COLOURS[n])
        );
    }
}
