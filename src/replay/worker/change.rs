//! Applies other settings, another region of interest or another ground truth; restarts only the affected stages.

use std::sync::Arc;

use super::{StopReason, Worker};
use crate::regions::Roi;
use crate::replay::published::{Phase, ShownFrame};
use crate::replay::tasks::analyse::PassInputs;
use crate::replay::tasks::analyse::analysis_pass::AnalysisPass;
use crate::replay::tasks::analyse::compared_pass::ComparedPass;
use crate::settings::{Settings, Stage};
use crate::truth::Truth;
use crate::truth::external::ExternalResults;

/// What decides which stages run again.
pub(super) struct SettingsChange {
    /// The settings in view.
    pub(super) in_view: Settings,
    /// The candidate settings to compare with them.
    pub(super) candidate: Option<Settings>,
    /// The region of interest; `None` for the whole image.
    pub(super) roi: Option<Arc<Roi>>,
}

impl Worker<'_> {
    /// Sets the ground truth, without masks if they have another size than the source.
    pub(super) fn set_truth_data(&mut self, truth: Option<Arc<Truth>>) {
        let size = self.info.size;
        let truth = match self.info.placement() {
            Some(placement) => truth.map(|truth| Arc::new(truth.in_frames(&placement))),
            None => truth,
        };
        let (truth, masks) = match truth {
            Some(truth) if truth.masks.as_ref().is_some_and(|masks| masks.size() != size) => {
                let (masks, size) =
                    (truth.masks.as_ref().map_or(size, |masks| masks.size()), self.info.source_size());
                self.outbox.warnings.push(format!(
                    "the ground-truth masks are {masks}, the frames of {} are {size}: the masks are \
                     ignored; load those of this video",
                    self.info.name
                ));
                (Some(Arc::new(Truth { masks: None, ..Truth::clone(&truth) })), None)
            }
            truth => {
                let masks = truth.as_ref().and_then(|truth| truth.masks.clone());
                (truth, masks)
            }
        };
        self.truth = truth;
        self.region_tuner.set_truth(masks);
        self.publish_region_tuning();
        self.publish_external_score();
        (self.outbox.timeline_grew, self.outbox.compared_grew) = (true, true);
        self.show_again();
    }

    /// Sets the external results, without masks if they have another size than the source.
    pub(super) fn set_external(&mut self, results: Option<Arc<ExternalResults>>) {
        let results = match self.info.placement() {
            Some(placement) => results.map(|results| Arc::new(results.in_frames(&placement))),
            None => results,
        };
        let results = results.map(|results| {
            let masks = results.masks.as_ref().map(|masks| masks.size());
            let Some(masks) = masks.filter(|masks| *masks != self.info.size) else { return results };
            self.outbox.warnings.push(format!(
                "the masks of {} are {masks}, the frames of {} are {}: the masks are ignored; load those of this video",
                results.name,
                self.info.name,
                self.info.source_size()
            ));
            Arc::new(ExternalResults { masks: None, ..ExternalResults::clone(&results) })
        });
        self.external.set_results(results);
        self.publish_external_score();
        self.show_again();
    }

    /// Publishes the frame in view with the present masks of ground truth and external results.
    fn show_again(&mut self) {
        if let Some(shown) = self.view.shown.clone() {
            self.show(ShownFrame::clone(&shown));
        }
    }

    /// The present settings and region of interest.
    pub(super) fn present_settings(&self) -> SettingsChange {
        SettingsChange {
            in_view: Settings::clone(self.pass.settings()),
            candidate: self.compared.settings.clone(),
            roi: self.pass.model.roi().cloned(),
        }
    }

    /// Applies other settings in view and compared, or another region of interest, and restarts the affected stages.
    pub(super) fn apply_settings(&mut self, change: SettingsChange) -> Result<(), StopReason> {
        let SettingsChange { in_view, candidate, roi } = change;
        let candidate = self.comparable(candidate);
        let differs = self.pass.first_difference(&in_view, roi.as_ref()).is_some();
        if !differs && !self.stopped && candidate == self.compared.settings {
            return Ok(());
        }
        if self.stopped {
            self.compared = ComparedPass::default();
        }
        if differs {
            // Under other settings the event may not exist.
            self.counterfactual_task.set_event(None);
            self.publish_counterfactual();
        }
        self.compared.settings = candidate;
        if differs || self.stopped {
            self.change_view(in_view, roi.clone())?;
        }
        self.change_compared(roi)
    }

    /// The settings to compare, if possible: a live source's frames come once and only some are cached, which is not
    /// enough for two passes.
    fn comparable(&mut self, candidate: Option<Settings>) -> Option<Settings> {
        let refused = candidate.is_some() && self.info.live;
        if refused && !std::mem::replace(&mut self.outbox.warned.live, true) {
            self.outbox.warnings.push(format!(
                "two settings cannot be compared on the live source {}; record it first",
                self.info.name
            ));
        }
        candidate.filter(|_| !refused)
    }

    /// Makes other settings those in view.
    fn change_view(&mut self, settings: Settings, roi: Option<Arc<Roi>>) -> Result<(), StopReason> {
        // The pixel first: its history over all frames takes a millisecond.
        self.pass.pixel_follower.choose(self.pixel, &settings, &self.info);
        self.publish_pixel();
        self.pins.run_again(&settings, &self.info);
        self.region_tuner.set_settings(&settings, &self.info);
        self.region.forget();
        self.outbox.pixel_grew = true;
        let budget = self.budget();
        let settings = Arc::new(settings);
        match self.pass.first_difference(&settings, roi.as_ref()) {
            _ if self.swap_with_compared(&settings, roi.as_ref()) => self.show_pixel(),
            Some(stage) if stage > Stage::Mixture && !self.stopped => {
                if self.compared.is(self.pass.settings())
                    && settings != *self.pass.settings()
                    && let Some(fork) = self.pass.fork(budget)
                {
                    let given_up = self.compared.pass.replace(fork);
                    rayon::spawn(move || drop(given_up));
                }
                self.pass.restart_at(stage, settings, roi)?;
            }
            _ => {
                let mut pass = AnalysisPass::new(self.inputs(settings, roi, budget))?;
                pass.pixel_follower = std::mem::take(&mut self.pass.pixel_follower);
                let old = std::mem::replace(&mut self.pass, pass);
                if self.compared.is(old.settings()) && !self.stopped {
                    let given_up = self.compared.pass.replace(old);
                    rayon::spawn(move || drop(given_up));
                    if let Some(old) = &mut self.compared.pass {
                        old.inspect(self.pixel);
                    }
                } else {
                    // Freeing gigabytes takes longer than analysing the first frames.
                    rayon::spawn(move || drop(old));
                }
                if self.info.live && !self.frames.numbers().is_empty() && self.frames.kept(0).is_none() {
                    self.start_over_live()?;
                }
            }
        }
        self.stopped = false;
        self.view.restart_search();
        // The timeline changes together with the view.
        self.outbox.analysed = 0;
        self.outbox.timeline_grew = true;
        self.shared.publish(|state| state.phase = Phase::Ready);
        Ok(())
    }

    /// Swaps the two passes if the compared one has the requested settings; returns whether it did.
    fn swap_with_compared(&mut self, settings: &Settings, roi: Option<&Arc<Roi>>) -> bool {
        let Some(pass) = &mut self.compared.pass else { return false };
        let is_requested = pass.first_difference(settings, roi).is_none() && !self.stopped;
        if is_requested {
            std::mem::swap(pass, &mut self.pass);
            pass.inspect(self.pixel);
            self.compared.shown = None;
        }
        is_requested
    }

    /// Sets the settings of the compared pass.
    fn change_compared(&mut self, roi: Option<Arc<Roi>>) -> Result<(), StopReason> {
        let budget = self.budget();
        self.pass.model.set_budget(budget);
        self.outbox.compared_grew = true;
        let settings = self.compared.settings.clone().filter(|settings| settings != &**self.pass.settings());
        let Some(settings) = settings else {
            // Equal settings share one pass; without settings there is none.
            let given_up = self.compared.take_pass();
            rayon::spawn(move || drop(given_up));
            return Ok(());
        };
        let inputs = self.inputs(Arc::new(settings), roi, budget);
        match &mut self.compared.pass {
            Some(pass) => match pass.first_difference(&inputs.settings, inputs.roi.as_ref()) {
                None => {}
                Some(stage) if stage > Stage::Mixture => {
                    pass.restart_at(stage, inputs.settings, inputs.roi)?;
                }
                Some(_) => {
                    let other = self.pass.fork_under(inputs)?;
                    let old = std::mem::replace(pass, other);
                    rayon::spawn(move || drop(old));
                }
            },
            none => *none = Some(self.pass.fork_under(inputs)?),
        }
        if let Some(pass) = &mut self.compared.pass {
            pass.model.set_budget(budget);
            pass.inspect(self.pixel);
        }
        Ok(())
    }

    /// The inputs of a pass through the session's source.
    fn inputs(&self, settings: Arc<Settings>, roi: Option<Arc<Roi>>, budget: usize) -> PassInputs {
        PassInputs { settings, roi, info: Arc::clone(&self.info), budget }
    }

    /// The memory budget for checkpoints and the record of one pass.
    const fn budget(&self) -> usize {
        if self.compared.settings.is_some() { self.model_budget / 2 } else { self.model_budget }
    }

    /// Restarts the sequence with the next frame: a live source whose first frames are evicted cannot be analysed
    /// again from its start.
    pub(super) fn start_over_live(&mut self) -> Result<(), StopReason> {
        let name = &self.info.name;
        if self.frames.is_complete() {
            return Err(StopReason(format!(
                "{name} has no more frames, and its first frames are no longer kept for a new analysis; \
                 open it again"
            )));
        }
        self.outbox.warnings.push(format!(
            "the first frames of {name} are no longer kept: the new settings apply from the next frame on"
        ));
        self.frames.forget();
        let (settings, roi) = (Arc::clone(self.pass.settings()), self.pass.model.roi().cloned());
        self.pass = AnalysisPass::new(self.inputs(settings, roi, self.model_budget))?;
        self.pass.inspect(self.pixel);
        self.pins.forget(self.pass.settings(), &self.info);
        self.region.forget();
        self.pixel_tuner.forget();
        self.region_tuner.forget();
        self.view.follow = true;
        Ok(())
    }
}
