//! All scores of an analysis: of its tracks and of its masks.

use std::collections::BTreeMap;

use serde::Serialize;

use super::boxes::{Bounds, Boxes};
use super::clear_mot::{self, ClearMot};
use super::hota::{self, Hota};
use super::mask_score::MaskScore;
use super::survival::{self, Survival};
use crate::export::number::rounded;
use crate::pipeline::OfflineResult;
use crate::tracking::FrameTracks;

/// The scores of tracks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackScore {
    /// Matches from an IoU of 0.5 on.
    #[serde(rename = "iou0.5")]
    pub strict: ClearMot,
    /// Matches from an IoU of 0.3 on.
    #[serde(rename = "iou0.3")]
    pub loose: ClearMot,
    /// The means over 19 least IoUs of a match; serialised among the [`Measures`](super::measures::Measures).
    #[serde(skip)]
    pub hota: Hota,
    /// The survival of identities through occlusion.
    pub occlusion: Survival,
}

/// The scores of an analysis, as far as there is ground truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// The scores of the tracks.
    pub tracks: Option<TrackScore>,
    /// The score of the masks of all frames with a true mask.
    pub masks: Option<MaskScore>,
}

/// Scores `found` against `truth`.
pub fn score(truth: &Boxes, found: &Boxes) -> TrackScore {
    score_with_episodes(truth, found, truth)
}

/// Scores `found`, which is known only of the frames for which `is_analysed` holds: objects in other frames are not
/// missed. Occlusion episodes are those of all frames.
pub fn score_of_frames(truth: &Boxes, found: &Boxes, is_analysed: impl Fn(u32) -> bool) -> TrackScore {
    let analysed = truth.iter().filter(|(number, _)| is_analysed(**number));
    let analysed: Boxes = analysed.map(|(number, boxes)| (*number, boxes.clone())).collect();
    score_with_episodes(&analysed, found, truth)
}

/// Scores `found` against `truth`, and by the occlusion episodes of `whole_truth`.
fn score_with_episodes(truth: &Boxes, found: &Boxes, whole_truth: &Boxes) -> TrackScore {
    TrackScore {
        strict: clear_mot::score(truth, found, 0.5),
        loose: clear_mot::score(truth, found, 0.3),
        hota: hota::score(truth, found),
        occlusion: survival::score(whole_truth, found),
    }
}

/// The boxes of an offline result, as in its file of tracks.
pub fn boxes_of(result: &OfflineResult) -> Boxes {
    let mut boxes = Boxes::new();
    for FrameTracks { number, tracks, .. } in &result.tracks {
        let of_frame: BTreeMap<_, _> = tracks
            .iter()
            .map(|track| {
                let bbox = track.bbox;
                (track.id, Bounds([bbox.x, bbox.y, bbox.w, bbox.h].map(rounded)))
            })
            .collect();
        if !of_frame.is_empty() {
            boxes.insert(*number, of_frame);
        }
    }
    boxes
}
