//! The worker's side: one small piece of work after another, the most urgent first.
//!
//! In this order: the frame that is wanted in view, under both settings where two are compared; what the chosen pixel
//! would be in it under other settings; the pixel's history, those of the pinned pixels, and what is seen around the
//! chosen one; the analysis ahead, of both abreast; and when all that is done, scores, what would have kept an event from
//! happening, and how right other settings would be around a pixel.
//! `view` is the way to the frame in view, `change` takes other settings, `publish` tells the window.
//! Between two pieces it looks at what was asked meanwhile. A piece takes some milliseconds, or as long as a frame
//! takes to decode or to analyse where that is more.

mod change;
mod meter;
mod publish;
#[cfg(test)]
mod tests;
mod view;

use std::sync::Arc;
use std::time::Instant;

use self::meter::Meter;
use self::publish::Outbox;
use super::gather::{self, Follower as _};
use super::lane::{Lane, Step};
use super::pins::Pins;
use super::region::Region;
use super::region_tuner::RegionTuner;
use super::rival::Rival;
use super::scoring::Scored;
use super::session::{self, Analysed, Around, Explained, Knobs, Known, Mapped, Pixel, Requests, Shared};
use super::tuner::Tuner;
use super::what_if::Asker;
use super::{Phase, Progress, Shown, Start, same};
use crate::mixture::Quantity;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::cache::{FrameCache, Keep};
use crate::source::{SourceError, SourceInfo};
use crate::tracking::Identity;
use crate::truth::Truth;

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
            outbox: Outbox::new(),
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
            self.pins.choose(&pins, self.lane.settings(), &self.info);
            self.outbox.pixel_grew = true;
        }
        if let Some(Around(region)) = requests.region {
            self.region.choose(region, self.info.size);
            self.outbox.pixel_grew = true;
        }
        if let Some(Around(region)) = requests.tune_region {
            self.region_tuner.choose(region, self.info.size);
            self.region_tuner.register(self.lane.settings());
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
            Some(rival) if !in_view || rival.next() < self.lane.next() => Some(Which::Rival),
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
                what: "computing counterfactuals".to_owned(),
                done: done as u32,
                total: (total > 0).then_some(total as u32),
            });
        }
        worked
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
        self.region_tuner.set_to_learn(self.info.bootstrap(self.lane.settings()));
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
            what: "testing other settings".to_owned(),
            done: done as u32,
            total: Some(total as u32),
        });
        true
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

    fn lane(&mut self, which: Which) -> Option<&mut Lane> {
        match which {
            Which::InView => Some(&mut self.lane),
            Which::Rival => self.rival.lane.as_mut(),
        }
    }

    /// Analyses the next frames that are there, or decodes one on the way to them.
    fn analyse(&mut self, which: Which) -> Result<(), Stopped> {
        let started = Instant::now();
        let (last, both) = (self.last_of(which), self.due_both());
        // The other one comes by soon, and is to find it there.
        let keep = if both { Keep::Yes } else { Keep::IfRoom };
        let lane = match which {
            Which::InView => &mut self.lane,
            Which::Rival => {
                let Some(lane) = &mut self.rival.lane else { return Ok(()) };
                lane
            }
        };
        let (position, learnt) = (lane.run.front(), lane.run.learns());
        let (pins, region_tuner) = (&mut self.pins, &mut self.region_tuner);
        let step = lane.go_on(&mut self.frames, last, keep, |position, frame| {
            pins.push(position, frame);
            region_tuner.push(position, frame);
        });
        let front = lane.run.front();
        let to_learn = lane.run.to_learn();
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
        if let Some(learnt) = learnt {
            self.busy = Some(Progress {
                what: "learning background".to_owned(),
                done: learnt,
                total: Some(to_learn),
            });
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
                _ if both => "analysing A and B".to_owned(),
                Which::Rival => "analysing other settings".to_owned(),
                Which::InView => "analysing".to_owned(),
            };
            self.busy = Some(Progress { what, done: front, total });
        }
        Ok(())
    }

    /// The last position up to which one of both is to be analysed in one piece, if there is one.
    fn last_of(&self, which: Which) -> Option<u32> {
        let (pass, next) = self.lane.next();
        match (which, &self.rival.lane) {
            // What is wanted in view comes first.
            (Which::InView, _) if !self.follow && pass > 0 && next <= self.wanted => Some(self.wanted),
            // No farther than what it passes is still kept when the other comes by.
            (Which::InView, Some(rival)) if rival.next() <= (pass, next) => {
                Some(next.saturating_add(self.frames.room().saturating_sub(2) as u32))
            }
            (Which::Rival, Some(rival)) if rival.next().0 == pass && rival.next().1 < next => Some(next - 1),
            _ => None,
        }
    }

    /// Whether both are being analysed.
    fn due_both(&self) -> bool {
        self.is_due(&self.lane) && self.rival.lane.as_ref().is_some_and(|lane| self.is_due(lane))
    }

    /// The frame number of a position; a guess beyond the frames that are known.
    fn number_of(&self, position: u32) -> u32 {
        let numbers = self.frames.numbers();
        numbers.get(position as usize).copied().unwrap_or_else(|| {
            let beyond = position.saturating_sub(numbers.len() as u32).saturating_add(1);
            numbers.last().map_or(beyond, |last| last.saturating_add(beyond))
        })
    }
}
