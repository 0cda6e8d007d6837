//! Text in figures: typeface and width.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};

/// The font families; the first is that of rasterised figures.
pub const FAMILY: &str = "Ubuntu, 'Ubuntu Light', Helvetica, Arial, sans-serif";
/// The font data.
pub const TYPEFACE: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

/// Distance from the figure's edge to its text.
pub(super) const MARGIN: f64 = 8.0;
/// Top of the legend, below the title.
pub(super) const LEGEND: f64 = 19.0;
/// Line height of the legend.
pub(super) const LINE: f64 = 11.0;
/// Space for the legend's sign before its text.
pub(super) const SIGN: f64 = 18.0;

static FONT: LazyLock<Option<FontRef<'static>>> = LazyLock::new(|| FontRef::try_from_slice(TYPEFACE).ok());

/// The width of a text of this size.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let Some(font) = FONT.as_ref() else { return 0.5 * size * text.chars().count() as f64 };
    let scale = font.units_per_em().map_or(1.0, |units| font.height_unscaled() / units);
    // The library's size is the line height, ours the em square.
    let font = font.as_scaled(PxScale::from(size as f32 * scale));
    text.chars().map(|sign| f64::from(font.h_advance(font.glyph_id(sign)))).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_typeface_has_every_character_of_figures() {
        let font = FONT.as_ref().unwrap();
        for sign in "μσλραηΣKTBwRGBYX₀₁₂₃²±·−–×≤≥()[]=,.%/".chars() {
            assert_ne!(font.glyph_id(sign).0, 0, "{sign}");
        }
    }

    #[test]
    fn the_width_of_text_grows_with_its_length() {
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
