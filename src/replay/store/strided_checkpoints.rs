//! Evenly spaced checkpoints.

use std::collections::BTreeMap;

/// Checkpoints by position, at multiples of a stride that doubles whenever the capacity is exceeded.
#[derive(Clone)]
pub(crate) struct StridedCheckpoints<T> {
    /// The checkpoints and their sizes in bytes, by position.
    entries: BTreeMap<u32, (T, usize)>,
    stride: u32,
    capacity_bytes: usize,
    used_bytes: usize,
}

impl<T> StridedCheckpoints<T> {
    /// An empty store with a capacity in bytes and an initial stride.
    pub(crate) const fn new(stride: u32, capacity_bytes: usize) -> Self {
        Self { entries: BTreeMap::new(), stride, capacity_bytes, used_bytes: 0 }
    }

    /// Whether a checkpoint at this position would be kept.
    pub(crate) fn accepts(&self, position: u32) -> bool {
        self.capacity_bytes > 0
            && position.is_multiple_of(self.stride)
            && !self.entries.contains_key(&position)
    }

    /// Distance from a position to the next multiple of the stride, at least 1.
    pub(crate) const fn until_next(&self, position: u32) -> u32 {
        self.stride - position % self.stride
    }

    /// Changes the capacity, in bytes.
    pub(crate) fn set_capacity(&mut self, capacity_bytes: usize) {
        self.capacity_bytes = capacity_bytes;
        self.thin();
    }

    /// Stores a checkpoint of `bytes`, and drops every other one when they exceed the capacity.
    pub(crate) fn insert(&mut self, position: u32, value: T, bytes: usize) {
        self.used_bytes += bytes;
        if let Some((_, before)) = self.entries.insert(position, (value, bytes)) {
            self.used_bytes -= before;
        }
        self.thin();
    }

    /// Drops every other checkpoint until the rest fits.
    fn thin(&mut self) {
        while self.used_bytes > self.capacity_bytes && self.entries.len() > 1 {
            self.stride = self.stride.saturating_mul(2);
            let (stride, used_bytes) = (self.stride, &mut self.used_bytes);
            self.entries.retain(|position, (_, bytes)| {
                let stays = position.is_multiple_of(stride);
                *used_bytes -= if stays { 0 } else { *bytes };
                stays
            });
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
    fn checkpoints_are_evenly_spaced_within_the_capacity() {
        let mut checkpoints = StridedCheckpoints::new(4, 50);
        for position in 1..=200 {
            if checkpoints.accepts(position) {
                checkpoints.insert(position, position * 10, 10);
            }
            assert!(
                checkpoints.entries.len() <= 5 && checkpoints.used_bytes == 10 * checkpoints.entries.len()
            );
            let steps: Vec<_> = checkpoints.entries.keys().copied().collect();
            assert!(steps.windows(2).all(|pair| pair[1] - pair[0] == checkpoints.stride), "{steps:?}");
            if let Some((at, &value)) = checkpoints.at_or_before(position) {
                assert!(value == at * 10 && position - at < checkpoints.stride);
            }
        }
        assert_eq!(checkpoints.stride, 64);
        assert_eq!(checkpoints.at_or_before(63), None);
        assert_eq!(checkpoints.at_or_before(130), Some((128, &1280)));
    }

    #[test]
    fn no_checkpoint_is_accepted_without_capacity() {
        let checkpoints = StridedCheckpoints::<u8>::new(1, 0);
        assert!(!checkpoints.accepts(0) && !checkpoints.accepts(7));
    }
}
