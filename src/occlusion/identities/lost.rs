//! Blobs without a region: wait, exit, or occluded by the scene (Algorithm 2).

use crate::frame::Size;
use crate::occlusion::event::Evidence;
use crate::occlusion::events::demerges::settle_demerges_of;
use crate::occlusion::events::emission::{can_leave, emit_exit, mark_occluded};
use crate::occlusion::members::member_search::try_reidentify_in_group;
use crate::occlusion::state::context::{Context, FrameRef};
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::object::{MIN_STABLE_FRAMES, Object};
use crate::occlusion::state::object_table::{ObjectTable, TrackedBlob};
use crate::regions::Rect;
use crate::tracking::ObjectId;

/// An exiting object moves outward at least this fast, in pixels a frame; negative to allow for flicker of the mask.
const MIN_OUTWARD_SPEED: f32 = -0.2;
/// A tentative object without a region for more frames than this is noise.
const MAX_TENTATIVE_GAP_FRAMES: u32 = 2;

/// Decides about every blob without a region: wait, exit, or occluded by the scene.
pub(crate) fn resolve_lost_blobs(context: &Context, table: &mut ObjectTable, decisions: &mut Decisions) {
    for index in (0..table.blobs().len()).rev() {
        let Some(tracked) = table.blob_mut(index) else { continue };
        if tracked.detection.is_some() {
            tracked.lost_from = None;
            continue;
        }
        let now = context.now();
        let lost_from = *tracked.lost_from.get_or_insert(now);
        let frames = context.index - lost_from.index + 1;
        let (members, bbox) = (tracked.members().to_vec(), tracked.blob.bbox);
        let waits = !context.matcher.is_unfit(&tracked.blob) && !context.is_outside(&bbox);
        if !members.iter().any(|&id| table.is_confirmed(id)) {
            if frames > MAX_TENTATIVE_GAP_FRAMES {
                for id in members {
                    table.end_object(id);
                }
            }
            continue;
        }
        if waits {
            continue;
        }
        // Identities may be swapped here, so the members are read afterwards.
        for id in members {
            settle_demerges_of(context, table, decisions, id);
        }
        let members = table.members_at(&[index]);
        if !members.iter().all(|&id| can_leave(context, table, id)) {
            continue;
        }
        let exit = table.blob(index).and_then(|tracked| exit_evidence(context, table, tracked, lost_from));
        for id in members {
            if exit.is_none()
                && (try_recover_track(context, table, id, lost_from)
                    || try_reidentify_in_group(context, table, decisions, id))
            {
                continue;
            }
            decisions.group_episodes.mark_member_lost(id);
            match &exit {
                Some(evidence) => {
                    emit_exit(context, table, decisions, id, lost_from.number, evidence.clone());
                }
                None => mark_occluded(context, table, decisions, id, lost_from),
            }
        }
    }
    table.drop_empty_blobs();
}

/// Decides about every blob that was lost shortly before the end of the video: exit, or occluded where that is no
/// flicker of the mask.
pub(crate) fn resolve_lost_blobs_at_end(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &mut Decisions,
) {
    for index in (0..table.blobs().len()).rev() {
        let Some(tracked) = table.blob(index) else { continue };
        let Some(lost_from) = tracked.lost_from else { continue };
        let exit = exit_evidence(context, table, tracked, lost_from);
        let lasts = context.index - lost_from.index + 1 >= MIN_STABLE_FRAMES;
        let members = tracked.members().to_vec();
        if !members.iter().all(|&id| table.is_confirmed(id) && can_leave(context, table, id))
            || exit.is_none() && !lasts
        {
            continue;
        }
        for id in members {
            match &exit {
                Some(evidence) => {
                    emit_exit(context, table, decisions, id, lost_from.number, evidence.clone());
                }
                None => mark_occluded(context, table, decisions, id, lost_from),
            }
        }
    }
    table.drop_empty_blobs();
}

/// Recovers a lost object whose region continued as an unexplained one: a tentative object began at its place when its
/// region was lost. Merges that track into it; whether there was one.
fn try_recover_track(context: &Context, table: &mut ObjectTable, id: ObjectId, lost_from: FrameRef) -> bool {
    let Some(past) = table.get(id).filter(|object| object.confirmed) else { return false };
    let reach = past.reappearance_radius(0);
    let since = |new: &Object| new.first_frame.t.abs_diff(lost_from.t);
    let near = |new: &Object| past.predicted_box().distance_outside(&new.last_detection.bbox);
    let new = table
        .lone_objects()
        .filter(|(_, new, _)| {
            !new.confirmed && since(new) <= context.limits.max_gap_frames && near(new) <= reach
        })
        .min_by(|a, b| near(a.1).total_cmp(&near(b.1)));
    let Some((new, ..)) = new else { return false };
    table.merge_track_into(new, id);
    true
}

/// The evidence that a blob without a region has left the image, `None` if it has not.
fn exit_evidence(
    context: &Context,
    table: &ObjectTable,
    tracked: &TrackedBlob,
    lost_from: FrameRef,
) -> Option<Evidence> {
    let velocity = tracked.blob.shown().model.velocity();
    let last = table
        .objects_of(tracked.members())
        .map(|object| object.last_detection.bbox)
        .reduce(|a, b| a.union(&b))?;
    let last = if tracked.is_shared() { tracked.blob.bbox } else { last };
    let distance = last.distance_to_edge(context.size).min(tracked.blob.bbox.distance_to_edge(context.size));
    let outward = outward_speed(&last, [velocity.x, velocity.y], context.size);
    let near = distance <= context.limits.border_px;
    (near && outward >= MIN_OUTWARD_SPEED).then(|| {
        let mut evidence = Evidence::of_branch(format!(
            "no region from frame {} on; box near the image edge and not moving inward",
            lost_from.number
        ));
        evidence.at_most("distance to image edge, pixels", distance, context.limits.border_px);
        evidence.at_least("outward speed, pixels/frame", outward, MIN_OUTWARD_SPEED);
        evidence
    })
}

/// Speed of a box towards its nearest edge, in pixels a frame.
fn outward_speed(bbox: &Rect, [vx, vy]: [f32; 2], size: Size) -> f32 {
    let (width, height) = (size.width as f32, size.height as f32);
    let edges = [(bbox.x, -vx), (bbox.y, -vy), (width - bbox.right(), vx), (height - bbox.bottom(), vy)];
    edges.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, speed)| *speed)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::event::EventKind;
    use crate::occlusion::fixtures::{RED, context, person, start_confirmed, start_tentative};

    /// Lets the only blob go without a region until it is decided about; gives the frame's t and the kinds of events.
    fn lose(table: &mut ObjectTable) -> (u32, Vec<EventKind>) {
        let mut decisions = Decisions::default();
        for t in 2..40 {
            let context = context(t);
            for tracked in table.blobs_mut() {
                tracked.detection = None;
                tracked.blob.predict(1.0);
                context.matcher.match_observations(&mut [&mut tracked.blob], &[]);
            }
            resolve_lost_blobs(&context, table, &mut decisions);
            assert_eq!(table.check(), None);
            if table.blobs().is_empty() {
                return (t, decisions.events.iter().map(|event| event.kind).collect());
            }
        }
        panic!("never decided");
    }

    #[test]
    fn an_object_lost_inside_the_image_is_occluded() {
        let mut table = ObjectTable::default();
        let id = start_confirmed(&context(1), &mut table, person(150.0, 80.0), RED, [2.0, 0.0]);
        assert_eq!(lose(&mut table).1, [EventKind::Disappear]);
        assert_eq!(table.occlusion_of(id).unwrap().since, FrameRef { number: 2, index: 2, t: 2 });
    }

    #[test]
    fn an_object_lost_at_the_image_edge_while_moving_outward_exits() {
        let mut table = ObjectTable::default();
        start_confirmed(&context(1), &mut table, person(298.0, 80.0), RED, [2.0, 0.0]);
        assert_eq!(lose(&mut table).1, [EventKind::Exit]);
        assert_eq!(table.iter().count(), 0);
        // One that moves inward does not.
        start_confirmed(&context(1), &mut table, person(298.0, 80.0), RED, [-2.0, 0.0]);
        assert_eq!(lose(&mut table).1, [EventKind::Disappear]);
    }

    #[test]
    fn a_tentative_object_ends_in_the_third_frame_without_a_region() {
        let mut table = ObjectTable::default();
        start_tentative(&context(1), &mut table, person(150.0, 80.0), RED, [0.0; 2]);
        assert_eq!(lose(&mut table), (4, vec![]));
    }

    #[test]
    fn a_tentative_object_that_began_at_its_place_continues_a_lost_one() {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let known = start_confirmed(&context(1), &mut table, person(150.0, 80.0), RED, [0.0; 2]);
        let new = start_tentative(&context(3), &mut table, person(160.0, 80.0), RED, [0.0; 2]);
        let tracked = table.blob_mut(0).unwrap();
        tracked.detection = None;
        for _ in 0..10 {
            context(3).matcher.match_observations(&mut [&mut tracked.blob], &[]);
        }
        tracked.lost_from = Some(FrameRef { number: 3, index: 3, t: 3 });
        resolve_lost_blobs(&context(8), &mut table, &mut decisions);
        assert!(decisions.events.is_empty() && !table.contains(new));
        assert_eq!(table.blobs()[0].members(), [known]);
    }

    /// The kinds of the events at the end of the video, in frame `last`, of a blob lost from frame 8 on.
    fn at_end(bbox: Rect, velocity: [f32; 2], last: u32, confirmed: bool) -> Vec<EventKind> {
        let (mut table, mut decisions) = (ObjectTable::default(), Decisions::default());
        let start = if confirmed { start_confirmed } else { start_tentative };
        start(&context(1), &mut table, bbox, RED, velocity);
        let tracked = table.blob_mut(0).unwrap();
        tracked.detection = None;
        tracked.lost_from = Some(FrameRef { number: 8, index: 8, t: 8 });
        resolve_lost_blobs_at_end(&context(last), &mut table, &mut decisions);
        assert_eq!((table.check(), table.blobs().len()), (None, usize::from(decisions.events.is_empty())));
        decisions.events.iter().map(|event| event.kind).collect()
    }

    #[test]
    fn a_blob_without_a_region_at_the_end_has_left_or_is_occluded_if_it_is_no_flicker() {
        let inside = person(150.0, 80.0);
        assert_eq!(at_end(inside, [0.0; 2], 10, true), [EventKind::Disappear], "the third frame");
        assert_eq!(at_end(inside, [0.0; 2], 9, true), []);
        assert_eq!(at_end(inside, [0.0; 2], 10, false), [], "it was tentative");
        assert_eq!(at_end(person(298.0, 80.0), [2.0, 0.0], 8, true), [EventKind::Exit]);
    }

    #[test]
    fn the_outward_speed_is_that_towards_the_nearest_edge() {
        let size = Size::new(320, 240);
        let speed = |x: f32, y: f32| outward_speed(&person(x, y), [2.0, 3.0], size);
        assert_eq!(
            [speed(5.0, 90.0), speed(150.0, 6.0), speed(295.0, 90.0), speed(150.0, 172.0)],
            [-2.0, -3.0, 2.0, 3.0]
        );
        // 30 pixels from the left edge, 40 from the lower one; and the other way round.
        assert_eq!([speed(30.0, 140.0), speed(40.0, 150.0)], [-2.0, 3.0]);
        assert_eq!([speed(270.0, 140.0), speed(260.0, 150.0)], [2.0, 3.0]);
    }
}
