//! Seeded value noise for the textures of rendered scenes.

/// Hashes a seed and two lattice coordinates to 64 bits.
pub fn hash(seed: u64, x: i64, y: i64) -> u64 {
    let mut bits = seed ^ (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    bits ^= (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    bits = (bits ^ (bits >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    bits ^ (bits >> 32)
}

/// The seed of one of several textures of a scene.
pub fn salted(seed: u64, texture: i64) -> u64 {
    hash(seed, texture, 0x7E87)
}

/// A pseudo-random number in 0..1 for a lattice point.
pub fn unit(seed: u64, x: i64, y: i64) -> f32 {
    (hash(seed, x, y) >> 40) as f32 / (1u64 << 24) as f32
}

/// Smooth noise in 0..1 with features about one unit wide.
pub fn value_noise(seed: u64, x: f32, y: f32) -> f32 {
    let (left, top) = (x.floor(), y.floor());
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (u, v) = (ease(x - left), ease(y - top));
    let (i, j) = (left as i64, top as i64);
    let upper = mix(unit(seed, i, j), unit(seed, i + 1, j), u);
    let lower = mix(unit(seed, i, j + 1), unit(seed, i + 1, j + 1), u);
    mix(upper, lower, v)
}

/// Fractal noise in 0..1: each octave has half the wavelength and half the amplitude of the previous one.
pub fn fractal_noise(seed: u64, x: f32, y: f32, octaves: u32) -> f32 {
    let (mut sum, mut total, mut strength, mut scale) = (0.0, 0.0, 1.0, 1.0);
    for octave in 0..octaves {
        sum += strength * value_noise(seed.wrapping_add(u64::from(octave)), x * scale, y * scale);
        total += strength;
        strength *= 0.5;
        scale *= 2.0;
    }
    sum / total
}

/// Linear interpolation: `a` at t = 0, `b` at t = 1.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 below `low`, 1 above `high`, smooth between.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// An unrounded colour, each channel in 0..255.
pub type Colour = [f32; 3];

/// Linear interpolation of colours: `a` at t = 0, `b` at t = 1.
pub fn mix_colour(a: Colour, b: Colour, t: f32) -> Colour {
    [mix(a[0], b[0], t), mix(a[1], b[1], t), mix(a[2], b[2], t)]
}

/// A colour scaled in brightness.
pub fn lit(colour: Colour, light: f32) -> Colour {
    colour.map(|channel| channel * light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_bounded_and_seeded() {
        let mut previous = value_noise(3, -2.0, 0.0);
        let (mut least, mut most) = (1.0f32, 0.0f32);
        for step in 0..4000 {
            let value = value_noise(3, -2.0 + step as f32 * 0.01, 0.0);
            assert!((0.0..1.0).contains(&value) && (value - previous).abs() < 0.03, "{value}");
            (least, most) = (least.min(value), most.max(value));
            previous = value;
        }
        assert!(least < 0.2 && most > 0.8, "the noise covers its range: {least}..{most}");
        assert_ne!(value_noise(3, 0.3, 0.4), value_noise(4, 0.3, 0.4));
    }
}
