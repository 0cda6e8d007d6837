//! The About dialog: version, build and graphics adapter, for bug reports and measurements.

use eframe::egui::{Context, Grid, Id, Modal, RichText, vec2};
use eframe::egui_wgpu::wgpu;

use crate::app::theme;
use crate::replay::memory;

/// The About dialog.
#[derive(Default)]
pub(crate) struct About {
    /// Whether the dialog is open.
    pub(crate) open: bool,
    graphics: String,
}

impl About {
    /// The dialog for this graphics adapter.
    pub(crate) fn on(card: &wgpu::AdapterInfo) -> Self {
        let driver = [card.driver.as_str(), card.driver_info.as_str()].join(" ");
        let driver = driver.split_whitespace().collect::<Vec<_>>().join(" ");
        let driver = if driver.is_empty() { String::new() } else { format!(", {driver}") };
        Self { open: false, graphics: format!("{} ({}{driver})", card.name, card.backend) }
    }

    /// The rows of the dialog, each with its label.
    fn lines(&self) -> [(&'static str, String); 6] {
        let opencv = opencv::core::get_version_string().unwrap_or_else(|_| "unknown".to_owned());
        [
            ("Version", env!("OCCLUSCOPE_VERSION").to_owned()),
            ("System", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)),
            ("Graphics", self.graphics.clone()),
            ("OpenCV", opencv),
            ("Threads", rayon::current_num_threads().to_string()),
            ("Memory", format!("{} MiB", memory() >> 20)),
        ]
    }

    /// Draws the dialog while it is open.
    pub(crate) fn ui(&mut self, ctx: &Context) {
        if !self.open {
            return;
        }
        let response = Modal::new(Id::unique("about")).frame(theme::dialog_frame(ctx)).show(ctx, |ui| {
            ui.set_width(440.0);
            ui.label(RichText::new("Occluscope").size(20.0).strong());
            ui.label("A microscope for background models, moving regions, tracks and occlusions in video.");
            ui.add_space(3.0 * theme::SPACE);
            let lines = self.lines();
            Grid::new("about").num_columns(2).spacing(vec2(16.0, 5.0)).show(ui, |ui| {
                for (name, what) in &lines {
                    ui.weak(*name);
                    ui.add(eframe::egui::Label::new(what).wrap());
                    ui.end_row();
                }
            });
            ui.add_space(3.0 * theme::SPACE);
            ui.horizontal(|ui| {
                if ui.button("Copy").on_hover_text("Copy these lines for a bug report").clicked() {
                    let text = lines.iter().map(|(name, what)| format!("{name}: {what}\n"));
                    ui.copy_text(text.collect());
                }
                ui.button("Close").clicked()
            })
            .inner
        });
        if response.inner || response.should_close() {
            self.open = false;
        }
    }
}
