//! Scores of an analysis against ground truth, computed in short steps.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Instant;

use crate::replay::store::analysis_record::AnalysisRecord;
use crate::replay::tasks::gather::frame_consumer::MAX_TURN;
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::decisions::Decisions;
use crate::truth::ignored::without_ignored;
use crate::truth::mask_score::MaskScore;
use crate::truth::summary::{self, Score, TrackScore};

/// Scores a complete analysis and stores the last score.
#[derive(Default)]
pub(crate) struct Scorer {
    job: Option<ScoreJob>,
    /// The ground truth, and the score against it.
    done: Option<(Arc<Truth>, Arc<Score>)>,
}

/// The result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScoreStep {
    /// There is nothing to do.
    Idle,
    /// Another step is needed.
    Working,
    /// The score is complete.
    Finished,
}

/// A [`Score`] in progress.
struct ScoreJob {
    truth: Arc<Truth>,
    /// Receives the score of the tracks, if there are true boxes, or the payload of a panic.
    tracks: Option<Receiver<thread::Result<TrackScore>>>,
    /// Number of processed frames, of frames with true masks, and the counts of decisions in these.
    looked_at: u32,
    judged: usize,
    decisions: Decisions,
}

impl Scorer {
    /// Advances the score of an analysis on `record`, whose offline result is `found`, against `truth`. Where the
    /// sequence `leaves_out` frames, objects in these are not missed.
    pub(crate) fn advance(
        &mut self,
        truth: &Arc<Truth>,
        found: &Arc<Boxes>,
        record: &AnalysisRecord,
        leaves_out: bool,
    ) -> ScoreStep {
        if self.by(truth).is_some() {
            return ScoreStep::Idle;
        }
        let job = match self.job.take() {
            Some(job) if Arc::ptr_eq(&job.truth, truth) => self.job.insert(job),
            _ => {
                let analysed =
                    leaves_out.then(|| record.outlines().map(|analysis| analysis.number).collect());
                self.job.insert(ScoreJob::new(truth, found, analysed))
            }
        };
        let Some(score) = job.advance(record) else { return ScoreStep::Working };
        (self.job, self.done) = (None, Some((Arc::clone(truth), Arc::new(score))));
        ScoreStep::Finished
    }

    /// The score against `truth`, if it is complete.
    pub(crate) fn by(&self, truth: &Arc<Truth>) -> Option<Arc<Score>> {
        let score = self.done.as_ref().filter(|(by, _)| Arc::ptr_eq(by, truth));
        score.map(|(_, score)| Arc::clone(score))
    }
}

impl ScoreJob {
    /// `analysed` are the numbers of the analysed frames where others are left out.
    fn new(truth: &Arc<Truth>, found: &Arc<Boxes>, analysed: Option<BTreeSet<u32>>) -> Self {
        let tracks = truth.boxes.is_some().then(|| {
            let (answer, answered) = channel();
            let (truth, found) = (Arc::clone(truth), Arc::clone(found));
            // All frames are matched in one call, which would delay a newer request.
            rayon::spawn(move || {
                let score = || {
                    truth.boxes.as_ref().map(|boxes| {
                        let found = without_ignored(boxes, &truth.ignored, &found);
                        match &analysed {
                            Some(analysed) => {
                                summary::score_of_frames(boxes, &found, |number| analysed.contains(&number))
                            }
                            None => summary::score(boxes, &found),
                        }
                    })
                };
                // The receiver is dropped when another truth is loaded.
                if let Some(score) = catch_unwind(AssertUnwindSafe(score)).transpose() {
                    let _ = answer.send(score);
                }
            });
            answered
        });
        Self { truth: Arc::clone(truth), tracks, looked_at: 0, judged: 0, decisions: Decisions::default() }
    }

    /// Advances by one step; returns the score if it is complete.
    fn advance(&mut self, record: &AnalysisRecord) -> Option<Score> {
        let started = Instant::now();
        while let Some((masks, analysis)) = self.truth.masks.as_ref().zip(record.outline(self.looked_at)) {
            // The scored masks are those in which regions are found.
            if let Some(truth) = masks.of(analysis.number) {
                let mut judge = truth.judge();
                record.for_each_run(self.looked_at, |run| judge.take(run));
                self.decisions += judge.decisions();
                self.judged += 1;
            }
            self.looked_at += 1;
            if started.elapsed() > MAX_TURN {
                return None;
            }
        }
        // No other work remains.
        let tracks = match self.tracks.as_ref().map(|answered| answered.recv_timeout(MAX_TURN)) {
            Some(Ok(Ok(tracks))) => Some(tracks),
            Some(Ok(Err(panic))) => resume_unwind(panic),
            Some(Err(RecvTimeoutError::Timeout)) => return None,
            Some(Err(RecvTimeoutError::Disconnected)) | None => None,
        };
        let masks = self.truth.masks.as_ref().map(|_| MaskScore::new(self.judged, self.decisions));
        Some(Score { tracks, masks })
    }
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::frame::Size;
    use crate::truth::boxes::Bounds;

    /// The boxes of one object, which moves to the right from `x` on in ten frames.
    pub(crate) fn boxes(x: f64) -> Boxes {
        let of_frame = |number: u32| [(1, Bounds([x + f64::from(number), 5.0, 10.0, 20.0]))].into();
        (1..=10).map(|number| (number, of_frame(number))).collect()
    }

    #[test]
    fn another_truth_is_scored_from_the_start() {
        let (found, record) = (Arc::new(boxes(0.0)), AnalysisRecord::new(Size::new(64, 48)));
        let truth = |x| Arc::new(Truth { boxes: Some(boxes(x)), ..Truth::default() });
        let (far, equal) = (truth(30.0), truth(0.0));
        let mut scorer = Scorer { job: Some(ScoreJob::new(&far, &found, None)), done: None };
        assert!((0..1000).any(|_| scorer.advance(&equal, &found, &record, false) == ScoreStep::Finished));
        assert!(scorer.by(&far).is_none());
        let tracks = scorer.by(&equal).and_then(|score| score.tracks.clone()).unwrap();
        assert_eq!((tracks.strict.mota, tracks.strict.idf1), (1.0, 1.0));
        assert_eq!(scorer.advance(&equal, &found, &record, false), ScoreStep::Idle);
    }
}
