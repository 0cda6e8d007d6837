//! The pool of Kalman models: each moving region's competing hypotheses, matched to the regions of a frame (§VIII).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use pathfinding::matrix::Matrix;
use pathfinding::prelude::{kuhn_munkres, separate_components};

use super::HypothesisSummary;
use super::kalman::{KalmanModel, Measurement, Noise, chi_squared_3};
use super::measurements::Measurements;
use crate::regions::Rect;
use crate::settings::Settings;

/// Largest number of hypotheses of one blob.
const MAX_HYPOTHESES_PER_BLOB: usize = 6;
/// Least score of a hypothesis relative to the shown one (a factor of e⁻⁸).
const MIN_SCORE: f32 = -8.0;

/// Standard deviation of a sudden manoeuvre relative to the object's √area: the gate then reaches about one object
/// length per frame. Tried from .3 to .6 on fish that accelerate; people and cars hardly need it.
const MANOEUVRE_SIGMA: f32 = 0.4;

/// What a hypothesis can be matched to: one region, or the joined fragments of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Bounding box of all its regions.
    pub bbox: Rect,
    /// Number of pixels of all its regions.
    pub area: f32,
}

impl Observation {
    /// The measurement for the Kalman model: the box's centre and √area.
    pub fn measurement(&self) -> Measurement {
        let [x, y] = self.bbox.centre();
        Vector3::new(x, y, self.area.sqrt())
    }
}

/// Mean squared Mahalanobis length of the errors of a model whose covariance is right: 3 degrees of freedom.
const EXPECTED_ERROR: f32 = 3.0;
/// Frame rate to which the setting `null_factor` refers.
const NULL_FACTOR_FPS: f32 = 25.0;
/// Largest multiple of `null_factor`'s frame that one unmatched frame counts for, at a lower rate: a mask can fail
/// for two frames at any rate.
const MAX_NULL_FRAMES: f32 = 5.0 / 3.0;

/// The fitness of a model (§VIII): 1 / mean squared Mahalanobis length of its prediction errors, times the null factors
/// since the last match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitness {
    mean_error: f32,
    /// Product of the null factors since the last match.
    nulls: f32,
}

impl Fitness {
    /// The fitness of a model whose errors agree with its covariance.
    pub const fn expected() -> Self {
        Self { mean_error: EXPECTED_ERROR, nulls: 1.0 }
    }

    /// The number that is compared with `min_fitness`, 0..=1/3. Errors smaller than the covariance predicts do not
    /// increase it.
    pub fn value(self) -> f32 {
        self.nulls / self.mean_error.max(EXPECTED_ERROR)
    }

    fn record_match(&mut self, distance_squared: f32, memory: u32) {
        self.mean_error += (distance_squared - self.mean_error) / memory as f32;
        self.nulls = 1.0;
    }

    fn record_miss(&mut self, null_factor: f32) {
        self.nulls *= null_factor;
    }
}

/// One explanation of the past of a moving region: which observation it was in each frame.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Its motion model.
    pub model: KalmanModel,
    /// Its fitness.
    pub fitness: Fitness,
    /// Sum of its log-likelihoods, relative to the shown one.
    pub score: f32,
    /// The observation that it matched in this frame, `None` for a null match.
    pub matched: Option<usize>,
}

/// A moving region and the hypotheses that compete for it.
#[derive(Clone, Debug)]
pub struct Blob {
    shown: Hypothesis,
    /// The other competing ones, the most probable first.
    others: Vec<Hypothesis>,
    /// Number of frames since it last had a region.
    pub lost: u32,
    /// Frame periods of the last prediction.
    periods: f32,
    /// The box of its last region, moved by the velocity while it has none.
    pub bbox: Rect,
}

impl Blob {
    /// A blob with one hypothesis at an observation.
    pub fn new(model: KalmanModel, observation: &Observation) -> Self {
        let shown = Hypothesis { model, fitness: Fitness::expected(), score: 0.0, matched: None };
        Self { shown, others: Vec::new(), lost: 0, periods: 1.0, bbox: observation.bbox }
    }

    /// The hypothesis that is shown.
    pub const fn shown(&self) -> &Hypothesis {
        &self.shown
    }

    /// All competing hypotheses, the shown one first.
    pub fn hypotheses(&self) -> impl Iterator<Item = &Hypothesis> {
        std::iter::once(&self.shown).chain(&self.others)
    }

    /// Predicts every hypothesis by a number of frame periods.
    pub fn predict(&mut self, periods: f32) {
        self.periods = periods;
        for hypothesis in std::iter::once(&mut self.shown).chain(&mut self.others) {
            hypothesis.model.predict(periods);
        }
    }

    /// Shows the hypothesis with this match, or else the first, and makes the others' scores relative to it.
    fn show(&mut self, mut hypotheses: Vec<Hypothesis>, matched: Option<usize>) {
        if let Some(at) = hypotheses.iter().position(|hypothesis| hypothesis.matched == matched) {
            hypotheses.swap(0, at);
        }
        let mut hypotheses = hypotheses.into_iter();
        let Some(shown) = hypotheses.next() else { return };
        let best = shown.score;
        self.shown = Hypothesis { score: 0.0, ..shown };
        self.others = hypotheses.map(|other| Hypothesis { score: other.score - best, ..other }).collect();
    }

    /// Summaries of all hypotheses, the shown one first; `gate` is χ² at the edge of the gate.
    pub fn summaries(&self, gate: f32) -> Vec<HypothesisSummary> {
        let most = self.hypotheses().map(|each| each.score).fold(f32::NEG_INFINITY, f32::max);
        let likelihood = |each: &Hypothesis| (each.score - most).exp();
        let total: f32 = self.hypotheses().map(likelihood).sum();
        let summaries = self.hypotheses().enumerate().map(|(rank, each)| HypothesisSummary {
            centre: each.model.centre(),
            gate: each.model.gate_ellipse(gate),
            fitness: each.fitness.value(),
            probability: likelihood(each) / total,
            // The shown one may have been updated from outside, in place of its own match.
            matched: if rank == 0 { self.lost == 0 } else { each.matched.is_some() },
        });
        summaries.collect()
    }

    /// Drops all but the shown hypothesis and lets `change` correct its model: after an interaction the others no
    /// longer apply.
    pub fn keep_shown(&mut self, observation: &Observation, change: impl FnOnce(&mut KalmanModel)) {
        self.others.clear();
        change(&mut self.shown.model);
        self.shown.score = 0.0;
        self.shown.fitness.nulls = 1.0;
        self.lost = 0;
        self.bbox = observation.bbox;
    }
}

/// How hypotheses are matched, scored and dropped.
#[derive(Clone, Debug)]
pub struct HypothesisMatcher {
    /// The Kalman models' noise.
    pub noise: Noise,
    /// χ² at the edge of the gate.
    pub gate: f32,
    fitness_memory: u32,
    /// The factor on the fitness per unmatched frame of this video.
    null_factor: f32,
    min_fitness: f32,
    max_hypotheses: usize,
}

impl HypothesisMatcher {
    /// The pool's part of `settings`, for `fps` frames per second.
    pub fn new(settings: &Settings, fps: f32) -> Self {
        let frames = (NULL_FACTOR_FPS / fps.max(1.0)).min(MAX_NULL_FRAMES);
        Self {
            noise: Noise { process: settings.process_noise, measurement: settings.measurement_noise },
            gate: chi_squared_3(settings.gate),
            fitness_memory: settings.fitness_memory,
            null_factor: settings.null_factor.powf(frames),
            min_fitness: settings.min_fitness,
            max_hypotheses: settings.max_hypotheses as usize,
        }
    }

    /// Whether a blob's shown model is below the least fitness.
    pub fn is_unfit(&self, blob: &Blob) -> bool {
        blob.shown().fitness.value() < self.min_fitness
    }

    /// Branches every hypothesis into one for each observation in its gate and one null match, and chooses the joint
    /// matching of greatest total likelihood in which no observation is explained twice. Returns for each blob the
    /// observation matched to it.
    pub fn match_observations(
        &self,
        blobs: &mut [&mut Blob],
        observations: &[Observation],
    ) -> Vec<Option<usize>> {
        let measurements = Measurements::new(observations);
        let branches: Vec<Vec<Hypothesis>> =
            blobs.iter().map(|blob| self.branch(blob.hypotheses(), &measurements)).collect();
        let chosen = best_joint_matching(&branches);
        for ((blob, branches), &matched) in blobs.iter_mut().zip(branches).zip(&chosen) {
            blob.show(branches, matched);
            if let Some(observation) = matched.and_then(|at| observations.get(at)) {
                blob.lost = 0;
                blob.bbox = observation.bbox;
            } else {
                blob.lost += 1;
                let travel = blob.periods * blob.shown().model.velocity();
                blob.bbox = blob.bbox.moved(travel.x, travel.y);
            }
        }
        self.prune(blobs);
        chosen
    }

    /// Matches blobs without a region to unexplained regions: an object that accelerates suddenly leaves the gate of
    /// constant velocity, but hardly moves farther per frame than its own size. Returns pairs of indices into `blobs`
    /// and `observations`, the likeliest first, each in one pair at most.
    pub fn match_manoeuvres(&self, blobs: &[&Blob], observations: &[&Observation]) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        let measurements = Measurements::new(observations.iter().copied());
        for (row, blob) in blobs.iter().enumerate() {
            let model = &blob.shown().model;
            let expected = model.expected_measurement(MANOEUVRE_SIGMA * model.scale());
            for (column, _, innovation) in measurements.within_gate(&expected, self.gate) {
                pairs.push((innovation.log_likelihood(), row, column));
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let (mut rows, mut columns) = (BTreeSet::new(), BTreeSet::new());
        pairs.retain(|(_, row, column)| {
            let free = !rows.contains(row) && !columns.contains(column);
            if free {
                rows.insert(*row);
                columns.insert(*column);
            }
            free
        });
        pairs.into_iter().map(|(_, row, column)| (row, column)).collect()
    }

    /// Updates a blob with an observation after a manoeuvre.
    pub fn update_after_manoeuvre(blob: &mut Blob, observation: &Observation) {
        let manoeuvre = MANOEUVRE_SIGMA * blob.shown().model.scale();
        blob.keep_shown(observation, |model| {
            model.update_after_manoeuvre(&observation.measurement(), manoeuvre);
        });
    }

    /// The branches of a blob's hypotheses: of several with the same observation, the best.
    fn branch<'a>(
        &self,
        parents: impl Iterator<Item = &'a Hypothesis>,
        measurements: &Measurements,
    ) -> Vec<Hypothesis> {
        let mut children: Vec<Hypothesis> = Vec::new();
        for parent in parents {
            let expected = parent.model.expected_measurement(0.0);
            let matches =
                measurements.within_gate(&expected, self.gate).map(|(index, measured, innovation)| {
                    let mut child = parent.clone();
                    child.model.update(measured, 1.0);
                    child.fitness.record_match(innovation.distance_squared, self.fitness_memory);
                    child.score += innovation.log_likelihood();
                    child.matched = Some(index);
                    child
                });
            // A null match is as likely as a match at the edge of the gate.
            let mut null = parent.clone();
            null.fitness.record_miss(self.null_factor);
            null.score -= 0.5 * self.gate;
            null.matched = None;
            for child in matches.chain([null]) {
                match children.iter_mut().find(|other| other.matched == child.matched) {
                    Some(other) if other.score >= child.score => {}
                    Some(other) => *other = child,
                    None => children.push(child),
                }
            }
        }
        children
    }

    /// Drops the hypotheses that cannot win any more, and the least probable beyond the cap.
    fn prune(&self, blobs: &mut [&mut Blob]) {
        for blob in blobs.iter_mut() {
            blob.others.retain(|other| other.score >= MIN_SCORE && other.fitness.value() >= self.min_fitness);
            blob.others.sort_by(|a, b| b.score.total_cmp(&a.score));
            blob.others.truncate(MAX_HYPOTHESES_PER_BLOB - 1);
        }
        let total: usize = blobs.iter().map(|blob| 1 + blob.others.len()).sum();
        if total <= self.max_hypotheses {
            return;
        }
        let mut scores: Vec<f32> =
            blobs.iter().flat_map(|blob| blob.others.iter().map(|other| other.score)).collect();
        scores.sort_by(|a, b| b.total_cmp(a));
        let room = self.max_hypotheses.saturating_sub(blobs.len());
        let least = scores.get(room).copied().unwrap_or(f32::NEG_INFINITY);
        for blob in blobs {
            blob.others.retain(|other| other.score > least);
        }
    }
}

/// In thousandths of a nat: far below what any sum of real scores reaches.
const IMPOSSIBLE_SCORE: i64 = -1_000_000_000;

/// For each blob, of whose hypotheses these are the branches, the observation (or none) that maximises the total
/// score; blobs come oldest first, and on a tie the older keeps its match.
fn best_joint_matching(branches: &[Vec<Hypothesis>]) -> Vec<Option<usize>> {
    let sought: Vec<Vec<usize>> =
        branches.iter().map(|each| each.iter().filter_map(|branch| branch.matched).collect()).collect();
    // Blobs that share no observation, nor by way of others, do not depend on each other.
    let (_, parts) = separate_components(&sought);
    let mut blobs_of = BTreeMap::<usize, Vec<(usize, &[Hypothesis])>>::new();
    for (row, (part, branches)) in parts.into_iter().zip(branches).enumerate() {
        if branches.iter().any(|branch| branch.matched.is_some()) {
            blobs_of.entry(part).or_default().push((row, branches));
        }
    }
    let chosen: BTreeMap<usize, usize> =
        blobs_of.values().flat_map(|blobs| best_matching_of_part(blobs)).collect();
    (0..branches.len()).map(|row| chosen.get(&row).copied()).collect()
}

/// The best joint matching of some blobs, each given by its row and its branches: the rows that get an observation,
/// each with that.
fn best_matching_of_part(blobs: &[(usize, &[Hypothesis])]) -> Vec<(usize, usize)> {
    let matched = blobs.iter().flat_map(|(_, branches)| branches.iter()).filter_map(|branch| branch.matched);
    let observations: Vec<usize> = matched.collect::<BTreeSet<usize>>().into_iter().collect();
    let thousandths = |score: f32| (f64::from(score) * 1000.0).round() as i64;
    let mut scores = Matrix::new(blobs.len(), observations.len() + blobs.len(), IMPOSSIBLE_SCORE);
    for (row, (_, branches)) in blobs.iter().enumerate() {
        for branch in *branches {
            let column = branch.matched.and_then(|at| observations.binary_search(&at).ok());
            if let Some(score) = scores.get_mut((row, column.unwrap_or(observations.len() + row))) {
                *score = thousandths(branch.score);
            }
        }
    }
    let (_, columns) = kuhn_munkres(&scores);
    let rows = blobs.iter().map(|(row, _)| *row);
    rows.zip(columns).filter_map(|(row, column)| Some((row, *observations.get(column)?))).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use proptest::prelude::*;

    use super::*;
    use crate::settings::Preset;

    fn at(x: f32, y: f32) -> Observation {
        Observation { bbox: Rect::around([x, y], 20.0, 40.0), area: 800.0 }
    }

    fn settings() -> HypothesisMatcher {
        HypothesisMatcher::new(&Settings::preset(Preset::Plain), 25.0)
    }

    fn blob(x: f32, y: f32, vx: f32) -> Blob {
        let model =
            KalmanModel::through(at(x - vx, y).measurement(), at(x, y).measurement(), 1.0, settings().noise);
        Blob::new(model, &at(x, y))
    }

    fn step_with(
        settings: &HypothesisMatcher,
        blobs: &mut [Blob],
        observations: &[Observation],
    ) -> Vec<Option<usize>> {
        for blob in blobs.iter_mut() {
            blob.predict(1.0);
        }
        settings.match_observations(&mut blobs.iter_mut().collect::<Vec<_>>(), observations)
    }

    fn step(blobs: &mut [Blob], observations: &[Observation]) -> Vec<Option<usize>> {
        step_with(&settings(), blobs, observations)
    }

    #[test]
    fn each_blob_is_matched_to_the_region_it_predicts_even_side_by_side() {
        let mut blobs = [blob(100.0, 50.0, 3.0), blob(108.0, 50.0, -3.0)];
        assert_eq!(step(&mut blobs, &[at(105.0, 50.0), at(103.0, 50.0)]), [Some(1), Some(0)]);
        assert!(blobs[0].hypotheses().count() > 1, "the other hypothesis stays");
    }

    #[test]
    fn after_a_null_match_the_prediction_stands_and_the_fitness_falls() {
        let mut blobs = [blob(100.0, 50.0, 3.0)];
        let fit = blobs[0].shown().fitness.value();
        assert_eq!(step(&mut blobs, &[at(300.0, 50.0)]), [None]);
        assert!((blobs[0].shown().model.centre()[0] - 103.0).abs() < 1e-3);
        assert!((blobs[0].shown().fitness.value() / fit - 0.8).abs() < 1e-4);
        assert_eq!(step(&mut blobs, &[at(106.0, 50.0)]), [Some(0)], "it regains the region");
        assert_eq!(blobs[0].lost, 0);
    }

    #[test]
    fn without_a_region_a_model_is_unfit_after_a_fifth_of_a_second_and_sooner_where_it_predicts_badly() {
        let frames_until_unfit = |fps: f32, mean_error: f32| {
            let settings = HypothesisMatcher::new(&Settings::default(), fps);
            let mut blobs = [blob(100.0, 50.0, 3.0)];
            blobs[0].shown.fitness.mean_error = mean_error;
            let mut frames = 0;
            while !settings.is_unfit(&blobs[0]) {
                step_with(&settings, &mut blobs, &[]);
                frames += 1;
            }
            frames
        };
        let of_rates = |mean_error| [7.0, 10.0, 25.0, 50.0].map(|fps| frames_until_unfit(fps, mean_error));
        assert_eq!(of_rates(EXPECTED_ERROR), [3, 3, 5, 10]);
        assert_eq!(of_rates(0.1), [3, 3, 5, 10], "smaller errors than expected do not raise the fitness");
        assert_eq!(of_rates(6.0), [2, 2, 2, 4]);
    }

    #[test]
    fn a_summary_says_whether_the_hypothesis_matched_a_region() {
        let matched = |blob: &Blob| blob.summaries(12.0).iter().map(|each| each.matched).collect::<Vec<_>>();
        let mut blobs = [blob(100.0, 50.0, 3.0)];
        assert_eq!(matched(&blobs[0]), [true], "it stands at one");
        step(&mut blobs, &[]);
        assert_eq!(matched(&blobs[0]), [false], "a null match");
        blobs[0].keep_shown(&at(106.0, 50.0), |_| {});
        assert_eq!(matched(&blobs[0]), [true]);
        step(&mut blobs, &[at(109.0, 50.0)]);
        assert_eq!(matched(&blobs[0])[..2], [true, false], "the region, or none");
    }

    #[test]
    fn a_manoeuvre_out_of_the_gate_is_matched_and_a_farther_region_is_not() {
        let settings = settings();
        let mut blobs = [blob(100.0, 50.0, 3.0), blob(300.0, 50.0, 3.0)];
        let (manoeuvred, far) = (at(118.0, 62.0), at(420.0, 50.0));
        assert_eq!(step_with(&settings, &mut blobs, &[manoeuvred.clone(), far.clone()]), [None, None]);
        let lost: Vec<&Blob> = blobs.iter().collect();
        assert_eq!(settings.match_manoeuvres(&lost, &[&far, &manoeuvred]), [(0, 1)]);
        HypothesisMatcher::update_after_manoeuvre(&mut blobs[0], &manoeuvred);
        assert_eq!(blobs[0].lost, 0);
        let [x, y] = blobs[0].shown().model.centre();
        assert!((x - 118.0).abs() < 2.0 && (y - 62.0).abs() < 2.0);
    }

    #[test]
    fn a_region_within_reach_of_two_manoeuvres_is_matched_to_the_nearer_blob() {
        let settings = settings();
        let blobs = [blob(100.0, 50.0, 0.0), blob(130.0, 50.0, 0.0)];
        let lost: Vec<&Blob> = blobs.iter().collect();
        assert_eq!(settings.match_manoeuvres(&lost, &[&at(120.0, 60.0)]), [(1, 0)]);
    }

    #[test]
    fn a_later_frame_can_reverse_an_earlier_match() {
        // Two regions lie in the gate; the nearer one stands still and is gone in the next frame,
        // the other goes on at the blob's velocity.
        let mut blobs = [blob(100.0, 50.0, 4.0)];
        assert_eq!(step(&mut blobs, &[at(102.0, 50.0), at(107.5, 50.0)]), [Some(0)]);
        let mut reversed = false;
        for frame in 1..4 {
            let matched = step(&mut blobs, &[at(107.5 + 4.0 * frame as f32, 50.0)]);
            reversed |= matched == [Some(0)];
        }
        assert!(reversed);
        assert!((blobs[0].shown().model.centre()[0] - 119.5).abs() < 3.0);
    }

    #[test]
    fn the_pool_never_has_more_hypotheses_than_its_limit() {
        let mut capped = settings();
        capped.max_hypotheses = 12;
        let mut blobs: Vec<_> = (0..10).map(|n| blob(100.0 + n as f32, 50.0, 0.0)).collect();
        let crowd: Vec<_> = (0..30).map(|n| at(95.0 + 0.5 * n as f32, 50.0)).collect();
        for _ in 0..5 {
            step_with(&capped, &mut blobs, &crowd);
            assert!(blobs.iter().map(|blob| blob.hypotheses().count()).sum::<usize>() <= 12);
        }
    }

    #[test]
    fn the_fitness_is_a_running_mean_of_the_errors() {
        let mut fitness = Fitness { mean_error: 4.0, nulls: 0.5 };
        fitness.record_match(10.0, 8);
        assert_eq!(fitness, Fitness { mean_error: 4.75, nulls: 1.0 });
        fitness.record_miss(0.8);
        assert_eq!(fitness.value(), 0.8 / 4.75);
        let mut blobs = [blob(100.0, 50.0, 3.0)];
        let mut settings = settings();
        settings.min_fitness = blobs[0].shown().fitness.value();
        assert!(!settings.is_unfit(&blobs[0]), "the least fitness is enough");
        step_with(&settings, &mut blobs, &[at(107.0, 52.0)]);
        let innovation = {
            let mut before = blob(100.0, 50.0, 3.0);
            before.predict(1.0);
            before.shown().model.expected_measurement(0.0).distance_squared(&at(107.0, 52.0).measurement())
        };
        let mean = EXPECTED_ERROR + (innovation - EXPECTED_ERROR) / settings.fitness_memory as f32;
        assert!((blobs[0].shown().fitness.mean_error - mean).abs() < 1e-4);
    }

    /// A hypothesis with this score and match.
    fn hypothesis(score: f32, matched: Option<usize>) -> Hypothesis {
        Hypothesis { score, matched, ..blob(100.0, 50.0, 0.0).shown }
    }

    fn scores(blob: &Blob) -> Vec<f32> {
        blob.hypotheses().map(|each| each.score).collect()
    }

    #[test]
    fn scores_are_relative_to_the_shown_hypothesis_and_probabilities_to_all() {
        let mut blob = blob(100.0, 50.0, 0.0);
        blob.show(
            vec![hypothesis(-2.5, None), hypothesis(-3.0, Some(1)), hypothesis(-7.0, Some(0))],
            Some(1),
        );
        assert_eq!(scores(&blob), [0.0, 0.5, -4.0]);
        let total = 1.0 + 0.5_f32.exp() + (-4.0_f32).exp();
        for (summary, score) in blob.summaries(12.0).iter().zip([0.0_f32, 0.5, -4.0]) {
            assert!((summary.probability - score.exp() / total).abs() < 1e-6, "{}", summary.probability);
        }
    }

    #[test]
    fn of_two_pasts_with_the_same_region_the_likelier_goes_on() {
        let parents = |first: f32, second: f32| {
            [(first, 101.0), (second, 100.0)]
                .map(|(score, x)| Hypothesis { score, ..blob(x, 50.0, 0.0).shown })
        };
        let observation = at(100.0, 50.0);
        let measured = observation.measurement();
        // The second predicts better, the first was likelier before.
        for (first, second, wins) in [(0.0, -0.01, 1), (0.0, -5.0, 0), (-5.0, 0.0, 1)] {
            let parents = parents(first, second);
            let children = settings().branch(parents.iter(), &Measurements::new([&observation]));
            let [with, without] = &children[..] else { panic!("{children:?}") };
            assert_eq!((with.matched, without.matched), (Some(0), None));
            let innovation = parents[wins].model.expected_measurement(0.0).innovation(&measured);
            assert_eq!(with.score, parents[wins].score + innovation.log_likelihood());
            assert_eq!(without.score, first.max(second) - 0.5 * settings().gate);
        }
    }

    #[test]
    fn improbable_unfit_and_surplus_hypotheses_are_dropped() {
        let with = |others: &[f32]| {
            let others = others.iter().map(|&score| hypothesis(score, None)).collect();
            Blob { others, ..blob(100.0, 50.0, 0.0) }
        };
        let prune = |settings: &HypothesisMatcher, mut blobs: Vec<Blob>| {
            settings.prune(&mut blobs.iter_mut().collect::<Vec<_>>());
            blobs.iter().map(scores).collect::<Vec<_>>()
        };
        let mut settings = settings();
        settings.max_hypotheses = 100;
        assert_eq!(prune(&settings, vec![with(&[-8.5, -1.0, -8.0, 0.5])]), [[0.0, 0.5, -1.0, -8.0]]);
        let many = with(&[-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0]);
        assert_eq!(prune(&settings, vec![many]), [[0.0, -1.0, -2.0, -3.0, -4.0, -5.0]]);
        let mut unfit = with(&[-1.0, -2.0]);
        unfit.others[0].fitness.nulls = 1e-3;
        assert_eq!(prune(&settings, vec![unfit]), [[0.0, -2.0]]);

        // Seven of two blobs; with room for them all stay, one less leaves the least probable out.
        let blobs = || vec![with(&[-1.0, -4.0]), with(&[-2.0, -3.0, -5.0])];
        settings.max_hypotheses = 7;
        assert_eq!(prune(&settings, blobs()), [vec![0.0, -1.0, -4.0], vec![0.0, -2.0, -3.0, -5.0]]);
        settings.max_hypotheses = 6;
        assert_eq!(prune(&settings, blobs()), [vec![0.0, -1.0, -4.0], vec![0.0, -2.0, -3.0]]);
        settings.max_hypotheses = 3;
        assert_eq!(prune(&settings, blobs()), [vec![0.0, -1.0], vec![0.0]]);
    }

    #[test]
    fn a_manoeuvre_reaches_in_proportion_to_the_object() {
        let settings = settings();
        let mut lost = blob(100.0, 50.0, 0.0);
        lost.predict(1.0);
        let reached = |x: f32| !settings.match_manoeuvres(&[&lost], &[&at(x, 50.0)]).is_empty();
        assert!(reached(125.0), "about an object's length");
        assert!(!reached(160.0));
        let sigma = 0.4 * 800.0_f32.sqrt();
        let mut expected = lost.shown().model.clone();
        expected.update_after_manoeuvre(&at(125.0, 50.0).measurement(), sigma);
        HypothesisMatcher::update_after_manoeuvre(&mut lost, &at(125.0, 50.0));
        assert_eq!(lost.shown().model, expected);
    }

    /// The greatest total score of matchings of these blobs to what is not yet taken.
    fn greatest_total(branches: &[Vec<Hypothesis>], taken: &[usize]) -> f32 {
        let Some((first, rest)) = branches.split_first() else { return 0.0 };
        let free = first.iter().filter(|branch| branch.matched.is_none_or(|at| !taken.contains(&at)));
        let totals = free.map(|branch| {
            let taken: Vec<usize> = taken.iter().copied().chain(branch.matched).collect();
            branch.score + greatest_total(rest, &taken)
        });
        totals.fold(f32::NEG_INFINITY, f32::max)
    }

    proptest! {
        #[test]
        fn the_joint_matching_has_the_greatest_total_score(
            scores in prop::collection::vec(
                (prop::collection::btree_map(0_usize..6, -64_i8..64, 0..4), -64_i8..0), 0..6,
            ),
        ) {
            let branches: Vec<Vec<Hypothesis>> = scores
                .iter()
                .map(|(matches, null)| {
                    let matches = matches.iter().map(|(&at, &score)| hypothesis(f32::from(score), Some(at)));
                    matches.chain([hypothesis(f32::from(*null), None)]).collect()
                })
                .collect();
            let chosen = best_joint_matching(&branches);
            let score = |(branches, matched): (&Vec<Hypothesis>, &Option<usize>)| {
                branches.iter().find(|branch| branch.matched == *matched).map(|branch| branch.score)
            };
            let total: Option<f32> = branches.iter().zip(&chosen).map(score).sum();
            prop_assert_eq!(total, Some(greatest_total(&branches, &[])));
            let mut taken: Vec<usize> = chosen.iter().flatten().copied().collect();
            taken.sort_unstable();
            prop_assert!(taken.windows(2).all(|pair| pair[0] < pair[1]), "{:?}", chosen);
        }
    }
}
