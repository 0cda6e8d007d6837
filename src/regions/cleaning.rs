//! Cleaning of the mask before regions are found: filters against specks, gaps and holes. Mask → mask of the same size.

use fearless_simd::dispatch;
use opencv::boxed_ref::{BoxedRef, BoxedRefMut};
use opencv::core::{BORDER_CONSTANT, CV_32S, Mat, Point, Size as CvSize};
use opencv::imgproc::{
    CCL_SPAGHETTI, MORPH_CLOSE, MORPH_ELLIPSE, MORPH_OPEN, connected_components_with_algorithm,
    get_structuring_element, morphology_default_border_value, morphology_ex,
};
use opencv::prelude::*;

use crate::frame::Mask;
use crate::instruction_set;
use crate::settings::Settings;

/// The filters and their sizes; a size of 0 turns a filter off. They run in the order of the fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cleaning {
    /// Side of the median filter's window in pixels.
    pub median: u32,
    /// Diameter of the opening's disc in pixels.
    pub opening: u32,
    /// Diameter of the closing's disc in pixels.
    pub closing: u32,
    /// Area in pixels up to which holes are filled.
    pub fill_holes: u32,
}

impl Cleaning {
    /// The filters in the settings.
    pub const fn new(settings: &Settings) -> Self {
        Self {
            median: settings.median,
            opening: settings.opening,
            closing: settings.closing,
            fill_holes: settings.fill_holes,
        }
    }

    /// The cleaned mask. Fails if OpenCV does.
    pub fn apply(&self, mask: Mask) -> opencv::Result<Mask> {
        let mut mask = mask;
        if self.median > 0 {
            mask = majority(&mask, self.median as usize);
        }
        if self.opening > 0 {
            mask = morphed(&mask, MORPH_OPEN, self.opening)?;
        }
        if self.closing > 0 {
            mask = morphed(&mask, MORPH_CLOSE, self.closing)?;
        }
        if self.fill_holes > 0 {
            fill_holes(&mut mask, self.fill_holes)?;
        }
        Ok(mask)
    }
}

/// Number of pixels of a row that are processed together.
const BLOCK: usize = 32;

/// The median of a mask: foreground where more than half of the pixels in the window are. Pixels outside the image
/// equal the nearest inside.
fn majority(mask: &Mask, side: usize) -> Mask {
    let mut result = Mask::empty(mask.size);
    dispatch!(instruction_set::level(), _simd => majority_into(mask, side, &mut result));
    result
}

#[inline(always)]
fn majority_into(mask: &Mask, side: usize, result: &mut Mask) {
    let (width, height, radius) = (mask.size.width as usize, mask.size.height as usize, side / 2);
    if result.data.is_empty() {
        return;
    }
    let half = (side * side / 2) as u16;
    let (outside, inside) = (vec![Mask::BACKGROUND; width], radius..radius + width);
    let row = |y: usize| &mask.data[y.saturating_sub(radius).min(height - 1) * width..][..width];
    // For each column, the number of foreground rows in the window; columns beside the image equal the nearest
    // inside.
    let mut counts = vec![0_u16; width + 2 * radius + BLOCK];
    for y in 0..side - 1 {
        change(&mut counts[inside.clone()], &outside, row(y));
    }
    for (y, to) in result.data.chunks_exact_mut(width).enumerate() {
        let leaving = if y == 0 { &outside[..] } else { row(y - 1) };
        change(&mut counts[inside.clone()], leaving, row(y + side - 1));
        let (first, last) = (counts[radius], counts[radius + width - 1]);
        counts[..radius].fill(first);
        counts[radius + width..][..radius].fill(last);
        for (block, to) in to.chunks_mut(BLOCK).enumerate() {
            let mut sums = [0; BLOCK];
            for counts in counts[block * BLOCK..].windows(BLOCK).take(side) {
                sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
            for (to, sum) in to.iter_mut().zip(sums) {
                *to = if sum > half { Mask::FOREGROUND } else { Mask::BACKGROUND };
            }
        }
    }
}

/// Moves the window by a row: subtracts the leaving row and adds the entering one.
#[inline(always)]
fn change(counts: &mut [u16], leaving: &[u8], entering: &[u8]) {
    for ((count, leaving), entering) in counts.iter_mut().zip(leaving).zip(entering) {
        *count = *count + u16::from(entering >> 7) - u16::from(leaving >> 7);
    }
}

/// Applies a filter that preserves size and type.
fn filtered(
    mask: &Mask,
    filter: impl FnOnce(&BoxedRef<'_, Mat>, &mut BoxedRefMut<'_, Mat>) -> opencv::Result<()>,
) -> opencv::Result<Mask> {
    let mut result = Mask::empty(mask.size);
    let (rows, columns) = (mask.size.height as i32, mask.size.width as i32);
    let mut to = Mat::new_rows_cols_with_bytes_mut::<u8>(rows, columns, &mut result.data)?;
    filter(&mat(mask)?, &mut to)?;
    drop(to);
    Ok(result)
}

fn morphed(mask: &Mask, operation: i32, side: u32) -> opencv::Result<Mask> {
    let centre = Point::new(-1, -1);
    let disc = get_structuring_element(MORPH_ELLIPSE, CvSize::new(side as i32, side as i32), centre)?;
    let border = morphology_default_border_value()?;
    filtered(mask, |from, to| morphology_ex(from, to, operation, &disc, centre, 1, BORDER_CONSTANT, border))
}

/// Fills holes: background areas of at most `largest` pixels that foreground encloses. A hole is 4-connected, because
/// foreground is 8-connected; an area that reaches the image edge is not a hole.
fn fill_holes(mask: &mut Mask, largest: u32) -> opencv::Result<()> {
    let inverse = Mask { size: mask.size, data: mask.data.iter().map(|value| 255 - value).collect() };
    let (labels, count) = connected_components(&inverse, 4)?;
    let (width, height) = (mask.size.width as usize, mask.size.height as usize);
    let mut areas = vec![0_u32; count];
    let mut open = vec![false; count];
    for (index, &label) in labels.iter().enumerate() {
        let (x, y) = (index % width, index / width);
        areas[label as usize] += 1;
        open[label as usize] |= x == 0 || y == 0 || x + 1 == width || y + 1 == height;
    }
    for (value, &label) in mask.data.iter_mut().zip(&labels) {
        if label != 0 && !open[label as usize] && areas[label as usize] <= largest {
            *value = Mask::FOREGROUND;
        }
    }
    Ok(())
}

/// OpenCV's labelling: a label for each pixel, 0 for background, and the number of labels, background included.
pub(super) fn connected_components(mask: &Mask, connectivity: i32) -> opencv::Result<(Vec<u32>, usize)> {
    let mut labels = Mat::default();
    let count =
        connected_components_with_algorithm(&mat(mask)?, &mut labels, connectivity, CV_32S, CCL_SPAGHETTI)?;
    let labels = labels.data_typed::<i32>()?.iter().map(|&label| label as u32).collect();
    Ok((labels, count as usize))
}

/// The mask as an OpenCV matrix, without a copy.
pub(super) fn mat(mask: &Mask) -> opencv::Result<BoxedRef<'_, Mat>> {
    Mat::new_rows_cols_with_bytes::<u8>(mask.size.height as i32, mask.size.width as i32, &mask.data)
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used)]
    use opencv::imgproc::median_blur;
    use proptest::prelude::*;

    use super::*;
    use crate::frame::Size;

    /// Random foreground with a density in percent.
    pub(crate) fn noise(size: Size, density: u32, seed: u32) -> Mask {
        let mut noise = seed | 1;
        let data = (0..size.pixels()).map(|_| {
            noise ^= noise << 13;
            noise ^= noise >> 17;
            noise ^= noise << 5;
            if noise % 100 < density { Mask::FOREGROUND } else { Mask::BACKGROUND }
        });
        Mask { size, data: data.collect() }
    }

    const OFF: Cleaning = Cleaning { median: 0, opening: 0, closing: 0, fill_holes: 0 };

    fn mask(rows: &[&str]) -> Mask {
        let data = rows.iter().flat_map(|row| row.bytes().map(|byte| if byte == b'#' { 255 } else { 0 }));
        Mask { size: Size::new(rows[0].len() as u32, rows.len() as u32), data: data.collect() }
    }

    #[test]
    fn cleaning_without_filters_changes_nothing() {
        let speckled = mask(&["#..", ".#.", "..#"]);
        assert_eq!(OFF.apply(speckled.clone()).unwrap(), speckled);
    }

    #[test]
    fn the_median_removes_specks_and_closes_pinholes() {
        let before = mask(&[".......", ".#.....", "...####", "...#.##", "...####", "...####", "......."]);
        let after = Cleaning { median: 3, ..OFF }.apply(before).unwrap();
        assert!(!after.is_foreground(1, 1));
        assert!(after.is_foreground(4, 3));
    }

    #[test]
    fn only_enclosed_holes_up_to_the_size_are_filled() {
        let before = mask(&["#####.#", "#.#...#", "#####.#", "#...#.#", "#...#.#", "#####.."]);
        let after = Cleaning { fill_holes: 5, ..OFF }.apply(before.clone()).unwrap();
        assert!(after.is_foreground(1, 1), "one pixel, enclosed");
        assert!(!after.is_foreground(3, 1), "reaches the image edge");
        assert!(!after.is_foreground(2, 3), "a hole of six pixels is too large");
        let after = Cleaning { fill_holes: 6, ..OFF }.apply(before).unwrap();
        assert!(after.is_foreground(2, 3));
    }

    #[test]
    fn discs_are_centred() {
        let mut block = Mask::empty(Size::new(20, 16));
        for (x, y) in (6..15_usize).flat_map(|x| (4..12_usize).map(move |y| (x, y))) {
            block.data[y * 20 + x] = Mask::FOREGROUND;
        }
        let mut corners = block.clone();
        for (x, y) in [6, 7, 13, 14].into_iter().flat_map(|x| [(x, 4), (x, 11)]) {
            corners.data[y * 20 + x] = Mask::BACKGROUND;
        }
        let opened = Cleaning { opening: 5, ..OFF }.apply(block.clone()).unwrap();
        assert!(opened == corners, "the top of the disc is one pixel wide, its sides are three");
        assert!(Cleaning { closing: 5, ..OFF }.apply(block.clone()).unwrap() == block);
    }

    #[test]
    fn opening_removes_thin_parts_and_closing_joins_thin_gaps() {
        let before = mask(&["..........", ".###.###..", ".###.#####", ".###.###..", ".........."]);
        let closed = Cleaning { closing: 3, ..OFF }.apply(before.clone()).unwrap();
        assert!(closed.is_foreground(4, 2));
        let opened = Cleaning { opening: 3, ..OFF }.apply(before).unwrap();
        assert!(!opened.is_foreground(9, 2) && opened.is_foreground(2, 2));
    }

    proptest! {
        #[test]
        fn the_median_equals_that_of_opencv(
            (width, height) in (1_u32..50, 1_u32..40),
            half in 1_u32..16,
            density in 1_u32..100,
            seed in any::<u32>(),
        ) {
            let mask = noise(Size::new(width, height), density, seed);
            let mut theirs = Mat::default();
            median_blur(&mat(&mask).unwrap(), &mut theirs, 2 * half as i32 + 1).unwrap();
            let ours = Cleaning { median: 2 * half + 1, ..OFF }.apply(mask).unwrap();
            prop_assert_eq!(&ours.data[..], theirs.data_bytes().unwrap());
        }

        /// A background pixel is filled where the background that is reached from it by steps to the side, up and
        /// down has at most so many pixels and does not reach the image edge.
        #[test]
        fn holes_equal_those_of_a_flood_fill(
            (width, height) in (1_usize..24, 1_usize..20),
            density in 20_u32..90,
            largest in 1_u32..9,
            seed in any::<u32>(),
        ) {
            let mask = noise(Size::new(width as u32, height as u32), density, seed);
            let filled = Cleaning { fill_holes: largest, ..OFF }.apply(mask.clone()).unwrap();
            for start in 0..width * height {
                let (mut reached, mut next) = (vec![start], 0);
                while mask.data[start] == Mask::BACKGROUND && next < reached.len() {
                    let (x, y) = (reached[next] % width, reached[next] / width);
                    let steps = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
                    for (x, y) in steps.into_iter().filter(|&(x, y)| x < width && y < height) {
                        let at = y * width + x;
                        if mask.data[at] == Mask::BACKGROUND && !reached.contains(&at) {
                            reached.push(at);
                        }
                    }
                    next += 1;
                }
                let inside = |at: &usize| {
                    (1..width - 1).contains(&(at % width)) && (1..height - 1).contains(&(at / width))
                };
                let hole = reached.len() <= largest as usize && reached.iter().all(inside);
                let foreground = mask.data[start] == Mask::FOREGROUND || hole;
                prop_assert_eq!(filled.data[start] == Mask::FOREGROUND, foreground);
            }
        }
    }
}
