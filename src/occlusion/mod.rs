//! Merging, disappearing, demerging, reappearing: Algorithms 1–3, each decision with its evidence.

pub mod event;

pub use event::{Counters, Episode, EpisodeKind, Event, EventKind, Evidence};
