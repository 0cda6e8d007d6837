//! The pass of the candidate settings, which are compared with those in view.

use std::sync::Arc;

use super::analysis_pass::AnalysisPass;
use crate::replay::{ShownFrame, is_same};
use crate::settings::Settings;

/// A second choice of settings on the same frames.
#[derive(Default)]
pub(crate) struct ComparedPass {
    /// The settings, `None` while nothing is compared.
    pub(crate) settings: Option<Settings>,
    /// Their pass; `None` while they equal the settings in view, whose pass serves both.
    pub(crate) pass: Option<AnalysisPass>,
    /// The frame shown last.
    pub(crate) shown: Option<Arc<ShownFrame>>,
}

impl ComparedPass {
    /// Whether these are its settings.
    pub(crate) fn is(&self, settings: &Settings) -> bool {
        self.settings.as_ref() == Some(settings)
    }

    /// Removes and returns the pass.
    pub(crate) fn take_pass(&mut self) -> Option<AnalysisPass> {
        self.shown = None;
        self.pass.take()
    }

    /// Whether the frame at a position has been analysed but not prepared.
    pub(crate) fn needs_frame(&self, position: u32) -> bool {
        let Some(pass) = &self.pass else { return false };
        pass.model.analysed() > position
            && !self.shown.as_ref().is_some_and(|shown| is_frame_of(shown, pass, position))
    }

    /// Whether a frame in view contains the newest available compared frame.
    pub(crate) fn is_current_in(&self, shown: &ShownFrame) -> bool {
        match (&self.settings, &self.pass) {
            (Some(_), None) => {
                shown.compared.as_ref().is_some_and(|compared| compared.settings == shown.settings)
            }
            (Some(_), Some(pass)) if pass.model.analysed() > shown.position => {
                shown.compared.as_ref().is_some_and(|compared| is_frame_of(compared, pass, shown.position))
            }
            _ => shown.compared.is_none(),
        }
    }

    /// The compared frame of a frame in view, if it is prepared.
    pub(crate) fn frame_for(&mut self, shown: &ShownFrame) -> Option<Arc<ShownFrame>> {
        self.settings.as_ref()?;
        let Some(pass) = &mut self.pass else {
            return Some(Arc::new(ShownFrame { compared: None, ..shown.clone() }));
        };
        let prepared = self.shown.take_if(|prepared| is_frame_of(prepared, pass, shown.position))?;
        let pixel = pass.pixel_follower.history_covering(shown.position);
        let prepared = if is_same(prepared.pixel.as_ref(), pixel.as_ref()) {
            prepared
        } else {
            Arc::new(ShownFrame { pixel, ..ShownFrame::clone(&prepared) })
        };
        self.shown = Some(Arc::clone(&prepared));
        Some(prepared)
    }

    /// Whether the chosen pixel's history is known but missing in the prepared frame.
    pub(crate) fn needs_pixel(&mut self, at: Option<(u32, u32)>) -> bool {
        let Some((pass, shown)) = self.pass.as_mut().zip(self.shown.as_ref()) else { return false };
        let of = |shown: &ShownFrame| shown.pixel.as_ref().map(|history| history.at);
        of(shown) != at && pass.pixel_follower.history_covering(shown.position).is_some()
    }
}

/// Whether a frame is the one at a position of a pass under its present settings.
fn is_frame_of(shown: &ShownFrame, pass: &AnalysisPass, position: u32) -> bool {
    shown.position == position && Arc::ptr_eq(&shown.settings, pass.settings())
}
