//! One choice of settings over the sequence: how far it has come, its record, and its model at any
//! frame on the way.

use std::sync::Arc;

use super::pictures::{Pictures, Recent};
use super::record::Record;
use super::spaced::Spaced;
use crate::frame::{Frame, Size};
use crate::mixture::{Mixture, Parameters};
use crate::pipeline::{Analysis, Pipeline, PipelineError, Reading, final_reading};
use crate::settings::Settings;
use crate::source::SourceInfo;

/// Checkpoints are not closer than this: replaying so few frames takes no time worth the memory.
const CLOSEST: u32 = 16;

/// The analysis of a sequence under one choice of settings.
///
/// A mixture at a past frame is that of the nearest checkpoint, taken forward frame by frame:
/// the same bits as when it passed there first. The state of MOG2 and KNN cannot be copied: of
/// them the background images are kept, every frame's while there is room, then every second, and
/// so on; a frame whose image is not kept gets that of the nearest earlier one that is.
pub(super) struct Run {
    settings: Arc<Settings>,
    info: Arc<SourceInfo>,
    pipeline: Pipeline,
    record: Record,
    /// Frames analysed in full; less than on record while tracking is being redone.
    front: u32,
    /// Mixtures by the number of frames that they have taken in.
    checkpoints: Spaced<Mixture>,
    /// Background images by position, of models that cannot be copied.
    backgrounds: Spaced<Arc<Frame>>,
    /// A mixture on its way through the past, and the frames that it has taken in.
    replay: Option<(u32, Mixture)>,
    recent: Recent,
}

/// What replaying towards a frame gave.
pub(super) enum Towards {
    /// The pictures of that frame.
    Pictures(Pictures),
    /// The frame at this position has to be given to [`Run::replay_frame`] first.
    Needs(u32),
}

impl Run {
    /// Nothing analysed yet; `budget` is the memory for going back in time, in bytes.
    pub(super) fn new(
        settings: Arc<Settings>,
        info: &Arc<SourceInfo>,
        budget: usize,
    ) -> Result<Self, PipelineError> {
        let pipeline = Pipeline::new(&settings, info.size, info.fps)?;
        let frame_bytes = (info.size.pixels() * 3).max(1);
        let (for_pictures, for_models) = (budget / 8, budget / 8 * 7);
        let state_bytes = pipeline.mixture().map_or(usize::MAX, |mixture| mixture.state_bytes().max(1));
        let recent = (for_pictures / (frame_bytes * 7 / 3).max(1)).clamp(1, 512);
        Ok(Self {
            checkpoints: Spaced::new(CLOSEST, for_models / state_bytes),
            backgrounds: Spaced::new(1, for_models / frame_bytes),
            record: Record::new(info.size),
            info: Arc::clone(info),
            settings,
            pipeline,
            front: 0,
            replay: None,
            recent: Recent::new(recent),
        })
    }

    pub(super) const fn settings(&self) -> &Arc<Settings> {
        &self.settings
    }

    /// How many frames have been analysed under these settings.
    pub(super) const fn front(&self) -> u32 {
        self.front
    }

    /// How many frames the model has seen.
    pub(super) fn modelled(&self) -> u32 {
        self.record.len()
    }

    /// Whether the next frame needs tracking alone, for which [`Self::track_next`] is there.
    pub(super) fn is_tracking_again(&self) -> bool {
        self.front < self.record.len()
    }

    /// Takes other settings of tracking and occlusion: masks, regions and models stay.
    pub(super) fn restart_tracking(&mut self, settings: Arc<Settings>) {
        self.pipeline.restart_tracking(&settings, self.info.fps);
        self.settings = settings;
        self.front = 0;
    }

    /// Tracks the next frame that is on record.
    pub(super) fn track_next(&mut self) {
        if let Some((analysis, _)) = self.record.outline(self.front) {
            let analysis = self.pipeline.track_again(analysis);
            self.record.replace(self.front, analysis);
            self.front += 1;
        }
    }

    /// Analyses the next frame.
    pub(super) fn step(&mut self, frame: &Frame) -> Result<(), PipelineError> {
        let analysis = self.pipeline.step(frame)?;
        self.record.push(analysis);
        let position = self.front;
        self.front += 1;
        if let Some(mixture) = self.pipeline.mixture() {
            if self.checkpoints.wants(self.front) {
                self.checkpoints.insert(self.front, mixture.clone());
            }
        } else if self.backgrounds.wants(position) {
            let background = self.background(frame.number, frame.size)?;
            self.backgrounds.insert(position, background);
        }
        Ok(())
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
    pub(super) fn final_reading(&self) -> Reading {
        final_reading(self.record.outlines(), &self.pipeline)
    }

    /// One step towards the pictures at `position`, whose frame is `frame`.
    pub(super) fn towards(&mut self, position: u32, frame: &Frame) -> Result<Towards, PipelineError> {
        if let Some(pictures) = self.recent.get(position) {
            return Ok(Towards::Pictures(pictures));
        }
        let is_last = position + 1 == self.record.len();
        let pictures = match self.pipeline.mixture() {
            Some(mixture) if is_last => Pictures::of_mixture(mixture, frame),
            Some(_) => return Ok(self.towards_past(position, frame)),
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

    fn towards_past(&mut self, position: u32, frame: &Frame) -> Towards {
        let wanted = position + 1;
        let checkpoint = self.checkpoints.at_or_before(wanted).filter(|(taken, _)| {
            // A replay that has come farther, yet not too far, is nearer.
            !self.replay.as_ref().is_some_and(|(replayed, _)| (*taken..=wanted).contains(replayed))
        });
        if let Some((taken, mixture)) = checkpoint {
            self.replay = Some((taken, mixture.clone()));
        }
        let (taken, mixture) = match &mut self.replay {
            Some(replay) if replay.0 <= wanted => replay,
            replay => replay.insert((0, Mixture::new(self.info.size, Parameters::new(&self.settings)))),
        };
        if *taken < wanted {
            return Towards::Needs(*taken);
        }
        let pictures = Pictures::of_mixture(mixture, frame);
        self.recent.insert(position, pictures.clone());
        Towards::Pictures(pictures)
    }

    /// Takes the replay one frame on. `keep`: its pictures will be asked for soon.
    pub(super) fn replay_frame(&mut self, position: u32, frame: &Frame, keep: bool) {
        if let Some((taken, mixture)) = &mut self.replay
            && *taken == position
        {
            mixture.step(frame);
            *taken += 1;
            if keep && self.recent.get(position).is_none() {
                self.recent.insert(position, Pictures::of_mixture(mixture, frame));
            }
        }
    }

    fn background(&self, number: u32, size: Size) -> Result<Arc<Frame>, PipelineError> {
        Ok(Arc::new(Frame::new(number, size, self.pipeline.background_image()?)))
    }
}
