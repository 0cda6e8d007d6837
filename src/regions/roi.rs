//! The region of interest: the part of the image that is analysed, from a mask file or from areas drawn over the
//! frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{DynamicImage, ImageReader};

use crate::frame::{Mask, Size};
use crate::placement::Placement;

/// Gray level from which on a pixel of a mask is part of the region.
const BRIGHT: u8 = 128;

/// An error of a region of interest.
#[derive(Debug, thiserror::Error)]
pub enum RoiError {
    /// The mask is missing or not an image.
    #[error(
        "the mask {path} cannot be read: {why}; give an image as large as the frames, white in the area to \
         analyse"
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The cause.
        why: String,
    },
    /// The region is empty.
    #[error(
        "the mask {path} is dark everywhere, so nothing would be analysed; make the area to analyse white"
    )]
    Dark {
        /// The file.
        path: PathBuf,
    },
    /// The region is empty in the frames.
    #[error(
        "the mask{file} is dark in all that is analysed; make a part white that is within the crop, and larger than a \
         pixel after scaling"
    )]
    Cropped {
        /// A blank and the mask's file, or empty.
        file: String,
    },
    /// The mask has another size than the frames.
    #[error("the mask{file} is {found}, but the frames are {expected}; give one as large as the frames")]
    Size {
        /// A blank and the mask's file, or empty.
        file: String,
        /// The mask's size.
        found: Size,
        /// The frames' size.
        expected: Size,
    },
}

/// The region of interest: the pixels that are analysed. All others are background.
#[derive(Clone, Debug)]
pub struct Roi {
    /// Foreground where pixels are analysed; not empty.
    inside: Mask,
    /// The file that it was read from, if any.
    file: Option<PathBuf>,
}

/// Regions are equal if their pixels are, whatever file they were read from.
impl PartialEq for Roi {
    fn eq(&self, other: &Self) -> bool {
        self.inside == other.inside
    }
}

impl Eq for Roi {}

impl Roi {
    /// The foreground of `inside`; `None` where there is none.
    pub fn new(inside: Mask) -> Option<Self> {
        (inside.foreground_pixels() > 0).then_some(Self { inside, file: None })
    }

    /// Reads an image whose bright pixels (128 or more) are analysed.
    pub fn read(path: &Path) -> Result<Self, RoiError> {
        let unreadable = |why: String| {
            // Messages of the decoders may contain line breaks; ours are one line.
            let why = why.split_whitespace().collect::<Vec<_>>().join(" ");
            RoiError::Unreadable { path: path.to_owned(), why }
        };
        let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
        let image = reader.map_err(|error| unreadable(error.to_string()))?.decode();
        let luma = image.map(DynamicImage::into_luma8).map_err(|error| unreadable(error.to_string()))?;
        let level = |level: &u8| if *level >= BRIGHT { Mask::FOREGROUND } else { Mask::BACKGROUND };
        let size = Size::new(luma.width(), luma.height());
        let inside = Mask { size, data: luma.as_raw().iter().map(level).collect() };
        let read = Self::new(inside).ok_or_else(|| RoiError::Dark { path: path.to_owned() })?;
        Ok(Self { file: Some(path.to_owned()), ..read })
    }

    /// Fails where frames of `expected` size do not match.
    pub fn check(&self, expected: Size) -> Result<(), RoiError> {
        let found = self.inside.size;
        if found == expected {
            return Ok(());
        }
        Err(RoiError::Size { file: self.file_name(), found, expected })
    }

    /// The region in frames of `size`, which are placed in the source's images: a region of the frames' size as it is,
    /// one of the source's size reduced like them. Fails where it has another size or nothing of it is left.
    pub fn of_frames(
        roi: &Arc<Self>,
        size: Size,
        placement: Option<&Placement>,
    ) -> Result<Arc<Self>, RoiError> {
        match placement {
            Some(placement) if roi.inside.size == placement.source() => {
                let reduced = Self::new(placement.frame_mask(&roi.inside));
                let reduced = reduced.ok_or_else(|| RoiError::Cropped { file: roi.file_name() })?;
                Ok(Arc::new(Self { file: roi.file.clone(), ..reduced }))
            }
            _ => roi.check(size).map(|()| Arc::clone(roi)),
        }
    }

    /// A blank and its file, or nothing.
    fn file_name(&self) -> String {
        self.file.as_ref().map_or_else(String::new, |file| format!(" {}", file.display()))
    }

    /// The region as a mask: foreground where pixels are analysed.
    pub const fn mask(&self) -> &Mask {
        &self.inside
    }

    /// Whether (x, y) is analysed; `false` outside the image.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        self.inside.is_foreground(x, y)
    }

    /// The analysed share of the image, more than 0 and up to 1.
    pub fn share(&self) -> f32 {
        self.inside.foreground_share()
    }

    /// Clears the foreground of `mask` outside the region.
    pub fn clear_outside(&self, mask: &mut Mask) {
        for (value, inside) in mask.data.iter_mut().zip(&self.inside.data) {
            *value &= inside;
        }
    }
}

/// The effect of a drawn area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Purpose {
    /// Everything outside all areas of this kind is ignored.
    Analyse,
    /// Its inside is ignored.
    Ignore,
}

/// A polygon on the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Its effect.
    pub purpose: Purpose,
    /// Its corners in order, in pixels; the last is connected to the first.
    pub corners: Vec<[f32; 2]>,
}

impl Area {
    /// Number of pixels of an image of `size` inside it.
    pub fn pixels(&self, size: Size) -> usize {
        let mut inside = Mask::empty(size);
        self.fill(&mut inside, Mask::FOREGROUND);
        inside.foreground_pixels()
    }

    /// Sets the pixels whose centres are inside to this value, by the even-odd rule.
    fn fill(&self, mask: &mut Mask, value: u8) {
        let width = mask.size.width as usize;
        let column = |x: f32| (x - 0.5).ceil().clamp(0.0, width as f32) as usize;
        let mut crossings = Vec::new();
        for (y, row) in mask.data.chunks_exact_mut(width.max(1)).enumerate() {
            let y = y as f32 + 0.5;
            let next = self.corners.iter().cycle().skip(1);
            crossings.clear();
            for ([x0, y0], [x1, y1]) in self.corners.iter().zip(next) {
                // An end belongs to the edge below it only, so that a row through a corner counts one crossing.
                if (*y0 <= y) != (*y1 <= y) {
                    crossings.push(x0 + (y - y0) / (y1 - y0) * (x1 - x0));
                }
            }
            crossings.sort_by(f32::total_cmp);
            for pair in crossings.chunks_exact(2) {
                row[column(pair[0])..column(pair[1])].fill(value);
            }
        }
    }
}

/// The region of interest of an image of `size` with these areas over `base`, or over the whole image without one.
///
/// Areas to analyse extend a base; without a base, only they are analysed. Areas to ignore override all others.
/// `None` where nothing is left.
pub fn of_areas(size: Size, base: Option<&Roi>, areas: &[Area]) -> Option<Roi> {
    let of = |purpose| areas.iter().filter(move |area| area.purpose == purpose);
    let mut inside = match base {
        Some(base) => base.inside.clone(),
        None if of(Purpose::Analyse).next().is_some() => Mask::empty(size),
        None => Mask { size, data: vec![Mask::FOREGROUND; size.pixels()] },
    };
    of(Purpose::Analyse).for_each(|area| area.fill(&mut inside, Mask::FOREGROUND));
    of(Purpose::Ignore).for_each(|area| area.fill(&mut inside, Mask::BACKGROUND));
    Roi::new(inside)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use image::{GrayImage, Luma};

    use super::*;

    const SIZE: Size = Size::new(8, 6);

    fn area(purpose: Purpose, corners: &[[f32; 2]]) -> Area {
        Area { purpose, corners: corners.to_vec() }
    }

    /// The rows of a mask as text.
    fn rows(mask: &Mask) -> Vec<String> {
        let row = |row: &[u8]| row.iter().map(|&value| if value == 255 { '#' } else { '.' }).collect();
        mask.data.chunks(mask.size.width as usize).map(row).collect()
    }

    #[test]
    fn a_polygon_contains_the_pixels_whose_centres_are_inside() {
        let mut mask = Mask::empty(SIZE);
        area(Purpose::Analyse, &[[1.0, 1.0], [7.0, 1.0], [1.0, 5.0]]).fill(&mut mask, 255);
        assert_eq!(rows(&mask), ["........", ".#####..", ".####...", ".##.....", ".#......", "........"]);
        // Compared with the definition, pixel by pixel, for a polygon that is concave and leaves the image.
        let corners = [[-3.0, 2.2], [4.1, 0.3], [9.5, 5.1], [4.0, 3.2], [2.5, 7.0]];
        let mut mask = Mask::empty(SIZE);
        area(Purpose::Analyse, &corners).fill(&mut mask, 255);
        for (y, x) in (0..6_u32).flat_map(|y| (0..8_u32).map(move |x| (y, x))) {
            let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
            let mut inside = false;
            for i in 0..5 {
                let ([x0, y0], [x1, y1]) = (corners[i], corners[(i + 1) % 5]);
                if (y0 > py) != (y1 > py) && px < (x1 - x0) * (py - y0) / (y1 - y0) + x0 {
                    inside = !inside;
                }
            }
            assert_eq!(mask.is_foreground(x, y), inside, "{x}, {y}: {:?}", rows(&mask));
        }
    }

    #[test]
    fn ignored_areas_override_analysed_areas_and_both_override_the_base() {
        let left = area(Purpose::Analyse, &[[0.0, 0.0], [4.0, 0.0], [4.0, 6.0], [0.0, 6.0]]);
        let corner = area(Purpose::Ignore, &[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        let both = of_areas(SIZE, None, &[corner.clone(), left.clone()]).unwrap();
        assert_eq!(rows(both.mask())[..3], ["..##....", "..##....", "####...."]);
        let ignored = of_areas(SIZE, None, std::slice::from_ref(&corner)).unwrap();
        assert_eq!(rows(ignored.mask())[..3], ["..######", "..######", "########"]);
        assert_eq!(corner.pixels(SIZE), 4);
        let over = of_areas(SIZE, Some(&ignored), std::slice::from_ref(&left)).unwrap();
        assert_eq!(over.share(), 1.0, "areas to analyse are added");
        let all = area(Purpose::Ignore, &[[-1.0, -1.0], [9.0, -1.0], [9.0, 9.0], [-1.0, 9.0]]);
        assert_eq!(of_areas(SIZE, None, &[left, all]), None);
    }

    #[test]
    fn bright_pixels_of_a_mask_are_analysed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        let image =
            GrayImage::from_fn(4, 2, |x, y| Luma([[0, 127, 128, 255][(x as usize + y as usize) % 4]]));
        image.save(&path).unwrap();
        let roi = Roi::read(&path).unwrap();
        assert_eq!(rows(roi.mask()), ["..##", ".##."]);
        assert!(roi.check(Size::new(4, 2)).is_ok());
        let other = roi.check(Size::new(4, 3)).unwrap_err().to_string();
        assert!(other.contains("4×2") && other.contains("4×3") && other.contains("mask.png"), "{other}");
        assert_eq!(roi, Roi::new(roi.mask().clone()).unwrap(), "equality ignores the file");
        assert_ne!(roi, Roi::new(Mask { size: roi.mask().size, data: vec![255; 8] }).unwrap());
        assert_eq!(roi.share(), 0.5);
        assert!(roi.contains(2, 0) && !roi.contains(1, 0) && !roi.contains(4, 0));
        let mut mask = Mask { size: Size::new(4, 2), data: vec![255, 0, 255, 0, 255, 255, 0, 255] };
        roi.clear_outside(&mut mask);
        assert_eq!(rows(&mask), ["..#.", ".#.."]);

        GrayImage::from_pixel(4, 2, Luma([127])).save(&path).unwrap();
        let dark = Roi::read(&path).unwrap_err().to_string();
        assert!(dark.contains("mask.png") && dark.contains("dark everywhere"), "{dark}");
        std::fs::write(&path, "no picture").unwrap();
        let broken = Roi::read(&path).unwrap_err().to_string();
        assert!(broken.contains("mask.png cannot be read"), "{broken}");
        assert!(Roi::read(&folder.path().join("none.png")).is_err());
    }
}
