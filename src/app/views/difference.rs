//! The difference of the input from the background.

use eframe::egui::Color32;

use super::{Compose, ComposeStyle, Pane, draw};
use crate::replay::ShownFrame;

fn difference(a: [u8; 3], b: [u8; 3]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

/// Draws the view.
pub(super) fn paint(pane: &Pane<'_>) {
    pane.compose(ComposeStyle::plain(Compose::Difference));
    let ground = |pixel| {
        let value = pixel_difference(pane.shown, pixel).unwrap_or(0);
        Color32::from_gray(value.saturating_mul(2))
    };
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
}

fn pixel_difference(shown: &ShownFrame, (x, y): (u32, u32)) -> Option<u8> {
    Some(difference(shown.frame.pixel(x, y)?, shown.background.pixel(x, y)?))
}

/// The maximum difference over the channels of a pixel.
pub(super) fn value(shown: &ShownFrame, at: (u32, u32)) -> String {
    pixel_difference(shown, at).map_or_else(String::new, |value| value.to_string())
}
