//! The upper part of the inspector: the chosen pixel and its verdict, or why there is none.

use eframe::egui::{self, RichText, Ui};
use egui_material_icons::icons;

use super::action::InspectorAction;
use super::chosen_pixel::ChosenPixel;
use super::style;
use crate::app::theme;
use crate::explain::pixel::verdict::Verdict;
use crate::settings::Space;

/// Maximum width of an explanation, in points: longer lines are hard to read.
const MAX_TEXT_WIDTH: f32 = 300.0;

/// A title with an explanation, where there is nothing to inspect.
pub(super) fn message(ui: &mut Ui, title: &str, text: &str) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.3).clamp(16.0, 160.0));
        ui.label(RichText::new(title).size(15.0).strong());
        ui.add_space(4.0);
        // A text wider than the panel would move the views over its left side.
        ui.set_max_width(ui.available_width().min(MAX_TEXT_WIDTH));
        ui.label(RichText::new(text).color(style::muted(ui.visuals())));
    });
}

/// Minimum width for the time beside the frame number, in points.
const MIN_SECONDS_WIDTH: f32 = 104.0;

/// Value and position of the chosen pixel, with the pin button. Returns the requested action.
pub(super) fn header(ui: &mut Ui, chosen: &ChosenPixel<'_>, pinned: Option<u8>) -> Option<InspectorAction> {
    let mut pin = None;
    let state = chosen.state;
    let [r, g, b] = state.rgb;
    ui.horizontal(|ui| {
        style::swatch(ui, state.rgb, 34.0, &format!("colour {r}, {g}, {b}"));
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let (x, y) = chosen.history.source_pixel();
            ui.horizontal(|ui| {
                ui.label(RichText::new(format!("Pixel {x}, {y}")).size(15.0).strong());
                pin = pin_button(ui, pinned);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if ui.available_width() > MIN_SECONDS_WIDTH {
                        ui.label(style::aside(ui, &format!("{} s", chosen.times.text(chosen.index))));
                    }
                    ui.label(format!("frame {}", state.number));
                });
            });
            ui.label(match chosen.history.parameters.space {
                Space::Rgb => format!("R {r}   G {g}   B {b}"),
                Space::Gray => format!("luma {}   (R {r}  G {g}  B {b})", state.value[0]),
            });
        });
    });
    pin
}

fn pin_button(ui: &mut Ui, pinned: Option<u8>) -> Option<InspectorAction> {
    let icon = icons::ICON_KEEP.rich_text().size(16.0);
    let icon = pinned.map_or_else(|| icon.clone(), |number| icon.clone().color(theme::pin_colour(number)));
    let (name, text) = match pinned {
        Some(_) => ("Unpin pixel", "Unpin this pixel (D)"),
        None => ("Pin pixel", "Pin this pixel to compare it under Pixels (D)"),
    };
    let button =
        egui::Button::new(icon).frame_when_inactive(pinned.is_some()).min_size(egui::vec2(20.0, 18.0));
    let response = ui.add(button).accessible_name(name).on_hover_text(text);
    response.clicked().then_some(InspectorAction::Pin)
}

/// The verdict in a sentence, with the name of the slot where there are two.
pub(super) fn verdict_ui(ui: &mut Ui, words: &Verdict, mask: bool, name: Option<&str>) {
    let colour = style::verdict_colour(ui.visuals(), words.foreground);
    let frame = egui::Frame::new()
        .fill(colour.gamma_multiply(0.14))
        .inner_margin(egui::Margin { left: 10, right: 6, top: 5, bottom: 5 })
        .corner_radius(3);
    let response = frame
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.spacing_mut().item_spacing.y = 2.0;
            let headline = match name {
                Some(name) => format!("{name}: {}", words.headline),
                None => words.headline.clone(),
            };
            ui.label(RichText::new(headline).color(ui.visuals().strong_text_color()));
            if mask != words.foreground {
                let made = if mask { "foreground" } else { "background" };
                ui.label(style::small(&format!("After post-processing: {made}.")));
            }
        })
        .response;
    let mut rule = response.rect;
    rule.set_width(3.0);
    ui.painter().rect_filled(rule, 1.0, colour);
}
