//! One frame through all stages.

use std::sync::Arc;

use crate::frame::Mask;
use crate::occlusion::{Counters, Episode, Event};
use crate::regions::{Labels, Region};
use crate::tracking::Track;

/// What all stages made of one frame: the causal reading, what was known at that frame.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The frame's number in its source.
    pub number: u32,
    /// The frame's place since the model started, from 1.
    pub t: u32,
    /// The foreground in which regions were found: after cleaning, before `min_area`.
    pub mask: Arc<Mask>,
    /// To which region each pixel belongs.
    pub labels: Arc<Labels>,
    /// The regions, by label.
    pub regions: Arc<Vec<Region>>,
    /// The objects that have an identity.
    pub tracks: Arc<Vec<Track>>,
    /// Objects seen in too few frames yet to have one (`id` 0).
    pub tentative: Arc<Vec<Track>>,
    /// The events that were decided in this frame; some may have happened a few frames earlier.
    pub events: Arc<Vec<Event>>,
    /// All events decided up to this frame, by kind.
    pub counters: Counters,
}

/// The final reading of a sequence: short tracks gone, late decisions entered.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Frame by frame in order: its number, and the objects with an identity, by identity.
    pub tracks: Vec<(u32, Vec<Track>)>,
    /// By frame, then in the order of the kinds.
    pub events: Vec<Event>,
    /// By start.
    pub episodes: Vec<Episode>,
    /// The events by kind.
    pub counters: Counters,
}
