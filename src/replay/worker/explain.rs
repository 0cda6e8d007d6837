//! Computes scores, and explanations of the verdict on a pixel, of the verdicts in a region, and of an event.

use super::Worker;
use crate::replay::is_same;
use crate::replay::published::WorkProgress;
use crate::replay::tasks::score::ScoreStep;

impl Worker<'_> {
    /// Advances the scores of complete analyses; returns whether there was work to do.
    pub(super) fn advance_scores(&mut self) -> bool {
        let Some(truth) = &self.truth else { return false };
        let in_view = self.pass.score(truth);
        self.outbox.timeline_grew |= in_view == ScoreStep::Finished;
        let Some(pass) = self.compared.pass.as_mut().filter(|_| in_view == ScoreStep::Idle) else {
            return in_view != ScoreStep::Idle;
        };
        let candidate = pass.score(truth);
        self.outbox.compared_grew |= candidate == ScoreStep::Finished;
        candidate != ScoreStep::Idle
    }

    /// Advances the score of the external results once all frames are analysed; returns whether there was work to do.
    pub(super) fn advance_external_score(&mut self) -> bool {
        let Some(truth) = self.truth.as_ref().filter(|_| self.pass.has_analysed_all(&self.frames)) else {
            return false;
        };
        let step = self.external.advance(truth, self.frames.numbers(), self.info.every() > 1);
        if step == ScoreStep::Finished {
            self.publish_external_score();
        }
        step != ScoreStep::Idle
    }

    /// Advances the tuning of the region; returns whether there was work to do.
    pub(super) fn advance_region_tuning(&mut self) -> bool {
        let before = self.region_tuner.latest();
        let Some((done, total)) = self.region_tuner.advance(self.pass.settings()) else { return false };
        if !is_same(before.as_ref(), self.region_tuner.latest().as_ref()) {
            self.publish_region_tuning();
        }
        self.busy = Some(WorkProgress {
            what: "testing other settings".to_owned(),
            done: done as u32,
            total: Some(total as u32),
        });
        true
    }

    /// Advances the tuning of the chosen pixel; returns whether there was work to do.
    pub(super) fn advance_tuning(&mut self) -> bool {
        let history =
            self.view.shown.as_ref().and_then(|shown| shown.pixel.as_ref().map(|pixel| (pixel, shown)));
        let Some((history, shown)) = history else { return false };
        let before = self.pixel_tuner.latest();
        let worked = self.pixel_tuner.advance(history, shown.position);
        let tuning = self.pixel_tuner.latest();
        if !is_same(tuning.as_ref(), before.as_ref()) {
            self.shared.publish(|state| state.tuning = tuning);
        }
        worked
    }

    /// Advances the counterfactual search; returns whether there was work to do.
    pub(super) fn advance_counterfactual(&mut self) -> bool {
        let before = self.counterfactual_task.latest();
        let numbers = self.frames.numbers();
        let worked =
            self.counterfactual_task.advance(&self.pass.model, numbers, self.info.size, self.info.fps);
        let answer = self.counterfactual_task.latest();
        if !is_same(before.as_ref(), answer.as_ref()) {
            self.publish_counterfactual();
        }
        if worked {
            let (done, total) = answer.map_or((0, 0), |answer| answer.tried);
            self.busy = Some(WorkProgress {
                what: "computing counterfactuals".to_owned(),
                done: done as u32,
                total: (total > 0).then_some(total as u32),
            });
        }
        worked
    }
}
