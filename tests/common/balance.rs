//! Checks that events are consistent: replayed in order, each changes the state left by the previous ones, and tracks
//! show the same groups as the events.

use std::collections::{BTreeMap, BTreeSet};

use occluscope::occlusion::{Event, EventKind};
use occluscope::settings::Settings;
use occluscope::tracking::{FrameTracks, Identity, ObjectId, Track, TrackState};

type Set = BTreeSet<Identity>;

#[derive(Default)]
struct Replay {
    here: Set,
    hidden: Set,
    gone: Set,
    groups: Vec<Set>,
    returns: BTreeSet<(Identity, u32, ObjectId)>,
    /// The number of consecutive frames in which a track contradicts the events.
    differs: BTreeMap<Identity, u32>,
    faults: Vec<String>,
}

/// All contradictions between events (by frame and kind) and tracks (by frame), one line each. Objects that merge
/// again within `same_episode` count as merged throughout, and objects that flicker in a gap as occluded.
pub(crate) fn faults(events: &[Event], tracks: &[FrameTracks], settings: &Settings, fps: f32) -> Vec<String> {
    let same_episode = settings.same_episode.frames(fps);
    // A re-identified object has its identity after this many frames.
    let known_again = settings.min_track.frames(fps).max(fps.round() as u32);
    let mut replay = Replay { returns: returns(events, tracks), ..Replay::default() };
    let mut events = events.iter().peekable();
    for FrameTracks { number: frame, tracks, .. } in tracks {
        let mut now = Vec::new();
        while let Some(event) = events.next_if(|event| event.frame <= *frame) {
            now.push(event);
        }
        replay.take_in(&now);
        replay.compare(*frame, tracks, same_episode, known_again);
    }
    replay.faults.extend(events.map(|event| format!("after the last frame: {event:?}")));
    replay.faults
}

/// Where each reappearance was emitted: identity, frame, and the key of its track from there on.
fn returns(events: &[Event], tracks: &[FrameTracks]) -> BTreeSet<(Identity, u32, ObjectId)> {
    let key_from = |id: Identity, from: u32| {
        let frames = tracks.iter().filter(|frame| frame.number >= from);
        frames.flat_map(|frame| &frame.tracks).find(|track| track.id == id).map(|track| track.key)
    };
    let returns = events.iter().filter(|event| event.kind == EventKind::Reappear);
    let returns = returns.flat_map(|event| event.objects.iter().map(|&id| (id, event.frame)));
    returns.filter_map(|(id, frame)| Some((id, frame, key_from(id, frame)?))).collect()
}

impl Replay {
    fn expect(&mut self, holds: bool, event: &Event, what: &str) {
        if !holds {
            let Event { frame, kind, objects, .. } = event;
            self.faults.push(format!("frame {frame}: {} of {objects:?}: {what}", kind.name()));
        }
    }

    fn group_of(&self, id: Identity) -> Set {
        self.groups.iter().find(|group| group.contains(&id)).cloned().unwrap_or_else(|| Set::from([id]))
    }

    fn leave(&mut self, id: Identity) {
        for group in &mut self.groups {
            group.remove(&id);
        }
        self.groups.retain(|group| group.len() > 1);
    }

    /// Applies the events of a frame. Objects that enter in it exist from its beginning.
    fn take_in(&mut self, events: &[&Event]) {
        let (first, then): (Vec<&Event>, Vec<&Event>) = events.iter().partition(|event| match event.kind {
            EventKind::Enter | EventKind::Appear => true,
            EventKind::Reappear => event.objects.iter().all(|id| self.hidden.contains(id)),
            _ => false,
        });
        for event in first.into_iter().chain(then) {
            self.replay(event);
        }
    }

    fn replay(&mut self, event: &Event) {
        let objects: Set = event.objects.iter().copied().collect();
        let id = event.objects[0];
        match event.kind {
            EventKind::Enter | EventKind::Appear => {
                let known = [&self.here, &self.hidden, &self.gone].iter().any(|set| set.contains(&id));
                self.expect(!known, event, "the object existed before");
                self.here.insert(id);
            }
            EventKind::Reappear => {
                let hidden = self.hidden.remove(&id);
                self.expect(hidden, event, "the object was not occluded");
                self.here.insert(id);
            }
            EventKind::Exit | EventKind::Disappear => {
                let here = self.here.remove(&id);
                self.expect(here, event, "the object was not present");
                self.leave(id);
                let to = if event.kind == EventKind::Exit { &mut self.gone } else { &mut self.hidden };
                to.insert(id);
            }
            EventKind::Merge => {
                self.expect(objects.is_subset(&self.here), event, "not all objects were present");
                self.expect(!objects.is_subset(&self.group_of(id)), event, "the objects were already merged");
                let all: Set = objects.iter().flat_map(|&id| self.group_of(id)).collect();
                self.groups.retain(|group| group.is_disjoint(&all));
                self.groups.push(all);
            }
            EventKind::Demerge => {
                let group = self.group_of(id);
                self.expect(objects == group, event, &format!("the group was {group:?}"));
                let pieces: Vec<Set> =
                    event.pieces.iter().map(|piece| piece.iter().copied().collect()).collect();
                let mut all: Vec<Identity> = event.pieces.concat();
                all.sort_unstable();
                self.expect(all == event.objects, event, &format!("the pieces are {pieces:?}"));
                self.expect(pieces.len() > 1, event, "there is only one piece");
                let alone: Set = pieces.iter().filter(|piece| piece.len() == 1).flatten().copied().collect();
                let came_out = if alone.is_empty() { objects } else { alone };
                let becomes: Set = event.becomes.iter().copied().collect();
                self.expect(becomes == came_out, event, &format!("{becomes:?} left the group"));
                self.groups.retain(|other| other.is_disjoint(&group));
                self.groups.extend(pieces.into_iter().filter(|piece| piece.len() > 1));
            }
        }
    }

    fn compare(&mut self, frame: u32, tracks: &[Track], same_episode: u32, known_again: u32) {
        let mut differ = BTreeMap::new();
        for track in tracks.iter().filter(|track| track.state != TrackState::Hidden) {
            let with: Set = if track.group.is_empty() {
                Set::from([track.id])
            } else {
                track.group.iter().copied().collect()
            };
            // A member of the group may be coasting; the others remain a group.
            let seen: Set =
                tracks.iter().filter(|it| it.state != TrackState::Hidden).map(|it| it.id).collect();
            let told: Set = self.group_of(track.id).intersection(&seen).copied().collect();
            if !self.here.contains(&track.id) || told != with {
                let frames = self.differs.get(&track.id).map_or(1, |frames| frames + 1);
                let here = self.here.contains(&track.id);
                // A member that leaves a group has no identity for as long as it is tentative. Where the group loses
                // its region meanwhile, the events are its occlusion and its reappearance; its track begins before.
                let returns_later = |it: &Track| {
                    let returns = self.returns.range((it.id, frame, 0)..=(it.id, u32::MAX, ObjectId::MAX));
                    told.contains(&it.id) && returns.into_iter().any(|&(_, _, key)| key == it.key)
                };
                if here && tracks.iter().any(returns_later) {
                    continue;
                }
                if frames == same_episode + 4 + if here { 0 } else { known_again } {
                    let (id, state) = (track.id, track.state.name());
                    self.faults.push(format!(
                        "frame {frame}: {id} is {state} with {with:?}, by the events with {told:?}, there {here}"
                    ));
                }
                differ.insert(track.id, frames);
            }
        }
        self.differs = differ;
    }
}
