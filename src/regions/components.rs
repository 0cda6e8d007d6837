//! Two-pass connected components of a mask (§VII), and the regions that they are.

use opencv::boxed_ref::BoxedRef;
use opencv::core::{CV_32S, Mat};
use opencv::imgproc::{CCL_WU, connected_components_with_algorithm};
use opencv::prelude::*;

use super::Region;
use super::colour::Histogram;
use super::shape::ShapeSums;
use crate::frame::{Frame, Mask, Size};

/// To which region each pixel belongs: its label, 0 where none, row after row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// Width and height.
    pub size: Size,
    /// A label for each pixel.
    pub data: Vec<u32>,
}

impl Labels {
    /// The label at (x, y): 0 where there is no region, `None` outside the image.
    pub fn at(&self, x: u32, y: u32) -> Option<u32> {
        self.size.index(x, y).map(|index| self.data[index])
    }
}

/// The 8-connected regions of at least `min_area` pixels, numbered from 1 in the raster order of
/// their first pixels, and the label of each pixel.
///
/// ```text
/// mask   # # . .      labels   1 1 0 0
///        . . # .               0 0 1 0     one region: corners touch
///        . . . .               0 0 0 0
///        # . . #               2 0 0 3
/// ```
pub fn find_regions(frame: &Frame, mask: &Mask, min_area: u32) -> opencv::Result<(Labels, Vec<Region>)> {
    let (mut data, count) = connected_components(mask, 8)?;
    let mut areas = vec![0_u32; count];
    for &label in &data {
        areas[label as usize] += 1;
    }
    // OpenCV's numbers do not follow the raster order for every algorithm and thread count: ours do.
    let mut renumbered = vec![None; count];
    renumbered[0] = Some(0);
    let mut sums: Vec<(ShapeSums, Histogram)> = Vec::new();
    let width = mask.size.width as usize;
    for (index, label) in data.iter_mut().enumerate().filter(|(_, label)| **label != 0) {
        let old = *label as usize;
        *label = *renumbered[old].get_or_insert_with(|| {
            if areas[old] < min_area {
                return 0;
            }
            sums.push((ShapeSums::default(), Histogram::default()));
            sums.len() as u32
        });
        if let Some((shape, histogram)) = (*label as usize).checked_sub(1).map(|at| &mut sums[at]) {
            shape.add((index % width) as u32, (index / width) as u32);
            histogram.add([frame.rgb[3 * index], frame.rgb[3 * index + 1], frame.rgb[3 * index + 2]]);
        }
    }
    let regions = sums.into_iter().zip(1..).map(|((shape, histogram), label)| Region {
        label,
        shape: shape.shape(),
        colour: histogram.dominant().unwrap_or_default(),
        histogram,
    });
    Ok((Labels { size: mask.size, data }, regions.collect()))
}

/// OpenCV's two-pass labelling (Wu's decision tree and union–find): a label for each pixel, 0 for
/// background, and how many labels there are, background among them.
pub(super) fn connected_components(mask: &Mask, connectivity: i32) -> opencv::Result<(Vec<u32>, usize)> {
    let mut labels = Mat::default();
    let count = connected_components_with_algorithm(&mat(mask)?, &mut labels, connectivity, CV_32S, CCL_WU)?;
    let labels = labels.data_typed::<i32>()?.iter().map(|&label| label as u32).collect();
    Ok((labels, count as usize))
}

/// The mask as OpenCV sees it, without a copy.
pub(super) fn mat(mask: &Mask) -> opencv::Result<BoxedRef<'_, Mat>> {
    Mat::new_rows_cols_with_bytes::<u8>(mask.size.height as i32, mask.size.width as i32, &mask.data)
}

#[cfg(test)]
mod tests {
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
        let (labels, regions) = find_regions(&frame, &mask, 1).unwrap();
        assert_eq!(labels.data[3], 1);
        assert_eq!(labels.data[5], 2);
        assert_eq!(labels.at(4, 4), Some(3));
        assert_eq!(labels.at(5, 4), None);
        let areas: Vec<_> = regions.iter().map(|region| (region.label, region.shape.area)).collect();
        assert_eq!(areas, [(1, 3), (2, 3), (3, 2)]);
    }

    #[test]
    fn small_regions_are_dropped_and_the_rest_numbered_without_gaps() {
        let (frame, mask) = scene(&["#....", "..##.", ".....", "#...#", "....#"]);
        let (labels, regions) = find_regions(&frame, &mask, 2).unwrap();
        assert_eq!(labels.data[0], 0);
        assert_eq!(regions.len(), 2);
        assert_eq!(labels.at(4, 4), Some(2));
        assert_eq!(mask.foreground_pixels(), 6, "the mask keeps them");
    }

    #[test]
    fn shape_agrees_with_sums_by_hand() {
        let (frame, mask) = scene(&[".....", ".###.", ".....", "....."]);
        let (_, regions) = find_regions(&frame, &mask, 1).unwrap();
        let shape = regions[0].shape;
        assert_eq!((shape.bbox.x, shape.bbox.y, shape.bbox.w, shape.bbox.h), (1.0, 1.0, 3.0, 1.0));
        assert_eq!(shape.centroid, [2.0, 1.0]);
        assert_eq!((shape.mu20, shape.mu11, shape.mu02), (2.0, 0.0, 0.0));
        assert_eq!((shape.orientation, shape.eccentricity, shape.extent), (0.0, 1.0, 1.0));
        assert_eq!(regions[0].colour, [255, 7, 0], "bins of 16 levels hold indices 6, 7 and 8 together");
    }
}
