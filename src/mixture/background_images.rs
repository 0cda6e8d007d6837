//! Images of the background model, one value per pixel in row order: its means as RGB bytes, and the number of
//! background components.

use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

use super::image::{Mixture, Planes, Tiles};
use super::pixel::Parameters;
use super::tile::{Gaussians, LANES, Vectors, VerdictMemories, raised_t};
use crate::instruction_set;
use crate::settings::Space;

/// The background model at each pixel, in row order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BackgroundImages {
    /// The mean of component 1: RGB bytes, luma repeated.
    pub mean: Vec<u8>,
    /// The weighted mean of the B background components: RGB bytes.
    pub multi_mode: Vec<u8>,
    /// B.
    pub background_count: Vec<u8>,
}

/// The part of [`BackgroundImages`] that belongs to one tile.
struct TileBackground {
    mean: [u8; 3 * LANES],
    multi_mode: [u8; 3 * LANES],
    background_count: [u8; LANES],
}

/// The part of [`BackgroundImages`] that a thread writes.
struct BackgroundSlices<'a> {
    mean: &'a mut [u8],
    multi_mode: &'a mut [u8],
    background_count: &'a mut [u8],
}

/// Number of tiles in a thread's job.
const TILES_A_JOB: usize = 256;

impl Mixture {
    /// The current background: at each pixel the result of [`Pixel::background_mean`] and [`Pixel::background_count`]
    /// under the pixel's own T.
    ///
    /// [`Pixel::background_mean`]: super::Pixel::background_mean
    /// [`Pixel::background_count`]: super::Pixel::background_count
    pub fn background_images(&self) -> BackgroundImages {
        let pixels = self.size().pixels();
        let mut all = BackgroundImages {
            mean: vec![0; 3 * pixels],
            multi_mode: vec![0; 3 * pixels],
            background_count: vec![0; pixels],
        };
        let level = instruction_set::level();
        all.mean
            .par_chunks_mut(3 * LANES * TILES_A_JOB)
            .zip(all.multi_mode.par_chunks_mut(3 * LANES * TILES_A_JOB))
            .zip(all.background_count.par_chunks_mut(LANES * TILES_A_JOB))
            .enumerate()
            .for_each(|(job, ((mean, multi_mode), background_count))| {
                let start = job * TILES_A_JOB;
                let images = BackgroundSlices { mean, multi_mode, background_count };
                dispatch!(level, simd => match &self.planes {
                    Planes::Rgb(tiles) => write_tiles(simd, self, tiles, start, images),
                    Planes::Gray(tiles) => write_tiles(simd, self, tiles, start, images),
                });
            });
        all
    }

    /// The mean of component 1 at each pixel: RGB bytes in row order, luma repeated.
    pub fn mean_image(&self) -> Vec<u8> {
        let gray = self.parameters().space == Space::Gray;
        let mut rgb = vec![0; self.size().pixels() * 3];
        rgb.par_chunks_mut(3 * LANES).enumerate().for_each(|(tile, rgb)| {
            for (lane, rgb) in rgb.chunks_exact_mut(3).enumerate() {
                let mean = match &self.planes {
                    Planes::Rgb(tiles) => tiles.first[tile].lane(lane).mean,
                    Planes::Gray(tiles) => tiles.first[tile].lane(lane).mean,
                };
                for (channel, byte) in rgb.iter_mut().enumerate() {
                    *byte = mean[if gray { 0 } else { channel }].round() as u8;
                }
            }
        });
        rgb
    }
}

#[inline(always)]
fn write_tiles<S: Simd, const N: usize>(
    simd: S,
    mixture: &Mixture,
    tiles: &Tiles<N>,
    start: usize,
    images: BackgroundSlices<'_>,
) {
    let others = mixture.parameters().k - 1;
    let BackgroundSlices { mean, multi_mode, background_count } = images;
    let places = mean
        .chunks_mut(3 * LANES)
        .zip(multi_mode.chunks_mut(3 * LANES))
        .zip(background_count.chunks_mut(LANES));
    for (tile, ((mean, multi_mode), count)) in (start..).zip(places) {
        let used = usize::from(tiles.used[tile]);
        let others = &tiles.others[tile * others..][..used.saturating_sub(1)];
        // Brings the weights up to date, some of which are stored as of an earlier frame.
        let keep = tiles.keep(tile, mixture);
        let t = tile_t(simd, tiles.pasts.get(tile), keep.len(), mixture.parameters());
        let seen = background_of_tile(simd, &tiles.first[tile], others, &keep, t);
        mean.copy_from_slice(&seen.mean[..mean.len()]);
        multi_mode.copy_from_slice(&seen.multi_mode[..multi_mode.len()]);
        count.copy_from_slice(&seen.background_count[..count.len()]);
    }
}

/// T of each lane, `frames` frames after its memory was last brought up to date.
#[inline(always)]
fn tile_t<S: Simd>(
    simd: S,
    pasts: Option<&VerdictMemories>,
    frames: usize,
    parameters: &Parameters,
) -> f32x16<S> {
    let t = f32x16::splat(simd, parameters.t);
    pasts.map_or(t, |pasts| {
        let mut unrest = pasts.unrest(simd);
        for _ in 0..frames {
            unrest *= parameters.feedback.keep();
        }
        raised_t(t, unrest, &parameters.feedback)
    })
}

#[inline(always)]
fn background_of_tile<S: Simd, const N: usize>(
    simd: S,
    first: &Gaussians<N>,
    others: &[Gaussians<N>],
    keep: &[f32],
    t: f32x16<S>,
) -> TileBackground {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let first = Vectors::load(simd, first);
    let settled = |other: &Gaussians<N>| {
        let mut other = Vectors::load(simd, other);
        for &keep in keep {
            other.weight *= keep;
        }
        other
    };
    // Sums over the background components: of the weights, then of w/total·μ.
    let mut sum = zero;
    let mut count = zero;
    let mut used = zero;
    let mut reached = sum.simd_gt(t);
    let mut total = zero;
    let mut each = |component: &Vectors<S, N>| {
        sum += component.weight;
        count = reached.select(count, count + one);
        total = reached.select(total, sum);
        used = component.weight.simd_gt(0.0).select(used + one, used);
        reached |= sum.simd_gt(t);
    };
    each(&first);
    for other in others {
        each(&settled(other));
    }
    let count = reached.select(count, used);
    let mut multi_mode = [zero; N];
    let mut rank = zero;
    let mut each = |component: &Vectors<S, N>| {
        let background = rank.simd_lt(count);
        for (sum, mean) in multi_mode.iter_mut().zip(&component.mean) {
            *sum = background.select(*sum + component.weight / total * *mean, *sum);
        }
        rank += one;
    };
    each(&first);
    for other in others {
        each(&settled(other));
    }
    let count = count.to_array();
    TileBackground {
        mean: bytes(first.mean),
        multi_mode: bytes(multi_mode),
        background_count: std::array::from_fn(|lane| count[lane] as u8),
    }
}

/// RGB bytes of rounded means, luma repeated.
#[inline(always)]
fn bytes<S: Simd, const N: usize>(means: [f32x16<S>; N]) -> [u8; 3 * LANES] {
    let means: [[f32; LANES]; N] = means.map(|mean| mean.round().to_array());
    std::array::from_fn(|at| means[(at % 3).min(N - 1)][at / 3] as u8)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::frame::{Frame, Size};
    use crate::settings::{Preset, Settings};

    /// An image of several jobs, the last one of a part of a tile.
    #[test]
    fn images_equal_the_mixture_of_every_pixel() {
        let size = Size::new(131, 79);
        assert!(size.pixels() > 2 * LANES * TILES_A_JOB && !size.pixels().is_multiple_of(LANES));
        for space in [Space::Rgb, Space::Gray] {
            let settings = Settings { space, alpha: 0.1, ..Settings::preset(Preset::Default) };
            let parameters = Parameters::new(&settings);
            let mut mixture = Mixture::new(size, parameters);
            for number in 1..=14_u32 {
                // Of each third pixel, two surfaces in turn.
                let byte = |at: usize| {
                    let other = (at / 3).is_multiple_of(3) && number.is_multiple_of(2);
                    (at % 97) as u8 + if other { 130 } else { 0 }
                };
                mixture.step(&Frame::new(number, size, (0..3 * size.pixels()).map(byte).collect()));
            }
            let images = mixture.background_images();
            let mut several = 0;
            for index in 0..size.pixels() {
                let pixel = mixture.pixel(index as u32 % size.width, index as u32 / size.width).unwrap();
                let t = parameters.t_of(pixel.past());
                let rgb = |mean: [f32; 3]| {
                    [0, 1, 2]
                        .map(|channel| mean[if space == Space::Gray { 0 } else { channel }].round() as u8)
                };
                assert_eq!(images.mean[3 * index..][..3], rgb(pixel.components()[0].mean), "{index}");
                assert_eq!(images.multi_mode[3 * index..][..3], rgb(pixel.background_mean(t)), "{index}");
                assert_eq!(usize::from(images.background_count[index]), pixel.background_count(t), "{index}");
                several += usize::from(images.background_count[index] > 1);
            }
            assert!(several > 1000, "{several}");
        }
    }
}
