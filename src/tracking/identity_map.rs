//! Identities of objects: an object has a track key from its first region, and an identity once it is confirmed.

use std::collections::BTreeMap;

use super::track::{Identity, Track, TrackState};

/// Key of an object's tracks from its first region on, before it is known whether it is noise.
pub type TrackKey = u32;

/// The identity of each track key. A key without one belongs to a tentative object or to noise.
#[derive(Clone, Debug, Default)]
pub struct IdentityMap {
    identities: BTreeMap<TrackKey, Identity>,
    last: Identity,
    /// Assignments since the last call of [`IdentityMap::take_decided`], in order.
    decided: Vec<(TrackKey, Identity)>,
}

impl IdentityMap {
    /// The identity of a key.
    pub fn of(&self, key: TrackKey) -> Option<Identity> {
        self.identities.get(&key).copied()
    }

    /// Assigns the next free identity to a key, unless it has one.
    pub fn assign_new(&mut self, key: TrackKey) -> Identity {
        if let Some(identity) = self.of(key) {
            return identity;
        }
        self.last += 1;
        self.set(key, self.last);
        self.last
    }

    /// Takes the assignments since the previous call, in order.
    pub fn take_decided(&mut self) -> Vec<(TrackKey, Identity)> {
        std::mem::take(&mut self.decided)
    }

    /// Drops the keys that nothing refers to any more.
    pub fn retain(&mut self, keep: impl Fn(TrackKey) -> bool) {
        self.identities.retain(|&key, _| keep(key));
    }

    /// Number of keys with an identity.
    pub fn len(&self) -> usize {
        self.identities.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.identities.is_empty()
    }

    /// Assigns an identity to a key.
    pub fn set(&mut self, key: TrackKey, identity: Identity) {
        self.identities.insert(key, identity);
        self.decided.push((key, identity));
    }

    /// Assigns the identity of another key to a key.
    pub fn link(&mut self, key: TrackKey, as_known: TrackKey) {
        if let Some(identity) = self.of(as_known) {
            self.set(key, identity);
        }
    }

    /// The tracks of one frame with their identities, in the order of these; tracks without one are left out. Of a
    /// predicted and a visible track of one identity the visible one is taken; two visible ones are fragments and are
    /// joined.
    pub fn apply<'a>(&self, tracks: impl IntoIterator<Item = &'a Track>) -> Vec<Track> {
        let mut named: BTreeMap<Identity, Track> = BTreeMap::new();
        for track in tracks {
            let Some(id) = self.of(track.key) else { continue };
            let seen = track.state == TrackState::Visible;
            match named.get_mut(&id) {
                Some(fragment) if seen && fragment.state == TrackState::Visible => {
                    merge_fragment(fragment, track);
                }
                Some(_) if !seen => {}
                _ => {
                    named.insert(id, Track { id, ..track.clone() });
                }
            }
        }
        for track in named.values_mut() {
            track.group.retain_mut(|member| match self.of(*member) {
                Some(id) => {
                    *member = id;
                    true
                }
                None => false,
            });
        }
        // A member whose demerge was decided later is a track of its own.
        let regions: BTreeMap<Identity, Vec<u32>> =
            named.values().map(|track| (track.id, track.regions.clone())).collect();
        for track in named.values_mut().filter(|track| track.state == TrackState::Merged) {
            track.group.retain(|member| regions.get(member) == Some(&track.regions));
            if track.group.len() < 2 {
                track.group.clear();
                track.state = TrackState::Visible;
            }
        }
        named.into_values().collect()
    }
}

/// Joins a fragment to the track of the same object in the same frame.
fn merge_fragment(track: &mut Track, fragment: &Track) {
    track.bbox = track.bbox.union(&fragment.bbox);
    track.centre = track.bbox.centre();
    track.scale = track.scale.hypot(fragment.scale);
    for label in &fragment.regions {
        if !track.regions.contains(label) {
            track.regions.push(*label);
        }
    }
    track.regions.sort_unstable();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::track;
    use crate::regions::Rect;

    #[test]
    fn fragments_that_proved_one_object_are_one_box_before() {
        let mut identity_map = IdentityMap::default();
        identity_map.assign_new(1);
        identity_map.link(2, 1);
        let at = |key: TrackKey, y: f32, label: u32| Track {
            key,
            state: TrackState::Visible,
            group: vec![],
            bbox: Rect::new(10.0, y, 20.0, 30.0),
            regions: vec![label],
            ..track(0, 0.0, 0.0)
        };
        let told = identity_map.apply(&[at(1, 20.0, 4), at(2, 60.0, 3)]);
        let [one] = &told[..] else { panic!("{told:?}") };
        assert_eq!((one.id, one.bbox), (1, Rect::new(10.0, 20.0, 20.0, 70.0)));
        assert_eq!(one.regions, [3, 4]);
    }

    #[test]
    fn who_came_out_before_it_was_known_stands_alone_and_leaves_the_rest_together() {
        let mut identity_map = IdentityMap::default();
        for key in 1..=3 {
            identity_map.assign_new(key);
        }
        let merged = |key: TrackKey| Track {
            key,
            state: TrackState::Merged,
            group: vec![1, 2, 3],
            regions: vec![1],
            ..track(0, 0.0, 0.0)
        };
        let out = Track {
            key: 4,
            state: TrackState::Visible,
            group: vec![],
            regions: vec![2],
            ..track(0, 0.0, 0.0)
        };
        identity_map.link(4, 3);
        let told = identity_map.apply(&[merged(1), merged(2), merged(3), out]);
        let with: Vec<_> = told.iter().map(|track| (track.id, track.group.clone())).collect();
        assert_eq!(with, [(1, vec![1, 2]), (2, vec![1, 2]), (3, vec![])]);
    }
}
