//! Events and episodes, derived from the truth of every frame.
//!
//! - A person is *visible* in a frame when at least 5 % of their full silhouette is inside the image and occluders
//!   leave at least 5 % of that part unscreened. `enter` is the first such frame, `exit` the last one; people who are
//!   still inside the image in the last frame have no exit.
//! - `merge` is the first frame in which the unscreened silhouettes of people touch or come within
//!   [`TOUCH_PIXELS`](super::render::TOUCH_PIXELS), so that one region contains them; `demerge` is the first in which
//!   they are separate again. Separations shorter than [`SAME_EPISODE`] belong to the same episode.
//! - `disappear` is the first frame in which the scene occludes a person (less than 5 % of their part inside the
//!   image is unscreened), `reappear` the first in which they are visible again; a visible interval shorter than
//!   [`SAME_EPISODE`] does not count. A person occluded by other people is merged, not disappeared.
//! - A parked car is background, but has not left: it has no events until it exits.

use serde::Serialize;

use super::render::{FrameTruth, Silhouette};
use crate::occlusion::{Episode, EpisodeKind, EventKind};
use crate::tracking::Identity;

/// People who are separate, or visible, for less than this many seconds are still in the same episode.
pub const SAME_EPISODE: f32 = 0.5;

/// A true event; the fields are those of `events.jsonl` without evidence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TruthEvent {
    /// The frame number.
    pub frame: u32,
    /// The kind of the event.
    pub kind: EventKind,
    /// The identities before: the whole group of a merge or demerge, the single one of other events.
    pub objects: Vec<Identity>,
    /// The identities after: the group of a merge, the members that left in a demerge, the one that entered or
    /// reappeared; empty after an exit or a disappearance.
    pub becomes: Vec<Identity>,
    /// The x coordinate of the centre of the bounding box of all members, in pixels.
    pub x: f32,
    /// The y coordinate of that centre, in pixels.
    pub y: f32,
    /// The front member of a merge.
    pub front: Option<Identity>,
}

/// All true events and episodes of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneTruth {
    /// The events by frame, then by kind.
    pub events: Vec<TruthEvent>,
    /// The episodes by start. `least_visible` is relative to the full silhouettes, as is MOTChallenge's visibility.
    pub episodes: Vec<Episode>,
    /// The frame and silhouette of all objects from enter to exit, occluded or not.
    pub boxes: Vec<(u32, Silhouette)>,
}

/// Derives events and episodes from the frames of a scene, in order.
#[derive(Clone, Debug)]
pub struct Recorder {
    shortest_break: f32,
    moments: Vec<FrameRecord>,
}

/// The recorded data of a frame.
#[derive(Clone, Debug)]
struct FrameRecord {
    number: u32,
    silhouettes: Vec<Silhouette>,
    touching: Vec<(Identity, Identity)>,
    depth: Vec<Identity>,
}

impl FrameRecord {
    fn silhouette(&self, id: Identity) -> Option<&Silhouette> {
        self.silhouettes.iter().find(|silhouette| silhouette.id == id)
    }

    fn is_seen(&self, id: Identity) -> bool {
        self.silhouette(id).is_some_and(|silhouette| silhouette.is_inside() && !silhouette.is_hidden())
    }

    /// The centre of the bounding box of some people.
    fn middle(&self, ids: &[Identity]) -> [f32; 2] {
        let boxes = ids.iter().filter_map(|&id| self.silhouette(id)).map(|silhouette| silhouette.bbox);
        boxes.reduce(|a, b| a.union(&b)).unwrap_or_default().centre()
    }
}

/// The presence of one person, as indices of recorded frames.
struct Presence {
    id: Identity,
    /// The first and last index of visibility; the last index of all for people who are still inside then.
    stay: (usize, usize),
    left: bool,
    /// The first and last index of each occlusion by the scene.
    hidden: Vec<(usize, usize)>,
}

impl Presence {
    fn is_in(&self, at: usize) -> bool {
        (self.stay.0..=self.stay.1).contains(&at)
    }

    fn is_hidden(&self, at: usize) -> bool {
        self.hidden.iter().any(|&(start, end)| (start..=end).contains(&at))
    }
}

impl Recorder {
    /// A recorder for a scene of this many frames per second.
    pub fn new(fps: f32) -> Self {
        Self { shortest_break: SAME_EPISODE * fps, moments: Vec::new() }
    }

    /// Adds the next frame.
    pub fn push(&mut self, frame: &FrameTruth) {
        self.moments.push(FrameRecord {
            number: frame.number,
            silhouettes: frame.silhouettes.clone(),
            touching: frame.touching.clone(),
            depth: frame.depth.clone(),
        });
    }

    /// The events and episodes of the added frames.
    pub fn finish(&self) -> SceneTruth {
        let people = self.presences();
        let groups = self.groups(&people);
        let mut events = self.comings_and_goings(&people);
        events.extend(self.open_episodes(&people, &groups));
        events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
        let mut episodes = self.inter_object_episodes(&groups);
        episodes.extend(self.scene_episodes(&people));
        episodes.sort_by_key(|episode| (episode.start, episode.objects.clone()));
        let mut boxes = Vec::new();
        for (at, moment) in self.moments.iter().enumerate() {
            let present = |id| people.iter().any(|person| person.id == id && person.is_in(at));
            boxes.extend(moment.silhouettes.iter().filter(|s| present(s.id)).map(|s| (moment.number, *s)));
        }
        SceneTruth { events, episodes, boxes }
    }

    /// Joins ranges that are separated by too short a break.
    fn close_breaks(&self, runs: impl IntoIterator<Item = (usize, usize)>) -> Vec<(usize, usize)> {
        let mut joined: Vec<(usize, usize)> = Vec::new();
        for (start, end) in runs {
            match joined.last_mut() {
                Some(last) if ((start - last.1 - 1) as f32) < self.shortest_break => last.1 = end,
                _ => joined.push((start, end)),
            }
        }
        joined
    }

    fn presences(&self) -> Vec<Presence> {
        let mut ids: Vec<Identity> =
            self.moments.iter().flat_map(|moment| moment.silhouettes.iter().map(|s| s.id)).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.into_iter().filter_map(|id| self.presence(id)).collect()
    }

    fn presence(&self, id: Identity) -> Option<Presence> {
        let first = self.moments.iter().position(|moment| moment.is_seen(id))?;
        let last_seen = self.moments.iter().rposition(|moment| moment.is_seen(id))?;
        let last = self.moments.len() - 1;
        let left = !self.moments[last].silhouette(id).is_some_and(Silhouette::is_inside);
        let stay = (first, if left { last_seen } else { last });
        let is_hidden = |at: usize| self.moments[at].silhouette(id).is_some_and(Silhouette::is_hidden);
        let hidden = self.close_breaks(runs(stay.0, stay.1, is_hidden));
        Some(Presence { id, stay, left, hidden })
    }

    /// The groups at each index: sorted, of at least two members each.
    fn groups(&self, people: &[Presence]) -> Vec<Vec<Vec<Identity>>> {
        let pairs = |at: usize| {
            let present = move |id| people.iter().any(|p| p.id == id && p.is_in(at) && !p.is_hidden(at));
            let touching = self.moments[at].touching.iter().copied();
            touching.filter(move |&(a, b)| present(a) && present(b))
        };
        let direct: Vec<_> = (0..self.moments.len()).map(|at| unite(pairs(at))).collect();
        let mut together: Vec<Vec<(Identity, Identity)>> = vec![Vec::new(); self.moments.len()];
        for (place, a) in people.iter().enumerate() {
            for b in &people[place + 1..] {
                let shared = (a.stay.0.max(b.stay.0), a.stay.1.min(b.stay.1));
                let meets = |at: usize| direct[at].iter().any(|g| g.contains(&a.id) && g.contains(&b.id));
                for (start, end) in self.close_breaks(runs(shared.0, shared.1, meets)) {
                    for moment in &mut together[start..=end] {
                        moment.push((a.id, b.id));
                    }
                }
            }
        }
        together.into_iter().map(unite).collect()
    }

    fn event(
        &self,
        at: usize,
        kind: EventKind,
        objects: Vec<Identity>,
        becomes: Vec<Identity>,
    ) -> TruthEvent {
        let [x, y] = self.moments[at].middle(&objects);
        TruthEvent { frame: self.moments[at].number, kind, objects, becomes, x, y, front: None }
    }

    fn comings_and_goings(&self, people: &[Presence]) -> Vec<TruthEvent> {
        let mut events = Vec::new();
        for person in people {
            let one = || vec![person.id];
            events.push(self.event(person.stay.0, EventKind::Enter, one(), one()));
            for &(start, end) in &person.hidden {
                events.push(self.event(start, EventKind::Disappear, one(), vec![]));
                if end < person.stay.1 {
                    events.push(self.event(end + 1, EventKind::Reappear, one(), one()));
                }
            }
            if person.left {
                events.push(self.event(person.stay.1, EventKind::Exit, one(), vec![]));
            }
        }
        events
    }

    fn open_episodes(&self, people: &[Presence], groups: &[Vec<Vec<Identity>>]) -> Vec<TruthEvent> {
        let mut events = Vec::new();
        let none = Vec::new();
        for (at, now) in groups.iter().enumerate() {
            let before = at.checked_sub(1).map_or(&none, |earlier| &groups[earlier]);
            for group in now {
                let held = |old: &Vec<Identity>| group.iter().all(|id| old.contains(id));
                if !before.iter().any(held) {
                    let mut event = self.event(at, EventKind::Merge, group.clone(), group.clone());
                    event.front = self.front(at, group);
                    events.push(event);
                }
            }
            for group in before {
                let stays =
                    |id: &Identity| people.iter().any(|p| p.id == *id && p.is_in(at) && !p.is_hidden(at));
                let out: Vec<Identity> = group.iter().copied().filter(stays).collect();
                let as_one = out.len() < 2 || now.iter().any(|new| out.iter().all(|id| new.contains(id)));
                if !as_one {
                    events.push(self.event(at, EventKind::Demerge, group.clone(), out));
                }
            }
        }
        events
    }

    /// The member of a group that is drawn last.
    fn front(&self, at: usize, group: &[Identity]) -> Option<Identity> {
        self.moments[at].depth.iter().rev().find(|id| group.contains(id)).copied()
    }

    /// An episode lasts as long as at least two of its members are together; people who join are members.
    fn inter_object_episodes(&self, groups: &[Vec<Vec<Identity>>]) -> Vec<Episode> {
        struct OpenEpisode {
            episode: Episode,
            last: usize,
            groups: Vec<Vec<Identity>>,
        }
        let mut open_episodes: Vec<OpenEpisode> = Vec::new();
        for (at, now) in groups.iter().enumerate() {
            let number = self.moments[at].number;
            for group in now {
                let continues = |open_episode: &OpenEpisode| {
                    let both = |old: &Vec<Identity>| group.iter().filter(|id| old.contains(id)).count() > 1;
                    open_episode.last + 1 == at && open_episode.groups.iter().any(both)
                        || open_episode.last == at
                            && at > 0
                            && groups[at - 1].iter().any(|old| {
                                both(old) && open_episode.episode.objects.iter().any(|id| old.contains(id))
                            })
                };
                let place = open_episodes.iter().position(continues).unwrap_or_else(|| {
                    let episode = Episode {
                        kind: EpisodeKind::InterObject,
                        objects: Vec::new(),
                        start: number,
                        end: number,
                        least_visible: 1.0,
                        front: self.front(at, group),
                        identities_kept: true,
                    };
                    open_episodes.push(OpenEpisode { episode, last: at, groups: Vec::new() });
                    open_episodes.len() - 1
                });
                let open_episode = &mut open_episodes[place];
                if open_episode.last < at {
                    open_episode.groups.clear();
                }
                open_episode.groups.push(group.clone());
                (open_episode.last, open_episode.episode.end) = (at, number);
                let objects = &mut open_episode.episode.objects;
                objects.extend(group);
                objects.sort_unstable();
                objects.dedup();
                let least = group.iter().map(|&id| self.visibility(at, id)).fold(1.0, f32::min);
                open_episode.episode.least_visible = open_episode.episode.least_visible.min(least);
            }
        }
        open_episodes.into_iter().map(|open_episode| open_episode.episode).collect()
    }

    fn scene_episodes(&self, people: &[Presence]) -> Vec<Episode> {
        let episode = |id: Identity, (start, end): (usize, usize)| Episode {
            kind: EpisodeKind::Scene,
            objects: vec![id],
            start: self.moments[start].number,
            end: self.moments[end].number,
            least_visible: (start..=end).map(|at| self.visibility(at, id)).fold(1.0, f32::min),
            front: None,
            identities_kept: true,
        };
        people.iter().flat_map(|p| p.hidden.iter().map(move |&time| episode(p.id, time))).collect()
    }

    fn visibility(&self, at: usize, id: Identity) -> f32 {
        self.moments[at].silhouette(id).map_or(0.0, Silhouette::visibility)
    }
}

/// The first and last index of every range within `first..=last` for which `holds`.
fn runs(first: usize, last: usize, holds: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for at in (first..=last).filter(|&at| holds(at)) {
        match runs.last_mut() {
            Some(run) if run.1 + 1 == at => run.1 = at,
            _ => runs.push((at, at)),
        }
    }
    runs
}

/// The connected components of pairs, sorted; they are disjoint.
fn unite(pairs: impl IntoIterator<Item = (Identity, Identity)>) -> Vec<Vec<Identity>> {
    let mut groups: Vec<Vec<Identity>> = Vec::new();
    for (a, b) in pairs {
        let (mut joined, apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group: &Vec<Identity>| group.contains(&a) || group.contains(&b));
        joined.push(vec![a, b]);
        let mut group = joined.concat();
        group.sort_unstable();
        group.dedup();
        groups = apart;
        groups.push(group);
    }
    groups.sort();
    groups
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::*;
    use crate::frame::Size;
    use crate::regions::Rect;
    use crate::synth::noise::CameraNoise;
    use crate::synth::{SceneParameters, catalogue, render};

    fn truth_of(name: &str, parameters: &SceneParameters) -> SceneTruth {
        let scene = catalogue::scene(name, parameters).unwrap();
        let mut recorder = Recorder::new(scene.fps);
        for (_, truth) in render(&scene) {
            recorder.push(&truth);
        }
        recorder.finish()
    }

    fn kinds(truth: &SceneTruth) -> Vec<(EventKind, Vec<Identity>)> {
        truth.events.iter().map(|event| (event.kind, event.objects.clone())).collect()
    }

    fn count(truth: &SceneTruth, kind: EventKind) -> usize {
        truth.events.iter().filter(|event| event.kind == kind).count()
    }

    /// Several seeds, sizes and speeds; small images for speed.
    fn varied() -> impl Iterator<Item = SceneParameters> {
        let sizes = [Size::new(96, 72), Size::new(128, 72), Size::new(160, 120), Size::new(100, 140)];
        (1..=6u64).map(move |seed| SceneParameters {
            size: sizes[seed as usize % sizes.len()],
            seed,
            speed: [1.0, 0.7, 1.6, 2.2][(seed / 2) as usize % 4],
            noise: CameraNoise { sigma: 0.0, signal_dependent: false },
            ..SceneParameters::default()
        })
    }

    #[test]
    fn two_crossing_people_merge_once_for_any_seed_size_and_speed() {
        for name in ["crossing", "crossing-alike", "overtake"] {
            for parameters in varied() {
                let truth = truth_of(name, &parameters);
                let mut sorted = kinds(&truth);
                sorted.sort();
                let expected = [
                    (EventKind::Exit, vec![1]),
                    (EventKind::Exit, vec![2]),
                    (EventKind::Demerge, vec![1, 2]),
                    (EventKind::Merge, vec![1, 2]),
                    (EventKind::Enter, vec![1]),
                    (EventKind::Enter, vec![2]),
                ];
                assert_eq!(sorted, expected, "{name} {parameters:?}");
                let at = |kind| truth.events.iter().find(|event| event.kind == kind).unwrap();
                let (merge, demerge) = (at(EventKind::Merge), at(EventKind::Demerge));
                assert_eq!((merge.front, &merge.becomes), (Some(2), &vec![1, 2]));
                let [open_episode] = truth.episodes.as_slice() else { panic!("{:?}", truth.episodes) };
                assert_eq!(open_episode.kind, EpisodeKind::InterObject);
                assert_eq!((open_episode.start, open_episode.end + 1), (merge.frame, demerge.frame));
                assert!(
                    open_episode.least_visible < 0.6,
                    "most of a member is occluded: {}",
                    open_episode.least_visible
                );
                assert!(truth.boxes[0].0 > catalogue::SETTLE);
            }
        }
    }

    #[test]
    fn a_tree_occludes_a_person_once_and_completely() {
        for parameters in varied() {
            let truth = truth_of("tree", &parameters);
            let expected = [EventKind::Enter, EventKind::Disappear, EventKind::Reappear, EventKind::Exit]
                .map(|kind| (kind, vec![1]));
            assert_eq!(kinds(&truth), expected, "{parameters:?}");
            let [hidden] = truth.episodes.as_slice() else { panic!("{:?}", truth.episodes) };
            assert_eq!((hidden.kind, hidden.least_visible), (EpisodeKind::Scene, 0.0));
            let seconds = (hidden.end + 1 - hidden.start) as f32 / catalogue::FPS * parameters.speed;
            assert!((0.9..2.0).contains(&seconds), "occluded for {seconds} s at normal speed");
        }
    }

    #[test]
    fn a_partly_occluded_person_does_not_disappear() {
        for parameters in varied() {
            for name in ["pole", "wall"] {
                let truth = truth_of(name, &parameters);
                assert_eq!(
                    kinds(&truth),
                    [(EventKind::Enter, vec![1]), (EventKind::Exit, vec![1])],
                    "{name}"
                );
                let least = truth.boxes.iter().map(|(_, who)| who.unscreened as f32 / who.inside as f32);
                let least = least.fold(1.0, f32::min);
                assert!((0.2..0.85).contains(&least), "{name} occludes a part: {least} is visible");
            }
            let pair = truth_of("pair", &parameters);
            assert_eq!((count(&pair, EventKind::Enter), count(&pair, EventKind::Exit)), (2, 2));
            assert!(pair.events.len() == 4 && pair.episodes.is_empty(), "{:?}", pair.events);
            assert_eq!(
                truth_of("empty", &SceneParameters { frames: Some(3), ..parameters }),
                SceneTruth::default()
            );
        }
    }

    #[test]
    fn three_meeting_people_are_one_episode() {
        for parameters in varied() {
            let truth = truth_of("group", &parameters);
            let all = |event: &&TruthEvent| event.objects == [1, 2, 3];
            assert!(truth.events.iter().filter(all).any(|event| event.kind == EventKind::Merge));
            assert!(truth.events.iter().filter(all).any(|event| event.kind == EventKind::Demerge));
            assert_eq!((count(&truth, EventKind::Enter), count(&truth, EventKind::Exit)), (3, 3));
            let [open_episode] = truth.episodes.as_slice() else {
                panic!("{parameters:?} {:?}", truth.episodes)
            };
            assert_eq!(open_episode.objects, [1, 2, 3]);
        }
    }

    #[test]
    fn boxes_continue_behind_the_tree() {
        let truth = truth_of("tree", &varied().next().unwrap());
        let frames: Vec<u32> = truth.boxes.iter().map(|(frame, _)| *frame).collect();
        let (enter, exit) = (truth.events[0].frame, truth.events[3].frame);
        assert_eq!(frames, (enter..=exit).collect::<Vec<_>>());
    }

    /// A frame with people of 100 pixels, 50 pixels apart, with these numbers of unscreened pixels.
    fn frame(number: u32, unscreened: &[(Identity, u32)], touching: &[(Identity, Identity)]) -> FrameTruth {
        let silhouette = |&(id, unscreened): &(Identity, u32)| Silhouette {
            id,
            bbox: Rect::new(50.0 * id as f32, 10.0, 10.0, 10.0),
            full: 100,
            inside: 100,
            unscreened,
            visible: unscreened,
            parked: false,
        };
        FrameTruth {
            number,
            size: Size::new(300, 40),
            identities: vec![0; 12_000],
            silhouettes: unscreened.iter().map(silhouette).collect(),
            touching: touching.to_vec(),
            depth: unscreened.iter().map(|(id, _)| *id).rev().collect(),
        }
    }

    fn told(frames: impl IntoIterator<Item = FrameTruth>) -> SceneTruth {
        let mut recorder = Recorder::new(10.0);
        frames.into_iter().for_each(|frame| recorder.push(&frame));
        recorder.finish()
    }

    fn frames_and_kinds(truth: &SceneTruth) -> Vec<(u32, EventKind)> {
        truth.events.iter().map(|event| (event.frame, event.kind)).collect()
    }

    #[test]
    fn a_separation_shorter_than_half_a_second_does_not_end_an_episode() {
        // Five frames are half a second.
        for (breadth, ends) in [(4, 1), (5, 2)] {
            let touches = |number: u32| (3..6).contains(&number) || (6 + breadth..20).contains(&number);
            let truth = told((1..=30).map(|number| {
                let pairs: &[_] = if touches(number) { &[(1, 2)] } else { &[] };
                frame(number, &[(1, 100), (2, 100)], pairs)
            }));
            assert_eq!(count(&truth, EventKind::Merge), ends);
            assert_eq!((truth.episodes.len(), truth.episodes[ends - 1].end), (ends, 19));
            assert_eq!(truth.episodes[0].front, Some(1));
        }
    }

    #[test]
    fn an_occluded_person_disappears_and_short_visible_intervals_do_not_count() {
        let open = |number: u32| if (5..20).contains(&number) && number != 9 { 4 } else { 100 };
        let truth = told((1..=30).map(|number| frame(number, &[(1, open(number))], &[])));
        let expected = [(1, EventKind::Enter), (5, EventKind::Disappear), (20, EventKind::Reappear)];
        assert_eq!(frames_and_kinds(&truth), expected, "there is no exit at the end");
        assert_eq!((truth.episodes[0].start, truth.episodes[0].end), (5, 19));
    }

    #[test]
    fn a_person_moved_outside_by_camera_shake_does_not_disappear() {
        let truth = told((1..=30).map(|number| {
            let seen: &[_] = if number == 7 { &[] } else { &[(1, 100)] };
            frame(number, seen, &[])
        }));
        assert_eq!(frames_and_kinds(&truth), [(1, EventKind::Enter)]);
    }

    #[test]
    fn a_person_occluded_at_the_end_neither_reappears_nor_exits() {
        let truth = told((1..=9).map(|number| frame(number, &[(1, if number < 6 { 100 } else { 0 })], &[])));
        assert_eq!(frames_and_kinds(&truth), [(1, EventKind::Enter), (6, EventKind::Disappear)]);
        assert_eq!((truth.episodes[0].end, truth.boxes.len()), (9, 9));
    }

    #[test]
    fn a_group_continues_after_one_member_leaves() {
        let truth = told((1..=40).map(|number| {
            let pairs: &[_] = match number {
                0..5 | 30.. => &[],
                10..20 => &[(1, 2), (2, 3)],
                _ => &[(1, 2)],
            };
            frame(number, &[(1, 100), (2, 100), (3, 100)], pairs)
        }));
        let open_episodes: Vec<_> = truth
            .events
            .iter()
            .skip(3)
            .map(|e| (e.frame, e.kind, e.objects.as_slice(), e.becomes.as_slice()))
            .collect();
        let expected: [(u32, EventKind, &[Identity], &[Identity]); 4] = [
            (5, EventKind::Merge, &[1, 2], &[1, 2]),
            (10, EventKind::Merge, &[1, 2, 3], &[1, 2, 3]),
            (20, EventKind::Demerge, &[1, 2, 3], &[1, 2, 3]),
            (30, EventKind::Demerge, &[1, 2], &[1, 2]),
        ];
        assert_eq!(open_episodes, expected);
        let [episode] = truth.episodes.as_slice() else { panic!("{:?}", truth.episodes) };
        assert_eq!((episode.objects.as_slice(), episode.start, episode.end), ([1, 2, 3].as_slice(), 5, 29));
    }

    #[test]
    fn a_leaving_group_has_exits_and_no_demerge() {
        let truth = told((1..=20).map(|number| match number {
            0..=5 => frame(number, &[(1, 100), (2, 100)], &[]),
            6..=10 => frame(number, &[(1, 100), (2, 100)], &[(1, 2)]),
            _ => frame(number, &[], &[]),
        }));
        let expected = [
            (1, EventKind::Enter),
            (1, EventKind::Enter),
            (6, EventKind::Merge),
            (10, EventKind::Exit),
            (10, EventKind::Exit),
        ];
        let mut told = frames_and_kinds(&truth);
        told.sort();
        assert_eq!(told, expected.map(|(frame, kind)| (frame, kind)));
    }
}
