//! Statistics of a pixel over some of its frames: mean and variance of its values, and counts of foreground frames
//! and of new components.

use std::ops::Range;

use crate::explain::pixel::component_slots::{ComponentChange, component_change};
use crate::explain::pixel::history::PixelHistory;
use crate::mixture::pixel::PixelValue;

/// Statistics of a pixel over some frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Number of frames.
    pub frames: usize,
    /// The mean of each channel, in levels.
    pub mean: PixelValue,
    /// The variance of each channel, in squared levels: the mean squared distance from the mean.
    pub variance: PixelValue,
    /// Number of frames in which the mixture classified it as foreground.
    pub foreground: usize,
    /// Number of components created in a free slot, including that of the first frame.
    pub births: usize,
    /// Number of components that replaced another.
    pub replacements: usize,
    /// The mean of B, the number of background components.
    pub mean_modes: f32,
    /// The greatest B.
    pub most_modes: u8,
    /// Number of components in use after the last frame.
    pub used: usize,
}

impl Statistics {
    /// The statistics of these states of a history; positions beyond the history are ignored.
    pub fn new(history: &PixelHistory, range: Range<usize>) -> Self {
        let end = range.end.min(history.states.len());
        let range = range.start.min(end)..end;
        let states = &history.states[range.clone()];
        let Some(last) = states.last() else { return Self::default() };
        let count = states.len() as f64;
        let mean =
            |of: &dyn Fn(PixelValue) -> f64| states.iter().map(|state| of(state.value)).sum::<f64>() / count;
        let means: [f64; 3] = std::array::from_fn(|channel| mean(&|value| f64::from(value[channel])));
        let variance = std::array::from_fn(|channel| {
            mean(&|value| (f64::from(value[channel]) - means[channel]).powi(2)) as f32
        });
        let count_of =
            |kind| range.clone().filter(|&index| component_change(history, index) == Some(kind)).count();
        let modes = states.iter().map(|state| state.outcome.background_count);
        Self {
            frames: states.len(),
            mean: means.map(|mean| mean as f32),
            variance,
            foreground: states.iter().filter(|state| state.outcome.foreground).count(),
            births: count_of(ComponentChange::Born),
            replacements: count_of(ComponentChange::Replaced),
            mean_modes: (modes.clone().map(f64::from).sum::<f64>() / count) as f32,
            most_modes: modes.max().unwrap_or(0),
            used: last.pixel.used(),
        }
    }

    /// The share of foreground frames, 0..=1.
    pub fn foreground_share(&self) -> f32 {
        self.foreground as f32 / self.frames.max(1) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    /// K = 2: ten dark frames, a bright one, eight dark ones, then a third colour.
    fn history() -> PixelHistory {
        let parameters = Parameters::new(&Settings { k: 2, ..Settings::preset(Preset::Plain) });
        let colour = |n| match n {
            11 => [200, 100, 0],
            20 => [10, 250, 130],
            _ => [20, 20, 20],
        };
        PixelHistory::of_colours((1, 1), parameters, (1..=20).map(|n| (n, colour(n))))
    }

    #[test]
    fn statistics_equal_values_computed_by_hand() {
        let all = Statistics::new(&history(), 0..20);
        // Red: 18 × 20, 200, 10: mean 28.5, squares (18·400 + 40 000 + 100) / 20 − 28.5².
        assert_eq!((all.frames, all.mean[0]), (20, 28.5));
        assert_eq!(all.variance[0], 47_300.0 / 20.0 - 28.5 * 28.5);
        assert_eq!(all.mean[2], (18.0 * 20.0 + 130.0) / 20.0);
        // Births: the first frame and the bright one. The third colour replaces a component.
        assert_eq!((all.births, all.replacements, all.foreground), (2, 1, 2));
        assert_eq!(all.foreground_share(), 0.1);
        assert_eq!((all.used, all.most_modes, all.mean_modes), (2, 1, 1.0));
    }

    #[test]
    fn statistics_of_a_range_count_only_its_frames() {
        let part = Statistics::new(&history(), 11..25);
        assert_eq!((part.frames, part.births, part.replacements, part.foreground), (9, 0, 1, 1));
        let steady = Statistics::new(&history(), 1..10);
        assert_eq!((steady.births, steady.variance, steady.used), (0, [0.0; 3], 1));
        assert_eq!(Statistics::new(&history(), 30..40), Statistics::default());
    }
}
