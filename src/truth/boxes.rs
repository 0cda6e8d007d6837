//! Bounding boxes in pixels by frame number and identity, from MOTChallenge's CSV.

use std::collections::BTreeMap;
use std::path::Path;

use super::TruthError;
use crate::placement::Placement;

/// A box: left, top, width, height, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds(pub [f64; 4]);

impl Bounds {
    /// Its area in square pixels.
    pub fn area(&self) -> f64 {
        self.0[2] * self.0[3]
    }

    /// The area of the intersection in square pixels.
    pub fn shared(&self, other: &Self) -> f64 {
        let [ax, ay, aw, ah] = self.0;
        let [bx, by, bw, bh] = other.0;
        let width = (ax + aw).min(bx + bw) - ax.max(bx);
        let height = (ay + ah).min(by + bh) - ay.max(by);
        width.max(0.0) * height.max(0.0)
    }

    /// Intersection over union, 0..=1.
    pub fn iou(&self, other: &Self) -> f64 {
        let shared = self.shared(other);
        let all = self.area() + other.area() - shared;
        if all > 0.0 { shared / all } else { 0.0 }
    }
}

/// Limit of frame numbers and identities, far below overflow.
const LARGEST: f64 = 1_000_000_001.0;

/// The boxes of each frame, by identity.
pub type Boxes = BTreeMap<u32, BTreeMap<u32, Bounds>>;

/// The boxes in the pixels of frames that are placed in the source's images.
pub fn in_frames(boxes: &Boxes, placement: &Placement) -> Boxes {
    let mut moved = boxes.clone();
    for bounds in moved.values_mut().flat_map(BTreeMap::values_mut) {
        bounds.0 = placement.frame_box(bounds.0);
    }
    moved
}

/// Reads `frame,id,x,y,w,h[,conf,…]` without a header. Skips rows of confidence 0, which are not to be counted, and
/// rows of fewer than six columns. Fails with the line if a number cannot be read or is out of range.
pub fn read(path: &Path) -> Result<Boxes, TruthError> {
    let reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_path(path);
    let mut boxes = Boxes::new();
    for (row, line) in reader.map_err(|error| TruthError::new(path, error))?.records().zip(1..) {
        let row = row.map_err(|error| TruthError::new(path, error))?;
        if row.len() < 6 {
            continue;
        }
        let numbers: Result<Vec<f64>, _> = row.iter().take(7).map(str::parse).collect();
        let numbers = numbers.map_err(|_| {
            let why = "expected numbers in MOTChallenge format: frame,id,x,y,w,h,conf,…";
            TruthError::new(
                path,
                format!("line {line} is `{}`: {why}", row.iter().collect::<Vec<_>>().join(",")),
            )
        })?;
        if numbers.get(6) == Some(&0.0) {
            continue;
        }
        let place = Bounds([numbers[2], numbers[3], numbers[4], numbers[5]]);
        let whole = numbers[..2].iter().all(|number| (0.0..LARGEST).contains(number));
        if !whole || !place.0.iter().all(|side| side.is_finite()) || place.0[2] < 0.0 || place.0[3] < 0.0 {
            let why = "frame and id must be 0 to 1000000000, and box sides finite and not negative";
            return Err(TruthError::new(path, format!("line {line}: {why}")));
        }
        boxes.entry(numbers[0] as u32).or_default().insert(numbers[1] as u32, place);
    }
    Ok(boxes)
}
