//! Scenes with backgrounds that are difficult to model.

use super::scene_builder::{SceneBuilder, WalkPlan};
use super::{Background, Entry, people};
use crate::synth::light::Shade;
use crate::synth::motion::MotionKind;
use crate::synth::occluder::{OccluderKind, Sway};
use crate::synth::path::Path;
use crate::synth::scene::Car;

/// Number of frames for learning recurring background before people pass.
const LEARNING: u32 = 150;

/// See [`super::entries`].
pub(super) const ENTRIES: [Entry; 14] = [
    Entry {
        name: "empty",
        description: "Nobody comes; only the camera's noise changes the image.",
        background: Background::Plaza,
        build: empty,
    },
    Entry {
        name: "car",
        description: "A car drives in, parks long enough to become background, and drives off.",
        background: Background::Street,
        build: car,
    },
    Entry {
        name: "swaying-tree",
        description: "A tree sways in the wind; a walker passes in front of it.",
        background: Background::Park,
        build: swaying_tree,
    },
    Entry {
        name: "flag",
        description: "A flag waves; a walker passes in front of it.",
        background: Background::Plaza,
        build: flag,
    },
    Entry {
        name: "lamp",
        description: "A lamp flashes twice in three seconds; a walker passes in front of it.",
        background: Background::Street,
        build: lamp,
    },
    Entry {
        name: "monitor",
        description: "A dark bar rolls down a computer monitor's picture; somebody passes in front of it.",
        background: Background::Room,
        build: monitor,
    },
    Entry {
        name: "glints",
        description: "The light glints on a pond; a walker passes in front of it.",
        background: Background::Park,
        build: glints,
    },
    Entry {
        name: "slow-light",
        description: "The whole image brightens by 40 % over 300 frames; two walkers cross meanwhile.",
        background: Background::Plaza,
        build: slow_light,
    },
    Entry {
        name: "sudden-light",
        description: "The whole image brightens by 40 % from one frame to the next; a walker comes later.",
        background: Background::Room,
        build: sudden_light,
    },
    Entry {
        name: "low-light",
        description: "Two walkers cross at night: little light, and twice the noise.",
        background: Background::Street,
        build: low_light,
    },
    Entry {
        name: "jitter",
        description: "Two walkers cross while the camera shakes by a pixel.",
        background: Background::Plaza,
        build: jitter,
    },
    Entry {
        name: "shadows",
        description: "Two walkers cross, soft shadows at their feet.",
        background: Background::Plaza,
        build: shadows,
    },
    Entry {
        name: "shade",
        description: "A walker goes out of the light, where noise is high, into deep shade, where it is low.",
        background: Background::Plaza,
        build: shade,
    },
    Entry {
        name: "passers-by",
        description: "Somebody passes every eight seconds, for two minutes, while the light comes and goes.",
        background: Background::Plaza,
        build: passers_by,
    },
];

fn empty(_: &mut SceneBuilder) {}

/// Number of frames that a car is parked: the default model takes about 120 to make it background.
const PARKED: f32 = 200.0;

fn car(builder: &mut SceneBuilder) {
    builder.body_share = 0.2;
    let length = 2.45 * builder.body();
    let drive = 5.0 * builder.pace() * builder.body();
    let brake = builder.while_usual(8.0);
    // The braking distance.
    let rolls = brake * (0.66 + 0.33) * drive;
    let from = -0.6 * length;
    let braking = LEARNING as f32 + (0.5 * builder.width() - rolls - from) / drive;
    let [parks, leaves] = [braking + 2.0 * brake, braking + 2.0 * brake + PARKED];
    let at = |share: f32| [share * drive, 0.0];
    let path = Path::straight(LEARNING as f32, [from, 0.965 * builder.height()], at(1.0))
        .then(braking, at(0.66))
        .then(braking + brake, at(0.33))
        .then(parks, at(0.0))
        .then(leaves, at(0.33))
        .then(leaves + brake, at(0.66))
        .then(leaves + 2.0 * brake, at(1.0));
    builder.cars.push(Car { length, path, colour: [150, 32, 36] });
}

/// A person passes after [`LEARNING`] frames.
fn passes(builder: &mut SceneBuilder, outfit: usize) {
    builder.settle = LEARNING;
    let meeting = builder.earliest_meeting(&[1.0]);
    builder.person(outfit, WalkPlan::right(1.0).meeting(meeting), 0.86);
}

fn swaying_tree(builder: &mut SceneBuilder) {
    passes(builder, 0);
    let (column, reach) = (0.62 * builder.width(), 0.05 * builder.body());
    let tree = builder.occluder(OccluderKind::Tree, 0.58, 0.26, 1.9);
    tree.at[0] = column;
    tree.sway = Some(Sway { reach, period: 60.0 });
}

fn flag(builder: &mut SceneBuilder) {
    passes(builder, 0);
    builder.motion(MotionKind::Flag, [0.62, 0.30], [0.80, 0.50], 24.0);
}

fn lamp(builder: &mut SceneBuilder) {
    passes(builder, 0);
    builder.motion(MotionKind::Lamp, [0.62, 0.52], [0.17, 0.17], 37.0);
}

fn monitor(builder: &mut SceneBuilder) {
    passes(builder, 0);
    builder.motion(MotionKind::Monitor, [0.60, 0.58], [0.66, 0.50], 31.0);
}

fn glints(builder: &mut SceneBuilder) {
    passes(builder, 0);
    builder.motion(MotionKind::Glints, [0.60, 0.54], [2.0, 0.42], 16.0);
}

fn slow_light(builder: &mut SceneBuilder) {
    people::crossing(builder);
    builder.light.gains = vec![(51.0, 0.68), (351.0, 0.68 * 1.4)];
    builder.least_frames = 400;
}

fn sudden_light(builder: &mut SceneBuilder) {
    passes(builder, 1);
    builder.light.gains = vec![(119.0, 0.68), (120.0, 0.68 * 1.4)];
}

fn low_light(builder: &mut SceneBuilder) {
    people::crossing(builder);
    builder.light.gains = vec![(0.0, 0.4)];
    builder.noise.sigma *= 2.0;
}

fn jitter(builder: &mut SceneBuilder) {
    people::crossing(builder);
    builder.jitter = 1;
}

fn shadows(builder: &mut SceneBuilder) {
    people::crossing(builder);
    builder.shadows = true;
}

fn shade(builder: &mut SceneBuilder) {
    passes(builder, 2);
    let from = 0.5 * builder.width();
    builder.light.shade = Some(Shade { from, softness: 0.03 * builder.width(), light: 0.22 });
    builder.noise.signal_dependent = true;
}

fn passers_by(builder: &mut SceneBuilder) {
    const EVERY: u32 = 200;
    // Identities are stored as bytes in the truth's images.
    const MOST: u32 = 250;
    let frames = builder.parameters.frames.unwrap_or(3000);
    builder.least_frames = frames;
    let meeting = builder.earliest_meeting(&[0.8]);
    for number in 0..(frames / EVERY).clamp(1, MOST) {
        // Four people return repeatedly.
        let who = number as usize % 4;
        let pace = 0.8 + 0.5 * builder.chance(who, 5);
        let way = if number.is_multiple_of(2) { WalkPlan::right(pace) } else { WalkPlan::left(pace) };
        let middle = meeting + (number * EVERY) as f32;
        builder.person(who, way.meeting(middle), 0.76 + 0.1 * builder.chance(who, 6));
    }
    let hour = |number: u32| ((number * 500) as f32, if number.is_multiple_of(2) { 0.7 } else { 0.95 });
    builder.light.gains = (0..=frames / 500 + 1).map(hour).collect();
}
