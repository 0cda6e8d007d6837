//! Localises the members of a group within its region.

use super::localisation::{self, Field, LocalisedObject};
use crate::occlusion::state::context::Context;
use crate::occlusion::state::object::{Detection, Object};
use crate::occlusion::state::object_table::ObjectTable;
use crate::tracking::ObjectId;

/// A member with a smaller visible share than this counts as unseen.
const MIN_VISIBLE_SHARE: f32 = 0.2;
/// The depth order of two members changes when the other order explains the region better by this many nats.
const MIN_ORDER_GAIN_NATS: f32 = 1.0;

/// Localises the members of a group within its region and updates their positions; a lone object in a region that
/// shows a part of it likewise. While a member has no template, none is localised.
pub(super) fn localise_members(
    context: &Context,
    table: &mut ObjectTable,
    members: &[ObjectId],
    detection: &Detection,
) {
    let Some((mut ids, mut localised, field)) = localisation_inputs(context, table, members, detection)
    else {
        return;
    };
    localisation::localise(&mut localised, &field);
    let mut best = localisation::log_likelihood(&localised, &field);
    for behind in 1..localised.len() {
        let [front, back] = localised.get(behind - 1..=behind).unwrap_or_default() else { continue };
        if !front.overlaps(back) {
            continue;
        }
        let mut other = localised.clone();
        other.swap(behind - 1, behind);
        localisation::localise(&mut other, &field);
        let total = localisation::log_likelihood(&other, &field);
        if total > best + MIN_ORDER_GAIN_NATS {
            best = total;
            localised = other;
            ids.swap(behind - 1, behind);
        }
    }
    let places: Vec<(ObjectId, [f32; 2], f32)> =
        ids.into_iter().zip(localised).map(|(id, it)| (id, it.centre, it.visible_share)).collect();
    for (id, centre, visible_share) in places {
        if let Some(object) = table.get_mut(id) {
            update_position(object, centre, visible_share);
        }
    }
}

fn update_position(object: &mut Object, centre: [f32; 2], visible_share: f32) {
    object.visible_share_in_group = visible_share;
    if visible_share < MIN_VISIBLE_SHARE {
        object.unseen_frames += 1;
    } else {
        object.update_position(centre, visible_share);
    }
}

/// Inputs of the localisation of some members, the lowest in the image first, as it is usually the nearest. `None`
/// while a member has no template.
pub(super) fn localisation_inputs<'a>(
    context: &Context,
    table: &'a ObjectTable,
    members: &[ObjectId],
    detection: &Detection,
) -> Option<(Vec<ObjectId>, Vec<LocalisedObject<'a>>, Field)> {
    let boxes = members.iter().filter_map(|&id| table.get(id)).map(Object::predicted_box);
    let around = boxes.reduce(|a, b| a.union(&b))?;
    let field = Field::new(&detection.mosaic, &around, context.size)?;
    let mut inputs: Vec<(ObjectId, LocalisedObject)> = Vec::new();
    for &id in members {
        inputs.push((id, localisation_input(table.get(id)?)?));
    }
    inputs.sort_by(|a, b| {
        let bottom = |it: &LocalisedObject| it.centre[1] + it.size.1 / 2.0;
        bottom(&b.1).total_cmp(&bottom(&a.1))
    });
    let (ids, localised) = inputs.into_iter().unzip();
    Some((ids, localised, field))
}

/// The localisation input of an object at its predicted place, `None` without a template.
pub(super) fn localisation_input(object: &Object) -> Option<LocalisedObject<'_>> {
    let velocity = object.model.velocity();
    let speed = velocity.x.hypot(velocity.y);
    let size = object.size();
    let centre = object.model.centre();
    let position_sigma = 1.0 + 0.03 * size.1 + 0.3 * speed * (1 + object.unseen_frames.min(10)) as f32;
    let template = object.template.as_ref()?;
    Some(LocalisedObject { template, size, predicted: centre, position_sigma, centre, visible_share: 0.0 })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::occlusion::fixtures::{
        BLUE, RED, context, person, shared_detection, start_confirmed, start_group,
    };
    use crate::regions::Rect;

    #[test]
    fn members_are_localised_where_their_colours_are() {
        let (mut table, context) = (ObjectTable::default(), context(2));
        let members = start_group(&context, &mut table, person(100.0, 80.0), person(130.0, 80.0));
        // Both are farther left than predicted.
        let seen = shared_detection(&[(person(94.0, 80.0), RED), (person(122.0, 80.0), BLUE)]);
        for id in members {
            table.get_mut(id).unwrap().unseen_frames = 1;
        }
        localise_members(&context, &mut table, &members, &seen);
        for (id, (predicted, visible)) in members.into_iter().zip([(110.0, 104.0), (140.0, 132.0)]) {
            let object = table.get(id).unwrap();
            let [x, y] = object.model.centre();
            assert!(x > visible - 1.0 && x < predicted - 1.0, "between both: {x}");
            assert!((y - 110.0).abs() < 1.5, "{y}");
            assert_eq!(object.unseen_frames, 0);
        }
    }

    #[test]
    fn a_member_that_is_not_visible_is_not_moved() {
        let (mut table, context) = (ObjectTable::default(), context(2));
        let [red, blue] = start_group(&context, &mut table, person(100.0, 80.0), person(104.0, 80.0));
        let seen = shared_detection(&[(person(100.0, 80.0), RED)]);
        localise_members(&context, &mut table, &[red, blue], &seen);
        let (red, blue) = (table.get(red).unwrap(), table.get(blue).unwrap());
        assert_eq!((red.unseen_frames, blue.unseen_frames), (0, 1));
        assert_eq!(blue.model.centre(), [114.0, 110.0]);
    }

    #[test]
    fn a_place_is_the_less_certain_the_larger_faster_and_longer_unseen_a_member_is() {
        let (mut table, context) = (ObjectTable::default(), context(2));
        let id = start_confirmed(&context, &mut table, person(100.0, 80.0), RED, [3.0, 4.0]);
        let object = table.get_mut(id).unwrap();
        let sigmas = [0, 3, 10, 30].map(|unseen_frames| {
            object.unseen_frames = unseen_frames;
            localisation_input(object).unwrap().position_sigma
        });
        let expected = [1.0, 4.0, 11.0, 11.0].map(|frames| 2.8 + 1.5 * frames);
        assert!(sigmas.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{sigmas:?}");
    }

    #[test]
    fn the_lowest_member_is_the_first() {
        let (mut table, context) = (ObjectTable::default(), context(2));
        let red = Rect::new(100.0, 80.0, 20.0, 60.0);
        // Its foot is lower, though its centre is higher; and the other way round.
        for (blue, first) in
            [(Rect::new(130.0, 60.0, 20.0, 90.0), 1), (Rect::new(130.0, 45.0, 20.0, 90.0), 0)]
        {
            let members = start_group(&context, &mut table, red, blue);
            let seen = shared_detection(&[(red, RED), (blue, BLUE)]);
            let (ids, ..) = localisation_inputs(&context, &table, &members, &seen).unwrap();
            assert_eq!(ids[0], members[first]);
        }
    }

    #[test]
    fn the_order_in_depth_is_the_one_that_explains_the_region() {
        let context = context(2);
        let (left, right) = (person(100.0, 80.0), person(110.0, 80.0));
        for blue_in_front in [true, false] {
            let mut table = ObjectTable::default();
            let [red, blue] = start_group(&context, &mut table, left, right);
            let (red_width, blue_from) = if blue_in_front { (10.0, 110.0) } else { (20.0, 120.0) };
            let seen = shared_detection(&[
                (Rect::new(100.0, 80.0, red_width, 60.0), RED),
                (Rect::new(blue_from, 80.0, 130.0 - blue_from, 60.0), BLUE),
            ]);
            for members in [[red, blue], [blue, red]] {
                localise_members(&context, &mut table, &members, &seen);
                let share = |id: ObjectId| table.get(id).unwrap().visible_share_in_group;
                let (front, behind) = if blue_in_front { (blue, red) } else { (red, blue) };
                let shares = (share(front), share(behind));
                assert!(shares.0 > 0.75 && (0.3..0.8).contains(&shares.1), "{blue_in_front} {shares:?}");
            }
        }
    }
}
