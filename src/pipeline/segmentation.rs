//! The stages before tracking: the background model, cleaning, and regions.

use std::sync::Arc;

use rayon::prelude::*;

use super::{BackgroundSubtractor, PipelineError, RegionFinder};
use crate::frame::{Frame, Mask, Size};
use crate::regions::{Labels, Region};
use crate::settings::Settings;

/// The results of the stages before tracking for one frame.
#[derive(Clone, Debug)]
pub(crate) struct SegmentedFrame {
    /// The frame number in the source.
    pub(super) number: u32,
    /// The frame's time in seconds since the source's first frame.
    pub(super) time: f64,
    /// The mask after cleaning, before `min_area`.
    pub(super) mask: Arc<Mask>,
    /// The region of each pixel.
    pub(super) labels: Arc<Labels>,
    /// The regions, by label.
    pub(super) regions: Arc<Vec<Region>>,
}

/// The stages before tracking with their state.
pub(super) struct Segmentation {
    size: Size,
    pub(super) model: BackgroundSubtractor,
    pub(super) region_finder: RegionFinder,
}

impl Segmentation {
    pub(super) fn new(settings: &Settings, size: Size) -> Result<Self, PipelineError> {
        let model = BackgroundSubtractor::new(settings, size)?;
        Ok(Self { size, model, region_finder: RegionFinder::new(settings, None) })
    }

    pub(super) const fn size(&self) -> Size {
        self.size
    }

    pub(super) fn learn(&mut self, frames: &[&Frame]) -> Result<(), PipelineError> {
        self.check_sizes(frames)?;
        self.model.learn(frames)
    }

    pub(super) fn masks(&mut self, frames: &[&Frame]) -> Result<Vec<Mask>, PipelineError> {
        self.check_sizes(frames)?;
        self.model.masks(frames)
    }

    /// Cleans the model's masks of these frames and finds their regions.
    pub(super) fn regions(
        &self,
        frames: &[&Frame],
        raw: Vec<Mask>,
    ) -> Result<Vec<SegmentedFrame>, PipelineError> {
        let finder = &self.region_finder;
        let regions_of = |(frame, raw): (&&Frame, Mask)| {
            let mask = finder.clean(frame, raw)?;
            let (labels, regions) = finder.find(frame, &mask);
            Ok(SegmentedFrame {
                number: frame.number,
                time: frame.time,
                mask: Arc::new(mask),
                labels: Arc::new(labels),
                regions: Arc::new(regions),
            })
        };
        frames.par_iter().zip(raw).map(regions_of).collect()
    }

    /// Processes the next frames.
    pub(super) fn step_many(&mut self, frames: &[&Frame]) -> Result<Vec<SegmentedFrame>, PipelineError> {
        let raw = self.masks(frames)?;
        self.regions(frames, raw)
    }

    /// A copy of the current state; `None` for MOG2 and KNN, whose state cannot be copied.
    pub(super) fn try_clone(&self) -> Option<Self> {
        let (model, region_finder) = (self.model.try_clone()?, self.region_finder.clone());
        Some(Self { model, region_finder, ..*self })
    }

    fn check_sizes(&self, frames: &[&Frame]) -> Result<(), PipelineError> {
        frames.iter().find(|frame| frame.size != self.size).map_or(Ok(()), |other| {
            let (found, expected) = (other.size, self.size);
            Err(PipelineError::Size { frame: other.number, found, expected })
        })
    }
}
