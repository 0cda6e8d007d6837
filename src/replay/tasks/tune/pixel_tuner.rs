//! The chosen pixel's state in the frame in view under other settings, in short steps.

use std::sync::Arc;

use rayon::prelude::*;

use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::{
    FlipSearch, RunOutcome, SettingAxis, TunableSetting, VerdictFlip, VerdictMap, run,
};
use crate::mixture::Parameters;
use crate::mixture::pixel::Value;
use crate::replay::Tuning;

/// Largest number of frames, over all runs, in one step of some milliseconds.
const MAX_FRAMES_PER_STEP: usize = 60_000;

/// Computes a [`Tuning`] and stores the last one.
#[derive(Default)]
pub(crate) struct PixelTuner {
    knobs: Option<[TunableSetting; 2]>,
    job: Option<TuningJob>,
    done: Option<Arc<Tuning>>,
}

/// A [`Tuning`] in progress.
struct TuningJob {
    query: TuningQuery,
    values: Vec<Value>,
    axes: [SettingAxis; 2],
    runs: Vec<Parameters>,
    outcomes: Vec<RunOutcome>,
    search: FlipSearch,
    /// The result of the search.
    flips: Option<Vec<VerdictFlip>>,
}

/// The inputs of a tuning.
#[derive(Clone, PartialEq)]
struct TuningQuery {
    at: (u32, u32),
    position: u32,
    parameters: Parameters,
    knobs: [TunableSetting; 2],
}

impl PixelTuner {
    /// Chooses the two settings of the map; `None` for no map.
    pub(crate) fn choose(&mut self, knobs: Option<[TunableSetting; 2]>) {
        self.knobs = knobs;
    }

    /// Drops all results, after the sequence's first frame has changed.
    pub(crate) fn forget(&mut self) {
        (self.job, self.done) = (None, None);
    }

    /// Advances for the state of `history` at `position`; returns whether there was work to do.
    pub(crate) fn advance(&mut self, history: &PixelHistory, position: u32) -> bool {
        let Some(knobs) = self.knobs else {
            self.forget();
            return false;
        };
        let query = TuningQuery { at: history.at, position, parameters: history.parameters, knobs };
        if self.done.as_ref().is_some_and(|done| TuningQuery::of(done) == query) {
            return false;
        }
        let job = match self.job.take() {
            Some(job) if job.query == query => self.job.insert(job),
            _ => {
                let Some(values) = history.values_until(position as usize) else { return false };
                self.job.insert(TuningJob::new(query, values))
            }
        };
        if let Some(tuning) = job.advance() {
            (self.job, self.done) = (None, Some(Arc::new(tuning)));
        }
        true
    }

    /// The newest tuning, which may belong to earlier inputs.
    pub(crate) fn latest(&self) -> Option<Arc<Tuning>> {
        self.done.clone()
    }
}

impl TuningQuery {
    fn of(tuning: &Tuning) -> Self {
        let knobs = tuning.map.axes.each_ref().map(|axis| axis.knob);
        Self { at: tuning.at, position: tuning.position, parameters: tuning.parameters, knobs }
    }
}

impl TuningJob {
    fn new(query: TuningQuery, values: Vec<Value>) -> Self {
        let axes = VerdictMap::axes(&query.parameters, query.knobs);
        let runs = VerdictMap::runs(&query.parameters, &axes);
        let search = FlipSearch::new(&query.parameters, &TunableSetting::ALL);
        Self { query, values, axes, runs, outcomes: Vec::new(), search, flips: None }
    }

    /// Advances by one step; returns the tuning if it is complete.
    fn advance(&mut self) -> Option<Tuning> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::explain::tuning::{flip, map};
    use crate::settings::{Preset, Settings};

    fn history(alpha: f32) -> PixelHistory {
        let parameters = Parameters::new(&Settings { alpha, ..Settings::preset(Preset::Plain) });
        let colours = (1..=300).map(|n| (n, [(n * 37 % 9 + if n % 50 > 40 { 120 } else { 60 }) as u8; 3]));
        PixelHistory::of_colours((2, 3), parameters, colours)
    }

    fn all_pieces(tuner: &mut PixelTuner, history: &PixelHistory, position: u32) -> usize {
        (0..2000).take_while(|_| tuner.advance(history, position)).count()
    }

    #[test]
    fn a_tuning_in_steps_equals_one_at_once_and_is_computed_once() {
        let (mut tuner, history) = (PixelTuner::default(), history(0.01));
        assert!(!tuner.advance(&history, 200), "no request is pending");
        for knobs in [
            [TunableSetting::Alpha, TunableSetting::Lambda],
            [TunableSetting::T, TunableSetting::K],
            [TunableSetting::InitialSigma, TunableSetting::T],
        ] {
            tuner.choose(Some(knobs));
            for position in [0, 145, 299] {
                let pieces = all_pieces(&mut tuner, &history, position);
                assert!(pieces > TunableSetting::ALL.len());
                assert!(pieces > 16, "at most one run on each side of a value per step: {pieces}");
                let tuning = tuner.latest().unwrap();
                let values: Vec<_> = history.states[..=position as usize].iter().map(|s| s.value).collect();
                assert_eq!(tuning.map, map(&values, &history.parameters, knobs));
                assert_eq!(
                    tuning.flips,
                    TunableSetting::ALL.map(|knob| flip(&values, &history.parameters, knob))
                );
                assert_eq!((tuning.at, tuning.position), ((2, 3), position));
                assert!(!tuner.advance(&history, position));
            }
        }
        assert!(!tuner.advance(&history, 300), "the frame is unknown");
    }

    #[test]
    fn a_newer_tuning_request_replaces_the_current_one() {
        let (mut tuner, one, other) = (PixelTuner::default(), history(0.01), history(0.2));
        tuner.choose(Some([TunableSetting::Alpha, TunableSetting::Lambda]));
        for _ in 0..7 {
            tuner.advance(&one, 250);
        }
        all_pieces(&mut tuner, &other, 245);
        let tuning = tuner.latest().unwrap();
        let values: Vec<_> = other.states[..=245].iter().map(|s| s.value).collect();
        assert_eq!(
            tuning.map,
            map(&values, &other.parameters, [TunableSetting::Alpha, TunableSetting::Lambda])
        );
        assert_eq!(tuning.parameters, other.parameters);
    }
}
