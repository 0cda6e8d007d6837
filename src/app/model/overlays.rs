//! Overlays of the views.

use std::fmt;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// The mask over the input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MaskOverlay {
    /// Whether it is shown.
    pub(crate) on: bool,
    /// Its opacity, in per cent.
    pub(crate) opacity: u8,
}

impl MaskOverlay {
    /// The opacities that a shortcut steps through, in per cent.
    const OPACITY_STEPS_PERCENT: [u8; 4] = [25, 50, 75, 100];

    /// The next of these opacities; the first after the last.
    pub(crate) fn next(self) -> u8 {
        Self::OPACITY_STEPS_PERCENT
            .into_iter()
            .find(|&step| step > self.opacity)
            .unwrap_or(Self::OPACITY_STEPS_PERCENT[0])
    }
}

/// An overlay of the tracks view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum TrackOverlay {
    /// Past positions of each object.
    Trails,
    /// Gates of the motion model.
    Gates,
    /// Occlusion groups.
    Groups,
    /// Areas where one object occludes another.
    Occlusions,
    /// The objects' identities.
    Names,
    /// Events of the frame.
    Events,
    /// Ground-truth boxes, where ground truth is loaded.
    Truth,
    /// Boxes of the external results, where such are loaded.
    External,
}

impl TrackOverlay {
    /// All overlays in order.
    pub(crate) const ALL: [Self; 8] = [
        Self::Trails,
        Self::Gates,
        Self::Groups,
        Self::Occlusions,
        Self::Names,
        Self::Events,
        Self::Truth,
        Self::External,
    ];
}

/// The set of shown overlays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct TrackOverlays(
    #[serde(deserialize_with = "of_any_version")] [bool; TrackOverlay::ALL.len()],
);

impl Default for TrackOverlays {
    fn default() -> Self {
        Self([true; TrackOverlay::ALL.len()])
    }
}

impl TrackOverlays {
    /// Whether an overlay is shown.
    pub(crate) const fn has(self, what: TrackOverlay) -> bool {
        self.0[what as usize]
    }

    /// Shows or hides an overlay.
    pub(crate) const fn toggle(&mut self, what: TrackOverlay) {
        self.0[what as usize] = !self.0[what as usize];
    }
}

/// Reads the overlays that are shown. Those that an older version did not write are shown.
fn of_any_version<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<[bool; TrackOverlay::ALL.len()], D::Error> {
    struct Shown;
    impl<'de> Visitor<'de> for Shown {
        type Value = [bool; TrackOverlay::ALL.len()];

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("whether each overlay is shown")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Self::Value, A::Error> {
            let mut shown = [true; TrackOverlay::ALL.len()];
            for shown in &mut shown {
                match sequence.next_element()? {
                    Some(is_shown) => *shown = is_shown,
                    None => break,
                }
            }
            Ok(shown)
        }
    }
    deserializer.deserialize_tuple(TrackOverlay::ALL.len(), Shown)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::collections::HashMap;

    use super::*;

    #[derive(Default)]
    struct Storage(HashMap<String, String>);

    impl eframe::Storage for Storage {
        fn get_string(&self, key: &str) -> Option<String> {
            self.0.get(key).cloned()
        }

        fn set_string(&mut self, key: &str, value: String) {
            self.0.insert(key.to_owned(), value);
        }

        fn remove_string(&mut self, key: &str) {
            self.0.remove(key);
        }

        fn flush(&mut self) {}
    }

    #[test]
    fn the_overlays_of_an_older_version_are_read() {
        let mut storage = Storage::default();
        let mut overlays = TrackOverlays::default();
        overlays.toggle(TrackOverlay::Gates);
        eframe::set_value(&mut storage, "now", &overlays);
        assert_eq!(eframe::get_value(&storage, "now"), Some(overlays));
        storage.0.insert("older".into(), "((true,false,true,true,true,true,true))".into());
        assert_eq!(eframe::get_value(&storage, "older"), Some(overlays));
    }
}
