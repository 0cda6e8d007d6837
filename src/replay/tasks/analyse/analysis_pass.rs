//! One pass of the analysis through the sequence under one choice of settings, with its results.

use std::sync::Arc;

use super::PassInputs;
use super::model_timeline::ModelTimeline;
use super::pass_progress::NextStep;
use crate::frame::Frame;
use crate::pipeline::PipelineError;
use crate::regions::Roi;
use crate::replay::store::model_pictures::ModelPictures;
use crate::replay::tasks::gather::frame_consumer::FrameConsumer as _;
use crate::replay::tasks::gather::pixel_follower::PixelFollower;
use crate::replay::tasks::score::{ScoreStep, Scorer};
use crate::replay::tasks::timeline::TimelineBuilder;
use crate::replay::{ShownFrame, Timeline};
use crate::settings::{Settings, Stage};
use crate::source::SourceError;
use crate::source::cache::{Fetched, FrameCache, Keep};
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::summary;

/// A pass through the sequence under one choice of settings.
pub(crate) struct AnalysisPass {
    /// Its progress, its record and its model at any frame.
    pub(crate) model: ModelTimeline,
    /// The chosen pixel under the same settings.
    pub(crate) pixel_follower: PixelFollower,
    timeline_builder: TimelineBuilder,
    /// The boxes of the offline result, once it has replaced the online one.
    finished: Option<Arc<Boxes>>,
    scorer: Scorer,
}

/// An error that ends a pass.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PassError {
    /// An error of the source.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// An error of a stage.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
}

/// The result of a step.
pub(crate) enum PassStep {
    /// Frames were analysed, or are being decoded.
    Advanced,
    /// The next frame of a live source is no longer cached.
    FrameLost,
}

impl AnalysisPass {
    /// A pass before the first frame.
    pub(crate) fn new(inputs: PassInputs) -> Result<Self, PipelineError> {
        Ok(Self {
            model: ModelTimeline::new(inputs)?,
            pixel_follower: PixelFollower::default(),
            timeline_builder: TimelineBuilder::default(),
            finished: None,
            scorer: Scorer::default(),
        })
    }

    /// A copy at the same position, with its own `budget`; `None` where the model's state cannot be copied.
    pub(crate) fn fork(&self, budget: usize) -> Option<Self> {
        Some(Self {
            model: self.model.fork(budget)?,
            pixel_follower: self.pixel_follower.clone(),
            timeline_builder: self.timeline_builder.clone(),
            finished: self.finished.clone(),
            scorer: Scorer::default(),
        })
    }

    /// A pass under other settings, which reuses the masks of this one where the model's settings are the same.
    pub(crate) fn fork_under(&self, inputs: PassInputs) -> Result<Self, PipelineError> {
        let stage = self.first_difference(&inputs.settings, inputs.roi.as_ref());
        let stage = stage.filter(|&stage| stage > Stage::Mixture);
        match stage.and_then(|stage| Some((stage, self.fork(inputs.budget)?))) {
            Some((stage, mut fork)) => fork.restart_at(stage, inputs.settings, inputs.roi).map(|()| fork),
            None => Self::new(inputs),
        }
    }

    /// The settings of the pass.
    pub(crate) const fn settings(&self) -> &Arc<Settings> {
        self.model.settings()
    }

    /// Chooses the pixel to follow; `None` for none.
    pub(crate) fn inspect(&mut self, at: Option<(u32, u32)>) {
        self.pixel_follower.choose(at, self.model.settings(), self.model.info());
    }

    /// The first stage affected by other settings or another region of interest; `None` where nothing differs.
    pub(crate) fn first_difference(&self, settings: &Settings, roi: Option<&Arc<Roi>>) -> Option<Stage> {
        let of_settings = self.settings().first_difference(settings);
        let of_roi = (self.model.roi() != roi).then_some(Stage::Cleaning);
        [of_settings, of_roi].into_iter().flatten().min()
    }

    /// Restarts at `stage` under other settings, of which those before `stage` are the same; the model itself stays.
    pub(crate) fn restart_at(
        &mut self,
        stage: Stage,
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
    ) -> Result<(), PipelineError> {
        self.timeline_builder = TimelineBuilder::default();
        (self.finished, self.scorer) = (None, Scorer::default());
        self.model.restart_at(stage, settings, roi)
    }

    /// Whether all frames of the source have been analysed.
    pub(crate) fn has_analysed_all(&self, frames: &FrameCache) -> bool {
        frames.is_complete() && self.model.analysed() as usize == frames.numbers().len()
    }

    /// Whether the offline result of all frames is complete.
    pub(crate) const fn is_finished(&self) -> bool {
        self.finished.is_some()
    }

    /// The key by which the steps of two passes are ordered: the pass whose key is less is behind.
    pub(crate) fn next_order(&self) -> (u32, u32) {
        self.model.next_step().order()
    }

    /// Takes the next step: learns from or analyses the next decoded frames, or decodes one frame, up to the position
    /// `last`, if given, or the end. `keep` says whether frames that are decoded again may evict others; `passed` is
    /// called with each frame and its position.
    pub(crate) fn advance(
        &mut self,
        frames: &mut FrameCache,
        last: Option<u32>,
        keep: Keep,
        mut passed: impl FnMut(u32, &Frame),
    ) -> Result<PassStep, PassError> {
        let (step, analysed) = (self.model.next_step(), self.model.analysed());
        let position = step.position();
        if matches!(step, NextStep::Track(_)) {
            self.model.advance(&[])?;
        } else {
            match frames.fetch(position, keep)? {
                Fetched::Frame(frame) => {
                    let frames = self.with_buffered_frames(frames, position, frame, last);
                    self.model.advance(&frames)?;
                    for (position, frame) in (position..).zip(&frames) {
                        self.pixel_follower.push(position, frame);
                        passed(position, frame);
                    }
                }
                Fetched::End if matches!(step, NextStep::Learn(_)) => self.model.begin(),
                Fetched::OnTheWay | Fetched::End => {}
                Fetched::Gone => return Ok(PassStep::FrameLost),
            }
        }
        for position in analysed..self.model.analysed() {
            let record = self.model.record();
            let outline = record.outline(position).zip(record.foreground_share(position));
            let Some((analysis, share)) = outline else { break };
            self.timeline_builder.push(analysis, share);
        }
        if self.has_analysed_all(frames) && self.finished.is_none() {
            let result = self.model.offline_result();
            self.finished = Some(Arc::new(summary::boxes_of(&result)));
            self.timeline_builder.finish(result);
        }
        Ok(PassStep::Advanced)
    }

    /// The next frame and the buffered frames after it, as many as can be analysed together.
    fn with_buffered_frames(
        &self,
        frames: &mut FrameCache,
        position: u32,
        frame: Arc<Frame>,
        last: Option<u32>,
    ) -> Vec<Arc<Frame>> {
        let most = match last.and_then(|last| last.checked_sub(position)) {
            Some(before_last) => self.model.max_next_frames().min(before_last as usize + 1),
            None => self.model.max_next_frames(),
        };
        let mut passed = vec![frame];
        while passed.len() < most {
            let Some(frame) = frames.at_hand(position + passed.len() as u32) else { break };
            passed.push(frame);
        }
        passed
    }

    /// The frame to show at a position with these pictures; `None` where it has not been analysed.
    pub(crate) fn shown(
        &mut self,
        position: u32,
        frame: Arc<Frame>,
        pictures: ModelPictures,
    ) -> Option<ShownFrame> {
        let analysis = self.model.analysis(position)?;
        Some(ShownFrame {
            position,
            settings: Arc::clone(self.settings()),
            roi: self.model.roi().cloned(),
            frame,
            analysis: Arc::new(analysis),
            background: pictures.background,
            multi_mode: pictures.multi_mode,
            map: pictures.map,
            pixel: self.pixel_follower.history_covering(position),
            truth: None,
            external: None,
            compared: None,
        })
    }

    /// Advances the score of the offline result and the masks against `truth`, if the analysis is complete.
    pub(crate) fn score(&mut self, truth: &Arc<Truth>) -> ScoreStep {
        let Some(found) = &self.finished else { return ScoreStep::Idle };
        let leaves_out = self.model.info().every() > 1;
        self.scorer.advance(truth, found, self.model.record(), leaves_out)
    }

    /// The current timeline, with the score against `truth`.
    pub(crate) fn timeline(&self, frames: &FrameCache, truth: Option<&Arc<Truth>>) -> Timeline {
        Timeline {
            decoded: frames.kept_ranges(),
            alignments: frames.alignments().to_vec(),
            score: truth.and_then(|truth| self.scorer.by(truth)),
            ..self.timeline_builder.timeline(frames)
        }
    }
}
