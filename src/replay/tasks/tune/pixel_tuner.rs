//! Tunes the chosen pixel in the frame in view.

use std::sync::Arc;

use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::{StepwiseTuning, TunableSetting, Tuning, TuningQuery};

/// Computes a [`Tuning`] and stores the last one.
#[derive(Default)]
pub(crate) struct PixelTuner {
    tuned_settings: Option<[TunableSetting; 2]>,
    current: Option<StepwiseTuning>,
    done: Option<Arc<Tuning>>,
}

impl PixelTuner {
    /// Chooses the two settings of the map; `None` for no map.
    pub(crate) const fn choose(&mut self, tuned_settings: Option<[TunableSetting; 2]>) {
        self.tuned_settings = tuned_settings;
    }

    /// Drops all results, after the sequence's first frame has changed.
    pub(crate) fn forget(&mut self) {
        (self.current, self.done) = (None, None);
    }

    /// Advances for the state of `history` at `position`; returns whether there was work to do.
    pub(crate) fn advance(&mut self, history: &PixelHistory, position: u32) -> bool {
        let Some(tuned_settings) = self.tuned_settings else {
            self.forget();
            return false;
        };
        let query = TuningQuery { at: history.at, position, parameters: history.parameters, tuned_settings };
        if self.done.as_ref().is_some_and(|done| done.query() == query) {
            return false;
        }
        let current = match self.current.take() {
            Some(current) if *current.query() == query => self.current.insert(current),
            _ => {
                let Some(values) = history.values_until(position as usize) else { return false };
                self.current.insert(StepwiseTuning::new(query, values))
            }
        };
        if let Some(tuning) = current.advance() {
            (self.current, self.done) = (None, Some(Arc::new(tuning)));
        }
        true
    }

    /// The newest tuning, which may belong to earlier inputs.
    pub(crate) fn latest(&self) -> Option<Arc<Tuning>> {
        self.done.clone()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::explain::tuning::{flip, map};
    use crate::mixture::Parameters;
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
        for tuned_settings in [
            [TunableSetting::Alpha, TunableSetting::Lambda],
            [TunableSetting::T, TunableSetting::K],
            [TunableSetting::InitialSigma, TunableSetting::T],
        ] {
            tuner.choose(Some(tuned_settings));
            for position in [0, 145, 299] {
                let pieces = all_pieces(&mut tuner, &history, position);
                assert!(pieces > TunableSetting::ALL.len());
                assert!(pieces > 16, "at most one run on each side of a value per step: {pieces}");
                let tuning = tuner.latest().unwrap();
                let values: Vec<_> = history.states[..=position as usize].iter().map(|s| s.value).collect();
                assert_eq!(tuning.map, map(&values, &history.parameters, tuned_settings));
                assert_eq!(
                    tuning.flips,
                    TunableSetting::ALL.map(|setting| flip(&values, &history.parameters, setting))
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
