//! Accuracy of the mixture in a region under other settings, computed in short steps.

use rayon::prelude::*;

use super::{SettingAxis, TunableSetting, grid};
use crate::frame::Frame;
use crate::mixture::pixel::Parameters;
use crate::truth::decisions::Decisions;
use crate::truth::masks::TrueMask;
use crate::truth::mixture_score::of_mixture;

/// Largest number of values, over all runs, in one step of some milliseconds.
const MAX_VALUES_PER_STEP: usize = 1_000_000;

/// Accuracy of the mixture in a region, against true masks and before cleaning, under other settings.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionTuning {
    /// The centre pixel: column and row.
    pub at: (u32, u32),
    /// Side of the region in pixels; it is clipped at the image's edge.
    pub side: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// Number of columns and rows of pixels that are scored.
    pub extent: [u32; 2],
    /// Number of scored frames.
    pub frames: usize,
    /// The counts of decisions under [`Self::parameters`].
    pub present: Decisions,
    /// The settings along a row and along a column.
    pub axes: [SettingAxis; 2],
    /// The counts of decisions in each cell, row by row.
    pub cells: Vec<Decisions>,
}

/// The inputs of a [`RegionTuning`].
#[derive(Clone, PartialEq)]
pub struct RegionTuningQuery {
    /// The centre pixel: column and row.
    pub at: (u32, u32),
    /// Side of the region in pixels.
    pub side: u32,
    /// The two settings of the grid.
    pub tuned_settings: [TunableSetting; 2],
    /// The present parameters.
    pub parameters: Parameters,
    /// Number of frames, scored or not.
    pub frames: usize,
}

/// A [`RegionTuning`] in progress.
pub struct StepwiseRegionTuning {
    query: RegionTuningQuery,
    axes: [SettingAxis; 2],
    truth: Vec<Option<TrueMask>>,
    /// The present parameters, then those of each cell.
    runs: Vec<Parameters>,
    decisions: Vec<Decisions>,
}

impl StepwiseRegionTuning {
    /// A tuning before its first step; `truth` is the true mask of the region in each frame, if there is one.
    pub fn new(query: RegionTuningQuery, truth: Vec<Option<TrueMask>>) -> Self {
        let (axes, cells) = grid(&query.parameters, query.tuned_settings);
        let mut runs = vec![query.parameters];
        runs.extend(cells);
        Self { query, axes, truth, runs, decisions: Vec::new() }
    }

    /// Its inputs.
    pub const fn query(&self) -> &RegionTuningQuery {
        &self.query
    }

    /// Number of finished runs, and of all.
    pub const fn progress(&self) -> (usize, usize) {
        (self.decisions.len(), self.runs.len())
    }

    /// Advances by one step on the region in all frames; returns the tuning if it is complete.
    pub fn advance(&mut self, frames: &[Frame]) -> Option<RegionTuning> {
        let values = frames.first().map_or(1, |frame| frame.size.pixels()) * frames.len();
        // At least one run per thread, whatever its length.
        let most = (MAX_VALUES_PER_STEP / values.max(1)).max(rayon::current_num_threads());
        let done = self.decisions.len();
        let next = &self.runs[done..self.runs.len().min(done + most)];
        let truth = &self.truth;
        self.decisions.par_extend(next.par_iter().map(|run| of_mixture(frames, truth, *run)));
        if self.decisions.len() < self.runs.len() {
            return None;
        }
        let RegionTuningQuery { at, side, parameters, .. } = self.query;
        let extent = frames.first().map_or([0; 2], |frame| [frame.size.width, frame.size.height]);
        let mut decisions = std::mem::take(&mut self.decisions).into_iter();
        Some(RegionTuning {
            at,
            side,
            parameters,
            extent,
            frames: self.truth.iter().flatten().count(),
            present: decisions.next().unwrap_or_default(),
            axes: self.axes.clone(),
            cells: decisions.collect(),
        })
    }
}
