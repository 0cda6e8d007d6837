//! The regions, with their labels and colours.

use eframe::egui::{Color32, Rect, Stroke, StrokeKind, pos2, vec2};

use super::{Compose, ComposeStyle, Pane, draw};
use crate::app::theme;
use crate::mixture::pixel::luma;
use crate::palette::identity_colour;
use crate::pipeline::Analysis;
use crate::replay::ShownFrame;

const UNASSOCIATED_COLOUR: Color32 = Color32::from_rgb(150, 156, 170);
const GROUP_COLOUR: Color32 = Color32::from_rgb(244, 246, 250);

/// The colour of each label: of its object, of an occlusion group, or of a region without a track.
pub(super) fn colours(analysis: &Analysis) -> Vec<Color32> {
    let most = analysis.regions.iter().map(|region| region.label).max().unwrap_or(0) as usize;
    let mut colours = vec![UNASSOCIATED_COLOUR; most + 1];
    for track in analysis.tracks.iter() {
        let colour = if track.group.len() > 1 { GROUP_COLOUR } else { theme::rgb(identity_colour(track.id)) };
        for &label in &track.regions {
            if let Some(of_label) = colours.get_mut(label as usize) {
                *of_label = colour;
            }
        }
    }
    colours
}

/// Draws the view.
pub(super) fn paint(pane: &Pane<'_>) {
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

/// The label of a pixel.
pub(super) fn value(shown: &ShownFrame, (x, y): (u32, u32)) -> String {
    match shown.analysis.labels.at(x, y) {
        None => String::new(),
        Some(0) => "-".to_owned(),
        Some(label) => format!("#{label}"),
    }
}
