//! Time travel: a worker that analyses ahead, remembers, and shows any frame as it was.
//!
//! The window holds a [`Session`] and asks; the worker publishes a [`State`] whenever something
//! changed. Neither waits for the other.

mod gather;
mod inspector;
mod lane;
mod memory;
mod near;
mod pictures;
mod pins;
mod record;
mod region;
mod region_tuner;
mod rival;
mod run;
mod runs;
mod scoring;
mod session;
mod since;
mod spaced;
mod timeline;
mod tuner;
mod what_if;
mod worker;

#[cfg(test)]
mod measure;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::frame::Frame;
use crate::mixture::tuning::{self, Axis, Flip};
use crate::mixture::{Map, Parameters, PixelHistory};
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
pub use region::{RegionShares, around};
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

/// How far a session has come.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// The source is being opened.
    Opening,
    /// Frames are there, or on their way.
    Ready,
    /// It cannot go on; a sentence that says why and what to do.
    Failed(String),
}

/// What the worker last published. Cheap to clone and to read.
#[derive(Clone, Debug)]
pub struct State {
    /// How far the session has come.
    pub phase: Phase,
    /// The source, once it is open.
    pub info: Option<Arc<SourceInfo>>,
    /// What went wrong without ending the work, a sentence each, in order.
    pub warnings: Arc<Vec<String>>,
    /// The frame in view: everything of one moment and one choice of settings.
    pub shown: Option<Arc<Shown>>,
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
    /// The share of foreground around the pixel that [`Session::region`] named, as far as it is counted.
    pub region: Option<Arc<RegionShares>>,
    /// What the chosen pixel would be under other settings, if [`Session::tune`] asked for it. It may
    /// be of another frame, pixel or choice of settings than the one in view: then the new one is on its way.
    pub tuning: Option<Arc<Tuning>>,
    /// How right the mixture would be around a pixel under other settings, if [`Session::tune_region`] asked for it and
    /// there are true masks. It may be the answer to an earlier question, as [`Self::tuning`] may.
    pub region_tuning: Option<Arc<RegionTuning>>,
    /// What would have kept an event from happening, if [`Session::explain`] asked for it, as far as that is known.
    pub what_if: Option<Arc<Counterfactual>>,
    /// What is known of the whole sequence so far under the settings of the frame in view, which it
    /// holds. It follows the work at most ten times a second.
    pub timeline: Arc<Timeline>,
    /// What is known of the sequence under the settings that [`Session::compare`] named; `None` where nothing is
    /// compared, or the same settings.
    pub beside: Option<Arc<Beside>>,
    /// What the worker is doing, `None` when it rests.
    pub busy: Option<Progress>,
    /// Frames a second of analysis, averaged over about the last second of work; 0 when unknown.
    pub analysis_fps: f32,
}

/// The sequence under settings that are compared with those in view.
#[derive(Clone, Debug)]
pub struct Beside {
    /// The settings.
    pub settings: Arc<Settings>,
    /// What is known so far.
    pub timeline: Timeline,
}

/// What one pixel would be in one frame under other settings of the mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The frame's place in the sequence, from 0.
    pub position: u32,
    /// The parameters around which was looked.
    pub parameters: Parameters,
    /// Foreground or background over a grid of two settings.
    pub map: tuning::Map,
    /// What flips the verdict, a setting each.
    pub flips: Vec<Flip>,
}

/// How right the mixture is about the pixels around one, by true masks and before any cleaning, under other settings.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionTuning {
    /// The pixel in the middle: column and row.
    pub at: (u32, u32),
    /// Pixels along each side; at the image's edge there are fewer.
    pub side: u32,
    /// The parameters around which was looked.
    pub parameters: Parameters,
    /// How many columns and rows of pixels were judged.
    pub extent: [u32; 2],
    /// In how many frames.
    pub frames: usize,
    /// What is decided under [`Self::parameters`].
    pub present: Decisions,
    /// What changes along a row, and from row to row.
    pub axes: [Axis; 2],
    /// What is decided in each cell, row by row.
    pub cells: Vec<Decisions>,
}

/// Work under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What: `analysing`, `going back to frame 203`.
    pub what: String,
    /// Frames done, or trials of other settings.
    pub done: u32,
    /// Frames or trials to do, where that is known.
    pub total: Option<u32>,
}

/// One frame with everything that was made of it.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The frame's place in the sequence, from 0.
    pub position: u32,
    /// The settings under which all of this came about.
    pub settings: Arc<Settings>,
    /// What was analysed, the whole image without one.
    pub roi: Option<Arc<Roi>>,
    /// The input.
    pub frame: Arc<Frame>,
    /// What the stages made of it.
    pub analysis: Arc<Analysis>,
    /// The mean of component 1 at each pixel, after this frame's update. What MOG2 and KNN give
    /// instead cannot be had again later: of them each frame's is kept while there is memory, then
    /// every second one's and so on, and a frame without its own shows the nearest earlier one.
    pub background: Arc<Frame>,
    /// The weighted mean of the B background components; `None` where the model has no mixture.
    pub multi_mode: Option<Arc<Frame>>,
    /// A number of each pixel after this frame's update, if [`Session::map`] asks for one that the model has.
    pub map: Option<Arc<Map>>,
    /// The chosen pixel through all frames up to the last that is known, under `settings`;
    /// `None` when no pixel is chosen or the model has no mixture. Its state of this frame is the
    /// one at index [`Shown::position`].
    pub pixel: Option<Arc<PixelHistory>>,
    /// What each pixel truly is, where [`Session::set_truth`] named a mask of this frame.
    pub truth: Option<Arc<TrueMask>>,
    /// The same frame under the settings that are compared with `settings`; `None` while nothing is compared, or it
    /// has not been analysed under them.
    pub beside: Option<Arc<Shown>>,
}

/// What is known of the whole sequence: for the timeline and the event list.
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
    /// Each identity's life, by identity.
    pub life_lines: Vec<LifeLine>,
    /// How right it is by the truth that [`Session::set_truth`] named, once all has been analysed.
    pub score: Option<Arc<Score>>,
}

/// When an object was seen, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct LifeLine {
    /// Who.
    pub id: Identity,
    /// Positions `first..=last` in which its state was the same, in order.
    pub spans: Vec<(u32, u32, TrackState)>,
}

/// Whether both are the same thing in memory, or both are none.
fn same<T>(one: Option<&Arc<T>>, other: Option<&Arc<T>>) -> bool {
    one.map(Arc::as_ptr) == other.map(Arc::as_ptr)
}
