//! The list of shortcuts, made from the table of actions.

use eframe::egui::{Align, Context, Grid, Id, Layout, Modal, RichText, ScrollArea, Ui, vec2};

use crate::app::commands::actions::ACTIONS;
use crate::app::commands::entry::Menu;
use crate::app::theme;

/// The actions of the pointer.
const POINTER_ACTIONS: &[(&str, &str)] = &[
    ("Click", "Select the pixel in all views"),
    ("Wheel", "Zoom at the pointer"),
    ("Drag", "Pan all views"),
    ("Double click", "Fit image"),
    ("Hold Alt", "Loupe at the pointer"),
    ("Wheel in timeline", "Zoom; with Shift, pan"),
    ("Click an outline", "Select the area"),
    ("Drag a view's title", "Move the view"),
    ("Drop a file", "Open a video or image folder"),
];

/// The keys of the focused control.
const FOCUS_KEYS: &[(&str, &str)] = &[
    ("Tab", "Next control"),
    ("Shift+Tab", "Previous control"),
    ("Space", "Activate control"),
    ("Arrow keys in a view", "Select a pixel"),
    ("Arrow keys in timeline", "Previous, next frame"),
    ("Esc", "Leave control"),
];

/// Draws the dialog while `open`.
pub(crate) fn ui(ctx: &Context, open: &mut bool) {
    if !*open {
        return;
    }
    let response = Modal::new(Id::unique("help")).frame(theme::dialog_frame(ctx)).show(ctx, |ui| {
        let screen = ctx.content_rect();
        ui.set_width((screen.width() - 80.0).clamp(0.0, 760.0));
        let mut close = false;
        ui.horizontal(|ui| {
            ui.label(RichText::new("Keyboard and mouse").size(18.0).strong());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| close = ui.button("Close").clicked());
        });
        ui.add_space(2.0 * theme::SPACE);
        ScrollArea::vertical()
            .max_height((screen.height() - 140.0).max(0.0))
            .min_scrolled_height(screen.height() - 140.0)
            .show(ui, |ui| {
                ui.columns(2, |columns| {
                    if let [left, right] = columns {
                        keys(left, Menu::Analysis);
                        keys(right, Menu::View);
                        keys(right, Menu::File);
                        keys(right, Menu::Help);
                        rows_ui(right, "Mouse", POINTER_ACTIONS);
                        rows_ui(right, "Keyboard focus", FOCUS_KEYS);
                    }
                });
            });
        close
    });
    if response.inner || response.should_close() {
        *open = false;
    }
}

fn keys(ui: &mut Ui, menu: Menu) {
    heading(ui, menu.name());
    Grid::new(menu.name()).num_columns(2).spacing(vec2(16.0, 5.0)).show(ui, |ui| {
        for entry in ACTIONS.iter().filter(|entry| entry.menu == menu && !entry.shortcuts.is_empty()) {
            let keys: Vec<String> = entry.shortcuts.iter().map(|shortcut| shortcut.text()).collect();
            ui.label(RichText::new(keys.join("  ")).monospace().color(theme::colours(ui.visuals()).accent));
            ui.label(entry.text.trim_end_matches('…')).on_hover_text(entry.tooltip);
            ui.end_row();
        }
    });
    ui.add_space(3.0 * theme::SPACE);
}

fn rows_ui(ui: &mut Ui, title: &str, rows: &[(&str, &str)]) {
    heading(ui, title);
    Grid::new(title).num_columns(2).spacing(vec2(16.0, 5.0)).show(ui, |ui| {
        for (what, does) in rows {
            ui.label(RichText::new(*what).monospace().color(theme::colours(ui.visuals()).accent));
            ui.label(*does);
            ui.end_row();
        }
    });
    ui.add_space(3.0 * theme::SPACE);
}

fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).strong());
    ui.add_space(theme::SPACE / 2.0);
}
