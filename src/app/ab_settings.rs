//! Two sets of settings on one video, A and B, of which one is in view.

use crate::settings::{SETTINGS, Setting, Settings};

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum AbSlot {
    /// The one to start with.
    A,
    /// The one to compare it with.
    B,
}

impl AbSlot {
    /// Both in order.
    pub(crate) const ALL: [Self; 2] = [Self::A, Self::B];

    /// The other one.
    pub(crate) const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// Its colour wherever the two are compared; apart for colour-blind eyes, too.
    pub(crate) const fn colour(self) -> [u8; 3] {
        match self {
            Self::A => [230, 159, 0],
            Self::B => [86, 180, 233],
        }
    }

    /// Its letter.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
        }
    }
}

/// The slot in view, and the settings of the other. The settings in view are the model's own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AbSettings {
    /// The slot in view.
    pub(crate) in_view: AbSlot,
    /// The settings of the other; none before there is a B.
    pub(crate) other: Option<Settings>,
}

impl AbSettings {
    /// A in view and no B.
    pub(crate) const fn new() -> Self {
        Self { in_view: AbSlot::A, other: None }
    }

    /// Brings a slot into view: the settings in view are stored, and `settings` become the slot's own. A slot without
    /// settings begins as a copy of the one in view.
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

/// In which settings the two differ, in a line.
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
    fn b_begins_as_a_copy_and_each_keeps_its_own() {
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
    fn the_difference_is_named() {
        let start = Settings::default();
        assert_eq!(difference(&start, &start), "A and B are equal");
        let other = Settings { k: start.k + 1, t: 0.9, ..start.clone() };
        assert_eq!(difference(&start, &other), "A and B differ in components, background ratio");
        assert!(difference(&start, &Settings::preset(Preset::OpencvMog)).starts_with("A and B differ in "));
    }
}
