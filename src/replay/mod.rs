//! Random access in time: a worker that analyses ahead, keeps records and checkpoints, and reproduces the results of
//! any frame.
//!
//! The window holds a [`Session`] and sends requests; the worker publishes a [`State`] after every change. Neither
//! blocks the other.

mod memory;
mod session;
mod store;
mod tasks;
mod worker;

#[cfg(test)]
mod measure;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::explain::events::counterfactual::Counterfactual;
use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::{self, SettingAxis, VerdictFlip};
use crate::frame::Frame;
use crate::mixture::{Parameters, QuantityMap};
use crate::occlusion::Event;
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
pub use session::Session;
pub use tasks::gather::region_shares::{RegionShares, region_bounds};

/// The frame in view after opening. The first frame is shown until that one is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The first frame.
    First,
    /// A frame within the first occlusion: a merge, or an object that disappears. The first frame where there is
    /// none.
    FirstOcclusion,
    /// The frame of this number, or the next existing one after it.
    Frame(u32),
}

/// The phase of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// The source is being opened.
    Opening,
    /// Frames are available or are being decoded.
    Ready,
    /// An error, with its cause and a remedy as a sentence.
    Failed(String),
}

/// The last published state. It is cheap to clone.
#[derive(Clone, Debug)]
pub struct State {
    /// The phase of the session.
    pub phase: Phase,
    /// The source, once it is open.
    pub info: Option<Arc<SourceInfo>>,
    /// Warnings of problems that did not end the work, one sentence each, in order.
    pub warnings: Arc<Vec<String>>,
    /// The frame in view, with all results of one frame under one choice of settings.
    pub shown: Option<Arc<ShownFrame>>,
    /// The history of the chosen pixel over all known frames, under the newest settings; `None` when no pixel is
    /// chosen or the model has no mixture. After a change of settings it is published before the frame in view.
    pub pixel: Option<Arc<PixelHistory>>,
    /// The histories of the pinned pixels over all known frames, in the order of [`Session::pin`], under the newest
    /// settings, without those that are unavailable.
    pub pins: Arc<Vec<Arc<PixelHistory>>>,
    /// The chosen and pinned pixels whose histories are unavailable, because a live source no longer has the first
    /// frames.
    pub lost: Vec<(u32, u32)>,
    /// The share of foreground in the region of [`Session::region`], for the frames counted so far.
    pub region: Option<Arc<RegionShares>>,
    /// The chosen pixel under other settings, after [`Session::tune`]. While a new result is computed, it may belong
    /// to another frame, pixel or choice of settings than the one in view.
    pub tuning: Option<Arc<Tuning>>,
    /// Accuracy of the mixture in a region under other settings, after [`Session::tune_region`], if there are true
    /// masks. It may belong to an earlier request, as [`Self::tuning`].
    pub region_tuning: Option<Arc<RegionTuning>>,
    /// Counterfactuals of an event, after [`Session::explain`], as far as known.
    pub counterfactual: Option<Arc<Counterfactual>>,
    /// The current timeline of the sequence under the settings of the frame in view, including that frame. It is
    /// updated at most ten times a second.
    pub timeline: Arc<Timeline>,
    /// The sequence under the candidate settings of [`Session::compare`]; `None` if nothing is compared, or the
    /// settings are equal.
    pub compared: Option<Arc<ComparedSequence>>,
    /// The current work of the worker, `None` when it is idle.
    pub busy: Option<Progress>,
    /// Frames analysed per second, averaged over about the last second of work; 0 when unknown.
    pub analysis_fps: f32,
}

/// The sequence under the candidate settings.
#[derive(Clone, Debug)]
pub struct ComparedSequence {
    /// The settings.
    pub settings: Arc<Settings>,
    /// The current timeline.
    pub timeline: Timeline,
}

/// The state of one pixel in one frame under other settings of the mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The frame's position in the sequence, from 0.
    pub position: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// The verdict over a grid of two settings.
    pub map: tuning::VerdictMap,
    /// For each setting the nearest value that flips the verdict.
    pub flips: Vec<VerdictFlip>,
}

/// Accuracy of the mixture in a region, against true masks and before cleaning, under other settings.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionTuning {
    /// The centre pixel: column and row.
    pub at: (u32, u32),
    /// Side of the region in pixels; it is clipped at the image's edge.
    pub side: u32,
    /// The present parameters.
    pub parameters: Parameters,
    /// Number of columns and rows of pixels that are scored.
    pub extent: [u32; 2],
    /// Number of scored frames.
    pub frames: usize,
    /// The counts of decisions under [`Self::parameters`].
    pub present: Decisions,
    /// The settings along a row and along a column.
    pub axes: [SettingAxis; 2],
    /// The counts of decisions in each cell, row by row.
    pub cells: Vec<Decisions>,
}

/// Work in progress.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// A description: `analysing`, `going back to frame 203`.
    pub what: String,
    /// Number of frames or runs that are done.
    pub done: u32,
    /// Total number of frames or runs, where known.
    pub total: Option<u32>,
}

/// One frame with all its results.
#[derive(Clone, Debug)]
pub struct ShownFrame {
    /// The frame's position in the sequence, from 0.
    pub position: u32,
    /// The settings of the results.
    pub settings: Arc<Settings>,
    /// The region of interest; `None` for the whole image.
    pub roi: Option<Arc<Roi>>,
    /// The input.
    pub frame: Arc<Frame>,
    /// The results of the stages.
    pub analysis: Arc<Analysis>,
    /// The mean of component 1 at each pixel, after this frame's update. The state of MOG2 and KNN cannot be
    /// restored: their background images are stored for every frame while there is memory, then for every second one,
    /// and so on. A frame without its own has that of the nearest earlier one.
    pub background: Arc<Frame>,
    /// The weighted mean of the B background components; `None` where the model has no mixture.
    pub multi_mode: Option<Arc<Frame>>,
    /// A quantity at each pixel after this frame's update, if [`Session::map`] requested one that the model has.
    pub map: Option<Arc<QuantityMap>>,
    /// The history of the chosen pixel over all known frames, under `settings`; `None` when no pixel is chosen or the
    /// model has no mixture. Index [`ShownFrame::position`] is its state of this frame.
    pub pixel: Option<Arc<PixelHistory>>,
    /// The true label of each pixel, if the ground truth of [`Session::set_truth`] has a mask of this frame.
    pub truth: Option<Arc<TrueMask>>,
    /// The same frame under the candidate settings; `None` if nothing is compared, or the frame has not been analysed
    /// under them.
    pub compared: Option<Arc<ShownFrame>>,
}

/// The results of the whole sequence so far, for the timeline and the event list.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The frame numbers of the positions known so far.
    pub numbers: Vec<u32>,
    /// Whether the end of the sequence is known, so that `numbers` is complete.
    pub complete: bool,
    /// Positions 0..analysed have been analysed under the present settings.
    pub analysed: u32,
    /// The positions whose decoded frames are cached, as inclusive ranges in ascending order.
    pub decoded: Vec<(u32, u32)>,
    /// Share of foreground of each analysed position, 0..=1.
    pub foreground_share: Vec<f32>,
    /// The alignment of each known position's frame, whether it is corrected or not.
    pub alignments: Vec<Alignment>,
    /// All events so far, by frame and kind, with their positions.
    pub events: Vec<(u32, Event)>,
    /// The track of each identity over time, by identity.
    pub track_timelines: Vec<TrackTimeline>,
    /// The score against the ground truth of [`Session::set_truth`], once all frames are analysed.
    pub score: Option<Arc<Score>>,
}

/// The states of a track over time.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackTimeline {
    /// Its identity.
    pub id: Identity,
    /// Positions `first..=last` of constant state, in order.
    pub spans: Vec<(u32, u32, TrackState)>,
}

/// Whether both point to the same allocation, or both are `None`.
fn same<T>(one: Option<&Arc<T>>, other: Option<&Arc<T>>) -> bool {
    one.map(Arc::as_ptr) == other.map(Arc::as_ptr)
}
