//! All that truth tells about an analysis.

use std::collections::BTreeMap;

use serde::Serialize;

use super::boxes::{Bounds, Boxes};
use super::clear_mot::{self, ClearMot};
use super::mask_score::MaskScore;
use super::survival::{self, Survival};
use crate::pipeline::OfflineResult;

/// How right tracks are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackScore {
    /// Where a box is on an object from an IoU of 0.5 on.
    #[serde(rename = "iou0.5")]
    pub strict: ClearMot,
    /// Where it is from 0.3 on.
    #[serde(rename = "iou0.3")]
    pub loose: ClearMot,
    /// What became of the identities of those who met.
    pub occlusion: Survival,
}

/// How right an analysis is, as far as there is truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// By boxes.
    pub tracks: Option<TrackScore>,
    /// By masks: of all frames of which there is a true one.
    pub masks: Option<MaskScore>,
}

/// Scores `found` against `truth`.
pub fn score(truth: &Boxes, found: &Boxes) -> TrackScore {
    TrackScore {
        strict: clear_mot::score(truth, found, 0.5),
        loose: clear_mot::score(truth, found, 0.3),
        occlusion: survival::score(truth, found),
    }
}

/// The boxes of a reading, as its file of tracks holds them.
pub fn boxes_of(reading: &OfflineResult) -> Boxes {
    let mut boxes = Boxes::new();
    for (number, tracks) in &reading.tracks {
        let of_frame: BTreeMap<_, _> = tracks
            .iter()
            .map(|track| {
                let bbox = track.bbox;
                (track.id, Bounds([bbox.x, bbox.y, bbox.w, bbox.h].map(f64::from)))
            })
            .collect();
        if !of_frame.is_empty() {
            boxes.insert(*number, of_frame);
        }
    }
    boxes
}
