//! Comparison of two foreground masks: common foreground, and foreground of one mask only.

use eframe::egui::Color32;

use super::{Compose, ComposeStyle, Pane, draw};
use crate::app::model::ab_settings::AbSlot;
use crate::app::theme;
use crate::frame::Mask;
use crate::replay::ShownFrame;

/// The colour of pixels that are foreground in both masks.
pub(super) const BOTH_COLOUR: [u8; 3] = [228, 232, 238];

/// Numbers of foreground pixels in two masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Agreement {
    /// In the first mask only.
    pub(crate) first: usize,
    /// In the second mask only.
    pub(crate) second: usize,
    /// In both masks.
    pub(crate) both: usize,
}

impl Agreement {
    /// Counts the pixels of two masks of equal size.
    pub(crate) fn of(first: &Mask, second: &Mask) -> Self {
        let mut counts = Self::default();
        // Chunks small enough for byte sums, which the compiler vectorises.
        for (a, b) in first.data.chunks(128).zip(second.data.chunks(128)) {
            let count = |of: fn(u8, u8) -> u8| {
                a.iter().zip(b).map(|(&a, &b)| of(a, b) & 1).fold(0_u8, u8::wrapping_add)
            };
            counts.first += usize::from(count(|a, b| a & !b));
            counts.second += usize::from(count(|a, b| b & !a));
            counts.both += usize::from(count(|a, b| a & b));
        }
        counts
    }
}

/// The composition of the view.
pub(super) fn compose_style(pane: &Pane<'_>) -> ComposeStyle {
    let in_view = pane.model.edits.ab_settings.in_view;
    let share = |[r, g, b]: [u8; 3]| [r, g, b, 255].map(|channel| f32::from(channel) / 255.0);
    ComposeStyle {
        overlay: share(in_view.colour()),
        other_colour: share(in_view.other().colour()),
        ..ComposeStyle::plain(Compose::Agreement)
    }
}

/// Draws the view.
pub(super) fn paint(pane: &Pane<'_>, compared: &ShownFrame) {
    let in_view = pane.model.edits.ab_settings.in_view;
    pane.compose(compose_style(pane));
    let (first, second) = (&pane.shown.analysis.mask, &compared.analysis.mask);
    let ground = |(x, y)| match (first.is_foreground(x, y), second.is_foreground(x, y)) {
        (true, true) => theme::rgb(BOTH_COLOUR),
        (true, false) => theme::rgb(in_view.colour()),
        (false, true) => theme::rgb(in_view.other().colour()),
        (false, false) => Color32::BLACK,
    };
    draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, in_view, at), ground);
    if let Some(agreement) = pane.set.agreement() {
        legend(pane, in_view, agreement);
    }
}

/// The legend of the colours, with the number of pixels of each.
fn legend(pane: &Pane<'_>, in_view: AbSlot, agreement: Agreement) {
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
pub(super) fn value(shown: &ShownFrame, in_view: AbSlot, at: (u32, u32)) -> String {
    let level = |foreground| if foreground { Mask::FOREGROUND } else { Mask::BACKGROUND };
    let levels = of_pixel(shown, in_view, at).map(|both| both.map(level));
    levels.map_or_else(String::new, |[a, b]| format!("{a} {b}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Size;

    #[test]
    fn every_pixel_counts_once() {
        let size = Size::new(37, 29);
        let mask = |step: usize| Mask {
            size,
            data: (0..size.pixels()).map(|at| if at % step < 2 { 255 } else { 0 }).collect(),
        };
        let (a, b) = (mask(3), mask(5));
        let count = |of: fn(bool, bool) -> bool| {
            (0..size.pixels()).filter(|&at| of(a.data[at] > 0, b.data[at] > 0)).count()
        };
        let expected = Agreement {
            first: count(|a, b| a && !b),
            second: count(|a, b| b && !a),
            both: count(|a, b| a && b),
        };
        assert_eq!(Agreement::of(&a, &b), expected);
        let all = Mask { size, data: vec![255; size.pixels()] };
        assert_eq!(Agreement::of(&all, &all), Agreement { both: size.pixels(), ..Agreement::default() });
    }
}
