//! Updates each object's own motion and appearance from its blob's detection.

use super::member_localisation::localise_members;
use crate::occlusion::state::context::Context;
use crate::occlusion::state::decisions::Decisions;
use crate::occlusion::state::object::{Detection, Object, clamp_around};
use crate::occlusion::state::object_table::ObjectTable;
use crate::occlusion::state::perspective::Perspective;
use crate::regions::Rect;
use crate::tracking::ObjectId;
use crate::tracking::kalman::KalmanModel;

/// A group member without visible pixels for more frames than this is not kept inside its group's region.
const MAX_COAST_FRAMES: u32 = 2;
/// A region this much wider than its widest member shows its outermost members at its left and right edges.
const MIN_SPREAD_RATIO: f32 = 1.15;

/// Updates every object, and learns from the wholly visible ones how size follows the place.
pub(crate) fn update_objects(
    context: &Context,
    table: &mut ObjectTable,
    decisions: &Decisions,
    perspective: &mut Perspective,
) {
    for index in 0..table.blobs().len() {
        let Some(tracked) = table.blob(index) else { break };
        let detection = tracked.detection.clone();
        match (tracked.only_member(), detection) {
            (Some(only), None) => {
                if let Some(object) = table.get_mut(only) {
                    object.coast();
                }
            }
            (Some(only), Some(detection)) => {
                let model = tracked.blob.shown().model.clone();
                let undecided = decisions.demerges.iter().any(|demerge| demerge.is_undecided(only));
                let Some(object) = table.get_mut(only) else { continue };
                if shows_part(context, object, &detection) {
                    object.update_partial(&detection);
                    localise_members(context, table, &[only], &detection);
                } else {
                    update_whole(context, object, &model, &detection, undecided, perspective);
                }
            }
            (None, Some(detection)) => {
                let members = tracked.members().to_vec();
                constrain_to_region(table, &members, &detection.bbox);
                localise_members(context, table, &members, &detection);
            }
            (None, None) => {}
        }
    }
}

/// Whether a detection shows a part of a lone object only. What seems a part for long is taken for the whole: after
/// some frames if it moves, after more in any case.
fn shows_part(context: &Context, object: &Object, detection: &Detection) -> bool {
    let limits = &context.limits;
    !object.is_nearly_whole(detection)
        && (object.partial_frames < limits.relearn_frames
            || !object.has_moved_while_partial(detection) && object.partial_frames < limits.max_hidden_frames)
}

/// Updates a lone object with a detection of its whole. While its identity is `undecided`, its appearance stays.
fn update_whole(
    context: &Context,
    object: &mut Object,
    model: &KalmanModel,
    detection: &Detection,
    undecided: bool,
    perspective: &mut Perspective,
) {
    let cut_off = context.is_near_border(&detection.bbox);
    object.set_model(model);
    if object.partial_frames >= context.limits.relearn_frames {
        object.relearn_appearance(detection, &context.settings);
    } else if let Some(clear) = &object.appearance
        && !cut_off
    {
        let [_, y] = detection.bbox.centre();
        perspective.update(y, detection.bbox.h, clear.y, clear.h);
    }
    if undecided {
        object.seen_frames += 1;
        object.partial_frames = 0;
    } else {
        object.update_appearance(detection, cut_off, &context.settings);
    }
}

/// Keeps the predicted boxes of a group's members inside its region. Where the region is wider than its widest
/// member, its left and right edges belong to the outermost members.
fn constrain_to_region(table: &mut ObjectTable, members: &[ObjectId], region: &Rect) {
    let widest = table.objects_of(members).map(|object| object.size().0).fold(0.0, f32::max);
    let across: Vec<(f32, ObjectId)> =
        members.iter().filter_map(|&id| table.get(id).map(|object| (object.model.centre()[0], id))).collect();
    let leftmost = across.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| *id);
    let rightmost = across.iter().rev().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| *id);
    let spread = region.w > MIN_SPREAD_RATIO * widest && leftmost != rightmost;
    for &id in members {
        let Some(object) = table.get_mut(id) else { continue };
        object.seen_frames += 1;
        if object.unseen_frames > MAX_COAST_FRAMES {
            object.damp_velocity();
            continue;
        }
        let (w, h) = object.size();
        let [x, y] = object.model.centre();
        let [middle_x, middle_y] = region.centre();
        let mut centre = [
            clamp_around(middle_x, (region.w - w) / 2.0, x),
            clamp_around(middle_y, (region.h - h) / 2.0, y),
        ];
        if spread && Some(id) == leftmost {
            centre[0] = f32::midpoint(centre[0], region.x + w / 2.0);
        }
        if spread && Some(id) == rightmost {
            centre[0] = f32::midpoint(centre[0], region.right() - w / 2.0);
        }
        object.constrain_centre(centre);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{BLUE, RED, context, detection, person, start_confirmed, start_group};
    use crate::occlusion::state::context::FrameRef;
    use crate::occlusion::state::decisions::PendingDemerge;

    /// Updates a confirmed person of 20 by 60 pixels with this detection in so many frames; gives the object.
    fn updated(detection: &Detection, decisions: &Decisions, frames: u32) -> Object {
        let mut table = ObjectTable::default();
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [0.0; 2]);
        for t in 1..=frames {
            table.blob_mut(0).unwrap().detection = Some(detection.clone());
            update_objects(&context(t), &mut table, decisions, &mut Perspective::default());
        }
        table.get(id).unwrap().clone()
    }

    #[test]
    fn the_size_is_learnt_from_the_whole_and_not_from_a_part() {
        let none = Decisions::default();
        let whole = updated(&detection(Rect::new(100.0, 80.0, 22.0, 60.0), RED), &none, 1);
        assert!(whole.size().0 > 20.0 && whole.partial_frames == 0);
        let part = updated(&detection(Rect::new(100.0, 80.0, 20.0, 30.0), RED), &none, 5);
        assert_eq!((part.size(), part.partial_frames), ((20.0, 60.0), 5));
    }

    #[test]
    fn the_appearance_of_an_object_with_an_undecided_identity_stays() {
        let demerge = PendingDemerge {
            at: FrameRef { number: 1, index: 1, t: 1 },
            members: vec![1],
            region_of: vec![0],
            regions: Vec::new(),
            scores: Vec::new(),
            decided: false,
        };
        let mut decisions = Decisions::default();
        decisions.demerges.push(demerge);
        let other = detection(Rect::new(100.0, 80.0, 22.0, 60.0), BLUE);
        assert_eq!(updated(&other, &decisions, 1).size().0, 20.0);
        decisions.demerges[0].decided = true;
        assert!(updated(&other, &decisions, 1).size().0 > 20.0);
    }

    #[test]
    fn members_are_kept_inside_their_region_and_the_outermost_at_its_edges() {
        let mut table = ObjectTable::default();
        let members = start_group(&context(1), &mut table, person(60.0, 80.0), person(120.0, 80.0));
        constrain_to_region(&mut table, &members, &Rect::new(100.0, 80.0, 60.0, 60.0));
        let centre_x = |id| table.get(id).unwrap().model.centre()[0];
        // The left one is moved to the edge. The right one at 130 is moved half the way to 150.
        assert_eq!(members.map(centre_x), [110.0, 140.0]);
    }

    #[test]
    fn a_lost_object_coasts() {
        let mut table = ObjectTable::default();
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [2.0, 0.0]);
        table.blob_mut(0).unwrap().detection = None;
        update_objects(&context(2), &mut table, &Decisions::default(), &mut Perspective::default());
        assert_eq!(table.get(id).unwrap().partial_frames, 1);
    }

    #[test]
    fn what_seems_a_part_for_long_is_the_whole() {
        let context = context(2);
        let whole = detection(Rect::new(100.0, 80.0, 40.0, 60.0), RED);
        let part = detection(Rect::new(100.0, 80.0, 20.0, 60.0), RED);
        let mut known = crate::occlusion::fixtures::object(&context, 1, &whole, [0.0; 2]);
        known.appearance = Some(crate::occlusion::state::object::Appearance::new(&whole, [0.0; 2]));
        let (soon, late) = (context.limits.relearn_frames, context.limits.max_hidden_frames);
        assert!(soon < late);
        let mut shows = |frames: u32, moved: f32| {
            known.partial_frames = frames;
            known.partial_start = [known.model.centre()[0] - moved, known.model.centre()[1]];
            shows_part(&context, &known, &part)
        };
        assert_eq!([shows(0, 0.0), shows(soon - 1, 50.0), shows(soon, 50.0)], [true, true, false]);
        assert_eq!([shows(soon, 0.0), shows(late - 1, 0.0), shows(late, 0.0)], [true, true, false]);
        assert!(!shows_part(&context, &known, &whole));
    }
}
