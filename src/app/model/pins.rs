//! Pinned pixels: up to eight, each with a fixed number and colour.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Largest number of pinned pixels.
pub(crate) const MAX_PINS: u8 = 8;

/// The pinned pixels by number, from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Pins(BTreeMap<u8, (u32, u32)>);

impl Pins {
    /// Numbers and pixels, by number.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u8, (u32, u32))> + '_ {
        self.0.iter().map(|(&number, &at)| (number, at))
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The number of a pixel, if it is pinned.
    pub(crate) fn number_of(&self, at: (u32, u32)) -> Option<u8> {
        self.iter().find(|(_, pinned)| *pinned == at).map(|(number, _)| number)
    }

    /// Pins a pixel under the first free number, or unpins it. Returns false if all numbers are taken.
    pub(crate) fn toggle(&mut self, at: (u32, u32)) -> bool {
        if let Some(number) = self.number_of(at) {
            self.remove(number);
            return true;
        }
        let free = (1..=MAX_PINS).find(|number| !self.0.contains_key(number));
        if let Some(number) = free {
            self.0.insert(number, at);
        }
        free.is_some()
    }

    /// Unpins the pixel of a number.
    pub(crate) fn remove(&mut self, number: u8) {
        self.0.remove(&number);
    }

    /// Unpins all pixels.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

/// The label of a pin. A number alone would be an object's identity.
pub(crate) fn name(number: u8) -> String {
    format!("P{number}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_keeps_its_number_while_others_change() {
        let mut pins = Pins::default();
        for x in 0..8 {
            assert!(pins.toggle((x, 5)));
        }
        assert!(!pins.toggle((9, 9)), "a ninth pin is rejected");
        assert!(pins.toggle((2, 5)), "a second toggle unpins");
        pins.remove(6);
        assert_eq!((pins.number_of((2, 5)), pins.number_of((7, 5))), (None, Some(8)));
        assert!(pins.toggle((9, 9)) && pins.number_of((9, 9)) == Some(3), "the first free number");
        assert_eq!(pins.iter().count(), 7);
        pins.clear();
        assert!(pins.is_empty());
    }
}
