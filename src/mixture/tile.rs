//! Sixteen pixels at once: the arithmetic of [`super::pixel`] on vectors of sixteen numbers.
//!
//! In almost every tile of almost every frame all sixteen pixels match their component 1. That path is short, has no
//! branches, and touches component 1 alone: the decay of the other weights is applied, multiplication by
//! multiplication, when they are next needed. The general path makes every decision of the scalar implementation by
//! selecting lanes.

use fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u8x16, u8x64, u32x16};

use super::feedback::{Feedback, VerdictMemory};
use super::hysteresis::Hysteresis;
use super::pixel::{Component, MAX_K, Parameters, Pixel};
use super::shadow::Shadow;
use crate::frame::Mask;
use crate::settings::Rate;

/// Number of pixels of a tile.
pub(super) const LANES: usize = 16;

/// The bytes of a tile in a frame.
pub(super) type TileRgb = [u8; 3 * LANES];

/// One number per pixel of a tile.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Lanes([f32; LANES]);

/// One component of each pixel of a tile, in N channels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaussians<const N: usize> {
    weight: Lanes,
    variance: Lanes,
    mean: [Lanes; N],
}

impl<const N: usize> Gaussians<N> {
    /// Components that are not in use.
    pub(super) const UNUSED: Self =
        Self { weight: Lanes([0.0; LANES]), variance: Lanes([0.0; LANES]), mean: [Lanes([0.0; LANES]); N] };

    /// w ← 1.
    pub(super) fn make_certain(&mut self) {
        self.weight = Lanes([1.0; LANES]);
    }

    /// Writes a component to one lane.
    pub(super) fn set_lane(&mut self, lane: usize, component: &Component) {
        self.weight.0[lane] = component.weight;
        self.variance.0[lane] = component.variance;
        for (lanes, channel) in self.mean.iter_mut().zip(component.mean) {
            lanes.0[lane] = channel;
        }
    }

    /// Copies one lane of another.
    pub(super) fn take_lane(&mut self, lane: usize, other: &Self) {
        self.weight.0[lane] = other.weight.0[lane];
        self.variance.0[lane] = other.variance.0[lane];
        for (mean, other) in self.mean.iter_mut().zip(&other.mean) {
            mean.0[lane] = other.0[lane];
        }
    }

    /// The component of one lane.
    pub(super) fn lane(&self, lane: usize) -> Component {
        let mut mean = [0.0; 3];
        for (channel, lanes) in mean.iter_mut().zip(&self.mean) {
            *channel = lanes.0[lane];
        }
        Component { weight: self.weight.0[lane], variance: self.variance.0[lane], mean }
    }
}

/// The past classification of each pixel of a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct VerdictMemories {
    run: Lanes,
    unrest: Lanes,
    /// One bit per lane.
    strict: u16,
    /// Whether any lane was foreground, in the final result or under the parameter T.
    busy: bool,
}

impl VerdictMemories {
    /// The memory of pixels without data.
    pub(super) const NONE: Self =
        Self { run: Lanes([0.0; LANES]), unrest: Lanes([0.0; LANES]), strict: 0, busy: false };

    /// u of each lane, as of the frame of `settled`.
    #[inline(always)]
    pub(super) fn unrest<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::load_array_ref(simd, &self.unrest.0)
    }

    /// Copies one lane of another.
    pub(super) fn take_lane(&mut self, lane: usize, other: &Self) {
        (self.run.0[lane], self.unrest.0[lane]) = (other.run.0[lane], other.unrest.0[lane]);
        let bit = 1 << lane;
        self.strict = self.strict & !bit | other.strict & bit;
        self.busy |= other.busy;
    }

    /// Writes the initial memory of a pixel to one lane.
    pub(super) fn begin_lane(&mut self, lane: usize, past: &VerdictMemory) {
        (self.run.0[lane], self.unrest.0[lane]) = (past.run, past.unrest);
        (self.strict, self.busy) = (0, false);
    }

    /// The memory of one lane, as of the frame of `settled`.
    pub(super) fn lane(&self, lane: usize) -> VerdictMemory {
        VerdictMemory {
            run: self.run.0[lane],
            unrest: self.unrest.0[lane],
            strict: self.strict >> lane & 1 > 0,
        }
    }
}

/// A tile's mixtures, borrowed from the image's.
pub(super) struct Tile<'a, const N: usize> {
    /// Component 1.
    pub(super) first: &'a mut Gaussians<N>,
    /// Components 2 to K.
    pub(super) others: &'a mut [Gaussians<N>],
    /// The number of components that were ever in use in any lane; the others are all zeros.
    pub(super) used: &'a mut u8,
    /// The frame as of which the weights of `others` are stored.
    pub(super) settled: &'a mut u32,
    /// The past classification, with the unrest as of the same frame; `None` where feedback is off.
    pub(super) pasts: Option<&'a mut VerdictMemories>,
    /// The tile's index, which determines when its weights are brought up to date.
    pub(super) place: u32,
}

/// A tile as it is stored.
pub(super) struct StoredTile<'a, const N: usize> {
    /// Component 1.
    pub(super) first: &'a Gaussians<N>,
    /// Components 2 to K.
    pub(super) others: &'a [Gaussians<N>],
    /// The frame as of which `others` and the unrest of `pasts` are stored.
    pub(super) settled: u32,
    /// The past classification; `None` where feedback is off.
    pub(super) pasts: Option<&'a VerdictMemories>,
}

/// The pixel of one lane after frame `t`.
pub(super) fn read<const N: usize>(
    stored: &StoredTile<'_, N>,
    lane: usize,
    parameters: &Parameters,
    t: u32,
) -> Pixel {
    let &StoredTile { first, others, settled, pasts } = stored;
    let mut pixel = Pixel::unseen(parameters.k);
    for (component, gaussians) in pixel.components_mut().iter_mut().zip(std::iter::once(first).chain(others))
    {
        *component = gaussians.lane(lane);
    }
    for component in pixel.components_mut().iter_mut().skip(1).filter(|component| component.is_used()) {
        for t in settled + 1..=t {
            component.weight *= 1.0 - parameters.alpha_at(t);
        }
    }
    if let Some(pasts) = pasts {
        let past = pixel.past_mut();
        *past = pasts.lane(lane);
        for _ in (settled + 1..=t).filter(|&t| !parameters.is_learning(t)) {
            past.unrest *= parameters.feedback.keep();
        }
    }
    pixel
}

/// Largest number of frames after which the weights of components 2 to K are brought up to date, so that a reader has
/// few frames to apply.
const SETTLE: u32 = 32;

/// Parameters of one frame, the same for all tiles.
#[derive(Clone, Copy)]
pub(super) struct FrameParameters {
    t: u32,
    alpha: f32,
    /// Whether the frame is in the warm-up, in which all pixels have the same α.
    warming: bool,
}

impl FrameParameters {
    /// The number of the frame since the model started, from 1.
    pub(super) const fn t(&self) -> u32 {
        self.t
    }
}

/// Constants of all tiles and frames.
pub(super) struct Constants {
    parameters: Parameters,
    lambda_squared: f32,
    initial_variance: f32,
    least_variance: f32,
    /// The squared distance from its component above which background is weakly matched.
    weak_match: f32,
}

impl Constants {
    pub(super) fn new(parameters: &Parameters) -> Self {
        Self {
            parameters: *parameters,
            lambda_squared: parameters.lambda * parameters.lambda,
            initial_variance: parameters.initial_sigma * parameters.initial_sigma,
            least_variance: parameters.min_sigma * parameters.min_sigma,
            weak_match: parameters.hysteresis.distance_squared(),
        }
    }

    pub(super) const fn rate(&self) -> Rate {
        self.parameters.rate
    }

    pub(super) const fn k(&self) -> usize {
        self.parameters.k
    }

    pub(super) fn moment(&self, t: u32) -> FrameParameters {
        FrameParameters { t, alpha: self.parameters.alpha_at(t), warming: self.parameters.is_warming(t) }
    }

    /// ρ, from w after the update and the state before it (§V).
    #[inline(always)]
    fn rho<S: Simd, const N: usize>(
        &self,
        alpha: f32x16<S>,
        weight: f32x16<S>,
        distance_squared: impl FnOnce() -> f32x16<S>,
        variance: f32x16<S>,
    ) -> f32x16<S> {
        let rho = match self.parameters.rate {
            Rate::Density => density::<S, N>(distance_squared(), variance) * alpha,
            Rate::Weight => alpha / weight,
            Rate::Constant => alpha,
        };
        rho.min(1.0)
    }
}

/// One component of each pixel of a tile, in vectors.
#[derive(Clone, Copy)]
pub(super) struct Vectors<S: Simd, const N: usize> {
    pub(super) weight: f32x16<S>,
    pub(super) variance: f32x16<S>,
    pub(super) mean: [f32x16<S>; N],
}

impl<S: Simd, const N: usize> Vectors<S, N> {
    #[inline(always)]
    pub(super) fn load(simd: S, from: &Gaussians<N>) -> Self {
        let vector = |lanes: &Lanes| f32x16::load_array_ref(simd, &lanes.0);
        Self {
            weight: vector(&from.weight),
            variance: vector(&from.variance),
            mean: std::array::from_fn(
                #[inline(always)]
                |channel| vector(&from.mean[channel]),
            ),
        }
    }

    #[inline(always)]
    fn store(&self, to: &mut Gaussians<N>) {
        self.weight.store_array(&mut to.weight.0);
        self.variance.store_array(&mut to.variance.0);
        for (mean, to) in self.mean.iter().zip(&mut to.mean) {
            mean.store_array(&mut to.0);
        }
    }

    #[inline(always)]
    fn distance_squared(&self, x: &[f32x16<S>; N]) -> f32x16<S> {
        let mut sum = f32x16::splat(self.weight.token(), 0.0);
        for (x, mean) in x.iter().zip(&self.mean) {
            let difference = *x - *mean;
            sum += difference * difference;
        }
        sum
    }

    /// The lanes in which this component is in use and matches: ‖X − μ‖² ≤ λ²σ².
    #[inline(always)]
    fn matches(&self, distance_squared: f32x16<S>, constants: &Constants) -> mask32x16<S> {
        distance_squared.simd_le(self.variance * constants.lambda_squared) & self.weight.simd_gt(0.0)
    }

    /// μ ← (1 − ρ)μ + ρX, then with the new μ, σ² ← (1 − ρ)σ² + ρ‖X − μ‖², at least σ_min².
    #[inline(always)]
    fn learn(&mut self, x: &[f32x16<S>; N], rho: f32x16<S>, constants: &Constants) {
        let keep = f32x16::splat(rho.token(), 1.0) - rho;
        for (mean, x) in self.mean.iter_mut().zip(x) {
            *mean = keep * *mean + rho * *x;
        }
        let variance = keep * self.variance + rho * self.distance_squared(x);
        self.variance = variance.max(constants.least_variance);
    }

    /// w/σ, 0 if unused.
    #[inline(always)]
    fn rank_value(&self) -> f32x16<S> {
        let zero = f32x16::splat(self.weight.token(), 0.0);
        self.weight.simd_gt(0.0).select(self.weight / self.variance.sqrt(), zero)
    }

    /// Copies these lanes of another.
    #[inline(always)]
    fn take(&mut self, lanes: mask32x16<S>, other: &Self) {
        self.weight = lanes.select(other.weight, self.weight);
        self.variance = lanes.select(other.variance, self.variance);
        for (mean, other) in self.mean.iter_mut().zip(&other.mean) {
            *mean = lanes.select(*other, *mean);
        }
    }
}

impl<const N: usize> Tile<'_, N> {
    /// Processes consecutive frames: `rgb` has the tile's bytes in each, and `marks` receives one byte per pixel.
    #[inline(always)]
    pub(super) fn run<S: Simd>(
        mut self,
        simd: S,
        constants: &Constants,
        frame_parameters: &[FrameParameters],
        rgb: &[TileRgb],
        marks: &mut [[u8; LANES]],
    ) {
        let mut first = Vectors::load(simd, self.first);
        for ((&moment, rgb), marks) in frame_parameters.iter().zip(rgb).zip(marks) {
            let x = values::<S, N>(simd, rgb);
            let distance = first.distance_squared(&x);
            let calm = self.pasts.as_ref().is_none_or(|pasts| !pasts.busy);
            if calm && first.matches(distance, constants).all_true() {
                first.weight = first.weight * (1.0 - moment.alpha) + moment.alpha;
                // Only the paper's own rate uses the distance, and only there it is kept in a register.
                let rho = constants.rho::<S, N>(
                    f32x16::splat(simd, moment.alpha),
                    first.weight,
                    #[inline(always)]
                    || distance,
                    first.variance,
                );
                first.learn(&x, rho, constants);
                let weak_match = distance.simd_gt(constants.weak_match);
                *marks = if weak_match.any_true() {
                    marks_of(
                        mask32x16::splat(simd, false),
                        weak_match,
                        &x,
                        &first,
                        &constants.parameters.shadow,
                    )
                } else {
                    [Mask::BACKGROUND; LANES]
                };
                if (moment.t + self.place).is_multiple_of(SETTLE) {
                    self.settle(simd, moment.t, constants);
                }
            } else {
                first.store(self.first);
                *marks = self.step(simd, rgb, moment, constants);
                first = Vectors::load(simd, self.first);
            }
        }
        first.store(self.first);
    }

    #[cold]
    #[inline(never)]
    fn step<S: Simd>(
        &mut self,
        simd: S,
        rgb: &TileRgb,
        moment: FrameParameters,
        constants: &Constants,
    ) -> [u8; LANES] {
        simd.vectorize(
            #[inline(always)]
            || {
                let x = values::<S, N>(simd, rgb);
                if moment.t <= 1 {
                    self.begin(&x, constants);
                    return [0; LANES];
                }
                self.settle(simd, moment.t - 1, constants);
                // Components in use in any lane, and one more, if there is room, for a new one. A constant known at
                // compile time lets the compiler unroll loops over them.
                let open = (usize::from(*self.used) + 1).min(constants.parameters.k);
                let (foreground, weak_match, missed) = match open {
                    1 => self.step_open::<S, 1>(&x, moment, constants),
                    2 => self.step_open::<S, 2>(&x, moment, constants),
                    3 => self.step_open::<S, 3>(&x, moment, constants),
                    4 => self.step_open::<S, 4>(&x, moment, constants),
                    5 => self.step_open::<S, 5>(&x, moment, constants),
                    6 => self.step_open::<S, 6>(&x, moment, constants),
                    7 => self.step_open::<S, 7>(&x, moment, constants),
                    _ => self.step_open::<S, MAX_K>(&x, moment, constants),
                };
                *self.settled = moment.t;
                if missed {
                    *self.used = open as u8;
                }
                let shadow = &constants.parameters.shadow;
                if (foreground | weak_match).any_true() {
                    marks_of(foreground, weak_match, &x, &Vectors::load(simd, self.first), shadow)
                } else {
                    [Mask::BACKGROUND; LANES]
                }
            },
        )
    }

    /// One component of weight 1 around the first value; every pixel starts as background.
    #[inline(always)]
    fn begin<S: Simd>(&mut self, x: &[f32x16<S>; N], constants: &Constants) {
        let simd = x[0].token();
        let first = Vectors {
            weight: f32x16::splat(simd, 1.0),
            variance: f32x16::splat(simd, constants.initial_variance),
            mean: *x,
        };
        first.store(self.first);
        *self.used = 1;
        *self.settled = 1;
        if let Some(pasts) = &mut self.pasts {
            **pasts = VerdictMemories::NONE;
        }
    }

    /// Brings the weights of components 2 to K up to date as of frame `t`; none of them matched since.
    #[inline(always)]
    pub(super) fn settle<S: Simd>(&mut self, simd: S, t: u32, constants: &Constants) {
        let used = usize::from(*self.used);
        let missed = *self.settled + 1..=t;
        for other in self.others.get_mut(..used.saturating_sub(1)).unwrap_or_default() {
            let mut weight = f32x16::load_array_ref(simd, &other.weight.0);
            for t in missed.clone() {
                weight *= 1.0 - constants.parameters.alpha_at(t);
            }
            weight.store_array(&mut other.weight.0);
        }
        if let Some(pasts) = &mut self.pasts {
            let mut unrest = pasts.unrest(simd);
            for _ in missed.filter(|&t| !constants.parameters.is_learning(t)) {
                unrest *= constants.parameters.feedback.keep();
            }
            unrest.store_array(&mut pasts.unrest.0);
        }
        *self.settled = t;
    }

    /// All of §V–VI on the first `W` components, of which the last is unused or may be replaced. Returns which pixels
    /// are foreground, which are weakly matched, and whether any of them matched nothing.
    #[inline(always)]
    fn step_open<S: Simd, const W: usize>(
        &mut self,
        x: &[f32x16<S>; N],
        moment: FrameParameters,
        constants: &Constants,
    ) -> (mask32x16<S>, mask32x16<S>, bool) {
        let simd = x[0].token();
        let no_lane = mask32x16::splat(simd, false);
        let mut components: [Vectors<S, N>; W] = std::array::from_fn(
            #[inline(always)]
            |k| Vectors::load(simd, if k == 0 { &*self.first } else { &self.others[k - 1] }),
        );

        let alpha = match &self.pasts {
            Some(pasts) if !moment.warming => {
                let factor = learning_factor(simd, pasts, &constants.parameters.feedback);
                (factor * moment.alpha).min(1.0)
            }
            _ => f32x16::splat(simd, moment.alpha),
        };
        let keep = f32x16::splat(simd, 1.0) - alpha;

        // The matched component of each lane, with its weight after the update and all else before it.
        let mut changed = components[0];
        let mut distance = f32x16::splat(simd, 0.0);
        // The lanes in which the component of each rank is the updated one.
        let mut at = [no_lane; W];
        let mut matched = no_lane;
        for (component, at) in components.iter_mut().zip(&mut at) {
            let d = component.distance_squared(x);
            *at = component.matches(d, constants) & !matched;
            matched |= *at;
            component.weight *= keep;
            component.weight = at.select(component.weight + alpha, component.weight);
            distance = at.select(d, distance);
            changed.take(*at, component);
        }
        let other = !at[0];
        let missed = !matched;
        let any_missed = missed.any_true();

        let rho = constants.rho::<S, N>(
            alpha,
            changed.weight,
            #[inline(always)]
            || distance,
            changed.variance,
        );
        changed.learn(x, rho, constants);
        if any_missed {
            let fresh = Vectors {
                weight: f32x16::splat(simd, constants.parameters.initial_weight),
                variance: f32x16::splat(simd, constants.initial_variance),
                mean: *x,
            };
            changed.take(missed, &fresh);
            at[W - 1] |= missed;
        }
        for (component, at) in components.iter_mut().zip(at) {
            component.take(at, &changed);
        }
        if any_missed {
            let mut sum = components[0].weight;
            for component in &components[1..] {
                sum += component.weight;
            }
            for component in &mut components {
                component.weight = missed.select(component.weight / sum, component.weight);
            }
        }
        sort_upwards(&mut components, &mut at);
        let t = f32x16::splat(simd, constants.parameters.t);
        let mut foreground = missed | beyond_background(&components, &at, t);
        if constants.parameters.is_learning(moment.t) {
            if let Some(pasts) = &mut self.pasts {
                record_change(pasts, other, moment.t);
            }
        } else if let Some(pasts) = &mut self.pasts {
            let feedback = &constants.parameters.feedback;
            let unrest = record_verdict(pasts, foreground, feedback);
            let t = raised_t(t, unrest, feedback);
            foreground = missed | beyond_background(&components, &at, t);
            record_final(pasts, foreground);
        }
        for (k, component) in components.iter().enumerate() {
            component.store(if k == 0 { &mut *self.first } else { &mut self.others[k - 1] });
        }
        (foreground, matched & !foreground & distance.simd_gt(constants.weak_match), any_missed)
    }
}

/// [`Feedback::restlessness`].
#[inline(always)]
fn restlessness<S: Simd>(unrest: f32x16<S>, feedback: &Feedback) -> f32x16<S> {
    (unrest / feedback.full).min(1.0)
}

/// [`Feedback::learning_factor`].
#[inline(always)]
fn learning_factor<S: Simd>(simd: S, pasts: &VerdictMemories, feedback: &Feedback) -> f32x16<S> {
    let (one, run) = (f32x16::splat(simd, 1.0), f32x16::load_array_ref(simd, &pasts.run.0));
    let restless = restlessness(pasts.unrest(simd), feedback);
    let young = restless * (feedback.learning - 1.0) + 1.0;
    let lasting = f32x16::splat(simd, feedback.hold);
    run.simd_le(0.0).select(one, run.simd_le(feedback.hold_after).select(young, lasting))
}

/// [`VerdictMemory::record_change`].
#[inline(always)]
fn record_change<S: Simd>(pasts: &mut VerdictMemories, other: mask32x16<S>, t: u32) {
    let simd = other.token();
    let bits = other.to_bitmask() as u16;
    let changed = mask32x16::from_bitmask(simd, u64::from(bits ^ pasts.strict));
    let (now, last) = (f32x16::splat(simd, t as f32), f32x16::load_array_ref(simd, &pasts.run.0));
    let longest = pasts.unrest(simd);
    changed.select(longest.max(now - last), longest).store_array(&mut pasts.unrest.0);
    changed.select(now, last).store_array(&mut pasts.run.0);
    pasts.strict = bits;
    pasts.busy = bits != 0;
}

/// [`VerdictMemory::record_verdict`]. Returns the unrest.
#[inline(always)]
fn record_verdict<S: Simd>(
    pasts: &mut VerdictMemories,
    strict: mask32x16<S>,
    feedback: &Feedback,
) -> f32x16<S> {
    let simd = strict.token();
    let bits = strict.to_bitmask() as u16;
    let changed = mask32x16::from_bitmask(simd, u64::from(bits ^ pasts.strict));
    let unrest = pasts.unrest(simd) * feedback.keep();
    let unrest = changed.select(unrest + feedback.gain, unrest);
    unrest.store_array(&mut pasts.unrest.0);
    pasts.strict = bits;
    unrest
}

/// [`VerdictMemory::record_final`].
#[inline(always)]
fn record_final<S: Simd>(pasts: &mut VerdictMemories, foreground: mask32x16<S>) {
    let simd = foreground.token();
    let longer = (f32x16::load_array_ref(simd, &pasts.run.0) + 1.0).min(VerdictMemory::MAX_RUN_FRAMES);
    foreground.select(longer, f32x16::splat(simd, 0.0)).store_array(&mut pasts.run.0);
    pasts.busy = pasts.strict != 0 || foreground.any_true();
}

/// [`Feedback::raised_t`].
#[inline(always)]
pub(super) fn raised_t<S: Simd>(t: f32x16<S>, unrest: f32x16<S>, feedback: &Feedback) -> f32x16<S> {
    t + (t.max(feedback.t) - t) * restlessness(unrest, feedback)
}

/// Moves the updated component up while its w/σ is greater than that of the one above.
#[inline(always)]
fn sort_upwards<S: Simd, const N: usize, const W: usize>(
    components: &mut [Vectors<S, N>; W],
    at: &mut [mask32x16<S>; W],
) {
    let mut rank_values: [f32x16<S>; W] = std::array::from_fn(
        #[inline(always)]
        |k| components[k].rank_value(),
    );
    for lower in (1..W).rev() {
        let upper = lower - 1;
        let rises = at[lower] & rank_values[lower].simd_gt(rank_values[upper]);
        if !rises.any_true() {
            continue;
        }
        let sinks = components[upper];
        let risen = components[lower];
        components[upper].take(rises, &risen);
        components[lower].take(rises, &sinks);
        rank_values[upper] = rises.select(rank_values[lower], rank_values[upper]);
        at[lower] &= !rises;
        at[upper] |= rises;
    }
}

/// The lanes in which the updated component has a rank greater than B: the smallest b with w₁ + … + w_b > T, all used
/// components if none reaches it.
#[inline(always)]
fn beyond_background<S: Simd, const N: usize, const W: usize>(
    components: &[Vectors<S, N>; W],
    at: &[mask32x16<S>; W],
    t: f32x16<S>,
) -> mask32x16<S> {
    let simd = components[0].weight.token();
    let mut sum = f32x16::splat(simd, 0.0);
    let mut beyond = mask32x16::splat(simd, false);
    let mut reached = beyond;
    let (mut used, mut rank) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 0.0));
    for (k, (component, &at)) in components.iter().zip(at).enumerate() {
        beyond |= at & reached;
        rank = at.select(f32x16::splat(simd, k as f32 + 1.0), rank);
        sum = if k == 0 { component.weight } else { sum + component.weight };
        reached |= sum.simd_gt(t);
        used = component.weight.simd_gt(0.0).select(used + 1.0, used);
    }
    beyond | (!reached & rank.simd_gt(used))
}

/// [`Shadow::mark`] in foreground lanes, [`Hysteresis::WEAK_MATCH`] in weakly matched ones that are not shadow, 0 in all
/// others.
#[inline(always)]
fn marks_of<S: Simd, const N: usize>(
    foreground: mask32x16<S>,
    weak_match: mask32x16<S>,
    x: &[f32x16<S>; N],
    surface: &Vectors<S, N>,
    shadow: &Shadow,
) -> [u8; LANES] {
    let simd = foreground.token();
    let dot = |a: &[f32x16<S>; N], b: &[f32x16<S>; N]| {
        a.iter().zip(b).fold(f32x16::splat(simd, 0.0), |sum, (a, b)| sum + *a * *b)
    };
    let along = dot(x, &surface.mean);
    let share = along / dot(&surface.mean, &surface.mean);
    let off = (dot(x, x) - share * along).max(0.0).sqrt();
    let darker = share.simd_ge(shadow.floor) & share.simd_lt(1.0);
    let brighter = share.simd_gt(1.0) & share.simd_le(shadow.ceiling);
    let is_on = mask32x16::splat(simd, shadow.is_on());
    let covers = (darker | brighter) & off.simd_le(shadow.colour) & is_on;
    let covered = if shadow.window > 0 {
        (share * Shadow::LEVELS).to_int::<u32x16<S>>() + 1
    } else {
        u32x16::splat(simd, Mask::BACKGROUND.into())
    };
    let marks = covers.select(covered, u32x16::splat(simd, Mask::FOREGROUND.into()));
    let mut all = [0; LANES];
    let mark = |mark: u8| u32x16::splat(simd, mark.into());
    let others = (weak_match & !covers).select(mark(Hysteresis::WEAK_MATCH), mark(Mask::BACKGROUND));
    foreground.select(marks, others).store_array(&mut all);
    all.map(|mark| mark as u8)
}

/// X of each pixel: three channels, or BT.601 luma in 8 bits as in [`super::pixel::luma`].
#[inline(always)]
fn values<S: Simd, const N: usize>(simd: S, rgb: &TileRgb) -> [f32x16<S>; N] {
    let [r, g, b] = channels(simd, rgb);
    if N == 3 {
        let all = [r, g, b];
        return std::array::from_fn(
            #[inline(always)]
            |channel| all[channel].to_float(),
        );
    }
    let luma = (r * 9798 + g * 19235 + b * 3735 + (1 << 14)) >> 15;
    [luma.to_float(); N]
}

/// Red, green and blue of each pixel.
#[inline(always)]
fn channels<S: Simd>(simd: S, rgb: &TileRgb) -> [u32x16<S>; 3] {
    // Four pixels per block of 16 bytes; the last block starts 4 bytes early so that it ends with the data.
    const SPREAD: [u8; 64] = [
        0, 1, 2, 3, 3, 4, 5, 6, 6, 7, 8, 9, 9, 10, 11, 12, //
        0, 1, 2, 3, 3, 4, 5, 6, 6, 7, 8, 9, 9, 10, 11, 12, //
        0, 1, 2, 3, 3, 4, 5, 6, 6, 7, 8, 9, 9, 10, 11, 12, //
        4, 5, 6, 7, 7, 8, 9, 10, 10, 11, 12, 13, 13, 14, 15, 15,
    ];
    let block = |at: usize| u8x16::from_slice(simd, &rgb[at..at + 16]);
    let blocks = block(0).combine(block(12)).combine(block(24).combine(block(32)));
    let pixels: u32x16<S> = blocks.swizzle_dyn_within_blocks(u8x64::load_array_ref(simd, &SPREAD)).bitcast();
    [pixels & 0xff, (pixels >> 8) & 0xff, (pixels >> 16) & 0xff]
}

/// [`super::pixel::density`].
#[inline(always)]
fn density<S: Simd, const N: usize>(distance_squared: f32x16<S>, variance: f32x16<S>) -> f32x16<S> {
    let two_pi_variance = variance * (2.0 * std::f32::consts::PI);
    let root = two_pi_variance.sqrt();
    let normaliser = if N == 3 { two_pi_variance * root } else { root };
    exp_of_negative(distance_squared * -0.5 / variance) / normaliser
}

/// [`super::exponential::exp_of_negative`].
#[inline(always)]
fn exp_of_negative<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    use super::exponential::{COEFFICIENTS, LEAST, LN_2_HIGH, LN_2_LOW, ROUND};
    let simd = x.token();
    let in_range = x.simd_ge(LEAST);
    let clamped = in_range.select(x, f32x16::splat(simd, LEAST));
    let n = (clamped * std::f32::consts::LOG2_E + ROUND) - ROUND;
    let r = (clamped - n * LN_2_HIGH) - n * LN_2_LOW;
    let mut p = f32x16::splat(simd, COEFFICIENTS[0]);
    for coefficient in &COEFFICIENTS[1..] {
        p = p * r + *coefficient;
    }
    let e_to_r = p * (r * r) + r + 1.0;
    let exponent: i32x16<S> = n.to_int();
    let two_to_n = f32x16::from_bits(((exponent + 127) << 23).bitcast::<u32x16<S>>());
    in_range.select(e_to_r * two_to_n, f32x16::splat(simd, 0.0))
}
