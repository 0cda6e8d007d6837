//! The views, and what the background view shows.

use serde::{Deserialize, Serialize};

use crate::app::model::ab_settings::{AbSettings, AbSlot};

/// A view of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) enum View {
    /// The input frame.
    Input,
    /// The background model.
    Background,
    /// The foreground mask.
    Foreground,
    /// Connected regions of the mask.
    Regions,
    /// Objects, occlusion groups, occlusions and events.
    Tracks,
    /// Difference of the input from the background.
    Difference,
    /// A per-pixel quantity as a colour.
    Map,
    /// The background model under the compared settings.
    #[serde(rename = "BesideBackground")]
    ComparedBackground,
    /// The foreground mask under the compared settings.
    #[serde(rename = "BesideForeground")]
    ComparedForeground,
    /// Objects, occlusion groups, occlusions and events under the compared settings.
    #[serde(rename = "BesideTracks")]
    ComparedTracks,
    /// Comparison of the two masks.
    Agreement,
    /// True and false decisions of the mask against the ground truth.
    #[serde(rename = "Right")]
    MaskErrors,
    /// Comparison of the mask with that of the external results.
    ExternalAgreement,
    /// True and false decisions of the external mask against the ground truth.
    ExternalErrors,
}

impl View {
    /// All views in menu order; the first nine have the keys 1 to 9.
    pub(crate) const ALL: [Self; 14] = [
        Self::Input,
        Self::Background,
        Self::Foreground,
        Self::Regions,
        Self::Tracks,
        Self::Difference,
        Self::Map,
        Self::Agreement,
        Self::MaskErrors,
        Self::ComparedForeground,
        Self::ComparedTracks,
        Self::ComparedBackground,
        Self::ExternalAgreement,
        Self::ExternalErrors,
    ];

    /// Its title.
    pub(crate) const fn title(self) -> &'static str {
        match self {
            Self::Input => "Input",
            Self::Background => "Background",
            Self::Foreground => "Foreground",
            Self::Regions => "Regions",
            Self::Tracks => "Tracks and occlusions",
            Self::Difference => "Difference",
            Self::Map => "Map",
            Self::ComparedBackground => "Background (B)",
            Self::ComparedForeground => "Foreground (B)",
            Self::ComparedTracks => "Tracks (B)",
            Self::Agreement => "A vs B difference",
            Self::MaskErrors => "Mask errors",
            Self::ExternalAgreement => "Ours vs external",
            Self::ExternalErrors => "Mask errors (external)",
        }
    }

    /// Its title while there are two slots, of which `in_view` is in view.
    pub(crate) fn slot_title(self, in_view: AbSlot) -> String {
        let (title, slot) = match self {
            Self::Input | Self::Agreement | Self::ExternalErrors => return self.title().to_owned(),
            Self::ComparedBackground => (Self::Background.title(), in_view.other()),
            Self::ComparedForeground => (Self::Foreground.title(), in_view.other()),
            Self::ComparedTracks => (Self::Tracks.title(), in_view.other()),
            _ => (self.title(), in_view),
        };
        format!("{title} ({})", slot.name())
    }

    /// Its title for screen readers and the status bar, with the slot's letter for compared settings.
    pub(crate) fn label(self, slots: &AbSettings) -> String {
        if self.compares() && slots.other.is_some() {
            self.slot_title(slots.in_view)
        } else {
            self.title().to_owned()
        }
    }

    /// Whether it needs compared settings.
    pub(crate) const fn compares(self) -> bool {
        matches!(
            self,
            Self::ComparedBackground | Self::ComparedForeground | Self::ComparedTracks | Self::Agreement
        )
    }

    /// Whether it needs external results.
    pub(crate) const fn is_external(self) -> bool {
        matches!(self, Self::ExternalAgreement | Self::ExternalErrors)
    }

    /// Whether it is open initially, without compared settings, ground truth or external results.
    pub(crate) const fn is_open_at_first(self) -> bool {
        !self.compares() && !self.is_external() && !matches!(self, Self::MaskErrors)
    }

    /// A description of its content.
    pub(crate) const fn meaning(self) -> &'static str {
        match self {
            Self::Input => "Input frame as decoded.",
            Self::Background => "Background model after this frame.",
            Self::Foreground => "Foreground mask after post-processing, before small regions are removed.",
            Self::Regions => {
                "Connected components with number, box and dominant colour. Coloured by the associated \
                 object, white for a group, gray for none."
            }
            Self::Tracks => {
                "Boxes in identity colours: solid if visible, dashed if predicted (merged or occluded). \
                 Dotted: gates. Hatched: occlusions. Flags: this frame's events."
            }
            Self::Difference => "Largest per-channel difference between input and background, times 2.",
            Self::Map => {
                "One quantity per pixel as a colour, of its mixture or its past; selected in the title bar."
            }
            Self::ComparedBackground => "Background model after this frame, under the other settings.",
            Self::ComparedForeground => "Foreground mask under the other settings.",
            Self::ComparedTracks => "Objects, groups and events under the other settings.",
            Self::Agreement => "Pixels that are foreground under A only, B only and both, over a dark input.",
            Self::MaskErrors => {
                "Foreground after post-processing against the ground truth: true positives (TP), false \
                 positives (FP), false negatives (FN)."
            }
            Self::ExternalAgreement => {
                "Pixels that are foreground in our mask only, in the external mask only and in both, over a dark input."
            }
            Self::ExternalErrors => {
                "Foreground of the external mask against the ground truth: true positives (TP), false positives (FP), \
                 false negatives (FN)."
            }
        }
    }

    /// Its index in [`Self::ALL`].
    pub(crate) fn index(self) -> usize {
        Self::ALL.iter().position(|&view| view == self).unwrap_or(0)
    }
}

/// The content of the background view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) enum BackgroundDisplay {
    /// The mean of component 1.
    // An earlier version had B here, which is a map now.
    #[serde(alias = "Count")]
    Mean,
    /// The weighted mean of the B background components.
    MultiMode,
}

impl BackgroundDisplay {
    /// All kinds in order.
    pub(crate) const ALL: [Self; 2] = [Self::Mean, Self::MultiMode];

    /// Its label on a button.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Mean => "Mean",
            Self::MultiMode => "Modes",
        }
    }

    /// A description in a sentence.
    pub(crate) const fn meaning(self) -> &'static str {
        match self {
            Self::Mean => "The mean of component 1 at each pixel",
            Self::MultiMode => "The weighted mean of the B components that are background",
        }
    }

    /// The kind after this one.
    pub(crate) const fn next(self) -> Self {
        match self {
            Self::Mean => Self::MultiMode,
            Self::MultiMode => Self::Mean,
        }
    }
}
