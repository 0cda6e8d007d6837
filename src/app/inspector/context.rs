//! The data that the inspector shows besides the chosen pixel's history, and its requests for them.

use std::sync::Arc;

use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::RegionShares;
use crate::explain::tuning::{RegionTuning, TunableSetting};
use crate::placement::Placement;
use crate::replay::WorkProgress;

/// The data that the inspector shows besides the chosen pixel's history.
#[derive(Clone, Copy, Default)]
pub struct InspectorContext<'a> {
    /// The chosen pixel.
    pub chosen: Option<(u32, u32)>,
    /// Where the frames lie in the source's images, if they are not these images.
    pub placement: Option<Placement>,
    /// The pinned pixels, with their numbers.
    pub pins: &'a [(u8, (u32, u32))],
    /// The available histories of the pinned pixels.
    pub histories: &'a [Arc<PixelHistory>],
    /// The pinned pixels whose history can never be computed.
    pub lost: &'a [(u32, u32)],
    /// How far the chosen pixel has been followed, while its history is computed.
    pub progress: Option<&'a WorkProgress>,
    /// The foreground ratio around the chosen pixel, if [`InspectorRequests::shares_side`] requests it.
    pub shares: Option<&'a Arc<RegionShares>>,
    /// The accuracy around the chosen pixel, by the ground truth.
    pub accuracy: RegionAccuracy<'a>,
}

impl InspectorContext<'_> {
    /// The pixel of the source's images, which is what the user sees.
    pub(super) fn source_pixel(&self, at: (u32, u32)) -> (u32, u32) {
        self.placement.map_or(at, |placement| placement.source_pixel(at))
    }
}

/// Accuracy in the region around the chosen pixel, by the ground truth.
#[derive(Clone, Copy, Default)]
pub struct RegionAccuracy<'a> {
    /// Whether there are ground-truth masks.
    pub has_masks: bool,
    /// The tuning of the region, if [`InspectorRequests::accuracy_side`] requests it.
    pub tuning: Option<&'a Arc<RegionTuning>>,
}

/// The data that the visible tab requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InspectorRequests {
    /// The two settings of the tuning map.
    pub tuning_axes: Option<[TunableSetting; 2]>,
    /// The side in pixels of the region whose accuracy is requested.
    pub accuracy_side: Option<u32>,
    /// The side in pixels of the region whose foreground ratio is requested.
    pub shares_side: Option<u32>,
}
