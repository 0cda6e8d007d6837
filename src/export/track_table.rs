//! The tracks of a finished run, as the formats of other tools take them.

use serde::Deserialize;

use crate::frame::Size;
use crate::tracking::{Identity, TrackState};

/// The tracks of one video.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackTable {
    /// The name of the video.
    pub video: String,
    /// Width and height of its images, to whose pixels the boxes refer.
    pub size: Size,
    /// Frames per second.
    pub fps: f32,
    /// The number that the other tool counts as its first frame; none is lower.
    pub first: u32,
    /// The numbers of the analysed frames, ascending.
    pub frames: Vec<u32>,
    /// The distance of the analysed frames, at least 1.
    pub every: u32,
    /// The boxes by frame, then by identity.
    pub boxes: Vec<TrackBox>,
}

/// An object in one frame.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct TrackBox {
    /// The frame's number.
    pub frame: u32,
    /// The object's identity.
    pub id: Identity,
    /// Its visibility.
    pub state: TrackState,
    /// Left edge of its box, in pixels.
    pub x: f32,
    /// Upper edge.
    pub y: f32,
    /// Width.
    pub w: f32,
    /// Height.
    pub h: f32,
    /// Its visible share, 0..=1.
    pub visible_share: f32,
}

/// The category of all objects.
pub const CATEGORY: &str = "object";

impl TrackBox {
    /// Whether its box is predicted, as others or the scene occlude it.
    pub fn is_occluded(&self) -> bool {
        self.state != TrackState::Visible
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Two objects in frames 3, 5, 7 and 9; the second is occluded in frame 7 and absent from 5.
    pub(crate) fn table() -> TrackTable {
        let at = |frame: u32, id, state, x| TrackBox {
            frame,
            id,
            state,
            x,
            y: 2.25,
            w: 8.0,
            h: 16.0,
            visible_share: if state == TrackState::Visible { 1.0 } else { 0.25 },
        };
        TrackTable {
            video: "a <b> & \"c\".mp4".to_owned(),
            size: Size::new(64, 48),
            fps: 12.5,
            first: 1,
            frames: vec![3, 5, 7, 9],
            every: 2,
            boxes: vec![
                at(3, 1, TrackState::Visible, 1.5),
                at(3, 4, TrackState::Visible, 30.0),
                at(5, 1, TrackState::Visible, 2.5),
                at(7, 1, TrackState::Visible, 3.5),
                at(7, 4, TrackState::Hidden, 32.0),
                at(9, 4, TrackState::Visible, 33.0),
            ],
        }
    }
}
