//! Explanations of events: pairs of equal events under two settings, and counterfactuals of one event.

pub mod counterfactual;
pub mod event_pairs;
