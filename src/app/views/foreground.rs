//! The foreground mask.

use eframe::egui::Color32;

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::replay::ShownFrame;

/// The mask.
pub(super) struct ForegroundContent;

impl ViewContent for ForegroundContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Mask.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(ComposeStyle::plain(Compose::Mask))
    }

    fn paint(&self, pane: &Pane<'_>) {
        pane.compose(ComposeStyle::plain(Compose::Mask));
        let mask = &pane.shown.analysis.mask;
        let ground = |(x, y)| if mask.is_foreground(x, y) { Color32::WHITE } else { Color32::BLACK };
        draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, at)
    }
}

/// The mask value of a pixel, 0 or 255.
pub(super) fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    let mask = &shown.analysis.mask;
    mask.size.index(x, y).map_or_else(String::new, |index| mask.data[index].to_string())
}
