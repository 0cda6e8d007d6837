//! The views of the compared settings.

use eframe::egui::{Align2, Color32, FontId};

use super::{Compose, ComposeStyle, Pane, agreement, draw, foreground, tracks};
use crate::app::model::view::{BackgroundDisplay, View};
use crate::app::theme;

/// Draws a view, or a message where it has nothing to show.
pub(super) fn paint(pane: &Pane<'_>) {
    let Some(compared) = &pane.shown.compared else {
        let in_view = pane.model.edits.ab_settings.in_view;
        let other = in_view.other().name();
        let why = if pane.model.edits.ab_settings.other.is_none() {
            "Only one set of settings.\nPress B to add a second set and compare.".to_owned()
        } else {
            format!("Not analysed yet under {other}.")
        };
        let font = FontId::proportional(theme::BODY_TEXT);
        pane.painter.text(pane.canvas.rect.center(), Align2::CENTER_CENTER, why, font, pane.colours.weak);
        return;
    };
    match pane.view {
        View::ComparedBackground => {
            pane.compose(ComposeStyle::plain(Compose::ComparedMean));
            let value = |at| super::background::value(compared, BackgroundDisplay::Mean, at);
            let ground = |(x, y)| theme::rgb(compared.background.pixel(x, y).unwrap_or_default());
            draw::values(pane.painter, &pane.canvas, value, ground);
        }
        View::ComparedForeground => {
            pane.compose(ComposeStyle::plain(Compose::ComparedMask));
            let mask = &compared.analysis.mask;
            let ground = |(x, y)| if mask.is_foreground(x, y) { Color32::WHITE } else { Color32::BLACK };
            draw::values(pane.painter, &pane.canvas, |at| foreground::value(compared, at), ground);
        }
        View::ComparedTracks => tracks::paint(&Pane { shown: compared, ..*pane }),
        _ => agreement::paint(pane, compared),
    }
}
