//! The whole image's mixtures, fast: equal to [`Pixel::update`] bit for bit.
//!
//! Pixels are independent, so they are kept sixteen to a tile, each quantity as a plane of sixteen
//! numbers that the compiler turns into vector instructions. In almost every tile of almost every
//! frame all sixteen pixels match their component 1; that case is short and has no branches. Any
//! other tile goes through the plain single-pixel code.

use multiversion::multiversion;
use rayon::prelude::*;

use super::pixel::{Component, Parameters, Pixel, density, luma};
use crate::frame::{Frame, Mask, Size};
use crate::settings::{Rate, Space};

/// Pixels a tile.
const LANES: usize = 16;
/// Tiles a piece of work for a thread, enough to make handing it out cheap.
const TILES_A_JOB: usize = 128;

type Plane = [f32; LANES];

/// One mixture for every pixel of an image.
///
/// Memory: K·(n + 2) numbers of 4 bytes a pixel, 60 bytes for K = 3 in colour.
#[derive(Clone)]
pub struct Mixture {
    size: Size,
    parameters: Parameters,
    /// Frames taken in so far.
    t: u32,
    /// Tile after tile; in a tile component after component; in a component w, σ², then μ by channel.
    planes: Vec<Plane>,
    /// For each tile how many components are in use in any of its pixels.
    used: Vec<u8>,
}

impl Mixture {
    /// Mixtures that have seen nothing, for images of `size`.
    pub fn new(size: Size, parameters: Parameters) -> Self {
        let tiles = size.pixels().div_ceil(LANES);
        let planes = vec![[0.0; LANES]; tiles * parameters.k * (2 + parameters.channels())];
        Self { size, parameters, t: 0, planes, used: vec![0; tiles] }
    }

    /// The size of the images.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The parameters of the pixel process.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Frames taken in so far.
    pub const fn frames_seen(&self) -> u32 {
        self.t
    }

    /// The memory that a copy takes, in bytes.
    pub const fn state_bytes(&self) -> usize {
        self.planes.len() * size_of::<Plane>() + self.used.len()
    }

    /// Takes the next frame in and says which pixels are foreground.
    ///
    /// # Panics
    /// When the frame has another size than the mixture.
    pub fn step(&mut self, frame: &Frame) -> Mask {
        assert_eq!(frame.size, self.size, "a frame of the mixture's size");
        self.t += 1;
        let step = Step::new(&self.parameters, self.t);
        let mut mask = Mask::empty(self.size);
        let planes_a_tile = step.planes_a_tile();
        self.planes
            .par_chunks_mut(planes_a_tile * TILES_A_JOB)
            .zip(self.used.par_chunks_mut(TILES_A_JOB))
            .zip(mask.data.par_chunks_mut(LANES * TILES_A_JOB))
            .zip(frame.rgb.par_chunks(3 * LANES * TILES_A_JOB))
            .for_each(|(((planes, used), mask), rgb)| step_tiles(&step, planes, used, mask, rgb));
        mask
    }

    /// The mixture of pixel (x, y), or `None` outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        self.size.index(x, y).map(|index| self.pixel_at(index))
    }

    /// The mean of component 1 at each pixel: RGB bytes in row order (gray repeated).
    pub fn mean_image(&self) -> Vec<u8> {
        self.image(|pixel| pixel.components()[0].mean)
    }

    /// The weighted mean of the B background components at each pixel: RGB bytes in row order.
    pub fn multi_mode_image(&self) -> Vec<u8> {
        let t = self.parameters.t;
        self.image(|pixel| pixel.background_mean(t))
    }

    /// B at each pixel, in row order.
    pub fn background_counts(&self) -> Vec<u8> {
        let mut counts = vec![0; self.size.pixels()];
        counts.par_iter_mut().enumerate().for_each(|(index, count)| {
            *count = self.pixel_at(index).background_count(self.parameters.t) as u8;
        });
        counts
    }

    fn image(&self, value: impl Fn(&Pixel) -> [f32; 3] + Sync) -> Vec<u8> {
        let gray = self.parameters.space == Space::Gray;
        let mut rgb = vec![0; self.size.pixels() * 3];
        rgb.par_chunks_exact_mut(3).enumerate().for_each(|(index, rgb)| {
            let mean = value(&self.pixel_at(index));
            for (channel, byte) in rgb.iter_mut().enumerate() {
                let mean = if gray { mean[0] } else { mean[channel] };
                *byte = mean.round().clamp(0.0, 255.0) as u8;
            }
        });
        rgb
    }

    fn pixel_at(&self, index: usize) -> Pixel {
        let planes_a_tile = self.parameters.k * (2 + self.parameters.channels());
        let tile = index / LANES;
        let planes = &self.planes[tile * planes_a_tile..(tile + 1) * planes_a_tile];
        read_lane(planes, index % LANES, &self.parameters)
    }
}

/// What is the same for all tiles of one frame.
struct Step {
    parameters: Parameters,
    t: u32,
    alpha: f32,
    lambda_squared: f32,
    least_variance: f32,
}

impl Step {
    fn new(parameters: &Parameters, t: u32) -> Self {
        Self {
            parameters: *parameters,
            t,
            alpha: parameters.alpha_at(t),
            lambda_squared: parameters.lambda * parameters.lambda,
            least_variance: parameters.min_sigma * parameters.min_sigma,
        }
    }

    fn planes_a_tile(&self) -> usize {
        self.parameters.k * (2 + self.parameters.channels())
    }
}

/// Takes consecutive tiles through one frame. The last tile of an image may have fewer pixels than
/// lanes; its spare lanes run along on zeros and nobody reads them.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx+avx2", "aarch64+neon"))]
fn step_tiles(step: &Step, planes: &mut [Plane], used: &mut [u8], mask: &mut [u8], rgb: &[u8]) {
    let tiles = planes.chunks_exact_mut(step.planes_a_tile()).zip(used);
    let pixels = mask.chunks_mut(LANES).zip(rgb.chunks(3 * LANES));
    for ((planes, used), (mask, rgb)) in tiles.zip(pixels) {
        match step.parameters.space {
            Space::Rgb => step_tile::<3>(step, planes, used, mask, &read_rgb(rgb)),
            Space::Gray => step_tile::<1>(step, planes, used, mask, &read_luma(rgb)),
        }
    }
}

#[inline(always)]
fn read_rgb(rgb: &[u8]) -> [Plane; 3] {
    let mut x = [[0.0; LANES]; 3];
    for (lane, rgb) in rgb.chunks_exact(3).take(LANES).enumerate() {
        x[0][lane] = f32::from(rgb[0]);
        x[1][lane] = f32::from(rgb[1]);
        x[2][lane] = f32::from(rgb[2]);
    }
    x
}

#[inline(always)]
fn read_luma(rgb: &[u8]) -> [Plane; 1] {
    let mut x = [[0.0; LANES]];
    for (lane, rgb) in rgb.chunks_exact(3).take(LANES).enumerate() {
        x[0][lane] = f32::from(luma([rgb[0], rgb[1], rgb[2]]));
    }
    x
}

#[inline(always)]
fn step_tile<const N: usize>(
    step: &Step,
    planes: &mut [Plane],
    used: &mut u8,
    mask: &mut [u8],
    x: &[Plane; N],
) {
    if *used > 0 && all_match_first(step, planes, x) {
        learn_first(step, planes, *used as usize, x);
        mask.fill(Mask::BACKGROUND);
        return;
    }
    *used = 0;
    for lane in 0..LANES {
        let mut value = [0.0; 3];
        for (channel, plane) in x.iter().enumerate() {
            value[channel] = plane[lane];
        }
        let mut pixel = read_lane(planes, lane, &step.parameters);
        let outcome = pixel.step(value, step.t, &step.parameters);
        write_lane(planes, lane, &pixel, N);
        *used = (*used).max(pixel.used() as u8);
        if let Some(mask) = mask.get_mut(lane) {
            *mask = if outcome.foreground { Mask::FOREGROUND } else { Mask::BACKGROUND };
        }
    }
}

/// Whether every pixel of the tile matches its component 1. One that is unused has σ² = 0 and w = 0.
#[inline(always)]
fn all_match_first<const N: usize>(step: &Step, planes: &[Plane], x: &[Plane; N]) -> bool {
    let mut all = true;
    for lane in 0..LANES {
        let distance = distance_squared(planes, x, lane);
        // Without a branch, so that the lanes go side by side.
        all &= distance <= step.lambda_squared * planes[1][lane];
        all &= planes[0][lane] > 0.0;
    }
    all
}

#[inline(always)]
fn distance_squared<const N: usize>(planes: &[Plane], x: &[Plane; N], lane: usize) -> f32 {
    let mut sum = 0.0;
    for channel in 0..N {
        let difference = x[channel][lane] - planes[2 + channel][lane];
        sum += difference * difference;
    }
    sum
}

/// The update of §V where component 1 matched in all lanes: it stays on top, all pixels are background.
#[inline(always)]
fn learn_first<const N: usize>(step: &Step, planes: &mut [Plane], used: usize, x: &[Plane; N]) {
    let keep = 1.0 - step.alpha;
    for component in 0..used {
        for weight in &mut planes[component * (2 + N)] {
            *weight *= keep;
        }
    }
    let mut rho = [0.0; LANES];
    for lane in 0..LANES {
        planes[0][lane] += step.alpha;
        rho[lane] = match step.parameters.rate {
            Rate::Density => step.alpha * density(distance_squared(planes, x, lane), planes[1][lane], N),
            Rate::Weight => step.alpha / planes[0][lane],
            Rate::Constant => step.alpha,
        };
        rho[lane] = if rho[lane] < 1.0 { rho[lane] } else { 1.0 };
    }
    for channel in 0..N {
        for lane in 0..LANES {
            let mean = &mut planes[2 + channel][lane];
            *mean = (1.0 - rho[lane]) * *mean + rho[lane] * x[channel][lane];
        }
    }
    for lane in 0..LANES {
        let distance = distance_squared(planes, x, lane);
        let variance = (1.0 - rho[lane]) * planes[1][lane] + rho[lane] * distance;
        planes[1][lane] = if variance < step.least_variance { step.least_variance } else { variance };
    }
}

fn read_lane(planes: &[Plane], lane: usize, parameters: &Parameters) -> Pixel {
    let fields = 2 + parameters.channels();
    let mut pixel = Pixel::unseen(parameters.k);
    for (component, planes) in pixel.components_mut().iter_mut().zip(planes.chunks_exact(fields)) {
        let mut mean = [0.0; 3];
        for (channel, plane) in mean.iter_mut().zip(&planes[2..]) {
            *channel = plane[lane];
        }
        *component = Component { weight: planes[0][lane], variance: planes[1][lane], mean };
    }
    pixel
}

fn write_lane(planes: &mut [Plane], lane: usize, pixel: &Pixel, channels: usize) {
    for (component, planes) in pixel.components().iter().zip(planes.chunks_exact_mut(2 + channels)) {
        planes[0][lane] = component.weight;
        planes[1][lane] = component.variance;
        for (channel, plane) in component.mean.iter().zip(&mut planes[2..]) {
            plane[lane] = *channel;
        }
    }
}
