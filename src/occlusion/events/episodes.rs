//! Records in which frames objects share a region, from which the inter-object episodes follow.

use crate::occlusion::state::context::Context;
use crate::occlusion::state::group_episodes::GroupEpisodes;
use crate::occlusion::state::object::Object;
use crate::occlusion::state::object_table::ObjectTable;
use crate::regions::Rect;
use crate::tracking::ObjectId;

/// From this share of one's box inside another's on, one of two members can be in front of the other.
const MIN_OVERLAP: f32 = 0.3;

/// Records which objects share a region in this frame, and closes the episodes of those that are apart.
pub(crate) fn update_group_episodes(context: &Context, table: &ObjectTable, episodes: &mut GroupEpisodes) {
    for tracked in table.blobs().iter().filter(|tracked| tracked.is_shared()) {
        let boxes: Vec<Rect> = table.objects_of(tracked.members()).map(Object::predicted_box).collect();
        let visible_share =
            |id: ObjectId| table.get(id).map_or(1.0, |object| tracked.visible_share_of(object));
        let shares: Vec<(ObjectId, f32)> =
            tracked.members().iter().map(|&id| (id, visible_share(id))).collect();
        episodes.record_sharing(&shares, context.number, context.t, has_overlap(&boxes));
    }
    episodes.close(context.t, context.limits.same_episode_frames);
}

fn has_overlap(boxes: &[Rect]) -> bool {
    boxes
        .iter()
        .enumerate()
        .any(|(index, a)| boxes.iter().skip(index + 1).any(|b| a.share_within(b) >= MIN_OVERLAP))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occlusion::fixtures::{RED, context, detection, person, start_group};

    #[test]
    fn objects_that_shared_a_region_have_one_episode_which_ends_once_they_were_apart_for_long() {
        let (mut table, mut episodes) = (ObjectTable::default(), GroupEpisodes::default());
        let members = start_group(&context(1), &mut table, person(100.0, 80.0), person(106.0, 80.0));
        // Only the red one is visible: it is in front.
        for tracked in table.blobs_mut() {
            tracked.detection = Some(detection(person(100.0, 80.0), RED));
        }
        for t in 1..=4 {
            update_group_episodes(&context(t), &table, &mut episodes);
        }
        let gap = context(1).limits.same_episode_frames;
        update_group_episodes(&context(4 + gap), &ObjectTable::default(), &mut episodes);
        assert!(episodes.contains(members[0]), "it may continue");
        update_group_episodes(&context(5 + gap), &ObjectTable::default(), &mut episodes);
        let closed = episodes.take_closed(|id| table.identity(id));
        let [episode] = &closed[..] else { panic!("{closed:?}") };
        assert_eq!((&episode.objects[..], episode.start, episode.end), (&[1, 2][..], 1, 4));
        assert_eq!((episode.front, episode.least_visible), (Some(1), 0.0));
        assert_eq!(episodes.len(), 0);
    }

    #[test]
    fn members_beside_each_other_have_nobody_in_front() {
        let (mut table, mut episodes) = (ObjectTable::default(), GroupEpisodes::default());
        start_group(&context(1), &mut table, person(100.0, 80.0), person(116.0, 80.0));
        for tracked in table.blobs_mut() {
            tracked.detection = Some(detection(person(100.0, 80.0), RED));
        }
        update_group_episodes(&context(1), &table, &mut episodes);
        episodes.close_all();
        let closed = episodes.take_closed(|id| table.identity(id));
        assert_eq!(closed.first().map(|episode| episode.front), Some(None));
    }
}
