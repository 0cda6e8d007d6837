//! Builds a scene of the catalogue.

use super::{SETTLE, SceneParameters, wardrobe};
use crate::synth::light::Lighting;
use crate::synth::motion::{BackgroundMotion, MotionKind};
use crate::synth::noise::CameraNoise;
use crate::synth::occluder::{Occluder, OccluderKind};
use crate::synth::path::Path;
use crate::synth::scene::{Actor, Car};
use crate::synth::texture::unit;

/// A person's height relative to the image's.
const BODY: f32 = 0.36;

/// Normal walking speed: 1.25 m/s at a height of 1.75 m, in body heights per frame.
const WALK: f32 = 0.0286;

/// Direction and speed of a walk, relative to the normal speed, and the frame in which it passes the middle.
#[derive(Clone, Copy)]
pub(super) struct WalkPlan {
    direction: f32,
    pace: f32,
    middle: f32,
}

impl WalkPlan {
    pub(super) fn right(pace: f32) -> Self {
        Self { direction: 1.0, pace, middle: 0.0 }
    }

    pub(super) fn left(pace: f32) -> Self {
        Self { direction: -1.0, ..Self::right(pace) }
    }

    pub(super) fn meeting(self, middle: f32) -> Self {
        Self { middle, ..self }
    }
}

pub(super) struct SceneBuilder {
    pub(super) parameters: SceneParameters,
    /// A person's height relative to the image's.
    pub(super) body_share: f32,
    /// Number of frames at the start without people in the image.
    pub(super) settle: u32,
    /// The variation of people's speed between seeds.
    pub(super) pace_spread: f32,
    /// Least number of frames of the scene.
    pub(super) least_frames: u32,
    pub(super) motions: Vec<BackgroundMotion>,
    pub(super) actors: Vec<Actor>,
    pub(super) cars: Vec<Car>,
    pub(super) occluders: Vec<Occluder>,
    pub(super) light: Lighting,
    pub(super) jitter: u32,
    pub(super) noise: CameraNoise,
    pub(super) shadows: bool,
}

impl SceneBuilder {
    pub(super) fn new(parameters: SceneParameters) -> Self {
        Self {
            parameters,
            body_share: BODY,
            settle: SETTLE,
            pace_spread: 0.04,
            least_frames: 0,
            motions: Vec::new(),
            actors: Vec::new(),
            cars: Vec::new(),
            occluders: Vec::new(),
            light: Lighting::default(),
            jitter: 0,
            noise: parameters.noise,
            shadows: parameters.shadows,
        }
    }

    pub(super) fn width(&self) -> f32 {
        self.parameters.size.width as f32
    }

    pub(super) fn height(&self) -> f32 {
        self.parameters.size.height as f32
    }

    pub(super) fn body(&self) -> f32 {
        self.body_share * self.parameters.size.height as f32
    }

    /// The normal speed, in body heights per frame.
    pub(super) fn pace(&self) -> f32 {
        WALK * self.parameters.speed
    }

    /// A duration in frames at normal speed, scaled to the scene's speed.
    pub(super) fn while_usual(&self, frames: f32) -> f32 {
        frames / self.parameters.speed
    }

    /// A pseudo-random number in 0..1 from the seed and the person.
    pub(super) fn chance(&self, person: usize, what: i64) -> f32 {
        unit(self.parameters.seed, person as i64, 900 + what)
    }

    /// The distance from beyond the image's edge to its middle, in body heights.
    fn half_way(&self) -> f32 {
        0.5 * self.parameters.size.width as f32 / self.body() + 0.36
    }

    /// The first frame in which people of these speeds can all be in the middle.
    pub(super) fn earliest_meeting(&self, paces: &[f32]) -> f32 {
        self.earliest(paces, 0.0)
    }

    /// The first frame in which people of these speeds can all be `beyond` body heights past the middle.
    pub(super) fn earliest(&self, paces: &[f32], beyond: f32) -> f32 {
        let slowest = paces.iter().copied().fold(f32::MAX, f32::min) * (1.0 - self.pace_spread);
        self.settle as f32 + 1.0 + (self.half_way() + beyond) / (slowest * self.pace())
    }

    /// Adds a person in outfit `outfit` (the seed determines which one that is) whose feet are at `foot` of the
    /// image's height.
    pub(super) fn person(&mut self, outfit: usize, way: WalkPlan, foot: f32) -> &mut Actor {
        let number = self.actors.len();
        let size = self.parameters.size;
        let spread = |chance: f32, share: f32| 1.0 + share * (2.0 * chance - 1.0);
        let height = self.body() * spread(self.chance(number, 1), 0.03);
        let speed = way.pace
            * self.pace()
            * self.body()
            * spread(self.chance(number, 2), self.pace_spread)
            * way.direction;
        let at = [size.width as f32 / 2.0, foot * size.height as f32];
        let path = Path::straight(way.middle, at, [speed, 0.0]);
        let phase = self.chance(number, 3);
        let build = spread(self.chance(number, 4), 0.07);
        let clothes = wardrobe::outfit(self.parameters.seed, outfit);
        let actor = Actor { height, path, horizon: None, phase, build, clothes, bag: None, arms_out: None };
        self.actors.push(actor);
        &mut self.actors[number]
    }

    /// Adds an occluder in the middle; width and height in body heights.
    pub(super) fn occluder(
        &mut self,
        kind: OccluderKind,
        foot: f32,
        width: f32,
        height: f32,
    ) -> &mut Occluder {
        let number = self.occluders.len();
        let size = self.parameters.size;
        let at = [size.width as f32 / 2.0, foot * size.height as f32];
        let (width, height) = (width * self.body(), height * self.body());
        self.occluders.push(Occluder { kind, at, width, height, sway: None });
        &mut self.occluders[number]
    }

    /// Adds a moving background object: its centre in shares of the image, its width and height in body heights, its
    /// period in frames.
    pub(super) fn motion(&mut self, kind: MotionKind, middle: [f32; 2], extent: [f32; 2], period: f32) {
        let at = [middle[0] * self.width(), middle[1] * self.height()];
        let [width, height] = extent.map(|side| side * self.body());
        self.motions.push(BackgroundMotion { kind, at, width, height, period });
    }

    /// Number of frames until all people have left.
    pub(super) fn frames_needed(&self) -> u32 {
        let reach = self.half_way() * self.body();
        let person = |actor: &Actor| actor.path.last_within(self.width() / 2.0, reach);
        let car = |car: &Car| car.path.last_within(self.width() / 2.0, self.width() / 2.0 + 0.6 * car.length);
        let exits = self.actors.iter().filter_map(person).chain(self.cars.iter().filter_map(car));
        let needed = exits.reduce(f32::max).map_or(150, |last| last.ceil() as u32 + 15);
        needed.max(self.least_frames)
    }
}
