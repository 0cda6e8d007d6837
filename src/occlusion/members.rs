//! The members of a group in its region, and those of whom nothing was seen, in the regions of others.

use super::assign;
use super::event::{Event, EventKind, Evidence};
use super::groups::Cause;
use super::hidden::{Return, reach};
use super::object::{Object, View};
use super::partition::held_share;
use super::placing::{self, Field, Placed};
use super::reasoner::{Carried, ObjectId, Reasoner};
use crate::settings::Switch;

/// An object of which a smaller share than this is seen in a group may not be there at all.
const UNSEEN: f32 = 0.2;
/// Who is in front changes when the other order explains the region better by so many nats.
const CLEARLY_IN_FRONT: f32 = 1.0;
/// Somebody unseen is found again in a region where at least this share of them is seen.
const FOUND_AGAIN: f32 = 0.4;

/// Existence, in nats of log odds: an object that is seen is believed in up to this.
const MAX_EXISTENCE: f32 = 4.0;
/// Nats a second that sight adds.
const EXISTENCE_GAIN: f32 = 20.0;
/// Nats a second lost while nothing is seen of an object where others can hide it.
const COVERED_LOSS: f32 = 3.0;
/// Nats a second lost while nothing is seen of it and nothing can hide it.
const UNCOVERED_LOSS: f32 = 12.0;
/// A group's region with more pixels than this multiple of all its members together says that they are not known well.
/// A third object that joined two like it unseen makes 1.5. Tried: 1.7 and 2, with the same result on people and fish.
const OVERSIZED: f32 = 1.7;
/// A region with fewer pixels than this multiple of its largest member shows one object only.
const ROOM_FOR_ONE: f32 = 1.15;

impl Reasoner {
    /// Takes in how far each member of a group is supported by its region. A member whose existence falls below even
    /// odds leaves the group and becomes a past object.
    pub(super) fn judge_members(&mut self) {
        let second = self.limits.second;
        let mut leaving: Vec<ObjectId> = Vec::new();
        for carried in &self.carried {
            let Some(view) = &carried.view else { continue };
            if let [only] = carried.members[..] {
                if let Some(object) = self.objects.get_mut(&only) {
                    object.existence = (object.existence + EXISTENCE_GAIN / second).min(MAX_EXISTENCE);
                }
                continue;
            }
            let one = self.has_room_for_one(carried, view);
            let share = |id: &ObjectId| self.share_in_group(*id, carried);
            let best = carried.members.iter().copied().max_by(|a, b| {
                let seen = |id: &ObjectId| self.objects.get(id).map_or(0.0, |object| object.seen_share);
                seen(a).total_cmp(&seen(b)).then(share(a).total_cmp(&share(b))).then(b.cmp(a))
            });
            let mut left = carried.members.len();
            for &id in &carried.members {
                let Some(object) = self.objects.get_mut(&id) else { continue };
                let seen = if one { Some(id) == best } else { object.unseen == 0 };
                let covered = held_share(&object.predicted_box(), &view.bbox) >= 0.5;
                let rate = match (seen, covered) {
                    (true, _) => EXISTENCE_GAIN,
                    (false, true) => -COVERED_LOSS,
                    (false, false) => -UNCOVERED_LOSS,
                };
                object.existence = (object.existence + rate / second).min(MAX_EXISTENCE);
                if object.existence < 0.0 && left > 1 && Some(id) != best {
                    left -= 1;
                    leaving.push(id);
                }
            }
        }
        for id in leaving {
            let place = self.objects.get(&id).map(|object| object.key);
            self.settle_splits_of(id);
            if self.objects.get(&id).map(|object| object.key) != place {
                // It changed places with another one, which is judged in the next frame.
                continue;
            }
            if !self.can_leave(id) {
                continue;
            }
            for carried in &mut self.carried {
                carried.members.retain(|member| *member != id);
            }
            self.meetings.lose(id);
            let Some(bbox) = self.objects.get(&id).map(Object::predicted_box) else { continue };
            if self.near_border(&bbox) {
                let mut evidence =
                    Evidence::of_branch("not visible in its group's region, at the image edge");
                let distance = bbox.distance_to_edge(self.size);
                evidence.at_most("distance to image edge, pixels", distance, self.limits.border);
                self.tell_exit(id, self.number, evidence);
            } else {
                self.hide(id, (self.number, self.t));
            }
        }
    }

    /// Corrects what was first seen of an object in fragments: where a group's region stays far larger than all its members,
    /// the largest of them is taken for all of it. The others then leave, as there is room for one only.
    pub(super) fn correct_sizes(&mut self) {
        for carried in &mut self.carried {
            let area = |id: &ObjectId| self.objects.get(id).map_or(0.0, Object::area);
            let Some(view) = carried.view.as_ref().filter(|_| carried.members.len() > 1) else { continue };
            let oversized = view.area > OVERSIZED * carried.members.iter().map(area).sum::<f32>();
            carried.oversized = if oversized { carried.oversized + 1 } else { 0 };
            if carried.oversized < self.limits.heads {
                continue;
            }
            let largest = carried.members.iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(b.cmp(a)));
            if let Some(object) = largest.and_then(|id| self.objects.get_mut(id)) {
                object.last = view.clone();
                object.forget_looks();
            }
        }
    }

    /// Whether a region is too small to show more than one of the objects it stands for.
    fn has_room_for_one(&self, carried: &Carried, view: &View) -> bool {
        let area = |id: &ObjectId| self.objects.get(id).map_or(0.0, Object::area);
        view.area < ROOM_FOR_ONE * carried.members.iter().map(area).fold(0.0, f32::max)
    }

    /// Moves the members of a group to where its region shows them.
    pub(super) fn place_members(&mut self, members: &[ObjectId], view: &View) {
        let Some((ids, mut placed, field)) = self.laid_out(members, view) else { return };
        let mut ids = ids;
        placing::place(&mut placed, &field);
        let mut best = placing::total(&placed, &field);
        for behind in 1..placed.len() {
            let [front, back] = placed.get(behind - 1..=behind).unwrap_or_default() else { continue };
            if !front.meets(back) {
                continue;
            }
            let mut other = placed.clone();
            other.swap(behind - 1, behind);
            placing::place(&mut other, &field);
            let total = placing::total(&other, &field);
            if total > best + CLEARLY_IN_FRONT {
                best = total;
                placed = other;
                ids.swap(behind - 1, behind);
            }
        }
        let found: Vec<(ObjectId, [f32; 2], f32)> =
            ids.into_iter().zip(placed).map(|(id, it)| (id, it.centre, it.seen)).collect();
        for (id, centre, seen) in found {
            self.sight(id, centre, seen);
        }
    }

    fn sight(&mut self, id: ObjectId, centre: [f32; 2], seen: f32) {
        let Some(object) = self.objects.get_mut(&id) else { return };
        object.seen_share = seen;
        if seen < UNSEEN {
            object.unseen += 1;
            return;
        }
        object.sight(centre, seen);
    }

    /// Some members of a region with their templates, who stands lowest in the image first: usually
    /// they are nearest. `None` while somebody's looks are not known.
    fn laid_out<'a>(
        &'a self,
        members: &[ObjectId],
        view: &View,
    ) -> Option<(Vec<ObjectId>, Vec<Placed<'a>>, Field)> {
        let boxes = self.objects_of(members).map(Object::predicted_box);
        let around = boxes.reduce(|a, b| a.union(&b))?;
        let field = Field::new(&view.mosaic, &around, self.size)?;
        let mut known: Vec<(ObjectId, Placed)> = Vec::new();
        for &id in members {
            known.push((id, placed(self.objects.get(&id)?)?));
        }
        known.sort_by(|a, b| {
            let bottom = |it: &Placed| it.centre[1] + it.size.1 / 2.0;
            bottom(&b.1).total_cmp(&bottom(&a.1))
        });
        let (ids, placed) = known.into_iter().unzip();
        Some((ids, placed, field))
    }

    /// Looks for everybody of whom nothing is seen in the regions near where they should be.
    pub(super) fn find_again(&mut self) {
        let in_groups = self.carried.iter().filter(|carried| carried.members.len() > 1);
        let unseen = in_groups.flat_map(|carried| carried.members.iter().copied());
        let long = |id: &ObjectId| self.objects.get(id).is_some_and(|object| object.unseen > 1);
        let mut missing: Vec<ObjectId> = unseen.filter(long).collect();
        missing.extend(self.hidden.iter().map(|hidden| hidden.id));
        for id in missing {
            if let Some((index, centre)) = self.region_that_shows(id) {
                self.join_again(id, index, centre);
            }
        }
    }

    /// Whether somebody whose own region is lost is seen in that of others, and joins them.
    pub(super) fn is_found_again(&mut self, id: ObjectId) -> bool {
        let named = self.objects.get(&id).is_some_and(|object| object.named);
        let place = (named && self.settings.find_again == Switch::On).then(|| self.region_that_shows(id));
        let Some((index, centre)) = place.flatten() else { return false };
        self.join_again(id, index, centre);
        true
    }

    /// The region, and the place in it, where a part that its own objects do not explain looks like
    /// this one.
    fn region_that_shows(&self, id: ObjectId) -> Option<(usize, [f32; 2])> {
        let object = self.objects.get(&id)?;
        let wide = reach(object, self.frames_unseen(id));
        let mut best: Option<(f32, usize, [f32; 2])> = None;
        for (index, carried) in self.carried.iter().enumerate() {
            let Some(view) = &carried.view else { continue };
            let named = carried.members.iter().any(|&member| self.is_named(member));
            if carried.members.contains(&id) || !named {
                continue;
            }
            if assign::outside(&object.predicted_box(), &view.bbox) > wide {
                continue;
            }
            if self.has_room_for_one(carried, view) {
                continue;
            }
            let Some((_, mut placed, field)) = self.laid_out(&carried.members, view) else { continue };
            let Some(mut last) = self::placed(object) else { continue };
            last.unsure = wide.max(last.unsure);
            let Some(start) = placing::unexplained(&placed, &field) else { continue };
            last.centre = start;
            placed.push(last);
            placing::place_last(&mut placed, &field);
            let Some(last) = placed.last() else { continue };
            if last.seen >= FOUND_AGAIN && best.is_none_or(|(most, ..)| last.seen > most) {
                best = Some((last.seen, index, last.centre));
            }
        }
        best.map(|(_, index, centre)| (index, centre))
    }

    fn frames_unseen(&self, id: ObjectId) -> u32 {
        let hidden = self.hidden.iter().find(|hidden| hidden.id == id);
        let since = hidden.map(|hidden| self.t - hidden.since.1);
        since.or_else(|| Some(self.objects.get(&id)?.unseen)).unwrap_or(0)
    }

    fn join_again(&mut self, id: ObjectId, index: usize, centre: [f32; 2]) {
        let key = self.objects.get(&id).map(|object| object.key);
        self.settle_splits_of(id);
        if self.objects.get(&id).map(|object| object.key) != key {
            // It changed places with another one, which is looked for in the next frame.
            return;
        }
        let mut evidence =
            Evidence::of_branch("object visible in a region that other objects do not fully explain");
        evidence.note("frames without detection", self.frames_unseen(id) as f32);
        self.groups.note_joining(id, Cause { frame: self.number, at: centre, evidence });
        for carried in &mut self.carried {
            carried.members.retain(|member| *member != id);
        }
        let Some(carried) = self.carried.get_mut(index) else { return };
        carried.members.push(id);
        carried.members.sort_unstable();
        let Some(object) = self.objects.get_mut(&id) else { return };
        let from = object.last.bbox;
        object.stand_at(centre);
        object.unseen = 0;
        object.partial = 0;
        let Some(at) = self.hidden.iter().position(|hidden| hidden.id == id) else { return };
        let hidden = self.hidden.remove(at);
        let Some(identity) = self.identity(id) else { return };
        let mut evidence = Evidence::of_branch(
            "occluded object visible in a region that other objects do not fully explain",
        );
        evidence.note("frames occluded", (self.t - hidden.since.1) as f32);
        let event = Event::of_one(self.number, EventKind::Reappear, identity, centre, evidence);
        self.returns.push(Return { id, since: hidden.since, t: self.t, event, from });
    }
}

/// An object where its own motion puts it, `None` while its looks are not known.
fn placed(object: &Object) -> Option<Placed<'_>> {
    let velocity = object.model.velocity();
    let speed = velocity.x.hypot(velocity.y);
    let size = object.size();
    let centre = object.model.centre();
    let unsure = 1.0 + 0.03 * size.1 + 0.3 * speed * (1 + object.unseen.min(10)) as f32;
    let template = object.template.as_ref()?;
    Some(Placed { template, size, predicted: centre, unsure, centre, seen: 0.0 })
}
