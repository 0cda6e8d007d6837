//! What the reasoner says of a frame.

use std::sync::Arc;

use super::object::Object;
use super::reasoner::{Reasoner, Seen};
use crate::regions::Rect;
use crate::tracking::pool::Blob;
use crate::tracking::seeds::Candidate;
use crate::tracking::{Track, TrackState};

/// The box of an object seen in part is extended to where the rest is predicted, but not beyond this multiple of its size.
const MAX_EXTENSION: f32 = 1.2;

impl Reasoner {
    /// All objects as they stand after this frame.
    pub(super) fn tell(&mut self) -> Seen {
        let mut objects = Vec::new();
        for carried in &self.carried {
            let labels = carried.view.as_ref().map(|view| view.labels.clone()).unwrap_or_default();
            let group: Vec<u32> = match carried.members.len() {
                1 => Vec::new(),
                _ => carried.members.iter().filter_map(|id| Some(self.objects.get(id)?.key)).collect(),
            };
            for id in &carried.members {
                let Some(object) = self.objects.get(id) else { continue };
                if carried.view.is_none() && !self.may_be_occluded(object) {
                    continue;
                }
                let (state, bbox, share) = match (&carried.view, group.is_empty()) {
                    (Some(view), true) => {
                        let bbox = self.full_box(object, &view.bbox);
                        (TrackState::Visible, bbox, object.visible_share(view.area))
                    }
                    (Some(_), false) => {
                        (TrackState::Merged, object.predicted_box(), self.share_in_group(*id, carried))
                    }
                    (None, _) => (TrackState::Hidden, object.predicted_box(), 0.0),
                };
                let mut track = self.track(object, Some(&carried.blob), state, bbox, share);
                track.regions.clone_from(&labels);
                track.group.clone_from(&group);
                objects.push(track);
            }
        }
        for hidden in &self.hidden {
            if let Some(object) = self.objects.get(&hidden.id)
                && self.t - hidden.since.1 <= self.limits.told
                && self.may_be_occluded(object)
            {
                objects.push(self.track(object, None, TrackState::Hidden, object.predicted_box(), 0.0));
            }
        }
        objects.sort_by_key(|track| track.key);
        let (named, tentative): (Vec<_>, Vec<_>) =
            objects.iter().partition(|track| self.naming.of(track.key).is_some());
        Seen {
            tracks: self.naming.apply(named),
            tentative: tentative.into_iter().cloned().collect(),
            objects,
            events: self.count_told(),
            settled: self.take_settled(),
        }
    }

    /// A new object in a frame before the one in which it was found.
    pub(super) fn earlier_track(&self, object: &Object, seen: &Candidate) -> Track {
        let Candidate { observation, labels, .. } = seen;
        let mut track = self.track(object, None, TrackState::Visible, observation.bbox, 1.0);
        track.centre = observation.bbox.centre();
        track.regions.clone_from(labels);
        track
    }

    /// The box of an object that is seen alone: extended to where the rest is predicted, if a part of it may be behind what
    /// has hidden objects before.
    fn full_box(&self, object: &Object, seen: &Rect) -> Rect {
        let cut_off = seen.distance_to_edge(self.size) <= 1.0;
        let extended = object.predicted_box().union(seen);
        let (w, h) = object.size();
        let fits = extended.w <= MAX_EXTENSION * w && extended.h <= MAX_EXTENSION * h;
        let hides =
            |occluder: &Rect| occluder.intersection(&extended).area() > occluder.intersection(seen).area();
        let partial = object.partial > 0 && !cut_off;
        if partial && fits && self.occluders.iter().any(hides) { extended } else { *seen }
    }

    fn track(
        &self,
        object: &Object,
        blob: Option<&Blob>,
        state: TrackState,
        bbox: Rect,
        share: f32,
    ) -> Track {
        let velocity = object.model.velocity();
        let shown = blob.map(Blob::shown);
        Track {
            id: 0,
            key: object.key,
            state,
            bbox,
            centre: object.model.centre(),
            velocity: [velocity.x, velocity.y],
            scale: object.model.scale(),
            gate: object.model.gate_ellipse(self.pool.gate),
            fitness: shown.map_or(0.0, |shown| shown.fitness.value()),
            hypotheses: blob.map_or_else(Arc::default, |blob| blob.competing(self.pool.gate).into()),
            visible_share: share,
            colours: object.colours(&self.settings),
            regions: Vec::new(),
            group: Vec::new(),
        }
    }
}
