//! Predicts blobs and objects from one frame to the next.

use crate::occlusion::state::context::Context;
use crate::occlusion::state::object_table::{ObjectTable, TrackedBlob};
use crate::occlusion::state::perspective::Perspective;
use crate::settings::Switch;
use crate::tracking::ObjectId;

/// Predicts every blob and object from the frame before to the present one. A lone object that was wholly visible has its blob's motion; the
/// others have their own.
pub(crate) fn predict(context: &Context, table: &mut ObjectTable, perspective: &Perspective) {
    for tracked in table.blobs_mut() {
        tracked.detection = None;
        tracked.blob.predict(context.periods);
    }
    let occluded: Vec<ObjectId> = table.occluded().iter().map(|occluded| occluded.id).collect();
    let (blobs, objects) = table.blobs_and_objects();
    for &id in blobs.iter().filter(|it| it.is_shared()).flat_map(TrackedBlob::members).chain(&occluded) {
        if let Some(object) = objects.get_mut(id) {
            object.predict(context.periods);
        }
    }
    for tracked in blobs.iter() {
        if let Some(object) = tracked.only_member().and_then(|id| objects.get_mut(id)) {
            if object.partial_frames > 0 {
                object.predict(context.periods);
            } else {
                object.set_model(&tracked.blob.shown().model);
            }
        }
    }
    if context.settings.perspective == Switch::On {
        for object in table.objects_mut() {
            object.update_scale(perspective);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::occlusion::fixtures::{RED, context, person, start_confirmed, start_group, start_tentative};
    use crate::occlusion::state::context::FrameRef;

    fn predict_one_frame(table: &mut ObjectTable) {
        predict(&context(2), table, &Perspective::default());
    }

    #[test]
    fn a_lone_object_follows_its_blob_and_has_no_detection_yet() {
        let mut table = ObjectTable::default();
        let id = start_tentative(&context(1), &mut table, person(100.0, 80.0), RED, [3.0, -1.0]);
        // Its blob was corrected since.
        table.blob_mut(0).unwrap().blob.keep_shown(
            &crate::occlusion::fixtures::detection(person(104.0, 80.0), RED).observation(),
            |model| model.set_centre([114.0, 110.0]),
        );
        predict_one_frame(&mut table);
        assert_eq!(table.get(id).unwrap().model.centre(), [117.0, 109.0]);
        assert!(table.blob(0).unwrap().detection.is_none());
    }

    #[test]
    fn a_partly_visible_object_continues_its_own_motion() {
        let mut table = ObjectTable::default();
        let id = start_confirmed(&context(1), &mut table, person(100.0, 80.0), RED, [3.0, 0.0]);
        table.get_mut(id).unwrap().partial_frames = 1;
        let observed = crate::occlusion::fixtures::detection(person(150.0, 80.0), RED).observation();
        table.blob_mut(0).unwrap().blob.keep_shown(&observed, |model| model.set_centre([160.0, 110.0]));
        predict_one_frame(&mut table);
        assert_eq!(table.get(id).unwrap().model.centre(), [113.0, 110.0]);
    }

    #[test]
    fn members_of_a_group_and_occluded_objects_continue_their_own_motion() {
        let (mut table, context) = (ObjectTable::default(), context(1));
        let members = start_group(&context, &mut table, person(100.0, 80.0), person(120.0, 80.0));
        let occluded = start_confirmed(&context, &mut table, person(200.0, 80.0), RED, [2.0, 0.0]);
        table.occlude(occluded, FrameRef { number: 1, index: 1, t: 1 });
        table.drop_empty_blobs();
        for id in members {
            table.get_mut(id).unwrap().model.set_velocity(nalgebra::Vector3::new(1.0, 0.0, 0.0));
        }
        predict_one_frame(&mut table);
        let centre_x = |id| table.get(id).unwrap().model.centre()[0];
        assert_eq!([members[0], members[1], occluded].map(centre_x), [111.0, 131.0, 212.0]);
    }
}
