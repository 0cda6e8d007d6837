//! The window's state that survives a restart, except the layout of the views.

use std::collections::BTreeMap;

use eframe::Storage;
use eframe::egui::{Context, Theme};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

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
/// The fields that have values by video.
const MARKS: &str = "marks";
const OPTIONS: &str = "options";

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

    /// Reads the state. What cannot be read of it has its initial value.
    pub(crate) fn read(storage: Option<&dyn Storage>) -> Self {
        let text = storage.and_then(|storage| storage.get_string(STORAGE_KEY)).unwrap_or_default();
        match serde_json::from_str::<Map<String, Value>>(&text) {
            Ok(stored) => Self::of_stored(stored),
            // An older version wrote it in another format.
            Err(_) => storage.and_then(|storage| eframe::get_value(storage, STORAGE_KEY)).unwrap_or_default(),
        }
    }

    /// The state with all stored values that it can have. Of values by video, each is taken by itself.
    fn of_stored(stored: Map<String, Value>) -> Self {
        let Ok(Value::Object(mut whole)) = serde_json::to_value(Self::default()) else {
            return Self::default();
        };
        for (key, value) in stored {
            let parts: Vec<Value> = match value {
                Value::Object(videos) if [MARKS, OPTIONS].contains(&key.as_str()) => {
                    videos.into_iter().map(|(video, value)| Map::from_iter([(video, value)]).into()).collect()
                }
                value => vec![value],
            };
            for part in parts {
                let mut changed = whole.clone();
                match (changed.get_mut(&key), part) {
                    (Some(Value::Object(videos)), Value::Object(part)) => videos.extend(part),
                    (_, part) => drop(changed.insert(key.clone(), part)),
                }
                if Self::deserialize(Value::Object(changed.clone())).is_ok() {
                    whole = changed;
                }
            }
        }
        Self::deserialize(Value::Object(whole)).unwrap_or_default()
    }

    /// Writes the state.
    pub(crate) fn write(&self, storage: &mut dyn Storage) {
        if let Ok(text) = serde_json::to_string(self) {
            storage.set_string(STORAGE_KEY, text);
        }
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn state() -> PersistedState {
        let options = Options { levels: "0..4095".parse().ok(), ..Options::default() };
        let marks = Marks { start: Some(7), bookmarks: [3, 9].into(), ..Marks::default() };
        let mut state = PersistedState { light: true, recent: vec!["a.mp4".into()], ..Default::default() };
        state.loupe = !state.loupe;
        state.options = ["a.mp4", "b.mp4"].map(|name| (name.to_owned(), options)).into();
        state.marks = ["a.mp4", "b.mp4"].map(|name| (name.to_owned(), marks.clone())).into();
        state
    }

    fn read(text: &str) -> PersistedState {
        PersistedState::of_stored(serde_json::from_str(text).unwrap())
    }

    #[test]
    fn a_value_that_cannot_be_costs_no_other() {
        let whole = state();
        let text = serde_json::to_string(&whole).unwrap();
        assert_eq!(read(&text), whole);
        // The options of one video, of a newer version or edited.
        let damaged = read(&text.replacen("0..4095", "much", 1));
        let mut expected = whole.clone();
        expected.options.remove("a.mp4");
        assert_eq!(damaged, expected);
        let damaged = read(&text.replacen("\"start\":7", "\"start\":-7", 1));
        let mut expected = whole.clone();
        expected.marks.remove("a.mp4");
        assert_eq!(damaged, expected);
        for (from, to) in [("\"light\":true", "\"light\":3"), ("\"light\":true", "\"light\":[{}]")] {
            let expected = PersistedState { light: PersistedState::default().light, ..whole.clone() };
            assert_eq!(read(&text.replacen(from, to, 1)), expected);
        }
        assert_eq!(read(&text.replacen('{', "{\"of_a_newer_version\":[1],", 1)), whole);
    }

    #[test]
    fn no_change_of_a_byte_is_a_panic() {
        let text = serde_json::to_string(&state()).unwrap();
        for at in 0..text.len() {
            for byte in [b'0', b'"', b'}', b'-', b'n'] {
                let mut bytes = text.clone().into_bytes();
                bytes[at] = byte;
                if let Ok(stored) = serde_json::from_slice(&bytes) {
                    PersistedState::of_stored(stored);
                }
            }
        }
    }
}
