//! A per-pixel quantity as a colour: of the mixture, or the frames since foreground.

use eframe::egui::{
    Align2, Color32, FontId, Mesh, Painter, Pos2, Rangef, Rect, Shape, Stroke, StrokeKind, pos2, vec2,
};

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use super::ramp::{COUNT_COLOURS, ColourScale, INFINITE_COLOUR, RAMP_COLOURS, ramp};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::mixture::Quantity;
use crate::replay::ShownFrame;
use crate::settings::{BackgroundModel, Settings};

/// The message for a live source, which delivers each frame only once, so that a map may be unavailable.
const NO_PREVIOUS_FRAMES: &str = "Previous frames are not available.";

/// Number of frames since foreground from which the colour is constant.
const MAX_FRAMES_AGO: f32 = 1000.0;

/// The quantity's name in menus.
pub(crate) const fn name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Sigma => "σ of component 1",
        Quantity::Weight => "w of component 1",
        Quantity::Used => "Components in use",
        Quantity::BackgroundCount => "B",
        Quantity::Matched => "Matched rank",
        Quantity::SinceForeground => "Frames since foreground",
    }
}

/// The symbol before a value.
pub(super) const fn symbol(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Sigma => "σ",
        Quantity::Weight => "w",
        Quantity::Used => "used",
        Quantity::BackgroundCount => "B",
        Quantity::Matched => "match",
        Quantity::SinceForeground => "since",
    }
}

/// The caption of the legend: symbol and unit.
const fn caption(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Sigma => "σ₁, levels",
        Quantity::Weight => "w₁",
        Quantity::Used => "in use",
        Quantity::BackgroundCount => "B",
        Quantity::Matched => "match",
        Quantity::SinceForeground => "frames ago",
    }
}

/// The colour scale. It depends on the settings but not on the frame, to avoid flicker during playback.
fn scale(quantity: Quantity, settings: &Settings) -> ColourScale {
    match quantity {
        Quantity::Sigma => {
            let low = settings.min_sigma;
            ColourScale::Log { offset: 0.0, low, high: (4.0 * settings.initial_sigma).max(2.0 * low) }
        }
        Quantity::Weight => ColourScale::Linear { low: 0.0, high: 1.0 },
        // Recent foreground is brightest.
        Quantity::SinceForeground => ColourScale::Log { offset: 1.0, low: MAX_FRAMES_AGO, high: 0.0 },
        Quantity::Used | Quantity::BackgroundCount | Quantity::Matched => ColourScale::Steps,
    }
}

/// A value as text.
fn number(quantity: Quantity, value: f32) -> String {
    match quantity {
        Quantity::Sigma => format!("{value:.2}"),
        Quantity::Weight => format!("{value:.3}"),
        Quantity::Matched if value == 0.0 => "none".into(),
        Quantity::SinceForeground if value.is_infinite() => "never".into(),
        _ => format!("{value:.0}"),
    }
}

/// The map of a quantity.
pub(super) struct MapContent;

impl ViewContent for MapContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Map.layers()
    }

    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        let scale = scale(pane.shown.map.as_ref()?.quantity, &pane.shown.settings);
        Some(ComposeStyle { scale: scale.values(), ..ComposeStyle::plain(Compose::Map) })
    }

    fn paint(&self, pane: &Pane<'_>) {
        let Some((map, style)) = pane.shown.map.as_ref().zip(self.compose_style(pane)) else {
            let other = pane.shown.settings.background_model != BackgroundModel::Mixture;
            if other && pane.model.display.quantity.is_of_mixture() {
                draw::message(pane.painter, &pane.canvas, draw::NO_MIXTURE, pane.colours.weak);
            } else if pane.model.worker.is_live() {
                draw::message(pane.painter, &pane.canvas, NO_PREVIOUS_FRAMES, pane.colours.weak);
            }
            return;
        };
        let scale = scale(map.quantity, &pane.shown.settings);
        pane.compose(style);
        let number =
            |at| at_pixel(pane.shown, at).map_or_else(String::new, |value| number(map.quantity, value));
        let ground = |at| scale.colour(at_pixel(pane.shown, at).unwrap_or(0.0));
        draw::values(pane.painter, &pane.canvas, number, ground);
        legend(pane.painter, pane.canvas.rect, map.quantity, scale);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        let quantity = shown.map.as_ref().map(|map| map.quantity);
        let value = quantity.zip(at_pixel(shown, at));
        value.map_or_else(String::new, |(of, value)| format!("{}={}", symbol(of), number(of, value)))
    }
}

fn at_pixel(shown: &ShownFrame, (x, y): (u32, u32)) -> Option<f32> {
    let index = shown.frame.size.index(x, y)?;
    shown.map.as_ref()?.values.get(index).copied()
}

/// The colour of the legend's text.
const LEGEND_INK: Color32 = Color32::from_rgb(236, 240, 246);
/// Minimum and maximum length of the ramp in the legend, in points.
const RAMP_LENGTH_RANGE_PT: Rangef = Rangef { min: 60.0, max: 132.0 };
/// Height of a line of the legend.
const LEGEND_LINE_HEIGHT_PT: f32 = 14.0;
/// Distance of the legend's content from its edge, and of the legend from the view's edge.
const LEGEND_MARGIN_PT: f32 = 6.0;
/// Minimum width of a view for the caption; the title bar shows the name, too.
const MIN_CAPTION_WIDTH_PT: f32 = 290.0;
/// Minimum distance of two numbers under the ramp.
const MIN_NUMBER_SPACING_PT: f32 = 22.0;

/// The legend on a dark plate in the lower left corner, if the view has space for it.
fn legend(painter: &Painter, view: Rect, quantity: Quantity, scale: ColourScale) {
    let font = FontId::proportional(theme::SMALL_TEXT);
    let word = if view.width() < MIN_CAPTION_WIDTH_PT { "" } else { caption(quantity) };
    let caption = painter.layout_no_wrap(word.to_owned(), font, LEGEND_INK);
    let before = if word.is_empty() { 0.0 } else { caption.size().x + 10.0 };
    let swatches = swatches(quantity);
    let beside = swatches.iter().map(|(_, word)| swatch_width(word)).sum::<f32>();
    let steps = scale == ColourScale::Steps;
    let space = view.width() - 24.0 - 2.0 * LEGEND_MARGIN_PT - before - beside;
    let bar = if steps { 0.0 } else { RAMP_LENGTH_RANGE_PT.clamp(space - 18.0) };
    let (ramp, lines) = if steps { (0.0, 1.0) } else { (bar + 18.0, 2.0) };
    let size = vec2(
        before + ramp + beside + 2.0 * LEGEND_MARGIN_PT,
        lines * LEGEND_LINE_HEIGHT_PT + 2.0 * LEGEND_MARGIN_PT - 4.0,
    );
    let place = Rect::from_min_size(view.left_bottom() + vec2(8.0, -8.0 - size.y), size);
    if !view.contains_rect(place.expand(4.0)) {
        return;
    }
    painter.rect_filled(place, 3.0, Color32::from_black_alpha(200));
    let corner = place.min + vec2(LEGEND_MARGIN_PT, LEGEND_MARGIN_PT - 2.0);
    painter.galley(
        pos2(corner.x, corner.y + (LEGEND_LINE_HEIGHT_PT - caption.size().y) / 2.0),
        caption,
        LEGEND_INK,
    );
    let mut x = corner.x + before;
    if !steps {
        let bar = Rect::from_min_size(pos2(x + 6.0, corner.y + 3.0), vec2(bar, 8.0));
        ramp_bar(painter, bar);
        let mut free = f32::NEG_INFINITY;
        for tick in ticks(quantity, scale) {
            let at = bar.left() + scale.share(tick).unwrap_or(0.0) * bar.width();
            if at >= free {
                free = at + MIN_NUMBER_SPACING_PT;
                painter.vline(at, bar.bottom()..=bar.bottom() + 3.0, (1.0, LEGEND_INK));
                text(painter, pos2(at, bar.bottom() + 9.0), Align2::CENTER_CENTER, &format!("{tick}"));
            }
        }
        x = bar.right() + 12.0;
    }
    for (colour, word) in swatches {
        let middle = corner.y + LEGEND_LINE_HEIGHT_PT / 2.0;
        let swatch = Rect::from_min_size(pos2(x, middle - 5.0), vec2(10.0, 10.0));
        let rim = Stroke::new(1.0, Color32::from_white_alpha(90));
        painter.rect(swatch, 2.0, colour, rim, StrokeKind::Inside);
        text(painter, pos2(x + 14.0, middle), Align2::LEFT_CENTER, &word);
        x += swatch_width(&word);
    }
}

fn swatch_width(word: &str) -> f32 {
    20.0 + 6.0 * word.len() as f32
}

fn text(painter: &Painter, at: Pos2, anchor: Align2, text: &str) {
    painter.text(at, anchor, text, FontId::proportional(theme::SMALL_TEXT - 1.0), LEGEND_INK);
}

/// Swatches beside the ramp, or in its place.
fn swatches(quantity: Quantity) -> Vec<(Color32, String)> {
    let step = |count: usize| {
        let more = if count + 1 == COUNT_COLOURS.len() { "+" } else { "" };
        (COUNT_COLOURS[count], format!("{count}{more}"))
    };
    let counts = (1..COUNT_COLOURS.len()).map(step);
    match quantity {
        Quantity::Used | Quantity::BackgroundCount => counts.collect(),
        Quantity::Matched => counts.chain([(COUNT_COLOURS[0], "none".to_owned())]).collect(),
        Quantity::SinceForeground => vec![(INFINITE_COLOUR, "never".to_owned())],
        Quantity::Sigma | Quantity::Weight => Vec::new(),
    }
}

/// The values labelled under the ramp.
fn ticks(quantity: Quantity, scale: ColourScale) -> Vec<f32> {
    match (quantity, scale) {
        (Quantity::SinceForeground, _) => vec![1000.0, 100.0, 10.0, 0.0],
        (Quantity::Weight, _) => vec![0.0, 0.5, 1.0],
        (_, ColourScale::Log { low, high, .. }) => {
            let decades = [0.1, 1.0, 10.0, 100.0].into_iter();
            let round = decades.flat_map(|decade| [1.0, 2.0, 3.0, 5.0].map(|digit| digit * decade));
            let mut ticks = vec![low];
            for tick in round.filter(|tick| (low..=high).contains(tick)) {
                let shares = ticks.last().and_then(|last| scale.share(tick).zip(scale.share(*last)));
                if shares.is_some_and(|(share, before)| share - before > 0.15) {
                    ticks.push(tick);
                }
            }
            ticks
        }
        _ => Vec::new(),
    }
}

fn ramp_bar(painter: &Painter, bar: Rect) {
    let mut mesh = Mesh::default();
    let columns = bar.width().max(2.0) as usize;
    for column in 0..columns {
        let at = |column: usize| bar.left() + bar.width() * column as f32 / columns as f32;
        let colour = ramp(column * (RAMP_COLOURS - 1) / (columns - 1));
        let place = Rect::from_x_y_ranges(at(column)..=at(column + 1), bar.y_range());
        mesh.add_colored_rect(place, colour);
    }
    painter.add(Shape::mesh(mesh));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_has_a_legend_with_colours_and_values() {
        let settings = Settings::default();
        for quantity in Quantity::ALL {
            let scale = scale(quantity, &settings);
            let ticks = ticks(quantity, scale);
            assert!(ticks.len() > 2 || swatches(quantity).len() > 4, "{quantity:?}");
            let shares: Vec<_> = ticks.iter().filter_map(|&tick| scale.share(tick)).collect();
            assert_eq!(shares.len(), ticks.len());
            assert!(
                shares.is_sorted() && shares.windows(2).all(|pair| pair[1] - pair[0] > 0.1),
                "{shares:?}"
            );
        }
        assert_eq!(number(Quantity::Matched, 0.0), "none");
        assert_eq!(number(Quantity::SinceForeground, f32::INFINITY), "never");
        assert_eq!(number(Quantity::Sigma, 5.3125), "5.31");
    }
}
