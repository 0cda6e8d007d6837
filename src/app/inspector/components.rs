//! The numbers of a frame: a table of the components, and the parameters of the update.

use eframe::egui::{Align, Layout, Pos2, Rect, Sense, Stroke, Ui, UiBuilder, Vec2};

use super::chosen_pixel::ChosenPixel;
use super::style::{self, SMALL_TEXT, small};
use crate::explain::pixel::component_states::ComponentState;
use crate::explain::pixel::verdict::number;

/// Columns of the table with their minimum widths, by line.
type Lines = &'static [&'static [(usize, f32)]];

/// The layout for panels of at least 320 points.
const ONE_LINE: Lines = &[&[(0, 22.0), (1, 33.0), (2, 80.0), (3, 27.0), (4, 43.0), (5, 40.0), (6, 50.0)]];
/// The layout for narrower panels: two lines a row.
const TWO_LINES: Lines =
    &[&[(0, 24.0), (2, 82.0), (3, 34.0), (6, 52.0)], &[(0, 24.0), (1, 50.0), (4, 62.0), (5, 56.0)]];

/// The components of a mixture, one row each.
pub(super) fn table(ui: &mut Ui, chosen: &ChosenPixel<'_>, rows: &[ComponentState]) {
    let gray = chosen.channels().len() == 1;
    let heads = [
        ("", "Rank and plot colour of the component. The colour is kept when the rank changes."),
        ("w", "Weight: share of the recent frames that the component accounts for"),
        ("μ", "Mean"),
        ("σ", "Standard deviation; σ² is updated with the squared distance summed over the channels"),
        ("w/σ", "Ranking criterion of the components"),
        ("dist.", "Distance of the value from the component before the update, in σ"),
        ("", ""),
    ];
    line(ui, None, |ui, column| {
        let (head, meaning) = heads[column];
        if !head.is_empty() {
            let label = ui.label(style::aside(ui, head));
            label.on_hover_text(meaning);
        }
    });
    let lambda = chosen.history.parameters.lambda;
    for row in rows {
        line(ui, Some(row.rank), |ui, column| match column {
            0 => {
                dot(ui, row);
                ui.label(small(&row.rank.to_string()));
            }
            1 => {
                ui.label(small(&format!("{:.3}", row.component.weight)));
            }
            2 => {
                let [r, g, b] = row.component.mean;
                let text = if gray { format!("{r:.1}") } else { format!("{r:.0}  {g:.0}  {b:.0}") };
                let exact =
                    if gray { format!("μ = {r:.2}") } else { format!("μ = ({r:.2}, {g:.2}, {b:.2})") };
                let rgb = if gray { [r; 3] } else { [r, g, b] }.map(|channel| channel.round() as u8);
                ui.add_space(5.0);
                style::swatch(ui, rgb, 11.0, &format!("mean colour {text}"));
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    ui.label(small(&text)).on_hover_text(exact);
                });
            }
            3 => {
                ui.label(small(&format!("{:.1}", row.component.sigma())));
            }
            4 => {
                ui.label(small(&format!("{:.4}", row.component.rank_value())));
            }
            5 => {
                let text = row.distance.map_or_else(|| "–".to_owned(), |d| format!("{d:.1} σ"));
                let near = row.distance.is_some_and(|d| d <= lambda);
                let text = small(&text);
                ui.label(if near { text.strong() } else { text.color(style::muted(ui.visuals())) });
            }
            _ => {
                let background = style::verdict_colour(ui.visuals(), false);
                let foreground = style::verdict_colour(ui.visuals(), true);
                let (text, colour) = if row.background { ("bg", background) } else { ("fg", foreground) };
                ui.label(small(text).color(colour)).on_hover_text(if row.background {
                    "Background: its rank is at most B"
                } else {
                    "Foreground: its rank is greater than B"
                });
                if row.matched {
                    ui.label(small("match").strong()).on_hover_text("The value matches this component");
                } else if row.new {
                    ui.label(small("new").strong()).on_hover_text("Created in this frame from its value");
                }
            }
        });
    }
}

/// A row of the table: columns at fixed positions, numbers aligned right.
fn line(ui: &mut Ui, rank: Option<usize>, mut cell: impl FnMut(&mut Ui, usize)) {
    const LINE_HEIGHT: f32 = SMALL_TEXT + 6.0;
    let least = |columns: &[(usize, f32)]| columns.iter().map(|(_, width)| width).sum::<f32>();
    let lines = if ui.available_width() < least(ONE_LINE[0]) { TWO_LINES } else { ONE_LINE };
    let size = Vec2::new(ui.available_width(), LINE_HEIGHT * lines.len() as f32);
    let (area, _) = ui.allocate_exact_size(size, Sense::hover());
    if rank.is_some_and(|rank| rank % 2 == 1) {
        ui.painter().rect_filled(area, 2.0, ui.visuals().faint_bg_color);
    }
    for (at, columns) in lines.iter().enumerate() {
        let spare = (area.width() - least(columns)).max(0.0) / (columns.len() - 1).max(1) as f32;
        let (mut x, top) = (area.left(), area.top() + LINE_HEIGHT * at as f32);
        for &(column, width) in *columns {
            let width = if column == 0 { width } else { width + spare };
            let place = Rect::from_min_size(Pos2::new(x, top), Vec2::new(width, LINE_HEIGHT));
            x += width;
            // Only the first line has the rank.
            if column == 0 && at > 0 {
                continue;
            }
            let layout = if column == 0 || (column == 2 && rank.is_some()) {
                Layout::left_to_right(Align::Center)
            } else {
                Layout::right_to_left(Align::Center)
            };
            // Each cell gets its own child area: the row has been allocated as a whole.
            let mut cell_ui =
                ui.new_child(UiBuilder::new().max_rect(place).layout(layout).id_salt((rank, column)));
            cell_ui.spacing_mut().item_spacing.x = 4.0;
            cell(&mut cell_ui, column);
        }
    }
}

fn dot(ui: &mut Ui, row: &ComponentState) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(11.0, 11.0), Sense::hover());
    let colour = style::component(ui.visuals(), row.slot);
    if row.background {
        ui.painter().circle_filled(rect.center(), 4.5, colour);
    } else {
        ui.painter().circle_stroke(rect.center(), 3.8, Stroke::new(1.6, colour));
    }
}

/// The other quantities of the frame's update, in columns.
pub(super) fn numbers(ui: &mut Ui, chosen: &ChosenPixel<'_>) {
    let (outcome, parameters) = (chosen.state.outcome, &chosen.history.parameters);
    let before = chosen.history.before(chosen.index).map(|before| *before.past()).unwrap_or_default();
    let alpha = parameters.alpha_of(&before, chosen.state.t);
    let past = chosen.state.pixel.past();
    let mut cells = vec![
        ("P(X)", number(outcome.p), "Probability density of the value under the mixture before the update"),
        ("ρ", number(outcome.rho), "Update rate of the matched component's μ and σ²; 0 without a match"),
        (
            "α",
            number(alpha),
            "Learning rate of the weights in this frame (1/t during warm-up; adapted by feedback)",
        ),
        ("B", outcome.background_count.to_string(), "Number of background components after the update"),
        (
            "t",
            chosen.state.t.to_string(),
            "Number of frames processed by the model, including this frame and bootstrap",
        ),
        (
            "λ, T",
            format!("{}, {}", number(parameters.lambda), number(parameters.t_of(past))),
            "Match threshold λ in σ, and background ratio T",
        ),
    ];
    if parameters.feedback.is_on() {
        cells.push(("run", number(past.run), "Number of consecutive foreground frames"));
        cells.push((
            "u",
            number(past.unrest),
            "Flicker: share of recent frames in which the verdict under T changed",
        ));
    }
    ui.separator();
    let across = if ui.available_width() < 270.0 { 2 } else { 3 };
    for pair in cells.chunks(across) {
        let (area, _) =
            ui.allocate_exact_size(Vec2::new(ui.available_width(), SMALL_TEXT + 7.0), Sense::hover());
        let width = (area.width() / across as f32).min(130.0);
        for (column, (name, value, meaning)) in pair.iter().enumerate() {
            let left = area.left() + width * column as f32;
            let place = Rect::from_min_size(Pos2::new(left, area.top()), Vec2::new(width, area.height()));
            let layout = Layout::left_to_right(Align::Center);
            let mut cell = ui.new_child(UiBuilder::new().max_rect(place).layout(layout).id_salt(name));
            cell.spacing_mut().item_spacing.x = 5.0;
            let label = cell.label(style::aside(&cell, name));
            label.on_hover_text(*meaning);
            cell.label(small(value)).on_hover_text(*meaning);
        }
    }
}
