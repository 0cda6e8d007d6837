//! True and found boxes of a sequence in the frames that were analysed.

use std::iter;
use std::path::Path;

use super::alignment;
use super::analysed_frames::{AnalysedFrames, Origin};
use super::boxes::{Boxes, shifted, shifted_number, span};
use super::event_scoring::ScoredEvent;
use super::formats::TrackFile;
use super::ignored::without_ignored;
use super::run_summary;
use super::summary::{self, TrackScore};
use super::{TruthError, counted};

/// True and found boxes that are judged.
pub struct Comparison<'a> {
    /// The true boxes in the range of analysed frames.
    pub boxes: Boxes,
    /// The found boxes that count.
    pub found: Boxes,
    analysed: &'a AnalysedFrames,
    truth: &'a TrackFile,
    results: &'a TrackFile,
    offset: i64,
}

impl<'a> Comparison<'a> {
    /// The boxes of `results`, which is known of the `analysed` frames, and those of `truth` with `offset` added to its
    /// frame numbers.
    pub fn new(
        truth: &'a TrackFile,
        results: &'a TrackFile,
        analysed: &'a AnalysedFrames,
        offset: i64,
    ) -> Self {
        let mut boxes = shifted(&truth.boxes, offset);
        boxes.retain(|number, _| analysed.covers(*number));
        let found = without_ignored(&boxes, &shifted(&truth.ignored, offset), &results.boxes);
        Self { boxes, found, analysed, truth, results, offset }
    }

    /// The score of the tracks.
    pub fn score(&self) -> TrackScore {
        summary::score_of_frames(&self.boxes, &self.found, |number| self.analysed.contains(number))
    }

    /// The events that lie within the analysed frames, with numbers of these.
    pub fn analysed_events(&self, events: &[ScoredEvent]) -> Vec<ScoredEvent> {
        let moved = events.iter().filter_map(|event| {
            let (start, end) = event.span;
            let span = (shifted_number(start, self.offset)?, shifted_number(end, self.offset)?);
            Some(ScoredEvent { span, ..event.clone() })
        });
        moved
            .filter(|event| self.analysed.covers(event.span.0) && self.analysed.covers(event.span.1))
            .collect()
    }

    /// The offset at which the boxes match better, if there is one.
    pub fn better_offset(&self) -> Option<i64> {
        let truth = shifted(&self.truth.boxes, self.offset);
        let more = alignment::better_offset(&truth, &self.results.boxes, self.analysed.span());
        more.map(|more| self.offset + more)
    }

    /// Whether a true box is in the analysed frames: without, no measure of tracks is defined.
    pub fn has_true_box(&self) -> bool {
        self.boxes.iter().any(|(number, boxes)| !boxes.is_empty() && self.analysed.contains(*number))
    }

    /// Fails if no box of the ground truth, which is in `path`, is in an analysed frame.
    pub fn check_frames(&self, path: &Path) -> Result<(), TruthError> {
        if self.has_true_box() {
            return Ok(());
        }
        let Some((true_first, true_last)) = span(&self.truth.boxes).filter(|_| self.truth.count() > 0) else {
            return Err(self.truth.without_box(path));
        };
        let (first, last) = self.analysed.span();
        if !self.boxes.is_empty() {
            let why = format!(
                "it has no box in the analysed frames, {first} to {last}, so that no measure of tracks is defined; \
                 analyse frames with a true box"
            );
            return Err(TruthError::new(path, why));
        }
        let (offset, reason) = match self.better_offset() {
            Some(offset) => (offset, "where the boxes match"),
            None => (i64::from(first) - i64::from(true_first), "which makes the first numbers equal"),
        };
        let (true_first, true_last) =
            (i64::from(true_first) + self.offset, i64::from(true_last) + self.offset);
        let why = format!(
            "its frames {true_first} to {true_last} are not among those that were analysed, {first} to {last}; analyse \
             these frames, or, if its numbers begin elsewhere, score with --offset {offset}, {reason}"
        );
        Err(TruthError::new(path, why))
    }

    /// What was read of the ground truth and of the results, and what is judged.
    pub fn note(&self) -> String {
        let truth = self.truth;
        let boxes = counted(truth.count(), "box", "boxes");
        let read = format!("{}, {boxes} in {}", truth.format, counted(truth.boxes.len(), "frame", "frames"));
        let remarks = self.results.remarks.iter().map(|remark| format!("of the results, {remark}"));
        let (first, last) = self.analysed.span();
        let frames = counted(self.analysed.count() as usize, "frame is", "frames are");
        let judged = format!("{frames} judged, {first} to {last}");
        let judged = match self.analysed.origin() {
            Origin::Record => judged,
            Origin::RecordBeside => {
                format!("{judged}, those in {} beside the tracks", run_summary::FILE)
            }
            Origin::Length => format!("{judged}, the sequence's seqLength in seqinfo.ini"),
            Origin::Results => {
                format!("{judged}, the first to the last with a result")
            }
            Origin::Unknown => "all frames are judged, as there are no results".to_owned(),
        };
        let numbers = truth.boxes.keys().filter_map(|number| shifted_number(*number, self.offset));
        let left_out = numbers.filter(|number| !self.analysed.contains(*number)).count();
        let left_out = (left_out > 0).then(|| {
            counted(
                left_out,
                "frame of the ground truth that was not analysed is left out",
                "frames of the ground truth that were not analysed are left out",
            )
        });
        let undefined = (!self.has_true_box())
            .then(|| "no box is in them, so that no measure of tracks is defined".to_owned());
        let clauses = iter::once(read).chain(truth.remarks.iter().cloned()).chain(remarks);
        clauses.chain([judged]).chain(undefined).chain(left_out).collect::<Vec<_>>().join("; ")
    }
}
