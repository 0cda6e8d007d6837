//! The tracker (the next commit brings it; this one has only its form).

use super::naming::Naming;
use super::track::Track;
use crate::frame::Size;
use crate::occlusion::{Counters, Episode, Event};
use crate::regions::Region;
use crate::settings::Settings;

/// What the tracker says of one frame.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Objects with an identity.
    pub tracks: Vec<Track>,
    /// Objects without one yet.
    pub tentative: Vec<Track>,
    /// All objects under their keys.
    pub objects: Vec<Track>,
    /// Events decided in this frame.
    pub events: Vec<Event>,
}

/// Follows objects.
#[derive(Clone)]
pub struct Tracker {
    naming: Naming,
    counters: Counters,
}

impl Tracker {
    /// A tracker that has seen nothing.
    pub fn new(_settings: &Settings, _size: Size, _fps: f32) -> Self {
        Self { naming: Naming::default(), counters: Counters::default() }
    }

    /// Takes the next frame's regions.
    pub fn step(&mut self, _number: u32, _regions: &[Region]) -> Seen {
        Seen::default()
    }

    /// Events so far, by kind.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Who is who.
    pub fn naming(&self) -> Naming {
        self.naming.clone()
    }

    /// Occlusion episodes so far.
    pub fn episodes(&self) -> Vec<Episode> {
        Vec::new()
    }

    /// Memory of a copy.
    pub fn state_bytes(&self) -> usize {
        size_of::<Self>()
    }
}
