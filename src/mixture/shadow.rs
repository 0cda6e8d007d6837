//! Foreground that is shadow: the surface behind it, darkened.

use crate::settings::Settings;

/// Which values are shadow on a surface.
///
/// A shadow takes light away from all channels alike. So its value lies on the line from black to
/// the surface's colour μ, not too near to black: X ≈ s·μ with τ ≤ s < 1 (Horprasert et al. 1999,
/// whose s is the brightness distortion, and ‖X − s·μ‖ the chromaticity distortion).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// τ, the darkest shadow as a share of the surface's brightness; 1 where there is none.
    pub floor: f32,
    /// How far, in levels, X may lie from the line.
    pub colour: f32,
}

impl Shadow {
    /// The part of `settings` about shadow.
    pub const fn new(settings: &Settings) -> Self {
        Self { floor: settings.shadow_floor, colour: settings.shadow_colour }
    }

    /// Whether anything is taken for shadow at all.
    pub fn is_on(self) -> bool {
        self.floor < 1.0
    }

    /// Whether `value` is shadow on a surface of the colour `mean`.
    pub fn covers(self, value: &[f32], mean: &[f32]) -> bool {
        let (share, off) = self.of(value, mean);
        self.is_on() && self.floor <= share && share < 1.0 && off <= self.colour
    }

    /// The share of the surface's brightness that is nearest to `value`, and how far, in levels,
    /// the value is from the surface's colour at that brightness.
    pub fn of(self, value: &[f32], mean: &[f32]) -> (f32, f32) {
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
        let (along, surface) = (dot(value, mean), dot(mean, mean));
        let share = along / surface;
        (share, (dot(value, value) - share * along).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADOW: Shadow = Shadow { floor: 0.6, colour: 12.0 };

    #[test]
    fn a_surface_darkened_is_shadow_until_it_is_too_dark() {
        let surface = [180.0, 160.0, 120.0];
        let darkened = |share: f32| surface.map(|channel| share * channel);
        assert!(SHADOW.covers(&darkened(0.9), &surface));
        assert!(SHADOW.covers(&darkened(0.65), &surface));
        assert!(!SHADOW.covers(&darkened(0.5), &surface));
        assert!(!SHADOW.covers(&darkened(1.1), &surface), "light is no shadow");
    }

    #[test]
    fn another_colour_is_no_shadow() {
        assert!(!SHADOW.covers(&[150.0, 100.0, 100.0], &[180.0, 160.0, 120.0]));
        assert!(SHADOW.covers(&[128.0, 118.0, 92.0], &[180.0, 160.0, 120.0]), "noise is allowed for");
    }

    #[test]
    fn on_black_there_is_none_and_off_is_off() {
        assert!(!SHADOW.covers(&[0.0; 3], &[0.0; 3]));
        let off = Shadow { floor: 1.0, ..SHADOW };
        assert!(!off.covers(&[90.0; 3], &[100.0; 3]));
    }
}
