//! One frame through all stages.

use std::sync::Arc;

use crate::frame::{Frame, Mask, Size};
use crate::mixture::opencv::OpencvModel;
use crate::mixture::{Mixture, Parameters};
use crate::occlusion::{Counters, Episode, Event};
use crate::regions::{Cleaning, Labels, Region, find_regions};
use crate::settings::Settings;
use crate::tracking::{Naming, Track, Tracker};

/// Why a frame could not be analysed.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// OpenCV refused; its words say why.
    #[error("OpenCV failed on frame {frame}: {source}")]
    Opencv {
        /// The frame's number, 0 before the first.
        frame: u32,
        /// OpenCV's own error.
        source: opencv::Error,
    },
    /// A frame of another size than those before it.
    #[error("frame {frame} is {found} where {expected} was expected; all frames must have one size")]
    Size {
        /// The frame's number.
        frame: u32,
        /// Its size.
        found: Size,
        /// The size of the frames before it.
        expected: Size,
    },
}

/// What all stages made of one frame: the causal reading, what was known at that frame.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The frame's number in its source.
    pub number: u32,
    /// The frame's place since the model started, from 1.
    pub t: u32,
    /// The foreground in which regions were found: after cleaning, before `min_area`.
    pub mask: Arc<Mask>,
    /// To which region each pixel belongs.
    pub labels: Arc<Labels>,
    /// The regions, by label.
    pub regions: Arc<Vec<Region>>,
    /// The objects that have an identity.
    pub tracks: Arc<Vec<Track>>,
    /// Objects seen in too few frames yet to have one (`id` 0).
    pub tentative: Arc<Vec<Track>>,
    /// All objects as the tracker keeps them, under their keys, for the final reading.
    pub objects: Arc<Vec<Track>>,
    /// The events that were decided in this frame; some may have happened a few frames earlier.
    pub events: Arc<Vec<Event>>,
    /// All events decided up to this frame, by kind.
    pub counters: Counters,
}

/// The final reading of a sequence: short tracks gone, late decisions entered.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Frame by frame in order: its number, and the objects with an identity, by identity.
    pub tracks: Vec<(u32, Vec<Track>)>,
    /// By frame, then in the order of the kinds.
    pub events: Vec<Event>,
    /// By start.
    pub episodes: Vec<Episode>,
    /// The events by kind.
    pub counters: Counters,
}

enum Model {
    Mixture(Mixture),
    Opencv(OpencvModel),
}

/// The stages with their state, ready for the next frame.
pub struct Pipeline {
    size: Size,
    t: u32,
    model: Model,
    cleaning: Cleaning,
    min_area: u32,
    tracker: Tracker,
}

impl Pipeline {
    /// Stages that have seen nothing, for frames of `size` at `fps` frames a second.
    pub fn new(settings: &Settings, size: Size, fps: f32) -> Result<Self, PipelineError> {
        let opencv =
            OpencvModel::new(settings, size).map_err(|source| PipelineError::Opencv { frame: 0, source })?;
        let model = opencv
            .map_or_else(|| Model::Mixture(Mixture::new(size, Parameters::new(settings))), Model::Opencv);
        Ok(Self {
            size,
            t: 0,
            model,
            cleaning: Cleaning::new(settings),
            min_area: settings.min_area,
            tracker: Tracker::new(settings, size, fps),
        })
    }

    /// Takes the next frame through all stages.
    pub fn step(&mut self, frame: &Frame) -> Result<Analysis, PipelineError> {
        if frame.size != self.size {
            let (found, expected) = (frame.size, self.size);
            return Err(PipelineError::Size { frame: frame.number, found, expected });
        }
        let opencv = |source| PipelineError::Opencv { frame: frame.number, source };
        self.t += 1;
        let raw = match &mut self.model {
            Model::Mixture(mixture) => mixture.step(frame),
            Model::Opencv(model) => model.step(frame).map_err(opencv)?,
        };
        let mask = self.cleaning.apply(raw).map_err(opencv)?;
        let (labels, regions) = find_regions(frame, &mask, self.min_area).map_err(opencv)?;
        let seen = self.tracker.step(frame.number, &regions);
        Ok(Analysis {
            number: frame.number,
            t: self.t,
            mask: Arc::new(mask),
            labels: Arc::new(labels),
            regions: Arc::new(regions),
            tracks: Arc::new(seen.tracks),
            tentative: Arc::new(seen.tentative),
            objects: Arc::new(seen.objects),
            events: Arc::new(seen.events),
            counters: self.tracker.counters(),
        })
    }

    /// The model's background: the mean of component 1, or what MOG2 or KNN give; RGB bytes in row order.
    pub fn background_image(&self) -> Result<Vec<u8>, PipelineError> {
        match &self.model {
            Model::Mixture(mixture) => Ok(mixture.mean_image()),
            Model::Opencv(model) => {
                model.background_image().map_err(|source| PipelineError::Opencv { frame: 0, source })
            }
        }
    }

    /// The mixtures, `None` when MOG2 or KNN stand in their place.
    pub const fn mixture(&self) -> Option<&Mixture> {
        match &self.model {
            Model::Mixture(mixture) => Some(mixture),
            Model::Opencv(_) => None,
        }
    }

    /// A copy that goes on from here; `None` for MOG2 and KNN, whose state cannot be copied.
    pub fn try_clone(&self) -> Option<Self> {
        let mixture = self.mixture()?.clone();
        Some(Self { model: Model::Mixture(mixture), tracker: self.tracker.clone(), ..*self })
    }

    /// The memory that a copy takes, in bytes, to the nearest few kilobytes.
    pub fn state_bytes(&self) -> usize {
        self.mixture().map_or(0, Mixture::state_bytes) + self.tracker.state_bytes()
    }

    /// Who is who, as decided up to here.
    pub fn naming(&self) -> Naming {
        self.tracker.naming()
    }

    /// The occlusion episodes up to here, by start; those still going on end at the last frame.
    pub fn episodes(&self) -> Vec<Episode> {
        self.tracker.episodes()
    }
}

/// The final reading of all `analyses`, in order, after `pipeline` has seen the last of them:
/// objects named from their first frame on, short tracks gone.
pub fn final_reading<'a>(analyses: impl IntoIterator<Item = &'a Analysis>, pipeline: &Pipeline) -> Reading {
    let naming = pipeline.naming();
    let mut reading = Reading { episodes: pipeline.episodes(), ..Reading::default() };
    for analysis in analyses {
        reading.tracks.push((analysis.number, naming.apply(analysis.objects.iter())));
        reading.events.extend(analysis.events.iter().cloned());
    }
    reading.events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
    for event in &reading.events {
        reading.counters.count(event.kind);
    }
    reading
}
