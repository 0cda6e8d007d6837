//! What a scene consists of.

use serde::{Deserialize, Serialize};

use super::noise::Noise;
use super::occluder::Occluder;
use crate::frame::Size;
use crate::regions::Rgb;

/// Everything that decides a scene's pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Its name in the catalogue.
    pub name: String,
    /// What happens in it, a sentence.
    pub description: String,
    /// Width and height.
    pub size: Size,
    /// Frames a second.
    pub fps: f32,
    /// How many frames, numbered from 1.
    pub frames: u32,
    /// Textures, noise and the variety of the people follow from it.
    pub seed: u64,
    /// Where it takes place.
    pub background: Background,
    /// The people; the first one's identity is 1.
    pub actors: Vec<Actor>,
    /// What stands in front of people.
    pub occluders: Vec<Occluder>,
    /// The camera's noise.
    pub noise: Noise,
    /// Whether people cast a soft shadow at their feet. Shadows belong to nobody in the truth.
    pub shadows: bool,
}

/// A place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Background {
    /// A rendered house front above paving slabs.
    Plaza,
    /// A hedge, a lawn, and a gravel path across it.
    Park,
    /// A brick wall above a pavement.
    Street,
}

/// A person who walks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actor {
    /// From sole to crown, in pixels.
    pub height: f32,
    /// Where they walk.
    pub path: Path,
    /// Where in the gait cycle they start, 0..1.
    pub phase: f32,
    /// How broad they are; 1 is usual.
    pub build: f32,
    /// What they wear.
    pub clothes: Clothes,
}

/// A straight way walked at constant speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// The frame in which the person is at `at`; may lie between frames and beyond the scene.
    pub frame: f32,
    /// The point on the ground below the hips, in pixels.
    pub at: [f32; 2],
    /// Pixels a frame, to the right and down.
    pub velocity: [f32; 2],
}

impl Path {
    /// The point on the ground in a frame.
    pub fn position(&self, frame: f32) -> [f32; 2] {
        let passed = frame - self.frame;
        [self.at[0] + self.velocity[0] * passed, self.at[1] + self.velocity[1] * passed]
    }

    /// The signed way from `at` to where they are in a frame, in pixels.
    pub fn walked(&self, frame: f32) -> f32 {
        (frame - self.frame) * self.velocity[0].hypot(self.velocity[1])
    }
}

/// What somebody wears, and their own colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clothes {
    /// Shirt, jumper or coat.
    pub shirt: Rgb,
    /// Trousers.
    pub trousers: Rgb,
    /// Shoes.
    pub shoes: Rgb,
    /// Hair.
    pub hair: Rgb,
    /// Face and hands.
    pub skin: Rgb,
    /// Whether what is worn above reaches to the thigh.
    pub coat: bool,
}
