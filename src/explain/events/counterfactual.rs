//! Counterfactuals of an event: the nearest value of each setting at which it does not happen.
//!
//! Every answer is a trial: the regions of the frames around the event go through tracking and occlusion again under
//! one other value. No rule is inverted analytically, so an answer holds for the whole method, including side effects
//! of the value.

use std::sync::Arc;

use rayon::prelude::*;

use crate::explain::events::event_pairs::EventTolerance;
use crate::frame::Size;
use crate::occlusion::{Event, FrameResult, Tracker};
use crate::regions::Region;
use crate::settings::{Kind, SETTINGS, Setting, Settings, Span, Stage, Value};
use crate::tracking::Identity;

/// Fractions of the distance from the present value to the end of its range, on each side, that are tried first.
const RANGE_FRACTIONS: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
/// How often the interval to the nearest preventing value is bisected.
const MAX_BISECTIONS: u32 = 4;
/// Frames that a trial advances at a time.
const FRAMES_PER_ADVANCE: usize = 4;
/// Trials that advance in parallel.
const MAX_PARALLEL_TRIALS: usize = 16;

/// The regions of one frame.
#[derive(Clone)]
pub struct FrameRegions {
    /// The frame's number.
    pub number: u32,
    /// Its time in seconds since the source's first frame.
    pub time: f64,
    /// Its regions.
    pub regions: Arc<Vec<Region>>,
}

/// The event, and the frames and settings under which it happened.
#[derive(Clone)]
pub struct CounterfactualQuery {
    /// The event as detected under `settings`.
    pub event: Event,
    /// The settings under which it happened.
    pub settings: Settings,
    /// The frames that led to it, those in which it was decided, and those after it in which it must not happen either.
    pub frames: Arc<Vec<FrameRegions>>,
    /// The size of the frames.
    pub size: Size,
    /// Frames per second.
    pub fps: f32,
}

/// A value of one setting that prevents the event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prevention {
    /// The setting's name.
    pub setting: &'static str,
    /// The nearest value found at which the event does not happen.
    pub value: Value,
    /// Whether it is greater than the present one; `None` for a choice among words.
    pub above: Option<bool>,
}

impl Prevention {
    /// As a short formula: `same_colour ≥ 31`, `placing = predicted`.
    pub fn words(&self) -> String {
        let sign = match self.above {
            Some(true) => '≥',
            Some(false) => '≤',
            None => '=',
        };
        format!("{} {sign} {}", self.setting, self.value)
    }
}

/// The results so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Counterfactual {
    /// The event.
    pub event: Event,
    /// What prevents it, in the order of the settings.
    pub preventions: Vec<Prevention>,
    /// Trials done, and all that are known to be needed.
    pub tried: (usize, usize),
    /// Whether the event happens when only these frames are processed; if not, there is no answer.
    pub happens: bool,
    /// Whether all trials are done.
    pub done: bool,
    /// Number of the last processed frame: a preventing value prevents the event up to there.
    pub until: u32,
}

/// The centre of each track in a frame, in pixels.
type Centres = Vec<(Identity, [f32; 2])>;

/// Events and tracks after the event under the present settings.
#[derive(Default)]
struct BaselineRecord {
    /// All events of the same kind.
    events: Vec<Event>,
    /// Identity and centre of each track, by frame, from the event's first possible frame on.
    tracks: Vec<(u32, Centres)>,
}

impl BaselineRecord {
    fn record(
        &mut self,
        result: &FrameResult,
        number: u32,
        query: &CounterfactualQuery,
        tolerance: EventTolerance,
    ) {
        self.events.extend(result.events.iter().filter(|event| event.kind == query.event.kind).cloned());
        if number + tolerance.frames >= query.event.frame {
            let tracks = result.tracks.iter().map(|track| (track.id, track.centre));
            self.tracks.push((number, tracks.collect()));
        }
    }

    /// Whether an event of another trial is the event in question, only later: it happens to the same objects, and
    /// there is none like it under the present settings. Identities differ between trials, places hardly do.
    fn is_delayed(&self, queried: &Event, event: &Event, tolerance: EventTolerance) -> bool {
        if event.kind != queried.kind
            || event.frame <= queried.frame
            || self.events.iter().any(|other| tolerance.matches(other, event))
        {
            return false;
        }
        let Some(original) = self.events.iter().find(|other| tolerance.matches(queried, other)) else {
            return false;
        };
        // The last place of each object until then.
        let mut places = vec![[queried.x, queried.y]];
        for id in original.objects.iter().chain(&original.becomes) {
            let until = self.tracks.iter().rev().filter(|(number, _)| *number <= event.frame);
            let last = until.flat_map(|(_, tracks)| tracks).find(|(other, _)| other == id);
            places.extend(last.map(|(_, centre)| *centre));
        }
        places.iter().any(|[x, y]| (event.x - x).hypot(event.y - y) <= tolerance.pixels)
    }
}

/// A run of the frames through tracking and occlusion under some settings.
struct Trial {
    tracker: Tracker,
    at: usize,
    /// Whether the event happened, once that is known.
    happened: Option<bool>,
}

impl Trial {
    fn new(query: &CounterfactualQuery, settings: &Settings) -> Self {
        Self { tracker: Tracker::new(settings, query.size, query.fps), at: 0, happened: None }
    }

    /// Advances by some frames. `baseline` is what follows the event under the present settings.
    fn advance(&mut self, query: &CounterfactualQuery, baseline: &BaselineRecord) {
        let tolerance = EventTolerance::of(query.size, query.fps);
        let is_event = |event: &Event| {
            tolerance.matches(&query.event, event) || baseline.is_delayed(&query.event, event, tolerance)
        };
        if self.frames(query).any(|(_, result)| result.events.iter().any(is_event)) {
            self.happened = Some(true);
        } else {
            self.end(query, false);
        }
    }

    /// Advances by some frames under the present settings, and records what follows the event.
    fn advance_baseline(&mut self, query: &CounterfactualQuery, baseline: &mut BaselineRecord) {
        let tolerance = EventTolerance::of(query.size, query.fps);
        for (number, result) in self.frames(query) {
            baseline.record(&result, number, query, tolerance);
        }
        self.end(query, baseline.events.iter().any(|event| tolerance.matches(&query.event, event)));
    }

    /// The next frames through tracking and occlusion.
    fn frames<'a>(
        &'a mut self,
        query: &'a CounterfactualQuery,
    ) -> impl Iterator<Item = (u32, FrameResult)> + 'a {
        let from = self.at;
        query.frames.iter().skip(from).take(FRAMES_PER_ADVANCE).map(|frame| {
            self.at += 1;
            (frame.number, self.tracker.step(frame.number, frame.time, &frame.regions))
        })
    }

    /// Decides whether the event happened if no frame is left.
    fn end(&mut self, query: &CounterfactualQuery, happened: bool) {
        if self.at >= query.frames.len() {
            self.happened = Some(happened);
        }
    }
}

/// The search for the nearest preventing value on one side of a setting's present value.
struct ValueSearch {
    setting: &'static Setting,
    above: Option<bool>,
    /// Values to try, the nearest first.
    steps: Vec<Value>,
    /// The farthest value known at which the event happens.
    happens: Value,
    /// The nearest value known at which it does not.
    prevents: Option<Value>,
    bisections: u32,
    trial: Option<(Value, Trial)>,
}

impl ValueSearch {
    /// The value to try next.
    fn next(&self) -> Option<Value> {
        match self.prevents {
            None => self.steps.first().copied(),
            Some(prevents) if self.above.is_some() && self.bisections < MAX_BISECTIONS => {
                between(&self.setting.kind, self.happens, prevents)
            }
            Some(_) => None,
        }
    }

    /// Records the outcome of a trial.
    fn record_outcome(&mut self, value: Value, happened: bool) {
        if self.prevents.is_none() {
            self.steps.remove(0);
        } else {
            self.bisections += 1;
        }
        if happened {
            self.happens = value;
        } else {
            self.prevents = Some(value);
        }
    }

    /// Approximate number of trials left.
    fn trials_left(&self) -> usize {
        match self.prevents {
            None => self.steps.len(),
            Some(_) if self.next().is_some() => (MAX_BISECTIONS - self.bisections) as usize,
            Some(_) => 0,
        }
    }
}

/// A search in progress.
pub struct CounterfactualSearch {
    query: CounterfactualQuery,
    /// The event under the present settings.
    present: Trial,
    baseline: BaselineRecord,
    value_searches: Vec<ValueSearch>,
    tried: usize,
}

impl CounterfactualSearch {
    /// A search before its first trial.
    pub fn new(query: CounterfactualQuery) -> Self {
        let settings = SETTINGS.iter().filter(|setting| setting.stage >= Stage::Tracking);
        let value_searches =
            settings.flat_map(|setting| value_searches(setting, setting.get(&query.settings))).collect();
        Self {
            present: Trial::new(&query, &query.settings),
            baseline: BaselineRecord::default(),
            query,
            value_searches,
            tried: 0,
        }
    }

    /// Does some milliseconds of work; whether there was any left.
    pub fn advance(&mut self) -> bool {
        let query = &self.query;
        match self.present.happened {
            None => {
                self.present.advance_baseline(query, &mut self.baseline);
                return true;
            }
            Some(false) => return false,
            Some(true) => {}
        }
        let baseline = &self.baseline;
        let mut busy: Vec<&mut ValueSearch> = self
            .value_searches
            .iter_mut()
            .filter(|search| search.trial.is_some() || search.next().is_some())
            .collect();
        // Trials in progress first.
        busy.sort_by_key(|search| search.trial.is_none());
        busy.truncate(MAX_PARALLEL_TRIALS);
        busy.par_iter_mut().for_each(|search| {
            if search.trial.is_none()
                && let Some(value) = search.next()
            {
                let mut settings = query.settings.clone();
                // Values are made within the range.
                if search.setting.set(&mut settings, value).is_ok() {
                    search.trial = Some((value, Trial::new(query, &settings)));
                } else {
                    search.record_outcome(value, true);
                }
            }
            if let Some((_, trial)) = &mut search.trial {
                trial.advance(query, baseline);
            }
        });
        let worked = !busy.is_empty();
        for search in busy {
            let ended = search.trial.as_ref().and_then(|(value, trial)| Some((*value, trial.happened?)));
            if let Some((value, happened)) = ended {
                search.trial = None;
                search.record_outcome(value, happened);
                self.tried += 1;
            }
        }
        worked
    }

    /// The results so far.
    pub fn report(&self) -> Counterfactual {
        let trials_left: usize = self.value_searches.iter().map(ValueSearch::trials_left).sum();
        let preventions = self.value_searches.iter().filter_map(|search| {
            Some(Prevention { setting: search.setting.name, value: search.prevents?, above: search.above })
        });
        let happens = self.present.happened != Some(false);
        Counterfactual {
            event: self.query.event.clone(),
            preventions: preventions.collect(),
            tried: (self.tried, self.tried + trials_left),
            happens,
            until: self.query.frames.last().map_or(0, |frame| frame.number),
            done: !happens || (self.present.happened.is_some() && trials_left == 0),
        }
    }
}

/// The searches from a present value: below and above, or each other choice.
fn value_searches(setting: &'static Setting, present: Value) -> Vec<ValueSearch> {
    let search = |above, steps: Vec<Value>| ValueSearch {
        setting,
        above,
        steps,
        happens: present,
        prevents: None,
        bisections: 0,
        trial: None,
    };
    if let Kind::Choice(words) = setting.kind {
        let others = words.iter().map(|&word| Value::Choice(word)).filter(|&word| word != present);
        return others.map(|word| search(None, vec![word])).collect();
    }
    let Some((low, high)) = ends(&setting.kind, present) else { return Vec::new() };
    let here = scale(&setting.kind, present);
    [(false, low), (true, high)]
        .into_iter()
        .map(|(above, end)| {
            let mut steps: Vec<Value> = Vec::new();
            for step in RANGE_FRACTIONS {
                let value = value(&setting.kind, present, here + (end - here) * step);
                let farther = steps.last().copied().unwrap_or(present);
                if value != farther && setting.kind.contains(value) {
                    steps.push(value);
                }
            }
            search(Some(above), steps)
        })
        .filter(|search| !search.steps.is_empty())
        .collect()
}

/// The ends of a range on its scale; for times, a useful range around the present one.
fn ends(kind: &Kind, present: Value) -> Option<(f64, f64)> {
    match *kind {
        Kind::Integer { min, max } => {
            Some((scale(kind, Value::Integer(min)), scale(kind, Value::Integer(max))))
        }
        Kind::Real { min, max, open, .. } => {
            let inside = if open { f64::from(max - min) * 1e-3 } else { 0.0 };
            let end = |value: f32, shift: f64| scale(kind, Value::Real((f64::from(value) + shift) as f32));
            Some((end(min, inside), end(max, -inside)))
        }
        Kind::Span { .. } => {
            let here = scale(kind, present);
            Some((0.0, (here * 10.0).max(10.0)))
        }
        Kind::Choice(_) | Kind::OddSize { .. } => None,
    }
}

/// A value on the scale on which its range is searched: by ratio for settings that are set by ratio.
fn scale(kind: &Kind, value: Value) -> f64 {
    match (kind, value) {
        (Kind::Real { logarithmic: true, .. }, Value::Real(value)) => f64::from(value).max(1e-9).ln(),
        (Kind::Integer { .. }, Value::Integer(value)) => f64::from(value).ln_1p(),
        (_, Value::Real(value) | Value::Span(Span::Seconds(value))) => f64::from(value),
        (_, Value::Integer(value) | Value::Span(Span::Frames(value))) => f64::from(value),
        (_, Value::Choice(_)) => 0.0,
    }
}

/// The value of the same kind as `like` at a place on the scale, to three digits.
fn value(kind: &Kind, like: Value, at: f64) -> Value {
    match (kind, like) {
        (Kind::Real { logarithmic: true, .. }, Value::Real(_)) => {
            Value::Real(within(kind, rounded(at.exp())))
        }
        (_, Value::Real(_)) => Value::Real(within(kind, rounded(at))),
        (_, Value::Integer(_)) => Value::Integer(at.exp_m1().round().max(0.0) as u32),
        (_, Value::Span(Span::Frames(_))) => Value::Span(Span::Frames(at.round().max(0.0) as u32)),
        (_, Value::Span(Span::Seconds(_))) => Value::Span(Span::Seconds(rounded(at.max(0.0)))),
        (_, choice) => choice,
    }
}

/// Between two values, or `None` where nothing is.
fn between(kind: &Kind, a: Value, b: Value) -> Option<Value> {
    let middle = value(kind, a, f64::midpoint(scale(kind, a), scale(kind, b)));
    (middle != a && middle != b && kind.contains(middle)).then_some(middle)
}

/// Rounding must not leave the range.
fn within(kind: &Kind, value: f32) -> f32 {
    match *kind {
        Kind::Real { min, max, open: false, .. } => value.clamp(min, max),
        _ => value,
    }
}

/// Rounded to three digits, so that the reported value is the tried one.
fn rounded(value: f64) -> f32 {
    if value == 0.0 || !value.is_finite() {
        return value as f32;
    }
    let step = 10_f64.powi(value.abs().log10().floor() as i32 - 2);
    ((value / step).round() * step) as f32
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::occlusion::EventKind;
    use crate::regions::{Shape, shape::Rect};

    const SIZE: Size = Size::new(320, 240);

    fn region(label: u32, x: f32, w: f32) -> Region {
        let bbox = Rect::new(x.round(), 100.0, w.round(), 60.0);
        let shape = Shape {
            area: bbox.area() as u32,
            bbox,
            centroid: bbox.centre(),
            extent: 1.0,
            ..Shape::default()
        };
        let colour = [200, 60, 60];
        let histogram = crate::regions::colour::tests::histogram(&[(colour, shape.area)]);
        Region { label, shape, colour, histogram, mosaic: Arc::default() }
    }

    /// Somebody walks to the right and has no region between the frames 40 and 52.
    fn query(kind: EventKind) -> Option<CounterfactualQuery> {
        let settings = Settings { placing: crate::settings::Placing::Predicted, ..Settings::default() };
        let frames: Vec<_> = (1..=100_u32)
            .map(|number| {
                let is_visible = !(40..52).contains(&number);
                let region = is_visible.then(|| region(1, 60.0 + number as f32, 24.0));
                FrameRegions {
                    number,
                    time: f64::from(number) / 25.0,
                    regions: Arc::new(region.into_iter().collect()),
                }
            })
            .collect();
        let mut tracker = Tracker::new(&settings, SIZE, 25.0);
        let events: Vec<Event> = frames
            .iter()
            .flat_map(|frame| tracker.step(frame.number, frame.time, &frame.regions).events)
            .collect();
        let event = events.into_iter().find(|event| event.kind == kind)?;
        Some(CounterfactualQuery { event, settings, frames: Arc::new(frames), size: SIZE, fps: 25.0 })
    }

    fn answer(query: CounterfactualQuery) -> Counterfactual {
        let mut search = CounterfactualSearch::new(query);
        let mut pieces = 0;
        while search.advance() {
            pieces += 1;
            assert!(pieces < 100_000);
        }
        search.report()
    }

    #[test]
    fn reported_settings_prevent_the_event_and_the_current_ones_do_not() {
        let query = query(EventKind::Reappear).unwrap();
        let answer = answer(query.clone());
        assert!(answer.happens && answer.done && answer.tried.0 == answer.tried.1, "{answer:?}");
        let mut search = CounterfactualSearch::new(query.clone());
        while search.present.happened.is_none() {
            search.advance();
        }
        let happens = |settings: &Settings| {
            let mut trial = Trial::new(&query, settings);
            while trial.happened.is_none() {
                trial.advance(&query, &search.baseline);
            }
            trial.happened.unwrap()
        };
        assert!(happens(&query.settings));
        for prevention in &answer.preventions {
            let setting = Setting::named(prevention.setting).unwrap();
            let mut settings = query.settings.clone();
            setting.set(&mut settings, prevention.value).unwrap();
            assert!(!happens(&settings), "{}", prevention.words());
        }
        // An object that is given up after less than the twelve frames does not reappear.
        let given_up = answer.preventions.iter().find(|each| each.setting == "max_hidden").unwrap();
        let Value::Span(span) = given_up.value else { panic!() };
        assert!(
            given_up.above == Some(false) && (2..=13).contains(&span.frames(25.0)),
            "{}",
            given_up.words()
        );
    }

    #[test]
    fn an_event_that_is_only_delayed_is_not_prevented() {
        let queried = query(EventKind::Reappear).unwrap().event;
        let [id] = queried.objects[..] else { panic!() };
        let at = |frame: u32, x: f32| Event { frame, x, ..queried.clone() };
        let tolerance = EventTolerance::of(SIZE, 25.0);
        let tracks = (0..100)
            .map(|frame| (queried.frame + frame, vec![(id, [queried.x + 2.0 * frame as f32, queried.y])]));
        let mut baseline = BaselineRecord { events: vec![queried.clone()], tracks: tracks.collect() };
        let delayed =
            |baseline: &BaselineRecord, event: &Event| baseline.is_delayed(&queried, event, tolerance);
        let later = at(queried.frame + 60, queried.x + 120.0);
        assert!(delayed(&baseline, &later), "it went there");
        assert!(
            !delayed(&baseline, &at(queried.frame + 60, queried.x + 220.0)),
            "somewhere else, to another one"
        );
        assert!(!delayed(&baseline, &Event { kind: EventKind::Merge, ..later.clone() }), "something else");
        baseline.events.push(at(queried.frame + 64, queried.x + 128.0));
        assert!(!delayed(&baseline, &later), "it happens as well under the present settings");
    }

    #[test]
    fn an_event_that_never_happened_cannot_be_prevented() {
        let mut query = query(EventKind::Reappear).unwrap();
        query.event.kind = EventKind::Merge;
        let answer = answer(query);
        assert!(!answer.happens && answer.done && answer.preventions.is_empty());
    }

    #[test]
    fn values_to_try_lie_in_the_range_and_apart() {
        for setting in SETTINGS {
            let present = setting.get(&Settings::default());
            for search in value_searches(setting, present) {
                let mut before = scale(&setting.kind, present);
                for step in &search.steps {
                    assert!(setting.kind.contains(*step), "{} {step}", setting.name);
                    let here = scale(&setting.kind, *step);
                    match search.above {
                        Some(true) => assert!(here > before, "{} {step}", setting.name),
                        Some(false) => assert!(here < before, "{} {step}", setting.name),
                        None => assert_ne!(*step, present),
                    }
                    before = here;
                }
            }
        }
        assert_eq!((rounded(0.012_345), rounded(31.26), rounded(-1234.5)), (0.0123, 31.3, -1230.0));
    }
}
