//! The parts of a scene.

use serde::{Deserialize, Serialize};

use super::light::Lighting;
use super::motion::BackgroundMotion;
use super::noise::CameraNoise;
use super::occluder::Occluder;
use super::path::Path;
use crate::frame::Size;
use crate::regions::Rgb;

/// All inputs of a scene's pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Its name in the catalogue.
    pub name: String,
    /// Its description, one sentence.
    pub description: String,
    /// Width and height.
    pub size: Size,
    /// Frames per second.
    pub fps: f32,
    /// Number of frames, numbered from 1.
    pub frames: u32,
    /// The seed of textures, noise and the variety of people.
    pub seed: u64,
    /// Its background.
    pub background: Background,
    /// Moving background objects, which are not part of the truth.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub motions: Vec<BackgroundMotion>,
    /// The people; the first one's identity is 1.
    pub actors: Vec<Actor>,
    /// The cars; their identities follow those of the people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cars: Vec<Car>,
    /// The occluders.
    pub occluders: Vec<Occluder>,
    /// The lighting.
    #[serde(default, skip_serializing_if = "Lighting::is_usual")]
    pub light: Lighting,
    /// The amplitude of camera shake in whole pixels, random in every frame.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub jitter: u32,
    /// The camera's noise.
    pub noise: CameraNoise,
    /// Whether people cast a soft contact shadow, which is background in the truth.
    pub shadows: bool,
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
const fn is_zero(number: &u32) -> bool {
    *number == 0
}

/// A background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Background {
    /// A rendered house front above paving slabs.
    Plaza,
    /// A hedge, a lawn, and a gravel path across it.
    Park,
    /// A brick wall above a pavement.
    Street,
    /// A room: a papered wall with a door and pictures above a wooden floor.
    Room,
}

/// A walking person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actor {
    /// Body height in pixels; with a horizon, the height at `path.at`.
    pub height: f32,
    /// Their path.
    pub path: Path,
    /// The row of the horizon. With one, people grow as they approach the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon: Option<f32>,
    /// The initial phase of the gait cycle, 0..1.
    pub phase: f32,
    /// The build; 1 is average.
    pub build: f32,
    /// Their clothes.
    pub clothes: Clothes,
    /// The colour of a broad bag that they carry in front, at arm's length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bag: Option<Rgb>,
    /// The first and last frame in which they hold their arms out, forwards and backwards.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arms_out: Option<[f32; 2]>,
}

impl Actor {
    /// Body height in a frame, in pixels.
    pub fn height_at(&self, frame: f32) -> f32 {
        self.horizon.map_or(self.height, |horizon| {
            let nearness = (self.path.position(frame)[1] - horizon) / (self.path.at[1] - horizon);
            self.height * nearness.clamp(0.2, 5.0)
        })
    }
}

/// A car, in side view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Car {
    /// The length in pixels.
    pub length: f32,
    /// Its path: the point on the ground below its middle.
    pub path: Path,
    /// Its colour.
    pub colour: Rgb,
}

/// A person's clothes, and colours of hair and skin.
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
    /// Whether the upper garment reaches to the thigh.
    pub coat: bool,
}
