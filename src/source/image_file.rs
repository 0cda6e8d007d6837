//! One image file, as 8-bit RGB.
//!
//! 16 bits are scaled to 8 (65535 becomes 255, rounded), gray is replicated, palettes are looked up. An alpha channel
//! is dropped, not composited, as in OpenCV's `imread`: the background model measures the stored colours, and
//! blending would add colours that are not in the data. The EXIF orientation is applied.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, metadata::Orientation};

use crate::frame::Size;

const EXTENSIONS: [&str; 13] =
    ["png", "jpg", "jpeg", "jpe", "bmp", "tif", "tiff", "webp", "ppm", "pgm", "pbm", "pnm", "gif"];

/// A JPEG's header, thumbnail included, lies within these first bytes; the decoder would read the whole file.
const JPEG_HEADER_BYTES: u64 = 256 << 10;

/// Whether the file name is that of an image; hidden files are not.
pub(super) fn has_image_name(path: &Path) -> bool {
    let hidden = path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    !hidden && extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}

/// The size of the image, read from its header only.
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

/// Whether the end marker of a JPEG is missing. The decoder fills missing data with gray, which the model would
/// learn. Only the second half is searched, because a thumbnail's end marker lies in the first half.
fn is_cut_off(jpeg: &[u8]) -> bool {
    !jpeg[jpeg.len() / 2..].windows(2).any(|bytes| bytes == [0xff, 0xd9])
}

#[allow(clippy::needless_pass_by_value, reason = "fits `map_err`")]
fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}
