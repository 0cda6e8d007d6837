//! The geometry of a region: bounding box, centroid, moments and derived measures (§VII).

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::frame::Size;

/// An axis-aligned rectangle in pixels; pixel (x, y) covers [x, x + 1) × [y, y + 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rect {
    /// Left edge.
    pub x: f32,
    /// Upper edge.
    pub y: f32,
    /// Width.
    pub w: f32,
    /// Height.
    pub h: f32,
}

impl Rect {
    /// A rectangle from its upper left corner and its size.
    pub const fn new(x: f32, y: f32, w: f32, h: f32) -> Self {
        Self { x, y, w, h }
    }

    /// A rectangle of size `w` × `h` around a centre.
    pub fn around(centre: [f32; 2], w: f32, h: f32) -> Self {
        Self::new(centre[0] - w / 2.0, centre[1] - h / 2.0, w, h)
    }

    /// Right edge.
    pub fn right(&self) -> f32 {
        self.x + self.w
    }

    /// Lower edge.
    pub fn bottom(&self) -> f32 {
        self.y + self.h
    }

    /// Middle.
    pub fn centre(&self) -> [f32; 2] {
        [self.x + self.w / 2.0, self.y + self.h / 2.0]
    }

    /// Area in square pixels.
    pub fn area(&self) -> f32 {
        self.w * self.h
    }

    /// The intersection; of size 0 where the two are disjoint.
    pub fn intersection(&self, other: &Self) -> Self {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let w = (self.right().min(other.right()) - x).max(0.0);
        let h = (self.bottom().min(other.bottom()) - y).max(0.0);
        Self { x, y, w, h }
    }

    /// The bounding rectangle of both.
    pub fn union(&self, other: &Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        Self { x, y, w: self.right().max(other.right()) - x, h: self.bottom().max(other.bottom()) - y }
    }

    /// The horizontal and vertical gap between them in pixels; 0 where they overlap in that direction.
    #[must_use]
    pub fn gap(&self, other: &Self) -> [f32; 2] {
        let across = self.x.max(other.x) - self.right().min(other.right());
        let down = self.y.max(other.y) - self.bottom().min(other.bottom());
        [across.max(0.0), down.max(0.0)]
    }

    /// The horizontal overlap as a share of the narrower one's width, 0..=1.
    #[must_use]
    pub fn shared_columns(&self, other: &Self) -> f32 {
        let shared = self.right().min(other.right()) - self.x.max(other.x);
        shared.max(0.0) / self.w.min(other.w).max(f32::MIN_POSITIVE)
    }

    /// Intersection over union, 0..=1.
    pub fn iou(&self, other: &Self) -> f32 {
        let shared = self.intersection(other).area();
        let all = self.area() + other.area() - shared;
        if all > 0.0 { shared / all } else { 0.0 }
    }

    /// The share of its area that lies within `outer`, 0..=1.
    pub fn share_within(&self, outer: &Self) -> f32 {
        self.intersection(outer).area() / self.area().max(f32::MIN_POSITIVE)
    }

    /// The distance in pixels that it would have to move to lie inside `other`, or to contain it where it is larger.
    pub fn distance_outside(&self, other: &Self) -> f32 {
        let axis = |low: f32, high: f32, other_low: f32, other_high: f32| {
            let (below, above) = (other_low - low, high - other_high);
            if high - low <= other_high - other_low {
                below.max(above).max(0.0)
            } else {
                (-below).max(-above).max(0.0)
            }
        };
        let across = axis(self.x, self.right(), other.x, other.right());
        across.hypot(axis(self.y, self.bottom(), other.y, other.bottom()))
    }

    /// Distance to the nearest edge of an image of this size, in pixels; negative beyond the edge.
    pub fn distance_to_edge(&self, size: Size) -> f32 {
        let right = size.width as f32 - self.right();
        let bottom = size.height as f32 - self.bottom();
        self.x.min(self.y).min(right).min(bottom)
    }

    /// The rectangle with its left and right edges moved outwards by `dx`, the other two by `dy`.
    pub fn grown(&self, dx: f32, dy: f32) -> Self {
        Self { x: self.x - dx, y: self.y - dy, w: self.w + 2.0 * dx, h: self.h + 2.0 * dy }
    }

    /// The rectangle moved by (`dx`, `dy`).
    pub fn moved(&self, dx: f32, dy: f32) -> Self {
        Self { x: self.x + dx, y: self.y + dy, ..*self }
    }
}

/// The shape of a region, from its pixels (i, j) as points at their indices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Number of pixels.
    pub area: u32,
    /// Bounding box, in whole pixels.
    pub bbox: Rect,
    /// Mean (x, y) of the pixels' indices.
    pub centroid: [f32; 2],
    /// μ20 = Σ (x − x̄)², in pixels⁴ as OpenCV's `moments` gives it.
    pub mu20: f64,
    /// μ11 = Σ (x − x̄)(y − ȳ).
    pub mu11: f64,
    /// μ02 = Σ (y − ȳ)².
    pub mu02: f64,
    /// Angle of the longer axis to the x axis in radians, −π/2..=π/2, y down: ½·atan2(2μ11, μ20 − μ02).
    pub orientation: f32,
    /// 0 for a disc, 1 for a line: √(1 − λ₂/λ₁) of the second moments' eigenvalues.
    pub eccentricity: f32,
    /// Area over the area of the bounding box, 0..=1.
    pub extent: f32,
}

impl Shape {
    /// The moments, and what follows from them; all else is 0.
    fn of_moments([mu20, mu11, mu02]: [f64; 3]) -> Self {
        let half_difference = ((mu20 - mu02).powi(2) + 4.0 * mu11 * mu11).sqrt() / 2.0;
        let middle = f64::midpoint(mu20, mu02);
        let (longer, shorter) = (middle + half_difference, (middle - half_difference).max(0.0));
        Self {
            mu20,
            mu11,
            mu02,
            orientation: (0.5 * (2.0 * mu11).atan2(mu20 - mu02)) as f32,
            eccentricity: if longer > 0.0 { (1.0 - shorter / longer).max(0.0).sqrt() as f32 } else { 0.0 },
            ..Self::default()
        }
    }

    /// Area, moments and what follows from them with pixels `width` × `height` as large; no position. For whole numbers
    /// they are those of the region in an image enlarged that many times.
    pub(crate) fn enlarged(&self, [width, height]: [f64; 2]) -> Self {
        let (area, times) = (f64::from(self.area), width * height);
        // The pixels that one becomes are spread around its centre.
        let spread = |side: f64| area * (side * side - 1.0) / 12.0;
        let mu20 = self.mu20 * width * width + spread(width);
        let mu02 = self.mu02 * height * height + spread(height);
        Self {
            area: (area * times).round() as u32,
            extent: self.extent,
            ..Self::of_moments([mu20, self.mu11 * times, mu02].map(|moment| moment * times))
        }
    }
}

/// Sums over a region's pixels from which its [`Shape`] is computed.
#[derive(Clone, Debug, Default)]
pub struct ShapeSums {
    area: u64,
    left: u32,
    top: u32,
    right: u32,
    bottom: u32,
    x: u64,
    y: u64,
    xx: u64,
    xy: u64,
    yy: u64,
}

impl ShapeSums {
    /// Adds the pixels of row `y` in these columns, at least one.
    pub fn add_run(&mut self, y: u32, columns: Range<u32>) {
        let last = columns.end - 1;
        if self.area == 0 {
            (self.left, self.top, self.right, self.bottom) = (columns.start, y, last, y);
        }
        self.left = self.left.min(columns.start);
        self.top = self.top.min(y);
        self.right = self.right.max(last);
        self.bottom = self.bottom.max(y);
        let (start, end, y) = (u64::from(columns.start), u64::from(columns.end), u64::from(y));
        let length = end - start;
        // Σ x and Σ x² of all columns below one; those of a run are differences.
        let sum = |end: u64| end * end.saturating_sub(1) / 2;
        let squares = |end: u64| end * end.saturating_sub(1) * (2 * end).saturating_sub(1) / 6;
        let x = sum(end) - sum(start);
        self.area += length;
        self.x += x;
        self.y += y * length;
        self.xx += squares(end) - squares(start);
        self.xy += x * y;
        self.yy += y * y * length;
    }

    /// The shape of the added pixels; all zeros if there were none.
    pub fn shape(&self) -> Shape {
        if self.area == 0 {
            return Shape::default();
        }
        let n = self.area as f64;
        let (mean_x, mean_y) = (self.x as f64 / n, self.y as f64 / n);
        let mu20 = self.xx as f64 - self.x as f64 * mean_x;
        let mu11 = self.xy as f64 - self.x as f64 * mean_y;
        let mu02 = self.yy as f64 - self.y as f64 * mean_y;
        let w = (self.right - self.left + 1) as f32;
        let h = (self.bottom - self.top + 1) as f32;
        Shape {
            area: self.area as u32,
            bbox: Rect::new(self.left as f32, self.top as f32, w, h),
            centroid: [mean_x as f32, mean_y as f32],
            extent: self.area as f32 / (w * h),
            ..Shape::of_moments([mu20, mu11, mu02])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_an_enlarged_region_are_those_of_its_pixels() {
        let runs = [(2, 3..7), (3, 5..6), (4, 5..11)];
        let (mut small, mut large) = (ShapeSums::default(), ShapeSums::default());
        for (y, columns) in runs {
            small.add_run(y, columns.clone());
            (0..2).for_each(|row| large.add_run(2 * y + row, 3 * columns.start..3 * columns.end));
        }
        let (enlarged, large) = (small.shape().enlarged([3.0, 2.0]), large.shape());
        assert_eq!((enlarged.area, enlarged.extent), (large.area, large.extent));
        for (a, b) in [(enlarged.mu20, large.mu20), (enlarged.mu11, large.mu11), (enlarged.mu02, large.mu02)]
        {
            assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
        }
        assert!((enlarged.orientation - large.orientation).abs() < 1e-6);
        assert!((enlarged.eccentricity - large.eccentricity).abs() < 1e-6);
        let same = small.shape();
        assert_eq!(Shape { bbox: same.bbox, centroid: same.centroid, ..same.enlarged([1.0, 1.0]) }, same);
    }

    #[test]
    fn a_box_inside_another_is_at_no_distance() {
        let large = Rect::new(0.0, 0.0, 50.0, 60.0);
        assert_eq!(Rect::new(10.0, 0.0, 20.0, 60.0).distance_outside(&large), 0.0);
        assert_eq!(Rect::new(33.0, 0.0, 20.0, 60.0).distance_outside(&large), 3.0);
        assert_eq!(large.distance_outside(&Rect::new(-4.0, 3.0, 20.0, 20.0)), 4.0);
    }

    #[test]
    fn edges_gaps_and_distances_of_boxes() {
        let bbox = Rect::new(10.0, 20.0, 30.0, 50.0);
        assert_eq!(
            (bbox.right(), bbox.bottom(), bbox.centre(), bbox.area()),
            (40.0, 70.0, [25.0, 45.0], 1500.0)
        );
        let below = Rect::new(43.0, 76.0, 10.0, 10.0);
        assert_eq!((bbox.gap(&below), below.gap(&bbox)), ([3.0, 6.0], [3.0, 6.0]));
        // Wider than the other and lower: to contain it, it moves by 2 across; to lie inside, by 12 down.
        let narrow = Rect::new(8.0, 10.0, 20.0, 66.0);
        assert_eq!(bbox.distance_outside(&narrow), 2.0);
        let low = Rect::new(8.0, 32.0, 20.0, 66.0);
        assert_eq!(bbox.distance_outside(&low), 2.0_f32.hypot(12.0));
        // As wide as the other, which lies to the right: by 3.
        assert_eq!(bbox.distance_outside(&Rect::new(13.0, 15.0, 30.0, 60.0)), 3.0);
        assert_eq!(bbox.distance_to_edge(Size::new(100, 72)), 2.0);
        assert_eq!(bbox.distance_to_edge(Size::new(38, 100)), -2.0);
    }

    /// Pixels (0, 0), (1, 0), (1, 1) and (2, 1): μ20 = 2, μ11 = 1, μ02 = 1, so that λ = (3 ± √5) / 2.
    #[test]
    fn orientation_and_eccentricity_of_a_slanted_region_agree_with_sums_by_hand() {
        let mut sums = ShapeSums::default();
        sums.add_run(0, 0..2);
        sums.add_run(1, 1..3);
        let shape = sums.shape();
        assert_eq!((shape.mu20, shape.mu11, shape.mu02), (2.0, 1.0, 1.0));
        let [longer, shorter] = [1.0, -1.0].map(|sign: f32| f32::midpoint(3.0, sign * 5.0_f32.sqrt()));
        assert!((shape.eccentricity - (1.0 - shorter / longer).sqrt()).abs() < 1e-6, "{shape:?}");
        assert!((shape.orientation - 0.5 * 2.0_f32.atan()).abs() < 1e-6, "{shape:?}");
        assert_eq!((shape.extent, shape.centroid), (4.0 / 6.0, [1.0, 0.5]));
    }

    #[test]
    fn overlap_of_boxes_and_their_move() {
        let bbox = Rect::new(10.0, 20.0, 30.0, 50.0);
        let other = Rect::new(30.0, 50.0, 20.0, 40.0);
        assert_eq!(bbox.iou(&other), 200.0 / (1500.0 + 800.0 - 200.0));
        assert_eq!((bbox.iou(&bbox), bbox.iou(&bbox.moved(30.0, 0.0))), (1.0, 0.0));
        assert_eq!(Rect::default().iou(&Rect::default()), 0.0);
        assert_eq!((bbox.shared_columns(&other), other.shared_columns(&bbox)), (0.5, 0.5));
        assert_eq!(bbox.moved(2.0, 3.0), Rect::new(12.0, 23.0, 30.0, 50.0));
    }
}
