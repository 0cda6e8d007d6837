//! Correspondence of regions between frames: linearly predictive multiple hypothesis tracking (§VIII).

pub mod naming;
pub mod track;
pub mod tracker;

pub use naming::{Key, Naming};
pub use track::{Identity, Track, TrackState};
pub use tracker::Tracker;
