//! The passes over a sequence: several combinations each, as many as there is memory for their models.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::{Context as _, bail};
use rayon::prelude::*;

use super::arguments::SweepJob;
use super::opened_sequence::OpenedSequence;
use crate::cli::console::LongProgress;
use crate::cli::frames::{Batch, Frames, Item};
use crate::cli::interrupt;
use crate::frame::{Frame, Size};
use crate::mixture::BATCH;
use crate::regions::Roi;
use crate::registration::CorrectionChoice;
use crate::replay::memory;
use crate::settings::{Settings, Stage};
use crate::sweep::pass::{Outcome, Pass, settings_up_to};
use crate::truth::analysed_frames::AnalysedFrames;

/// Largest number of models in a pass. Decoding then costs little beside them, and a stop loses little.
const MAX_MODELS: usize = 8;
/// Largest number of combinations in a pass, so that a stop does not lose too many rows.
const MAX_COMBINATIONS: usize = 256;
/// Memory of what a tracker gives for a frame, in bytes: that of some ten objects.
const TRACKED_FRAME_BYTES: usize = 8 << 10;

/// The settings of the combinations of a pass, by index.
pub(super) type Combinations = BTreeMap<usize, Settings>;

/// Divides combinations into passes over a sequence of this number of frames, within a third of the memory for models and
/// a sixth for the results of trackers. Combinations of a pass have the same correction of camera and light, which is
/// measured once; those of the same model are in the same pass, if there is room.
pub(super) fn passes(
    combinations: &Combinations,
    sequence: &OpenedSequence,
    frames: u32,
) -> Vec<Combinations> {
    let memory = usize::try_from(memory()).unwrap_or(usize::MAX);
    let model = combinations.values().map(|settings| model_bytes(settings, sequence.info.size)).max();
    let models = (memory / 3 / model.unwrap_or(1).max(1)).clamp(1, MAX_MODELS);
    let results = TRACKED_FRAME_BYTES * frames.max(1) as usize;
    let room = if sequence.kinds.tracks { memory / 6 / results } else { MAX_COMBINATIONS };
    divided(combinations, models, room.clamp(1, MAX_COMBINATIONS))
}

/// Divides combinations into passes of at most this number of models and of combinations.
fn divided(combinations: &Combinations, max_models: usize, max_combinations: usize) -> Vec<Combinations> {
    let mut groups: BTreeMap<String, BTreeMap<String, Vec<usize>>> = BTreeMap::new();
    for (&index, settings) in combinations {
        let models = groups.entry(settings_up_to(settings, Stage::Registration)).or_default();
        models.entry(settings_up_to(settings, Stage::Mixture)).or_default().push(index);
    }
    let mut passes = Vec::new();
    for models in groups.into_values() {
        let mut models: Vec<Vec<usize>> = models.into_values().collect();
        models.sort();
        let (mut pass, mut models_of_pass) = (Vec::new(), 0);
        for part in models.iter().flat_map(|alike| alike.chunks(max_combinations)) {
            if models_of_pass == max_models || pass.len() + part.len() > max_combinations {
                passes.push(std::mem::take(&mut pass));
                models_of_pass = 0;
            }
            pass.extend_from_slice(part);
            models_of_pass += 1;
        }
        passes.push(pass);
    }
    let with_settings = |pass: Vec<usize>| {
        pass.into_iter().filter_map(|at| Some((at, combinations.get(&at)?.clone()))).collect()
    };
    passes.into_iter().filter(|pass| !pass.is_empty()).map(with_settings).collect()
}

/// Memory of a model with the masks of a batch, in bytes; OpenCV's models are taken for mixtures.
fn model_bytes(settings: &Settings, size: Size) -> usize {
    size.pixels() * (20 * settings.k as usize + 12 + 2 * BATCH)
}

/// What a pass gives.
pub(super) struct PassResult {
    pub outcomes: Vec<Outcome>,
    pub analysed: AnalysedFrames,
    /// The share of each combination of an outcome in the time of the pass, in seconds.
    pub seconds: Vec<f64>,
}

/// Analyses a sequence under these combinations and keeps the masks of the one `recorded`.
pub(super) fn run(
    job: &SweepJob,
    sequence: &OpenedSequence,
    combinations: &Combinations,
    recorded: Option<usize>,
    progress: &LongProgress,
    is_first: bool,
) -> anyhow::Result<PassResult> {
    let started = Instant::now();
    let Some(settings) = combinations.values().next() else { bail!("there are no settings to compare") };
    let choice = CorrectionChoice::new(settings);
    let mut frames = Frames::open(&sequence.video, job.options, job.range, Some(choice))?;
    let info = frames.info.clone();
    let roi = job.roi.as_ref().map(|roi| Roi::of_frames(roi, info.size, info.placement().as_ref()));
    let roi = roi.transpose()?;
    let mut pass = Pass::new(combinations, &info, roi.as_ref(), sequence.kinds, recorded)?;
    let to_learn = pass.to_learn();
    frames.learn_first(
        to_learn,
        |first| pass.learn(first).with_context(|| sequence.video.clone()),
        |_| (),
    )?;
    let mut numbers = Vec::new();
    loop {
        if interrupt::is_stop_requested() {
            bail!("stopped");
        }
        let Batch { frames: batch, after } = frames.batch(BATCH);
        let batch: Vec<&Frame> = batch.iter().collect();
        let truths = batch.par_iter().map(|frame| match &sequence.truth.masks {
            Some(masks) => masks.read_of_size(frame.number, info.source_size()),
            None => Ok(None),
        });
        let truths = truths.collect::<Result<Vec<_>, _>>()?;
        pass.step(&batch, &truths).with_context(|| sequence.video.clone())?;
        numbers.extend(batch.iter().map(|frame| frame.number));
        progress.advance((batch.len() * combinations.len()) as u64);
        match after {
            Some(Item::Warning(text)) if is_first => {
                progress.note(&format!("warning: {}: {text}", sequence.name));
            }
            // Warnings are the same in every pass.
            None | Some(Item::Frame(_) | Item::Warning(_)) => {}
            Some(Item::Failed(error)) => return Err(error),
            Some(Item::End) => break,
        }
    }
    let analysed = AnalysedFrames::of_numbers(numbers);
    let analysed = analysed.with_context(|| format!("{} has no frames", sequence.video))?;
    let outcomes = pass.finish();
    let all: f64 = outcomes.iter().map(|it| it.time.as_secs_f64() * it.combinations.len() as f64).sum();
    let factor = started.elapsed().as_secs_f64() / all.max(f64::MIN_POSITIVE);
    let seconds = outcomes.iter().map(|it| it.time.as_secs_f64() * factor).collect();
    Ok(PassResult { outcomes, analysed, seconds })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::settings::Stabilise;

    #[test]
    fn combinations_of_a_model_stay_together_and_corrections_apart() {
        let settings = |at: usize| Settings {
            alpha: 0.001 * (1 + at % 20) as f32,
            min_area: at as u32,
            ..Settings::default()
        };
        let mut all: Combinations = (0..60).map(|at| (at, settings(at))).collect();
        all.insert(60, Settings { stabilise: Stabilise::Shift, ..Settings::default() });
        let members = |max_models, max_combinations| -> Vec<Vec<usize>> {
            let passes = divided(&all, max_models, max_combinations);
            passes.iter().map(|pass| pass.keys().copied().collect()).collect()
        };
        let whole = members(16, 256);
        assert_eq!(whole.iter().map(Vec::len).collect::<Vec<_>>(), [48, 12, 1]);
        assert!(whole[0].iter().all(|at| at % 20 < 16) && whole[1].iter().all(|at| at % 20 >= 16));
        assert_eq!(whole[2], [60]);
        // A model that fills the memory is alone, and one of many combinations is made again for some of them.
        assert_eq!(members(1, 256).len(), 21);
        let small = members(16, 2);
        assert!(small.len() == 41 && small.iter().all(|pass| pass.len() <= 2), "{small:?}");
        let mut all_members: Vec<usize> = small.concat();
        all_members.sort_unstable();
        assert_eq!(all_members, (0..61).collect::<Vec<_>>());
    }
}
