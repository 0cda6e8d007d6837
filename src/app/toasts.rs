//! Short messages that come and go: what was done, what went wrong.

use std::time::Duration;

use eframe::egui::{Color32, Context, vec2};
use egui_material_icons::icons as m;

use super::icons::Icon;
use super::theme;

/// How long something that was done is told.
const BRIEFLY: Duration = Duration::from_secs(4);
/// How long something that went wrong is told; it stands elsewhere too.
const LONGER: Duration = Duration::from_secs(8);

/// The messages that are shown.
pub(crate) struct Toasts(egui_notify::Toasts);

impl Default for Toasts {
    fn default() -> Self {
        let corner = egui_notify::Anchor::TopRight;
        Self(egui_notify::Toasts::default().with_anchor(corner).with_margin(vec2(12.0, 40.0)))
    }
}

impl Toasts {
    /// Something was done.
    pub(crate) fn done(&mut self, ctx: &Context, text: impl Into<String>) {
        let colour = theme::colours(&ctx.global_style().visuals).good;
        self.add(text, m::ICON_CHECK_CIRCLE, colour, BRIEFLY);
    }

    /// Something went wrong without ending the work.
    pub(crate) fn warn(&mut self, ctx: &Context, text: impl Into<String>) {
        let colour = theme::colours(&ctx.global_style().visuals).warn;
        self.add(text, m::ICON_WARNING, colour, LONGER);
    }

    /// Something failed.
    pub(crate) fn fail(&mut self, ctx: &Context, text: impl Into<String>) {
        let colour = theme::colours(&ctx.global_style().visuals).bad;
        self.add(text, m::ICON_ERROR, colour, LONGER);
    }

    /// Shows them.
    pub(crate) fn show(&mut self, ctx: &Context) {
        self.0.show(ctx);
    }

    fn add(&mut self, text: impl Into<String>, icon: Icon, colour: Color32, time: Duration) {
        self.0.custom(text.into(), icon.codepoint.to_owned(), colour).duration(time).closable(false);
    }
}
