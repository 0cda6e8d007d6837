//! Merging, disappearing, demerging, reappearing: Algorithms 1–3, each decision with its evidence.
//!
//! [`tracker`] takes a frame's regions through the stages, one file each: functions of the `context` (settings and
//! frame), the `object_table` (where each object is) and the `decisions` (pending ones, events and episodes).
//! [`partition`] clusters objects and regions that interact, [`assign`] assigns the members of a group to the regions
//! after a demerge.

#![deny(clippy::indexing_slicing)]

pub mod assign;
mod association;
mod births;
mod cluster_update;
mod coherence;
mod confirmation;
mod context;
mod decisions;
mod demerges;
mod detections;
mod emission;
mod episodes;
pub mod event;
mod existence;
#[cfg(test)]
mod fixtures;
mod frame_result;
mod group_changes;
pub mod group_episodes;
mod groups;
pub mod head_count;
mod head_split;
pub mod localisation;
mod lost;
mod member_localisation;
mod member_search;
pub mod object;
mod object_table;
mod object_update;
mod occluded;
pub mod partition;
pub mod perspective;
mod prediction;
mod region_counts;
mod split_member;
pub mod split_region;
pub mod template;
pub mod tracker;

pub use event::{Comparison, Counters, Episode, EpisodeKind, Event, EventKind, Evidence, Relation};
pub use frame_result::{FinalResult, FrameResult, SettledResults};
pub use tracker::Tracker;
