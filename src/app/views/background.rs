//! The background model: the mean of component 1, or of the background components.

use super::{ComposeStyle, NO_MIXTURE, Pane, draw};
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::replay::ShownFrame;

/// The composition of the view.
pub(super) fn compose_style(pane: &Pane<'_>) -> ComposeStyle {
    ComposeStyle::plain(in_view(pane).compose())
}

/// Draws the view.
pub(super) fn paint(pane: &Pane<'_>) {
    let shown = pane.shown;
    let kind = in_view(pane);
    let picture = match kind {
        BackgroundDisplay::Mean => Some(&shown.background),
        BackgroundDisplay::MultiMode => shown.multi_mode.as_ref(),
    };
    let Some(frame) = picture else {
        draw::message(pane.painter, &pane.canvas, NO_MIXTURE, pane.colours.weak);
        return;
    };
    pane.compose(ComposeStyle::plain(kind.compose()));
    let ground = |(x, y)| theme::rgb(frame.pixel(x, y).unwrap_or_default());
    draw::values(pane.painter, &pane.canvas, |at| value(shown, kind, at), ground);
}

/// The selected kind. Until its layer is uploaded, the previous kind, so that the view is never empty.
fn in_view(pane: &Pane<'_>) -> BackgroundDisplay {
    let chosen = pane.model.display.background;
    let is_uploaded =
        |kind: &BackgroundDisplay| kind.compose().layers().iter().all(|&layer| pane.set.has(layer));
    let is_published = chosen.compose().layers().iter().all(|layer| layer.is_in(pane.shown));
    let other =
        if is_uploaded(&chosen) { None } else { BackgroundDisplay::ALL.into_iter().find(is_uploaded) };
    other.filter(|_| is_published).unwrap_or(chosen)
}

/// Red, green and blue of a pixel.
pub(super) fn value(shown: &ShownFrame, kind: BackgroundDisplay, (x, y): (u32, u32)) -> String {
    let colour = match kind {
        BackgroundDisplay::Mean => shown.background.pixel(x, y),
        BackgroundDisplay::MultiMode => shown.multi_mode.as_ref().and_then(|frame| frame.pixel(x, y)),
    };
    colour.map_or_else(String::new, |[r, g, b]| format!("{r} {g} {b}"))
}
