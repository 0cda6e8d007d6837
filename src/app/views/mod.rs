//! The linked views in the middle, one file each, and the tiles that arrange them.

mod agreement;
mod areas;
mod background;
mod canvas;
mod compared;
mod compose_style;
mod composer;
mod composition;
mod contents;
mod difference;
mod draw;
mod external_boxes;
mod external_masks;
mod foreground;
mod frame_uploads;
mod input;
mod layer;
mod layer_upload;
mod layouts;
mod loupe;
mod map;
mod mask_agreement;
mod mask_errors;
mod pane;
mod pins;
mod pointer;
mod ramp;
mod region_colours;
mod regions;
mod tiles;
mod title_bar;
mod tracks;
mod uploaded_frame;

#[cfg(test)]
pub(crate) use canvas::ViewCanvas;
pub(crate) use contents::pixel_value;
pub(crate) use frame_uploads::FrameUploads;
pub(crate) use layouts::{is_open, restored, set_open, tree_of};
#[cfg(test)]
pub(crate) use loupe::{picture as loupe_picture, place as loupe_place, words as loupe_words};
pub(crate) use tiles::show;
