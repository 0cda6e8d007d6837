//! The mixture of one pixel: the reference implementation, which every optimised one has to equal bit for bit.
//!
//! A pixel's value X is a vector of n channels in 0..=255. Its recent history is modelled by K Gaussians, each with
//! weight w, mean μ and covariance σ²I, in rank order (descending w/σ). Arithmetic is f32, in the order in which it
//! is written here.

use std::f32::consts::PI;

use super::exponential::exp_of_negative;
use super::feedback::{Feedback, VerdictMemory};
use super::hysteresis::Hysteresis;
use super::shadow::Shadow;
use crate::registration;
use crate::settings::{Rate, Settings, Space, Span};

/// The largest K.
pub const MAX_K: usize = 8;

/// A pixel's value: n channels in 0..=255, those beyond n are 0.
pub type PixelValue = [f32; 3];

/// The parameters of the pixel process, with the symbols of §V–VI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// K, the number of components, 1..=8.
    pub k: usize,
    /// α, the learning rate, 0 < α < 1.
    pub alpha: f32,
    /// T, the least portion of the data that the background accounts for.
    pub t: f32,
    /// λ, the match threshold in standard deviations.
    pub lambda: f32,
    /// σ₀, the standard deviation of a new component.
    pub initial_sigma: f32,
    /// w₀, the weight of a new component.
    pub initial_weight: f32,
    /// σ_min, the least standard deviation.
    pub min_sigma: f32,
    /// The formula of ρ.
    pub rate: Rate,
    /// The colour space of X.
    pub space: Space,
    /// While t ≤ `warm_up`, α is max(α, 1/t).
    pub warm_up: u32,
    /// The part of a file to learn from before its first frame is classified.
    pub bootstrap: Span,
    /// The number of frames that were learned from: at most all frames of a file, and none of a camera. t counts
    /// them, and in them, too, α is max(α, 1/t), so that all have equal weight.
    pub learnt: u32,
    /// The detection of shadows in the foreground.
    pub shadow: Shadow,
    /// The reclassification of background near foreground.
    pub hysteresis: Hysteresis,
    /// The effect of past classification on the mixture.
    pub feedback: Feedback,
    /// The correction of the frame before X is read.
    pub registration: registration::CorrectionChoice,
}

impl Parameters {
    /// The parameters in `settings`, before any frame is learned from.
    pub fn new(settings: &Settings) -> Self {
        Self {
            k: settings.k as usize,
            alpha: settings.alpha,
            t: settings.t,
            lambda: settings.match_sigmas,
            initial_sigma: settings.initial_sigma,
            initial_weight: settings.initial_weight,
            min_sigma: settings.min_sigma,
            rate: settings.rate,
            space: settings.space,
            warm_up: settings.warm_up,
            bootstrap: settings.bootstrap,
            learnt: 0,
            shadow: Shadow::new(settings),
            hysteresis: Hysteresis::new(settings),
            feedback: Feedback::new(settings),
            registration: registration::CorrectionChoice::new(settings),
        }
    }

    /// Whether they equal those in `settings`, apart from the number of learned frames.
    pub fn equal_settings(&self, settings: &Settings) -> bool {
        Self { learnt: 0, ..*self } == Self::new(settings)
    }

    /// n, the number of channels.
    pub const fn channels(&self) -> usize {
        match self.space {
            Space::Rgb => 3,
            Space::Gray => 1,
        }
    }

    /// The names of X's n channels.
    pub const fn channel_names(&self) -> &'static [&'static str] {
        match self.space {
            Space::Rgb => &["R", "G", "B"],
            Space::Gray => &["Y"],
        }
    }

    /// α of the t-th frame, t from 1.
    pub fn alpha_at(&self, t: u32) -> f32 {
        if self.is_warming(t) { self.alpha.max(1.0 / t as f32) } else { self.alpha }
    }

    /// Whether the t-th frame is in the warm-up, or learned from before the first classified one.
    pub fn is_warming(&self, t: u32) -> bool {
        t <= self.warm_up.max(self.learnt)
    }

    /// Whether the t-th frame is only learned from.
    pub const fn is_learning(&self, t: u32) -> bool {
        t <= self.learnt
    }

    /// Whether the t-th frame is the first classified one after frames that were learned from.
    pub const fn begins_at(&self, t: u32) -> bool {
        self.learnt > 0 && t == self.learnt + 1
    }

    /// α of the t-th frame for a pixel with this memory. In the warm-up it is the same for all pixels.
    pub fn alpha_of(&self, past: &VerdictMemory, t: u32) -> f32 {
        let alpha = self.alpha_at(t);
        if self.is_warming(t) { alpha } else { (alpha * self.feedback.learning_factor(past)).min(1.0) }
    }

    /// T for a pixel with this memory.
    pub fn t_of(&self, past: &VerdictMemory) -> f32 {
        self.feedback.raised_t(self.t, past)
    }

    /// X of an RGB pixel.
    pub fn value(&self, rgb: [u8; 3]) -> PixelValue {
        match self.space {
            Space::Rgb => rgb.map(f32::from),
            Space::Gray => [f32::from(luma(rgb)), 0.0, 0.0],
        }
    }
}

/// BT.601 luma in 8 bits, rounded as in OpenCV's `COLOR_RGB2GRAY`.
#[inline(always)]
pub fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((9798 * u32::from(r) + 19235 * u32::from(g) + 3735 * u32::from(b) + (1 << 14)) >> 15) as u8
}

/// One Gaussian of a mixture. A component that was never used is all zeros.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Component {
    /// w, the share of the recent data that the component accounts for.
    pub weight: f32,
    /// μ.
    pub mean: PixelValue,
    /// σ², equal in all channels; it is estimated from the squared distance summed over the channels.
    pub variance: f32,
}

impl Component {
    /// σ.
    pub fn sigma(&self) -> f32 {
        self.variance.sqrt()
    }

    /// λσ: the largest distance from μ of a value that matches.
    pub fn reach(&self, lambda: f32) -> f32 {
        lambda * self.sigma()
    }

    /// w/σ, the sort key of the ranks; 0 for an unused component.
    pub fn rank_value(&self) -> f32 {
        if self.is_used() { self.weight / self.sigma() } else { 0.0 }
    }

    /// Whether the component is in use.
    pub fn is_used(&self) -> bool {
        self.weight > 0.0
    }

    /// ‖X − μ‖², summed over the channels.
    pub fn distance_squared(&self, x: PixelValue) -> f32 {
        let [r, g, b] = [x[0] - self.mean[0], x[1] - self.mean[1], x[2] - self.mean[2]];
        (r * r + g * g) + b * b
    }

    /// η(X; μ, σ²I) over `channels` channels, with the usual normaliser (2π)^(n/2)·σⁿ.
    pub fn density(&self, x: PixelValue, channels: usize) -> f32 {
        density(self.distance_squared(x), self.variance, channels)
    }
}

/// η for a squared distance and a variance: e^(−d²/2σ²) / ((2π)^(n/2)·σⁿ).
#[inline(always)]
pub fn density(distance_squared: f32, variance: f32, channels: usize) -> f32 {
    let two_pi_variance = 2.0 * PI * variance;
    let normaliser =
        if channels == 3 { two_pi_variance * two_pi_variance.sqrt() } else { two_pi_variance.sqrt() };
    exp_of_negative(-0.5 * distance_squared / variance) / normaliser
}

/// The first component in rank order within λ standard deviations of the value: ‖X − μ‖² ≤ λ²σ².
pub(super) fn first_match(components: &[Component], x: PixelValue, lambda: f32) -> Option<usize> {
    let lambda_squared = lambda * lambda;
    components.iter().position(|component| {
        component.is_used() && component.distance_squared(x) <= lambda_squared * component.variance
    })
}

/// The result of one update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The rank (from 1), before the update, of the matched component; 0 if none matched.
    pub matched: u8,
    /// The rank (from 1), after the update, of the matched or new component.
    pub rank: u8,
    /// B, the number of background components after the update.
    pub background_count: u8,
    /// Whether the pixel is foreground.
    pub foreground: bool,
    /// Whether the pixel is background, but farther from the mean of its component before the update than hysteresis
    /// allows near foreground.
    pub weak_match: bool,
    /// ρ, 0 if nothing matched.
    pub rho: f32,
    /// P(X), the density of the mixture at the value, before the update; 0 in the first frame.
    pub p: f32,
}

/// A pixel's mixture: K components in rank order, unused ones last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    components: [Component; MAX_K],
    k: usize,
    past: VerdictMemory,
}

impl Pixel {
    /// A pixel without data, with room for `k` components.
    pub fn unseen(k: usize) -> Self {
        Self {
            components: [Component::default(); MAX_K],
            k: k.clamp(1, MAX_K),
            past: VerdictMemory::default(),
        }
    }

    /// A pixel with these components, in rank order, unused ones last; at most [`MAX_K`].
    #[cfg(test)]
    pub(crate) fn from_components(components: &[Component]) -> Self {
        let mut pixel = Self::unseen(components.len());
        pixel.components[..components.len()].copy_from_slice(components);
        pixel
    }

    /// The K components in rank order.
    pub fn components(&self) -> &[Component] {
        &self.components[..self.k]
    }

    /// The pixel's past classification; constant while feedback is off.
    pub const fn past(&self) -> &VerdictMemory {
        &self.past
    }

    pub(super) const fn past_mut(&mut self) -> &mut VerdictMemory {
        &mut self.past
    }

    pub(super) fn components_mut(&mut self) -> &mut [Component] {
        &mut self.components[..self.k]
    }

    /// The number of components in use.
    pub fn used(&self) -> usize {
        self.components().iter().filter(|component| component.is_used()).count()
    }

    /// P(X) = Σ w·η(X; μ, σ²I), in rank order.
    pub fn probability(&self, x: PixelValue, channels: usize) -> f32 {
        let used = self.components().iter().filter(|component| component.is_used());
        used.fold(0.0, |sum, component| sum + component.weight * component.density(x, channels))
    }

    /// B: the smallest b with w₁ + … + w_b > T, all used components if none reaches it (§VI).
    pub fn background_count(&self, t: f32) -> usize {
        let mut sum = 0.0;
        for (index, component) in self.components().iter().enumerate() {
            sum += component.weight;
            if sum > t {
                return index + 1;
            }
        }
        self.used()
    }

    /// The weighted mean of the B background components.
    pub fn background_mean(&self, t: f32) -> PixelValue {
        let background = &self.components()[..self.background_count(t)];
        let total: f32 = background.iter().map(|component| component.weight).sum();
        let mut mean = [0.0; 3];
        for component in background {
            for (sum, channel) in mean.iter_mut().zip(component.mean) {
                *sum += component.weight / total * channel;
            }
        }
        mean
    }

    /// Makes the learned state the start of classification: component 1 alone, with weight 1, as after a first frame.
    /// A pixel with recurring changes (a lamp, a flag) keeps all components that are background to a restless pixel,
    /// and starts as one. The past classification is reset.
    pub fn begin(&mut self, parameters: &Parameters) {
        let feedback = &parameters.feedback;
        if feedback.is_on() && self.past.run <= 0.0 && self.used() > 1 {
            // Classification has already started: a pixel that is still learning has recorded a change.
            return;
        }
        let recurs = feedback.is_on() && self.past.recurs(parameters.learnt);
        let restless = VerdictMemory { unrest: feedback.full, ..VerdictMemory::default() };
        let kept = if recurs { self.background_count(parameters.t_of(&restless)).max(1) } else { 1 };
        self.past = if kept > 1 { restless } else { VerdictMemory::default() };
        self.components_mut()[kept..].fill(Component::default());
        if kept == 1 {
            self.components[0].weight = 1.0;
        } else {
            self.renormalise();
        }
    }

    /// Updates the mixture by the value of the `t`-th frame (from 1) and classifies the pixel (§V–VI). Frames are
    /// passed in order. The first frame after those that were learned from is processed after [`Self::begin`].
    ///
    /// # Examples
    /// A pixel of a grey wall is hidden by a shirt in frames 5 and 6:
    ///
    /// ```
    /// use occluscope::mixture::{Parameters, Pixel};
    /// use occluscope::settings::{Preset, Settings};
    ///
    /// let plain = Settings::preset(Preset::Plain);
    /// let parameters = Parameters::new(&Settings { k: 3, alpha: 0.125, initial_weight: 0.125, ..plain });
    /// let (wall, shirt) = (parameters.value([100; 3]), parameters.value([200; 3]));
    /// let mut pixel = Pixel::unseen(parameters.k);
    /// for t in 1..=4 {
    ///     assert!(!pixel.update(wall, t, &parameters).foreground);
    /// }
    ///
    /// // No component matches: a new one starts with the weight w₀. As w₁ = 0.875 > T = 0.7, B is 1.
    /// let first = pixel.update(shirt, 5, &parameters);
    /// assert_eq!((first.matched, first.rank, first.background_count), (0, 2, 1));
    /// assert!(first.foreground);
    /// let weights: Vec<f32> = pixel.components().iter().map(|component| component.weight).collect();
    /// assert_eq!(weights, [0.875, 0.125, 0.0]);
    ///
    /// // The shirt matches component 2, which is not background; the wall then matches component 1 at once.
    /// let second = pixel.update(shirt, 6, &parameters);
    /// assert_eq!((second.matched, second.foreground), (2, true));
    /// let third = pixel.update(wall, 7, &parameters);
    /// assert_eq!((third.matched, third.foreground), (1, false));
    /// ```
    pub fn update(&mut self, x: PixelValue, t: u32, parameters: &Parameters) -> Outcome {
        if parameters.begins_at(t) {
            self.begin(parameters);
        }
        let p = self.probability(x, parameters.channels());
        Outcome { p, ..self.step(x, t, parameters) }
    }

    /// The outcome of a frame that does not show the pixel: nothing is learned, and the pixel is background.
    pub fn skip(&self, parameters: &Parameters) -> Outcome {
        let background_count = self.background_count(parameters.t_of(&self.past)) as u8;
        Outcome { matched: 1, rank: 1, background_count, ..Outcome::default() }
    }

    /// [`Pixel::update`] without P(X), which costs K exponentials and has no effect on the state.
    pub(crate) fn step(&mut self, x: PixelValue, t: u32, parameters: &Parameters) -> Outcome {
        if t <= 1 {
            return self.first_frame(x, parameters);
        }
        if parameters.begins_at(t) {
            self.begin(parameters);
        }
        let alpha = parameters.alpha_of(&self.past, t);

        let matched = first_match(self.components(), x, parameters.lambda);
        let far = matched.is_some_and(|index| {
            self.components[index].distance_squared(x) > parameters.hysteresis.distance_squared()
        });
        self.update_weights(matched, alpha);
        let (changed, rho) = if let Some(index) = matched {
            (index, self.learn(index, x, alpha, parameters))
        } else {
            self.replace_last(x, parameters);
            self.renormalise();
            (self.k - 1, 0.0)
        };
        let rank = self.sort_upwards(changed) + 1;
        let is_foreground = |background_count: usize| matched.is_none() || rank > background_count;
        let (on, learning) = (parameters.feedback.is_on(), parameters.is_learning(t));
        if on && learning {
            self.past.record_change(matched != Some(0), t);
        } else if on {
            let strict = is_foreground(self.background_count(parameters.t));
            self.past.record_verdict(strict, &parameters.feedback);
        }
        let raised = if learning { parameters.t } else { parameters.t_of(&self.past) };
        let background_count = self.background_count(raised);
        let foreground = is_foreground(background_count);
        if on && !learning {
            self.past.record_final(foreground);
        }
        Outcome {
            matched: matched.map_or(0, |index| index as u8 + 1),
            rank: rank as u8,
            background_count: background_count as u8,
            foreground,
            weak_match: far && !foreground,
            rho,
            p: 0.0,
        }
    }

    /// One component of weight 1 around the first value; every pixel starts as background.
    fn first_frame(&mut self, x: PixelValue, parameters: &Parameters) -> Outcome {
        *self = Self::unseen(parameters.k);
        self.components[0] =
            Component { weight: 1.0, mean: x, variance: parameters.initial_sigma * parameters.initial_sigma };
        Outcome { rank: 1, background_count: 1, ..Outcome::default() }
    }

    /// w ← (1 − α)·w + α·M; M is 1 for the matched component and 0 for the others.
    fn update_weights(&mut self, matched: Option<usize>, alpha: f32) {
        for (index, component) in self.components[..self.k].iter_mut().enumerate() {
            component.weight *= 1.0 - alpha;
            if matched == Some(index) {
                component.weight += alpha;
            }
        }
    }

    /// μ ← (1 − ρ)μ + ρX, then with the new μ, σ² ← (1 − ρ)σ² + ρ‖X − μ‖², at least σ_min². Returns ρ.
    fn learn(&mut self, index: usize, x: PixelValue, alpha: f32, parameters: &Parameters) -> f32 {
        let component = &mut self.components[index];
        let rho = match parameters.rate {
            Rate::Density => alpha * component.density(x, parameters.channels()),
            Rate::Weight => alpha / component.weight,
            Rate::Constant => alpha,
        };
        let rho = if rho < 1.0 { rho } else { 1.0 };
        for (mean, channel) in component.mean.iter_mut().zip(x) {
            *mean = (1.0 - rho) * *mean + rho * channel;
        }
        let variance = (1.0 - rho) * component.variance + rho * component.distance_squared(x);
        let least = parameters.min_sigma * parameters.min_sigma;
        component.variance = if variance < least { least } else { variance };
        rho
    }

    /// Replaces the least probable component by (w₀, X, σ₀²).
    fn replace_last(&mut self, x: PixelValue, parameters: &Parameters) {
        self.components[self.k - 1] = Component {
            weight: parameters.initial_weight,
            mean: x,
            variance: parameters.initial_sigma * parameters.initial_sigma,
        };
    }

    /// Divides the weights by their sum. Only a replacement changes the sum: after a match (1 − α)·1 + α = 1, and
    /// rounding errors decay by 1 − α per frame.
    fn renormalise(&mut self) {
        let components = &mut self.components[..self.k];
        let sum = components.iter().fold(0.0, |sum, component| sum + component.weight);
        for component in components {
            component.weight /= sum;
        }
    }

    /// Moves a component up while its w/σ is greater than that of the one above; returns its final index.
    ///
    /// As the paper sorts upwards only, a matched component whose σ grew may stay above one of larger w/σ.
    fn sort_upwards(&mut self, mut index: usize) -> usize {
        while index > 0 && self.components[index].rank_value() > self.components[index - 1].rank_value() {
            self.components.swap(index, index - 1);
            index -= 1;
        }
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;

    fn component(weight: f32, level: f32, sigma: f32) -> Component {
        Component { weight, mean: [level; 3], variance: sigma * sigma }
    }

    #[test]
    fn the_background_accounts_for_more_than_t() {
        let pixel = Pixel::from_components(&[
            component(0.5, 10.0, 4.0),
            component(0.25, 50.0, 4.0),
            component(0.25, 90.0, 4.0),
            Component::default(),
        ]);
        let counts = [0.25, 0.5, 0.7, 0.75, 1.0].map(|t| pixel.background_count(t));
        assert_eq!(counts, [1, 2, 2, 3, 3]);
    }

    #[test]
    fn a_component_of_equal_rank_stays_below() {
        let mut pixel = Pixel::from_components(&[component(0.5, 10.0, 4.0), component(0.5, 90.0, 4.0)]);
        assert_eq!(pixel.sort_upwards(1), 1);
        pixel.components[1].weight = 0.625;
        assert_eq!(pixel.sort_upwards(1), 0);
        assert_eq!((pixel.components[0].mean[0], pixel.components[1].mean[0]), (90.0, 10.0));
    }

    #[test]
    fn reach_and_rank_follow_from_the_standard_deviation() {
        let component = component(0.5, 10.0, 4.0);
        assert_eq!((component.sigma(), component.reach(2.5), component.rank_value()), (4.0, 10.0, 0.125));
        assert_eq!(Component::default().rank_value(), 0.0);
    }

    #[test]
    fn the_number_of_learned_frames_is_no_setting() {
        let settings = Settings::preset(Preset::Plain);
        let parameters = Parameters { learnt: 12, ..Parameters::new(&settings) };
        assert!(parameters.equal_settings(&settings));
        assert!(!parameters.equal_settings(&Settings { k: settings.k + 1, ..settings.clone() }));
    }

    #[test]
    fn a_frame_that_does_not_show_the_pixel_is_background() {
        let settings = Settings::preset(Preset::Plain);
        let parameters = Parameters { t: 0.6, ..Parameters::new(&settings) };
        let pixel = Pixel::from_components(&[component(0.5, 10.0, 4.0), component(0.5, 90.0, 4.0)]);
        let expected = Outcome { matched: 1, rank: 1, background_count: 2, ..Outcome::default() };
        assert_eq!(pixel.skip(&parameters), expected);
    }
}
