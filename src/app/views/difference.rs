//! The difference of the input from the background.

use eframe::egui::Color32;

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::replay::ShownFrame;

fn difference(a: [u8; 3], b: [u8; 3]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

/// The difference as a gray level.
pub(super) struct DifferenceContent;

impl ViewContent for DifferenceContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Difference.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(ComposeStyle::plain(Compose::Difference))
    }

    fn paint(&self, pane: &Pane<'_>) {
        pane.compose(ComposeStyle::plain(Compose::Difference));
        let ground = |pixel| {
            let value = pixel_difference(pane.shown, pixel).unwrap_or(0);
            Color32::from_gray(value.saturating_mul(2))
        };
        draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, at)
    }
}

fn pixel_difference(shown: &ShownFrame, (x, y): (u32, u32)) -> Option<u8> {
    Some(difference(shown.frame.pixel(x, y)?, shown.background.pixel(x, y)?))
}

/// The maximum difference over the channels of a pixel.
fn value(shown: &ShownFrame, at: (u32, u32)) -> String {
    pixel_difference(shown, at).map_or_else(String::new, |value| value.to_string())
}
