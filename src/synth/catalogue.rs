//! The scenes by name.
//!
//! Lengths are in body heights, so that a scene is the same at every image size. People come from
//! outside the image after [`SETTLE`] frames, which a background model needs to settle.

use serde::{Deserialize, Serialize};

use super::noise::Noise;
use super::occluder::{Occluder, OccluderKind};
use super::scene::{Actor, Background, Clothes, Path, Scene};
use super::texture::unit;
use crate::frame::Size;

/// Nobody is in the image in so many frames at the start.
pub const SETTLE: u32 = 35;

/// Frames a second of every scene.
pub const FPS: f32 = 25.0;

/// A person's height over the image's.
const BODY: f32 = 0.36;

/// An unhurried walk: 1.25 m/s for 1.75 m, in body heights a frame.
const WALK: f32 = 0.0286;

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

/// Every scene, the simplest first.
pub const ENTRIES: [Entry; 9] = [
    Entry {
        name: "crossing",
        description: "Two walkers in different clothes come from opposite sides, cross in the middle and leave.",
        background: Background::Plaza,
        build: crossing,
    },
    Entry {
        name: "tree",
        description: "A walker passes behind a tree that hides all of them for about a second.",
        background: Background::Park,
        build: tree,
    },
    Entry {
        name: "crossing-alike",
        description: "Two walkers in nearly the same clothes cross, one walking, one hurrying.",
        background: Background::Plaza,
        build: crossing_alike,
    },
    Entry {
        name: "overtake",
        description: "Two walkers go the same way; the faster one overtakes in front of the slower.",
        background: Background::Street,
        build: overtake,
    },
    Entry {
        name: "group",
        description: "Three walkers come together in the middle and go on their ways.",
        background: Background::Plaza,
        build: group,
    },
    Entry {
        name: "pair",
        description: "Two walkers go the same way at the same pace, a gap between them.",
        background: Background::Street,
        build: pair,
    },
    Entry {
        name: "pole",
        description: "A walker passes behind a pole narrower than they are.",
        background: Background::Street,
        build: pole,
    },
    Entry {
        name: "wall",
        description: "A walker passes behind a low wall that hides their legs.",
        background: Background::Park,
        build: wall,
    },
    Entry {
        name: "empty",
        description: "Nobody comes; only the camera's noise changes the image.",
        background: Background::Plaza,
        build: empty,
    },
];

/// The scene of that name, or `None` if there is no such scene.
pub fn scene(name: &str, parameters: &Parameters) -> Option<Scene> {
    let entry = ENTRIES.iter().find(|entry| entry.name == name)?;
    let mut stage = Stage::new(*parameters);
    (entry.build)(&mut stage);
    let last_exit = stage.actors.iter().map(|actor| stage.exit_frame(actor)).fold(0.0, f32::max);
    let needed = if stage.actors.is_empty() { 150 } else { last_exit.ceil() as u32 + 15 };
    Some(Scene {
        name: entry.name.to_owned(),
        description: entry.description.to_owned(),
        size: parameters.size,
        fps: FPS,
        frames: parameters.frames.unwrap_or(needed),
        seed: parameters.seed,
        background: entry.background,
        actors: stage.actors,
        occluders: stage.occluders,
        noise: parameters.noise,
        shadows: parameters.shadows,
    })
}

fn crossing(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[0.9, 0.97]);
    stage.person(0, Way::right(0.9).meeting(meeting), 0.80);
    stage.person(1, Way::left(0.97).meeting(meeting), 0.845);
}

fn crossing_alike(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[0.8, 1.4]);
    stage.person(0, Way::right(0.8).meeting(meeting), 0.80);
    stage.person(0, Way::left(1.4).meeting(meeting), 0.845);
    // Nearly the same: a shade lighter, a dye apart.
    let clothes = &mut stage.actors[1].clothes;
    for colour in [&mut clothes.shirt, &mut clothes.trousers] {
        *colour = [colour[0].saturating_add(7), colour[1].saturating_add(4), colour[2].saturating_sub(4)];
    }
}

fn overtake(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[0.75, 1.4]);
    stage.person(0, Way::right(0.75).meeting(meeting), 0.80);
    stage.person(1, Way::right(1.4).meeting(meeting), 0.845);
}

fn group(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[0.85, 0.95, 1.25]);
    stage.person(0, Way::right(0.85).meeting(meeting), 0.785);
    stage.person(1, Way::left(0.95).meeting(meeting), 0.82);
    stage.person(2, Way::right(1.25).meeting(meeting), 0.855);
}

fn pair(stage: &mut Stage) {
    stage.pace_spread = 0.0;
    let meeting = stage.earliest_meeting(&[0.95]);
    stage.person(0, Way::right(0.95).meeting(meeting), 0.805);
    let behind = 1.0 / (0.95 * stage.pace());
    stage.person(1, Way::right(0.95).meeting(meeting + behind), 0.835);
}

fn tree(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[1.0]);
    stage.person(3, Way::right(1.0).meeting(meeting), 0.80);
    stage.occluder(OccluderKind::Tree, 0.93, 1.16, 3.2);
}

fn pole(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[1.0]);
    stage.person(1, Way::left(1.0).meeting(meeting), 0.80);
    stage.occluder(OccluderKind::Pole, 0.89, 0.11, 2.9);
}

fn wall(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[1.0]);
    stage.person(2, Way::right(1.0).meeting(meeting), 0.80);
    stage.occluder(OccluderKind::Wall, 0.86, 1.7, 0.55);
}

fn empty(_: &mut Stage) {}

/// Which way somebody goes and how fast, over the usual walk, and when they are in the middle.
#[derive(Clone, Copy)]
struct Way {
    direction: f32,
    pace: f32,
    middle: f32,
}

impl Way {
    fn right(pace: f32) -> Self {
        Self { direction: 1.0, pace, middle: 0.0 }
    }

    fn left(pace: f32) -> Self {
        Self { direction: -1.0, ..Self::right(pace) }
    }

    fn meeting(self, middle: f32) -> Self {
        Self { middle, ..self }
    }
}

/// A scene while it is being laid out.
struct Stage {
    parameters: Parameters,
    /// How much people's pace differs from one seed to the next.
    pace_spread: f32,
    actors: Vec<Actor>,
    occluders: Vec<Occluder>,
}

impl Stage {
    fn new(parameters: Parameters) -> Self {
        Self { parameters, pace_spread: 0.04, actors: Vec::new(), occluders: Vec::new() }
    }

    fn body(&self) -> f32 {
        BODY * self.parameters.size.height as f32
    }

    /// Body heights a frame.
    fn pace(&self) -> f32 {
        WALK * self.parameters.speed
    }

    /// A number in 0..1 that belongs to the seed and the person.
    fn chance(&self, person: usize, what: i64) -> f32 {
        unit(self.parameters.seed, person as i64, 900 + what)
    }

    /// The way from beyond the image's edge to its middle, in body heights.
    fn half_way(&self) -> f32 {
        0.5 * self.parameters.size.width as f32 / self.body() + 0.36
    }

    /// The first frame in which people of these paces can all be in the middle.
    fn earliest_meeting(&self, paces: &[f32]) -> f32 {
        let slowest = paces.iter().copied().fold(f32::MAX, f32::min) * (1.0 - self.pace_spread);
        SETTLE as f32 + 1.0 + self.half_way() / (slowest * self.pace())
    }

    /// Adds somebody in outfit `outfit` (the seed decides which that is) whose feet are at `foot` of
    /// the image's height.
    fn person(&mut self, outfit: usize, way: Way, foot: f32) {
        let number = self.actors.len();
        let size = self.parameters.size;
        let spread = |chance: f32, share: f32| 1.0 + share * (2.0 * chance - 1.0);
        let height = self.body() * spread(self.chance(number, 1), 0.03);
        let speed = way.pace
            * self.pace()
            * self.body()
            * spread(self.chance(number, 2), self.pace_spread)
            * way.direction;
        let path = Path {
            frame: way.middle,
            at: [size.width as f32 / 2.0, foot * size.height as f32],
            velocity: [speed, 0.0],
        };
        let phase = self.chance(number, 3);
        let build = spread(self.chance(number, 4), 0.07);
        let clothes = outfits(self.parameters.seed)[outfit];
        self.actors.push(Actor { height, path, phase, build, clothes });
    }

    /// Adds something in the middle; width and height in body heights.
    fn occluder(&mut self, kind: OccluderKind, foot: f32, width: f32, height: f32) {
        let size = self.parameters.size;
        let at = [size.width as f32 / 2.0, foot * size.height as f32];
        self.occluders.push(Occluder { kind, at, width: width * self.body(), height: height * self.body() });
    }

    /// The frame in which somebody is surely outside the image again.
    fn exit_frame(&self, actor: &Actor) -> f32 {
        actor.path.frame + self.half_way() * self.body() / actor.path.velocity[0].abs().max(f32::MIN_POSITIVE)
    }
}

/// The wardrobe. Any two outfits differ plainly in shirt and trousers taken together, and all of
/// them from the grounds that people walk on.
const WARDROBE: [Clothes; 4] = [
    Clothes {
        shirt: [176, 34, 40],
        trousers: [38, 44, 66],
        shoes: [44, 34, 30],
        hair: [52, 34, 22],
        skin: [222, 174, 146],
        coat: false,
    },
    Clothes {
        shirt: [34, 74, 140],
        trousers: [84, 66, 48],
        shoes: [30, 30, 34],
        hair: [28, 24, 24],
        skin: [150, 102, 74],
        coat: false,
    },
    Clothes {
        shirt: [226, 178, 52],
        trousers: [32, 34, 38],
        shoes: [214, 208, 200],
        hair: [88, 58, 32],
        skin: [234, 190, 164],
        coat: false,
    },
    Clothes {
        shirt: [92, 36, 92],
        trousers: [24, 30, 52],
        shoes: [60, 44, 34],
        hair: [166, 128, 80],
        skin: [230, 186, 158],
        coat: true,
    },
];

/// The wardrobe in an order that the seed decides; seed 1 has it as it is written.
fn outfits(seed: u64) -> [Clothes; 4] {
    let mut order = WARDROBE;
    if seed != 1 {
        for place in (1..order.len()).rev() {
            order.swap(place, (unit(seed, place as i64, 990) * (place + 1) as f32) as usize);
        }
    }
    order
}
