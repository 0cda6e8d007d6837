//! One image file, as 8-bit RGB.
//!
//! 16 bits are scaled to 8 (65535 is 255, rounded), gray is replicated, palettes are looked up.
//! An alpha channel is dropped, not composited: a background model measures the colours that are
//! stored, and blending with a colour of our choice would bring in one that is not in the data;
//! OpenCV's `imread` does the same. An EXIF orientation is applied, as every viewer does.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, metadata::Orientation};

use crate::frame::Size;

const EXTENSIONS: [&str; 13] =
    ["png", "jpg", "jpeg", "jpe", "bmp", "tif", "tiff", "webp", "ppm", "pgm", "pbm", "pnm", "gif"];

/// A JPEG's header lies within its first bytes, thumbnail and all; the decoder would read the whole file.
const JPEG_HEADER_BYTES: u64 = 256 << 10;

/// Whether a file of this name is taken for an image; hidden files are not.
pub(super) fn has_image_name(path: &Path) -> bool {
    let hidden = path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    !hidden && extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}

/// The size of the image, from its header alone.
pub(super) fn size(path: &Path) -> Result<Size, String> {
    let reader = reader(path)?;
    if reader.format() != Some(ImageFormat::Jpeg) {
        return size_of(reader.into_decoder().map_err(text)?);
    }
    let mut header = Vec::new();
    File::open(path).and_then(|file| file.take(JPEG_HEADER_BYTES).read_to_end(&mut header)).map_err(text)?;
    match ImageReader::with_format(Cursor::new(header), ImageFormat::Jpeg).into_decoder() {
        Ok(decoder) => size_of(decoder),
        Err(_) => size_of(reader.into_decoder().map_err(text)?),
    }
}

/// The image's size and its RGB bytes.
pub(super) fn read(path: &Path) -> Result<(Size, Vec<u8>), String> {
    let bytes = std::fs::read(path).map_err(text)?;
    let reader = ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(text)?;
    if reader.format() == Some(ImageFormat::Jpeg) && is_cut_off(&bytes) {
        return Err("the file is truncated".into());
    }
    let mut decoder = reader.into_decoder().map_err(text)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut image = DynamicImage::from_decoder(decoder).map_err(text)?;
    image.apply_orientation(orientation);
    let rgb = image.into_rgb8();
    Ok((Size::new(rgb.width(), rgb.height()), rgb.into_raw()))
}

fn reader(path: &Path) -> Result<ImageReader<BufReader<File>>, String> {
    let file = BufReader::new(File::open(path).map_err(text)?);
    ImageReader::new(file).with_guessed_format().map_err(text)
}

fn size_of(mut decoder: impl ImageDecoder) -> Result<Size, String> {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    let (width, height) = decoder.dimensions();
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let sideways = matches!(orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH);
    let (width, height) = if sideways { (height, width) } else { (width, height) };
    if width == 0 || height == 0 { Err("it has no pixels".into()) } else { Ok(Size::new(width, height)) }
}

/// Whether a JPEG lacks its end. The decoder would fill what is missing with gray, and the model
/// would learn that gray. The end marker of a thumbnail stands in the first half.
fn is_cut_off(jpeg: &[u8]) -> bool {
    !jpeg[jpeg.len() / 2..].windows(2).any(|bytes| bytes == [0xff, 0xd9])
}

#[allow(clippy::needless_pass_by_value, reason = "fits `map_err`")]
fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}
