//! The views of the compared settings.

use eframe::egui::Color32;

use super::compose_style::{Compose, ComposeStyle};
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use super::{background, draw, foreground, input, tracks};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::replay::ShownFrame;

/// The background model under the compared settings.
pub(super) struct ComparedBackgroundContent;

impl ViewContent for ComparedBackgroundContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::ComparedMean.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(ComposeStyle::plain(Compose::ComparedMean))
    }

    fn paint(&self, pane: &Pane<'_>) {
        let Some(compared) = compared(pane) else { return };
        pane.compose(ComposeStyle::plain(Compose::ComparedMean));
        let value = |at| background::value(compared, BackgroundDisplay::Mean, at);
        let ground = |(x, y)| theme::rgb(compared.background.pixel(x, y).unwrap_or_default());
        draw::values(pane.painter, &pane.canvas, value, ground);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        let value = |shown: &_| background::value(shown, BackgroundDisplay::Mean, at);
        shown.compared.as_deref().map_or_else(String::new, value)
    }
}

/// The foreground mask under the compared settings.
pub(super) struct ComparedForegroundContent;

impl ViewContent for ComparedForegroundContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::ComparedMask.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(ComposeStyle::plain(Compose::ComparedMask))
    }

    fn paint(&self, pane: &Pane<'_>) {
        let Some(compared) = compared(pane) else { return };
        pane.compose(ComposeStyle::plain(Compose::ComparedMask));
        let mask = &compared.analysis.mask;
        let ground = |(x, y)| if mask.is_foreground(x, y) { Color32::WHITE } else { Color32::BLACK };
        draw::values(pane.painter, &pane.canvas, |at| foreground::value(compared, at), ground);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        shown.compared.as_deref().map_or_else(String::new, |shown| foreground::value(shown, at))
    }
}

/// Objects, occlusion groups, occlusions and events under the compared settings.
pub(super) struct ComparedTracksContent;

impl ViewContent for ComparedTracksContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Input.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(tracks::compose_style())
    }

    fn paint(&self, pane: &Pane<'_>) {
        if let Some(shown) = compared(pane) {
            tracks::paint(&Pane { shown, ..*pane });
        }
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        shown.compared.as_deref().map_or_else(String::new, |shown| input::value(shown, at))
    }
}

/// The frame under the compared settings. Where there is none, draws a message that says why.
pub(super) fn compared<'a>(pane: &Pane<'a>) -> Option<&'a ShownFrame> {
    let compared = pane.shown.compared.as_deref();
    if compared.is_none() {
        let slots = &pane.model.edits.ab_settings;
        let why = if slots.other.is_none() {
            "Only one set of settings.\nPress B to add a second set and compare.".to_owned()
        } else {
            format!("Not analysed yet under {}.", slots.in_view.other().name())
        };
        draw::message(pane.painter, &pane.canvas, &why, pane.colours.weak);
    }
    compared
}
