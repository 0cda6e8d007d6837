//! A pixel's brightness over time, downsampled for small multiples of several pixels.

use std::ops::Range;

use crate::explain::pixel::history::PixelHistory;
use crate::mixture::pixel::{Component, luma};
use crate::settings::Space;

/// Consecutive frames of a pixel, drawn as one column of a sparkline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparklineColumn {
    /// Positions of its frames.
    pub frames: Range<usize>,
    /// Least and greatest brightness, in levels.
    pub values: (f32, f32),
    /// μ ± λσ of each component that was background in the last frame, in rank order.
    pub bands: Vec<(f32, f32)>,
    /// The share of its frames that are foreground, 0..=1.
    pub foreground: f32,
}

/// The sparkline of a history, at a scale of `columns` columns for `frames` frames; it has fewer columns while the
/// history has fewer frames.
pub fn sparkline(history: &PixelHistory, columns: usize, frames: usize) -> Vec<SparklineColumn> {
    let count = frames.min(columns.max(1));
    let edge = |column: usize| (frames * column / count.max(1)).min(history.states.len());
    let ranges =
        (0..count).map(|column| edge(column)..edge(column + 1)).take_while(|range| !range.is_empty());
    ranges.map(|range| sparkline_column(history, range)).collect()
}

fn sparkline_column(history: &PixelHistory, frames: Range<usize>) -> SparklineColumn {
    let states = &history.states[frames.clone()];
    let values = states.iter().map(|state| f32::from(luma(state.rgb)));
    let values = values
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let foreground = states.iter().filter(|state| state.outcome.foreground).count();
    let bands = states.last().map_or_else(Vec::new, |last| {
        let background = last.pixel.components().iter().take(usize::from(last.outcome.background_count));
        let band = |component: &Component| {
            let [r, g, b] = component.mean;
            let mean = match history.parameters.space {
                Space::Rgb => 0.299 * r + 0.587 * g + 0.114 * b,
                Space::Gray => r,
            };
            let reach = component.reach(history.parameters.lambda);
            (mean - reach, mean + reach)
        };
        background.map(band).collect()
    });
    SparklineColumn { frames, values, bands, foreground: foreground as f32 / states.len().max(1) as f32 }
}

/// The range of brightness of the plot: all values and bands of these columns, and at least `MIN_LEVELS` levels, so
/// that noise remains small.
pub fn level_range(sparks: &[SparklineColumn]) -> (f32, f32) {
    const MIN_LEVELS: f32 = 48.0;
    let all = sparks.iter().flat_map(|spark| spark.bands.iter().copied().chain([spark.values]));
    let (low, high) =
        all.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)));
    let (low, high) = (low.max(0.0), high.min(255.0));
    // A margin, so that the bands' edges are visible.
    let missing = ((MIN_LEVELS - (high - low)) / 2.0).max(0.14 * (high - low));
    if low <= high { (low - missing, high + missing) } else { (0.0, 255.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    fn history(frames: u32) -> PixelHistory {
        let colour = |n: u32| if n % 97 == 50 { [250, 240, 230] } else { [100 + (n % 7) as u8, 90, 80] };
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        PixelHistory::of_colours((0, 0), parameters, (0..frames).map(|n| (n + 1, colour(n))))
    }

    #[test]
    fn columns_keep_extremes_and_leave_room_for_later_frames() {
        let history = history(600);
        let all = sparkline(&history, 60, 600);
        assert_eq!(all.len(), 60);
        for (column, spark) in all.iter().enumerate() {
            let flash = (column * 10..column * 10 + 10).any(|n| n % 97 == 50);
            assert_eq!(spark.values.1 > 200.0, flash, "{column}");
            assert_eq!(spark.foreground > 0.0, flash, "{column}");
            let last = &history.states[column * 10 + 9];
            assert_eq!(spark.bands.len(), usize::from(last.outcome.background_count));
        }
        let (low, high) = all[30].bands[0];
        assert!(low < 93.0 && high > 93.0, "{low} {high}");
        let [r, g, b] = history.states[309].pixel.components()[0].mean;
        let first = 0.299 * r + 0.587 * g + 0.114 * b;
        assert!((f32::midpoint(low, high) - first).abs() < 1e-3, "component 1 comes first");
        assert_eq!(sparkline(&history, 60, 1200).len(), 30, "the history has half of the frames");
        assert_eq!(sparkline(&history, 900, 600).len(), 600, "a frame each");
        assert!(sparkline(&self::history(0), 60, 100).is_empty());
    }

    #[test]
    fn the_level_range_contains_all_columns_and_a_minimum_of_levels() {
        let spark = |values, bands: &[(f32, f32)]| SparklineColumn {
            values,
            bands: bands.to_vec(),
            ..SparklineColumn::default()
        };
        assert_eq!(level_range(&[spark((100.0, 104.0), &[(98.0, 106.0)])]), (78.0, 126.0));
        let (low, high) = level_range(&[spark((90.0, 94.0), &[(80.0, 110.0)]), spark((10.0, 240.0), &[])]);
        assert!(low < 10.0 && high > 240.0, "{low} {high}");
        assert_eq!(level_range(&[]), (0.0, 255.0));
    }
}
