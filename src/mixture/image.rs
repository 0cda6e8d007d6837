//! The mixtures of a whole image, optimised: equal to [`Pixel::update`] bit for bit.
//!
//! Pixels are independent, except for the votes of neighbours on shadow and weak matches, which come last. They are
//! stored in tiles of sixteen, and a tile processes many frames while its mixtures are in the nearest cache.
//! [`Mixture::step_many`] loads and stores the state of a pixel once for all frames, [`Mixture::step`] once per frame.

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::pixel::{Parameters, Pixel};
use super::tile::{
    self, Constants, FrameParameters, Gaussians, LANES, StoredTile, Tile, TileRgb, VerdictMemories,
};
use crate::frame::{Frame, Mask, Size};
use crate::instruction_set;
use crate::registration::Corrected;
use crate::settings::{Rate, Space};

/// Number of tiles in a thread's job: the values of a batch of frames then fit the nearest caches.
const TILES_A_JOB: usize = 64;

/// Number of frames that a tile processes before the next tile.
pub const BATCH: usize = 16;

/// One mixture for every pixel of an image.
///
/// Memory: K·(n + 2) numbers of 4 bytes per pixel, 60 bytes for K = 3 in colour, and 12 bytes with feedback. Where
/// all pixels of a tile match component 1, a frame loads and stores only component 1: 20 bytes per pixel each way.
#[derive(Clone)]
pub struct Mixture {
    size: Size,
    parameters: Parameters,
    /// Number of frames processed so far.
    t: u32,
    pub(super) planes: Planes,
}

#[derive(Clone)]
pub(super) enum Planes {
    Rgb(Tiles<3>),
    Gray(Tiles<1>),
}

/// All tiles of an image, in row order of their pixels.
#[derive(Clone)]
pub(super) struct Tiles<const N: usize> {
    /// Component 1, stored separately: in most tiles a frame touches nothing else.
    pub(super) first: Vec<Gaussians<N>>,
    /// Components 2 to K, tile by tile.
    pub(super) others: Vec<Gaussians<N>>,
    /// For each tile the number of components that were ever in use in any of its pixels.
    pub(super) used: Vec<u8>,
    /// For each tile the frame as of which the weights of `others` are stored.
    settled: Vec<u32>,
    /// For each tile the past classification of its pixels; empty where feedback is off.
    pub(super) pasts: Vec<VerdictMemories>,
}

impl Mixture {
    /// New mixtures for images of `size`.
    pub fn new(size: Size, parameters: Parameters) -> Self {
        let tiles = size.pixels().div_ceil(LANES);
        let planes = match parameters.space {
            Space::Rgb => Planes::Rgb(Tiles::new(tiles, &parameters)),
            Space::Gray => Planes::Gray(Tiles::new(tiles, &parameters)),
        };
        Self { size, parameters, t: 0, planes }
    }

    /// The size of the images.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The parameters of the pixel process.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Number of frames processed so far.
    pub const fn frames_seen(&self) -> u32 {
        self.t
    }

    /// A snapshot of the state, without components that were never used.
    pub fn snapshot(&self) -> Snapshot {
        let packed = match &self.planes {
            Planes::Rgb(tiles) => PackedPlanes::Rgb(tiles.pack(self.parameters.k)),
            Planes::Gray(tiles) => PackedPlanes::Gray(tiles.pack(self.parameters.k)),
        };
        Snapshot { t: self.t, packed }
    }

    /// Restores the state of `snapshot`, which was taken of this mixture or of one of the same size and parameters.
    /// Otherwise returns `false` and changes nothing.
    pub fn restore(&mut self, snapshot: &Snapshot) -> bool {
        let k = self.parameters.k;
        let restored = match (&mut self.planes, &snapshot.packed) {
            (Planes::Rgb(tiles), PackedPlanes::Rgb(packed)) => tiles.unpack(k, packed),
            (Planes::Gray(tiles), PackedPlanes::Gray(packed)) => tiles.unpack(k, packed),
            _ => false,
        };
        if restored {
            self.t = snapshot.t;
        }
        restored
    }

    /// Processes the next frame and returns its foreground mask, in the reference's coordinates where shake is
    /// corrected.
    ///
    /// # Panics
    /// If the frame has another size than the mixture.
    pub fn step(&mut self, frame: &Frame) -> Mask {
        let mut mask = Mask::empty(self.size);
        self.step_many(&[frame], std::slice::from_mut(&mut mask));
        mask
    }

    /// Processes the next frames in order and writes their foreground masks: equal to [`Mixture::step`] frame by
    /// frame, but several times faster.
    ///
    /// # Panics
    /// If a frame has another size than the mixture, or the numbers of masks and frames differ.
    pub fn step_many(&mut self, frames: &[&Frame], masks: &mut [Mask]) {
        assert_eq!(frames.len(), masks.len(), "a mask for each frame");
        self.begin();
        for (frames, masks) in frames.chunks(BATCH).zip(masks.chunks_mut(BATCH)) {
            self.take_corrected(frames, masks);
        }
    }

    /// Learns from frames before the first classified one: the first frames of a file, which are classified
    /// afterwards.
    ///
    /// # Panics
    /// If a frame has another size than the mixture.
    pub fn learn(&mut self, frames: &[&Frame]) {
        let mut masks = vec![Mask::empty(self.size); frames.len().min(BATCH)];
        for frames in frames.chunks(BATCH) {
            self.parameters.learnt = self.t + frames.len() as u32;
            self.take_corrected(frames, &mut masks[..frames.len()]);
        }
    }

    /// Makes the learned state the start of classification, after the last frame to learn from. The next frame does
    /// this otherwise; needed only to read the state before it.
    pub fn begin(&mut self) {
        if !self.parameters.begins_at(self.t + 1) {
            return;
        }
        match &mut self.planes {
            Planes::Rgb(tiles) => tiles.begin(&self.parameters, self.t),
            Planes::Gray(tiles) => tiles.begin(&self.parameters, self.t),
        }
    }

    /// Processes frames after registration.
    fn take_corrected(&mut self, frames: &[&Frame], masks: &mut [Mask]) {
        let choice = self.parameters.registration;
        let corrections: Vec<_> =
            frames.iter().map(|frame| choice.correction(&frame.alignment, frame.size)).collect();
        if corrections.iter().all(Option::is_none) {
            self.take(instruction_set::level(), frames, &[], masks);
            return;
        }
        let corrected: Vec<Option<Corrected>> = corrections
            .par_iter()
            .zip(frames)
            .map(|(correction, frame)| Some(correction.as_ref()?.apply(frame)))
            .collect();
        let pairs = corrected.iter().zip(frames);
        let seen: Vec<_> =
            pairs.map(|(corrected, frame)| corrected.as_ref().map_or(*frame, |seen| &seen.frame)).collect();
        let unknown: Vec<_> = corrected
            .iter()
            .map(|corrected| corrected.as_ref().and_then(|seen| seen.unknown.as_deref()))
            .collect();
        self.take(instruction_set::level(), &seen, &unknown, masks);
    }

    /// Processes frames with the instruction set `level`; all give the same bits. `unknown` is empty, or has for each
    /// frame the pixels that it does not show, if any; their mixtures do not change.
    fn take(&mut self, level: Level, frames: &[&Frame], unknown: &[Option<&[bool]>], masks: &mut [Mask]) {
        for (frame, mask) in frames.iter().zip(&*masks) {
            assert!(
                frame.size == self.size && mask.size == self.size,
                "frames and masks of the mixture's size"
            );
        }
        let constants = Constants::new(&self.parameters);
        let frame_parameters: Vec<_> =
            (self.t + 1..).take(frames.len()).map(|t| constants.moment(t)).collect();
        self.t += frames.len() as u32;
        let k = self.parameters.k;
        match &mut self.planes {
            Planes::Rgb(tiles) => tiles.take(k, frames, unknown, masks, |near, job| {
                dispatch!(level, simd => run::<_, 3>(simd, near, job, &constants, &frame_parameters));
            }),
            Planes::Gray(tiles) => tiles.take(k, frames, unknown, masks, |near, job| {
                dispatch!(level, simd => run::<_, 1>(simd, near, job, &constants, &frame_parameters));
            }),
        }
        self.parameters.shadow.settle(level, masks);
        self.parameters.hysteresis.settle(level, masks);
    }

    /// The mixture of pixel (x, y), or `None` outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Pixel> {
        self.size.index(x, y).map(|index| self.pixel_at(index))
    }

    fn pixel_at(&self, index: usize) -> Pixel {
        match &self.planes {
            Planes::Rgb(tiles) => tiles.pixel(index, &self.parameters, self.t),
            Planes::Gray(tiles) => tiles.pixel(index, &self.parameters, self.t),
        }
    }
}

/// The state of a [`Mixture`], packed: most pixels use one or two components.
pub struct Snapshot {
    t: u32,
    packed: PackedPlanes,
}

enum PackedPlanes {
    Rgb(Packed<3>),
    Gray(Packed<1>),
}

/// All tiles of an image, with only the components that were ever used.
struct Packed<const N: usize> {
    first: Vec<Gaussians<N>>,
    /// For each tile, components 2 to the last one in use.
    others: Vec<Gaussians<N>>,
    used: Vec<u8>,
    settled: Vec<u32>,
    pasts: Vec<VerdictMemories>,
}

impl Snapshot {
    /// Size in memory, in bytes.
    pub const fn bytes(&self) -> usize {
        match &self.packed {
            PackedPlanes::Rgb(packed) => packed.bytes(),
            PackedPlanes::Gray(packed) => packed.bytes(),
        }
    }
}

impl<const N: usize> Packed<N> {
    const fn bytes(&self) -> usize {
        (self.first.len() + self.others.len()) * size_of::<Gaussians<N>>()
            + self.used.len() * 5
            + self.pasts.len() * size_of::<VerdictMemories>()
    }
}

/// Consecutive tiles, and their part of consecutive frames and masks.
struct TileJob<'a, const N: usize> {
    state: TileStates<'a, N>,
    /// The bytes of each frame.
    rgb: Vec<&'a [u8]>,
    /// For each frame the pixels that it does not show; empty where all frames show all pixels.
    unknown: Vec<Option<&'a [bool]>>,
    /// The bytes of each mask.
    masks: Vec<&'a mut [u8]>,
}

/// The state of a job's tiles.
struct TileStates<'a, const N: usize> {
    first: &'a mut [Gaussians<N>],
    others: &'a mut [Gaussians<N>],
    used: &'a mut [u8],
    settled: &'a mut [u32],
    /// Empty where feedback is off.
    pasts: &'a mut [VerdictMemories],
}

impl<const N: usize> TileStates<'_, N> {
    /// One tile, of K components.
    #[inline(always)]
    fn tile(&mut self, index: usize, k: usize) -> Tile<'_, N> {
        let others = k - 1;
        Tile {
            first: &mut self.first[index],
            others: &mut self.others[index * others..(index + 1) * others],
            used: &mut self.used[index],
            settled: &mut self.settled[index],
            pasts: self.pasts.get_mut(index),
            place: index as u32,
        }
    }
}

impl<const N: usize> Tiles<N> {
    fn new(tiles: usize, parameters: &Parameters) -> Self {
        Self {
            first: vec![Gaussians::UNUSED; tiles],
            others: vec![Gaussians::UNUSED; tiles * (parameters.k - 1)],
            used: vec![0; tiles],
            settled: vec![0; tiles],
            pasts: vec![VerdictMemories::NONE; if parameters.feedback.is_on() { tiles } else { 0 }],
        }
    }

    fn pack(&self, k: usize) -> Packed<N> {
        let in_use = |used: u8| usize::from(used).saturating_sub(1);
        let mut others = Vec::with_capacity(self.used.iter().map(|&used| in_use(used)).sum());
        for (tile, &used) in self.others.chunks((k - 1).max(1)).zip(&self.used) {
            others.extend_from_slice(&tile[..in_use(used)]);
        }
        Packed {
            first: self.first.clone(),
            others,
            used: self.used.clone(),
            settled: self.settled.clone(),
            pasts: self.pasts.clone(),
        }
    }

    fn unpack(&mut self, k: usize, packed: &Packed<N>) -> bool {
        let alike = packed.first.len() == self.first.len() && packed.pasts.len() == self.pasts.len();
        if !alike || packed.used.iter().any(|&used| usize::from(used) > k) {
            return false;
        }
        let mut others = &packed.others[..];
        for ((tile, &used), old) in self.others.chunks_mut((k - 1).max(1)).zip(&packed.used).zip(&self.used) {
            let (mine, rest) = others.split_at(usize::from(used).saturating_sub(1));
            others = rest;
            tile[..mine.len()].copy_from_slice(mine);
            // Components that came into use since the snapshot are reset.
            if old > &used {
                tile[mine.len()..usize::from(*old) - 1].fill(Gaussians::UNUSED);
            }
        }
        self.first.copy_from_slice(&packed.first);
        self.used.copy_from_slice(&packed.used);
        self.settled.copy_from_slice(&packed.settled);
        self.pasts.copy_from_slice(&packed.pasts);
        true
    }

    /// The factors, in order, by which the stored weights of a tile's components 2 to K are to be multiplied.
    pub(super) fn keep(&self, tile: usize, mixture: &Mixture) -> Vec<f32> {
        (self.settled[tile] + 1..=mixture.t).map(|t| 1.0 - mixture.parameters.alpha_at(t)).collect()
    }

    /// [`Pixel::begin`] after the frame `t`.
    fn begin(&mut self, parameters: &Parameters, t: u32) {
        let others = parameters.k - 1;
        for tile in 0..self.first.len() {
            if self.used[tile] <= 1 {
                self.settled[tile] = t;
                self.used[tile] = 1;
                self.first[tile].make_certain();
                if let Some(pasts) = self.pasts.get_mut(tile) {
                    *pasts = VerdictMemories::NONE;
                }
                continue;
            }
            let mut used = 1;
            for lane in 0..LANES {
                let mut pixel = self.pixel(tile * LANES + lane, parameters, t);
                pixel.begin(parameters);
                if let Some(pasts) = self.pasts.get_mut(tile) {
                    pasts.begin_lane(lane, pixel.past());
                }
                used = used.max(pixel.used());
                let mut gaussians =
                    std::iter::once(&mut self.first[tile]).chain(&mut self.others[tile * others..]);
                for component in pixel.components() {
                    if let Some(gaussians) = gaussians.next() {
                        gaussians.set_lane(lane, component);
                    }
                }
            }
            (self.used[tile], self.settled[tile]) = (used as u8, t);
        }
    }

    fn pixel(&self, index: usize, parameters: &Parameters, t: u32) -> Pixel {
        let (tile, others) = (index / LANES, parameters.k - 1);
        let others = &self.others[tile * others..(tile + 1) * others];
        let stored = StoredTile {
            first: &self.first[tile],
            others,
            settled: self.settled[tile],
            pasts: self.pasts.get(tile),
        };
        tile::read(&stored, index % LANES, parameters, t)
    }

    /// Divides the image among threads.
    fn take(
        &mut self,
        k: usize,
        frames: &[&Frame],
        unknown: &[Option<&[bool]>],
        masks: &mut [Mask],
        run: impl Fn(&mut JobBuffers, TileJob<'_, N>) + Send + Sync,
    ) {
        const PIXELS: usize = LANES * TILES_A_JOB;
        let mut masks: Vec<_> = masks.iter_mut().map(|mask| mask.data.chunks_mut(PIXELS)).collect();
        let mut others = self.others.chunks_mut(((k - 1) * TILES_A_JOB).max(1));
        let parts = self.first.chunks_mut(TILES_A_JOB).zip(self.used.chunks_mut(TILES_A_JOB));
        let parts = parts.zip(self.settled.chunks_mut(TILES_A_JOB));
        let mut pasts = self.pasts.chunks_mut(TILES_A_JOB);
        let jobs: Vec<_> = parts
            .enumerate()
            .map(|(part, ((first, used), settled))| {
                let pixels = part * PIXELS
                    ..((part + 1) * PIXELS).min(frames.first().map_or(0, |frame| frame.size.pixels()));
                let others = others.next().unwrap_or_default();
                let pasts = pasts.next().unwrap_or_default();
                TileJob {
                    state: TileStates { first, others, used, settled, pasts },
                    rgb: frames.iter().map(|frame| &frame.rgb[3 * pixels.start..3 * pixels.end]).collect(),
                    unknown: unknown.iter().map(|unknown| unknown.map(|all| &all[pixels.clone()])).collect(),
                    masks: masks.iter_mut().filter_map(Iterator::next).collect(),
                }
            })
            .collect();
        jobs.into_par_iter().for_each_init(JobBuffers::default, run);
    }
}

/// Buffers for a job's part of its frames and masks, ordered by tile and then by frame: access to contiguous memory
/// is fastest, and a tile needs little of each frame.
#[derive(Default)]
struct JobBuffers {
    rgb: Vec<TileRgb>,
    marks: Vec<[u8; LANES]>,
}

impl JobBuffers {
    /// Copies the frames into the buffer. The last tile of an image may have fewer pixels than lanes; its spare lanes
    /// process zeros, and their results are not read.
    #[inline(always)]
    fn take(&mut self, frames: &[&[u8]], tiles: usize) {
        self.rgb.resize(tiles * frames.len(), [0; 3 * LANES]);
        self.marks.resize(tiles * frames.len(), [Mask::BACKGROUND; LANES]);
        for (place, rgb) in frames.iter().enumerate() {
            let (whole, rest) = rgb.as_chunks();
            let mut to = self.rgb[place..].iter_mut().step_by(frames.len());
            to.by_ref().zip(whole).for_each(|(to, from)| *to = *from);
            if let Some(to) = to.next() {
                *to = [0; 3 * LANES];
                to[..rest.len()].copy_from_slice(rest);
            }
        }
    }

    /// Copies the results to the masks.
    #[inline(always)]
    fn give(&self, masks: &mut [&mut [u8]]) {
        let frames = masks.len();
        for (place, mask) in masks.iter_mut().enumerate() {
            let (whole, rest) = mask.as_chunks_mut();
            let mut from = self.marks[place..].iter().step_by(frames);
            whole.iter_mut().zip(from.by_ref()).for_each(|(to, from)| *to = *from);
            rest.iter_mut().zip(from.flatten()).for_each(|(to, from)| *to = *from);
        }
    }
}

/// Processes the job's frames tile by tile; where the result of a frame has a long latency and the next frame needs
/// it, frame by frame, so that the tiles overlap their latencies.
#[inline(always)]
fn run<S: Simd, const N: usize>(
    simd: S,
    near: &mut JobBuffers,
    mut job: TileJob<'_, N>,
    constants: &Constants,
    frame_parameters: &[FrameParameters],
) {
    near.take(&job.rgb, job.state.first.len());
    let frames_a_turn = if constants.rate() == Rate::Density { 1 } else { frame_parameters.len() };
    for start in (0..frame_parameters.len()).step_by(frames_a_turn.max(1)) {
        let frames = start..frame_parameters.len().min(start + frames_a_turn);
        for index in 0..job.state.first.len() {
            run_tile(simd, near, &mut job, index, frames.clone(), constants, frame_parameters);
        }
    }
    near.give(&mut job.masks);
}

/// Processes some of the frames with one tile; `frame_parameters` has those of all frames.
#[inline(always)]
fn run_tile<S: Simd, const N: usize>(
    simd: S,
    near: &mut JobBuffers,
    job: &mut TileJob<'_, N>,
    index: usize,
    frames: Range<usize>,
    constants: &Constants,
    frame_parameters: &[FrameParameters],
) {
    let start = index * LANES;
    let hidden = |unknown: Option<&[bool]>| match unknown.map(|all| &all[start..]) {
        // A length known at compile time makes this a single comparison.
        Some(all) => all.first_chunk().map_or_else(|| all.contains(&true), |lanes| *lanes != [false; LANES]),
        None => false,
    };
    if job.unknown.get(frames.clone()).is_some_and(|unknown| unknown.iter().copied().any(hidden)) {
        run_partly_known(simd, near, job, index, frames, constants, frame_parameters);
        return;
    }
    run_known(simd, near, job, index, frames, constants, frame_parameters);
}

/// Processes frames one by one with a tile of which some frame does not show all pixels: the effect of such a frame
/// on those pixels is undone.
#[cold]
#[inline(never)]
fn run_partly_known<S: Simd, const N: usize>(
    simd: S,
    near: &mut JobBuffers,
    job: &mut TileJob<'_, N>,
    index: usize,
    frames: Range<usize>,
    constants: &Constants,
    frame_parameters: &[FrameParameters],
) {
    let (start, others) = (index * LANES, constants.k() - 1);
    for frame in frames {
        let unknown = job.unknown[frame].map(|all| &all[start..all.len().min(start + LANES)]);
        let Some(unknown) = unknown.filter(|unknown| unknown.contains(&true)) else {
            run_known(simd, near, job, index, frame..frame + 1, constants, frame_parameters);
            continue;
        };
        let t = frame_parameters[frame].t();
        settle(simd, job, index, t - 1, constants);
        let range = index * others..(index + 1) * others;
        let before = (
            job.state.first[index],
            job.state.others[range.clone()].to_vec(),
            job.state.pasts.get(index).copied(),
        );
        run_known(simd, near, job, index, frame..frame + 1, constants, frame_parameters);
        settle(simd, job, index, t, constants);
        for (lane, _) in unknown.iter().enumerate().filter(|(_, unknown)| **unknown) {
            job.state.first[index].take_lane(lane, &before.0);
            for (other, before) in job.state.others[range.clone()].iter_mut().zip(&before.1) {
                other.take_lane(lane, before);
            }
            if let Some((pasts, before)) = job.state.pasts.get_mut(index).zip(before.2.as_ref()) {
                pasts.take_lane(lane, before);
            }
            near.marks[index * frame_parameters.len() + frame][lane] = Mask::BACKGROUND;
        }
    }
}

/// Brings a tile's weights up to date as of frame `t`.
fn settle<S: Simd, const N: usize>(
    simd: S,
    job: &mut TileJob<'_, N>,
    index: usize,
    t: u32,
    constants: &Constants,
) {
    job.state.tile(index, constants.k()).settle(simd, t, constants);
}

#[inline(always)]
fn run_known<S: Simd, const N: usize>(
    simd: S,
    near: &mut JobBuffers,
    job: &mut TileJob<'_, N>,
    index: usize,
    frames: Range<usize>,
    constants: &Constants,
    frame_parameters: &[FrameParameters],
) {
    let places = index * frame_parameters.len() + frames.start..index * frame_parameters.len() + frames.end;
    let (rgb, marks) = (&near.rgb[places.clone()], &mut near.marks[places]);
    job.state.tile(index, constants.k()).run(simd, constants, &frame_parameters[frames], rgb, marks);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Preset, Settings};

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let size = Size::new(53, 3);
        let frames: Vec<_> = (1..=80_u32)
            .map(|number| {
                let byte = |at: usize| {
                    let mut noise = (at as u32).wrapping_mul(2_654_435_761) ^ number.wrapping_mul(40_503);
                    noise ^= noise >> 13;
                    noise = noise.wrapping_mul(0x5bd1_e995);
                    noise ^= noise >> 15;
                    if noise.is_multiple_of(23) {
                        (noise >> 8) as u8
                    } else {
                        (at * 7) as u8 ^ (noise >> 28) as u8
                    }
                };
                Frame::new(number, size, (0..size.pixels() * 3).map(byte).collect())
            })
            .collect();
        let frames: Vec<_> = frames.iter().collect();
        for (rate, space, preset) in [
            (Rate::Density, Space::Rgb, Preset::Plain),
            (Rate::Weight, Space::Rgb, Preset::Plain),
            (Rate::Density, Space::Gray, Preset::Plain),
            (Rate::Weight, Space::Rgb, Preset::Default),
        ] {
            let settings = Settings { rate, space, alpha: 0.05, ..Settings::preset(preset) };
            let run = |level| {
                let mut mixture = Mixture::new(size, Parameters::new(&settings));
                let mut masks = vec![Mask::empty(size); frames.len()];
                mixture.take(level, &frames, &[], &mut masks);
                let pixels: Vec<_> = (0..size.pixels()).map(|index| mixture.pixel_at(index)).collect();
                (masks, format!("{pixels:?}"))
            };
            let levels = instruction_set::tests::all();
            let plainest = run(levels[0]);
            assert!(plainest.0.iter().any(|mask| mask.foreground_pixels() > 0));
            for &level in &levels[1..] {
                assert!(run(level) == plainest, "{level:?} differs, {rate:?}, {space:?}");
            }
        }
    }

    /// Pixels that show another surface for one to five frames of every three to eighteen, among them lamps that recur
    /// and places that stay for too long.
    #[test]
    fn the_start_after_recurring_changes_equals_the_reference() {
        const LEARNT: u32 = 100;
        let size = Size::new(80, 1);
        let frames: Vec<_> = (1..=LEARNT + 30)
            .map(|number| {
                let level = |x: u32| {
                    let (period, stay) = (3 + x % 16, 1 + x / 16);
                    let noise = (number * 7 + x * 3) % 5;
                    (if (number + x) % period < stay { 180 } else { 90 } + noise) as u8
                };
                Frame::new(number, size, (0..size.width).flat_map(|x| [level(x); 3]).collect())
            })
            .collect();
        let (learnt, rest) = frames.split_at(LEARNT as usize);
        let settings = Settings { k: 3, alpha: 0.02, ..Settings::preset(Preset::Default) };
        let mut mixture = Mixture::new(size, Parameters::new(&settings));
        mixture.learn(&learnt.iter().collect::<Vec<_>>());
        let parameters = *mixture.parameters();
        assert_eq!(parameters.learnt, LEARNT);
        let mut pixels = vec![Pixel::unseen(parameters.k); size.pixels()];
        let value = |frame: &Frame, index: usize| {
            parameters.value([frame.rgb[3 * index], frame.rgb[3 * index + 1], frame.rgb[3 * index + 2]])
        };
        for (t, frame) in (1..).zip(learnt) {
            for (index, pixel) in pixels.iter_mut().enumerate() {
                pixel.step(value(frame, index), t, &parameters);
            }
        }
        for (t, frame) in (LEARNT + 1..).zip(rest) {
            mixture.step(frame);
            for (index, pixel) in pixels.iter_mut().enumerate() {
                pixel.step(value(frame, index), t, &parameters);
                assert_eq!(mixture.pixel_at(index), *pixel, "pixel {index} in frame {t}");
            }
            if t == LEARNT + 1 {
                let restless = pixels.iter().filter(|pixel| pixel.past().unrest > 0.0).count();
                assert!((10..70).contains(&restless), "{restless} of 80 recur");
            }
        }
    }
}
