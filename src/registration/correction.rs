//! The correction of a frame's motion and light before the mixture.

use super::{Alignment, Light, Motion};
use crate::frame::{Frame, Mask, Size};
use crate::instruction_set;
use crate::settings::{LightCorrection, Settings, Stabilise};
use fearless_simd::{Simd, dispatch, f32x16, i32x16, prelude::*};
use rayon::prelude::*;

/// Which parts of a frame's alignment are corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CorrectionChoice {
    pub(super) stabilise: Stabilise,
    pub(super) light: LightCorrection,
}

impl Default for CorrectionChoice {
    fn default() -> Self {
        Self::NOTHING
    }
}

impl CorrectionChoice {
    /// No correction.
    pub const NOTHING: Self = Self { stabilise: Stabilise::Off, light: LightCorrection::Off };

    /// The choice in the settings.
    pub const fn new(settings: &Settings) -> Self {
        Self { stabilise: settings.stabilise, light: settings.light }
    }

    /// The correction of a frame of this size and alignment; `None` where the frame stays as it is.
    pub fn correction(self, alignment: &Alignment, size: Size) -> Option<Correction> {
        let motion = self.motion(alignment);
        let light = if self.light == LightCorrection::Off { Light::SAME } else { alignment.light };
        // Correcting less than a tenth of a pixel would only blur.
        let edge = 0.5 * size.width.max(size.height) as f32;
        let still = motion.length() + edge * (motion.turn.abs() + motion.zoom.abs()) < 0.1;
        let motion = if still { Motion::NONE } else { motion };
        (motion != Motion::NONE || light != Light::SAME).then(|| Correction::new(motion, light, size))
    }

    /// The mixture's input at a pixel; `None` outside the image.
    pub fn pixel(self, frame: &Frame, (x, y): (u32, u32)) -> Option<ObservedColour> {
        let rgb = frame.pixel(x, y)?;
        Some(match self.correction(&frame.alignment, frame.size) {
            None => ObservedColour { colour: Some(rgb), applied: Applied::NOTHING },
            Some(correction) => {
                ObservedColour { colour: correction.pixel(frame, x, y), applied: correction.applied(x, y) }
            }
        })
    }

    fn motion(self, alignment: &Alignment) -> Motion {
        match self.stabilise {
            Stabilise::Off => Motion::NONE,
            Stabilise::Shift => alignment.motion.shift(),
            Stabilise::Similarity => alignment.motion,
            // Before the shake was detected, the mixture learned the image around the rest position.
            Stabilise::Auto => {
                alignment.rest.map_or(Motion::NONE, |rest| alignment.motion.after(&rest.inverse()))
            }
        }
    }
}

/// The mixture's input at one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservedColour {
    /// The pixel's colour; `None` where the frame does not show it.
    pub colour: Option<[u8; 3]>,
    /// The correction that was applied.
    pub applied: Applied,
}

/// The correction applied to one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Applied {
    /// The pixel's displacement to the right and down, in pixels.
    pub shift: [f32; 2],
    /// The factor on its luma.
    pub gain: f32,
}

impl Applied {
    /// No correction.
    pub const NOTHING: Self = Self { shift: [0.0; 2], gain: 1.0 };
}

/// Corrects the motion and light of a frame, each pixel independently.
pub struct Correction {
    size: Size,
    motion: Motion,
    light: Light,
    /// Lookup table of each channel's levels.
    levels: Option<Box<[[u8; 256]; 3]>>,
    /// Level of each channel from which on it is clipped by overexposure.
    cut_off: [u8; 3],
}

/// A corrected frame, the mixture's input.
pub struct Corrected {
    /// The frame warped to the reference and in its light.
    pub frame: Frame,
    /// The pixels that the frame does not show, in row order; `None` if it shows all.
    pub unknown: Option<Vec<bool>>,
}

/// The corrected frame; `None` where no correction is needed.
pub fn corrected(frame: &Frame, choice: CorrectionChoice) -> Option<Corrected> {
    choice.correction(&frame.alignment, frame.size).map(|correction| correction.apply(frame))
}

impl Correction {
    fn new(motion: Motion, light: Light, size: Size) -> Self {
        let levels = (light != Light::SAME).then(|| {
            let mut levels = Box::new([[0; 256]; 3]);
            for ((table, gain), offset) in levels.iter_mut().zip(light.gain).zip(light.offset) {
                for (level, to) in table.iter_mut().enumerate() {
                    *to = ((level as f32 - offset) / gain + 0.5).clamp(0.0, 255.0) as u8;
                }
            }
            levels
        });
        let cut_off = light.gain.map(|gain| if gain > 1.0 { 253 } else { u8::MAX });
        let cut_off = if levels.is_some() { cut_off } else { [u8::MAX; 3] };
        Self { size, motion, light, levels, cut_off }
    }

    /// The motion that is corrected.
    pub const fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The corrected colour at (x, y); `None` where the frame does not show it.
    pub fn pixel(&self, frame: &Frame, x: u32, y: u32) -> Option<[u8; 3]> {
        let rgb = if self.motion == Motion::NONE {
            frame.pixel(x, y)
        } else {
            between(frame, fixed(self.row(y as f32)(x as f32)))
        };
        rgb.and_then(|rgb| self.relit_pixel(rgb))
    }

    fn applied(&self, x: u32, y: u32) -> Applied {
        let (x, y) = (x as f32, y as f32);
        let (moved_x, moved_y) = self.row(y)(x);
        let shift = if self.motion == Motion::NONE { [0.0; 2] } else { [moved_x - x, moved_y - y] };
        Applied { shift, gain: if self.levels.is_some() { self.light.luma_gain() } else { 1.0 } }
    }

    fn centre(&self) -> (f32, f32) {
        (0.5 * (self.size.width as f32 - 1.0), 0.5 * (self.size.height as f32 - 1.0))
    }

    /// Maps the pixels of a row to their positions in the frame.
    #[inline(always)]
    fn row(&self, y: f32) -> impl Fn(f32) -> (f32, f32) + use<> {
        let ((centre_x, centre_y), motion) = (self.centre(), self.motion);
        let y = y - centre_y;
        move |x| {
            let (x, y) = motion.apply(x - centre_x, y);
            (x + centre_x, y + centre_y)
        }
    }

    /// A colour of the frame in the reference's light; `None` where it is clipped by overexposure.
    #[inline(always)]
    fn relit_pixel(&self, rgb: [u8; 3]) -> Option<[u8; 3]> {
        let Some(levels) = &self.levels else { return Some(rgb) };
        (!self.is_cut(rgb)).then(|| std::array::from_fn(|channel| levels[channel][usize::from(rgb[channel])]))
    }

    /// Corrects the whole frame.
    pub fn apply(&self, frame: &Frame) -> Corrected {
        let width = self.size.width as usize;
        if let (true, Some(levels)) = (self.motion == Motion::NONE, &self.levels) {
            return self.relit(frame, levels);
        }
        let mut rgb = frame.rgb.clone();
        let mut unknown = vec![false; self.size.pixels()];
        let rows =
            rgb.par_chunks_exact_mut((3 * width).max(1)).zip(unknown.par_chunks_exact_mut(width.max(1)));
        let level = instruction_set::level();
        rows.with_min_len(16).enumerate().for_each(|(y, (row, unknown))| {
            dispatch!(level, simd => self.move_row(simd, frame, y, row, unknown));
        });
        let unknown = holds_true(&unknown).then_some(unknown);
        Corrected { frame: Frame::new(frame.number, frame.size, rgb), unknown }
    }

    /// Warps one row.
    #[inline(always)]
    fn move_row<S: Simd>(&self, simd: S, frame: &Frame, y: usize, row: &mut [u8], unknown: &mut [bool]) {
        let moved = self.row(y as f32);
        let blocks = row.chunks_mut(3 * BLOCK).zip(unknown.chunks_mut(BLOCK));
        for (x, (row, unknown)) in (0..).step_by(BLOCK).zip(blocks) {
            let together = match row.as_mut_array() {
                Some(to) => block_between(simd, frame, &moved, x, to),
                None => false,
            };
            if together && self.levels.is_none() {
                continue;
            }
            for ((x, to), unknown) in (x..).zip(row.as_chunks_mut::<3>().0).zip(unknown) {
                let rgb = if together { Some(*to) } else { between(frame, fixed(moved(x as f32))) };
                match rgb.and_then(|rgb| self.relit_pixel(rgb)) {
                    Some(rgb) => *to = rgb,
                    None => *unknown = true,
                }
            }
        }
    }

    /// Corrects the light of the whole frame, without motion.
    fn relit(&self, frame: &Frame, levels: &[[u8; 256]; 3]) -> Corrected {
        let mut rgb = frame.rgb.clone();
        let mut unknown = vec![false; self.size.pixels()];
        let may_be_cut = self.cut_off != [u8::MAX; 3];
        rgb.par_chunks_mut(3 << 13).zip(unknown.par_chunks_mut(1 << 13)).for_each(|(rgb, unknown)| {
            for (rgb, unknown) in rgb.as_chunks_mut::<3>().0.iter_mut().zip(unknown) {
                if may_be_cut && self.is_cut(*rgb) {
                    *unknown = true;
                } else {
                    *rgb = std::array::from_fn(|channel| levels[channel][usize::from(rgb[channel])]);
                }
            }
        });
        let unknown = holds_true(&unknown).then_some(unknown);
        Corrected { frame: Frame::new(frame.number, frame.size, rgb), unknown }
    }

    /// Whether a colour is clipped by overexposure.
    #[inline(always)]
    fn is_cut(&self, rgb: [u8; 3]) -> bool {
        rgb.iter().zip(self.cut_off).any(|(level, cut_off)| *level >= cut_off && cut_off < u8::MAX)
    }

    /// Warps a mask from the reference's coordinates to those of the frame.
    pub fn mask_of_frame(&self, mask: Mask) -> Mask {
        if self.motion == Motion::NONE {
            return mask;
        }
        let back = self.motion.inverse();
        let (centre_x, centre_y) = self.centre();
        let mut moved = Mask::empty(self.size);
        let level = instruction_set::level();
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let has_any: Vec<bool> = mask.data.chunks_exact(width.max(1)).map(has_foreground).collect();
        moved.data.par_chunks_exact_mut(width.max(1)).with_min_len(16).enumerate().for_each(|(y, row)| {
            let place = |x: f32| {
                let (x, y) = back.apply(x - centre_x, y as f32 - centre_y);
                (x + centre_x + 0.5, y + centre_y + 0.5)
            };
            // The row's source pixels lie between the rows of its two ends.
            let (one, other) = (place(0.0).1, place(width as f32).1);
            let first = (one.min(other) - 1.0).max(0.0) as usize;
            let last = ((one.max(other) + 2.0).max(0.0) as usize).min(height);
            if !has_any.get(first..last).is_some_and(|rows| rows.contains(&true)) {
                return;
            }
            dispatch!(level, simd => nearest(simd, &mask, place, row));
        });
        moved
    }
}

/// The mask's value nearest to each source position of a row; background outside.
#[inline(always)]
fn nearest<S: Simd>(simd: S, mask: &Mask, place: impl Fn(f32) -> (f32, f32), row: &mut [u8]) {
    let (width, height) = (mask.size.width as usize, mask.size.height as usize);
    for (start, row) in (0..).step_by(BLOCK).zip(row.chunks_mut(BLOCK)) {
        let (mut xs, mut ys) = ([0.0_f32; BLOCK], [0.0_f32; BLOCK]);
        for (at, (x, y)) in xs.iter_mut().zip(&mut ys).enumerate() {
            (*x, *y) = place((start + at) as f32);
        }
        let (columns, lines) = (whole(simd, &xs), whole(simd, &ys));
        let (column, line) = (columns[0], lines[0]);
        let mut beside = xs[0] >= 0.0;
        for (at, (x, y)) in columns.iter().zip(&lines).enumerate() {
            beside &= *x == column + at as i32 && *y == line && ys[at] >= 0.0;
        }
        let (column, line) = (column as usize, line as usize);
        if beside && column + BLOCK <= width && line < height {
            row.copy_from_slice(&mask.data[line * width + column..][..row.len()]);
            continue;
        }
        for ((&x, &y), to) in xs.iter().zip(&ys).zip(row) {
            if x >= 0.0 && y >= 0.0 && (x as usize) < width && (y as usize) < height {
                *to = mask.data[y as usize * width + x as usize];
            }
        }
    }
}

fn holds_true(all: &[bool]) -> bool {
    all.chunks(64).any(|some| some.iter().fold(false, |found, one| found | one))
}

fn has_foreground(row: &[u8]) -> bool {
    memchr::memchr(Mask::FOREGROUND, row).is_some()
}

/// Number of pixels of a row that are interpolated together where they are contiguous in the frame.
const BLOCK: usize = 32;

/// The index of the pixel of each byte in a block.
const PIXEL: [i32; 3 * BLOCK] = {
    let mut pixel = [0; 3 * BLOCK];
    let mut at = 0;
    while at < pixel.len() {
        pixel[at] = at as i32 / 3;
        at += 1;
    }
    pixel
};

/// A position in 1/256 of a pixel, before truncation.
#[inline(always)]
fn fixed((x, y): (f32, f32)) -> (f32, f32) {
    (x * 256.0 + 0.5, y * 256.0 + 0.5)
}

/// Truncates to integers.
#[inline(always)]
fn whole<S: Simd, const COUNT: usize>(simd: S, numbers: &[f32; COUNT]) -> [i32; COUNT] {
    let mut all = [0; COUNT];
    for (to, from) in all.as_chunks_mut().0.iter_mut().zip(numbers.as_chunks().0) {
        f32x16::load_array_ref(simd, from).to_int::<i32x16<S>>().store_array(to);
    }
    all
}

/// [`between`] for the pixels of a row from x on, byte by byte; `false`, with `to` unchanged, where they lie outside
/// or are not contiguous in one row.
#[inline(always)]
fn block_between<S: Simd>(
    simd: S,
    frame: &Frame,
    moved: &impl Fn(f32) -> (f32, f32),
    x: usize,
    to: &mut [u8; 3 * BLOCK],
) -> bool {
    let (mut xs, mut ys) = ([0.0; 3 * BLOCK], [0.0; 3 * BLOCK]);
    for ((to_x, to_y), pixel) in xs.iter_mut().zip(&mut ys).zip(PIXEL) {
        (*to_x, *to_y) = fixed(moved((x as i32 + pixel) as f32));
    }
    let (xs, ys) = (whole(simd, &xs), whole(simd, &ys));
    let (column, row) = (xs[0] >> 8, ys[0] >> 8);
    let mut beside = column >= 0 && row >= 0;
    for ((x, y), pixel) in xs.iter().zip(&ys).zip(PIXEL) {
        beside &= x >> 8 == column + pixel && y >> 8 == row;
    }
    let (width, height) = (frame.size.width as usize, frame.size.height as usize);
    let (column, row) = (column as usize, row as usize);
    if !beside || column + BLOCK >= width || row + 1 >= height {
        return false;
    }
    let start = 3 * (row * width + column);
    let (upper, lower) = (&frame.rgb[start..], &frame.rgb[start + 3 * width..]);
    let (Some(upper), Some(lower)) = (upper.first_chunk(), lower.first_chunk()) else { return false };
    for (at, to) in to.iter_mut().enumerate() {
        let (right, down) = (xs[at] as u32 & 255, ys[at] as u32 & 255);
        let mix =
            |row: &[u8; 3 * BLOCK + 3]| u32::from(row[at]) * (256 - right) + u32::from(row[at + 3]) * right;
        *to = ((mix(upper) * (256 - down) + mix(lower) * down + (1 << 15)) >> 16) as u8;
    }
    true
}

/// Bilinear interpolation of the colour at a position in 1/256 of a pixel; `None` outside the outermost pixels'
/// centres.
#[inline(always)]
fn between(frame: &Frame, (x, y): (f32, f32)) -> Option<[u8; 3]> {
    let (x, y) = (x as i32, y as i32);
    if x < 0 || y < 0 {
        return None;
    }
    let (column, row) = (x as usize >> 8, y as usize >> 8);
    let (width, height) = (frame.size.width as usize, frame.size.height as usize);
    if column + 1 >= width || row + 1 >= height {
        return None;
    }
    let (right, down) = (x as u32 & 255, y as u32 & 255);
    let start = 3 * (row * width + column);
    let upper: &[u8; 6] = frame.rgb[start..].first_chunk()?;
    let lower: &[u8; 6] = frame.rgb[start + 3 * width..].first_chunk()?;
    Some(std::array::from_fn(|channel| {
        let mix =
            |pair: &[u8; 6]| u32::from(pair[channel]) * (256 - right) + u32::from(pair[channel + 3]) * right;
        ((mix(upper) * (256 - down) + mix(lower) * down + (1 << 15)) >> 16) as u8
    }))
}
