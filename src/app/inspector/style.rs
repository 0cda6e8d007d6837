//! Common style of the inspector's plots: colours, text sizes, numbers.

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Color32, CornerRadius, FontId, RichText, Sense, Stroke, StrokeKind, Ui, Vec2, Visuals, WidgetInfo,
};

use crate::app::theme;
pub(super) use crate::app::theme::SMALL_TEXT;
use crate::explain::pixel::scatter_points::{AGES, PointKind};
use crate::palette::{self, component_colour, component_on_light};

pub(super) fn small(text: &str) -> RichText {
    RichText::new(text).size(SMALL_TEXT)
}

pub(super) fn font() -> FontId {
    FontId::proportional(SMALL_TEXT)
}

/// The font of numbers on axes.
pub(super) fn tick_font() -> FontId {
    FontId::proportional(9.5)
}

/// The colour of the component in `slot`.
pub(super) fn component(visuals: &Visuals, slot: u8) -> Color32 {
    let colour = if visuals.dark_mode { component_colour } else { component_on_light };
    theme::rgb(colour(usize::from(slot)))
}

/// The colour of foreground or background.
pub(super) const fn verdict_colour(visuals: &Visuals, foreground: bool) -> Color32 {
    theme::rgb(palette::verdict_colour(foreground, visuals.dark_mode))
}

/// The colour of frames with this foreground ratio. A single foreground frame among a hundred stays visible.
pub(super) fn verdict_share(visuals: &Visuals, share: f32) -> Color32 {
    if share > 0.0 {
        verdict_colour(visuals, true).gamma_multiply(0.45 + 0.55 * share)
    } else {
        verdict_colour(visuals, false).gamma_multiply(0.30)
    }
}

/// The colour of a kind of point.
pub(super) fn point_colour(visuals: &Visuals, kind: PointKind) -> Color32 {
    match kind {
        PointKind::Component { slot, .. } => component(visuals, slot),
        PointKind::Verdict { foreground } => verdict_colour(visuals, foreground),
        PointKind::Age(age) => {
            let share = f32::from(age + 1) / f32::from(AGES);
            visuals.panel_fill.lerp_to_gamma(visuals.strong_text_color(), 0.15 + 0.85 * share)
        }
    }
}

/// The colour of lines and marks that show the data itself.
pub(super) fn ink(visuals: &Visuals) -> Color32 {
    visuals.strong_text_color()
}

/// The colour of captions, ticks and notes.
pub(super) fn muted(visuals: &Visuals) -> Color32 {
    theme::colours(visuals).weak
}

/// A caption or a note.
pub(super) fn aside(ui: &Ui, text: &str) -> RichText {
    small(text).color(muted(ui.visuals()))
}

/// Axis frames and grids.
pub(super) fn faint(visuals: &Visuals) -> Stroke {
    Stroke::new(1.0, visuals.text_color().gamma_multiply(0.22))
}

/// A colour swatch with a thin border, visible on any background.
pub(super) fn swatch(ui: &mut Ui, rgb: [u8; 3], side: f32, name: &str) {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
    let [r, g, b] = rgb;
    ui.painter().rect(
        rect,
        CornerRadius::same(2),
        Color32::from_rgb(r, g, b),
        faint(ui.visuals()),
        StrokeKind::Inside,
    );
}
