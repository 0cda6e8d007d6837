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
use crate::palette::TRUE_POSITIVE;
use crate::regions::Rgb;
use crate::replay::ShownFrame;

/// The colour of pixels that are foreground in both masks.
const BOTH_COLOUR: [u8; 3] = TRUE_POSITIVE;

/// Two masks to compare.
pub(super) struct MaskPair {
    /// The colours of pixels that are foreground in one of them only.
    pub(super) colours: [Rgb; 2],
    /// The names of these colours in the legend.
    pub(super) names: [&'static str; 2],
}

impl MaskPair {
    /// The composition of the masks, of which the first is ours.
    pub(super) fn compose_style(&self, what: Compose) -> ComposeStyle {
        ComposeStyle::in_two_colours(what, self.colours[0], self.colours[1])
    }
}

/// The masks under A and B.
const SLOTS: MaskPair =
    MaskPair { colours: [AbSlot::A.colour(), AbSlot::B.colour()], names: ["A only", "B only"] };

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
        if compared(pane).is_none() {
            return;
        }
        let in_view = pane.model.edits.ab_settings.in_view;
        pane.compose(compose_style(in_view));
        let is_in = |at| of_pixel(pane.shown, in_view, at).unwrap_or_default();
        let agreement = pane.set.agreement.map(|agreement| match in_view {
            AbSlot::A => agreement,
            AbSlot::B => {
                MaskAgreement { first: agreement.second, second: agreement.first, both: agreement.both }
            }
        });
        paint(pane, &SLOTS, is_in, |at| value(pane.shown, in_view, at), agreement);
    }

    fn value(&self, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, model.edits.ab_settings.in_view, at)
    }
}

/// The composition, with the colours of the slots.
fn compose_style(in_view: AbSlot) -> ComposeStyle {
    ComposeStyle::in_two_colours(Compose::Agreement, in_view.colour(), in_view.other().colour())
}

/// Draws the values of two masks where pixels are large enough, and the legend of their colours with the number of pixels
/// of each.
pub(super) fn paint(
    pane: &Pane<'_>,
    masks: &MaskPair,
    is_in: impl Fn((u32, u32)) -> [bool; 2],
    value: impl Fn((u32, u32)) -> String,
    agreement: Option<MaskAgreement>,
) {
    let ground = |at| match is_in(at) {
        [true, true] => theme::rgb(BOTH_COLOUR),
        [true, false] => theme::rgb(masks.colours[0]),
        [false, true] => theme::rgb(masks.colours[1]),
        [false, false] => Color32::BLACK,
    };
    draw::values(pane.painter, &pane.canvas, value, ground);
    let Some(MaskAgreement { first, second, both }) = agreement else { return };
    let ([of_first, of_second], [one, other]) = (masks.colours, masks.names);
    let rows = [(of_first, one, first), (of_second, other, second), (BOTH_COLOUR, "both", both)];
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
    of_pixel(shown, in_view, at).map_or_else(String::new, levels)
}

/// The values of two masks.
pub(super) fn levels(is_in: [bool; 2]) -> String {
    let [a, b] = is_in.map(|foreground| if foreground { Mask::FOREGROUND } else { Mask::BACKGROUND });
    format!("{a} {b}")
}
