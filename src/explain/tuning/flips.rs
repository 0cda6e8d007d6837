//! Finds, by re-running the pixel, the nearest value of each setting at which its verdict flips.

use rayon::prelude::*;

use super::{Rounding, RunOutcome, TunableSetting, rounded, run};
use crate::mixture::pixel::{Parameters, PixelValue};

/// Number of search steps on each side of the present value.
const MAX_STEPS: usize = 24;
/// Number of bisections of the step that contains the flip.
const MAX_BISECTIONS: usize = 14;
/// Range of significant digits of the result: as few as preserve the flip.
const MIN_DIGITS: i32 = 3;
const MAX_DIGITS: i32 = 5;

/// The nearest value of one setting that flips a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerdictFlip {
    /// The setting.
    pub setting: TunableSetting,
    /// The value nearest to the present one at which the verdict flips, on a logarithmic scale where the setting has
    /// one. `None` if none was found.
    pub value: Option<f32>,
    /// Whether it is greater than the present value.
    pub above: bool,
}

impl VerdictFlip {
    /// A short form: `α ≥ 0.013`, `no value of T`.
    pub fn words(&self) -> String {
        let symbol = self.setting.symbol();
        match self.value {
            None => format!("no value of {symbol}"),
            Some(value) => format!("{symbol} {} {value}", if self.above { '≥' } else { '≤' }),
        }
    }
}

/// The nearest value of `setting` at which the verdict after `values` differs from that under `parameters`.
///
/// Each side of the present value is searched in steps, and the first step whose end flips is bisected; two flips
/// within one step are not found. The returned value has been verified to flip the verdict.
pub fn flip(values: &[PixelValue], parameters: &Parameters, setting: TunableSetting) -> VerdictFlip {
    let mut search = FlipSearch::new(parameters, &[setting]);
    loop {
        if let Some(&[found]) = search.advance(values).as_deref() {
            return found;
        }
    }
}

/// An incremental search as in [`flip`] for several settings at once.
pub struct FlipSearch {
    parameters: Parameters,
    /// The outcome under the present settings.
    present: Option<RunOutcome>,
    /// The search on both sides of the present value, for each setting.
    sides: Vec<[SearchSide; 2]>,
}

impl FlipSearch {
    /// A search before its first run.
    pub fn new(parameters: &Parameters, tuned_settings: &[TunableSetting]) -> Self {
        let sides = |&setting: &TunableSetting| {
            [false, true].map(|above| SearchSide::new(setting, setting.get(parameters), above))
        };
        Self { parameters: *parameters, present: None, sides: tuned_settings.iter().map(sides).collect() }
    }

    /// Tries the next value on each side of each setting, with at most one run through `values` for each. Returns the
    /// results, in the order of the settings, when the search is complete.
    pub fn advance(&mut self, values: &[PixelValue]) -> Option<Vec<VerdictFlip>> {
        let parameters = self.parameters;
        let present = *self.present.get_or_insert_with(|| run(values, &parameters));
        let now = present.is_foreground(parameters.t);
        self.sides.as_flattened_mut().par_iter_mut().for_each(|side| {
            if let Some(value) = side.next() {
                let foreground = if side.setting.is_decision_only(&parameters) {
                    present.is_foreground(value)
                } else {
                    run(values, &side.setting.with(&parameters, value)).is_foreground(parameters.t)
                };
                side.learn(value, foreground != now);
            }
        });
        self.sides.iter().map(nearest).collect()
    }
}

/// The nearer of the results of both sides; `None` while they search.
fn nearest(sides: &[SearchSide; 2]) -> Option<VerdictFlip> {
    let [SearchStage::Done(below), SearchStage::Done(above)] = sides.each_ref().map(|side| side.stage) else {
        return None;
    };
    let SearchSide { setting, from, .. } = sides[0];
    let distance = |value: f32| (setting.scaled(value) - setting.scaled(from)).abs();
    let found = [below, above].into_iter().flatten().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    Some(VerdictFlip { setting, value: found, above: found.is_some_and(|value| value > from) })
}

/// The search on one side of the present value.
struct SearchSide {
    setting: TunableSetting,
    /// The present value.
    from: f32,
    above: bool,
    stage: SearchStage,
}

/// The stage of the search on one side.
#[derive(Clone, Copy)]
enum SearchStage {
    /// The verdict does not flip up to this step.
    Stepping(usize),
    /// The verdict does not flip at `inner` and flips at `outer`.
    Halving { inner: f32, outer: f32, left: usize },
    /// The verdict flips at `outer`; the value rounded to `digits` digits is tried next.
    Rounding { outer: f32, digits: i32 },
    /// The search is complete; the nearest value, if any.
    Done(Option<f32>),
}

impl SearchSide {
    fn new(setting: TunableSetting, from: f32, above: bool) -> Self {
        let mut side = Self { setting, from, above, stage: SearchStage::Stepping(0) };
        let end = side.end();
        if (above && from >= end) || (!above && from <= end) {
            side.stage = SearchStage::Done(None);
        }
        side
    }

    /// The limit of the search.
    const fn end(&self) -> f32 {
        let (low, high) = self.setting.range();
        if self.above { high } else { low }
    }

    /// The number of steps to the limit.
    fn steps(&self) -> usize {
        if self.setting == TunableSetting::K { (self.end() - self.from).abs() as usize } else { MAX_STEPS }
    }

    /// The value at a step.
    fn at(&self, step: usize) -> f32 {
        let Self { setting, from, above, .. } = *self;
        match step {
            0 => from,
            _ if setting == TunableSetting::K && above => from + step as f32,
            _ if setting == TunableSetting::K => from - step as f32,
            MAX_STEPS => self.end(),
            _ => {
                let (start, width) =
                    (setting.scaled(from), setting.scaled(self.end()) - setting.scaled(from));
                setting.unscaled(start + width * step as f64 / MAX_STEPS as f64)
            }
        }
    }

    /// The value to try next.
    fn next(&self) -> Option<f32> {
        let setting = self.setting;
        match self.stage {
            SearchStage::Stepping(step) => Some(self.at(step + 1)),
            SearchStage::Halving { inner, outer, .. } => {
                Some(setting.unscaled(f64::midpoint(setting.scaled(inner), setting.scaled(outer))))
            }
            SearchStage::Rounding { outer, digits } => Some(self.short(outer, digits)),
            SearchStage::Done(_) => None,
        }
    }

    /// Advances the search by the verdict at the tried value.
    fn learn(&mut self, value: f32, flips: bool) {
        self.stage = match self.stage {
            SearchStage::Stepping(_) if flips && self.setting == TunableSetting::K => {
                SearchStage::Done(Some(value))
            }
            SearchStage::Stepping(step) if flips => {
                SearchStage::Halving { inner: self.at(step), outer: value, left: MAX_BISECTIONS }
            }
            SearchStage::Stepping(step) if step + 1 < self.steps() => SearchStage::Stepping(step + 1),
            SearchStage::Stepping(_) => SearchStage::Done(None),
            SearchStage::Halving { inner, outer, left } => {
                let (inner, outer) = if flips { (inner, value) } else { (value, outer) };
                if left > 1 {
                    SearchStage::Halving { inner, outer, left: left - 1 }
                } else {
                    self.rounding(outer, MIN_DIGITS)
                }
            }
            SearchStage::Rounding { .. } if flips => SearchStage::Done(Some(value)),
            SearchStage::Rounding { outer, digits } => self.rounding(outer, digits + 1),
            SearchStage::Done(found) => SearchStage::Done(found),
        };
    }

    /// The value rounded to `digits` digits, away from the present value.
    fn short(&self, value: f32, digits: i32) -> f32 {
        rounded(value, digits, if self.above { Rounding::Up } else { Rounding::Down })
    }

    /// The stage after the bisection: rounding to the first number of digits, from `digits` on, within the setting's
    /// range.
    fn rounding(&self, outer: f32, digits: i32) -> SearchStage {
        let (low, high) = self.setting.range();
        let inside = |digits: &i32| (low..=high).contains(&self.short(outer, *digits));
        match (digits..=MAX_DIGITS).find(inside) {
            Some(digits) => SearchStage::Rounding { outer, digits },
            None => SearchStage::Done(Some(outer)),
        }
    }
}
