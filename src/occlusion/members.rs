//! Localisation and existence of group members, and re-identification of unseen ones in the regions of others.

use super::assign;
use super::event::{Event, EventKind, Evidence};
use super::groups::GroupChange;
use super::localisation::{self, Field, LocalisedObject};
use super::object::{Detection, Object};
use super::occluded::{PendingReappearance, reappearance_radius};
use super::partition::contained_share;
use super::tracker::{ObjectId, TrackedBlob, Tracker};
use crate::settings::Switch;

/// A member with a smaller visible share than this counts as unseen.
const MIN_VISIBLE_SHARE: f32 = 0.2;
/// The depth order of two members changes when the other order explains the region better by this many nats.
const MIN_ORDER_GAIN_NATS: f32 = 1.0;
/// An unseen object is re-identified in a region where at least this share of it is visible.
const MIN_REIDENTIFIED_SHARE: f32 = 0.4;

/// Upper limit of the log odds of existence.
const MAX_EXISTENCE_NATS: f32 = 4.0;
/// Gain of log odds a second while visible.
const EXISTENCE_GAIN_NATS_PER_SECOND: f32 = 20.0;
/// Loss of log odds a second while unseen inside the group's region, where others can hide it.
const COVERED_LOSS_NATS_PER_SECOND: f32 = 3.0;
/// Loss of log odds a second while unseen outside the group's region.
const UNCOVERED_LOSS_NATS_PER_SECOND: f32 = 12.0;
/// A group's region of more pixels than this multiple of all its members together indicates wrong sizes. A third
/// object that joined two like it unseen makes 1.5. Tried: 1.7 and 2, with the same result on people and fish.
const MAX_AREA_RATIO: f32 = 1.7;
/// A region of fewer pixels than this multiple of its largest member shows one object only.
const MAX_SINGLE_AREA_RATIO: f32 = 1.15;

impl Tracker {
    /// Updates the existence of each group member by its visibility. A member below even odds leaves the group and
    /// becomes occluded, or exits.
    pub(super) fn update_member_existence(&mut self) {
        let second = self.limits.fps;
        let mut leaving: Vec<ObjectId> = Vec::new();
        for tracked in &self.blobs {
            let Some(detection) = &tracked.detection else { continue };
            if let [only] = tracked.members[..] {
                if let Some(object) = self.objects.get_mut(&only) {
                    object.existence =
                        (object.existence + EXISTENCE_GAIN_NATS_PER_SECOND / second).min(MAX_EXISTENCE_NATS);
                }
                continue;
            }
            let one = self.shows_one_object(tracked, detection);
            let share = |id: &ObjectId| self.visible_share_in_group(*id, tracked);
            let best = tracked.members.iter().copied().max_by(|a, b| {
                let seen =
                    |id: &ObjectId| self.objects.get(id).map_or(0.0, |object| object.visible_share_in_group);
                seen(a).total_cmp(&seen(b)).then(share(a).total_cmp(&share(b))).then(b.cmp(a))
            });
            let mut left = tracked.members.len();
            for &id in &tracked.members {
                let Some(object) = self.objects.get_mut(&id) else { continue };
                let seen = if one { Some(id) == best } else { object.unseen_frames == 0 };
                let covered = contained_share(&object.predicted_box(), &detection.bbox) >= 0.5;
                let rate = match (seen, covered) {
                    (true, _) => EXISTENCE_GAIN_NATS_PER_SECOND,
                    (false, true) => -COVERED_LOSS_NATS_PER_SECOND,
                    (false, false) => -UNCOVERED_LOSS_NATS_PER_SECOND,
                };
                object.existence = (object.existence + rate / second).min(MAX_EXISTENCE_NATS);
                if object.existence < 0.0 && left > 1 && Some(id) != best {
                    left -= 1;
                    leaving.push(id);
                }
            }
        }
        for id in leaving {
            let place = self.objects.get(&id).map(|object| object.key);
            self.settle_demerges_of(id);
            if self.objects.get(&id).map(|object| object.key) != place {
                // Identities were swapped; the other object is handled in the next frame.
                continue;
            }
            if !self.can_leave(id) {
                continue;
            }
            for tracked in &mut self.blobs {
                tracked.members.retain(|member| *member != id);
            }
            self.group_episodes.mark_member_lost(id);
            let Some(bbox) = self.objects.get(&id).map(Object::predicted_box) else { continue };
            if self.is_near_border(&bbox) {
                let mut evidence =
                    Evidence::of_branch("not visible in its group's region, at the image edge");
                let distance = bbox.distance_to_edge(self.size);
                evidence.at_most("distance to image edge, pixels", distance, self.limits.border_px);
                self.emit_exit(id, self.number, evidence);
            } else {
                self.mark_occluded(id, (self.number, self.t));
            }
        }
    }

    /// Corrects sizes learnt from fragments: where a group's region stays far larger than all its members, the
    /// largest member gets the whole region as its size. The others then leave, as the region has room for one only.
    pub(super) fn correct_member_sizes(&mut self) {
        for tracked in &mut self.blobs {
            let area = |id: &ObjectId| self.objects.get(id).map_or(0.0, Object::area);
            let Some(detection) = tracked.detection.as_ref().filter(|_| tracked.members.len() > 1) else {
                continue;
            };
            let oversized = detection.area > MAX_AREA_RATIO * tracked.members.iter().map(area).sum::<f32>();
            tracked.oversized = if oversized { tracked.oversized + 1 } else { 0 };
            if tracked.oversized < self.limits.head_count_frames {
                continue;
            }
            let largest = tracked.members.iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(b.cmp(a)));
            if let Some(object) = largest.and_then(|id| self.objects.get_mut(id)) {
                object.last_detection = detection.clone();
                object.reset_appearance();
            }
        }
    }

    /// Whether a region is too small to show more than one of its members.
    fn shows_one_object(&self, tracked: &TrackedBlob, detection: &Detection) -> bool {
        let area = |id: &ObjectId| self.objects.get(id).map_or(0.0, Object::area);
        detection.area < MAX_SINGLE_AREA_RATIO * tracked.members.iter().map(area).fold(0.0, f32::max)
    }

    /// Localises the members of a group within its region.
    pub(super) fn localise_members(&mut self, members: &[ObjectId], detection: &Detection) {
        let Some((ids, mut localised, field)) = self.localisation_inputs(members, detection) else { return };
        let mut ids = ids;
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
        let found: Vec<(ObjectId, [f32; 2], f32)> =
            ids.into_iter().zip(localised).map(|(id, it)| (id, it.centre, it.visible_share)).collect();
        for (id, centre, seen) in found {
            self.update_member_position(id, centre, seen);
        }
    }

    fn update_member_position(&mut self, id: ObjectId, centre: [f32; 2], seen: f32) {
        let Some(object) = self.objects.get_mut(&id) else { return };
        object.visible_share_in_group = seen;
        if seen < MIN_VISIBLE_SHARE {
            object.unseen_frames += 1;
            return;
        }
        object.update_position(centre, seen);
    }

    /// Inputs of the localisation of some members, the lowest in the image first, as it is usually the nearest.
    /// `None` while a member has no template.
    fn localisation_inputs<'a>(
        &'a self,
        members: &[ObjectId],
        detection: &Detection,
    ) -> Option<(Vec<ObjectId>, Vec<LocalisedObject<'a>>, Field)> {
        let boxes = self.objects_of(members).map(Object::predicted_box);
        let around = boxes.reduce(|a, b| a.union(&b))?;
        let field = Field::new(&detection.mosaic, &around, self.size)?;
        let mut known: Vec<(ObjectId, LocalisedObject)> = Vec::new();
        for &id in members {
            known.push((id, localised(self.objects.get(&id)?)?));
        }
        known.sort_by(|a, b| {
            let bottom = |it: &LocalisedObject| it.centre[1] + it.size.1 / 2.0;
            bottom(&b.1).total_cmp(&bottom(&a.1))
        });
        let (ids, localised) = known.into_iter().unzip();
        Some((ids, localised, field))
    }

    /// Searches unseen members and occluded objects in the regions near their predicted places.
    pub(super) fn reidentify_unseen_members(&mut self) {
        let in_groups = self.blobs.iter().filter(|tracked| tracked.members.len() > 1);
        let unseen = in_groups.flat_map(|tracked| tracked.members.iter().copied());
        let long = |id: &ObjectId| self.objects.get(id).is_some_and(|object| object.unseen_frames > 1);
        let mut missing: Vec<ObjectId> = unseen.filter(long).collect();
        missing.extend(self.occluded.iter().map(|occluded| occluded.id));
        for id in missing {
            if let Some((index, centre)) = self.find_in_groups(id) {
                self.add_to_group(id, index, centre);
            }
        }
    }

    /// Re-identifies an object that lost its own region in the region of others; whether it was.
    pub(super) fn reidentify_in_group(&mut self, id: ObjectId) -> bool {
        let named = self.objects.get(&id).is_some_and(|object| object.confirmed);
        let place = (named && self.settings.find_again == Switch::On).then(|| self.find_in_groups(id));
        let Some((index, centre)) = place.flatten() else { return false };
        self.add_to_group(id, index, centre);
        true
    }

    /// The blob and the place in it where an unexplained part matches this object's template.
    fn find_in_groups(&self, id: ObjectId) -> Option<(usize, [f32; 2])> {
        let object = self.objects.get(&id)?;
        let wide = reappearance_radius(object, self.frames_unseen(id));
        let mut best: Option<(f32, usize, [f32; 2])> = None;
        for (index, tracked) in self.blobs.iter().enumerate() {
            let Some(detection) = &tracked.detection else { continue };
            let named = tracked.members.iter().any(|&member| self.is_confirmed(member));
            if tracked.members.contains(&id) || !named {
                continue;
            }
            if assign::distance_outside(&object.predicted_box(), &detection.bbox) > wide {
                continue;
            }
            if self.shows_one_object(tracked, detection) {
                continue;
            }
            let Some((_, mut localised, field)) = self.localisation_inputs(&tracked.members, detection)
            else {
                continue;
            };
            let Some(mut last) = self::localised(object) else { continue };
            last.position_sigma = wide.max(last.position_sigma);
            let Some(start) = localisation::unexplained_centre(&localised, &field) else { continue };
            last.centre = start;
            localised.push(last);
            localisation::localise_last(&mut localised, &field);
            let Some(last) = localised.last() else { continue };
            if last.visible_share >= MIN_REIDENTIFIED_SHARE
                && best.is_none_or(|(most, ..)| last.visible_share > most)
            {
                best = Some((last.visible_share, index, last.centre));
            }
        }
        best.map(|(_, index, centre)| (index, centre))
    }

    fn frames_unseen(&self, id: ObjectId) -> u32 {
        let occluded = self.occluded.iter().find(|occluded| occluded.id == id);
        let since = occluded.map(|occluded| self.t - occluded.since.1);
        since.or_else(|| Some(self.objects.get(&id)?.unseen_frames)).unwrap_or(0)
    }

    fn add_to_group(&mut self, id: ObjectId, index: usize, centre: [f32; 2]) {
        let key = self.objects.get(&id).map(|object| object.key);
        self.settle_demerges_of(id);
        if self.objects.get(&id).map(|object| object.key) != key {
            // Identities were swapped; the other object is searched in the next frame.
            return;
        }
        let mut evidence =
            Evidence::of_branch("object visible in a region that other objects do not fully explain");
        evidence.note("frames without detection", self.frames_unseen(id) as f32);
        self.groups.record_joining(id, GroupChange { frame: self.number, at: centre, evidence });
        for tracked in &mut self.blobs {
            tracked.members.retain(|member| *member != id);
        }
        let Some(tracked) = self.blobs.get_mut(index) else { return };
        tracked.members.push(id);
        tracked.members.sort_unstable();
        let Some(object) = self.objects.get_mut(&id) else { return };
        let from = object.last_detection.bbox;
        object.set_centre(centre);
        object.unseen_frames = 0;
        object.partial_frames = 0;
        let Some(at) = self.occluded.iter().position(|occluded| occluded.id == id) else { return };
        let occluded = self.occluded.remove(at);
        let Some(identity) = self.identity(id) else { return };
        let mut evidence = Evidence::of_branch(
            "occluded object visible in a region that other objects do not fully explain",
        );
        evidence.note("frames occluded", (self.t - occluded.since.1) as f32);
        let event = Event::of_one(self.number, EventKind::Reappear, identity, centre, evidence);
        self.pending_reappearances.push(PendingReappearance {
            id,
            since: occluded.since,
            t: self.t,
            event,
            from,
        });
    }
}

/// The localisation input of an object at its predicted place, `None` without a template.
fn localised(object: &Object) -> Option<LocalisedObject<'_>> {
    let velocity = object.model.velocity();
    let speed = velocity.x.hypot(velocity.y);
    let size = object.size();
    let centre = object.model.centre();
    let position_sigma = 1.0 + 0.03 * size.1 + 0.3 * speed * (1 + object.unseen_frames.min(10)) as f32;
    let template = object.template.as_ref()?;
    Some(LocalisedObject { template, size, predicted: centre, position_sigma, centre, visible_share: 0.0 })
}
