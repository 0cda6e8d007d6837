//! Seeks the frame to show.

use std::sync::Arc;

use super::{PassSlot, StopReason, Worker};
use crate::replay::published::{ShownFrame, WorkProgress};
use crate::replay::tasks::show::{ShowStep, seek_frame};

impl Worker<'_> {
    pub(super) fn is_view_current(&self) -> bool {
        self.view.shown.as_ref().is_some_and(|shown| {
            self.view.is_current(shown, &self.pass, &self.frames) && self.compared.is_current_in(shown)
        })
    }

    /// One step towards showing the requested frame. Where both passes have analysed it, both frames are published
    /// together.
    pub(super) fn advance_view(&mut self) -> Result<(), StopReason> {
        let is_current = |shown: &Arc<ShownFrame>| self.view.is_current(shown, &self.pass, &self.frames);
        if self.compared.needs_frame(self.view.target) {
            if let Some(shown) = self.seek(PassSlot::Compared)? {
                self.compared.shown = Some(Arc::new(shown));
            }
        } else if let Some(shown) = self.view.shown.clone().filter(is_current) {
            self.show(ShownFrame::clone(&shown));
        } else if let Some(shown) = self.view.without_map(&self.pass, &self.frames) {
            self.show(shown);
        } else if self.view.target >= self.pass.model.analysed() {
            self.analyse(PassSlot::InView)?;
        } else if let Some(shown) = self.seek(PassSlot::InView)? {
            self.show(shown);
        }
        Ok(())
    }

    /// One step of seeking the requested frame in a pass; returns the frame when it is complete.
    fn seek(&mut self, which: PassSlot) -> Result<Option<ShownFrame>, StopReason> {
        let position = self.view.target;
        let quantity = self.view.map.filter(|_| which == PassSlot::InView);
        let pass = match (which, &mut self.compared.pass) {
            (PassSlot::InView, _) => &mut self.pass,
            (PassSlot::Compared, Some(pass)) => pass,
            (PassSlot::Compared, None) => return Ok(None),
        };
        match seek_frame(pass, &mut self.frames, position, quantity)? {
            ShowStep::Frame(shown) => return Ok(Some(shown)),
            ShowStep::Continues => {}
            ShowStep::Replays { number, from } => {
                let what = format!("computing frame {number}");
                self.busy = Some(WorkProgress { what, done: from, total: Some(position + 1) });
            }
            ShowStep::Decodes => {
                let what = format!("decoding up to frame {}", self.number_of(position));
                self.busy = Some(WorkProgress { what, done: 0, total: None });
            }
            ShowStep::FrameLost => self.show_newest_instead(),
        }
        Ok(None)
    }

    /// Requests the newest frame in place of one that is no longer available. Only a live source drops frames; the
    /// newest one is always available.
    fn show_newest_instead(&mut self) {
        self.view.target = self.pass.model.classified().saturating_sub(1);
        if !std::mem::replace(&mut self.outbox.warned.gone, true) {
            self.outbox.warnings.push(format!(
                "earlier frames of {} are no longer kept: the newest one is shown",
                self.info.name
            ));
        }
    }
}
