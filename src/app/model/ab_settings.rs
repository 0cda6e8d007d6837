//! Two sets of settings, A and B, on one video. One of them is in view.

use crate::settings::{SETTINGS, Setting, Settings};

/// A slot for settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum AbSlot {
    /// The initial slot.
    A,
    /// The slot to compare with A.
    B,
}

impl AbSlot {
    /// Both slots in order.
    pub(crate) const ALL: [Self; 2] = [Self::A, Self::B];

    /// The other one.
    pub(crate) const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// The slot's colour in comparisons, distinguishable by colour-blind readers.
    pub(crate) const fn colour(self) -> [u8; 3] {
        match self {
            Self::A => [230, 159, 0],
            Self::B => [86, 180, 233],
        }
    }

    /// The slot's letter.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
        }
    }
}

/// The slot in view, and the settings of the other slot. The model holds the settings in view.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AbSettings {
    /// The slot in view.
    pub(crate) in_view: AbSlot,
    /// The settings of the other slot; `None` before B exists.
    pub(crate) other: Option<Settings>,
}

impl AbSettings {
    /// Slot A in view, without B.
    pub(crate) const fn new() -> Self {
        Self { in_view: AbSlot::A, other: None }
    }

    /// Brings a slot into view: stores the settings in view and loads the slot's own into `settings`. A slot without
    /// settings starts as a copy of the settings in view.
    pub(crate) fn show(&mut self, slot: AbSlot, settings: &mut Settings) {
        if slot == self.in_view {
            return;
        }
        self.in_view = slot;
        match &mut self.other {
            Some(other) => std::mem::swap(other, settings),
            none => *none = Some(settings.clone()),
        }
    }
}

/// Names the settings in which the two sets differ, in one line.
pub(crate) fn difference(one: &Settings, other: &Settings) -> String {
    let names: Vec<_> = SETTINGS
        .iter()
        .filter(|setting| setting.get(one) != setting.get(other))
        .map(Setting::label)
        .collect();
    match names.len() {
        0 => "A and B are equal".to_owned(),
        1..=6 => format!("A and B differ in {}", names.join(", ")),
        many => format!("A and B differ in {} and {} more", names[..5].join(", "), many - 5),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    #[test]
    fn b_starts_as_a_copy_and_each_slot_keeps_its_settings() {
        let mut settings = Settings { k: 3, ..Settings::default() };
        let mut slots = AbSettings::new();
        slots.show(AbSlot::A, &mut settings);
        assert_eq!(slots.other, None);
        slots.show(AbSlot::B, &mut settings);
        assert_eq!((slots.in_view, settings.k), (AbSlot::B, 3));
        settings.k = 5;
        slots.show(AbSlot::A, &mut settings);
        assert_eq!((slots.in_view, settings.k), (AbSlot::A, 3));
        settings.k = 2;
        slots.show(AbSlot::A, &mut settings);
        slots.show(AbSlot::B, &mut settings);
        assert_eq!((slots.in_view, settings.k), (AbSlot::B, 5));
        slots.show(AbSlot::A, &mut settings);
        assert_eq!(settings.k, 2);
    }

    #[test]
    fn the_difference_names_the_settings() {
        let start = Settings::default();
        assert_eq!(difference(&start, &start), "A and B are equal");
        let other = Settings { k: start.k + 1, t: 0.9, ..start.clone() };
        assert_eq!(difference(&start, &other), "A and B differ in components, background ratio");
        assert!(difference(&start, &Settings::preset(Preset::OpencvMog)).starts_with("A and B differ in "));
    }
}
