//! The external results, and their score against ground truth, computed on a thread.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

use super::score::ScoreStep;
use crate::replay::tasks::gather::frame_consumer::MAX_TURN;
use crate::truth::Truth;
use crate::truth::external::ExternalResults;
use crate::truth::masks::TrueMask;
use crate::truth::summary::Score;

/// Scores external results and stores the last score.
#[derive(Default)]
pub(crate) struct ExternalScorer {
    results: Option<Arc<ExternalResults>>,
    job: Option<ScoreJob>,
    /// The ground truth, and the score against it.
    done: Option<(Arc<Truth>, Arc<Score>)>,
}

/// A score in progress.
struct ScoreJob {
    truth: Arc<Truth>,
    /// Receives the score, or the payload of a panic.
    score: Receiver<thread::Result<Score>>,
}

impl ExternalScorer {
    /// Sets the results, in the pixels of the frames.
    pub(crate) fn set_results(&mut self, results: Option<Arc<ExternalResults>>) {
        *self = Self { results, ..Self::default() };
    }

    /// The mask of a frame.
    pub(crate) fn mask(&self, number: u32) -> Option<&Arc<TrueMask>> {
        self.results.as_ref()?.mask(number)
    }

    /// Advances the score against `truth` in the frames of these numbers, which all are analysed. Where the sequence
    /// `leaves_out` frames, objects in these are not missed.
    pub(crate) fn advance(&mut self, truth: &Arc<Truth>, analysed: &[u32], leaves_out: bool) -> ScoreStep {
        let Some(results) = self.results.as_ref().filter(|_| self.by(truth).is_none()) else {
            return ScoreStep::Idle;
        };
        let job = match self.job.take() {
            Some(job) if Arc::ptr_eq(&job.truth, truth) => job,
            _ => ScoreJob::start(truth, results, analysed.iter().copied().collect(), leaves_out),
        };
        match job.score.recv_timeout(MAX_TURN) {
            Ok(Ok(score)) => {
                self.done = Some((job.truth, Arc::new(score)));
                ScoreStep::Finished
            }
            Ok(Err(panic)) => resume_unwind(panic),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                self.job = Some(job);
                ScoreStep::Working
            }
        }
    }

    /// The score against `truth`, if it is complete.
    pub(crate) fn by(&self, truth: &Arc<Truth>) -> Option<Arc<Score>> {
        let score = self.done.as_ref().filter(|(by, _)| Arc::ptr_eq(by, truth));
        score.map(|(_, score)| Arc::clone(score))
    }
}

impl ScoreJob {
    fn start(
        truth: &Arc<Truth>,
        results: &Arc<ExternalResults>,
        analysed: BTreeSet<u32>,
        leaves_out: bool,
    ) -> Self {
        let (answer, score) = channel();
        let (of_thread, results) = (Arc::clone(truth), Arc::clone(results));
        rayon::spawn(move || {
            let score = || results.score(&of_thread, &analysed, leaves_out);
            // The receiver is dropped when other results or another truth are loaded.
            let _ = answer.send(catch_unwind(AssertUnwindSafe(score)));
        });
        Self { truth: Arc::clone(truth), score }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::replay::tasks::score::tests::boxes;

    #[test]
    fn another_truth_is_scored_from_the_start() {
        let truth = |x| Arc::new(Truth { boxes: Some(boxes(x)), ..Truth::default() });
        let (far, equal) = (truth(30.0), truth(0.0));
        let analysed: Vec<u32> = (1..=10).collect();
        let results = Arc::new(ExternalResults { boxes: Some(boxes(0.0)), ..ExternalResults::default() });
        let mut scorer = ExternalScorer::default();
        assert_eq!(scorer.advance(&equal, &analysed, false), ScoreStep::Idle);
        scorer.set_results(Some(Arc::clone(&results)));
        scorer.job = Some(ScoreJob::start(&far, &results, (1..=10).collect(), false));
        assert!((0..1000).any(|_| scorer.advance(&equal, &analysed, false) == ScoreStep::Finished));
        assert!(scorer.by(&far).is_none());
        let tracks = scorer.by(&equal).and_then(|score| score.tracks.clone()).unwrap();
        assert_eq!((tracks.strict.mota, tracks.strict.idf1), (1.0, 1.0));
        scorer.set_results(Some(results));
        assert!(scorer.by(&equal).is_none(), "the score is that of the earlier results");
    }
}
