//! Options of a source.

use std::num::NonZeroU32;

use serde::{Deserialize, Serialize};

use super::Levels;
use crate::placement::Crop;

/// The accepted range of scales; 1 keeps the size.
pub const SCALE_RANGE: (f32, f32) = (0.01, 1.0);

/// Options of a source besides its name: how it is read. They belong to the input and are not settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    /// Frames per second, in place of the source's own rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fps: Option<f32>,
    /// Whether the two fields of each frame of a video file are made into one picture of a single time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub deinterlace: bool,
    /// The index of the stream of a video file, in place of the one that the `ffmpeg` program selects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<u32>,
    /// The stored values of images that become 0 and 255, in place of the ends of the range of their type.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<Levels>,
    /// The factor by which images are reduced in width and height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f32>,
    /// The distance of the frames that are read: the first, and each `every`-th after it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<NonZeroU32>,
    /// The part of the images that is read, before scaling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crop: Option<Crop>,
}

impl Options {
    /// The source is read as it is.
    pub const AS_IS: Self = Self {
        fps: None,
        deinterlace: false,
        stream: None,
        levels: None,
        scale: None,
        every: None,
        crop: None,
    };

    /// Whether the source is read as it is.
    pub fn is_default(&self) -> bool {
        *self == Self::AS_IS
    }

    /// Whether every value is within its range, which a file can violate.
    pub fn is_valid(&self) -> bool {
        let (least, greatest) = super::FPS_RANGE;
        self.fps.is_none_or(|fps| (least..=greatest).contains(&fps))
            && self.levels.is_none_or(Levels::is_valid)
            && self.scale.is_none_or(is_scale)
            && self.crop.is_none_or(|crop| crop.width > 0 && crop.height > 0)
    }

    /// The flag of an option that only video files have, if one is given.
    pub(super) fn flag_of_videos(&self) -> Option<&'static str> {
        let flags = [("--deinterlace", self.deinterlace), ("--stream", self.stream.is_some())];
        flags.into_iter().find(|(_, is_given)| *is_given).map(|(flag, _)| flag)
    }
}

/// Whether a scale is within [`SCALE_RANGE`].
fn is_scale(scale: f32) -> bool {
    let (least, greatest) = SCALE_RANGE;
    (least..=greatest).contains(&scale)
}

/// Parses a scale; `None` where the text is not a number within [`SCALE_RANGE`].
pub fn parse_scale(text: &str) -> Option<f32> {
    text.trim().parse().ok().filter(|&scale| is_scale(scale))
}

/// Parses a crop from `X,Y,W,H`; `None` where the text is not that, or the crop is empty.
pub fn parse_crop(text: &str) -> Option<Crop> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers?[..] {
        [x, y, width, height] if width > 0 && height > 0 => Some(Crop { x, y, width, height }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_values_within_their_ranges_are_accepted() {
        assert_eq!(
            ["0.5", " 1 ", "0.01", "1e-2"].map(parse_scale),
            [Some(0.5), Some(1.0), Some(0.01), Some(0.01)]
        );
        assert_eq!(["0", "1.1", "-0.5", "nan", "half", "", "0.005"].map(parse_scale), [None; 7]);
        let crop = Crop { x: 1, y: 2, width: 30, height: 40 };
        assert_eq!(["1,2,30,40", " 1, 2 ,30,40"].map(parse_crop), [Some(crop); 2]);
        assert_eq!(
            ["1,2,3", "1,2,3,0", "1,2,0,4", "-1,2,3,4", "1,2,3,4,5", "a,b,c,d", ""].map(parse_crop),
            [None; 7]
        );
        let valid = Options { scale: Some(0.5), crop: Some(crop), ..Options::default() };
        assert!(valid.is_valid() && !Options { scale: Some(f32::NAN), ..valid }.is_valid());
        assert!(!Options { crop: Some(Crop { width: 0, ..crop }), ..valid }.is_valid());
    }
}
