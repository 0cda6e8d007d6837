//! A pass over a sequence for several combinations: each stage runs once for the combinations whose settings up to it are
//! equal.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::frame::{Frame, Mask};
use crate::occlusion::{FrameResult, Tracker};
use crate::pipeline::{
    BackgroundSubtractor, OfflineResult, PipelineError, RegionFinder, TrackedFrame, offline_result_of,
};
use crate::placement::Placement;
use crate::regions::{Region, Roi, rle};
use crate::settings::{SETTINGS, Settings, Stage};
use crate::source::SourceInfo;
use crate::truth::decisions::Decisions;
use crate::truth::masks::TrueMask;

/// What is scored. Stages that it does not need are not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScoredKinds {
    /// The masks.
    pub masks: bool,
    /// The tracks and events.
    pub tracks: bool,
    /// Whether there is a true box: without, tracks have no measure.
    pub has_box: bool,
}

impl ScoredKinds {
    /// The last stage that is run.
    pub fn last_stage(self) -> Stage {
        if self.tracks { Stage::Occlusion } else { Stage::Cleaning }
    }
}

/// The result of combinations whose settings do not differ in any stage that was run.
pub struct Outcome {
    /// The indices of the combinations.
    pub combinations: Vec<usize>,
    /// Number of frames with a true mask.
    pub judged_masks: usize,
    /// The decisions on the pixels of these frames, in the source's pixels.
    pub decisions: Decisions,
    /// The offline result in the frames' pixels, if tracks are scored.
    pub result: Option<OfflineResult>,
    /// The masks of all frames, if they were recorded.
    pub masks: Option<Arc<Vec<RecordedMask>>>,
    /// The time that its stages took, by this machine's clock; that of shared stages is divided.
    pub time: Duration,
}

/// The mask of a frame.
pub struct RecordedMask {
    /// The frame number.
    pub number: u32,
    /// Run-length encoded by [`rle::encode_mask`].
    pub(crate) runs: Box<[u8]>,
    /// The decisions on its pixels, if there is a true mask.
    pub decisions: Option<Decisions>,
}

/// The stages of all combinations of a pass, ready for the next frames.
pub struct Pass {
    models: Vec<ModelBranch>,
    placement: Option<Placement>,
}

/// Combinations with the same background model.
struct ModelBranch {
    model: BackgroundSubtractor,
    /// Number of frames that the model is still to learn from.
    to_learn: usize,
    time: Duration,
    cleanings: Vec<CleaningBranch>,
}

/// Combinations with the same regions, or the same cleaned mask where tracks are not scored.
struct CleaningBranch {
    finder: RegionFinder,
    judged_masks: usize,
    decisions: Decisions,
    record: Option<Vec<RecordedMask>>,
    time: Duration,
    trackers: Vec<TrackerBranch>,
}

/// Combinations that differ in no stage that is run.
struct TrackerBranch {
    combinations: Vec<usize>,
    /// The tracker, if tracks are scored.
    tracker: Option<Tracker>,
    /// The number, time and result of each frame.
    frames: Vec<(u32, f64, FrameResult)>,
    time: Duration,
}

impl Pass {
    /// The stages before the first frame of the source `info` under these settings, by the index of their combination.
    /// The masks of the combination `recorded` are kept. Fails only if OpenCV cannot create MOG2 or KNN.
    pub fn new(
        settings: &BTreeMap<usize, Settings>,
        info: &SourceInfo,
        roi: Option<&Arc<Roi>>,
        kinds: ScoredKinds,
        recorded: Option<usize>,
    ) -> Result<Self, PipelineError> {
        let tracker = |of: Combinations<'_>| TrackerBranch {
            combinations: of.iter().map(|(combination, _)| *combination).collect(),
            tracker: kinds.tracks.then(|| Tracker::new(of[0].1, info.size, info.fps)),
            frames: Vec::new(),
            time: Duration::ZERO,
        };
        let cleaning = |of: Combinations<'_>| CleaningBranch {
            finder: RegionFinder::new(of[0].1, roi.cloned()),
            judged_masks: 0,
            decisions: Decisions::default(),
            record: of.iter().any(|(combination, _)| Some(*combination) == recorded).then(Vec::new),
            time: Duration::ZERO,
            trackers: groups(of, kinds.last_stage()).iter().map(|of| tracker(of)).collect(),
        };
        let model = |of: Combinations<'_>| {
            Ok::<_, PipelineError>(ModelBranch {
                model: BackgroundSubtractor::new(of[0].1, info.size)?,
                to_learn: info.bootstrap(of[0].1) as usize,
                time: Duration::ZERO,
                cleanings: groups(of, kinds.last_stage().min(Stage::Regions))
                    .iter()
                    .map(|of| cleaning(of))
                    .collect(),
            })
        };
        let all: Vec<_> = settings.iter().map(|(combination, settings)| (*combination, settings)).collect();
        let models = groups(&all, Stage::Mixture);
        let models = models.iter().map(|of| model(of)).collect::<Result<_, PipelineError>>()?;
        Ok(Self { models, placement: info.placement() })
    }

    /// Number of the first frames that a model learns from before the first step.
    pub fn to_learn(&self) -> u32 {
        self.models.iter().map(|branch| branch.to_learn as u32).max().unwrap_or(0)
    }

    /// Lets the models learn from the next of the first frames, each from as many as its settings have.
    pub fn learn(&mut self, frames: &[&Frame]) -> Result<(), PipelineError> {
        self.models.par_iter_mut().try_for_each(|ModelBranch { model, to_learn, time, .. }| {
            let started = Instant::now();
            let count = frames.len().min(*to_learn);
            *to_learn -= count;
            if count > 0 {
                model.learn(&frames[..count])?;
            }
            *time += started.elapsed();
            Ok(())
        })
    }

    /// Processes the next frames; `truths` has the true mask of each, if there is one, in the source's pixels.
    pub fn step(&mut self, frames: &[&Frame], truths: &[Option<TrueMask>]) -> Result<(), PipelineError> {
        let placement = self.placement.as_ref();
        self.models.par_iter_mut().try_for_each(|ModelBranch { model, time, cleanings, .. }| {
            let started = Instant::now();
            let masks = model.masks(frames)?;
            *time += started.elapsed();
            cleanings.par_iter_mut().try_for_each(|branch| branch.step(frames, &masks, truths, placement))
        })
    }

    /// The outcomes after the last frame.
    pub fn finish(self) -> Vec<Outcome> {
        let outcomes = self.models.into_iter().flat_map(|ModelBranch { time, cleanings, .. }| {
            let of_model = time / count(cleanings.iter().flat_map(|branch| &branch.trackers));
            cleanings.into_iter().flat_map(move |branch| {
                let shared = of_model + branch.time / count(&branch.trackers);
                let record = branch.record.map(Arc::new);
                let outcome = move |of: TrackerBranch| Outcome {
                    time: of.time / count([&of]) + shared,
                    combinations: of.combinations,
                    judged_masks: branch.judged_masks,
                    decisions: branch.decisions,
                    result: of.tracker.map(|tracker| offline(tracker, &of.frames)),
                    masks: record.clone(),
                };
                branch.trackers.into_iter().map(outcome)
            })
        });
        outcomes.collect()
    }
}

impl CleaningBranch {
    fn step(
        &mut self,
        frames: &[&Frame],
        masks: &[Mask],
        truths: &[Option<TrueMask>],
        placement: Option<&Placement>,
    ) -> Result<(), PipelineError> {
        let started = Instant::now();
        let (finder, has_tracker) = (&self.finder, self.trackers.iter().any(|it| it.tracker.is_some()));
        let processed = frames.par_iter().zip(masks).zip(truths).map(|((frame, mask), truth)| {
            let mask = finder.clean(frame, mask.clone())?;
            let decisions = truth.as_ref().map(|truth| match placement {
                Some(placement) => truth.score(&placement.source_mask(&mask)),
                None => truth.score(&mask),
            });
            let regions = if has_tracker { finder.find(frame, &mask).1 } else { Vec::new() };
            Ok((mask, decisions, regions))
        });
        let processed: Vec<_> = processed.collect::<Result<_, PipelineError>>()?;
        for (frame, (mask, decisions, _)) in frames.iter().zip(&processed) {
            self.judged_masks += usize::from(decisions.is_some());
            self.decisions += decisions.unwrap_or_default();
            if let Some(record) = &mut self.record {
                let runs = rle::encode_mask(mask);
                record.push(RecordedMask { number: frame.number, runs, decisions: *decisions });
            }
        }
        self.time += started.elapsed();
        let found: Vec<(&Frame, &[Region])> =
            frames.iter().zip(&processed).map(|(frame, (_, _, regions))| (*frame, &**regions)).collect();
        self.trackers.par_iter_mut().for_each(|tracker| tracker.step(&found));
        Ok(())
    }
}

impl TrackerBranch {
    fn step(&mut self, found: &[(&Frame, &[Region])]) {
        let Some(tracker) = &mut self.tracker else { return };
        let started = Instant::now();
        for (frame, regions) in found {
            let result = tracker.step(frame.number, frame.time, regions);
            // The offline result needs neither, and they would double the memory.
            let result = FrameResult { tracks: Vec::new(), tentative: Vec::new(), ..result };
            self.frames.push((frame.number, frame.time, result));
        }
        self.time += started.elapsed();
    }
}

/// The offline result of these frames, after the last of which the tracker is.
fn offline(mut tracker: Tracker, frames: &[(u32, f64, FrameResult)]) -> OfflineResult {
    let last = tracker.finish();
    let frames = frames.iter().map(|(number, time, result)| TrackedFrame {
        number: *number,
        time: *time,
        objects: &result.objects,
        events: &result.events,
        settled: &result.settled,
    });
    offline_result_of(&frames.collect::<Vec<_>>(), &last)
}

/// Number of combinations, at least 1.
fn count<'a>(trackers: impl IntoIterator<Item = &'a TrackerBranch>) -> u32 {
    trackers.into_iter().map(|branch| branch.combinations.len() as u32).sum::<u32>().max(1)
}

/// Combinations with their settings, at least one.
type Combinations<'a> = &'a [(usize, &'a Settings)];

/// The combinations in groups whose settings up to a stage are equal, in the order of their first members.
fn groups(all: Combinations<'_>, stage: Stage) -> Vec<Vec<(usize, &Settings)>> {
    let mut groups: Vec<(String, Vec<(usize, &Settings)>)> = Vec::new();
    for &(combination, settings) in all {
        let key = settings_up_to(settings, stage);
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, group)) => group.push((combination, settings)),
            None => groups.push((key, vec![(combination, settings)])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// The values of all settings that affect the stages up to this one.
pub fn settings_up_to(settings: &Settings, stage: Stage) -> String {
    let values = SETTINGS.iter().filter(|setting| setting.stage <= stage);
    values.map(|setting| format!("{}={}", setting.name, setting.get(settings))).collect::<Vec<_>>().join("\n")
}
