//! Identities of objects: an object has a number from its first region on, and an identity once it is confirmed.

use std::collections::BTreeMap;

use super::track::{Identity, ObjectId, Track, TrackState};

/// The identity of each object's number and of each number that its tracks are recorded under (their key). An object's
/// number is its first key, and no number is used twice, so that one map has both. A number without an identity belongs
/// to a tentative object or to noise.
#[derive(Clone, Debug, Default)]
pub struct IdentityMap {
    identities: BTreeMap<ObjectId, Identity>,
    last: Identity,
    /// Assignments since the last call of [`IdentityMap::take_assigned`], in order.
    assigned: Vec<(ObjectId, Identity)>,
}

impl IdentityMap {
    /// The identity of a key.
    pub fn of(&self, key: ObjectId) -> Option<Identity> {
        self.identities.get(&key).copied()
    }

    /// Assigns the next free identity to a key, unless it has one.
    pub fn assign_new(&mut self, key: ObjectId) -> Identity {
        if let Some(identity) = self.of(key) {
            return identity;
        }
        self.last += 1;
        self.set(key, self.last);
        self.last
    }

    /// Takes the assignments since the previous call, in order.
    pub fn take_assigned(&mut self) -> Vec<(ObjectId, Identity)> {
        std::mem::take(&mut self.assigned)
    }

    /// Drops the keys that nothing refers to any more.
    pub fn retain(&mut self, keep: impl Fn(ObjectId) -> bool) {
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
    pub fn set(&mut self, key: ObjectId, identity: Identity) {
        self.identities.insert(key, identity);
        self.assigned.push((key, identity));
    }

    /// Assigns the identity of another key to a key.
    pub fn link(&mut self, key: ObjectId, as_known: ObjectId) {
        if let Some(identity) = self.of(as_known) {
            self.set(key, identity);
        }
    }

    /// The tracks of one frame with their identities, in the order of these; tracks without one are left out. Of a
    /// predicted and a visible track of one identity the visible one is taken; two visible ones are fragments and are
    /// joined.
    pub fn apply<'a>(&self, tracks: impl IntoIterator<Item = &'a Track>) -> Vec<Track> {
        let mut by_identity: BTreeMap<Identity, Track> = BTreeMap::new();
        for track in tracks {
            let Some(id) = self.of(track.key) else { continue };
            let seen = track.state == TrackState::Visible;
            match by_identity.get_mut(&id) {
                Some(fragment) if seen && fragment.state == TrackState::Visible => {
                    merge_fragment(fragment, track);
                }
                Some(_) if !seen => {}
                _ => {
                    by_identity.insert(id, Track { id, ..track.clone() });
                }
            }
        }
        for track in by_identity.values_mut() {
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
            by_identity.values().map(|track| (track.id, track.regions.clone())).collect();
        for track in by_identity.values_mut().filter(|track| track.state == TrackState::Merged) {
            track.group.retain(|member| regions.get(member) == Some(&track.regions));
            if track.group.len() < 2 {
                track.group.clear();
                track.state = TrackState::Visible;
            }
        }
        by_identity.into_values().collect()
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
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::export::tests::track;
    use crate::regions::Rect;

    #[test]
    fn visible_tracks_of_one_identity_in_a_frame_are_joined() {
        let mut identity_map = IdentityMap::default();
        identity_map.assign_new(1);
        identity_map.link(2, 1);
        let at = |key: ObjectId, y: f32, label: u32| Track {
            key,
            state: TrackState::Visible,
            group: vec![],
            bbox: Rect::new(10.0, y, 20.0, 30.0),
            regions: vec![label],
            ..track(0, 0.0, 0.0)
        };
        let tracks = identity_map.apply(&[at(1, 20.0, 4), at(2, 60.0, 3)]);
        let [one] = &tracks[..] else { panic!("{tracks:?}") };
        assert_eq!((one.id, one.bbox), (1, Rect::new(10.0, 20.0, 20.0, 70.0)));
        assert_eq!(one.regions, [3, 4]);
    }

    #[test]
    fn a_member_whose_demerge_was_decided_later_leaves_the_group_of_the_others() {
        let mut identity_map = IdentityMap::default();
        for key in 1..=3 {
            identity_map.assign_new(key);
        }
        let merged = |key: ObjectId| Track {
            key,
            state: TrackState::Merged,
            group: vec![1, 2, 3],
            regions: vec![1],
            ..track(0, 0.0, 0.0)
        };
        let departed = Track {
            key: 4,
            state: TrackState::Visible,
            group: vec![],
            regions: vec![2],
            ..track(0, 0.0, 0.0)
        };
        identity_map.link(4, 3);
        let tracks = identity_map.apply(&[merged(1), merged(2), merged(3), departed]);
        let with: Vec<_> = tracks.iter().map(|track| (track.id, track.group.clone())).collect();
        assert_eq!(with, [(1, vec![1, 2]), (2, vec![1, 2]), (3, vec![])]);
    }

    #[test]
    fn of_a_visible_and_a_predicted_track_of_one_identity_the_visible_one_is_taken() {
        let mut identity_map = IdentityMap::default();
        identity_map.assign_new(1);
        identity_map.link(2, 1);
        let at = |key: ObjectId, state: TrackState| Track {
            key,
            state,
            group: vec![],
            bbox: Rect::new(key as f32, 0.0, 20.0, 30.0),
            regions: vec![key],
            ..track(0, 0.0, 0.0)
        };
        let [visible, merged, hidden] = [TrackState::Visible, TrackState::Merged, TrackState::Hidden];
        let cases =
            [((visible, hidden), 1), ((hidden, visible), 2), ((hidden, hidden), 1), ((merged, visible), 2)];
        for ((first, second), taken) in cases {
            let tracks = identity_map.apply(&[at(1, first), at(2, second)]);
            let [one] = &tracks[..] else { panic!("{tracks:?}") };
            assert_eq!(
                (one.id, one.bbox.x, &one.regions[..]),
                (1, taken as f32, &[taken][..]),
                "{first:?} {second:?}"
            );
        }
    }

    #[test]
    fn a_group_that_one_member_is_left_of_is_none() {
        let mut identity_map = IdentityMap::default();
        identity_map.assign_new(1);
        let merged = Track { key: 1, state: TrackState::Merged, group: vec![1, 2], ..track(0, 0.0, 0.0) };
        let tracks = identity_map.apply(std::slice::from_ref(&merged));
        assert_eq!((tracks[0].state, &tracks[0].group[..]), (TrackState::Visible, &[][..]));
        identity_map.assign_new(2);
        let both = identity_map.apply(&[merged.clone(), Track { key: 2, ..merged }]);
        assert!(both.iter().all(|track| track.state == TrackState::Merged && track.group == [1, 2]));
    }
}
