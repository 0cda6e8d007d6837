//! The mask of external results: compared with ours, and its decisions against the ground truth.

use super::agreement::{self, MaskPair};
use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::mask_errors;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::view::BackgroundDisplay;
use crate::replay::ShownFrame;
use crate::truth::masks::Label;

/// Our mask and the external one: the colours of A and B, as the other comparison has them.
const MASKS: MaskPair =
    MaskPair { colours: [AbSlot::A.colour(), AbSlot::B.colour()], names: ["ours only", "external only"] };

/// Our mask and the external one over a dark input.
pub(super) struct ExternalAgreementContent;

impl ViewContent for ExternalAgreementContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::ExternalAgreement.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        pane.shown.external.as_ref().map(|_| MASKS.compose_style(Compose::ExternalAgreement))
    }

    fn paint(&self, pane: &Pane<'_>) {
        if !has_mask(pane) {
            return;
        }
        pane.compose(MASKS.compose_style(Compose::ExternalAgreement));
        let is_in = |at| in_masks(pane.shown, at);
        agreement::paint(
            pane,
            &MASKS,
            is_in,
            |at| agreement_value(pane.shown, at),
            pane.set.external_agreement,
        );
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        agreement_value(shown, at)
    }
}

/// The decisions of the external mask over a dark input.
pub(super) struct ExternalErrorsContent;

impl ViewContent for ExternalErrorsContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::ExternalErrors.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        let both = pane.shown.truth.as_ref().zip(pane.shown.external.as_ref());
        both.map(|_| mask_errors::compose_style(Compose::ExternalErrors))
    }

    fn paint(&self, pane: &Pane<'_>) {
        if !has_mask(pane) {
            return;
        }
        let is_found = |at| is_external(pane.shown, at);
        mask_errors::paint(pane, Compose::ExternalErrors, is_found, pane.set.external_decisions);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        mask_errors::value(shown, is_external(shown, at), at)
    }
}

/// Whether there is an external mask of the frame. Where there is none, draws a message that says why.
fn has_mask(pane: &Pane<'_>) -> bool {
    if pane.shown.external.is_none() {
        let masks = pane.model.external.as_ref().and_then(|loaded| loaded.results.masks.as_ref());
        let why = if masks.is_some() {
            "No external mask for this frame."
        } else {
            "No external masks.\nFile, External results loads a folder of masks\nor the output folder of a \
             run with masks."
        };
        draw::message(pane.painter, &pane.canvas, why, pane.colours.weak);
    }
    pane.shown.external.is_some()
}

fn is_external(shown: &ShownFrame, (x, y): (u32, u32)) -> bool {
    shown.external.as_ref().and_then(|mask| mask.at(x, y)) == Some(Label::Foreground)
}

/// Whether a pixel is foreground in our mask and in the external one.
fn in_masks(shown: &ShownFrame, at: (u32, u32)) -> [bool; 2] {
    [shown.analysis.mask.is_foreground(at.0, at.1), is_external(shown, at)]
}

/// The values of our mask and of the external one, each 0 or 255.
fn agreement_value(shown: &ShownFrame, at: (u32, u32)) -> String {
    if shown.external.is_none() {
        return String::new();
    }
    agreement::levels(in_masks(shown, at))
}
