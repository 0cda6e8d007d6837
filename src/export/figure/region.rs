//! A figure of the share of foreground around a pixel over time.

use std::ops::Range;

use super::through_time::COLUMNS;
use super::{
    Axis, Figure, INK, Key, MarkShape, Panel, Sign, WIDE, frame_span, frames_axis, number_at, parameters,
    pixel_name,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::RegionShares;
use crate::palette::verdict_colour;

/// The opacity of the area.
const STRENGTH: f64 = 0.55;

/// The maximum shares over consecutive frames, so that short peaks remain visible.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// Positions of the frames.
    pub frames: Range<usize>,
    /// The maximum share before cleaning, 0..=1.
    pub model: f32,
    /// The maximum share after cleaning, 0..=1.
    pub cleaned: f32,
}

/// The maxima over all frames of a region, in at most `columns` columns of nearly equal length.
pub fn peaks(shares: &RegionShares, columns: usize) -> Vec<Peak> {
    let frames = shares.model.len().min(shares.cleaned.len());
    let count = frames.min(columns.max(1));
    let most = |shares: &[f32]| shares.iter().copied().fold(0.0, f32::max);
    (0..count)
        .map(|column| {
            let range = frames * column / count..frames * (column + 1) / count;
            let (model, cleaned) = (most(&shares.model[range.clone()]), most(&shares.cleaned[range.clone()]));
            Peak { frames: range, model, cleaned }
        })
        .collect()
}

/// The figure: the share after cleaning as an area, before it as a line. `history` is that of the centre pixel, whose
/// frame numbers label the axis; `index` is the position of the frame in view.
pub fn figure(history: &PixelHistory, shares: &RegionShares, index: usize) -> Figure {
    let peaks = peaks(shares, COLUMNS);
    let end = peaks.last().map_or(0, |peak| peak.frames.end);
    let (first, last) = (number_at(history, 0), number_at(history, end.saturating_sub(1)));
    let title = format!(
        "foreground ratio in the neighbourhood of {} pixels around {}, frames {first}–{last}",
        shares.pixels,
        pixel_name(history)
    );
    let legend = vec![
        Key::new(Sign::Patch(STRENGTH), verdict_colour(true, false), "after post-processing"),
        Key::new(Sign::Line, INK, "mixture verdicts"),
        Key::new(Sign::Dashed, INK, "current frame"),
    ];
    let region = format!("{side} × {side} pixels, {}", parameters(history), side = shares.side);
    let mut figure = Figure::new(WIDE, title, region, legend);
    let edges = |peak: &Peak| frame_span(history, &peak.frames);
    let ends = match (peaks.first(), peaks.last()) {
        (Some(first), Some(last)) => (edges(first)[0], edges(last)[1]),
        _ => (0.5, 1.5),
    };
    let share = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (share, format!("{:.0} %", share * 100.0)));
    let up = Axis::new("foreground ratio", (0.0, 1.0), 4).with_ticks(share.to_vec());
    let mut panel = Panel::new(frames_axis(ends), up);
    let steps = |of: fn(&Peak) -> f32| -> Vec<[f64; 2]> {
        peaks.iter().flat_map(|peak| edges(peak).map(|x| [x, f64::from(of(peak))])).collect()
    };
    let mut area = steps(|peak| peak.cleaned);
    area.extend([[ends.1, 0.0], [ends.0, 0.0]]);
    panel.draw("ratio after post-processing", MarkShape::Area(area), verdict_colour(true, false), STRENGTH);
    let line = MarkShape::Line { points: steps(|peak| peak.model), width: 0.9, dashed: false };
    panel.draw("ratio before post-processing", line, INK, 1.0);
    if index < end {
        panel.draw_vertical("current frame", f64::from(number_at(history, index)), 0.6, true);
    }
    panel.draw_ground("none");
    figure.stack(0, 1, vec![(panel, 110.0)]);
    figure
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_the_maximum_share_of_its_frames() {
        let model: Vec<f32> = (0..1000).map(|n| if n == 777 { 1.0 } else { 0.1 }).collect();
        let cleaned = vec![0.05; 1000];
        let shares = RegionShares { at: (4, 4), side: 3, pixels: 9, model, cleaned };
        let columns = peaks(&shares, 60);
        assert_eq!((columns.len(), columns[0].frames.start, columns[59].frames.end), (60, 0, 1000));
        for pair in columns.windows(2) {
            assert_eq!(pair[0].frames.end, pair[1].frames.start);
        }
        for peak in &columns {
            let expected = if peak.frames.contains(&777) { 1.0 } else { 0.1 };
            assert_eq!((peak.model, peak.cleaned), (expected, 0.05), "{:?}", peak.frames);
        }
        assert_eq!(peaks(&shares, 5000).len(), 1000, "a frame each");
        let none = RegionShares { model: Vec::new(), cleaned: Vec::new(), ..shares };
        assert!(peaks(&none, 60).is_empty());
    }
}
