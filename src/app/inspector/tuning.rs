//! What the pixel would be under other settings: a map over two of them, and what flips the verdict.

use std::time::Duration;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align2, Painter, Pos2, Rangef, Rect, Response, RichText, Sense, Stroke, StrokeKind, Tooltip, Ui, Vec2,
    WidgetInfo,
};

use super::chart::{self, Columns, TICKS};
use super::menu;
use super::plot::Plot;
use super::style::{self, small};
use super::{Chosen, InspectorAction};
use crate::mixture::tuning::{Axis, Flip, Knob, Map};
use crate::mixture::verdict::number;
use crate::replay::Tuning;

/// Room for the name of the axis across.
const NAME: f32 = 15.0;
/// The map's greatest side.
const SIDE: f32 = 380.0;
/// Its height as a share of its width: what flips the verdict should be in sight below it.
const FLAT: f32 = 0.62;
/// An answer that is older than the question for so many seconds is drawn pale.
const LATE: f64 = 0.15;

/// How strongly background and foreground are drawn: much of either must not outshine the cross.
const STRENGTHS: [f32; 2] = [0.34, 0.72];

/// Which settings the map is about.
pub(super) struct TuningView {
    pub(super) knobs: [Knob; 2],
    /// Since when the answer belongs to another question, in the window's seconds.
    late_since: Option<f64>,
}

impl Default for TuningView {
    fn default() -> Self {
        Self { knobs: [Knob::Alpha, Knob::T], late_since: None }
    }
}

impl TuningView {
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &Chosen<'_>,
        tuning: Option<&Tuning>,
    ) -> Option<InspectorAction> {
        let tuning = tuning.filter(|tuning| tuning.at == chosen.history.at);
        let of_knobs = tuning.filter(|tuning| tuning.map.axes.each_ref().map(|axis| axis.knob) == self.knobs);
        let current = tuning.filter(|tuning| {
            tuning.position as usize == chosen.index && tuning.parameters == chosen.history.parameters
        });
        let asked = self.controls(ui, chosen, of_knobs.filter(|_| current.is_some()));
        // What was just chosen has no map yet.
        let of_knobs =
            of_knobs.filter(|tuning| tuning.map.axes.each_ref().map(|axis| axis.knob) == self.knobs);
        let pale = self.is_late(ui, of_knobs.is_some() && current.is_none());
        let taken = map_ui(ui, chosen, self.knobs, of_knobs.map(|tuning| &tuning.map), pale);
        ui.horizontal_wrapped(legend);
        ui.add_space(6.0);
        let taken = flips_ui(ui, chosen, current.map(|tuning| &tuning.flips[..])).or(taken);
        ui.add_space(8.0);
        taken.or(asked)
    }

    fn controls(
        &mut self,
        ui: &mut Ui,
        chosen: &Chosen<'_>,
        map: Option<&Tuning>,
    ) -> Option<InspectorAction> {
        let mut asked = None;
        for (side, name) in ["across", "up"].into_iter().enumerate() {
            let menu = |ui: &mut Ui| {
                let map = map.filter(|_| side == 0)?;
                menu::of_plot(ui, "the map", || Plot::Map(chosen.followed(), Box::new(map.clone())))
            };
            asked = asked.or(menu::row(ui, menu, |ui| self.knobs(ui, side, name)));
        }
        asked
    }

    fn knobs(&mut self, ui: &mut Ui, side: usize, name: &str) {
        ui.spacing_mut().item_spacing.x = 2.0;
        let (rect, _) = ui.allocate_exact_size(Vec2::new(38.0, 16.0), Sense::hover());
        let (painter, visuals) = (ui.painter(), ui.visuals());
        painter.text(rect.left_center(), Align2::LEFT_CENTER, name, style::font(), style::muted(visuals));
        for knob in Knob::ALL {
            let label = ui.selectable_label(self.knobs[side] == knob, knob.symbol());
            let label = label.on_hover_text(format!("{}: {}, {name}", knob.symbol(), knob.name()));
            if label.clicked() && self.knobs[side] != knob {
                // The two sides change places rather than show the same.
                if self.knobs[1 - side] == knob {
                    self.knobs.swap(0, 1);
                } else {
                    self.knobs[side] = knob;
                }
            }
        }
    }

    /// Whether the answer has been behind for so long that it must be seen: while a video plays it
    /// is so for a moment in every frame, and would flicker.
    fn is_late(&mut self, ui: &Ui, behind: bool) -> bool {
        if !behind {
            self.late_since = None;
            return false;
        }
        let now = ui.input(|input| input.time);
        let since = *self.late_since.get_or_insert(now);
        ui.ctx().request_repaint_after(Duration::from_secs_f64(LATE));
        now - since > LATE
    }
}

/// What the colours and the cross stand for.
fn legend(ui: &mut Ui) {
    ui.spacing_mut().item_spacing.x = 4.0;
    for (foreground, name) in [(true, "foreground"), (false, "background")] {
        let (rect, _) = ui.allocate_exact_size(Vec2::new(12.0, 10.0), Sense::hover());
        let strength = STRENGTHS[usize::from(foreground)];
        let colour = style::verdict_colour(ui.visuals(), foreground).gamma_multiply(strength);
        let plate = Rect::from_center_size(rect.center(), Vec2::new(12.0, 8.0));
        ui.painter().rect_filled(plate, 1.0, colour);
        ui.label(style::aside(ui, name));
    }
    let (rect, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
    let (at, stroke) = (rect.center(), Stroke::new(2.0, style::ink(ui.visuals())));
    ui.painter().hline(Rangef::new(at.x - 5.0, at.x + 5.0), at.y, stroke);
    ui.painter().vline(at.x, Rangef::new(at.y - 5.0, at.y + 5.0), stroke);
    ui.label(style::aside(ui, "now"));
}

fn map_ui(
    ui: &mut Ui,
    chosen: &Chosen<'_>,
    knobs: [Knob; 2],
    map: Option<&Map>,
    pale: bool,
) -> Option<InspectorAction> {
    let side = (ui.available_width() - chart::GUTTER - chart::RIGHT).clamp(80.0, SIDE);
    let size = Vec2::new(side + chart::GUTTER + chart::RIGHT, 6.0 + side * FLAT + TICKS + NAME);
    let (area, response) = ui.allocate_exact_size(size, Sense::click());
    let [across, up] = knobs.map(Knob::symbol);
    response.widget_info(|| {
        let share = map.map_or("not known yet".to_owned(), |map| {
            format!("foreground in {:.0} % of it", map.foreground_share() * 100.0)
        });
        WidgetInfo::labeled(Role::Image, true, format!("Tuning map of {across} across and {up} up, {share}"))
    });
    let plot = Rect::from_min_size(
        Pos2::new(area.left() + chart::GUTTER, area.top() + 6.0),
        Vec2::new(side, side * FLAT),
    );
    let (painter, visuals) = (ui.painter_at(area), ui.visuals());
    let parameters = &chosen.history.parameters;
    let Some(map) = map else {
        painter.rect_filled(plot, 0.0, visuals.faint_bg_color);
        let text = "trying other settings …";
        painter.text(plot.center(), Align2::CENTER_CENTER, text, style::font(), style::muted(visuals));
        return None;
    };
    cells(&painter, ui, plot, map, if pale { 0.4 } else { 1.0 });
    axes(&painter, ui, plot, &map.axes);
    let [x, y] = &map.axes;
    let here = Pos2::new(
        plot.left() + plot.width() * x.share_of(x.knob.get(parameters)).clamp(0.0, 1.0),
        plot.bottom() - plot.height() * y.share_of(y.knob.get(parameters)).clamp(0.0, 1.0),
    );
    cross(&painter, ui, here);
    pick(ui, &response, &painter, plot, map)
}

fn cells(painter: &Painter, ui: &Ui, plot: Rect, map: &Map, strength: f32) {
    let visuals = ui.visuals();
    let colours = STRENGTHS.map(|share| share * strength);
    let background = style::verdict_colour(visuals, false).gamma_multiply(colours[0]);
    let foreground = style::verdict_colour(visuals, true).gamma_multiply(colours[1]);
    let mut columns = Columns::default();
    for row in 0..map.axes[1].values.len() {
        for column in 0..map.axes[0].values.len() {
            let cell = cell_rect(plot, map, column, row);
            let colour = if map.is_foreground(column, row) { foreground } else { background };
            columns.add(cell.x_range(), cell.top(), cell.bottom(), colour);
        }
    }
    columns.paint(painter);
}

fn cell_rect(plot: Rect, map: &Map, column: usize, row: usize) -> Rect {
    let [columns, rows] = map.axes.each_ref().map(|axis| axis.values.len().max(1) as f32);
    let x = |column: usize| plot.left() + plot.width() * column as f32 / columns;
    let y = |row: usize| plot.bottom() - plot.height() * row as f32 / rows;
    Rect::from_x_y_ranges(Rangef::new(x(column), x(column + 1)), Rangef::new(y(row + 1), y(row)))
}

fn axes(painter: &Painter, ui: &Ui, plot: Rect, [x, y]: &[Axis; 2]) {
    let visuals = ui.visuals();
    chart::frame(painter, plot, visuals);
    let labels: Vec<_> = ticks(x, (plot.width() / 50.0) as usize)
        .into_iter()
        .map(|value| (plot.left() + plot.width() * x.share_of(value), number(value)))
        .collect();
    chart::x_labels(painter, plot, &labels, visuals);
    let name = format!("{}, {}", x.knob.symbol(), x.knob.name());
    let place = Pos2::new(plot.center().x, plot.bottom() + TICKS + 2.0);
    painter.text(place, Align2::CENTER_TOP, name, style::font(), visuals.text_color());

    let labels: Vec<_> = ticks(y, (plot.height() / 30.0) as usize)
        .into_iter()
        .map(|value| (plot.bottom() - plot.height() * y.share_of(value), number(value)))
        // The axis' own name stands at its upper end.
        .filter(|(at, _)| *at > plot.top() + 16.0)
        .collect();
    chart::y_labels(painter, plot.left(), &labels, visuals);
    let place = Pos2::new(plot.left() - 6.0, plot.top() - 2.0);
    painter.text(place, Align2::RIGHT_TOP, y.knob.symbol(), style::font(), visuals.text_color());
}

/// Round values along an axis.
fn ticks(axis: &Axis, most: usize) -> Vec<f32> {
    let (low, high) = (axis.value_at(0.0), axis.value_at(1.0));
    if !axis.knob.is_logarithmic() {
        let round = chart::ticks(low.into(), high.into(), most).into_iter().map(|value| value as f32);
        return round.collect();
    }
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let round = decades.map(|power| 10_f64.powi(power) as f32);
    round.filter(|value| (low..=high).contains(value)).collect()
}

/// The present settings: a cross with a rim, to be seen on both colours.
fn cross(painter: &Painter, ui: &Ui, at: Pos2) {
    let visuals = ui.visuals();
    for (width, colour) in [(4.0, visuals.panel_fill), (2.0, style::ink(visuals))] {
        let stroke = Stroke::new(width, colour);
        let reach = 6.0 + width / 2.0;
        painter.hline(Rangef::new(at.x - reach, at.x + reach), at.y, stroke);
        painter.vline(at.x, Rangef::new(at.y - reach, at.y + reach), stroke);
    }
}

/// The cell under the pointer: its values, and on a click they are asked for.
fn pick(ui: &Ui, response: &Response, painter: &Painter, plot: Rect, map: &Map) -> Option<InspectorAction> {
    let pointer = response.hover_pos().or(response.interact_pointer_pos()).filter(|at| plot.contains(*at))?;
    let [x, y] = &map.axes;
    let column = x.cell_at((pointer.x - plot.left()) / plot.width());
    let row = y.cell_at((plot.bottom() - pointer.y) / plot.height());
    let values = [(x.knob, x.values[column]), (y.knob, y.values[row])];
    let cell = cell_rect(plot, map, column, row);
    let stroke = Stroke::new(1.5, style::ink(ui.visuals()));
    painter.rect_stroke(cell, 0.0, stroke, StrokeKind::Inside);
    Tooltip::for_widget(response).at_pointer().show(|ui| {
        let words = values.map(|(knob, value)| format!("{} = {}", knob.symbol(), number(value)));
        ui.label(words.join(",  "));
        let verdict = if map.is_foreground(column, row) { "Foreground" } else { "Background" };
        ui.label(small(&format!("{verdict}. Click to take these settings.")));
    });
    response.clicked().then_some(InspectorAction::Take(values))
}

/// For each setting alone the nearest value that flips the verdict.
fn flips_ui(ui: &mut Ui, chosen: &Chosen<'_>, flips: Option<&[Flip]>) -> Option<InspectorAction> {
    let other = if chosen.state.outcome.foreground { "background" } else { "foreground" };
    ui.label(RichText::new(format!("What alone would make it {other}")).strong()).on_hover_text(
        "For each setting, the value nearest to the present one at which the mixture's verdict about this pixel in \
         this frame is the other one. Each was found by running the pixel anew from the first frame.",
    );
    let mut taken = None;
    for (at, knob) in Knob::ALL.into_iter().enumerate() {
        let flip = flips.and_then(|flips| flips.iter().find(|flip| flip.knob == knob));
        let present = knob.get(&chosen.history.parameters);
        let height = style::SMALL + 9.0;
        let (row, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::hover());
        if at % 2 == 0 {
            ui.painter().rect_filled(row, 2.0, ui.visuals().faint_bg_color);
        }
        let visuals = ui.visuals();
        let text = |x: f32, text: &str, colour| {
            let place = Pos2::new(row.left() + x, row.center().y);
            ui.painter().text(place, Align2::LEFT_CENTER, text, style::font(), colour);
        };
        // A narrow panel has no room for the name; it stands over the map, too.
        let name = if row.width() < 270.0 { "" } else { knob.name() };
        let left = if name.is_empty() { 26.0 } else { 124.0 };
        text(6.0, knob.symbol(), visuals.text_color());
        text(26.0, name, style::muted(visuals));
        text(left, &format!("now {}", number(present)), style::muted(visuals));
        let place = Rect::from_min_max(Pos2::new(row.left() + left + 72.0, row.top()), row.right_bottom());
        ui.scope_builder(eframe::egui::UiBuilder::new().max_rect(place), |ui| {
            ui.horizontal_centered(|ui| match flip {
                None => {
                    ui.label(style::aside(ui, "…"));
                }
                Some(flip @ Flip { value: Some(value), .. }) => {
                    let button = ui.small_button(small(&flip.words()));
                    let says = format!("Set {} to {value}", knob.symbol());
                    if button.on_hover_text(says).clicked() {
                        // The same setting twice: the other one stays as it is.
                        taken = Some(InspectorAction::Take([(knob, *value); 2]));
                    }
                }
                Some(flip) => {
                    ui.label(style::aside(ui, &flip.words()));
                }
            });
        });
    }
    taken
}
