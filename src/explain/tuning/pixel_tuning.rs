//! The state of one pixel in one frame under other settings, computed in short steps.

use rayon::prelude::*;

use super::{FlipSearch, RunOutcome, SettingAxis, TunableSetting, VerdictFlip, VerdictMap, run};
use crate::mixture::pixel::{Parameters, PixelValue};

/// Largest number of frames, over all runs, in one step of some milliseconds.
const MAX_FRAMES_PER_STEP: usize = 60_000;

/// The state of one pixel in one frame under other settings of the mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The frame's position in the sequence, from 0.
    pub position: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// The verdict over a grid of two settings.
    pub map: VerdictMap,
    /// For each setting the nearest value that flips the verdict.
    pub flips: Vec<VerdictFlip>,
}

impl Tuning {
    /// The inputs from which it was computed.
    pub fn query(&self) -> TuningQuery {
        let tuned_settings = self.map.axes.each_ref().map(|axis| axis.setting);
        TuningQuery { at: self.at, position: self.position, parameters: self.parameters, tuned_settings }
    }
}

/// The inputs of a [`Tuning`].
#[derive(Clone, PartialEq)]
pub struct TuningQuery {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The frame's position in the sequence, from 0.
    pub position: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// The two settings of the map.
    pub tuned_settings: [TunableSetting; 2],
}

/// A [`Tuning`] in progress.
pub struct StepwiseTuning {
    query: TuningQuery,
    values: Vec<PixelValue>,
    axes: [SettingAxis; 2],
    runs: Vec<Parameters>,
    outcomes: Vec<RunOutcome>,
    search: FlipSearch,
    /// The result of the search.
    flips: Option<Vec<VerdictFlip>>,
}

impl StepwiseTuning {
    /// A tuning before its first step; `values` are the pixel's, from the model's start to the frame.
    pub fn new(query: TuningQuery, values: Vec<PixelValue>) -> Self {
        let axes = VerdictMap::axes(&query.parameters, query.tuned_settings);
        let runs = VerdictMap::runs(&query.parameters, &axes);
        let search = FlipSearch::new(&query.parameters, &TunableSetting::ALL);
        Self { query, values, axes, runs, outcomes: Vec::new(), search, flips: None }
    }

    /// Its inputs.
    pub const fn query(&self) -> &TuningQuery {
        &self.query
    }

    /// Advances by one step; returns the tuning if it is complete.
    pub fn advance(&mut self) -> Option<Tuning> {
        let TuningQuery { at, position, parameters, .. } = self.query;
        if self.flips.is_none() {
            self.flips = self.search.advance(&self.values);
            return None;
        }
        let done = self.outcomes.len();
        // At least one run per thread, however long the history is.
        let most = (MAX_FRAMES_PER_STEP / self.values.len().max(1)).max(rayon::current_num_threads());
        let next = &self.runs[done..self.runs.len().min(done + most)];
        self.outcomes.par_extend(next.par_iter().map(|parameters| run(&self.values, parameters)));
        if self.outcomes.len() < self.runs.len() {
            return None;
        }
        let map = VerdictMap::of(&parameters, self.axes.clone(), &self.outcomes);
        Some(Tuning { at, position, parameters, map, flips: self.flips.take().unwrap_or_default() })
    }
}
