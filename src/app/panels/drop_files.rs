//! Opening by dropping a file or folder on the window: a video, ground truth, or the results of a sweep.

use std::path::Path;

use eframe::egui::{Align2, Color32, Context, FontId, Id, LayerId, Order, Stroke, StrokeKind};

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::opened_sweep::TABLE_NAME;
use crate::app::theme;
use crate::replay::Start;
use crate::source::{SceneFolder, name_of, path_of};
use crate::truth::TruthSource;

/// Shows a hint while files are dragged over the window, and opens dropped files and folders. Dropped ground truth is
/// loaded for the open video.
pub(crate) fn ui(ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
    let (hovered, dropped) = ctx.input(|input| {
        let path = input.raw.dropped_files.first().map(|file| file.path().to_owned());
        (!input.raw.hovered_files.is_empty(), path)
    });
    if let Some(path) = dropped.filter(|path| !path.as_os_str().is_empty()) {
        if is_sweep(&path) {
            commands.push(Command::ReadSweep(path));
        } else if model.worker.shown().is_some() && is_truth_for(&path, model) {
            commands.push(Command::ReadTruth(path));
        } else {
            commands.push(Command::Open(name_of(path), Start::First));
        }
    }
    if hovered {
        let rect = ctx.content_rect();
        let painter = ctx.layer_painter(LayerId::new(Order::Foreground, Id::unique("drop")));
        let accent = theme::colours(&ctx.global_style().visuals).accent;
        painter.rect_filled(rect, 0.0, Color32::from_black_alpha(225));
        painter.rect_stroke(rect.shrink(16.0), 10.0, Stroke::new(3.0, accent), StrokeKind::Inside);
        painter.text(
            rect.center(),
            Align2::CENTER_CENTER,
            "Drop to open",
            FontId::proportional(26.0),
            Color32::WHITE,
        );
    }
}

/// Whether a path is a sweep rather than a video or ground truth: its table, or a folder that has one.
fn is_sweep(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == TABLE_NAME) || path.join(TABLE_NAME).is_file()
}

/// Whether a path is ground truth for the open video rather than a video. The folder of a sequence is both: it is opened,
/// unless the open video is in it.
fn is_truth_for(path: &Path, model: &Model) -> bool {
    if path.is_dir() {
        let is_opened = || model.videos.opened.as_ref().is_some_and(|name| path_of(name).starts_with(path));
        return TruthSource::of(path).is_ok() && (is_opened() || SceneFolder::at(path).is_none());
    }
    let ending = path.extension().unwrap_or_default();
    ["txt", "csv", "xml", "json", "zip"].iter().any(|other| ending.eq_ignore_ascii_case(other))
}
