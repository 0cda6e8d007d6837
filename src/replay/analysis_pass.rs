//! One choice of settings on its way through the sequence, with all that grows on the way.

use std::sync::Arc;

use super::gather::Follower as _;
use super::inspector::Inspector;
use super::run::Run;
use super::scoring::{Scored, Scoring};
use super::timeline::Growing;
use super::{Shown, Timeline, pictures::Pictures};
use crate::frame::Frame;
use crate::pipeline::PipelineError;
use crate::regions::Roi;
use crate::settings::{Settings, Stage};
use crate::source::cache::{Fetched, FrameCache, Keep};
use crate::source::{SourceError, SourceInfo};
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::summary;

/// The sequence under one choice of settings.
pub(super) struct Lane {
    /// How far it has come, and its model.
    pub(super) run: Run,
    /// The chosen pixel under the same settings.
    pub(super) inspector: Inspector,
    growing: Growing,
    /// The boxes of the final reading, once that has taken the place of the causal one.
    finished: Option<Arc<Boxes>>,
    scoring: Scoring,
}

/// Why an analysis cannot go on.
#[derive(Debug, thiserror::Error)]
pub(super) enum LaneError {
    /// Frames cannot be had.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A stage fails.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
}

/// What came of going on.
pub(super) enum Step {
    /// Frames were analysed, or will be when they have come.
    On,
    /// The next frame is no longer kept: a live source has forgotten it.
    Gone,
}

impl Lane {
    /// Nothing analysed yet; `budget` is the memory for going back in time, in bytes.
    pub(super) fn new(
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
        info: &Arc<SourceInfo>,
        budget: usize,
    ) -> Result<Self, PipelineError> {
        Ok(Self {
            run: Run::new(settings, roi, info, budget)?,
            inspector: Inspector::default(),
            growing: Growing::default(),
            finished: None,
            scoring: Scoring::default(),
        })
    }

    /// Another lane that has come just as far, with its own `budget`; `None` where the model's state cannot be copied.
    pub(super) fn fork(&self, budget: usize) -> Option<Self> {
        Some(Self {
            run: self.run.fork(budget)?,
            inspector: self.inspector.clone(),
            growing: self.growing.clone(),
            finished: self.finished.clone(),
            scoring: Scoring::default(),
        })
    }

    /// A lane under other settings, with the masks of this one where the model's are the same.
    pub(super) fn beside(
        &self,
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
        info: &Arc<SourceInfo>,
        budget: usize,
    ) -> Result<Self, PipelineError> {
        let stage = self.first_difference(&settings, roi.as_ref()).filter(|&stage| stage > Stage::Mixture);
        match stage.and_then(|stage| Some((stage, self.fork(budget)?))) {
            Some((stage, mut fork)) => fork.restart_at(stage, settings, roi).map(|()| fork),
            None => Self::new(settings, roi, info, budget),
        }
    }

    /// Its settings.
    pub(super) const fn settings(&self) -> &Arc<Settings> {
        self.run.settings()
    }

    /// Follows a pixel, or none.
    pub(super) fn inspect(&mut self, at: Option<(u32, u32)>) {
        self.inspector.choose(at, self.run.settings(), self.run.info());
    }

    /// The first stage that other settings or another part of the image touch; `None` where they are the same.
    pub(super) fn first_difference(&self, settings: &Settings, roi: Option<&Arc<Roi>>) -> Option<Stage> {
        let of_settings = self.settings().first_difference(settings);
        let of_roi = (self.run.roi() != roi).then_some(Stage::Cleaning);
        [of_settings, of_roi].into_iter().flatten().min()
    }

    /// Takes other settings, of which those before `stage` are the same; the model itself stays.
    pub(super) fn restart_at(
        &mut self,
        stage: Stage,
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
    ) -> Result<(), PipelineError> {
        self.growing = Growing::default();
        (self.finished, self.scoring) = (None, Scoring::default());
        self.run.restart_at(stage, settings, roi)
    }

    /// Whether all frames there are have been analysed.
    pub(super) fn is_through(&self, frames: &FrameCache) -> bool {
        frames.is_complete() && self.run.front() as usize == frames.numbers().len()
    }

    /// Whether the final reading of all frames is there.
    pub(super) const fn is_finished(&self) -> bool {
        self.finished.is_some()
    }

    /// Where it is on its way: how often it has passed all that it learns from, and the position of the next frame.
    pub(super) fn next(&self) -> (u32, u32) {
        self.run.learns().map_or_else(|| (1, self.run.front()), |position| (0, position))
    }

    /// Learns from or analyses the next frames that are there, or lets one be decoded on the way to them: not beyond
    /// the position `last`, where there is one before the end. What has to be decoded again is kept as `keep` says;
    /// `passed` is given each frame with its position.
    pub(super) fn go_on(
        &mut self,
        frames: &mut FrameCache,
        last: Option<u32>,
        keep: Keep,
        mut passed: impl FnMut(u32, &Frame),
    ) -> Result<Step, LaneError> {
        if let Some(position) = self.run.learns() {
            match frames.fetch(position, keep)? {
                Fetched::Frame(frame) => {
                    let frames = self.with_those_at_hand(frames, position, frame, last);
                    self.run.learn(&frames)?;
                    for (position, frame) in (position..).zip(&frames) {
                        self.inspector.push(position, frame);
                        passed(position, frame);
                    }
                }
                Fetched::OnTheWay => {}
                Fetched::End => self.run.begin(),
                Fetched::Gone => return Ok(Step::Gone),
            }
            return Ok(Step::On);
        }
        let position = self.run.front();
        if self.run.is_tracking_again() {
            self.run.track_next();
        } else {
            match frames.fetch(position, keep)? {
                Fetched::Frame(frame) => {
                    let frames = self.with_those_at_hand(frames, position, frame, last);
                    self.run.step(&frames)?;
                    for (position, frame) in (position..).zip(&frames) {
                        self.inspector.push(position, frame);
                        passed(position, frame);
                    }
                }
                Fetched::OnTheWay | Fetched::End => {}
                Fetched::Gone => return Ok(Step::Gone),
            }
        }
        for position in position..self.run.front() {
            let Some((analysis, share)) = self.run.outline(position) else { break };
            self.growing.push(analysis, share);
        }
        if self.is_through(frames) && self.finished.is_none() {
            let reading = self.run.offline_result();
            self.finished = Some(Arc::new(summary::boxes_of(&reading)));
            self.growing.finish(reading);
        }
        Ok(Step::On)
    }

    /// The next frame, and those after it that need not be waited for, as many as may be analysed together.
    fn with_those_at_hand(
        &self,
        frames: &mut FrameCache,
        position: u32,
        frame: Arc<Frame>,
        last: Option<u32>,
    ) -> Vec<Arc<Frame>> {
        let most = match last.and_then(|last| last.checked_sub(position)) {
            Some(before_last) => self.run.most_frames().min(before_last as usize + 1),
            None => self.run.most_frames(),
        };
        let mut passed = vec![frame];
        while passed.len() < most {
            let Some(frame) = frames.at_hand(position + passed.len() as u32) else { break };
            passed.push(frame);
        }
        passed
    }

    /// A frame under these settings, from its pictures; `None` where it has not been analysed.
    pub(super) fn shown(&mut self, position: u32, frame: Arc<Frame>, pictures: Pictures) -> Option<Shown> {
        let analysis = self.run.analysis(position)?;
        Some(Shown {
            position,
            settings: Arc::clone(self.settings()),
            roi: self.run.roi().cloned(),
            frame,
            analysis: Arc::new(analysis),
            background: pictures.background,
            multi_mode: pictures.multi_mode,
            map: pictures.map,
            pixel: self.inspector.covering(position),
            truth: None,
            beside: None,
        })
    }

    /// Does a piece of work on the score of the final reading and the masks by `truth`, if all is there.
    pub(super) fn score(&mut self, truth: &Arc<Truth>) -> Scored {
        let Some(found) = &self.finished else { return Scored::Already };
        self.scoring.piece(truth, found, self.run.record())
    }

    /// What is known of the sequence now; its score is by `truth`.
    pub(super) fn timeline(&self, frames: &FrameCache, truth: Option<&Arc<Truth>>) -> Timeline {
        Timeline {
            decoded: frames.kept_ranges(),
            alignments: frames.alignments().to_vec(),
            score: truth.and_then(|truth| self.scoring.by(truth)),
            ..self.growing.timeline(frames.numbers(), frames.is_complete())
        }
    }
}
