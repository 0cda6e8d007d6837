//! A folder of images with an identity at each pixel, 0 being background: 16-bit gray levels, or 8-bit levels or indices of a
//! palette, as DAVIS has.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageBuffer, Luma};
use rayon::prelude::*;

use super::{Role, TrackFile};
use crate::source::MAX_PIXELS;
use crate::truth::boxes::Bounds;
use crate::truth::masks::{is_mask_level, numbered_images};
use crate::truth::{TruthError, counted};

/// The label of KITTI-MOTS' regions that are not judged.
const IGNORED: u16 = 10_000;
/// KITTI-MOTS' labels of objects: a thousand times the class, car or pedestrian, and a number.
const OBJECTS: std::ops::Range<u16> = 1000..3000;
/// Least level of 8-bit gray that is no label: masks have 127 as shadow, and from it to 255 as likely foreground.
const MASK_LEVEL: u16 = 127;
/// Number of images, at equal steps, by which the kind of a folder is known.
const SAMPLE: usize = 9;

type Labels = ImageBuffer<Luma<u16>, Vec<u16>>;

/// How labels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Depth {
    Gray16,
    Gray8,
    Palette,
    /// A palette of which only the levels of masks are used, as in a frame without objects.
    MaskPalette,
}

/// The labels of an image and how they are stored; `None` of an image that has no labels. Fails if it cannot be read.
fn labels_in(path: &Path) -> Result<Option<(Labels, Depth)>, TruthError> {
    if let Some(indices) = palette_indices(path) {
        return Ok(Some(indices));
    }
    match image::open(path) {
        Ok(DynamicImage::ImageLuma16(image)) => Ok(Some((image, Depth::Gray16))),
        Ok(DynamicImage::ImageLuma8(image)) => {
            let (width, height) = image.dimensions();
            let levels = image.iter().copied().map(u16::from).collect();
            Ok(Labels::from_raw(width, height, levels).map(|labels| (labels, Depth::Gray8)))
        }
        Ok(_) => Ok(None),
        Err(error) => Err(TruthError::new(path, format!("{error}; check that it is complete"))),
    }
}

/// The indices of a PNG with a palette; `None` of other images.
fn palette_indices(path: &Path) -> Option<(Labels, Depth)> {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(path).ok()?));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().ok()?;
    let info = reader.info();
    if info.color_type != png::ColorType::Indexed {
        return None;
    }
    let (width, height, bits) = (info.width, info.height, info.bit_depth as usize);
    // A header can claim anything; the other reader says that it is too large.
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return None;
    }
    let palette = info.palette.clone()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let line = reader.next_frame(&mut bytes).ok()?.line_size;
    let index = |x: usize, y: usize| {
        let at = x * bits;
        let byte = bytes[y * line + at / 8];
        u16::from(byte >> (8 - bits - at % 8)) & ((1 << bits) - 1)
    };
    let indices: Vec<u16> = (0..height as usize)
        .flat_map(|y| (0..width as usize).map(move |x| (x, y)))
        .map(|(x, y)| index(x, y))
        .collect();
    let is_level = |index: &u16| {
        let colour = palette.chunks_exact(3).nth(usize::from(*index));
        colour.is_some_and(|colour| colour.iter().all(|level| *level == colour[0] && is_mask_level(*level)))
    };
    let mut used = indices.clone();
    used.sort_unstable();
    used.dedup();
    let depth = if used.iter().all(is_level) { Depth::MaskPalette } else { Depth::Palette };
    Some((Labels::from_raw(width, height, indices)?, depth))
}

/// Whether the images of a folder have labels: 16 bits in the first one, a palette of colours, or 8-bit gray levels that no
/// mask has, in areas with the background beside them.
pub fn is_folder_of_labels(folder: &Path) -> bool {
    let Ok(paths) = numbered_images(folder) else { return false };
    let sample: Vec<&PathBuf> = paths.values().step_by(paths.len().div_ceil(SAMPLE).max(1)).collect();
    let images = sample.iter().map(|path| labels_in(path).ok().flatten());
    let mut has_other_level = false;
    for (at, image) in images.enumerate() {
        match image {
            Some((_, Depth::Gray16)) if at == 0 => return true,
            Some((_, Depth::Palette)) => return true,
            Some((_, Depth::MaskPalette)) => {}
            Some((labels, Depth::Gray8)) if are_areas(&labels) => {
                has_other_level |= labels.iter().any(|label| !is_mask_level(*label as u8));
            }
            _ => return false,
        }
    }
    has_other_level
}

/// Whether gray levels are those of areas: below those of masks, and mostly equal to the next one in the row.
fn are_areas(labels: &Labels) -> bool {
    let rows = || labels.rows().map(|row| row.map(|pixel| pixel.0[0]).collect::<Vec<_>>());
    let (mut labelled, mut continued) = (0_u64, 0_u64);
    for row in rows() {
        let pairs = row.windows(2).filter(|pair| pair[0] > 0);
        for pair in pairs {
            labelled += 1;
            continued += u64::from(pair[0] == pair[1]);
        }
    }
    labels.iter().all(|label| *label < MASK_LEVEL) && labels.contains(&0) && 2 * continued >= labelled
}

/// Reads the box of each identity in each image; the last number in a name is the frame's. Of ground truth, the box of
/// KITTI-MOTS' ignored regions is ignored. Fails with the image that has no labels, or others than the first.
pub(super) fn read(folder: &Path, role: Role) -> Result<TrackFile, TruthError> {
    let paths: Vec<_> = numbered_images(folder)?.into_iter().collect();
    let boxes = paths.par_iter().map(|(number, path)| Ok((*number, boxes_in(path)?)));
    let images: Vec<(u32, ImageBoxes)> = boxes.collect::<Result<_, TruthError>>()?;
    let depth = images.first().map(|(_, image)| image.depth);
    let is_like_first = |other: Depth| (other == Depth::Gray16) == (depth == Some(Depth::Gray16));
    if let Some(at) = images.iter().position(|(_, image)| !is_like_first(image.depth)) {
        let why = "its depth differs from that of the first image; give images of 16 or of 8 bits";
        return Err(TruthError::new(&paths[at].1, why));
    }
    let labels = || images.iter().flat_map(|(_, image)| image.boxes.keys());
    let is_mots = role == Role::Truth
        && labels().any(|label| *label == IGNORED)
        && labels().all(|label| *label == IGNORED || OBJECTS.contains(label));
    let mut file = TrackFile::new("label images");
    let mut ignored = 0;
    for (frame, image) in images {
        for (label, bounds) in image.boxes {
            if is_mots && label == IGNORED {
                ignored += 1;
                file.ignore(frame, bounds);
            } else {
                file.boxes.entry(frame).or_default().insert(label.into(), bounds);
            }
        }
    }
    if ignored > 0 {
        file.remarks.push(counted(
            ignored,
            "box of KITTI-MOTS' label 10000 is ignored",
            "boxes of KITTI-MOTS' label 10000 are ignored",
        ));
    }
    Ok(file)
}

/// The box of each label in an image.
struct ImageBoxes {
    boxes: BTreeMap<u16, Bounds>,
    depth: Depth,
}

fn boxes_in(path: &Path) -> Result<ImageBoxes, TruthError> {
    let Some((image, depth)) = labels_in(path)? else {
        let why = "it has no labels: 16-bit or 8-bit gray levels, or a palette; give images of one kind";
        return Err(TruthError::new(path, why));
    };
    let mut corners: BTreeMap<u16, [u32; 4]> = BTreeMap::new();
    for (x, y, level) in image.enumerate_pixels().filter(|(_, _, level)| level.0[0] > 0) {
        let [left, top, right, bottom] = corners.entry(level.0[0]).or_insert([x, y, x, y]);
        (*left, *top, *right, *bottom) = (x.min(*left), y.min(*top), x.max(*right), y.max(*bottom));
    }
    let bounds = |[left, top, right, bottom]: [u32; 4]| {
        Bounds([left, top, right - left + 1, bottom - top + 1].map(f64::from))
    };
    let boxes = corners.into_iter().map(|(identity, corners)| (identity, bounds(corners))).collect();
    Ok(ImageBoxes { boxes, depth })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

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
        assert!(read(folder.path(), Role::Truth).unwrap_err().to_string().contains("000004.png"));
    }

    /// Two objects of these labels.
    fn labels(of: [u16; 2]) -> impl Fn(u32, u32) -> u16 {
        move |x, y| match (x, y) {
            (2..=4, 0..=1) => of[0],
            (6.., 2..) => of[1],
            _ => 0,
        }
    }

    fn write_palette(path: &Path, indices: impl Fn(u32, u32) -> u16, palette: &[u8]) {
        let mut encoder = png::Encoder::new(File::create(path).unwrap(), 8, 4);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Two);
        encoder.set_palette(palette.to_vec());
        let byte = |y: u32, start: u32| (0..4).fold(0, |byte, at| byte << 2 | indices(start + at, y) as u8);
        let bytes: Vec<u8> = (0..4).flat_map(|y| [byte(y, 0), byte(y, 4)]).collect();
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    }

    #[test]
    fn labels_of_8_bits_are_distinguished_from_masks() {
        let (colours, grays) = ([0, 0, 0, 128, 0, 0, 0, 128, 0], [0, 0, 0, 255, 255, 255, 170, 170, 170]);
        for (colours, is_labels) in [(colours, true), (grays, false)] {
            let folder = tempfile::tempdir().unwrap();
            write_palette(&folder.path().join("00001.png"), |_, _| 0, &colours);
            write_palette(&folder.path().join("00002.png"), labels([1, 2]), &colours);
            assert_eq!(is_folder_of_labels(folder.path()), is_labels);
            if is_labels {
                let file = read(folder.path(), Role::Truth).unwrap();
                assert_eq!((file.boxes.len(), file.boxes[&2].len()), (1, 2));
                assert_eq!(file.boxes[&2][&1], Bounds([2.0, 0.0, 3.0, 2.0]));
                assert_eq!(file.boxes[&2][&2], Bounds([6.0, 2.0, 2.0, 2.0]));
            }
        }
        for (objects, is_labels) in [
            ([1, 2], true),
            ([1, 1], false),
            ([50, 170], false),
            ([255, 255], false),
            ([255, 127], false),
            ([3, 200], false),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let of = labels(objects);
            let image = image::GrayImage::from_fn(8, 4, |x, y| Luma([of(x, y) as u8]));
            image.save(folder.path().join("1.png")).unwrap();
            assert_eq!(is_folder_of_labels(folder.path()), is_labels, "{objects:?}");
            if is_labels {
                assert_eq!(read(folder.path(), Role::Truth).unwrap().boxes[&1].len(), 2);
            }
        }
        // A picture.
        let folder = tempfile::tempdir().unwrap();
        image::GrayImage::from_fn(8, 4, |x, y| Luma([(x * 9 + y) as u8]))
            .save(folder.path().join("1.png"))
            .unwrap();
        assert!(!is_folder_of_labels(folder.path()));
    }

    #[test]
    fn ignored_regions_of_kitti_mots_are_no_objects() {
        for (objects, role, ignored) in [
            ([2001, 10_000], Role::Truth, 1),
            ([2001, 10_000], Role::Results, 0),
            ([9999, 10_000], Role::Truth, 0),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let of = labels(objects);
            Labels::from_fn(8, 4, |x, y| Luma([of(x, y)])).save(folder.path().join("1.png")).unwrap();
            let file = read(folder.path(), role).unwrap();
            assert_eq!((file.count(), file.ignored.len()), (2 - ignored, ignored), "{objects:?} {role:?}");
        }
    }

    #[test]
    fn a_palette_image_that_claims_too_much_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("00001.png");
        let mut encoder = png::Encoder::new(File::create(&path).unwrap(), 2, 2);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::One);
        encoder.set_palette([0, 0, 0, 200, 10, 10].as_slice());
        encoder.write_header().unwrap().write_image_data(&[0x40, 0x80]).unwrap();
        let labels = palette_indices(&path).unwrap().0;
        assert_eq!(labels.into_raw(), [0, 1, 1, 0]);

        // Width and height after the signature, the length and the name of the first chunk, whose checksum follows it.
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        let checksum = crc32fast::hash(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        std::fs::write(&path, bytes).unwrap();
        assert!(palette_indices(&path).is_none() && labels_in(&path).is_err());
    }
}
