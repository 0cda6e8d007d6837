//! A grid over two settings: coloured cells, a cross at the present settings, a click that applies a cell.

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align2, Color32, Painter, Pos2, Rangef, Rect, Response, Sense, Stroke, StrokeKind, Tooltip, Ui, Vec2,
    WidgetInfo,
};

use super::action::InspectorAction;
use super::chart::{self, Columns, TICKS_HEIGHT};
use super::style::{self, small};
use crate::explain::pixel::verdict::number;
use crate::explain::tuning::{SettingAxis, TunableSetting};
use crate::mixture::Parameters;

/// Height of the x axis name.
const AXIS_NAME_HEIGHT: f32 = 15.0;
/// Maximum side of the grid.
const MAX_SIDE_PT: f32 = 380.0;

/// A computed grid.
pub(super) struct Grid<'a> {
    /// The settings of the x and y axes.
    pub(super) axes: &'a [SettingAxis; 2],
    /// The present settings.
    pub(super) parameters: &'a Parameters,
    /// The colour of a cell, by column and row.
    pub(super) colour: &'a dyn Fn(usize, usize) -> Color32,
    /// The description of a cell, by column and row.
    pub(super) words: &'a dyn Fn(usize, usize) -> String,
    /// A highlighted cell.
    pub(super) marked: Option<(usize, usize)>,
}

/// Draws the grid called `name`, or a placeholder until it is computed; `flat` is the ratio of height to width.
pub(super) fn ui(ui: &mut Ui, name: &str, flat: f32, grid: Option<&Grid<'_>>) -> Option<InspectorAction> {
    let side = (ui.available_width() - chart::GUTTER_WIDTH - chart::RIGHT_MARGIN).clamp(80.0, MAX_SIDE_PT);
    let size = Vec2::new(
        side + chart::GUTTER_WIDTH + chart::RIGHT_MARGIN,
        6.0 + side * flat + TICKS_HEIGHT + AXIS_NAME_HEIGHT,
    );
    let (area, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
    let plot = Rect::from_min_size(
        Pos2::new(area.left() + chart::GUTTER_WIDTH, area.top() + 6.0),
        Vec2::new(side, side * flat),
    );
    let (painter, visuals) = (ui.painter_at(area), ui.visuals());
    let Some(grid) = grid else {
        painter.rect_filled(plot, 0.0, visuals.faint_bg_color);
        let text = "Testing other settings…";
        painter.text(plot.center(), Align2::CENTER_CENTER, text, style::font(), style::muted(visuals));
        return None;
    };
    let [x, y] = grid.axes;
    let mut columns = Columns::default();
    for row in 0..y.values.len() {
        for column in 0..x.values.len() {
            let cell = cell_rect(plot, grid.axes, column, row);
            columns.add(cell.x_range(), cell.top(), cell.bottom(), (grid.colour)(column, row));
        }
    }
    columns.paint(&painter);
    axes(&painter, ui, plot, grid.axes);
    if let Some((column, row)) = grid.marked {
        let at = cell_rect(plot, grid.axes, column, row).center();
        for (width, colour) in rimmed(ui) {
            painter.circle_stroke(at, 5.0, Stroke::new(width, colour));
        }
    }
    let here = Pos2::new(
        plot.left() + plot.width() * x.share_of(x.setting.get(grid.parameters)).clamp(0.0, 1.0),
        plot.bottom() - plot.height() * y.share_of(y.setting.get(grid.parameters)).clamp(0.0, 1.0),
    );
    cross(&painter, ui, here);
    pick(ui, &response, &painter, plot, grid)
}

/// The legend of the cross.
pub(super) fn legend_of_cross(ui: &mut Ui) {
    let (rect, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
    let (at, stroke) = (rect.center(), Stroke::new(2.0, style::ink(ui.visuals())));
    ui.painter().hline(Rangef::new(at.x - 5.0, at.x + 5.0), at.y, stroke);
    ui.painter().vline(at.x, Rangef::new(at.y - 5.0, at.y + 5.0), stroke);
    ui.label(style::aside(ui, "current"));
}

/// The legend of the ring.
pub(super) fn legend_of_ring(ui: &mut Ui) {
    let (rect, _) = ui.allocate_exact_size(Vec2::splat(12.0), Sense::hover());
    ui.painter().circle_stroke(rect.center(), 4.5, Stroke::new(2.0, style::ink(ui.visuals())));
    ui.label(style::aside(ui, "best"));
}

fn cell_rect(plot: Rect, axes: &[SettingAxis; 2], column: usize, row: usize) -> Rect {
    let [columns, rows] = axes.each_ref().map(|axis| axis.values.len().max(1) as f32);
    let x = |column: usize| plot.left() + plot.width() * column as f32 / columns;
    let y = |row: usize| plot.bottom() - plot.height() * row as f32 / rows;
    Rect::from_x_y_ranges(Rangef::new(x(column), x(column + 1)), Rangef::new(y(row + 1), y(row)))
}

fn axes(painter: &Painter, ui: &Ui, plot: Rect, [x, y]: &[SettingAxis; 2]) {
    let visuals = ui.visuals();
    chart::frame(painter, plot, visuals);
    let labels: Vec<_> = ticks(x, (plot.width() / 50.0) as usize)
        .into_iter()
        .map(|value| (plot.left() + plot.width() * x.share_of(value), number(value)))
        .collect();
    chart::x_labels(painter, plot, &labels, visuals);
    let name = format!("{}, {}", x.setting.symbol(), x.setting.name());
    let place = Pos2::new(plot.center().x, plot.bottom() + TICKS_HEIGHT + 2.0);
    painter.text(place, Align2::CENTER_TOP, name, style::font(), visuals.text_color());

    let labels: Vec<_> = ticks(y, (plot.height() / 30.0) as usize)
        .into_iter()
        .map(|value| (plot.bottom() - plot.height() * y.share_of(value), number(value)))
        // The upper end of the axis shows the axis name.
        .filter(|(at, _)| *at > plot.top() + 16.0)
        .collect();
    chart::y_labels(painter, plot.left(), &labels, visuals);
    let place = Pos2::new(plot.left() - 6.0, plot.top() - 2.0);
    painter.text(place, Align2::RIGHT_TOP, y.setting.symbol(), style::font(), visuals.text_color());
}

/// Round values along an axis.
fn ticks(axis: &SettingAxis, most: usize) -> Vec<f32> {
    let (low, high) = (axis.value_at(0.0), axis.value_at(1.0));
    if !axis.setting.is_logarithmic() {
        let round = chart::ticks(low.into(), high.into(), most).into_iter().map(|value| value as f32);
        return round.collect();
    }
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let round = decades.map(|power| 10_f64.powi(power) as f32);
    round.filter(|value| (low..=high).contains(value)).collect()
}

/// Widths and colours of a line with a contrasting rim, visible on all colours.
fn rimmed(ui: &Ui) -> [(f32, Color32); 2] {
    [(4.0, ui.visuals().panel_fill), (2.0, style::ink(ui.visuals()))]
}

/// The cross at the present settings.
fn cross(painter: &Painter, ui: &Ui, at: Pos2) {
    for (width, colour) in rimmed(ui) {
        let stroke = Stroke::new(width, colour);
        let reach = 6.0 + width / 2.0;
        painter.hline(Rangef::new(at.x - reach, at.x + reach), at.y, stroke);
        painter.vline(at.x, Rangef::new(at.y - reach, at.y + reach), stroke);
    }
}

/// The settings of a cell.
pub(super) fn values(
    [x, y]: &[SettingAxis; 2],
    (column, row): (usize, usize),
) -> Option<[(TunableSetting, f32); 2]> {
    Some([(x.setting, *x.values.get(column)?), (y.setting, *y.values.get(row)?)])
}

/// The settings of a cell as text.
pub(super) fn words(values: [(TunableSetting, f32); 2]) -> String {
    values.map(|(setting, value)| format!("{} = {}", setting.symbol(), number(value))).join(",  ")
}

/// The cell under the pointer: shows its values, and applies them on a click.
fn pick(
    ui: &Ui,
    response: &Response,
    painter: &Painter,
    plot: Rect,
    grid: &Grid<'_>,
) -> Option<InspectorAction> {
    let pointer = response.hover_pos().or(response.interact_pointer_pos()).filter(|at| plot.contains(*at))?;
    let [x, y] = grid.axes;
    let column = x.cell_at((pointer.x - plot.left()) / plot.width());
    let row = y.cell_at((plot.bottom() - pointer.y) / plot.height());
    let values = values(grid.axes, (column, row))?;
    let cell = cell_rect(plot, grid.axes, column, row);
    let stroke = Stroke::new(1.5, style::ink(ui.visuals()));
    painter.rect_stroke(cell, 0.0, stroke, StrokeKind::Inside);
    Tooltip::for_widget(response).at_pointer().show(|ui| {
        ui.label(words(values));
        ui.label(small(&format!("{} Click to apply these settings.", (grid.words)(column, row))));
    });
    response.clicked().then_some(InspectorAction::Apply(values))
}
