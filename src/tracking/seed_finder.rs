//! New models from pairs of unexplained detections of the previous two frames, tested on the current one (§VIII).

use std::collections::BTreeSet;

use super::kalman::KalmanModel;
use super::measurements::Measurements;
use super::pool::{HypothesisMatcher, Observation};
use crate::regions::Rect;
use crate::regions::box_index::BoxIndex;

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
        let measurements = Measurements::new(unexplained.iter().map(|it| &it.observation));
        let index = BoxIndex::new(self.last.iter().map(|it| point(&it.observation)));
        let mut found = Vec::new();
        for first in &self.before_last {
            let reach = MAX_PLAUSIBLE_SHIFT * first.observation.area.sqrt();
            let near = index.meeting(&point(&first.observation).grown(reach, reach)).into_iter();
            let seconds = near.filter_map(|number| self.last.get(number));
            for second in seconds.filter(|second| plausible(&first.observation, &second.observation)) {
                let [one, two] = [first, second].map(|it| it.observation.measurement());
                let mut model = KalmanModel::through(one, two, self.periods, settings.noise);
                model.predict(periods);
                let expected = model.expected_measurement(0.0);
                for (number, measured, innovation) in measurements.within_gate(&expected, settings.gate) {
                    let Some(third) = unexplained.get(number) else { continue };
                    let mut model = model.clone();
                    model.update(measured, 1.0);
                    let earlier = [first.clone(), second.clone()];
                    let seed = Seed { model, index: third.index, earlier };
                    found.push((innovation.distance_squared, seed));
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

/// A larger one of two areas is less than this multiple of the other, and
const MAX_AREA_GROWTH: f32 = 3.0;
/// their centres are at most this multiple of the first one's √area apart in each direction: ½ (1 + √3), rounded up.
const MAX_PLAUSIBLE_SHIFT: f32 = 1.367;

/// Whether two detections of consecutive frames can be the same object: they overlap or nearly do, and neither is
/// much larger. This limits the number of pairs in noise.
fn plausible(first: &Observation, second: &Observation) -> bool {
    let reach = 0.5 * (first.area.sqrt() + second.area.sqrt());
    let ([x, y], [other_x, other_y]) = (first.bbox.centre(), second.bbox.centre());
    let near = (x - other_x).abs() <= reach && (y - other_y).abs() <= reach;
    let similar = first.area < MAX_AREA_GROWTH * second.area && second.area < MAX_AREA_GROWTH * first.area;
    near && similar
}

/// The centre as a box without a size.
fn point(observation: &Observation) -> Rect {
    Rect::around(observation.bbox.centre(), 0.0, 0.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::settings::{Preset, Settings};

    fn at(index: usize, x: f32, y: f32) -> UnexplainedDetection {
        let observation = Observation { bbox: Rect::around([x, y], 20.0, 40.0), area: 800.0 };
        UnexplainedDetection { index, observation, labels: vec![index as u32 + 1] }
    }

    /// The seeds of the third of three frames, the second two periods after the first.
    fn seeds(frames: [Vec<UnexplainedDetection>; 3]) -> Vec<Seed> {
        let settings = HypothesisMatcher::new(&Settings::preset(Preset::Plain), 25.0);
        let mut finder = SeedFinder::default();
        let [first, second, third] = frames;
        assert_eq!(finder.step(&settings, 1.0, first).len(), 0);
        assert_eq!(finder.step(&settings, 2.0, second).len(), 0);
        finder.step(&settings, 1.0, third)
    }

    #[test]
    fn three_detections_at_one_velocity_are_an_object() {
        let found = seeds([vec![at(4, 100.0, 50.0)], vec![at(2, 112.0, 54.0)], vec![at(7, 118.0, 56.0)]]);
        let [seed] = &found[..] else { panic!("{found:?}") };
        assert_eq!((seed.index, seed.earlier[0].index, seed.earlier[1].index), (7, 4, 2));
        assert_eq!(seed.model.centre(), [118.0, 56.0]);
        assert_eq!((seed.model.velocity().x, seed.model.velocity().y), (6.0, 2.0));
        assert_eq!(
            seeds([vec![at(0, 100.0, 50.0)], vec![at(0, 112.0, 50.0)], vec![at(0, 160.0, 50.0)]]).len(),
            0
        );
    }

    #[test]
    fn each_detection_has_the_seed_that_predicts_it_best() {
        let found = seeds([
            vec![at(0, 97.0, 50.0), at(1, 100.0, 50.0)],
            vec![at(0, 112.0, 50.0)],
            vec![at(0, 119.4, 50.0), at(1, 118.2, 50.0)],
        ]);
        let pairs: Vec<_> = found.iter().map(|seed| (seed.index, seed.earlier[0].index)).collect();
        assert_eq!(pairs, [(0, 0), (1, 1)], "119.5 and 118 are predicted");
    }

    #[test]
    fn detections_far_apart_or_of_other_sizes_are_not_one_object() {
        let one = at(0, 100.0, 50.0).observation;
        let other = |x: f32, y: f32, area: f32| Observation { area, ..at(0, x, y).observation };
        let both = |second: &Observation| [plausible(&one, second), plausible(second, &one)];
        // Half the sum of √800 and √450 is 24.7.
        assert_eq!(both(&other(124.0, 26.0, 450.0)), [true; 2]);
        assert_eq!(both(&other(125.0, 50.0, 450.0)), [false; 2]);
        assert_eq!(both(&other(100.0, 25.0, 450.0)), [false; 2]);
        assert_eq!(both(&other(100.0, 50.0, 2399.0)), [true; 2]);
        assert_eq!(both(&other(100.0, 50.0, 2400.0)), [false; 2]);
        assert_eq!(both(&other(100.0, 50.0, 267.0)), [true; 2]);
    }

    #[test]
    fn detections_are_retained_for_two_frames() {
        let settings = HypothesisMatcher::new(&Settings::default(), 25.0);
        let mut finder = SeedFinder::default();
        let kept = [3, 1, 0, 0].map(|count| {
            finder.step(
                &settings,
                1.0,
                (0..count).map(|index| at(index, 90.0 * index as f32, 50.0)).collect(),
            );
            finder.len()
        });
        assert_eq!(kept, [3, 4, 1, 0]);
    }
}
