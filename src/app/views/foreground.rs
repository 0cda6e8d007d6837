//! The foreground mask.

use eframe::egui::Color32;

use super::{Compose, ComposeStyle, Pane, draw};
use crate::replay::ShownFrame;

/// Draws the view.
pub(super) fn paint(pane: &Pane<'_>) {
    pane.compose(ComposeStyle::plain(Compose::Mask));
    let mask = &pane.shown.analysis.mask;
    let ground = |(x, y)| if mask.is_foreground(x, y) { Color32::WHITE } else { Color32::BLACK };
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
}

/// The mask value of a pixel, 0 or 255.
pub(super) fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    let mask = &shown.analysis.mask;
    mask.size.index(x, y).map_or_else(String::new, |index| mask.data[index].to_string())
}
