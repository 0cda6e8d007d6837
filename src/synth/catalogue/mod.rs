//! The catalogue of scenes by name.
//!
//! Lengths are in body heights, so that a scene is the same at every image size. People enter the image after
//! [`SETTLE`] frames, during which the background model settles.

use serde::{Deserialize, Serialize};

use super::noise::CameraNoise;
use super::scene::{Background, Scene};
use crate::frame::Size;
use scene_builder::SceneBuilder;

mod background;
mod occluders;
mod people;
mod scene_builder;
mod wardrobe;

/// Number of frames at the start without people in the image.
pub const SETTLE: u32 = 35;

/// Frames per second of every scene.
pub const FPS: f32 = 25.0;

/// The parameters of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneParameters {
    /// Width and height, both even (because of chroma subsampling) and at least 64.
    pub size: Size,
    /// Number of frames; `None` for as many as the scene needs until all people have left.
    pub frames: Option<u32>,
    /// The seed of textures, noise, clothes and small differences of pace.
    pub seed: u64,
    /// The camera's noise.
    pub noise: CameraNoise,
    /// Factor on the speed of all people.
    pub speed: f32,
    /// Whether people cast a soft contact shadow.
    pub shadows: bool,
}

impl Default for SceneParameters {
    fn default() -> Self {
        Self {
            size: Size::new(320, 240),
            frames: None,
            seed: 1,
            noise: CameraNoise { sigma: 4.0, signal_dependent: false },
            speed: 1.0,
            shadows: false,
        }
    }
}

/// A scene's name and description.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name on the command line.
    pub name: &'static str,
    /// The description, one sentence.
    pub description: &'static str,
    background: Background,
    build: fn(&mut SceneBuilder),
}

/// All scenes: those of people, those with occluders, and those with difficult backgrounds; the simplest of each
/// group first.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    people::ENTRIES.iter().chain(&occluders::ENTRIES).chain(&background::ENTRIES)
}

/// The scene of this name; `None` if there is none.
pub fn scene(name: &str, parameters: &SceneParameters) -> Option<Scene> {
    let entry = entries().find(|entry| entry.name == name)?;
    let mut builder = SceneBuilder::new(*parameters);
    (entry.build)(&mut builder);
    Some(Scene {
        name: entry.name.to_owned(),
        description: entry.description.to_owned(),
        size: parameters.size,
        fps: FPS,
        frames: parameters.frames.unwrap_or_else(|| builder.frames_needed()),
        seed: parameters.seed,
        background: entry.background,
        motions: builder.motions,
        actors: builder.actors,
        cars: builder.cars,
        occluders: builder.occluders,
        light: builder.light,
        jitter: builder.jitter,
        noise: builder.noise,
        shadows: builder.shadows,
    })
}
