//! New models from pairs of unexplained detections of the previous two frames, tested on the current one (§VIII).

use std::collections::BTreeSet;

use super::kalman::KalmanModel;
use super::pool::{HypothesisMatcher, Observation};

/// A detection that no blob explains.
#[derive(Clone, Debug)]
pub struct UnexplainedDetection {
    /// Its index among its frame's detections.
    pub index: usize,
    /// Its box and pixels.
    pub observation: Observation,
    /// The labels of its regions.
    pub labels: Vec<u32>,
}

/// A model through three unexplained detections.
#[derive(Clone, Debug)]
pub struct Seed {
    /// The model after the third.
    pub model: KalmanModel,
    /// The index of the third among the current frame's detections.
    pub index: usize,
    /// The two before it, the oldest first.
    pub earlier: [UnexplainedDetection; 2],
}

/// The unexplained detections of the previous two frames.
#[derive(Clone, Debug, Default)]
pub struct SeedFinder {
    before_last: Vec<UnexplainedDetection>,
    last: Vec<UnexplainedDetection>,
    /// Frame periods between the two.
    periods: f32,
}

impl SeedFinder {
    /// Number of retained detections.
    pub(crate) fn len(&self) -> usize {
        self.before_last.len() + self.last.len()
    }

    /// Processes the unexplained detections of a frame that is `periods` frame periods after the previous one. Returns
    /// the models that explain one of them, the best for each.
    pub fn step(
        &mut self,
        settings: &HypothesisMatcher,
        periods: f32,
        unexplained: Vec<UnexplainedDetection>,
    ) -> Vec<Seed> {
        let measurements: Vec<_> = unexplained.iter().map(|it| it.observation.measurement()).collect();
        let mut found = Vec::new();
        for first in &self.before_last {
            for second in &self.last {
                if !plausible(&first.observation, &second.observation) {
                    continue;
                }
                let [one, two] = [first, second].map(|it| it.observation.measurement());
                let mut model = KalmanModel::through(one, two, self.periods, settings.noise);
                model.predict(periods);
                let expected = model.expected_measurement(0.0);
                for (third, measured) in unexplained.iter().zip(&measurements) {
                    if !expected.may_reach(measured, settings.gate) {
                        continue;
                    }
                    let distance = expected.distance_squared(measured);
                    if distance <= settings.gate {
                        let mut model = model.clone();
                        model.update(measured, 1.0);
                        let earlier = [first.clone(), second.clone()];
                        found.push((distance, Seed { model, index: third.index, earlier }));
                    }
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.index.cmp(&b.1.index)));
        let mut taken = BTreeSet::new();
        found.retain(|(_, seed)| taken.insert(seed.index));
        self.periods = periods;
        self.before_last = std::mem::replace(&mut self.last, unexplained);
        found.into_iter().map(|(_, seed)| seed).collect()
    }
}

/// Whether two detections of consecutive frames can be the same object: they overlap or nearly do, and neither is
/// much larger. This limits the number of pairs in noise.
fn plausible(first: &Observation, second: &Observation) -> bool {
    let reach = 0.5 * (first.area.sqrt() + second.area.sqrt());
    let ([x, y], [other_x, other_y]) = (first.bbox.centre(), second.bbox.centre());
    let near = (x - other_x).abs() <= reach && (y - other_y).abs() <= reach;
    near && first.area < 3.0 * second.area && second.area < 3.0 * first.area
}
