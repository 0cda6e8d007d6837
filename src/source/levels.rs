//! The stored values of images that become black and white.

use std::fmt;
use std::str::FromStr;

use image::{ColorType, DynamicImage, GrayImage, RgbImage};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::image_file::{self, ImageFile};

/// Largest number of images that [`Levels::Auto`] measures.
const MAX_MEASURED: usize = 16;

/// 16-bit images that use less than this share of their range are reported.
const REPORTED_SHARE: f32 = 0.25;

/// The numbers of bits of cameras that are stored in 16.
const CAMERA_BITS: [u32; 4] = [8, 10, 12, 14];

/// The stored values of images that become 0 and 255; those between are scaled linearly, those beyond are clamped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Levels {
    /// The least and the greatest value of up to 16 images, from the first to the last of the sequence at equal steps.
    Auto,
    /// These values.
    Range(LevelRange),
}

/// The stored values that become 0 and 255.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelRange {
    /// The value that becomes 0.
    pub low: f32,
    /// The value that becomes 255.
    pub high: f32,
}

impl Levels {
    /// Whether the values are finite and ascend.
    pub fn is_valid(self) -> bool {
        match self {
            Self::Auto => true,
            Self::Range(LevelRange { low, high }) => low.is_finite() && high.is_finite() && low < high,
        }
    }

    /// The range of a sequence of images. Fails with the reason if it cannot be measured.
    pub(super) fn range(self, images: &[&ImageFile]) -> Result<LevelRange, String> {
        match self {
            Self::Range(range) => Ok(range),
            Self::Auto => measured(images),
        }
    }
}

/// `auto`, or two numbers as in `0..4095`.
impl FromStr for Levels {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let range = text.split_once("..").and_then(|(low, high)| {
            Some(LevelRange { low: low.trim().parse().ok()?, high: high.trim().parse().ok()? })
        });
        range.map(Self::Range).ok_or_else(|| format!("`{text}` is neither a range nor `auto`"))
    }
}

impl TryFrom<String> for Levels {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Levels> for String {
    fn from(levels: Levels) -> Self {
        levels.to_string()
    }
}

impl fmt::Display for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Range(range) => range.fmt(f),
        }
    }
}

impl fmt::Display for LevelRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.low, self.high)
    }
}

/// The image as 8-bit RGB. Without `levels`, the whole range of the type is scaled to that of 8 bits.
pub(super) fn rgb8(image: DynamicImage, levels: Option<LevelRange>) -> RgbImage {
    // Other conversions of real numbers make white of what is no number.
    let is_real = matches!(image.color(), ColorType::Rgb32F | ColorType::Rgba32F);
    let levels = levels.or_else(|| is_real.then_some(LevelRange { low: 0.0, high: 1.0 }));
    let Some(LevelRange { low, high }) = levels else { return image.into_rgb8() };
    let (width, height) = (image.width(), image.height());
    let (values, channels) = samples(image);
    let (low, span) = (f64::from(low), f64::from(high) - f64::from(low));
    // The conversion to a byte clamps, and cuts off decimals.
    let level = |value: f32| ((f64::from(value) - low) * 255.0 / span + 0.5) as u8;
    let bytes = values.into_iter().map(level).collect();
    let mapped = if channels == 1 {
        GrayImage::from_raw(width, height, bytes).map(DynamicImage::ImageLuma8)
    } else {
        RgbImage::from_raw(width, height, bytes).map(DynamicImage::ImageRgb8)
    };
    // There is a byte for every sample.
    mapped.map(DynamicImage::into_rgb8).unwrap_or_default()
}

/// Suggests levels for a 16-bit image whose values use a small part of the range, and for one of real numbers whose
/// values exceed it.
pub(super) fn suggestion(image: &DynamicImage) -> Option<String> {
    if matches!(image.color(), ColorType::Rgb32F | ColorType::Rgba32F) {
        let found = extent(image.clone()).filter(|found| found.low < 0.0 || found.high > 1.0)?;
        return Some(format!(
            "has values from {} to {}, and those below 0 become black, those above 1 white; scale them with --levels \
             {found} or --levels auto",
            found.low, found.high
        ));
    }
    let is_16_bit =
        matches!(image.color(), ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16);
    let LevelRange { low, high } = is_16_bit.then(|| extent(image.clone())).flatten()?;
    let whole = f32::from(u16::MAX);
    if high - low >= REPORTED_SHARE * whole {
        return None;
    }
    let of_camera = CAMERA_BITS.iter().map(|bits| ((1_u32 << bits) - 1) as f32).find(|&most| high <= most);
    let range = match of_camera {
        Some(most) => LevelRange { low: 0.0, high: most },
        // Values far from 0, as of a thermal camera: some room around them.
        None => LevelRange {
            low: (low / 256.0).floor() * 256.0,
            high: ((high + 1.0) / 256.0).ceil() * 256.0 - 1.0,
        },
    };
    Some(format!(
        "has values from {low} to {high}, a small part of its 16 bits, which leaves few of the 256 levels; scale them with \
         --levels {range} or --levels auto"
    ))
}

/// The least and the greatest value of some of the images. Images that cannot be read are skipped.
fn measured(images: &[&ImageFile]) -> Result<LevelRange, String> {
    let count = images.len().min(MAX_MEASURED);
    let last = images.len().saturating_sub(1);
    let chosen: Vec<_> = (0..count).filter_map(|i| images.get(i * last / (count - 1).max(1))).collect();
    let extents: Vec<_> =
        chosen.par_iter().filter_map(|image| extent(image_file::decode(image).ok()?)).collect();
    let range = extents.into_iter().reduce(LevelRange::around).ok_or("none of its images can be read")?;
    if range.low < range.high {
        Ok(range)
    } else {
        Err(format!("all its values are {}; give the range as --levels LOW..HIGH", range.low))
    }
}

impl LevelRange {
    fn around(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// The least and the greatest value; `None` without a finite one.
fn extent(image: DynamicImage) -> Option<LevelRange> {
    let (values, _) = samples(image);
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.map(|value| LevelRange { low: value, high: value }).reduce(LevelRange::around)
}

/// The stored values without alpha, and their number per pixel.
fn samples(image: DynamicImage) -> (Vec<f32>, usize) {
    let of_bytes = |bytes: Vec<u8>| bytes.into_iter().map(f32::from).collect();
    let of_words = |words: Vec<u16>| words.into_iter().map(f32::from).collect();
    match image.color() {
        ColorType::L8 | ColorType::La8 => (of_bytes(image.into_luma8().into_raw()), 1),
        ColorType::Rgb8 | ColorType::Rgba8 => (of_bytes(image.into_rgb8().into_raw()), 3),
        ColorType::L16 | ColorType::La16 => (of_words(image.into_luma16().into_raw()), 1),
        ColorType::Rgb16 | ColorType::Rgba16 => (of_words(image.into_rgb16().into_raw()), 3),
        _ => (image.into_rgb32f().into_raw(), 3),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use image::{ImageBuffer, Luma, LumaA, Rgb};

    use super::*;

    fn gray16(values: &[u16]) -> DynamicImage {
        let image: ImageBuffer<Luma<u16>, _> =
            ImageBuffer::from_raw(values.len() as u32, 1, values.to_vec()).unwrap();
        image.into()
    }

    fn first_channel(image: DynamicImage, low: f32, high: f32) -> Vec<u8> {
        rgb8(image, Some(LevelRange { low, high })).pixels().map(|pixel| pixel.0[0]).collect()
    }

    #[test]
    fn what_is_no_number_is_black() {
        let image =
            DynamicImage::ImageRgb32F(image::Rgb32FImage::from_raw(1, 1, vec![f32::NAN, 0.5, 7.0]).unwrap());
        assert_eq!(rgb8(image, None).into_raw(), [0, 128, 255]);
    }

    #[test]
    fn values_are_scaled_linearly_rounded_and_clamped() {
        let values = [0, 99, 100, 101, 355, 356, 65535];
        assert_eq!(first_channel(gray16(&values), 100.0, 355.0), [0, 0, 0, 1, 255, 255, 255]);
        assert_eq!(first_channel(gray16(&[8, 2047, 2048, 4095]), 0.0, 4095.0), [0, 127, 128, 255]);
        let eight_bit = GrayImage::from_raw(3, 1, vec![10, 20, 30]).unwrap();
        assert_eq!(first_channel(eight_bit.into(), 10.0, 30.0), [0, 128, 255]);
        let floats: ImageBuffer<Rgb<f32>, _> =
            ImageBuffer::from_raw(2, 1, vec![-3.0, -2.0, f32::NAN, 0.5, 40.0, 2.0]).unwrap();
        let mapped = rgb8(floats.into(), Some(LevelRange { low: -3.0, high: 2.0 }));
        assert_eq!(mapped.into_raw(), [0, 51, 0, 179, 255, 255]);
    }

    #[test]
    fn alpha_is_no_value() {
        let image: ImageBuffer<LumaA<u16>, _> =
            ImageBuffer::from_raw(2, 1, vec![5, 65535, 9, 65535]).unwrap();
        assert_eq!(extent(image.into()), Some(LevelRange { low: 5.0, high: 9.0 }));
    }

    #[test]
    fn a_range_that_fits_the_values_is_suggested() {
        for (values, suggested) in [
            (&[0, 200][..], Some("0..255")),
            (&[3, 4095], Some("0..4095")),
            (&[3, 4096], Some("0..16383")),
            (&[28_000, 32_000], Some("27904..32255")),
            (&[0, 16_384], None),
            (&[0, 65535], None),
        ] {
            let text = suggestion(&gray16(values));
            let found = text.as_deref().and_then(|text| text.split("--levels ").nth(1)?.split(' ').next());
            assert_eq!(found, suggested, "{text:?}");
        }
        assert_eq!(suggestion(&DynamicImage::new_rgb8(2, 2)), None);
    }

    #[test]
    fn levels_are_written_as_they_are_given() {
        for text in ["auto", "0..4095", "-1.5..3"] {
            let levels: Levels = text.parse().unwrap();
            assert!(levels.is_valid());
            let json = serde_json::to_string(&levels).unwrap();
            assert_eq!(json, format!("{text:?}"));
            assert_eq!(serde_json::from_str::<Levels>(&json).unwrap(), levels);
        }
        for text in ["5..5", "9..5", "NaN..4", "0..inf"] {
            assert!(!text.parse::<Levels>().unwrap().is_valid(), "{text}");
        }
        for text in ["", "..", "4095", "0..", "a..b", "0..5..9", "automatic"] {
            assert!(text.parse::<Levels>().is_err(), "{text}");
        }
    }
}
