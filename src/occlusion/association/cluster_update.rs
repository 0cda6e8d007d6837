//! Assigns the objects of each cluster to its regions: a lone object continues, several in one region become or stay
//! an occlusion group, several in several regions are split.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::partition::{self, Cluster, Extent};
use crate::occlusion::event::Evidence;
use crate::occlusion::events::assign;
use crate::occlusion::events::demerges::{settle_before_merge, start_demerge};
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::groups::GroupChange;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::{ObjectTable, SplitPart, TrackedBlob};
use crate::occlusion::state::split_region::{AssociationScore, SplitRegion};
use crate::regions::Rect;
use crate::tracking::ObjectId;
use crate::tracking::kalman::KalmanModel;
use crate::tracking::pool::Blob;

/// Detections of one object, joined.
#[derive(Debug)]
struct JoinedDetection {
    indices: Vec<usize>,
    /// The joined detection.
    detection: Detection,
}

impl JoinedDetection {
    /// Whether it consists of the one detection that the pool matched.
    fn is_just(&self, matched: Option<usize>) -> bool {
        matches!((&self.indices[..], matched), ([only], Some(matched)) if *only == matched)
    }

    fn box_and_area(&self) -> (Rect, f32) {
        (self.detection.bbox, self.detection.area)
    }
}

/// Assigns the cluster's objects to its detections. Gives the detections that no object explains.
pub(crate) fn update_cluster(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    cluster: &Cluster,
    detections: &[Detection],
) -> Vec<usize> {
    if cluster.blobs.is_empty() || cluster.observations.is_empty() {
        return cluster.observations.clone();
    }
    let mut joined = join_detections(table, &cluster.blobs, &cluster.observations, detections);
    let blobs = &end_tentative_objects(table, &cluster.blobs, joined.len());
    let members = table.members_at(blobs);
    if blobs.len() > 1 || (joined.len() > 1 && members.len() > 1) {
        settle_before_merge(context, table, decisions, &members, joined.len());
    }
    let members = table.members_at(blobs);
    if members.len() == 1 {
        joined = join_detections(table, blobs, &cluster.observations, detections);
    }
    match (&members[..], &blobs[..], joined.len()) {
        (&[only], &[blob], _) => update_single(context, table, blob, only, joined),
        (_, _, 1) => {
            if let Some(joined) = joined.pop() {
                merge_group(context, table, blobs, &joined);
            }
            Vec::new()
        }
        _ => split_group(context, table, decisions, blobs, &members, joined),
    }
}

/// Updates a lone object with its own detection. Gives the other ones, which stay unexplained.
fn update_single(
    context: &Context,
    table: &mut ObjectTable,
    blob: usize,
    id: ObjectId,
    mut joined: Vec<JoinedDetection>,
) -> Vec<usize> {
    let Some(own) = own_detection(table, blob, &joined) else { return Vec::new() };
    let own = joined.remove(own);
    update_with_detection(context, table, blob, &own);
    let extent = extent(table, &[id]);
    let beside = joined
        .iter()
        .any(|other| partition::are_side_by_side(&own.box_and_area(), &other.box_and_area(), extent));
    if let Some(object) = table.get_mut(id) {
        object.record_side_by_side(beside);
    }
    joined.into_iter().flat_map(|other| other.indices).collect()
}

/// The detections at the indices `observations`, with the fragments of one object joined.
fn join_detections(
    table: &ObjectTable,
    blobs: &[usize],
    observations: &[usize],
    detections: &[Detection],
) -> Vec<JoinedDetection> {
    let members = table.members_at(blobs);
    let local: Vec<(usize, &Detection)> =
        observations.iter().filter_map(|&index| Some((index, detections.get(index)?))).collect();
    let observed: Vec<(Rect, f32)> =
        local.iter().map(|(_, detection)| (detection.bbox, detection.area)).collect();
    let inside = match members[..] {
        [only] => table
            .get(only)
            .zip(table.blobs_at(blobs).next())
            .map(|(object, tracked)| object.predicted_box().union(&tracked.blob.bbox)),
        _ => None,
    };
    let whole = |joined: Vec<usize>| {
        let parts = || joined.iter().filter_map(|&index| local.get(index));
        let detections: Vec<&Detection> = parts().map(|(_, detection)| *detection).collect();
        JoinedDetection {
            indices: parts().map(|(index, _)| *index).collect(),
            detection: Detection::join(&detections),
        }
    };
    partition::join_fragments(&observed, extent(table, &members), inside).into_iter().map(whole).collect()
}

/// The confirmed ones of some objects that come to share a region, or the oldest where none is confirmed. Contact of a
/// tentative object with a confirmed one is no merge.
fn confirmed_or_oldest(table: &ObjectTable, members: &[ObjectId]) -> Vec<ObjectId> {
    let confirmed: Vec<ObjectId> = members.iter().copied().filter(|&id| table.is_confirmed(id)).collect();
    if confirmed.is_empty() { members.iter().take(1).copied().collect() } else { confirmed }
}

/// Ends the tentative objects of these blobs, if there are fewer joined detections than blobs. Gives the blobs that
/// still have a member.
fn end_tentative_objects(table: &mut ObjectTable, blobs: &[usize], joined_detections: usize) -> Vec<usize> {
    if blobs.len() < 2 || joined_detections >= blobs.len() {
        return blobs.to_vec();
    }
    let members = table.members_at(blobs);
    let keep = confirmed_or_oldest(table, &members);
    for &id in members.iter().filter(|id| !keep.contains(id)) {
        table.end_object(id);
    }
    let has_members = |blob: &usize| table.blob(*blob).is_some_and(|tracked| !tracked.members().is_empty());
    blobs.iter().copied().filter(has_members).collect()
}

fn extent(table: &ObjectTable, members: &[ObjectId]) -> Extent {
    let none = Extent { w: 0.0, h: 0.0, least_area: f32::INFINITY };
    table.objects_of(members).fold(none, |extent, object| {
        let (w, h) = object.size();
        Extent { w: extent.w.max(w), h: extent.h.max(h), least_area: extent.least_area.min(object.area()) }
    })
}

/// Which joined detection belongs to a lone object: the one that contains the pool's match, else the one with the
/// greatest overlap.
fn own_detection(table: &ObjectTable, blob: usize, joined: &[JoinedDetection]) -> Option<usize> {
    let tracked = table.blob(blob)?;
    let with_match = joined.iter().position(|it| tracked.matched.is_some_and(|at| it.indices.contains(&at)));
    with_match.or_else(|| {
        let expected = table.get(*tracked.members().first()?)?.predicted_box();
        let overlaps =
            joined.iter().map(|joined| expected.intersection(&joined.detection.bbox).area()).enumerate();
        overlaps.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|(at, _)| at)
    })
}

/// Updates a blob with its detection. Where the pool matched exactly this detection its hypotheses stay; otherwise the
/// model is corrected and the competing hypotheses are dropped.
fn update_with_detection(context: &Context, table: &mut ObjectTable, blob: usize, joined: &JoinedDetection) {
    let detection = &joined.detection;
    let measured = detection.observation();
    let only = table.blob(blob).and_then(TrackedBlob::only_member);
    let whole = only.and_then(|id| table.get(id)).is_none_or(|object| object.is_nearly_whole(detection));
    let cut_off = context.is_near_border(&detection.bbox);
    let Some(tracked) = table.blob_mut(blob) else { return };
    tracked.detection = Some(detection.clone());
    if joined.is_just(tracked.matched) {
        return;
    }
    let fits = tracked.blob.shown().model.expected_measurement(0.0).distance_squared(&measured.measurement())
        <= 4.0 * context.matcher.gate;
    tracked.blob.keep_shown(&measured, |model| {
        if fits && whole && !cut_off {
            model.update(&measured.measurement(), 2.0);
        } else {
            // Only a part of it is visible, or the image edge cuts it off: the box's centre moves differently from
            // the whole, so the velocity stays at its last clear value.
            let velocity = model.velocity();
            model.restart_at(&measured.measurement());
            model.set_velocity(Vector3::new(velocity.x, velocity.y, 0.0));
        }
    });
}

/// All objects of these blobs are in one region: an occlusion group continues, or objects have merged.
fn merge_group(context: &Context, table: &mut ObjectTable, blobs: &[usize], joined: &JoinedDetection) {
    if let [only] = *blobs {
        update_with_detection(context, table, only, joined);
        return;
    }
    let detection = &joined.detection;
    let members = table.members_at(blobs);
    record_merge_cause(context, table, blobs, &members, detection);
    let model = merged_model(context, table, &members, detection);
    table.merge_blobs(blobs, Blob::new(model, &detection.observation()), detection.clone());
}

/// The model of a region that these objects come to share: it moves at their mean velocity.
fn merged_model(
    context: &Context,
    table: &ObjectTable,
    members: &[ObjectId],
    detection: &Detection,
) -> KalmanModel {
    let mean = table.objects_of(members).map(|object| object.model.velocity()).sum::<Vector3<f32>>()
        / members.len().max(1) as f32;
    let velocity = Vector3::new(mean.x, mean.y, 0.0);
    let noise = context.matcher.noise;
    KalmanModel::new(detection.observation().measurement(), velocity, noise.measurement, noise)
}

/// Records why the members of these blobs share a region.
fn record_merge_cause(
    context: &Context,
    table: &mut ObjectTable,
    blobs: &[usize],
    members: &[ObjectId],
    detection: &Detection,
) {
    let largest = |tracked: &TrackedBlob| {
        table.objects_of(tracked.members()).map(|object| object.last_detection.area).fold(0.0, f32::max)
    };
    let before: f32 = table.blobs_at(blobs).map(largest).fold(0.0, f32::max);
    let grown = detection.area / before.max(1.0) - 1.0;
    let mut evidence = Evidence::of_branch(format!(
        "{} objects with separate regions now share one of {:.0} pixels, {:+.0} % relative to the largest \
         of them",
        blobs.len(),
        detection.area,
        100.0 * grown,
    ));
    evidence.at_least("region growth", grown, context.settings.size_step);
    for &id in members {
        let Some(object) = table.get(id) else { continue };
        let contained = object.predicted_box().share_within(&detection.bbox);
        let whose = table.identity(id).unwrap_or_default();
        evidence.at_least(format!("share of the predicted box of {whose} inside the region"), contained, 0.5);
    }
    let cause = GroupChange { frame: context.number, at: detection.bbox.centre(), evidence };
    for &id in members {
        table.groups_mut().record_joining(id, cause.clone());
    }
}

/// Assigns several objects to several joined detections, and records the merges and demerges that follow. Gives the
/// detections without an object.
fn split_group(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    blobs: &[usize],
    members: &[ObjectId],
    joined: Vec<JoinedDetection>,
) -> Vec<usize> {
    let before: Vec<(usize, Vec<ObjectId>)> =
        blobs.iter().filter_map(|&blob| Some((blob, table.blob(blob)?.members().to_vec()))).collect();
    let in_group: Vec<bool> = members
        .iter()
        .map(|id| before.iter().any(|(_, group)| group.len() > 1 && group.contains(id)))
        .collect();
    let objects: Vec<&Object> = table.objects_of(members).collect();
    let position_sigmas: Vec<f32> = members
        .iter()
        .zip(&objects)
        .zip(&in_group)
        .map(|((&id, object), &group)| {
            object.position_sigma(group.then(|| decisions.group_episodes.duration_of(id, context.t)))
        })
        .collect();
    let regions: Vec<SplitRegion> = joined.iter().map(|joined| split_region(&joined.detection)).collect();
    let scores = assign::association_scores(&objects, &position_sigmas, &regions, &context.settings);
    let assigned = assign::assign_to_regions(&scores, &objects, &regions, &in_group);

    let (mut parts, mut unexplained): (Vec<(usize, SplitPart)>, Vec<usize>) = (Vec::new(), Vec::new());
    for (number, joined) in joined.into_iter().enumerate() {
        let here: Vec<ObjectId> =
            members.iter().zip(&assigned).filter(|(_, at)| **at == number).map(|(&id, _)| id).collect();
        if here.is_empty() {
            unexplained.extend(&joined.indices);
            continue;
        }
        let keep = confirmed_or_oldest(table, &here);
        for &id in here.iter().filter(|id| !keep.contains(id)) {
            table.end_object(id);
        }
        parts.push((number, split_part(context, table, keep, joined.detection)));
    }
    for (_, part) in &parts {
        let from = before.iter().filter(|(_, group)| part.members.iter().any(|id| group.contains(id)));
        let from: Vec<usize> = from.map(|(blob, _)| *blob).collect();
        if from.len() > 1 {
            record_merge_cause(context, table, &from, &part.members, &part.detection);
        }
    }
    let scores: BTreeMap<ObjectId, Vec<AssociationScore>> = members.iter().copied().zip(scores).collect();
    for (_, group) in before.iter().filter(|(_, group)| group.len() > 1) {
        start_demerge(context, table, decisions, group, &parts, &scores);
    }
    table.split_blobs(blobs, parts.into_iter().map(|(_, part)| part).collect());
    unexplained
}

/// The part of a split region with these members: a lone object keeps its own motion.
fn split_part(
    context: &Context,
    table: &ObjectTable,
    members: Vec<ObjectId>,
    detection: Detection,
) -> SplitPart {
    let observed = detection.observation();
    let alone = match members[..] {
        [only] => table.get(only).map(|object| object.model.clone()),
        _ => None,
    };
    let model = alone.map_or_else(
        || merged_model(context, table, &members, &detection),
        |mut model| {
            model.restart_at(&observed.measurement());
            model
        },
    );
    SplitPart { blob: Blob::new(model, &observed), members, detection }
}

fn split_region(detection: &Detection) -> SplitRegion {
    SplitRegion { bbox: detection.bbox, area: detection.area, histogram: detection.histogram.clone() }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::association::matching::{clusters, match_blobs};
    use crate::occlusion::fixtures::{
        BLUE, RED, context, detection, person, shared_detection, start_confirmed, start_group,
        start_tentative,
    };

    /// The members of each blob after these detections, and the unexplained ones.
    fn update(
        table: &mut ObjectTable,
        decisions: &mut Decisions,
        detections: &[Detection],
    ) -> (Vec<Vec<ObjectId>>, Vec<usize>) {
        let context = context(2);
        table.blobs_mut().for_each(|tracked| tracked.detection = None);
        match_blobs(&context, table, detections);
        let mut unexplained = Vec::new();
        for cluster in clusters(&context, table, detections) {
            unexplained.extend(update_cluster(&context, table, decisions, &cluster, detections));
        }
        table.drop_empty_blobs();
        (table.blobs().iter().map(|tracked| tracked.members().to_vec()).collect(), unexplained)
    }

    #[test]
    fn a_lone_object_gets_the_fragments_that_an_occluder_leaves() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let halves = [
            detection(Rect::new(100.0, 80.0, 8.0, 60.0), RED),
            detection(Rect::new(112.0, 80.0, 8.0, 60.0), RED),
        ];
        let (members, unexplained) = update(&mut table, &mut decisions, &halves);
        assert_eq!((members, unexplained), (vec![vec![id]], vec![]));
        assert_eq!(table.blobs()[0].detection.as_ref().unwrap().bbox, person(100.0, 80.0));
    }

    #[test]
    fn a_detection_elsewhere_stays_unexplained() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let detections = [detection(person(240.0, 80.0), BLUE), detection(person(102.0, 80.0), RED)];
        assert_eq!(update(&mut table, &mut decisions, &detections), (vec![vec![id]], vec![0]));
    }

    #[test]
    fn two_confirmed_objects_in_one_detection_become_a_group_with_a_cause() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let [a, b] = [(100.0, RED), (126.0, BLUE)]
            .map(|(x, colour)| start_confirmed(&context(1), &mut table, person(x, 80.0), colour, [0.0; 2]));
        let shared = [shared_detection(&[(person(104.0, 80.0), RED), (person(122.0, 80.0), BLUE)])];
        assert_eq!(update(&mut table, &mut decisions, &shared).0, [[a, b]]);
        let cause = table.groups().cause_of_joining(&[a]).unwrap();
        assert!(cause.evidence.branch.starts_with("2 objects with separate regions"), "{cause:?}");
    }

    #[test]
    fn a_tentative_object_in_the_region_of_a_confirmed_one_ends() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let confirmed = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        let tentative = start_tentative(&context(1), &mut table, person(126.0, 80.0), BLUE, [0.0; 2]);
        let shared = [shared_detection(&[(person(104.0, 80.0), RED), (person(122.0, 80.0), BLUE)])];
        assert_eq!(update(&mut table, &mut decisions, &shared).0, [[confirmed]]);
        assert!(!table.contains(tentative));
    }

    #[test]
    fn the_members_of_a_split_group_are_assigned_by_their_colours() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let [red, blue] = start_group(&context(1), &mut table, person(130.0, 80.0), person(150.0, 80.0));
        // They have crossed.
        let detections = [detection(person(116.0, 80.0), BLUE), detection(person(164.0, 80.0), RED)];
        let (members, _) = update(&mut table, &mut decisions, &detections);
        assert_eq!(members.len(), 2);
        let place = |id| table.blob(table.blob_of(id).unwrap()).unwrap().blob.bbox;
        assert_eq!([place(red), place(blue)], [person(164.0, 80.0), person(116.0, 80.0)]);
        assert_eq!(decisions.demerges[0].members, [red, blue]);
        assert!(decisions.demerges[0].is_undecided(red), "they are observed for some frames first");
        assert_eq!(table.check(), None);
    }
}
