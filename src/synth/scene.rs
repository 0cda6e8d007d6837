//! What a scene consists of.

use serde::{Deserialize, Serialize};

use super::light::Light;
use super::motion::Motion;
use super::noise::Noise;
use super::occluder::Occluder;
use super::path::Path;
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
    /// What moves there and belongs to the place: nothing of it is in the truth.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub motions: Vec<Motion>,
    /// The people; the first one's identity is 1.
    pub actors: Vec<Actor>,
    /// The cars; their identities follow those of the people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cars: Vec<Car>,
    /// What stands in front of people.
    pub occluders: Vec<Occluder>,
    /// How light it is, where, and when.
    #[serde(default, skip_serializing_if = "Light::is_usual")]
    pub light: Light,
    /// The camera shakes by up to so many whole pixels, anew in every frame.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub jitter: u32,
    /// The camera's noise.
    pub noise: Noise,
    /// Whether people cast a soft shadow at their feet. Shadows belong to nobody in the truth.
    pub shadows: bool,
}

// Serde hands over a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
const fn is_zero(number: &u32) -> bool {
    *number == 0
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
    /// A room: a papered wall with a door and pictures above a wooden floor.
    Room,
}

/// A person who walks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actor {
    /// From sole to crown, in pixels; with a horizon, while they are at `path.at`.
    pub height: f32,
    /// Where they walk.
    pub path: Path,
    /// The row in which the ground would meet the sky; who comes nearer then grows, away from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon: Option<f32>,
    /// Where in the gait cycle they start, 0..1.
    pub phase: f32,
    /// How broad they are; 1 is usual.
    pub build: f32,
    /// What they wear.
    pub clothes: Clothes,
    /// The colour of a broad bag that they carry before them at arm's length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bag: Option<Rgb>,
    /// The first and last frame in which they hold their arms out, to the front and to the back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arms_out: Option<[f32; 2]>,
}

impl Actor {
    /// From sole to crown in a frame, in pixels.
    pub fn height_at(&self, frame: f32) -> f32 {
        self.horizon.map_or(self.height, |horizon| {
            let nearness = (self.path.position(frame)[1] - horizon) / (self.path.at[1] - horizon);
            self.height * nearness.clamp(0.2, 5.0)
        })
    }
}

/// A car, seen from its side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Car {
    /// From bumper to bumper, in pixels.
    pub length: f32,
    /// Where it drives: the point on the ground below its middle.
    pub path: Path,
    /// Its paint.
    pub colour: Rgb,
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
