//! Scores events and occlusion episodes against the truth of a rendered scene by kind, time and members.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use csv::StringRecord;
use serde::{Deserialize, Serialize};

use super::TruthError;
use super::boxes::Boxes;
use super::share::share_or_one;

/// Least IoU at which a reported box belongs to a true object.
const MIN_IOU: f64 = 0.5;

/// An event or episode, reported or true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScoredEvent {
    /// The kind of event or episode.
    pub kind: String,
    /// The identities of the members, in ascending order.
    pub objects: Vec<u32>,
    /// The first and last frame; an event has one.
    pub span: (u32, u32),
}

/// The score of the events of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EventScore {
    /// Number of true events.
    pub truth: usize,
    /// Number of reported events.
    pub reported: usize,
    /// Number of matches; each event is matched at most once.
    pub matched: usize,
    /// matched / reported; 1 if none was reported.
    pub precision: f64,
    /// matched / truth; 1 if there is none.
    pub recall: f64,
}

impl EventScore {
    fn new(truth: usize, reported: usize, matched: usize) -> Self {
        Self {
            truth,
            reported,
            matched,
            precision: share_or_one(matched as u64, reported as u64),
            recall: share_or_one(matched as u64, truth as u64),
        }
    }
}

/// The score of the events of all kinds together.
pub fn total(kinds: &BTreeMap<String, EventScore>) -> EventScore {
    let sum = |count: fn(&EventScore) -> usize| kinds.values().map(count).sum();
    EventScore::new(sum(|kind| kind.truth), sum(|kind| kind.reported), sum(|kind| kind.matched))
}

/// Reads `events.jsonl`.
pub fn read_events(path: &Path) -> Result<Vec<ScoredEvent>, TruthError> {
    #[derive(Deserialize)]
    struct Line {
        frame: u32,
        kind: String,
        objects: Vec<u32>,
    }
    let text = fs::read_to_string(path).map_err(|error| TruthError::unreadable(path, error))?;
    let line = |(line, number): (&str, usize)| {
        let Line { frame, kind, mut objects } = serde_json::from_str(line)
            .map_err(|error| TruthError::new(path, format!("line {number} is not an event ({error})")))?;
        objects.sort_unstable();
        Ok(ScoredEvent { kind, objects, span: (frame, frame) })
    };
    text.lines().zip(1..).filter(|(line, _)| !line.trim().is_empty()).map(line).collect()
}

/// Reads `episodes.csv`.
pub fn read_episodes(path: &Path) -> Result<Vec<ScoredEvent>, TruthError> {
    #[derive(Deserialize)]
    struct Row {
        kind: String,
        objects: String,
        start: u32,
        end: u32,
    }
    let text = fs::read(path).map_err(|error| TruthError::unreadable(path, error))?;
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(text.as_slice());
    let episode = |row: &StringRecord, headers: &StringRecord| {
        let Row { kind, objects, start, end } = row.deserialize(Some(headers)).ok()?;
        let mut objects = objects.split('+').map(|id| id.parse().ok()).collect::<Option<Vec<u32>>>()?;
        objects.sort_unstable();
        Some(ScoredEvent { kind, objects, span: (start, end) })
    };
    // The position of a row is before the empty lines above it.
    let line_at = |byte: usize| {
        let empty = text[byte..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        text[..byte + empty].split(|&byte| byte == b'\n').count()
    };
    let refused = |line: usize| {
        let why = "is not an episode; expected numbers under the header kind,objects,start,end, as in inter-object,1+2,10,20";
        TruthError::new(path, format!("line {line} {why}"))
    };
    let headers = reader.headers().map_err(|_| refused(1))?.clone();
    let rows = reader.records().zip(2..).map(|(row, count)| {
        let row = row.map_err(|_| refused(count))?;
        let line = row.position().map_or(count, |position| line_at(position.byte() as usize));
        episode(&row, &headers).ok_or_else(|| refused(line))
    });
    rows.collect()
}

/// The person that each identity matches most often; 0 if none.
pub fn people(truth: &Boxes, found: &Boxes) -> BTreeMap<u32, u32> {
    let mut counts: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
    for (frame, found_boxes) in found {
        let Some(true_boxes) = truth.get(frame) else { continue };
        for (identity, place) in found_boxes {
            let best = true_boxes.iter().map(|(person, true_place)| (place.iou(true_place), person));
            if let Some((iou, person)) = best.max_by(|a, b| a.0.total_cmp(&b.0))
                && iou >= MIN_IOU
            {
                *counts.entry(*identity).or_default().entry(*person).or_default() += 1;
            }
        }
    }
    let most = |people: BTreeMap<u32, usize>| {
        people.into_iter().max_by_key(|(_, count)| *count).map(|(person, _)| person)
    };
    counts.into_iter().filter_map(|(identity, people)| Some((identity, most(people)?))).collect()
}

/// Matches events of the same kind with the same people whose ends are all within `tolerance` frames. `people` maps
/// the identities in `reported` to people.
pub fn compare(
    truth: &[ScoredEvent],
    reported: &[ScoredEvent],
    people: &BTreeMap<u32, u32>,
    tolerance: u32,
) -> BTreeMap<String, EventScore> {
    let named = |event: &ScoredEvent| {
        let mut objects: Vec<_> =
            event.objects.iter().map(|id| people.get(id).copied().unwrap_or(0)).collect();
        objects.sort_unstable();
        ScoredEvent { objects, ..event.clone() }
    };
    let mut open: Vec<ScoredEvent> = reported.iter().map(named).collect();
    let kinds: BTreeSet<&String> = truth.iter().chain(reported).map(|it| &it.kind).collect();
    let mut all: BTreeMap<String, EventScore> =
        kinds.into_iter().map(|kind| (kind.clone(), EventScore::default())).collect();
    for it in reported {
        all.entry(it.kind.clone()).or_default().reported += 1;
    }
    for it in truth {
        let found = all.entry(it.kind.clone()).or_default();
        found.truth += 1;
        let off =
            |other: &ScoredEvent| it.span.0.abs_diff(other.span.0).max(it.span.1.abs_diff(other.span.1));
        let same = |other: &&(usize, &ScoredEvent)| other.1.kind == it.kind && other.1.objects == it.objects;
        let nearest =
            open.iter().enumerate().filter(|other| same(&other)).min_by_key(|(_, other)| off(other));
        if let Some((at, other)) = nearest
            && off(other) <= tolerance
        {
            found.matched += 1;
            open.remove(at);
        }
    }
    for found in all.values_mut() {
        *found = EventScore::new(found.truth, found.reported, found.matched);
    }
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn merge(objects: &[u32], frame: u32) -> ScoredEvent {
        ScoredEvent { kind: "merge".into(), objects: objects.to_vec(), span: (frame, frame) }
    }

    #[test]
    fn events_match_once_by_time_and_people() {
        let people = BTreeMap::from([(11, 1), (12, 2), (13, 3)]);
        let truth = [merge(&[1, 2], 100), merge(&[1, 2], 200), merge(&[2, 3], 300)];
        // A match; a duplicate; too late; other people.
        let reported =
            [merge(&[12, 11], 104), merge(&[11, 12], 96), merge(&[11, 12], 209), merge(&[11, 13], 300)];
        let score = &compare(&truth, &reported, &people, 8)["merge"];
        assert_eq!((score.truth, score.reported, score.matched), (3, 4, 1));
        assert_eq!((score.precision, score.recall), (0.25, 1.0 / 3.0));
        let nothing = &compare(&[], &reported, &people, 8)["merge"];
        assert_eq!((nothing.precision, nothing.recall), (0.0, 1.0));
    }

    #[test]
    fn an_episode_that_cannot_be_read_is_told_with_its_line() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let read = |text: &[u8]| {
            fs::write(&file, text).unwrap();
            read_episodes(file.path()).map_err(|error| error.to_string())
        };
        let episodes = read(b"kind,objects,start,end,front\n\ninter-object,2+1,3,9,\n").unwrap();
        let expected = ScoredEvent { kind: "inter-object".into(), objects: vec![1, 2], span: (3, 9) };
        assert_eq!(episodes, [expected]);
        for (text, line) in [
            (&b"kind,objects,start,end\ninter-object,1+2,3,9\ninter-object,1+b,3,9\n"[..], "line 3"),
            (b"kind,objects,start,end\ninter-object,1+2,3\n", "line 2"),
            (b"kind,objects\n\ninter-object,1+2\n", "line 3"),
            (b"kind,objects,start,end\n\xff,1,3,9\n", "line 2"),
        ] {
            let why = read(text).unwrap_err();
            assert!(
                why.contains(line) && why.contains("kind,objects,start,end") && !why.contains("CSV"),
                "{why}"
            );
        }
    }

    #[test]
    fn the_total_of_all_kinds_is_that_of_their_counts() {
        let kinds = [("merge", EventScore::new(4, 1, 1)), ("enter", EventScore::new(0, 3, 0))];
        let total = total(&kinds.map(|(kind, score)| (kind.to_owned(), score)).into());
        assert_eq!((total.truth, total.reported, total.matched), (4, 4, 1));
        assert_eq!((total.precision, total.recall), (0.25, 0.25));
        assert_eq!(
            (super::total(&BTreeMap::new()).precision, super::total(&BTreeMap::new()).recall),
            (1.0, 1.0)
        );
    }

    #[test]
    fn an_event_of_others_or_too_far_away_does_not_match() {
        let people = BTreeMap::from([(11, 1), (12, 2), (13, 3)]);
        let matched = |objects: &[u32], frame: u32| {
            compare(&[merge(&[1, 2], 100)], &[merge(objects, frame)], &people, 8)["merge"].matched
        };
        assert_eq!([matched(&[11, 12], 108), matched(&[11, 12], 109), matched(&[11, 13], 100)], [1, 0, 0]);
    }
}
