//! The second stage: cleaning of a mask, and its regions.

use std::sync::Arc;

use super::PipelineError;
use crate::frame::{Frame, Mask};
use crate::regions::{Cleaning, Labels, Region, Roi, find_regions};
use crate::settings::Settings;

/// Finds regions in masks, independently of earlier frames.
#[derive(Clone)]
pub(crate) struct RegionFinder {
    /// The region of interest; `None` for the whole image.
    pub(super) roi: Option<Arc<Roi>>,
    cleaning: Cleaning,
    min_area: u32,
}

impl RegionFinder {
    pub(crate) fn new(settings: &Settings, roi: Option<Arc<Roi>>) -> Self {
        Self { roi, cleaning: Cleaning::new(settings), min_area: settings.min_area }
    }

    /// Cleans the model's mask of a frame.
    pub(crate) fn clean(&self, frame: &Frame, mut raw: Mask) -> Result<Mask, PipelineError> {
        let failed = |source| PipelineError::Opencv { frame: frame.number, source };
        if let Some(roi) = &self.roi {
            roi.clear_outside(&mut raw);
        }
        let mut mask = self.cleaning.apply(raw).map_err(failed)?;
        // A closing extends beyond the region of interest, and a filled hole can be ignored.
        if let Some(roi) = &self.roi {
            roi.clear_outside(&mut mask);
        }
        Ok(mask)
    }

    /// Finds the regions of a frame in its cleaned mask.
    pub(crate) fn find(&self, frame: &Frame, mask: &Mask) -> (Labels, Vec<Region>) {
        find_regions(frame, mask, self.min_area)
    }
}
