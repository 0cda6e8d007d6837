//! Merging, disappearing, demerging, reappearing: Algorithms 1–3, each decision with its evidence.
//!
//! [`tracker`] takes a frame's regions through tracking and reasoning. [`partition`] clusters objects and regions
//! that interact, [`assign`] assigns the members of a group to the regions after a demerge; `demerges` and `occluded`
//! hold pending demerges and objects without a region.

#![deny(clippy::indexing_slicing)]

pub mod assign;
mod coherence;
mod demerges;
pub mod event;
mod frame_result;
pub mod group_episodes;
mod groups;
pub mod head_count;
mod head_split;
pub mod localisation;
mod members;
pub mod object;
mod occluded;
pub mod partition;
pub mod perspective;
pub mod template;
pub mod tracker;

pub use event::{Comparison, Counters, Episode, EpisodeKind, Event, EventKind, Evidence, Relation};
pub use tracker::{FinalResult, FrameResult, SettledResults, Tracker};
