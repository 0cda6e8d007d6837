//! A figure of a pixel's values in a plane of its channels.

use super::{
    Anchor, Axis, Figure, GRAY, INK, Key, MarkShape, NARROW, Panel, Sign, component, parameters, pixel_name,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_states::{ComponentState, component_states};
use crate::explain::pixel::scatter_points::{
    AGES, PointGrouping, PointKind, ScatterPoint, ScatterSelection, ScatterSpace, coordinates_of,
    scatter_points,
};
use crate::explain::pixel::verdict::number;
use crate::mixture::MAX_K;
use crate::palette::verdict_colour;
use crate::regions::Rgb;

/// The figure of a plane: the points, the radius λσ of each component at the frame in view, and its value.
pub fn figure(
    history: &PixelHistory,
    slots: &[[u8; MAX_K]],
    choice: &ScatterSelection,
    index: usize,
) -> Figure {
    let (x, y) = match choice.space {
        ScatterSpace::Plane(x, y) => (x.min(2), y.min(2)),
        ScatterSpace::Cube | ScatterSpace::Next => (0, 0),
    };
    let gray = x == y;
    let mut places = scatter_points(history, slots, choice);
    let (component_states, _) = component_states(history, slots, index, false);
    let here = coordinates_of(history, index, choice.space);

    let mut range = ValueRange::default();
    for place in &places {
        range.take([place.at[0].into(), place.at[1].into()], 2.0);
    }
    for component_state in &component_states {
        let reach = f64::from(component_state.component.reach(history.parameters.lambda));
        range.take(
            [component_state.component.mean[x].into(), component_state.component.mean[y].into()],
            reach + 2.0,
        );
    }
    let [across, up] = range.square();
    let names = if gray {
        ["Y of a frame (levels)".to_owned(), "Y of the next frame (levels)".to_owned()]
    } else {
        [x, y].map(|channel| format!("{} (levels)", history.parameters.channel_names()[channel]))
    };
    let mut figure = Figure::new(
        NARROW,
        title(history, choice),
        parameters(history),
        legend(history, choice, &component_states, gray),
    );
    let [x_name, y_name] = names;
    let mut panel = Panel::new(Axis::new(x_name, across, 6), Axis::new(y_name, up, 6));
    for (name, run) in groups(&mut places) {
        let (colour, sign, opacity) = look(&run[0]);
        let places = run.iter().map(|place| [place.at[0].into(), place.at[1].into()]).collect();
        let radius = if sign == Sign::Ring { 1.5 } else { 1.2 };
        panel.draw(name, MarkShape::Dots { places, radius, sign }, colour, opacity);
    }
    for component_state in &component_states {
        let reach = f64::from(component_state.component.reach(history.parameters.lambda));
        let (mx, my) =
            (f64::from(component_state.component.mean[x]), f64::from(component_state.component.mean[y]));
        let points = outline([mx, my], reach, gray);
        let (colour, dashed) = (component(component_state.slot), !component_state.background);
        panel.draw(
            format!("reach of rank {}", component_state.rank),
            MarkShape::Line { points, width: 1.1, dashed },
            colour,
            1.0,
        );
        let (text, anchor) = (component_state.rank.to_string(), Anchor::Middle);
        let lift = (up.1 - up.0) * 0.012;
        panel.draw("", MarkShape::Text { at: [mx, my + reach + lift], text, anchor }, colour, 1.0);
    }
    if let Some(here) = here {
        panel.draw_cross("current value", [here[0].into(), here[1].into()], 4.0);
    }
    let side = figure.size[0] - super::LEFT - super::RIGHT;
    figure.stack(0, 1, vec![(panel, side)]);
    figure
}

/// `pixel (5, 4), frames 1–500`.
pub(super) fn title(history: &PixelHistory, choice: &ScatterSelection) -> String {
    let states = history.states.get(choice.frames.start..choice.frames.end.min(history.states.len()));
    let numbers = states.and_then(|states| Some((states.first()?.number, states.last()?.number)));
    let (from, to) = numbers.unwrap_or((0, 0));
    format!("{}, frames {from}–{to}", pixel_name(history))
}

/// Groups the points by appearance, in drawing order.
fn groups(places: &mut [ScatterPoint]) -> impl Iterator<Item = (String, &[ScatterPoint])> {
    places.sort_by_key(|place| (place.kind, density(place.count)));
    let runs = places.chunk_by(|a, b| a.kind == b.kind && density(a.count) == density(b.count));
    runs.map(|run| (kind_name(run[0].kind), run))
}

fn kind_name(kind: PointKind) -> String {
    let verdict = |foreground| if foreground { "foreground" } else { "background" };
    match kind {
        PointKind::Component { slot, foreground } => {
            format!("values of component {}, {}", slot + 1, verdict(foreground))
        }
        PointKind::Verdict { foreground } => format!("values, {}", verdict(foreground)),
        PointKind::Age(age) => format!("values of age {} of {AGES}", age + 1),
    }
}

/// The density class 0..=2 of a number of frames, on a logarithmic scale.
pub const fn density(count: u32) -> usize {
    match count {
        0 | 1 => 0,
        2..=5 => 1,
        _ => 2,
    }
}

/// Colour, sign and opacity of a point.
pub(super) fn look(place: &ScatterPoint) -> (Rgb, Sign, f64) {
    let strength = [0.5, 0.7, 0.95][density(place.count)];
    match place.kind {
        PointKind::Component { slot, foreground: true } => (component(slot), Sign::Ring, 1.0),
        PointKind::Component { slot, .. } => (component(slot), Sign::Dot, strength),
        PointKind::Verdict { foreground } => (verdict_colour(foreground, false), Sign::Dot, strength),
        PointKind::Age(age) => (age_colour(age), Sign::Dot, strength.max(0.8)),
    }
}

/// The colour of an age, from pale to dark.
fn age_colour(age: u8) -> Rgb {
    let share = 1.0 - f64::from(age + 1) / f64::from(AGES);
    INK.map(|ink| (f64::from(ink) + (215.0 - f64::from(ink)) * share) as u8)
}

/// The legend of a scatter plot.
pub(super) fn legend(
    history: &PixelHistory,
    choice: &ScatterSelection,
    component_states: &[ComponentState],
    gray: bool,
) -> Vec<Key> {
    let mut keys = Vec::new();
    match choice.by {
        PointGrouping::Component => {
            for component_state in component_states {
                let name = if component_state.rank == 1 {
                    "component of rank 1".to_owned()
                } else {
                    component_state.rank.to_string()
                };
                keys.push(Key::new(Sign::Dot, component(component_state.slot), name));
            }
            keys.push(Key::new(Sign::Ring, GRAY, "foreground"));
        }
        PointGrouping::Verdict => {
            keys.push(Key::new(Sign::Dot, verdict_colour(false, false), "background"));
            keys.push(Key::new(Sign::Dot, verdict_colour(true, false), "foreground"));
        }
        PointGrouping::Time => {
            keys.push(Key::new(Sign::Dot, age_colour(0), "first frames"));
            keys.push(Key::new(Sign::Dot, age_colour(AGES - 1), "last frames"));
        }
    }
    let form = if gray { "squares" } else { "circles" };
    keys.push(Key::new(Sign::Line, GRAY, format!("{form}: λσ, λ = {}", number(history.parameters.lambda))));
    keys.push(Key::new(Sign::Cross, INK, "current value"));
    keys
}

/// The outline of the values within λσ: a circle, or a square where a value is plotted against the next.
pub fn outline(at: [f64; 2], reach: f64, gray: bool) -> Vec<[f64; 2]> {
    if gray { square(at, reach) } else { circle(at, reach) }
}

fn circle([x, y]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let angles = (0..=72).map(|step| f64::from(step) / 72.0 * std::f64::consts::TAU);
    angles.map(|angle| [x + radius * angle.cos(), y + radius * angle.sin()]).collect()
}

fn square([x, y]: [f64; 2], reach: f64) -> Vec<[f64; 2]> {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
        .map(|(dx, dy)| [x + dx * reach, y + dy * reach])
        .to_vec()
}

/// The range of displayed values.
struct ValueRange {
    low: [f64; 2],
    high: [f64; 2],
}

impl Default for ValueRange {
    fn default() -> Self {
        Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] }
    }
}

impl ValueRange {
    fn take(&mut self, at: [f64; 2], reach: f64) {
        for (side, value) in at.into_iter().enumerate() {
            self.low[side] = self.low[side].min(value - reach);
            self.high[side] = self.high[side].max(value + reach);
        }
    }

    /// Both axes with the same length, so that circles remain circles.
    fn square(&self) -> [(f64, f64); 2] {
        if self.low[0] > self.high[0] {
            return [(0.0, 255.0); 2];
        }
        let span = (self.high[0] - self.low[0]).max(self.high[1] - self.low[1]).max(16.0);
        [0, 1].map(|side| {
            let middle = f64::midpoint(self.low[side], self.high[side]);
            (middle - span / 2.0, middle + span / 2.0)
        })
    }
}
