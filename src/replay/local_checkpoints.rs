//! Things kept around the position that is looked at: who steps there will step on.

use std::collections::BTreeMap;

/// Things by position; the farthest from where one is go first when they take too many bytes.
pub(super) struct Near<T> {
    /// With the memory that each takes.
    kept: BTreeMap<u32, (T, usize)>,
    room: usize,
    taken: usize,
    /// Where one was when something was last kept.
    here: u32,
}

impl<T> Near<T> {
    /// Room for `room` bytes of things.
    pub(super) const fn new(room: usize) -> Self {
        Self { kept: BTreeMap::new(), room, taken: 0, here: 0 }
    }

    /// Less room, as other things take it, or more.
    pub(super) fn set_room(&mut self, room: usize) {
        self.room = room;
        self.thin();
    }

    /// Whether something belongs to this position already.
    pub(super) fn has(&self, position: u32) -> bool {
        self.kept.contains_key(&position)
    }

    /// Keeps a thing of so many bytes that belongs to `position`, if there is room for it near `here`.
    pub(super) fn insert(&mut self, position: u32, thing: T, bytes: usize, here: u32) {
        self.taken += bytes;
        if let Some((_, before)) = self.kept.insert(position, (thing, bytes)) {
            self.taken -= before;
        }
        self.here = here;
        self.thin();
    }

    /// Drops what is farthest until the rest has room.
    fn thin(&mut self) {
        while self.taken > self.room {
            let ends = [self.kept.keys().next(), self.kept.keys().next_back()];
            let Some(farthest) = ends.into_iter().flatten().copied().max_by_key(|at| at.abs_diff(self.here))
            else {
                break;
            };
            if let Some((_, bytes)) = self.kept.remove(&farthest) {
                self.taken -= bytes;
            }
        }
    }

    /// The last thing at or before a position.
    pub(super) fn at_or_before(&self, position: u32) -> Option<(u32, &T)> {
        self.kept.range(..=position).next_back().map(|(&position, (thing, _))| (position, thing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_far_goes_first() {
        let mut near = Near::new(30);
        for position in [10, 20, 30] {
            near.insert(position, position, 10, 30);
        }
        near.insert(40, 40, 10, 40);
        assert!(!near.has(10) && near.has(20) && near.has(40));
        assert_eq!(near.at_or_before(35), Some((30, &30)));
        near.insert(5, 5, 10, 5);
        assert!(!near.has(40) && near.has(5) && near.taken == 30);
        near.insert(5, 6, 20, 5);
        assert_eq!((near.at_or_before(9), near.taken), (Some((5, &6)), 30));
        near.insert(7, 7, 31, 7);
        assert!(near.kept.is_empty() && near.taken == 0, "too large for any room");
    }

    #[test]
    fn with_less_room_what_is_far_goes_at_once() {
        let mut near = Near::new(40);
        for position in [10, 20, 30, 40] {
            near.insert(position, position, 10, 25);
        }
        near.insert(20, 20, 10, 22);
        near.set_room(25);
        assert!(near.taken == 20 && near.has(20) && near.has(30), "{:?}", near.kept.keys());
        near.set_room(0);
        assert!(near.taken == 0 && near.at_or_before(50).is_none());
    }
}
