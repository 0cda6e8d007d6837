//! Merging, disappearing, demerging, reappearing: Algorithms 1–3, each decision with its evidence.
//!
//! [`reasoner`] takes a frame's regions through tracking and reasoning; it reads as its stages.
//! [`partition`] finds which objects and regions have to do with each other, [`assign`] who is who
//! among the pieces of a group; `splits` and `hidden` hold what is undecided or out of sight.

#![deny(clippy::indexing_slicing)]

mod abreast;
pub mod assign;
mod coherence;
pub mod compare;
pub mod event;
mod groups;
mod hidden;
pub mod lobes;
pub mod meetings;
mod members;
pub mod object;
pub mod partition;
pub mod perspective;
pub mod placing;
mod readout;
pub mod reasoner;
mod splits;
pub mod template;
pub mod what_if;

pub use event::{Comparison, Counters, Episode, EpisodeKind, Event, EventKind, Evidence, Relation};
pub use reasoner::{Ending, Reasoner, Seen, Settled};
