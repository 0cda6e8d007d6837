//! The model over the sequence under one choice of settings: its progress, its record, and its state at any past
//! frame.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::PassInputs;
use super::pass_progress::{NextStep, PassProgress};
use crate::frame::{Frame, Mask, Size};
use crate::mixture::{BATCH, Mixture, Parameters, Quantity, Snapshot};
use crate::pipeline::{Analysis, OfflineResult, Pipeline, PipelineError, offline_result};
use crate::regions::Roi;
use crate::regions::rle;
use crate::replay::store::analysis_record::AnalysisRecord;
use crate::replay::store::local_checkpoints::LocalCheckpoints;
use crate::replay::store::model_pictures::{ModelPictures, RecentPictures};
use crate::replay::store::strided_checkpoints::StridedCheckpoints;
use crate::replay::tasks::gather::last_foreground::LastForeground;
use crate::settings::{Settings, Stage};
use crate::source::SourceInfo;

/// Least distance of checkpoints: replaying fewer frames is too fast to justify the memory.
const MIN_CHECKPOINT_SPACING_FRAMES: u32 = 2 * BATCH as u32;

/// Largest number of pixels that one step processes, though at least one frame: a step must not delay a newer
/// request.
const MAX_PIXELS_PER_STEP: usize = 8 << 20;

/// Largest number of frames of this size in one step.
fn max_frames_per_step(size: Size) -> usize {
    (MAX_PIXELS_PER_STEP / size.pixels().max(1)).clamp(1, BATCH)
}

/// The analysis of a sequence under one choice of settings.
///
/// The mixture at a past frame is restored from the nearest checkpoint and replayed frame by frame, which gives the
/// same bits as the first pass. The state of MOG2 and KNN cannot be copied. Their background images are stored
/// instead: every frame's while there is room, then every second one's, and so on. A frame without a stored image has
/// that of the nearest earlier one, under that one's number.
pub(crate) struct ModelTimeline {
    settings: Arc<Settings>,
    roi: Option<Arc<Roi>>,
    info: Arc<SourceInfo>,
    pipeline: Pipeline,
    record: AnalysisRecord,
    progress: PassProgress,
    /// The mixture at the start of classification, if it learned from any frames.
    start: Option<Arc<Snapshot>>,
    /// Memory budget for checkpoints and the record, in bytes.
    model_budget_bytes: usize,
    /// Snapshots of the mixture by the number of processed frames.
    checkpoints: StridedCheckpoints<Arc<Snapshot>>,
    /// Snapshots around frames that were shown, by the number of processed frames.
    local_checkpoints: LocalCheckpoints<Snapshot>,
    /// Background images by position, for models that cannot be copied.
    backgrounds: StridedCheckpoints<Arc<Frame>>,
    /// A mixture that is replayed, and the number of its processed frames.
    replay: Option<(u32, Mixture)>,
    /// Buffers for the masks of a replay, which are not used.
    masks: Vec<Mask>,
    recent: RecentPictures,
    last_foreground: LastForeground,
}

/// The result of a step of seeking to a frame.
pub(crate) enum SeekStep {
    /// The pictures of that frame.
    Pictures(ModelPictures),
    /// Another step is needed.
    Continues,
    /// The frames at these positions have to be passed to [`ModelTimeline::replay_frames`] first, at least one.
    NeedsFrames(Range<u32>),
}

impl ModelTimeline {
    /// A timeline before the first frame.
    pub(crate) fn new(inputs: PassInputs) -> Result<Self, PipelineError> {
        let PassInputs { settings, roi, info, budget } = inputs;
        let mut pipeline = Pipeline::new(&settings, info.size, info.fps)?;
        pipeline.set_roi(roi.clone())?;
        let mut timeline = Self {
            model_budget_bytes: 0,
            checkpoints: StridedCheckpoints::new(MIN_CHECKPOINT_SPACING_FRAMES, 0),
            local_checkpoints: LocalCheckpoints::new(0),
            backgrounds: StridedCheckpoints::new(1, 0),
            record: AnalysisRecord::new(info.size),
            progress: PassProgress::new(info.bootstrap(&settings)),
            settings,
            roi,
            pipeline,
            start: None,
            replay: None,
            masks: Vec::new(),
            recent: RecentPictures::new(1),
            last_foreground: LastForeground::new(info.size),
            info,
        };
        timeline.set_budget(budget);
        Ok(timeline)
    }

    /// A copy at the same position with its own `budget`; the record and checkpoints are shared. `None` where the
    /// model's state cannot be copied.
    pub(crate) fn fork(&self, budget: usize) -> Option<Self> {
        let mut fork = Self {
            pipeline: self.pipeline.try_clone()?,
            settings: Arc::clone(&self.settings),
            roi: self.roi.clone(),
            info: Arc::clone(&self.info),
            start: self.start.clone(),
            record: self.record.clone(),
            checkpoints: self.checkpoints.clone(),
            local_checkpoints: LocalCheckpoints::new(0),
            backgrounds: self.backgrounds.clone(),
            replay: None,
            masks: Vec::new(),
            recent: self.recent.clone(),
            last_foreground: LastForeground::new(self.info.size),
            ..*self
        };
        fork.set_budget(budget);
        Some(fork)
    }

    /// Sets the memory budget for checkpoints and the record, in bytes.
    pub(crate) fn set_budget(&mut self, budget: usize) {
        let frame_bytes = (self.info.size.pixels() * 3).max(1);
        let (for_pictures, for_local, for_last_foreground) = (budget / 8, budget / 8, budget / 16);
        self.model_budget_bytes = budget / 16 * 11;
        self.last_foreground.set_capacity(for_last_foreground);
        self.local_checkpoints.set_capacity(for_local);
        self.recent.set_capacity((for_pictures / (frame_bytes * 10 / 3).max(1)).clamp(1, 512));
        self.update_capacity();
    }

    /// Sets the capacity for checkpoints to what the record leaves of the budget: the record is never dropped.
    fn update_capacity(&mut self) {
        let start = self.start.as_ref().map_or(0, |start| start.bytes());
        let capacity = self.model_budget_bytes.saturating_sub(self.record.bytes() + start);
        self.checkpoints.set_capacity(capacity);
        self.backgrounds.set_capacity(capacity);
    }

    pub(crate) const fn settings(&self) -> &Arc<Settings> {
        &self.settings
    }

    pub(crate) const fn info(&self) -> &Arc<SourceInfo> {
        &self.info
    }

    pub(crate) const fn roi(&self) -> Option<&Arc<Roi>> {
        self.roi.as_ref()
    }

    /// Number of frames analysed under these settings.
    pub(crate) const fn analysed(&self) -> u32 {
        self.progress.analysed()
    }

    /// The next step, and the position of its frame.
    pub(crate) fn next_step(&self) -> NextStep {
        self.progress.next_step(self.record.len())
    }

    /// Number of first frames to learn from, as far as known.
    pub(crate) const fn to_learn(&self) -> u32 {
        self.progress.frames_to_learn()
    }

    /// Takes the next step on its frame and the frames after it: no more than [`Self::max_next_frames`]. Frames are not
    /// needed, and one is processed, where the step is [`NextStep::Track`].
    pub(crate) fn advance(&mut self, frames: &[Arc<Frame>]) -> Result<(), PipelineError> {
        match self.next_step() {
            NextStep::Learn(_) => self.learn(frames)?,
            NextStep::Classify(_) => self.classify(frames)?,
            NextStep::FindRegions(position) => self.find_regions(position, frames)?,
            NextStep::Track(position) => self.track(position),
        }
        Ok(())
    }

    fn learn(&mut self, frames: &[Arc<Frame>]) -> Result<(), PipelineError> {
        let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
        self.pipeline.learn(&borrowed)?;
        if self.progress.add_learnt(frames.len() as u32) {
            self.begin();
        }
        Ok(())
    }

    /// Starts classification with the learned model: there are no more frames to learn from.
    pub(crate) fn begin(&mut self) {
        self.progress.end_learning();
        self.pipeline.begin();
        self.start = self.pipeline.mixture().map(|mixture| Arc::new(mixture.snapshot()));
        self.update_capacity();
    }

    /// Number of frames that the model has classified.
    pub(crate) fn classified(&self) -> u32 {
        self.record.len()
    }

    /// Applies other settings that are the same before `stage`; results of earlier stages stay. Another `roi` needs a
    /// stage no later than cleaning. Other settings of the model need another [`ModelTimeline`].
    pub(crate) fn restart_at(
        &mut self,
        stage: Stage,
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
    ) -> Result<(), PipelineError> {
        self.pipeline.set_roi(roi.clone())?;
        self.roi = roi;
        self.progress.restart_at(stage, self.record.len());
        self.pipeline.restart_after_model(&settings, self.info.fps);
        self.settings = settings;
        Ok(())
    }

    /// Largest number of next frames for one call of [`Self::advance`]: up to the next checkpoint.
    pub(crate) fn max_next_frames(&self) -> usize {
        let until_kept = match self.next_step() {
            NextStep::Learn(position) => self.to_learn() - position,
            NextStep::FindRegions(position) | NextStep::Track(position) => self.record.len() - position,
            NextStep::Classify(position) if self.pipeline.mixture().is_some() => {
                self.checkpoints.until_next(position)
            }
            NextStep::Classify(_) => 1,
        };
        max_frames_per_step(self.info.size).min(until_kept as usize).max(1)
    }

    /// Tracks the regions of a frame that are on record.
    fn track(&mut self, position: u32) {
        if let Some(analysis) = self.record.outline(position) {
            let analysis = self.pipeline.track_again(analysis);
            self.record.replace(position, analysis);
            self.progress.add_analysed(1);
            self.update_capacity();
        }
    }

    /// Finds and tracks regions in the masks on record, from `position` on.
    fn find_regions(&mut self, position: u32, frames: &[Arc<Frame>]) -> Result<(), PipelineError> {
        let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
        self.progress.add_analysed(frames.len() as u32);
        let raw = (position..).map_while(|position| self.record.raw(position)).take(frames.len()).collect();
        for (position, analysis) in (position..).zip(self.pipeline.analyse_masks(&borrowed, raw)?) {
            self.record.replace_regions(position, analysis);
        }
        self.update_capacity();
        Ok(())
    }

    /// Analyses frames that are not on record.
    fn classify(&mut self, frames: &[Arc<Frame>]) -> Result<(), PipelineError> {
        let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
        self.progress.add_analysed(frames.len() as u32);
        let raw = self.pipeline.masks(&borrowed)?;
        let kept: Vec<_> = raw.par_iter().map(rle::encode_mask).collect();
        for (analysis, raw) in self.pipeline.analyse_masks(&borrowed, raw)?.into_iter().zip(kept) {
            self.record.push(analysis, raw);
        }
        self.keep_model(frames.last())
    }

    /// Stores a checkpoint of the model after this frame, if there is room.
    fn keep_model(&mut self, last: Option<&Arc<Frame>>) -> Result<(), PipelineError> {
        let Some((last, position)) = last.zip(self.analysed().checked_sub(1)) else { return Ok(()) };
        self.update_capacity();
        if let Some(mixture) = self.pipeline.mixture() {
            if self.checkpoints.accepts(self.analysed()) {
                let snapshot = mixture.snapshot();
                let bytes = snapshot.bytes();
                self.checkpoints.insert(self.analysed(), Arc::new(snapshot), bytes);
            }
        } else if self.backgrounds.accepts(position) {
            let background = self.background(last.number, last.size)?;
            let bytes = background.rgb.len();
            self.backgrounds.insert(position, background, bytes);
        }
        Ok(())
    }

    /// The record of the frames.
    pub(crate) const fn record(&self) -> &AnalysisRecord {
        &self.record
    }

    /// The analysis of a frame, without mask and labels.
    pub(crate) fn outline(&self, position: u32) -> Option<&Analysis> {
        self.record.outline(position)
    }

    /// The analysis of a frame in full.
    pub(crate) fn analysis(&self, position: u32) -> Option<Analysis> {
        self.record.analysis(position)
    }

    /// The offline result of all analysed frames.
    pub(crate) fn offline_result(&self) -> OfflineResult {
        offline_result(self.record.outlines(), &self.pipeline)
    }

    /// One step of seeking to the pictures at `position`, whose frame is `frame`, with a map of `quantity` if the
    /// model has it.
    pub(crate) fn seek(
        &mut self,
        position: u32,
        frame: &Frame,
        quantity: Option<Quantity>,
    ) -> Result<SeekStep, PipelineError> {
        if quantity != Some(Quantity::SinceForeground) {
            return self.seek_model(position, frame, quantity.filter(|_| self.pipeline.mixture().is_some()));
        }
        if !self.last_foreground.advance_to(position, &self.record) {
            return Ok(SeekStep::Continues);
        }
        // The map is made together with the final pictures: before that it would be discarded.
        Ok(match self.seek_model(position, frame, None)? {
            SeekStep::Pictures(pictures) => SeekStep::Pictures(
                pictures.with_map(quantity, Some(self.last_foreground.frames_since(position))),
            ),
            unfinished => unfinished,
        })
    }

    /// Whether the model has this quantity.
    pub(crate) fn has(&self, quantity: Quantity) -> bool {
        !quantity.is_of_mixture() || self.pipeline.mixture().is_some()
    }

    /// The positions whose frames are needed for the pictures at `position` with a map of `quantity`, the last one
    /// being `position`; `None` where the earlier mixture is not available.
    pub(crate) fn frames_needed(&self, position: u32, quantity: Quantity) -> Option<Range<u32>> {
        // The time since foreground needs masks only, and the pictures contain none of its values.
        let quantity = Some(quantity).filter(|quantity| quantity.is_of_mixture());
        let before = quantity == Some(Quantity::Matched);
        let recent = self.recent.get(position);
        let recent = recent.is_some_and(|pictures| quantity.is_none_or(|quantity| pictures.has(quantity)));
        if recent || self.pipeline.mixture().is_none() {
            return Some(position..position + 1);
        }
        let is_last = position + 1 == self.record.len();
        if is_last && !before {
            return Some(position..position + 1);
        }
        if is_last && !self.is_close_behind(position) {
            return None;
        }
        let wanted = if before { position } else { position + 1 };
        let kept = checkpoint(&self.checkpoints, &self.local_checkpoints, wanted).map_or(0, |(kept, _)| kept);
        let replay_at = self
            .replay
            .as_ref()
            .map(|(replayed, _)| *replayed)
            .filter(|replayed| (kept..=wanted).contains(replayed));
        Some(replay_at.unwrap_or(kept).min(position)..position + 1)
    }

    fn seek_model(
        &mut self,
        position: u32,
        frame: &Frame,
        quantity: Option<Quantity>,
    ) -> Result<SeekStep, PipelineError> {
        if let Some(pictures) = self.recent.get(position)
            && quantity.is_none_or(|quantity| pictures.has(quantity))
        {
            return Ok(SeekStep::Pictures(pictures));
        }
        let is_last = position + 1 == self.record.len();
        // The matched rank cannot be derived from the mixture after the update.
        let is_there = is_last && quantity != Some(Quantity::Matched);
        let pictures = match self.pipeline.mixture() {
            Some(mixture) if is_there => ModelPictures::of_mixture(mixture, frame, quantity),
            // Earlier frames of a camera may be lost: the next frame may have a map where this one has none.
            Some(mixture) if is_last && self.info.live && !self.is_close_behind(position) => {
                self.replay = Some((self.record.len(), mixture.clone()));
                ModelPictures::of_mixture(mixture, frame, None)
            }
            Some(_) => return Ok(self.seek_past(position, frame, quantity)),
            None if is_last => ModelPictures::of_background(self.background(frame.number, frame.size)?),
            None => {
                let kept = self.backgrounds.at_or_before(position).map(|(_, kept)| Arc::clone(kept));
                let last = self.record.len().checked_sub(1).and_then(|last| self.record.outline(last));
                ModelPictures::of_background(match kept {
                    Some(kept) => kept,
                    // The only one left is that of the last frame.
                    None => self.background(last.map_or(frame.number, |last| last.number), frame.size)?,
                })
            }
        };
        Ok(SeekStep::Pictures(pictures))
    }

    /// Whether the replay is at most a checkpoint distance before `position`.
    fn is_close_behind(&self, position: u32) -> bool {
        let close = position.saturating_sub(MIN_CHECKPOINT_SPACING_FRAMES)..=position;
        self.replay.as_ref().is_some_and(|(replayed, _)| close.contains(replayed))
    }

    fn seek_past(&mut self, position: u32, frame: &Frame, quantity: Option<Quantity>) -> SeekStep {
        // The matched component of a frame is determined by the mixture before it.
        let before = quantity == Some(Quantity::Matched);
        let wanted = if before { position } else { position + 1 };
        let parameters = self
            .pipeline
            .mixture()
            .map_or_else(|| Parameters::new(&self.settings), |mixture| *mixture.parameters());
        let new = || {
            let mut mixture = Mixture::new(self.info.size, parameters);
            if let Some(start) = &self.start {
                mixture.restore(start);
            }
            (0, mixture)
        };
        let (replayed, mixture) = self.replay.get_or_insert_with(new);
        let checkpoint = checkpoint(&self.checkpoints, &self.local_checkpoints, wanted);
        // The replay is nearer if it is past the checkpoint but not past the target.
        let nearest = checkpoint.map_or(0, |(kept, _)| kept);
        if !(nearest..=wanted).contains(replayed) {
            match checkpoint {
                Some((kept, snapshot)) if mixture.restore(snapshot) => *replayed = kept,
                _ => (*replayed, *mixture) = new(),
            }
        }
        if *replayed < wanted {
            // No further than the next position for a checkpoint.
            let most = (max_frames_per_step(self.info.size) as u32)
                .min(MIN_CHECKPOINT_SPACING_FRAMES - *replayed % MIN_CHECKPOINT_SPACING_FRAMES);
            return SeekStep::NeedsFrames(*replayed..wanted.min(*replayed + most));
        }
        let matches = before.then(|| mixture.matches(frame));
        if before {
            self.masks.resize_with(1, || Mask::empty(self.info.size));
            mixture.step_many(&[frame], &mut self.masks);
            *replayed += 1;
        }
        let pictures = ModelPictures::of_mixture(mixture, frame, quantity).with_map(quantity, matches);
        self.recent.insert(position, pictures.clone());
        SeekStep::Pictures(pictures)
    }

    /// Advances the replay by the frames from `position` on, towards the one at `wanted`.
    pub(crate) fn replay_frames(&mut self, position: u32, frames: &[Arc<Frame>], wanted: u32) {
        if let Some((replayed, mixture)) = &mut self.replay
            && *replayed == position
        {
            let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
            self.masks.resize_with(frames.len(), || Mask::empty(self.info.size));
            mixture.step_many(&borrowed, &mut self.masks);
            *replayed += frames.len() as u32;
            // Checkpoints may be sparse: some are stored on the way, for the next step back.
            if replayed.is_multiple_of(MIN_CHECKPOINT_SPACING_FRAMES)
                && !self.local_checkpoints.has(*replayed)
            {
                let snapshot = mixture.snapshot();
                let bytes = snapshot.bytes();
                self.local_checkpoints.insert(*replayed, snapshot, bytes, wanted);
            }
        }
    }

    fn background(&self, number: u32, size: Size) -> Result<Arc<Frame>, PipelineError> {
        Ok(Arc::new(Frame::new(number, size, self.pipeline.background_image()?)))
    }
}

/// The stored mixture nearest to, and not after, this number of frames.
fn checkpoint<'a>(
    checkpoints: &'a StridedCheckpoints<Arc<Snapshot>>,
    local: &'a LocalCheckpoints<Snapshot>,
    wanted: u32,
) -> Option<(u32, &'a Snapshot)> {
    let strided = checkpoints.at_or_before(wanted).map(|(kept, snapshot)| (kept, &**snapshot));
    [strided, local.at_or_before(wanted)].into_iter().flatten().max_by_key(|(kept, _)| *kept)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::replay::tests::{info_of, scene, settings, single_pass};
    use crate::settings::Span;

    /// Enough frames for two checkpoints.
    const FRAMES: usize = 2 * MIN_CHECKPOINT_SPACING_FRAMES as usize + 6;

    #[test]
    fn the_frames_needed_for_a_map_begin_at_the_nearest_model() {
        let folder = scene();
        let settings = Settings { bootstrap: Span::Frames(0), ..settings() };
        let seen = single_pass(folder.path(), &settings);
        let size = seen[0].frame.size;
        let frames: Vec<_> = seen.iter().cycle().take(FRAMES).map(|shown| Arc::clone(&shown.frame)).collect();
        let (settings, info) = (Arc::new(settings), Arc::new(info_of(size)));
        let inputs = PassInputs { settings, roi: None, info, budget: 1 << 30 };
        let mut model = ModelTimeline::new(inputs).unwrap();
        for frame in &frames {
            model.advance(std::slice::from_ref(frame)).unwrap();
        }
        let spacing = MIN_CHECKPOINT_SPACING_FRAMES;
        let last = FRAMES as u32 - 1;
        // The present model is that of the last frame. The rank that matched needs the model before the frame.
        assert_eq!(model.frames_needed(last, Quantity::Sigma), Some(last..last + 1));
        assert_eq!(model.frames_needed(last, Quantity::Matched), None, "of a live source");
        for quantity in [Quantity::Sigma, Quantity::Matched] {
            assert_eq!(model.frames_needed(spacing + 9, quantity), Some(spacing..spacing + 10));
            assert_eq!(model.frames_needed(spacing - 2, quantity), Some(0..spacing - 1));
        }
        assert_eq!(model.frames_needed(spacing - 1, Quantity::Sigma), Some(spacing - 1..spacing));
        assert_eq!(model.frames_needed(spacing - 1, Quantity::Matched), Some(0..spacing));
        let mut seek = |position: u32| {
            loop {
                match model.seek(position, &frames[position as usize], None).unwrap() {
                    SeekStep::Pictures(_) => return,
                    SeekStep::Continues => {}
                    SeekStep::NeedsFrames(range) => {
                        let passed = &frames[range.start as usize..range.end as usize];
                        model.replay_frames(range.start, passed, position);
                    }
                }
            }
        };
        seek(spacing + 5);
        seek(spacing + 10);
        // The model of the frame shown last goes on, and the pictures of the one before are kept.
        assert_eq!(model.frames_needed(spacing + 14, Quantity::Sigma), Some(spacing + 11..spacing + 15));
        assert_eq!(
            model.frames_needed(spacing + 5, Quantity::SinceForeground),
            Some(spacing + 5..spacing + 6)
        );
        assert_eq!(model.frames_needed(spacing + 5, Quantity::Sigma), Some(spacing..spacing + 6));
        assert_eq!(model.frames_needed(last, Quantity::Matched), Some(2 * spacing..last + 1));
    }

    #[test]
    fn the_record_of_a_second_pass_reduces_the_memory_for_checkpoints() {
        let folder = scene();
        let frames: Vec<_> =
            single_pass(folder.path(), &settings()).into_iter().map(|shown| shown.frame).collect();
        let size = frames[0].size;
        let info = info_of(size);
        let without_learning = Settings { bootstrap: Span::Frames(0), ..settings() };
        let few = Arc::new(Settings { median: 5, min_area: 2000, ..without_learning.clone() });
        let many = Arc::new(Settings { median: 0, min_area: 0, ..without_learning.clone() });
        let pass = |run: &mut ModelTimeline| {
            for frame in frames.iter().cycle().take(FRAMES) {
                run.advance(std::slice::from_ref(frame)).unwrap();
            }
        };
        let run_of = |settings: &Arc<Settings>, budget| {
            let (settings, info) = (Arc::clone(settings), Arc::new(info.clone()));
            let mut run = ModelTimeline::new(PassInputs { settings, roi: None, info, budget }).unwrap();
            pass(&mut run);
            run
        };
        let [first, second] = [&few, &many].map(|settings| run_of(settings, 1 << 30));
        let (one_pass, two_passes) = (first.record.bytes(), second.record.bytes());
        assert!(two_passes > one_pass + 10_000, "{one_pass} {two_passes}");
        let models = [MIN_CHECKPOINT_SPACING_FRAMES, 2 * MIN_CHECKPOINT_SPACING_FRAMES]
            .map(|at| first.checkpoints.at_or_before(at).unwrap().1.bytes());
        let model_budget_bytes = models.iter().sum::<usize>() + usize::midpoint(one_pass, two_passes);

        let mut run = run_of(&few, model_budget_bytes.div_ceil(11) * 16);
        assert!(
            run.checkpoints.at_or_before(MIN_CHECKPOINT_SPACING_FRAMES).is_some(),
            "the capacity is sufficient for both"
        );
        run.restart_at(Stage::Cleaning, Arc::clone(&many), None).unwrap();
        pass(&mut run);
        assert_eq!(run.record.bytes(), two_passes);
        assert!(run.checkpoints.at_or_before(MIN_CHECKPOINT_SPACING_FRAMES).is_none(), "one is dropped");
        let late = Arc::new(Settings { max_hypotheses: 1, ..Settings::clone(&many) });
        let fresh = run_of(&late, 1 << 30);
        run.restart_at(Stage::Tracking, late, None).unwrap();
        while matches!(run.next_step(), NextStep::Track(_)) {
            run.advance(&[]).unwrap();
        }
        assert_eq!(run.record.bytes(), fresh.record.bytes());
        assert_ne!(fresh.record.bytes(), two_passes);
    }
}
