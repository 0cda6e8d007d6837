//! The frame as it came.

use eframe::egui::{Color32, TextureId};

use super::{Pane, View, draw};
use crate::app::theme;
use crate::replay::Shown;

/// Paints it.
pub(super) fn paint(pane: &mut Pane<'_>) {
    let texture = texture(pane);
    draw::image(pane.painter, &pane.canvas, texture, Color32::WHITE);
    let frame = &pane.shown.frame;
    let ground = |(x, y)| theme::rgb(frame.pixel(x, y).unwrap_or_default());
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
}

/// The frame as a picture, which the tracks view shares.
pub(super) fn texture(pane: &mut Pane<'_>) -> TextureId {
    let frame = &pane.shown.frame;
    pane.textures.get(pane.ctx, (View::Input, 0), [frame.clone(), frame.clone()], frame.size, |index| {
        Color32::from_rgb(frame.rgb[index * 3], frame.rgb[index * 3 + 1], frame.rgb[index * 3 + 2])
    })
}

/// Red, green and blue.
pub(super) fn value(shown: &Shown, (x, y): (u32, u32)) -> String {
    shown.frame.pixel(x, y).map_or_else(String::new, |[r, g, b]| format!("{r} {g} {b}"))
}
