//! How right the tracks are, by the ground truth that was loaded.

use eframe::egui::{Align, Grid, Layout, RichText, Ui};

use super::state::Model;
use super::{slots::Slot, theme};
use crate::truth::summary::TrackScore;

/// What stands over a column, what it means, and its number of a score.
type Column = (&'static str, &'static str, fn(&TrackScore) -> String);

const COLUMNS: [Column; 4] = [
    (
        "MOTA",
        "1 − (missed + made up + switched) / true boxes, where a box is on an object from an IoU of 0.5 on",
        |score| format!("{:.3}", score.strict.mota),
    ),
    ("IDF1", "The harmonic mean of identity precision and recall, from an IoU of 0.5 on", |score| {
        format!("{:.3}", score.strict.idf1)
    }),
    ("switches", "How often an object's identity became another", |score| {
        score.strict.num_switches.to_string()
    }),
    (
        "survive",
        "Identities that are the same before and after two objects met, of those that met",
        |score| format!("{}/{}", score.occlusion.survived, score.occlusion.identities),
    ),
];

/// Shows the scores of the settings in view and of those that are compared, while there is truth.
pub(crate) fn ui(ui: &mut Ui, model: &Model) {
    if model.truth.is_none() {
        return;
    }
    let of_view = model.timeline().and_then(|timeline| timeline.score.as_deref());
    let of_other = model.beside().and_then(|timeline| timeline.score.as_deref());
    let mut rows: Vec<(Option<Slot>, Option<&TrackScore>)> = vec![(None, of_view)];
    if model.slots.other.is_some() {
        let slot = model.slots.in_view;
        // Equal settings have one run.
        let of_other = if model.compared.is_none() { of_view } else { of_other };
        rows = vec![(Some(slot), of_view), (Some(slot.other()), of_other)];
        rows.sort_by_key(|(slot, _)| *slot == Some(Slot::B));
    }
    ui.add_space(theme::SPACE);
    Grid::new("scores").num_columns(COLUMNS.len() + 1).spacing([2.0 * theme::SPACE, 2.0]).show(ui, |ui| {
        ui.label(RichText::new("truth").size(theme::SMALL).weak());
        for (name, meaning, _) in COLUMNS {
            right(ui, RichText::new(name).size(theme::SMALL).weak()).on_hover_text(meaning);
        }
        ui.end_row();
        for (slot, score) in rows {
            ui.label(RichText::new(slot.map_or("score", Slot::name)).size(theme::SMALL));
            for (_, meaning, number) in COLUMNS {
                let text = score.map_or_else(|| "…".to_owned(), number);
                right(ui, RichText::new(text).monospace()).on_hover_text(match score {
                    Some(_) => meaning,
                    None => "Scored when all frames have been analysed",
                });
            }
            ui.end_row();
        }
    });
}

fn right(ui: &mut Ui, text: RichText) -> eframe::egui::Response {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(text)).inner
}
