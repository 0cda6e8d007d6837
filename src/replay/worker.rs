//! The worker's side: one small piece of work after another, the most urgent first.
//!
//! In this order: the frame that is wanted in view, what the chosen pixel would be in it under other
//! settings, the pixel's history, the analysis ahead.
//! Between two pieces it looks at what was asked meanwhile; no piece takes longer than a frame.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::inspector::Inspector;
use super::run::{Run, Towards};
use super::session::{Analysed, Knobs, Pixel, Requests, Shared};
use super::timeline::Growing;
use super::tuner::Tuner;
use super::{Phase, Progress, Shown, Start, Timeline};
use crate::frame::Frame;
use crate::mixture::PixelHistory;
use crate::occlusion::EventKind;
use crate::regions::Roi;
use crate::settings::{Settings, Stage};
use crate::source::cache::{Fetched, FrameCache, Keep};
use crate::source::{SourceError, SourceInfo};
use crate::tracking::{Identity, TrackState};

/// Growing things are published at most so often.
const PACE: Duration = Duration::from_millis(100);

/// After the first occlusion was decided, so many more frames show how it goes on.
const INTO_OCCLUSION: u32 = 10;

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
    run: Run,
    /// The position that the window wants to see.
    wanted: u32,
    /// What will be wanted once it is found.
    aim: Option<Aim>,
    /// A live source: the newest frame is what is wanted.
    follow: bool,
    pixel: Option<(u32, u32)>,
    inspector: Inspector,
    tuner: Tuner,
    growing: Growing,
    /// Whether the final reading has taken the place of the causal one.
    finished: bool,
    stopped: bool,
    shown: Option<Arc<Shown>>,
    busy: Option<Progress>,
    meter: Meter,
    outbox: Outbox,
}

/// What waits to be published, and when that was last done.
struct Outbox {
    timeline_grew: bool,
    pixel_grew: bool,
    warnings: Vec<String>,
    told_of_gone: bool,
    /// As last published.
    pixel: Option<Arc<PixelHistory>>,
    /// How far the timeline reached that was last published.
    analysed: u32,
    /// As last published.
    busy: Option<Progress>,
    published: Instant,
    publishing_took: Duration,
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
        let run = Run::new(Arc::new(settings), roi, &info, model_budget)?;
        shared.publish(|state| {
            state.phase = Phase::Ready;
            state.info = Some(Arc::clone(&info));
        });
        Ok(Self {
            shared,
            frames,
            follow: info.live,
            info,
            model_budget,
            run,
            wanted: 0,
            aim: match start {
                Start::First => None,
                Start::FirstOcclusion => Some(Aim::Occlusion(None)),
                Start::Frame(number) => Some(Aim::Number(number)),
            },
            pixel: None,
            inspector: Inspector::default(),
            tuner: Tuner::default(),
            growing: Growing::default(),
            finished: false,
            stopped: false,
            shown: None,
            busy: None,
            meter: Meter::default(),
            outbox: Outbox {
                timeline_grew: true,
                pixel_grew: false,
                warnings: Vec::new(),
                told_of_gone: false,
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
        if let Some(position) = requests.show {
            self.aim = None;
            self.wanted = position;
            self.follow = self.info.live && position >= self.run.front().saturating_sub(1);
        }
        if let Some(Pixel(pixel)) = requests.inspect {
            self.pixel = pixel.filter(|&(x, y)| self.info.size.index(x, y).is_some());
            self.inspector.choose(self.pixel, self.run.settings());
            self.show_pixel();
        }
        if let Some(Knobs(knobs)) = requests.tune {
            self.tuner.choose(knobs);
        }
        if requests.settings.is_none() && requests.roi.is_none() {
            return Ok(());
        }
        let settings = requests.settings.unwrap_or_else(|| Settings::clone(self.run.settings()));
        let roi = requests.roi.map_or_else(|| self.run.roi().cloned(), |Analysed(roi)| roi);
        self.change(settings, roi)
    }

    /// Takes other settings, or another part of the image, and runs again what they touch.
    fn change(&mut self, settings: Settings, roi: Option<Arc<Roi>>) -> Result<(), Stopped> {
        let of_settings = self.run.settings().first_difference(&settings);
        let of_roi = (self.run.roi() != roi.as_ref()).then_some(Stage::Cleaning);
        let difference = [of_settings, of_roi].into_iter().flatten().min();
        if difference.is_none() && !self.stopped {
            return Ok(());
        }
        // Before anything else: one pixel through all frames is a matter of a millisecond.
        self.inspector.choose(self.pixel, &settings);
        self.publish_pixel();
        let settings = Arc::new(settings);
        match difference {
            Some(stage) if stage > Stage::Mixture && !self.stopped => {
                self.run.restart_at(stage, settings, roi)?;
            }
            _ => {
                let run = Run::new(settings, roi, &self.info, self.model_budget)?;
                let old = std::mem::replace(&mut self.run, run);
                // To give gigabytes back takes longer than the first frames.
                rayon::spawn(move || drop(old));
                if self.info.live && !self.frames.numbers().is_empty() && self.frames.kept(0).is_none() {
                    self.start_over_live()?;
                }
            }
        }
        self.stopped = false;
        self.growing = Growing::default();
        self.finished = false;
        if let Some(Aim::Occlusion(found)) = &mut self.aim {
            *found = None;
        }
        // The timeline changes together with the view.
        self.outbox.analysed = 0;
        self.outbox.timeline_grew = true;
        self.shared.publish(|state| state.phase = Phase::Ready);
        Ok(())
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
        let (settings, roi) = (Arc::clone(self.run.settings()), self.run.roi().cloned());
        self.run = Run::new(settings, roi, &self.info, self.model_budget)?;
        self.growing = Growing::default();
        self.inspector = Inspector::default();
        self.inspector.choose(self.pixel, self.run.settings());
        self.tuner.forget();
        self.follow = true;
        Ok(())
    }

    /// Does the most urgent piece of work; whether there was any.
    fn piece(&mut self) -> Result<bool, Stopped> {
        if self.stopped {
            return Ok(false);
        }
        self.find_aim();
        if self.follow {
            self.wanted = self.run.front().saturating_sub(1);
        }
        if self.frames.is_complete() {
            self.wanted = self.wanted.min((self.frames.numbers().len() as u32).saturating_sub(1));
        }
        if !self.is_view_current() {
            self.approach_view()?;
        } else if self.tune() {
            // It publishes itself.
        } else if self.inspector.gather(&mut self.frames)? {
            self.outbox.pixel_grew = true;
            if let Some(shown) = &self.shown
                && shown.pixel.as_ref().map(|history| history.at) != self.pixel
            {
                self.show_pixel();
            }
        } else if !self.is_all_analysed() {
            self.analyse_next()?;
        } else {
            return Ok(false);
        }
        Ok(true)
    }

    /// Works on what the chosen pixel would be under other settings; whether there was anything to do.
    fn tune(&mut self) -> bool {
        let history = self.shown.as_ref().and_then(|shown| shown.pixel.as_ref().map(|pixel| (pixel, shown)));
        let Some((history, shown)) = history else { return false };
        let before = self.tuner.latest();
        let worked = self.tuner.piece(history, shown.position);
        let tuning = self.tuner.latest();
        let same = match (&tuning, &before) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        };
        if !same {
            self.shared.publish(|state| state.tuning = tuning);
        }
        worked
    }

    fn is_view_current(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| {
            shown.position == self.wanted && Arc::ptr_eq(&shown.settings, self.run.settings())
        })
    }

    fn is_all_analysed(&self) -> bool {
        self.frames.is_complete() && self.run.front() as usize == self.frames.numbers().len()
    }

    /// One step towards showing the wanted frame.
    fn approach_view(&mut self) -> Result<(), Stopped> {
        let position = self.wanted;
        if position >= self.run.front() {
            return self.analyse_next();
        }
        let Some(frame) = self.fetch(position)? else { return Ok(()) };
        match self.run.towards(position, &frame)? {
            Towards::Pictures(pictures) => {
                if let Some(analysis) = self.run.analysis(position) {
                    let pixel = self.inspector.covering(position);
                    self.show(Shown {
                        position,
                        settings: Arc::clone(self.run.settings()),
                        roi: self.run.roi().cloned(),
                        frame,
                        analysis: Arc::new(analysis),
                        background: pictures.background,
                        multi_mode: pictures.multi_mode,
                        background_count: pictures.background_count,
                        pixel,
                    });
                }
            }
            Towards::Needs(needed) => {
                if let Some(passed) = self.fetch(needed.start)? {
                    let mut passed = vec![passed];
                    for position in needed.start + 1..needed.end {
                        let Some(frame) = self.frames.kept(position) else { break };
                        passed.push(frame);
                    }
                    self.run.replay_frames(needed.start, &passed, position);
                }
                let what = format!("going back to frame {}", frame.number);
                self.busy = Some(Progress { what, done: needed.start, total: Some(position + 1) });
            }
        }
        Ok(())
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
                self.wanted = self.run.modelled().saturating_sub(1);
                if !std::mem::replace(&mut self.outbox.told_of_gone, true) {
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
    fn analyse_next(&mut self) -> Result<(), Stopped> {
        let started = Instant::now();
        let position = self.run.front();
        if self.run.is_tracking_again() {
            self.run.track_next();
        } else {
            let fetched = self.frames.fetch(position, Keep::IfRoom);
            self.outbox.warnings.extend(self.frames.take_warnings());
            self.outbox.timeline_grew = true;
            match fetched? {
                Fetched::Frame(frame) => {
                    let frames = self.with_those_at_hand(position, frame);
                    self.run.step(&frames)?;
                    for (position, frame) in (position..).zip(&frames) {
                        self.inspector.push(position, frame);
                    }
                }
                Fetched::OnTheWay | Fetched::End => {}
                // After a change of settings, frames of a live source that the new run needs.
                Fetched::Gone => return self.start_over_live(),
            }
            self.outbox.warnings.extend(self.frames.take_warnings());
        }
        let front = self.run.front();
        for position in position..front {
            let Some((analysis, share)) = self.run.outline(position) else { break };
            self.growing.push(analysis, share);
            if let Some(Aim::Occlusion(found @ None)) = &mut self.aim {
                let occlusion = analysis
                    .events
                    .iter()
                    .find(|event| matches!(event.kind, EventKind::Merge | EventKind::Disappear));
                *found = occlusion.map(|event| (position, event.objects.clone()));
            }
        }
        if front > position {
            self.meter.add(started.elapsed(), front - position);
            let total = if self.frames.is_complete() {
                Some(self.frames.numbers().len() as u32)
            } else {
                self.info.frames.map(|frames| frames.max(front))
            };
            let what = if self.wanted >= front && !self.follow {
                format!("analysing up to frame {}", self.number_of(self.wanted))
            } else {
                "analysing".to_owned()
            };
            self.busy = Some(Progress { what, done: front, total });
            self.outbox.timeline_grew = true;
        }
        if self.is_all_analysed() && !self.finished {
            self.growing.finish(self.run.final_reading());
            self.finished = true;
            self.outbox.timeline_grew = true;
        }
        Ok(())
    }

    /// The next frame, and those after it that need not be waited for, as many as may be analysed
    /// together: not beyond the one that is wanted in view, so that the model stops there.
    fn with_those_at_hand(&mut self, position: u32, frame: Arc<Frame>) -> Vec<Arc<Frame>> {
        let mut frames = vec![frame];
        let most = match self.wanted.checked_sub(position) {
            Some(before_wanted) if !self.follow => self.run.most_frames().min(before_wanted as usize + 1),
            _ => self.run.most_frames(),
        };
        while frames.len() < most {
            let Some(frame) = self.frames.at_hand(position + frames.len() as u32) else { break };
            frames.push(frame);
        }
        frames
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
                let front = self.run.front();
                (front > decided.saturating_add(INTO_OCCLUSION) || self.is_all_analysed())
                    .then(|| self.within_occlusion(*decided, objects))
            }
            Aim::Occlusion(None) => self.is_all_analysed().then_some(self.wanted),
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
            self.run.outline(*position).is_some_and(|(analysis, _)| {
                let mut tracks = analysis.tracks.iter();
                tracks.any(|track| objects.contains(&track.id) && track.state != TrackState::Visible)
            })
        };
        let Some(first) = (decided..self.run.front()).find(occluded) else { return decided };
        let length = (first..self.run.front()).take_while(occluded).count() as u32;
        first + length / 2
    }

    /// Publishes a frame in view, and the timeline with it where that did not reach so far yet.
    fn show(&mut self, shown: Shown) {
        let shown = Arc::new(shown);
        self.shown = Some(Arc::clone(&shown));
        let timeline = (shown.position >= self.outbox.analysed).then(|| self.timeline());
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
        });
    }

    /// The timeline to publish now.
    fn timeline(&mut self) -> Arc<Timeline> {
        self.outbox.timeline_grew = false;
        let timeline = self.growing.timeline(self.frames.numbers(), self.frames.is_complete());
        self.outbox.analysed = timeline.analysed;
        Arc::new(Timeline { decoded: self.frames.kept_ranges(), ..timeline })
    }

    /// Publishes the pixel's history as it is now, and the frame in view with it where both are of
    /// the same settings.
    fn show_pixel(&mut self) {
        let pixel = self.inspector.latest();
        let same = |a: &Option<Arc<PixelHistory>>| match (a, &pixel) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        // A view that waits for new settings keeps the old ones' history.
        let shown = self.shown.as_ref().filter(|shown| {
            Arc::ptr_eq(&shown.settings, self.run.settings())
                && !same(&shown.pixel)
                && pixel.as_ref().is_none_or(|history| history.states.len() as u32 > shown.position)
        });
        if let Some(shown) = shown {
            self.show(Shown { pixel, ..Shown::clone(shown) });
        } else if !same(&self.outbox.pixel) {
            self.publish_pixel();
        }
    }

    /// Publishes the pixel's history alone, ahead of the frame in view.
    fn publish_pixel(&mut self) {
        let pixel = self.inspector.latest();
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
        let grew = self.outbox.timeline_grew || std::mem::take(&mut self.outbox.pixel_grew);
        if self.busy == self.outbox.busy && !grew && self.outbox.warnings.is_empty() {
            return;
        }
        let started = Instant::now();
        // While the view waits for new settings, what belongs to the old ones stays as well.
        let view_lags =
            self.shown.as_ref().is_some_and(|shown| !Arc::ptr_eq(&shown.settings, self.run.settings()));
        let timeline = (self.outbox.timeline_grew && !view_lags).then(|| self.timeline());
        let new_warnings = std::mem::take(&mut self.outbox.warnings);
        self.show_pixel();
        self.shared.publish(|state| {
            if let Some(timeline) = timeline {
                state.timeline = timeline;
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
