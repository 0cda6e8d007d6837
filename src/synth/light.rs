//! The lighting of a scene, in space and time.

use serde::{Deserialize, Serialize};

use super::texture::{Colour, lit, mix, smoothstep};
use crate::frame::Size;

/// A global gain of the light, which can change over time, and a shadow over one side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lighting {
    /// Key frames and their gains, in order, with linear interpolation between them and constant values before the
    /// first and after the last. Empty is a gain of 1.
    pub gains: Vec<(f32, f32)>,
    /// The shadow, if any.
    pub shade: Option<Shade>,
}

/// A shadow over everything to the right of a column, people included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shade {
    /// The column at which it begins, in pixels.
    pub from: f32,
    /// The width of its transition, in pixels.
    pub softness: f32,
    /// The factor on the light in it.
    pub light: f32,
}

impl Lighting {
    /// Whether it has no effect.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// The gain in a frame.
    pub fn gain(&self, frame: f32) -> f32 {
        let later = self.gains.iter().position(|&(at, _)| at > frame);
        match (later, self.gains.last()) {
            (Some(0), _) => self.gains[0].1,
            (Some(next), _) => {
                let ((start, from), (end, to)) = (self.gains[next - 1], self.gains[next]);
                mix(from, to, (frame - start) / (end - start))
            }
            (None, last) => last.map_or(1.0, |last| last.1),
        }
    }

    /// Applies it to an image.
    pub(super) fn fall_on(&self, image: &mut [Colour], size: Size, frame: f32) {
        if self.is_usual() {
            return;
        }
        let gain = self.gain(frame);
        let column = |x: u32| {
            let shaded = |shade: &Shade| {
                let depth = smoothstep(shade.from, shade.from + shade.softness, x as f32 + 0.5);
                mix(1.0, shade.light, depth)
            };
            gain * self.shade.as_ref().map_or(1.0, shaded)
        };
        let factors: Vec<f32> = (0..size.width).map(column).collect();
        for row in image.chunks_exact_mut(factors.len()) {
            for (colour, factor) in row.iter_mut().zip(&factors) {
                *colour = lit(*colour, *factor);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_is_interpolated_between_key_frames_and_constant_beyond_them() {
        let light = Lighting { gains: vec![(10.0, 0.5), (20.0, 1.0)], shade: None };
        assert_eq!([1.0, 10.0, 15.0, 20.0, 99.0].map(|frame| light.gain(frame)), [0.5, 0.5, 0.75, 1.0, 1.0]);
        assert_eq!(Lighting::default().gain(7.0), 1.0);
    }

    #[test]
    fn a_shadow_covers_one_side() {
        let shade = Shade { from: 40.0, softness: 10.0, light: 0.25 };
        let light = Lighting { gains: vec![(0.0, 2.0)], shade: Some(shade) };
        let mut image = vec![[10.0; 3]; 200];
        light.fall_on(&mut image, Size::new(100, 2), 5.0);
        assert_eq!((image[39], image[150]), ([20.0; 3], [5.0; 3]));
    }
}
