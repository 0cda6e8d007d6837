//! A folder of 16-bit images with an identity at each pixel, 0 being background.

use std::collections::BTreeMap;
use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageReader};
use rayon::prelude::*;

use super::TrackFile;
use crate::truth::TruthError;
use crate::truth::boxes::Bounds;
use crate::truth::masks::numbered_images;

/// Whether the first image of a folder has 16-bit labels.
pub fn is_folder_of_labels(folder: &Path) -> bool {
    let Ok(paths) = numbered_images(folder) else { return false };
    let color = || {
        let reader = ImageReader::open(paths.values().next()?).ok()?;
        Some(reader.into_decoder().ok()?.color_type())
    };
    color() == Some(ColorType::L16)
}

/// Reads the box of each identity in each image; the last number in a name is the frame's. Fails with the image that has no
/// 16-bit labels.
pub(super) fn read(folder: &Path) -> Result<TrackFile, TruthError> {
    let paths: Vec<_> = numbered_images(folder)?.into_iter().collect();
    let boxes = paths.par_iter().map(|(number, path)| Ok((*number, boxes_in(path)?)));
    let mut file = TrackFile::new("label images");
    file.boxes = boxes.collect::<Result<_, TruthError>>()?;
    file.boxes.retain(|_, boxes: &mut BTreeMap<_, _>| !boxes.is_empty());
    Ok(file)
}

fn boxes_in(path: &Path) -> Result<BTreeMap<u32, Bounds>, TruthError> {
    let image = match image::open(path) {
        Ok(DynamicImage::ImageLuma16(image)) => image,
        Ok(_) => return Err(TruthError::new(path, "it has no 16-bit gray levels, as the first image has")),
        Err(error) => return Err(TruthError::new(path, format!("{error}; check that it is complete"))),
    };
    let mut corners: BTreeMap<u16, [u32; 4]> = BTreeMap::new();
    for (x, y, level) in image.enumerate_pixels().filter(|(_, _, level)| level.0[0] > 0) {
        let [left, top, right, bottom] = corners.entry(level.0[0]).or_insert([x, y, x, y]);
        (*left, *top, *right, *bottom) = (x.min(*left), y.min(*top), x.max(*right), y.max(*bottom));
    }
    let bounds = |[left, top, right, bottom]: [u32; 4]| {
        Bounds([left, top, right - left + 1, bottom - top + 1].map(f64::from))
    };
    Ok(corners.into_iter().map(|(identity, corners)| (identity.into(), bounds(corners))).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use image::{ImageBuffer, Luma};

    use super::*;

    #[test]
    fn each_identity_has_the_box_of_its_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let level = |x: u32, y: u32| Luma([if (2..5).contains(&x) && y < 2 { 700 } else { 0_u16 }]);
        ImageBuffer::from_fn(8, 4, level).save(folder.path().join("000003.png")).unwrap();
        assert!(is_folder_of_labels(folder.path()));
        let file = super::super::read(folder.path(), super::super::Role::Truth).unwrap();
        assert_eq!(file.boxes[&3][&700], Bounds([2.0, 0.0, 3.0, 2.0]));
        image::GrayImage::new(8, 4).save(folder.path().join("000004.png")).unwrap();
        assert!(read(folder.path()).unwrap_err().to_string().contains("000004.png"));
    }
}
