//! True and false decisions of the mask against the ground truth.

use eframe::egui::Color32;

use super::agreement::BOTH_COLOUR;
use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::replay::ShownFrame;
use crate::truth::masks::Label;

/// True positive.
const TRUE_POSITIVE: [u8; 3] = BOTH_COLOUR;
/// False positive.
const FALSE_POSITIVE: [u8; 3] = [232, 92, 28];
/// False negative.
const FALSE_NEGATIVE: [u8; 3] = [86, 180, 233];
/// Ignored; the shader draws it equally dark.
const IGNORED_COLOUR: [u8; 3] = [58, 52, 66];

/// The decisions over a dark input.
pub(super) struct MaskErrorsContent;

impl ViewContent for MaskErrorsContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::MaskErrors.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        pane.shown.truth.as_ref().map(|_| compose_style())
    }

    fn paint(&self, pane: &Pane<'_>) {
        let Some(truth) = &pane.shown.truth else {
            let why = if pane.model.has_true_masks() {
                "No ground-truth mask for this frame."
            } else {
                "No ground-truth masks.\nFile, Load ground truth folder… loads a CDnet folder\nor a scene \
                 written by synth."
            };
            draw::message(pane.painter, &pane.canvas, why, pane.colours.weak);
            return;
        };
        pane.compose(compose_style());
        let mask = &pane.shown.analysis.mask;
        let ground = |(x, y)| match (truth.at(x, y), mask.is_foreground(x, y)) {
            (Some(Label::Foreground), true) => theme::rgb(TRUE_POSITIVE),
            (Some(Label::Foreground), false) => theme::rgb(FALSE_NEGATIVE),
            (Some(Label::Background), true) => theme::rgb(FALSE_POSITIVE),
            (Some(Label::Background), false) => Color32::BLACK,
            (Some(Label::Uncounted) | None, _) => theme::rgb(IGNORED_COLOUR),
        };
        draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
        if let Some(decisions) = pane.set.decisions {
            let uncounted = truth.size().pixels() as u64 - decisions.all();
            let mut rows = vec![
                (TRUE_POSITIVE, format!("TP  {} px", decisions.tp)),
                (FALSE_POSITIVE, format!("FP  {} px", decisions.fp)),
                (FALSE_NEGATIVE, format!("FN  {} px", decisions.fn_)),
            ];
            if uncounted > 0 {
                rows.push((IGNORED_COLOUR, format!("ignored  {uncounted} px")));
            }
            draw::legend(pane.painter, pane.canvas.rect, &rows);
        }
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, at)
    }
}

/// The composition, with the colours of the decisions.
fn compose_style() -> ComposeStyle {
    ComposeStyle::in_two_colours(Compose::MaskErrors, FALSE_POSITIVE, FALSE_NEGATIVE)
}

/// The decision of a pixel: true or false, positive or negative.
fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    let found = shown.analysis.mask.is_foreground(x, y);
    match shown.truth.as_ref().and_then(|truth| truth.at(x, y)) {
        None => "",
        Some(Label::Uncounted) => "ignored",
        Some(Label::Foreground) if found => "true positive",
        Some(Label::Foreground) => "false negative",
        Some(Label::Background) if found => "false positive",
        Some(Label::Background) => "true negative",
    }
    .to_owned()
}
