//! Two-pass connected components of a mask (§VII).

use crate::frame::Size;

/// To which region each pixel belongs: its label, 0 where none, row after row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// Width and height.
    pub size: Size,
    /// A label for each pixel.
    pub data: Vec<u32>,
}
