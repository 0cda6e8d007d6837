//! The presentation times of the frames of a video and its key packets, recorded as it is read first.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Largest number of frames between one without a time of its own and the last before it that has one.
const MAX_UNTIMED: usize = 64;

/// How many key packets to go back, one after the other, where decoding from the last one does not give the frame.
const BACK: [usize; 4] = [0, 1, 3, 8];

/// A packet at which decoding can start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Key {
    /// Time of presentation, in ticks of the stream's time base.
    pub(super) pts: Option<i64>,
    /// Time of decoding.
    pub(super) dts: Option<i64>,
}

impl Key {
    /// The time that orders it among frames.
    pub(super) fn time(&self) -> Option<i64> {
        self.pts.or(self.dts)
    }
}

/// The presentation time of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameTime {
    /// In ticks of the stream's time base.
    pub(super) pts: i64,
    /// Whether it is from the file, not computed from the frame before.
    pub(super) is_from_file: bool,
}

/// How to reach a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Approach {
    /// Position of the last frame up to the wanted one that is identified by its time.
    pub(super) anchor: u32,
    /// The anchor's time.
    pub(super) pts: i64,
    /// Key packets before it from which decoding may start, the most promising first.
    pub(super) keys: Vec<Key>,
}

/// An index that the first reader records while others use it.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedIndex(Arc<Mutex<Index>>);

impl SharedIndex {
    /// Waits for the index.
    pub(super) fn lock(&self) -> MutexGuard<'_, Index> {
        // Every change of an index is complete before anything can panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Times of frames and key packets.
#[derive(Debug, Default)]
pub(super) struct Index {
    times: Vec<FrameTime>,
    /// By time.
    keys: Vec<Key>,
    /// Position of the frame at a time; `None` where several have it.
    by_time: HashMap<i64, Option<u32>>,
    /// Whether the video is damaged, and has to be decoded on one thread.
    pub(super) is_damaged: bool,
}

impl Index {
    /// Adds the next frame.
    pub(super) fn push(&mut self, time: FrameTime) {
        if time.is_from_file {
            let position = self.times.len() as u32;
            self.by_time.entry(time.pts).and_modify(|other| *other = None).or_insert(Some(position));
        }
        self.times.push(time);
    }

    /// Adds key packets that are not known yet.
    pub(super) fn add_keys(&mut self, keys: Vec<Key>) {
        for key in keys {
            let Some(time) = key.time() else { continue };
            let at = self.keys.partition_point(|other| other.time() < Some(time));
            if self.keys.get(at).and_then(Key::time) != Some(time) {
                self.keys.insert(at, key);
            }
        }
    }

    /// Number of frames.
    pub(super) fn len(&self) -> u32 {
        self.times.len() as u32
    }

    /// The time of the frame at `position`.
    pub(super) fn time(&self, position: u32) -> Option<FrameTime> {
        self.times.get(position as usize).copied()
    }

    /// How to reach the frame at `position`; `None` where no frame shortly before it is identified by its time.
    pub(super) fn approach(&self, position: u32) -> Option<Approach> {
        let anchor = (position.saturating_sub(MAX_UNTIMED as u32)..=position).rev().find(|&at| {
            self.time(at)
                .is_some_and(|time| time.is_from_file && self.by_time.get(&time.pts) == Some(&Some(at)))
        })?;
        let pts = self.time(anchor)?.pts;
        let before = self.keys.partition_point(|key| key.time().is_some_and(|time| time <= pts));
        let keys = BACK.iter().filter_map(|back| self.keys.get(before.checked_sub(1 + back)?).copied());
        Some(Approach { anchor, pts, keys: keys.collect() })
    }

    /// Number of frames before the one at `position` back to this key packet; all of them where it has no time.
    pub(super) fn distance(&self, key: Option<Key>, position: u32) -> u32 {
        let Some(time) = key.and_then(|key| key.time()) else { return position };
        let before = self.times.iter().take(position as usize).rev();
        before.take_while(|frame| frame.pts >= time).count() as u32
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn key(time: i64) -> Key {
        Key { pts: Some(time), dts: Some(time - 2) }
    }

    fn index(times: &[(i64, bool)], keys: &[i64]) -> Index {
        let mut index = Index::default();
        for &(pts, is_from_file) in times {
            index.push(FrameTime { pts, is_from_file });
        }
        index.add_keys(keys.iter().copied().map(key).collect());
        index
    }

    #[test]
    fn a_frame_is_reached_from_the_last_key_packets_before_it() {
        let times: Vec<_> = (0..100).map(|at| (at * 10, true)).collect();
        let keys: Vec<_> = (0..10).map(|at| at * 100).collect();
        let index = index(&times, &keys);
        let approach = index.approach(55).unwrap();
        assert_eq!((approach.anchor, approach.pts), (55, 550));
        assert_eq!(approach.keys, [key(500), key(400), key(200)]);
        assert_eq!(index.approach(50).unwrap().keys[0], key(500), "a key frame is its own");
        assert_eq!(index.approach(9).unwrap().keys, [key(0)]);
        assert_eq!(index.approach(100).unwrap().anchor, 99);
    }

    #[test]
    fn a_frame_without_a_unique_time_is_counted_from_one_before() {
        let index = index(&[(0, true), (10, true), (20, true), (20, true), (30, false), (40, false)], &[0]);
        assert_eq!([0, 1, 2, 3, 4, 5].map(|at| index.approach(at).unwrap().anchor), [0, 1, 1, 1, 1, 1]);
        let mut untimed = vec![(0, true)];
        untimed.extend((1..90).map(|at| (at, false)));
        let untimed = self::index(&untimed, &[0]);
        assert_eq!(untimed.approach(64).map(|approach| approach.anchor), Some(0));
        assert_eq!(untimed.approach(65), None);
    }

    #[test]
    fn the_distance_to_a_key_packet_is_counted_in_frames() {
        let times: Vec<_> = (0..50).map(|at| (at * 10, true)).collect();
        let index = index(&times, &[0, 200]);
        assert_eq!(index.distance(Some(key(200)), 30), 10);
        assert_eq!(index.distance(Some(key(200)), 20), 0);
        assert_eq!(index.distance(None, 30), 30);
        assert_eq!((index.len(), index.distance(Some(key(0)), index.len())), (50, 50));
    }

    #[test]
    fn key_packets_are_ordered_and_counted_once() {
        let index = index(&[(100, true)], &[50, 10, 30, 10, 50]);
        assert_eq!(index.keys, [10, 30, 50].map(key));
        let without = self::index(&[(5, true)], &[]);
        assert_eq!(without.approach(0).unwrap().keys, []);
    }
}
