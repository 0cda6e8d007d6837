//! The results of a frame.

use std::sync::Arc;

use super::object::Object;
use super::tracker::{FrameResult, Tracker};
use crate::regions::Rect;
use crate::tracking::pool::Blob;
use crate::tracking::seed_finder::UnexplainedDetection;
use crate::tracking::{Track, TrackState};

/// The box of a partly visible object is extended to its predicted full extent, but not beyond this multiple of its
/// size.
const MAX_EXTENSION: f32 = 1.2;

impl Tracker {
    /// Takes the results after this frame.
    pub(super) fn emit_frame_result(&mut self) -> FrameResult {
        let mut objects = Vec::new();
        for tracked in &self.blobs {
            let labels =
                tracked.detection.as_ref().map(|detection| detection.labels.clone()).unwrap_or_default();
            let group: Vec<u32> = match tracked.members.len() {
                1 => Vec::new(),
                _ => tracked.members.iter().filter_map(|id| Some(self.objects.get(id)?.key)).collect(),
            };
            for id in &tracked.members {
                let Some(object) = self.objects.get(id) else { continue };
                if tracked.detection.is_none() && !self.is_behind_known_occluder(object) {
                    continue;
                }
                let (state, bbox, share) = match (&tracked.detection, group.is_empty()) {
                    (Some(detection), true) => {
                        let bbox = self.extended_box(object, &detection.bbox);
                        (TrackState::Visible, bbox, object.visible_share(detection.area))
                    }
                    (Some(_), false) => (
                        TrackState::Merged,
                        object.predicted_box(),
                        self.visible_share_in_group(*id, tracked),
                    ),
                    (None, _) => (TrackState::Hidden, object.predicted_box(), 0.0),
                };
                let mut track = self.track(object, Some(&tracked.blob), state, bbox, share);
                track.regions.clone_from(&labels);
                track.group.clone_from(&group);
                objects.push(track);
            }
        }
        for occluded in &self.occluded {
            if let Some(object) = self.objects.get(&occluded.id)
                && self.t - occluded.since.1 <= self.limits.max_coast_frames
                && self.is_behind_known_occluder(object)
            {
                objects.push(self.track(object, None, TrackState::Hidden, object.predicted_box(), 0.0));
            }
        }
        objects.sort_by_key(|track| track.key);
        let (named, tentative): (Vec<_>, Vec<_>) =
            objects.iter().partition(|track| self.identity_map.of(track.key).is_some());
        FrameResult {
            tracks: self.identity_map.apply(named),
            tentative: tentative.into_iter().cloned().collect(),
            objects,
            events: self.take_counted_events(),
            settled: self.take_settled(),
        }
    }

    /// The track of a new object in a frame before the one that started it.
    pub(super) fn earlier_track(&self, object: &Object, seen: &UnexplainedDetection) -> Track {
        let UnexplainedDetection { observation, labels, .. } = seen;
        let mut track = self.track(object, None, TrackState::Visible, observation.bbox, 1.0);
        track.centre = observation.bbox.centre();
        track.regions.clone_from(labels);
        track
    }

    /// The box of a lone object: extended to its predicted full extent, if a part of it may be behind a known
    /// occluder.
    fn extended_box(&self, object: &Object, seen: &Rect) -> Rect {
        let cut_off = seen.distance_to_edge(self.size) <= 1.0;
        let extended = object.predicted_box().union(seen);
        let (w, h) = object.size();
        let fits = extended.w <= MAX_EXTENSION * w && extended.h <= MAX_EXTENSION * h;
        let hides =
            |occluder: &Rect| occluder.intersection(&extended).area() > occluder.intersection(seen).area();
        let partial = object.partial_frames > 0 && !cut_off;
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
            hypotheses: blob.map_or_else(Arc::default, |blob| blob.summaries(self.pool.gate).into()),
            visible_share: share,
            colours: object.colours(&self.settings),
            regions: Vec::new(),
            group: Vec::new(),
        }
    }
}
