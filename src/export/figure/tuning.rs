//! A figure of a tuning map: the verdict on one pixel, or the accuracy in a region.

use super::{Axis, Figure, INK, Key, MarkShape, NARROW, Panel, Sign, number_at, parameters, pixel_name};
use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::{SettingAxis as Side, VerdictMap};
use crate::palette::{ramp, verdict_colour};
use crate::truth::decisions::{Decisions, Measure};

/// The opacity of background and of foreground.
const STRENGTHS: [f64; 2] = [0.34, 0.8];
/// Number of colour steps for the values of a measure.
const STEPS: usize = 17;

/// The figure of the map of `history`'s pixel at the frame in view.
pub fn figure(history: &PixelHistory, map: &VerdictMap, index: usize) -> Figure {
    let frame = number_at(history, index);
    let colour = |foreground| verdict_colour(foreground, false);
    let legend = vec![
        Key::new(Sign::Patch(STRENGTHS[1]), colour(true), "foreground"),
        Key::new(Sign::Patch(STRENGTHS[0]), colour(false), "background"),
        present(),
    ];
    let title = format!("{}, frame {frame}, under other settings", pixel_name(history));
    let mut figure = Figure::new(NARROW, title, parameters(history), legend);
    let [across, up] = &map.axes;
    let mut panel = Panel { grid: false, ..Panel::new(axis(across), axis(up)) };
    for (foreground, name) in [(false, "background"), (true, "foreground")] {
        let mut cells = Vec::new();
        for row in 0..up.values.len() {
            for column in 0..across.values.len() {
                if map.is_foreground(column, row) == foreground {
                    cells.push(cell(&map.axes, column, row));
                }
            }
        }
        panel.draw(name, MarkShape::Rects(cells), colour(foreground), STRENGTHS[usize::from(foreground)]);
    }
    draw_present(&mut panel, &map.axes, history);
    figure.stack(0, 1, vec![(panel, 160.0)]);
    figure
}

/// The figure of a measure of the decisions in each cell of a grid around `history`; `about` describes the pixels.
pub fn of_decisions(
    history: &PixelHistory,
    about: &str,
    (axes, cells): (&[Side; 2], &[Decisions]),
    measure: Measure,
) -> Figure {
    let values: Vec<f64> = cells.iter().map(|&decisions| measure.of(decisions)).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let step = |value: f64| {
        let share = (value - low) / (high - low).max(1e-9);
        (share * (STEPS - 1) as f64).round() as usize
    };
    let colour = |step: usize| ramp(step as f32 / (STEPS - 1) as f32);
    let mut legend: Vec<Key> = [0, STEPS / 2, STEPS - 1]
        .map(|step| {
            let value = low + (high - low) * step as f64 / (STEPS - 1) as f64;
            Key::new(Sign::Patch(1.0), colour(step), format!("{value:.3}"))
        })
        .into();
    legend.push(present());
    let title = format!("{} around {}, {about}, under other settings", measure.name(), pixel_name(history));
    let mut figure = Figure::new(NARROW, title, parameters(history), legend);
    let [across, up] = axes;
    let mut panel = Panel { grid: false, ..Panel::new(axis(across), axis(up)) };
    for wanted in 0..STEPS {
        let cells: Vec<_> = values
            .iter()
            .enumerate()
            .filter(|(_, value)| step(**value) == wanted)
            .map(|(index, _)| {
                let (row, column) = (index / across.values.len().max(1), index % across.values.len().max(1));
                cell(axes, column, row)
            })
            .collect();
        panel.draw(measure.name(), MarkShape::Rects(cells), colour(wanted), 1.0);
    }
    draw_present(&mut panel, axes, history);
    figure.stack(0, 1, vec![(panel, 160.0)]);
    figure
}

fn present() -> Key {
    Key::new(Sign::Cross, INK, "current settings")
}

fn draw_present(panel: &mut Panel, axes: &[Side; 2], history: &PixelHistory) {
    let here = axes.each_ref().map(|side| f64::from(side.setting.get(&history.parameters)));
    panel.draw_cross("current settings", here, 5.0);
}

fn cell([across, up]: &[Side; 2], column: usize, row: usize) -> [f64; 4] {
    let ((left, right), (bottom, top)) = (edges(across, column), edges(up, row));
    [left, bottom, right, top]
}

fn axis(side: &Side) -> Axis {
    let name = format!("{} ({})", side.setting.symbol(), side.setting.name());
    let ends = (f64::from(side.value_at(0.0)), f64::from(side.value_at(1.0)));
    if side.setting.is_logarithmic() { Axis::logarithmic(name, ends, 1) } else { Axis::new(name, ends, 6) }
}

/// The edges of a cell.
fn edges(side: &Side, cell: usize) -> (f64, f64) {
    let count = side.values.len().max(1) as f32;
    let at = |cell: usize| f64::from(side.value_at(cell as f32 / count));
    (at(cell), at(cell + 1))
}
