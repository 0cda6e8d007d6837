//! The frame in view: its position, its map, and the steps of seeking it.

use std::ops::Range;
use std::sync::Arc;

use super::analyse::analysis_pass::{AnalysisPass, PassError};
use super::analyse::model_timeline::{ModelTimeline, SeekStep};
use crate::mixture::Quantity;
use crate::occlusion::EventKind;
use crate::replay::published::{ShownFrame, Start};
use crate::source::cache::{Fetched, FrameCache, Keep};
use crate::tracking::{Identity, TrackState};

/// Number of frames after the decision of the first occlusion before a frame within it is chosen.
const FRAMES_INTO_OCCLUSION: u32 = 10;

/// The frame in view, and the one to show next.
pub(crate) struct FrameInView {
    /// The position that the window wants to show.
    pub(crate) target: u32,
    /// Whether the newest frame is shown, for a live source.
    pub(crate) follow: bool,
    /// The quantity mapped in the frame in view.
    pub(crate) map: Option<Quantity>,
    /// The last published frame.
    pub(crate) shown: Option<Arc<ShownFrame>>,
    /// The frame to show first, until its position is known.
    start: Option<StartTarget>,
}

/// A frame to show first whose position is not known yet.
enum StartTarget {
    Number(u32),
    /// The first occlusion, once it is found.
    Occlusion(Option<FoundOcclusion>),
}

/// An occlusion in the analysed frames.
struct FoundOcclusion {
    /// The position at which it was decided.
    decided: u32,
    objects: Vec<Identity>,
}

impl FrameInView {
    /// No frame is shown; the first one is the target until the position of `start` is known.
    pub(crate) const fn new(start: Start, live: bool) -> Self {
        let start = match start {
            Start::First => None,
            Start::FirstOcclusion => Some(StartTarget::Occlusion(None)),
            Start::Frame(number) => Some(StartTarget::Number(number)),
        };
        Self { target: 0, follow: live, map: None, shown: None, start }
    }

    /// Requests the frame at a position, where `analysed` frames are analysed.
    pub(crate) fn request(&mut self, position: u32, analysed: u32, live: bool) {
        self.start = None;
        self.target = position;
        self.follow = live && position >= analysed.saturating_sub(1);
    }

    /// Cancels seeking: the frame in view stays, or the last analysed frame under new settings.
    pub(crate) fn cancel(&mut self, analysed: u32) {
        self.start = None;
        if let Some(shown) = &self.shown {
            self.target = shown.position.min(analysed.saturating_sub(1));
        }
    }

    /// Searches the first occlusion again, under other settings, if it is still to be shown.
    pub(crate) fn restart_search(&mut self) {
        if let Some(StartTarget::Occlusion(found)) = &mut self.start {
            *found = None;
        }
    }

    /// Whether a frame is the requested one under the settings of `pass`, with the requested map if there can be one.
    pub(crate) fn is_current(&self, shown: &ShownFrame, pass: &AnalysisPass, frames: &FrameCache) -> bool {
        self.is_current_except_map(shown, pass)
            && self.map.is_none_or(|quantity| match &shown.map {
                Some(map) => map.quantity == quantity,
                None => !self.can_map(quantity, pass, frames),
            })
    }

    fn is_current_except_map(&self, shown: &ShownFrame, pass: &AnalysisPass) -> bool {
        shown.position == self.target && Arc::ptr_eq(&shown.settings, pass.settings())
    }

    /// Whether the requested frame can have a map of `quantity`: for a camera, earlier frames must still be cached.
    fn can_map(&self, quantity: Quantity, pass: &AnalysisPass, frames: &FrameCache) -> bool {
        let cached = |mut positions: Range<u32>| positions.all(|position| frames.has(position));
        pass.model.has(quantity)
            && (!frames.info().live || pass.model.frames_needed(self.target, quantity).is_some_and(cached))
    }

    /// The frame in view without its map, if that is of another quantity than the requested one and none can be made.
    pub(crate) fn without_map(&self, pass: &AnalysisPass, frames: &FrameCache) -> Option<ShownFrame> {
        let shown = self.shown.as_ref().filter(|shown| self.is_current_except_map(shown, pass))?;
        let quantity = self.map;
        let other =
            shown.map.as_ref().is_some_and(|map| quantity.is_some_and(|quantity| map.quantity != quantity));
        (other && !quantity.is_some_and(|quantity| self.can_map(quantity, pass, frames)))
            .then(|| ShownFrame { map: None, ..ShownFrame::clone(shown) })
    }

    /// Keeps the target within the sequence, and at its newest frame where that is followed.
    pub(crate) fn update_target(&mut self, analysed: u32, ahead: bool, frames: &FrameCache) {
        if self.follow && ahead {
            self.target = analysed.saturating_sub(1);
        }
        if frames.is_complete() {
            self.target = self.target.min((frames.numbers().len() as u32).saturating_sub(1));
        }
    }

    /// Records the first occlusion in newly analysed frames, if it is the frame to show first.
    pub(crate) fn find_occlusion(&mut self, model: &ModelTimeline, positions: Range<u32>) {
        let Some(StartTarget::Occlusion(found @ None)) = &mut self.start else { return };
        for position in positions {
            let Some(analysis) = model.outline(position) else { break };
            let occlusion = analysis
                .events
                .iter()
                .find(|event| matches!(event.kind, EventKind::Merge | EventKind::Disappear));
            *found =
                occlusion.map(|event| FoundOcclusion { decided: position, objects: event.objects.clone() });
            if found.is_some() {
                break;
            }
        }
    }

    /// Requests the frame to show first, once its position is known and the first frame was shown.
    pub(crate) fn resolve_start(&mut self, pass: &AnalysisPass, frames: &FrameCache) {
        let Some(start) = self.start.as_ref().filter(|_| self.shown.is_some()) else { return };
        let numbers = frames.numbers();
        let found = match start {
            StartTarget::Number(number) => {
                let position = numbers.partition_point(|known| known < number);
                (position < numbers.len() || frames.is_complete()).then_some(position as u32)
            }
            StartTarget::Occlusion(Some(FoundOcclusion { decided, objects })) => {
                let is_long_enough = pass.model.analysed() > decided.saturating_add(FRAMES_INTO_OCCLUSION);
                (is_long_enough || pass.has_analysed_all(frames))
                    .then(|| within_occlusion(&pass.model, *decided, objects))
            }
            StartTarget::Occlusion(None) => pass.has_analysed_all(frames).then_some(self.target),
        };
        if let Some(position) = found {
            self.target = position;
            self.start = None;
        }
    }
}

/// The middle of the interval in which one of `objects` is merged or occluded, around the position at which the
/// occlusion was decided.
fn within_occlusion(model: &ModelTimeline, decided: u32, objects: &[Identity]) -> u32 {
    let occluded = |position: &u32| {
        model.outline(*position).is_some_and(|analysis| {
            let mut tracks = analysis.tracks.iter();
            tracks.any(|track| objects.contains(&track.id) && track.state != TrackState::Visible)
        })
    };
    let Some(first) = (decided..model.analysed()).find(occluded) else { return decided };
    let length = (first..model.analysed()).take_while(occluded).count() as u32;
    first + length / 2
}

/// The result of a step of seeking a frame.
pub(crate) enum ShowStep {
    /// The frame with its results.
    Frame(ShownFrame),
    /// Another step is needed.
    Continues,
    /// The model is being replayed towards the frame with this number, from this position on.
    Replays {
        /// The number of the requested frame.
        number: u32,
        /// The position of the model.
        from: u32,
    },
    /// The requested frame is being decoded.
    Decodes,
    /// A frame that is needed is no longer available.
    FrameLost,
}

/// One step of seeking the analysed frame at a position of `pass`, with a map of `quantity`.
pub(crate) fn seek_frame(
    pass: &mut AnalysisPass,
    frames: &mut FrameCache,
    position: u32,
    quantity: Option<Quantity>,
) -> Result<ShowStep, PassError> {
    let frame = match frames.fetch(position, Keep::Yes)? {
        Fetched::Frame(frame) => frame,
        Fetched::OnTheWay => return Ok(ShowStep::Decodes),
        Fetched::Gone | Fetched::End => return Ok(ShowStep::FrameLost),
    };
    frames.view(position);
    let needed = match pass.model.seek(position, &frame, quantity)? {
        SeekStep::Pictures(pictures) => {
            return Ok(pass.shown(position, frame, pictures).map_or(ShowStep::Continues, ShowStep::Frame));
        }
        SeekStep::Continues => return Ok(ShowStep::Continues),
        SeekStep::NeedsFrames(needed) => needed,
    };
    match frames.fetch(needed.start, Keep::Yes)? {
        Fetched::Frame(first) => {
            let mut passed = vec![first];
            passed.extend((needed.start + 1..needed.end).map_while(|position| frames.kept(position)));
            pass.model.replay_frames(needed.start, &passed, position);
        }
        Fetched::OnTheWay => {}
        Fetched::Gone | Fetched::End => return Ok(ShowStep::FrameLost),
    }
    Ok(ShowStep::Replays { number: frame.number, from: needed.start })
}
