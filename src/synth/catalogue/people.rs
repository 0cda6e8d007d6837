//! Scenes of one person, or of several who cross or meet.

use super::scene_builder::{SceneBuilder, WalkPlan};
use super::{Background, Entry};
use crate::synth::path::{Path, VelocityChange};
use crate::synth::scene::Actor;

/// See [`super::entries`].
pub(super) const ENTRIES: [Entry; 15] = [
    Entry {
        name: "crossing",
        description: "Two walkers in different clothes come from opposite sides, cross in the middle and leave.",
        background: Background::Plaza,
        build: crossing,
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
        name: "crossing-diagonal",
        description: "Two walkers come nearer on diagonals, and cross in the middle.",
        background: Background::Plaza,
        build: crossing_diagonal,
    },
    Entry {
        name: "crossing-steep",
        description: "A walker turns steeply across the way of another, away from the camera, and turns off behind them.",
        background: Background::Plaza,
        build: crossing_steep,
    },
    Entry {
        name: "meet-and-part",
        description: "Two walkers come from opposite sides, stop before each other, and go back the way they came.",
        background: Background::Plaza,
        build: meet_and_part,
    },
    Entry {
        name: "child",
        description: "A child runs after a grown-up, walks on at their side, and both leave as one.",
        background: Background::Park,
        build: child,
    },
    Entry {
        name: "enter-together",
        description: "A walker overtakes another at the image's edge, where both are still entering.",
        background: Background::Street,
        build: enter_together,
    },
    Entry {
        name: "leave-together",
        description: "A walker overtakes another at the image's edge, and both leave as one.",
        background: Background::Street,
        build: leave_together,
    },
    Entry {
        name: "crowd",
        description: "Twelve walkers, far and near, go about in both directions.",
        background: Background::Plaza,
        build: crowd,
    },
    Entry {
        name: "bag",
        description: "A walker's bag has the colour of the ground: what is seen of them splits and rejoins.",
        background: Background::Street,
        build: bag,
    },
    Entry {
        name: "arms",
        description: "A walker stops, holds their arms out for two seconds, and goes on.",
        background: Background::Plaza,
        build: arms,
    },
    Entry {
        name: "room",
        description: "Two people cross in a room.",
        background: Background::Room,
        build: crossing,
    },
];

/// Two people cross in the middle.
pub(super) fn crossing(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[0.9, 0.97]);
    builder.person(0, WalkPlan::right(0.9).meeting(meeting), 0.80);
    builder.person(1, WalkPlan::left(0.97).meeting(meeting), 0.845);
}

fn crossing_alike(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[0.8, 1.4]);
    builder.person(0, WalkPlan::right(0.8).meeting(meeting), 0.80);
    builder.person(0, WalkPlan::left(1.4).meeting(meeting), 0.845);
    // Nearly the same clothes: slightly lighter, of slightly different colour.
    let clothes = &mut builder.actors[1].clothes;
    for colour in [&mut clothes.shirt, &mut clothes.trousers] {
        *colour = [colour[0].saturating_add(7), colour[1].saturating_add(4), colour[2].saturating_sub(4)];
    }
}

fn overtake(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[0.75, 1.4]);
    builder.person(0, WalkPlan::right(0.75).meeting(meeting), 0.80);
    builder.person(1, WalkPlan::right(1.4).meeting(meeting), 0.845);
}

fn group(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[0.85, 0.95, 1.25]);
    builder.person(0, WalkPlan::right(0.85).meeting(meeting), 0.785);
    builder.person(1, WalkPlan::left(0.95).meeting(meeting), 0.82);
    builder.person(2, WalkPlan::right(1.25).meeting(meeting), 0.855);
}

fn pair(builder: &mut SceneBuilder) {
    builder.pace_spread = 0.0;
    let meeting = builder.earliest_meeting(&[0.95]);
    builder.person(0, WalkPlan::right(0.95).meeting(meeting), 0.805);
    let behind = 1.0 / (0.95 * builder.pace());
    builder.person(1, WalkPlan::right(0.95).meeting(meeting + behind), 0.835);
}

/// The row of the plaza's horizon, as a share of the image's height.
const PLAZA_HORIZON: f32 = 40.0 / 240.0;

fn crossing_diagonal(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[0.9, 1.1]);
    let horizon = PLAZA_HORIZON * builder.height();
    // Vertical per horizontal displacement: 0.36 of the image's height between its edges.
    let slope = 0.36 * builder.height() / builder.width();
    let mut goes = |outfit, way: WalkPlan, foot| {
        let actor = builder.person(outfit, way.meeting(meeting), foot);
        actor.path.velocity[1] = slope * actor.path.velocity[0].abs();
        actor.horizon = Some(horizon);
    };
    goes(0, WalkPlan::right(0.9), 0.725);
    goes(1, WalkPlan::left(1.1), 0.785);
}

fn crossing_steep(builder: &mut SceneBuilder) {
    let (meeting, horizon) = (builder.earliest_meeting(&[0.8]), PLAZA_HORIZON * builder.height());
    let height = builder.height();
    builder.person(0, WalkPlan::right(0.8).meeting(meeting), 0.68);
    let (before, after) = (builder.while_usual(16.0), builder.while_usual(22.0));
    let actor = builder.person(1, WalkPlan::left(1.0).meeting(meeting), 0.80);
    let [speed, _] = actor.path.velocity;
    // The vertical speed is three times the horizontal one while they cross the other's path.
    let upwards = [0.35 * speed, speed];
    let [x, y] = actor.path.at;
    let turn = [x - upwards[0] * before, y - upwards[1] * before];
    actor.path = Path::straight(meeting - before, turn, [speed, 0.0])
        .then(meeting - before, upwards)
        .then(meeting + after, [speed, 0.0]);
    actor.height *= (turn[1] - horizon) / (0.80 * height - horizon);
    actor.horizon = Some(horizon);
}

fn meet_and_part(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[0.9, 1.0]);
    let (apart, talk) = (0.16 * builder.body(), builder.while_usual(30.0));
    let turns_back = |actor: &mut Actor| {
        let [speed, _] = actor.path.velocity;
        actor.path.at[0] -= apart / 2.0 * speed.signum();
        let stop = VelocityChange { frame: meeting, velocity: [0.0; 2] };
        actor.path.turns = vec![stop, VelocityChange { frame: meeting + talk, velocity: [-speed, 0.0] }];
    };
    turns_back(builder.person(0, WalkPlan::right(0.9).meeting(meeting), 0.80));
    turns_back(builder.person(1, WalkPlan::left(1.0).meeting(meeting), 0.83));
}

fn child(builder: &mut SceneBuilder) {
    builder.pace_spread = 0.0;
    let joining = builder.earliest_meeting(&[0.7]);
    let beside = 0.10 * builder.body();
    let [walk, _] = builder.person(0, WalkPlan::right(0.7).meeting(joining), 0.80).path.velocity;
    let child = builder.person(1, WalkPlan::right(1.4).meeting(joining), 0.825);
    child.height *= 0.58;
    child.path.at[0] -= beside;
    child.path.turns.push(VelocityChange { frame: joining, velocity: [walk, 0.0] });
}

fn enter_together(builder: &mut SceneBuilder) {
    builder.pace_spread = 0.02;
    let abreast = builder.earliest_meeting(&[0.8, 1.5]);
    let near_edge = 0.97 * builder.body();
    builder.person(0, WalkPlan::right(0.8).meeting(abreast), 0.80).path.at[0] = near_edge;
    builder.person(1, WalkPlan::right(1.5).meeting(abreast), 0.845).path.at[0] = near_edge;
}

fn leave_together(builder: &mut SceneBuilder) {
    builder.pace_spread = 0.02;
    let at_edge = builder.width() + 0.1 * builder.body();
    let abreast = builder.earliest(&[0.8, 1.4], 0.5 * builder.width() / builder.body());
    builder.person(0, WalkPlan::right(0.8).meeting(abreast), 0.80).path.at[0] = at_edge;
    builder.person(1, WalkPlan::right(1.4).meeting(abreast), 0.845).path.at[0] = at_edge;
}

fn crowd(builder: &mut SceneBuilder) {
    builder.body_share = 0.14;
    let first = builder.earliest_meeting(&[0.8]);
    let rows = [0.8, 1.0, 1.15, 0.9].map(|pace| pace * (1.0 + 0.1 * builder.chance(0, 5)));
    for number in 0..12 {
        // Four rows, each with its own path and speed; nearer people are larger.
        let row = number % rows.len();
        let (foot, size) = (0.58 + 0.12 * row as f32, 0.85 + 0.15 * row as f32);
        let way = if row.is_multiple_of(2) { WalkPlan::right(rows[row]) } else { WalkPlan::left(rows[row]) };
        let middle = first + builder.while_usual(25.0 * number as f32);
        builder.person(number, way.meeting(middle), foot).height *= size;
    }
}

/// The pavement's mean colour under the lighting of a bag.
const BAG: [u8; 3] = [182, 179, 173];

fn bag(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[1.0]);
    builder.person(0, WalkPlan::right(1.0).meeting(meeting), 0.82).bag = Some(BAG);
}

fn arms(builder: &mut SceneBuilder) {
    let meeting = builder.earliest_meeting(&[1.0]);
    let (lift, lower, stay) =
        (builder.while_usual(8.0), builder.while_usual(58.0), builder.while_usual(66.0));
    let actor = builder.person(0, WalkPlan::left(1.0).meeting(meeting), 0.80);
    let walk = actor.path.velocity;
    actor.arms_out = Some([meeting + lift, meeting + lower]);
    let stop = VelocityChange { frame: meeting, velocity: [0.0; 2] };
    actor.path.turns = vec![stop, VelocityChange { frame: meeting + stay, velocity: walk }];
}
