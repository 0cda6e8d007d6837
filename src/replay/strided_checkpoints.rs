//! Things kept at evenly spaced positions, farther apart as their room fills.

use std::collections::BTreeMap;

/// Things by position, at multiples of a stride that doubles whenever there is no more room.
#[derive(Clone)]
pub(super) struct Spaced<T> {
    /// With the memory that each takes.
    kept: BTreeMap<u32, (T, usize)>,
    stride: u32,
    room: usize,
    taken: usize,
}

impl<T> Spaced<T> {
    /// Room for `room` bytes of things, at first at multiples of `stride`.
    pub(super) const fn new(stride: u32, room: usize) -> Self {
        Self { kept: BTreeMap::new(), stride, room, taken: 0 }
    }

    /// Whether what belongs to this position would be kept.
    pub(super) fn wants(&self, position: u32) -> bool {
        self.room > 0 && position.is_multiple_of(self.stride) && !self.kept.contains_key(&position)
    }

    /// How far it is from a position to the next one that might be wanted, at least 1.
    pub(super) const fn until_next(&self, position: u32) -> u32 {
        self.stride - position % self.stride
    }

    /// Less room, as other things take it, or more.
    pub(super) fn set_room(&mut self, room: usize) {
        self.room = room;
        self.thin();
    }

    /// Keeps a thing of so many bytes, and drops every other one when they take too many.
    pub(super) fn insert(&mut self, position: u32, thing: T, bytes: usize) {
        self.taken += bytes;
        if let Some((_, before)) = self.kept.insert(position, (thing, bytes)) {
            self.taken -= before;
        }
        self.thin();
    }

    /// Drops every other thing until the rest has room.
    fn thin(&mut self) {
        while self.taken > self.room && self.kept.len() > 1 {
            self.stride = self.stride.saturating_mul(2);
            let (stride, taken) = (self.stride, &mut self.taken);
            self.kept.retain(|position, (_, bytes)| {
                let stays = position.is_multiple_of(stride);
                *taken -= if stays { 0 } else { *bytes };
                stays
            });
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
    fn it_thins_evenly_and_never_exceeds_its_room() {
        let mut spaced = Spaced::new(4, 50);
        for position in 1..=200 {
            if spaced.wants(position) {
                spaced.insert(position, position * 10, 10);
            }
            assert!(spaced.kept.len() <= 5 && spaced.taken == 10 * spaced.kept.len());
            let steps: Vec<_> = spaced.kept.keys().copied().collect();
            assert!(steps.windows(2).all(|pair| pair[1] - pair[0] == spaced.stride), "{steps:?}");
            if let Some((at, &thing)) = spaced.at_or_before(position) {
                assert!(thing == at * 10 && position - at < spaced.stride);
            }
        }
        assert_eq!(spaced.stride, 64);
        assert_eq!(spaced.at_or_before(63), None);
        assert_eq!(spaced.at_or_before(130), Some((128, &1280)));
    }

    #[test]
    fn without_room_nothing_is_wanted() {
        let spaced = Spaced::<u8>::new(1, 0);
        assert!(!spaced.wants(0) && !spaced.wants(7));
    }
}
