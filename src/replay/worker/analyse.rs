//! Advances the passes through the sequence.

use std::time::Instant;

use super::{AheadMode, PassSlot, StopReason, Worker};
use crate::replay::published::WorkProgress;
use crate::replay::tasks::analyse::analysis_pass::{AnalysisPass, PassStep};
use crate::replay::tasks::analyse::pass_progress::NextStep;
use crate::replay::tasks::gather::frame_consumer::FrameConsumer as _;
use crate::source::cache::Keep;

impl Worker<'_> {
    /// Resumes the analysis beyond the frame in view, or stops it and cancels seeking.
    pub(super) fn analyse_ahead(&mut self, ahead: bool) {
        // Where nothing is left to stop, other settings are still analysed to the end.
        let is_through = |pass: &AnalysisPass| pass.has_analysed_all(&self.frames);
        let nothing = is_through(&self.pass) && self.compared.pass.as_ref().is_none_or(is_through);
        self.ahead = if ahead || nothing { AheadMode::All } else { AheadMode::Nothing };
        if !ahead {
            self.view.cancel(self.pass.model.analysed());
        }
    }

    /// The pass to advance next. Both stay at the same position, so that each decoded frame is used by both.
    pub(super) fn next_due(&self) -> Option<PassSlot> {
        let in_view = self.is_due(&self.pass);
        let compared = self.compared.pass.as_ref().filter(|pass| self.is_due(pass));
        match compared {
            Some(compared) if !in_view || compared.next_order() < self.pass.next_order() => {
                Some(PassSlot::Compared)
            }
            _ => in_view.then_some(PassSlot::InView),
        }
    }

    /// Whether frames remain to be analysed: all, or up to the requested one.
    fn is_due(&self, pass: &AnalysisPass) -> bool {
        if pass.has_analysed_all(&self.frames) {
            // The other pass may have found the end.
            return !pass.is_finished();
        }
        self.ahead == AheadMode::All || pass.model.analysed() <= self.view.target
    }

    /// Analyses the next decoded frames, or decodes one.
    pub(super) fn analyse(&mut self, which: PassSlot) -> Result<(), StopReason> {
        let started = Instant::now();
        let (last, both) = (self.last_position_of(which), self.are_both_due());
        // The other pass needs the same frame soon.
        let keep = if both { Keep::Yes } else { Keep::IfRoom };
        let pass = match which {
            PassSlot::InView => &mut self.pass,
            PassSlot::Compared => {
                let Some(pass) = &mut self.compared.pass else { return Ok(()) };
                pass
            }
        };
        let (position, next) = (pass.model.analysed(), pass.model.next_step());
        let (pins, region_tuner) = (&mut self.pins, &mut self.region_tuner);
        let step = pass.advance(&mut self.frames, last, keep, |position, frame| {
            pins.push(position, frame);
            region_tuner.push(position, frame);
        });
        let front = pass.model.analysed();
        let to_learn = pass.model.to_learn();
        self.outbox.warnings.extend(self.frames.take_warnings());
        // The end of the sequence may have been found.
        self.outbox.timeline_grew = true;
        match step? {
            PassStep::Advanced => {}
            // After a change of settings, the new pass needs frames that a live source has lost.
            PassStep::FrameLost => return self.start_over_live(),
        }
        match which {
            PassSlot::InView => self.view.find_occlusion(&self.pass.model, position..front),
            PassSlot::Compared => self.outbox.compared_grew = true,
        }
        if let NextStep::Learn(learnt) = next {
            self.busy = Some(WorkProgress {
                what: "learning background".to_owned(),
                done: learnt,
                total: Some(to_learn),
            });
        }
        if front > position {
            self.speed_meter.add(started.elapsed(), front - position);
            let total = if self.frames.is_complete() {
                Some(self.frames.numbers().len() as u32)
            } else {
                self.info.frames.map(|frames| frames.max(front))
            };
            let what = match which {
                PassSlot::InView if self.view.target >= front && !self.view.follow => {
                    format!("analysing up to frame {}", self.number_of(self.view.target))
                }
                _ if both => "analysing A and B".to_owned(),
                PassSlot::Compared => "analysing other settings".to_owned(),
                PassSlot::InView => "analysing".to_owned(),
            };
            self.busy = Some(WorkProgress { what, done: front, total });
        }
        Ok(())
    }

    /// The last position for one step of a pass, if it is limited.
    fn last_position_of(&self, which: PassSlot) -> Option<u32> {
        let (pass, next) = self.pass.next_order();
        match (which, &self.compared.pass) {
            // The requested frame comes first.
            (PassSlot::InView, _) if !self.view.follow && pass > 0 && next <= self.view.target => {
                Some(self.view.target)
            }
            // No further than the cached frames reach until the other pass needs them.
            (PassSlot::InView, Some(compared)) if compared.next_order() <= (pass, next) => {
                Some(next.saturating_add(self.frames.room().saturating_sub(2) as u32))
            }
            (PassSlot::Compared, Some(compared))
                if compared.next_order().0 == pass && compared.next_order().1 < next =>
            {
                Some(next - 1)
            }
            _ => None,
        }
    }

    /// Whether both passes have frames left to analyse.
    fn are_both_due(&self) -> bool {
        self.is_due(&self.pass) && self.compared.pass.as_ref().is_some_and(|pass| self.is_due(pass))
    }
}
