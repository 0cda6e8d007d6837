//! Values gathered over all frames: of single pixels from the decoded frames, of pixels and regions from the record.

pub(crate) mod frame_consumer;
pub(crate) mod last_foreground;
pub(crate) mod pin_follower;
pub(crate) mod pixel_follower;
pub(crate) mod region_shares;
