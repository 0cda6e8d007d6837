//! The scores of tracks and masks against the loaded ground truth.

use eframe::egui::{Align, FontId, Grid, Label, Layout, Response, RichText, Ui, vec2};

use crate::app::model::Model;
use crate::app::model::ab_settings::AbSlot;
use crate::app::theme;
use crate::replay::Timeline;
use crate::truth::hota::Hota;
use crate::truth::mask_score::MaskScore;
use crate::truth::summary::{Score, TrackScore};

/// A column.
struct Column<S> {
    heading: &'static str,
    meaning: &'static str,
    /// The number of characters for which there is space in a narrow panel.
    characters: usize,
    /// The text of a score.
    text: fn(&S) -> String,
    /// What a score has besides, a line of its tooltip.
    detail: Option<fn(&S) -> String>,
}

const TRACK_COLUMNS: [Column<TrackScore>; 5] = [
    Column {
        heading: "HOTA",
        meaning: "Higher order tracking accuracy: the mean over IoU 0.05, 0.1 … 0.95 of √(DetA·AssA)",
        characters: 4,
        text: |score| share(score.hota.hota),
        detail: Some(|TrackScore { hota: Hota { deta, assa, loca, .. }, .. }| {
            format!("Detection DetA {deta:.3}, association AssA {assa:.3}, localisation LocA {loca:.3}")
        }),
    },
    Column {
        heading: "MOTA",
        meaning: "1 − (FN + FP + IDSW)/GT, boxes matched at IoU ≥ 0.5",
        characters: 5,
        text: |score| share(score.strict.mota),
        detail: None,
    },
    Column {
        heading: "IDF1",
        meaning: "Harmonic mean of identity precision and recall, at IoU ≥ 0.5",
        characters: 4,
        text: |score| share(score.strict.idf1),
        detail: None,
    },
    Column {
        heading: "IDSW",
        meaning: "ID switches: changes of the identity assigned to an object",
        characters: 4,
        text: |score| score.strict.num_switches.to_string(),
        detail: None,
    },
    Column {
        heading: "kept",
        meaning: "IDs kept through occlusion: identities equal before and after occlusion, of all occluded",
        characters: 5,
        text: |score| format!("{}/{}", score.occlusion.survived, score.occlusion.identities),
        detail: None,
    },
];

const MASK_COLUMNS: [Column<MaskScore>; 4] = [
    Column {
        heading: "F",
        meaning: "2·precision·recall/(precision + recall) of all evaluated pixels, after post-processing",
        characters: 4,
        text: |score| share(score.f_measure),
        detail: Some(|score| format!("Of {} frames with masks", score.frames)),
    },
    Column {
        heading: "precision",
        meaning: "TP/(TP + FP) of all evaluated pixels",
        characters: 4,
        text: |score| share(score.precision),
        detail: None,
    },
    Column {
        heading: "recall",
        meaning: "TP/(TP + FN) of all evaluated pixels",
        characters: 4,
        text: |score| share(score.recall),
        detail: None,
    },
    Column {
        heading: "PWC",
        meaning: "Percentage of wrong classifications: 100·(FP + FN)/evaluated pixels",
        characters: 5,
        text: |score| format!("{:.2}", score.pwc),
        detail: None,
    },
];

/// Minimum width of the row names, in points.
const MIN_NAME_WIDTH: f32 = 34.0;
/// Space between two columns, in points.
const COLUMN_SPACING: f32 = 4.0;

/// A row: its name, what the name stands for, and its score if it is known.
struct Row<S> {
    name: String,
    meaning: String,
    score: Option<S>,
}

/// Draws the scores of the settings in view, of the compared settings and of external results, while there is ground truth.
pub(crate) fn ui(ui: &mut Ui, model: &Model) {
    let Some(truth) = &model.truth else { return };
    let external = model.external.as_ref().map(|loaded| &loaded.results);
    let name = external.map(|results| results.name.as_str());
    if truth.boxes.is_some() {
        let has_boxes = external.is_some_and(|results| results.boxes.is_some());
        let rows = rows(model, name.filter(|_| has_boxes), |score| score.tracks.clone());
        grid(ui, "tracks", &TRACK_COLUMNS, rows);
    }
    if model.has_true_masks() {
        let has_masks = external.is_some_and(|results| results.masks.is_some());
        let rows = rows(model, name.filter(|_| has_masks), |score| score.masks);
        grid(ui, "masks", &MASK_COLUMNS, rows);
    }
}

/// The rows of our settings, and that of external results of this name. `part` is the part of a score that they show.
fn rows<S>(model: &Model, external: Option<&str>, part: impl Fn(&Score) -> Option<S>) -> Vec<Row<S>> {
    let worker = &model.worker;
    let row = |name: &str, meaning: &str, timeline: Option<&Timeline>| Row {
        name: name.to_owned(),
        meaning: meaning.to_owned(),
        score: timeline.and_then(|timeline| part(timeline.score.as_ref()?)),
    };
    let mut rows = Vec::new();
    match &model.edits.ab_settings.other {
        None => {
            let name = if external.is_some() { "ours" } else { "score" };
            rows.push(row(name, "Under the present settings", worker.timeline()));
        }
        Some(other) => {
            let in_view = model.edits.ab_settings.in_view;
            // Equal settings share one run.
            let is_shared = *other == model.edits.settings;
            for slot in AbSlot::ALL {
                let timeline =
                    if slot == in_view || is_shared { worker.timeline() } else { worker.compared_timeline() };
                rows.push(row(slot.name(), &format!("Under settings {}", slot.name()), timeline));
            }
        }
    }
    if let Some(name) = external {
        let score = worker.state.as_ref().and_then(|state| part(state.external_score.as_deref()?));
        rows.push(Row { name: name.to_owned(), meaning: format!("External results: {name}"), score });
    }
    rows
}

/// A share of at most 1, in four characters where it is not negative: `.612`.
fn share(value: f64) -> String {
    let text = format!("{value:.3}");
    match (text.strip_prefix("0."), text.strip_prefix("-0.")) {
        (Some(digits), _) => format!(".{digits}"),
        (_, Some(digits)) => format!("-.{digits}"),
        _ if value > 0.0 => format!("{value:.2}"),
        _ => format!("{value:.1}"),
    }
}

fn grid<S>(ui: &mut Ui, name: &str, columns: &[Column<S>], rows: Vec<Row<S>>) {
    ui.add_space(theme::SPACE);
    let is_named = rows.iter().any(|row| row.name.len() > "score".len());
    let (name_width, widths) = column_widths(ui, columns, is_named);
    let number = FontId::monospace(theme::SMALL_TEXT);
    Grid::new(("scores", name))
        .num_columns(columns.len() + 1)
        .spacing(vec2(COLUMN_SPACING, 2.0))
        .min_col_width(0.0)
        .show(ui, |ui| {
            left(ui, name_width, RichText::new(name).size(theme::SMALL_TEXT).weak());
            for (column, width) in columns.iter().zip(&widths) {
                let heading = RichText::new(column.heading).size(theme::SMALL_TEXT).weak();
                right(ui, *width, heading).on_hover_text(column.meaning);
            }
            ui.end_row();
            for Row { name, meaning, score } in rows {
                left(ui, name_width, RichText::new(name).size(theme::SMALL_TEXT)).on_hover_text(meaning);
                for (column, width) in columns.iter().zip(&widths) {
                    let text = score.as_ref().map_or_else(|| "…".to_owned(), column.text);
                    let response = right(ui, *width, RichText::new(text).font(number.clone()));
                    response.on_hover_ui(|ui| match &score {
                        Some(score) => {
                            ui.label(column.meaning);
                            if let Some(detail) = column.detail {
                                ui.label(detail(score));
                            }
                        }
                        None => {
                            ui.label("Computed when all frames are analysed");
                        }
                    });
                }
                ui.end_row();
            }
        });
}

/// The width of the row names, and that of each column: what their texts need, and the rest of the panel in equal parts.
/// Half of the rest goes to the names where a row `is_named` by a file.
fn column_widths<S>(ui: &Ui, columns: &[Column<S>], is_named: bool) -> (f32, Vec<f32>) {
    let width = |text: String, font: FontId| {
        ui.painter().layout_no_wrap(text, font, ui.visuals().text_color()).size().x
    };
    let least = columns.iter().map(|column| {
        let numbers = width("0".repeat(column.characters), FontId::monospace(theme::SMALL_TEXT));
        // A point more, as sizes are rounded.
        1.0 + width(column.heading.to_owned(), FontId::proportional(theme::SMALL_TEXT)).max(numbers)
    });
    let least: Vec<f32> = least.collect();
    let count = columns.len() as f32;
    let rest = ui.available_width() - MIN_NAME_WIDTH - least.iter().sum::<f32>() - count * COLUMN_SPACING;
    let rest = rest.max(0.0);
    let of_name = if is_named { rest / 2.0 } else { 0.0 };
    let more = ((rest - of_name) / count).floor();
    (MIN_NAME_WIDTH + of_name.floor(), least.into_iter().map(|width| width + more).collect())
}

/// A text at the left of a cell, cut to its width.
fn left(ui: &mut Ui, width: f32, text: RichText) -> Response {
    cell(ui, width, Layout::left_to_right(Align::Center), text)
}

/// A text at the right of a cell.
fn right(ui: &mut Ui, width: f32, text: RichText) -> Response {
    cell(ui, width, Layout::right_to_left(Align::Center), text)
}

fn cell(ui: &mut Ui, width: f32, layout: Layout, text: RichText) -> Response {
    ui.allocate_ui_with_layout(vec2(width, ui.spacing().interact_size.y), layout, |ui| {
        ui.set_min_width(width);
        ui.add(Label::new(text).truncate().show_tooltip_when_elided(false))
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_no_zero_before_the_point() {
        let expected = [
            (0.6124, ".612"),
            (1.0, "1.00"),
            (0.9999, "1.00"),
            (0.0, ".000"),
            (-0.25, "-.250"),
            (-12.345, "-12.3"),
        ];
        for (value, text) in expected {
            assert_eq!(share(value), text);
        }
    }
}
