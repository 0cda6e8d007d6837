//! Images as PNG files. Errors name the file and a remedy.

use std::fs;
use std::io;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::label_image::LabelImage;
use super::write_failure::describe;
use crate::frame::{Frame, Mask};

/// Writes an RGB image.
pub fn write_frame(path: &Path, frame: &Frame) -> io::Result<()> {
    let size = frame.size;
    // PNG filters reduce the size of natural images by a third.
    write(path, &frame.rgb, size.width, size.height, ExtendedColorType::Rgb8, FilterType::Sub)
}

/// Writes a mask in CDnet's format: 8-bit gray, 0 background, 255 foreground.
pub fn write_mask(path: &Path, mask: &Mask) -> io::Result<()> {
    let size = mask.size;
    write(path, &mask.data, size.width, size.height, ExtendedColorType::L8, FilterType::NoFilter)
}

/// Writes a label image: 16-bit gray, 0 background.
pub fn write_labels(path: &Path, image: &LabelImage) -> io::Result<()> {
    let size = image.size;
    // The encoder expects the machine's order of bytes.
    let bytes: Vec<u8> = image.data.iter().flat_map(|label| label.to_ne_bytes()).collect();
    write(path, &bytes, size.width, size.height, ExtendedColorType::L16, FilterType::NoFilter)
}

fn write(
    path: &Path,
    bytes: &[u8],
    width: u32,
    height: u32,
    colour: ExtendedColorType,
    filter: FilterType,
) -> io::Result<()> {
    // The encoder passes on no error of its last writes: it has memory to write to, and the file gets all bytes at once.
    let mut bytes_of_file = Vec::new();
    // A run writes thousands of images: the fast level takes a tenth of the time for a few per cent more size.
    let encoder = PngEncoder::new_with_quality(&mut bytes_of_file, CompressionType::Fast, filter);
    let encoded = encoder.write_image(bytes, width, height, colour).map_err(io::Error::other);
    encoded.and_then(|()| fs::write(path, bytes_of_file)).map_err(|error| describe(path, error))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::frame::Size;

    #[test]
    fn images_are_restored_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let size = Size::new(5, 3);
        let frame = Frame::new(1, size, (0..45).map(|value| value * 5).collect());
        let path = folder.path().join("frame.png");
        write_frame(&path, &frame).unwrap();
        assert_eq!(image::open(&path).unwrap().into_rgb8().into_raw(), frame.rgb);

        let mask = Mask { size, data: (0..15).map(|at| if at % 4 == 0 { 255 } else { 0 }).collect() };
        let path = folder.path().join("mask.png");
        write_mask(&path, &mask).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::L8);
        assert_eq!(read.into_luma8().into_raw(), mask.data);

        let image = LabelImage { size, data: (0..15).map(|at| at * 4681).collect() };
        let path = folder.path().join("labels.png");
        write_labels(&path, &image).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::L16);
        assert_eq!(read.into_luma16().into_raw(), image.data);
    }
}
