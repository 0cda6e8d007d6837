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
}

impl Naming {
    /// The identity of an object.
    pub fn of(&self, key: Key) -> Option<Identity> {
        self.identities.get(&key).copied()
    }

    /// Gives an object the next free identity, unless it has one.
    pub fn name(&mut self, key: Key) -> Identity {
        let last = &mut self.last;
        *self.identities.entry(key).or_insert_with(|| {
            *last += 1;
            *last
        })
    }

    /// Decides that an object is one that has been known before.
    pub fn same(&mut self, key: Key, as_known: Key) {
        if let Some(identity) = self.of(as_known) {
            self.identities.insert(key, identity);
        }
    }

    /// The tracks of one frame under their identities, in the order of these, those without one
    /// left out. Where an object stands twice, as a prediction and as the piece that it turned
    /// out to be, the one that was seen counts.
    pub fn apply<'a>(&self, tracks: impl IntoIterator<Item = &'a Track>) -> Vec<Track> {
        let mut named: BTreeMap<Identity, Track> = BTreeMap::new();
        for track in tracks {
            let Some(id) = self.of(track.key) else { continue };
            let seen = track.state == TrackState::Visible;
            if seen || !named.contains_key(&id) {
                named.insert(id, Track { id, ..track.clone() });
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
        named.into_values().collect()
    }
}
