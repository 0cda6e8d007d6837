//! Correspondence of regions between frames: linearly predictive multiple hypothesis tracking (§VIII).
//!
//! [`kalman`] is one model, [`pool`] the competing models of each moving region and their matching, [`seed_finder`]
//! starts new ones. These follow regions; [`crate::occlusion`] decides which objects are in them.

#![deny(clippy::indexing_slicing)]

pub mod fragments;
pub mod identity_map;
pub mod kalman;
pub mod pool;
pub mod seed_finder;
pub mod track;

pub use identity_map::IdentityMap;
pub use track::{FrameTracks, HypothesisSummary, Identity, ObjectId, Track, TrackState};
