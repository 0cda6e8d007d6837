//! Output files: one module per format, each from data to bytes.
//!
//! Writers take the data and an output stream; with [`Staging`] files appear under their names only when they are
//! complete.

pub mod annotate;
pub mod canvas;
pub mod episodes_csv;
pub mod events_jsonl;
pub mod figure;
pub mod number;
pub mod picture;
pub mod picture_queue;
pub mod pixel_csv;
pub mod regions_csv;
pub mod shares_csv;
pub mod staging;
pub mod statistics_csv;
pub mod summary;
pub mod tracks_csv;
pub mod tracks_json;
pub mod tuning_csv;
pub mod video;

pub use staging::Staging;

use crate::tracking::Identity;

/// Several identities in one table cell: `3+5`.
fn joined(identities: &[Identity]) -> String {
    identities.iter().map(Identity::to_string).collect::<Vec<_>>().join("+")
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::Arc;

    use crate::regions::Rect;
    use crate::tracking::{Identity, Track, TrackState};

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
