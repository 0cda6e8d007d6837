//! A region of a group after a demerge, and how well an object fits it.

use crate::regions::{Histogram, Rect};

/// A region of a group after a demerge.
#[derive(Clone, Debug)]
pub(crate) struct SplitRegion {
    /// Its box.
    pub(crate) bbox: Rect,
    /// Its pixels.
    pub(crate) area: f32,
    /// Its colours.
    pub(crate) histogram: Histogram,
}

/// The score of one object for one region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AssociationScore {
    /// Colour similarity, 0..=1.2.
    pub(crate) colour: f32,
    /// Least ΔE between two dominant colours.
    pub(crate) delta_e: f32,
    /// Distance in pixels by which the object's predicted box lies outside the region.
    pub(crate) distance: f32,
    /// Log-likelihood of that distance in nats, at most 0.
    pub(crate) motion: f32,
}
