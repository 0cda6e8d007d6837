//! Births: new tentative objects from detections that no object explains.

use crate::occlusion::frame_result::track_before_birth;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::ObjectTable;
use crate::tracking::Track;
use crate::tracking::pool::Blob;
use crate::tracking::seed_finder::{SeedFinder, UnexplainedDetection};

/// Starts new objects from unexplained detections of three frames. Gives their tracks in the two frames before this
/// one, with those frames' numbers.
pub(crate) fn start_objects(
    context: &Context,
    table: &mut ObjectTable,
    seeds: &mut SeedFinder,
    detections: &[Detection],
    unexplained: &[usize],
) -> Vec<(u32, Track)> {
    let candidate = |&index: &usize| {
        let detection = detections.get(index)?;
        let (observation, labels) = (detection.observation(), detection.labels.clone());
        Some(UnexplainedDetection { index, observation, labels })
    };
    let mut tracks = Vec::new();
    for seed in
        seeds.step(&context.matcher, context.periods, unexplained.iter().filter_map(candidate).collect())
    {
        let Some(detection) = detections.get(seed.index) else { continue };
        let blob = Blob::new(seed.model.clone(), &detection.observation());
        let birth = (context.recent[0], seed.earlier[0].observation.bbox);
        let new = |id| {
            // The two earlier frames; this one is counted when its blob is updated.
            let seen_frames = 2;
            Object { seen_frames, ..Object::new(id, birth, seed.model, detection.clone()) }
        };
        let id = table.start_alone(new, blob, detection.clone());
        let Some(object) = table.get(id) else { continue };
        for (frame, earlier) in context.recent.into_iter().zip(&seed.earlier) {
            // At the image edge the first visible part is often a foot or an arm.
            if !context.is_cut_off(&earlier.observation.bbox) {
                tracks.push((frame.number, track_before_birth(context, object, earlier)));
            }
        }
    }
    tracks
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{RED, context, detection, person};

    /// The table and the tracks before birth after a region at each x in successive frames.
    fn after(places: &[f32]) -> (ObjectTable, Vec<(u32, Track)>) {
        let (mut table, mut seeds, mut tracks) = (ObjectTable::default(), SeedFinder::default(), Vec::new());
        for (t, &x) in (1..).zip(places) {
            let detections = [detection(person(x, 80.0), RED)];
            tracks = start_objects(&context(t), &mut table, &mut seeds, &detections, &[0]);
        }
        (table, tracks)
    }

    #[test]
    fn three_detections_in_line_start_an_object_with_tracks_in_the_first_two_frames() {
        assert_eq!(after(&[100.0, 104.0]).0.blobs().len(), 0, "two are too few");
        let (table, tracks) = after(&[100.0, 104.0, 108.0]);
        let (id, object, _) = table.lone_objects().next().unwrap();
        assert_eq!((object.first_frame.number, object.first_bbox), (1, person(100.0, 80.0)));
        assert_eq!((object.seen_frames, object.key, object.confirmed), (2, id, false));
        let places: Vec<_> = tracks.iter().map(|(number, track)| (*number, track.bbox.x)).collect();
        assert_eq!(places, [(1, 100.0), (2, 104.0)]);
    }

    #[test]
    fn detections_that_jump_start_none() {
        assert_eq!(after(&[100.0, 112.0, 92.0]).0.blobs().len(), 0);
    }

    #[test]
    fn there_is_no_track_of_what_the_image_edge_cuts_off() {
        let (table, tracks) = after(&[0.0, 4.0, 8.0]);
        assert_eq!(table.blobs().len(), 1);
        assert_eq!(tracks.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [2]);
    }
}
