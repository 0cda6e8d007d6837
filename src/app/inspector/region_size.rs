//! The side of the region around the chosen pixel.

use eframe::egui::Ui;

use super::style::{self, small};

/// The available sides, in pixels.
const SIDES_PX: [u32; 5] = [1, 3, 5, 9, 15];

/// A selector of the side, in one line.
pub(super) fn choice(ui: &mut Ui, chosen: &mut u32) {
    for side in SIDES_PX {
        let text = format!("{side}×{side}");
        let label = ui.selectable_label(*chosen == side, small(&side.to_string())).accessible_name(&text);
        if label.on_hover_text(format!("{text} pixels around the selected pixel")).clicked() {
            *chosen = side;
        }
    }
    ui.label(style::aside(ui, "px"));
}
