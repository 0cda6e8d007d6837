//! Random access in time: a worker that analyses ahead, keeps records and checkpoints, and shows any frame as it was.
//!
//! The window holds a [`Session`] and sends requests; the worker publishes a [`State`] after every change. Neither
//! waits for the other.

mod analysis_pass;
mod analysis_record;
mod compared_pass;
mod counterfactual;
mod frame_consumer;
mod last_foreground;
mod local_checkpoints;
mod memory;
mod model_timeline;
mod pictures;
mod pin_follower;
mod pixel_follower;
mod region_shares;
mod region_tuner;
mod rle;
mod scorer;
mod session;
mod strided_checkpoints;
mod timeline_builder;
mod tuner;
mod worker;

#[cfg(test)]
mod measure;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::frame::Frame;
use crate::mixture::tuning::{self, SettingAxis, VerdictFlip};
use crate::mixture::{Parameters, PixelHistory, QuantityMap};
use crate::occlusion::Event;
use crate::occlusion::counterfactual::Counterfactual;
use crate::pipeline::Analysis;
use crate::regions::Roi;
use crate::registration::Alignment;
use crate::settings::Settings;
use crate::source::SourceInfo;
use crate::tracking::{Identity, TrackState};
use crate::truth::decisions::Decisions;
use crate::truth::masks::TrueMask;
use crate::truth::summary::Score;

pub use memory::memory;
pub use region_shares::{RegionShares, region_bounds};
pub use session::Session;

/// Which frame comes into view after opening. The first frame is shown until it is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The first.
    First,
    /// One within the first occlusion: a merge, or an object that disappears. The first frame where
    /// there is none.
    FirstOcclusion,
    /// The one of this number, or the next one after it that there is.
    Frame(u32),
}

/// The phase of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// The source is being opened.
    Opening,
    /// Frames are there, or on their way.
    Ready,
    /// It cannot go on; a sentence that says why and what to do.
    Failed(String),
}

/// The state that the worker published last. Cheap to clone and to read.
#[derive(Clone, Debug)]
pub struct State {
    /// How far the session has come.
    pub phase: Phase,
    /// The source, once it is open.
    pub info: Option<Arc<SourceInfo>>,
    /// What went wrong without ending the work, a sentence each, in order.
    pub warnings: Arc<Vec<String>>,
    /// The frame in view: everything of one moment and one choice of settings.
    pub shown: Option<Arc<ShownFrame>>,
    /// The chosen pixel through all frames that are known, under the settings chosen last; `None` when
    /// no pixel is chosen or the model has no mixture. After a change of settings it is there at
    /// once, before the frame in view.
    pub pixel: Option<Arc<PixelHistory>>,
    /// The pinned pixels through all frames that are known, in the order in which [`Session::pin`] named them, under the
    /// settings chosen last. Those that cannot be known are left out.
    pub pins: Arc<Vec<Arc<PixelHistory>>>,
    /// Of the chosen pixel and the pinned ones those whose histories cannot be known, as they begin with first frames
    /// that a live source no longer has.
    pub lost: Vec<(u32, u32)>,
    /// The share of foreground in the region that [`Session::region`] named, as far as it is counted.
    pub region: Option<Arc<RegionShares>>,
    /// What the chosen pixel would be under other settings, if [`Session::tune`] asked for it. It may
    /// be of another frame, pixel or choice of settings than the one in view: then the new one is on its way.
    pub tuning: Option<Arc<Tuning>>,
    /// Accuracy of the mixture in a region under other settings, if [`Session::tune_region`] asked for it and there
    /// are true masks. It may belong to an earlier request, as [`Self::tuning`] may.
    pub region_tuning: Option<Arc<RegionTuning>>,
    /// Counterfactuals of an event, if [`Session::explain`] asked for them, as far as known.
    pub counterfactual: Option<Arc<Counterfactual>>,
    /// The timeline of the sequence so far under the settings of the frame in view, which it contains. It is updated
    /// at most ten times a second.
    pub timeline: Arc<Timeline>,
    /// The sequence under the settings that [`Session::compare`] named; `None` where nothing is compared, or the same
    /// settings.
    pub compared: Option<Arc<ComparedSequence>>,
    /// The current work of the worker, `None` when it is idle.
    pub busy: Option<Progress>,
    /// Frames a second of analysis, averaged over about the last second of work; 0 when unknown.
    pub analysis_fps: f32,
}

/// The sequence under the compared settings.
#[derive(Clone, Debug)]
pub struct ComparedSequence {
    /// The settings.
    pub settings: Arc<Settings>,
    /// The timeline so far.
    pub timeline: Timeline,
}

/// The state of one pixel in one frame under other settings of the mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The frame's place in the sequence, from 0.
    pub position: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// Foreground or background over a grid of two settings.
    pub map: tuning::VerdictMap,
    /// For each setting the nearest value that flips the verdict.
    pub flips: Vec<VerdictFlip>,
}

/// Accuracy of the mixture in a region, against true masks and before cleaning, under other settings.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionTuning {
    /// The pixel in the middle: column and row.
    pub at: (u32, u32),
    /// Pixels along each side; at the image's edge there are fewer.
    pub side: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// How many columns and rows of pixels were judged.
    pub extent: [u32; 2],
    /// In how many frames.
    pub frames: usize,
    /// What is decided under [`Self::parameters`].
    pub present: Decisions,
    /// What changes along a row, and from row to row.
    pub axes: [SettingAxis; 2],
    /// What is decided in each cell, row by row.
    pub cells: Vec<Decisions>,
}

/// Work in progress.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What: `analysing`, `going back to frame 203`.
    pub what: String,
    /// Frames done, or trials of other settings.
    pub done: u32,
    /// Frames or trials to do, where that is known.
    pub total: Option<u32>,
}

/// One frame with all results for it.
#[derive(Clone, Debug)]
pub struct ShownFrame {
    /// The frame's place in the sequence, from 0.
    pub position: u32,
    /// The settings of all these results.
    pub settings: Arc<Settings>,
    /// The area of interest; `None` for the whole image.
    pub roi: Option<Arc<Roi>>,
    /// The input.
    pub frame: Arc<Frame>,
    /// The results of the stages.
    pub analysis: Arc<Analysis>,
    /// The mean of component 1 at each pixel, after this frame's update. What MOG2 and KNN give
    /// instead cannot be had again later: of them each frame's is kept while there is memory, then
    /// every second one's and so on, and a frame without its own shows the nearest earlier one.
    pub background: Arc<Frame>,
    /// The weighted mean of the B background components; `None` where the model has no mixture.
    pub multi_mode: Option<Arc<Frame>>,
    /// A number of each pixel after this frame's update, if [`Session::map`] asks for one that the model has.
    pub map: Option<Arc<QuantityMap>>,
    /// The chosen pixel through all frames up to the last that is known, under `settings`;
    /// `None` when no pixel is chosen or the model has no mixture. Its state of this frame is the
    /// one at index [`ShownFrame::position`].
    pub pixel: Option<Arc<PixelHistory>>,
    /// What each pixel truly is, where [`Session::set_truth`] named a mask of this frame.
    pub truth: Option<Arc<TrueMask>>,
    /// The same frame under the settings that are compared with `settings`; `None` while nothing is compared, or it
    /// has not been analysed under them.
    pub compared: Option<Arc<ShownFrame>>,
}

/// The results of the whole sequence so far: for the timeline and the event list.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The frame numbers of the positions known so far.
    pub numbers: Vec<u32>,
    /// Whether the sequence's end has been found, so that `numbers` is all there is.
    pub complete: bool,
    /// Positions 0..analysed have been analysed under the present settings.
    pub analysed: u32,
    /// The positions whose frames are kept decoded, as ranges with both ends in them, in order: to go there takes no
    /// decoding.
    pub decoded: Vec<(u32, u32)>,
    /// Share of foreground of each analysed position, 0..=1.
    pub foreground_share: Vec<f32>,
    /// How each known position's frame lies against those before it, whether that is taken out or not.
    pub alignments: Vec<Alignment>,
    /// All events so far, by frame and kind, with the position at which each happened.
    pub events: Vec<(u32, Event)>,
    /// The track of each identity over time, by identity.
    pub track_timelines: Vec<TrackTimeline>,
    /// Its score against the ground truth that [`Session::set_truth`] named, once all has been analysed.
    pub score: Option<Arc<Score>>,
}

/// The states of a track over time.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackTimeline {
    /// Its identity.
    pub id: Identity,
    /// Positions `first..=last` in which its state was the same, in order.
    pub spans: Vec<(u32, u32, TrackState)>,
}

/// Whether both are the same thing in memory, or both are none.
fn same<T>(one: Option<&Arc<T>>, other: Option<&Arc<T>>) -> bool {
    one.map(Arc::as_ptr) == other.map(Arc::as_ptr)
}
