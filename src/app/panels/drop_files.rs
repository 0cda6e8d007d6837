//! Opening by dropping a file or folder on the window.

use std::path::Path;

use eframe::egui::{Align2, Color32, Context, FontId, Id, LayerId, Order, Stroke, StrokeKind};

use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::theme;
use crate::replay::Start;
use crate::truth::TruthSource;

/// Shows a hint while files are dragged over the window, and opens dropped files. Dropped ground truth is loaded for
/// the open video.
pub(crate) fn ui(ctx: &Context, model: &Model, commands: &mut Vec<Command>) {
    let (hovered, dropped) = ctx.input(|input| {
        let path = input.raw.dropped_files.first().map(|file| file.path().to_string_lossy().into_owned());
        (!input.raw.hovered_files.is_empty(), path)
    });
    if let Some(path) = dropped.filter(|path| !path.is_empty()) {
        if model.worker.shown().is_some() && is_truth(Path::new(&path)) {
            commands.push(Command::ReadTruth(path.into()));
        } else {
            commands.push(Command::Open(path, Start::First));
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

/// Whether a path is ground truth rather than a video.
fn is_truth(path: &Path) -> bool {
    let of_boxes = ["txt", "csv"].map(|ending| path.extension().is_some_and(|other| other == ending));
    if path.is_dir() { TruthSource::of(path).is_ok() } else { of_boxes.contains(&true) }
}
