//! Correspondence of regions between frames: linearly predictive multiple hypothesis tracking (§VIII).
//!
//! [`fragments`] joins regions that are parts of one object into detections. [`kalman`] is one model of a moving
//! region, `measurements` finds those of a frame
//! by place, [`pool`] the competing models of each moving region and their matching to the detections of a frame,
//! [`seed_finder`] starts new ones. These follow regions; [`crate::occlusion`] decides which objects are in them.
//! [`track`] and [`identity_map`] are the results. Lengths are in pixels, times in frames.

#![deny(clippy::indexing_slicing)]

pub mod fragments;
pub mod identity_map;
pub mod kalman;
mod measurements;
pub mod pool;
pub mod seed_finder;
pub mod track;

pub use identity_map::IdentityMap;
pub use track::{FrameTracks, HypothesisSummary, Identity, ObjectId, Track, TrackState};
