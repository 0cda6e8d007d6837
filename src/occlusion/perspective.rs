//! How size changes with place: who walks away grows smaller, also while nobody sees how much.

use crate::frame::Size;

/// The slope is trusted as far as what was seen of it outweighs this much evidence that there is
/// none: people at places this share of the image's height apart, for so many frames.
const DOUBT_HEIGHT: f32 = 0.05;
const DOUBT_FRAMES: f32 = 50.0;
/// It is applied in full where it explains this share of the changes of size that were seen (R²): it does of people on
/// a plain seen from above (.7), and not of fish (.002).
const PROVEN: f32 = 0.3;
/// Nobody changes size between two places by more than this factor.
const MOST: f32 = 2.0;

/// Learns, from everybody seen clearly, by how much the logarithm of the height grows for each
/// pixel that the feet stand lower in the image. Camera and ground are taken as fixed.
#[derive(Clone, Debug, Default)]
pub struct Perspective {
    spread: f32,
    together: f32,
    squares: f32,
    doubt: f32,
}

impl Perspective {
    /// For images of this size.
    pub fn new(size: Size) -> Self {
        let doubt = DOUBT_FRAMES * (DOUBT_HEIGHT * size.height as f32).powi(2);
        Self { spread: 0.0, together: 0.0, squares: 0.0, doubt }
    }

    /// Takes in somebody seen clearly: where their feet are and how tall they are, against what was
    /// remembered of the same one.
    pub fn see(&mut self, feet: f32, height: f32, feet_before: f32, height_before: f32) {
        let moved = feet - feet_before;
        self.spread += moved * moved;
        let grown = (height.max(1.0) / height_before.max(1.0)).ln();
        self.together += moved * grown;
        self.squares += grown * grown;
    }

    /// By which factor somebody is larger at `feet` than at `feet_before`.
    pub fn scale(&self, feet: f32, feet_before: f32) -> f32 {
        let explained = self.together * self.together / (self.spread * self.squares).max(f32::MIN_POSITIVE);
        let trust = (explained / PROVEN).min(1.0);
        let slope = self.together / (self.spread + self.doubt).max(f32::MIN_POSITIVE);
        (trust * slope * (feet - feet_before)).exp().clamp(1.0 / MOST, MOST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_seen_of_some_is_said_of_others() {
        let mut perspective = Perspective::new(Size::new(640, 480));
        assert_eq!(perspective.scale(300.0, 200.0), 1.0, "nothing is known yet");
        for feet in (200..400).step_by(2) {
            let feet = feet as f32;
            let height = |feet: f32| 50.0 * (0.003 * (feet - 200.0)).exp();
            perspective.see(feet, height(feet), feet - 20.0, height(feet - 20.0));
        }
        let scale = perspective.scale(300.0, 200.0);
        assert!((scale.ln() - 0.3).abs() < 0.15, "{scale}");
        assert!(perspective.scale(1.0e6, 0.0) <= 2.0);
    }

    #[test]
    fn where_size_does_not_follow_the_place_it_is_not_scaled() {
        let mut fish = Perspective::new(Size::new(640, 480));
        for n in 0..400 {
            // They turn, and so their boxes are long and short in turn, wherever they are.
            let (before, after) = if n % 2 == 0 { (20.0, 34.0) } else { (34.0, 20.0) };
            fish.see(200.0 + (n * 37 % 100) as f32, after, 200.0 + (n * 53 % 100) as f32, before);
        }
        assert!((fish.scale(300.0, 200.0) - 1.0).abs() < 0.05, "{}", fish.scale(300.0, 200.0));
    }
}
