//! Scenes of people who pass behind an occluder.

use super::scene_builder::{SceneBuilder, WalkPlan};
use super::{Background, Entry};
use crate::synth::occluder::OccluderKind;
use crate::synth::path::VelocityChange;

/// See [`super::entries`].
pub(super) const ENTRIES: [Entry; 4] = [
    Entry {
        name: "tree",
        description: "A walker passes behind a tree that hides all of them for about a second.",
        background: Background::Park,
        build: tree,
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
        name: "wall-edge",
        description: "A walker goes behind a high wall at the image's edge, stays there, and comes back.",
        background: Background::Street,
        build: wall_edge,
    },
];

fn tree(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[1.0]);
    builder.person(3, WalkPlan::right(1.0).meeting(meeting), 0.80);
    builder.occluder(OccluderKind::Tree, 0.93, 1.16, 3.2);
}

fn pole(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[1.0]);
    builder.person(1, WalkPlan::left(1.0).meeting(meeting), 0.80);
    builder.occluder(OccluderKind::Pole, 0.89, 0.11, 2.9);
}

fn wall(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[1.0]);
    builder.person(2, WalkPlan::right(1.0).meeting(meeting), 0.80);
    builder.occluder(OccluderKind::Wall, 0.86, 1.7, 0.55);
}

fn wall_edge(builder: &mut SceneBuilder) {
    let behind = 0.45 * builder.body();
    let arrival = builder.earliest(&[1.0], 0.5 * builder.width() / builder.body());
    let stay = builder.while_usual(30.0);
    let actor = builder.person(0, WalkPlan::left(1.0).meeting(arrival), 0.80);
    let [speed, _] = actor.path.velocity;
    actor.path.at[0] = behind;
    let stop = VelocityChange { frame: arrival, velocity: [0.0; 2] };
    actor.path.turns = vec![stop, VelocityChange { frame: arrival + stay, velocity: [-speed, 0.0] }];
    builder.occluder(OccluderKind::Wall, 0.86, 1.9, 1.4).at[0] = 0.0;
}
