//! Figures of the mixture at one frame: densities with the value, and weights with T and B.

use super::{
    Anchor, Axis, Figure, GRAY, INK, Key, MarkShape, NARROW, Panel, Sign, WIDE, component, number_at,
    parameters, pixel_name,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_states::{ComponentState, component_states, t_at};
use crate::explain::pixel::verdict::number;
use crate::mixture::MAX_K;

/// The mixture of a frame before or after its update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpdateSide {
    /// The mixture that the value was compared with.
    Before,
    /// The mixture updated by the value, which determines B.
    #[default]
    After,
    /// Both mixtures, side by side.
    Both,
}

impl UpdateSide {
    /// For each displayed mixture, whether it is the one before the update.
    pub const fn sides(self) -> &'static [bool] {
        match self {
            Self::Before => &[true],
            Self::After => &[false],
            Self::Both => &[true, false],
        }
    }
}

const STEPS: usize = 510;

/// Draws w·η of each component in each channel, with the value, and below μ ± λσ.
pub fn densities(history: &PixelHistory, slots: &[[u8; MAX_K]], index: usize, moment: UpdateSide) -> Figure {
    let sides: Vec<_> = moment
        .sides()
        .iter()
        .map(|&before| (before, component_states(history, slots, index, before).0))
        .collect();
    let peaks =
        sides.iter().flat_map(|(_, component_states)| component_states.iter().map(ComponentState::peak));
    let top = peaks.fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let lambda = number(history.parameters.lambda);
    let mut legend =
        legend(&sides.iter().map(|(_, component_states)| &component_states[..]).collect::<Vec<_>>());
    legend.push(Key::new(Sign::Line, INK, "value X"));
    legend.push(Key::new(Sign::Patch(0.5), GRAY, format!("bars: μ ± {lambda}σ")));
    let mut figure = start(history, index, moment, legend);
    for (column, (before, component_states)) in sides.iter().enumerate() {
        let mut panels = Vec::new();
        for (channel, name) in history.parameters.channel_names().iter().enumerate() {
            let mut y = Axis::new(format!("w·η ({name})"), (0.0, top), 3);
            // Space for the bars below the curves.
            let lane = top * 0.07;
            y.ends.0 = -lane * (component_states.len() as f64 + 0.4);
            let levels = [0, 64, 128, 192, 255].map(|level| (f64::from(level), level.to_string()));
            let x = Axis::new("X (levels)", (0.0, 255.0), 4).with_ticks(levels.to_vec());
            let mut panel = Panel::new(x, y);
            if channel == 0 {
                panel.caption = caption(moment, *before);
            }
            for (at, component_state) in component_states.iter().enumerate() {
                curve(&mut panel, component_state, channel);
                let reach = f64::from(component_state.component.reach(history.parameters.lambda));
                let mean = f64::from(component_state.component.mean[channel]);
                let (low, high) = (-lane * (at as f64 + 1.2), -lane * (at as f64 + 0.4));
                let colour = component(component_state.slot);
                let strength = if component_state.background { 0.55 } else { 0.25 };
                let bar = MarkShape::Rects(vec![[mean - reach, low, mean + reach, high]]);
                panel.draw(format!("band of rank {}", component_state.rank), bar, colour, strength);
                let middle =
                    MarkShape::Line { points: vec![[mean, low], [mean, high]], width: 1.2, dashed: false };
                panel.draw(format!("mean of rank {}", component_state.rank), middle, colour, 1.0);
            }
            let value = history.states.get(index).map_or(0.0, |state| state.value[channel]);
            panel.draw_vertical("value", value.into(), 1.0, false);
            panels.push((panel, 84.0));
        }
        figure.stack(column, sides.len(), panels);
    }
    figure
}

/// Draws the weights as cumulative bars in rank order, with T and the limit of B.
pub fn weights(history: &PixelHistory, slots: &[[u8; MAX_K]], index: usize, moment: UpdateSide) -> Figure {
    const BAR: f64 = 15.0;
    let sides: Vec<_> = moment
        .sides()
        .iter()
        .map(|&before| (before, component_states(history, slots, index, before)))
        .collect();
    let mut legend =
        legend(&sides.iter().map(|(_, (component_states, _))| &component_states[..]).collect::<Vec<_>>());
    let t = number(t_at(history, index, moment == UpdateSide::Before));
    legend.push(Key::new(Sign::Dashed, INK, format!("T = {t}")));
    let mut figure = start(history, index, moment, legend);
    let most =
        sides.iter().map(|(_, (component_states, _))| component_states.len()).max().unwrap_or(0).max(1);
    for (column, (before, (component_states, count))) in sides.iter().enumerate() {
        let ranks = component_states.iter().map(|component_state| {
            (most as f64 - component_state.rank as f64 + 0.5, component_state.rank.to_string())
        });
        let y = Axis::new("rank", (0.0, most as f64), 1).with_ticks(ranks.collect());
        let x = Axis::new("w, cumulative in rank order", (0.0, 1.0), 4);
        let mut panel = Panel { grid: false, caption: caption(moment, *before), ..Panel::new(x, y) };
        let mut sum = 0.0;
        for component_state in component_states {
            let (from, top) = (sum, (most + 1 - component_state.rank) as f64);
            sum += f64::from(component_state.component.weight);
            let bar = MarkShape::Rects(vec![[from, top - 0.88, sum, top - 0.12]]);
            let strength = if component_state.background { 0.75 } else { 0.28 };
            panel.draw(
                format!("weight of rank {}", component_state.rank),
                bar,
                component(component_state.slot),
                strength,
            );
            // The text is on the side of the bar with more space.
            let (at, anchor) =
                if from > 1.0 - sum { (from - 0.015, Anchor::End) } else { (sum + 0.015, Anchor::Start) };
            let text = format!("{:.3}", component_state.component.weight);
            panel.draw("", MarkShape::Text { at: [at, top - 0.66], text, anchor }, INK, 1.0);
        }
        panel.draw_vertical("T", t_at(history, index, *before).into(), 1.0, true);
        let cut = (most - (*count).min(most)) as f64;
        panel.draw_horizontal("B", cut, 0.6, false);
        let text = format!("B = {count}");
        panel.draw("", MarkShape::Text { at: [0.99, cut + 0.16], text, anchor: Anchor::End }, GRAY, 1.0);
        figure.stack(column, sides.len(), vec![(panel, BAR * most as f64)]);
    }
    figure
}

fn start(history: &PixelHistory, index: usize, moment: UpdateSide, legend: Vec<Key>) -> Figure {
    let number = number_at(history, index);
    let when = match moment {
        UpdateSide::Before => " before the update",
        UpdateSide::After => " after the update",
        UpdateSide::Both => "",
    };
    let title = format!("{}, frame {number}{when}", pixel_name(history));
    Figure::new(if moment == UpdateSide::Both { WIDE } else { NARROW }, title, parameters(history), legend)
}

fn caption(moment: UpdateSide, before: bool) -> String {
    match (moment, before) {
        (UpdateSide::Both, true) => "before the update".to_owned(),
        (UpdateSide::Both, false) => "after the update".to_owned(),
        _ => String::new(),
    }
}

/// The legend: the components of the last mixture by rank, each with its rank in the previous one if that differs.
fn legend(sides: &[&[ComponentState]]) -> Vec<Key> {
    let mut keys: Vec<Key> = Vec::new();
    let Some((last, before)) = sides.split_last() else { return keys };
    for component_state in *last {
        // A new component has the colour, but not the rank, of the one that it replaced.
        let same = |other: &&ComponentState| other.slot == component_state.slot && !component_state.new;
        let ranked = before.iter().flat_map(|side| side.iter()).find(same).map(|other| other.rank);
        let rank = match ranked {
            Some(ranked) if ranked != component_state.rank => {
                format!("{} (was {ranked})", component_state.rank)
            }
            None if component_state.new && !before.is_empty() => format!("{} (new)", component_state.rank),
            _ => component_state.rank.to_string(),
        };
        let name = if keys.is_empty() { format!("component of rank {rank}") } else { rank };
        let sign = if component_state.background { Sign::Band } else { Sign::Dashed };
        keys.push(Key::new(sign, component(component_state.slot), name));
    }
    keys.push(Key::new(Sign::Dashed, GRAY, "foreground component"));
    keys
}

/// The curve of a component where it is not 0: filled for background, dashed for foreground.
fn curve(panel: &mut Panel, component_state: &ComponentState, channel: usize) {
    let least = panel.y.ends.1 * 1e-3;
    let points: Vec<[f64; 2]> = (0..=STEPS)
        .map(|step| step as f64 * 255.0 / STEPS as f64)
        .map(|x| [x, component_state.marginal(channel, x)])
        .collect();
    let colour = component(component_state.slot);
    for run in points.chunk_by(|a, b| (a[1] > least) == (b[1] > least)).filter(|run| run[0][1] > least) {
        let ends = [[run[run.len() - 1][0], 0.0], [run[0][0], 0.0]];
        let strength = if component_state.background { 0.38 } else { 0.10 };
        panel.draw("", MarkShape::Area([run, &ends].concat()), colour, strength);
        let line = MarkShape::Line { points: run.to_vec(), width: 1.0, dashed: !component_state.background };
        panel.draw(format!("density of rank {}", component_state.rank), line, colour, 1.0);
    }
}
