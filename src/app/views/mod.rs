//! The linked views in the middle, one file each, and the tiles that arrange them.

mod agreement;
mod areas;
mod background;
mod canvas;
mod compared;
mod compose;
mod difference;
mod draw;
mod foreground;
mod input;
mod layer;
mod layer_upload;
mod layouts;
mod loupe;
mod map;
mod mask_errors;
mod pictures;
mod pins;
mod ramp;
mod regions;
mod tiles;
mod tracks;

pub(crate) use areas::area_colour;
pub(crate) use canvas::Canvas;
pub(crate) use layouts::{Layout, is_open, set_open};
#[cfg(test)]
pub(crate) use loupe::{picture as loupe_picture, place as loupe_place, words as loupe_words};
pub(crate) use pictures::Pictures;
pub(crate) use tiles::show;

use std::sync::Arc;

use eframe::egui::Painter;
use serde::{Deserialize, Serialize};

use self::compose::{Compose, ComposeStyle, Composer, Composition};
use self::layer::Layer;
use self::pictures::UploadedFrame;
use crate::app::model::Model;
use crate::app::model::ab_settings::{AbSettings, AbSlot};
use crate::app::theme::Colours;
use crate::replay::ShownFrame;

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
}

impl View {
    /// All views in the order of their keys, from 1.
    pub(crate) const ALL: [Self; 12] = [
        Self::Input,
        Self::Background,
        Self::Foreground,
        Self::Regions,
        Self::Tracks,
        Self::Difference,
        Self::Map,
        Self::ComparedBackground,
        Self::ComparedForeground,
        Self::ComparedTracks,
        Self::Agreement,
        Self::MaskErrors,
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
        }
    }

    /// Its title while there are two slots, of which `in_view` is in view.
    pub(crate) fn titled(self, in_view: AbSlot) -> String {
        let (title, slot) = match self {
            Self::Input | Self::Agreement => return self.title().to_owned(),
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
            self.titled(slots.in_view)
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

    /// Whether it is open initially, without compared settings or ground truth.
    pub(crate) const fn is_there_at_first(self) -> bool {
        !self.compares() && !matches!(self, Self::MaskErrors)
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
        }
    }

    /// Its index in [`Self::ALL`].
    pub(crate) fn place(self) -> usize {
        Self::ALL.iter().position(|&view| view == self).unwrap_or(0)
    }

    /// The value of a pixel in it, with parts separated by spaces.
    pub(crate) fn value(self, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
        match self {
            Self::Input | Self::Tracks => input::value(shown, at),
            Self::Background => background::value(shown, model.background, at),
            Self::Foreground => foreground::value(shown, at),
            Self::Regions => regions::value(shown, at),
            Self::Difference => difference::value(shown, at),
            Self::Map => map::value(shown, at),
            Self::Agreement => agreement::value(shown, model.ab_settings.in_view, at),
            Self::MaskErrors => mask_errors::value(shown, at),
            Self::ComparedBackground | Self::ComparedForeground | Self::ComparedTracks => {
                let Some(beside) = &shown.compared else { return String::new() };
                match self {
                    Self::ComparedBackground => background::value(beside, Background::Mean, at),
                    Self::ComparedForeground => foreground::value(beside, at),
                    _ => input::value(beside, at),
                }
            }
        }
    }

    /// The layers that it is composed from.
    const fn layers(self, background: Background) -> &'static [Layer] {
        match self {
            // Includes the mask while the overlay is off, so that switching it on uploads nothing.
            Self::Input => Compose::Masked.layers(),
            Self::Background => background.compose().layers(),
            Self::Foreground => Compose::Mask.layers(),
            Self::Regions => Compose::Regions.layers(),
            Self::Tracks | Self::ComparedTracks => Compose::Input.layers(),
            Self::Difference => Compose::Difference.layers(),
            Self::Map => Compose::Map.layers(),
            Self::ComparedBackground => Compose::ComparedMean.layers(),
            Self::ComparedForeground => Compose::ComparedMask.layers(),
            Self::Agreement => Compose::Agreement.layers(),
            Self::MaskErrors => Compose::MaskErrors.layers(),
        }
    }

    /// The composition of its image, without the overlays.
    fn look(self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        match self {
            Self::Input => Some(input::look(pane)),
            Self::Background => Some(background::look(pane)),
            Self::Foreground => Some(ComposeStyle::plain(Compose::Mask)),
            Self::Regions => Some(ComposeStyle::plain(Compose::Regions)),
            Self::Tracks | Self::ComparedTracks => Some(tracks::look()),
            Self::Difference => Some(ComposeStyle::plain(Compose::Difference)),
            Self::Map => map::look(pane),
            Self::ComparedBackground => Some(ComposeStyle::plain(Compose::ComparedMean)),
            Self::ComparedForeground => Some(ComposeStyle::plain(Compose::ComparedMask)),
            Self::Agreement => pane.shown.compared.as_ref().map(|_| agreement::look(pane)),
            Self::MaskErrors => pane.shown.truth.as_ref().map(|_| mask_errors::look()),
        }
    }

    fn paint(self, pane: &Pane<'_>) {
        match self {
            Self::Input => input::paint(pane),
            Self::Background => background::paint(pane),
            Self::Foreground => foreground::paint(pane),
            Self::Regions => regions::paint(pane),
            Self::Tracks => tracks::paint(pane),
            Self::Difference => difference::paint(pane),
            Self::Map => map::paint(pane),
            Self::MaskErrors => mask_errors::paint(pane),
            Self::ComparedBackground | Self::ComparedForeground | Self::ComparedTracks | Self::Agreement => {
                compared::paint(pane);
            }
        }
    }
}

const NO_MIXTURE: &str = "No mixture in this background model";

/// The content of the background view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) enum Background {
    /// The mean of component 1.
    // An earlier version had B here, which is a map now.
    #[serde(alias = "Count")]
    Mean,
    /// The weighted mean of the B background components.
    MultiMode,
}

impl Background {
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

    /// Its composition.
    const fn compose(self) -> Compose {
        match self {
            Self::Mean => Compose::Mean,
            Self::MultiMode => Compose::Modes,
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

/// The data that a view needs for drawing.
struct Pane<'a> {
    view: View,
    painter: &'a Painter,
    canvas: Canvas,
    model: &'a Model,
    shown: &'a ShownFrame,
    composer: &'a Arc<Composer>,
    set: &'a Arc<UploadedFrame>,
    colours: Colours,
}

impl Pane<'_> {
    /// Draws the composed image.
    fn compose(&self, look: ComposeStyle) {
        let shape = Composition::shape(self.composer, self.set, self.view, look, self.canvas);
        if let Some(shape) = shape {
            self.painter.add(shape);
        }
    }
}
