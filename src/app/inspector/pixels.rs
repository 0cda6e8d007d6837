//! Several pixels at once: the foreground ratio around the chosen pixel, and the pinned pixels.

use std::sync::Arc;

use eframe::egui::Ui;

use super::action::InspectorAction;
use super::context::InspectorContext;
use super::frame_axis::FramePosition;
use super::pinned_pixels::PinnedPixelsView;
use super::region_shares::RegionSharesView;
use crate::explain::pixel::PixelHistory;

/// The two parts of the tab.
#[derive(Default)]
pub(super) struct PixelsView {
    /// The foreground ratio around the chosen pixel.
    pub(super) region: RegionSharesView,
    /// The pinned pixels.
    pub(super) pins: PinnedPixelsView,
}

impl PixelsView {
    /// Draws the region around `chosen` and the pins.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &Arc<PixelHistory>,
        here: FramePosition<'_>,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        let region = self.region.ui(ui, chosen, here, context.shares);
        ui.add_space(10.0);
        self.pins.ui(ui, here, context).or(region)
    }

    /// Drops all cached columns.
    pub(super) fn forget(&mut self) {
        self.region.forget();
        self.pins.forget();
    }
}
