//! Renders a walking person: a pose from the gait cycle, limbs as rounded cones.

use super::layer::Layer;
use super::scene::Actor;
use super::texture::{Colour, lit, smoothstep, value_noise};
use crate::regions::Rgb;

type Point = [f32; 2];

/// Hip flexion in degrees, every tenth of a cycle from heel strike (sagittal gait analysis of adults).
const HIP: [f32; 10] = [30.0, 25.0, 16.0, 6.0, -4.0, -11.0, -6.0, 12.0, 26.0, 32.0];
/// Knee flexion in degrees, at the same phases.
const KNEE: [f32; 10] = [4.0, 16.0, 14.0, 8.0, 5.0, 12.0, 38.0, 60.0, 48.0, 18.0];
/// Ankle flexion in degrees, positive upwards, at the same phases.
const ANKLE: [f32; 10] = [0.0, -6.0, 2.0, 7.0, 10.0, 5.0, -16.0, -8.0, 0.0, 2.0];

/// Distance of a whole cycle (two steps), in body heights, at which the feet do not slide.
const STRIDE: f32 = 0.80;

const THIGH: f32 = 0.245;
const SHIN: f32 = 0.235;
const UPPER_ARM: f32 = 0.165;
const FOREARM: f32 = 0.135;

/// Number of frames for raising or lowering the arms.
const ARM_LIFT: f32 = 10.0;

/// A limb: the convex hull of two discs.
struct Part {
    from: Point,
    to: Point,
    from_radius: f32,
    to_radius: f32,
    colour: Colour,
    grain: u64,
}

/// Interpolates a cyclic table at any phase (Catmull-Rom).
fn cyclic(table: &[f32; 10], phase: f32) -> f32 {
    let place = phase.rem_euclid(1.0) * 10.0;
    let (index, t) = (place as usize, place.fract());
    let point = |offset: usize| table[(index + offset) % 10];
    let (a, b, c, d) = (point(9), point(0), point(1), point(2));
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

fn from_rgb(colour: Rgb) -> Colour {
    colour.map(f32::from)
}

/// The end of a limb of this length, at an angle from straight down, forward positive.
fn hang(from: Point, degrees: f32, length: f32) -> Point {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [from[0] + sin * length, from[1] - cos * length]
}

struct Leg {
    knee: Point,
    ankle: Point,
    heel: Point,
    toe: Point,
}

/// A leg with its hip at the origin, in body heights, forward and up positive. `stride` is the factor on the angles:
/// 0 stands straight.
fn leg(phase: f32, stride: f32) -> Leg {
    let hip = cyclic(&HIP, phase) * stride;
    let shin = hip - cyclic(&KNEE, phase) * stride;
    let knee = hang([0.0, 0.0], hip, THIGH);
    let ankle = hang(knee, shin, SHIN);
    let sole = shin + 90.0 + cyclic(&ANKLE, phase) * stride;
    let heel = hang(hang(ankle, sole, -0.022), sole - 90.0, 0.018);
    Leg { knee, ankle, heel, toe: hang(heel, sole, 0.105) }
}

/// The limbs from the farthest to the nearest, in pixels.
fn pose(actor: &Actor, frame: f32) -> Vec<Part> {
    const SOLE: f32 = 0.019;
    let phase = actor.path.walked(frame) / (STRIDE * actor.height) + actor.phase;
    let (stride, height) = (actor.path.stride(frame), actor.height_at(frame));
    let clothes = &actor.clothes;
    let (near, far) = (leg(phase, stride), leg(phase + 0.5, stride));
    let lowest = [near.heel, near.toe, far.heel, far.toe].iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    let hip = [0.0, SOLE - lowest];

    let ground = actor.path.position(frame);
    let facing = actor.path.facing(frame);
    let to_image = |p: Point| -> Point { [ground[0] + facing * height * p[0], ground[1] - height * p[1]] };
    let mut parts = Vec::with_capacity(24);
    let mut add = |from: Point, from_radius: f32, to: Point, to_radius: f32, colour: Rgb, light: f32| {
        let grain = parts.len() as u64;
        let scale = height * actor.build;
        parts.push(Part {
            from: to_image(from),
            to: to_image(to),
            from_radius: from_radius * scale,
            to_radius: to_radius * scale,
            colour: lit(from_rgb(colour), light),
            grain,
        });
    };
    let on_hip = |p: Point| -> Point { [hip[0] + p[0], hip[1] + p[1]] };
    // The trunk rotates opposite to the pelvis and leans forward slightly.
    let neck = on_hip([0.022, 0.275]);
    let shoulder = on_hip([0.018, 0.255]);
    // An arm swings with the opposite leg.
    let held_out = actor.arms_out.map_or(0.0, |[from, to]| {
        smoothstep(from, from + ARM_LIFT, frame) * smoothstep(to, to - ARM_LIFT, frame)
    });
    let arm = |phase: f32, out: f32, light: f32| {
        let swing = (std::f32::consts::TAU * phase).cos() * stride;
        let upper = 2.0 + 24.0 * swing + out * held_out;
        let elbow = hang(shoulder, upper, UPPER_ARM);
        let wrist = hang(elbow, upper + 20.0 + 10.0 * swing, FOREARM);
        let hand = hang(wrist, upper + 22.0 + 10.0 * swing, 0.032);
        [
            (shoulder, 0.040, elbow, 0.031, clothes.shirt, light),
            (elbow, 0.030, wrist, 0.023, clothes.shirt, light),
            (wrist, 0.019, hand, 0.021, clothes.skin, light),
        ]
    };
    let (far_arm, near_arm) = (arm(phase, -95.0, 0.70), arm(phase + 0.5, 75.0, 0.93));
    for (a, ra, b, rb, colour, light) in far_arm {
        add(a, ra, b, rb, colour, light);
    }
    for (leg, light) in [(&far, 0.72), (&near, 1.0)] {
        let (knee, ankle) = (on_hip(leg.knee), on_hip(leg.ankle));
        add(on_hip(leg.heel), SOLE + 0.004, on_hip(leg.toe), SOLE * 0.9, clothes.shoes, light);
        add(knee, 0.044, ankle, 0.030, clothes.trousers, light);
        add(hip, 0.064, knee, 0.045, clothes.trousers, light);
    }
    add(on_hip([-0.004, -0.005]), 0.070, on_hip([0.0, 0.04]), 0.068, clothes.trousers, 1.0);
    if clothes.coat {
        let hem = (near.knee[0] + far.knee[0]) * 0.25;
        add(on_hip([hem, -0.13]), 0.088, on_hip([0.0, 0.08]), 0.076, clothes.shirt, 0.96);
    }
    add(on_hip([0.0, 0.035]), 0.070, on_hip([0.014, 0.225]), 0.086, clothes.shirt, 1.0);
    add(neck, 0.034, [neck[0] + 0.014, neck[1] + 0.07], 0.032, clothes.skin, 0.86);
    let head = [neck[0] + 0.020, neck[1] + 0.122];
    let at = |forward: f32, up: f32| -> Point { [head[0] + forward, head[1] + up] };
    add(at(-0.016, -0.014), 0.044, at(-0.003, 0.014), 0.057, clothes.hair, 1.0);
    add(at(0.020, -0.040), 0.026, at(0.015, 0.0), 0.042, clothes.skin, 1.0);
    add(at(-0.014, 0.032), 0.034, at(0.016, 0.046), 0.020, clothes.hair, 1.05);
    if let Some(colour) = actor.bag {
        // The bag hangs from the near hand and swings with it.
        let hand = near_arm[2].2;
        let at = |forward: f32| -> Point { [0.6 * hand[0] + forward, hand[1] - 0.085] };
        add(at(-0.125), 0.082, at(0.125), 0.082, colour, 1.0);
    }
    for (a, ra, b, rb, colour, light) in near_arm {
        add(a, ra, b, rb, colour, light);
    }
    parts
}

/// Signed distance to a part's outline, position along it (0..=1) and across it (−1..=1).
fn measure(part: &Part, p: Point) -> (f32, f32, f32) {
    let axis = [part.to[0] - part.from[0], part.to[1] - part.from[1]];
    let offset = [p[0] - part.from[0], p[1] - part.from[1]];
    let length = axis[0].hypot(axis[1]).max(1e-3);
    let along = (offset[0] * axis[0] + offset[1] * axis[1]) / length;
    let across = (axis[0] * offset[1] - axis[1] * offset[0]) / length;
    let shrink = (part.from_radius - part.to_radius) / length;
    // One disc contains the other when their radii differ by more than their distance; the larger one is then the
    // outline.
    let lean = shrink.clamp(-0.999, 0.999);
    let steep = (1.0 - lean * lean).sqrt();
    // The foot of the tangent line on the axis determines whether a disc or the side is nearest.
    let foot = along - across.abs() * lean / steep;
    let distance = if foot <= 0.0 {
        offset[0].hypot(offset[1]) - part.from_radius
    } else if foot >= length {
        (offset[0] - axis[0]).hypot(offset[1] - axis[1]) - part.to_radius
    } else {
        across.abs() * steep + along * lean - part.from_radius
    };
    let s = (along / length).clamp(0.0, 1.0);
    let radius = part.from_radius + (part.to_radius - part.from_radius) * s;
    (distance, s, (across / radius.max(0.5)).clamp(-1.0, 1.0))
}

/// The bounding box of parts in pixels: left, top, right, bottom, the last two exclusive.
fn reach<'a>(parts: impl IntoIterator<Item = &'a Part>) -> [i32; 4] {
    let ends = |part: &'a Part| [(part.from, part.from_radius), (part.to, part.to_radius)];
    parts.into_iter().flat_map(ends).fold([i32::MAX, i32::MAX, i32::MIN, i32::MIN], |reach, (p, radius)| {
        [
            reach[0].min((p[0] - radius - 1.0).floor() as i32),
            reach[1].min((p[1] - radius - 1.0).floor() as i32),
            reach[2].max((p[0] + radius + 1.0).ceil() as i32),
            reach[3].max((p[1] + radius + 1.0).ceil() as i32),
        ]
    })
}

/// Renders a person in a frame, including parts outside the image.
pub fn draw(actor: &Actor, frame: f32, seed: u64) -> Layer {
    let parts = pose(actor, frame);
    let height = actor.height_at(frame);
    let [left, top, right, bottom] = reach(&parts);
    let mut layer = Layer::clear(left, top, (right - left) as usize, (bottom - top) as usize);
    for part in &parts {
        let [part_left, part_top, part_right, part_bottom] = reach([part]);
        for (x, y) in (part_top..part_bottom).flat_map(|y| (part_left..part_right).map(move |x| (x, y))) {
            let (distance, along, across) = measure(part, [x as f32 + 0.5, y as f32 + 0.5]);
            let coverage = (0.5 - distance).clamp(0.0, 1.0);
            if coverage > 0.0 {
                let at = (y - top) as usize * layer.width + (x - left) as usize;
                layer.paint(at, shade(part, along, across, seed, height), coverage);
            }
        }
    }
    layer
}

/// Shading of a round limb lit from the upper left, with the weave and folds of its cloth.
fn shade(part: &Part, along: f32, across: f32, seed: u64, height: f32) -> Colour {
    let axis = [part.to[0] - part.from[0], part.to[1] - part.from[1]];
    let length = axis[0].hypot(axis[1]).max(1e-3);
    let normal = [-axis[1] / length * across, axis[0] / length * across];
    let towards_us = (1.0 - across * across).max(0.0).sqrt();
    let light = (-0.42 * normal[0] - 0.50 * normal[1] + 0.76 * towards_us).max(0.0);
    let fold = value_noise(
        seed ^ (part.grain << 8),
        along * length / (0.045 * height) + 31.0,
        across * 1.3 + 17.0 * part.grain as f32,
    );
    let edge = smoothstep(1.0, 0.7, across.abs());
    lit(part.colour, (0.60 + 0.42 * light) * (0.90 + 0.16 * fold) * (0.94 + 0.06 * edge))
}
