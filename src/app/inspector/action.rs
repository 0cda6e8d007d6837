//! The actions that the inspector requests of the window.

use super::plot::{Format, Plot};
use super::table::Table;
use crate::explain::tuning::TunableSetting;

/// An action that the inspector requests of the window.
#[derive(Clone, Debug, PartialEq)]
pub enum InspectorAction {
    /// Show the frame at this position of the sequence, from 0.
    GoTo(u32),
    /// Apply these values of these settings.
    Apply([(TunableSetting, f32); 2]),
    /// Choose this pixel.
    Choose((u32, u32)),
    /// Pin the chosen pixel, or unpin it.
    Pin,
    /// Unpin the pixel of this number.
    Unpin(u8),
    /// Choose a folder of ground truth.
    LoadTruth,
    /// Copy the numbers behind a plot to the clipboard.
    Copy(Table),
    /// Write them to a file.
    Save(Table),
    /// Copy a plot to the clipboard as an image.
    CopyPicture(Box<Plot>),
    /// Write it to a file.
    SavePicture(Box<Plot>, Format),
}
