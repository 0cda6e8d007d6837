//! One image file or page of a file, as 8-bit RGB.
//!
//! 16 bits are scaled to 8 (65535 becomes 255, rounded) unless [`Levels`] are given, gray is replicated, palettes are
//! looked up. An alpha channel is dropped, not composited, as in OpenCV's `imread`: the background model measures the
//! stored colours, and blending would add colours that are not in the data. The EXIF orientation is applied.
//!
//! [`Levels`]: super::Levels

use std::fmt;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use image::codecs::{gif::GifDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{
    AnimationDecoder, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits,
    metadata::Orientation,
};

use super::levels::{self, LevelRange};
use super::tiff_pages::{self, PageReader};
use super::{jpeg, jpeg_data, tiff_samples};
use crate::frame::Size;

const EXTENSIONS: [&str; 13] =
    ["png", "jpg", "jpeg", "jpe", "bmp", "tif", "tiff", "webp", "ppm", "pgm", "pbm", "pnm", "gif"];

/// Largest number of pixels of an image, as FFmpeg has it for videos. A header can claim any.
pub(crate) const MAX_PIXELS: u64 = 1 << 28;

/// Largest number of bytes of the values of an image: four channels of 16 bits of the most pixels.
const MAX_BYTES: u64 = 8 * MAX_PIXELS;

/// A JPEG's header, thumbnail included, lies within these first bytes; the decoder would read the whole file.
const JPEG_HEADER_BYTES: u64 = 256 << 10;

/// The place of an image.
#[derive(Clone, Debug)]
pub(super) struct ImageFile {
    pub(super) path: PathBuf,
    /// The page of a TIFF file; `None` for the file's first or only image.
    pub(super) page: Option<Page>,
}

/// A page of a TIFF file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Page {
    /// Its number from 1.
    pub(super) number: u32,
    /// The place of its directory in the file.
    pub(super) directory: u64,
}

impl ImageFile {
    /// The image without its folder.
    pub(super) fn short_name(&self) -> String {
        match self.page {
            None => self.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            Some(page) => format!("page {}", page.number),
        }
    }
}

impl fmt::Display for ImageFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.page {
            None => self.path.display().fmt(f),
            Some(page) => write!(f, "page {} of {}", page.number, self.path.display()),
        }
    }
}

/// Whether the file name is that of an image; hidden files are not.
pub(crate) fn has_image_name(path: &Path) -> bool {
    let hidden = path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    !hidden && extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}

/// The size of the image, read from its header only.
pub(super) fn size(image: &ImageFile) -> Result<Size, String> {
    let path = &image.path;
    if let Some(page) = image.page {
        let reader = || page_reader(path, page);
        return match reader()?.into_decoder() {
            Err(ImageError::Unsupported(_)) => tiff_samples::size(reader()?.into_inner()),
            decoder => size_of(decoder.map_err(text)?),
        };
    }
    let reader = reader(path)?;
    let format = reader.format();
    if format != Some(ImageFormat::Jpeg) {
        return match reader.into_decoder() {
            Err(ImageError::Unsupported(_)) if format == Some(ImageFormat::Tiff) => {
                tiff_samples::size(BufReader::new(File::open(path).map_err(text)?))
            }
            decoder => size_of(decoder.map_err(text)?),
        };
    }
    let mut header = Vec::new();
    File::open(path).and_then(|file| file.take(JPEG_HEADER_BYTES).read_to_end(&mut header)).map_err(text)?;
    match ImageReader::with_format(Cursor::new(header), ImageFormat::Jpeg).into_decoder() {
        Ok(decoder) => size_of(decoder),
        Err(_) => size_of(reader.into_decoder().map_err(text)?),
    }
}

/// The image's size and its RGB bytes.
pub(super) fn read(image: &ImageFile, levels: Option<LevelRange>) -> Result<(Size, Vec<u8>), String> {
    Ok(rgb(decode(image)?, levels))
}

/// The size and the RGB bytes of a decoded image.
pub(super) fn rgb(image: DynamicImage, levels: Option<LevelRange>) -> (Size, Vec<u8>) {
    let rgb = levels::rgb8(image, levels);
    (Size::new(rgb.width(), rgb.height()), rgb.into_raw())
}

/// The image with its stored values, upright.
pub(super) fn decode(image: &ImageFile) -> Result<DynamicImage, String> {
    if let Some(page) = image.page {
        let reader = || page_reader(&image.path, page);
        return match reader()?.into_decoder() {
            Err(ImageError::Unsupported(_)) => tiff_samples::decode(reader()?.into_inner()),
            decoder => upright(decoder.map_err(text)?),
        };
    }
    let bytes = std::fs::read(&image.path).map_err(text)?;
    let reader = ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(text)?;
    let format = reader.format();
    if format == Some(ImageFormat::Jpeg) {
        if jpeg::is_cut_off(&bytes) {
            return Err("the file is truncated".into());
        }
        if jpeg_data::is_damaged(&bytes) {
            return Err("its data is damaged".into());
        }
    }
    match reader.into_decoder() {
        Err(ImageError::Unsupported(_)) if format == Some(ImageFormat::Tiff) => {
            tiff_samples::decode(Cursor::new(&bytes))
        }
        decoder => upright(decoder.map_err(text)?),
    }
}

/// What a file holds besides its first picture, if anything: pages, or an animation.
pub(super) fn further_pictures(path: &Path) -> Option<&'static str> {
    let file = || File::open(path).map(BufReader::new).ok();
    let is_animated = match reader(path).ok()?.format()? {
        ImageFormat::Tiff => {
            let several = tiff_pages::pages(path, 2).is_ok_and(|pages| pages.directories.len() > 1);
            return several.then_some(
                "has several pages; of such files in a folder only the first page is used, give the file itself to read all",
            );
        }
        ImageFormat::Png => PngDecoder::new(file()?).and_then(|png| png.is_apng()).ok()?,
        ImageFormat::WebP => WebPDecoder::new(file()?).ok()?.has_animation(),
        ImageFormat::Gif => GifDecoder::new(file()?).ok()?.into_frames().take(2).count() > 1,
        _ => false,
    };
    is_animated.then_some(
        "is animated; of such files only the first picture is used, convert it to a video to read all",
    )
}

fn upright(mut decoder: impl ImageDecoder) -> Result<DynamicImage, String> {
    let (width, height) = decoder.dimensions();
    checked_size(width, height)?;
    check_bytes(decoder.total_bytes())?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    // Beside the picture itself, which is not too large.
    let mut limits = Limits::default();
    limits.max_alloc = limits.max_alloc.map(|bytes| bytes.saturating_add(decoder.total_bytes()));
    decoder.set_limits(limits).map_err(text)?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(text)?;
    image.apply_orientation(orientation);
    Ok(image)
}

fn reader(path: &Path) -> Result<ImageReader<BufReader<File>>, String> {
    let file = File::open(path).map_err(|error| {
        if path.is_symlink() && !path.exists() {
            "it is a link to a file that does not exist".to_owned()
        } else {
            text(error)
        }
    })?;
    if file.metadata().is_ok_and(|metadata| metadata.len() == 0) {
        return Err("the file is empty".into());
    }
    ImageReader::new(BufReader::new(file)).with_guessed_format().map_err(text)
}

fn page_reader(path: &Path, page: Page) -> Result<ImageReader<PageReader>, String> {
    Ok(ImageReader::with_format(PageReader::open(path, page.directory).map_err(text)?, ImageFormat::Tiff))
}

fn size_of(mut decoder: impl ImageDecoder) -> Result<Size, String> {
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    upright_size(decoder.dimensions(), orientation)
}

/// The size of an image after its orientation is applied.
pub(super) fn upright_size((width, height): (u32, u32), orientation: Orientation) -> Result<Size, String> {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    match orientation {
        Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH => checked_size(height, width),
        _ => checked_size(width, height),
    }
}

/// The size that a header claims. Fails where there is nothing, or too much to be an image.
pub(super) fn checked_size(width: u32, height: u32) -> Result<Size, String> {
    match u64::from(width) * u64::from(height) {
        0 => Err("it has no pixels".into()),
        pixels if pixels > MAX_PIXELS => {
            let most = MAX_PIXELS / 1_000_000;
            Err(format!("its header says {width}×{height}, and images have at most {most} million pixels"))
        }
        _ => Ok(Size::new(width, height)),
    }
}

/// Fails where a header claims more bytes of values than an image has.
pub(super) fn check_bytes(bytes: u64) -> Result<(), String> {
    let [claimed, most] = [bytes, MAX_BYTES].map(|bytes| bytes >> 20);
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    Err(format!(
        "its header says {claimed} MiB of values, and images have at most {most}; convert it to 16 bits"
    ))
}

#[allow(clippy::needless_pass_by_value, reason = "fits `map_err`")]
fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn bytes_that_a_header_only_claims_are_not_allocated() {
        for (seed, claimed) in [
            (&include_bytes!("../../fuzz/seeds/images/claims-4-gigabytes.tif")[1..], "4096 MiB"),
            (&include_bytes!("../../fuzz/seeds/images/claims-6-gigabytes.tif")[1..], "6144 MiB"),
        ] {
            let file = tempfile::Builder::new().suffix(".tif").tempfile().unwrap();
            std::fs::write(&file, seed).unwrap();
            let image = ImageFile { path: file.path().to_owned(), page: None };
            assert_eq!(size(&image), Ok(Size::new(16384, 16384)));
            let why = decode(&image).unwrap_err();
            assert!(why.contains(claimed) && why.contains("at most 2048"), "{why}");
        }
    }
}
