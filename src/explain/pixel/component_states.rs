//! The components of a pixel in one frame, as data of tables and plots.

use std::f64::consts::TAU;

use crate::explain::pixel::component_slots::{FIRST_SLOTS, rank_before};
use crate::explain::pixel::history::PixelHistory;
use crate::explain::pixel::verdict::distance_in_sigmas;
use crate::mixture::pixel::{Component, MAX_K};

/// A component in use, and its relation to the frame's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComponentState {
    /// From 1.
    pub rank: usize,
    /// Its slot, which stays the same through changes of rank; see [`crate::explain::pixel::component_slots`].
    pub slot: u8,
    /// The component itself.
    pub component: Component,
    /// Whether its rank is at most B.
    pub background: bool,
    /// Distance of the value from the component before the update, in σ; `None` for a new component.
    pub distance: Option<f32>,
    /// Whether the value matched it.
    pub matched: bool,
    /// Whether the update created it.
    pub new: bool,
}

impl ComponentState {
    /// w·η in one channel: the component's contribution to the density of that channel, with variance σ².
    pub fn marginal(&self, channel: usize, x: f64) -> f64 {
        let variance = f64::from(self.component.variance);
        let off = x - f64::from(self.component.mean[channel]);
        f64::from(self.component.weight) * (-0.5 * off * off / variance).exp() / (TAU * variance).sqrt()
    }

    /// The maximum of w·η in a channel.
    pub fn peak(&self) -> f64 {
        f64::from(self.component.weight) / (TAU * f64::from(self.component.variance)).sqrt()
    }
}

/// T of the pixel for the state at `index`, after its update or `before` it.
pub fn t_at(history: &PixelHistory, index: usize, before: bool) -> f32 {
    let after = history.states.get(index).map(|state| &state.pixel);
    let pixel = if before { history.before(index) } else { after };
    pixel.map_or(history.parameters.t, |pixel| history.parameters.t_of(pixel.past()))
}

/// The components in use at the state at `index`, in rank order, and B.
///
/// These are the components after the update, or `before` it: the ones that the value was compared with. There are
/// none before the first frame.
pub fn component_states(
    history: &PixelHistory,
    slots: &[[u8; MAX_K]],
    index: usize,
    before: bool,
) -> (Vec<ComponentState>, usize) {
    let (Some(state), Some(here)) = (history.states.get(index), slots.get(index)) else {
        return (Vec::new(), 0);
    };
    let old = history.before(index);
    let (pixel, slots, count) = if before {
        let of_before = match index.checked_sub(1) {
            Some(index) => slots.get(index),
            None => Some(&FIRST_SLOTS),
        };
        let Some((old, slots)) = old.zip(of_before) else { return (Vec::new(), 0) };
        (old, slots, old.background_count(history.parameters.t_of(old.past())))
    } else {
        (&state.pixel, here, usize::from(state.outcome.background_count))
    };
    let used = pixel.components().iter().take_while(|component| component.is_used());
    let component_states = used.zip(slots).enumerate().map(|(rank, (&component, &slot))| {
        let was = if before { Some(rank) } else { rank_before(state, rank) };
        let compared = was.and_then(|was| old?.components().get(was)).filter(|old| old.is_used());
        let matched = usize::from(state.outcome.matched);
        ComponentState {
            rank: rank + 1,
            slot,
            component,
            background: rank < count,
            distance: compared.map(|old| distance_in_sigmas(old, state.value)),
            matched: matched > 0 && was == Some(matched - 1),
            new: !before && was.is_none(),
        }
    });
    (component_states.collect(), count)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::explain::pixel::component_slots::slots_by_rank;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    fn history() -> PixelHistory {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colour = |n| if n % 3 == 2 { [200, 190, 180] } else { [40 + (n % 5) as u8, 50, 60] };
        PixelHistory::of_colours((0, 0), parameters, (1..=60).map(|n| (n, colour(n))))
    }

    #[test]
    fn components_before_and_after_the_update_correspond() {
        let history = history();
        let slots = slots_by_rank(&history);
        let (after, count) = component_states(&history, &slots, 40, false);
        let state = &history.states[40];
        assert_eq!(count, usize::from(state.outcome.background_count));
        assert_eq!(after.len(), state.pixel.used());
        assert_eq!(after.iter().filter(|component_state| component_state.matched).count(), 1);
        let (before, _) = component_states(&history, &slots, 40, true);
        for component_state in &after {
            let same = before.iter().find(|other| other.slot == component_state.slot).unwrap();
            assert_eq!((same.distance, same.matched), (component_state.distance, component_state.matched));
        }
        let old = history.before(40).unwrap();
        assert!(
            before
                .iter()
                .zip(old.components())
                .all(|(component_state, component)| component_state.component == *component)
        );
    }

    #[test]
    fn a_new_component_has_no_distance_and_the_first_frame_no_components_before() {
        let history = history();
        let slots = slots_by_rank(&history);
        let (after, _) = component_states(&history, &slots, 1, false);
        let new = after.iter().find(|component_state| component_state.new).unwrap();
        assert_eq!((new.rank, new.distance, new.matched), (2, None, false));
        assert!(component_states(&history, &slots, 0, true).0.is_empty());
        assert!(component_states(&history, &slots, 60, false).0.is_empty());
    }

    #[test]
    fn a_marginal_is_a_density_times_the_weight() {
        let history = history();
        let (after, _) = component_states(&history, &slots_by_rank(&history), 59, false);
        for component_state in after {
            let sum: f64 =
                (-4000..8000).map(|x| component_state.marginal(0, f64::from(x) / 10.0) / 10.0).sum();
            assert!((sum - f64::from(component_state.component.weight)).abs() < 1e-6);
            let top = component_state.marginal(1, f64::from(component_state.component.mean[1]));
            assert!((top - component_state.peak()).abs() < 1e-12);
        }
    }
}
