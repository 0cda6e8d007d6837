//! A pixel's verdict under other settings: a map over two settings, and the nearest value of each at which the
//! verdict flips.
//!
//! Every result is a re-run of the pixel over its values, from the model's start to the current frame. T determines
//! only the background and not the mixture, so that one run is enough for all of its values. With feedback T affects
//! the mixture, and needs a run per value like the others.

mod flips;
mod pixel_tuning;
mod region_tuning;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::mixture::pixel::{MAX_K, Outcome, Parameters, Pixel, PixelValue};
use crate::settings::{Setting, SettingError, Settings, Value};

pub use flips::{FlipSearch, VerdictFlip, flip};
pub use pixel_tuning::{StepwiseTuning, Tuning, TuningQuery};
pub use region_tuning::{RegionTuning, RegionTuningQuery, StepwiseRegionTuning};

/// Number of cells along an axis of a map, for settings that are not integers.
pub const CELLS: usize = 24;

/// A tunable setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TunableSetting {
    /// α, the learning rate.
    Alpha,
    /// T, the least portion of the data that the background accounts for.
    T,
    /// K, the number of components.
    K,
    /// λ, the match threshold in standard deviations.
    Lambda,
    /// σ₀, the standard deviation of a new component.
    InitialSigma,
}

impl TunableSetting {
    /// All tunable settings.
    pub const ALL: [Self; 5] = [Self::Alpha, Self::T, Self::K, Self::Lambda, Self::InitialSigma];

    /// Its symbol.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Alpha => "α",
            Self::T => "T",
            Self::K => "K",
            Self::Lambda => "λ",
            Self::InitialSigma => "σ₀",
        }
    }

    /// Its name in settings files and tables.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Alpha => "alpha",
            Self::T => "t",
            Self::K => "k",
            Self::Lambda => "match_sigmas",
            Self::InitialSigma => "initial_sigma",
        }
    }

    /// A short description.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Alpha => "learning rate",
            Self::T => "background ratio",
            Self::K => "components",
            Self::Lambda => "match threshold",
            Self::InitialSigma => "initial std. dev.",
        }
    }

    /// Whether it has a logarithmic scale.
    pub const fn is_logarithmic(self) -> bool {
        matches!(self, Self::Alpha)
    }

    /// Whether it affects the decision but not the mixture, so that one run is enough for all of its values.
    fn is_decision_only(self, parameters: &Parameters) -> bool {
        self == Self::T && !parameters.feedback.is_on()
    }

    /// Its value in `parameters`.
    pub const fn get(self, parameters: &Parameters) -> f32 {
        match self {
            Self::Alpha => parameters.alpha,
            Self::T => parameters.t,
            Self::K => parameters.k as f32,
            Self::Lambda => parameters.lambda,
            Self::InitialSigma => parameters.initial_sigma,
        }
    }

    /// `parameters` with this value; K is rounded.
    pub fn with(self, parameters: &Parameters, value: f32) -> Parameters {
        let mut parameters = *parameters;
        match self {
            Self::Alpha => parameters.alpha = value,
            Self::T => parameters.t = value,
            Self::K => parameters.k = (value.round() as usize).clamp(1, MAX_K),
            Self::Lambda => parameters.lambda = value,
            Self::InitialSigma => parameters.initial_sigma = value,
        }
        parameters
    }

    /// Sets the value in `settings`.
    pub fn set(self, settings: &mut Settings, value: f32) -> Result<(), SettingError> {
        let value = match self {
            Self::K => Value::Integer(value.round().max(0.0) as u32),
            _ => Value::Real(value),
        };
        let setting = Setting::named(self.key());
        setting.ok_or_else(|| SettingError::Unknown(self.key().to_owned()))?.set(settings, value)
    }

    /// The range of interest: all allowed values, but for α and T without the extremes.
    const fn range(self) -> (f32, f32) {
        match self {
            Self::Alpha => (0.0005, 0.5),
            Self::T => (0.01, 0.99),
            Self::K => (1.0, MAX_K as f32),
            Self::Lambda => (0.5, 10.0),
            Self::InitialSigma => (1.0, 128.0),
        }
    }

    /// The value on the setting's scale, linear or logarithmic, and back.
    fn scaled(self, value: f32) -> f64 {
        if self.is_logarithmic() { f64::from(value).ln() } else { f64::from(value) }
    }

    fn unscaled(self, scaled: f64) -> f32 {
        (if self.is_logarithmic() { scaled.exp() } else { scaled }) as f32
    }
}

/// One axis of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct SettingAxis {
    /// The setting.
    pub setting: TunableSetting,
    /// The value of each cell, ascending.
    pub values: Vec<f32>,
    ends: (f32, f32),
}

impl SettingAxis {
    /// An axis that includes `present`.
    pub fn new(setting: TunableSetting, present: f32) -> Self {
        let (low, high) = setting.range();
        if setting == TunableSetting::K {
            return Self {
                setting,
                values: (1..=MAX_K).map(|k| k as f32).collect(),
                ends: (0.5, high + 0.5),
            };
        }
        let ends = (low.min(present), high.max(present));
        let mut axis = Self { setting, values: Vec::new(), ends };
        let centres = (0..CELLS).map(|cell| (cell as f32 + 0.5) / CELLS as f32);
        axis.values = centres.map(|share| rounded(axis.value_at(share), 3, Rounding::Nearest)).collect();
        axis
    }

    /// The position of `value` on the axis, 0 at its low end and 1 at its high end.
    pub fn share_of(&self, value: f32) -> f32 {
        let (low, high) = (self.setting.scaled(self.ends.0), self.setting.scaled(self.ends.1));
        ((self.setting.scaled(value) - low) / (high - low)) as f32
    }

    /// The value at a position of the axis, 0..=1.
    pub fn value_at(&self, share: f32) -> f32 {
        let (low, high) = (self.setting.scaled(self.ends.0), self.setting.scaled(self.ends.1));
        self.setting.unscaled(low + f64::from(share) * (high - low))
    }

    /// The cell at a position of the axis, 0..=1.
    pub fn cell_at(&self, share: f32) -> usize {
        let cells = self.values.len();
        ((share.max(0.0) * cells as f32) as usize).min(cells.saturating_sub(1))
    }
}

/// The state of the pixel after the last value of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunOutcome {
    pixel: Pixel,
    outcome: Outcome,
    /// Whether T affected the run, so that the result is valid for its own T only.
    bound: bool,
    /// The number of values.
    frames: usize,
}

impl RunOutcome {
    /// Whether the pixel is foreground under this T, which must be that of the run where feedback is on.
    pub fn is_foreground(&self, t: f32) -> bool {
        if self.bound {
            return self.outcome.foreground;
        }
        // The first frame is background without a comparison.
        self.frames > 1
            && (self.outcome.matched == 0 || usize::from(self.outcome.rank) > self.pixel.background_count(t))
    }
}

/// Runs a new pixel through all of `values`.
pub fn run(values: &[PixelValue], parameters: &Parameters) -> RunOutcome {
    let mut pixel = Pixel::unseen(parameters.k);
    let mut outcome = Outcome::default();
    for (t, &value) in (1..).zip(values) {
        outcome = pixel.step(value, t, parameters);
    }
    RunOutcome { pixel, outcome, bound: parameters.feedback.is_on(), frames: values.len() }
}

/// The axes of a grid of two settings around `parameters`, and the parameters of each cell, row by row.
pub fn grid(
    parameters: &Parameters,
    tuned_settings: [TunableSetting; 2],
) -> ([SettingAxis; 2], Vec<Parameters>) {
    let axes = VerdictMap::axes(parameters, tuned_settings);
    let [across, along] = &axes;
    let rows = along.values.iter().map(|&y| along.setting.with(parameters, y));
    let cells = rows.flat_map(|row| across.values.iter().map(move |&x| across.setting.with(&row, x)));
    let cells = cells.collect();
    (axes, cells)
}

/// The classification of a pixel over a grid of two settings.
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictMap {
    /// The settings along a row and along a column; two different ones.
    pub axes: [SettingAxis; 2],
    /// The classification of each cell, row by row.
    foreground: Vec<bool>,
}

impl VerdictMap {
    /// The axes of a map around `parameters`.
    pub fn axes(parameters: &Parameters, tuned_settings: [TunableSetting; 2]) -> [SettingAxis; 2] {
        tuned_settings.map(|setting| SettingAxis::new(setting, setting.get(parameters)))
    }

    /// The runs that a map needs: one per cell, or one per row or column where the other setting is T and does not
    /// affect the mixture.
    pub fn runs(parameters: &Parameters, axes: &[SettingAxis; 2]) -> Vec<Parameters> {
        let values = |axis: &SettingAxis| {
            if axis.setting.is_decision_only(parameters) { vec![parameters.t] } else { axis.values.clone() }
        };
        let (across, along) = (values(&axes[0]), values(&axes[1]));
        let rows = along.iter().map(|&y| axes[1].setting.with(parameters, y));
        rows.flat_map(|row| across.iter().map(move |&x| (row, x)))
            .map(|(row, x)| axes[0].setting.with(&row, x))
            .collect()
    }

    /// The map from the outcomes of [`Self::runs`], in the same order.
    pub fn of(parameters: &Parameters, axes: [SettingAxis; 2], outcomes: &[RunOutcome]) -> Self {
        let [across, along] = &axes;
        let mut foreground = Vec::with_capacity(across.values.len() * along.values.len());
        for (row, &y) in along.values.iter().enumerate() {
            for (column, &x) in across.values.iter().enumerate() {
                let at = if across.setting.is_decision_only(parameters) {
                    row
                } else if along.setting.is_decision_only(parameters) {
                    column
                } else {
                    row * across.values.len() + column
                };
                let cell = along.setting.with(&across.setting.with(parameters, x), y);
                foreground.push(outcomes.get(at).is_some_and(|outcome| outcome.is_foreground(cell.t)));
            }
        }
        Self { axes, foreground }
    }

    /// Whether the pixel is foreground in a cell.
    pub fn is_foreground(&self, column: usize, row: usize) -> bool {
        self.foreground.get(row * self.axes[0].values.len() + column).copied().unwrap_or(false)
    }

    /// The share of foreground cells, 0..=1.
    pub fn foreground_share(&self) -> f32 {
        let foreground = self.foreground.iter().filter(|&&cell| cell).count();
        foreground as f32 / self.foreground.len().max(1) as f32
    }
}

/// The map of `tuned_settings` around `parameters` for a pixel with these values.
pub fn map(
    values: &[PixelValue],
    parameters: &Parameters,
    tuned_settings: [TunableSetting; 2],
) -> VerdictMap {
    let axes = VerdictMap::axes(parameters, tuned_settings);
    let outcomes: Vec<_> =
        VerdictMap::runs(parameters, &axes).par_iter().map(|parameters| run(values, parameters)).collect();
    VerdictMap::of(parameters, axes, &outcomes)
}

#[derive(Clone, Copy, PartialEq)]
enum Rounding {
    Nearest,
    Up,
    Down,
}

/// The positive `value` rounded to this many significant digits.
fn rounded(value: f32, digits: i32, how: Rounding) -> f32 {
    let value = f64::from(value);
    if value <= 0.0 {
        return value as f32;
    }
    // Powers of ten with non-negative integer exponents are exact.
    let places = digits - 1 - value.log10().floor() as i32;
    let power = 10_f64.powi(places.abs());
    let whole = if places >= 0 { value * power } else { value / power };
    let whole = match how {
        Rounding::Nearest => whole.round(),
        Rounding::Up => whole.ceil(),
        Rounding::Down => whole.floor(),
    };
    (if places >= 0 { whole / power } else { whole * power }) as f32
}
