//! The measures of an outcome.

use super::pass::{Outcome, ScoredKinds};
use crate::export::source_pixels;
use crate::occlusion::{Episode, Event};
use crate::pipeline::OfflineResult;
use crate::placement::Placement;
use crate::truth::TruthError;
use crate::truth::analysed_frames::AnalysedFrames;
use crate::truth::boxes::Boxes;
use crate::truth::comparison::Comparison;
use crate::truth::event_scoring::ScoredEvent;
use crate::truth::formats::TrackFile;
use crate::truth::mask_score::MaskScore;
use crate::truth::measures::Measures;
use crate::truth::sequence_truth::{Occlusions, Scores, SequenceTruth};
use crate::truth::summary;

/// What the ground truth of a sequence permits to score.
pub fn scored_kinds(truth: &SequenceTruth) -> ScoredKinds {
    ScoredKinds {
        masks: truth.masks.is_some(),
        tracks: truth.tracks.is_some(),
        has_box: truth.tracks.as_ref().is_some_and(|tracks| tracks.count() > 0),
    }
}

/// The measures of an outcome over the `analysed` frames, as `score` computes them from the files of `run`. Fails if no
/// frame of the ground truth was analysed, or nothing in these frames is judged.
pub fn measures(
    outcome: &Outcome,
    truth: &SequenceTruth,
    analysed: &AnalysedFrames,
    placement: Option<&Placement>,
) -> Result<Measures, TruthError> {
    let mut scores = Scores::default();
    if let Some(masks) = &truth.masks {
        if outcome.judged_masks == 0 {
            return Err(masks.without_common_frame(&truth.path, analysed.span()));
        }
        masks.check_decisions(outcome.decisions, &truth.path)?;
        scores.masks = Some(MaskScore::new(outcome.judged_masks, outcome.decisions));
    }
    if let (Some(tracks), Some(result)) = (&truth.tracks, &outcome.result) {
        let results = TrackFile { boxes: source_boxes(result, placement), ..TrackFile::default() };
        let comparison = Comparison::new(tracks, &results, analysed, truth.offset);
        if truth.occlusions.is_none() && scores.masks.is_none() {
            comparison.check_frames(&truth.path)?;
        }
        scores.add_tracks(&comparison, truth, Some(&reported_occlusions(result)));
    }
    Ok(scores.measures())
}

/// The offset of the ground truth's frame numbers at which its boxes match better, if there is one.
pub fn better_offset(
    outcome: &Outcome,
    truth: &SequenceTruth,
    analysed: &AnalysedFrames,
    placement: Option<&Placement>,
) -> Option<i64> {
    let (tracks, result) = truth.tracks.as_ref().zip(outcome.result.as_ref())?;
    let results = TrackFile { boxes: source_boxes(result, placement), ..TrackFile::default() };
    Comparison::new(tracks, &results, analysed, truth.offset).better_offset()
}

/// The found boxes in the source's pixels.
pub fn source_boxes(result: &OfflineResult, placement: Option<&Placement>) -> Boxes {
    let Some(placement) = placement else { return summary::boxes_of(result) };
    let mut tracks = result.tracks.clone();
    source_pixels::move_tracks(&mut tracks, placement);
    summary::boxes_of(&OfflineResult { tracks, ..OfflineResult::default() })
}

/// The reported events and episodes.
fn reported_occlusions(result: &OfflineResult) -> Occlusions {
    let scored = |kind: &str, objects: &[u32], span| {
        let mut objects = objects.to_vec();
        objects.sort_unstable();
        ScoredEvent { kind: kind.to_owned(), objects, span }
    };
    let event = |event: &Event| scored(event.kind.name(), &event.objects, (event.frame, event.frame));
    let episode =
        |episode: &Episode| scored(episode.kind.name(), &episode.objects, (episode.start, episode.end));
    Occlusions {
        events: result.events.iter().map(event).collect(),
        episodes: result.episodes.iter().map(episode).collect(),
    }
}
