//! The regions, with their labels and colours.

use eframe::egui::{Color32, Rect, Stroke, StrokeKind, pos2, vec2};

use super::compose_style::{Compose, ComposeStyle};
use super::draw;
use super::layer::ViewLayer;
use super::pane::{Pane, ViewContent};
use super::region_colours::{UNASSOCIATED_COLOUR, colours};
use crate::app::model::Model;
use crate::app::model::view::BackgroundDisplay;
use crate::app::theme;
use crate::mixture::pixel::luma;
use crate::replay::ShownFrame;

/// The regions over a dark input.
pub(super) struct RegionsContent;

impl ViewContent for RegionsContent {
    fn layers(&self, _: BackgroundDisplay) -> &'static [ViewLayer] {
        Compose::Regions.layers()
    }

    fn compose_style(&self, _: &Pane<'_>) -> Option<ComposeStyle> {
        Some(ComposeStyle::plain(Compose::Regions))
    }

    fn paint(&self, pane: &Pane<'_>) {
        pane.compose(ComposeStyle::plain(Compose::Regions));
        let (frame, analysis) = (&pane.shown.frame, &pane.shown.analysis);
        let colours = colours(analysis);
        let colour_of = |label: u32| colours.get(label as usize).copied().unwrap_or(UNASSOCIATED_COLOUR);
        let ground = |(x, y)| {
            let gray = luma(frame.pixel(x, y).unwrap_or_default());
            match analysis.labels.at(x, y) {
                None | Some(0) => Color32::from_gray(gray / 4),
                Some(label) => {
                    // A fraction of the input's luma keeps the inside of the region recognisable.
                    let light = 0.55 + 0.45 * f32::from(gray) / 255.0;
                    let [r, g, b, _] =
                        colour_of(label).to_array().map(|channel| (f32::from(channel) * light) as u8);
                    Color32::from_rgb(r, g, b)
                }
            }
        };
        for region in analysis.regions.iter() {
            let place = pane.canvas.place(&region.shape.bbox);
            if !pane.canvas.rect.intersects(place) {
                continue;
            }
            let colour = colour_of(region.label);
            pane.painter.rect_stroke(place, 0.0, Stroke::new(1.0, colour), StrokeKind::Outside);
            // The numbers of very small regions would hide the image.
            if place.width().max(place.height()) > 14.0 {
                let number = draw::tag(
                    pane.painter,
                    place.left_top(),
                    &region.label.to_string(),
                    colour,
                    pane.canvas.rect,
                );
                let swatch = Rect::from_min_size(
                    pos2(number.right() + 2.0, number.top()),
                    vec2(number.height(), number.height()),
                );
                pane.painter.rect(
                    swatch,
                    2.0,
                    theme::rgb(region.colour),
                    Stroke::new(1.0, colour),
                    StrokeKind::Inside,
                );
            }
        }
        draw::values(pane.painter, &pane.canvas, |at| value(pane.shown, at), ground);
    }

    fn value(&self, _: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        value(shown, at)
    }
}

/// The label of a pixel.
fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    match shown.analysis.labels.at(x, y) {
        None => String::new(),
        Some(0) => "-".to_owned(),
        Some(label) => format!("#{label}"),
    }
}
