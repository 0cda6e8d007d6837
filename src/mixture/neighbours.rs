//! Decides the undecided pixels of a mask by the votes of the pixels in the square around each.

use crate::frame::Mask;

/// Number of pixels of a row that are processed together as vectors.
pub(super) const BLOCK: usize = 32;

/// Decides each pixel for which `waits` holds by the sum of the votes in the square around it, of the given `radius`.
///
/// `vote` computes the votes of a row's pixels, and `decide` the new value of a pixel from the sum of the votes in
/// its square, x and y. The votes of a row may depend on the adjacent rows. Only rows near undecided pixels are
/// processed.
#[inline(always)]
pub(super) fn settle(
    mask: &mut Mask,
    radius: usize,
    waits: impl Fn(u8) -> bool + Copy,
    vote: impl Fn(&Mask, usize, &mut [i8]),
    decide: impl Fn(i16, usize, usize) -> u8,
) {
    let (width, height) = (mask.size.width as usize, mask.size.height as usize);
    let any_waits = |pixels: &[u8]| pixels.iter().fold(false, |found, &byte| found | waits(byte));
    let rows = mask.data.chunks_exact(width.max(1)).enumerate();
    let rows: Vec<usize> = rows.filter(|(_, row)| any_waits(row)).map(|(y, _)| y).collect();
    let kept = 2 * radius + 1;
    let mut votes = vec![0_i8; kept * width];
    // The sum of the votes of rows `top..bottom` in each column; pixels outside the image do not vote.
    let mut columns = vec![0_i16; width + 2 * radius + BLOCK];
    let (mut top, mut bottom) = (0, 0);
    for y in rows {
        let (from, to) = (y.saturating_sub(radius), (y + radius + 1).min(height));
        if from >= bottom {
            columns.fill(0);
            (top, bottom) = (from, from);
        }
        let sums = &mut columns[radius..radius + width];
        for leaving in top..from {
            let votes = &votes[leaving % kept * width..][..width];
            sums.iter_mut().zip(votes).for_each(|(sum, &vote)| *sum -= i16::from(vote));
        }
        for entering in bottom..to {
            let votes = &mut votes[entering % kept * width..][..width];
            vote(mask, entering, votes);
            sums.iter_mut().zip(&*votes).for_each(|(sum, &vote)| *sum += i16::from(vote));
        }
        (top, bottom) = (from, to);
        // Votes of later rows depend on no row before the one after this, so this row can be changed.
        let row = &mut mask.data[y * width..][..width];
        for (block, bytes) in row.chunks_mut(BLOCK).enumerate() {
            if !any_waits(bytes) {
                continue;
            }
            let mut sums = [0; BLOCK];
            for columns in columns[block * BLOCK..].windows(BLOCK).take(kept) {
                sums.iter_mut().zip(columns).for_each(|(sum, column)| *sum += column);
            }
            for (at, (byte, sum)) in bytes.iter_mut().zip(sums).enumerate() {
                if waits(*byte) {
                    *byte = decide(sum, block * BLOCK + at, y);
                }
            }
        }
    }
}
