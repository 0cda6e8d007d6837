//! The number of identities that survive occlusion.
//!
//! An episode is a sequence of frames in which two true boxes overlap by at least 15 % of the smaller one (gaps up to
//! 5 frames closed), at least 3 frames long, with both objects in the truth within the 10 frames before and after. An
//! identity survives if it matches the same object most often in the 10 frames before and after, and only that
//! object.

use std::collections::BTreeMap;
use std::ops::Bound;

use serde::Serialize;

use super::boxes::{Bounds, Boxes};

/// Least overlap of two boxes as a share of the smaller one.
const MIN_OVERLAP_SHARE: f64 = 0.15;
/// Least distance in frames of two episodes of the same pair.
const MIN_GAP_FRAMES: u32 = 7;
/// Least length of an episode in frames.
const MIN_EPISODE_FRAMES: u32 = 3;
/// Number of frames before and after an episode in which identities are compared.
const FRAMES_AROUND_EPISODE: u32 = 10;
/// Least IoU of a match.
const MIN_IOU: f64 = 0.3;

/// The survival of the identities of overlapping objects.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Survival {
    /// Number of episodes.
    pub episodes: usize,
    /// Number of identities in them, two per episode.
    pub identities: usize,
    /// Number of identities that were the same before and after.
    pub survived: usize,
    /// survived / identities; `None` without episodes.
    pub survival: Option<f64>,
}

/// The episodes of true boxes: two objects, in ascending order, and the first and last frame.
pub(super) fn meetings(truth: &Boxes) -> Vec<([u32; 2], (u32, u32))> {
    let mut objects: BTreeMap<u32, BTreeMap<u32, Bounds>> = BTreeMap::new();
    for (frame, boxes) in truth {
        for (id, place) in boxes {
            objects.entry(*id).or_default().insert(*frame, *place);
        }
    }
    let mut meetings = Vec::new();
    for (a, boxes_a) in &objects {
        for (b, boxes_b) in objects.range((Bound::Excluded(*a), Bound::Unbounded)) {
            meetings.extend(episodes(boxes_a, boxes_b).into_iter().map(|span| ([*a, *b], span)));
        }
    }
    meetings
}

/// Whether two boxes overlap by so much that their objects meet.
pub(super) fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a.shared(b) >= MIN_OVERLAP_SHARE * a.area().min(b.area())
}

/// Scores `found` against `truth`.
pub fn score(truth: &Boxes, found: &Boxes) -> Survival {
    let identities = matched_identities(truth, found);
    let mut survival = Survival::default();
    for (objects, (start, end)) in meetings(truth) {
        survival.episodes += 1;
        survival.identities += 2;
        let most = |object: u32, from: u32, to: u32| most_frequent(&identities, object, from, to);
        let before = objects.map(|id| most(id, start.saturating_sub(FRAMES_AROUND_EPISODE), start));
        let after =
            objects.map(|id| most(id, end.saturating_add(1), end.saturating_add(1 + FRAMES_AROUND_EPISODE)));
        for (object, other) in [(0, 1), (1, 0)] {
            let is_kept = before[object].is_some() && before[object] == after[object];
            let is_distinct = before[object] != before[other] && after[object] != after[other];
            survival.survived += usize::from(is_kept && is_distinct);
        }
    }
    survival.survival =
        (survival.identities > 0).then(|| survival.survived as f64 / survival.identities as f64);
    survival
}

fn episodes(a: &BTreeMap<u32, Bounds>, b: &BTreeMap<u32, Bounds>) -> Vec<(u32, u32)> {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for (&frame, box_a) in a {
        let Some(box_b) = b.get(&frame) else { continue };
        if !overlap(box_a, box_b) {
            continue;
        }
        match runs.last_mut() {
            Some((_, end)) if frame - *end < MIN_GAP_FRAMES => *end = frame,
            _ => runs.push((frame, frame)),
        }
    }
    let both_within = |from: u32, to: u32| [a, b].iter().all(|boxes| boxes.range(from..to).next().is_some());
    runs.retain(|&(start, end)| {
        end - start + 1 >= MIN_EPISODE_FRAMES
            && both_within(start.saturating_sub(FRAMES_AROUND_EPISODE), start)
            && both_within(end.saturating_add(1), end.saturating_add(1 + FRAMES_AROUND_EPISODE))
    });
    runs
}

/// The identity of each true object in each frame, from the pairs of largest IoU first.
fn matched_identities(truth: &Boxes, found: &Boxes) -> BTreeMap<(u32, u32), u32> {
    let mut identities = BTreeMap::new();
    for (frame, true_boxes) in truth {
        let Some(found_boxes) = found.get(frame) else { continue };
        let mut pairs: Vec<(f64, u32, u32)> = Vec::new();
        for (object, a) in true_boxes {
            pairs.extend(found_boxes.iter().map(|(identity, b)| (a.iou(b), *object, *identity)));
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((b.1, b.2).cmp(&(a.1, a.2))));
        let mut taken = Vec::new();
        for (iou, object, identity) in pairs {
            if iou >= MIN_IOU && !identities.contains_key(&(*frame, object)) && !taken.contains(&identity) {
                identities.insert((*frame, object), identity);
                taken.push(identity);
            }
        }
    }
    identities
}

/// The identity that matches an object most often in frames `from..to`, the earlier one on a tie.
fn most_frequent(identities: &BTreeMap<(u32, u32), u32>, object: u32, from: u32, to: u32) -> Option<u32> {
    let mut counts: Vec<(u32, usize)> = Vec::new();
    for identity in (from..to).filter_map(|frame| identities.get(&(frame, object))) {
        match counts.iter_mut().find(|(known, _)| known == identity) {
            Some((_, count)) => *count += 1,
            None => counts.push((*identity, 1)),
        }
    }
    let most = counts.iter().map(|(_, count)| *count).max()?;
    counts.into_iter().find(|(_, count)| *count == most).map(|(identity, _)| identity)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two objects that cross in 40 frames, and their identities before and after frame 20.
    fn crossing(names: [[u32; 2]; 2]) -> (Boxes, Boxes) {
        let (mut truth, mut found) = (Boxes::new(), Boxes::new());
        for frame in 1..=40_u32 {
            let half = usize::from(frame > 20);
            for (object, x) in [(1, f64::from(frame) * 2.0), (2, 80.0 - f64::from(frame) * 2.0)] {
                let place = Bounds([x, 0.0, 10.0, 20.0]);
                truth.entry(frame).or_default().insert(object, place);
                found.entry(frame).or_default().insert(names[object as usize - 1][half], place);
            }
        }
        (truth, found)
    }

    #[test]
    fn an_identity_that_stays_with_its_object_survives() {
        for (names, survived) in [([[5, 5], [6, 6]], 2), ([[5, 6], [6, 5]], 0), ([[5, 5], [6, 7]], 1)] {
            let (truth, found) = crossing(names);
            let score = score(&truth, &found);
            assert_eq!((score.episodes, score.identities, score.survived), (1, 2, survived), "{names:?}");
        }
    }

    #[test]
    fn an_identity_that_is_lost_or_switched_does_not_survive() {
        let (truth, mut found) = crossing([[5, 5], [6, 6]]);
        for boxes in found.range_mut(21..).map(|(_, boxes)| boxes) {
            boxes.remove(&6);
        }
        assert_eq!(score(&truth, &found).survived, 1);
        let (truth, found) = crossing([[5, 7], [6, 5]]);
        assert_eq!(score(&truth, &found).survived, 0);
        assert_eq!(score(&Boxes::new(), &found), Survival::default());
    }

    /// The episodes of an object in frames 1 to 60 and another one in these frames, which overlaps with it in some of
    /// them by `columns` of its ten.
    fn episodes_of(
        frames: impl Iterator<Item = u32>,
        overlaps: impl Fn(u32) -> bool,
        columns: f64,
    ) -> Vec<(u32, u32)> {
        let place = |x: f64| Bounds([x, 0.0, 10.0, 20.0]);
        let one = (1..=60).map(|frame| (frame, place(0.0))).collect();
        let x = |frame: u32| if overlaps(frame) { 10.0 - columns } else { 50.0 };
        let other = frames.map(|frame| (frame, place(x(frame)))).collect();
        episodes(&one, &other)
    }

    #[test]
    fn an_episode_is_an_overlap_of_three_frames_between_frames_with_both() {
        let at =
            |frames: std::ops::RangeInclusive<u32>| episodes_of(1..=60, |frame| frames.contains(&frame), 5.0);
        assert_eq!((at(20..=22), at(20..=21)), (vec![(20, 22)], vec![]));
        assert_eq!(episodes_of(1..=60, |frame| (20..30).contains(&frame), 1.5), [(20, 29)]);
        assert_eq!(episodes_of(1..=60, |frame| (20..30).contains(&frame), 1.4), []);
        let twice = |second: u32| {
            episodes_of(
                1..=60,
                |frame| (20..=22).contains(&frame) || (second..second + 3).contains(&frame),
                5.0,
            )
        };
        assert_eq!(twice(28), [(20, 30)]);
        assert_eq!(twice(29), [(20, 22), (29, 31)]);
        // The other one is there in frames 20 to 22, and in one before and one after.
        let around = |before: u32, after: u32| {
            let frames = [before, 20, 21, 22, after].into_iter();
            episodes_of(frames, |frame| (20..=22).contains(&frame), 5.0).len()
        };
        assert_eq!((around(10, 32), around(9, 32), around(10, 33)), (1, 0, 0));
    }

    #[test]
    fn an_identity_is_the_most_frequent_one_and_of_one_object() {
        let identities =
            BTreeMap::from([((1, 7), 5), ((2, 7), 6), ((3, 7), 6), ((4, 7), 5), ((5, 7), 5), ((6, 8), 9)]);
        let most = |from: u32, to: u32| most_frequent(&identities, 7, from, to);
        assert_eq!([most(1, 6), most(2, 5), most(1, 3), most(6, 9)], [Some(5), Some(6), Some(5), None]);
        let place = |x: f64| Bounds([x, 0.0, 10.0, 20.0]);
        let truth = Boxes::from([(3, BTreeMap::from([(1, place(0.0)), (2, place(4.0))]))]);
        let found = |boxes: &[(u32, f64)]| {
            let boxes = boxes.iter().map(|&(identity, x)| (identity, place(x))).collect();
            matched_identities(&truth, &Boxes::from([(3, boxes)]))
        };
        assert_eq!(found(&[(8, 3.0)]), BTreeMap::from([((3, 2), 8)]), "of the nearer one only");
        assert_eq!(found(&[(8, 3.0), (9, 2.0)]), BTreeMap::from([((3, 2), 8), ((3, 1), 9)]));
        assert_eq!(found(&[(8, 10.0)]), BTreeMap::new(), "an IoU of a quarter");
    }

    #[test]
    fn survival_is_the_share_of_the_identities() {
        let (truth, mut found) = crossing([[5, 5], [6, 7]]);
        assert_eq!(score(&truth, &found).survival, Some(0.5));
        assert_eq!(score(&Boxes::new(), &found).survival, None);
        // After the overlap, in frames 19 to 21 or so, the second is found in the last of the ten frames only.
        let [(_, end)] = episodes(&of(&truth, 1), &of(&truth, 2))[..] else { panic!("one episode") };
        for (frame, boxes) in found.range_mut(end + 1..) {
            if let Some(place) = boxes.remove(&7).filter(|_| *frame == end + 10) {
                boxes.insert(6, place);
            }
        }
        assert_eq!(score(&truth, &found).survived, 2);
    }

    /// The boxes of one object by frame.
    fn of(boxes: &Boxes, object: u32) -> BTreeMap<u32, Bounds> {
        boxes.iter().map(|(frame, boxes)| (*frame, boxes[&object])).collect()
    }
}
