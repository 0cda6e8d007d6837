//! The track of an object in one frame: the state of its shown hypothesis.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::regions::{Rect, Rgb};

/// An object's number, from its first region on, before it is known whether it is noise: from 1, never reused. The
/// tracks of an object are recorded under its number, or after a demerge under another number of the same sequence,
/// as it may turn out later that they belong to another member of the group.
pub type ObjectId = u32;

/// Identity of a confirmed object throughout a video, from 1.
pub type Identity = u32;

/// The visibility of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrackState {
    /// It has a region of its own.
    Visible,
    /// It shares a region with others.
    Merged,
    /// It has no region; its box is the predicted one.
    Hidden,
}

impl TrackState {
    /// Its name on the screen.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Hidden => "occluded",
            _ => self.name(),
        }
    }

    /// The word for it in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Merged => "merged",
            Self::Hidden => "hidden",
        }
    }
}

/// One of the hypotheses that compete for an object (§VIII).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HypothesisSummary {
    /// Its Kalman model's centre (x, y), in pixels.
    pub centre: [f32; 2],
    /// Half axes (pixels) and angle (radians) of the ellipse within which the centre of its next region may lie.
    pub gate: [f32; 3],
    /// Inverse of the variance of its prediction error.
    pub fitness: f32,
    /// Its share of the likelihood of all competing hypotheses, 0..=1. The shown one need not have the greatest: the
    /// joint matching of all objects is the likeliest.
    pub probability: f32,
    /// Whether it matched a region in this frame, or none (a null match).
    pub matched: bool,
}

/// An object in one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Its identity; 0 while it is tentative.
    pub id: Identity,
    /// The number that it is recorded under, also before the object is confirmed.
    #[serde(skip)]
    pub key: ObjectId,
    /// Its visibility.
    pub state: TrackState,
    /// Its box in pixels, the predicted one while merged or hidden.
    pub bbox: Rect,
    /// The Kalman model's centre (x, y) after the frame's measurement, in pixels.
    pub centre: [f32; 2],
    /// The model's velocity (vx, vy), in pixels per frame period.
    pub velocity: [f32; 2],
    /// The model's size s = √area, in pixels.
    pub scale: f32,
    /// Half axes (pixels) and angle (radians) of the ellipse within which the centre of the next region lies with the
    /// gate's probability.
    pub gate: [f32; 3],
    /// Inverse of the variance of the prediction error.
    pub fitness: f32,
    /// The hypotheses that compete for it, the shown one first; none while no region is followed for it.
    #[serde(skip)]
    pub hypotheses: Arc<[HypothesisSummary]>,
    /// Its visible share, 0..=1.
    pub visible_share: f32,
    /// Its dominant colours, the most frequent first.
    pub colours: Vec<Rgb>,
    /// The labels of the regions that it explains, alone or as a member of a group.
    pub regions: Vec<u32>,
    /// While merged, the identities of the whole group, itself among them (their keys, in tentative tracks).
    pub group: Vec<Identity>,
}

/// The objects of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameTracks {
    /// The frame's number.
    pub number: u32,
    /// Its time in seconds since the source's first frame.
    pub time: f64,
    /// Its confirmed objects.
    pub tracks: Vec<Track>,
}
