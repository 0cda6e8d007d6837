//! Foreground that is light: the surface behind it, darkened by a shadow or brightened.

use rayon::prelude::*;

use crate::frame::Mask;
use crate::settings::Settings;

/// Which values are shadow, or more light, on a surface.
///
/// A shadow takes light away from all channels alike. So its value lies on the line from black to
/// the surface's colour μ, not too near to black: X ≈ s·μ with τ ≤ s < 1 (Horprasert et al. 1999,
/// whose s is the brightness distortion, and ‖X − s·μ‖ the chromaticity distortion). A lamp, or a camera that opens
/// its iris, gives s > 1.
///
/// An object may by chance have the colour of the surface in another light, but seldom all over: a dark car has windows
/// and wheels. Light falls on whole areas. So such a pixel leaves the mask only where there are at least as many of
/// its kind around it as there is other foreground; the decision of one pixel then hangs on its neighbours in
/// the same frame, and on nothing before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// τ, the darkest shadow as a share of the surface's brightness; 1 where there is none.
    pub floor: f32,
    /// The brightest light as a multiple of the surface's brightness; 1 where there is none.
    pub ceiling: f32,
    /// How far, in levels, X may lie from the line.
    pub colour: f32,
    /// Side of the square of neighbours that are counted, in pixels; 0 where none are.
    pub window: u32,
}

impl Shadow {
    /// What a mask holds where a pixel is light by its colour, until its neighbours are counted.
    pub(super) const CANDIDATE: u8 = 1;

    /// The part of `settings` about shadow and light.
    pub const fn new(settings: &Settings) -> Self {
        Self {
            floor: settings.shadow_floor,
            ceiling: settings.light_ceiling,
            colour: settings.shadow_colour,
            window: settings.shadow_window,
        }
    }

    /// Whether anything is taken for shadow or light at all.
    pub fn is_on(self) -> bool {
        self.floor < 1.0 || self.ceiling > 1.0
    }

    /// Whether `value` has the colour of a shadow, or of more light, on a surface of the colour `mean`.
    pub fn covers(self, value: &[f32], mean: &[f32]) -> bool {
        let (share, off) = self.of(value, mean);
        let darker = self.floor <= share && share < 1.0;
        let brighter = 1.0 < share && share <= self.ceiling;
        self.is_on() && (darker || brighter) && off <= self.colour
    }

    /// The share of the surface's brightness that is nearest to `value`, and how far, in levels,
    /// the value is from the surface's colour at that brightness.
    pub fn of(self, value: &[f32], mean: &[f32]) -> (f32, f32) {
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
        let (along, surface) = (dot(value, mean), dot(mean, mean));
        let share = along / surface;
        (share, (dot(value, value) - share * along).max(0.0).sqrt())
    }

    /// What the tile writes for such a pixel.
    pub(super) const fn mark(self) -> u8 {
        if self.window > 0 { Self::CANDIDATE } else { Mask::BACKGROUND }
    }

    /// Lets the neighbours decide about the candidates in each mask.
    pub(super) fn settle(self, masks: &mut [Mask]) {
        if self.is_on() && self.window > 0 {
            let radius = self.window as usize / 2;
            masks.par_iter_mut().for_each(|mask| settle(mask, radius));
        }
    }
}

/// A candidate becomes background where no fewer candidates than other foreground lie in the square around it, itself
/// among them, and foreground elsewhere.
fn settle(mask: &mut Mask, radius: usize) {
    let (width, height) = (mask.size.width as usize, mask.size.height as usize);
    let Some(first) = memchr::memchr(Shadow::CANDIDATE, &mask.data) else { return };
    // As signed numbers candidates are 1, other foreground is -1, and background 0: their sum over the square decides.
    let before = mask.data.clone();
    let row = |y: usize| &before[y * width..][..width];
    let first = first / width;
    let mut columns = vec![0_i16; width];
    for y in first.saturating_sub(radius)..(first + radius).min(height) {
        columns.iter_mut().zip(row(y)).for_each(|(sum, &value)| *sum += i16::from(value.cast_signed()));
    }
    for (y, row_of_mask) in mask.data.chunks_exact_mut(width).enumerate().skip(first) {
        if y + radius < height {
            let entering = row(y + radius);
            columns.iter_mut().zip(entering).for_each(|(sum, &value)| *sum += i16::from(value.cast_signed()));
        }
        if let Some(left) = y.checked_sub(radius + 1).filter(|&left| left >= first.saturating_sub(radius)) {
            let leaving = row(left);
            columns.iter_mut().zip(leaving).for_each(|(sum, &value)| *sum -= i16::from(value.cast_signed()));
        }
        let mut from = 0;
        // The sum over the columns left of `to`, and of those from `start` on.
        let (mut start, mut to, mut sum) = (0, 0, 0_i32);
        while let Some(next) = memchr::memchr(Shadow::CANDIDATE, &row_of_mask[from..]) {
            let x = from + next;
            let (low, high) = (x.saturating_sub(radius), (x + radius + 1).min(width));
            if low >= to {
                (start, to, sum) = (low, low, 0);
            }
            sum += columns[to..high].iter().map(|&column| i32::from(column)).sum::<i32>();
            sum -= columns[start..low].iter().map(|&column| i32::from(column)).sum::<i32>();
            (start, to) = (low, high);
            row_of_mask[x] = if sum >= 0 { Mask::BACKGROUND } else { Mask::FOREGROUND };
            from = x + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::frame::Size;

    const SHADOW: Shadow = Shadow { floor: 0.6, ceiling: 1.0, colour: 12.0, window: 0 };

    #[test]
    fn a_surface_darkened_is_shadow_until_it_is_too_dark() {
        let surface = [180.0, 160.0, 120.0];
        let darkened = |share: f32| surface.map(|channel| share * channel);
        assert!(SHADOW.covers(&darkened(0.9), &surface));
        assert!(SHADOW.covers(&darkened(0.65), &surface));
        assert!(!SHADOW.covers(&darkened(0.5), &surface));
        assert!(!SHADOW.covers(&darkened(1.1), &surface), "light is no shadow");
        let light = Shadow { floor: 1.0, ceiling: 1.2, ..SHADOW };
        assert!(light.covers(&darkened(1.1), &surface));
        assert!(!light.covers(&darkened(1.3), &surface) && !light.covers(&darkened(0.9), &surface));
    }

    #[test]
    fn another_colour_is_no_shadow() {
        assert!(!SHADOW.covers(&[150.0, 100.0, 100.0], &[180.0, 160.0, 120.0]));
        assert!(SHADOW.covers(&[128.0, 118.0, 92.0], &[180.0, 160.0, 120.0]), "noise is allowed for");
    }

    #[test]
    fn on_black_there_is_none_and_off_is_off() {
        assert!(!SHADOW.covers(&[0.0; 3], &[0.0; 3]));
        let off = Shadow { floor: 1.0, ..SHADOW };
        assert!(!off.covers(&[90.0; 3], &[100.0; 3]));
    }

    #[test]
    fn an_area_of_light_goes_and_a_patch_on_an_object_stays() {
        let size = Size::new(30, 12);
        let mut mask = Mask::empty(size);
        for y in 2..10 {
            for x in 2..12 {
                mask.data[y * 30 + x] = Shadow::CANDIDATE;
            }
            for x in 16..28 {
                let patch = (4..7).contains(&y) && (20..23).contains(&x);
                mask.data[y * 30 + x] = if patch { Shadow::CANDIDATE } else { Mask::FOREGROUND };
            }
        }
        Shadow { window: 7, ..SHADOW }.settle(std::slice::from_mut(&mut mask));
        assert!((0..15).all(|x| (0..12).all(|y| !mask.is_foreground(x, y))));
        assert!((16..28).all(|x| (2..10).all(|y| mask.data[y * 30 + x] == Mask::FOREGROUND)));
    }

    proptest! {
        #[test]
        fn neighbours_are_counted_in_the_square(
            (width, height) in (1_u32..40, 1_u32..30),
            radius in 1_u32..8,
            values in prop::collection::vec(0_usize..7, 40 * 30),
        ) {
            let size = Size::new(width, height);
            let data: Vec<u8> = values[..size.pixels()].iter().map(|&at| [0, 0, 0, 0, 1, 1, 255][at]).collect();
            let mut mask = Mask { size, data: data.clone() };
            Shadow { window: 2 * radius + 1, ..SHADOW }.settle(std::slice::from_mut(&mut mask));
            for y in 0..height {
                for x in 0..width {
                    let at = |x: u32, y: u32| data[(y * width + x) as usize];
                    let rows = y.saturating_sub(radius)..=(y + radius).min(height - 1);
                    let columns = x.saturating_sub(radius)..=(x + radius).min(width - 1);
                    let around: Vec<_> = rows.flat_map(|y| columns.clone().map(move |x| at(x, y))).collect();
                    let count = |value: u8| around.iter().map(|&other| usize::from(other == value)).sum::<usize>();
                    let expected = match at(x, y) {
                        1 if count(1) >= count(255) => 0,
                        1 => 255,
                        other => other,
                    };
                    prop_assert_eq!(mask.data[(y * width + x) as usize], expected, "{} {}", x, y);
                }
            }
        }
    }
}
