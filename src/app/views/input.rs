//! The input frame.

use super::{Compose, ComposeStyle, Pane, draw};
use crate::app::theme;
use crate::replay::ShownFrame;

/// The colour of the mask overlay: rare in video, and no identity's colour.
const OVERLAY_COLOUR: [u8; 3] = [255, 45, 149];

/// The composition of the view.
pub(super) fn compose_style(pane: &Pane<'_>) -> ComposeStyle {
    let overlay = pane.model.display.overlay;
    let opacity = if overlay.on { f32::from(overlay.opacity) / 100.0 } else { 0.0 };
    let [r, g, b] = OVERLAY_COLOUR.map(|channel| f32::from(channel) / 255.0);
    let what = if overlay.on { Compose::Masked } else { Compose::Input };
    ComposeStyle { overlay: [r, g, b, opacity], ..ComposeStyle::plain(what) }
}

/// Draws the view.
pub(super) fn paint(pane: &Pane<'_>) {
    let style = compose_style(pane);
    let opacity = style.overlay[3];
    pane.compose(style);
    let (frame, mask) = (&pane.shown.frame, &pane.shown.analysis.mask);
    let ground = |(x, y)| {
        let under = theme::rgb(frame.pixel(x, y).unwrap_or_default());
        let covered = if mask.is_foreground(x, y) { opacity } else { 0.0 };
        under.lerp_to_gamma(theme::rgb(OVERLAY_COLOUR), covered)
    };
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
}

/// Red, green and blue of a pixel.
pub(super) fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    shown.frame.pixel(x, y).map_or_else(String::new, |[r, g, b]| format!("{r} {g} {b}"))
}
