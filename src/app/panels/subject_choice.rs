//! The choice between pixel and object for the panel on the right.

use eframe::egui::Ui;

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::selection::Subject;

/// Draws the choice, once an object was chosen.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(id) = model.selection.object else { return };
    ui.horizontal(|ui| {
        let pixel = model.selection.pixel.map(|at| model.worker.source_pixel(at));
        let pixel = pixel.map_or_else(|| "Pixel".to_owned(), |(x, y)| format!("Pixel {x}, {y}"));
        for (subject, word) in [(Subject::Pixel, pixel), (Subject::Object, format!("Object {id}"))] {
            let name = format!("Explain {}", word.to_lowercase());
            let response =
                ui.selectable_label(model.selection.subject == subject, word).accessible_name(name);
            if response.on_hover_text("Select what this panel explains").clicked() {
                commands.push(Command::ShowSubject(subject));
            }
        }
    });
    ui.separator();
}
