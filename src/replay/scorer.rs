//! How right an analysis is, worked out on the side and in small pieces.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Instant;

use super::gather::TURN;
use super::record::Record;
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::decisions::Decisions;
use crate::truth::mask_score::MaskScore;
use crate::truth::summary::{self, Score, TrackScore};

/// Scores what was analysed in full, and keeps the last score.
#[derive(Default)]
pub(super) struct Scoring {
    job: Option<Job>,
    /// By which truth it was scored, and what came out.
    done: Option<(Arc<Truth>, Arc<Score>)>,
}

/// How far a score is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scored {
    /// There is nothing to do.
    Already,
    /// It takes another piece of work.
    UnderWay,
    /// That was the last piece.
    Now,
}

/// A [`Score`] under way.
struct Job {
    truth: Arc<Truth>,
    /// Gives the score of the tracks, where there are true boxes, or what its panic says.
    tracks: Option<Receiver<thread::Result<TrackScore>>>,
    /// Frames whose masks were looked at, how many of them were judged, and what was decided in those.
    looked_at: u32,
    judged: usize,
    decisions: Decisions,
}

impl Scoring {
    /// Does a piece of work on the score of an analysis on `record`, whose final reading is `found`, by `truth`.
    pub(super) fn piece(&mut self, truth: &Arc<Truth>, found: &Arc<Boxes>, record: &Record) -> Scored {
        if self.by(truth).is_some() {
            return Scored::Already;
        }
        let job = match self.job.take() {
            Some(job) if Arc::ptr_eq(&job.truth, truth) => self.job.insert(job),
            _ => self.job.insert(Job::new(truth, found)),
        };
        let Some(score) = job.go_on(record) else { return Scored::UnderWay };
        (self.job, self.done) = (None, Some((Arc::clone(truth), Arc::new(score))));
        Scored::Now
    }

    /// The score by a truth, if it is there.
    pub(super) fn by(&self, truth: &Arc<Truth>) -> Option<Arc<Score>> {
        let score = self.done.as_ref().filter(|(by, _)| Arc::ptr_eq(by, truth));
        score.map(|(_, score)| Arc::clone(score))
    }
}

impl Job {
    fn new(truth: &Arc<Truth>, found: &Arc<Boxes>) -> Self {
        let tracks = truth.boxes.is_some().then(|| {
            let (answer, answered) = channel();
            let (truth, found) = (Arc::clone(truth), Arc::clone(found));
            // All frames are matched one after the other, which may take longer than a newer request can wait.
            rayon::spawn(move || {
                let score = || truth.boxes.as_ref().map(|boxes| summary::score(boxes, &found));
                // Nobody listens any more where another truth was named meanwhile.
                if let Some(score) = catch_unwind(AssertUnwindSafe(score)).transpose() {
                    let _ = answer.send(score);
                }
            });
            answered
        });
        Self { truth: Arc::clone(truth), tracks, looked_at: 0, judged: 0, decisions: Decisions::default() }
    }

    /// The score, if this was the last piece.
    fn go_on(&mut self, record: &Record) -> Option<Score> {
        let started = Instant::now();
        while let Some((masks, (analysis, _))) = self.truth.masks.as_ref().zip(record.outline(self.looked_at))
        {
            // The masks in which regions are found are what is judged.
            if let Some(truth) = masks.of(analysis.number) {
                let mut judge = truth.judge();
                record.each_run(self.looked_at, |run| judge.take(run));
                self.decisions += judge.decisions();
                self.judged += 1;
            }
            self.looked_at += 1;
            if started.elapsed() > TURN {
                return None;
            }
        }
        // There is nothing else to do meanwhile.
        let tracks = match self.tracks.as_ref().map(|answered| answered.recv_timeout(TURN)) {
            Some(Ok(Ok(tracks))) => Some(tracks),
            Some(Ok(Err(panic))) => resume_unwind(panic),
            Some(Err(RecvTimeoutError::Timeout)) => return None,
            Some(Err(RecvTimeoutError::Disconnected)) | None => None,
        };
        let masks = self.truth.masks.as_ref().map(|_| MaskScore::new(self.judged, self.decisions));
        Some(Score { tracks, masks })
    }
}
