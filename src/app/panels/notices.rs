//! Bars over the views: a failure of the analysis, and the hint for the bundled sample.

use eframe::egui::{Align, Button, Frame, Label, Layout, Margin, Panel, RichText, Ui};
use egui_material_icons::icons as m;

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::videos::Origin;
use crate::app::theme;
use crate::replay::{Phase, Start};

/// Draws the bars.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    failure(ui, model, commands);
    hint(ui, model, commands);
}

/// A bar over the views after the analysis has failed while a frame was in view.
fn failure(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(Phase::Failed(why)) = model.worker.state.as_ref().map(|state| &state.phase) else { return };
    let colours = theme::colours(ui.visuals());
    // Nothing is drawn below the bar, so its colour is opaque.
    let fill = colours.panel.blend(colours.bad.gamma_multiply(0.18));
    let strip = Frame::new().fill(fill).inner_margin(Margin::symmetric(10, 6));
    Panel::top("stopped").frame(strip).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(m::ICON_ERROR.rich_text().size(theme::ICON_SIZE).color(colours.bad));
            ui.label(why);
            if let Some(name) = &model.videos.opened
                && ui.button("Open again").clicked()
            {
                commands.push(Command::Open(name.clone(), Start::First));
            }
        });
    });
}

/// A hint over the views of the bundled sample on what to try first, until it is dismissed.
fn hint(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    if !model.panels.hint || model.videos.origin != Origin::Sample {
        return;
    }
    let colours = theme::colours(ui.visuals());
    let strip = Frame::new().fill(colours.panel).inner_margin(Margin::symmetric(10, 3));
    Panel::top("hint").frame(strip).show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.label(m::ICON_LIGHTBULB.rich_text().size(theme::ICON_SIZE).color(colours.accent));
            let text = "Two people cross. Step with the arrow keys; the panel on the right explains the \
             pixel under the cross. Click any pixel to inspect it.";
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let close = Button::new(m::ICON_CLOSE.rich_text().size(14.0)).frame_when_inactive(false);
                let close = ui.add(close).accessible_name("Hide hint");
                if close.on_hover_text("Do not show again").clicked() {
                    commands.push(Command::HideHint);
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    ui.add(Label::new(RichText::new(text).color(colours.weak)).wrap());
                });
            });
        });
    });
}
