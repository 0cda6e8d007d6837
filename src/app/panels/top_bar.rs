//! The menus, made from the table of actions, and information about the open video.

use eframe::egui::{Align, DragValue, Layout, MenuBar, RichText, Ui};

use crate::app::commands::action::Action;
use crate::app::commands::actions::ACTIONS;
use crate::app::commands::command::Command;
use crate::app::commands::entry::{ActionEntry, Menu};
use crate::app::menu_item::menu_item;
use crate::app::model::Model;
use crate::app::model::videos::file_name;
use crate::app::theme;
use crate::replay::Start;
use crate::source::{FPS_RANGE, FpsFrom};

/// Draws the bar.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.name(), |ui| {
                ui.set_min_width(250.0);
                let entries: Vec<_> = ACTIONS.iter().filter(|entry| entry.menu == menu).collect();
                for group in entries.chunk_by(|a, b| a.submenu.is_some() && a.submenu == b.submenu) {
                    group_ui(ui, model, group, commands);
                }
            });
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add_space(theme::SPACE);
            opened(ui, model, commands);
        });
    });
}

/// One action, or a submenu of several.
fn group_ui(ui: &mut Ui, model: &Model, group: &[&'static ActionEntry], commands: &mut Vec<Command>) {
    if group.first().is_some_and(|entry| entry.line_before) {
        ui.separator();
    }
    match group.first().and_then(|entry| entry.submenu) {
        Some(name) => {
            ui.menu_button(name, |ui| {
                ui.set_min_width(220.0);
                for entry in group {
                    menu_item(ui, model, entry, commands);
                }
            });
        }
        None => {
            for entry in group {
                menu_item(ui, model, entry, commands);
                if entry.action == Action::OpenSample {
                    recent(ui, model, commands);
                }
            }
        }
    }
}

/// The submenu of recent videos.
fn recent(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    if model.videos.recent.is_empty() {
        return;
    }
    ui.menu_button("Open recent", |ui| {
        for name in &model.videos.recent {
            if ui.button(file_name(name)).on_hover_text(name).clicked() {
                commands.push(Command::Open(name.clone(), Start::First));
                ui.close();
            }
        }
    });
}

/// The frame rate, with a field to type it where the source does not specify it.
fn rate(ui: &mut Ui, rounded: f32, from: FpsFrom, commands: &mut Vec<Command>) {
    let label = ui.weak(if from == FpsFrom::Assumed { "fps, assumed" } else { "fps" });
    let mut fps = f64::from(rounded);
    let (least, greatest) = FPS_RANGE;
    // Another rate restarts the analysis: it can be typed but not dragged.
    let typed = DragValue::new(&mut fps)
        .range(f64::from(least)..=f64::from(greatest))
        .speed(0.0)
        .max_decimals(2)
        .update_while_editing(false);
    let hover = "Frames per second; settings in seconds depend on it. Click to edit; the video is analysed \
     again.";
    if ui.add(typed).labelled_by(label.id).on_hover_text(hover).changed() {
        commands.push(Command::Rate(fps as f32));
    }
}

/// Name, size, frame rate and number of frames, from right to left.
fn opened(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let Some(name) = &model.videos.opened else { return };
    if let Some(info) = model.worker.state.as_ref().and_then(|state| state.info.as_ref()) {
        let complete = model.worker.timeline().is_some_and(|timeline| timeline.complete);
        let about = if complete { "" } else { "about " };
        let frames = match (model.worker.frames(), info.live) {
            (_, true) => "live".to_owned(),
            (0, _) => "frames unknown".to_owned(),
            (frames, _) => format!("{about}{frames} frames"),
        };
        let rounded = (info.source_fps() * 100.0).round() / 100.0;
        let size = match info.placement() {
            Some(_) => format!("{} of {}", info.size, info.source_size()),
            None => info.size.to_string(),
        };
        let frames = match info.every() {
            1 => frames,
            every => format!("{frames}, 1 of {every}"),
        };
        match info.fps_from {
            FpsFrom::Video | FpsFrom::SeqInfo => {
                ui.weak(format!("·  {size}  ·  {rounded} fps  ·  {frames}"));
            }
            FpsFrom::Given | FpsFrom::Assumed => {
                ui.weak(format!("·  {frames}"));
                rate(ui, rounded, info.fps_from, commands);
                ui.weak(format!("·  {size}  ·"));
            }
        }
    }
    ui.label(RichText::new(file_name(name)).strong()).on_hover_text(name);
}
