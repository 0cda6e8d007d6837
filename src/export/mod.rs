//! Output files: one module per format, each from data to bytes.
//!
//! Writers take the data and an output stream; with [`Staging`] files appear under their names only when they are
//! complete.

pub mod annotate;
pub mod canvas;
pub mod categories_csv;
pub mod coco_json;
pub mod cvat_xml;
pub mod episodes_csv;
pub mod events_jsonl;
pub mod figure;
pub mod heat_map;
pub mod label_image;
pub mod model_npz;
pub mod mot_zip;
pub mod npy;
pub mod number;
pub mod picture;
pub mod picture_queue;
pub mod pixel_csv;
pub mod regions_csv;
pub mod report;
pub mod shares_csv;
pub mod single_file;
pub mod source_pixels;
mod staged_path;
pub mod staging;
pub mod statistics_csv;
pub mod summary;
pub mod sweep_csv;
pub mod track_table;
pub mod tracks_csv;
pub mod tracks_json;
pub mod tuning_csv;
pub mod video;
pub mod write_failure;
pub mod zip;

pub use single_file::SingleFile;
pub use staging::Staging;

use crate::tracking::Identity;

/// Several identities in one table cell: `3+5`.
fn joined(identities: &[Identity]) -> String {
    identities.iter().map(Identity::to_string).collect::<Vec<_>>().join("+")
}

/// The columns of a value with this number of channels: `mean_r,mean_g,mean_b`, or `mean` for one.
fn channel_columns(name: &str, channels: usize) -> String {
    match channels {
        3 => format!("{name}_r,{name}_g,{name}_b"),
        _ => name.to_owned(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io;
    use std::sync::Arc;

    use crate::regions::Rect;
    use crate::tracking::{Identity, Track, TrackState};

    /// What `write` writes, as text.
    pub(crate) fn written(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> String {
        let mut bytes = Vec::new();
        write(&mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    /// A visible object of 8 × 16 pixels with its upper left corner at (x, y).
    pub(crate) fn track(id: Identity, x: f32, y: f32) -> Track {
        let bbox = Rect::new(x, y, 8.0, 16.0);
        Track {
            key: id,
            id,
            state: TrackState::Visible,
            bbox,
            centre: bbox.centre(),
            velocity: [1.0, 0.0],
            scale: 11.0,
            gate: [5.0, 5.0, 0.0],
            fitness: 1.0,
            hypotheses: Arc::default(),
            visible_share: 1.0,
            colours: vec![[200, 10, 10]],
            regions: vec![1],
            group: Vec::new(),
        }
    }
}
