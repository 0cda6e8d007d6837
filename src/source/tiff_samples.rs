//! TIFF images of kinds of values that the `image` crate does not read: real numbers in gray, whole numbers with a sign or of
//! more than 16 bits.

use std::fmt::Display;
use std::io::{Read, Seek};

use image::metadata::Orientation;
use image::{DynamicImage, Rgb32FImage};
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::image_file::{check_bytes, checked_size, upright_size};
use crate::frame::Size;

/// The size of the image, upright.
pub(super) fn size(file: impl Read + Seek) -> Result<Size, String> {
    let mut decoder = decoder(file)?;
    channels(&mut decoder)?;
    upright_size(decoder.dimensions().map_err(text)?, orientation(&mut decoder))
}

/// The image with its stored values as real numbers, upright and without alpha.
pub(super) fn decode(file: impl Read + Seek) -> Result<DynamicImage, String> {
    let mut decoder = decoder(file)?;
    let (stored, used) = channels(&mut decoder)?;
    let (width, height) = decoder.dimensions().map_err(text)?;
    let size = checked_size(width, height)?;
    let orientation = orientation(&mut decoder);
    let layout = decoder.image_buffer_layout().map_err(text)?;
    if layout.planes > 1 {
        return Err("its colours are in planes of their own; convert it to one plane".into());
    }
    check_bytes(layout.complete_len as u64)?;
    let mut limits = Limits::default();
    // The picture is not too large.
    limits.decoding_buffer_size = limits.decoding_buffer_size.max(layout.complete_len);
    let mut decoder = decoder.with_limits(limits);
    let values = values(decoder.read_image().map_err(text)?);
    if values.len() < size.pixels() * stored {
        return Err("it has fewer values than its size needs".into());
    }
    let colours = values.chunks_exact(stored).take(size.pixels()).flat_map(|pixel| match used {
        1 => [pixel[0]; 3],
        _ => [pixel[0], pixel[1], pixel[2]],
    });
    let image = Rgb32FImage::from_raw(size.width, size.height, colours.collect());
    // There are three values for each pixel.
    let mut image = image.map(DynamicImage::ImageRgb32F).unwrap_or_default();
    image.apply_orientation(orientation);
    Ok(image)
}

fn decoder<R: Read + Seek>(file: R) -> Result<Decoder<R>, String> {
    Decoder::new(file).map_err(text)
}

/// Numbers of stored values of a pixel, and of those that are colours. Fails for other kinds of images.
fn channels(decoder: &mut Decoder<impl Read + Seek>) -> Result<(usize, usize), String> {
    let kind = decoder.colortype().map_err(text)?;
    let (bits, channels) = match kind {
        ColorType::Gray(bits) => (bits, (1, 1)),
        ColorType::RGB(bits) => (bits, (3, 3)),
        ColorType::RGBA(bits) => (bits, (4, 3)),
        // Gray with alpha.
        ColorType::Multiband { bit_depth, num_samples: 2 } => (bit_depth, (2, 1)),
        other => return Err(format!("its colours are {other:?}, which are not read; convert it to RGB")),
    };
    if matches!(bits, 8 | 16 | 32 | 64) {
        Ok(channels)
    } else {
        Err(format!("its values have {bits} bits; convert it to 8 or 16 bits"))
    }
}

fn orientation(decoder: &mut Decoder<impl Read + Seek>) -> Orientation {
    let number = decoder.find_tag_unsigned::<u8>(Tag::Orientation).ok().flatten();
    number.and_then(Orientation::from_exif).unwrap_or(Orientation::NoTransforms)
}

fn values(stored: DecodingResult) -> Vec<f32> {
    fn all<T>(values: Vec<T>, real: impl Fn(T) -> f32) -> Vec<f32> {
        values.into_iter().map(real).collect()
    }
    match stored {
        DecodingResult::U8(values) => all(values, f32::from),
        DecodingResult::I8(values) => all(values, f32::from),
        DecodingResult::U16(values) => all(values, f32::from),
        DecodingResult::I16(values) => all(values, f32::from),
        DecodingResult::U32(values) => all(values, |value| value as f32),
        DecodingResult::I32(values) => all(values, |value| value as f32),
        DecodingResult::U64(values) => all(values, |value| value as f32),
        DecodingResult::I64(values) => all(values, |value| value as f32),
        DecodingResult::F16(values) => all(values, f32::from),
        DecodingResult::F32(values) => values,
        DecodingResult::F64(values) => all(values, |value| value as f32),
    }
}

#[allow(clippy::needless_pass_by_value, reason = "fits `map_err`")]
fn text(error: impl Display) -> String {
    error.to_string()
}
