//! The content in the middle while there is no frame: no open video, opening, failure.

use std::time::Duration;

use eframe::egui::{Align, Button, Layout, RichText, Spinner, Ui, vec2};
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::icons::Icon;
use crate::app::model::Model;
use crate::app::model::videos::file_name;
use crate::app::theme;
use crate::replay::{Phase, Start};

/// The duration after which an opening counts as slow: the source may not respond.
const SLOW_OPENING: Duration = Duration::from_secs(3);

/// Draws the content.
pub(crate) fn ui(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let colours = theme::colours(ui.visuals());
    let rect = ui.available_rect_before_wrap();
    ui.painter().rect_filled(rect, 0.0, colours.canvas);
    // On a large screen ordinary text would be too small.
    let scale = (rect.height() / 1000.0).clamp(1.0, 1.8);
    for font in ui.style_mut().text_styles.values_mut() {
        font.size *= scale;
    }
    ui.add_space((rect.height() * 0.5 - 130.0 * scale).max(12.0));
    ui.with_layout(Layout::top_down(Align::Center), |ui| {
        ui.set_max_width((rect.width() - 40.0).clamp(0.0, 560.0 * scale));
        match model.worker.state.as_ref().map(|state| &state.phase) {
            Some(Phase::Failed(why)) => {
                ui.label(m::ICON_ERROR.rich_text().size(44.0 * scale).color(colours.bad));
                ui.add_space(2.0 * theme::SPACE);
                ui.label(RichText::new("Cannot open").size(20.0 * scale).strong());
                ui.add_space(theme::SPACE);
                ui.label(why);
                ui.add_space(5.0 * theme::SPACE);
                choices(ui, scale, commands);
            }
            Some(_) => opening(ui, model, scale, commands),
            None => {
                ui.label(m::ICON_FRAME_INSPECT.rich_text().size(44.0 * scale).color(colours.accent));
                ui.add_space(2.0 * theme::SPACE);
                ui.label(RichText::new("Open a video").size(20.0 * scale).strong());
                ui.add_space(theme::SPACE);
                ui.label("Drop a video or a folder of images on this window, or choose one below.");
                ui.add_space(5.0 * theme::SPACE);
                choices(ui, scale, commands);
                recent(ui, model, commands);
            }
        }
    });
}

/// The progress of opening a video, with a button that cancels it.
fn opening(ui: &mut Ui, model: &Model, scale: f32, commands: &mut Vec<Command>) {
    let colours = theme::colours(ui.visuals());
    ui.add(Spinner::new().size(36.0 * scale).color(colours.accent));
    ui.add_space(3.0 * theme::SPACE);
    let name = model.videos.opened.as_deref().unwrap_or_default();
    ui.label(RichText::new("Opening").size(20.0 * scale).strong());
    ui.label(file_name(name)).on_hover_text(name);
    ui.add_space(theme::SPACE);
    let busy = model.worker.state.as_ref().and_then(|state| state.busy.as_ref());
    if let Some(busy) = busy {
        let total = busy.total.filter(|&total| total > 0);
        if let Some(total) = total {
            let share = busy.done as f32 / total as f32;
            let bar = theme::progress(ui, share, ui.available_width().min(260.0 * scale));
            bar.accessible_name(format!("Opening {}", file_name(name)));
            ui.add_space(theme::SPACE);
        }
        let total = total.map_or_else(String::new, |total| format!(" of {total}"));
        ui.weak(format!("{}: {}{total}", busy.what, busy.done));
    }
    // The spinner repaints every frame, and with it the seconds.
    let waited = model.worker.opened_at.map(|at| at.elapsed()).unwrap_or_default();
    if waited >= SLOW_OPENING {
        // Without any progress it is unknown what it waits for.
        let cause = if busy.is_some() { "" } else { "; the camera, drive or network may not be responding" };
        ui.weak(format!("{} s elapsed{cause}", waited.as_secs()));
    }
    ui.add_space(4.0 * theme::SPACE);
    if ui.button("Cancel").on_hover_text("Cancel opening").clicked() {
        commands.push(Command::Act(Action::CloseVideo));
    }
}

/// The list of recent videos.
fn recent(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    if model.videos.recent.is_empty() {
        return;
    }
    ui.add_space(5.0 * theme::SPACE);
    ui.weak("Recent");
    for name in model.videos.recent.iter().take(5) {
        if ui.link(file_name(name)).on_hover_text(name).clicked() {
            commands.push(Command::Open(name.clone(), Start::First));
        }
    }
}

fn choices(ui: &mut Ui, scale: f32, commands: &mut Vec<Command>) {
    let colours = theme::colours(ui.visuals());
    for (action, icon, text) in [
        (Action::OpenVideo, m::ICON_VIDEO_FILE, "Open video…"),
        (Action::OpenFolder, m::ICON_FOLDER_OPEN, "Open folder of images…"),
        (Action::OpenSample, m::ICON_MOVIE, "Open sample"),
    ] {
        let main = action == Action::OpenVideo;
        if choice(ui, scale, icon, text, main.then_some((colours.accent, colours.on_accent))) {
            commands.push(Command::Act(action));
        }
    }
}

fn choice(
    ui: &mut Ui,
    scale: f32,
    icon: Icon,
    text: &str,
    main: Option<(eframe::egui::Color32, eframe::egui::Color32)>,
) -> bool {
    let (mut icon, mut label) = (icon.rich_text().size(18.0 * scale), RichText::new(text));
    if let Some((_, ink)) = main {
        (icon, label) = (icon.color(ink), label.color(ink));
    }
    let mut button = Button::new((icon, label)).min_size(scale * vec2(220.0, 32.0));
    if let Some((fill, _)) = main {
        button = button.fill(fill);
    }
    ui.add(button).accessible_name(text).clicked()
}
