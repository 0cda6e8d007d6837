//! The measures of a sequence under short names: keys of `score --json`, and columns of tables.

use std::collections::BTreeMap;

use serde::Serialize;

use super::event_scoring::{self, EventScore};
use super::hota::Hota;
use super::mask_measures::MaskMeasures;
use super::summary::TrackScore;

/// The measures that the ground truth permits, each serialised under its own name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Measures {
    /// Of the masks.
    #[serde(flatten)]
    pub masks: Option<MaskMeasures>,
    /// Of the tracks.
    #[serde(flatten)]
    pub tracks: Option<TrackMeasures>,
    /// Of the occlusion episodes.
    #[serde(flatten)]
    pub episodes: Option<EpisodeMeasures>,
}

/// The measures of tracks. CLEAR-MOT and IDF1 are those of matches from an IoU of 0.5 on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TrackMeasures {
    /// CLEAR-MOT's accuracy.
    pub mota: f64,
    /// The harmonic mean of identity precision and recall.
    pub idf1: f64,
    /// HOTA and its parts.
    #[serde(flatten)]
    pub hota: Hota,
    /// Number of identity switches.
    pub switches: usize,
    /// The share of identities that survive occlusion; `None` where no true boxes overlap.
    pub identities_kept: Option<f64>,
}

impl From<&TrackScore> for TrackMeasures {
    fn from(score: &TrackScore) -> Self {
        Self {
            mota: score.strict.mota,
            idf1: score.strict.idf1,
            hota: score.hota,
            switches: score.strict.num_switches,
            identities_kept: score.occlusion.survival,
        }
    }
}

/// The measures of occlusion episodes of all kinds together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EpisodeMeasures {
    /// The share of the true episodes that are reported; 1 if there is none.
    pub episode_recall: f64,
    /// The share of the reported episodes that are true; 1 if none was reported.
    pub episode_precision: f64,
}

impl From<&BTreeMap<String, EventScore>> for EpisodeMeasures {
    fn from(kinds: &BTreeMap<String, EventScore>) -> Self {
        let EventScore { recall, precision, .. } = event_scoring::total(kinds);
        Self { episode_recall: recall, episode_precision: precision }
    }
}
