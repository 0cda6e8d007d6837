//! A tuning map as a figure.

use super::{Axis, Figure, INK, Key, NARROW, Panel, Shape, Sign, parameters, pixel_name};
use crate::mixture::PixelHistory;
use crate::mixture::tuning::{Axis as Side, Map};
use crate::palette::verdict_colour;

/// How strongly background and foreground are drawn.
const STRENGTHS: [f64; 2] = [0.34, 0.8];

/// The figure of the map about `history` at the frame in view.
pub fn figure(history: &PixelHistory, map: &Map, index: usize) -> Figure {
    let frame = history.states.get(index).map_or(0, |state| state.number);
    let colour = |foreground| verdict_colour(foreground, false);
    let legend = vec![
        Key { sign: Sign::Plate(STRENGTHS[1]), colour: colour(true), name: "foreground".to_owned() },
        Key { sign: Sign::Plate(STRENGTHS[0]), colour: colour(false), name: "background".to_owned() },
        Key { sign: Sign::Cross, colour: INK, name: "present settings".to_owned() },
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
                    let ((left, right), (bottom, top)) = (edges(across, column), edges(up, row));
                    cells.push([left, bottom, right, top]);
                }
            }
        }
        panel.draw(name, Shape::Rects(cells), colour(foreground), STRENGTHS[usize::from(foreground)]);
    }
    let here = [across, up].map(|side| f64::from(side.knob.get(&history.parameters)));
    panel.draw(
        "present settings",
        Shape::Dots { places: vec![here], radius: 5.0, sign: Sign::Cross },
        INK,
        1.0,
    );
    figure.stack(0, 1, vec![(panel, 160.0)]);
    figure
}

fn axis(side: &Side) -> Axis {
    let name = format!("{} ({})", side.knob.symbol(), side.knob.name());
    let ends = (f64::from(side.value_at(0.0)), f64::from(side.value_at(1.0)));
    if side.knob.is_logarithmic() { Axis::logarithmic(name, ends, 1) } else { Axis::new(name, ends, 6) }
}

/// From where to where a cell goes.
fn edges(side: &Side, cell: usize) -> (f64, f64) {
    let count = side.values.len().max(1) as f32;
    let at = |cell: usize| f64::from(side.value_at(cell as f32 / count));
    (at(cell), at(cell + 1))
}
