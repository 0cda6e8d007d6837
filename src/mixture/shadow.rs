//! Detects shadows and highlights in the foreground by their colour relative to the background, and removes evenly
//! darkened or brightened areas.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::hysteresis::Hysteresis;
use super::neighbours::{self, BLOCK};
use crate::frame::Mask;
use crate::settings::Settings;

/// The colours of shadow, or highlight, on a surface.
///
/// A shadow attenuates all channels by the same factor. Its value lies on the line from black to the surface's colour
/// μ, not too near black: X ≈ s·μ with τ ≤ s < 1 (Horprasert et al. 1999, where s is the brightness distortion and ‖X
/// − s·μ‖ the chromaticity distortion). A lamp, or a camera that opens its iris, gives s > 1.
///
/// Parts of an object may have such a colour by chance: a dark car on a road, the blurred outline of a fish. A shadow
/// darkens a surface evenly: s is about the same in neighbouring pixels, whatever the surface's pattern, while an
/// object's s follows the object's own pattern. Such a pixel is therefore removed from the mask only where the square
/// around it has at least as many *even* candidates as other foreground pixels. The soft edge of a shadow is near its
/// even interior. The decision depends only on neighbours in the same frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// τ, the darkest shadow as a share of the surface's brightness; 1 is off.
    pub floor: f32,
    /// The brightest highlight as a multiple of the surface's brightness; 1 is off.
    pub ceiling: f32,
    /// Largest distance of X from the line, in levels.
    pub colour: f32,
    /// Side of the voting square in pixels; 0 is no vote.
    pub window: u32,
    /// Largest standard deviation of s in 3 × 3 pixels of an even candidate.
    pub spread: f32,
}

impl Shadow {
    /// Before the vote, a mask has 1 plus this many levels per unit of s at each candidate. s is at most 4, which
    /// stays below `Hysteresis::WEAK_MATCH`.
    pub const LEVELS: f32 = 60.0;

    /// The shadow parameters in `settings`.
    pub const fn new(settings: &Settings) -> Self {
        Self {
            floor: settings.shadow_floor,
            ceiling: settings.light_ceiling,
            colour: settings.shadow_colour,
            window: settings.shadow_window,
            spread: settings.shadow_spread,
        }
    }

    /// Whether shadows or highlights are detected at all.
    pub fn is_on(self) -> bool {
        self.floor < 1.0 || self.ceiling > 1.0
    }

    /// Whether `value` has the colour of a shadow or a highlight on a surface of the colour `mean`.
    pub fn covers(self, value: &[f32], mean: &[f32]) -> bool {
        let (share, off) = self.of(value, mean);
        let darker = self.floor <= share && share < 1.0;
        let brighter = 1.0 < share && share <= self.ceiling;
        self.is_on() && (darker || brighter) && off <= self.colour
    }

    /// The brightness distortion s of `value`, and its chromaticity distortion in levels.
    pub fn of(self, value: &[f32], mean: &[f32]) -> (f32, f32) {
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
        let (along, surface) = (dot(value, mean), dot(mean, mean));
        let share = along / surface;
        (share, (dot(value, value) - share * along).max(0.0).sqrt())
    }

    /// The mask's value, before the vote, of a foreground pixel of this colour on a surface of the colour `mean`.
    pub fn mark(self, value: &[f32], mean: &[f32]) -> u8 {
        match self.covers(value, mean) {
            true if self.window > 0 => 1 + (Self::LEVELS * self.of(value, mean).0) as u8,
            true => Mask::BACKGROUND,
            false => Mask::FOREGROUND,
        }
    }

    /// Decides the candidates of each mask by the vote of their neighbours. All instruction sets give the same
    /// result.
    pub(super) fn settle(self, level: Level, masks: &mut [Mask]) {
        if self.is_on() && self.window > 0 {
            masks.par_iter_mut().for_each(|mask| dispatch!(level, _simd => self.settle_mask(mask)));
        }
    }

    /// A candidate becomes background where the square around it, itself included, has at least as many even
    /// candidates as other foreground pixels; else foreground. Only rows near candidates are processed.
    #[inline(always)]
    fn settle_mask(self, mask: &mut Mask) {
        // Even candidates vote 1, other foreground −1, all others 0; the sum over the square decides.
        neighbours::settle(
            mask,
            self.window as usize / 2,
            is_candidate,
            #[inline(always)]
            |mask, y, votes| self.vote(mask, y, votes),
            #[inline(always)]
            |sum, _, _| if sum >= 0 { Mask::BACKGROUND } else { Mask::FOREGROUND },
        );
    }

    /// The votes of the pixels of row y.
    #[inline(always)]
    fn vote(self, mask: &Mask, y: usize, votes: &mut [i8]) {
        let row = &mask.data[y * votes.len()..][..votes.len()];
        for (block, (votes, bytes)) in votes.chunks_mut(BLOCK).zip(row.chunks(BLOCK)).enumerate() {
            if holds_candidate(bytes) {
                let even = self.even(mask, block * BLOCK, y);
                for ((vote, &byte), even) in votes.iter_mut().zip(bytes).zip(even) {
                    *vote =
                        if is_candidate(byte) { i8::from(even) } else { -i8::from(byte == Mask::FOREGROUND) };
                }
            } else {
                votes
                    .iter_mut()
                    .zip(bytes)
                    .for_each(|(vote, &byte)| *vote = -i8::from(byte == Mask::FOREGROUND));
            }
        }
    }

    /// Whether each pixel from (x, y) on is even: at least half of the 3 × 3 pixels around it are candidates, and
    /// their s is about the same.
    #[inline(always)]
    fn even(self, mask: &Mask, x: usize, y: usize) -> [bool; BLOCK] {
        let (width, height) = (mask.size.width as usize, mask.size.height as usize);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let (mut count, mut sum, mut squares) = ([0_u32; WIDE], [0_u32; WIDE], [0_u32; WIDE]);
        for y in rows.clone() {
            let bytes = from_before(&mask.data[y * width..][..width], x);
            for (at, byte) in bytes.into_iter().enumerate() {
                let level = if is_candidate(byte) { u32::from(byte) } else { 0 };
                count[at] += u32::from(is_candidate(byte));
                sum[at] += level;
                squares[at] += level * level;
            }
        }
        let mut even = [false; BLOCK];
        for (at, even) in even.iter_mut().enumerate() {
            let three = |columns: &[u32; WIDE]| columns[at] + columns[at + 1] + columns[at + 2];
            let (count, sum, squares) = (three(&count), three(&sum), three(&squares));
            let outside = u32::from(x + at == 0) + u32::from(x + at + 1 >= width);
            let pixels = (3 - outside) * rows.len() as u32;
            let deviation = (count * squares - sum * sum) as f32;
            let most = count as f32 * self.spread * Self::LEVELS;
            *even = 2 * count >= pixels && deviation <= most * most;
        }
        even
    }
}

/// [`BLOCK`] pixels, their neighbours, and padding to whole vectors.
const WIDE: usize = BLOCK + 16;

/// The pixels of a row from the one before x on, 0 outside the image.
#[inline(always)]
fn from_before(row: &[u8], x: usize) -> [u8; WIDE] {
    if let Some(inside) = x.checked_sub(1).and_then(|before| row[before..].first_chunk()) {
        return *inside;
    }
    let mut bytes = [Mask::BACKGROUND; WIDE];
    for (byte, &pixel) in bytes[usize::from(x == 0)..].iter_mut().zip(&row[x.saturating_sub(1)..]) {
        *byte = pixel;
    }
    bytes
}

#[inline(always)]
fn holds_candidate(pixels: &[u8]) -> bool {
    pixels.iter().fold(false, |found, &byte| found | is_candidate(byte))
}

/// Whether a pixel is an undecided candidate.
#[inline(always)]
const fn is_candidate(byte: u8) -> bool {
    byte != Mask::BACKGROUND && byte < Hysteresis::WEAK_MATCH
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::frame::Size;
    use crate::instruction_set;

    const SHADOW: Shadow = Shadow { floor: 0.6, ceiling: 1.0, colour: 12.0, window: 0, spread: 0.08 };

    #[test]
    fn a_darkened_surface_is_shadow_above_the_floor() {
        let surface = [180.0, 160.0, 120.0];
        let darkened = |share: f32| surface.map(|channel| share * channel);
        assert!(SHADOW.covers(&darkened(0.9), &surface));
        assert!(SHADOW.covers(&darkened(0.65), &surface));
        assert!(!SHADOW.covers(&darkened(0.5), &surface));
        assert!(!SHADOW.covers(&darkened(1.1), &surface), "a brightened surface is not shadow");
        let light = Shadow { floor: 1.0, ceiling: 1.2, ..SHADOW };
        assert!(light.covers(&darkened(1.1), &surface));
        assert!(!light.covers(&darkened(1.3), &surface) && !light.covers(&darkened(0.9), &surface));
    }

    #[test]
    fn another_colour_is_not_shadow() {
        assert!(!SHADOW.covers(&[150.0, 100.0, 100.0], &[180.0, 160.0, 120.0]));
        assert!(SHADOW.covers(&[128.0, 118.0, 92.0], &[180.0, 160.0, 120.0]), "noise is tolerated");
    }

    #[test]
    fn black_has_no_shadow_and_no_shadow_is_detected_when_off() {
        assert!(!SHADOW.covers(&[0.0; 3], &[0.0; 3]));
        let off = Shadow { floor: 1.0, ..SHADOW };
        assert!(!off.covers(&[90.0; 3], &[100.0; 3]));
    }

    /// The mask's value of a candidate with this s.
    fn candidate(share: f32) -> u8 {
        Shadow { window: 7, ..SHADOW }.mark(&[share * 200.0], &[200.0])
    }

    /// An isolated block of 10 × 8 candidates whose s is `share`.
    fn block(share: impl Fn(u32, u32) -> f32) -> Mask {
        let mut mask = Mask::empty(Size::new(30, 12));
        for (x, y) in (2..10).flat_map(|y| (2..12).map(move |x| (x, y))) {
            mask.data[(y * 30 + x) as usize] = candidate(share(x, y));
        }
        mask
    }

    fn settled(mut mask: Mask) -> Mask {
        Shadow { window: 7, ..SHADOW }.settle(instruction_set::level(), std::slice::from_mut(&mut mask));
        mask
    }

    #[test]
    fn an_area_of_candidates_is_removed_and_a_patch_on_an_object_is_kept() {
        let mut mask = block(|_, _| 0.7);
        for (x, y) in (2..10).flat_map(|y| (16..28).map(move |x| (x, y))) {
            let patch = (4..7).contains(&y) && (20..23).contains(&x);
            mask.data[y * 30 + x] = if patch { candidate(0.7) } else { Mask::FOREGROUND };
        }
        let mask = settled(mask);
        assert!((0..15).all(|x| (0..12).all(|y| !mask.is_foreground(x, y))));
        assert!((16..28).all(|x| (2..10).all(|y| mask.data[y * 30 + x] == Mask::FOREGROUND)));
    }

    #[test]
    fn even_candidates_are_shadow_and_patterned_ones_foreground() {
        let bare = Mask::empty(Size::new(30, 12));
        assert_eq!(settled(block(|_, _| 0.7)), bare);
        assert_eq!(
            settled(block(|x, _| if x < 4 { 0.98 - 0.07 * x as f32 } else { 0.7 })),
            bare,
            "with a soft edge"
        );
        // Uneven candidates do not vote: near other foreground they become foreground.
        let patterned = |x: u32, y: u32| if (x + y).is_multiple_of(2) { 0.65 } else { 0.95 };
        let mut car = block(patterned);
        car.data[5 * 30 + 12] = Mask::FOREGROUND;
        assert!(settled(car).is_foreground(10, 5));
    }

    proptest! {
        #[test]
        fn neighbours_are_counted_in_the_square(
            (width, height) in (1_u32..40, 1_u32..30),
            radius in 1_u32..8,
            values in prop::collection::vec(0_usize..9, 40 * 30),
        ) {
            let size = Size::new(width, height);
            let choice = [0, 0, 0, 0, 40, 41, 43, 50, 255];
            let data: Vec<u8> = values[..size.pixels()].iter().map(|&at| choice[at]).collect();
            let mut mask = Mask { size, data: data.clone() };
            let shadow = Shadow { window: 2 * radius + 1, spread: 0.077, ..SHADOW };
            shadow.settle(instruction_set::level(), std::slice::from_mut(&mut mask));
            let at = |x: u32, y: u32| data[(y * width + x) as usize];
            let around = |x: u32, y: u32, radius: u32| {
                let rows = y.saturating_sub(radius)..=(y + radius).min(height - 1);
                let columns = x.saturating_sub(radius)..=(x + radius).min(width - 1);
                rows.flat_map(|y| columns.clone().map(move |x| (x, y))).collect::<Vec<_>>()
            };
            let is_candidate = |byte: u8| byte > 0 && byte < 255;
            let is_even = |x: u32, y: u32| {
                let square: Vec<u8> = around(x, y, 1).into_iter().map(|(x, y)| at(x, y)).collect();
                let shares: Vec<f64> =
                    square.iter().filter(|byte| is_candidate(**byte)).map(|&byte| f64::from(byte) / 60.0).collect();
                let mean = shares.iter().sum::<f64>() / shares.len() as f64;
                let variance = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / shares.len() as f64;
                2 * shares.len() >= square.len() && variance.sqrt() <= 0.077
            };
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let votes = around(x, y, radius).into_iter().map(|(x, y)| match at(x, y) {
                    0 => 0,
                    255 => -1,
                    _ => i32::from(is_even(x, y)),
                });
                let expected = match at(x, y) {
                    byte if !is_candidate(byte) => byte,
                    _ if votes.sum::<i32>() >= 0 => 0,
                    _ => 255,
                };
                prop_assert_eq!(mask.data[(y * width + x) as usize], expected, "{} {}", x, y);
            }
        }
    }

    #[test]
    fn the_mark_of_a_candidate_is_its_share_of_the_brightness() {
        let shadow = Shadow { floor: 0.4, ceiling: 1.5, colour: 10.0, window: 5, spread: 0.07 };
        let mean = [100.0, 80.0, 60.0];
        let marks = |shadow: Shadow| {
            [0.3_f32, 0.5, 0.75, 1.25, 1.6].map(|share| shadow.mark(&mean.map(|level| share * level), &mean))
        };
        assert_eq!(marks(shadow), [Mask::FOREGROUND, 31, 46, 76, Mask::FOREGROUND]);
        let removed = Mask::BACKGROUND;
        assert_eq!(
            marks(Shadow { window: 0, ..shadow }),
            [Mask::FOREGROUND, removed, removed, removed, Mask::FOREGROUND]
        );
    }
}
