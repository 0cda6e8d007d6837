//! Bars over the views: a failure of the analysis, the question for the frame rate, an offer of ground truth, and the hint
//! for the bundled sample.

use std::sync::Arc;

use eframe::egui::{Align, Button, Frame, Label, Layout, Margin, Panel, RichText, Ui};
use egui_material_icons::icons as m;

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::videos::Origin;
use crate::app::theme;
use crate::replay::{Phase, Start};
use crate::source::{FpsFrom, SourceInfo};

/// Draws the bars.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    failure(ui, model, commands);
    rate(ui, model, commands);
    offer_truth(ui, model, commands);
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

/// Frame rates of common cameras and data sets.
const COMMON_RATES: [u16; 7] = [7, 10, 14, 15, 25, 30, 50];

/// A question over the views of a source that states no frame rate, until one is chosen or typed.
fn rate(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let info = model.worker.state.as_ref().and_then(|state| state.info.as_ref());
    let is_unknown = |info: &&Arc<SourceInfo>| info.fps_from == FpsFrom::Assumed && !info.live;
    let Some(info) = info.filter(is_unknown) else { return };
    let colours = theme::colours(ui.visuals());
    let strip = Frame::new().fill(colours.panel).inner_margin(Margin::symmetric(10, 4));
    Panel::top("rate").frame(strip).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(m::ICON_SPEED.rich_text().size(theme::ICON_SIZE).color(colours.accent));
            let text = format!("No frame rate is given, {} fps are assumed. Choose it:", info.source_fps());
            ui.label(text).on_hover_text("Times and settings in seconds depend on it");
            for rate in COMMON_RATES {
                if ui.button(rate.to_string()).clicked() {
                    commands.push(Command::Rate(rate.into()));
                }
            }
            ui.weak("or type it above");
        });
    });
}

/// An offer to load the ground truth beside the video, until it is loaded or dismissed.
fn offer_truth(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(path) = model.offered_truth.as_ref().filter(|_| model.truth.is_none()) else { return };
    let colours = theme::colours(ui.visuals());
    let strip = Frame::new().fill(colours.panel).inner_margin(Margin::symmetric(10, 3));
    Panel::top("offered truth").frame(strip).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(m::ICON_LIGHTBULB.rich_text().size(theme::ICON_SIZE).color(colours.accent));
            ui.label(RichText::new("This sequence has ground truth.").color(colours.weak));
            let load = ui.button("Load its ground truth");
            if load.on_hover_text(path.display().to_string()).clicked() {
                commands.push(Command::ReadTruth(path.clone()));
            }
            if ui.button("Not now").clicked() {
                commands.push(Command::DismissTruth);
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
