//! Association of blobs and detections: the pool's joint matching, clusters of blobs and detections that interact,
//! and sudden manoeuvres.

use super::partition::{self, Cluster, ExpectedRegion};
use crate::occlusion::state::context::Context;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::{ObjectTable, TrackedBlob};
use crate::regions::Rect;
use crate::tracking::pool::{Blob, HypothesisMatcher, Observation};

/// Matches blobs to detections by the pool's joint matching.
pub(crate) fn match_blobs(context: &Context, table: &mut ObjectTable, detections: &[Detection]) {
    let observations: Vec<Observation> = detections.iter().map(Detection::observation).collect();
    let mut blobs: Vec<&mut Blob> = table.blobs_mut().map(|tracked| &mut tracked.blob).collect();
    let matched = context.matcher.match_observations(&mut blobs, &observations);
    for (tracked, matched) in table.blobs_mut().zip(matched) {
        tracked.matched = matched;
    }
}

/// The clusters of blobs and detections that interact in this frame.
pub(crate) fn clusters(context: &Context, table: &ObjectTable, detections: &[Detection]) -> Vec<Cluster> {
    let expected: Vec<ExpectedRegion> =
        table.blobs().iter().map(|tracked| expected_region(table, tracked)).collect();
    let observed: Vec<(Rect, f32)> =
        detections.iter().map(|detection| (detection.bbox, detection.area)).collect();
    partition::clusters(&expected, &observed, context.settings.size_step)
}

/// The region that a blob's members would have.
fn expected_region(table: &ObjectTable, tracked: &TrackedBlob) -> ExpectedRegion {
    let members = table.objects_of(tracked.members());
    let predicted = members.clone().map(Object::predicted_box).reduce(|a, b| a.union(&b));
    let predicted = predicted.unwrap_or(tracked.blob.bbox);
    ExpectedRegion {
        bbox: match (tracked.is_shared(), tracked.matched) {
            (false, None) => predicted,
            _ => tracked.blob.bbox.union(&predicted),
        },
        area: members.map(Object::area).fold(0.0, f32::max),
        matched: tracked.matched,
        group: tracked.is_shared(),
    }
}

/// Matches lone objects that are lost in this frame to unexplained detections within reach of a manoeuvre. Gives the
/// detections that stay unexplained. After a gap in time, the reach would be everywhere: nothing is matched.
pub(crate) fn match_manoeuvred_blobs(
    context: &Context,
    table: &mut ObjectTable,
    detections: &[Detection],
    mut unexplained: Vec<usize>,
) -> Vec<usize> {
    if context.periods > context.limits.max_gap_frames as f32 {
        return unexplained;
    }
    let is_lost = |tracked: &&mut TrackedBlob| tracked.detection.is_none() && !tracked.is_shared();
    let mut lost: Vec<&mut TrackedBlob> = table.blobs_mut().filter(is_lost).collect();
    let free: Vec<(usize, &Detection, Observation)> = unexplained
        .iter()
        .filter_map(|&index| {
            let detection = detections.get(index)?;
            Some((index, detection, detection.observation()))
        })
        .collect();
    let blobs: Vec<&Blob> = lost.iter().map(|tracked| &tracked.blob).collect();
    let observations: Vec<&Observation> = free.iter().map(|(.., observed)| observed).collect();
    let mut matched = Vec::new();
    for (row, column) in context.matcher.match_manoeuvres(&blobs, &observations) {
        let (Some(tracked), Some((index, detection, observed))) = (lost.get_mut(row), free.get(column))
        else {
            continue;
        };
        HypothesisMatcher::update_after_manoeuvre(&mut tracked.blob, observed);
        tracked.detection = Some(Detection::clone(detection));
        matched.push(*index);
    }
    unexplained.retain(|index| !matched.contains(index));
    unexplained
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::occlusion::fixtures::{
        BLUE, RED, context, detection, person, shared_detection, start_tentative,
    };

    /// Two people at x = 100 and 160, matched to the detections.
    fn matched_to(detections: &[Detection]) -> ObjectTable {
        let (mut table, context) = (ObjectTable::default(), context(2));
        for (x, colour) in [(100.0, RED), (160.0, BLUE)] {
            start_tentative(&context, &mut table, person(x, 80.0), colour, [0.0; 2]);
        }
        table.blobs_mut().for_each(|tracked| tracked.detection = None);
        match_blobs(&context, &mut table, detections);
        table
    }

    #[test]
    fn each_blob_is_matched_to_the_detection_near_it() {
        let detections = [detection(person(162.0, 80.0), BLUE), detection(person(98.0, 80.0), RED)];
        let table = matched_to(&detections);
        let matched: Vec<Option<usize>> = table.blobs().iter().map(|tracked| tracked.matched).collect();
        assert_eq!(matched, [Some(1), Some(0)]);
        let of =
            |blob: usize, observation: usize| Cluster { blobs: vec![blob], observations: vec![observation] };
        assert_eq!(clusters(&context(2), &table, &detections), [of(0, 1), of(1, 0)]);
    }

    #[test]
    fn two_objects_in_one_detection_are_one_cluster() {
        let shared = [shared_detection(&[(person(102.0, 80.0), RED), (person(158.0, 80.0), BLUE)])];
        let table = matched_to(&shared);
        let all = Cluster { blobs: vec![0, 1], observations: vec![0] };
        assert_eq!(clusters(&context(2), &table, &shared), [all]);
    }

    #[test]
    fn a_lost_object_is_matched_to_an_unexplained_detection_within_reach_of_a_manoeuvre() {
        let detections = [detection(person(100.0, 100.0), RED), detection(person(260.0, 80.0), BLUE)];
        let mut table = matched_to(&[]);
        let rest = match_manoeuvred_blobs(&context(2), &mut table, &detections, vec![0, 1]);
        assert_eq!(rest, [1], "too far for a manoeuvre");
        let boxes: Vec<Option<Rect>> =
            table.blobs().iter().map(|tracked| tracked.detection.as_ref().map(|it| it.bbox)).collect();
        assert_eq!(boxes, [Some(person(100.0, 100.0)), None]);
    }
}
