//! Two-pass connected components of a mask (§VII), and the regions that they form.
//!
//! The passes process runs of foreground pixels in a row. Most of a mask is background, which is skipped many pixels
//! at a time.

use std::ops::Range;
use std::sync::Arc;

use memchr::memchr;

use super::Region;
use super::colour::Tally;
use super::mosaic::{MosaicSums, cell_side};
use super::shape::ShapeSums;
use crate::frame::{Frame, Mask, Size};

/// The label image, run-length encoded: the region of each pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// Width and height.
    pub size: Size,
    /// The runs of foreground in raster order; no run crosses the end of a row.
    pub runs: Vec<LabelRun>,
}

/// A run: consecutive foreground pixels in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LabelRun {
    /// Index of the first pixel in row order.
    pub start: u32,
    /// Number of pixels.
    pub length: u32,
    /// The label of their region; 0 where it is too small.
    pub label: u32,
}

impl LabelRun {
    /// The pixels' indices in row order.
    pub const fn pixels(self) -> Range<usize> {
        self.start as usize..(self.start + self.length) as usize
    }
}

impl Labels {
    /// The labels of an image without foreground.
    pub const fn none(size: Size) -> Self {
        Self { size, runs: Vec::new() }
    }

    /// The labels of a label image in row order, 0 being background.
    #[cfg(all(test, feature = "gui"))]
    pub(crate) fn of_image(size: Size, image: &[u32]) -> Self {
        let mut labels = Self::none(size);
        let mut start = 0;
        for row in image.chunks(size.width.max(1) as usize) {
            for run in row.chunk_by(|a, b| a == b) {
                let length = run.len() as u32;
                if run[0] > 0 {
                    labels.runs.push(LabelRun { start, length, label: run[0] });
                }
                start += length;
            }
        }
        labels
    }

    /// The label at (x, y): 0 outside all regions, `None` outside the image.
    pub fn at(&self, x: u32, y: u32) -> Option<u32> {
        let index = self.size.index(x, y)?;
        let after = self.runs.partition_point(|run| run.pixels().end <= index);
        Some(self.runs.get(after).filter(|run| run.pixels().contains(&index)).map_or(0, |run| run.label))
    }

    /// The label of each pixel in row order, 0 outside all regions.
    #[cfg(test)]
    pub(crate) fn image(&self) -> Vec<u32> {
        let mut image = vec![0; self.size.pixels()];
        for run in &self.runs {
            image[run.pixels()].fill(run.label);
        }
        image
    }
}

/// Foreground pixels `start..end` of row `y`, and the index of the run's parent in the union-find forest.
struct Run {
    y: u32,
    start: u32,
    end: u32,
    parent: usize,
}

/// The 8-connected regions of at least `min_area` pixels, numbered from 1 in the raster order of their first pixels,
/// and the label of each pixel. `frame`, which gives the colours, and `mask` have the same size.
///
/// ```text
/// mask   # # . .      labels   1 1 0 0
///        . . # .               0 0 1 0     one region: corners touch
///        . . . .               0 0 0 0
///        # . . #               2 0 0 3
/// ```
///
/// # Examples
/// The mask above, with single pixels left out:
///
/// ```
/// use occluscope::frame::{Frame, Mask, Size};
/// use occluscope::regions::{Rect, find_regions};
///
/// let size = Size::new(4, 4);
/// let red = Frame::new(1, size, [200, 40, 40].repeat(size.pixels()));
/// let data = vec![
///     255, 255, 0, 0,
///     0, 0, 255, 0,
///     0, 0, 0, 0,
///     255, 0, 0, 255,
/// ];
/// let (labels, regions) = find_regions(&red, &Mask { size, data }, 2);
///
/// assert_eq!(regions.len(), 1);
/// let shape = regions[0].shape;
/// assert_eq!((shape.area, shape.bbox), (3, Rect::new(0.0, 0.0, 3.0, 2.0)));
/// assert_eq!((shape.extent, regions[0].colour), (0.5, [200, 40, 40]));
/// assert_eq!(labels.at(2, 1), Some(1));
/// assert_eq!(labels.at(0, 3), Some(0), "a region of one pixel is left out");
/// assert_eq!(labels.at(4, 0), None, "outside the image");
/// ```
pub fn find_regions(frame: &Frame, mask: &Mask, min_area: u32) -> (Labels, Vec<Region>) {
    let mut runs = runs(mask);
    connect(&mut runs);
    // The root of a region is its first run in raster order.
    let mut areas = vec![0; runs.len()];
    for index in 0..runs.len() {
        let root = root(&mut runs, index);
        areas[root] += runs[index].end - runs[index].start;
    }
    let mut places = vec![None; runs.len()];
    let mut members: Vec<Vec<&Run>> = Vec::new();
    let mut labels = Labels { size: mask.size, runs: Vec::with_capacity(runs.len()) };
    for (index, run) in runs.iter().enumerate() {
        // Every parent is now a root.
        if run.parent == index && areas[index] >= min_area {
            places[index] = Some(members.len());
            members.push(Vec::new());
        }
        let place = places[run.parent];
        if let Some(place) = place {
            members[place].push(run);
        }
        let label = place.map_or(0, |place| place as u32 + 1);
        let start = run.y * mask.size.width + run.start;
        labels.runs.push(LabelRun { start, length: run.end - run.start, label });
    }

    let mut tally = Tally::default();
    let width = mask.size.width as usize;
    let side = cell_side(mask.size);
    let regions = members.into_iter().zip(1..).map(|(members, label)| {
        let mut sums = ShapeSums::default();
        let mut mosaic = MosaicSums::new(side, columns(&members), rows(&members));
        for run in members {
            let row = run.y as usize * width;
            let pixels = row + run.start as usize..row + run.end as usize;
            sums.add_run(run.y, run.start..run.end);
            let rgb = &frame.rgb[3 * pixels.start..3 * pixels.end];
            tally.add(rgb);
            mosaic.add_run(run.y, run.start, rgb);
        }
        let histogram = tally.take();
        Region {
            label,
            shape: sums.shape(),
            colour: histogram.dominant().unwrap_or_default(),
            histogram,
            mosaic: Arc::new(mosaic.mosaic()),
        }
    });
    let regions = regions.collect();
    (labels, regions)
}

/// The columns that a region's runs span.
fn columns(runs: &[&Run]) -> Range<u32> {
    let left = runs.iter().map(|run| run.start).min().unwrap_or_default();
    left..runs.iter().map(|run| run.end).max().unwrap_or_default()
}

/// The rows that a region's runs, in raster order, span.
fn rows(runs: &[&Run]) -> Range<u32> {
    let top = runs.first().map_or(0, |run| run.y);
    top..runs.last().map_or(0, |run| run.y + 1)
}

/// The runs of foreground in raster order, each its own parent.
fn runs(mask: &Mask) -> Vec<Run> {
    let mut runs = Vec::new();
    for (y, row) in (0..).zip(mask.data.chunks_exact((mask.size.width as usize).max(1))) {
        let mut end = 0;
        while let Some(skipped) = memchr(Mask::FOREGROUND, &row[end..]) {
            let start = end + skipped;
            end = memchr(Mask::BACKGROUND, &row[start..]).map_or(row.len(), |length| start + length);
            runs.push(Run { y, start: start as u32, end: end as u32, parent: runs.len() });
        }
    }
    runs
}

/// The first pass: unites runs that touch, diagonally as well, under the earliest of them.
fn connect(runs: &mut [Run]) {
    let mut above = 0;
    for below in 0..runs.len() {
        let Run { y, start, end, .. } = runs[below];
        while runs[above].y + 1 < y || runs[above].y + 1 == y && runs[above].end < start {
            above += 1;
        }
        let touching = runs[above..below].iter().take_while(|run| run.y < y && run.start <= end).count();
        for other in above..above + touching {
            let (a, b) = (root(runs, other), root(runs, below));
            runs[a.max(b)].parent = a.min(b);
        }
    }
}

/// The root of a run, with path compression.
fn root(runs: &mut [Run], run: usize) -> usize {
    let mut root = run;
    while runs[root].parent != root {
        root = runs[root].parent;
    }
    let mut next = run;
    while next != root {
        next = std::mem::replace(&mut runs[next].parent, root);
    }
    root
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::super::cleaning::connected_components;
    use super::super::cleaning::tests::noise;
    use super::super::colour::Histogram;
    use super::*;

    fn scene(rows: &[&str]) -> (Frame, Mask) {
        let size = Size::new(rows[0].len() as u32, rows.len() as u32);
        let data: Vec<u8> =
            rows.iter().flat_map(|row| row.bytes()).map(|byte| if byte == b'.' { 0 } else { 255 }).collect();
        let rgb = data.iter().enumerate().flat_map(|(index, &value)| [value, index as u8, 0]).collect();
        (Frame::new(1, size, rgb), Mask { size, data })
    }

    #[test]
    fn labels_follow_the_raster_order_and_corners_connect() {
        let (frame, mask) = scene(&["...##", "#...#", ".#...", "#..#.", "....#"]);
        let (labels, regions) = find_regions(&frame, &mask, 1);
        assert_eq!(labels.at(3, 0), Some(1));
        assert_eq!(labels.at(0, 1), Some(2));
        assert_eq!(labels.at(2, 0), Some(0));
        assert_eq!(labels.at(4, 4), Some(3));
        assert_eq!(labels.at(5, 4), None);
        let areas: Vec<_> = regions.iter().map(|region| (region.label, region.shape.area)).collect();
        assert_eq!(areas, [(1, 3), (2, 3), (3, 2)]);
    }

    #[test]
    fn small_regions_are_dropped_and_the_rest_numbered_without_gaps() {
        let (frame, mask) = scene(&["#....", "..##.", ".....", "#...#", "....#"]);
        let (labels, regions) = find_regions(&frame, &mask, 2);
        assert_eq!(labels.at(0, 0), Some(0));
        assert_eq!(regions.len(), 2);
        assert_eq!(labels.at(4, 4), Some(2));
        assert_eq!(mask.foreground_pixels(), 6, "the mask keeps small regions");
    }

    #[test]
    fn shape_agrees_with_sums_by_hand() {
        let (frame, mask) = scene(&[".....", ".###.", ".....", "....."]);
        let (_, regions) = find_regions(&frame, &mask, 1);
        let shape = regions[0].shape;
        assert_eq!((shape.bbox.x, shape.bbox.y, shape.bbox.w, shape.bbox.h), (1.0, 1.0, 3.0, 1.0));
        assert_eq!(shape.centroid, [2.0, 1.0]);
        assert_eq!((shape.mu20, shape.mu11, shape.mu02), (2.0, 0.0, 0.0));
        assert_eq!((shape.orientation, shape.eccentricity, shape.extent), (0.0, 1.0, 1.0));
        assert_eq!(regions[0].colour, [255, 7, 0], "bins of 16 levels hold indices 6, 7 and 8 together");
    }

    proptest! {
        #[test]
        fn regions_agree_with_opencv(
            (width, height) in (1_u32..40, 1_u32..30),
            density in 1_u32..100,
            min_area in 0_u32..6,
            seed in any::<u32>(),
        ) {
            let size = Size::new(width, height);
            let mask = noise(size, density, seed);
            let frame = Frame::new(1, size, (0..size.pixels() * 3).map(|at| (at * 31) as u8).collect());
            let (labels, regions) = find_regions(&frame, &mask, min_area);
            let (theirs, count) = connected_components(&mask, 8).unwrap();

            let mut shapes = vec![(ShapeSums::default(), Histogram::default()); count];
            let mut first = vec![usize::MAX; count];
            for (index, &label) in theirs.iter().enumerate().filter(|(_, label)| **label > 0) {
                let (shape, histogram) = &mut shapes[label as usize];
                shape.add_run(index as u32 / width, index as u32 % width..index as u32 % width + 1);
                histogram.add_many([frame.rgb[3 * index], frame.rgb[3 * index + 1], frame.rgb[3 * index + 2]], 1);
                first[label as usize] = first[label as usize].min(index);
            }
            let mut expected: Vec<_> = (1..count).filter(|&at| shapes[at].0.shape().area >= min_area).collect();
            expected.sort_by_key(|&at| first[at]);
            prop_assert_eq!(regions.len(), expected.len());
            for (region, &at) in regions.iter().zip(&expected) {
                prop_assert_eq!(region.shape, shapes[at].0.shape());
                prop_assert_eq!(&region.histogram, &shapes[at].1);
                prop_assert_eq!(Some(region.colour), shapes[at].1.dominant());
            }
            let image = labels.image();
            for (index, &label) in theirs.iter().enumerate() {
                let place = expected.iter().position(|&at| at == label as usize);
                prop_assert_eq!(image[index] as usize, place.map_or(0, |place| place + 1));
                prop_assert_eq!(labels.at(index as u32 % width, index as u32 / width), Some(image[index]));
            }
            let foreground: usize = labels.runs.iter().map(|run| run.length as usize).sum();
            prop_assert_eq!(foreground, mask.foreground_pixels(), "small regions keep their runs");
        }
    }
}
