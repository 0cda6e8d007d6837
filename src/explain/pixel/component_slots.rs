//! Follows the components of a pixel through their changes of rank.
//!
//! An update moves at most one component, so the result is exact. Every component has a *slot* 0..K that it keeps as
//! long as it exists. A new component takes the slot of the one that it replaces, or the first free one.

use crate::explain::pixel::history::{PixelHistory, PixelState};
use crate::mixture::pixel::MAX_K;

/// The ranks, from 0, before and after the update, of the component that the update of `state` matched or created.
///
/// The rank before of a new component is the last one where it replaced another.
fn rank_move(state: &PixelState) -> (usize, usize) {
    let last = state.pixel.components().len() - 1;
    let from = usize::from(state.outcome.matched).checked_sub(1).unwrap_or(last).min(last);
    (from, usize::from(state.outcome.rank).saturating_sub(1).min(from))
}

/// A change of the number or order of a pixel's components by an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentChange {
    /// A component was created in a free slot.
    Born,
    /// A component was created in place of the last.
    Replaced,
    /// A component rose in rank. Ranks from 1.
    Rose {
        /// Its rank before.
        from: u8,
        /// Its rank after.
        to: u8,
    },
}

/// The change by the update of the state at `index`; `None` where no component was created or changed its rank.
pub fn component_change(history: &PixelHistory, index: usize) -> Option<ComponentChange> {
    let outcome = history.states.get(index)?.outcome;
    if outcome.matched == 0 {
        let room = history.before(index).is_none_or(|before| before.used() < before.components().len());
        return Some(if room { ComponentChange::Born } else { ComponentChange::Replaced });
    }
    (outcome.rank < outcome.matched)
        .then_some(ComponentChange::Rose { from: outcome.matched, to: outcome.rank })
}

/// The rank (from 0), before the update of `state`, of the component that has `rank` (from 0) after it; `None` for a
/// component created in this frame.
pub fn rank_before(state: &PixelState, rank: usize) -> Option<usize> {
    let (from, to) = rank_move(state);
    if state.t <= 1 {
        return None;
    }
    if rank == to {
        (state.outcome.matched > 0).then_some(from)
    } else if rank > to && rank <= from {
        Some(rank - 1)
    } else {
        Some(rank)
    }
}

/// The slots by rank before the first frame.
pub(super) const FIRST_SLOTS: [u8; MAX_K] = [0, 1, 2, 3, 4, 5, 6, 7];

/// The slots of the components by rank, for every state of a history; those beyond the components in use have no
/// meaning.
pub fn slots_by_rank(history: &PixelHistory) -> Vec<[u8; MAX_K]> {
    let mut all = Vec::with_capacity(history.states.len());
    extend_slots(&mut all, history);
    all
}

/// Extends the slots of a history's first states by those of its other states.
pub fn extend_slots(all: &mut Vec<[u8; MAX_K]>, history: &PixelHistory) {
    let mut slots = all.last().copied().unwrap_or(FIRST_SLOTS);
    for (index, state) in history.states.iter().enumerate().skip(all.len()) {
        if let Some(before) = history.before(index) {
            let (from, to) = rank_move(state);
            let used = before.used();
            if state.outcome.matched == 0 && used <= from {
                // There was room: the new component takes the first of the free slots, which are the last ones.
                let first = (used..=from).min_by_key(|&rank| slots[rank]).unwrap_or(from);
                slots.swap(first, from);
            }
            slots[to..=from].rotate_right(1);
        }
        all.push(slots);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    /// A pixel that shows three surfaces in turn, in an order that causes changes of rank and replacements.
    fn history() -> PixelHistory {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colours = (0..900_u32).map(|number| {
            let wobble = (number * 7919 % 5) as u8;
            let gray = match (number / 30) % 7 {
                0 | 1 => 40,
                2 => 220,
                3 | 4 => 130,
                5 => (number % 251) as u8,
                _ => 90,
            };
            (number + 1, [gray + wobble % (255 - gray).max(1), gray, gray])
        });
        PixelHistory::of_colours((3, 4), parameters, colours)
    }

    #[test]
    fn a_followed_component_keeps_its_mean_unless_it_was_updated() {
        let history = history();
        let (mut moved, mut replaced) = (0, 0);
        for (index, state) in history.states.iter().enumerate().skip(1) {
            let before = history.before(index).unwrap();
            let touched = usize::from(state.outcome.rank) - 1;
            for (rank, component) in state.pixel.components().iter().enumerate() {
                match rank_before(state, rank) {
                    Some(old) if rank != touched => {
                        assert_eq!(before.components()[old].mean, component.mean, "frame {index}");
                    }
                    Some(old) => moved += usize::from(old != rank),
                    None => replaced += 1,
                }
            }
        }
        assert!(moved > 3 && replaced > 5, "the history contains both: {moved} moved, {replaced} new");
    }

    #[test]
    fn a_component_change_agrees_with_the_components_before_and_after() {
        let history = history();
        let k = history.parameters.k;
        let (mut born, mut replaced, mut rose) = (0, 0, 0);
        for index in 1..history.states.len() {
            let (before, after) = (history.before(index).unwrap(), history.states[index].pixel);
            match component_change(&history, index) {
                Some(ComponentChange::Born) => {
                    born += 1;
                    assert_eq!(after.used(), before.used() + 1);
                }
                Some(ComponentChange::Replaced) => {
                    replaced += 1;
                    assert_eq!((before.used(), after.used()), (k, k));
                    let gone = before.components()[k - 1].mean;
                    let lives_on = after.components().iter().any(|component| component.mean == gone);
                    assert!(!lives_on || history.states[index].value == gone, "frame {index}");
                }
                Some(ComponentChange::Rose { from, to }) => {
                    rose += 1;
                    let passed = before.components()[usize::from(to) - 1];
                    assert_eq!(after.components()[usize::from(to)].mean, passed.mean, "frame {index}");
                    assert!(from > to);
                }
                None => assert_eq!(after.used(), before.used()),
            }
        }
        assert!(
            born == k - 1 && replaced > 3 && rose > 1,
            "the history contains all: {born} born, {replaced} replaced, {rose} rose"
        );
        assert_eq!(component_change(&history, 0), Some(ComponentChange::Born));
        assert_eq!(component_change(&history, history.states.len()), None);
    }

    #[test]
    fn slots_are_unique_and_constant_for_a_component() {
        let history = history();
        let slots = slots_by_rank(&history);
        assert_eq!(slots.len(), history.states.len());
        for (index, state) in history.states.iter().enumerate().skip(1) {
            let k = state.pixel.components().len();
            let mut sorted = slots[index][..k].to_vec();
            sorted.sort_unstable();
            assert!(sorted.iter().enumerate().all(|(slot, &found)| slot == usize::from(found)));
            for rank in 0..state.pixel.used() {
                if let Some(old) = rank_before(state, rank) {
                    assert_eq!(slots[index][rank], slots[index - 1][old], "frame {index} rank {rank}");
                }
            }
        }
    }

    #[test]
    fn extended_slots_equal_those_of_the_whole_history() {
        let whole = history();
        let mut grown = Vec::new();
        for end in [0, 1, 2, 450, 451, 900] {
            let part = PixelHistory { states: whole.states[..end].to_vec(), ..whole.clone() };
            extend_slots(&mut grown, &part);
            assert_eq!(grown, slots_by_rank(&part), "{end} frames");
        }
    }

    #[test]
    fn new_components_take_the_slots_in_order_while_there_is_room() {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colours = [[10; 3], [100; 3], [200; 3]].into_iter().enumerate();
        let history =
            PixelHistory::of_colours((0, 0), parameters, colours.map(|(at, rgb)| (at as u32 + 1, rgb)));
        let slots = slots_by_rank(&history);
        for (frame, expected) in [(0, 0), (1, 1), (2, 2)] {
            let rank = usize::from(history.states[frame].outcome.rank) - 1;
            assert_eq!(slots[frame][rank], expected);
        }
    }
}
