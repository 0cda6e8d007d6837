//! The way to the frame that is wanted in view, and which frame that is at the start.

use std::ops::Range;
use std::sync::Arc;

use super::{Aim, Stopped, Which, Worker};
use crate::frame::Frame;
use crate::mixture::Quantity;
use crate::occlusion::EventKind;
use crate::replay::run::Towards;
use crate::replay::{Progress, Shown};
use crate::source::SourceError;
use crate::source::cache::{Fetched, Keep};
use crate::tracking::{Identity, TrackState};

/// After the first occlusion was decided, so many more frames show how it goes on.
const INTO_OCCLUSION: u32 = 10;

impl Worker<'_> {
    pub(super) fn is_view_current(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| self.is_current(shown) && self.rival.is_beside(shown))
    }

    pub(super) fn is_current(&self, shown: &Shown) -> bool {
        self.is_current_but_for_its_map(shown)
            && self.map.is_none_or(|quantity| match &shown.map {
                Some(map) => map.quantity == quantity,
                None => !self.can_map(quantity),
            })
    }

    pub(super) fn is_current_but_for_its_map(&self, shown: &Shown) -> bool {
        shown.position == self.wanted && Arc::ptr_eq(&shown.settings, self.lane.settings())
    }

    /// Whether the wanted frame can have a map of `quantity`: for a camera's, what came before it must still be kept.
    pub(super) fn can_map(&self, quantity: Quantity) -> bool {
        let run = &self.lane.run;
        let kept = |mut positions: Range<u32>| positions.all(|position| self.frames.has(position));
        run.has(quantity) && (!self.info.live || run.way_to(self.wanted, quantity).is_some_and(kept))
    }

    /// The frame in view without its map, where that is of another quantity than is asked for and none can be made.
    pub(super) fn without_map(&self) -> Option<Shown> {
        let shown = self.shown.as_ref().filter(|shown| self.is_current_but_for_its_map(shown))?;
        let other =
            shown.map.as_ref().is_some_and(|map| self.map.is_some_and(|quantity| map.quantity != quantity));
        (other && !self.map.is_some_and(|quantity| self.can_map(quantity)))
            .then(|| Shown { map: None, ..Shown::clone(shown) })
    }

    /// One step towards showing the wanted frame. Where both have been analysed, both come into view together.
    pub(super) fn approach_view(&mut self) -> Result<(), Stopped> {
        if self.rival.lags_behind(self.wanted) {
            if let Some(shown) = self.look(Which::Rival)? {
                self.rival.shown = Some(Arc::new(shown));
            }
        } else if let Some(shown) = self.shown.clone().filter(|shown| self.is_current(shown)) {
            self.show(Shown::clone(&shown));
        } else if let Some(shown) = self.without_map() {
            self.show(shown);
        } else if self.wanted >= self.lane.run.front() {
            self.analyse(Which::InView)?;
        } else if let Some(shown) = self.look(Which::InView)? {
            self.show(shown);
        }
        Ok(())
    }

    /// One step towards the wanted frame under some settings; the frame when it is there.
    pub(super) fn look(&mut self, which: Which) -> Result<Option<Shown>, Stopped> {
        let position = self.wanted;
        let Some(frame) = self.fetch(position)? else { return Ok(None) };
        let quantity = self.map.filter(|_| which == Which::InView);
        let Some(lane) = self.lane(which) else { return Ok(None) };
        match lane.run.towards(position, &frame, quantity)? {
            Towards::Pictures(pictures) => return Ok(lane.shown(position, frame, pictures)),
            Towards::GoesOn => {}
            Towards::Needs(needed) => {
                if let Some(passed) = self.fetch(needed.start)? {
                    let mut passed = vec![passed];
                    for position in needed.start + 1..needed.end {
                        let Some(frame) = self.frames.kept(position) else { break };
                        passed.push(frame);
                    }
                    if let Some(lane) = self.lane(which) {
                        lane.run.replay_frames(needed.start, &passed, position);
                    }
                }
                let what = format!("computing frame {}", frame.number);
                self.busy = Some(Progress { what, done: needed.start, total: Some(position + 1) });
            }
        }
        Ok(None)
    }

    /// A frame that has been analysed, or `None` while it is on its way.
    pub(super) fn fetch(&mut self, position: u32) -> Result<Option<Arc<Frame>>, SourceError> {
        match self.frames.fetch(position, Keep::Yes)? {
            Fetched::Frame(frame) => return Ok(Some(frame)),
            Fetched::OnTheWay => {
                let what = format!("decoding up to frame {}", self.number_of(position));
                self.busy = Some(Progress { what, done: 0, total: None });
            }
            Fetched::Gone | Fetched::End => {
                // Only a live source forgets: the oldest thing that surely is there is the newest.
                self.wanted = self.lane.run.modelled().saturating_sub(1);
                if !std::mem::replace(&mut self.outbox.told_of.gone, true) {
                    self.outbox.warnings.push(format!(
                        "earlier frames of {} are no longer kept: the newest one is shown",
                        self.info.name
                    ));
                }
            }
        }
        Ok(None)
    }

    /// Notes the first occlusion among frames that were just analysed, if that is aimed at.
    pub(super) fn find_occlusion(&mut self, positions: Range<u32>) {
        let Some(Aim::Occlusion(found @ None)) = &mut self.aim else { return };
        for position in positions {
            let Some((analysis, _)) = self.lane.run.outline(position) else { break };
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

    /// Wants what the start aims at, once it is known and the first frame has been seen.
    pub(super) fn find_aim(&mut self) {
        let Some(aim) = &self.aim else { return };
        if self.shown.is_none() {
            return;
        }
        let numbers = self.frames.numbers();
        let found = match aim {
            Aim::Number(number) => {
                let position = numbers.partition_point(|known| known < number);
                (position < numbers.len() || self.frames.is_complete()).then_some(position as u32)
            }
            Aim::Occlusion(Some((decided, objects))) => {
                let front = self.lane.run.front();
                (front > decided.saturating_add(INTO_OCCLUSION) || self.lane.is_through(&self.frames))
                    .then(|| self.within_occlusion(*decided, objects))
            }
            Aim::Occlusion(None) => self.lane.is_through(&self.frames).then_some(self.wanted),
        };
        if let Some(position) = found {
            self.wanted = position;
            self.aim = None;
        }
    }

    /// The middle of the stretch in which one of `objects` is merged or hidden, around the position
    /// at which that was decided.
    pub(super) fn within_occlusion(&self, decided: u32, objects: &[Identity]) -> u32 {
        let occluded = |position: &u32| {
            self.lane.run.outline(*position).is_some_and(|(analysis, _)| {
                let mut tracks = analysis.tracks.iter();
                tracks.any(|track| objects.contains(&track.id) && track.state != TrackState::Visible)
            })
        };
        let Some(first) = (decided..self.lane.run.front()).find(occluded) else { return decided };
        let length = (first..self.lane.run.front()).take_while(occluded).count() as u32;
        first + length / 2
    }
}
