//! Background scenes: the static image without people.

use rayon::prelude::*;

use super::scene::Background;
use super::texture::{Colour, fractal_noise, lit, mix_colour, salted, smoothstep, unit};
use crate::frame::Size;

/// Samples per pixel along each axis.
const SAMPLES: u32 = 3;

/// Renders a background without noise: a colour for each pixel, row by row, 0..=255 but not rounded.
pub fn draw(place: Background, size: Size, seed: u64) -> Vec<Colour> {
    // Textures are defined for an image 240 rows high and scaled to other sizes, so that a scene looks the same at
    // every size.
    let scale = 240.0 / size.height as f32;
    let width = size.width as f32 * scale;
    let colour_at = |x: f32, y: f32| match place {
        Background::Plaza => plaza(x, y, width, seed),
        Background::Park => park(x, y, width, seed),
        Background::Street => street(x, y, width, seed),
        Background::Room => room(x, y, width, seed),
    };
    (0..size.pixels())
        .into_par_iter()
        .map(|at| {
            let (column, row) = ((at % size.width as usize) as f32, (at / size.width as usize) as f32);
            let mut sum = [0.0; 3];
            for sample in 0..SAMPLES * SAMPLES {
                let dx = ((sample % SAMPLES) as f32 + 0.5) / SAMPLES as f32;
                let dy = ((sample / SAMPLES) as f32 + 0.5) / SAMPLES as f32;
                let colour = colour_at((column + dx) * scale, (row + dy) * scale);
                sum = [sum[0] + colour[0], sum[1] + colour[1], sum[2] + colour[2]];
            }
            let mean = sum.map(|channel| channel / (SAMPLES * SAMPLES) as f32);
            lit(mean, vignette(column * scale / width - 0.5, row / size.height as f32 - 0.5))
        })
        .collect()
}

/// Vignetting: the lens is darker towards the corners.
fn vignette(x: f32, y: f32) -> f32 {
    1.06 - 0.30 * (x * x + y * y)
}

/// The point of the ground plane at an image point, in units of the camera's height: to the right of the centre, and
/// away from the camera.
fn ground(x: f32, y: f32, width: f32, horizon: f32) -> (f32, f32) {
    let depth = 120.0 / (y - horizon).max(1.0);
    ((x - width / 2.0) / 150.0 * depth, depth)
}

/// Slabs or bricks in rows, each row shifted by `shift` relative to the previous one: the index of the stone, and the
/// distance of a point to its edge, in the given units.
fn stones(u: f32, v: f32, length: f32, height: f32, shift: f32) -> (i64, i64, f32) {
    let row = (v / height).floor();
    let along = u / length + shift * row.rem_euclid(2.0);
    let column = along.floor();
    let (s, t) = (along - column, v / height - row);
    let edge = (s.min(1.0 - s) * length).min(t.min(1.0 - t) * height);
    (column as i64, row as i64, edge)
}

fn plaza(x: f32, y: f32, width: f32, seed: u64) -> Colour {
    const FOOT_OF_HOUSE: f32 = 112.0;
    if y < FOOT_OF_HOUSE {
        return house(x, y, width, seed);
    }
    let (u, v) = ground(x, y, width, 40.0);
    let (column, row, edge) = stones(u, v, 0.26, 0.13, 0.5);
    let tint = unit(salted(seed, 11), column, row);
    let stain = fractal_noise(salted(seed, 12), u * 5.0, v * 9.0, 4);
    let grain = fractal_noise(salted(seed, 13), x * 0.5, y * 0.5, 3);
    let slab = mix_colour([168.0, 161.0, 151.0], [200.0, 189.0, 173.0], tint);
    let slab = lit(slab, 0.80 + 0.22 * stain + 0.18 * (grain - 0.5));
    let joint = lit([122.0, 115.0, 106.0], 0.9 + 0.2 * grain);
    let stone = mix_colour(joint, slab, smoothstep(0.003, 0.009, edge));
    // The faint contact shadow of the house.
    lit(stone, 0.80 + 0.20 * smoothstep(FOOT_OF_HOUSE, FOOT_OF_HOUSE + 12.0, y))
}

fn house(x: f32, y: f32, width: f32, seed: u64) -> Colour {
    let plaster_grain = fractal_noise(salted(seed, 21), x * 0.35, y * 0.35, 4);
    let weather = fractal_noise(salted(seed, 22), x * 0.02, y * 0.012, 4);
    let plaster = lit([205.0, 184.0, 152.0], 0.80 + 0.14 * plaster_grain + 0.16 * weather);
    if y > 96.0 {
        let (column, row, edge) = stones(x - width / 2.0, y - 96.0, 27.0, 16.0, 0.5);
        let block = lit(
            [139.0, 134.0, 128.0],
            0.84 + 0.2 * unit(salted(seed, 23), column, row) + 0.2 * (plaster_grain - 0.5),
        );
        let ledge = 1.0 + 0.16 * smoothstep(98.5, 97.0, y);
        return lit(mix_colour([92.0, 88.0, 84.0], block, smoothstep(0.2, 0.9, edge)), ledge);
    }
    // Windows every 52 pixels, one of them in the middle; sills protrude and cast a shadow.
    let window = ((x - width / 2.0) / 52.0 + 0.5).floor();
    let (s, t) = (x - width / 2.0 - window * 52.0, y - 20.0);
    let (half, height) = (15.0, 54.0);
    if s.abs() < half && (0.0..height).contains(&t) {
        let pane_edge = (s.abs() - 0.6).min(half - 2.0 - s.abs()).min((t - 18.0).abs() - 0.6).min(t - 2.0);
        let sky = fractal_noise(salted(seed, 24), (x + 40.0 * window) * 0.05, y * 0.03, 3);
        let glass = mix_colour([42.0, 52.0, 62.0], [112.0, 130.0, 145.0], sky * (1.0 - t / height) * 1.2);
        let inset = smoothstep(-half, -half + 4.0, s) * 0.25 + 0.75;
        return lit(mix_colour([222.0, 217.0, 206.0], glass, smoothstep(0.0, 0.9, pane_edge)), inset);
    }
    if s.abs() < half + 2.5 && (height..height + 4.0).contains(&t) {
        return lit([190.0, 184.0, 174.0], 0.95 + 0.1 * plaster_grain);
    }
    let sill_shade = if s.abs() < half + 2.5 { smoothstep(height + 9.0, height + 4.0, t) } else { 0.0 };
    let sill_shade = if t > height { sill_shade } else { 0.0 };
    lit(plaster, 1.0 - 0.22 * sill_shade)
}

fn park(x: f32, y: f32, width: f32, seed: u64) -> Colour {
    let hedge_foot = 84.0 + 3.0 * fractal_noise(salted(seed, 31), x * 0.04, 0.0, 3);
    if y < hedge_foot {
        return hedge(x, y, hedge_foot, seed);
    }
    let (u, v) = ground(x, y, width, 30.0);
    let blades = fractal_noise(salted(seed, 32), x * 0.42, y * 0.20, 3);
    let patches = fractal_noise(salted(seed, 33), u * 3.2, v * 5.0, 4);
    let grass = mix_colour([86.0, 112.0, 50.0], [152.0, 164.0, 86.0], 0.62 * patches + 0.38 * blades);
    let grass = lit(grass, 0.86 + 0.30 * (blades - 0.5) + 0.10 * smoothstep(84.0, 130.0, y));
    let gravel_grain = fractal_noise(salted(seed, 34), x * 0.9, y * 1.3, 2);
    let gravel_drift = fractal_noise(salted(seed, 35), u * 2.4, v * 6.0, 4);
    let gravel = lit([204.0, 189.0, 162.0], 0.80 + 0.22 * gravel_drift + 0.26 * (gravel_grain - 0.5));
    let ragged = 5.0 * (fractal_noise(salted(seed, 36), x * 0.09, y * 0.12, 4) - 0.5);
    let on_path = smoothstep(163.0, 165.5, y + ragged) * smoothstep(223.0, 220.0, y + ragged);
    let verge = 1.0 - 0.14 * smoothstep(6.0, 0.0, (y + ragged - 164.0).abs().min((y + ragged - 221.0).abs()));
    lit(
        mix_colour(grass, gravel, on_path),
        verge * (0.93 + 0.07 * smoothstep(hedge_foot, hedge_foot + 9.0, y)),
    )
}

fn hedge(x: f32, y: f32, foot: f32, seed: u64) -> Colour {
    let bushes = fractal_noise(salted(seed, 41), x * 0.035, y * 0.045, 3);
    let leaves = fractal_noise(salted(seed, 42), x * 0.30, y * 0.34, 3);
    let skyline = 20.0 + 26.0 * fractal_noise(salted(seed, 43), x * 0.022, 0.5, 4) + 5.0 * leaves;
    let haze = mix_colour([206.0, 216.0, 226.0], [184.0, 202.0, 222.0], smoothstep(40.0, 0.0, y));
    let wood = mix_colour([30.0, 46.0, 26.0], [96.0, 118.0, 58.0], 0.65 * leaves + 0.35 * bushes);
    let depth = 0.66 + 0.42 * smoothstep(foot, skyline, y) + 0.5 * (bushes - 0.5);
    mix_colour(haze, lit(wood, depth), smoothstep(skyline - 1.0, skyline + 1.0, y))
}

fn street(x: f32, y: f32, width: f32, seed: u64) -> Colour {
    const FOOT_OF_WALL: f32 = 118.0;
    if y < FOOT_OF_WALL {
        let (column, row, edge) = stones(x, y, 15.0, 6.4, 0.5);
        let tint = unit(salted(seed, 51), column, row);
        let grain = fractal_noise(salted(seed, 52), x * 0.7, y * 0.7, 3);
        let weather = fractal_noise(salted(seed, 53), x * 0.02, y * 0.03, 4);
        let brick = mix_colour([126.0, 70.0, 54.0], [168.0, 102.0, 78.0], tint);
        let brick = lit(brick, 0.78 + 0.20 * weather + 0.24 * (grain - 0.4));
        let mortar = lit([172.0, 162.0, 150.0], 0.78 + 0.22 * weather);
        let wall = mix_colour(mortar, brick, smoothstep(0.25, 0.85, edge));
        return lit(wall, 0.86 + 0.14 * smoothstep(FOOT_OF_WALL, FOOT_OF_WALL - 26.0, y));
    }
    let (u, v) = ground(x, y, width, 40.0);
    let grain = fractal_noise(salted(seed, 54), x * 0.8, y * 0.9, 3);
    let stain = fractal_noise(salted(seed, 55), u * 3.0, v * 6.0, 4);
    if y > 226.0 {
        // The kerb and the road below it.
        let kerb = smoothstep(230.5, 229.5, y);
        let road = lit([86.0, 86.0, 90.0], 0.84 + 0.2 * stain + 0.3 * (grain - 0.5));
        let stone = lit([166.0, 162.0, 155.0], 0.85 + 0.1 * stain + 0.2 * (grain - 0.5));
        return mix_colour(road, stone, kerb);
    }
    let (column, row, edge) = stones(u, v, 0.36, 0.24, 0.5);
    let slab = mix_colour([160.0, 158.0, 155.0], [182.0, 178.0, 171.0], unit(salted(seed, 56), column, row));
    let slab = lit(slab, 0.80 + 0.26 * stain + 0.20 * (grain - 0.5));
    let stone = mix_colour([116.0, 113.0, 110.0], slab, smoothstep(0.002, 0.007, edge));
    lit(stone, 0.78 + 0.22 * smoothstep(FOOT_OF_WALL, FOOT_OF_WALL + 9.0, y))
}

fn room(x: f32, y: f32, width: f32, seed: u64) -> Colour {
    const FOOT_OF_WALL: f32 = 124.0;
    if y < FOOT_OF_WALL {
        return inner_wall(x - width / 2.0, FOOT_OF_WALL - y, seed);
    }
    let (u, v) = ground(x, y, width, 44.0);
    // Floorboards perpendicular to the wall, with joints staggered between neighbours.
    let board = (u / 0.13).floor();
    let (column, row, edge) = stones(v + 0.37 * unit(salted(seed, 91), board as i64, 0), u, 0.9, 0.13, 0.5);
    let tint = unit(salted(seed, 92), column, row);
    let veins = fractal_noise(salted(seed, 93), u * 90.0, v * 4.0 + 7.0 * tint, 3);
    let board = mix_colour([150.0, 108.0, 70.0], [186.0, 142.0, 98.0], tint);
    let board = lit(board, 0.84 + 0.26 * veins);
    let floor = mix_colour([92.0, 64.0, 42.0], board, smoothstep(0.001, 0.005, edge));
    lit(floor, 0.82 + 0.18 * smoothstep(FOOT_OF_WALL, FOOT_OF_WALL + 14.0, y))
}

/// An interior wall: `x` to the right of the middle, `up` above its foot.
fn inner_wall(x: f32, up: f32, seed: u64) -> Colour {
    let grain = fractal_noise(salted(seed, 94), x * 0.5, up * 0.5, 3);
    let light =
        0.88 + 0.10 * fractal_noise(salted(seed, 95), x * 0.012, up * 0.012, 3) + 0.08 * (grain - 0.5);
    if up < 9.0 {
        let top = smoothstep(7.6, 8.2, up);
        return lit([226.0, 221.0, 210.0], (0.78 + 0.14 * top) * light);
    }
    // A door to the left of the middle, with its handle on the right.
    let (s, door) = ((x + 92.0).abs(), 104.0);
    if s < 27.0 && up < door + 5.0 {
        if s > 23.0 || up > door {
            return lit([216.0, 210.0, 198.0], light);
        }
        let handle = (x + 74.0).hypot(1.4 * (up - 50.0));
        if handle < 2.4 {
            return lit([190.0, 168.0, 96.0], 1.25 - 0.2 * handle);
        }
        let panel = ((s - 8.0).abs() - 7.0).max(((up - 56.0).abs() - 24.0).abs() - 19.0);
        let relief = 1.0 - 0.12 * smoothstep(1.4, 0.4, panel.abs());
        let veins = fractal_noise(salted(seed, 96), x * 0.5, up * 0.05, 3);
        return lit([122.0, 88.0, 62.0], relief * light * (0.86 + 0.24 * veins));
    }
    // Two pictures hang on the right.
    for (number, middle, half, height) in [(0, 58.0, 21.0, 15.0), (1, 116.0, 13.0, 17.0)] {
        let edge = ((x - middle).abs() - half).max((up - 78.0).abs() - height);
        if edge < 0.0 {
            let seen = fractal_noise(salted(seed, 97 + number), x * 0.07, up * 0.10, 4);
            let painting = mix_colour([58.0, 84.0, 104.0], [206.0, 176.0, 120.0], smoothstep(0.3, 0.7, seen));
            return mix_colour(
                painting,
                lit([92.0, 68.0, 44.0], 0.8 + 0.4 * grain),
                smoothstep(-3.4, -2.6, edge),
            );
        }
    }
    let stripe = smoothstep(0.44, 0.56, (x / 11.0).rem_euclid(1.0))
        * smoothstep(1.0, 0.88, (x / 11.0).rem_euclid(1.0));
    lit(mix_colour([206.0, 201.0, 176.0], [194.0, 192.0, 168.0], stripe), light)
}
