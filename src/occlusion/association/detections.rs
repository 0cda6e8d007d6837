//! Detections of a frame: its regions, with the fragments of one object joined.

use std::sync::Arc;

use crate::occlusion::state::context::Context;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::ObjectTable;
use crate::regions::box_index::BoxIndex;
use crate::regions::{Rect, Region};
use crate::tracking::fragments::group_fragments;

/// A region of at least this share of `track_min_area` can be a fragment of a detection.
const MIN_FRAGMENT_SHARE: f32 = 0.3;

/// The detections of a frame, from its regions and the predicted boxes of the blobs: fragments of two of these are
/// never joined.
pub(crate) fn detections(context: &Context, table: &ObjectTable, regions: &[Region]) -> Vec<Detection> {
    let fragments: Vec<Detection> = regions
        .iter()
        .filter(|region| region.shape.area as f32 >= MIN_FRAGMENT_SHARE * context.limits.min_area_px)
        .map(detection_of)
        .collect();
    let observed: Vec<(Rect, f32)> =
        fragments.iter().map(|detection| (detection.bbox, detection.area)).collect();
    let predicted: Vec<Rect> = table
        .blobs()
        .iter()
        .map(|tracked| {
            let boxes = table.objects_of(tracked.members()).map(Object::predicted_box);
            boxes.reduce(|a, b| a.union(&b)).unwrap_or(tracked.blob.bbox)
        })
        .collect();
    let index = BoxIndex::new(predicted.iter().copied());
    let owner = |(bbox, _): &(Rect, f32)| {
        let near = index.meeting(bbox).into_iter();
        let contained = near.filter_map(|at| Some((at, bbox.share_within(predicted.get(at)?))));
        contained.filter(|(_, share)| *share >= 0.5).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
    };
    let owners: Vec<Option<usize>> = observed.iter().map(owner).collect();
    let groups = group_fragments(&observed, &owners, context.settings.fragment_gap);
    let joined = groups.iter().map(|group| {
        let parts: Vec<&Detection> = group.iter().filter_map(|&index| fragments.get(index)).collect();
        Detection::join(&parts)
    });
    joined.filter(|detection| detection.area >= context.limits.min_area_px).collect()
}

fn detection_of(region: &Region) -> Detection {
    Detection {
        bbox: region.shape.bbox,
        area: region.shape.area as f32,
        histogram: region.histogram.clone(),
        labels: vec![region.label],
        mosaic: Arc::clone(&region.mosaic),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occlusion::fixtures::{BLUE, RED, context, region, start_tentative};

    /// A torso and legs with a gap at the belt.
    fn torso_and_legs() -> [Region; 2] {
        let (torso, legs) = (Rect::new(100.0, 80.0, 20.0, 28.0), Rect::new(100.0, 112.0, 20.0, 28.0));
        [region(1, torso, RED), region(2, legs, BLUE)]
    }

    #[test]
    fn two_fragments_are_one_detection_with_both_labels() {
        let found = detections(&context(1), &ObjectTable::default(), &torso_and_legs());
        let [whole] = &found[..] else { panic!("{found:?}") };
        assert_eq!((whole.bbox, whole.area), (Rect::new(100.0, 80.0, 20.0, 60.0), 2.0 * 20.0 * 28.0));
        assert_eq!(whole.labels, [1, 2]);
    }

    #[test]
    fn regions_of_two_objects_are_two_detections() {
        let (mut table, context) = (ObjectTable::default(), context(1));
        for fragment in torso_and_legs() {
            start_tentative(&context, &mut table, fragment.shape.bbox, fragment.colour, [0.0; 2]);
        }
        let labels: Vec<Vec<u32>> =
            detections(&context, &table, &torso_and_legs()).into_iter().map(|it| it.labels).collect();
        assert_eq!(labels, [[1], [2]]);
    }

    #[test]
    fn what_is_too_small_is_no_detection() {
        // 0.03 % of 320 × 240 pixels are 23 pixels.
        let small = region(1, Rect::new(100.0, 80.0, 4.0, 4.0), RED);
        assert!(detections(&context(1), &ObjectTable::default(), &[small]).is_empty());
    }
}
