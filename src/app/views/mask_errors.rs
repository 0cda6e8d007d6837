//! True and false decisions of the mask against the ground truth. The shader draws ignored pixels equally dark.

use eframe::egui::Color32;

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::palette::{FALSE_NEGATIVE, FALSE_POSITIVE, IGNORED, TRUE_POSITIVE};
use crate::replay::ShownFrame;
use crate::truth::decisions::Decisions;
use crate::truth::masks::Label;

/// The decisions over a dark input.
pub(super) struct MaskErrorsContent;

impl ViewContent for MaskErrorsContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::MaskErrors.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        pane.shown.truth.as_ref().map(|_| compose_style(Compose::MaskErrors))
    }

    fn paint(&self, pane: &Pane<'_>) {
        let is_found = |at| is_foreground(pane.shown, at);
        paint(pane, Compose::MaskErrors, is_found, pane.set.decisions);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, is_foreground(shown, at), at)
    }
}

fn is_foreground(shown: &ShownFrame, (x, y): (u32, u32)) -> bool {
    shown.analysis.mask.is_foreground(x, y)
}

/// Draws the decisions of the mask in which these pixels are found, or a message where there is no true mask.
pub(super) fn paint(
    pane: &Pane<'_>,
    what: Compose,
    is_found: impl Fn((u32, u32)) -> bool,
    decisions: Option<Decisions>,
) {
    let Some(truth) = &pane.shown.truth else {
        let why = if pane.model.has_true_masks() {
            "No ground-truth mask for this frame."
        } else {
            "No ground-truth masks.\nFile, Load ground truth folder… loads a CDnet folder\nor a scene written by synth."
        };
        draw::message(pane.painter, &pane.canvas, why, pane.colours.weak);
        return;
    };
    pane.compose(compose_style(what));
    let ground = |(x, y)| match (truth.at(x, y), is_found((x, y))) {
        (Some(Label::Foreground), true) => theme::rgb(TRUE_POSITIVE),
        (Some(Label::Foreground), false) => theme::rgb(FALSE_NEGATIVE),
        (Some(Label::Background), true) => theme::rgb(FALSE_POSITIVE),
        (Some(Label::Background), false) => Color32::BLACK,
        (Some(Label::Uncounted) | None, _) => theme::rgb(IGNORED),
    };
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, is_found(at), at), ground);
    if let Some(decisions) = decisions {
        let uncounted = truth.size().pixels() as u64 - decisions.all();
        let mut rows = vec![
            (TRUE_POSITIVE, format!("TP  {} px", decisions.tp)),
            (FALSE_POSITIVE, format!("FP  {} px", decisions.fp)),
            (FALSE_NEGATIVE, format!("FN  {} px", decisions.fn_)),
        ];
        if uncounted > 0 {
            rows.push((IGNORED, format!("ignored  {uncounted} px")));
        }
        draw::legend(pane.painter, pane.canvas.rect, &rows);
    }
}

/// The composition, with the colours of the decisions.
pub(super) fn compose_style(what: Compose) -> ComposeStyle {
    ComposeStyle::in_two_colours(what, FALSE_POSITIVE, FALSE_NEGATIVE)
}

/// The decision on a pixel that is `found` or not: true or false, positive or negative.
pub(super) fn value(shown: &ShownFrame, found: bool, (x, y): (u32, u32)) -> String {
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
