//! Where a pixel's values lie in the space of its channels, with the reach of each component.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use eframe::egui;
use eframe::egui::accesskit::Role;
use eframe::egui::{Color32, Rangef, Ui, Visuals, WidgetInfo};
use egui_plot::{
    AxisHints, GridInput, GridMark, HoverPosition, Line, LineStyle, MarkerShape, Plot, PlotPoint, PlotPoints,
    Points,
};

use super::Chosen;
use super::chart;
use super::style::{self, small};
use crate::mixture::PixelHistory;
use crate::mixture::verdict::number;

/// What a point's colour says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum By {
    #[default]
    Component,
    Verdict,
    Time,
}

/// Steps of age in which points are coloured by time.
const AGES: u8 = 6;

/// Which plane and which frames are shown.
pub(super) struct Scatter {
    plane: (usize, usize),
    /// The last so many frames up to the one in view, 0 for all of the history.
    last: usize,
    by: By,
    cache: Option<Cache>,
}

impl Default for Scatter {
    fn default() -> Self {
        Self { plane: (0, 1), last: 500, by: By::Component, cache: None }
    }
}

#[derive(Clone, PartialEq)]
struct Choice {
    plane: (usize, usize),
    frames: Range<usize>,
    by: By,
}

struct Cache {
    history: Arc<PixelHistory>,
    choice: Choice,
    groups: Vec<Group>,
}

/// Points of one look.
struct Group {
    kind: Kind,
    /// 0..=2: how many frames share the place, on a logarithmic scale.
    density: u8,
    points: Vec<PlotPoint>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Component { slot: u8, foreground: bool },
    Verdict { foreground: bool },
    Age(u8),
}

impl Scatter {
    pub(super) fn ui(&mut self, ui: &mut Ui, chosen: &Chosen<'_>) {
        let gray = chosen.channels().len() == 1;
        ui.horizontal(|ui| {
            if gray {
                ui.label(small("luma against the next frame's luma"));
            } else {
                for (plane, name) in [((0, 1), "R–G"), ((1, 2), "G–B"), ((0, 2), "R–B")] {
                    ui.selectable_value(&mut self.plane, plane, name);
                }
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.label(style::aside(ui, "frames"));
            for (last, name) in [(100, "last 100"), (500, "last 500"), (0, "all")] {
                ui.selectable_value(&mut self.last, last, small(name));
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.label(style::aside(ui, "colour"));
            for (by, name) in [(By::Component, "component"), (By::Verdict, "verdict"), (By::Time, "time")] {
                ui.selectable_value(&mut self.by, by, small(name));
            }
        });
        self.plot(ui, chosen, gray);
        ui.label(style::aside(ui, &self.caption(chosen, gray)));
        ui.add_space(8.0);
    }

    fn frames(&self, chosen: &Chosen<'_>) -> Range<usize> {
        let end = chosen.index + 1;
        if self.last == 0 { 0..chosen.history.states.len() } else { end.saturating_sub(self.last)..end }
    }

    fn caption(&self, chosen: &Chosen<'_>, gray: bool) -> String {
        let lambda = number(chosen.history.parameters.lambda);
        let reach = if gray { "Squares" } else { "Circles" };
        let colours = match self.by {
            By::Component => "filled dots are background, rings foreground",
            By::Verdict => "green is background, orange foreground",
            By::Time => "darker dots are later",
        };
        let colours = if self.by == By::Time && gray { "stronger dots are later" } else { colours };
        format!(
            "{reach} reach {lambda}σ around each component's mean, solid for background, dashed for foreground; {colours}; the cross is the value in view."
        )
    }

    fn plot(&mut self, ui: &mut Ui, chosen: &Chosen<'_>, gray: bool) {
        let (x, y) = if gray { (0, 0) } else { self.plane };
        let choice = Choice { plane: (x, y), frames: self.frames(chosen), by: self.by };
        let fits = self
            .cache
            .as_ref()
            .is_some_and(|cache| Arc::ptr_eq(&cache.history, chosen.history) && cache.choice == choice);
        if !fits {
            let groups = groups(chosen, &choice, gray);
            self.cache = Some(Cache { history: Arc::clone(chosen.history), choice, groups });
        }
        let groups = self.cache.as_ref().map_or(&[][..], |cache| &cache.groups);

        let visuals = ui.visuals().clone();
        let state = chosen.state;
        let lambda = f64::from(chosen.history.parameters.lambda);
        let slots = chosen.slots[chosen.index];
        let names = if gray { ("luma", "next") } else { (chosen.channels()[x], chosen.channels()[y]) };
        let side = (ui.available_width() - 4.0).min(440.0);
        let next = chosen.history.states.get(chosen.index + 1).map_or(state.value[0], |next| next.value[0]);
        let cross =
            if gray { [state.value[0], next] } else { [state.value[x], state.value[y]] }.map(f64::from);

        // A plane is looked at with its own pan and zoom.
        let response = Plot::new(("scatter", x, y, gray))
            .width(side)
            .height(side)
            .data_aspect(1.0)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .show_crosshair(false)
            .show_background(false)
            .x_grid_spacer(|input| marks(&input))
            .y_grid_spacer(|input| marks(&input))
            .grid_color(style::faint(&visuals).color)
            .grid_fade(0.0)
            .custom_x_axes(vec![axis(AxisHints::new_x(), names.0, &visuals)])
            .custom_y_axes(vec![axis(AxisHints::new_y(), names.1, &visuals)])
            .label_formatter(move |at| {
                let (HoverPosition::NearDataPoint { position: at, .. }
                | HoverPosition::Elsewhere { position: at }) = at;
                Some(format!("{} {:.0}\n{} {:.0}", names.0, at.x, names.1, at.y))
            })
            .show(ui, |plot| {
                for group in groups {
                    // Rings have little ink, and foreground is rare and must be found.
                    let hollow = matches!(group.kind, Kind::Component { foreground: true, .. });
                    let strength =
                        if hollow { 1.0 } else { [0.45, 0.65, 0.9][usize::from(group.density.min(2))] };
                    let colour = colour(&visuals, group.kind).gamma_multiply(strength);
                    plot.points(
                        Points::new("", PlotPoints::Borrowed(&group.points))
                            .color(colour)
                            .filled(!hollow)
                            .radius(if hollow { 2.4 } else { 1.9 })
                            .allow_hover(false),
                    );
                }
                let background = usize::from(state.outcome.background_count);
                for (rank, component) in
                    state.pixel.components().iter().enumerate().filter(|(_, c)| c.is_used())
                {
                    let (mx, my) = (f64::from(component.mean[x]), f64::from(component.mean[y]));
                    let reach = lambda * f64::from(component.sigma());
                    let outline: Vec<[f64; 2]> = if gray {
                        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
                            .map(|(dx, dy)| [mx + dx * reach, my + dy * reach])
                            .to_vec()
                    } else {
                        (0..=72)
                            .map(|step| f64::from(step) / 72.0 * std::f64::consts::TAU)
                            .map(|angle| [mx + reach * angle.cos(), my + reach * angle.sin()])
                            .collect()
                    };
                    let colour = style::component(&visuals, slots[rank]);
                    let dashed = LineStyle::Dashed { length: 6.0 };
                    let style = if rank < background { LineStyle::Solid } else { dashed };
                    plot.line(
                        Line::new("", outline).color(colour).width(1.5).style(style).allow_hover(false),
                    );
                    let name = egui::RichText::new((rank + 1).to_string()).size(12.0).strong();
                    let top = PlotPoint::new(mx, my + reach);
                    plot.text(
                        egui_plot::Text::new("", top, name)
                            .color(colour)
                            .anchor(egui::Align2::CENTER_BOTTOM)
                            .allow_hover(false),
                    );
                }
                plot.points(
                    Points::new("", cross)
                        .shape(MarkerShape::Cross)
                        .color(style::ink(&visuals))
                        .radius(6.0)
                        .allow_hover(false),
                );
            });
        response.response.widget_info(|| {
            let count: usize = groups.iter().map(|group| group.points.len()).sum();
            WidgetInfo::labeled(
                Role::Image,
                true,
                format!("Scatter of {} against {}, {count} places", names.1, names.0),
            )
        });
    }
}

fn colour(visuals: &Visuals, kind: Kind) -> Color32 {
    match kind {
        Kind::Component { slot, .. } => style::component(visuals, slot),
        Kind::Verdict { foreground } => style::verdict_colour(visuals, foreground),
        Kind::Age(age) => {
            let share = f32::from(age + 1) / f32::from(AGES);
            visuals.panel_fill.lerp_to_gamma(visuals.strong_text_color(), 0.15 + 0.85 * share)
        }
    }
}

fn axis<'a>(hints: AxisHints<'a>, name: &str, visuals: &Visuals) -> AxisHints<'a> {
    hints
        .label(small(name))
        .label_spacing(Rangef::new(18.0, 19.0))
        .tick_label_font(style::tick_font())
        .tick_label_color(style::muted(visuals))
}

/// Grid lines of one kind, as many as leave room for their numbers.
fn marks(input: &GridInput) -> Vec<GridMark> {
    let (min, max) = input.bounds;
    let values = chart::ticks(min, max, 6);
    let step_size = values.get(1).map_or(max - min, |second| second - values[0]);
    values.into_iter().map(|value| GridMark { value, step_size }).collect()
}

/// The points of `choice`, equal ones of a kind drawn once: values are whole numbers, so even a
/// hundred thousand frames come to few places.
fn groups(chosen: &Chosen<'_>, choice: &Choice, gray: bool) -> Vec<Group> {
    let states = &chosen.history.states;
    let mut counts: BTreeMap<(Kind, [u32; 2]), u32> = BTreeMap::new();
    for index in choice.frames.clone() {
        let Some(state) = states.get(index) else { break };
        let place = if gray {
            let Some(next) = states.get(index + 1) else { break };
            [state.value[0], next.value[0]]
        } else {
            [state.value[choice.plane.0], state.value[choice.plane.1]]
        };
        let foreground = state.outcome.foreground;
        let kind = match choice.by {
            By::Component => {
                let rank = usize::from(state.outcome.rank).saturating_sub(1);
                Kind::Component { slot: chosen.slots[index][rank], foreground }
            }
            By::Verdict => Kind::Verdict { foreground },
            By::Time => {
                let age = (index - choice.frames.start) * usize::from(AGES) / choice.frames.len().max(1);
                Kind::Age(age as u8)
            }
        };
        *counts.entry((kind, place.map(|value| value as u32))).or_default() += 1;
    }
    let mut groups: BTreeMap<(Kind, u8), Vec<PlotPoint>> = BTreeMap::new();
    for ((kind, [x, y]), count) in counts {
        let density = match count {
            1 => 0,
            2..=5 => 1,
            _ => 2,
        };
        groups.entry((kind, density)).or_default().push(PlotPoint::new(x, y));
    }
    groups.into_iter().map(|((kind, density), points)| Group { kind, density, points }).collect()
}
