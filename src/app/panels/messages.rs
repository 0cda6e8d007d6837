//! The log of all messages since the start.

use std::collections::VecDeque;

use eframe::egui::{Align2, Context, RichText, ScrollArea, Window};

use crate::app::icons::Icon;
use crate::app::theme;

/// Largest number of retained messages.
const MAX_MESSAGES: usize = 500;

/// A message.
struct Message {
    /// Time in seconds of the window's clock.
    at: f64,
    text: String,
    icon: Icon,
    colour: fn(&theme::Colours) -> eframe::egui::Color32,
}

/// The messages, oldest first.
#[derive(Default)]
pub(crate) struct Messages {
    /// Whether the list is shown.
    pub(crate) open: bool,
    all: VecDeque<Message>,
}

impl Messages {
    /// Adds a message.
    pub(crate) fn add(
        &mut self,
        at: f64,
        text: &str,
        icon: Icon,
        colour: fn(&theme::Colours) -> eframe::egui::Color32,
    ) {
        self.all.push_back(Message { at, text: text.to_owned(), icon, colour });
        if self.all.len() > MAX_MESSAGES {
            self.all.pop_front();
        }
    }

    /// Draws the list while it is open.
    pub(crate) fn ui(&mut self, ctx: &Context) {
        let mut open = self.open;
        let middle = ctx.content_rect().center();
        let window = Window::new("Messages").open(&mut open).default_size([520.0, 260.0]).min_width(300.0);
        let window = window.default_pos(middle).pivot(Align2::CENTER_CENTER).collapsible(false);
        window.show(ctx, |ui| {
            if self.all.is_empty() {
                ui.weak("No messages yet.");
            }
            ScrollArea::vertical().stick_to_bottom(true).auto_shrink([false, true]).show(ui, |ui| {
                let colours = theme::colours(ui.visuals());
                for message in &self.all {
                    ui.horizontal_wrapped(|ui| {
                        ui.label(RichText::new(clock(message.at)).monospace().color(colours.weak));
                        ui.label(message.icon.rich_text().size(14.0).color((message.colour)(&colours)));
                        ui.label(&message.text);
                    });
                }
            });
            if !self.all.is_empty() && ui.button("Copy all").clicked() {
                let lines =
                    self.all.iter().map(|message| format!("{} {}\n", clock(message.at), message.text));
                ui.copy_text(lines.collect());
            }
        });
        self.open = open;
    }
}

/// Minutes and seconds since the start.
fn clock(seconds: f64) -> String {
    let seconds = seconds.max(0.0) as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_messages_are_dropped_and_times_are_in_minutes_and_seconds() {
        let mut messages = Messages::default();
        for count in 0..MAX_MESSAGES + 3 {
            messages.add(0.0, &count.to_string(), egui_material_icons::icons::ICON_CHECK, |c| c.good);
        }
        assert_eq!(messages.all.len(), MAX_MESSAGES);
        assert_eq!(messages.all.front().map(|message| message.text.as_str()), Some("3"));
        assert_eq!([clock(0.4), clock(59.9), clock(605.0)], ["0:00", "0:59", "10:05"]);
    }
}
