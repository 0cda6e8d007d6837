//! The background model: the mean of component 1, or of the background components.

use std::sync::Arc;

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::frame::Frame;
use crate::replay::ShownFrame;

/// The selected kind of background.
pub(super) struct BackgroundContent;

impl ViewContent for BackgroundContent {
    fn layers(&self, background: BackgroundDisplay) -> &'static [ViewLayer] {
        composition(background).layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        Some(ComposeStyle::plain(composition(in_view(pane))))
    }

    fn paint(&self, pane: &Pane<'_>) {
        let shown = pane.shown;
        let kind = in_view(pane);
        let Some(frame) = picture(shown, kind) else {
            draw::message(pane.painter, &pane.canvas, draw::NO_MIXTURE, pane.colours.weak);
            return;
        };
        pane.compose(ComposeStyle::plain(composition(kind)));
        let ground = |(x, y)| theme::rgb(frame.pixel(x, y).unwrap_or_default());
        draw::values(pane.painter, &pane.canvas, |at| value(shown, kind, at), ground);
        // Of MOG2 and KNN not every frame's image is stored.
        if frame.number != shown.frame.number {
            draw::note(pane.painter, &pane.canvas, format!("Background of frame {}", frame.number));
        }
    }

    fn value(&self, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, model.display.background, at)
    }
}

/// The composition of a kind of background.
const fn composition(kind: BackgroundDisplay) -> Compose {
    match kind {
        BackgroundDisplay::Mean => Compose::Mean,
        BackgroundDisplay::MultiMode => Compose::Modes,
    }
}

/// The selected kind. Until its layer is uploaded, the previous kind, so that the view is never empty.
fn in_view(pane: &Pane<'_>) -> BackgroundDisplay {
    let chosen = pane.model.display.background;
    let is_uploaded =
        |kind: &BackgroundDisplay| composition(*kind).layers().iter().all(|&layer| pane.set.has(layer));
    let is_published = composition(chosen).layers().iter().all(|layer| layer.is_in(pane.shown));
    let other =
        if is_uploaded(&chosen) { None } else { BackgroundDisplay::ALL.into_iter().find(is_uploaded) };
    other.filter(|_| is_published).unwrap_or(chosen)
}

/// The picture of a kind; no model but the mixture has one of several modes.
fn picture(shown: &ShownFrame, kind: BackgroundDisplay) -> Option<&Arc<Frame>> {
    match kind {
        BackgroundDisplay::Mean => Some(&shown.background),
        BackgroundDisplay::MultiMode => shown.multi_mode.as_ref(),
    }
}

/// Red, green and blue of a pixel, with the frame where it is another one's.
pub(super) fn value(shown: &ShownFrame, kind: BackgroundDisplay, (x, y): (u32, u32)) -> String {
    let Some((frame, [r, g, b])) = picture(shown, kind).and_then(|frame| Some((frame, frame.pixel(x, y)?)))
    else {
        return String::new();
    };
    let number = frame.number;
    if number == shown.frame.number { format!("{r} {g} {b}") } else { format!("{r} {g} {b}, frame {number}") }
}
