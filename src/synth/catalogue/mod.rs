//! The scenes by name.
//!
//! Lengths are in body heights, so that a scene is the same at every image size. People come from
//! outside the image after [`SETTLE`] frames, which a background model needs to settle.

use serde::{Deserialize, Serialize};

use super::noise::Noise;
use super::scene::{Background, Scene};
use crate::frame::Size;
use stage::Stage;

mod background;
mod occluders;
mod people;
mod stage;
mod wardrobe;

/// Nobody is in the image in so many frames at the start.
pub const SETTLE: u32 = 35;

/// Frames a second of every scene.
pub const FPS: f32 = 25.0;

/// What can be chosen of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Width and height, both even (a video's colours are halved) and at least 64.
    pub size: Size,
    /// How many frames; `None` for as many as the scene needs until everybody has left.
    pub frames: Option<u32>,
    /// Textures, noise, clothes and small differences of pace follow from it.
    pub seed: u64,
    /// The camera's noise.
    pub noise: Noise,
    /// Factor on everybody's speed.
    pub speed: f32,
    /// Whether people cast a soft shadow at their feet.
    pub shadows: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            size: Size::new(320, 240),
            frames: None,
            seed: 1,
            noise: Noise { sigma: 4.0, signal_dependent: false },
            speed: 1.0,
            shadows: false,
        }
    }
}

/// A scene's name and what happens in it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// As the command line takes it.
    pub name: &'static str,
    /// A sentence.
    pub description: &'static str,
    background: Background,
    build: fn(&mut Stage),
}

/// Every scene: those of people, those with something before them, and those whose background does
/// what makes it hard; in each the simplest first.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    people::ENTRIES.iter().chain(&occluders::ENTRIES).chain(&background::ENTRIES)
}

/// The scene of that name, or `None` if there is no such scene.
pub fn scene(name: &str, parameters: &Parameters) -> Option<Scene> {
    let entry = entries().find(|entry| entry.name == name)?;
    let mut stage = Stage::new(*parameters);
    (entry.build)(&mut stage);
    Some(Scene {
        name: entry.name.to_owned(),
        description: entry.description.to_owned(),
        size: parameters.size,
        fps: FPS,
        frames: parameters.frames.unwrap_or_else(|| stage.frames_needed()),
        seed: parameters.seed,
        background: entry.background,
        motions: stage.motions,
        actors: stage.actors,
        cars: stage.cars,
        occluders: stage.occluders,
        light: stage.light,
        jitter: stage.jitter,
        noise: stage.noise,
        shadows: stage.shadows,
    })
}
