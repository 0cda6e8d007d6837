//! Comparison of rendered images with the golden images in `tests/pictures`.

use eframe::egui::Rect;
use egui_kittest::{SnapshotOptions, image_snapshot_options};
use image::RgbaImage;
use image::imageops::crop_imm;

/// Checks that an image, or its `part`, matches `tests/pictures/NAME.png`. A mismatch writes a difference image beside
/// it; `UPDATE_SNAPSHOTS=1 cargo test` replaces the golden image, which is to be reviewed before it is committed.
///
/// Only lines and text are checked this way. Tests compare displayed frames with the frame data itself.
pub(crate) fn looks_as_before(picture: &RgbaImage, part: Option<Rect>, name: &str) {
    let part = part.map(|part| {
        let [left, top] = [part.left(), part.top()].map(|edge| edge.round() as u32);
        let [width, height] = [part.width(), part.height()].map(|length| length.round() as u32);
        crop_imm(picture, left, top, width, height).to_image()
    });
    // Text is rasterised by the same code everywhere. Another renderer may round the edge of a line differently.
    let options = SnapshotOptions::new().output_path("tests/pictures").max_failed_pixels(10);
    image_snapshot_options(part.as_ref().unwrap_or(picture), name, &options);
}
