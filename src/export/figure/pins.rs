//! A figure of several pixels over time, stacked.

use super::through_time::COLUMNS;
use super::{
    Axis, Figure, GRAY, INK, Key, MarkShape, Panel, Sign, WIDE, frame_span, frames_axis, number_at,
    parameters, verdicts,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::sparklines::{SparklineColumn, level_range, sparkline};
use crate::palette::identity_on_light;

/// The opacity of the band of component 1, and of those of others.
const STRENGTHS: [f64; 2] = [0.42, 0.24];

/// The figure: for each pixel, with its number, its brightness over the bands of its background components, and its
/// verdict below. `index` is the position of the frame in view.
pub fn figure(pins: &[(u8, &PixelHistory)], index: usize) -> Figure {
    let frames = pins.iter().map(|(_, history)| history.states.len()).max().unwrap_or(0);
    let longest = pins.iter().map(|(_, history)| *history).find(|history| history.states.len() == frames);
    let number = |position| longest.map_or(0, |history| number_at(history, position));
    let (first, last) = (number(0), number(frames.saturating_sub(1)));
    let lambda = longest.map_or(0.0, |history| history.parameters.lambda);
    let title = format!("pinned pixels, frames {first}–{last}");
    let band = format!("μ ± {}σ of background components", crate::explain::pixel::verdict::number(lambda));
    let mut legend = vec![
        Key::new(Sign::Line, INK, "brightness"),
        Key::new(Sign::Patch(STRENGTHS[0]), GRAY, band),
        Key::new(Sign::Dashed, INK, "current frame"),
    ];
    let columns: Vec<Vec<SparklineColumn>> =
        pins.iter().map(|(_, history)| sparkline(history, COLUMNS, frames)).collect();
    legend.extend(verdicts::legend(columns.iter().flatten().map(|spark| spark.foreground)));
    let description = longest.map(parameters).unwrap_or_default();
    let mut figure = Figure::new(WIDE, title, description, legend);
    let ends = if frames == 0 { (0.5, 1.5) } else { (f64::from(first) - 0.5, f64::from(last) + 0.5) };
    let mut panels = Vec::new();
    for ((pin, history), sparks) in pins.iter().zip(&columns) {
        let (low, high) = level_range(sparks);
        let mut panel = Panel::new(
            frames_axis(ends),
            Axis::new(format!("P{pin} (levels)"), (low.into(), high.into()), 3),
        );
        let (x, y) = history.source_pixel();
        panel.caption = format!("P{pin}, pixel ({x}, {y})");
        bands(&mut panel, history, sparks, identity_on_light((*pin).into()));
        let brightness = sparks.iter().flat_map(|spark| {
            let [from, to] = frame_span(history, &spark.frames);
            let middle = f64::midpoint(from, to);
            [[middle, f64::from(spark.values.0)], [middle, f64::from(spark.values.1)]]
        });
        let mut points: Vec<_> = brightness.collect();
        points.dedup();
        panel.draw("brightness", MarkShape::Line { points, width: 0.6, dashed: false }, INK, 1.0);
        let mut below = Panel { grid: false, ..Panel::new(frames_axis(ends), Axis::new("", (0.0, 1.0), 1)) };
        below.y.ticks.clear();
        verdicts::draw(
            &mut below,
            sparks.iter().map(|spark| (frame_span(history, &spark.frames), spark.foreground)),
        );
        for panel in [&mut panel, &mut below] {
            if index < frames {
                panel.draw_vertical("current frame", f64::from(number(index)), 0.6, true);
            }
        }
        panels.extend([(panel, 46.0), (below, 6.0)]);
    }
    figure.stack(0, 1, panels);
    figure
}

/// Draws the bands of the background components, one shape per rank.
fn bands(panel: &mut Panel, history: &PixelHistory, sparks: &[SparklineColumn], colour: crate::regions::Rgb) {
    let most = sparks.iter().map(|spark| spark.bands.len()).max().unwrap_or(0);
    for rank in 0..most {
        let rects = sparks.iter().filter_map(|spark| {
            let (&(low, high), [from, to]) = (spark.bands.get(rank)?, frame_span(history, &spark.frames));
            Some([from, f64::from(low), to, f64::from(high)])
        });
        let strength = STRENGTHS[rank.min(1)];
        panel.draw(format!("band of rank {}", rank + 1), MarkShape::Rects(rects.collect()), colour, strength);
    }
}
