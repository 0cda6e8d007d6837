//! Where a pixel's values lie among its channels: what a scatter plot shows.

use std::collections::BTreeMap;
use std::ops::Range;

use super::history::PixelHistory;
use super::pixel::MAX_K;

/// Steps of age in which places are told apart by time.
pub const AGES: u8 = 6;

/// What tells points apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum By {
    /// The component that was matched or made, and the verdict.
    #[default]
    Component,
    /// The mixture's verdict.
    Verdict,
    /// How long ago it was.
    Time,
}

/// What sort of point one is; the later is drawn over the earlier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A value of this component.
    Component {
        /// The component's slot.
        slot: u8,
        /// Whether the pixel was foreground.
        foreground: bool,
    },
    /// A value with this verdict.
    Verdict {
        /// Whether the pixel was foreground.
        foreground: bool,
    },
    /// A value of this age, 0 the oldest, [`AGES`] − 1 the newest.
    Age(u8),
}

/// Against what a value is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// One channel against another.
    Plane(usize, usize),
    /// All three.
    Cube,
    /// The first channel against that of the next frame.
    Next,
}

/// Which points are shown, and how they are told apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Against what.
    pub space: Space,
    /// Positions of the frames.
    pub frames: Range<usize>,
    /// Told apart by what.
    pub by: By,
}

/// A place that some frames share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Of which sort.
    pub kind: Kind,
    /// Where, in levels; the third is 0 but in the cube.
    pub at: [u8; 3],
    /// How many frames.
    pub count: u32,
}

/// The place of the state at `index` in a space, in levels; `None` where there is no such state or no next one.
pub fn place(history: &PixelHistory, index: usize, space: Space) -> Option<[u8; 3]> {
    let value = history.states.get(index)?.value.map(|level| level as u8);
    Some(match space {
        Space::Plane(x, y) => [value[x.min(2)], value[y.min(2)], 0],
        Space::Cube => value,
        Space::Next => [value[0], history.states.get(index + 1)?.value[0] as u8, 0],
    })
}

/// The places of `choice` by kind, equal ones of a kind once: values are whole numbers, so even a
/// hundred thousand frames come to few places.
pub fn places(history: &PixelHistory, slots: &[[u8; MAX_K]], choice: &Choice) -> Vec<Place> {
    let mut counts: BTreeMap<(Kind, [u8; 3]), u32> = BTreeMap::new();
    for (at, index) in choice.frames.clone().enumerate() {
        let Some((place, slots)) = place(history, index, choice.space).zip(slots.get(index)) else { break };
        let outcome = &history.states[index].outcome;
        let kind = match choice.by {
            By::Component => Kind::Component {
                slot: slots[usize::from(outcome.rank).saturating_sub(1)],
                foreground: outcome.foreground,
            },
            By::Verdict => Kind::Verdict { foreground: outcome.foreground },
            By::Time => Kind::Age((at * usize::from(AGES) / choice.frames.len().max(1)) as u8),
        };
        *counts.entry((kind, place)).or_default() += 1;
    }
    counts.into_iter().map(|((kind, at), count)| Place { kind, at, count }).collect()
}

/// At most so many places: as long as there are more, those of a kind that lie together are made one.
pub fn thinned(mut places: Vec<Place>, most: usize) -> Vec<Place> {
    let mut cell = 2;
    while places.len() > most && cell < 128 {
        let mut counts: BTreeMap<(Kind, [u8; 3]), u32> = BTreeMap::new();
        for place in &places {
            // The middle of its cell.
            let at = place.at.map(|level| level / cell * cell + cell / 2);
            *counts.entry((place.kind, at)).or_default() += place.count;
        }
        places = counts.into_iter().map(|((kind, at), count)| Place { kind, at, count }).collect();
        cell *= 2;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixture::Parameters;
    use crate::mixture::follow::slots;
    use crate::settings::{Preset, Settings};

    /// Nine dark frames and a bright one, ten times.
    fn history() -> PixelHistory {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colour = |n| if n % 10 == 0 { [200, 150, 100] } else { [20, 30, 40] };
        PixelHistory::of_colours((0, 0), parameters, (1..=100).map(|n| (n, colour(n))))
    }

    fn of(space: Space, frames: Range<usize>, by: By) -> Vec<Place> {
        let history = history();
        places(&history, &slots(&history), &Choice { space, frames, by })
    }

    #[test]
    fn every_frame_is_counted_once_in_each_space() {
        for (space, dark, bright) in [
            (Space::Plane(0, 1), [20, 30, 0], [200, 150, 0]),
            (Space::Plane(0, 2), [20, 40, 0], [200, 100, 0]),
            (Space::Cube, [20, 30, 40], [200, 150, 100]),
        ] {
            let found = of(space, 0..100, By::Verdict);
            let count =
                |at| found.iter().filter(|place| place.at == at).map(|place| place.count).sum::<u32>();
            assert_eq!((count(dark), count(bright)), (90, 10), "{space:?}");
        }
    }

    #[test]
    fn the_next_value_is_across_from_each_but_the_last() {
        let found = of(Space::Next, 0..100, By::Verdict);
        let count = |at| found.iter().filter(|place| place.at == at).map(|place| place.count).sum::<u32>();
        assert_eq!(count([20, 20, 0]), 80);
        assert_eq!((count([20, 200, 0]), count([200, 20, 0])), (10, 9), "nothing follows the last");
    }

    #[test]
    fn thinning_loses_no_frame_and_moves_no_place_far() {
        let places: Vec<_> = (0..=255_u8)
            .map(|level| Place { kind: Kind::Age(level % 2), at: [level, 255 - level, 7], count: 3 })
            .collect();
        let few = thinned(places.clone(), 100);
        assert!(few.len() <= 100 && few.len() > 20, "{}", few.len());
        assert_eq!(few.iter().map(|place| place.count).sum::<u32>(), 3 * 256);
        for place in &places {
            let near = |other: &&Place| other.at.iter().zip(place.at).all(|(a, b)| a.abs_diff(b) <= 8);
            assert!(few.iter().filter(near).any(|other| other.kind == place.kind), "{place:?}");
        }
        assert_eq!(thinned(places.clone(), 256), places, "no more than there has to be");
    }

    #[test]
    fn kinds_are_those_of_the_states() {
        let found = of(Space::Cube, 0..100, By::Component);
        let bright = found.iter().find(|place| place.at[0] == 200);
        assert_eq!(bright.map(|place| place.kind), Some(Kind::Component { slot: 1, foreground: true }));
        let found = of(Space::Cube, 50..100, By::Time);
        let newest: u32 =
            found.iter().filter(|place| place.kind == Kind::Age(AGES - 1)).map(|place| place.count).sum();
        assert_eq!(newest, 8, "50 frames in six ages: the last begins at 42");
        assert_eq!(found.iter().map(|place| place.count).sum::<u32>(), 50);
    }
}
