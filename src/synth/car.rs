//! Renders a car in side view.

use super::layer::Layer;
use super::scene::Car;
use super::texture::{Colour, lit, mix_colour, smoothstep};

/// Samples per pixel along each axis.
const SAMPLES: i32 = 3;

/// Lengths are relative to the car's length. Distance of the axles from its middle.
const AXLE: f32 = 0.31;
const WHEEL: f32 = 0.075;
/// Height of the roof above the ground.
const HEIGHT: f32 = 0.33;

/// Renders a car in a frame, including parts outside the image.
pub fn draw(car: &Car, frame: f32) -> Layer {
    let [x, y] = car.path.position(frame);
    let facing = car.path.facing(frame);
    let roll = car.path.walked(frame) / (WHEEL * car.length);
    let (left, right) = ((x - 0.56 * car.length).floor() as i32, (x + 0.56 * car.length).ceil() as i32);
    let (top, bottom) =
        ((y - (HEIGHT + 0.01) * car.length).floor() as i32, (y + 0.05 * car.length).ceil() as i32);
    let mut layer = Layer::clear(left, top, (right - left) as usize, (bottom - top) as usize);
    for (at, column, row) in layer.places() {
        let mut shade = 0.0;
        for sample in 0..SAMPLES * SAMPLES {
            let part = |index: i32| (index as f32 + 0.5) / SAMPLES as f32;
            let forward = (column as f32 + part(sample % SAMPLES) - x) / car.length * facing;
            let up = (y - row as f32 - part(sample / SAMPLES)) / car.length;
            let share = 1.0 / (SAMPLES * SAMPLES) as f32;
            if let Some(colour) = look(car.colour.map(f32::from), forward, up, roll) {
                layer.coverage[at] += share;
                for (sum, channel) in layer.colour[at].iter_mut().zip(colour) {
                    *sum += channel * share;
                }
            } else {
                shade += share * 0.45 * smoothstep(1.0, 0.5, (forward / 0.53).hypot((up + 0.004) / 0.03));
            }
        }
        // The shadow below is not part of the silhouette and must not make a pixel solid.
        if layer.coverage[at] < Layer::SOLID {
            layer.coverage[at] = (layer.coverage[at] + shade).min(Layer::SOLID - 0.01);
        }
    }
    layer
}

/// The colour of a point of the car, `forward` of its middle and `up` from the ground.
fn look(paint: Colour, forward: f32, up: f32, roll: f32) -> Option<Colour> {
    for axle in [-AXLE, AXLE] {
        let (dx, dy) = (forward - axle, up - WHEEL);
        let away = dx.hypot(dy) / WHEEL;
        if away < 1.0 {
            let spoke = (5.0 * (dy.atan2(dx) + roll)).cos();
            let rim = mix_colour([70.0; 3], [178.0; 3], smoothstep(-0.1, 0.4, spoke));
            return Some(if away < 0.62 { rim } else { [26.0, 26.0, 28.0] });
        }
    }
    let (body_top, belt) = (0.205 - 0.045 * smoothstep(0.30, 0.50, forward), 0.185);
    let nose = 0.5 - 0.03 * (1.0 - smoothstep(0.06, 0.14, up)) - 0.02 * smoothstep(0.12, 0.20, up);
    let in_arch = [-AXLE, AXLE].iter().any(|axle| (forward - axle).hypot(up - WHEEL) < 1.18 * WHEEL);
    let in_body = (0.05..body_top).contains(&up) && forward.abs() < nose && !in_arch;
    // The cabin narrows towards the roof, more at the windscreen than at the back.
    let t = (up - belt) / (HEIGHT - belt);
    let (back, front) = (-0.41 + 0.10 * t, 0.20 - 0.17 * t);
    let round = HEIGHT - 0.012 * smoothstep(0.10, 0.19, (forward + 0.13).abs());
    let in_cabin = up >= belt && up < round && (back..front).contains(&forward);
    if in_cabin {
        let edge = (up - belt - 0.018)
            .min(HEIGHT - 0.026 - up)
            .min(forward - back - 0.03)
            .min(front - 0.022 - forward);
        let pillar = (forward + 0.09).abs() - 0.008;
        if edge.min(pillar) > 0.0 {
            let sky = mix_colour([38.0, 46.0, 54.0], [120.0, 138.0, 150.0], 0.2 + 0.7 * t - 0.3 * forward);
            return Some(sky);
        }
        return Some(lit(paint, 1.12));
    }
    if !in_body {
        return (in_arch && up < 0.19 && up > WHEEL).then_some([24.0, 24.0, 26.0]);
    }
    if up > 0.125 && up < 0.155 && forward > nose - 0.045 {
        return Some([238.0, 232.0, 206.0]);
    }
    if up > 0.13 && up < 0.165 && forward < 0.03 - nose {
        return Some([158.0, 26.0, 24.0]);
    }
    let bumper = smoothstep(0.085, 0.075, up);
    let seam = smoothstep(0.004, 0.002, (forward - 0.10).abs().min((forward + 0.16).abs()));
    // The curved side reflects the sky above its crease and the road below.
    let light = 0.74 + 0.40 * smoothstep(0.08, 0.20, up) - 0.10 * smoothstep(0.148, 0.152, up) - 0.25 * seam;
    Some(mix_colour(lit(paint, light), [46.0, 46.0, 48.0], bumper))
}
