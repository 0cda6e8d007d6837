//! A frame on the graphics card.

use std::sync::Arc;
use std::time::Duration;

use eframe::egui_wgpu::wgpu;

use super::layer::ViewLayer;
use super::layer_upload::UploadedLayers;
use super::mask_agreement::MaskAgreement;
use crate::app::model::trails::FrameWithTrails;
use crate::frame::Size;
use crate::truth::decisions::Decisions;

/// A frame whose layers are uploaded.
pub(crate) struct UploadedFrame {
    /// The frame.
    pub(super) frame: Arc<FrameWithTrails>,
    /// The index of its video.
    pub(super) video: u32,
    /// The sampling step from pixels to texels.
    pub(super) every: u32,
    /// The layers.
    pub(super) uploaded: UploadedLayers,
    /// The bind group of the layers.
    pub(super) group: wgpu::BindGroup,
    /// The agreement of its mask with the mask of the compared settings, if both exist.
    pub(super) agreement: Option<MaskAgreement>,
    /// The decisions of its mask against the ground truth, if there is a ground-truth mask and its view is visible.
    pub(super) decisions: Option<Decisions>,
    /// The agreement of its mask with the external mask, if there is one and its view is visible.
    pub(super) external_agreement: Option<MaskAgreement>,
    /// The decisions of the external mask against the ground truth, if there are both and their view is visible.
    pub(super) external_decisions: Option<Decisions>,
    /// The duration of the upload.
    pub(super) took: Duration,
    /// The number of uploaded bytes. Unchanged layers of the previous frame are reused.
    pub(super) bytes: u64,
}

impl UploadedFrame {
    /// The frame.
    pub(crate) const fn frame(&self) -> &Arc<FrameWithTrails> {
        &self.frame
    }

    /// Whether a layer is there.
    pub(crate) const fn has(&self, layer: ViewLayer) -> bool {
        self.uploaded[layer as usize].is_some()
    }

    /// Width and height in texels.
    pub(crate) fn texels(&self) -> Size {
        ViewLayer::Input.texels(&self.frame.shown, self.every)
    }

    /// The decisions of its mask against the ground truth.
    #[cfg(test)]
    pub(crate) const fn decisions(&self) -> Option<Decisions> {
        self.decisions
    }

    /// The agreement of its mask with the external mask.
    #[cfg(test)]
    pub(crate) const fn external_agreement(&self) -> Option<MaskAgreement> {
        self.external_agreement
    }

    /// The decisions of the external mask against the ground truth.
    #[cfg(test)]
    pub(crate) const fn external_decisions(&self) -> Option<Decisions> {
        self.external_decisions
    }

    /// The duration of the upload.
    pub(crate) const fn duration(&self) -> Duration {
        self.took
    }

    /// The number of uploaded bytes.
    pub(crate) const fn bytes(&self) -> u64 {
        self.bytes
    }
}
