//! Downsampling of pixel histories to the number of columns on the screen. Each column holds the extremes of its
//! frames, so that short events remain visible.

use std::ops::Range;

use crate::explain::pixel::component_slots::{ComponentChange, component_change};
use crate::explain::pixel::history::PixelHistory;
use crate::mixture::pixel::MAX_K;

/// Number of levels per bin of [`HistoryColumn::levels`].
pub const LEVELS_PER_BIN: u8 = 4;
/// Largest number of frames of a column without [`HistoryColumn::levels`].
pub const MAX_FRAMES_WITHOUT_LEVELS: usize = 4;

/// Consecutive frames of a history, drawn as one column.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryColumn {
    /// Positions of its frames.
    pub frames: Range<usize>,
    /// Least and greatest value of each channel.
    pub value: [(f32, f32); 3],
    /// Histogram of each channel in bins of [`LEVELS_PER_BIN`] levels: `(bin, frames)` of the non-empty bins; empty
    /// for columns of few frames.
    pub levels: [Vec<(u8, u32)>; 3],
    /// The matching range of each component, by slot.
    pub bands: [Option<Band>; MAX_K],
    /// Slot and weight of the components in use in the column's last frame, in rank order.
    pub weights: Vec<(u8, f32)>,
    /// B in the last frame.
    pub background_count: u8,
    /// The greatest B.
    pub most_background: u8,
    /// Number of foreground frames.
    pub foreground: usize,
    /// Least and greatest ρ of the frames in which a component was updated; `None` if there are none.
    pub rho: Option<(f32, f32)>,
    /// The slot of the last component that was created in a free slot, that replaced another, and that rose in rank.
    pub changes: [Option<u8>; 3],
    /// The slots in which a component was created.
    pub made: [bool; MAX_K],
}

impl HistoryColumn {
    /// The share of its frames that are foreground, 0..=1.
    pub fn foreground_share(&self) -> f32 {
        self.foreground as f32 / self.frames.len().max(1) as f32
    }
}

/// The matching range of a component during a column: μ ± λσ in each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Least μ − λσ and greatest μ + λσ of each channel.
    pub range: [(f32, f32); 3],
    /// μ in the last frame.
    pub mean: [f32; 3],
    /// Whether it was background in the last frame.
    pub background: bool,
}

/// Downsamples `frames` of the history to at most `columns` columns of nearly equal length.
pub fn downsample(
    history: &PixelHistory,
    slots: &[[u8; MAX_K]],
    frames: Range<usize>,
    columns: usize,
) -> Vec<HistoryColumn> {
    let end = frames.end.min(history.states.len()).min(slots.len());
    let frames = frames.start.min(end)..end;
    let count = frames.len().min(columns.max(1));
    let edge = |bin: usize| frames.start + frames.len() * bin / count.max(1);
    (0..count).map(|at| column(history, slots, edge(at)..edge(at + 1))).collect()
}

fn column(history: &PixelHistory, slots: &[[u8; MAX_K]], frames: Range<usize>) -> HistoryColumn {
    let lambda = history.parameters.lambda;
    let mut bin = HistoryColumn {
        frames: frames.clone(),
        value: [(f32::INFINITY, f32::NEG_INFINITY); 3],
        levels: Default::default(),
        bands: [None; MAX_K],
        weights: Vec::new(),
        background_count: 0,
        most_background: 0,
        foreground: 0,
        rho: None,
        changes: [None; 3],
        made: [false; MAX_K],
    };
    for index in frames.clone() {
        let slot = slots[index][usize::from(history.states[index].outcome.rank).saturating_sub(1)];
        let kind = match component_change(history, index) {
            None => continue,
            Some(ComponentChange::Born) => 0,
            Some(ComponentChange::Replaced) => 1,
            Some(ComponentChange::Rose { .. }) => 2,
        };
        bin.changes[kind] = Some(slot);
        bin.made[usize::from(slot)] |= kind < 2;
    }
    for (state, slots) in history.states[frames.clone()].iter().zip(&slots[frames]) {
        for ((low, high), value) in bin.value.iter_mut().zip(state.value) {
            (*low, *high) = (low.min(value), high.max(value));
        }
        let count = state.outcome.background_count;
        let used = state.pixel.components().iter().take_while(|component| component.is_used());
        for ((rank, component), &slot) in used.enumerate().zip(slots) {
            let reach = component.reach(lambda);
            let band = bin.bands[usize::from(slot)].get_or_insert(Band {
                range: [(f32::INFINITY, f32::NEG_INFINITY); 3],
                mean: component.mean,
                background: false,
            });
            for ((low, high), mean) in band.range.iter_mut().zip(component.mean) {
                (*low, *high) = (low.min(mean - reach), high.max(mean + reach));
            }
            band.mean = component.mean;
            band.background = rank < usize::from(count);
        }
        bin.background_count = count;
        bin.most_background = bin.most_background.max(count);
        bin.foreground += usize::from(state.outcome.foreground);
        if state.outcome.matched > 0 {
            let rho = state.outcome.rho;
            let (low, high) = bin.rho.unwrap_or((rho, rho));
            bin.rho = Some((low.min(rho), high.max(rho)));
        }
    }
    if bin.frames.len() > MAX_FRAMES_WITHOUT_LEVELS {
        bin.levels = std::array::from_fn(|channel| levels(history, bin.frames.clone(), channel));
    }
    if let Some(last) = bin.frames.clone().next_back() {
        let used = history.states[last].pixel.components().iter().take_while(|component| component.is_used());
        bin.weights = used.zip(slots[last]).map(|(component, slot)| (slot, component.weight)).collect();
    }
    bin
}

/// The range of the values of these columns and of the background's bands, with a margin.
pub fn value_range(bins: &[HistoryColumn], channels: usize) -> (f64, f64) {
    let values = bins.iter().flat_map(|bin| bin.value[..channels].iter().copied());
    let bands = bins.iter().flat_map(|bin| bin.bands.iter().flatten()).filter(|band| band.background);
    let (low, high) = values
        .chain(bands.flat_map(|band| band.range[..channels].iter().copied()))
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), (from, to)| (low.min(from), high.max(to)));
    if low > high { (0.0, 255.0) } else { (f64::from(low) - 3.0, f64::from(high) + 3.0) }
}

/// The powers of ten between which all ρ of these columns lie; the upper one is 1.
pub fn rate_range(bins: &[HistoryColumn]) -> (f64, f64) {
    let least = bins.iter().filter_map(|bin| bin.rho).map(|(low, _)| low).filter(|&rho| rho > 0.0);
    // 0.01 in f64 is slightly more than the nearest f32.
    let power = (f64::from(least.fold(0.1_f32, f32::min)).log10() + 1e-6).floor();
    // The paper's ρ = α·η can be almost 0.
    (10_f64.powf(power.max(-12.0)), 1.0)
}

fn levels(history: &PixelHistory, frames: Range<usize>, channel: usize) -> Vec<(u8, u32)> {
    let mut counts = [0_u32; 256 / LEVELS_PER_BIN as usize];
    for state in &history.states[frames] {
        counts[state.value[channel].clamp(0.0, 255.0) as usize / usize::from(LEVELS_PER_BIN)] += 1;
    }
    let occurring = counts.into_iter().enumerate().filter(|&(_, count)| count > 0);
    occurring.map(|(step, count)| (step as u8, count)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::explain::pixel::component_slots::slots_by_rank;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    fn history(frames: u32) -> PixelHistory {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colour = |n: u32| if n % 97 == 50 { [250, 10, 10] } else { [100 + (n % 7) as u8, 90, 80] };
        PixelHistory::of_colours((0, 0), parameters, (0..frames).map(|n| (n + 1, colour(n))))
    }

    #[test]
    fn columns_cover_every_frame_once_and_keep_the_extremes() {
        let history = history(1000);
        let bins = downsample(&history, &slots_by_rank(&history), 100..900, 64);
        assert_eq!(bins.len(), 64);
        assert_eq!((bins[0].frames.start, bins[63].frames.end), (100, 900));
        assert!(bins.windows(2).all(|pair| pair[0].frames.end == pair[1].frames.start));
        let foreground = history.states[100..900].iter().filter(|state| state.outcome.foreground).count();
        assert_eq!(bins.iter().map(|bin| bin.foreground).sum::<usize>(), foreground);
        assert!(foreground > 0);
        // Each flash to red is visible, and only in its own column.
        for bin in &bins {
            let flash = bin.frames.clone().any(|n| n % 97 == 50);
            assert_eq!(bin.value[0].1 == 250.0, flash);
            assert_eq!(bin.value[1].0 == 10.0, flash);
            assert_eq!(bin.levels[0].contains(&(250 / LEVELS_PER_BIN, 1)), flash);
            let counted: u32 = bin.levels[0].iter().map(|&(_, count)| count).sum();
            assert_eq!(counted as usize, bin.frames.len());
        }
    }

    #[test]
    fn a_column_of_one_frame_equals_that_frame() {
        let history = history(60);
        let slots = slots_by_rank(&history);
        let bins = downsample(&history, &slots, 0..60, 400);
        assert_eq!(bins.len(), 60);
        for (state, bin) in history.states.iter().zip(&bins) {
            assert_eq!(bin.value[0], (state.value[0], state.value[0]));
            let component = state.pixel.components()[0];
            let band = bin.bands[usize::from(bin.weights[0].0)].unwrap();
            assert_eq!(band.mean, component.mean);
            assert_eq!(band.range[1].1, component.mean[1] + 2.5 * component.sigma());
            assert_eq!(bin.weights.len(), state.pixel.used());
            assert_eq!(bin.background_count, state.outcome.background_count);
            let learned = state.outcome.matched > 0;
            assert_eq!(bin.rho, learned.then_some((state.outcome.rho, state.outcome.rho)));
        }
    }

    #[test]
    fn every_component_change_is_kept() {
        let history = history(1000);
        let slots = slots_by_rank(&history);
        let made: Vec<_> = (0..1000).filter(|&n| history.states[n].outcome.matched == 0).collect();
        assert!(made.len() > 1, "the history creates components: {made:?}");
        for columns in [1000, 64, 7] {
            for bin in downsample(&history, &slots, 0..1000, columns) {
                let within: Vec<_> = made.iter().filter(|n| bin.frames.contains(n)).collect();
                assert_eq!(bin.changes[0].or(bin.changes[1]).is_some(), !within.is_empty());
                for &&n in &within {
                    let rank = usize::from(history.states[n].outcome.rank) - 1;
                    assert!(bin.made[usize::from(slots[n][rank])], "frame {n}");
                }
            }
        }
    }

    #[test]
    fn a_value_range_contains_values_and_background() {
        let history = history(300);
        let all = downsample(&history, &slots_by_rank(&history), 0..300, 50);
        let (low, high) = value_range(&all, 3);
        // The values include the flashes to red, [250, 10, 10]; the background's widest band, 80 − λσ₀ = 30, is
        // within their range.
        assert_eq!((low, high), (7.0, 253.0));
        assert_eq!(value_range(&[], 3), (0.0, 255.0));
    }

    #[test]
    fn rates_lie_between_powers_of_ten() {
        let history = history(300);
        let bins = downsample(&history, &slots_by_rank(&history), 0..300, 50);
        let (low, high) = rate_range(&bins);
        assert_eq!(high, 1.0);
        assert!((low.log10() - low.log10().round()).abs() < 1e-9);
        let learned = history.states.iter().filter(|state| state.outcome.matched > 0);
        let least = learned.map(|state| f64::from(state.outcome.rho)).fold(1.0, f64::min);
        assert!(low <= least * 1.001 && least < 10.0 * low, "{low} and {least}");
        assert_eq!(rate_range(&[]), (0.1, 1.0));
    }

    #[test]
    fn ranges_are_clamped_to_the_history() {
        let history = history(10);
        let slots = slots_by_rank(&history);
        assert_eq!(downsample(&history, &slots, 5..50, 400).len(), 5);
        assert!(downsample(&history, &slots, 50..60, 400).is_empty());
        assert_eq!(downsample(&history, &slots, 0..10, 0).len(), 1);
    }
}
