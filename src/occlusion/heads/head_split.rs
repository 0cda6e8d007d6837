//! Splits a region with more heads than members: adds the member that entered side by side with another, or was taken
//! for lost.

use std::sync::Arc;

use super::head_count::head_columns;
use crate::occlusion::event::Evidence;
use crate::occlusion::identities::confirmation::confirm_object;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::groups::GroupChange;
use crate::occlusion::state::object::{Appearance, Detection, Object, template_of};
use crate::occlusion::state::object_table::ObjectTable;
use crate::regions::Rect;
use crate::tracking::ObjectId;
use crate::tracking::kalman::KalmanModel;

/// An appearance this much wider than the present body was learnt from two objects.
const MIN_DOUBLE_WIDTH_RATIO: f32 = 1.3;

/// What a frame with more heads than members adds to the score, and what one without subtracts. Two heads are visible
/// in about half the frames of two people who walk abreast, as arms and legs swing, and rarely for one. Tried: 1 and
/// 2, 4 and 1, 8 and 1, on 180 drawn scenes of people who mill about and on 28 real ones.
const EXTRA_HEAD_INCREMENT: u32 = 4;
const EXTRA_HEAD_DECREMENT: u32 = 1;

/// Counts the heads of every region. Where they exceed the members for long enough, adds a member.
pub(crate) fn count_heads(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    for index in 0..table.blobs().len() {
        let bodies = extra_bodies(context, table, index);
        if bodies.len() > 1 {
            assign_head(context, table, decisions, index, bodies);
        }
    }
}

/// Counts the heads of one region and updates the score of its first member by whether they exceed the visible
/// members. Gives the bodies in the region once that was so for long enough, otherwise none.
fn extra_bodies(context: &Context, table: &mut ObjectTable, index: usize) -> Vec<Detection> {
    let (blobs, objects) = table.blobs_and_objects();
    let Some(tracked) = blobs.get(index) else { return Vec::new() };
    let (Some(detection), Some(first)) = (&tracked.detection, tracked.members().first().copied()) else {
        return Vec::new();
    };
    let members = tracked.members().iter().filter_map(|&id| objects.get(id));
    let seen = members.filter(|object| object.unseen_frames == 0).count().max(1);
    let cut_off = context.is_cut_off(&detection.bbox);
    let heads = if cut_off { Vec::new() } else { head_columns(&detection.mosaic) };
    let Some(object) = objects.get_mut(first) else { return Vec::new() };
    if heads.len() <= seen || !object.confirmed {
        object.extra_head_score = object.extra_head_score.saturating_sub(EXTRA_HEAD_DECREMENT);
        return Vec::new();
    }
    object.extra_head_score += EXTRA_HEAD_INCREMENT;
    if object.extra_head_score <= EXTRA_HEAD_INCREMENT * context.limits.head_count_frames {
        return Vec::new();
    }
    object.extra_head_score = 0;
    heads.iter().filter_map(|columns| body_detection(detection, columns)).collect()
}

/// Assigns one of a region's bodies, two at least, to an unseen member, or to a new object.
fn assign_head(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
    index: usize,
    mut bodies: Vec<Detection>,
) {
    let Some(members) = table.blob(index).map(|tracked| tracked.members().to_vec()) else { return };
    let heads = bodies.len();
    let Some(free) = unexplained_body(context, table, &members, &bodies) else { return };
    let free = bodies.remove(free);
    let centre = free.bbox.centre();
    let frames_unseen = |id: &ObjectId| table.get(*id).map_or(0, |object| object.unseen_frames);
    let unseen = members.iter().copied().filter(|id| frames_unseen(id) > 0).max_by_key(frames_unseen);
    if let Some(id) = unseen {
        if let Some(object) = table.get_mut(id) {
            object.set_centre(centre);
            object.unseen_frames = 0;
        }
        return;
    }
    let Some(&first) = members.first() else { return };
    let other = if members.len() == 1 { bodies.first() } else { None };
    let Some(id) = start_companion(context, table, index, first, free, other) else { return };
    let mut evidence = Evidence::of_branch("more heads than objects in a region: one object added");
    evidence.note("heads", heads as f32);
    evidence.note("objects", members.len() as f32);
    let cause = GroupChange { frame: context.number, at: centre, evidence };
    table.groups_mut().record_joining(first, cause);
    confirm_object(context, table, decisions, id);
}

/// The index of the body that the members explain least. Both bodies of a lone object overlap it; the less similar one
/// is the new object's.
fn unexplained_body(
    context: &Context,
    table: &ObjectTable,
    members: &[ObjectId],
    bodies: &[Detection],
) -> Option<usize> {
    let objects: Vec<&Object> = table.objects_of(members).collect();
    let explained = |detection: &Detection| {
        if let [only] = objects[..] {
            return only.colour_similarity(&detection.histogram, &context.settings).0;
        }
        let seen = objects.iter().filter(|object| object.unseen_frames == 0);
        seen.map(|object| object.predicted_box().iou(&detection.bbox)).fold(0.0, f32::max)
    };
    let shares = bodies.iter().map(explained).enumerate();
    shares.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// Starts an object beside the first member of a region, with the same velocity. A lone first member that is much
/// wider than the new body was two from the start: it then continues as the `other` body alone.
fn start_companion(
    context: &Context,
    table: &mut ObjectTable,
    index: usize,
    first: ObjectId,
    body: Detection,
    other: Option<&Detection>,
) -> Option<ObjectId> {
    let known = table.get(first)?;
    let velocity = known.model.velocity();
    let other = other.filter(|_| known.size().0 >= MIN_DOUBLE_WIDTH_RATIO * body.bbox.w);
    let birth = match other {
        Some(_) => (known.first_frame, known.first_bbox),
        None => (context.now(), body.bbox),
    };
    let noise = context.matcher.noise;
    let model = |detection: &Detection| {
        KalmanModel::new(detection.observation().measurement(), velocity, noise.measurement, noise)
    };
    let appearance = |detection: &Detection| Some(Appearance::new(detection, [velocity.x, velocity.y]));
    if let Some(own) = other
        && let Some(object) = table.get_mut(first)
    {
        object.appearance = appearance(own);
        object.template = template_of(own, &context.settings);
        object.scale = 1.0;
        object.model = model(own);
        object.partial_frames = 0;
        object.last_detection = own.clone();
    }
    table.start_in_blob(index, |id| Object {
        appearance: appearance(&body),
        template: template_of(&body, &context.settings),
        ..Object::new(id, birth, model(&body), body)
    })
}

/// The detection of these columns of a region.
fn body_detection(detection: &Detection, columns: &std::ops::Range<u32>) -> Option<Detection> {
    let mosaic = detection.mosaic.part(columns);
    let bbox: Rect = mosaic.bbox()?.intersection(&detection.bbox);
    let histogram = mosaic.histogram();
    let labels = detection.labels.clone();
    Some(Detection { bbox, area: histogram.total(), histogram, labels, mosaic: Arc::new(mosaic) })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{RED, context, person, shared_detection, start_confirmed, start_group};

    /// Two heads above one wide body of 40 by 60 pixels in all.
    fn two_heads() -> Detection {
        let heads = [104.0, 124.0].map(|x| (Rect::new(x, 80.0, 12.0, 14.0), RED));
        shared_detection(&[(Rect::new(100.0, 94.0, 40.0, 46.0), RED), heads[0], heads[1]])
    }

    fn count_in_frames(table: &mut ObjectTable, decisions: &mut Decisions, frames: u32) {
        for t in 1..=frames {
            table.blob_mut(0).unwrap().detection = Some(two_heads());
            count_heads(&context(t), table, decisions);
        }
    }

    #[test]
    fn a_wide_object_with_two_heads_becomes_two_after_some_frames() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let first =
            start_confirmed(&context(1), &mut table, Rect::new(100.0, 80.0, 40.0, 60.0), RED, [0.0; 2]);
        let frames = context(1).limits.head_count_frames;
        count_in_frames(&mut table, &mut decisions, frames);
        assert_eq!(table.blobs()[0].members(), [first]);
        count_in_frames(&mut table, &mut decisions, 1);
        let members = table.blobs()[0].members();
        assert_eq!((members.len(), members[0]), (2, first));
        let widths = table.objects_of(members).map(|object| object.size().0).collect::<Vec<_>>();
        assert!(widths.iter().all(|width| *width <= 24.0), "{widths:?}");
        assert_eq!(table.check(), None);
    }

    #[test]
    fn the_second_head_is_an_unseen_member_where_there_is_one() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let [_, unseen] = start_group(&context(1), &mut table, person(100.0, 80.0), person(104.0, 80.0));
        table.get_mut(unseen).unwrap().unseen_frames = 5;
        count_in_frames(&mut table, &mut decisions, 1 + context(1).limits.head_count_frames);
        assert_eq!(table.iter().count(), 2, "no new object");
        let object = table.get(unseen).unwrap();
        assert_eq!(object.unseen_frames, 0);
        assert!((object.model.centre()[0] - 130.0).abs() <= 4.0, "{:?}", object.model.centre());
    }
}
