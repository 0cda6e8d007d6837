//! The results of the frames, kept until the files with the offline result are written.

use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::input_hash::{hexadecimal, is_images};
use crate::export::regions_csv::{FrameRows, RegionRow};
use crate::export::source_pixels;
use crate::frame::{Frame, Mask, Size};
use crate::pipeline::{Analysis, OfflineResult, Pipeline, offline_result};
use crate::placement::Placement;
use crate::regions::{Labels, Region};
use crate::source::SourceInfo;

/// The recorded results of the whole sequence.
pub(super) struct RunRecord {
    pub result: OfflineResult,
    /// The regions of each frame, in order.
    pub regions: Vec<FrameRows>,
    /// Mean share of foreground pixels, 0..=1.
    pub foreground_share: f64,
    /// Warnings about the input, one sentence each.
    pub warnings: Vec<String>,
    /// The hash of all decoded frames; `None` for a camera or a video file, which has its own hash.
    pub frames_hash: Option<String>,
}

impl RunRecord {
    /// Moves the results from the pixels of the frames to those of the source.
    pub(super) fn move_to_source(&mut self, placement: &Placement) {
        source_pixels::move_tracks(&mut self.result.tracks, placement);
        source_pixels::move_events(&mut self.result.events, placement);
        source_pixels::move_regions(&mut self.regions, placement);
    }
}

/// Records the results frame by frame.
pub(super) struct ResultRecorder {
    size: Size,
    analyses: Vec<Analysis>,
    regions: Vec<FrameRows>,
    foreground_pixels: usize,
    warnings: Vec<String>,
    hasher: Option<Sha256>,
    no_mask: Arc<Mask>,
    no_labels: Arc<Labels>,
    no_regions: Arc<Vec<Region>>,
}

impl ResultRecorder {
    /// Before the first frame of this source.
    pub(super) fn new(info: &SourceInfo) -> Self {
        Self {
            size: info.size,
            analyses: Vec::new(),
            regions: Vec::new(),
            foreground_pixels: 0,
            warnings: Vec::new(),
            hasher: is_images(info).then(Sha256::new),
            no_mask: Arc::new(Mask::empty(Size::new(0, 0))),
            no_labels: Arc::new(Labels::none(Size::new(0, 0))),
            no_regions: Arc::new(Vec::new()),
        }
    }

    /// Adds the next frame.
    pub(super) fn add(&mut self, frame: &Frame, analysis: Analysis) {
        if let Some(hasher) = &mut self.hasher {
            hasher.update(&frame.rgb);
        }
        self.foreground_pixels += analysis.mask.foreground_pixels();
        let rows = analysis.regions.iter().map(RegionRow::from).collect();
        self.regions.push(FrameRows { number: frame.number, rows });
        // Masks, labels and histograms would exceed the memory, and the offline result does not need them.
        self.analyses.push(Analysis {
            mask: self.no_mask.clone(),
            labels: self.no_labels.clone(),
            regions: self.no_regions.clone(),
            ..analysis
        });
    }

    /// Adds a warning about the input.
    pub(super) fn add_warning(&mut self, text: String) {
        self.warnings.push(text);
    }

    /// The record of all added frames; `None` without frames.
    pub(super) fn finish(self, pipeline: &Pipeline) -> Option<RunRecord> {
        if self.analyses.is_empty() {
            return None;
        }
        let pixels = self.analyses.len() * self.size.pixels();
        Some(RunRecord {
            result: offline_result(&self.analyses, pipeline),
            foreground_share: self.foreground_pixels as f64 / pixels as f64,
            regions: self.regions,
            warnings: self.warnings,
            frames_hash: self.hasher.map(|hasher| hexadecimal(&hasher.finalize())),
        })
    }
}
