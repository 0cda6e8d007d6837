//! Seeks the frame to show, and chooses the first one.

use std::ops::Range;
use std::sync::Arc;

use super::{PassSlot, StartTarget, StopReason, Worker};
use crate::frame::Frame;
use crate::mixture::Quantity;
use crate::occlusion::EventKind;
use crate::replay::tasks::analyse::model_timeline::SeekStep;
use crate::replay::{Progress, ShownFrame};
use crate::source::SourceError;
use crate::source::cache::{Fetched, Keep};
use crate::tracking::{Identity, TrackState};

/// Number of frames after the decision of the first occlusion before a frame within it is chosen.
const FRAMES_INTO_OCCLUSION: u32 = 10;

impl Worker<'_> {
    pub(super) fn is_view_current(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| self.is_current(shown) && self.compared.is_current_in(shown))
    }

    pub(super) fn is_current(&self, shown: &ShownFrame) -> bool {
        self.is_current_but_for_its_map(shown)
            && self.map.is_none_or(|quantity| match &shown.map {
                Some(map) => map.quantity == quantity,
                None => !self.can_map(quantity),
            })
    }

    pub(super) fn is_current_but_for_its_map(&self, shown: &ShownFrame) -> bool {
        shown.position == self.target_position && Arc::ptr_eq(&shown.settings, self.pass.settings())
    }

    /// Whether the requested frame can have a map of `quantity`: for a camera, earlier frames must still be cached.
    pub(super) fn can_map(&self, quantity: Quantity) -> bool {
        let run = &self.pass.model;
        let kept = |mut positions: Range<u32>| positions.all(|position| self.frames.has(position));
        run.has(quantity)
            && (!self.info.live || run.frames_needed(self.target_position, quantity).is_some_and(kept))
    }

    /// The frame in view without its map, if that is of another quantity than the requested one and none can be made.
    pub(super) fn without_map(&self) -> Option<ShownFrame> {
        let shown = self.shown.as_ref().filter(|shown| self.is_current_but_for_its_map(shown))?;
        let other =
            shown.map.as_ref().is_some_and(|map| self.map.is_some_and(|quantity| map.quantity != quantity));
        (other && !self.map.is_some_and(|quantity| self.can_map(quantity)))
            .then(|| ShownFrame { map: None, ..ShownFrame::clone(shown) })
    }

    /// One step towards showing the requested frame. Where both passes have analysed it, both frames are published
    /// together.
    pub(super) fn advance_view(&mut self) -> Result<(), StopReason> {
        if self.compared.needs_frame(self.target_position) {
            if let Some(shown) = self.seek_frame(PassSlot::Compared)? {
                self.compared.shown = Some(Arc::new(shown));
            }
        } else if let Some(shown) = self.shown.clone().filter(|shown| self.is_current(shown)) {
            self.show(ShownFrame::clone(&shown));
        } else if let Some(shown) = self.without_map() {
            self.show(shown);
        } else if self.target_position >= self.pass.model.front() {
            self.analyse(PassSlot::InView)?;
        } else if let Some(shown) = self.seek_frame(PassSlot::InView)? {
            self.show(shown);
        }
        Ok(())
    }

    /// One step of seeking the requested frame in a pass; returns the frame when it is complete.
    pub(super) fn seek_frame(&mut self, which: PassSlot) -> Result<Option<ShownFrame>, StopReason> {
        let position = self.target_position;
        let Some(frame) = self.fetch(position)? else { return Ok(None) };
        let quantity = self.map.filter(|_| which == PassSlot::InView);
        let Some(pass) = self.pass(which) else { return Ok(None) };
        match pass.model.seek(position, &frame, quantity)? {
            SeekStep::Pictures(pictures) => return Ok(pass.shown(position, frame, pictures)),
            SeekStep::Continues => {}
            SeekStep::NeedsFrames(needed) => {
                if let Some(passed) = self.fetch(needed.start)? {
                    let mut passed = vec![passed];
                    for position in needed.start + 1..needed.end {
                        let Some(frame) = self.frames.kept(position) else { break };
                        passed.push(frame);
                    }
                    if let Some(pass) = self.pass(which) {
                        pass.model.replay_frames(needed.start, &passed, position);
                    }
                }
                let what = format!("computing frame {}", frame.number);
                self.busy = Some(Progress { what, done: needed.start, total: Some(position + 1) });
            }
        }
        Ok(None)
    }

    /// A decoded frame; `None` while it is being decoded.
    pub(super) fn fetch(&mut self, position: u32) -> Result<Option<Arc<Frame>>, SourceError> {
        match self.frames.fetch(position, Keep::Yes)? {
            Fetched::Frame(frame) => return Ok(Some(frame)),
            Fetched::OnTheWay => {
                let what = format!("decoding up to frame {}", self.number_of(position));
                self.busy = Some(Progress { what, done: 0, total: None });
            }
            Fetched::Gone | Fetched::End => {
                // Only a live source drops frames; the newest one is always available.
                self.target_position = self.pass.model.modelled().saturating_sub(1);
                if !std::mem::replace(&mut self.outbox.warned.gone, true) {
                    self.outbox.warnings.push(format!(
                        "earlier frames of {} are no longer kept: the newest one is shown",
                        self.info.name
                    ));
                }
            }
        }
        Ok(None)
    }

    /// Records the first occlusion in newly analysed frames, if it is the frame to show first.
    pub(super) fn find_occlusion(&mut self, positions: Range<u32>) {
        let Some(StartTarget::Occlusion(found @ None)) = &mut self.start_target else { return };
        for position in positions {
            let Some((analysis, _)) = self.pass.model.outline(position) else { break };
            let occlusion = analysis
                .events
                .iter()
                .find(|event| matches!(event.kind, EventKind::Merge | EventKind::Disappear));
            *found = occlusion.map(|event| (position, event.objects.clone()));
            if found.is_some() {
                break;
            }
        }
    }

    /// Requests the frame to show first, once its position is known and the first frame was shown.
    pub(super) fn resolve_start_target(&mut self) {
        let Some(start_target) = &self.start_target else { return };
        if self.shown.is_none() {
            return;
        }
        let numbers = self.frames.numbers();
        let found = match start_target {
            StartTarget::Number(number) => {
                let position = numbers.partition_point(|known| known < number);
                (position < numbers.len() || self.frames.is_complete()).then_some(position as u32)
            }
            StartTarget::Occlusion(Some((decided, objects))) => {
                let front = self.pass.model.front();
                (front > decided.saturating_add(FRAMES_INTO_OCCLUSION)
                    || self.pass.has_analysed_all(&self.frames))
                .then(|| self.within_occlusion(*decided, objects))
            }
            StartTarget::Occlusion(None) => {
                self.pass.has_analysed_all(&self.frames).then_some(self.target_position)
            }
        };
        if let Some(position) = found {
            self.target_position = position;
            self.start_target = None;
        }
    }

    /// The middle of the interval in which one of `objects` is merged or occluded, around the position at which the
    /// occlusion was decided.
    pub(super) fn within_occlusion(&self, decided: u32, objects: &[Identity]) -> u32 {
        let occluded = |position: &u32| {
            self.pass.model.outline(*position).is_some_and(|(analysis, _)| {
                let mut tracks = analysis.tracks.iter();
                tracks.any(|track| objects.contains(&track.id) && track.state != TrackState::Visible)
            })
        };
        let Some(first) = (decided..self.pass.model.front()).find(occluded) else { return decided };
        let length = (first..self.pass.model.front()).take_while(occluded).count() as u32;
        first + length / 2
    }
}
