//! Options of a source.

use serde::{Deserialize, Serialize};

/// Options of a source besides its name: how it is read. They belong to the input and are not settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    /// Frames per second, in place of the source's own rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fps: Option<f32>,
}

impl Options {
    /// Whether the source is read as it is.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether every value is within its range, which a file can violate.
    pub fn is_valid(&self) -> bool {
        let (least, greatest) = super::FPS_RANGE;
        self.fps.is_none_or(|fps| (least..=greatest).contains(&fps))
    }
}
