//! Correspondence of regions between frames: linearly predictive multiple hypothesis tracking (§VIII).
//!
//! [`kalman`] is one model, [`pool`] the competing models of each moving region and how they are
//! matched, [`seeds`] where new ones come from. The tracker follows regions; who is in them is for
//! [`crate::occlusion`] to say.

#![deny(clippy::indexing_slicing)]

pub mod fragments;
pub mod kalman;
pub mod naming;
pub mod pool;
pub mod seeds;
pub mod track;

pub use naming::{Key, Naming};
pub use track::{Competing, Identity, Track, TrackState};
