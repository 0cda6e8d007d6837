//! The measurements of a frame, by place.

use super::kalman::{ExpectedMeasurement, Innovation, Measurement};
use super::pool::Observation;
use crate::regions::Rect;
use crate::regions::box_index::BoxIndex;

/// The measurements of some observations of a frame, each by its number in the order given.
pub(super) struct Measurements {
    all: Vec<Measurement>,
    index: BoxIndex,
}

impl Measurements {
    /// The measurements of these observations.
    pub(super) fn new<'a>(observations: impl IntoIterator<Item = &'a Observation>) -> Self {
        let all: Vec<Measurement> = observations.into_iter().map(Observation::measurement).collect();
        let index = BoxIndex::new(all.iter().map(|it| Rect::new(it.x, it.y, 0.0, 0.0)));
        Self { all, index }
    }

    /// Those within a gate, given in squared Mahalanobis lengths, with their numbers, ascending, and innovations.
    pub(super) fn within_gate(
        &self,
        expected: &ExpectedMeasurement,
        gate: f32,
    ) -> impl Iterator<Item = (usize, &Measurement, Innovation)> {
        self.index.meeting(&expected.reach(gate)).into_iter().filter_map(move |number| {
            let measured = self.all.get(number)?;
            let innovation = expected.innovation(measured);
            (innovation.distance_squared <= gate).then_some((number, measured, innovation))
        })
    }
}
