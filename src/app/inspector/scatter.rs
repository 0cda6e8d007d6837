//! Scatter plot of a pixel's values in the space of its channels, with the match radius of each component.

use std::ops::Range;
use std::sync::Arc;

use eframe::egui;
use eframe::egui::accesskit::Role;
use eframe::egui::{DragValue, Rangef, Ui, Visuals, WidgetInfo};
use egui_plot::{
    AxisHints, GridInput, GridMark, HoverPosition, Line, LineStyle, MarkerShape, Plot, PlotPoint, PlotPoints,
    Points,
};

use super::action::InspectorAction;
use super::chart;
use super::chosen_pixel::ChosenPixel;
use super::cube::CubeView;
use super::menu;
use super::plot;
use super::style::{self, small};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_states::component_states;
use crate::explain::pixel::scatter_points::{
    PointGrouping, PointKind, ScatterPoint, ScatterSelection, ScatterSpace, coordinates_of, scatter_points,
};
use crate::explain::pixel::verdict::number;
use crate::export::figure::{cube, scatter};

/// The displayed space and frames.
pub(super) struct ScatterView {
    /// The space for pixels of three channels.
    space: ScatterSpace,
    /// The number of frames up to the frame in view; 0 for the whole history.
    last: usize,
    by: PointGrouping,
    cube: CubeView,
    cache: Option<CachedPoints>,
}

impl Default for ScatterView {
    fn default() -> Self {
        let (space, by) = (ScatterSpace::Plane(0, 1), PointGrouping::Component);
        Self { space, last: 500, by, cube: CubeView::default(), cache: None }
    }
}

/// Points are recomputed only for another history or selection.
struct CachedPoints {
    history: Arc<PixelHistory>,
    choice: ScatterSelection,
    places: Vec<ScatterPoint>,
    groups: Vec<PointGroup>,
}

/// Points of one appearance.
struct PointGroup {
    kind: PointKind,
    /// 0..=2: the number of frames at the same point, on a logarithmic scale.
    density: usize,
    points: Vec<PlotPoint>,
}

impl ScatterView {
    pub(super) fn ui(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>) -> Option<InspectorAction> {
        let gray = chosen.channels().len() == 1;
        let choice = self.choice(chosen);
        let look = self.cube.look;
        let plot = || match choice.space {
            ScatterSpace::Cube => {
                plot::Plot::Cube(chosen.slotted_history(), choice.clone(), chosen.index, look)
            }
            _ => plot::Plot::Scatter(chosen.slotted_history(), choice.clone(), chosen.index),
        };
        let asked = menu::row(
            ui,
            |ui| menu::of_plot(ui, "the scatter plot", plot),
            |ui| {
                if gray {
                    ui.label(small("luma vs luma of the next frame"));
                    return;
                }
                ui.spacing_mut().item_spacing.x = 2.0;
                ui.spacing_mut().button_padding.x = 6.0;
                for (space, name, meaning) in [
                    (ScatterSpace::Plane(0, 1), "R–G", "X axis: red, Y axis: green"),
                    (ScatterSpace::Plane(1, 2), "G–B", "X axis: green, Y axis: blue"),
                    (ScatterSpace::Plane(0, 2), "R–B", "X axis: red, Y axis: blue"),
                    (ScatterSpace::Cube, "3-D", "All three channels, rotatable"),
                ] {
                    ui.selectable_value(&mut self.space, space, name).on_hover_text(meaning);
                }
            },
        );
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 6.0;
            ui.label(style::aside(ui, "frames"));
            let total = chosen.history.states.len();
            let mut last = if self.last == 0 { total } else { self.last };
            // The chosen number is retained while fewer frames are available.
            let drag = DragValue::new(&mut last).range(2..=total.max(2)).clamp_existing_to_range(false);
            let drag = drag.prefix("last ");
            let drag = ui.add(drag).accessible_name("Frames up to the current one");
            if drag
                .on_hover_text("Number of frames up to the current one; drag, or click to enter a value")
                .changed()
            {
                self.last = last;
            }
            ui.add_space(4.0);
            for (last, name) in [(100, "100"), (500, "500"), (0, "all")] {
                ui.selectable_value(&mut self.last, last, small(name));
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 6.0;
            ui.label(style::aside(ui, "colour"));
            for (by, name) in [
                (PointGrouping::Component, "component"),
                (PointGrouping::Verdict, "verdict"),
                (PointGrouping::Time, "time"),
            ] {
                ui.selectable_value(&mut self.by, by, small(name));
            }
        });
        let choice = self.choice(chosen);
        let cube = choice.space == ScatterSpace::Cube;
        self.count(chosen, choice);
        let cache = self.cache.as_ref();
        if cube {
            self.cube.ui(ui, chosen, cache.map_or(&[], |cache| &cache.places));
        } else if let Some(cache) = cache {
            plane(ui, chosen, &cache.choice, &cache.groups);
        }
        ui.label(style::aside(ui, &self.caption(chosen)));
        ui.add_space(8.0);
        asked
    }

    fn choice(&self, chosen: &ChosenPixel<'_>) -> ScatterSelection {
        let end = chosen.index + 1;
        let frames: Range<usize> =
            if self.last == 0 { 0..chosen.history.states.len() } else { end.saturating_sub(self.last)..end };
        let space = if chosen.channels().len() == 1 { ScatterSpace::Next } else { self.space };
        ScatterSelection { space, frames, by: self.by }
    }

    /// Drops the cached points.
    pub(super) fn forget(&mut self) {
        self.cache = None;
    }

    fn count(&mut self, chosen: &ChosenPixel<'_>, choice: ScatterSelection) {
        // A point of this space also needs the next frame's value.
        let end = choice.frames.end + usize::from(choice.space == ScatterSpace::Next);
        let fits = self
            .cache
            .as_mut()
            .is_some_and(|cache| cache.choice == choice && chosen.shares(&mut cache.history, end));
        if fits {
            return;
        }
        let cube = choice.space == ScatterSpace::Cube;
        let count = if cube { cube::spots } else { scatter_points };
        let places = count(chosen.history, chosen.slots, &choice);
        let groups = if cube { Vec::new() } else { groups(&places) };
        self.cache = Some(CachedPoints { history: Arc::clone(chosen.history), choice, places, groups });
    }

    fn caption(&self, chosen: &ChosenPixel<'_>) -> String {
        let lambda = number(chosen.history.parameters.lambda);
        let reach = match self.choice(chosen).space {
            ScatterSpace::Next => "Squares",
            ScatterSpace::Plane(..) => "Circles",
            ScatterSpace::Cube => "Spheres",
        };
        let colours = match self.by {
            PointGrouping::Component => "filled dots: background, rings: foreground",
            PointGrouping::Verdict => "green: background, orange: foreground",
            PointGrouping::Time => "stronger dots: later frames",
        };
        let cross = match coordinates_of(chosen.history, chosen.index, self.choice(chosen).space) {
            Some(_) => "cross: current value",
            None => "no cross: the next value is not available yet",
        };
        format!(
            "{reach}: {lambda}σ around each component's mean, solid for background, dashed for foreground; \
             {colours}; {cross}."
        )
    }
}

/// A plane of two channels, or of a value and the next, with pan and zoom.
fn plane(ui: &mut Ui, chosen: &ChosenPixel<'_>, choice: &ScatterSelection, groups: &[PointGroup]) {
    let (x, y) = if let ScatterSpace::Plane(x, y) = choice.space { (x, y) } else { (0, 0) };
    let gray = choice.space == ScatterSpace::Next;
    let visuals = ui.visuals().clone();
    let lambda = chosen.history.parameters.lambda;
    let (component_states, _) = component_states(chosen.history, chosen.slots, chosen.index, false);
    let names = if gray { ("luma", "next") } else { (chosen.channels()[x], chosen.channels()[y]) };
    let side = (ui.available_width() - 4.0).min(440.0);
    let cross =
        coordinates_of(chosen.history, chosen.index, choice.space).map(|[x, y, _]| [x, y].map(f64::from));

    // Each plane has its own pan and zoom.
    let response = Plot::new(("scatter", x, y, gray))
        .width(side)
        .height(side)
        .data_aspect(1.0)
        // The number above a circle must stay inside.
        .set_margin_fraction(egui::Vec2::splat(0.08))
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
                // Rings are faint, and foreground is rare and must be visible.
                let hollow = matches!(group.kind, PointKind::Component { foreground: true, .. });
                let strength = if hollow { 1.0 } else { [0.45, 0.65, 0.9][group.density.min(2)] };
                let colour = style::point_colour(&visuals, group.kind).gamma_multiply(strength);
                plot.points(
                    Points::new("", PlotPoints::Borrowed(&group.points))
                        .color(colour)
                        .filled(!hollow)
                        .radius(if hollow { 2.4 } else { 1.9 })
                        .allow_hover(false),
                );
            }
            for component_state in &component_states {
                let component = component_state.component;
                let (mx, my) = (f64::from(component.mean[x]), f64::from(component.mean[y]));
                let reach = f64::from(component.reach(lambda));
                let outline = scatter::outline([mx, my], reach, gray);
                let colour = style::component(&visuals, component_state.slot);
                let dashed = LineStyle::Dashed { length: 6.0 };
                let style = if component_state.background { LineStyle::Solid } else { dashed };
                plot.line(Line::new("", outline).color(colour).width(1.5).style(style).allow_hover(false));
                let name = egui::RichText::new(component_state.rank.to_string()).size(12.0).strong();
                let top = PlotPoint::new(mx, my + reach);
                plot.text(
                    egui_plot::Text::new("", top, name)
                        .color(colour)
                        .anchor(egui::Align2::CENTER_BOTTOM)
                        .allow_hover(false),
                );
            }
            if let Some(cross) = cross {
                plot.points(
                    Points::new("", cross)
                        .shape(MarkerShape::Cross)
                        .color(style::ink(&visuals))
                        .radius(6.0)
                        .allow_hover(false),
                );
            }
        });
    response.response.widget_info(|| {
        let count: usize = groups.iter().map(|group| group.points.len()).sum();
        let here = cross.map_or_else(String::new, |[x, y]| format!(", current value at {x}, {y}"));
        WidgetInfo::labeled(
            Role::Image,
            true,
            format!("Scatter plot of {} vs {}, {count} positions{here}", names.1, names.0),
        )
    });
}

fn axis<'a>(hints: AxisHints<'a>, name: &str, visuals: &Visuals) -> AxisHints<'a> {
    hints
        .label(small(name))
        .label_spacing(Rangef::new(18.0, 19.0))
        .tick_label_font(style::tick_font())
        .tick_label_color(style::muted(visuals))
}

/// Grid lines of one kind, only as many as leave space for their numbers.
fn marks(input: &GridInput) -> Vec<GridMark> {
    let (min, max) = input.bounds;
    let values = chart::ticks(min, max, 6);
    let step_size = values.get(1).map_or(max - min, |second| second - values[0]);
    values.into_iter().map(|value| GridMark { value, step_size }).collect()
}

/// Groups points by appearance.
fn groups(places: &[ScatterPoint]) -> Vec<PointGroup> {
    let mut groups: Vec<PointGroup> = Vec::new();
    let mut sorted: Vec<_> =
        places.iter().map(|place| (place.kind, scatter::density(place.count), place.at)).collect();
    sorted.sort_unstable();
    for (kind, density, [x, y, _]) in sorted {
        let point = PlotPoint::new(x, y);
        match groups.last_mut().filter(|group| (group.kind, group.density) == (kind, density)) {
            Some(group) => group.points.push(point),
            None => groups.push(PointGroup { kind, density, points: vec![point] }),
        }
    }
    groups
}
