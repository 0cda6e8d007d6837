//! Scenes of people who pass behind an occluder.

use super::stage::{Stage, WalkPlan};
use super::{Background, Entry};
use crate::synth::occluder::OccluderKind;
use crate::synth::path::Turn;

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

fn tree(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[1.0]);
    stage.person(3, WalkPlan::right(1.0).meeting(meeting), 0.80);
    stage.occluder(OccluderKind::Tree, 0.93, 1.16, 3.2);
}

fn pole(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[1.0]);
    stage.person(1, WalkPlan::left(1.0).meeting(meeting), 0.80);
    stage.occluder(OccluderKind::Pole, 0.89, 0.11, 2.9);
}

fn wall(stage: &mut Stage) {
    let meeting = stage.earliest_meeting(&[1.0]);
    stage.person(2, WalkPlan::right(1.0).meeting(meeting), 0.80);
    stage.occluder(OccluderKind::Wall, 0.86, 1.7, 0.55);
}

fn wall_edge(stage: &mut Stage) {
    let behind = 0.45 * stage.body();
    let arrival = stage.earliest(&[1.0], 0.5 * stage.width() / stage.body());
    let stay = stage.while_usual(30.0);
    let actor = stage.person(0, WalkPlan::left(1.0).meeting(arrival), 0.80);
    let [speed, _] = actor.path.velocity;
    actor.path.at[0] = behind;
    let stop = Turn { frame: arrival, velocity: [0.0; 2] };
    actor.path.turns = vec![stop, Turn { frame: arrival + stay, velocity: [-speed, 0.0] }];
    stage.occluder(OccluderKind::Wall, 0.86, 1.9, 1.4).at[0] = 0.0;
}
