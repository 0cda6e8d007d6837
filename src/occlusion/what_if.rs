//! What would have kept an event from happening: the nearest value of each setting at which it does not.
//!
//! Every answer is a trial: the regions of the frames before the event go through tracking and
//! occlusion again under one other value. No rule is turned round on paper, so what is told is true
//! of the whole reasoning, whatever else the value changes on the way.

use std::sync::Arc;

use rayon::prelude::*;

use super::compare::Reach;
use super::{Event, Reasoner, Seen};
use crate::frame::Size;
use crate::regions::Region;
use crate::settings::{Kind, SETTINGS, Setting, Settings, Span, Stage, Value};
use crate::tracking::Identity;

/// How far from the present value to the end of a range, on each side, is tried first.
const STEPS: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
/// How often the way to the nearest value that prevents the event is halved.
const HALVINGS: u32 = 4;
/// A trial goes on by so many frames at a time.
const FRAMES: usize = 4;
/// So many trials go on side by side.
const TRIALS: usize = 16;

/// What is asked.
#[derive(Clone)]
pub struct Question {
    /// The event, as tracking told it under `settings`.
    pub event: Event,
    /// The settings under which it happened.
    pub settings: Settings,
    /// Number and regions of the frames that led to it, of those in which it was decided, and of those after it in which it
    /// must not happen either.
    pub frames: Arc<Vec<(u32, Arc<Vec<Region>>)>>,
    /// The size of the frames.
    pub size: Size,
    /// Frames a second.
    pub fps: f32,
}

/// One setting's answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prevention {
    /// The setting's name.
    pub setting: &'static str,
    /// The nearest value that was found at which the event does not happen.
    pub value: Value,
    /// Whether it is greater than the present one; `None` of a choice among words.
    pub above: Option<bool>,
}

impl Prevention {
    /// In a few signs: `same_colour ≥ 31`, `placing = predicted`.
    pub fn words(&self) -> String {
        let sign = match self.above {
            Some(true) => '≥',
            Some(false) => '≤',
            None => '=',
        };
        format!("{} {sign} {}", self.setting, self.value)
    }
}

/// How far the search has come.
#[derive(Clone, Debug, PartialEq)]
pub struct WhatIf {
    /// The event that was asked about.
    pub event: Event,
    /// What prevents it, in the order of the settings.
    pub preventions: Vec<Prevention>,
    /// Trials that were made, and all that are known to be needed.
    pub tried: (usize, usize),
    /// Whether the event happens at all when those frames alone are looked at; if not, nothing can be said.
    pub happens: bool,
    /// Whether nothing is left to try.
    pub done: bool,
    /// The number of the last frame that was looked at: what prevents the event does so up to there.
    pub until: u32,
}

/// The centre of each track in a frame, in pixels.
type Centres = Vec<(Identity, [f32; 2])>;

/// What follows the event under the present settings.
#[derive(Default)]
struct Sequel {
    /// All events of its kind.
    events: Vec<Event>,
    /// Identity and centre of each track, by frame, from the event's first possible frame on.
    tracks: Vec<(u32, Centres)>,
}

impl Sequel {
    fn take_in(&mut self, seen: &Seen, number: u32, question: &Question, reach: Reach) {
        self.events.extend(seen.events.iter().filter(|event| event.kind == question.event.kind).cloned());
        if number + reach.frames >= question.event.frame {
            let tracks = seen.tracks.iter().map(|track| (track.id, track.centre));
            self.tracks.push((number, tracks.collect()));
        }
    }

    /// Whether an event of another trial is the one that is asked about, only later: it happens to the same objects, and
    /// there is none like it under the present settings. Identities differ between trials, places hardly do.
    fn is_delayed(&self, asked: &Event, event: &Event, reach: Reach) -> bool {
        if event.kind != asked.kind
            || event.frame <= asked.frame
            || self.events.iter().any(|other| reach.covers(other, event))
        {
            return false;
        }
        let Some(original) = self.events.iter().find(|other| reach.covers(asked, other)) else {
            return false;
        };
        // Where each was last seen until then.
        let mut places = vec![[asked.x, asked.y]];
        for id in original.objects.iter().chain(&original.becomes) {
            let until = self.tracks.iter().rev().filter(|(number, _)| *number <= event.frame);
            let last = until.flat_map(|(_, tracks)| tracks).find(|(other, _)| other == id);
            places.extend(last.map(|(_, centre)| *centre));
        }
        places.iter().any(|[x, y]| (event.x - x).hypot(event.y - y) <= reach.pixels)
    }
}

/// Frames going through tracking and occlusion under some settings.
struct Trial {
    reasoner: Reasoner,
    at: usize,
    /// Whether the event happened, once that is known.
    happened: Option<bool>,
}

impl Trial {
    fn new(question: &Question, settings: &Settings) -> Self {
        Self { reasoner: Reasoner::new(settings, question.size, question.fps), at: 0, happened: None }
    }

    /// Goes on by some frames. `sequel` is what follows the event under the present settings.
    fn go_on(&mut self, question: &Question, sequel: &Sequel) {
        let reach = Reach::of(question.size, question.fps);
        let same = |event: &Event| {
            reach.covers(&question.event, event) || sequel.is_delayed(&question.event, event, reach)
        };
        if self.frames(question).any(|(_, seen)| seen.events.iter().any(same)) {
            self.happened = Some(true);
        } else {
            self.end(question, false);
        }
    }

    /// Goes on by some frames under the present settings, and notes what follows the event.
    fn go_on_noting(&mut self, question: &Question, sequel: &mut Sequel) {
        let reach = Reach::of(question.size, question.fps);
        for (number, seen) in self.frames(question) {
            sequel.take_in(&seen, number, question, reach);
        }
        self.end(question, sequel.events.iter().any(|event| reach.covers(&question.event, event)));
    }

    /// The next frames through tracking and occlusion.
    fn frames<'a>(&'a mut self, question: &'a Question) -> impl Iterator<Item = (u32, Seen)> + 'a {
        let from = self.at;
        question.frames.iter().skip(from).take(FRAMES).map(|(number, regions)| {
            self.at += 1;
            (*number, self.reasoner.step(*number, regions))
        })
    }

    /// Settles whether the event happened if no frame is left.
    fn end(&mut self, question: &Question, happened: bool) {
        if self.at >= question.frames.len() {
            self.happened = Some(happened);
        }
    }
}

/// One way from the present value of a setting, on which the nearest value is looked for.
struct Way {
    setting: &'static Setting,
    above: Option<bool>,
    /// Values to try, the nearest first.
    steps: Vec<Value>,
    /// The farthest value known at which the event happens.
    happens: Value,
    /// The nearest value known at which it does not.
    prevents: Option<Value>,
    halvings: u32,
    trial: Option<(Value, Trial)>,
}

impl Way {
    /// The value to try next.
    fn next(&self) -> Option<Value> {
        match self.prevents {
            None => self.steps.first().copied(),
            Some(prevents) if self.above.is_some() && self.halvings < HALVINGS => {
                between(&self.setting.kind, self.happens, prevents)
            }
            Some(_) => None,
        }
    }

    /// Takes in how a trial ended.
    fn learn(&mut self, value: Value, happened: bool) {
        if self.prevents.is_none() {
            self.steps.remove(0);
        } else {
            self.halvings += 1;
        }
        if happened {
            self.happens = value;
        } else {
            self.prevents = Some(value);
        }
    }

    /// About how many trials are left.
    fn left(&self) -> usize {
        match self.prevents {
            None => self.steps.len(),
            Some(_) if self.next().is_some() => (HALVINGS - self.halvings) as usize,
            Some(_) => 0,
        }
    }
}

/// A search under way.
pub struct Search {
    question: Question,
    /// The event under the present settings.
    present: Trial,
    sequel: Sequel,
    ways: Vec<Way>,
    tried: usize,
}

impl Search {
    /// Nothing tried yet.
    pub fn new(question: Question) -> Self {
        let settings = SETTINGS.iter().filter(|setting| setting.stage >= Stage::Tracking);
        let ways = settings.flat_map(|setting| ways(setting, setting.get(&question.settings))).collect();
        Self {
            present: Trial::new(&question, &question.settings),
            sequel: Sequel::default(),
            question,
            ways,
            tried: 0,
        }
    }

    /// Does some milliseconds of work; whether there was any left.
    pub fn go_on(&mut self) -> bool {
        let question = &self.question;
        match self.present.happened {
            None => {
                self.present.go_on_noting(question, &mut self.sequel);
                return true;
            }
            Some(false) => return false,
            Some(true) => {}
        }
        let sequel = &self.sequel;
        let mut busy: Vec<&mut Way> =
            self.ways.iter_mut().filter(|way| way.trial.is_some() || way.next().is_some()).collect();
        // Those under way first.
        busy.sort_by_key(|way| way.trial.is_none());
        busy.truncate(TRIALS);
        busy.par_iter_mut().for_each(|way| {
            if way.trial.is_none()
                && let Some(value) = way.next()
            {
                let mut settings = question.settings.clone();
                // Values are made within the range.
                if way.setting.set(&mut settings, value).is_ok() {
                    way.trial = Some((value, Trial::new(question, &settings)));
                } else {
                    way.learn(value, true);
                }
            }
            if let Some((_, trial)) = &mut way.trial {
                trial.go_on(question, sequel);
            }
        });
        let worked = !busy.is_empty();
        for way in busy {
            let ended = way.trial.as_ref().and_then(|(value, trial)| Some((*value, trial.happened?)));
            if let Some((value, happened)) = ended {
                way.trial = None;
                way.learn(value, happened);
                self.tried += 1;
            }
        }
        worked
    }

    /// What is known so far.
    pub fn what_if(&self) -> WhatIf {
        let left: usize = self.ways.iter().map(Way::left).sum();
        let preventions = self.ways.iter().filter_map(|way| {
            Some(Prevention { setting: way.setting.name, value: way.prevents?, above: way.above })
        });
        let happens = self.present.happened != Some(false);
        WhatIf {
            event: self.question.event.clone(),
            preventions: preventions.collect(),
            tried: (self.tried, self.tried + left),
            happens,
            until: self.question.frames.last().map_or(0, |(number, _)| *number),
            done: !happens || (self.present.happened.is_some() && left == 0),
        }
    }
}

/// The ways from a present value: up and down, or to each other word.
fn ways(setting: &'static Setting, present: Value) -> Vec<Way> {
    let way = |above, steps: Vec<Value>| Way {
        setting,
        above,
        steps,
        happens: present,
        prevents: None,
        halvings: 0,
        trial: None,
    };
    if let Kind::Choice(words) = setting.kind {
        let others = words.iter().map(|&word| Value::Choice(word)).filter(|&word| word != present);
        return others.map(|word| way(None, vec![word])).collect();
    }
    let Some((low, high)) = ends(&setting.kind, present) else { return Vec::new() };
    let here = scale(&setting.kind, present);
    [(false, low), (true, high)]
        .into_iter()
        .map(|(above, end)| {
            let mut steps: Vec<Value> = Vec::new();
            for step in STEPS {
                let value = value(&setting.kind, present, here + (end - here) * step);
                let farther = steps.last().copied().unwrap_or(present);
                if value != farther && setting.kind.contains(value) {
                    steps.push(value);
                }
            }
            way(Some(above), steps)
        })
        .filter(|way| !way.steps.is_empty())
        .collect()
}

/// The ends of a range on its scale; of times, what is worth trying around the present one.
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

/// A value on the scale on which its range is looked through: numbers by ratio where that is how they are set.
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

/// To three digits: what is told is what was tried.
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
    fn question(kind: EventKind) -> Option<Question> {
        let settings = Settings { placing: crate::settings::Placing::Predicted, ..Settings::default() };
        let frames: Vec<_> = (1..=100_u32)
            .map(|number| {
                let seen = !(40..52).contains(&number);
                (
                    number,
                    Arc::new(if seen { vec![region(1, 60.0 + number as f32, 24.0)] } else { Vec::new() }),
                )
            })
            .collect();
        let mut reasoner = Reasoner::new(&settings, SIZE, 25.0);
        let events: Vec<Event> =
            frames.iter().flat_map(|(number, regions)| reasoner.step(*number, regions).events).collect();
        let event = events.into_iter().find(|event| event.kind == kind)?;
        Some(Question { event, settings, frames: Arc::new(frames), size: SIZE, fps: 25.0 })
    }

    fn answer(question: Question) -> WhatIf {
        let mut search = Search::new(question);
        let mut pieces = 0;
        while search.go_on() {
            pieces += 1;
            assert!(pieces < 100_000);
        }
        search.what_if()
    }

    #[test]
    fn what_is_told_prevents_the_event_and_the_present_settings_do_not() {
        let question = question(EventKind::Reappear).unwrap();
        let answer = answer(question.clone());
        assert!(answer.happens && answer.done && answer.tried.0 == answer.tried.1, "{answer:?}");
        let mut search = Search::new(question.clone());
        while search.present.happened.is_none() {
            search.go_on();
        }
        let happens = |settings: &Settings| {
            let mut trial = Trial::new(&question, settings);
            while trial.happened.is_none() {
                trial.go_on(&question, &search.sequel);
            }
            trial.happened.unwrap()
        };
        assert!(happens(&question.settings));
        for prevention in &answer.preventions {
            let setting = Setting::named(prevention.setting).unwrap();
            let mut settings = question.settings.clone();
            setting.set(&mut settings, prevention.value).unwrap();
            assert!(!happens(&settings), "{}", prevention.words());
        }
        // Who is given up after less than the twelve frames does not reappear.
        let given_up = answer.preventions.iter().find(|each| each.setting == "max_hidden").unwrap();
        let Value::Span(span) = given_up.value else { panic!() };
        assert!(
            given_up.above == Some(false) && (2..=13).contains(&span.frames(25.0)),
            "{}",
            given_up.words()
        );
    }

    #[test]
    fn what_happens_later_to_the_same_objects_is_not_prevented() {
        let asked = question(EventKind::Reappear).unwrap().event;
        let [id] = asked.objects[..] else { panic!() };
        let at = |frame: u32, x: f32| Event { frame, x, ..asked.clone() };
        let reach = Reach::of(SIZE, 25.0);
        let tracks =
            (0..100).map(|frame| (asked.frame + frame, vec![(id, [asked.x + 2.0 * frame as f32, asked.y])]));
        let mut sequel = Sequel { events: vec![asked.clone()], tracks: tracks.collect() };
        let delayed = |sequel: &Sequel, event: &Event| sequel.is_delayed(&asked, event, reach);
        let later = at(asked.frame + 60, asked.x + 120.0);
        assert!(delayed(&sequel, &later), "it went there");
        assert!(!delayed(&sequel, &at(asked.frame + 60, asked.x + 220.0)), "somewhere else, to another one");
        assert!(!delayed(&sequel, &Event { kind: EventKind::Merge, ..later.clone() }), "something else");
        sequel.events.push(at(asked.frame + 64, asked.x + 128.0));
        assert!(!delayed(&sequel, &later), "it happens as well under the present settings");
    }

    #[test]
    fn an_event_that_never_happened_cannot_be_prevented() {
        let mut question = question(EventKind::Reappear).unwrap();
        question.event.kind = EventKind::Merge;
        let answer = answer(question);
        assert!(!answer.happens && answer.done && answer.preventions.is_empty());
    }

    #[test]
    fn values_to_try_lie_in_the_range_and_apart() {
        for setting in SETTINGS {
            let present = setting.get(&Settings::default());
            for way in ways(setting, present) {
                let mut before = scale(&setting.kind, present);
                for step in &way.steps {
                    assert!(setting.kind.contains(*step), "{} {step}", setting.name);
                    let here = scale(&setting.kind, *step);
                    match way.above {
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
