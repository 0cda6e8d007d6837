//! Single-channel images in levels, on which motion is estimated.

use crate::frame::Frame;

/// Approximate maximum number of pixels of the image on which motion is estimated.
const PIXELS: usize = 130_000;

/// A single-channel image.
#[derive(Clone, Default)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) data: Vec<f32>,
}

/// The integer factor by which an image is reduced for the estimate.
pub(super) fn reduction(width: usize, height: usize) -> usize {
    (1..=width.max(height)).find(|factor| (width / factor) * (height / factor) <= PIXELS).unwrap_or(1)
}

/// The mean luma of one square of `factor` pixels; equals that of [`Plane::luma`].
pub(super) fn square(frame: &Frame, factor: usize, x: usize, y: usize) -> f32 {
    let stride = frame.size.width as usize * 3;
    let mut sum = 0;
    for row in frame.rgb.chunks_exact(stride).skip(y * factor).take(factor) {
        for rgb in row[3 * x * factor..3 * (x + 1) * factor].chunks_exact(3) {
            sum += weighted(rgb);
        }
    }
    sum as f32 * (1.0 / (256 * factor * factor) as f32)
}

/// BT.601 luma in 1/256 of a level.
#[inline(always)]
fn weighted(rgb: &[u8]) -> u32 {
    77 * u32::from(rgb[0]) + 150 * u32::from(rgb[1]) + 29 * u32::from(rgb[2])
}

impl Plane {
    /// The luma of a frame, averaged over squares of `factor` pixels.
    pub(super) fn luma(frame: &Frame, factor: usize) -> Self {
        let (width, height) = (frame.size.width as usize / factor, frame.size.height as usize / factor);
        let stride = frame.size.width as usize * 3;
        let scale = 1.0 / (256 * factor * factor) as f32;
        let mut data = Vec::with_capacity(width * height);
        let mut sums = vec![0_u32; width];
        for y in 0..height {
            sums.fill(0);
            for row in frame.rgb.chunks_exact(stride).skip(y * factor).take(factor) {
                for (sum, square) in sums.iter_mut().zip(row.chunks_exact(3 * factor)) {
                    for rgb in square.chunks_exact(3) {
                        *sum += weighted(rgb);
                    }
                }
            }
            data.extend(sums.iter().map(|&sum| sum as f32 * scale));
        }
        Self { width, height, data }
    }

    /// The plane at half the scale, averaged over squares of two pixels.
    pub(super) fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut data = Vec::with_capacity(width * height);
        for rows in self.data.chunks_exact((2 * self.width).max(1)).take(height) {
            let (upper, lower) = rows.split_at(self.width);
            let pairs = upper.chunks_exact(2).zip(lower.chunks_exact(2));
            data.extend(pairs.map(|(upper, lower)| 0.25 * ((upper[0] + upper[1]) + (lower[0] + lower[1]))));
        }
        Self { width, height, data }
    }

    /// Subtracts the mean of the surrounding pixels, `radius` to each side, which leaves contrast independent of
    /// light.
    pub(super) fn contrast(&self, radius: usize) -> Self {
        let across = mean_along(&self.data, self.width, radius);
        let turned = transposed(&across, self.width, self.height);
        let down = mean_along(&turned, self.height, radius);
        let mean = transposed(&down, self.height, self.width);
        let data = self.data.iter().zip(&mean).map(|(value, mean)| value - mean).collect();
        Self { data, ..*self }
    }

    /// The bilinearly interpolated value; `None` outside the outermost pixels' centres.
    #[inline(always)]
    pub(super) fn at(&self, x: f32, y: f32) -> Option<f32> {
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        if column + 1 >= self.width || row + 1 >= self.height {
            return None;
        }
        let (right, down) = (x - column as f32, y - row as f32);
        let start = row * self.width + column;
        let upper = &self.data[start..start + 2];
        let lower = &self.data[start + self.width..start + self.width + 2];
        let upper = upper[0] + right * (upper[1] - upper[0]);
        let lower = lower[0] + right * (lower[1] - lower[0]);
        Some(upper + down * (lower - upper))
    }
}

/// The moving mean of each row over `radius` values to each side, fewer at its ends.
fn mean_along(data: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let mut means = Vec::with_capacity(data.len());
    for row in data.chunks_exact(width.max(1)) {
        let mut sum: f32 = row.iter().take(radius).sum();
        let mut count = radius.min(row.len());
        for x in 0..row.len() {
            if x + radius < row.len() {
                sum += row[x + radius];
                count += 1;
            }
            if x > radius {
                sum -= row[x - radius - 1];
                count -= 1;
            }
            means.push(sum / count as f32);
        }
    }
    means
}

fn transposed(data: &[f32], width: usize, height: usize) -> Vec<f32> {
    (0..width).flat_map(|x| (0..height).map(move |y| data[y * width + x])).collect()
}
