//! One choice of settings over the sequence: how far it has come, its record, and its model at any
//! frame on the way.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::near::Near;
use super::pictures::{Pictures, Recent};
use super::record::Record;
use super::runs;
use super::since::Since;
use super::spaced::Spaced;
use crate::frame::{Frame, Mask, Size};
use crate::mixture::{BATCH, Mixture, Parameters, Quantity, Snapshot};
use crate::pipeline::{Analysis, OfflineResult, Pipeline, PipelineError, offline_result};
use crate::regions::Roi;
use crate::settings::{Settings, Stage};
use crate::source::SourceInfo;

/// Checkpoints are not closer than this: replaying so few frames takes no time worth the memory.
const CLOSEST: u32 = 2 * BATCH as u32;

/// A piece of work takes frames of so many pixels together at most, and one frame at least: it is
/// not to keep a newer request waiting.
const PIXELS_AT_ONCE: usize = 8 << 20;

/// How many frames of this size a piece of work may take.
fn most_at_once(size: Size) -> usize {
    (PIXELS_AT_ONCE / size.pixels().max(1)).clamp(1, BATCH)
}

/// The analysis of a sequence under one choice of settings.
///
/// A mixture at a past frame is that of the nearest checkpoint, taken forward frame by frame:
/// the same bits as when it passed there first. The state of MOG2 and KNN cannot be copied: of
/// them the background images are kept, every frame's while there is room, then every second, and
/// so on; a frame whose image is not kept gets that of the nearest earlier one that is.
pub(super) struct Run {
    settings: Arc<Settings>,
    roi: Option<Arc<Roi>>,
    info: Arc<SourceInfo>,
    pipeline: Pipeline,
    record: Record,
    /// How many of the first frames the model is to learn from before it begins; less where there are fewer.
    to_learn: u32,
    /// How many it has learnt from.
    learnt: u32,
    /// The mixture as it begins, where it learnt from anything.
    start: Option<Arc<Snapshot>>,
    /// Frames analysed in full; less than on record while what follows the model is being redone.
    front: u32,
    /// Whether what is redone begins with the regions, and not with tracking.
    finding_again: bool,
    /// Memory for models and the record, in bytes.
    for_models: usize,
    /// Mixtures by the number of frames that they have taken in.
    checkpoints: Spaced<Arc<Snapshot>>,
    /// Mixtures on the way to frames that were looked at, by the number of frames taken in.
    near: Near<Snapshot>,
    /// Background images by position, of models that cannot be copied.
    backgrounds: Spaced<Arc<Frame>>,
    /// A mixture on its way through the past, and the frames that it has taken in.
    replay: Option<(u32, Mixture)>,
    /// Where a replay puts masks that nobody needs.
    masks: Vec<Mask>,
    recent: Recent,
    since: Since,
}

/// What replaying towards a frame gave.
pub(super) enum Towards {
    /// The pictures of that frame.
    Pictures(Pictures),
    /// They take another piece of work.
    GoesOn,
    /// The frames at these positions have to be given to [`Run::replay_frames`] first, at least one.
    Needs(Range<u32>),
}

impl Run {
    /// Nothing analysed yet; `budget` is the memory for going back in time, in bytes.
    pub(super) fn new(
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
        info: &Arc<SourceInfo>,
        budget: usize,
    ) -> Result<Self, PipelineError> {
        let mut pipeline = Pipeline::new(&settings, info.size, info.fps)?;
        pipeline.set_roi(roi.clone())?;
        let to_learn = info.bootstrap(&settings);
        let mut run = Self {
            for_models: 0,
            checkpoints: Spaced::new(CLOSEST, 0),
            near: Near::new(0),
            backgrounds: Spaced::new(1, 0),
            record: Record::new(info.size),
            info: Arc::clone(info),
            settings,
            roi,
            pipeline,
            to_learn,
            learnt: 0,
            start: None,
            front: 0,
            finding_again: false,
            replay: None,
            masks: Vec::new(),
            recent: Recent::new(1),
            since: Since::new(info.size),
        };
        run.set_budget(budget);
        Ok(run)
    }

    /// Another run that has come just as far, with its own `budget`: what was analysed and the models on the way are
    /// shared. `None` where the model's state cannot be copied.
    pub(super) fn fork(&self, budget: usize) -> Option<Self> {
        let mut fork = Self {
            pipeline: self.pipeline.try_clone()?,
            settings: Arc::clone(&self.settings),
            roi: self.roi.clone(),
            info: Arc::clone(&self.info),
            start: self.start.clone(),
            record: self.record.clone(),
            checkpoints: self.checkpoints.clone(),
            near: Near::new(0),
            backgrounds: self.backgrounds.clone(),
            replay: None,
            masks: Vec::new(),
            recent: self.recent.clone(),
            since: Since::new(self.info.size),
            ..*self
        };
        fork.set_budget(budget);
        Some(fork)
    }

    /// Keeps within so much memory for going back in time, in bytes.
    pub(super) fn set_budget(&mut self, budget: usize) {
        let frame_bytes = (self.info.size.pixels() * 3).max(1);
        let (for_pictures, for_near, for_since) = (budget / 8, budget / 8, budget / 16);
        self.for_models = budget / 16 * 11;
        self.since.set_room(for_since);
        self.near.set_room(for_near);
        self.recent.set_room((for_pictures / (frame_bytes * 10 / 3).max(1)).clamp(1, 512));
        self.give_room();
    }

    /// Every frame's record is kept: what it takes, models go without.
    fn give_room(&mut self) {
        let start = self.start.as_ref().map_or(0, |start| start.bytes());
        let room = self.for_models.saturating_sub(self.record.bytes() + start);
        self.checkpoints.set_room(room);
        self.backgrounds.set_room(room);
    }

    pub(super) const fn settings(&self) -> &Arc<Settings> {
        &self.settings
    }

    pub(super) const fn info(&self) -> &Arc<SourceInfo> {
        &self.info
    }

    pub(super) const fn roi(&self) -> Option<&Arc<Roi>> {
        self.roi.as_ref()
    }

    /// How many frames have been analysed under these settings.
    pub(super) const fn front(&self) -> u32 {
        self.front
    }

    /// The position of the first frame that the model still has to learn from before it begins; `None` when it has
    /// begun.
    pub(super) fn learns(&self) -> Option<u32> {
        (self.learnt < self.to_learn).then_some(self.learnt)
    }

    /// How many of the first frames the model is to learn from, as far as that is known.
    pub(super) const fn to_learn(&self) -> u32 {
        self.to_learn
    }

    /// Learns from the next frames, from that at [`Self::learns`] on: no more than [`Self::most_frames`].
    pub(super) fn learn(&mut self, frames: &[Arc<Frame>]) -> Result<(), PipelineError> {
        let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
        self.pipeline.learn(&borrowed)?;
        self.learnt += frames.len() as u32;
        if self.learnt == self.to_learn {
            self.begin();
        }
        Ok(())
    }

    /// Begins with what is learnt: there are no more frames to learn from.
    pub(super) fn begin(&mut self) {
        self.to_learn = self.learnt;
        self.pipeline.begin();
        self.start = self.pipeline.mixture().map(|mixture| Arc::new(mixture.snapshot()));
        self.give_room();
    }

    /// How many frames have been judged under the model.
    pub(super) fn modelled(&self) -> u32 {
        self.record.len()
    }

    /// Whether the next frame needs tracking alone, for which [`Self::track_next`] is there.
    pub(super) fn is_tracking_again(&self) -> bool {
        self.front < self.record.len() && !self.finding_again
    }

    /// Takes other settings, of which those before `stage` are the same: what comes before it stays.
    /// Another `roi` needs a stage no later than cleaning. The model itself has to run again in another [`Run`].
    pub(super) fn restart_at(
        &mut self,
        stage: Stage,
        settings: Arc<Settings>,
        roi: Option<Arc<Roi>>,
    ) -> Result<(), PipelineError> {
        self.pipeline.set_roi(roi.clone())?;
        self.roi = roi;
        // Frames that were not reached yet still have regions of the settings before.
        let half_done = self.finding_again && self.front < self.record.len();
        self.finding_again = half_done || stage <= Stage::Regions;
        self.pipeline.restart_finding(&settings, self.info.fps);
        self.settings = settings;
        self.front = 0;
        Ok(())
    }

    /// Tracks the next frame that is on record.
    pub(super) fn track_next(&mut self) {
        if let Some((analysis, _)) = self.record.outline(self.front) {
            let analysis = self.pipeline.track_again(analysis);
            self.record.replace(self.front, analysis);
            self.front += 1;
            self.give_room();
        }
    }

    /// How many of the next frames [`Self::learn`] or [`Self::step`] may take at a time: after the last of them the
    /// model may have to be kept.
    pub(super) fn most_frames(&self) -> usize {
        let until_kept = match self.pipeline.mixture() {
            _ if self.learnt < self.to_learn => self.to_learn - self.learnt,
            _ if self.front < self.record.len() => self.record.len() - self.front,
            Some(_) => self.checkpoints.until_next(self.front),
            None => 1,
        };
        most_at_once(self.info.size).min(until_kept as usize).max(1)
    }

    /// Analyses the next frames, up to [`Self::most_frames`] of them.
    pub(super) fn step(&mut self, frames: &[Arc<Frame>]) -> Result<(), PipelineError> {
        let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
        let position = self.front;
        self.front += frames.len() as u32;
        if position < self.record.len() {
            let raw =
                (position..).map_while(|position| self.record.raw(position)).take(frames.len()).collect();
            for (position, analysis) in (position..).zip(self.pipeline.find_many(&borrowed, raw)?) {
                self.record.find_again(position, analysis);
            }
            self.give_room();
            return Ok(());
        }
        let raw = self.pipeline.masks(&borrowed)?;
        let kept: Vec<_> = raw.par_iter().map(runs::of_mask).collect();
        for (analysis, raw) in self.pipeline.find_many(&borrowed, raw)?.into_iter().zip(kept) {
            self.record.push(analysis, raw);
        }
        self.keep_model(frames.last())
    }

    /// Keeps what is needed to come back to the model as it is after this frame, if there is room.
    fn keep_model(&mut self, last: Option<&Arc<Frame>>) -> Result<(), PipelineError> {
        let Some((last, position)) = last.zip(self.front.checked_sub(1)) else { return Ok(()) };
        self.give_room();
        if let Some(mixture) = self.pipeline.mixture() {
            if self.checkpoints.wants(self.front) {
                let snapshot = mixture.snapshot();
                let bytes = snapshot.bytes();
                self.checkpoints.insert(self.front, Arc::new(snapshot), bytes);
            }
        } else if self.backgrounds.wants(position) {
            let background = self.background(last.number, last.size)?;
            let bytes = background.rgb.len();
            self.backgrounds.insert(position, background, bytes);
        }
        Ok(())
    }

    /// What is kept of the frames.
    pub(super) const fn record(&self) -> &Record {
        &self.record
    }

    /// The analysis of a frame, without mask and labels, and its share of foreground.
    pub(super) fn outline(&self, position: u32) -> Option<(&Analysis, f32)> {
        self.record.outline(position)
    }

    /// The analysis of a frame in full.
    pub(super) fn analysis(&self, position: u32) -> Option<Analysis> {
        self.record.analysis(position)
    }

    /// The final reading of all that has been analysed.
    pub(super) fn offline_result(&self) -> OfflineResult {
        offline_result(self.record.outlines(), &self.pipeline)
    }

    /// One step towards the pictures at `position`, whose frame is `frame`, with a map of `quantity` where the model
    /// has it.
    pub(super) fn towards(
        &mut self,
        position: u32,
        frame: &Frame,
        quantity: Option<Quantity>,
    ) -> Result<Towards, PipelineError> {
        if quantity != Some(Quantity::Since) {
            return self.towards_model(
                position,
                frame,
                quantity.filter(|_| self.pipeline.mixture().is_some()),
            );
        }
        if !self.since.reach(position, &self.record) {
            return Ok(Towards::GoesOn);
        }
        // The map is made when the pictures are there: on the way to them it would be thrown away.
        Ok(match self.towards_model(position, frame, None)? {
            Towards::Pictures(pictures) => {
                Towards::Pictures(pictures.with_map(quantity, Some(self.since.at(position))))
            }
            on_the_way => on_the_way,
        })
    }

    /// Whether the model has such a number of each pixel.
    pub(super) fn has(&self, quantity: Quantity) -> bool {
        !quantity.is_of_mixture() || self.pipeline.mixture().is_some()
    }

    /// The positions whose frames it takes to come to the pictures at `position` with a map of `quantity`, its own the
    /// last of them; `None` where the mixture before it is not to be had.
    pub(super) fn way_to(&self, position: u32, quantity: Quantity) -> Option<Range<u32>> {
        // The time since foreground needs masks alone, and the pictures have none of its numbers.
        let quantity = Some(quantity).filter(|quantity| quantity.is_of_mixture());
        let before = quantity == Some(Quantity::Matched);
        let at_hand = self.recent.get(position);
        let at_hand = at_hand.is_some_and(|pictures| quantity.is_none_or(|quantity| pictures.has(quantity)));
        if at_hand || self.pipeline.mixture().is_none() {
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
        let kept = checkpoint(&self.checkpoints, &self.near, wanted).map_or(0, |(kept, _)| kept);
        let come =
            self.replay.as_ref().map(|(taken, _)| *taken).filter(|taken| (kept..=wanted).contains(taken));
        Some(come.unwrap_or(kept).min(position)..position + 1)
    }

    fn towards_model(
        &mut self,
        position: u32,
        frame: &Frame,
        quantity: Option<Quantity>,
    ) -> Result<Towards, PipelineError> {
        if let Some(pictures) = self.recent.get(position)
            && quantity.is_none_or(|quantity| pictures.has(quantity))
        {
            return Ok(Towards::Pictures(pictures));
        }
        let is_last = position + 1 == self.record.len();
        // What matched is not to be seen in the mixture after the update.
        let is_there = is_last && quantity != Some(Quantity::Matched);
        let pictures = match self.pipeline.mixture() {
            Some(mixture) if is_there => Pictures::of_mixture(mixture, frame, quantity),
            // What a camera gave a while ago may be gone: the next frame will have what this one cannot.
            Some(mixture) if is_last && self.info.live && !self.is_close_behind(position) => {
                self.replay = Some((self.record.len(), mixture.clone()));
                Pictures::of_mixture(mixture, frame, None)
            }
            Some(_) => return Ok(self.towards_past(position, frame, quantity)),
            None if is_last => Pictures::of_background(self.background(frame.number, frame.size)?),
            None => {
                let kept = self.backgrounds.at_or_before(position).map(|(_, kept)| Arc::clone(kept));
                Pictures::of_background(match kept {
                    Some(kept) => kept,
                    None => self.background(frame.number, frame.size)?,
                })
            }
        };
        Ok(Towards::Pictures(pictures))
    }

    /// Whether the replay is where few frames take it to `position`.
    fn is_close_behind(&self, position: u32) -> bool {
        let close = position.saturating_sub(CLOSEST)..=position;
        self.replay.as_ref().is_some_and(|(taken, _)| close.contains(taken))
    }

    fn towards_past(&mut self, position: u32, frame: &Frame, quantity: Option<Quantity>) -> Towards {
        // Which component a frame matched is told by the mixture before it.
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
        let (taken, mixture) = self.replay.get_or_insert_with(new);
        let checkpoint = checkpoint(&self.checkpoints, &self.near, wanted);
        // A replay that has come farther, yet not too far, is nearer.
        let nearest = checkpoint.map_or(0, |(kept, _)| kept);
        if !(nearest..=wanted).contains(taken) {
            match checkpoint {
                Some((kept, snapshot)) if mixture.restore(snapshot) => *taken = kept,
                _ => (*taken, *mixture) = new(),
            }
        }
        if *taken < wanted {
            // Not beyond where the model may be kept.
            let most = (most_at_once(self.info.size) as u32).min(CLOSEST - *taken % CLOSEST);
            return Towards::Needs(*taken..wanted.min(*taken + most));
        }
        let matches = before.then(|| mixture.matches(frame));
        if before {
            self.masks.resize_with(1, || Mask::empty(self.info.size));
            mixture.replay(&[frame], &mut self.masks);
            *taken += 1;
        }
        let pictures = Pictures::of_mixture(mixture, frame, quantity).with_map(quantity, matches);
        self.recent.insert(position, pictures.clone());
        Towards::Pictures(pictures)
    }

    /// Takes the replay on by the frames from `position` on, on the way to the one at `wanted`.
    pub(super) fn replay_frames(&mut self, position: u32, frames: &[Arc<Frame>], wanted: u32) {
        if let Some((taken, mixture)) = &mut self.replay
            && *taken == position
        {
            let borrowed: Vec<_> = frames.iter().map(Arc::as_ref).collect();
            self.masks.resize_with(frames.len(), || Mask::empty(self.info.size));
            mixture.replay(&borrowed, &mut self.masks);
            *taken += frames.len() as u32;
            // Checkpoints may have become few: some of the way is kept, for the next step back.
            if taken.is_multiple_of(CLOSEST) && !self.near.has(*taken) {
                let snapshot = mixture.snapshot();
                let bytes = snapshot.bytes();
                self.near.insert(*taken, snapshot, bytes, wanted);
            }
        }
    }

    fn background(&self, number: u32, size: Size) -> Result<Arc<Frame>, PipelineError> {
        Ok(Arc::new(Frame::new(number, size, self.pipeline.background_image()?)))
    }
}

/// The mixture that is kept nearest before so many frames.
fn checkpoint<'a>(
    checkpoints: &'a Spaced<Arc<Snapshot>>,
    near: &'a Near<Snapshot>,
    wanted: u32,
) -> Option<(u32, &'a Snapshot)> {
    let spaced = checkpoints.at_or_before(wanted).map(|(kept, snapshot)| (kept, &**snapshot));
    [spaced, near.at_or_before(wanted)].into_iter().flatten().max_by_key(|(kept, _)| *kept)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::replay::tests::{scene, settings, straight};

    /// So many frames that the model is kept twice on the way.
    const FRAMES: usize = 2 * CLOSEST as usize + 6;

    #[test]
    fn what_a_second_pass_finds_is_counted_and_models_make_room_for_it() {
        let folder = scene();
        let frames: Vec<_> =
            straight(folder.path(), &settings()).into_iter().map(|shown| shown.frame).collect();
        let size = frames[0].size;
        let info = SourceInfo {
            name: "scene".into(),
            size,
            fps: 25.0,
            fps_from: crate::source::FpsFrom::Video,
            frames: None,
            live: false,
        };
        let few = Arc::new(Settings { median: 5, min_area: 2000, ..settings() });
        let many = Arc::new(Settings { median: 0, min_area: 0, ..settings() });
        let pass = |run: &mut Run| {
            for frame in frames.iter().cycle().take(FRAMES) {
                run.step(std::slice::from_ref(frame)).unwrap();
            }
        };
        let run = |settings: &Arc<Settings>, budget| {
            let mut run = Run::new(Arc::clone(settings), None, &Arc::new(info.clone()), budget).unwrap();
            pass(&mut run);
            run
        };
        let [first, second] = [&few, &many].map(|settings| run(settings, 1 << 30));
        let (one_pass, two_passes) = (first.record.bytes(), second.record.bytes());
        assert!(two_passes > one_pass + 10_000, "{one_pass} {two_passes}");
        let models = [CLOSEST, 2 * CLOSEST].map(|at| first.checkpoints.at_or_before(at).unwrap().1.bytes());
        let for_models = models.iter().sum::<usize>() + usize::midpoint(one_pass, two_passes);

        let mut run = run(&few, for_models.div_ceil(11) * 16);
        assert!(run.checkpoints.at_or_before(CLOSEST).is_some(), "there is room for both");
        run.restart_at(Stage::Cleaning, Arc::clone(&many), None).unwrap();
        pass(&mut run);
        assert_eq!(run.record.bytes(), two_passes);
        assert!(run.checkpoints.at_or_before(CLOSEST).is_none(), "one has to go");
        let late = Settings { max_hypotheses: 1, ..settings() };
        let late = Arc::new(Settings { median: 0, min_area: 0, ..late });
        let fresh = self::Run::new(Arc::clone(&late), None, &Arc::new(info.clone()), 1 << 30);
        let mut fresh = fresh.unwrap();
        pass(&mut fresh);
        run.restart_at(Stage::Tracking, late, None).unwrap();
        while run.is_tracking_again() {
            run.track_next();
        }
        assert_eq!(run.record.bytes(), fresh.record.bytes());
        assert_ne!(fresh.record.bytes(), two_passes);
    }
}
