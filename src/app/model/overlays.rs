//! Overlays of the views.

use serde::{Deserialize, Serialize};

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
}

impl TrackOverlay {
    /// All overlays in order.
    pub(crate) const ALL: [Self; 7] =
        [Self::Trails, Self::Gates, Self::Groups, Self::Occlusions, Self::Names, Self::Events, Self::Truth];
}

/// The set of shown overlays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct TrackOverlays([bool; TrackOverlay::ALL.len()]);

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
