//! Who is who: objects are followed from their first region, and get an identity when they have proved themselves.

use std::collections::BTreeMap;

use super::track::{Identity, Track, TrackState};

/// The number of an object from its first region on, before anybody knows whether it is noise.
pub type Key = u32;

/// Which identity each object has. An object without one is noise, or too young.
#[derive(Clone, Debug, Default)]
pub struct Naming {
    identities: BTreeMap<Key, Identity>,
    last: Identity,
    /// What was decided since it was last asked, in order.
    decided: Vec<(Key, Identity)>,
}

impl Naming {
    /// The identity of an object.
    pub fn of(&self, key: Key) -> Option<Identity> {
        self.identities.get(&key).copied()
    }

    /// Gives an object the next free identity, unless it has one.
    pub fn name(&mut self, key: Key) -> Identity {
        if let Some(identity) = self.of(key) {
            return identity;
        }
        self.last += 1;
        self.set(key, self.last);
        self.last
    }

    /// Who was found to be who since this was last asked, in the order in which it was decided.
    pub fn take_decided(&mut self) -> Vec<(Key, Identity)> {
        std::mem::take(&mut self.decided)
    }

    /// Forgets the objects of which nothing is to be told any more.
    pub fn retain(&mut self, keep: impl Fn(Key) -> bool) {
        self.identities.retain(|&key, _| keep(key));
    }

    /// How many objects are known by name.
    pub fn len(&self) -> usize {
        self.identities.len()
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.identities.is_empty()
    }

    /// How many identities have been given.
    pub const fn count(&self) -> u32 {
        self.last
    }

    /// Decides who an object is.
    pub fn set(&mut self, key: Key, identity: Identity) {
        self.identities.insert(key, identity);
        self.decided.push((key, identity));
    }

    /// Decides that an object is one that has been known before.
    pub fn same(&mut self, key: Key, as_known: Key) {
        if let Some(identity) = self.of(as_known) {
            self.set(key, identity);
        }
    }

    /// The tracks of one frame under their identities, in the order of these, those without one
    /// left out. Where an object stands twice, as a prediction and as the piece that it turned
    /// out to be, the one that was seen counts; two that were seen are fragments of it.
    pub fn apply<'a>(&self, tracks: impl IntoIterator<Item = &'a Track>) -> Vec<Track> {
        let mut named: BTreeMap<Identity, Track> = BTreeMap::new();
        for track in tracks {
            let Some(id) = self.of(track.key) else { continue };
            let seen = track.state == TrackState::Visible;
            match named.get_mut(&id) {
                Some(fragment) if seen && fragment.state == TrackState::Visible => join(fragment, track),
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
        // Who came out before it was known that they did stands by themselves.
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

/// Adds a fragment to what is seen of an object in the same frame.
fn join(track: &mut Track, fragment: &Track) {
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
        let mut naming = Naming::default();
        naming.name(1);
        naming.same(2, 1);
        let at = |key: Key, y: f32, label: u32| Track {
            key,
            state: TrackState::Visible,
            group: vec![],
            bbox: Rect::new(10.0, y, 20.0, 30.0),
            regions: vec![label],
            ..track(0, 0.0, 0.0)
        };
        let told = naming.apply(&[at(1, 20.0, 4), at(2, 60.0, 3)]);
        let [one] = &told[..] else { panic!("{told:?}") };
        assert_eq!((one.id, one.bbox), (1, Rect::new(10.0, 20.0, 20.0, 70.0)));
        assert_eq!(one.regions, [3, 4]);
    }

    #[test]
    fn who_came_out_before_it_was_known_stands_alone_and_leaves_the_rest_together() {
        let mut naming = Naming::default();
        for key in 1..=3 {
            naming.name(key);
        }
        let merged = |key: Key| Track {
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
        naming.same(4, 3);
        let told = naming.apply(&[merged(1), merged(2), merged(3), out]);
        let with: Vec<_> = told.iter().map(|track| (track.id, track.group.clone())).collect();
        assert_eq!(with, [(1, vec![1, 2]), (2, vec![1, 2]), (3, vec![])]);
    }
}
