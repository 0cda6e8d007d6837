//! The input frame.

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::replay::ShownFrame;

/// The colour of the mask overlay: rare in video, and no identity's colour.
const OVERLAY_COLOUR: [u8; 3] = [255, 45, 149];

/// The input frame, under the mask overlay while it is on.
pub(super) struct InputContent;

impl ViewContent for InputContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        // Includes the mask while the overlay is off, so that switching it on uploads nothing.
        Compose::Masked.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        Some(compose_style(pane))
    }

    fn paint(&self, pane: &Pane<'_>) {
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

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, at)
    }
}

fn compose_style(pane: &Pane<'_>) -> ComposeStyle {
    let overlay = pane.model.display.overlay;
    let opacity = if overlay.on { f32::from(overlay.opacity) / 100.0 } else { 0.0 };
    let [r, g, b] = OVERLAY_COLOUR.map(|channel| f32::from(channel) / 255.0);
    let what = if overlay.on { Compose::Masked } else { Compose::Input };
    ComposeStyle { overlay: [r, g, b, opacity], ..ComposeStyle::plain(what) }
}

/// Red, green and blue of a pixel.
pub(super) fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    shown.frame.pixel(x, y).map_or_else(String::new, |[r, g, b]| format!("{r} {g} {b}"))
}
