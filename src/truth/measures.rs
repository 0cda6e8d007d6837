//! The measures of a sequence under short names: keys of `score --json`, and columns of tables.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::event_scoring::{self, EventScore};
use super::hota::Hota;
use super::mask_measures::MaskMeasures;
use super::meetings::MeetingScore;
use super::summary::TrackScore;

/// A measure as a column of a table.
#[derive(Clone, Copy, Debug)]
pub struct MeasureColumn {
    /// Its name in tables and as a key.
    pub name: &'static str,
    /// Its name on the screen.
    pub label: &'static str,
    /// Its meaning, a sentence.
    pub meaning: &'static str,
    /// Whether a greater value is better.
    pub more_is_better: bool,
    /// Its value, if the ground truth permits it.
    pub of: fn(&Measures) -> Option<f64>,
}

impl MeasureColumn {
    /// Whether a value is better than another.
    pub fn is_better(&self, value: f64, other: f64) -> bool {
        if self.more_is_better { value > other } else { value < other }
    }

    /// Number of decimals on the screen; a mean of counts has one, a whole count none.
    pub fn decimals(&self) -> usize {
        match self.name {
            "switches" => 1,
            "pwc" => 2,
            _ => 3,
        }
    }

    /// A value on the screen.
    pub fn text(&self, value: f64) -> String {
        let decimals = if self.decimals() == 1 && value.fract() == 0.0 { 0 } else { self.decimals() };
        format!("{value:.decimals$}").replace('-', "−")
    }
}

/// The measure by which combinations of settings are ranked where none is chosen: the mean of F and HOTA, or the one of
/// them that the ground truth permits.
pub static OBJECTIVE: MeasureColumn = MeasureColumn {
    name: "score",
    label: "score",
    meaning: "Mean of F and HOTA, or the one of them that the ground truth permits",
    more_is_better: true,
    of: |measures| match (measures.masks, measures.tracks) {
        (Some(masks), Some(tracks)) => Some(f64::midpoint(masks.f, tracks.hota.hota)),
        (Some(masks), None) => Some(masks.f),
        (None, Some(tracks)) => Some(tracks.hota.hota),
        (None, None) => None,
    },
};

/// Whether a measure has this name.
pub fn is_name(name: &str) -> bool {
    name == OBJECTIVE.name || column(name).is_some()
}

/// The column of this name.
pub fn column(name: &str) -> Option<&'static MeasureColumn> {
    COLUMNS.iter().find(|column| column.name == name)
}

/// The names of CDnet's measures of masks, the first of [`COLUMNS`].
pub const OF_MASKS: [&str; 7] = ["f", "precision", "recall", "pwc", "specificity", "fpr", "fnr"];

/// The measures of tables, in their order.
pub static COLUMNS: [MeasureColumn; 13] = [
    MeasureColumn {
        name: "f",
        label: "F",
        meaning: "Harmonic mean of precision and recall of the masks",
        more_is_better: true,
        of: |measures| Some(measures.masks?.f),
    },
    MeasureColumn {
        name: "precision",
        label: "precision",
        meaning: "Share of true foreground in the foreground of the masks",
        more_is_better: true,
        of: |measures| Some(measures.masks?.precision),
    },
    MeasureColumn {
        name: "recall",
        label: "recall",
        meaning: "Share of the true foreground that the masks have",
        more_is_better: true,
        of: |measures| Some(measures.masks?.recall),
    },
    MeasureColumn {
        name: "pwc",
        label: "PWC",
        meaning: "Percentage of wrong classifications of the masks",
        more_is_better: false,
        of: |measures| Some(measures.masks?.pwc),
    },
    MeasureColumn {
        name: "specificity",
        label: "specificity",
        meaning: "Share of the true background that the masks leave out",
        more_is_better: true,
        of: |measures| known(measures.masks?.specificity),
    },
    MeasureColumn {
        name: "fpr",
        label: "FPR",
        meaning: "False positive rate: share of the true background that the masks have",
        more_is_better: false,
        of: |measures| known(measures.masks?.fpr),
    },
    MeasureColumn {
        name: "fnr",
        label: "FNR",
        meaning: "False negative rate: share of the true foreground that the masks leave out",
        more_is_better: false,
        of: |measures| known(measures.masks?.fnr),
    },
    MeasureColumn {
        name: "mota",
        label: "MOTA",
        meaning: "CLEAR-MOT's accuracy of the tracks, boxes matched from an IoU of 0.5 on",
        more_is_better: true,
        of: |measures| Some(measures.tracks?.mota),
    },
    MeasureColumn {
        name: "idf1",
        label: "IDF1",
        meaning: "Harmonic mean of identity precision and recall, from an IoU of 0.5 on",
        more_is_better: true,
        of: |measures| Some(measures.tracks?.idf1),
    },
    MeasureColumn {
        name: "hota",
        label: "HOTA",
        meaning: "Geometric mean of detection and association accuracy, over 19 thresholds of IoU",
        more_is_better: true,
        of: |measures| Some(measures.tracks?.hota.hota),
    },
    MeasureColumn {
        name: "switches",
        label: "ID switches",
        meaning: "Number of identity switches",
        more_is_better: false,
        of: |measures| Some(measures.tracks?.switches as f64),
    },
    MeasureColumn {
        name: "episode_recall",
        label: "episode recall",
        meaning: "Share of the true occlusion episodes that are reported",
        more_is_better: true,
        of: |measures| Some(measures.episodes?.episode_recall),
    },
    MeasureColumn {
        name: "episode_precision",
        label: "episode precision",
        meaning: "Share of the reported occlusion episodes that are true",
        more_is_better: true,
        of: |measures| Some(measures.episodes?.episode_precision),
    },
];

/// A value that a table can lack: NaN is none.
fn known(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// The measures that the ground truth permits, each serialised under its own name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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

impl Measures {
    /// Whether every value is one that the measure can have, which a file can violate.
    pub fn is_possible(&self) -> bool {
        const ROUNDING: f64 = 1e-9;
        let is_share = |share: f64| (-ROUNDING..=1.0 + ROUNDING).contains(&share);
        let of_masks = self.masks.is_none_or(|masks| {
            let MaskMeasures { f, precision, recall, pwc, specificity, fpr, fnr } = masks;
            [f, precision, recall, pwc / 100.0, specificity, fpr, fnr].into_iter().all(is_share)
        });
        let of_tracks =
            self.tracks.is_none_or(|TrackMeasures { mota, idf1, hota, identities_kept, .. }| {
                let Hota { hota, deta, assa, loca } = hota;
                mota.is_finite()
                    && mota <= 1.0 + ROUNDING
                    && [idf1, hota, deta, assa, loca].into_iter().chain(identities_kept).all(is_share)
            });
        let of_episodes =
            self.episodes.is_none_or(|EpisodeMeasures { episode_recall, episode_precision }| {
                is_share(episode_recall) && is_share(episode_precision)
            });
        of_masks && of_tracks && of_episodes
    }

    /// Whether tracks were scored. Those of a scene without objects have no measure, but its episodes do.
    pub fn are_of_tracks(&self) -> bool {
        self.tracks.is_some() || self.episodes.is_some()
    }

    /// Whether they are those that ground truth with masks, with boxes or with both permits.
    pub fn is_of(&self, masks: bool, boxes: bool) -> bool {
        self.masks.is_some() == masks && self.tracks.is_some() == boxes
    }
}

/// The measures of tracks. CLEAR-MOT and IDF1 are those of matches from an IoU of 0.5 on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeMeasures {
    /// The share of the true episodes that are reported; 1 if there is none.
    pub episode_recall: f64,
    /// The share of the reported episodes that are true; 1 if none was reported.
    pub episode_precision: f64,
}

impl From<&MeetingScore> for EpisodeMeasures {
    fn from(score: &MeetingScore) -> Self {
        Self { episode_recall: score.recall, episode_precision: score.precision }
    }
}

impl From<&BTreeMap<String, EventScore>> for EpisodeMeasures {
    fn from(kinds: &BTreeMap<String, EventScore>) -> Self {
        let EventScore { recall, precision, .. } = event_scoring::total(kinds);
        Self { episode_recall: recall, episode_precision: precision }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_measures_of_masks_come_first() {
        let masks = MaskMeasures { fpr: f64::NAN, ..MaskMeasures::default() };
        let measures = Measures { masks: Some(masks), ..Measures::default() };
        assert_eq!(COLUMNS.iter().map(|column| column.name).collect::<Vec<_>>()[..7], OF_MASKS);
        let known = COLUMNS.iter().filter(|column| (column.of)(&measures).is_some());
        let known: Vec<_> = known.map(|column| column.name).collect();
        assert_eq!(known, ["f", "precision", "recall", "pwc", "specificity", "fnr"]);
    }

    #[test]
    fn a_value_has_the_digits_of_its_measure() {
        for (name, value, text) in [
            ("f", 0.812_49, "0.812"),
            ("mota", -0.25, "−0.250"),
            ("pwc", 3.456, "3.46"),
            ("switches", 12.0, "12"),
            ("switches", 12.25, "12.2"),
        ] {
            assert_eq!(column(name).unwrap().text(value), text, "{name}");
        }
    }
}
