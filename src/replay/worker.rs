//! The worker's side: one small piece of work after another, the most urgent first.
//!
//! In this order: the frame that is wanted in view, under both settings where two are compared; what the chosen pixel
//! would be in it under other settings; the pixel's history, those of the pinned pixels, and what is seen around the
//! chosen one; the analysis ahead, of both abreast; and when all that is done, scores, what would have kept an event from
//! happening, and how right other settings would be around a pixel.
//! Between two pieces it looks at what was asked meanwhile. A piece takes some milliseconds, or as long as a frame
//! takes to decode or to analyse where that is more.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::gather::{self, Follower as _};
use super::lane::{Lane, Step};
use super::pins::Pins;
use super::region::Region;
use super::region_tuner::RegionTuner;
use super::rival::Rival;
use super::run::Towards;
use super::scoring::Scored;
use super::session::{self, Analysed, Around, Explained, Knobs, Known, Mapped, Pixel, Requests, Shared};
use super::tuner::Tuner;
use super::what_if::Asker;
use super::{Beside, Phase, Progress, Shown, Start, Timeline, same};
use crate::frame::Frame;
use crate::mixture::{PixelHistory, Quantity};
use crate::occlusion::EventKind;
use crate::regions::Roi;
use crate::settings::{Settings, Stage};
use crate::source::cache::{Fetched, FrameCache, Keep};
use crate::source::{SourceError, SourceInfo};
use crate::tracking::{Identity, TrackState};
use crate::truth::Truth;

/// Growing things are published at most so often.
const PACE: Duration = Duration::from_millis(100);

/// After the first occlusion was decided, so many more frames show how it goes on.
const INTO_OCCLUSION: u32 = 10;

/// Which of two choices of settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Which {
    /// The one in view.
    InView,
    /// The one that is compared with it.
    Rival,
}

/// What stops the work on a choice of settings, in words for the user.
struct Stopped(String);

impl<E: std::error::Error> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

pub(super) struct Worker<'a> {
    shared: &'a Shared,
    frames: FrameCache,
    info: Arc<SourceInfo>,
    /// Memory for going back in time, in bytes.
    model_budget: usize,
    /// What is in view.
    lane: Lane,
    /// What is compared with it.
    rival: Rival,
    /// The position that the window wants to see.
    wanted: u32,
    /// What will be wanted once it is found.
    aim: Option<Aim>,
    /// A live source: the newest frame is what is wanted.
    follow: bool,
    ahead: Ahead,
    pixel: Option<(u32, u32)>,
    pins: Pins,
    region: Region,
    tuner: Tuner,
    region_tuner: RegionTuner,
    asker: Asker,
    /// What is mapped of the frame in view.
    map: Option<Quantity>,
    /// By what results are scored.
    truth: Option<Arc<Truth>>,
    stopped: bool,
    shown: Option<Arc<Shown>>,
    busy: Option<Progress>,
    meter: Meter,
    outbox: Outbox,
}

/// What waits to be published, and when that was last done.
struct Outbox {
    timeline_grew: bool,
    beside_grew: bool,
    /// The chosen pixel, a pinned one, or the share of a region.
    pixel_grew: bool,
    warnings: Vec<String>,
    told_of: Told,
    /// As last published.
    pixel: Option<Arc<PixelHistory>>,
    /// How far the timeline reached that was last published.
    analysed: u32,
    /// As last published.
    busy: Option<Progress>,
    published: Instant,
    publishing_took: Duration,
}

/// What is told once.
#[derive(Default)]
struct Told {
    /// That frames are no longer kept.
    gone: bool,
    /// That a live source cannot be compared.
    live: bool,
}

/// What is analysed beyond what is asked for.
#[derive(PartialEq)]
enum Ahead {
    All,
    Nothing,
}

/// A frame to show that is not known yet.
enum Aim {
    Number(u32),
    /// The first occlusion: the position at which it was decided, and who takes part.
    Occlusion(Option<(u32, Vec<Identity>)>),
}

impl<'a> Worker<'a> {
    /// Opens the frames and works until the session is over.
    pub(super) fn open_and_run(
        shared: &'a Shared,
        open: impl FnOnce() -> Result<FrameCache, SourceError>,
        under: (Settings, Option<Arc<Roi>>),
        start: Start,
        model_budget: usize,
    ) {
        match Self::open(shared, open, under, start, model_budget) {
            Ok(mut worker) => worker.work(),
            Err(Stopped(why)) => shared.fail(why),
        }
    }

    fn open(
        shared: &'a Shared,
        open: impl FnOnce() -> Result<FrameCache, SourceError>,
        (settings, roi): (Settings, Option<Arc<Roi>>),
        start: Start,
        model_budget: usize,
    ) -> Result<Self, Stopped> {
        let frames = open()?;
        let info = Arc::clone(frames.info());
        let lane = Lane::new(Arc::new(settings), roi, &info, model_budget)?;
        shared.publish(|state| {
            state.phase = Phase::Ready;
            state.info = Some(Arc::clone(&info));
        });
        Ok(Self {
            shared,
            frames,
            follow: info.live,
            ahead: Ahead::All,
            info,
            model_budget,
            lane,
            rival: Rival::default(),
            wanted: 0,
            aim: match start {
                Start::First => None,
                Start::FirstOcclusion => Some(Aim::Occlusion(None)),
                Start::Frame(number) => Some(Aim::Number(number)),
            },
            pixel: None,
            pins: Pins::default(),
            region: Region::default(),
            tuner: Tuner::default(),
            region_tuner: RegionTuner::default(),
            asker: Asker::default(),
            map: None,
            truth: None,
            stopped: false,
            shown: None,
            busy: None,
            meter: Meter::default(),
            outbox: Outbox {
                timeline_grew: true,
                beside_grew: false,
                pixel_grew: false,
                warnings: Vec::new(),
                told_of: Told::default(),
                pixel: None,
                analysed: 0,
                busy: None,
                published: Instant::now(),
                publishing_took: Duration::ZERO,
            },
        })
    }

    fn work(&mut self) {
        let mut resting = false;
        while let Some(requests) = self.shared.take_requests(resting) {
            let worked = self.take(requests).and_then(|()| self.piece());
            resting = !worked.unwrap_or_else(|Stopped(why)| {
                self.stopped = true;
                self.shared.fail(why);
                false
            });
            self.publish_in_time(resting);
        }
    }

    fn take(&mut self, requests: Requests) -> Result<(), Stopped> {
        if let Some(ahead) = requests.analyse_ahead {
            // Where nothing is left to stop, other settings are run through as ever.
            let through = |lane: &Lane| lane.is_through(&self.frames);
            let nothing = through(&self.lane) && self.rival.lane.as_ref().is_none_or(through);
            self.ahead = if ahead || nothing { Ahead::All } else { Ahead::Nothing };
            if !ahead {
                self.stay();
            }
        }
        if let Some(position) = requests.show {
            self.aim = None;
            self.wanted = position;
            self.follow = self.info.live && position >= self.lane.run.front().saturating_sub(1);
        }
        if let Some(Pixel(pixel)) = requests.inspect {
            self.pixel = pixel.filter(|&(x, y)| self.info.size.index(x, y).is_some());
            self.lane.inspect(self.pixel);
            if let Some(lane) = &mut self.rival.lane {
                lane.inspect(self.pixel);
            }
            self.show_pixel();
        }
        if let Some(Knobs(knobs)) = requests.tune {
            self.tuner.choose(knobs);
            self.region_tuner.tune(knobs);
        }
        if let Some(Mapped(quantity)) = requests.map {
            self.map = quantity;
        }
        if let Some(mut pins) = requests.pins {
            pins.retain(|&(x, y)| self.info.size.index(x, y).is_some());
            self.pins.choose(&pins, self.lane.settings());
            self.outbox.pixel_grew = true;
        }
        if let Some(Around(region)) = requests.region {
            self.region.choose(region, self.info.size);
            self.outbox.pixel_grew = true;
        }
        if let Some(Around(region)) = requests.tune_region {
            self.region_tuner.choose(region, self.info.size);
            self.publish_region_tuning();
        }
        if let Some(Explained(event)) = requests.explain {
            self.asker.ask(event);
            self.publish_what_if();
        }
        if let Some(Known(truth)) = requests.truth {
            self.take_truth(truth);
        }
        if requests.settings.is_none() && requests.roi.is_none() && requests.beside.is_none() {
            return Ok(());
        }
        let settings = requests.settings.unwrap_or_else(|| Settings::clone(self.lane.settings()));
        let roi = requests.roi.map_or_else(|| self.lane.run.roi().cloned(), |Analysed(roi)| roi);
        let beside =
            requests.beside.map_or_else(|| self.rival.settings.clone(), |session::Rival(beside)| beside);
        self.change(settings, roi, beside)
    }

    /// Takes what is known to be right, as far as it is about frames of this size.
    fn take_truth(&mut self, truth: Option<Arc<Truth>>) {
        let size = self.info.size;
        let (truth, masks) = match truth {
            Some(truth) if truth.masks.as_ref().is_some_and(|masks| masks.size() != size) => {
                let masks = truth.masks.as_ref().map_or(size, |masks| masks.size());
                self.outbox.warnings.push(format!(
                    "the true masks are {masks}, the frames of {} are {size}: they are not used; choose those of this video",
                    self.info.name
                ));
                (Some(Arc::new(Truth { boxes: truth.boxes.clone(), masks: None })), None)
            }
            truth => {
                let masks = truth.as_ref().and_then(|truth| truth.masks.clone());
                (truth, masks)
            }
        };
        self.truth = truth;
        self.region_tuner.set_truth(masks);
        self.publish_region_tuning();
        (self.outbox.timeline_grew, self.outbox.beside_grew) = (true, true);
        if let Some(shown) = self.shown.clone() {
            self.show(Shown::clone(&shown));
        }
    }

    /// Gives up going anywhere: the frame in view stays, or the last that is analysed under new settings.
    fn stay(&mut self) {
        self.aim = None;
        if let Some(shown) = &self.shown {
            self.wanted = shown.position.min(self.lane.run.front().saturating_sub(1));
        }
    }

    /// Takes other settings in view and beside it, or another part of the image, and runs again what they touch.
    fn change(
        &mut self,
        settings: Settings,
        roi: Option<Arc<Roi>>,
        beside: Option<Settings>,
    ) -> Result<(), Stopped> {
        let beside = self.comparable(beside);
        let differs = self.lane.first_difference(&settings, roi.as_ref()).is_some();
        if !differs && !self.stopped && beside == self.rival.settings {
            return Ok(());
        }
        if self.stopped {
            self.rival = Rival::default();
        }
        if differs {
            // Under other settings it may never have happened.
            self.asker.ask(None);
            self.publish_what_if();
        }
        self.rival.settings = beside;
        if differs || self.stopped {
            self.change_view(settings, roi.clone())?;
        }
        self.change_rival(roi)
    }

    /// A live source's frames come once, and only some are kept: two runs cannot both have them.
    fn comparable(&mut self, beside: Option<Settings>) -> Option<Settings> {
        let refused = beside.is_some() && self.info.live;
        if refused && !std::mem::replace(&mut self.outbox.told_of.live, true) {
            self.outbox.warnings.push(format!(
                "two settings cannot be compared on {}, whose frames come only once; record it first",
                self.info.name
            ));
        }
        beside.filter(|_| !refused)
    }

    /// Brings other settings into view.
    fn change_view(&mut self, settings: Settings, roi: Option<Arc<Roi>>) -> Result<(), Stopped> {
        // Before anything else: one pixel through all frames is a matter of a millisecond.
        self.lane.inspector.choose(self.pixel, &settings);
        self.publish_pixel();
        self.pins.run_again(&settings);
        self.region.forget();
        self.outbox.pixel_grew = true;
        let budget = self.budget();
        let settings = Arc::new(settings);
        match self.lane.first_difference(&settings, roi.as_ref()) {
            _ if self.take_from_rival(&settings, roi.as_ref()) => self.show_pixel(),
            Some(stage) if stage > Stage::Mixture && !self.stopped => {
                if self.rival.is(self.lane.settings())
                    && settings != *self.lane.settings()
                    && let Some(fork) = self.lane.fork(budget)
                {
                    let given_up = self.rival.lane.replace(fork);
                    rayon::spawn(move || drop(given_up));
                }
                self.lane.restart_at(stage, settings, roi)?;
            }
            _ => {
                let mut lane = Lane::new(settings, roi, &self.info, budget)?;
                lane.inspector = std::mem::take(&mut self.lane.inspector);
                let old = std::mem::replace(&mut self.lane, lane);
                if self.rival.is(old.settings()) && !self.stopped {
                    let given_up = self.rival.lane.replace(old);
                    rayon::spawn(move || drop(given_up));
                    if let Some(old) = &mut self.rival.lane {
                        old.inspect(self.pixel);
                    }
                } else {
                    // To give gigabytes back takes longer than the first frames.
                    rayon::spawn(move || drop(old));
                }
                if self.info.live && !self.frames.numbers().is_empty() && self.frames.kept(0).is_none() {
                    self.start_over_live()?;
                }
            }
        }
        self.stopped = false;
        if let Some(Aim::Occlusion(found)) = &mut self.aim {
            *found = None;
        }
        // The timeline changes together with the view.
        self.outbox.analysed = 0;
        self.outbox.timeline_grew = true;
        self.shared.publish(|state| state.phase = Phase::Ready);
        Ok(())
    }

    /// Changes places with the rival, if what is asked for is its run; whether it was.
    fn take_from_rival(&mut self, settings: &Settings, roi: Option<&Arc<Roi>>) -> bool {
        let Some(lane) = &mut self.rival.lane else { return false };
        let same = lane.first_difference(settings, roi).is_none() && !self.stopped;
        if same {
            std::mem::swap(lane, &mut self.lane);
            lane.inspect(self.pixel);
            self.rival.shown = None;
        }
        same
    }

    /// Gives the rival the settings that it is to have.
    fn change_rival(&mut self, roi: Option<Arc<Roi>>) -> Result<(), Stopped> {
        let budget = self.budget();
        self.lane.run.set_budget(budget);
        self.outbox.beside_grew = true;
        let settings = self.rival.settings.clone().filter(|settings| settings != &**self.lane.settings());
        let Some(settings) = settings else {
            // Equal settings have one run; without settings there is none.
            let given_up = self.rival.give_up();
            rayon::spawn(move || drop(given_up));
            return Ok(());
        };
        let settings = Arc::new(settings);
        match &mut self.rival.lane {
            Some(lane) => match lane.first_difference(&settings, roi.as_ref()) {
                None => {}
                Some(stage) if stage > Stage::Mixture => lane.restart_at(stage, settings, roi)?,
                Some(_) => {
                    let other = self.lane.beside(settings, roi, &self.info, budget)?;
                    let old = std::mem::replace(lane, other);
                    rayon::spawn(move || drop(old));
                }
            },
            none => *none = Some(self.lane.beside(settings, roi, &self.info, budget)?),
        }
        if let Some(lane) = &mut self.rival.lane {
            lane.run.set_budget(budget);
            lane.inspect(self.pixel);
        }
        Ok(())
    }

    /// The memory for going back in time that one run may take.
    const fn budget(&self) -> usize {
        if self.rival.settings.is_some() { self.model_budget / 2 } else { self.model_budget }
    }

    /// A live source whose first frames are no longer kept cannot be run again from the start: the
    /// sequence begins with the next frame.
    fn start_over_live(&mut self) -> Result<(), Stopped> {
        let name = &self.info.name;
        if self.frames.is_complete() {
            return Err(Stopped(format!(
                "{name} gives no more frames, and its first ones are no longer kept to run them again; open it again"
            )));
        }
        self.outbox.warnings.push(format!(
            "the first frames of {name} are no longer kept: the new settings start with the next one"
        ));
        self.frames.forget();
        let (settings, roi) = (Arc::clone(self.lane.settings()), self.lane.run.roi().cloned());
        self.lane = Lane::new(settings, roi, &self.info, self.model_budget)?;
        self.lane.inspect(self.pixel);
        self.pins.forget(self.lane.settings());
        self.region.forget();
        self.tuner.forget();
        self.region_tuner.forget();
        self.follow = true;
        Ok(())
    }

    /// Does the most urgent piece of work; whether there was any.
    fn piece(&mut self) -> Result<bool, Stopped> {
        if self.stopped {
            return Ok(false);
        }
        self.find_aim();
        if self.follow && self.ahead == Ahead::All {
            self.wanted = self.lane.run.front().saturating_sub(1);
        }
        if self.frames.is_complete() {
            self.wanted = self.wanted.min((self.frames.numbers().len() as u32).saturating_sub(1));
        }
        if !self.is_view_current() {
            self.approach_view()?;
        } else if self.tune() || self.gather()? || self.gather_beside()? {
            // What came of it is published at once, or in time.
        } else if let Some(which) = self.due() {
            self.analyse(which)?;
        } else {
            // The way to the frame in view, or to the end, is behind it.
            self.busy = None;
            return Ok(self.score() || self.explain() || self.tune_region());
        }
        Ok(true)
    }

    /// Which of both is to be analysed further. They keep abreast, so that a frame is there for both when it is decoded.
    fn due(&self) -> Option<Which> {
        let in_view = self.is_due(&self.lane);
        let rival = self.rival.lane.as_ref().filter(|lane| self.is_due(lane));
        match rival {
            Some(rival) if !in_view || rival.run.front() < self.lane.run.front() => Some(Which::Rival),
            _ => in_view.then_some(Which::InView),
        }
    }

    /// Works on what would have kept an event from happening; whether there was anything to do.
    fn explain(&mut self) -> bool {
        let before = self.asker.latest();
        let numbers = self.frames.numbers();
        let worked = self.asker.piece(&self.lane.run, numbers, self.info.size, self.info.fps);
        let answer = self.asker.latest();
        if !same(before.as_ref(), answer.as_ref()) {
            self.publish_what_if();
        }
        if worked {
            let (done, total) = answer.map_or((0, 0), |answer| answer.tried);
            self.busy = Some(Progress {
                what: "looking for what would have kept it from happening".to_owned(),
                done: done as u32,
                total: (total > 0).then_some(total as u32),
            });
        }
        worked
    }

    fn publish_what_if(&self) {
        let what_if = self.asker.latest();
        self.shared.publish(|state| state.what_if = what_if);
    }

    /// Whether there is more to analyse: all, or what is looked at.
    fn is_due(&self, lane: &Lane) -> bool {
        if lane.is_through(&self.frames) {
            // The end may have been found on the other's way.
            return !lane.is_finished();
        }
        self.ahead == Ahead::All || lane.run.front() <= self.wanted
    }

    /// Takes the chosen pixel through the frames that are known; whether there was anything to do.
    fn gather(&mut self) -> Result<bool, SourceError> {
        if gather::gather(&mut self.lane.inspector, &mut self.frames)? {
            self.outbox.pixel_grew = true;
            if let Some(shown) = &self.shown
                && shown.pixel.as_ref().map(|history| history.at) != self.pixel
            {
                self.show_pixel();
            }
            return Ok(true);
        }
        let Some(lane) = &mut self.rival.lane else { return Ok(false) };
        let worked = lane.inspector.catch_up(&self.lane.inspector)
            || gather::gather(&mut lane.inspector, &mut self.frames)?;
        if let Some(shown) = self.shown.clone().filter(|_| worked && self.rival.takes_pixel(self.pixel)) {
            self.show(Shown::clone(&shown));
        }
        Ok(worked)
    }

    /// Takes the pinned pixels through the frames that are known, counts the foreground around the chosen one, and
    /// gathers the colours there; whether there was anything to do.
    fn gather_beside(&mut self) -> Result<bool, SourceError> {
        let run = &self.lane.run;
        let worked = gather::gather(&mut self.pins, &mut self.frames)?
            || self.region.gather(run.record(), run.front(), self.info.size);
        self.outbox.pixel_grew |= worked;
        Ok(worked || gather::gather(&mut self.region_tuner, &mut self.frames)?)
    }

    /// Scores what has been analysed in full; whether there was anything to do.
    fn score(&mut self) -> bool {
        let Some(truth) = &self.truth else { return false };
        let in_view = self.lane.score(truth);
        self.outbox.timeline_grew |= in_view == Scored::Now;
        let Some(lane) = self.rival.lane.as_mut().filter(|_| in_view == Scored::Already) else {
            return in_view != Scored::Already;
        };
        let beside = lane.score(truth);
        self.outbox.beside_grew |= beside == Scored::Now;
        beside != Scored::Already
    }

    /// Works on how right the mixture would be under other settings; whether there was anything to do.
    fn tune_region(&mut self) -> bool {
        let before = self.region_tuner.latest();
        let Some((done, total)) = self.region_tuner.piece(self.lane.settings()) else { return false };
        if !same(before.as_ref(), self.region_tuner.latest().as_ref()) {
            self.publish_region_tuning();
        }
        self.busy = Some(Progress {
            what: "trying other settings".to_owned(),
            done: done as u32,
            total: Some(total as u32),
        });
        true
    }

    fn publish_region_tuning(&self) {
        let tuning = self.region_tuner.latest();
        self.shared.publish(|state| state.region_tuning = tuning);
    }

    /// Works on what the chosen pixel would be under other settings; whether there was anything to do.
    fn tune(&mut self) -> bool {
        let history = self.shown.as_ref().and_then(|shown| shown.pixel.as_ref().map(|pixel| (pixel, shown)));
        let Some((history, shown)) = history else { return false };
        let before = self.tuner.latest();
        let worked = self.tuner.piece(history, shown.position);
        let tuning = self.tuner.latest();
        if !same(tuning.as_ref(), before.as_ref()) {
            self.shared.publish(|state| state.tuning = tuning);
        }
        worked
    }

    fn is_view_current(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| self.is_current(shown) && self.rival.is_beside(shown))
    }

    fn is_current(&self, shown: &Shown) -> bool {
        self.is_current_but_for_its_map(shown)
            && self.map.is_none_or(|quantity| match &shown.map {
                Some(map) => map.quantity == quantity,
                None => !self.can_map(quantity),
            })
    }

    fn is_current_but_for_its_map(&self, shown: &Shown) -> bool {
        shown.position == self.wanted && Arc::ptr_eq(&shown.settings, self.lane.settings())
    }

    /// Whether the wanted frame can have a map of `quantity`: for a camera's, what came before it must still be kept.
    fn can_map(&self, quantity: Quantity) -> bool {
        let run = &self.lane.run;
        let kept = |mut positions: Range<u32>| positions.all(|position| self.frames.has(position));
        run.has(quantity) && (!self.info.live || run.way_to(self.wanted, quantity).is_some_and(kept))
    }

    /// The frame in view without its map, where that is of another quantity than is asked for and none can be made.
    fn without_map(&self) -> Option<Shown> {
        let shown = self.shown.as_ref().filter(|shown| self.is_current_but_for_its_map(shown))?;
        let other =
            shown.map.as_ref().is_some_and(|map| self.map.is_some_and(|quantity| map.quantity != quantity));
        (other && !self.map.is_some_and(|quantity| self.can_map(quantity)))
            .then(|| Shown { map: None, ..Shown::clone(shown) })
    }

    fn lane(&mut self, which: Which) -> Option<&mut Lane> {
        match which {
            Which::InView => Some(&mut self.lane),
            Which::Rival => self.rival.lane.as_mut(),
        }
    }

    /// One step towards showing the wanted frame. Where both have been analysed, both come into view together.
    fn approach_view(&mut self) -> Result<(), Stopped> {
        if self.rival.lags_behind(self.wanted) {
            if let Some(shown) = self.look(Which::Rival)? {
                self.rival.shown = Some(Arc::new(shown));
            }
        } else if let Some(shown) = self.shown.clone().filter(|shown| self.is_current(shown)) {
            self.show(Shown::clone(&shown));
        } else if let Some(shown) = self.without_map() {
            self.show(shown);
        } else if self.wanted >= self.lane.run.front() {
            self.analyse(Which::InView)?;
        } else if let Some(shown) = self.look(Which::InView)? {
            self.show(shown);
        }
        Ok(())
    }

    /// One step towards the wanted frame under some settings; the frame when it is there.
    fn look(&mut self, which: Which) -> Result<Option<Shown>, Stopped> {
        let position = self.wanted;
        let Some(frame) = self.fetch(position)? else { return Ok(None) };
        let quantity = self.map.filter(|_| which == Which::InView);
        let Some(lane) = self.lane(which) else { return Ok(None) };
        match lane.run.towards(position, &frame, quantity)? {
            Towards::Pictures(pictures) => return Ok(lane.shown(position, frame, pictures)),
            Towards::GoesOn => {}
            Towards::Needs(needed) => {
                if let Some(passed) = self.fetch(needed.start)? {
                    let mut passed = vec![passed];
                    for position in needed.start + 1..needed.end {
                        let Some(frame) = self.frames.kept(position) else { break };
                        passed.push(frame);
                    }
                    if let Some(lane) = self.lane(which) {
                        lane.run.replay_frames(needed.start, &passed, position);
                    }
                }
                let what = format!("going back to frame {}", frame.number);
                self.busy = Some(Progress { what, done: needed.start, total: Some(position + 1) });
            }
        }
        Ok(None)
    }

    /// A frame that has been analysed, or `None` while it is on its way.
    fn fetch(&mut self, position: u32) -> Result<Option<Arc<Frame>>, SourceError> {
        match self.frames.fetch(position, Keep::Yes)? {
            Fetched::Frame(frame) => return Ok(Some(frame)),
            Fetched::OnTheWay => {
                let what = format!("reading again up to frame {}", self.number_of(position));
                self.busy = Some(Progress { what, done: 0, total: None });
            }
            Fetched::Gone | Fetched::End => {
                // Only a live source forgets: the oldest thing that surely is there is the newest.
                self.wanted = self.lane.run.modelled().saturating_sub(1);
                if !std::mem::replace(&mut self.outbox.told_of.gone, true) {
                    self.outbox.warnings.push(format!(
                        "earlier frames of {} are no longer kept: the newest is shown",
                        self.info.name
                    ));
                }
            }
        }
        Ok(None)
    }

    /// Analyses the next frames that are there, or decodes one on the way to them.
    fn analyse(&mut self, which: Which) -> Result<(), Stopped> {
        let started = Instant::now();
        let (last, both) = (self.last_of(which), self.due_both());
        let lane = match which {
            Which::InView => &mut self.lane,
            Which::Rival => {
                let Some(lane) = &mut self.rival.lane else { return Ok(()) };
                lane
            }
        };
        let position = lane.run.front();
        let (pins, region_tuner) = (&mut self.pins, &mut self.region_tuner);
        let step = lane.go_on(&mut self.frames, last, |position, frame| {
            pins.push(position, frame);
            region_tuner.push(position, frame);
        });
        let front = lane.run.front();
        self.outbox.warnings.extend(self.frames.take_warnings());
        // The end of the sequence may have been found.
        self.outbox.timeline_grew = true;
        match step? {
            Step::On => {}
            // After a change of settings, frames of a live source that the new run needs.
            Step::Gone => return self.start_over_live(),
        }
        match which {
            Which::InView => self.find_occlusion(position..front),
            Which::Rival => self.outbox.beside_grew = true,
        }
        if front > position {
            self.meter.add(started.elapsed(), front - position);
            let total = if self.frames.is_complete() {
                Some(self.frames.numbers().len() as u32)
            } else {
                self.info.frames.map(|frames| frames.max(front))
            };
            let what = match which {
                Which::InView if self.wanted >= front && !self.follow => {
                    format!("analysing up to frame {}", self.number_of(self.wanted))
                }
                _ if both => "analysing both".to_owned(),
                Which::Rival => "analysing what is compared".to_owned(),
                Which::InView => "analysing".to_owned(),
            };
            self.busy = Some(Progress { what, done: front, total });
        }
        Ok(())
    }

    /// The last position up to which one of both is to be analysed in one piece, if there is one.
    fn last_of(&self, which: Which) -> Option<u32> {
        let front = self.lane.run.front();
        match (which, &self.rival.lane) {
            // What is wanted in view comes first.
            (Which::InView, _) if !self.follow && front <= self.wanted => Some(self.wanted),
            // No farther than what it passes is still kept when the other comes by.
            (Which::InView, Some(rival)) if rival.run.front() <= front => {
                Some(front.saturating_add(self.frames.room().saturating_sub(2) as u32))
            }
            (Which::Rival, Some(rival)) if rival.run.front() < front => Some(front - 1),
            _ => None,
        }
    }

    /// Whether both are being analysed.
    fn due_both(&self) -> bool {
        self.is_due(&self.lane) && self.rival.lane.as_ref().is_some_and(|lane| self.is_due(lane))
    }

    /// Notes the first occlusion among frames that were just analysed, if that is aimed at.
    fn find_occlusion(&mut self, positions: Range<u32>) {
        let Some(Aim::Occlusion(found @ None)) = &mut self.aim else { return };
        for position in positions {
            let Some((analysis, _)) = self.lane.run.outline(position) else { break };
            let occlusion = analysis
                .events
                .iter()
                .find(|event| matches!(event.kind, EventKind::Merge | EventKind::Disappear));
            *found = occlusion.map(|event| (position, event.objects.clone()));
            if found.is_some() {
                break;
            }
        }
    }

    /// The frame number of a position; a guess beyond the frames that are known.
    fn number_of(&self, position: u32) -> u32 {
        let numbers = self.frames.numbers();
        numbers.get(position as usize).copied().unwrap_or_else(|| {
            let beyond = position.saturating_sub(numbers.len() as u32).saturating_add(1);
            numbers.last().map_or(beyond, |last| last.saturating_add(beyond))
        })
    }

    /// Wants what the start aims at, once it is known and the first frame has been seen.
    fn find_aim(&mut self) {
        let Some(aim) = &self.aim else { return };
        if self.shown.is_none() {
            return;
        }
        let numbers = self.frames.numbers();
        let found = match aim {
            Aim::Number(number) => {
                let position = numbers.partition_point(|known| known < number);
                (position < numbers.len() || self.frames.is_complete()).then_some(position as u32)
            }
            Aim::Occlusion(Some((decided, objects))) => {
                let front = self.lane.run.front();
                (front > decided.saturating_add(INTO_OCCLUSION) || self.lane.is_through(&self.frames))
                    .then(|| self.within_occlusion(*decided, objects))
            }
            Aim::Occlusion(None) => self.lane.is_through(&self.frames).then_some(self.wanted),
        };
        if let Some(position) = found {
            self.wanted = position;
            self.aim = None;
        }
    }

    /// The middle of the stretch in which one of `objects` is merged or hidden, around the position
    /// at which that was decided.
    fn within_occlusion(&self, decided: u32, objects: &[Identity]) -> u32 {
        let occluded = |position: &u32| {
            self.lane.run.outline(*position).is_some_and(|(analysis, _)| {
                let mut tracks = analysis.tracks.iter();
                tracks.any(|track| objects.contains(&track.id) && track.state != TrackState::Visible)
            })
        };
        let Some(first) = (decided..self.lane.run.front()).find(occluded) else { return decided };
        let length = (first..self.lane.run.front()).take_while(occluded).count() as u32;
        first + length / 2
    }

    /// Publishes a frame in view, and the timeline with it where that did not reach so far yet.
    fn show(&mut self, shown: Shown) {
        let truth =
            self.truth.as_ref().and_then(|truth| truth.masks.as_ref()?.of(shown.frame.number).cloned());
        let shown = Arc::new(Shown { beside: self.rival.beside(&shown), truth, ..shown });
        self.shown = Some(Arc::clone(&shown));
        let timeline = (shown.position >= self.outbox.analysed).then(|| self.timeline());
        // What it is compared with changes together with it.
        let beside = (timeline.is_some() && self.outbox.beside_grew).then(|| self.beside());
        if shown.pixel.is_some() || self.pixel.is_none() {
            self.outbox.pixel.clone_from(&shown.pixel);
        }
        let pixel = self.outbox.pixel.clone();
        self.shared.publish(|state| {
            state.shown = Some(shown);
            state.pixel = pixel;
            state.analysis_fps = self.meter.frames_a_second();
            if let Some(timeline) = timeline {
                state.timeline = timeline;
            }
            if let Some(beside) = beside {
                state.beside = beside;
            }
        });
    }

    /// The timeline to publish now.
    fn timeline(&mut self) -> Arc<Timeline> {
        self.outbox.timeline_grew = false;
        let timeline = self.lane.timeline(&self.frames, self.truth.as_ref());
        self.outbox.analysed = timeline.analysed;
        Arc::new(timeline)
    }

    /// What is known of the sequence under the settings that are compared with those in view.
    fn beside(&mut self) -> Option<Arc<Beside>> {
        self.outbox.beside_grew = false;
        let lane = self.rival.lane.as_ref()?;
        let timeline = lane.timeline(&self.frames, self.truth.as_ref());
        Some(Arc::new(Beside { settings: Arc::clone(lane.settings()), timeline }))
    }

    /// Publishes the pixel's history as it is now, and the frame in view with it where both are of
    /// the same settings.
    fn show_pixel(&mut self) {
        let pixel = self.lane.inspector.latest();
        // A view that waits for new settings keeps the old ones' history.
        let shown = self.shown.as_ref().filter(|shown| {
            Arc::ptr_eq(&shown.settings, self.lane.settings())
                && !same(shown.pixel.as_ref(), pixel.as_ref())
                && pixel.as_ref().is_none_or(|history| history.states.len() as u32 > shown.position)
        });
        if let Some(shown) = shown {
            self.show(Shown { pixel, ..Shown::clone(shown) });
        } else if !same(self.outbox.pixel.as_ref(), pixel.as_ref()) {
            self.publish_pixel();
        }
    }

    /// Publishes the pixel's history alone, ahead of the frame in view.
    fn publish_pixel(&mut self) {
        let pixel = self.lane.inspector.latest();
        self.outbox.pixel.clone_from(&pixel);
        self.shared.publish(|state| state.pixel = pixel);
    }

    /// Publishes what grows, not too often, and whatever is left before resting.
    fn publish_in_time(&mut self, resting: bool) {
        let pace = PACE.max(self.outbox.publishing_took * 10);
        if self.stopped || !resting && self.outbox.published.elapsed() < pace {
            return;
        }
        if resting {
            self.busy = None;
        }
        // A request that changed nothing is no reason to wake anybody, who might ask again.
        let pixel_grew = std::mem::take(&mut self.outbox.pixel_grew);
        let grew = self.outbox.timeline_grew || self.outbox.beside_grew || pixel_grew;
        if self.busy == self.outbox.busy && !grew && self.outbox.warnings.is_empty() {
            return;
        }
        let started = Instant::now();
        // While the view waits for new settings, what belongs to the old ones stays as well.
        let view_lags =
            self.shown.as_ref().is_some_and(|shown| !Arc::ptr_eq(&shown.settings, self.lane.settings()));
        let timeline = (self.outbox.timeline_grew && !view_lags).then(|| self.timeline());
        let beside = (self.outbox.beside_grew && !view_lags).then(|| self.beside());
        let new_warnings = std::mem::take(&mut self.outbox.warnings);
        self.show_pixel();
        let around = (Arc::new(self.pins.latest()), self.region.latest());
        let lost = self.lane.inspector.lost().into_iter().chain(self.pins.lost()).collect();
        self.shared.publish(|state| {
            (state.pins, state.region) = around;
            state.lost = lost;
            if let Some(timeline) = timeline {
                state.timeline = timeline;
            }
            if let Some(beside) = beside {
                state.beside = beside;
            }
            if !new_warnings.is_empty() {
                Arc::make_mut(&mut state.warnings).extend(new_warnings);
            }
            state.busy.clone_from(&self.busy);
            state.analysis_fps = self.meter.frames_a_second();
        });
        self.outbox.busy.clone_from(&self.busy);
        self.outbox.published = Instant::now();
        self.outbox.publishing_took = started.elapsed();
    }
}

/// How fast the analysis goes, over about its last second of work.
#[derive(Default)]
struct Meter {
    pieces: VecDeque<(Duration, u32)>,
    took: Duration,
    frames: u32,
}

impl Meter {
    fn add(&mut self, took: Duration, frames: u32) {
        self.pieces.push_back((took, frames));
        self.took += took;
        self.frames += frames;
        while self.took > Duration::from_secs(1) && self.pieces.len() > 1 {
            let (took, frames) = self.pieces.pop_front().unwrap_or_default();
            self.took -= took;
            self.frames -= frames;
        }
    }

    fn frames_a_second(&self) -> f32 {
        if self.took.is_zero() { 0.0 } else { self.frames as f32 / self.took.as_secs_f32() }
    }
}
