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
mod pointer;
mod ramp;
mod regions;
mod tiles;
mod title_bar;
mod tracks;

pub(crate) use canvas::ViewCanvas;
pub(crate) use layouts::{is_open, set_open, tree_of};
#[cfg(test)]
pub(crate) use loupe::{picture as loupe_picture, place as loupe_place, words as loupe_words};
pub(crate) use pictures::FrameUploads;
pub(crate) use tiles::show;

use std::sync::Arc;

use eframe::egui::Painter;

use self::compose::{Compose, ComposeStyle, Composer, Composition};
use self::layer::ViewLayer;
use self::pictures::UploadedFrame;
use crate::app::model::Model;
use crate::app::model::view::{BackgroundDisplay, View};
use crate::app::theme::Colours;
use crate::replay::ShownFrame;

/// The value of a pixel in a view, with parts separated by spaces.
pub(crate) fn pixel_value(view: View, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
    match view {
        View::Input | View::Tracks => input::value(shown, at),
        View::Background => background::value(shown, model.display.background, at),
        View::Foreground => foreground::value(shown, at),
        View::Regions => regions::value(shown, at),
        View::Difference => difference::value(shown, at),
        View::Map => map::value(shown, at),
        View::Agreement => agreement::value(shown, model.edits.ab_settings.in_view, at),
        View::MaskErrors => mask_errors::value(shown, at),
        View::ComparedBackground | View::ComparedForeground | View::ComparedTracks => {
            let Some(compared) = &shown.compared else { return String::new() };
            match view {
                View::ComparedBackground => background::value(compared, BackgroundDisplay::Mean, at),
                View::ComparedForeground => foreground::value(compared, at),
                _ => input::value(compared, at),
            }
        }
    }
}

impl View {
    /// The layers that it is composed from.
    const fn layers(self, background: BackgroundDisplay) -> &'static [ViewLayer] {
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
    fn compose_style(self, pane: &Pane<'_>) -> Option<ComposeStyle> {
        match self {
            Self::Input => Some(input::compose_style(pane)),
            Self::Background => Some(background::compose_style(pane)),
            Self::Foreground => Some(ComposeStyle::plain(Compose::Mask)),
            Self::Regions => Some(ComposeStyle::plain(Compose::Regions)),
            Self::Tracks | Self::ComparedTracks => Some(tracks::compose_style()),
            Self::Difference => Some(ComposeStyle::plain(Compose::Difference)),
            Self::Map => map::compose_style(pane),
            Self::ComparedBackground => Some(ComposeStyle::plain(Compose::ComparedMean)),
            Self::ComparedForeground => Some(ComposeStyle::plain(Compose::ComparedMask)),
            Self::Agreement => pane.shown.compared.as_ref().map(|_| agreement::compose_style(pane)),
            Self::MaskErrors => pane.shown.truth.as_ref().map(|_| mask_errors::compose_style()),
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

impl BackgroundDisplay {
    /// Its composition.
    const fn compose(self) -> Compose {
        match self {
            Self::Mean => Compose::Mean,
            Self::MultiMode => Compose::Modes,
        }
    }
}

/// The data that a view needs for drawing.
struct Pane<'a> {
    view: View,
    painter: &'a Painter,
    canvas: ViewCanvas,
    model: &'a Model,
    shown: &'a ShownFrame,
    composer: &'a Arc<Composer>,
    set: &'a Arc<UploadedFrame>,
    colours: Colours,
}

impl Pane<'_> {
    /// Draws the composed image.
    fn compose(&self, style: ComposeStyle) {
        let shape = Composition::shape(self.composer, self.set, self.view, style, self.canvas);
        if let Some(shape) = shape {
            self.painter.add(shape);
        }
    }
}
