//! Pictures as they were when they were last looked at.

use eframe::egui::Rect;
use egui_kittest::{SnapshotOptions, image_snapshot_options};
use image::RgbaImage;
use image::imageops::crop_imm;

/// Sees that what is in `part` of a picture, or all of it, looks as `tests/pictures/NAME.png` does. The difference is
/// written beside it; `UPDATE_SNAPSHOTS=1 cargo test` takes what is there now, to be looked at before it is committed.
///
/// Only what is drawn by lines and letters is held to this: pictures of frames are compared with the frames themselves.
pub(crate) fn looks_as_before(picture: &RgbaImage, part: Option<Rect>, name: &str) {
    let part = part.map(|part| {
        let [left, top] = [part.left(), part.top()].map(|edge| edge.round() as u32);
        let [width, height] = [part.width(), part.height()].map(|length| length.round() as u32);
        crop_imm(picture, left, top, width, height).to_image()
    });
    // Letters are drawn by the same code everywhere; another renderer may round the edge of a line otherwise.
    let options = SnapshotOptions::new().output_path("tests/pictures").max_failed_pixels(10);
    image_snapshot_options(part.as_ref().unwrap_or(picture), name, &options);
}
