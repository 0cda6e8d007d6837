//! Scores the reported occlusion episodes of several objects against true boxes, where the true episodes are not known.
//!
//! A true meeting is an overlap of two true boxes as in [`survival`]. It is found if an episode has both among its objects
//! at that time. A reported episode is right if the true box of each of its objects overlaps that of another of them at that
//! time: in a chain of three, the outer two need not overlap. What scenery hides is not in boxes and is not judged.

use std::collections::BTreeMap;

use serde::Serialize;

use super::boxes::Boxes;
use super::event_scoring::ScoredEvent;
use super::share::share_or_one;
use super::survival;

/// The kind of the episodes of several objects.
const INTER_OBJECT: &str = "inter-object";

/// The score of the meetings of true objects.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeetingScore {
    /// Number of true meetings of two objects.
    pub truth: usize,
    /// Number of true meetings that are reported.
    pub found: usize,
    /// found / truth; 1 if there is none.
    pub recall: f64,
    /// Number of reported episodes of several objects.
    pub reported: usize,
    /// Number of reported episodes that are right.
    pub right: usize,
    /// right / reported; 1 if none was reported.
    pub precision: f64,
}

/// Scores the `reported` episodes against the boxes of `truth`. `people` maps reported identities to true objects;
/// `tolerance` is in frames.
pub fn score(
    truth: &Boxes,
    reported: &[ScoredEvent],
    people: &BTreeMap<u32, u32>,
    tolerance: u32,
) -> MeetingScore {
    let widened = |(start, end): (u32, u32)| (start.saturating_sub(tolerance), end.saturating_add(tolerance));
    // The true object of each member, 0 where there is none.
    let episodes: Vec<(Vec<u32>, (u32, u32))> = reported
        .iter()
        .filter(|episode| episode.kind == INTER_OBJECT)
        .map(|episode| {
            let members = episode.objects.iter().map(|id| people.get(id).copied().unwrap_or(0));
            (members.collect(), widened(episode.span))
        })
        .collect();
    let meetings = survival::meetings(truth);
    let is_found = |&([a, b], (start, end)): &([u32; 2], (u32, u32))| {
        episodes.iter().any(|(members, (first, last))| {
            members.contains(&a) && members.contains(&b) && start <= *last && *first <= end
        })
    };
    let overlap = |a: u32, b: u32, (first, last): (u32, u32)| {
        let mut boxes = truth.range(first..=last).map(|(_, boxes)| boxes);
        boxes.any(|boxes| boxes.get(&a).zip(boxes.get(&b)).is_some_and(|(a, b)| survival::overlap(a, b)))
    };
    let is_right = |(members, span): &&(Vec<u32>, (u32, u32))| {
        members.iter().all(|&a| members.iter().any(|&b| a != b && overlap(a, b, *span)))
    };
    let (found, right) =
        (meetings.iter().filter(|it| is_found(it)).count(), episodes.iter().filter(is_right).count());
    MeetingScore {
        truth: meetings.len(),
        found,
        recall: share_or_one(found as u64, meetings.len() as u64),
        reported: episodes.len(),
        right,
        precision: share_or_one(right as u64, episodes.len() as u64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::boxes::Bounds;

    /// Objects 1 and 2 meet about frame 20, 2 and 3 about frame 35, and 4 is alone. 1 comes from 3, with which it is from the
    /// first frame on: that is no meeting.
    fn truth() -> Boxes {
        let place = |x: f64| Bounds([x, 0.0, 10.0, 20.0]);
        let boxes = |frame: u32| {
            let x = f64::from(frame);
            let places = [2.0 * x, 80.0 - 2.0 * x, 80.0 - 2.0 * 35.0, 300.0].map(place);
            (1..).zip(places).collect()
        };
        (1..=60).map(|frame| (frame, boxes(frame))).collect()
    }

    fn episode(objects: &[u32], span: (u32, u32)) -> ScoredEvent {
        ScoredEvent { kind: INTER_OBJECT.to_owned(), objects: objects.to_vec(), span }
    }

    /// True meetings that are found of all, and reported episodes that are right of all.
    fn of(reported: &[ScoredEvent]) -> [usize; 4] {
        let people = [(11, 1), (12, 2), (13, 3), (14, 4), (15, 4)].into();
        let MeetingScore { truth: all, found, reported, right, .. } = score(&truth(), reported, &people, 2);
        [found, all, right, reported]
    }

    #[test]
    fn a_meeting_is_found_by_an_episode_of_both_at_its_time() {
        assert_eq!(of(&[]), [0, 2, 0, 0]);
        assert_eq!(of(&[episode(&[11, 12], (19, 22))]), [1, 2, 1, 1]);
        assert_eq!(of(&[episode(&[11, 12], (26, 27))]), [0, 2, 0, 1], "too late");
        assert_eq!(of(&[episode(&[11, 14], (19, 22))]), [0, 2, 0, 1], "another object");
    }

    #[test]
    fn an_episode_is_right_where_every_member_overlaps_another() {
        assert_eq!(of(&[episode(&[11, 12, 14], (18, 23))])[2..], [0, 1]);
        assert_eq!(of(&[episode(&[12, 13], (33, 37)), episode(&[11, 12], (18, 23))])[2..], [2, 2]);
        // Fragments of one object, and what is no object.
        assert_eq!(of(&[episode(&[14, 15], (18, 23)), episode(&[11, 99], (18, 23))])[2..], [0, 2]);
        let behind_scenery = ScoredEvent { kind: "scene".to_owned(), ..episode(&[11], (5, 9)) };
        assert_eq!(of(&[behind_scenery])[2..], [0, 0]);
    }
}
