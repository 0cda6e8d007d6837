//! A figure of a pixel's history: values, weights, B, ρ, changes and verdict over the frames.

use std::ops::Range;

use super::{
    Axis, Figure, GRAY, INK, Key, MarkShape, Panel, Sign, WIDE, component, frame_span, frames_axis,
    number_at, parameters, pixel_name, verdicts,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_states::component_states;
use crate::explain::pixel::downsampled_history::{HistoryColumn, downsample, rate_range, value_range};
use crate::explain::pixel::verdict::number;
use crate::mixture::MAX_K;

/// Largest number of columns; more would exceed the resolution of a printed page.
pub const COLUMNS: usize = 1500;

/// The part of a history in the figure.
#[derive(Clone, Debug, PartialEq)]
pub struct HistorySelection {
    /// Positions of the frames.
    pub frames: Range<usize>,
    /// The position of the frame in view.
    pub index: usize,
    /// Whether the value axes fit the values instead of covering 0..=255.
    pub fit: bool,
}

/// The figure. Up to [`COLUMNS`] frames are drawn individually; more are combined to the range of several frames.
pub fn figure(history: &PixelHistory, slots: &[[u8; MAX_K]], choice: &HistorySelection) -> Figure {
    let bins = downsample(history, slots, choice.frames.clone(), COLUMNS);
    let drawing = Drawing { history, bins: &bins };
    let ends = drawing.ends();
    let title = format!("{}, frames {}–{}", pixel_name(history), number_at(history, choice.frames.start), {
        number_at(history, choice.frames.end.saturating_sub(1))
    });
    let mut figure =
        Figure::new(WIDE, title, parameters(history), legend(history, slots, &bins, choice.index));
    let x = || frames_axis(ends);
    let fitted = choice.fit.then(|| value_range(&bins, history.parameters.channels()));
    let (low, high) = fitted.unwrap_or((0.0, 255.0));
    let mut panels = Vec::new();
    for (channel, name) in history.parameters.channel_names().iter().enumerate() {
        let mut y = Axis::new(format!("{name} (levels)"), (low, high), 4);
        if fitted.is_none() {
            y = y.with_ticks([0, 128, 255].map(|tick| (f64::from(tick), tick.to_string())).to_vec());
        }
        let mut panel = Panel::new(x(), y);
        drawing.bands(&mut panel, channel);
        drawing.values(&mut panel, channel);
        panels.push((panel, 62.0));
    }

    let mut panel = Panel::new(x(), Axis::new("w", (0.0, 1.0), 2));
    drawing.weights(&mut panel);
    panel.draw_horizontal("T", history.parameters.t.into(), 0.9, true);
    panels.push((panel, 56.0));

    let most = history.parameters.k as f64;
    let ends = [0, history.parameters.k].map(|count| (count as f64, count.to_string())).to_vec();
    let mut panel = Panel::new(x(), Axis::new("B", (0.0, most), 1).with_ticks(ends));
    drawing.background_counts(&mut panel);
    panels.push((panel, 28.0));

    let (low, high) = rate_range(&bins);
    let decades = (high / low).log10().round() as i32;
    let mut panel = Panel::new(x(), Axis::logarithmic("ρ", (low, high), (decades + 2) / 3));
    drawing.rates(&mut panel);
    panels.push((panel, 34.0));

    let lanes =
        [(2.5, "created"), (1.5, "replaced"), (0.5, "moved up")].map(|(at, name)| (at, name.to_owned()));
    let changes = Axis::new("", (0.0, 3.0), 3).with_ticks(lanes.to_vec());
    let mut panel = Panel { grid: false, ..Panel::new(x(), changes) };
    drawing.changes(&mut panel);
    panels.push((panel, 27.0));

    let verdict = Axis::new("", (0.0, 1.0), 1).with_ticks(vec![(0.5, "verdict".to_owned())]);
    let mut panel = Panel { grid: false, ..Panel::new(x(), verdict) };
    drawing.verdicts(&mut panel);
    panels.push((panel, 10.0));

    if choice.frames.contains(&choice.index) {
        let here = f64::from(number_at(history, choice.index));
        for (panel, _) in &mut panels {
            panel.draw_vertical("current frame", here, 0.6, true);
        }
    }
    figure.stack(0, 1, panels);
    figure
}

fn legend(history: &PixelHistory, slots: &[[u8; MAX_K]], bins: &[HistoryColumn], index: usize) -> Vec<Key> {
    let lambda = number(history.parameters.lambda);
    let mut keys = vec![Key::new(Sign::Line, INK, "value X")];
    // A component keeps its colour through changes of rank.
    for component_state in component_states(history, slots, index, false).0 {
        let name = if component_state.rank == 1 {
            format!("μ ± {lambda}σ and w of rank 1 at frame {}", number_at(history, index))
        } else {
            component_state.rank.to_string()
        };
        keys.push(Key::new(Sign::Band, component(component_state.slot), name));
    }
    keys.push(Key::new(Sign::Dashed, GRAY, "foreground component (pale)"));
    keys.extend(verdicts::legend(bins.iter().map(HistoryColumn::foreground_share)));
    keys.push(Key::new(Sign::Dashed, INK, "T; current frame"));
    keys
}

struct Drawing<'a> {
    history: &'a PixelHistory,
    bins: &'a [HistoryColumn],
}

impl Drawing<'_> {
    fn edges(&self, bin: &HistoryColumn) -> [f64; 2] {
        frame_span(self.history, &bin.frames)
    }

    fn middle(&self, bin: &HistoryColumn) -> f64 {
        let [from, to] = self.edges(bin);
        f64::midpoint(from, to)
    }

    fn ends(&self) -> (f64, f64) {
        match (self.bins.first(), self.bins.last()) {
            (Some(first), Some(last)) => (self.edges(first)[0], self.edges(last)[1]),
            _ => (0.5, 1.5),
        }
    }

    /// Draws μ ± λσ of each component, interrupted where it is replaced, or changes between background and
    /// foreground.
    fn bands(&self, panel: &mut Panel, channel: usize) {
        let mut means = Vec::new();
        for slot in 0..MAX_K {
            let side = |bin: &HistoryColumn| bin.bands[slot].map(|band| band.background);
            for run in self.bins.chunk_by(|a, b| side(a) == side(b) && !b.made[slot]) {
                let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
                let Some(background) = side(first) else { continue };
                let (from, to) = (self.edges(first)[0], self.edges(last)[1]);
                let along =
                    |of: &dyn Fn(&crate::explain::pixel::downsampled_history::Band) -> f32| -> Vec<[f64; 2]> {
                        let middle = run.iter().filter_map(|bin| {
                            Some([self.middle(bin), f64::from(of(bin.bands[slot].as_ref()?))])
                        });
                        let middle: Vec<_> = middle.collect();
                        let ends = middle.first().zip(middle.last()).map(|(a, b)| ([from, a[1]], [to, b[1]]));
                        let Some((start, end)) = ends else { return middle };
                        [vec![start], middle, vec![end]].concat()
                    };
                let mut area = along(&|band| band.range[channel].1);
                area.extend(along(&|band| band.range[channel].0).into_iter().rev());
                let (colour, name) = (component(slot as u8), slot + 1);
                let strength = if background { 0.3 } else { 0.1 };
                panel.draw(format!("band of component {name}"), MarkShape::Area(area), colour, strength);
                let points = along(&|band| band.mean[channel]);
                let line = MarkShape::Line { points, width: 0.9, dashed: !background };
                means.push((format!("mean of component {name}"), line, colour));
            }
        }
        for (name, line, colour) in means {
            panel.draw(name, line, colour, 1.0);
        }
    }

    fn values(&self, panel: &mut Panel, channel: usize) {
        let mut points = Vec::with_capacity(2 * self.bins.len());
        for bin in self.bins {
            let (low, high) = bin.value[channel];
            points.push([self.middle(bin), f64::from(low)]);
            if high > low {
                points.push([self.middle(bin), f64::from(high)]);
            }
        }
        let name = format!("value {}", self.history.parameters.channel_names()[channel]);
        panel.draw(name, MarkShape::Line { points, width: 0.6, dashed: false }, INK, 1.0);
    }

    /// Draws the weights stacked in rank order.
    fn weights(&self, panel: &mut Panel) {
        for rank in 0..MAX_K {
            let here = |bin: &HistoryColumn| {
                bin.weights.get(rank).map(|&(slot, _)| (slot, rank < usize::from(bin.background_count)))
            };
            for run in self.bins.chunk_by(|a, b| here(a) == here(b)) {
                let Some((slot, background)) = run.first().and_then(here) else { continue };
                let sum = |bin: &HistoryColumn, ranks: usize| -> f64 {
                    bin.weights.iter().take(ranks).map(|&(_, weight)| f64::from(weight)).sum()
                };
                let steps = |ranks: usize| {
                    run.iter().flat_map(move |bin| {
                        let ([from, to], top) = (self.edges(bin), sum(bin, ranks));
                        [[from, top], [to, top]]
                    })
                };
                let mut area: Vec<_> = steps(rank + 1).collect();
                area.extend(steps(rank).collect::<Vec<_>>().into_iter().rev());
                let strength = if background { 0.75 } else { 0.28 };
                let name = format!("weight of rank {}", rank + 1);
                panel.draw(name, MarkShape::Area(area), component(slot), strength);
            }
        }
    }

    fn background_counts(&self, panel: &mut Panel) {
        let steps = self.bins.iter().flat_map(|bin| {
            let ([from, to], count) = (self.edges(bin), f64::from(bin.most_background));
            [[from, count], [to, count]]
        });
        panel.draw("B", MarkShape::Line { points: steps.collect(), width: 0.9, dashed: false }, INK, 1.0);
    }

    /// Draws ρ, interrupted where nothing matched.
    fn rates(&self, panel: &mut Panel) {
        for run in self.bins.chunk_by(|a, b| a.rho.is_some() == b.rho.is_some()) {
            let points: Vec<_> = run
                .iter()
                .filter_map(|bin| bin.rho.map(|rho| (bin, rho)))
                .flat_map(|(bin, (low, high))| {
                    let [from, to] = self.edges(bin);
                    [[from, f64::from(low)], [to, f64::from(high)]]
                })
                .collect();
            if !points.is_empty() {
                panel.draw("ρ", MarkShape::Line { points, width: 0.7, dashed: false }, INK, 1.0);
            }
        }
    }

    /// Draws a tick for each component that was created in a free slot, replaced another, or rose in rank.
    fn changes(&self, panel: &mut Panel) {
        for (lane, name) in ["created", "replaced", "moved up"].into_iter().enumerate() {
            let bottom = 2.0 - lane as f64;
            for bin in self.bins {
                let Some(slot) = bin.changes[lane] else { continue };
                let x = self.middle(bin);
                let points = vec![[x, bottom + 0.1], [x, bottom + 0.9]];
                panel.draw(name, MarkShape::Line { points, width: 0.8, dashed: false }, component(slot), 1.0);
            }
        }
    }

    fn verdicts(&self, panel: &mut Panel) {
        verdicts::draw(panel, self.bins.iter().map(|bin| (self.edges(bin), bin.foreground_share())));
    }
}
