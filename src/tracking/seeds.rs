//! New models: pairs of unexplained regions of the previous two frames, tried on the current one (§VIII).

use super::kalman::Model;
use super::pool::{Observation, PoolSettings};

/// A model through three unexplained regions.
#[derive(Clone, Debug)]
pub struct Seed {
    /// The model after the third.
    pub model: Model,
    /// The current frame's observation that it explains.
    pub observation: usize,
    /// What it was in the frame before the previous one.
    pub first: Observation,
}

/// The unexplained regions of the previous two frames.
#[derive(Clone, Debug, Default)]
pub struct Seeds {
    before_last: Vec<Observation>,
    last: Vec<Observation>,
}

impl Seeds {
    /// How many are remembered.
    pub fn len(&self) -> usize {
        self.before_last.len() + self.last.len()
    }

    /// Whether none are.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Takes in the frame's unexplained observations, `(index, observation)`, and gives the models
    /// that explain one of them, the best for each.
    pub fn step(&mut self, settings: &PoolSettings, unexplained: Vec<(usize, Observation)>) -> Vec<Seed> {
        let mut candidates = Vec::new();
        for first in &self.before_last {
            for second in &self.last {
                if !plausible(first, second) {
                    continue;
                }
                let mut model = Model::through(first.measurement(), second.measurement(), settings.noise);
                model.predict();
                for (index, third) in &unexplained {
                    let distance = model.distance_squared(&third.measurement());
                    if distance <= settings.gate {
                        let mut model = model.clone();
                        model.update(&third.measurement(), 1.0);
                        candidates
                            .push((distance, Seed { model, observation: *index, first: first.clone() }));
                    }
                }
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.observation.cmp(&b.1.observation)));
        let mut taken = Vec::new();
        candidates.retain(|(_, seed)| {
            let free = !taken.contains(&seed.observation);
            taken.push(seed.observation);
            free
        });
        self.before_last = std::mem::take(&mut self.last);
        self.last = unexplained.into_iter().map(|(_, observation)| observation).collect();
        candidates.into_iter().map(|(_, seed)| seed).collect()
    }
}

/// Whether two regions of consecutive frames can be the same thing at all: they overlap or nearly
/// do, and neither is much larger. This keeps pairs few when noise makes regions many.
fn plausible(first: &Observation, second: &Observation) -> bool {
    let reach = 0.5 * (first.area.sqrt() + second.area.sqrt());
    let ([x, y], [other_x, other_y]) = (first.bbox.centre(), second.bbox.centre());
    let near = (x - other_x).abs() <= reach && (y - other_y).abs() <= reach;
    near && first.area < 3.0 * second.area && second.area < 3.0 * first.area
}
