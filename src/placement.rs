//! Where the analysed frames lie in the images of their source, if these are cropped or scaled.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::frame::{Frame, Mask, Size};
use crate::regions::{Rect, Shape};

/// A part of an image, in its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crop {
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// Number of columns, at least 1.
    pub width: u32,
    /// Number of rows, at least 1.
    pub height: u32,
}

impl Display for Crop {
    /// As in `--crop X,Y,W,H`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { x, y, width, height } = self;
        write!(f, "{x},{y},{width},{height}")
    }
}

impl Crop {
    /// The whole of an image.
    pub const fn whole(size: Size) -> Self {
        Self { x: 0, y: 0, width: size.width, height: size.height }
    }

    /// Whether it is a part of an image of this size.
    pub fn is_within(self, size: Size) -> bool {
        let fits = |first: u32, count: u32, most: u32| count > 0 && first < most && count <= most - first;
        fits(self.x, self.width, size.width) && fits(self.y, self.height, size.height)
    }

    /// Whether pixel (x, y) of the image is in it.
    pub fn contains(self, x: u32, y: u32) -> bool {
        let within = |at: u32, first: u32, count: u32| at >= first && at - first < count;
        within(x, self.x, self.width) && within(y, self.y, self.height)
    }
}

/// The place of the analysed frames in the source's images: a part of them, reduced to the frames' size.
///
/// Rectangles and points are in pixels, pixel (x, y) covering [x, x + 1) × [y, y + 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    source: Size,
    crop: Crop,
    size: Size,
}

impl Placement {
    /// The frames of a source whose images of `source` size are cropped, then scaled by a factor of 0 to 1; sizes are
    /// rounded, to 1 pixel at least. `None` where the crop is not within the image.
    pub fn new(source: Size, crop: Option<Crop>, scale: Option<f32>) -> Option<Self> {
        let crop = crop.unwrap_or(Crop::whole(source));
        let scale = f64::from(scale.unwrap_or(1.0));
        let side = |side: u32| ((f64::from(side) * scale).round() as u32).clamp(1, side.max(1));
        let size = Size::new(side(crop.width), side(crop.height));
        crop.is_within(source).then_some(Self { source, crop, size })
    }

    /// Whether the frames are the source's images as they are.
    pub fn is_identity(&self) -> bool {
        self.size == self.source
    }

    /// Size of the source's images.
    pub const fn source(&self) -> Size {
        self.source
    }

    /// The analysed part of the source's images.
    pub const fn crop(&self) -> Crop {
        self.crop
    }

    /// The analysed part of the source's images; `None` where it is all of them.
    pub fn part(&self) -> Option<Crop> {
        (self.crop != Crop::whole(self.source)).then_some(self.crop)
    }

    /// Size of the analysed frames.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The width and the height of a frame's pixel in the source's pixels, at least 1.
    pub fn pixel_size(&self) -> [f64; 2] {
        [
            f64::from(self.crop.width) / f64::from(self.size.width),
            f64::from(self.crop.height) / f64::from(self.size.height),
        ]
    }

    /// The source's pixel at the centre of a frame's pixel. [`Self::frame_pixel`] is its inverse.
    pub fn source_pixel(&self, (x, y): (u32, u32)) -> (u32, u32) {
        let Self { crop, size, .. } = self;
        let column = map_pixel(x, size.width, crop.width);
        let row = map_pixel(y, size.height, crop.height);
        (crop.x + column, crop.y + row)
    }

    /// The pixel of the frame that has the centre of the source's pixel (x, y); `None` outside the crop.
    pub fn frame_pixel(&self, (x, y): (u32, u32)) -> Option<(u32, u32)> {
        let Self { crop, size, .. } = self;
        let column = || map_pixel(x - crop.x, crop.width, size.width);
        let row = || map_pixel(y - crop.y, crop.height, size.height);
        crop.contains(x, y).then(|| (column(), row()))
    }

    /// A point of the frame in the source's image.
    pub fn source_point(&self, point: [f32; 2]) -> [f32; 2] {
        self.place(point.map(f64::from)).map(|at| at as f32)
    }

    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.pixel_size();
        [f64::from(self.crop.x) + x * width, f64::from(self.crop.y) + y * height]
    }

    /// A rectangle of the frame in the source's image.
    pub fn source_rect(&self, rect: &Rect) -> Rect {
        let [x, y] = self.source_point([rect.x, rect.y]);
        let [width, height] = self.pixel_size();
        Rect::new(x, y, (f64::from(rect.w) * width) as f32, (f64::from(rect.h) * height) as f32)
    }

    /// The shape of a region in the source's image, with its pixels enlarged to their size there.
    pub fn source_shape(&self, shape: &Shape) -> Shape {
        // Centroids are means of indices, which are half a pixel less than the centres.
        let centre = self.place(shape.centroid.map(|index| f64::from(index) + 0.5));
        Shape {
            bbox: self.source_rect(&shape.bbox),
            centroid: centre.map(|at| (at - 0.5) as f32),
            ..shape.enlarged(self.pixel_size())
        }
    }

    /// A box of the source's image, as left, top, width and height, in the frame. It can be outside.
    pub fn frame_box(&self, [x, y, w, h]: [f64; 4]) -> [f64; 4] {
        let [width, height] = self.pixel_size();
        [(x - f64::from(self.crop.x)) / width, (y - f64::from(self.crop.y)) / height, w / width, h / height]
    }

    /// A mask of the frame's size as a mask of the source's size: each pixel has the value of the frame's pixel at its
    /// place, and is background outside the crop.
    pub fn source_mask(&self, mask: &Mask) -> Mask {
        Mask { size: self.source, data: self.source_values(&mask.data, Mask::BACKGROUND) }
    }

    /// The values of the frame's pixels, in row order, as those of the source's pixels: each has the value of the
    /// frame's pixel at its place, or `outside` the crop.
    pub fn source_values<T: Copy>(&self, values: &[T], outside: T) -> Vec<T> {
        let Self { source, crop, size } = *self;
        let columns: Vec<usize> =
            (0..crop.width).map(|column| map_pixel(column, crop.width, size.width) as usize).collect();
        let mut whole = vec![outside; source.pixels()];
        let width = source.width as usize;
        let (left, right) = (crop.x as usize, (crop.x + crop.width) as usize);
        let rows = whole.chunks_exact_mut(width).skip(crop.y as usize).take(crop.height as usize);
        for (row, out) in (0..).zip(rows) {
            let from = map_pixel(row, crop.height, size.height) as usize * size.width as usize;
            let values = &values[from..from + size.width as usize];
            for (out, &column) in out[left..right].iter_mut().zip(&columns) {
                *out = values[column];
            }
        }
        whole
    }

    /// The frame of an image of the source.
    pub fn frame(&self, image: &Frame) -> Frame {
        let Self { crop, size, .. } = *self;
        let (columns, rows) = (crop.x..crop.x + crop.width, crop.y..crop.y + crop.height);
        if (size.width, size.height) == (crop.width, crop.height) {
            return image.cut(&columns, &rows);
        }
        Frame::new(image.number, size, self.averaged(&image.rgb)).at_time(image.time)
    }

    /// The mask of a frame from one of the source's size: each pixel has the value at its centre. It is the inverse of
    /// [`Self::source_mask`].
    pub fn frame_mask(&self, mask: &Mask) -> Mask {
        let value = |at| mask.data[at];
        Mask { size: self.size, data: self.centres().map(value).collect() }
    }

    /// The index of the source's pixel at the centre of each of the frame's, in row order.
    pub fn centres(&self) -> impl Iterator<Item = usize> {
        let width = self.source.width as usize;
        let pixels = (0..self.size.height).flat_map(|y| (0..self.size.width).map(move |x| (x, y)));
        pixels.map(move |at| {
            let (x, y) = self.source_pixel(at);
            y as usize * width + x as usize
        })
    }

    /// The mean over the area of each pixel of the frame, for an RGB image of the source. Sums are of integers, so that
    /// the result is the same everywhere: a pixel of the source is `size` units long, one of the frame `crop` units.
    fn averaged(&self, rgb: &[u8]) -> Vec<u8> {
        let Self { source, crop, size } = *self;
        let (left, width) = (crop.x as usize * 3, crop.width as usize * 3);
        let across = overlaps(crop.width, size.width);
        let total = u64::from(crop.width) * u64::from(crop.height);
        let mut averaged = Vec::with_capacity(size.pixels() * 3);
        let mut sums = vec![0_u32; width];
        for down in overlaps(crop.height, size.height) {
            sums.fill(0);
            for (row, weight) in down {
                let start = (crop.y as usize + row) * source.width as usize * 3 + left;
                for (sum, &byte) in sums.iter_mut().zip(&rgb[start..start + width]) {
                    *sum += weight * u32::from(byte);
                }
            }
            for pixels in &across {
                let mut mean = [total / 2; 3];
                for &(column, weight) in pixels {
                    for (mean, &sum) in mean.iter_mut().zip(&sums[column * 3..]) {
                        *mean += u64::from(weight) * u64::from(sum);
                    }
                }
                // Faster than a division of integers, and as exact below 2⁵³.
                averaged.extend(mean.map(|mean| (mean as f64 / total as f64) as u8));
            }
        }
        averaged
    }
}

/// The pixel among `to` in a row that has the centre of pixel `at` among `from`.
fn map_pixel(at: u32, from: u32, to: u32) -> u32 {
    ((2 * u64::from(at) + 1) * u64::from(to) / (2 * u64::from(from))) as u32
}

/// For each of `to` pixels in a row, the pixels among `from` that it overlaps, and by how much: a pixel of the former
/// is `from` units long, one of the latter `to`.
fn overlaps(from: u32, to: u32) -> Vec<Vec<(usize, u32)>> {
    let (unit, length) = (u64::from(to), u64::from(from));
    let of_pixel = |pixel: u64| {
        let (start, end) = (pixel * length, (pixel + 1) * length);
        let overlap = |at: u64| end.min((at + 1) * unit) - start.max(at * unit);
        (start / unit..end.div_ceil(unit)).map(|at| (at as usize, overlap(at) as u32)).collect()
    };
    (0..unit).map(of_pixel).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SOURCE: Size = Size::new(40, 30);
    const CROP: Crop = Crop { x: 4, y: 6, width: 20, height: 15 };

    fn placement(crop: Option<Crop>, scale: Option<f32>) -> Placement {
        Placement::new(SOURCE, crop, scale).unwrap()
    }

    #[test]
    fn sizes_are_rounded_and_at_least_one_pixel() {
        let size = |crop, scale| placement(crop, scale).size();
        assert_eq!(size(None, None), SOURCE);
        assert_eq!(size(None, Some(0.5)), Size::new(20, 15));
        assert_eq!(size(Some(CROP), Some(0.5)), Size::new(10, 8), "7.5 is rounded up");
        assert_eq!(size(Some(Crop { x: 39, y: 0, width: 1, height: 30 }), Some(0.01)), Size::new(1, 1));
        let whole = placement(Some(Crop::whole(SOURCE)), Some(1.0));
        assert!(whole.is_identity() && whole.part().is_none());
        assert_eq!(placement(Some(CROP), Some(0.5)).part(), Some(CROP));
    }

    #[test]
    fn a_crop_lies_within_the_image() {
        let crop = |x, y, width, height| Placement::new(SOURCE, Some(Crop { x, y, width, height }), None);
        assert!(crop(39, 29, 1, 1).is_some() && crop(0, 0, 40, 30).is_some());
        for (x, y, width, height) in [
            (40, 0, 1, 1),
            (0, 30, 1, 1),
            (30, 0, 11, 5),
            (0, 29, 5, 2),
            (0, 0, 0, 5),
            (u32::MAX, 0, u32::MAX, 1),
        ] {
            assert!(crop(x, y, width, height).is_none(), "{x},{y},{width},{height}");
        }
    }

    #[test]
    fn a_pixel_of_the_frame_has_its_own_pixel_of_the_source() {
        for scale in [1.0, 0.97, 0.75, 0.6, 0.5, 0.34, 0.1] {
            let placement = placement(Some(CROP), Some(scale));
            let size = placement.size();
            for at in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
                let there = placement.source_pixel(at);
                assert_eq!(placement.frame_pixel(there), Some(at), "{scale}: {there:?}");
            }
        }
        let half = placement(Some(CROP), Some(0.5));
        assert_eq!(half.source_pixel((0, 0)), (5, 6), "columns 4 and 5");
        assert_eq!([(3, 6), (4, 5), (24, 6), (4, 21)].map(|at| half.frame_pixel(at)), [None; 4]);
        assert_eq!(half.frame_pixel((23, 20)), Some((9, 7)));
    }

    #[test]
    fn points_and_boxes_are_those_of_the_source() {
        let half = placement(Some(CROP), Some(0.5));
        assert_eq!(half.pixel_size(), [2.0, 15.0 / 8.0]);
        let all = Rect::new(0.0, 0.0, 10.0, 8.0);
        assert_eq!(half.source_rect(&all), Rect::new(4.0, 6.0, 20.0, 15.0));
        assert_eq!(half.source_point([5.0, 4.0]), [14.0, 13.5]);
        assert_eq!(half.frame_box([4.0, 6.0, 20.0, 15.0]), [0.0, 0.0, 10.0, 8.0]);
        let cropped = placement(Some(CROP), None);
        assert_eq!(cropped.source_rect(&Rect::new(1.5, 2.0, 3.0, 4.0)), Rect::new(5.5, 8.0, 3.0, 4.0));
    }

    #[test]
    fn shrinking_averages_over_the_area_of_each_pixel() {
        // Three columns to two: a pixel and a half each.
        let size = Size::new(3, 1);
        let shrunk = Placement::new(size, None, Some(0.67)).unwrap();
        assert_eq!(shrunk.size(), Size::new(2, 1));
        let image = Frame::new(7, size, vec![30, 0, 255, 90, 3, 255, 0, 8, 255]);
        let frame = shrunk.frame(&image);
        assert_eq!((frame.number, frame.size), (7, Size::new(2, 1)));
        assert_eq!(frame.rgb, [50, 1, 255, 30, 6, 255], "(30 + 45) / 1.5, (0 + 1.5) / 1.5, …");
        // A crop alone moves pixels and changes none.
        let rgb = (0..SOURCE.pixels() * 3).map(|at| (at * 7) as u8).collect();
        let image = Frame::new(1, SOURCE, rgb);
        let cut = placement(Some(CROP), None).frame(&image);
        assert_eq!(cut.pixel(3, 4), image.pixel(7, 10));
        // A crop with a scale averages within the crop only.
        let one = placement(Some(Crop { x: 8, y: 2, width: 2, height: 2 }), Some(0.5)).frame(&image);
        let corners = [(8, 2), (9, 2), (8, 3), (9, 3)].map(|(x, y)| image.pixel(x, y).unwrap());
        for channel in 0..3 {
            let sum: u32 = corners.iter().map(|corner| u32::from(corner[channel])).sum();
            assert_eq!(u32::from(one.rgb[channel]), (sum + 2) / 4);
        }
    }

    #[test]
    fn masks_are_enlarged_to_the_source_and_reduced_again() {
        let half = placement(Some(CROP), Some(0.6));
        let data = (0..half.size().pixels()).map(|at| if at % 3 == 0 { 255 } else { 0 }).collect();
        let mask = Mask { size: half.size(), data };
        let whole = half.source_mask(&mask);
        assert_eq!(whole.size, SOURCE);
        for (x, y) in (0..30).flat_map(|y| (0..40).map(move |x| (x, y))) {
            let there = half.frame_pixel((x, y));
            assert_eq!(whole.is_foreground(x, y), there.is_some_and(|(x, y)| mask.is_foreground(x, y)));
        }
        assert_eq!(half.frame_mask(&whole), mask);
    }
}
