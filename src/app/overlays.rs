//! What can be laid over the pictures.

use serde::{Deserialize, Serialize};

/// The mask over the input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Overlay {
    /// Whether it is there.
    pub(crate) on: bool,
    /// How much of the input it covers, in per cent.
    pub(crate) opacity: u8,
}

impl Overlay {
    /// Its opacities, in per cent, through which a key goes.
    const STEPS: [u8; 4] = [25, 50, 75, 100];

    /// The next opacity of the steps; the first after the last.
    pub(crate) fn next(self) -> u8 {
        Self::STEPS.into_iter().find(|&step| step > self.opacity).unwrap_or(Self::STEPS[0])
    }
}

/// Something that is drawn over the tracks view beside the boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Drawn {
    /// Where each object has been.
    Trails,
    /// Where a region may lie to belong to an object.
    Gates,
    /// Which objects share a region.
    Groups,
    /// Where one object hides another.
    Occlusions,
    /// The objects' identities.
    Names,
    /// The frame's events.
    Events,
    /// The boxes of the ground truth, where one was loaded.
    Truth,
}

impl Drawn {
    /// All of them in order.
    pub(crate) const ALL: [Self; 7] =
        [Self::Trails, Self::Gates, Self::Groups, Self::Occlusions, Self::Names, Self::Events, Self::Truth];
}

/// Which of them are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Overlays([bool; Drawn::ALL.len()]);

impl Default for Overlays {
    fn default() -> Self {
        Self([true; Drawn::ALL.len()])
    }
}

impl Overlays {
    /// Whether it is drawn.
    pub(crate) const fn has(self, what: Drawn) -> bool {
        self.0[what as usize]
    }

    /// Draws it, or leaves it out.
    pub(crate) const fn toggle(&mut self, what: Drawn) {
        self.0[what as usize] = !self.0[what as usize];
    }
}
