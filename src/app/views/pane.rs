//! What a view shows, and the data that it needs for drawing.

use std::sync::Arc;

use eframe::egui::Painter;

use super::canvas::ViewCanvas;
use super::compose_style::ComposeStyle;
use super::composer::Composer;
use super::composition::Composition;
use super::layer::ViewLayer;
use super::uploaded_frame::UploadedFrame;
use crate::app::model::Model;
use crate::app::model::view::{BackgroundDisplay, View};
use crate::app::theme::Colours;
use crate::replay::ShownFrame;

/// The content of a view.
pub(super) trait ViewContent {
    /// The layers that its image is composed from, with this kind of background.
    fn layers(&self, background: BackgroundDisplay) -> &'static [ViewLayer];

    /// The composition of its image, without the overlays; `None` where there is nothing to show.
    fn compose_style(&self, pane: &Pane<'_>) -> Option<ComposeStyle>;

    /// Draws its image and the overlays, or a message where there is nothing to show.
    fn paint(&self, pane: &Pane<'_>);

    /// The value of a pixel, with parts separated by spaces.
    fn value(&self, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String;
}

/// The data that a view needs for drawing.
pub(super) struct Pane<'a> {
    /// The view.
    pub(super) view: View,
    /// Draws within the view.
    pub(super) painter: &'a Painter,
    /// The position of the image.
    pub(super) canvas: ViewCanvas,
    /// The window's state.
    pub(super) model: &'a Model,
    /// The frame.
    pub(super) shown: &'a ShownFrame,
    /// Composes the image.
    pub(super) composer: &'a Arc<Composer>,
    /// The layers of the frame.
    pub(super) set: &'a Arc<UploadedFrame>,
    /// The colours of the theme.
    pub(super) colours: Colours,
}

impl Pane<'_> {
    /// Draws the composed image.
    pub(super) fn compose(&self, style: ComposeStyle) {
        let shape = Composition::shape(self.composer, self.set, self.view, style, self.canvas);
        if let Some(shape) = shape {
            self.painter.add(shape);
        }
    }
}
