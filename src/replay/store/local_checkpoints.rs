//! Checkpoints around the playhead, where seeking is most likely.

use std::collections::BTreeMap;

/// Checkpoints by position; the farthest from the playhead are dropped first when they exceed the capacity.
pub(crate) struct LocalCheckpoints<T> {
    /// The checkpoints and their sizes in bytes, by position.
    entries: BTreeMap<u32, (T, usize)>,
    capacity_bytes: usize,
    used_bytes: usize,
    /// The playhead at the last insertion.
    centre: u32,
}

impl<T> LocalCheckpoints<T> {
    /// An empty store with a capacity in bytes.
    pub(crate) const fn new(capacity_bytes: usize) -> Self {
        Self { entries: BTreeMap::new(), capacity_bytes, used_bytes: 0, centre: 0 }
    }

    /// Changes the capacity, in bytes.
    pub(crate) fn set_capacity(&mut self, capacity_bytes: usize) {
        self.capacity_bytes = capacity_bytes;
        self.thin();
    }

    /// Whether there is a checkpoint at this position.
    pub(crate) fn has(&self, position: u32) -> bool {
        self.entries.contains_key(&position)
    }

    /// Stores a checkpoint of `bytes` at `position`, if the capacity around `centre` allows it.
    pub(crate) fn insert(&mut self, position: u32, value: T, bytes: usize, centre: u32) {
        self.used_bytes += bytes;
        if let Some((_, before)) = self.entries.insert(position, (value, bytes)) {
            self.used_bytes -= before;
        }
        self.centre = centre;
        self.thin();
    }

    /// Drops the farthest checkpoints until the others fit.
    fn thin(&mut self) {
        while self.used_bytes > self.capacity_bytes {
            let ends = [self.entries.keys().next(), self.entries.keys().next_back()];
            let Some(farthest) =
                ends.into_iter().flatten().copied().max_by_key(|at| at.abs_diff(self.centre))
            else {
                break;
            };
            if let Some((_, bytes)) = self.entries.remove(&farthest) {
                self.used_bytes -= bytes;
            }
        }
    }

    /// The last checkpoint at or before a position.
    pub(crate) fn at_or_before(&self, position: u32) -> Option<(u32, &T)> {
        self.entries.range(..=position).next_back().map(|(&position, (value, _))| (position, value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_checkpoints_are_dropped_first() {
        let mut checkpoints = LocalCheckpoints::new(30);
        for position in [10, 20, 30] {
            checkpoints.insert(position, position, 10, 30);
        }
        checkpoints.insert(40, 40, 10, 40);
        assert!(!checkpoints.has(10) && checkpoints.has(20) && checkpoints.has(40));
        assert_eq!(checkpoints.at_or_before(35), Some((30, &30)));
        checkpoints.insert(5, 5, 10, 5);
        assert!(!checkpoints.has(40) && checkpoints.has(5) && checkpoints.used_bytes == 30);
        checkpoints.insert(5, 6, 20, 5);
        assert_eq!((checkpoints.at_or_before(9), checkpoints.used_bytes), (Some((5, &6)), 30));
        checkpoints.insert(7, 7, 31, 7);
        assert!(checkpoints.entries.is_empty() && checkpoints.used_bytes == 0, "larger than the capacity");
    }

    #[test]
    fn a_smaller_capacity_drops_the_farthest_checkpoints_at_once() {
        let mut checkpoints = LocalCheckpoints::new(40);
        for position in [10, 20, 30, 40] {
            checkpoints.insert(position, position, 10, 25);
        }
        checkpoints.insert(20, 20, 10, 22);
        checkpoints.set_capacity(25);
        assert!(
            checkpoints.used_bytes == 20 && checkpoints.has(20) && checkpoints.has(30),
            "{:?}",
            checkpoints.entries.keys()
        );
        checkpoints.set_capacity(0);
        assert!(checkpoints.used_bytes == 0 && checkpoints.at_or_before(50).is_none());
    }
}
