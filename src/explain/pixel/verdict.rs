//! Explains the classification of a pixel in one frame, in words with the compared numbers.

use crate::explain::pixel::history::{PixelHistory, PixelState};
use crate::mixture::hysteresis::Hysteresis;
use crate::mixture::pixel::{Component, Parameters, Pixel, PixelValue};
use crate::mixture::shadow::Shadow;
use crate::settings::{Rate, SETTINGS, Setting, Settings, Stage, Value};

/// The mixture's classification of a pixel in one frame, before any later stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The classification and the comparison that decided it, one sentence without a full stop.
    pub headline: String,
    /// Further events of this frame, one sentence each, the most important first.
    pub details: Vec<String>,
    /// Whether the mixture calls the pixel foreground.
    pub foreground: bool,
}

/// ‖X − μ‖ / σ: the distance of `x` from a component's mean in standard deviations.
pub fn distance_in_sigmas(component: &Component, x: PixelValue) -> f32 {
    (component.distance_squared(x) / component.variance).sqrt()
}

/// The verdict at the state at `index` of a history, by the paper's rules.
///
/// Ranks are those after the update unless stated otherwise. All distances are to the components before the update,
/// because those were compared with the value.
pub fn verdict(history: &PixelHistory, index: usize) -> Verdict {
    let Some(state) = history.states.get(index) else {
        return Verdict {
            headline: "This frame is not analysed yet".to_owned(),
            details: Vec::new(),
            foreground: false,
        };
    };
    let parameters = &history.parameters;
    let mut verdict = match history.before(index) {
        None => first_frame(state, parameters),
        Some(_) if !state.known => not_shown(state),
        Some(before) if state.outcome.matched == 0 => unmatched(state, before, parameters),
        Some(before) => matched(state, before, parameters),
    };
    verdict.details.extend(shadow(state, parameters));
    verdict.details.extend(history.before(index).and_then(|before| doubt(state, before, parameters)));
    verdict.details.extend(taken_out(state));
    if parameters.begins_at(state.t) {
        verdict.details.push(format!(
            "First evaluated frame: the model is initialised from {} frames (bootstrap) with component 1, \
             and with recurring background components.",
            parameters.learnt
        ));
    }
    verdict
}

/// The verdict about a pixel that the frame does not show.
fn not_shown(state: &PixelState) -> Verdict {
    Verdict {
        headline: "Background: no data for this pixel in this frame; the model is not updated".to_owned(),
        details: vec![
            "Motion correction (stabilise) places it outside the input frame, or it is saturated under \
             light correction (light). The value shown is the mean of component 1."
                .to_owned(),
        ],
        foreground: state.outcome.foreground,
    }
}

/// The corrections of the frame at this pixel.
fn taken_out(state: &PixelState) -> Vec<String> {
    let [dx, dy] = state.applied.shift;
    let mut sentences = Vec::new();
    if state.applied.gain != 1.0 {
        let gain = number_with(state.applied.gain, 2);
        sentences
            .push(format!("Light correction (light): gain {gain} relative to the reference, compensated."));
    }
    if dx != 0.0 || dy != 0.0 {
        sentences.push(format!(
            "Motion correction (stabilise): camera motion of {dx:.1} px to the right and {dy:.1} px down \
             at this pixel, compensated."
        ));
    }
    sentences
}

/// Whether the foreground pixel has the colour of a shadow or a highlight, in words.
fn shadow(state: &PixelState, parameters: &Parameters) -> Option<String> {
    let channels = parameters.channels();
    let surface = state.pixel.components().first()?;
    let (value, mean) = (&state.value[..channels], &surface.mean[..channels]);
    let rule = parameters.shadow;
    let covers = state.outcome.foreground && rule.covers(value, mean);
    covers.then(|| {
        let (share, off) = rule.of(value, mean);
        let (what, limit) = if share < 1.0 {
            ("shadow", format!("threshold τ = {}, shadow threshold", number(rule.floor)))
        } else {
            ("light", format!("maximum {}, light threshold", number(rule.ceiling)))
        };
        let then = if rule.window > 0 {
            format!(
                "removed from the mask if the {0} × {0} neighbourhood has at least as many even pixels of \
                 this kind as other foreground (shadow window, shadow spread)",
                rule.window
            )
        } else {
            "removed from the mask".to_owned()
        };
        format!(
            "Classified as {what}, {then}: colour of component 1 at {} of its brightness ({limit}), colour \
             distance {} levels (maximum {}, shadow colour).",
            number(share),
            number(off),
            number(rule.colour)
        )
    })
}

/// Whether the pixel is weakly matched, i.e. background only as long as few of its neighbours are foreground, in words.
fn doubt(state: &PixelState, before: &Pixel, parameters: &Parameters) -> Option<String> {
    let channels = parameters.channels();
    let surface = state.pixel.components().first()?;
    let is_shadow = parameters.shadow.covers(&state.value[..channels], &surface.mean[..channels]);
    if !state.outcome.weak_match || is_shadow {
        return None;
    }
    let component = before.components().get(usize::from(state.outcome.matched).checked_sub(1)?)?;
    let rule = parameters.hysteresis;
    Some(format!(
        "Weak match: {} levels from the component's mean (threshold {}, hysteresis). It becomes foreground \
         if at least {3} of the {2} × {2} neighbourhood is foreground (hysteresis window, hysteresis \
         share).",
        number(component.distance_squared(state.value).sqrt()),
        number(rule.distance),
        rule.window,
        number(rule.share)
    ))
}

/// The later stage that overruled the mixture's verdict; `None` if none did.
///
/// `mixture` and `mask` are whether the pixel is foreground in each, `ignored` whether it lies outside the region of
/// interest.
pub fn overruled(mixture: bool, mask: bool, ignored: bool, settings: &Settings) -> Option<String> {
    if ignored {
        let made = "Changed by a later stage: the pixel lies outside the analysed area.";
        return mixture.then(|| made.to_owned());
    }
    // Opening only removes foreground; closing and the filling of holes only add it.
    let powerless = if mixture { ["closing", "fill_holes"] } else { ["opening", ""] };
    let shadow = mixture && Shadow::new(settings).is_on();
    let hysteresis = !mixture && Hysteresis::new(settings).is_on();
    let changes_masks = |setting: &Setting| {
        setting.stage == Stage::Cleaning && !powerless.contains(&setting.name)
            || hysteresis && setting.name.starts_with("hysteresis")
            || shadow
                && ["shadow_floor", "light_ceiling", "shadow_window", "shadow_spread"].contains(&setting.name)
    };
    let steps: Vec<String> = SETTINGS
        .iter()
        .filter(|setting| changes_masks(setting))
        .filter_map(|setting| match setting.get(settings) {
            Value::Integer(0) | Value::Real(1.0) | Value::Choice("off" | "none") => None,
            value => Some(format!("{} {value}", setting.label())),
        })
        .collect();
    let made = if mask { "foreground" } else { "background" };
    let by = if steps.is_empty() { String::new() } else { format!(" ({})", steps.join(", ")) };
    (mixture != mask)
        .then(|| format!("Changed by a later stage: after post-processing{by} this pixel is {made}."))
}

fn first_frame(state: &PixelState, parameters: &Parameters) -> Verdict {
    Verdict {
        headline: "Background: first frame of the model, all pixels are background".to_owned(),
        details: vec![format!(
            "Component 1 starts at this value with w = 1 and σ = {} (initial sigma).",
            number(parameters.initial_sigma)
        )],
        foreground: state.outcome.foreground,
    }
}

fn matched(state: &PixelState, before: &Pixel, parameters: &Parameters) -> Verdict {
    let (from, rank) = (usize::from(state.outcome.matched), usize::from(state.outcome.rank));
    let old = before.components()[from - 1];
    let distance = apart(distance_in_sigmas(&old, state.value), parameters.lambda, 1);
    let limit = number(parameters.lambda);
    let t = parameters.t_of(state.pixel.past());
    let background = background_words(&state.pixel, state.outcome.background_count, t);
    let headline = if state.outcome.foreground {
        let only = background.headline;
        format!("Foreground: matched component {rank} at {distance} σ (threshold {limit}), but {only}")
    } else {
        format!("Background: matched component {rank} at {distance} σ (threshold {limit})")
    };

    let mut details = Vec::new();
    if !state.outcome.foreground {
        details.push(background.sentence);
    }
    if rank < from {
        let (moved, passed) = (&state.pixel.components()[rank - 1], &state.pixel.components()[rank]);
        let (now, others) = pair(moved.rank_value(), passed.rank_value(), 4);
        details.push(format!("It moved up from rank {from} to {rank}: its w/σ is {now}, above {others}."));
    }
    details.extend(raised(state, parameters));
    details.extend(nearer(state, before, from));
    details.push(learning(state, before, parameters));
    details.extend(paced(before, state.t, parameters));
    let new = &state.pixel.components()[rank - 1];
    let learned =
        (1.0 - state.outcome.rho) * old.variance + state.outcome.rho * new.distance_squared(state.value);
    if learned < parameters.min_sigma * parameters.min_sigma {
        details.push(format!(
            "σ is clamped to the minimum {} (min sigma); without the limit it is {}.",
            number(parameters.min_sigma),
            apart(learned.max(0.0).sqrt(), parameters.min_sigma, 1),
        ));
    }
    if let Some(below) = state.pixel.components().get(rank).filter(|c| c.rank_value() > new.rank_value()) {
        let (own, others) = pair(new.rank_value(), below.rank_value(), 4);
        details.push(format!(
            "It stays above component {} although its w/σ {own} is below {others}: a match only moves up \
             in rank.",
            rank + 1,
        ));
    }
    details.extend(changed_count(state, before, parameters));
    Verdict { headline, details, foreground: state.outcome.foreground }
}

fn unmatched(state: &PixelState, before: &Pixel, parameters: &Parameters) -> Verdict {
    let limit = number(parameters.lambda);
    let nearest = before
        .components()
        .iter()
        .enumerate()
        .filter(|(_, component)| component.is_used())
        .map(|(index, component)| (index + 1, distance_in_sigmas(component, state.value)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let nearest = nearest.map_or_else(String::new, |(rank, distance)| {
        format!(
            "; nearest is component {rank} at {} σ (threshold {limit})",
            apart(distance, parameters.lambda, 1)
        )
    });

    let k = before.components().len();
    let rank = usize::from(state.outcome.rank);
    let last = before.components()[k - 1];
    let count = usize::from(state.outcome.background_count);
    let new = format!(
        "σ = {} and w = {}",
        number(parameters.initial_sigma),
        number_with(state.pixel.components()[rank - 1].weight, 3),
    );
    let mut details = vec![if last.is_used() {
        format!(
            "Component {k}, the last (w = {}), is replaced by a new component at this value with {new}.",
            number_with(last.weight, 3)
        )
    } else {
        format!(
            "A new component is added at this value with {new}: {} of {k} components were in use.",
            before.used()
        )
    }];
    if rank < k && last.is_used() {
        details.push(format!("The new component moved up from rank {k} to {rank}."));
    }
    if rank <= count {
        details
            .push(format!("Its rank is {rank} and B = {count}, but a value without a match is foreground."));
    }
    let t = parameters.t_of(state.pixel.past());
    details.push(background_words(&state.pixel, state.outcome.background_count, t).sentence);
    details.extend(raised(state, parameters));
    details.extend(paced(before, state.t, parameters));
    details.extend(changed_count(state, before, parameters));
    Verdict {
        headline: format!("Foreground: no match{nearest}"),
        details,
        foreground: state.outcome.foreground,
    }
}

/// Which components are background and why, as the end of the headline and as a separate sentence.
struct BackgroundWords {
    headline: String,
    sentence: String,
}

fn background_words(pixel: &Pixel, count: u8, t: f32) -> BackgroundWords {
    let count = usize::from(count);
    let weights: Vec<f32> = pixel.components().iter().take(count).map(|component| component.weight).collect();
    let sum: f32 = weights.iter().fold(0.0, |sum, weight| sum + weight);
    let who = match count {
        1 => "component 1".to_owned(),
        _ => format!("components 1 to {count}"),
    };
    if sum > t {
        let why = format!("{} > T = {}", sum_above(&weights, t), number(t));
        BackgroundWords {
            headline: format!("background consists only of {who} ({why})"),
            sentence: format!("Background consists of {who}: {why}, so B = {count}."),
        }
    } else {
        let why = format!("no sum of weights exceeds T = {}", number(t));
        BackgroundWords {
            headline: format!("background consists only of {who} ({why})"),
            sentence: format!("Background consists of all {count} components in use: {why}, so B = {count}."),
        }
    }
}

/// States that a component of lower rank is nearer, if one is: the first match in rank order counts, not the nearest.
fn nearer(state: &PixelState, before: &Pixel, from: usize) -> Option<String> {
    let taken = distance_in_sigmas(&before.components()[from - 1], state.value);
    before
        .components()
        .iter()
        .enumerate()
        .skip(from)
        .filter(|(_, component)| component.is_used())
        .map(|(index, component)| (index + 1, distance_in_sigmas(component, state.value)))
        .filter(|&(_, distance)| distance < taken)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(rank, distance)| {
            let (nearer, taken) = pair(distance, taken, 1);
            format!(
                "The component of rank {rank} is nearer, {nearer} σ vs {taken}, but the first match in \
                 rank order is used."
            )
        })
}

/// States that the pixel's T differs from the parameter, if it does.
fn raised(state: &PixelState, parameters: &Parameters) -> Option<String> {
    let past = state.pixel.past();
    let t = parameters.t_of(past);
    (t > parameters.t).then(|| {
        let (raised, plain) = pair(t, parameters.t, 2);
        format!(
            "T is raised from {plain} to {raised} because this pixel flickers: its verdict changed in {} % \
             of the recent frames (full effect from {} %, flicker limit).",
            number(100.0 * past.unrest),
            number(100.0 * parameters.feedback.full)
        )
    })
}

/// States why the pixel's α differs from the parameter, if it does.
fn paced(before: &Pixel, t: u32, parameters: &Parameters) -> Option<String> {
    let past = before.past();
    let (alpha, plain) = (parameters.alpha_of(past, t), parameters.alpha_at(t));
    if alpha == plain {
        return None;
    }
    let run = number(past.run);
    Some(if past.run > parameters.feedback.hold_after {
        format!(
            "α is {} of {}: foreground for {run} consecutive frames (more than {}, hold after) is learned \
             slowly (hold).",
            number(alpha / plain),
            number(plain),
            number(parameters.feedback.hold_after),
        )
    } else {
        format!(
            "α is {} times {}: this pixel flickers, and was foreground for only {run} consecutive frames \
             (at most {}, hold after).",
            number(alpha / plain),
            number(plain),
            number(parameters.feedback.hold_after),
        )
    })
}

fn learning(state: &PixelState, before: &Pixel, parameters: &Parameters) -> String {
    let alpha = parameters.alpha_of(before.past(), state.t);
    let how = match parameters.rate {
        Rate::Density => "α·η, rate = density",
        Rate::Weight => "α/w, rate = weight",
        Rate::Constant => "α, rate = constant",
    };
    let warming =
        if state.t <= parameters.warm_up && alpha > parameters.alpha { " = 1/t (warm-up)" } else { "" };
    // α·η is unbounded: where σ is small, η exceeds 1/α.
    let limited = if state.outcome.rho >= 1.0 { "limited to 1" } else { how };
    format!("Updated with ρ = {} ({limited}), α = {}{warming}.", number(state.outcome.rho), number(alpha))
}

fn changed_count(state: &PixelState, before: &Pixel, parameters: &Parameters) -> Option<String> {
    let (old, new) = (
        before.background_count(parameters.t_of(before.past())),
        usize::from(state.outcome.background_count),
    );
    (old != new).then(|| format!("B changed from {old} to {new} in this frame."))
}

/// A number with at most four significant digits and no trailing zeros; very small ones as `1.2e-7`.
pub fn number(value: f32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor() as i32;
    if magnitude < -4 {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.*}", (3 - magnitude).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn number_with(value: f32, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

/// `value` with `decimals` digits, or with as many more as keep it on its side of `limit`, which is formatted by
/// [`number`]: 2.503 beside a limit of 2.5 must not be shown as 2.5.
fn apart(value: f32, limit: f32, decimals: usize) -> String {
    let limit = number(limit).parse().unwrap_or(limit);
    (decimals..=decimals + 5)
        .map(|decimals| format!("{value:.decimals$}"))
        .find(|text| {
            text.parse::<f32>().is_ok_and(|shown| shown.total_cmp(&limit) == value.total_cmp(&limit))
        })
        .unwrap_or_else(|| format!("{value}"))
}

/// Two numbers with the same number of digits, at least `decimals`, and enough to differ.
fn pair(a: f32, b: f32, decimals: usize) -> (String, String) {
    (decimals..=decimals + 5)
        .map(|decimals| (format!("{a:.decimals$}"), format!("{b:.decimals$}")))
        .find(|(a, b)| a != b)
        .unwrap_or_else(|| (format!("{a}"), format!("{b}")))
}

/// `0.61 + 0.22`, with enough digits that the shown sum exceeds `t`.
fn sum_above(weights: &[f32], t: f32) -> String {
    let shown = |decimals: usize| -> Vec<String> {
        weights.iter().map(|weight| format!("{weight:.decimals$}")).collect()
    };
    let t = number(t).parse().unwrap_or(f64::from(t));
    let sum = |texts: &[String]| texts.iter().filter_map(|text| text.parse::<f64>().ok()).sum::<f64>();
    (2..=6).map(shown).find(|texts| sum(texts) > t + 1e-9).unwrap_or_else(|| shown(6)).join(" + ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::settings::Preset;

    fn parameters() -> Parameters {
        Parameters::new(&Settings { space: crate::settings::Space::Gray, ..Settings::preset(Preset::Plain) })
    }

    fn gray(weight: f32, mean: f32, sigma: f32) -> Component {
        Component { weight, mean: [mean, 0.0, 0.0], variance: sigma * sigma }
    }

    /// The verdict on a gray value for a given mixture, long after the start.
    fn meets(components: &[Component], level: u8, parameters: Parameters) -> (Verdict, PixelState) {
        let mut history = PixelHistory::new((0, 0), Parameters { k: components.len(), ..parameters });
        history.push_colour(1, [0; 3]);
        history.states[0].pixel = Pixel::from_components(components);
        history.push_colour(2, [level; 3]);
        (verdict(&history, 1), history.states[1])
    }

    fn detail<'a>(verdict: &'a Verdict, part: &str) -> &'a str {
        verdict.details.iter().find(|detail| detail.contains(part)).unwrap_or_else(|| {
            unreachable!("no detail has {part:?}: {verdict:#?}");
        })
    }

    #[test]
    fn the_first_frame_after_learning_is_classified_like_any_other() {
        let mut history = PixelHistory::new((0, 0), parameters());
        history.learn_colours((1..=40).map(|n| if n < 9 { [200; 3] } else { [50; 3] }));
        history.push_colour(1, [200; 3]);
        let words = verdict(&history, 0);
        assert!(words.foreground && !words.headline.contains("first frame"), "{}", words.headline);
        assert!(words.headline.starts_with("Foreground: no match"), "{}", words.headline);
        let begins = words.details.iter().find(|detail| detail.contains("initialised from 40 frames"));
        assert!(begins.is_some(), "{:?}", words.details);
        history.push_colour(2, [50; 3]);
        let words = verdict(&history, 1);
        assert!(!words.foreground && !words.details.iter().any(|detail| detail.contains("initialised from")));
    }

    #[test]
    fn the_first_frame_is_named_as_such() {
        let history = PixelHistory::of_colours((0, 0), parameters(), [(7, [50; 3])]);
        let words = verdict(&history, 0);
        assert!(!words.foreground && words.headline.starts_with("Background: first frame of the model"));
        assert!(detail(&words, "Component 1 starts").contains("σ = 20"));
    }

    #[test]
    fn a_frame_beyond_the_history_is_not_analysed() {
        let history = PixelHistory::of_colours((0, 0), parameters(), [(7, [50; 3])]);
        assert_eq!(verdict(&history, 1).headline, "This frame is not analysed yet");
    }

    #[test]
    fn a_background_match_names_component_distance_and_limit() {
        let (words, state) = meets(&[gray(0.6, 100.0, 10.0), gray(0.4, 200.0, 10.0)], 112, parameters());
        assert!(!words.foreground && !state.outcome.foreground);
        assert_eq!(words.headline, "Background: matched component 1 at 1.2 σ (threshold 2.5)");
        assert_eq!(
            words.details[0],
            "Background consists of components 1 to 2: 0.60 + 0.40 > T = 0.7, so B = 2."
        );
        assert!(detail(&words, "Updated with").contains("α/w, rate = weight"));
        assert!(!words.details.iter().any(|detail| detail.contains("clamped") || detail.contains("rank")));
    }

    #[test]
    fn a_match_beyond_b_names_the_sufficient_weights() {
        let mixture = [gray(0.61, 100.0, 10.0), gray(0.22, 150.0, 10.0), gray(0.17, 230.0, 10.0)];
        let (words, state) = meets(&mixture, 242, parameters());
        assert!(words.foreground && state.outcome.matched == 3);
        assert_eq!(
            words.headline,
            "Foreground: matched component 3 at 1.2 σ (threshold 2.5), but background consists only of \
             components 1 to 2 (0.60 + 0.22 > T = 0.7)"
        );
    }

    #[test]
    fn no_match_names_the_nearest_and_the_replaced_component() {
        let mixture = [gray(0.7, 100.0, 10.0), gray(0.2, 200.0, 10.0), gray(0.1, 20.0, 4.0)];
        let (words, _) = meets(&mixture, 169, parameters());
        assert!(words.foreground);
        assert_eq!(words.headline, "Foreground: no match; nearest is component 2 at 3.1 σ (threshold 2.5)");
        assert_eq!(
            words.details[0],
            "Component 3, the last (w = 0.100), is replaced by a new component at this value with σ = 20 \
             and w = 0.053."
        );
    }

    #[test]
    fn no_match_with_a_free_slot_reports_an_added_component() {
        let mixture = [gray(1.0, 100.0, 10.0), Component::default(), Component::default()];
        let (words, state) = meets(&mixture, 200, parameters());
        assert_eq!(state.outcome.rank, 2);
        assert!(detail(&words, "is added").contains("1 of 3 components were in use"));
    }

    #[test]
    fn a_new_component_within_b_is_foreground() {
        let (words, state) = meets(&[gray(0.02, 100.0, 60.0)], 255, parameters());
        assert!(words.foreground && state.outcome.rank <= state.outcome.background_count);
        assert!(detail(&words, "without a match is foreground").contains("rank is 1"));
    }

    #[test]
    fn the_rise_of_a_new_component_is_reported() {
        let mixture = [gray(0.9, 100.0, 10.0), gray(0.099, 200.0, 90.0), gray(0.001, 20.0, 4.0)];
        let (words, state) =
            meets(&mixture, 140, Parameters { initial_weight: 0.4, lambda: 0.6, ..parameters() });
        assert_eq!((state.outcome.matched, state.outcome.rank), (0, 2));
        assert!(detail(&words, "new component moved up").contains("from rank 3 to 2"));
    }

    #[test]
    fn changes_of_rank_and_of_b_are_reported() {
        let fast = Parameters { alpha: 0.3, ..parameters() };
        let (words, state) = meets(&[gray(0.72, 100.0, 10.0), gray(0.28, 200.0, 5.0)], 200, fast);
        assert_eq!((state.outcome.matched, state.outcome.rank), (2, 1));
        assert!(words.headline.starts_with("Background: matched component 1 at 0.0 σ"));
        assert!(detail(&words, "moved up").starts_with("It moved up from rank 2 to 1"));
        assert_eq!(detail(&words, "B changed"), "B changed from 1 to 2 in this frame.");
    }

    #[test]
    fn a_nearer_component_of_lower_rank_is_named() {
        let (words, state) = meets(&[gray(0.6, 100.0, 20.0), gray(0.4, 140.0, 20.0)], 130, parameters());
        assert_eq!(state.outcome.matched, 1);
        assert!(detail(&words, "nearer").contains("rank 2 is nearer, 0.5 σ vs 1.5"));
    }

    #[test]
    fn a_component_above_one_of_larger_rank_value_is_reported() {
        let (words, _) = meets(&[gray(0.5, 100.0, 10.0), gray(0.5, 200.0, 10.0)], 100, parameters());
        assert!(!words.details.iter().any(|detail| detail.contains("stays above")));
        let (words, _) = meets(
            &[gray(0.5, 100.0, 10.0), gray(0.1, 200.0, 1.0)],
            100,
            Parameters { min_sigma: 0.5, ..parameters() },
        );
        assert!(detail(&words, "stays above").contains("component 2"));
    }

    #[test]
    fn the_limit_of_sigma_is_reported() {
        let (words, state) = meets(&[gray(1.0, 100.0, 4.0)], 100, parameters());
        assert_eq!(state.pixel.components()[0].sigma(), 4.0);
        assert!(detail(&words, "clamped").contains("minimum 4 (min sigma); without the limit it is 3.98"));
        let (words, _) = meets(&[gray(1.0, 100.0, 4.5)], 100, parameters());
        assert!(!words.details.iter().any(|detail| detail.contains("clamped")));
    }

    #[test]
    fn a_limited_rho_is_reported() {
        let sharp = Parameters { rate: Rate::Density, alpha: 0.9, min_sigma: 0.1, ..parameters() };
        let (words, state) = meets(&[gray(1.0, 100.0, 0.1)], 100, sharp);
        assert_eq!(state.outcome.rho, 1.0);
        assert!(detail(&words, "Updated with").contains("ρ = 1 (limited to 1)"));
        let (words, state) = meets(&[gray(1.0, 100.0, 10.0)], 100, sharp);
        assert!(state.outcome.rho < 1.0 && detail(&words, "Updated with").contains("rate = density"));
    }

    #[test]
    fn doubt_is_reported_with_its_distance_and_limits() {
        let settings = Settings { hysteresis: 24.0, min_sigma: 16.0, ..Settings::preset(Preset::Plain) };
        let mut history = PixelHistory::new((0, 0), Parameters::new(&settings));
        (1..=50).for_each(|number| history.push_colour(number, [100, 100, 100]));
        history.push_colour(51, [100, 130, 100]);
        let words = verdict(&history, 50);
        assert!(!words.foreground, "{words:#?}");
        let told = detail(&words, "Weak match");
        assert!(
            told.contains("30 levels from the component's mean (threshold 24, hysteresis)")
                && told.contains("at least 0.35 of the 11 × 11 neighbourhood"),
            "{told}"
        );
        history.push_colour(52, [100, 115, 100]);
        let near = verdict(&history, 51);
        assert!(!near.details.iter().any(|detail| detail.contains("Weak match")), "{near:#?}");
        let later = overruled(false, true, false, &settings).unwrap_or_default();
        assert!(later.contains("hysteresis 24"), "{later}");
        assert!(overruled(true, false, false, &settings).is_some_and(|words| !words.contains("hysteresis")));
    }

    #[test]
    fn shadow_is_reported_with_its_measurements() {
        let parameters = Parameters::new(&Settings {
            shadow_floor: 0.6,
            shadow_colour: 12.0,
            ..Settings::preset(Preset::Plain)
        });
        let mut history = PixelHistory::new((0, 0), parameters);
        (1..=50).for_each(|number| history.push_colour(number, [180, 160, 120]));
        history.push_colour(51, [126, 112, 84]);
        let words = verdict(&history, 50);
        assert!(words.foreground && words.headline.starts_with("Foreground: no match"), "{words:#?}");
        let told = detail(&words, "Classified as shadow");
        assert!(
            told.contains("component 1 at 0.7 of its brightness (threshold τ = 0.6, shadow threshold)")
                && told.contains("levels (maximum 12, shadow colour)"),
            "{told}"
        );
        let window = PixelHistory {
            parameters: Parameters { shadow: Shadow { window: 7, ..parameters.shadow }, ..parameters },
            ..history.clone()
        };
        let words = verdict(&window, 50);
        assert!(detail(&words, "Classified as shadow").contains("if the 7 × 7 neighbourhood"), "{words:#?}");
        history.push_colour(52, [60, 20, 90]);
        let other = verdict(&history, 51);
        assert!(
            other.foreground && !other.details.iter().any(|detail| detail.contains("shadow")),
            "{other:#?}"
        );
    }

    #[test]
    fn the_effect_of_feedback_is_reported() {
        let settings = Settings {
            hold: 0.1,
            restless_learning: 3.0,
            restless_t: 0.9,
            ..Settings::preset(Preset::Plain)
        };
        let parameters = Parameters::new(&settings);
        let colour = |number: u32, other: bool| (number, [if other { 200 } else { 60 }; 3]);
        let steady = (1..=50).map(|number| colour(number, number > 35));
        let history = PixelHistory::of_colours((0, 0), parameters, steady);
        let words = verdict(&history, 49);
        let told = detail(&words, "consecutive");
        assert!(
            words.foreground
                && told.contains("α is 0.1 of 0.01")
                && told.contains("for 14 consecutive frames"),
            "{told}"
        );
        assert!(detail(&words, "Updated with").contains("α = 0.001."), "{words:#?}");
        assert!(
            !verdict(&history, 30)
                .details
                .iter()
                .any(|told| told.contains("flickers") || told.contains("α is"))
        );

        let flicker = (1..=200).map(|number| colour(number, number % 7 == 0));
        let history = PixelHistory::of_colours((0, 0), parameters, flicker);
        let words = verdict(&history, 199);
        let told = detail(&words, "T is raised from 0.70 to 0.");
        assert!(told.contains("its verdict changed in") && !words.foreground, "{words:#?}");
        let told: Vec<_> = (20..60).flat_map(|index| verdict(&history, index).details).collect();
        let count = told
            .iter()
            .filter(|told| told.contains("this pixel flickers, and was foreground for only 1 "))
            .count();
        assert!(count > 0, "{told:#?}");
    }

    #[test]
    fn the_alpha_of_the_warm_up_is_reported() {
        let (words, _) = meets(&[gray(1.0, 100.0, 10.0)], 100, Parameters { warm_up: 100, ..parameters() });
        assert!(detail(&words, "Updated with").contains("α = 0.5 = 1/t (warm-up)"));
    }

    #[test]
    fn a_sum_that_never_exceeds_t_is_reported() {
        let (words, state) = meets(
            &[gray(0.5, 100.0, 10.0), gray(0.2, 200.0, 10.0)],
            100,
            Parameters { t: 0.9, ..parameters() },
        );
        assert_eq!(state.outcome.background_count, 2);
        assert!(words.details[0].contains("all 2 components in use: no sum of weights exceeds T = 0.9"));
    }

    #[test]
    fn shown_numbers_never_contradict_the_comparison() {
        let (words, _) = meets(&[gray(1.0, 100.0, 7.99)], 120, parameters());
        assert!(words.headline.contains("at 2.503 σ (threshold 2.5)"), "{}", words.headline);
        assert_eq!(sum_above(&[0.5, 0.2004], 0.7), "0.5000 + 0.2004");
        assert_eq!(pair(0.04918, 0.04916, 4), ("0.04918".to_owned(), "0.04916".to_owned()));
    }

    #[test]
    fn numbers_have_few_digits() {
        for (value, text) in [
            (0.7, "0.7"),
            (20.0, "20"),
            (51.96, "51.96"),
            (1234.6, "1235"),
            (0.0, "0"),
            (0.002, "0.002"),
            (1.234e-7, "1.23e-7"),
            (1.0, "1"),
            (9.999_99, "10"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn overruling_stages_name_the_filters_that_could_cause_it() {
        let settings = Settings { median: 5, opening: 3, closing: 7, ..Settings::preset(Preset::Plain) };
        assert_eq!(overruled(true, true, false, &settings), None);
        assert_eq!(overruled(false, false, false, &settings), None);
        let gone = overruled(true, false, false, &settings).unwrap();
        assert_eq!(
            gone,
            "Changed by a later stage: after post-processing (median 5, opening 3) this pixel is background."
        );
        let come = overruled(false, true, false, &settings).unwrap();
        assert!(come.contains("(median 5, closing 7) this pixel is foreground"), "{come}");
        let ignored = overruled(true, false, true, &settings).unwrap();
        assert!(
            ignored.contains("outside the analysed area") && !ignored.contains("post-processing"),
            "{ignored}"
        );
        assert_eq!(overruled(false, false, true, &settings), None);
    }
}
