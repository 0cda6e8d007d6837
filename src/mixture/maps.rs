//! Maps of one quantity of every pixel's mixture: one f32 per pixel in row order.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::image::{Mixture, Planes, Tiles};
use super::pixel::{Component, first_match};
use super::tile::LANES;
use crate::frame::Frame;
use crate::registration::corrected;

/// The quantity of a [`QuantityMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Quantity {
    /// σ of component 1, in levels.
    Sigma,
    /// w of component 1, 0..=1.
    Weight,
    /// The number of components in use, 1..=K.
    Used,
    /// B, the number of background components, 1..=K.
    BackgroundCount,
    /// The rank, before the update, of the component that the frame's value matched; 0 if none did.
    Matched,
    /// The number of frames since the pixel was last foreground in the model's mask, before cleaning: 0 if it is now,
    /// infinite if it never was.
    #[serde(rename = "Since")]
    SinceForeground,
}

impl Quantity {
    /// All quantities in order.
    pub const ALL: [Self; 6] =
        [Self::Sigma, Self::Weight, Self::Used, Self::BackgroundCount, Self::Matched, Self::SinceForeground];

    /// Whether it is a quantity of the mixture, which other models do not have.
    pub const fn is_of_mixture(self) -> bool {
        !matches!(self, Self::SinceForeground)
    }
}

/// A quantity at each pixel, after one frame's update.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityMap {
    /// The quantity.
    pub quantity: Quantity,
    /// Its values in row order.
    pub values: Vec<f32>,
}

impl Mixture {
    /// σ of component 1 at each pixel, in row order; 0 before the first frame.
    pub fn sigmas(&self) -> Vec<f32> {
        self.of_tiles(|tile, lane| match &self.planes {
            Planes::Rgb(tiles) => tiles.first[tile].lane(lane).sigma(),
            Planes::Gray(tiles) => tiles.first[tile].lane(lane).sigma(),
        })
    }

    /// w of component 1 at each pixel, in row order.
    pub fn weights(&self) -> Vec<f32> {
        self.of_tiles(|tile, lane| match &self.planes {
            Planes::Rgb(tiles) => tiles.first[tile].lane(lane).weight,
            Planes::Gray(tiles) => tiles.first[tile].lane(lane).weight,
        })
    }

    /// The number of components in use at each pixel, in row order.
    pub fn used_counts(&self) -> Vec<f32> {
        let count = |components: &[Component]| {
            components.iter().filter(|component| component.is_used()).count() as f32
        };
        self.of_components(|components, _| count(components))
    }

    /// The rank from 1 of the component that each pixel of the next frame, `frame`, matches; 0 if it matches none,
    /// and everywhere before the first frame.
    ///
    /// # Panics
    /// If the frame has another size than the mixture.
    pub fn matches(&self, frame: &Frame) -> Vec<f32> {
        assert_eq!(frame.size, self.size(), "a frame of the mixture's size");
        let parameters = *self.parameters();
        let corrected = corrected(frame, parameters.registration);
        let frame = corrected.as_ref().map_or(frame, |corrected| &corrected.frame);
        let unknown = corrected.as_ref().and_then(|corrected| corrected.unknown.as_deref());
        self.of_components(|components, index| {
            // As in [`super::Pixel::skip`].
            if unknown.is_some_and(|unknown| unknown[index]) {
                return 1.0;
            }
            let Some(rgb) = frame.rgb.get(3 * index..).and_then(|rest| rest.first_chunk()) else {
                return 0.0;
            };
            let matched = first_match(components, parameters.value(*rgb), parameters.lambda);
            matched.map_or(0.0, |at| at as f32 + 1.0)
        })
    }

    /// `value` of the tile and the lane of each pixel.
    fn of_tiles(&self, value: impl Fn(usize, usize) -> f32 + Sync) -> Vec<f32> {
        let mut values = vec![0.0; self.size().pixels()];
        values.par_chunks_mut(LANES).with_min_len(64).enumerate().for_each(|(tile, values)| {
            for (lane, to) in values.iter_mut().enumerate() {
                *to = value(tile, lane);
            }
        });
        values
    }

    /// `value` of the components, in rank order, that were ever in use in each pixel's tile, and of the pixel's
    /// index.
    fn of_components(&self, value: impl Fn(&[Component], usize) -> f32 + Sync) -> Vec<f32> {
        let mut values = vec![0.0; self.size().pixels()];
        values.par_chunks_mut(LANES).with_min_len(64).enumerate().for_each(|(tile, values)| {
            match &self.planes {
                Planes::Rgb(tiles) => tiles.each_lane(tile, self, values, &value),
                Planes::Gray(tiles) => tiles.each_lane(tile, self, values, &value),
            }
        });
        values
    }
}

impl<const N: usize> Tiles<N> {
    fn each_lane(
        &self,
        tile: usize,
        mixture: &Mixture,
        values: &mut [f32],
        value: &impl Fn(&[Component], usize) -> f32,
    ) {
        let others = mixture.parameters().k - 1;
        let in_use = usize::from(self.used[tile]).saturating_sub(1);
        let others = &self.others[tile * others..][..in_use];
        // Brings the weights up to date, some of which are stored as of an earlier frame.
        let keep = self.keep(tile, mixture);
        let mut components = [Component::default(); super::MAX_K];
        for (lane, to) in values.iter_mut().enumerate() {
            components[0] = self.first[tile].lane(lane);
            for (component, other) in components[1..].iter_mut().zip(others) {
                *component = other.lane(lane);
                for keep in &keep {
                    component.weight *= keep;
                }
            }
            *to = value(&components[..=in_use], tile * LANES + lane);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Size;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings, Space};

    #[test]
    fn maps_equal_the_mixture_of_every_pixel() {
        let size = Size::new(37, 5);
        let frames: Vec<_> = (1..=90_u32)
            .map(|number| {
                let byte = |at: usize| {
                    let noise =
                        (at as u32 / 3).wrapping_mul(2_654_435_761) ^ number.wrapping_mul(0x9e37_79b1);
                    let noise = (noise ^ noise >> 15).wrapping_mul(0x85eb_ca6b) >> 24;
                    if noise.is_multiple_of(19) {
                        noise as u8
                    } else {
                        90 + (noise % 7) as u8 + (at % 40) as u8
                    }
                };
                Frame::new(number, size, (0..size.pixels() * 3).map(byte).collect())
            })
            .collect();
        for space in [Space::Rgb, Space::Gray] {
            let settings = Settings { space, alpha: 0.05, ..Settings::preset(Preset::Default) };
            let parameters = Parameters::new(&settings);
            let mut mixture = Mixture::new(size, parameters);
            let (mut most_used, mut unmatched) = (0.0_f32, 0);
            for (t, frame) in (1..).zip(&frames) {
                let matches = mixture.matches(frame);
                for (index, &matched) in matches.iter().enumerate() {
                    let (x, y) = (index as u32 % size.width, index as u32 / size.width);
                    let mut pixel = mixture.pixel(x, y).unwrap();
                    let rgb = frame.pixel(x, y).unwrap();
                    let outcome = pixel.update(parameters.value(rgb), t, &parameters);
                    assert_eq!(matched, f32::from(outcome.matched), "frame {t}, pixel {x}, {y}");
                    unmatched += u32::from(matched == 0.0);
                }
                mixture.step(frame);
                let maps = [mixture.sigmas(), mixture.weights(), mixture.used_counts()];
                for index in 0..size.pixels() {
                    let pixel = mixture.pixel(index as u32 % size.width, index as u32 / size.width).unwrap();
                    let first = pixel.components()[0];
                    let expected = [first.sigma(), first.weight, pixel.used() as f32];
                    assert_eq!(maps.each_ref().map(|map| map[index]), expected, "frame {t}, pixel {index}");
                    most_used = most_used.max(expected[2]);
                }
            }
            assert!(most_used > 2.0 && unmatched > size.pixels() as u32, "{most_used} {unmatched}");
        }
    }
}
