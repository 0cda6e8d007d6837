//! Boxes of a frame by place, so that each is compared with those near it only.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::Rect;

/// Boxes up to so many pixels apart count as touching, so that rounding loses none.
const SLACK: f32 = 0.0625;

/// Boxes that are found by place, each by its number in the order given.
#[derive(Debug)]
pub(crate) struct BoxIndex(RTree<GeomWithData<Rectangle<[f32; 2]>, usize>>);

impl BoxIndex {
    /// An index of these boxes, in pixels.
    pub(crate) fn new(boxes: impl IntoIterator<Item = Rect>) -> Self {
        let entries = boxes.into_iter().enumerate();
        let entries = entries.map(|(number, bbox)| GeomWithData::new(envelope(&bbox).into(), number));
        Self(RTree::bulk_load(entries.collect()))
    }

    /// The numbers of the boxes that overlap or touch `bbox`, ascending.
    pub(crate) fn meeting(&self, bbox: &Rect) -> Vec<usize> {
        let found = self.0.locate_in_envelope_intersecting(envelope(&bbox.grown(SLACK, SLACK)));
        let mut numbers: Vec<usize> = found.map(|entry| entry.data).collect();
        numbers.sort_unstable();
        numbers
    }
}

fn envelope(bbox: &Rect) -> AABB<[f32; 2]> {
    AABB::from_corners([bbox.x, bbox.y], [bbox.right(), bbox.bottom()])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_box() -> impl Strategy<Value = Rect> {
        let [x, y] = [-20_i16..120, -20..120];
        // Sides of 0 and boxes that only touch are frequent.
        (x, y, 0_i16..30, 0_i16..30)
            .prop_map(|(x, y, w, h)| Rect::new(f32::from(x), f32::from(y), f32::from(w), f32::from(h)))
    }

    proptest! {
        #[test]
        fn exactly_the_boxes_that_overlap_or_touch_are_found(
            boxes in prop::collection::vec(any_box(), 0..40), sought in any_box(),
        ) {
            let meets = |bbox: &Rect| bbox.gap(&sought) == [0.0, 0.0];
            let expected: Vec<usize> = (0..boxes.len()).filter(|&number| meets(&boxes[number])).collect();
            prop_assert_eq!(BoxIndex::new(boxes).meeting(&sought), expected);
        }
    }
}
