//! Objects without a region: exits, occlusions by the scene, and reappearances (Algorithms 2 and 3).

use super::assign;
use super::event::{Episode, EpisodeKind, Event, EventKind, Evidence};
use super::object::{MIN_STABLE_FRAMES, Object};
use super::partition::contained_share;
use super::tracker::{ObjectId, Tracker};
use crate::regions::Rect;
use crate::settings::ReappearBy;

/// Least colour similarity of an occluded object and a new one away from the predicted place. In rendered scenes it
/// is up to .95 and more for the same person, and at most .7 for others.
const MIN_COLOUR_SIMILARITY: f32 = 0.8;
/// Number of intervals between the last and the predicted place at whose ends an occluded object may have stopped.
const STOP_POSITIONS: u8 = 8;

/// An exiting object moves outward at least this fast, in pixels a frame; negative to allow for flicker of the mask.
const MIN_OUTWARD_SPEED: f32 = -0.2;
/// Number of remembered places of occlusion by the scene; the oldest are dropped first.
const MAX_OCCLUDERS: usize = 64;

/// An object that the scene occludes: the paper's past object.
#[derive(Clone, Debug)]
pub(super) struct OccludedObject {
    pub(super) id: ObjectId,
    /// Number and t of the first frame without a region.
    pub(super) since: (u32, u32),
}

/// The place of a new object relative to where an occluded one may reappear.
#[derive(Clone, Copy, Debug)]
struct ReappearancePlace {
    /// Distance from there in pixels, and the largest allowed distance.
    distance: f32,
    reach: f32,
    /// Whether it is at the predicted place, or else between the last place and that.
    predicted: bool,
    /// Whether it is near enough to the predicted place to need no clearer view.
    near: bool,
}

impl ReappearancePlace {
    /// Distance over the largest allowed one.
    fn share(&self) -> f32 {
        self.distance / self.reach
    }
}

/// A reappearance that is not emitted yet: the object may be occluded again at once.
#[derive(Clone, Debug)]
pub(super) struct PendingReappearance {
    pub(super) id: ObjectId,
    pub(super) since: (u32, u32),
    pub(super) t: u32,
    pub(super) event: Event,
    /// Its last box before the occlusion.
    pub(super) from: Rect,
}

impl Tracker {
    /// Decides about every blob without a region: wait, exit, or occluded by the scene.
    pub(super) fn resolve_lost_blobs(&mut self) {
        for index in (0..self.blobs.len()).rev() {
            let Some(tracked) = self.blobs.get_mut(index) else { continue };
            if tracked.detection.is_some() {
                tracked.lost_from = None;
                continue;
            }
            let lost_from = *tracked.lost_from.get_or_insert((self.number, self.t));
            let frames = self.t - lost_from.1 + 1;
            let (members, bbox) = (tracked.members.clone(), tracked.blob.bbox);
            let unfit = self.pool.is_unfit(&tracked.blob);
            if !members.iter().any(|&id| self.is_confirmed(id)) {
                // Not confirmed: noise.
                if frames > 2 {
                    self.remove(index, &members);
                }
                continue;
            }
            if !unfit && !self.is_outside(&bbox) {
                continue;
            }
            // Identities may be swapped here, so the members are read afterwards.
            for &id in &members {
                self.settle_demerges_of(id);
            }
            let members = self.blobs.get(index).map(|tracked| tracked.members.as_slice());
            if !members.unwrap_or_default().iter().all(|&id| self.can_leave(id)) {
                continue;
            }
            let exit_evidence = self.exit_evidence(index, lost_from.0);
            for id in self.blobs.remove(index).members {
                if exit_evidence.is_none()
                    && (self.recover_lost_track(id, lost_from) || self.reidentify_in_group(id))
                {
                    continue;
                }
                self.group_episodes.mark_member_lost(id);
                match &exit_evidence {
                    Some(evidence) => self.emit_exit(id, lost_from.0, evidence.clone()),
                    None => self.mark_occluded(id, lost_from),
                }
            }
        }
    }

    /// Decides about every blob that was lost shortly before the end of the video: exit, or occluded where that is no
    /// flicker of the mask.
    pub(super) fn resolve_lost_blobs_at_end(&mut self) {
        for index in (0..self.blobs.len()).rev() {
            let Some(tracked) = self.blobs.get(index) else { continue };
            let Some(lost_from) = tracked.lost_from else { continue };
            let exit_evidence = self.exit_evidence(index, lost_from.0);
            let lasts = self.t - lost_from.1 + 1 >= MIN_STABLE_FRAMES;
            if !tracked.members.iter().all(|&id| self.is_confirmed(id) && self.can_leave(id))
                || exit_evidence.is_none() && !lasts
            {
                continue;
            }
            for id in self.blobs.remove(index).members {
                match &exit_evidence {
                    Some(evidence) => self.emit_exit(id, lost_from.0, evidence.clone()),
                    None => self.mark_occluded(id, lost_from),
                }
            }
        }
    }

    /// Recovers a lost object whose region continued as an unexplained one: a tentative object began at its place
    /// when its region was lost. Merges that track into it; whether there was one.
    fn recover_lost_track(&mut self, id: ObjectId, lost_from: (u32, u32)) -> bool {
        let Some(past) = self.objects.get(&id).filter(|object| object.confirmed) else { return false };
        let reach = reappearance_radius(past, 0);
        let since = |new: &Object| new.first_frame.abs_diff(lost_from.0);
        let near = |new: &Object| assign::distance_outside(&past.predicted_box(), &new.last_detection.bbox);
        let alone = self.blobs.iter().filter_map(|tracked| match tracked.members[..] {
            [only] => self.objects.get(&only).map(|object| (only, object)),
            _ => None,
        });
        let new = alone
            .filter(|(_, new)| {
                !new.confirmed && since(new) <= self.limits.max_gap_frames && near(new) <= reach
            })
            .min_by(|a, b| near(a.1).total_cmp(&near(b.1)));
        let Some((new, _)) = new else { return false };
        self.merge_track_into(new, id);
        true
    }

    fn remove(&mut self, index: usize, members: &[ObjectId]) {
        self.blobs.remove(index);
        for id in members {
            self.objects.remove(id);
        }
    }

    fn is_outside(&self, bbox: &Rect) -> bool {
        let image = Rect::new(0.0, 0.0, self.size.width as f32, self.size.height as f32);
        bbox.intersection(&image).area() <= 0.0
    }

    /// The evidence that a blob without a region has left the image, `None` if it has not.
    fn exit_evidence(&self, index: usize, lost_from: u32) -> Option<Evidence> {
        let tracked = self.blobs.get(index)?;
        let velocity = tracked.blob.shown().model.velocity();
        let last = self
            .objects_of(&tracked.members)
            .map(|object| object.last_detection.bbox)
            .reduce(|a, b| a.union(&b))?;
        let last = if tracked.members.len() > 1 { tracked.blob.bbox } else { last };
        let distance = last.distance_to_edge(self.size).min(tracked.blob.bbox.distance_to_edge(self.size));
        let outward =
            outward_speed(&last, [velocity.x, velocity.y], self.size.width as f32, self.size.height as f32);
        let near = distance <= self.limits.border_px;
        let leaves = near && outward >= MIN_OUTWARD_SPEED;
        leaves.then(|| {
            let mut evidence = Evidence::of_branch(format!(
                "no region from frame {lost_from} on; box near the image edge and not moving inward"
            ));
            evidence.at_most("distance to image edge, pixels", distance, self.limits.border_px);
            evidence.at_least("outward speed, pixels/frame", outward, MIN_OUTWARD_SPEED);
            evidence
        })
    }

    pub(super) fn emit_exit(&mut self, id: ObjectId, frame: u32, evidence: Evidence) {
        self.emit_reappearance(id);
        let Some(identity) = self.identity(id) else { return };
        let Some(at) = self.objects.get(&id).map(|object| object.last_detection.bbox.centre()) else {
            return;
        };
        self.emit_event(&[id], Event::of_one(frame, EventKind::Exit, identity, at, evidence));
        self.end_object(id);
    }

    /// Marks an object that lost its region inside the image as occluded (a past object).
    pub(super) fn mark_occluded(&mut self, id: ObjectId, since: (u32, u32)) {
        let Some(identity) = self.identity(id) else {
            self.end_object(id);
            return;
        };
        if let Some(index) = self.pending_reappearances.iter().position(|pending| pending.id == id) {
            // It was visible only through a gap in the occluder: the occlusion continues.
            let since = self.pending_reappearances.remove(index).since;
            self.occluded.push(OccludedObject { id, since });
            return;
        }
        let Some(object) = self.objects.get_mut(&id) else { return };
        object.restore_clear_velocity();
        let last = object.last_detection.bbox;
        let distance = last.distance_to_edge(self.size);
        let away = distance > self.limits.border_px;
        let place = if away { "away from the image edge" } else { "moving inward at the image edge" };
        let mut evidence = Evidence::of_branch(format!(
            "no region from frame {} on, {place}; no other region grew to contain it",
            since.0
        ));
        evidence.at_least("distance to image edge, pixels", distance, self.limits.border_px);
        self.occluded.push(OccludedObject { id, since });
        self.emit_event(
            &[id],
            Event::of_one(since.0, EventKind::Disappear, identity, last.centre(), evidence),
        );
        self.leave_group(id);
    }

    /// Matches a new object to an occluded one; on success it takes that one's identity.
    pub(super) fn match_reappearance(&mut self, id: ObjectId) -> bool {
        let Some(new) = self.objects.get(&id) else { return false };
        if new.first_bbox.distance_to_edge(self.size) <= self.limits.border_px {
            return false;
        }
        let mut candidates: Vec<(ReappearancePlace, f32, usize)> = Vec::new();
        for (index, occluded) in self.occluded.iter().enumerate() {
            let Some(past) = self.objects.get(&occluded.id) else { continue };
            if !new.may_match(past) {
                continue;
            }
            let Some(place) = self.reappearance_place(past, occluded, &new.last_detection.bbox) else {
                continue;
            };
            let (similarity, _) = past.colour_similarity(&new.last_detection.histogram, &self.settings);
            if place.predicted || similarity >= MIN_COLOUR_SIMILARITY {
                candidates.push((place, similarity, index));
            }
        }
        let by_colour = self.settings.reappear_by == ReappearBy::Colour && candidates.len() > 1;
        let chosen = if by_colour {
            candidates.iter().max_by(|a, b| a.1.total_cmp(&b.1))
        } else {
            candidates.iter().min_by(|a, b| a.0.share().total_cmp(&b.0.share()))
        };
        let Some(&(ReappearancePlace { distance, reach, predicted, .. }, similarity, index)) = chosen else {
            return false;
        };
        let occluded = self.occluded.remove(index);
        let branch = match (by_colour, predicted) {
            (true, _) => {
                "unassociated region within reach of several occluded objects; selected by colour similarity"
            }
            (false, true) => "unassociated region at the predicted position of an occluded object",
            (false, false) => {
                "unassociated region where an occluded object may have stopped or turned; its colours are \
                 similar"
            }
        };
        let mut evidence = Evidence::of_branch(branch);
        let from = if predicted { "predicted position" } else { "predicted path" };
        evidence.at_most(format!("distance to {from}, pixels"), distance, reach);
        if predicted {
            evidence.note("colour similarity, 0 to 1.2", similarity);
        } else {
            evidence.at_least("colour similarity", similarity, MIN_COLOUR_SIMILARITY);
        }
        evidence.note("frames occluded", (self.t - occluded.since.1) as f32);
        self.restore_occluded(id, &occluded, evidence);
        true
    }

    /// Whether a new object needs a clearer view before its colours can be compared with occluded ones.
    pub(super) fn needs_clearer_view(&self, id: ObjectId) -> bool {
        let Some(new) = self.objects.get(&id) else { return false };
        let by_colours = |occluded: &OccludedObject| {
            self.objects.get(&occluded.id).is_some_and(|past| {
                let place = self.reappearance_place(past, occluded, &new.last_detection.bbox);
                place.is_some_and(|place| !place.near) && !past.is_nearly_whole(&new.last_detection)
            })
        };
        self.settings.reappear_by == ReappearBy::Colour
            && new.seen_frames < self.limits.edge_wait_frames
            && new.first_bbox.distance_to_edge(self.size) > self.limits.border_px
            && self.occluded.iter().any(by_colours)
    }

    /// The place of a box relative to an occluded object, if it may be that one's: at the predicted place, or else
    /// between the last place and that, as it may have stopped or turned.
    fn reappearance_place(
        &self,
        past: &Object,
        occluded: &OccludedObject,
        bbox: &Rect,
    ) -> Option<ReappearancePlace> {
        let frames = self.t - occluded.since.1;
        let (at_rest, wide) = (stationary_radius(past, frames), reappearance_radius(past, frames));
        let predicted_box = past.predicted_box();
        let distance = assign::distance_outside(&predicted_box, bbox);
        let inside = !self.is_outside(&predicted_box);
        if inside && distance <= wide {
            return Some(ReappearancePlace {
                distance,
                reach: wide,
                predicted: true,
                near: distance <= at_rest,
            });
        }
        if self.settings.reappear_by == ReappearBy::Position {
            return None;
        }
        let ([from_x, from_y], [to_x, to_y]) = (past.last_detection.bbox.centre(), past.model.centre());
        let (w, h) = past.size();
        let outside = |step: u8| {
            let share = f32::from(step) / f32::from(STOP_POSITIONS);
            let at = [from_x + share * (to_x - from_x), from_y + share * (to_y - from_y)];
            assign::distance_outside(&Rect::around(at, w, h), bbox)
        };
        let distance = (0..=STOP_POSITIONS).map(outside).fold(f32::INFINITY, f32::min);
        (distance <= at_rest).then_some(ReappearancePlace {
            distance,
            reach: at_rest,
            predicted: false,
            near: false,
        })
    }

    fn restore_occluded(&mut self, new: ObjectId, occluded: &OccludedObject, evidence: Evidence) {
        let Some(from) = self.objects.get(&occluded.id).map(|object| object.last_detection.bbox) else {
            return;
        };
        let Some(seen) = self.objects.get(&new) else { return };
        // Its new region may have begun before the old one was given up.
        let (frame, at) = (seen.first_frame.max(occluded.since.0), seen.first_bbox.centre());
        self.merge_track_into(new, occluded.id);
        let Some(identity) = self.identity(occluded.id) else { return };
        let event = Event::of_one(frame, EventKind::Reappear, identity, at, evidence);
        self.pending_reappearances.push(PendingReappearance {
            id: occluded.id,
            since: occluded.since,
            t: self.t,
            event,
            from,
        });
    }

    /// Merges the track of a new object into a known one.
    pub(super) fn merge_track_into(&mut self, new: ObjectId, known: ObjectId) {
        let Some(seen) = self.objects.remove(&new) else { return };
        let Some(object) = self.objects.get_mut(&known) else { return };
        self.identity_map.link(seen.key, object.key);
        object.key = seen.key;
        object.seen_frames += seen.seen_frames;
        if object.is_nearly_whole(&seen.last_detection) {
            object.model = seen.model;
            object.partial_frames = 0;
        } else {
            object.update_partial(&seen.last_detection);
        }
        object.last_detection = seen.last_detection;
        for tracked in &mut self.blobs {
            for member in tracked.members.iter_mut().filter(|member| **member == new) {
                *member = known;
            }
            tracked.members.sort_unstable();
        }
    }

    /// Ends objects that have been occluded for too long, and emits the reappearances of those that stayed visible.
    pub(super) fn update_occluded(&mut self) {
        for OccludedObject { id, since } in std::mem::take(&mut self.occluded) {
            // By position alone no object reappears from outside the image.
            let lost = |object: &Object| {
                self.settings.reappear_by == ReappearBy::Position && self.is_outside(&object.predicted_box())
            };
            let gone = self.objects.get(&id).is_none_or(lost);
            if gone || self.t - since.1 > self.limits.max_hidden_frames {
                self.objects.remove(&id);
            } else {
                self.occluded.push(OccludedObject { id, since });
            }
        }
        let stayed: Vec<ObjectId> = self
            .pending_reappearances
            .iter()
            .filter(|pending| self.t - pending.t > self.limits.same_episode_frames)
            .map(|pending| pending.id)
            .collect();
        for id in stayed {
            self.emit_reappearance(id);
        }
    }

    /// Whether an object without a region is at a known occluder: a place where one disappeared and reappeared
    /// before.
    pub(super) fn is_behind_known_occluder(&self, object: &Object) -> bool {
        let bbox = object.predicted_box();
        self.occluders.iter().any(|occluder| contained_share(&bbox, occluder) >= 0.5)
    }

    pub(super) fn emit_reappearance(&mut self, id: ObjectId) {
        let Some(index) = self.pending_reappearances.iter().position(|pending| pending.id == id) else {
            return;
        };
        let pending = self.pending_reappearances.remove(index);
        if let Some(object) = self.objects.get(&id) {
            if self.occluders.len() >= MAX_OCCLUDERS {
                self.occluders.remove(0);
            }
            let back = Rect::around([pending.event.x, pending.event.y], object.size().0, object.size().1);
            self.occluders.push(pending.from.union(&back));
        }
        self.episodes.push(Episode {
            kind: EpisodeKind::Scene,
            objects: pending.event.objects.clone(),
            start: pending.since.0,
            end: pending.event.frame.saturating_sub(1).max(pending.since.0),
            least_visible: 0.0,
            front: None,
            identities_kept: true,
        });
        self.emit_event(&[id], pending.event);
    }
}

/// Radius in pixels around the predicted place within which an occluded object may reappear: it may have slowed down,
/// stopped or turned.
pub(super) fn reappearance_radius(object: &Object, frames: u32) -> f32 {
    let velocity = object.model.velocity();
    stationary_radius(object, frames) + 0.5 * velocity.x.hypot(velocity.y) * frames as f32
}

/// The radius around any place where it may have stopped.
fn stationary_radius(object: &Object, frames: u32) -> f32 {
    0.6 * object.size().1 + (frames as f32).sqrt()
}

/// Speed of a box towards its nearest edge, in pixels a frame.
fn outward_speed(bbox: &Rect, [vx, vy]: [f32; 2], width: f32, height: f32) -> f32 {
    let edges = [(bbox.x, -vx), (bbox.y, -vy), (width - bbox.right(), vx), (height - bbox.bottom(), vy)];
    edges.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, speed)| *speed)
}
