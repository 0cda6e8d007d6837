//! Comparison of two foreground masks: common foreground, and foreground of one mask only.

use eframe::egui::Color32;

use super::compared::compared;
use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::mask_agreement::MaskAgreement;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::frame::Mask;
use crate::replay::ShownFrame;

/// The colour of pixels that are foreground in both masks.
pub(super) const BOTH_COLOUR: [u8; 3] = [228, 232, 238];

/// Both masks over a dark input.
pub(super) struct AgreementContent;

impl ViewContent for AgreementContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Agreement.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        pane.shown.compared.as_ref().map(|_| compose_style(pane.model.edits.ab_settings.in_view))
    }

    fn paint(&self, pane: &Pane<'_>) {
        let Some(compared) = compared(pane) else { return };
        let in_view = pane.model.edits.ab_settings.in_view;
        pane.compose(compose_style(in_view));
        let (first, second) = (&pane.shown.analysis.mask, &compared.analysis.mask);
        let ground = |(x, y)| match (first.is_foreground(x, y), second.is_foreground(x, y)) {
            (true, true) => theme::rgb(BOTH_COLOUR),
            (true, false) => theme::rgb(in_view.colour()),
            (false, true) => theme::rgb(in_view.other().colour()),
            (false, false) => Color32::BLACK,
        };
        draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, in_view, at), ground);
        if let Some(agreement) = pane.set.agreement {
            legend(pane, in_view, agreement);
        }
    }

    fn value(&self, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, model.edits.ab_settings.in_view, at)
    }
}

/// The composition, with the colours of the slots.
fn compose_style(in_view: AbSlot) -> ComposeStyle {
    ComposeStyle::in_two_colours(Compose::Agreement, in_view.colour(), in_view.other().colour())
}

/// The legend of the colours, with the number of pixels of each.
fn legend(pane: &Pane<'_>, in_view: AbSlot, agreement: MaskAgreement) {
    let (a, b) = match in_view {
        AbSlot::A => (agreement.first, agreement.second),
        AbSlot::B => (agreement.second, agreement.first),
    };
    let rows = [
        (AbSlot::A.colour(), "A only", a),
        (AbSlot::B.colour(), "B only", b),
        (BOTH_COLOUR, "both", agreement.both),
    ];
    let rows = rows.map(|(colour, word, count)| (colour, format!("{word}  {count} px")));
    draw::legend(pane.painter, pane.canvas.rect, &rows);
}

/// Whether a pixel is foreground in A and in B; `None` where no settings are compared.
pub(super) fn of_pixel(shown: &ShownFrame, in_view: AbSlot, (x, y): (u32, u32)) -> Option<[bool; 2]> {
    let compared = shown.compared.as_ref()?;
    let [seen, other] = [&shown.analysis, &compared.analysis].map(|of| of.mask.is_foreground(x, y));
    Some(match in_view {
        AbSlot::A => [seen, other],
        AbSlot::B => [other, seen],
    })
}

/// The mask values in A and in B, each 0 or 255.
fn value(shown: &ShownFrame, in_view: AbSlot, at: (u32, u32)) -> String {
    let level = |foreground| if foreground { Mask::FOREGROUND } else { Mask::BACKGROUND };
    let levels = of_pixel(shown, in_view, at).map(|both| both.map(level));
    levels.map_or_else(String::new, |[a, b]| format!("{a} {b}"))
}
