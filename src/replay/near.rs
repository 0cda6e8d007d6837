//! Things kept around the position that is looked at: who steps there will step on.

use std::collections::BTreeMap;

/// Things by position; the farthest from where one is go first when they take too many bytes.
pub(super) struct Near<T> {
    /// With the memory that each takes.
    kept: BTreeMap<u32, (T, usize)>,
    room: usize,
    taken: usize,
}

impl<T> Near<T> {
    /// Room for `room` bytes of things.
    pub(super) const fn new(room: usize) -> Self {
        Self { kept: BTreeMap::new(), room, taken: 0 }
    }

    /// Less room, or more, for what is kept from now on.
    pub(super) const fn set_room(&mut self, room: usize) {
        self.room = room;
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
        while self.taken > self.room {
            let ends = [self.kept.keys().next(), self.kept.keys().next_back()];
            let Some(farthest) = ends.into_iter().flatten().copied().max_by_key(|at| at.abs_diff(here))
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
}
