//! Which part of the image is analysed: a mask that was drawn elsewhere, or areas drawn over the frames.

use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageReader};

use crate::frame::{Mask, Size};

/// From this grey level on a pixel of a mask counts.
const BRIGHT: u8 = 128;

/// Why a mask cannot say what is to be analysed.
#[derive(Debug, thiserror::Error)]
pub enum RoiError {
    /// It is not there, or no picture.
    #[error(
        "the mask {path} cannot be read: {why}; give an image as large as the frames, white in the area to \
         analyse"
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// It leaves nothing.
    #[error(
        "the mask {path} is dark everywhere, so nothing would be analysed; make the area to analyse white"
    )]
    Dark {
        /// The file.
        path: PathBuf,
    },
    /// It belongs to other frames.
    #[error("the mask{file} is {found}, but the frames are {expected}; give one as large as the frames")]
    Size {
        /// A blank and the file that it was read from, or nothing.
        file: String,
        /// The mask's size.
        found: Size,
        /// The frames'.
        expected: Size,
    },
}

/// The region of interest: the pixels that are analysed. All others are background, whatever the model says.
#[derive(Clone, Debug)]
pub struct Roi {
    /// Foreground where pixels are analysed, somewhere at least.
    inside: Mask,
    /// The file that it was read from, if it was.
    file: Option<PathBuf>,
}

/// The same pixels are the same region, wherever they were read from.
impl PartialEq for Roi {
    fn eq(&self, other: &Self) -> bool {
        self.inside == other.inside
    }
}

impl Eq for Roi {}

impl Roi {
    /// The pixels that are foreground in `inside`; `None` where none is.
    pub fn new(inside: Mask) -> Option<Self> {
        (inside.foreground_pixels() > 0).then_some(Self { inside, file: None })
    }

    /// Reads a picture in which bright pixels (128 or more) are those to be analysed.
    pub fn read(path: &Path) -> Result<Self, RoiError> {
        let unreadable = |why: String| RoiError::Unreadable { path: path.to_owned(), why };
        let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
        let image = reader.map_err(|error| unreadable(error.to_string()))?.decode();
        let luma = image.map(DynamicImage::into_luma8).map_err(|error| unreadable(error.to_string()))?;
        let level = |level: &u8| if *level >= BRIGHT { Mask::FOREGROUND } else { Mask::BACKGROUND };
        let size = Size::new(luma.width(), luma.height());
        let inside = Mask { size, data: luma.as_raw().iter().map(level).collect() };
        let read = Self::new(inside).ok_or_else(|| RoiError::Dark { path: path.to_owned() })?;
        Ok(Self { file: Some(path.to_owned()), ..read })
    }

    /// Fails where frames of `expected` have other pixels than this.
    pub fn check(&self, expected: Size) -> Result<(), RoiError> {
        let found = self.inside.size;
        if found == expected {
            return Ok(());
        }
        let file = self.file.as_ref().map_or_else(String::new, |file| format!(" {}", file.display()));
        Err(RoiError::Size { file, found, expected })
    }

    /// As a mask: foreground where pixels are analysed.
    pub const fn mask(&self) -> &Mask {
        &self.inside
    }

    /// Whether (x, y) is analysed; outside the image nothing is.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        self.inside.is_foreground(x, y)
    }

    /// The share of the image that is analysed, more than 0 and up to 1.
    pub fn share(&self) -> f32 {
        self.inside.foreground_share()
    }

    /// Takes away the foreground of `mask` that is not to be analysed.
    pub fn clear_outside(&self, mask: &mut Mask) {
        for (value, inside) in mask.data.iter_mut().zip(&self.inside.data) {
            *value &= inside;
        }
    }
}

/// What an area that was drawn is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Purpose {
    /// What lies outside of all such areas is ignored.
    Analyse,
    /// What lies inside is ignored.
    Ignore,
}

/// A polygon over the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// What it is for.
    pub purpose: Purpose,
    /// Its corners in order, in pixels; the last is joined to the first.
    pub corners: Vec<[f32; 2]>,
}

impl Area {
    /// How many pixels of an image of `size` lie in it.
    pub fn pixels(&self, size: Size) -> usize {
        let mut inside = Mask::empty(size);
        self.fill(&mut inside, Mask::FOREGROUND);
        inside.foreground_pixels()
    }

    /// Gives the pixels whose centres lie in it this value. Where it overlaps itself, the even-odd rule holds.
    fn fill(&self, mask: &mut Mask, value: u8) {
        let width = mask.size.width as usize;
        let column = |x: f32| (x - 0.5).ceil().clamp(0.0, width as f32) as usize;
        let mut crossings = Vec::new();
        for (y, row) in mask.data.chunks_exact_mut(width.max(1)).enumerate() {
            let y = y as f32 + 0.5;
            let next = self.corners.iter().cycle().skip(1);
            crossings.clear();
            for ([x0, y0], [x1, y1]) in self.corners.iter().zip(next) {
                // An end counts for the edge below it alone, so that a row through a corner is crossed once.
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

/// What is analysed of an image of `size` where these areas were drawn over `base`, the whole image without one.
///
/// Areas to analyse add to a base; without one, they are all there is. Areas to ignore go over all others.
/// Fails with `None` where nothing is left.
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

    /// The rows of a mask as they are read.
    fn rows(mask: &Mask) -> Vec<String> {
        let row = |row: &[u8]| row.iter().map(|&value| if value == 255 { '#' } else { '.' }).collect();
        mask.data.chunks(mask.size.width as usize).map(row).collect()
    }

    #[test]
    fn a_polygon_holds_the_pixels_whose_centres_lie_in_it() {
        let mut mask = Mask::empty(SIZE);
        area(Purpose::Analyse, &[[1.0, 1.0], [7.0, 1.0], [1.0, 5.0]]).fill(&mut mask, 255);
        assert_eq!(rows(&mask), ["........", ".#####..", ".####...", ".##.....", ".#......", "........"]);
        // Against the definition, point by point, of one that turns inwards and leaves the image.
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
    fn areas_to_ignore_go_over_those_to_analyse_and_both_over_the_base() {
        let left = area(Purpose::Analyse, &[[0.0, 0.0], [4.0, 0.0], [4.0, 6.0], [0.0, 6.0]]);
        let corner = area(Purpose::Ignore, &[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        let both = of_areas(SIZE, None, &[corner.clone(), left.clone()]).unwrap();
        assert_eq!(rows(both.mask())[..3], ["..##....", "..##....", "####...."]);
        let ignored = of_areas(SIZE, None, std::slice::from_ref(&corner)).unwrap();
        assert_eq!(rows(ignored.mask())[..3], ["..######", "..######", "########"]);
        assert_eq!(corner.pixels(SIZE), 4);
        let over = of_areas(SIZE, Some(&ignored), std::slice::from_ref(&left)).unwrap();
        assert_eq!(over.share(), 1.0, "what is to be analysed is added");
        let all = area(Purpose::Ignore, &[[-1.0, -1.0], [9.0, -1.0], [9.0, 9.0], [-1.0, 9.0]]);
        assert_eq!(of_areas(SIZE, None, &[left, all]), None);
    }

    #[test]
    fn a_mask_is_read_by_what_is_bright_in_it() {
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
        assert_eq!(roi, Roi::new(roi.mask().clone()).unwrap(), "wherever it comes from");
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
