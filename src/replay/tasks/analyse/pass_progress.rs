//! How far a pass has come, and what it does next.

use crate::settings::Stage;

/// How far a pass has come. The number of frames on record is the record's own length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PassProgress {
    /// Number of first frames that the model learns from before classification; fewer where the source has fewer.
    to_learn: u32,
    /// Number of frames that it has learned from.
    learnt: u32,
    /// Number of fully analysed frames; fewer than on record while later stages are run again.
    analysed: u32,
    /// Whether the stages that are run again start with the regions, and not with tracking.
    redoing_regions: bool,
}

/// The next step of a pass, with the position of its frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NextStep {
    /// The model learns from the frame, before any is classified.
    Learn(u32),
    /// The model classifies the frame, and all later stages follow.
    Classify(u32),
    /// The frame's mask is on record; its regions are found and tracked again.
    FindRegions(u32),
    /// The frame's regions are on record; they are tracked again.
    Track(u32),
}

impl NextStep {
    /// The position of the frame.
    pub(crate) const fn position(self) -> u32 {
        match self {
            Self::Learn(position)
            | Self::Classify(position)
            | Self::FindRegions(position)
            | Self::Track(position) => position,
        }
    }

    /// A key by which steps are ordered: learning comes before all others, then the position counts.
    pub(crate) const fn order(self) -> (u32, u32) {
        (if matches!(self, Self::Learn(_)) { 0 } else { 1 }, self.position())
    }
}

impl PassProgress {
    /// Before the first frame.
    pub(crate) const fn new(to_learn: u32) -> Self {
        Self { to_learn, learnt: 0, analysed: 0, redoing_regions: false }
    }

    /// The next step, where `recorded` frames are on record.
    pub(crate) const fn next_step(&self, recorded: u32) -> NextStep {
        if self.learnt < self.to_learn {
            NextStep::Learn(self.learnt)
        } else if self.analysed >= recorded {
            NextStep::Classify(self.analysed)
        } else if self.redoing_regions {
            NextStep::FindRegions(self.analysed)
        } else {
            NextStep::Track(self.analysed)
        }
    }

    /// Number of fully analysed frames.
    pub(crate) const fn analysed(&self) -> u32 {
        self.analysed
    }

    /// Number of first frames to learn from, as far as known.
    pub(crate) const fn frames_to_learn(&self) -> u32 {
        self.to_learn
    }

    /// Counts frames that the model has learned from; returns whether they are the last ones.
    pub(crate) const fn add_learnt(&mut self, frames: u32) -> bool {
        self.learnt += frames;
        self.learnt >= self.to_learn
    }

    /// Ends learning, where there are no more frames to learn from.
    pub(crate) const fn end_learning(&mut self) {
        self.to_learn = self.learnt;
    }

    /// Counts frames that all stages have analysed.
    pub(crate) const fn add_analysed(&mut self, frames: u32) {
        self.analysed += frames;
    }

    /// Returns to the first frame for `stage` and the stages after it, where `recorded` frames are on record.
    pub(crate) fn restart_at(&mut self, stage: Stage, recorded: u32) {
        // Frames that were not reached yet still have regions of the previous settings.
        let half_done = self.redoing_regions && self.analysed < recorded;
        self.redoing_regions = half_done || stage <= Stage::Regions;
        self.analysed = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_learned_from_before_any_is_classified() {
        let mut progress = PassProgress::new(3);
        assert_eq!(progress.next_step(0), NextStep::Learn(0));
        assert!(!progress.add_learnt(2));
        assert_eq!(progress.next_step(0), NextStep::Learn(2));
        assert!(progress.add_learnt(1));
        assert_eq!(progress.next_step(0), NextStep::Classify(0));
        progress.add_analysed(4);
        assert_eq!((progress.next_step(4), progress.analysed()), (NextStep::Classify(4), 4));
        assert_eq!(PassProgress::new(0).next_step(0), NextStep::Classify(0));
    }

    #[test]
    fn a_short_source_ends_learning_early() {
        let mut progress = PassProgress::new(10);
        progress.add_learnt(4);
        progress.end_learning();
        assert_eq!((progress.frames_to_learn(), progress.next_step(0)), (4, NextStep::Classify(0)));
    }

    #[test]
    fn a_restart_repeats_only_the_affected_stages() {
        let mut progress = PassProgress::new(0);
        progress.add_analysed(9);
        progress.restart_at(Stage::Tracking, 9);
        assert_eq!(progress.next_step(9), NextStep::Track(0));
        progress.add_analysed(9);
        assert_eq!(progress.next_step(9), NextStep::Classify(9));
        progress.restart_at(Stage::Cleaning, 9);
        assert_eq!(progress.next_step(9), NextStep::FindRegions(0));
    }

    #[test]
    fn regions_that_were_not_found_again_yet_are_found_after_a_later_restart() {
        let mut progress = PassProgress::new(0);
        progress.add_analysed(9);
        progress.restart_at(Stage::Regions, 9);
        progress.add_analysed(5);
        progress.restart_at(Stage::Tracking, 9);
        assert_eq!(progress.next_step(9), NextStep::FindRegions(0), "positions 5 to 8 have old regions");
        progress.add_analysed(9);
        progress.restart_at(Stage::Tracking, 9);
        assert_eq!(progress.next_step(9), NextStep::Track(0));
    }

    #[test]
    fn learning_is_ordered_before_all_other_steps() {
        let steps = [NextStep::Learn(0), NextStep::Learn(7), NextStep::Track(2), NextStep::Classify(3)];
        assert!(steps.is_sorted_by_key(|step| step.order()));
        assert!(NextStep::Learn(9).order() < NextStep::FindRegions(0).order());
    }
}
