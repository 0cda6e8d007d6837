//! Hysteresis: a second, narrower band around the background, in levels, which applies near foreground.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::neighbours;
use crate::frame::{Mask, Size};
use crate::settings::Settings;

/// Reclassifies background pixels near foreground.
///
/// The band of λσ has to be wide enough that noise is background everywhere. Near foreground a pixel is more likely
/// to be foreground: clothes of nearly the background's colour, a hole in a body, an edge. There a second threshold
/// is used, as in Canny's edge detector. A *weakly matched* pixel matches the background but is farther from its
/// component's mean than this threshold. It becomes foreground where enough of the square around it is foreground.
/// The threshold is in levels, not in σ: where σ is large (water), the background says little about the pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hysteresis {
    /// Largest distance in levels, from the mean of the matched component, of a pixel that is not weakly matched; 0 is off.
    pub distance: f32,
    /// Side of the square, in pixels.
    pub window: u32,
    /// Least share of foreground among the square's pixels inside the image.
    pub share: f32,
}

impl Hysteresis {
    /// The mask's value of a weakly matched pixel before the vote. Marks of shadow are below it.
    pub const WEAK_MATCH: u8 = 254;

    /// The hysteresis parameters in `settings`.
    pub const fn new(settings: &Settings) -> Self {
        Self {
            distance: settings.hysteresis,
            window: settings.hysteresis_window,
            share: settings.hysteresis_share,
        }
    }

    /// Whether any pixel can be weakly matched.
    pub fn is_on(self) -> bool {
        self.distance > 0.0 && self.window > 0
    }

    /// ‖X − μ‖² above which a pixel is weakly matched.
    pub fn distance_squared(self) -> f32 {
        if self.is_on() { self.distance * self.distance } else { f32::INFINITY }
    }

    /// Decides the weakly matched pixels of each mask by the vote of their neighbours. All instruction sets give the same
    /// result.
    pub(super) fn settle(self, level: Level, masks: &mut [Mask]) {
        if self.is_on() {
            masks.par_iter_mut().for_each(|mask| dispatch!(level, _simd => self.settle_mask(mask)));
        }
    }

    #[inline(always)]
    fn settle_mask(self, mask: &mut Mask) {
        let (size, radius) = (mask.size, self.window as usize / 2);
        neighbours::settle(
            mask,
            radius,
            #[inline(always)]
            |byte| byte == Self::WEAK_MATCH,
            #[inline(always)]
            |mask, y, votes| {
                let row = &mask.data[y * votes.len()..][..votes.len()];
                votes
                    .iter_mut()
                    .zip(row)
                    .for_each(|(vote, &byte)| *vote = i8::from(byte == Mask::FOREGROUND));
            },
            #[inline(always)]
            |foreground, x, y| {
                let enough =
                    f32::from(foreground) >= self.share * pixels_of_square(size, radius, x, y) as f32;
                if enough { Mask::FOREGROUND } else { Mask::BACKGROUND }
            },
        );
    }
}

/// Number of pixels of the square around (x, y) inside the image.
fn pixels_of_square(size: Size, radius: usize, x: usize, y: usize) -> usize {
    let side = |at: usize, length: u32| (at + radius + 1).min(length as usize) - at.saturating_sub(radius);
    side(x, size.width) * side(y, size.height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instruction_set;

    const HYSTERESIS: Hysteresis = Hysteresis { distance: 24.0, window: 7, share: 0.35 };

    fn settled(rows: [&str; 8]) -> Vec<String> {
        let size = Size::new(rows[0].len() as u32, 8);
        let byte = |mark: u8| match mark {
            b'#' => Mask::FOREGROUND,
            b'?' => Hysteresis::WEAK_MATCH,
            _ => Mask::BACKGROUND,
        };
        let mut mask = Mask { size, data: rows.iter().flat_map(|row| row.bytes().map(byte)).collect() };
        HYSTERESIS.settle(instruction_set::level(), std::slice::from_mut(&mut mask));
        let mark = |&byte: &u8| if byte == Mask::FOREGROUND { '#' } else { '.' };
        mask.data.chunks(rows[0].len()).map(|row| row.iter().map(mark).collect()).collect()
    }

    #[test]
    fn doubtful_pixels_are_foreground_only_near_foreground() {
        let filled = settled([
            "..............????",
            "..######......????",
            "..##??##.....?????",
            "..##??##......????",
            "..##..##......????",
            "..######..........",
            "..######?.........",
            "..................",
        ]);
        assert_eq!(
            filled,
            [
                "..................",
                "..######..........",
                "..######..........",
                "..######..........",
                "..##..##..........",
                "..######..........",
                "..######..........",
                "..................",
            ]
        );
    }

    #[test]
    fn hysteresis_of_distance_zero_changes_nothing() {
        let off = |hysteresis: Hysteresis| hysteresis.distance_squared() == f32::INFINITY;
        assert!(
            off(Hysteresis { distance: 0.0, ..HYSTERESIS }) && off(Hysteresis { window: 0, ..HYSTERESIS })
        );
        assert_eq!(HYSTERESIS.distance_squared(), 576.0);
    }
}
