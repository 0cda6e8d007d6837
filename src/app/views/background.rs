//! The background model: the mean of component 1, the mean of the background components, or their number.

use eframe::egui::{Align2, Color32, FontId, Rect, pos2, vec2};

use super::{Background, Look, Pane, draw};
use crate::app::theme;
use crate::replay::Shown;

const NO_MIXTURE: &str = "This background model has no mixture";

/// The colour of B: dark for one component, brighter and warmer for more.
pub(super) const COUNTS: [Color32; 5] = [
    Color32::from_rgb(0, 0, 0),
    Color32::from_rgb(38, 50, 72),
    Color32::from_rgb(70, 140, 200),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(213, 94, 0),
];

fn count_colour(count: u8) -> Color32 {
    COUNTS[usize::from(count).min(COUNTS.len() - 1)]
}

/// Paints it.
pub(super) fn paint(pane: &Pane<'_>) {
    let shown = pane.shown;
    let kind = in_view(pane);
    let picture = match kind {
        Background::Mean => Some(&shown.background),
        Background::MultiMode => shown.multi_mode.as_ref(),
        Background::Count => {
            paint_counts(pane);
            return;
        }
    };
    let Some(frame) = picture else {
        draw::message(pane.painter, &pane.canvas, NO_MIXTURE, pane.colours.weak);
        return;
    };
    pane.compose(Look::plain(kind.compose()));
    let ground = |(x, y)| theme::rgb(frame.pixel(x, y).unwrap_or_default());
    draw::values(pane.painter, &pane.canvas, |at| value(shown, kind, at), ground);
}

/// The kind that is chosen; until its layer is on the card, the one before it, so that the view is never empty.
fn in_view(pane: &Pane<'_>) -> Background {
    let chosen = pane.model.background;
    let is_there = |kind: &Background| kind.compose().layers().iter().all(|&layer| pane.set.has(layer));
    let is_on_its_way = chosen.compose().layers().iter().all(|layer| layer.is_in(pane.shown));
    let other = if is_there(&chosen) { None } else { Background::ALL.into_iter().find(is_there) };
    other.filter(|_| is_on_its_way).unwrap_or(chosen)
}

fn paint_counts(pane: &Pane<'_>) {
    let shown = pane.shown;
    let Some(counts) = &shown.background_count else {
        draw::message(pane.painter, &pane.canvas, NO_MIXTURE, pane.colours.weak);
        return;
    };
    let size = shown.frame.size;
    pane.compose(Look::plain(Background::Count.compose()));
    let count = |(x, y)| size.index(x, y).and_then(|index| counts.get(index)).copied().unwrap_or(0);
    let text = |at| value(shown, Background::Count, at);
    draw::values(pane.painter, &pane.canvas, text, |at| count_colour(count(at)));
    legend(pane);
}

fn legend(pane: &Pane<'_>) {
    let corner = pane.canvas.rect.left_bottom() + vec2(8.0, -8.0);
    let ground = Rect::from_min_max(corner - vec2(4.0, 20.0), corner + vec2(22.0 + 4.0 * 34.0, 4.0));
    pane.painter.rect_filled(ground, 3.0, Color32::from_black_alpha(190));
    let font = FontId::proportional(theme::SMALL);
    let middle = corner.y - 8.0;
    pane.painter.text(pos2(corner.x, middle), Align2::LEFT_CENTER, "B", font.clone(), Color32::WHITE);
    for (step, count) in (1_u8..=4).enumerate() {
        let left = corner.x + 18.0 + step as f32 * 34.0;
        let swatch = Rect::from_min_size(pos2(left, middle - 5.0), vec2(10.0, 10.0));
        pane.painter.rect_filled(swatch, 2.0, count_colour(count));
        let text = if count == 4 { "4+".to_owned() } else { count.to_string() };
        pane.painter.text(pos2(left + 14.0, middle), Align2::LEFT_CENTER, text, font.clone(), Color32::WHITE);
    }
}

/// Red, green and blue, or B.
pub(super) fn value(shown: &Shown, kind: Background, (x, y): (u32, u32)) -> String {
    let colour = match kind {
        Background::Mean => shown.background.pixel(x, y),
        Background::MultiMode => shown.multi_mode.as_ref().and_then(|frame| frame.pixel(x, y)),
        Background::Count => {
            let index = shown.frame.size.index(x, y);
            let count =
                shown.background_count.as_ref().zip(index).and_then(|(counts, index)| counts.get(index));
            return count.map_or_else(String::new, |count| format!("B={count}"));
        }
    };
    colour.map_or_else(String::new, |[r, g, b]| format!("{r} {g} {b}"))
}
