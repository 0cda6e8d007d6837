//! The window's state that survives a restart, except the layout of the views.

use std::collections::BTreeMap;

use eframe::Storage;
use eframe::egui::{Context, Theme};
use serde::{Deserialize, Serialize};

use crate::app::model::Model;
use crate::app::model::marks::Marks;
use crate::app::model::overlays::{MaskOverlay, TrackOverlays};
use crate::app::model::playback::SPEEDS;
use crate::app::model::view::BackgroundDisplay;
use crate::mixture::Quantity;
use crate::occlusion::EventKind;
use crate::source::Options;

/// The storage key.
const STORAGE_KEY: &str = "window";

/// The persisted state. Fields that an older version did not write have their initial values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PersistedState {
    light: bool,
    hint: bool,
    /// Visibility of the settings panel and of the inspector panel.
    panels: [bool; 2],
    background: BackgroundDisplay,
    quantity: Quantity,
    overlay: MaskOverlay,
    loupe: bool,
    drawn: TrackOverlays,
    speed: usize,
    listed: Vec<bool>,
    recent: Vec<String>,
    marks: BTreeMap<String, Marks>,
    options: BTreeMap<String, Options>,
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
            hint: model.panels.hint,
            panels: [model.panels.settings, model.panels.inspector],
            background: model.display.background,
            quantity: model.display.quantity,
            overlay: model.display.overlay,
            loupe: model.display.loupe,
            drawn: model.display.track_overlays,
            speed: model.playback.speed,
            listed: model.events.listed_kinds.to_vec(),
            recent: model.videos.recent.clone(),
            marks: model.videos.marks.clone(),
            options: model.videos.options.clone(),
        }
    }

    /// Reads the state. An unreadable state has its initial values.
    pub(crate) fn read(storage: Option<&dyn Storage>) -> Self {
        storage.and_then(|storage| eframe::get_value(storage, STORAGE_KEY)).unwrap_or_default()
    }

    /// Writes the state.
    pub(crate) fn write(&self, storage: &mut dyn Storage) {
        eframe::set_value(storage, STORAGE_KEY, self);
    }

    /// Restores the window.
    pub(crate) fn restore(self, ctx: &Context, model: &mut Model) {
        ctx.set_theme(if self.light { Theme::Light } else { Theme::Dark });
        [model.panels.settings, model.panels.inspector] = self.panels;
        (model.display.background, model.display.quantity) = (self.background, self.quantity);
        model.display.overlay = MaskOverlay { opacity: self.overlay.opacity.clamp(5, 100), ..self.overlay };
        (model.display.track_overlays, model.display.loupe) = (self.drawn, self.loupe);
        model.playback.speed = self.speed.min(SPEEDS.len() - 1);
        if let Ok(listed) = <[bool; EventKind::ALL.len()]>::try_from(self.listed) {
            model.events.listed_kinds = listed;
        }
        (model.videos.recent, model.panels.hint) = (self.recent, self.hint);
        model.videos.marks = self.marks;
        model.videos.options = self.options.into_iter().filter(|(_, options)| options.is_valid()).collect();
    }
}
