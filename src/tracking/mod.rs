//! Correspondence of regions between frames: linearly predictive multiple hypothesis tracking (§VIII).

pub mod track;

pub use track::{Identity, Track, TrackState};
