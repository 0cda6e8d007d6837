//! Pairs of the events that two analyses of the same frames have in common: of one kind, close in time and position.

use std::collections::{BTreeMap, BTreeSet};

use crate::frame::Size;
use crate::occlusion::Event;

/// The largest differences of two events of one kind that count as the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventTolerance {
    /// Difference of the frame numbers.
    pub frames: u32,
    /// Distance in pixels.
    pub pixels: f32,
}

impl EventTolerance {
    /// The tolerance for a video: one second, and 8 % of the image diagonal.
    pub fn of(size: Size, fps: f32) -> Self {
        Self {
            frames: fps.round().max(1.0) as u32,
            pixels: 0.08 * (size.width as f32).hypot(size.height as f32),
        }
    }

    /// Whether two events may be the same.
    pub fn matches(&self, event: &Event, other: &Event) -> bool {
        event.kind == other.kind
            && event.frame.abs_diff(other.frame) <= self.frames
            && (event.x - other.x).hypot(event.y - other.y) <= self.pixels
    }
}

/// An event of one or both analyses, by its index in the list of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventPair {
    /// Only the first analysis has it.
    First(usize),
    /// Only the second has it.
    Second(usize),
    /// Both have it.
    Both(usize, usize),
}

/// Pairs the events of two timelines, `(position in the sequence, event)` in order of position. The events nearest in
/// time are paired first; the result is in order of time.
///
/// Identities are not compared: two analyses number the same people differently.
pub fn pair_events(
    first: &[(u32, Event)],
    second: &[(u32, Event)],
    tolerance: EventTolerance,
) -> Vec<EventPair> {
    let mut candidates = Vec::new();
    for (i, (position, event)) in first.iter().enumerate() {
        let near = second.partition_point(|(other, _)| other + tolerance.frames < *position);
        let near = second.iter().enumerate().skip(near);
        for (j, (other, beside)) in near.take_while(|(_, (other, _))| *other <= position + tolerance.frames) {
            let distance = (event.x - beside.x).hypot(event.y - beside.y);
            if event.kind == beside.kind && distance <= tolerance.pixels {
                candidates.push((position.abs_diff(*other), distance, i, j));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then((a.2, a.3).cmp(&(b.2, b.3))));
    let (mut of_first, mut of_second) = (BTreeMap::new(), BTreeSet::new());
    for (_, _, i, j) in candidates {
        if !of_first.contains_key(&i) && !of_second.contains(&j) {
            of_first.insert(i, j);
            of_second.insert(j);
        }
    }
    let of_either = first.iter().enumerate().map(|(i, (position, _))| {
        (*position, of_first.get(&i).map_or(EventPair::First(i), |&j| EventPair::Both(i, j)))
    });
    let rest = second.iter().enumerate().filter(|(j, _)| !of_second.contains(j));
    let mut pairs: Vec<(u32, EventPair)> =
        of_either.chain(rest.map(|(j, (position, _))| (*position, EventPair::Second(j)))).collect();
    pairs.sort_by_key(|(position, _)| *position);
    pairs.into_iter().map(|(_, pair_events)| pair_events).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::{EventKind, Evidence};

    fn event(position: u32, kind: EventKind, x: f32) -> (u32, Event) {
        let evidence = Evidence::default();
        let event = Event {
            frame: position + 1,
            kind,
            objects: vec![],
            becomes: vec![],
            pieces: vec![],
            x,
            y: 0.0,
            front: None,
            evidence,
        };
        (position, event)
    }

    const TOLERANCE: EventTolerance = EventTolerance { frames: 10, pixels: 20.0 };

    #[test]
    fn an_event_is_paired_with_the_nearest_in_time_and_with_one_only() {
        use EventKind::{Demerge, Merge};
        let first =
            [event(5, Merge, 0.0), event(9, Merge, 0.0), event(30, Merge, 0.0), event(40, Demerge, 0.0)];
        let second =
            [event(10, Merge, 5.0), event(29, Merge, 50.0), event(41, Demerge, 0.0), event(42, Merge, 0.0)];
        assert_eq!(
            pair_events(&first, &second, TOLERANCE),
            [
                EventPair::First(0),
                EventPair::Both(1, 0),
                EventPair::Second(1),
                EventPair::First(2),
                EventPair::Both(3, 2),
                EventPair::Second(3)
            ]
        );
    }

    #[test]
    fn all_events_of_equal_lists_are_paired() {
        let events: Vec<_> =
            (0..50).map(|at| event(at / 2, EventKind::ALL[at as usize % 7], (at % 5) as f32)).collect();
        let pairs = pair_events(&events, &events, TOLERANCE);
        assert_eq!(pairs, (0..50).map(|at| EventPair::Both(at, at)).collect::<Vec<_>>());
        assert!(pair_events(&[], &[], TOLERANCE).is_empty());
    }
}
