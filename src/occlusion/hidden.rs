//! Objects without a region: who left, who is hidden, and who came back (Algorithms 2 and 3).

use super::assign;
use super::event::{Episode, EpisodeKind, Event, EventKind, Evidence};
use super::object::{LASTS, Object};
use super::partition::held_share;
use super::reasoner::{ObjectId, Reasoner};
use crate::regions::Rect;
use crate::settings::ReappearBy;

/// How well the colours must agree of somebody hidden and somebody who comes from where they are not predicted. In
/// rendered scenes the same person's do to .95 and more, and other people's to .7 at most.
const ALIKE: f32 = 0.8;
/// At so many places, from where it was last seen to where it is predicted, a hidden object may have stopped.
const STOPS: u8 = 8;

/// Who leaves moves outward, or hardly inward, as far as a mask's flicker goes: in pixels a frame.
const LEAST_OUTWARD: f32 = -0.2;
/// Places of occlusion by the scene that are remembered; the oldest go first.
const MAX_OCCLUDERS: usize = 64;

/// An object that the scene hides: the paper's past object.
#[derive(Clone, Debug)]
pub(super) struct Hidden {
    pub(super) id: ObjectId,
    /// The frame's number and t from which on it had no region.
    pub(super) since: (u32, u32),
}

/// Where somebody came from, with respect to somebody hidden.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// How far from there, in pixels, and how far it may be.
    distance: f32,
    reach: f32,
    /// Whether it is where they were predicted, or else on the way there.
    predicted: bool,
    /// Whether it is so near to the predicted place that a first glimpse says enough.
    near: bool,
}

impl Place {
    /// Of how far it may be.
    fn share(&self) -> f32 {
        self.distance / self.reach
    }
}

/// An object that came back, not told yet: it may be gone again in the next moment.
#[derive(Clone, Debug)]
pub(super) struct Return {
    pub(super) id: ObjectId,
    pub(super) since: (u32, u32),
    pub(super) t: u32,
    pub(super) event: Event,
    /// The box in which it was last seen.
    pub(super) from: Rect,
}

impl Reasoner {
    /// Decides about every blob without a region: wait, left the image, or hidden.
    pub(super) fn judge_lost(&mut self) {
        for index in (0..self.carried.len()).rev() {
            let Some(carried) = self.carried.get_mut(index) else { continue };
            if carried.view.is_some() {
                carried.lost_from = None;
                continue;
            }
            let lost_from = *carried.lost_from.get_or_insert((self.number, self.t));
            let frames = self.t - lost_from.1 + 1;
            let (members, bbox) = (carried.members.clone(), carried.blob.bbox);
            let unfit = self.pool.unfit(&carried.blob);
            if !members.iter().any(|&id| self.is_named(id)) {
                // Nobody yet: it was noise.
                if frames > 2 {
                    self.remove(index, &members);
                }
                continue;
            }
            if !unfit && !self.is_outside(&bbox) {
                continue;
            }
            // Objects may change places here, so that who is lost is asked only afterwards.
            for &id in &members {
                self.settle_splits_of(id);
            }
            let members = self.carried.get(index).map(|carried| carried.members.as_slice());
            if !members.unwrap_or_default().iter().all(|&id| self.can_leave(id)) {
                continue;
            }
            let leaves = self.leaves(index, lost_from.0);
            for id in self.carried.remove(index).members {
                if leaves.is_none() && (self.goes_on(id, lost_from) || self.is_found_again(id)) {
                    continue;
                }
                self.meetings.lose(id);
                match &leaves {
                    Some(evidence) => self.tell_exit(id, lost_from.0, evidence.clone()),
                    None => self.hide(id, lost_from),
                }
            }
        }
    }

    /// Decides about every blob that was lost a moment before the end of the video: left the image, or hidden where it is
    /// no flicker of the mask.
    pub(super) fn judge_lost_at_end(&mut self) {
        for index in (0..self.carried.len()).rev() {
            let Some(carried) = self.carried.get(index) else { continue };
            let Some(lost_from) = carried.lost_from else { continue };
            let leaves = self.leaves(index, lost_from.0);
            let lasts = self.t - lost_from.1 + 1 >= LASTS;
            if !carried.members.iter().all(|&id| self.is_named(id) && self.can_leave(id))
                || leaves.is_none() && !lasts
            {
                continue;
            }
            for id in self.carried.remove(index).members {
                match &leaves {
                    Some(evidence) => self.tell_exit(id, lost_from.0, evidence.clone()),
                    None => self.hide(id, lost_from),
                }
            }
        }
    }

    /// Whether somebody lost was there all the time: a region that nothing explained began, where
    /// they should be, when theirs was lost. Then that is theirs.
    fn goes_on(&mut self, id: ObjectId, lost_from: (u32, u32)) -> bool {
        let Some(past) = self.objects.get(&id).filter(|object| object.named) else { return false };
        let reach = reach(past, 0);
        let since = |new: &Object| new.born.abs_diff(lost_from.0);
        let near = |new: &Object| assign::outside(&past.predicted_box(), &new.last.bbox);
        let alone = self.carried.iter().filter_map(|carried| match carried.members[..] {
            [only] => self.objects.get(&only).map(|object| (only, object)),
            _ => None,
        });
        let new = alone
            .filter(|(_, new)| !new.named && since(new) <= self.limits.patience && near(new) <= reach)
            .min_by(|a, b| near(a.1).total_cmp(&near(b.1)));
        let Some((new, _)) = new else { return false };
        self.take_place(new, id);
        true
    }

    fn remove(&mut self, index: usize, members: &[ObjectId]) {
        self.carried.remove(index);
        for id in members {
            self.objects.remove(id);
        }
    }

    fn is_outside(&self, bbox: &Rect) -> bool {
        let image = Rect::new(0.0, 0.0, self.size.width as f32, self.size.height as f32);
        bbox.intersection(&image).area() <= 0.0
    }

    /// The evidence that a blob without a region has left the image, `None` when it has not.
    fn leaves(&self, index: usize, lost_from: u32) -> Option<Evidence> {
        let carried = self.carried.get(index)?;
        let velocity = carried.blob.shown().model.velocity();
        let last =
            self.objects_of(&carried.members).map(|object| object.last.bbox).reduce(|a, b| a.union(&b))?;
        let last = if carried.members.len() > 1 { carried.blob.bbox } else { last };
        let distance = last.distance_to_edge(self.size).min(carried.blob.bbox.distance_to_edge(self.size));
        let outward =
            outward_speed(&last, [velocity.x, velocity.y], self.size.width as f32, self.size.height as f32);
        let near = distance <= self.limits.border;
        let leaves = near && outward >= LEAST_OUTWARD;
        leaves.then(|| {
            let mut evidence = Evidence::of_branch(format!(
                "no region from frame {lost_from} on; box near the image edge and not moving inward"
            ));
            evidence.at_most("distance to image edge, pixels", distance, self.limits.border);
            evidence.at_least("outward speed, pixels/frame", outward, LEAST_OUTWARD);
            evidence
        })
    }

    pub(super) fn tell_exit(&mut self, id: ObjectId, frame: u32, evidence: Evidence) {
        self.tell_return_of(id);
        let Some(identity) = self.identity(id) else { return };
        let Some(at) = self.objects.get(&id).map(|object| object.last.bbox.centre()) else { return };
        self.push_event(&[id], Event::of_one(frame, EventKind::Exit, identity, at, evidence));
        self.end_object(id);
    }

    /// An object lost its region inside the image: it is kept as a past object.
    pub(super) fn hide(&mut self, id: ObjectId, since: (u32, u32)) {
        let Some(identity) = self.identity(id) else {
            self.end_object(id);
            return;
        };
        if let Some(index) = self.returns.iter().position(|returned| returned.id == id) {
            // It only flickered through a gap in what hides it: hidden all the time.
            let since = self.returns.remove(index).since;
            self.hidden.push(Hidden { id, since });
            return;
        }
        let Some(object) = self.objects.get_mut(&id) else { return };
        object.keep_pace();
        let last = object.last.bbox;
        let distance = last.distance_to_edge(self.size);
        let away = distance > self.limits.border;
        let place = if away { "away from the image edge" } else { "moving inward at the image edge" };
        let mut evidence = Evidence::of_branch(format!(
            "no region from frame {} on, {place}; no other region grew to contain it",
            since.0
        ));
        evidence.at_least("distance to image edge, pixels", distance, self.limits.border);
        self.hidden.push(Hidden { id, since });
        self.push_event(
            &[id],
            Event::of_one(since.0, EventKind::Disappear, identity, last.centre(), evidence),
        );
        self.leave_group(id);
    }

    /// Whether a new object is a hidden one that came back; if so it takes that one's identity.
    pub(super) fn reappears(&mut self, id: ObjectId) -> bool {
        let Some(new) = self.objects.get(&id) else { return false };
        if new.birthplace.distance_to_edge(self.size) <= self.limits.border {
            return false;
        }
        let mut candidates: Vec<(Place, f32, usize)> = Vec::new();
        for (index, hidden) in self.hidden.iter().enumerate() {
            let Some(past) = self.objects.get(&hidden.id) else { continue };
            if !new.may_be(past) {
                continue;
            }
            let Some(place) = self.place_of_return(past, hidden, &new.last.bbox) else { continue };
            let (agreement, _) = past.agreement(&new.last.histogram, &self.settings);
            if place.predicted || agreement >= ALIKE {
                candidates.push((place, agreement, index));
            }
        }
        let by_colour = self.settings.reappear_by == ReappearBy::Colour && candidates.len() > 1;
        let chosen = if by_colour {
            candidates.iter().max_by(|a, b| a.1.total_cmp(&b.1))
        } else {
            candidates.iter().min_by(|a, b| a.0.share().total_cmp(&b.0.share()))
        };
        let Some(&(Place { distance, reach, predicted, .. }, agreement, index)) = chosen else {
            return false;
        };
        let hidden = self.hidden.remove(index);
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
            evidence.note("colour similarity, 0 to 1.2", agreement);
        } else {
            evidence.at_least("colour similarity", agreement, ALIKE);
        }
        evidence.note("frames occluded", (self.t - hidden.since.1) as f32);
        self.take_back(id, &hidden, evidence);
        true
    }

    /// Whether more must be seen of a new object before its colours can tell whether somebody hidden came back.
    pub(super) fn must_be_seen_better(&self, id: ObjectId) -> bool {
        let Some(new) = self.objects.get(&id) else { return false };
        let by_colours = |hidden: &Hidden| {
            self.objects.get(&hidden.id).is_some_and(|past| {
                let place = self.place_of_return(past, hidden, &new.last.bbox);
                place.is_some_and(|place| !place.near) && !past.is_nearly_whole(&new.last)
            })
        };
        self.settings.reappear_by == ReappearBy::Colour
            && new.seen < self.limits.at_edge
            && new.birthplace.distance_to_edge(self.size) > self.limits.border
            && self.hidden.iter().any(by_colours)
    }

    /// Where a box is, if it may be of somebody hidden: where they are predicted, or else somewhere between where they
    /// were last seen and there, as they may have stopped or turned.
    fn place_of_return(&self, past: &Object, hidden: &Hidden, bbox: &Rect) -> Option<Place> {
        let frames = self.t - hidden.since.1;
        let (at_rest, wide) = (reach_at_rest(past, frames), reach(past, frames));
        let predicted_box = past.predicted_box();
        let distance = assign::outside(&predicted_box, bbox);
        let inside = !self.is_outside(&predicted_box);
        if inside && distance <= wide {
            return Some(Place { distance, reach: wide, predicted: true, near: distance <= at_rest });
        }
        if self.settings.reappear_by == ReappearBy::Position {
            return None;
        }
        let ([from_x, from_y], [to_x, to_y]) = (past.last.bbox.centre(), past.model.centre());
        let (w, h) = past.size();
        let outside = |step: u8| {
            let share = f32::from(step) / f32::from(STOPS);
            let at = [from_x + share * (to_x - from_x), from_y + share * (to_y - from_y)];
            assign::outside(&Rect::around(at, w, h), bbox)
        };
        let distance = (0..=STOPS).map(outside).fold(f32::INFINITY, f32::min);
        (distance <= at_rest).then_some(Place { distance, reach: at_rest, predicted: false, near: false })
    }

    fn take_back(&mut self, new: ObjectId, hidden: &Hidden, evidence: Evidence) {
        let Some(from) = self.objects.get(&hidden.id).map(|object| object.last.bbox) else { return };
        let Some(seen) = self.objects.get(&new) else { return };
        // Its new region can have begun before the old one was lost for good.
        let (frame, at) = (seen.born.max(hidden.since.0), seen.birthplace.centre());
        self.take_place(new, hidden.id);
        let Some(identity) = self.identity(hidden.id) else { return };
        let event = Event::of_one(frame, EventKind::Reappear, identity, at, evidence);
        self.returns.push(Return { id: hidden.id, since: hidden.since, t: self.t, event, from });
    }

    /// What was taken for a new object is one that is known.
    pub(super) fn take_place(&mut self, new: ObjectId, known: ObjectId) {
        let Some(seen) = self.objects.remove(&new) else { return };
        let Some(object) = self.objects.get_mut(&known) else { return };
        self.naming.same(seen.key, object.key);
        object.key = seen.key;
        object.seen += seen.seen;
        if object.is_nearly_whole(&seen.last) {
            object.model = seen.model;
            object.partial = 0;
        } else {
            object.see_part(&seen.last);
        }
        object.last = seen.last;
        for carried in &mut self.carried {
            for member in carried.members.iter_mut().filter(|member| **member == new) {
                *member = known;
            }
            carried.members.sort_unstable();
        }
    }

    /// Gives up who has been hidden for too long, and tells of those who came back to stay.
    pub(super) fn judge_hidden(&mut self) {
        for Hidden { id, since } in std::mem::take(&mut self.hidden) {
            // By place alone nobody comes back from outside.
            let lost = |object: &Object| {
                self.settings.reappear_by == ReappearBy::Position && self.is_outside(&object.predicted_box())
            };
            let gone = self.objects.get(&id).is_none_or(lost);
            if gone || self.t - since.1 > self.limits.max_hidden {
                self.objects.remove(&id);
            } else {
                self.hidden.push(Hidden { id, since });
            }
        }
        let stayed: Vec<ObjectId> = self
            .returns
            .iter()
            .filter(|returned| self.t - returned.t > self.limits.same_episode)
            .map(|returned| returned.id)
            .collect();
        for id in stayed {
            self.tell_return_of(id);
        }
    }

    /// Whether an object without a region is where the scene is known to hide objects: where one disappeared and came
    /// back before.
    pub(super) fn may_be_occluded(&self, object: &Object) -> bool {
        let bbox = object.predicted_box();
        self.occluders.iter().any(|occluder| held_share(&bbox, occluder) >= 0.5)
    }

    pub(super) fn tell_return_of(&mut self, id: ObjectId) {
        let Some(index) = self.returns.iter().position(|returned| returned.id == id) else { return };
        let returned = self.returns.remove(index);
        if let Some(object) = self.objects.get(&id) {
            if self.occluders.len() >= MAX_OCCLUDERS {
                self.occluders.remove(0);
            }
            let back = Rect::around([returned.event.x, returned.event.y], object.size().0, object.size().1);
            self.occluders.push(returned.from.union(&back));
        }
        self.episodes.push(Episode {
            kind: EpisodeKind::Scene,
            objects: returned.event.objects.clone(),
            start: returned.since.0,
            end: returned.event.frame.saturating_sub(1).max(returned.since.0),
            least_visible: 0.0,
            front: None,
            identities_kept: true,
        });
        self.push_event(&[id], returned.event);
    }
}

/// How far from its predicted place a hidden object may come back: it may have slowed down,
/// stopped or turned behind what hides it.
pub(super) fn reach(object: &Object, frames: u32) -> f32 {
    let velocity = object.model.velocity();
    reach_at_rest(object, frames) + 0.5 * velocity.x.hypot(velocity.y) * frames as f32
}

/// The same, from any place where it may have stopped.
fn reach_at_rest(object: &Object, frames: u32) -> f32 {
    0.6 * object.size().1 + (frames as f32).sqrt()
}

/// How fast a box near an edge moves towards it, in pixels a frame.
fn outward_speed(bbox: &Rect, [vx, vy]: [f32; 2], width: f32, height: f32) -> f32 {
    let edges = [(bbox.x, -vx), (bbox.y, -vy), (width - bbox.right(), vx), (height - bbox.bottom(), vy)];
    edges.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, speed)| *speed)
}
