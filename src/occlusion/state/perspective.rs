//! Perspective: how size changes with the place in the image, also while an object is not visible.

/// Successive frames are nearly the same; this many count as one observation.
const FRAMES_PER_OBSERVATION: f32 = 50.0;
/// Multiple of the variance of the slope's estimate that is subtracted from its square. Tried from 1 to 5 on people
/// near and far and on fish.
const SHRINKAGE_VARIANCES: f32 = 2.0;
/// Largest factor by which size changes between two places.
const MAX_SCALE: f32 = 2.0;

/// Learns from clearly visible objects by how much the logarithm of the height grows for each pixel that the centre
/// is lower in the image. Camera and ground are taken as fixed.
///
/// On a plane, height and the centre's distance from the horizon are proportional. The place is measured by the
/// centre, not the lower edge: the lower edge depends on the size itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct Perspective {
    spread: f32,
    together: f32,
    squares: f32,
    frames: u32,
}

impl Perspective {
    /// Updates it with a clearly visible object: its centre's y in pixels and its height, against the learnt values
    /// of the same object.
    pub(crate) fn update(&mut self, y: f32, height: f32, y_before: f32, height_before: f32) {
        let moved = y - y_before;
        self.spread += moved * moved;
        let grown = (height.max(1.0) / height_before.max(1.0)).ln();
        self.together += moved * grown;
        self.squares += grown * grown;
        self.frames = self.frames.saturating_add(1);
    }

    /// Ratio of an object's size with the centre at `y` to that at `y_before`.
    pub(crate) fn scale(&self, y: f32, y_before: f32) -> f32 {
        (self.slope() * (y - y_before)).exp().clamp(1.0 / MAX_SCALE, MAX_SCALE)
    }

    /// The regression's slope, drawn towards 0 by as much as it is uncertain: times 1 − c·s² / b², where b is the slope
    /// and s² = b² (1/R² − 1) / n its variance (the positive part of James and Stein's estimate).
    fn slope(&self) -> f32 {
        let explained = self.together * self.together / (self.spread * self.squares);
        let observations = self.frames as f32 / FRAMES_PER_OBSERVATION;
        let trust = 1.0 - SHRINKAGE_VARIANCES * (1.0 / explained - 1.0) / observations;
        // Not a number before the first update.
        if trust > 0.0 { trust * self.together / self.spread } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;

    #[test]
    fn the_scale_learnt_from_some_objects_applies_to_others() {
        let mut perspective = Perspective::default();
        assert_eq!(perspective.scale(300.0, 200.0), 1.0, "before the first observation");
        for y in (200..400).step_by(2) {
            let y = y as f32;
            let height = |y: f32| 50.0 * (0.003 * (y - 200.0)).exp();
            perspective.update(y, height(y), y - 20.0, height(y - 20.0));
        }
        let scale = perspective.scale(300.0, 200.0);
        assert!((scale.ln() - 0.3).abs() < 0.01, "{scale}");
        assert!(perspective.scale(1.0e6, 0.0) <= 2.0);
    }

    #[test]
    fn a_slope_counts_more_with_more_observations() {
        let mut perspective = Perspective::default();
        let mut scales = Vec::new();
        for n in 0..400 {
            // Half of what changes the height is noise.
            let noise = if n % 2 == 0 { 1.06 } else { 1.0 / 1.06 };
            perspective.update(220.0, 50.0 * 1.06 * noise, 200.0, 50.0);
            scales.push(perspective.scale(300.0, 200.0));
        }
        assert_eq!(scales[40], 1.0, "a few frames are not enough");
        assert!(scales[150] > 1.05 && scales[399] > scales[150], "{} {}", scales[150], scales[399]);
    }

    #[test]
    fn without_a_relation_of_size_and_place_the_scale_is_one() {
        let mut fish = Perspective::default();
        for n in 0..400 {
            // They turn, and so their boxes are long and short in turn, wherever they are.
            let (before, after) = if n % 2 == 0 { (20.0, 34.0) } else { (34.0, 20.0) };
            fish.update(200.0 + (n * 37 % 100) as f32, after, 200.0 + (n * 53 % 100) as f32, before);
        }
        assert!((fish.scale(300.0, 200.0) - 1.0).abs() < 0.01, "{}", fish.scale(300.0, 200.0));
    }
}
