//! Merging, disappearing, demerging, reappearing: Algorithms 1–3, each decision with its evidence.
//!
//! [`tracker`] takes a frame's regions through the stages, one file each: functions of the `context` (settings and
//! frame), the `object_table` (where each object is) and the `decisions` (pending ones, events and episodes). These
//! three are in `state`; the stages are in
//!
//! - `association`: regions become detections, each of a blob or of a new object;
//! - `members`: motion, appearance and existence of the objects in each region;
//! - `heads`: regions with more heads than members;
//! - `identities`: confirmation, re-identification, occlusion and end of objects;
//! - `events`: merges, demerges, episodes, and the emission of all events.
//!
//! No two folders depend on each other: `association`, `members` and `identities` use `events`, `identities` uses
//! `members`, `heads` uses `identities`, and all use `state`.

#![deny(clippy::indexing_slicing)]

mod association;
pub mod event;
mod events;
#[cfg(test)]
mod fixtures;
mod frame_result;
mod heads;
mod identities;
mod members;
mod state;
pub mod tracker;

pub use event::{Comparison, Counters, Episode, EpisodeKind, Event, EventKind, Evidence, Relation};
pub use frame_result::{FinalResult, FrameResult, SettledResults};
pub use tracker::Tracker;
