//! The foreground mask.

use eframe::egui::Color32;

use super::{Pane, View, draw};
use crate::replay::Shown;

/// Paints it.
pub(super) fn paint(pane: &mut Pane<'_>) {
    let mask = &pane.shown.analysis.mask;
    let texture = pane.textures.get(
        pane.ctx,
        (View::Foreground, 0),
        [mask.clone(), mask.clone()],
        mask.size,
        |index| Color32::from_gray(mask.data[index]),
    );
    draw::image(pane.painter, &pane.canvas, texture, Color32::WHITE);
    let ground = |(x, y)| if mask.is_foreground(x, y) { Color32::WHITE } else { Color32::BLACK };
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
}

/// 0 or 255.
pub(super) fn value(shown: &Shown, (x, y): (u32, u32)) -> String {
    let mask = &shown.analysis.mask;
    mask.size.index(x, y).map_or_else(String::new, |index| mask.data[index].to_string())
}
