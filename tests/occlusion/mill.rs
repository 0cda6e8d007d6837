//! Random scenes of people who mill about, more difficult than those of the catalogue. A seed determines a scene.

use occluscope::frame::Size;
use occluscope::synth::noise::CameraNoise;
use occluscope::synth::occluder::{Occluder, OccluderKind};
use occluscope::synth::path::Path;
use occluscope::synth::scene::{Actor, Scene};
use occluscope::synth::{SceneParameters, catalogue};

const SIZE: Size = Size::new(240, 180);
const BODY: f32 = 65.0;
const FRAMES: u32 = 400;

/// The kind of a random scene.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Mill {
    /// Two to four people, some with another at their shoulder.
    Mixed,
    /// Two people who mostly walk towards or away from the camera, so that their size changes.
    Deep,
    /// One or two people, mostly with another at their shoulder.
    Abreast,
}

/// A seeded random number generator.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn within(&mut self, least: f32, most: f32) -> f32 {
        least + (most - least) * self.unit()
    }

    fn chance(&mut self, share: f32) -> bool {
        self.unit() < share
    }
}

impl Mill {
    /// The scene of a seed: people come from both sides, are near the middle at about the same time, stop, turn or
    /// walk on, and leave; sometimes behind an occluder.
    pub(crate) fn scene(self, seed: u64) -> Scene {
        let noise = CameraNoise { sigma: 4.0, signal_dependent: false };
        let parameters = SceneParameters { size: SIZE, seed, noise, ..SceneParameters::default() };
        let scene = |name| catalogue::scene(name, &parameters).expect("a scene of the catalogue");
        let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(7));
        for _ in 0..3 {
            dice.unit();
        }
        let mut dressed = scene("crowd").actors.into_iter();
        let mut actors: Vec<Actor> = Vec::new();
        let mut count = match self {
            Self::Mixed => 2 + (dice.unit() * 3.0) as usize,
            Self::Deep => 2,
            Self::Abreast => 1 + (dice.unit() * 2.0) as usize,
        };
        while actors.len() < count {
            let actor = self.walker(dressed.next().expect("twelve are dressed"), &mut dice);
            let companion = match self {
                Self::Mixed => 0.2,
                Self::Deep => 0.0,
                Self::Abreast => 0.9,
            };
            if dice.chance(companion) {
                let mut other = dressed.next().expect("twelve are dressed");
                other.height = actor.height * dice.within(0.9, 1.05);
                (other.horizon, other.path) = (actor.horizon, actor.path.clone());
                other.path.at[0] += BODY * dice.within(0.22, 0.36);
                other.path.at[1] += dice.within(-3.0, 3.0);
                actors.extend([actor, other]);
                count = count.max(actors.len());
            } else {
                actors.push(actor);
            }
        }
        let occluders = if dice.chance(0.35) { vec![occluder(&mut dice)] } else { Vec::new() };
        Scene { actors, occluders, frames: FRAMES, ..scene("crossing") }
    }

    fn walker(self, mut actor: Actor, dice: &mut Dice) -> Actor {
        let (width, height) = (SIZE.width as f32, SIZE.height as f32);
        let horizon = Some(0.15 * height);
        let (deep, slope) = match self {
            Self::Deep => (0.9, 2.0),
            Self::Mixed | Self::Abreast => (0.4, 1.0),
        };
        actor.height = BODY * dice.within(0.85, 1.15);
        let direction = if dice.chance(0.5) { 1.0 } else { -1.0 };
        let pace = 0.0286 * BODY * dice.within(0.75, 1.5);
        let meeting = dice.within(148.0, 172.0);
        let foot = dice.within(0.62, 0.92) * height;
        let at = [width / 2.0 + dice.within(-22.0, 22.0), foot];
        let mut path = Path::straight(meeting, at, [direction * pace, 0.0]);
        if dice.chance(deep) {
            actor.horizon = horizon;
            path.velocity[1] = dice.within(-0.25, 0.25) * pace * slope;
        }
        if dice.chance(0.45) {
            let stay = dice.within(8.0, 60.0);
            let back = if dice.chance(0.5) { -1.0 } else { 1.0 };
            let leaves = [back * direction * pace, 0.0];
            path = if dice.chance(0.3) {
                actor.horizon = horizon;
                path.then(meeting, [0.0, dice.within(-1.2, 1.2)]).then(meeting + 0.5 * stay, leaves)
            } else {
                path.then(meeting, [0.0; 2]).then(meeting + stay, leaves)
            };
        }
        Actor { path, ..actor }
    }
}

fn occluder(dice: &mut Dice) -> Occluder {
    let (width, height) = (SIZE.width as f32, SIZE.height as f32);
    let kinds =
        [(OccluderKind::Tree, 1.1, 3.0), (OccluderKind::Pole, 0.12, 2.9), (OccluderKind::Wall, 1.4, 0.6)];
    let (kind, across, up) = kinds[(dice.unit() * 3.0) as usize % 3];
    let at = [dice.within(0.1, 0.9) * width, 0.93 * height];
    Occluder { kind, at, width: across * BODY, height: up * BODY, sway: None }
}
