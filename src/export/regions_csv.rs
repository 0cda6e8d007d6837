//! Regions with shape, colour and objects, one per row.
//!
//! Lengths are in pixels, moments and derived measures are those of [`Shape`], `r,g,b` is the dominant colour, and
//! `object` the identities of the associated objects, as in `3+5`; empty if there are none.

use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use super::joined;
use super::number::significant;
use crate::placement::Placement;
use crate::regions::{Region, Rgb, Shape};
use crate::tracking::{Identity, Track};

/// The columns of the header.
const HEADER: &str =
    "frame,label,area,x,y,w,h,cx,cy,mu20,mu11,mu02,orientation,eccentricity,extent,r,g,b,object";

/// A row's data of a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionRow {
    label: u32,
    shape: Shape,
    colour: Rgb,
}

impl From<&Region> for RegionRow {
    fn from(region: &Region) -> Self {
        Self { label: region.label, shape: region.shape, colour: region.colour }
    }
}

impl RegionRow {
    /// Moves it from the pixels of the frames to those of the source.
    pub(super) fn move_to_source(&mut self, placement: &Placement) {
        self.shape = placement.source_shape(&self.shape);
    }
}

/// The rows of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRows {
    /// The frame's number.
    pub number: u32,
    /// A row for each region.
    pub rows: Vec<RegionRow>,
}

/// Writes the header.
pub fn write_header(out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")
}

/// Writes the regions of a frame with the objects of the same frame.
pub fn write_frame(out: &mut impl Write, frame: &FrameRows, tracks: &[Track]) -> io::Result<()> {
    for row in &frame.rows {
        write_row(out, frame.number, row, &objects_of(row.label, tracks))?;
    }
    Ok(())
}

fn write_row(out: &mut impl Write, number: u32, row: &RegionRow, objects: &[Identity]) -> io::Result<()> {
    let RegionRow { label, shape, colour: [r, g, b] } = row;
    let [x, y, w, h] = [shape.bbox.x, shape.bbox.y, shape.bbox.w, shape.bbox.h];
    let [cx, cy] = shape.centroid.map(significant);
    let [mu20, mu11, mu02] = [shape.mu20, shape.mu11, shape.mu02].map(significant);
    let [orientation, eccentricity, extent] =
        [shape.orientation, shape.eccentricity, shape.extent].map(significant);
    writeln!(
        out,
        "{number},{label},{},{x},{y},{w},{h},{cx},{cy},{mu20},{mu11},{mu02},{orientation},{eccentricity},{extent},{r},{g},{b},{}",
        shape.area,
        joined(objects),
    )
}

/// The identities, ascending, of the objects that the region is assigned to.
fn objects_of(label: u32, tracks: &[Track]) -> Vec<Identity> {
    let mut objects: Vec<_> =
        tracks.iter().filter(|track| track.regions.contains(&label)).map(|track| track.id).collect();
    objects.sort_unstable();
    objects
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::{track, written};
    use crate::regions::Rect;

    #[test]
    fn a_row_has_the_objects_of_its_region() {
        let shape = Shape {
            area: 12,
            bbox: Rect::new(1.0, 2.0, 3.0, 4.0),
            centroid: [2.0, 3.5],
            mu20: 8.0,
            mu11: -0.5,
            mu02: 15.0,
            orientation: 1.5,
            eccentricity: 0.25,
            extent: 1.0,
        };
        let row = |label| RegionRow { label, shape, colour: [9, 8, 7] };
        let frames = [
            FrameRows { number: 3, rows: vec![row(1)] },
            FrameRows { number: 4, rows: vec![row(1), row(2)] },
        ];
        let tracks = [vec![], vec![track(3, 0.0, 0.0), track(5, 0.0, 0.0)]];
        let text = written(|out| {
            write_header(out)?;
            frames.iter().zip(&tracks).try_for_each(|(frame, tracks)| write_frame(out, frame, tracks))
        });
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[0], HEADER);
        assert_eq!(lines[1], "3,1,12,1,2,3,4,2,3.5,8,-0.5,15,1.5,0.25,1,9,8,7,");
        assert_eq!(lines[2], "4,1,12,1,2,3,4,2,3.5,8,-0.5,15,1.5,0.25,1,9,8,7,3+5");
        assert_eq!(lines[3], "4,2,12,1,2,3,4,2,3.5,8,-0.5,15,1.5,0.25,1,9,8,7,");
    }
}
