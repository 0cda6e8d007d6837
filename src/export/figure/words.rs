//! Text in figures: its typeface, and how much room it takes.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};

/// The typefaces that are asked for; the first is the one that pictures are drawn with.
pub const FAMILY: &str = "Ubuntu, 'Ubuntu Light', Helvetica, Arial, sans-serif";
/// The typeface itself.
pub const TYPEFACE: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

/// From the figure's edge to its text.
pub(super) const MARGIN: f64 = 8.0;
/// Where the legend begins, below the title.
pub(super) const LEGEND: f64 = 19.0;
/// From one line of the legend to the next.
pub(super) const LINE: f64 = 11.0;
/// Room for the legend's sign before its words.
pub(super) const SIGN: f64 = 18.0;

static FONT: LazyLock<Option<FontRef<'static>>> = LazyLock::new(|| FontRef::try_from_slice(TYPEFACE).ok());

/// How wide a word of this size is.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let Some(font) = FONT.as_ref() else { return 0.5 * size * text.chars().count() as f64 };
    let scale = font.units_per_em().map_or(1.0, |units| font.height_unscaled() / units);
    // The library's size is the line's height, ours the em square's.
    let font = font.as_scaled(PxScale::from(size as f32 * scale));
    text.chars().map(|sign| f64::from(font.h_advance(font.glyph_id(sign)))).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_typeface_has_every_sign_that_figures_use() {
        let font = FONT.as_ref().unwrap();
        for sign in "μσλραηΣKTBwRGBYX₀₁₂₃²±·−–×≤≥()[]=,.%/".chars() {
            assert_ne!(font.glyph_id(sign).0, 0, "{sign}");
        }
    }

    #[test]
    fn words_are_as_wide_as_they_are_long() {
        assert_eq!(width("", 8.0), 0.0);
        let one = width("frame", 8.0);
        // Five letters of an em square of 8 points, each about half as wide as high.
        assert!((14.0..26.0).contains(&one), "{one}");
        assert!(
            (width("frameframe", 8.0) - 2.0 * one).abs() < 1e-3
                && (width("frame", 16.0) - 2.0 * one).abs() < 0.1
        );
    }
}
