//! The values of a pixel as points in its colour space: the data of scatter plots.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::explain::pixel::history::PixelHistory;
use crate::mixture::pixel::MAX_K;

/// Number of age groups when points are grouped by time.
pub const AGES: u8 = 6;

/// How points are grouped by colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointGrouping {
    /// The matched or new component, and the verdict.
    #[default]
    Component,
    /// The mixture's verdict.
    Verdict,
    /// The age of the frame.
    Time,
}

/// The kind of a point; the later kind is drawn over the earlier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PointKind {
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

/// The axes of a scatter plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScatterSpace {
    /// One channel against another.
    Plane(usize, usize),
    /// All three.
    Cube,
    /// The first channel against that of the next frame.
    Next,
}

/// The points that are shown, and their grouping.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScatterSelection {
    /// The axes.
    pub space: ScatterSpace,
    /// Positions of the frames.
    pub frames: Range<usize>,
    /// How they are grouped.
    pub by: PointGrouping,
}

/// A point that some frames share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScatterPoint {
    /// Its kind.
    pub kind: PointKind,
    /// Its coordinates in levels; the third is 0 except in the cube.
    pub at: [u8; 3],
    /// Number of frames.
    pub count: u32,
}

/// The coordinates of the state at `index` in a space, in levels; `None` if there is no such state or no next one.
pub fn coordinates_of(history: &PixelHistory, index: usize, space: ScatterSpace) -> Option<[u8; 3]> {
    let value = history.states.get(index)?.value.map(|level| level as u8);
    Some(match space {
        ScatterSpace::Plane(x, y) => [value[x.min(2)], value[y.min(2)], 0],
        ScatterSpace::Cube => value,
        ScatterSpace::Next => [value[0], history.states.get(index + 1)?.value[0] as u8, 0],
    })
}

/// The distinct points of `choice` of each kind, with their counts. Values are integers, so that a hundred thousand
/// frames give few points.
pub fn scatter_points(
    history: &PixelHistory,
    slots: &[[u8; MAX_K]],
    choice: &ScatterSelection,
) -> Vec<ScatterPoint> {
    let mut counts: BTreeMap<(PointKind, [u8; 3]), u32> = BTreeMap::new();
    for (at, index) in choice.frames.clone().enumerate() {
        let Some((place, slots)) = coordinates_of(history, index, choice.space).zip(slots.get(index)) else {
            break;
        };
        let outcome = &history.states[index].outcome;
        let kind = match choice.by {
            PointGrouping::Component => PointKind::Component {
                slot: slots[usize::from(outcome.rank).saturating_sub(1)],
                foreground: outcome.foreground,
            },
            PointGrouping::Verdict => PointKind::Verdict { foreground: outcome.foreground },
            PointGrouping::Time => {
                PointKind::Age((at * usize::from(AGES) / choice.frames.len().max(1)) as u8)
            }
        };
        *counts.entry((kind, place)).or_default() += 1;
    }
    counts.into_iter().map(|((kind, at), count)| ScatterPoint { kind, at, count }).collect()
}

/// Reduces points to at most `most`: merges points of a kind in cells of increasing size.
pub fn thin_points(mut places: Vec<ScatterPoint>, most: usize) -> Vec<ScatterPoint> {
    let mut cell = 2;
    while places.len() > most && cell < 128 {
        let mut counts: BTreeMap<(PointKind, [u8; 3]), u32> = BTreeMap::new();
        for place in &places {
            // The centre of its cell.
            let at = place.at.map(|level| level / cell * cell + cell / 2);
            *counts.entry((place.kind, at)).or_default() += place.count;
        }
        places = counts.into_iter().map(|((kind, at), count)| ScatterPoint { kind, at, count }).collect();
        cell *= 2;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::pixel::component_slots::slots_by_rank;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    /// Nine dark frames and a bright one, ten times.
    fn history() -> PixelHistory {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colour = |n| if n % 10 == 0 { [200, 150, 100] } else { [20, 30, 40] };
        PixelHistory::of_colours((0, 0), parameters, (1..=100).map(|n| (n, colour(n))))
    }

    fn of(space: ScatterSpace, frames: Range<usize>, by: PointGrouping) -> Vec<ScatterPoint> {
        let history = history();
        scatter_points(&history, &slots_by_rank(&history), &ScatterSelection { space, frames, by })
    }

    #[test]
    fn every_frame_is_counted_once_in_each_space() {
        for (space, dark, bright) in [
            (ScatterSpace::Plane(0, 1), [20, 30, 0], [200, 150, 0]),
            (ScatterSpace::Plane(0, 2), [20, 40, 0], [200, 100, 0]),
            (ScatterSpace::Cube, [20, 30, 40], [200, 150, 100]),
        ] {
            let found = of(space, 0..100, PointGrouping::Verdict);
            let count =
                |at| found.iter().filter(|place| place.at == at).map(|place| place.count).sum::<u32>();
            assert_eq!((count(dark), count(bright)), (90, 10), "{space:?}");
        }
    }

    #[test]
    fn the_delayed_space_has_a_point_for_each_frame_but_the_last() {
        let found = of(ScatterSpace::Next, 0..100, PointGrouping::Verdict);
        let count = |at| found.iter().filter(|place| place.at == at).map(|place| place.count).sum::<u32>();
        assert_eq!(count([20, 20, 0]), 80);
        assert_eq!((count([20, 200, 0]), count([200, 20, 0])), (10, 9), "the last frame has no next value");
    }

    #[test]
    fn thinning_keeps_counts_and_moves_points_little() {
        let places: Vec<_> = (0..=255_u8)
            .map(|level| ScatterPoint {
                kind: PointKind::Age(level % 2),
                at: [level, 255 - level, 7],
                count: 3,
            })
            .collect();
        let few = thin_points(places.clone(), 100);
        assert!(few.len() <= 100 && few.len() > 20, "{}", few.len());
        assert_eq!(few.iter().map(|place| place.count).sum::<u32>(), 3 * 256);
        for place in &places {
            let near = |other: &&ScatterPoint| other.at.iter().zip(place.at).all(|(a, b)| a.abs_diff(b) <= 8);
            assert!(few.iter().filter(near).any(|other| other.kind == place.kind), "{place:?}");
        }
        assert_eq!(thin_points(places.clone(), 256), places, "points are merged only as needed");
    }

    #[test]
    fn kinds_are_those_of_the_states() {
        let found = of(ScatterSpace::Cube, 0..100, PointGrouping::Component);
        let bright = found.iter().find(|place| place.at[0] == 200);
        assert_eq!(bright.map(|place| place.kind), Some(PointKind::Component { slot: 1, foreground: true }));
        let found = of(ScatterSpace::Cube, 50..100, PointGrouping::Time);
        let newest: u32 = found
            .iter()
            .filter(|place| place.kind == PointKind::Age(AGES - 1))
            .map(|place| place.count)
            .sum();
        assert_eq!(newest, 8, "50 frames in six ages: the last begins at 42");
        assert_eq!(found.iter().map(|place| place.count).sum::<u32>(), 50);
    }
}
