//! The scores of tracks and masks against the loaded ground truth.

use eframe::egui::{Align, Grid, Layout, Response, RichText, Ui, vec2};

use crate::app::model::Model;
use crate::app::model::ab_settings::AbSlot;
use crate::app::theme;
use crate::replay::Timeline;
use crate::truth::mask_score::MaskScore;
use crate::truth::summary::TrackScore;

/// A column: its heading, its meaning, and the text of a score in it.
type Column<S> = (&'static str, &'static str, fn(&S) -> String);

const TRACK_COLUMNS: [Column<TrackScore>; 4] = [
    ("MOTA", "1 − (FN + FP + IDSW)/GT, boxes matched at IoU ≥ 0.5", |score| {
        format!("{:.3}", score.strict.mota)
    }),
    ("IDF1", "Harmonic mean of identity precision and recall, at IoU ≥ 0.5", |score| {
        format!("{:.3}", score.strict.idf1)
    }),
    ("IDSW", "ID switches: changes of the identity assigned to an object", |score| {
        score.strict.num_switches.to_string()
    }),
    (
        "IDs kept",
        "IDs kept through occlusion: identities equal before and after occlusion, of all occluded",
        |score| format!("{}/{}", score.occlusion.survived, score.occlusion.identities),
    ),
];

const MASK_COLUMNS: [Column<MaskScore>; 4] = [
    (
        "F",
        "2·precision·recall/(precision + recall) of all evaluated pixels, after post-processing",
        |score| format!("{:.3}", score.f_measure),
    ),
    ("precision", "TP/(TP + FP) of all evaluated pixels", |score| format!("{:.3}", score.precision)),
    ("recall", "TP/(TP + FN) of all evaluated pixels", |score| format!("{:.3}", score.recall)),
    ("PWC", "Percentage of wrong classifications: 100·(FP + FN)/evaluated pixels", |score| {
        format!("{:.2}", score.pwc)
    }),
];

/// Width of the row names, in points.
const NAME_COLUMN_WIDTH: f32 = 36.0;

/// Draws the scores of the settings in view and of the compared settings, while there is ground truth.
pub(crate) fn ui(ui: &mut Ui, model: &Model) {
    let Some(truth) = &model.truth else { return };
    let mut rows = vec![(None, model.worker.timeline())];
    if let Some(other) = &model.edits.ab_settings.other {
        let slot = model.edits.ab_settings.in_view;
        // Equal settings share one run.
        let of_other = if *other == model.edits.settings {
            model.worker.timeline()
        } else {
            model.worker.compared_timeline()
        };
        rows = vec![(Some(slot), model.worker.timeline()), (Some(slot.other()), of_other)];
        rows.sort_by_key(|(slot, _)| *slot == Some(AbSlot::B));
    }
    let score = |timeline: Option<&Timeline>| timeline.and_then(|timeline| timeline.score.clone());
    if truth.boxes.is_some() {
        let rows = rows.iter().map(|&(slot, of)| (slot, score(of).and_then(|score| score.tracks.clone())));
        grid(ui, "tracks", &TRACK_COLUMNS, rows.collect());
    }
    if model.has_true_masks() {
        let rows = rows.iter().map(|&(slot, of)| (slot, score(of).and_then(|score| score.masks)));
        grid(ui, "masks", &MASK_COLUMNS, rows.collect());
    }
}

fn grid<S>(ui: &mut Ui, name: &str, columns: &[Column<S>], rows: Vec<(Option<AbSlot>, Option<S>)>) {
    ui.add_space(theme::SPACE);
    let spacing = vec2(theme::SPACE, 2.0);
    let width = ((ui.available_width() - NAME_COLUMN_WIDTH) / columns.len() as f32 - spacing.x).max(0.0);
    Grid::new(("scores", name))
        .num_columns(columns.len() + 1)
        .spacing(spacing)
        .min_col_width(NAME_COLUMN_WIDTH)
        .show(ui, |ui| {
            ui.label(RichText::new(name).size(theme::SMALL_TEXT).weak());
            for (name, meaning, _) in columns {
                right(ui, width, RichText::new(*name).size(theme::SMALL_TEXT).weak()).on_hover_text(*meaning);
            }
            ui.end_row();
            for (slot, score) in rows {
                ui.label(RichText::new(slot.map_or("score", AbSlot::name)).size(theme::SMALL_TEXT));
                for (_, meaning, number) in columns {
                    let text = score.as_ref().map_or_else(|| "…".to_owned(), number);
                    right(ui, width, RichText::new(text).monospace()).on_hover_text(match score {
                        Some(_) => meaning,
                        None => "Computed when all frames are analysed",
                    });
                }
                ui.end_row();
            }
        });
}

fn right(ui: &mut Ui, width: f32, text: RichText) -> Response {
    let layout = Layout::right_to_left(Align::Center);
    ui.allocate_ui_with_layout(vec2(width, ui.spacing().interact_size.y), layout, |ui| {
        ui.set_min_width(width);
        ui.label(text)
    })
    .inner
}
