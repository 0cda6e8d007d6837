//! The ground truth of a sequence as files, and all scores that it permits.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::analysed_frames::{AnalysedFrames, Origin};
use super::boxes::shifted_number;
use super::comparison::Comparison;
use super::event_scoring::{self, EventScore, ScoredEvent};
use super::formats::TrackFile;
use super::mask_score::MaskScore;
use super::masks::MaskFiles;
use super::measures::Measures;
use super::meetings::{self, MeetingScore};
use super::summary::TrackScore;
use super::{TruthError, TruthSource, counted, ignored};
use crate::placement::Crop;
use crate::source::sequence_length;

/// Largest deviation in frames of events and of the ends of episodes.
pub const EVENT_TOLERANCE: u32 = 8;

/// The files of events and episodes.
const EVENTS: &str = "events.jsonl";
const EPISODES: &str = "episodes.csv";

/// Events and episodes, true or reported.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Occlusions {
    /// The events.
    pub events: Vec<ScoredEvent>,
    /// The occlusion episodes.
    pub episodes: Vec<ScoredEvent>,
}

impl Occlusions {
    /// Whether both files are in a folder.
    pub fn are_in(folder: &Path) -> bool {
        [EVENTS, EPISODES].iter().all(|name| folder.join(name).is_file())
    }

    /// Reads `events.jsonl` and `episodes.csv` of a folder.
    pub fn read(folder: &Path) -> Result<Self, TruthError> {
        Ok(Self {
            events: event_scoring::read_events(&folder.join(EVENTS))?,
            episodes: event_scoring::read_episodes(&folder.join(EPISODES))?,
        })
    }
}

/// The ground truth of a sequence: tracks, masks, or both.
pub struct SequenceTruth {
    /// Its path.
    pub path: PathBuf,
    /// The true tracks, in their own frame numbers.
    pub tracks: Option<TrackFile>,
    /// The files of the true masks, in the frame numbers of the results.
    pub masks: Option<MaskFiles>,
    /// Whether it is a scene written by `synth`.
    pub is_scene: bool,
    /// The true events and episodes, in their own frame numbers.
    pub occlusions: Option<Occlusions>,
    /// What is added to its frame numbers.
    pub offset: i64,
    /// The number of frames of the sequence, where it is stated.
    pub length: Option<u32>,
}

impl SequenceTruth {
    /// Reads the ground truth at `path`, of any kind of [`TruthSource`], except its masks. `offset` is added to its frame
    /// numbers.
    pub fn read(path: &Path, offset: i64) -> Result<Self, TruthError> {
        let source = TruthSource::of(path)?;
        let occlusions = match &source {
            TruthSource::Scene(folder) if folder.join("events.jsonl").is_file() => {
                Some(Occlusions::read(folder)?)
            }
            _ => None,
        };
        let tracks = source.tracks()?;
        if let (TruthSource::Boxes(_), Some(tracks)) = (&source, &tracks)
            && tracks.count() == 0
        {
            return Err(tracks.without_box(path));
        }
        Ok(Self {
            path: path.to_owned(),
            tracks,
            masks: source.masks()?.map(|masks| masks.shifted(offset)),
            is_scene: matches!(source, TruthSource::Scene(_)),
            occlusions,
            offset,
            length: length_of(path),
        })
    }

    /// All frames of the sequence in the numbers of the results, where their number is stated.
    pub fn frames(&self) -> Option<AnalysedFrames> {
        let number = |number| shifted_number(number, self.offset);
        let frames = AnalysedFrames::at_steps(number(1)?, number(self.length?)?, 1)?;
        Some(frames.known_by(Origin::Length))
    }

    /// The ground truth of a part of the images, as [`ignored::crop`] cuts boxes; pixels outside do not count. Events and
    /// episodes, which are those of whole images, are left out.
    #[must_use]
    pub fn within(mut self, part: Crop) -> Self {
        if let Some(tracks) = &mut self.tracks {
            let left_out = ignored::crop(&mut tracks.boxes, &mut tracks.ignored, &part);
            let occlusions = if self.occlusions.is_some() { ", and all events and episodes," } else { "" };
            let boxes = counted(left_out, "box", "boxes");
            let are = if left_out == 1 && occlusions.is_empty() { "is" } else { "are" };
            tracks.remarks.push(format!("{boxes} outside the crop {part}{occlusions} {are} left out"));
        }
        self.masks = self.masks.map(|masks| masks.within(part));
        self.occlusions = None;
        self
    }
}

/// The number of frames that MOTChallenge's `seqinfo.ini` states of the sequence with the ground truth at `path`: its folder,
/// the folder `gt` in it, or a file in either.
fn length_of(path: &Path) -> Option<u32> {
    let path = path.canonicalize().ok()?;
    let folder = if path.is_file() { path.parent()? } else { &path };
    sequence_length(if folder.ends_with("gt") { folder.parent()? } else { folder })
}

/// All scores that the ground truth permits.
#[derive(Default, Serialize)]
pub struct Scores {
    /// Of the tracks.
    #[serde(flatten)]
    pub tracks: Option<TrackScore>,
    /// Of the events by kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events: Option<BTreeMap<String, EventScore>>,
    /// Of the occlusion episodes by kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub episodes: Option<BTreeMap<String, EventScore>>,
    /// Of the occlusion episodes of several objects, where the truth has boxes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meetings: Option<MeetingScore>,
    /// Of the masks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub masks: Option<MaskScore>,
}

impl Scores {
    /// Scores the tracks, where a true box is judged, and the reported events and episodes: against those of a scene, or, of
    /// other ground truth, the episodes against the true boxes.
    pub fn add_tracks(
        &mut self,
        comparison: &Comparison<'_>,
        truth: &SequenceTruth,
        reported: Option<&Occlusions>,
    ) {
        let people = || event_scoring::people(&comparison.boxes, &comparison.found);
        if let Some(reported) = reported.filter(|_| !truth.is_scene && comparison.has_true_box()) {
            self.meetings =
                Some(meetings::score(&comparison.boxes, &reported.episodes, &people(), EVENT_TOLERANCE));
        }
        if let Some((truth, reported)) = truth.occlusions.as_ref().zip(reported) {
            let people = people();
            let compare = |truth: &[ScoredEvent], reported: &[ScoredEvent]| {
                let truth = comparison.analysed_events(truth);
                event_scoring::compare(&truth, reported, &people, EVENT_TOLERANCE)
            };
            self.events = Some(compare(&truth.events, &reported.events));
            self.episodes = Some(compare(&truth.episodes, &reported.episodes));
        }
        self.tracks = comparison.has_true_box().then(|| comparison.score());
    }

    /// The main results under short names.
    pub fn measures(&self) -> Measures {
        Measures {
            masks: self.masks.as_ref().map(Into::into),
            tracks: self.tracks.as_ref().map(Into::into),
            episodes: self.episodes.as_ref().map(Into::into).or(self.meetings.as_ref().map(Into::into)),
        }
    }
}
