//! Short temporary messages about results and errors.

use std::time::Duration;

use eframe::egui::{Color32, Context, vec2};
use egui_material_icons::icons as m;

use crate::app::icons::Icon;
use crate::app::panels::messages::Messages;
use crate::app::theme;

/// How long a confirmation is shown.
const CONFIRMATION_DURATION: Duration = Duration::from_secs(4);
/// How long an error is shown; it is also shown elsewhere.
const ERROR_DURATION: Duration = Duration::from_secs(8);

/// Maximum number of characters in a line.
const MAX_LINE_CHARACTERS: usize = 68;

/// The visible messages, and the log of all messages.
pub(crate) struct Toasts {
    shown: egui_notify::Toasts,
    /// The log of all messages.
    pub(crate) messages: Messages,
}

/// The colour of a message, by theme.
type ThemeColour = fn(&theme::Colours) -> Color32;

impl Default for Toasts {
    fn default() -> Self {
        let corner = egui_notify::Anchor::TopRight;
        let shown = egui_notify::Toasts::default().with_anchor(corner).with_margin(vec2(12.0, 40.0));
        Self { shown, messages: Messages::default() }
    }
}

impl Toasts {
    /// Shows a confirmation.
    pub(crate) fn done(&mut self, ctx: &Context, text: impl Into<String>) {
        self.add(ctx, text, m::ICON_CHECK_CIRCLE, |colours| colours.good, CONFIRMATION_DURATION);
    }

    /// Shows a warning: an error that does not end the work.
    pub(crate) fn warn(&mut self, ctx: &Context, text: impl Into<String>) {
        self.add(ctx, text, m::ICON_WARNING, |colours| colours.warn, ERROR_DURATION);
    }

    /// Shows an error.
    pub(crate) fn fail(&mut self, ctx: &Context, text: impl Into<String>) {
        self.add(ctx, text, m::ICON_ERROR, |colours| colours.bad, ERROR_DURATION);
    }

    /// Logs an error that the window shows in full elsewhere.
    pub(crate) fn note_failure(&mut self, ctx: &Context, why: &str) {
        self.messages.add(ctx.input(|input| input.time), why, m::ICON_ERROR, |colours| colours.bad);
    }

    /// Draws the visible messages.
    pub(crate) fn show(&mut self, ctx: &Context) {
        self.shown.show(ctx);
        self.messages.ui(ctx);
    }

    /// Hides the visible messages: how far they have faded depends on the number of drawn frames.
    #[cfg(test)]
    pub(crate) fn hide(&mut self) {
        self.shown = Self::default().shown;
    }

    fn add(
        &mut self,
        ctx: &Context,
        text: impl Into<String>,
        icon: Icon,
        colour: ThemeColour,
        time: Duration,
    ) {
        let text = text.into();
        self.messages.add(ctx.input(|input| input.time), &text, icon, colour);
        let colour = colour(&theme::colours(&ctx.global_style().visuals));
        self.shown
            .custom(lines(&text, MAX_LINE_CHARACTERS), icon.codepoint.to_owned(), colour)
            .duration(time)
            .closable(false);
    }
}

/// Wraps the text to lines of at most this many characters. A longer path is broken.
fn lines(text: &str, most: usize) -> String {
    let mut lines = vec![String::new()];
    let mut free = most;
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for (piece, part) in letters.chunks(most).enumerate() {
            let gap = usize::from(piece == 0 && free < most);
            if part.len() + gap > free {
                lines.push(String::new());
                free = most;
            }
            if let Some(line) = lines.last_mut() {
                if gap > 0 && free < most {
                    line.push(' ');
                    free -= 1;
                }
                line.extend(part);
                free -= part.len();
            }
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_messages_are_wrapped_without_loss() {
        assert_eq!(lines("Wrote a.png", 20), "Wrote a.png");
        assert_eq!(lines("one two three", 7), "one two\nthree");
        assert_eq!(lines("in /a/very/long/path it is", 8), "in\n/a/very/\nlong/pat\nh it is");
        assert_eq!(lines("12345678 1 2", 8), "12345678\n1 2");
        assert_eq!(lines("", 8), "");
    }
}
