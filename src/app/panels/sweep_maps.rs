//! The dialog of a sweep: a measure over two settings, whose cells are loaded into A or B.

use std::sync::Arc;

use eframe::egui::{
    Align2, Button, ComboBox, Context, FontId, Grid, Id, Modal, Rect, Response, RichText, ScrollArea, Sense,
    Stroke, StrokeKind, Ui, pos2, vec2,
};

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::opened_sweep::OpenedSweep;
use crate::app::theme;
use crate::export::heat_map::{axis_title, open_axes};
use crate::export::sweep_csv;
use crate::palette;
use crate::settings::Settings;
use crate::sweep::heat_map::{Cell, HeatMap, MapAxes, Subject, mapped_axes, mapped_measures};
use crate::truth::measures::{MeasureColumn, OBJECTIVE};

/// Largest width of the dialog, in points.
const WIDTH: f32 = 760.0;
/// Least width of a cell, and its height.
const CELL: [f32; 2] = [60.0, 30.0];
/// Height of the rows of text above the cells.
const HEADER: f32 = 20.0;
/// Width of a choice.
const CHOICE_WIDTH: f32 = 220.0;
/// Largest height of a list of choices, that of all measures.
const LIST_HEIGHT: f32 = 360.0;
/// Height of the dialog's parts around the cells.
const AROUND: f32 = 340.0;

/// The dialog. The map in view, while it is open.
#[derive(Default)]
pub(crate) struct SweepMaps(Option<MapInView>);

/// A map of a sweep.
struct MapInView {
    sweep: Arc<OpenedSweep>,
    measures: Vec<&'static MeasureColumn>,
    choice: MapChoice,
    /// The map of the choice.
    map: HeatMap,
}

/// Which map is in view.
#[derive(Clone, Copy, PartialEq)]
struct MapChoice {
    subject: Subject,
    /// The index of the measure.
    measure: usize,
    axes: MapAxes,
}

impl SweepMaps {
    /// Opens the dialog with the first map of a sweep.
    pub(crate) fn open(&mut self, sweep: Arc<OpenedSweep>) {
        let table = &sweep.table;
        let mut measures = sweep_csv::columns(table);
        if mapped_measures(table).iter().any(|measure| measure.name == OBJECTIVE.name) {
            measures.insert(0, &OBJECTIVE);
        }
        let ranking = mapped_measures(table).first().map_or("", |measure| measure.name);
        let measure = measures.iter().position(|measure| measure.name == ranking).unwrap_or(0);
        let axes = mapped_axes(&sweep.table.grid);
        let axes = MapAxes { across: axes.first().copied().unwrap_or(0), down: axes.get(1).copied() };
        let choice = MapChoice { subject: Subject::All, measure, axes };
        let map = map_of(&sweep, &measures, choice);
        self.0 = Some(MapInView { sweep, measures, choice, map });
    }

    /// Whether the dialog is open.
    pub(crate) const fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Draws the dialog while it is open.
    pub(crate) fn ui(&mut self, ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
        let Some(shown) = &mut self.0 else { return };
        let response = Modal::new(Id::unique("sweep"))
            .frame(theme::dialog_frame(ctx))
            .show(ctx, |ui| content(ui, shown, model, commands));
        if response.inner || response.should_close() {
            self.0 = None;
        }
    }
}

fn map_of(sweep: &OpenedSweep, measures: &[&MeasureColumn], choice: MapChoice) -> HeatMap {
    let measure = measures.get(choice.measure).copied().unwrap_or(&OBJECTIVE);
    HeatMap::new(&sweep.table, choice.subject, measure, choice.axes)
}

/// Draws the contents of the dialog; returns whether it is to be closed.
fn content(ui: &mut Ui, shown: &mut MapInView, model: &Model, commands: &mut Vec<Command>) -> bool {
    let screen = ui.ctx().content_rect();
    ui.set_width((screen.width() - 64.0).clamp(0.0, WIDTH));
    ui.label(RichText::new("Sweep").size(18.0).strong());
    about(ui, &shown.sweep);
    ui.add_space(2.0 * theme::SPACE);
    let before = shown.choice;
    controls(ui, shown);
    if shown.choice != before {
        shown.map = map_of(&shown.sweep, &shown.measures, shown.choice);
    }
    ui.add_space(2.0 * theme::SPACE);
    let open = open_axes(&shown.sweep.table, shown.choice.axes);
    let open = if open.is_empty() { open } else { format!("Each cell is the {open}. ") };
    ui.weak(format!(
        "{open}Click: load into A. Shift+click or right click: load into B. Brighter is better."
    ));
    ui.add_space(theme::SPACE);
    let most = (screen.height() - AROUND).max(3.0 * CELL[1]);
    let chosen = ScrollArea::both().max_height(most).show(ui, |ui| cells(ui, shown, model)).inner;
    ui.add_space(2.0 * theme::SPACE);
    let best = best(ui, shown);
    if let Some((combination, slot)) = chosen.or(best) {
        let base = shown.sweep.base.as_ref().unwrap_or(&model.edits.settings);
        // The values of the table were checked when it was read.
        if let Ok(settings) = shown.sweep.table.grid.settings(base, combination) {
            commands.push(Command::SetSlot(slot, Box::new(settings)));
        }
    }
    ui.add_space(2.0 * theme::SPACE);
    ui.button("Close").clicked()
}

/// What was opened, and from which settings cells start.
fn about(ui: &mut Ui, sweep: &OpenedSweep) {
    let table = &sweep.table;
    let (sequences, combinations) = (table.sequences.len(), table.grid.combinations());
    ui.weak(sweep.path.display().to_string());
    let missing = (sequences * combinations).saturating_sub(table.rows.len());
    let missing = if missing > 0 { format!(", {missing} rows are missing") } else { String::new() };
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    ui.weak(format!(
        "{sequences} sequence{}, {combinations} combination{} of settings{missing}",
        plural(sequences),
        plural(combinations)
    ));
    if sweep.base.is_none() {
        let text = "No settings.toml beside the table: other settings stay as they are now.";
        ui.colored_label(theme::colours(ui.visuals()).warn, text);
    }
}

fn controls(ui: &mut Ui, MapInView { sweep, measures, choice, .. }: &mut MapInView) {
    let table = &sweep.table;
    let mut subjects = vec![Subject::All];
    if table.sequences.len() > 1 {
        subjects.extend((0..table.sequences.len()).map(Subject::Sequence));
    }
    let indices: Vec<usize> = (0..measures.len()).collect();
    let axes = mapped_axes(&sweep.table.grid);
    let title =
        |at: &usize| table.grid.axes().get(*at).map_or_else(String::new, |axis| axis_title(axis.setting));
    Grid::new("sweep").num_columns(4).spacing(vec2(8.0, 6.0)).show(ui, |ui| {
        select(ui, "Sequence", &mut choice.subject, &subjects, |subject| subject.name(table).to_owned());
        select(ui, "Measure", &mut choice.measure, &indices, |&at| measures[at].label.to_owned());
        ui.end_row();
        let MapAxes { across, down } = &mut choice.axes;
        let before = *across;
        if !axes.is_empty() {
            select(ui, "X axis", across, &axes, title);
        }
        if let Some(down) = down {
            if *down == *across {
                *down = before;
            }
            let others: Vec<usize> = axes.iter().copied().filter(|axis| axis != across).collect();
            select(ui, "Y axis", down, &others, title);
        }
        ui.end_row();
    });
}

/// A choice of one of some values, in two cells of a grid.
fn select<T: Copy + PartialEq>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    values: &[T],
    text: impl Fn(&T) -> String,
) {
    let label = ui.weak(label).id;
    let combo = ComboBox::from_id_salt(label).selected_text(text(value)).width(CHOICE_WIDTH);
    let combo = combo.height(LIST_HEIGHT).truncate();
    let shown = combo.show_ui(ui, |ui| {
        for one in values {
            ui.selectable_value(value, *one, text(one));
        }
    });
    shown.response.labelled_by(label);
}

/// The combinations of A and B, if the table has them.
fn combinations_of_slots(shown: &MapInView, model: &Model) -> [Option<usize>; 2] {
    let slots = &model.edits.ab_settings;
    AbSlot::ALL.map(|slot| {
        let settings: Option<&Settings> =
            if slot == slots.in_view { Some(&model.edits.settings) } else { slots.other.as_ref() };
        let (grid, settings) = (&shown.sweep.table.grid, settings?);
        let base = shown.sweep.base.as_ref().unwrap_or(settings);
        let combination = grid.combination_of(settings)?;
        (grid.settings(base, combination).ok()? == *settings).then_some(combination)
    })
}

/// Draws the cells. Returns the combination that was chosen, and its slot.
fn cells(ui: &mut Ui, shown: &MapInView, model: &Model) -> Option<(usize, AbSlot)> {
    let MapInView { sweep, map, choice, .. } = shown;
    let grid = &sweep.table.grid;
    let axis = |at: usize| {
        let Some(axis) = grid.axes().get(at) else { return (String::new(), Vec::new()) };
        (axis_title(axis.setting), axis.values.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let (across, down) = (axis(choice.axes.across), choice.axes.down.map_or_else(Default::default, axis));
    let font = FontId::proportional(theme::BODY_TEXT);
    let (text, weak) = (ui.visuals().text_color(), theme::colours(ui.visuals()).weak);
    let width = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), weak).size().x;
    let widest = |texts: &[String]| texts.iter().map(|text| width(text)).fold(0.0, f32::max);
    let cell = vec2((widest(&across.1) + 12.0).max(CELL[0]), CELL[1]);
    let left = widest(&down.1).max(width(&down.0)) + 8.0;
    let rows = map.cells.len() / map.columns.max(1);
    let size = vec2(left + cell.x * map.columns as f32, 2.0 * HEADER + cell.y * rows as f32);
    let (area, _) = ui.allocate_exact_size(size.max(vec2(left + width(&across.0), 0.0)), Sense::hover());
    let corner = area.min + vec2(left, 2.0 * HEADER);
    let painter = ui.painter().clone();
    let label = |at, align, label: &str, colour| painter.text(at, align, label, font.clone(), colour);
    label(pos2(corner.x, area.top()), Align2::LEFT_TOP, &across.0, text);
    label(pos2(area.left(), area.top() + HEADER), Align2::LEFT_TOP, &down.0, text);
    for (column, value) in across.1.iter().enumerate() {
        let x = corner.x + (column as f32 + 0.5) * cell.x;
        label(pos2(x, area.top() + HEADER), Align2::CENTER_TOP, value, weak);
    }
    for (row, value) in down.1.iter().enumerate() {
        let y = corner.y + (row as f32 + 0.5) * cell.y;
        label(pos2(corner.x - 8.0, y), Align2::RIGHT_CENTER, value, weak);
    }
    let (best, slots) = (map.best(), combinations_of_slots(shown, model));
    let mut chosen = None;
    for (at, content) in map.cells.iter().enumerate() {
        let place = vec2((at % map.columns) as f32 * cell.x, (at / map.columns) as f32 * cell.y);
        let rect = Rect::from_min_size(corner + place, cell).shrink(1.0);
        if !ui.is_rect_visible(rect) {
            continue;
        }
        let Some(content) = content else {
            painter.rect_stroke(
                rect,
                2.0,
                Stroke::new(1.0, theme::colours(ui.visuals()).line),
                StrokeKind::Inside,
            );
            painter.text(rect.center(), Align2::CENTER_CENTER, "–", font.clone(), weak);
            continue;
        };
        let response = cell_button(ui, shown, rect, content, best == Some(at));
        for (slot, combination) in AbSlot::ALL.into_iter().zip(slots) {
            if combination == Some(content.combination) {
                let (at, align) = match slot {
                    AbSlot::A => (rect.left_top() + vec2(4.0, 1.0), Align2::LEFT_TOP),
                    AbSlot::B => (rect.right_top() + vec2(-4.0, 1.0), Align2::RIGHT_TOP),
                };
                let ink = theme::ink_on(theme::rgb(palette::ramp(map.share(content.value))));
                painter.text(at, align, slot.name(), FontId::proportional(theme::SMALL_TEXT), ink);
            }
        }
        if response.secondary_clicked() {
            chosen = Some((content.combination, AbSlot::B));
        } else if response.clicked() {
            let slot = if ui.input(|input| input.modifiers.shift) { AbSlot::B } else { AbSlot::A };
            chosen = Some((content.combination, slot));
        }
    }
    chosen
}

fn cell_button(ui: &mut Ui, shown: &MapInView, rect: Rect, cell: &Cell, is_best: bool) -> Response {
    let MapInView { sweep, measures, choice, map } = shown;
    let measure = measures.get(choice.measure).copied().unwrap_or(&OBJECTIVE);
    let fill = theme::rgb(palette::ramp(map.share(cell.value)));
    let text = measure.text(cell.value);
    let name = format!("{}: {} {text}", sweep.table.grid.name(cell.combination), measure.label);
    let stroke = if is_best { Stroke::new(3.0, ui.visuals().strong_text_color()) } else { Stroke::NONE };
    let text = RichText::new(text).color(theme::ink_on(fill));
    let text = if is_best { text.strong().color(theme::ink_on(fill)) } else { text };
    let button = Button::new(text).fill(fill).stroke(stroke).corner_radius(2.0);
    let response = ui.put(rect, button).accessible_name(name);
    theme::focus(ui, &response);
    if response.gained_focus() {
        response.scroll_to_me(None);
    }
    response.on_hover_ui(|ui| {
        ui.label(RichText::new(sweep.table.grid.name(cell.combination)).strong());
        for measure in measures {
            if let Some(value) = choice.subject.value(&sweep.table, cell.combination, measure) {
                ui.label(format!("{} {}", measure.label, measure.text(value)));
            }
        }
    })
}

/// The best cell in words, with buttons. Returns the combination that was chosen, and its slot.
fn best(ui: &mut Ui, MapInView { sweep, measures, choice, map }: &MapInView) -> Option<(usize, AbSlot)> {
    let Some(cell) = map.best().and_then(|at| map.cells[at]) else {
        ui.weak("No combination has a value of this measure.");
        return None;
    };
    let measure = measures.get(choice.measure).copied().unwrap_or(&OBJECTIVE);
    let mut chosen = None;
    ui.horizontal_wrapped(|ui| {
        let text = format!(
            "Best: {} {}, {}",
            measure.label,
            measure.text(cell.value),
            sweep.table.grid.name(cell.combination)
        );
        ui.label(text);
        for slot in AbSlot::ALL {
            if ui.button(format!("Load into {}", slot.name())).clicked() {
                chosen = Some((cell.combination, slot));
            }
        }
    });
    chosen
}
