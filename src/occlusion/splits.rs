//! Groups that fell apart: who came out as whom (Algorithm 3), decided when the pieces were seen for a while.

use std::collections::BTreeMap;

use super::assign::{self, Fit, Piece};
use super::event::{Comparison, Evidence};
use super::groups::Cause;
use super::object::Object;
use super::reasoner::{Carried, ObjectId, Reasoner};
use crate::regions::{Histogram, Rect};

/// A decision about identity waits at most this many frames for clearer sight.
const LONGEST_WAIT: u32 = 10;

/// A group that fell apart and whose parting has not been told yet.
#[derive(Clone, Debug)]
pub(super) struct Split {
    /// The frame's number and t of the parting.
    frame: u32,
    t: u32,
    pub(super) members: Vec<ObjectId>,
    /// For each member the piece that it is in.
    piece_of: Vec<usize>,
    pieces: Vec<Piece>,
    /// Member by piece, at the parting.
    fits: Vec<Vec<Fit>>,
    decided: bool,
}

impl Split {
    /// Whether it is still open who this is.
    pub(super) fn is_undecided(&self, id: ObjectId) -> bool {
        !self.decided && self.members.contains(&id)
    }

    /// The piece that a member is in.
    pub(super) fn piece(&self, id: ObjectId) -> Option<usize> {
        let member = self.members.iter().zip(&self.piece_of).find(|(member, _)| **member == id);
        member.map(|(_, &piece)| piece)
    }

    fn members_in(&self, piece: usize) -> Vec<ObjectId> {
        self.members.iter().zip(&self.piece_of).filter(|(_, at)| **at == piece).map(|(&id, _)| id).collect()
    }
}

impl Reasoner {
    /// Notes that a group fell apart, if its members are now in several of `blobs`, each with the number of its piece in
    /// the rows of `fits`.
    pub(super) fn start_split(
        &mut self,
        group: &[ObjectId],
        blobs: &[(usize, Carried)],
        fits: &BTreeMap<ObjectId, Vec<Fit>>,
    ) {
        let present: Vec<ObjectId> =
            group.iter().copied().filter(|id| self.objects.contains_key(id)).collect();
        let pieces: Vec<&(usize, Carried)> = blobs
            .iter()
            .filter(|(_, carried)| carried.members.iter().any(|id| present.contains(id)))
            .collect();
        if pieces.len() < 2 {
            return;
        }
        for &id in &present {
            self.settle_splits_of(id);
        }
        let piece_of = present
            .iter()
            .map(|id| pieces.iter().position(|(_, carried)| carried.members.contains(id)).unwrap_or(0))
            .collect();
        let fits = present
            .iter()
            .filter_map(|id| fits.get(id))
            .map(|row| pieces.iter().filter_map(|(number, _)| row.get(*number).copied()).collect())
            .collect();
        let empty = |bbox: Rect, area: f32| Piece { bbox, area, histogram: Histogram::default() };
        let pieces = pieces
            .iter()
            .map(|(_, carried)| {
                let view = carried.view.as_ref();
                view.map_or_else(|| empty(Rect::default(), 0.0), |view| empty(view.bbox, view.area))
            })
            .collect();
        // From here on their tracks go under new keys: should it turn out that they came out the
        // other way round, only who the keys are has to change.
        for &id in &present {
            let key = self.new_key();
            if let Some(object) = self.objects.get_mut(&id) {
                self.naming.same(key, object.key);
                object.key = key;
            }
        }
        self.splits.push(Split {
            frame: self.number,
            t: self.t,
            members: present,
            piece_of,
            pieces,
            fits,
            decided: false,
        });
    }

    /// Whether a new object is a member of a group that shrank: it came out where the group's region
    /// had already been left (Algorithm 3). If so it takes that member's identity.
    pub(super) fn comes_out(&mut self, id: ObjectId) -> bool {
        let Some(new) = self.objects.get(&id) else { return false };
        if new.birthplace.distance_to_edge(self.size) <= self.limits.border {
            return false;
        }
        let piece =
            Piece { bbox: new.birthplace, area: new.last.area, histogram: new.last.histogram.clone() };
        let mut best: Option<(f32, usize, ObjectId, Fit, f32)> = None;
        for (index, group) in self
            .carried
            .iter()
            .enumerate()
            .filter(|(_, it)| it.members.len() > 1 && !it.members.contains(&id))
        {
            let due: f32 = self.objects_of(&group.members).map(Object::area).sum();
            let seen = group.view.as_ref().map_or(0.0, |view| view.area);
            let shrunk = seen <= (1.0 - self.settings.size_step) * due;
            let known = group.members.iter().filter_map(|id| Some((*id, self.objects.get(id)?)));
            for (member, object) in known.filter(|(_, object)| shrunk || object.unseen > 0) {
                if !new.may_be(object) {
                    continue;
                }
                let unsure = self.unsureness(member, true);
                let fits = assign::fits(&[object], &[unsure], std::slice::from_ref(&piece), &self.settings);
                let Some(&fit) = fits.first().and_then(|row| row.first()) else { continue };
                if fit.distance > 3.0 * unsure {
                    continue;
                }
                let value = assign::nats(fit);
                if best.is_none_or(|(most, ..)| value > most) {
                    best = Some((value, index, member, fit, seen / due));
                }
            }
        }
        let Some((_, index, member, fit, filled)) = best else { return false };
        if self.splits.iter().any(|split| split.members.contains(&member)) {
            // The identities within the group have been undecided until now.
            self.settle_splits_of(member);
            return self.comes_out(id);
        }
        let objects = self.carried.get(index).map_or(0, |group| group.members.len());
        let step = self.settings.size_step;
        let why = if filled <= 1.0 - step { "that shrank" } else { "in which it was not visible" };
        let mut evidence = Evidence::of_branch(format!(
            "unassociated region next to one shared by {objects} objects, {why}; assigned to the \
             best-matching group member",
        ));
        evidence.at_most("group area relative to the expected area of its members", filled, 1.0 - step);
        evidence.note("colour similarity, 0 to 1.2", fit.colour);
        evidence.note("distance to the member's prediction, pixels", fit.distance);
        let frame = new.born;
        if let Some(group) = self.carried.get_mut(index) {
            group.members.retain(|&other| other != member);
        }
        self.take_place(id, member);
        self.groups.note_leaving(member, Cause { frame, at: piece.bbox.centre(), evidence });
        true
    }

    /// Before objects are shared out anew among `pieces` regions, what is open about them is decided
    /// with what is known; objects may change places. Only where all who parted a moment ago share
    /// one region again there is nothing to decide: they never parted.
    pub(super) fn settle_before_meeting(&mut self, members: &[ObjectId], pieces: usize) {
        let together = |split: &Split| pieces == 1 && split.members.iter().all(|id| members.contains(id));
        self.splits.retain(|split| !together(split));
        for &id in members {
            self.settle_splits_of(id);
        }
    }

    /// Decides and tells at once what is open about an object.
    pub(super) fn settle_splits_of(&mut self, id: ObjectId) {
        while let Some(index) = self.splits.iter().position(|split| split.members.contains(&id)) {
            let split = self.splits.remove(index);
            self.settle_split(split);
        }
    }

    fn settle_split(&mut self, mut split: Split) {
        self.decide_split(&mut split);
        self.tell_split(&split);
    }

    /// Looks at the pieces once more; decides and tells what has waited long enough.
    pub(super) fn follow_splits(&mut self) {
        let same_episode = self.limits.same_episode;
        for mut split in std::mem::take(&mut self.splits) {
            self.look_at_pieces(&mut split);
            let waited = self.t - split.t;
            if waited >= LONGEST_WAIT.min(same_episode.max(3)) {
                self.decide_split(&mut split);
            }
            if waited > same_episode {
                self.settle_split(split);
            } else {
                self.splits.push(split);
            }
        }
    }

    fn look_at_pieces(&self, split: &mut Split) {
        let members: Vec<Vec<ObjectId>> =
            (0..split.pieces.len()).map(|piece| split.members_in(piece)).collect();
        for (piece, members) in split.pieces.iter_mut().zip(members) {
            let carried = self.carried.iter().find(|carried| carried.members == members);
            if let Some(view) = carried.and_then(|carried| carried.view.as_ref()) {
                piece.histogram.add_scaled(&view.histogram, 1.0 / view.area.max(1.0));
            }
        }
    }

    /// Asks the colours again, with all that was seen of the pieces since; the motion is that at
    /// the parting. Where the answer differs from the first guess the objects change places.
    fn decide_split(&mut self, split: &mut Split) {
        if std::mem::replace(&mut split.decided, true) {
            return;
        }
        if split.pieces.iter().any(|piece| piece.histogram.total() <= 0.0)
            || split.members.iter().any(|id| !self.objects.contains_key(id))
        {
            return;
        }
        let mut fits = split.fits.clone();
        for (row, object) in fits.iter_mut().zip(self.objects_of(&split.members)) {
            for (fit, piece) in row.iter_mut().zip(&split.pieces) {
                (fit.colour, fit.delta_e) = object.agreement(&piece.histogram, &self.settings);
            }
        }
        let assigned = assign::reassign(&fits, &split.piece_of, split.pieces.len());
        let mut takes_place_of = BTreeMap::new();
        for piece in 0..split.pieces.len() {
            let new = split.members.iter().zip(&assigned).filter(|(_, at)| **at == piece).map(|(&id, _)| id);
            takes_place_of.extend(new.zip(split.members_in(piece)));
        }
        self.change_places(&takes_place_of);
        split.fits = fits;
        split.piece_of = assigned;
    }

    /// Each object (key) takes the place of another (value): its key, motion, last view and blob.
    fn change_places(&mut self, takes_place_of: &BTreeMap<ObjectId, ObjectId>) {
        if takes_place_of.iter().all(|(id, place)| id == place) {
            return;
        }
        let identities: BTreeMap<ObjectId, Option<u32>> =
            takes_place_of.keys().map(|&id| (id, self.identity(id))).collect();
        let places: BTreeMap<ObjectId, Object> =
            takes_place_of.values().filter_map(|id| Some((*id, self.objects.get(id)?.clone()))).collect();
        for (id, place) in takes_place_of {
            if let (Some(object), Some(place)) = (self.objects.get_mut(id), places.get(place)) {
                object.key = place.key;
                object.model = place.model.clone();
                object.last = place.last.clone();
                if let Some(identity) = identities.get(id).copied().flatten() {
                    self.naming.set(place.key, identity);
                }
            }
        }
        let who: BTreeMap<ObjectId, ObjectId> =
            takes_place_of.iter().map(|(&id, &place)| (place, id)).collect();
        for carried in &mut self.carried {
            for member in &mut carried.members {
                *member = who.get(member).copied().unwrap_or(*member);
            }
            carried.members.sort_unstable();
        }
    }

    fn tell_split(&mut self, split: &Split) {
        let area: f32 = split.pieces.iter().map(|piece| piece.area).sum();
        let mut evidence = Evidence::of_branch(format!(
            "region shared by {} objects split into {} fragments, {area:.0} pixels in total; decided after \
             {} frames",
            self.identities(&split.members).len(),
            split.pieces.len(),
            self.t - split.t,
        ));
        for (member, (row, &chosen)) in split.members.iter().zip(split.fits.iter().zip(&split.piece_of)) {
            let identity = self.identity(*member).unwrap_or_default();
            for (piece, fit) in row.iter().enumerate() {
                let name = piece + 1;
                let taken = piece == chosen;
                let delta_e = if fit.delta_e.is_finite() { fit.delta_e } else { 999.0 };
                let alternatives = [
                    Comparison::at_most(
                        format!("ΔE of {identity} and fragment {name}"),
                        delta_e,
                        self.settings.same_colour,
                    ),
                    Comparison::note(
                        format!("colour similarity of {identity} and fragment {name}, 0 to 1.2"),
                        fit.colour,
                    ),
                    Comparison::note(
                        format!("distance of fragment {name} to the prediction of {identity}, pixels"),
                        fit.distance,
                    ),
                ];
                evidence.comparisons.extend(alternatives.map(|it| it.of_alternative(taken)));
            }
        }
        let around =
            split.pieces.iter().map(|piece| piece.bbox).reduce(|a, b| a.union(&b)).unwrap_or_default();
        let pieces: Vec<Vec<ObjectId>> =
            (0..split.pieces.len()).map(|piece| split.members_in(piece)).collect();
        self.tell_parting(&pieces, &Cause { frame: split.frame, at: around.centre(), evidence });
    }
}
