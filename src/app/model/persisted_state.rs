//! The window's state that survives a restart, except the layout of the views.

use std::collections::BTreeMap;

use eframe::Storage;
use eframe::egui::{Context, Theme};
use serde::{Deserialize, Serialize};

use crate::app::model::marks::Marks;
use crate::app::model::overlays::{Overlay, Overlays};
use crate::app::model::{Model, SPEEDS};
use crate::app::views::Background;
use crate::mixture::Quantity;
use crate::occlusion::EventKind;
use crate::source::FPS_RANGE;

/// The storage key.
const NAME: &str = "window";

/// The persisted state. Fields that an older version did not write have their initial values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PersistedState {
    light: bool,
    hint: bool,
    /// Visibility of the settings panel and of the inspector panel.
    panels: [bool; 2],
    background: Background,
    quantity: Quantity,
    overlay: Overlay,
    loupe: bool,
    drawn: Overlays,
    speed: usize,
    listed: Vec<bool>,
    recent: Vec<String>,
    marks: BTreeMap<String, Marks>,
    rates: BTreeMap<String, f32>,
}

impl Default for PersistedState {
    fn default() -> Self {
        Self::of(&Model::new(crate::settings::Settings::default()), false)
    }
}

impl PersistedState {
    /// The state of a window.
    pub(crate) fn of(model: &Model, light: bool) -> Self {
        Self {
            light,
            hint: model.hint,
            panels: [model.settings_panel, model.inspector_panel],
            background: model.background,
            quantity: model.quantity,
            overlay: model.overlay,
            loupe: model.loupe,
            drawn: model.drawn,
            speed: model.playback.speed,
            listed: model.listed.to_vec(),
            recent: model.recent.clone(),
            marks: model.marks_of.clone(),
            rates: model.rates.clone(),
        }
    }

    /// Reads the state. An unreadable state has its initial values.
    pub(crate) fn read(storage: Option<&dyn Storage>) -> Self {
        storage.and_then(|storage| eframe::get_value(storage, NAME)).unwrap_or_default()
    }

    /// Writes the state.
    pub(crate) fn write(&self, storage: &mut dyn Storage) {
        eframe::set_value(storage, NAME, self);
    }

    /// Restores the window.
    pub(crate) fn restore(self, ctx: &Context, model: &mut Model) {
        ctx.set_theme(if self.light { Theme::Light } else { Theme::Dark });
        [model.settings_panel, model.inspector_panel] = self.panels;
        (model.background, model.quantity) = (self.background, self.quantity);
        model.overlay = Overlay { opacity: self.overlay.opacity.clamp(5, 100), ..self.overlay };
        (model.drawn, model.loupe) = (self.drawn, self.loupe);
        model.playback.speed = self.speed.min(SPEEDS.len() - 1);
        if let Ok(listed) = <[bool; EventKind::ALL.len()]>::try_from(self.listed) {
            model.listed = listed;
        }
        (model.recent, model.hint) = (self.recent, self.hint);
        model.marks_of = self.marks;
        let (least, greatest) = FPS_RANGE;
        model.rates = self.rates.into_iter().filter(|(_, fps)| (least..=greatest).contains(fps)).collect();
    }
}
