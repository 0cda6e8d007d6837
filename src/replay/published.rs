//! Everything that the worker publishes and the window reads.

use std::sync::Arc;

use crate::explain::events::counterfactual::Counterfactual;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::RegionShares;
use crate::explain::tuning::{RegionTuning, Tuning};
use crate::frame::Frame;
use crate::mixture::QuantityMap;
use crate::occlusion::Event;
use crate::pipeline::Analysis;
use crate::regions::Roi;
use crate::registration::Alignment;
use crate::settings::Settings;
use crate::source::SourceInfo;
use crate::tracking::{Identity, TrackState};
use crate::truth::masks::TrueMask;
use crate::truth::summary::Score;

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
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Phase {
    /// The source is being opened.
    #[default]
    Opening,
    /// Frames are available or are being decoded.
    Ready,
    /// An error, with its cause and a remedy as a sentence.
    Failed(String),
}

/// The last published state. It is cheap to clone.
#[derive(Clone, Debug, Default)]
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
    /// The frames through which the chosen pixel has been followed, of those that its history needs to cover the frame
    /// in view; `None` when no pixel is chosen or all of them are known.
    pub pixel_progress: Option<WorkProgress>,
    /// The histories of the pinned pixels over all known frames, in the order of `Request::Pin`, under the newest
    /// settings, without those that are unavailable.
    pub pins: Arc<Vec<Arc<PixelHistory>>>,
    /// The chosen and pinned pixels whose histories are unavailable, because a live source no longer has the first
    /// frames.
    pub lost: Vec<(u32, u32)>,
    /// The share of foreground in the region of `Request::CountRegion`, for the frames counted so far.
    pub region: Option<Arc<RegionShares>>,
    /// The chosen pixel under other settings, after `Request::Tune`. While a new result is computed, it may belong
    /// to another frame, pixel or choice of settings than the one in view.
    pub tuning: Option<Arc<Tuning>>,
    /// Accuracy of the mixture in a region under other settings, after `Request::TuneRegion`, if there are true
    /// masks. It may belong to an earlier request, as [`Self::tuning`].
    pub region_tuning: Option<Arc<RegionTuning>>,
    /// Counterfactuals of an event, after `Request::Explain`, as far as known.
    pub counterfactual: Option<Arc<Counterfactual>>,
    /// The current timeline of the sequence under the settings of the frame in view, including that frame. It is
    /// updated at most ten times a second.
    pub timeline: Arc<Timeline>,
    /// The sequence under the candidate settings of `Request::Settings`; `None` if nothing is compared, or the
    /// settings are equal.
    pub compared: Option<Arc<ComparedSequence>>,
    /// The score of the external results of `Request::External` against the ground truth, once all frames are analysed.
    pub external_score: Option<Arc<Score>>,
    /// The current work of the worker, `None` when it is idle.
    pub busy: Option<WorkProgress>,
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

/// Work in progress.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkProgress {
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
    /// A quantity at each pixel after this frame's update, if `Request::Map` requested one that the model has.
    pub map: Option<Arc<QuantityMap>>,
    /// The history of the chosen pixel over all known frames, under `settings`; `None` when no pixel is chosen or the
    /// model has no mixture. Index [`ShownFrame::position`] is its state of this frame.
    pub pixel: Option<Arc<PixelHistory>>,
    /// The true label of each pixel, if the ground truth of `Request::Truth` has a mask of this frame.
    pub truth: Option<Arc<TrueMask>>,
    /// The mask of the external results of `Request::External`, if they have one of this frame.
    pub external: Option<Arc<TrueMask>>,
    /// The same frame under the candidate settings; `None` if nothing is compared, or the frame has not been analysed
    /// under them.
    pub compared: Option<Arc<ShownFrame>>,
}

/// The results of the whole sequence so far, for the timeline and the event list.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The frame numbers of the positions known so far.
    pub numbers: Vec<u32>,
    /// The times of these frames in seconds since the first.
    pub times: Vec<f64>,
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
    /// The score against the ground truth of `Request::Truth`, once all frames are analysed.
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
