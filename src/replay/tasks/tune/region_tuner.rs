//! Collects a region of all frames, and tunes the mixture in it.

use std::ops::Range;
use std::sync::Arc;

use crate::explain::pixel::region_shares::{PixelRegion, region_bounds};
use crate::explain::tuning::{RegionTuning, RegionTuningQuery, StepwiseRegionTuning, TunableSetting};
use crate::frame::{Frame, Size};
use crate::mixture::Parameters;
use crate::registration::{CorrectionChoice, corrected};
use crate::replay::tasks::gather::frame_consumer::FrameConsumer;
use crate::settings::{BackgroundModel, Settings};
use crate::source::SourceInfo;
use crate::truth::masks::{TrueMask, TrueMasks};

/// Computes a [`RegionTuning`] and stores the last one.
#[derive(Default)]
pub(crate) struct RegionTuner {
    region: Option<RegionFrames>,
    /// Number of first frames that are learned from before classification.
    to_learn: u32,
    /// The correction of the collected frames.
    registration: CorrectionChoice,
    tuned_settings: Option<[TunableSetting; 2]>,
    truth: Option<Arc<TrueMasks>>,
    current: Option<StepwiseRegionTuning>,
    done: Option<(RegionTuningQuery, Arc<RegionTuning>)>,
}

/// The pixels of the region in all frames so far.
struct RegionFrames {
    region: PixelRegion,
    columns: Range<u32>,
    rows: Range<u32>,
    frames: Vec<Frame>,
}

impl RegionFrames {
    /// The true masks of the region in each of its frames.
    fn true_masks(&self, truth: &TrueMasks) -> Vec<Option<TrueMask>> {
        let masks = self.frames.iter().map(|frame| truth.of(frame.number));
        masks.map(|mask| mask.map(|mask| mask.cut(&self.columns, &self.rows))).collect()
    }
}

impl RegionTuner {
    /// Chooses a region of an image of `size`, or none.
    pub(crate) fn choose(&mut self, region: Option<PixelRegion>, size: Size) {
        let region = region.filter(|region| region.is_centred_in(size));
        if self.region.as_ref().map(|frames| frames.region) != region {
            self.region = region.map(|region| {
                let (columns, rows) = region_bounds(region.centre, region.side, size);
                RegionFrames { region, columns, rows, frames: Vec::new() }
            });
            (self.current, self.done) = (None, None);
        }
    }

    /// Applies the settings; drops frames collected under another correction.
    pub(crate) fn set_settings(&mut self, settings: &Settings, info: &SourceInfo) {
        self.to_learn = info.bootstrap(settings);
        let registration = CorrectionChoice::new(settings);
        if registration != self.registration {
            self.registration = registration;
            if let Some(region) = &mut self.region {
                region.frames.clear();
            }
            (self.current, self.done) = (None, None);
        }
    }

    /// Chooses the two settings of the grid; `None` for no grid.
    pub(crate) const fn tune(&mut self, tuned_settings: Option<[TunableSetting; 2]>) {
        self.tuned_settings = tuned_settings;
    }

    /// Sets the true masks, which have the size of the frames.
    pub(crate) fn set_truth(&mut self, truth: Option<Arc<TrueMasks>>) {
        self.truth = truth;
        (self.current, self.done) = (None, None);
    }

    /// Drops all frames and results, after the sequence's first frame has changed.
    pub(crate) fn forget(&mut self) {
        self.lose();
        (self.current, self.done) = (None, None);
    }

    /// Advances on the collected frames; returns the number of finished runs and of all runs, if there was work to
    /// do.
    pub(crate) fn advance(&mut self, settings: &Settings) -> Option<(usize, usize)> {
        let mixture = settings.background_model == BackgroundModel::Mixture;
        let (Some(region), Some(tuned_settings), Some(truth)) =
            (&self.region, self.tuned_settings, &self.truth)
        else {
            return None;
        };
        let PixelRegion { centre: at, side } = region.region;
        let frames = region.frames.len();
        let learnt = self.to_learn.min(frames as u32);
        let parameters = Parameters { learnt, ..Parameters::new(settings) };
        let query = RegionTuningQuery { at, side, tuned_settings, parameters, frames };
        let known = self.done.as_ref().is_some_and(|(done, _)| *done == query);
        if known || frames == 0 || !mixture {
            return None;
        }
        let current = match self.current.take() {
            Some(current) if *current.query() == query => self.current.insert(current),
            _ => self.current.insert(StepwiseRegionTuning::new(query.clone(), region.true_masks(truth))),
        };
        let progress = current.progress();
        if let Some(tuning) = current.advance(&region.frames) {
            self.current = None;
            self.done = Some((query, Arc::new(tuning)));
        }
        Some(progress)
    }

    /// The newest tuning, which may belong to earlier inputs.
    pub(crate) fn latest(&self) -> Option<Arc<RegionTuning>> {
        self.done.as_ref().map(|(_, tuning)| Arc::clone(tuning))
    }
}

impl FrameConsumer for RegionTuner {
    fn next(&self) -> Option<u32> {
        let (region, truth) = self.region.as_ref().zip(self.truth.as_ref())?;
        let more = region.frames.len() < self.to_learn as usize
            || region.frames.last().is_none_or(|frame| frame.number < truth.last());
        more.then_some(region.frames.len() as u32)
    }

    fn push(&mut self, position: u32, frame: &Frame) {
        if self.next() == Some(position)
            && let Some(region) = &mut self.region
        {
            region.frames.push(match corrected(frame, self.registration) {
                Some(corrected) => corrected.frame.cut(&region.columns, &region.rows),
                None => frame.cut(&region.columns, &region.rows),
            });
        }
    }

    fn lose(&mut self) {
        self.region = None;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::collections::BTreeMap;

    use super::*;
    use crate::settings::Preset;
    use crate::synth::{self, SceneParameters};
    use crate::truth::mixture_score::of_mixture;

    #[test]
    fn every_cell_computed_in_steps_equals_a_run_of_its_settings() {
        let parameters = SceneParameters { size: Size::new(64, 48), ..SceneParameters::default() };
        let scene = synth::catalogue::scene("crossing", &parameters).unwrap();
        let (mut frames, mut masks) = (Vec::new(), BTreeMap::new());
        for (frame, truth) in synth::render(&scene).take(90) {
            let number = frame.number;
            frames.push(frame);
            if number % 4 == 0 && number < 80 {
                masks.insert(number, Arc::new(TrueMask::of_identities(truth.size, &truth.identities)));
            }
        }
        let truth = Arc::new(TrueMasks::new(masks).unwrap());
        let settings = Settings::preset(Preset::Plain);
        let mut tuner = RegionTuner::default();
        tuner.choose(Some(PixelRegion { centre: (30, 30), side: 5 }), frames[0].size);
        assert!(tuner.next().is_none() && tuner.advance(&settings).is_none(), "without true masks");
        tuner.set_truth(Some(Arc::clone(&truth)));
        while let Some(next) = tuner.next() {
            tuner.push(next, &frames[next as usize]);
        }
        assert_eq!(tuner.region.as_ref().unwrap().frames.len(), 76, "no frame after the last scored one");
        assert!(tuner.advance(&settings).is_none(), "no request is pending");
        let part: Vec<_> = frames[..76].iter().map(|frame| frame.cut(&(28..33), &(28..33))).collect();
        let labels: Vec<_> =
            part.iter().map(|frame| Some(truth.of(frame.number)?.cut(&(28..33), &(28..33)))).collect();
        for tuned_settings in
            [[TunableSetting::Alpha, TunableSetting::T], [TunableSetting::K, TunableSetting::Lambda]]
        {
            tuner.tune(Some(tuned_settings));
            let pieces = std::iter::from_fn(|| tuner.advance(&settings)).count();
            assert!(pieces > usize::from(tuned_settings[0] == TunableSetting::Alpha), "{pieces}");
            let tuning = tuner.latest().unwrap();
            let [across, up] = &tuning.axes;
            assert_eq!(tuning.cells.len(), across.values.len() * up.values.len());
            assert_eq!((tuning.frames, tuning.present.all()), (19, 19 * 25));
            for (column, row) in [(0, 0), (5, 2), (1, up.values.len() - 1)] {
                let cell = tuned_settings[1].with(&tuning.parameters, up.values[row]);
                let cell = tuned_settings[0].with(&cell, across.values[column]);
                let expected = of_mixture(&part, &labels, cell);
                assert_eq!(tuning.cells[row * across.values.len() + column], expected, "{column} {row}");
            }
            assert_eq!(tuning.present, of_mixture(&part, &labels, tuning.parameters));
        }
        let other = Settings { alpha: 0.2, ..settings };
        tuner.tune(Some([TunableSetting::Alpha, TunableSetting::T]));
        assert!(
            tuner.advance(&other).is_some() && tuner.current.is_some(),
            "another question takes several steps"
        );
        let last = Settings { alpha: 0.05, ..settings };
        assert!(std::iter::from_fn(|| tuner.advance(&last)).count() > 0, "and one more before its answer");
        let tuning = tuner.latest().unwrap();
        assert_eq!(tuning.parameters, Parameters::new(&last));
        assert_eq!(tuning.present, of_mixture(&part, &labels, tuning.parameters));
        tuner.forget();
        assert!(tuner.latest().is_none() && tuner.advance(&other).is_none());
    }
}
