//! The theme of the window: colours, text sizes and distances.

use eframe::egui::{
    Color32, CornerRadius, FontFamily, FontId, Frame, Margin, Shadow, Stroke, Style, TextStyle, Theme,
    Visuals,
    style::{ScrollStyle, Selection},
    vec2,
};

use crate::palette::identity_colour;
use crate::regions::roi::Purpose;

/// Size of secondary text, in points: units, hints, axis labels.
pub const SMALL_TEXT: f32 = 11.0;
/// Size of ordinary text, in points.
pub const BODY_TEXT: f32 = 13.0;
/// Size of numbers in tables and pixels, in points.
pub const MONO_TEXT: f32 = 12.0;
/// Size of a panel's heading, in points.
pub const HEADING_TEXT: f32 = 15.0;
/// Size of an icon in a line of text, in points.
pub const ICON_SIZE: f32 = 16.0;
/// The base distance, in points; all others are its multiples.
pub const SPACE: f32 = 4.0;
/// Height of a row in lists, and of a view's title bar, in points.
pub const ROW_HEIGHT: f32 = 24.0;

/// The colours that egui does not define, for dark and light.
#[derive(Clone, Copy, Debug)]
pub struct Colours {
    /// The accent: playhead, selection, active controls.
    pub accent: Color32,
    /// Text on top of the accent.
    pub on_accent: Color32,
    /// Background of images and plots.
    pub canvas: Color32,
    /// Background of panels.
    pub panel: Color32,
    /// Separators.
    pub line: Color32,
    /// Ordinary text.
    pub text: Color32,
    /// Secondary text.
    pub weak: Color32,
    /// Success, or a condition that holds.
    pub good: Color32,
    /// A warning.
    pub warn: Color32,
    /// Failure, or a condition that does not hold.
    pub bad: Color32,
}

const DARK: Colours = Colours {
    accent: Color32::from_rgb(116, 162, 255),
    on_accent: Color32::from_rgb(10, 16, 30),
    canvas: Color32::from_rgb(11, 13, 16),
    panel: Color32::from_rgb(24, 27, 32),
    line: Color32::from_rgb(44, 49, 57),
    text: Color32::from_rgb(214, 220, 228),
    weak: Color32::from_rgb(146, 155, 168),
    good: Color32::from_rgb(94, 201, 142),
    warn: Color32::from_rgb(236, 178, 76),
    bad: Color32::from_rgb(242, 112, 100),
};

const LIGHT: Colours = Colours {
    accent: Color32::from_rgb(32, 88, 208),
    on_accent: Color32::WHITE,
    canvas: Color32::from_rgb(226, 229, 234),
    panel: Color32::from_rgb(246, 247, 249),
    line: Color32::from_rgb(206, 211, 219),
    text: Color32::from_rgb(28, 33, 41),
    weak: Color32::from_rgb(88, 97, 110),
    good: Color32::from_rgb(16, 122, 72),
    warn: Color32::from_rgb(158, 96, 0),
    bad: Color32::from_rgb(190, 44, 36),
};

/// The colour of an area's purpose.
pub(crate) const fn area_colour(purpose: Purpose) -> Color32 {
    match purpose {
        Purpose::Analyse => Color32::from_rgb(64, 196, 140),
        Purpose::Ignore => Color32::from_rgb(240, 140, 60),
    }
}

/// A palette colour adapted to panels: darker on a light panel.
pub(crate) fn readable_colour(ui: &eframe::egui::Ui, colour: [u8; 3]) -> Color32 {
    let colour = rgb(colour);
    if ui.visuals().dark_mode {
        colour
    } else {
        Color32::from_rgb(colour.r() / 10 * 7, colour.g() / 10 * 7, colour.b() / 10 * 7)
    }
}

/// The colour of the pinned pixel of this number.
pub(crate) fn pin_colour(number: u8) -> Color32 {
    rgb(identity_colour(number.into()))
}

/// The colours of these visuals.
pub fn colours(visuals: &Visuals) -> Colours {
    if visuals.dark_mode { DARK } else { LIGHT }
}

/// A palette colour as an egui colour.
pub const fn rgb(colour: [u8; 3]) -> Color32 {
    Color32::from_rgb(colour[0], colour[1], colour[2])
}

/// Black or white, whichever has the higher contrast on `background`.
pub fn ink_on(background: Color32) -> Color32 {
    let [r, g, b, _] = background.to_array().map(|channel| (f32::from(channel) / 255.0).powf(2.2));
    // The luminance at which black and white have equal contrast ratios.
    if 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.18 { Color32::from_rgb(12, 14, 18) } else { Color32::WHITE }
}

/// A progress bar filled to `share`, for panels and canvas.
pub fn progress(ui: &mut eframe::egui::Ui, share: f32, width: f32) -> eframe::egui::Response {
    ui.scope(|ui| {
        // By default the bar's background has the colour of the canvas.
        ui.visuals_mut().extreme_bg_color = colours(ui.visuals()).line;
        ui.visuals_mut().selection.bg_fill = colours(ui.visuals()).accent;
        ui.add(eframe::egui::ProgressBar::new(share).desired_width(width).desired_height(6.0))
    })
    .inner
}

/// The outline of the keyboard focus, for controls that are not egui's own.
pub fn focus(ui: &eframe::egui::Ui, response: &eframe::egui::Response) {
    if response.has_focus() {
        let stroke = eframe::egui::Stroke::new(1.5, colours(ui.visuals()).accent);
        let inside = eframe::egui::StrokeKind::Inside;
        ui.painter().rect_stroke(response.rect, 3.0, stroke, inside);
    }
}

/// The frame of a dialog over the window.
pub fn dialog_frame(ctx: &eframe::egui::Context) -> Frame {
    Frame::popup(&ctx.global_style()).inner_margin(4.0 * SPACE)
}

/// Installs fonts, sizes, distances and colours in `ctx`, for dark and light.
pub fn install(ctx: &eframe::egui::Context) {
    egui_material_icons::initialize(ctx);
    // The table of actions has its own zoom actions.
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.style_mut_of(Theme::Dark, |style| apply(style, Visuals::dark(), &DARK));
    ctx.style_mut_of(Theme::Light, |style| apply(style, Visuals::light(), &LIGHT));
}

fn apply(style: &mut Style, visuals: Visuals, colours: &Colours) {
    style.text_styles = [
        (TextStyle::Small, FontId::new(SMALL_TEXT, FontFamily::Proportional)),
        (TextStyle::Body, FontId::new(BODY_TEXT, FontFamily::Proportional)),
        (TextStyle::Button, FontId::new(BODY_TEXT, FontFamily::Proportional)),
        (TextStyle::Monospace, FontId::new(MONO_TEXT, FontFamily::Monospace)),
        (TextStyle::Heading, FontId::new(HEADING_TEXT, FontFamily::Proportional)),
    ]
    .into();
    style.drag_value_text_style = TextStyle::Monospace;
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(2.0 * SPACE, SPACE);
    spacing.button_padding = vec2(2.0 * SPACE, 3.0);
    spacing.interact_size = vec2(28.0, 22.0);
    spacing.slider_rail_height = 4.0;
    spacing.menu_margin = Margin::same(6);
    spacing.window_margin = Margin::same(14);
    spacing.tooltip_width = 360.0;
    spacing.scroll = ScrollStyle { bar_width: 6.0, ..ScrollStyle::solid() };
    style.visuals = visuals_with_colours(visuals, colours);
}

/// The visuals of egui in these colours.
fn visuals_with_colours(mut visuals: Visuals, colours: &Colours) -> Visuals {
    let corner = CornerRadius::same(4);
    let dark = visuals.dark_mode;
    let step = |amount: u8| -> Color32 {
        let [r, g, b, _] = colours.panel.to_array();
        let shift = |channel: u8| {
            if dark { channel.saturating_add(amount) } else { channel.saturating_sub(amount) }
        };
        Color32::from_rgb(shift(r), shift(g), shift(b))
    };
    visuals.panel_fill = colours.panel;
    visuals.window_fill = if dark { step(6) } else { Color32::WHITE };
    visuals.window_stroke = Stroke::new(1.0, colours.line);
    visuals.extreme_bg_color = colours.canvas;
    visuals.text_edit_bg_color = Some(if dark { colours.canvas } else { Color32::WHITE });
    visuals.faint_bg_color = step(6);
    visuals.code_bg_color = step(12);
    visuals.weak_text_color = Some(colours.weak);
    visuals.warn_fg_color = colours.warn;
    visuals.error_fg_color = colours.bad;
    visuals.hyperlink_color = colours.accent;
    visuals.selection = Selection {
        bg_fill: if dark { Color32::from_rgb(44, 66, 112) } else { Color32::from_rgb(196, 214, 250) },
        stroke: Stroke::new(
            1.0,
            if dark { Color32::from_rgb(232, 239, 255) } else { Color32::from_rgb(16, 44, 110) },
        ),
    };
    visuals.slider_trailing_fill = true;
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = CornerRadius::same(6);
    visuals.window_shadow = Shadow {
        offset: [0, 8],
        blur: 28,
        spread: 0,
        color: Color32::from_black_alpha(if dark { 140 } else { 50 }),
    };
    visuals.popup_shadow = Shadow {
        offset: [0, 4],
        blur: 14,
        spread: 0,
        color: Color32::from_black_alpha(if dark { 120 } else { 40 }),
    };
    let widgets = &mut visuals.widgets;
    for (widget, amount) in [
        (&mut widgets.noninteractive, 0),
        (&mut widgets.inactive, 16),
        (&mut widgets.hovered, 30),
        (&mut widgets.active, 40),
        (&mut widgets.open, 22),
    ] {
        widget.corner_radius = corner;
        widget.weak_bg_fill = step(amount);
        widget.bg_fill = step(amount + if amount == 0 { 0 } else { 12 });
        widget.bg_stroke = Stroke::NONE;
        widget.fg_stroke = Stroke::new(1.0, colours.text);
        widget.expansion = 0.0;
    }
    if !dark {
        // Gray on light gray has too little contrast without a border.
        widgets.inactive.bg_stroke = Stroke::new(1.0, colours.line);
    }
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, colours.line);
    widgets.hovered.bg_stroke = Stroke::new(1.0, colours.weak.gamma_multiply(0.6));
    widgets.active.bg_stroke = Stroke::new(1.0, colours.accent);
    let strong = if dark { Color32::WHITE } else { Color32::BLACK };
    widgets.hovered.fg_stroke = Stroke::new(1.0, strong);
    widgets.active.fg_stroke = Stroke::new(1.0, strong);
    visuals
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(colour: Color32) -> f32 {
        let linear = |c: u8| {
            let c = f32::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    }

    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn text_is_readable_on_panels_and_on_the_canvas() {
        for (name, colours) in [("dark", DARK), ("light", LIGHT)] {
            for background in [colours.panel, colours.canvas] {
                for (what, text) in [
                    ("text", colours.text),
                    ("weak", colours.weak),
                    ("good", colours.good),
                    ("warn", colours.warn),
                    ("bad", colours.bad),
                    ("accent", colours.accent),
                ] {
                    let ratio = contrast(text, background);
                    assert!(ratio >= 4.0, "{name}: {what} has a contrast of {ratio:.1}");
                }
            }
            assert!(contrast(colours.on_accent, colours.accent) >= 4.5);
        }
    }

    #[test]
    fn ink_is_readable_on_every_identity_colour() {
        for id in 1..=10 {
            let fill = rgb(crate::palette::identity_colour(id));
            assert!(contrast(ink_on(fill), fill) >= 3.5, "{id}");
        }
    }
}
