//! Bounding boxes in pixels by frame number and identity.

use std::collections::BTreeMap;

use crate::placement::{Crop, Placement};

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

    /// The part of it that lies in a part of the image; `None` if nothing does.
    pub fn within(&self, crop: &Crop) -> Option<Self> {
        let cut = |start: f64, length: f64, first: u32, count: u32| {
            let (first, end) = (f64::from(first), f64::from(first) + f64::from(count));
            if start >= first && start + length <= end {
                return Some([start, length]);
            }
            let (start, end) = (start.max(first), end.min(start + length));
            (start < end).then_some([start, end - start])
        };
        let [x, y, w, h] = self.0;
        let [x, w] = cut(x, w, crop.x, crop.width)?;
        let [y, h] = cut(y, h, crop.y, crop.height)?;
        Some(Self([x, y, w, h]))
    }

    /// Intersection over union, 0..=1.
    pub fn iou(&self, other: &Self) -> f64 {
        let shared = self.shared(other);
        let all = self.area() + other.area() - shared;
        if all > 0.0 { shared / all } else { 0.0 }
    }
}

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

/// A map by frame number with `offset` added to the numbers, without those that become negative or too large.
pub fn shifted<T: Clone>(frames: &BTreeMap<u32, T>, offset: i64) -> BTreeMap<u32, T> {
    let moved = frames.iter().map(|(number, content)| (shifted_number(*number, offset), content));
    moved.filter_map(|(number, content)| Some((number?, content.clone()))).collect()
}

/// A frame number plus `offset`; `None` if it becomes negative or too large.
pub fn shifted_number(number: u32, offset: i64) -> Option<u32> {
    i64::from(number).checked_add(offset).and_then(|number| u32::try_from(number).ok())
}

/// The first and the last frame number.
pub fn span<T>(frames: &BTreeMap<u32, T>) -> Option<(u32, u32)> {
    Some((*frames.first_key_value()?.0, *frames.last_key_value()?.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_cut_to_a_part_of_the_image() {
        let part = Crop { x: 2, y: 3, width: 6, height: 10 };
        let within = |bounds: [f64; 4]| Bounds(bounds).within(&part).map(|cut| cut.0);
        assert_eq!(within([2.5, 4.0, 3.0, 2.0]), Some([2.5, 4.0, 3.0, 2.0]));
        assert_eq!(within([0.5, 4.0, 9.0, 2.0]), Some([2.0, 4.0, 6.0, 2.0]));
        assert_eq!(within([2.0, 11.5, 0.5, 6.0]), Some([2.0, 11.5, 0.5, 1.5]));
        assert_eq!(within([4.0, 1.0, 1.0, 2.5]), Some([4.0, 3.0, 1.0, 0.5]));
        assert_eq!([within([8.0, 4.0, 3.0, 2.0]), within([4.0, 0.0, 3.0, 3.0])], [None; 2]);
    }

    #[test]
    fn overlaps_and_shifts() {
        let one = Bounds([0.0, 0.0, 10.0, 20.0]);
        let other = Bounds([5.0, 10.0, 10.0, 20.0]);
        assert_eq!((one.shared(&other), one.iou(&other)), (50.0, 50.0 / 350.0));
        assert_eq!(
            (one.iou(&Bounds([20.0, 0.0, 1.0, 1.0])), Bounds([0.0; 4]).iou(&Bounds([0.0; 4]))),
            (0.0, 0.0)
        );
        let frames = BTreeMap::from([(2, 'a'), (5, 'b')]);
        assert_eq!(shifted(&frames, -3), BTreeMap::from([(2, 'b')]));
        assert_eq!(span(&frames), Some((2, 5)));
    }
}
