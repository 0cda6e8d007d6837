//! The worker's side of a session: executes one short step of work after another, the most urgent first.
//!
//! The order is: the frame to show, under both settings where two are compared; the tuning of the chosen pixel in it;
//! the histories of the chosen and the pinned pixels, and the region around the chosen one; the analysis ahead, both
//! passes in turn; then scores, counterfactuals, and the tuning of the region. `view` seeks the frame to show,
//! `change` applies other settings, `publish` publishes the state. Requests are read between two steps. A step takes
//! some milliseconds, or the time to decode or analyse one frame if that is longer.

mod change;
mod publish;
mod speed_meter;
#[cfg(test)]
mod tests;
mod view;

use std::sync::Arc;
use std::time::Instant;

use self::publish::Outbox;
use self::speed_meter::SpeedMeter;
use super::session::{
    self, ExplainRequest, MapRequest, PixelRequest, RegionRequest, Requests, RoiRequest, Shared,
    TruthRequest, TuneRequest,
};
use super::{Phase, Progress, ShownFrame, Start, same};
use crate::mixture::Quantity;
use crate::regions::Roi;
use crate::replay::tasks::analyse::analysis_pass::{AnalysisPass, PassStep};
use crate::replay::tasks::analyse::compared_pass::ComparedPass;
use crate::replay::tasks::explain::CounterfactualTask;
use crate::replay::tasks::gather::frame_consumer::{self, FrameConsumer as _};
use crate::replay::tasks::gather::pin_follower::PinFollower;
use crate::replay::tasks::gather::region_shares::RegionShareCounter;
use crate::replay::tasks::score::ScoreStep;
use crate::replay::tasks::tune::pixel_tuner::PixelTuner;
use crate::replay::tasks::tune::region_tuner::RegionTuner;
use crate::settings::Settings;
use crate::source::cache::{FrameCache, Keep};
use crate::source::{SourceError, SourceInfo};
use crate::tracking::Identity;
use crate::truth::Truth;

/// A pass of the worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PassSlot {
    /// The pass in view.
    InView,
    /// The pass of the candidate settings.
    Compared,
}

/// The error that stopped the work on a choice of settings, in words for the user.
struct StopReason(String);

impl<E: std::error::Error> From<E> for StopReason {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

pub(super) struct Worker<'a> {
    shared: &'a Shared,
    frames: FrameCache,
    info: Arc<SourceInfo>,
    /// Memory for checkpoints and records, in bytes.
    model_budget: usize,
    /// The pass in view.
    pass: AnalysisPass,
    /// The pass of the candidate settings.
    compared: ComparedPass,
    /// The position that the window wants to show.
    target_position: u32,
    /// The frame to show first, until its position is known.
    start_target: Option<StartTarget>,
    /// Whether the newest frame is shown, for a live source.
    follow: bool,
    ahead: AheadMode,
    pixel: Option<(u32, u32)>,
    pins: PinFollower,
    region: RegionShareCounter,
    tuner: PixelTuner,
    region_tuner: RegionTuner,
    counterfactual_task: CounterfactualTask,
    /// The quantity mapped in the frame in view.
    map: Option<Quantity>,
    /// The ground truth for scores.
    truth: Option<Arc<Truth>>,
    stopped: bool,
    shown: Option<Arc<ShownFrame>>,
    busy: Option<Progress>,
    speed_meter: SpeedMeter,
    outbox: Outbox,
}

/// How far the analysis goes beyond the requested frame.
#[derive(PartialEq)]
enum AheadMode {
    All,
    Nothing,
}

/// A frame to show first whose position is not known yet.
enum StartTarget {
    Number(u32),
    /// The first occlusion: the position at which it was decided, and its members.
    Occlusion(Option<(u32, Vec<Identity>)>),
}

impl<'a> Worker<'a> {
    /// Opens the source and works until the session ends.
    pub(super) fn open_and_run(
        shared: &'a Shared,
        open: impl FnOnce() -> Result<FrameCache, SourceError>,
        under: (Settings, Option<Arc<Roi>>),
        start: Start,
        model_budget: usize,
    ) {
        match Self::open(shared, open, under, start, model_budget) {
            Ok(mut worker) => worker.work(),
            Err(StopReason(why)) => shared.fail(why),
        }
    }

    fn open(
        shared: &'a Shared,
        open: impl FnOnce() -> Result<FrameCache, SourceError>,
        (settings, roi): (Settings, Option<Arc<Roi>>),
        start: Start,
        model_budget: usize,
    ) -> Result<Self, StopReason> {
        let frames = open()?;
        let info = Arc::clone(frames.info());
        let pass = AnalysisPass::new(Arc::new(settings), roi, &info, model_budget)?;
        shared.publish(|state| {
            state.phase = Phase::Ready;
            state.info = Some(Arc::clone(&info));
        });
        Ok(Self {
            shared,
            frames,
            follow: info.live,
            ahead: AheadMode::All,
            info,
            model_budget,
            pass,
            compared: ComparedPass::default(),
            target_position: 0,
            start_target: match start {
                Start::First => None,
                Start::FirstOcclusion => Some(StartTarget::Occlusion(None)),
                Start::Frame(number) => Some(StartTarget::Number(number)),
            },
            pixel: None,
            pins: PinFollower::default(),
            region: RegionShareCounter::default(),
            tuner: PixelTuner::default(),
            region_tuner: RegionTuner::default(),
            counterfactual_task: CounterfactualTask::default(),
            map: None,
            truth: None,
            stopped: false,
            shown: None,
            busy: None,
            speed_meter: SpeedMeter::default(),
            outbox: Outbox::new(),
        })
    }

    fn work(&mut self) {
        let mut resting = false;
        while let Some(requests) = self.shared.take_requests(resting) {
            let worked = self.apply_requests(requests).and_then(|()| self.work_once());
            resting = !worked.unwrap_or_else(|StopReason(why)| {
                self.stopped = true;
                self.shared.fail(why);
                false
            });
            self.publish_in_time(resting);
        }
    }

    fn apply_requests(&mut self, requests: Requests) -> Result<(), StopReason> {
        if let Some(ahead) = requests.analyse_ahead {
            // Where nothing is left to stop, other settings are still analysed to the end.
            let through = |pass: &AnalysisPass| pass.has_analysed_all(&self.frames);
            let nothing = through(&self.pass) && self.compared.pass.as_ref().is_none_or(through);
            self.ahead = if ahead || nothing { AheadMode::All } else { AheadMode::Nothing };
            if !ahead {
                self.cancel_seek();
            }
        }
        if let Some(position) = requests.show {
            self.start_target = None;
            self.target_position = position;
            self.follow = self.info.live && position >= self.pass.model.front().saturating_sub(1);
        }
        if let Some(PixelRequest(pixel)) = requests.inspect {
            self.pixel = pixel.filter(|&(x, y)| self.info.size.index(x, y).is_some());
            self.pass.inspect(self.pixel);
            if let Some(pass) = &mut self.compared.pass {
                pass.inspect(self.pixel);
            }
            self.show_pixel();
        }
        if let Some(TuneRequest(knobs)) = requests.tune {
            self.tuner.choose(knobs);
            self.region_tuner.tune(knobs);
        }
        if let Some(MapRequest(quantity)) = requests.map {
            self.map = quantity;
        }
        if let Some(mut pins) = requests.pins {
            pins.retain(|&(x, y)| self.info.size.index(x, y).is_some());
            self.pins.choose(&pins, self.pass.settings(), &self.info);
            self.outbox.pixel_grew = true;
        }
        if let Some(RegionRequest(region)) = requests.region {
            self.region.choose(region, self.info.size);
            self.outbox.pixel_grew = true;
        }
        if let Some(RegionRequest(region)) = requests.tune_region {
            self.region_tuner.choose(region, self.info.size);
            self.region_tuner.register(self.pass.settings());
            self.publish_region_tuning();
        }
        if let Some(ExplainRequest(event)) = requests.explain {
            self.counterfactual_task.set_event(event);
            self.publish_counterfactual();
        }
        if let Some(TruthRequest(truth)) = requests.truth {
            self.set_truth_data(truth);
        }
        if requests.settings.is_none() && requests.roi.is_none() && requests.compared.is_none() {
            return Ok(());
        }
        let settings = requests.settings.unwrap_or_else(|| Settings::clone(self.pass.settings()));
        let roi = requests.roi.map_or_else(|| self.pass.model.roi().cloned(), |RoiRequest(roi)| roi);
        let beside = requests
            .compared
            .map_or_else(|| self.compared.settings.clone(), |session::CompareRequest(beside)| beside);
        self.apply_settings(settings, roi, beside)
    }

    /// Executes the most urgent step of work; returns whether there was any.
    fn work_once(&mut self) -> Result<bool, StopReason> {
        if self.stopped {
            return Ok(false);
        }
        self.resolve_start_target();
        if self.follow && self.ahead == AheadMode::All {
            self.target_position = self.pass.model.front().saturating_sub(1);
        }
        if self.frames.is_complete() {
            self.target_position =
                self.target_position.min((self.frames.numbers().len() as u32).saturating_sub(1));
        }
        if !self.is_view_current() {
            self.advance_view()?;
        } else if self.advance_tuning() || self.follow_pixel()? || self.follow_pins()? {
            // The step publishes its results at once or at a limited rate.
        } else if let Some(which) = self.next_due() {
            self.analyse(which)?;
        } else {
            // The frame in view, or the end, has been reached.
            self.busy = None;
            return Ok(self.advance_scores()
                || self.advance_counterfactual()
                || self.advance_region_tuning());
        }
        Ok(true)
    }

    /// The pass to advance next. Both stay at the same position, so that each decoded frame is used by both.
    fn next_due(&self) -> Option<PassSlot> {
        let in_view = self.is_due(&self.pass);
        let compared = self.compared.pass.as_ref().filter(|pass| self.is_due(pass));
        match compared {
            Some(compared) if !in_view || compared.next_position() < self.pass.next_position() => {
                Some(PassSlot::Compared)
            }
            _ => in_view.then_some(PassSlot::InView),
        }
    }

    /// Advances the counterfactual search; returns whether there was work to do.
    fn advance_counterfactual(&mut self) -> bool {
        let before = self.counterfactual_task.latest();
        let numbers = self.frames.numbers();
        let worked =
            self.counterfactual_task.advance(&self.pass.model, numbers, self.info.size, self.info.fps);
        let answer = self.counterfactual_task.latest();
        if !same(before.as_ref(), answer.as_ref()) {
            self.publish_counterfactual();
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

    /// Whether frames remain to be analysed: all, or up to the requested one.
    fn is_due(&self, pass: &AnalysisPass) -> bool {
        if pass.has_analysed_all(&self.frames) {
            // The other pass may have found the end.
            return !pass.is_finished();
        }
        self.ahead == AheadMode::All || pass.model.front() <= self.target_position
    }

    /// Follows the chosen pixel through the known frames; returns whether there was work to do.
    fn follow_pixel(&mut self) -> Result<bool, SourceError> {
        if frame_consumer::feed_frames(&mut self.pass.pixel_follower, &mut self.frames)? {
            self.outbox.pixel_grew = true;
            if let Some(shown) = &self.shown
                && shown.pixel.as_ref().map(|history| history.at) != self.pixel
            {
                self.show_pixel();
            }
            return Ok(true);
        }
        let Some(pass) = &mut self.compared.pass else { return Ok(false) };
        let worked = pass.pixel_follower.copy_colours_from(&self.pass.pixel_follower)
            || frame_consumer::feed_frames(&mut pass.pixel_follower, &mut self.frames)?;
        if let Some(shown) = self.shown.clone().filter(|_| worked && self.compared.needs_pixel(self.pixel)) {
            self.show(ShownFrame::clone(&shown));
        }
        Ok(worked)
    }

    /// Follows the pinned pixels through the known frames, counts the foreground around the chosen one, and collects
    /// the colours there; returns whether there was work to do.
    fn follow_pins(&mut self) -> Result<bool, SourceError> {
        self.region_tuner.set_to_learn(self.info.bootstrap(self.pass.settings()));
        let run = &self.pass.model;
        let worked = frame_consumer::feed_frames(&mut self.pins, &mut self.frames)?
            || self.region.count(run.record(), run.front(), self.info.size);
        self.outbox.pixel_grew |= worked;
        Ok(worked || frame_consumer::feed_frames(&mut self.region_tuner, &mut self.frames)?)
    }

    /// Advances the scores of complete analyses; returns whether there was work to do.
    fn advance_scores(&mut self) -> bool {
        let Some(truth) = &self.truth else { return false };
        let in_view = self.pass.score(truth);
        self.outbox.timeline_grew |= in_view == ScoreStep::Finished;
        let Some(pass) = self.compared.pass.as_mut().filter(|_| in_view == ScoreStep::Idle) else {
            return in_view != ScoreStep::Idle;
        };
        let beside = pass.score(truth);
        self.outbox.compared_grew |= beside == ScoreStep::Finished;
        beside != ScoreStep::Idle
    }

    /// Advances the tuning of the region; returns whether there was work to do.
    fn advance_region_tuning(&mut self) -> bool {
        let before = self.region_tuner.latest();
        let Some((done, total)) = self.region_tuner.advance(self.pass.settings()) else { return false };
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

    /// Advances the tuning of the chosen pixel; returns whether there was work to do.
    fn advance_tuning(&mut self) -> bool {
        let history = self.shown.as_ref().and_then(|shown| shown.pixel.as_ref().map(|pixel| (pixel, shown)));
        let Some((history, shown)) = history else { return false };
        let before = self.tuner.latest();
        let worked = self.tuner.advance(history, shown.position);
        let tuning = self.tuner.latest();
        if !same(tuning.as_ref(), before.as_ref()) {
            self.shared.publish(|state| state.tuning = tuning);
        }
        worked
    }

    fn pass(&mut self, which: PassSlot) -> Option<&mut AnalysisPass> {
        match which {
            PassSlot::InView => Some(&mut self.pass),
            PassSlot::Compared => self.compared.pass.as_mut(),
        }
    }

    /// Analyses the next decoded frames, or decodes one.
    fn analyse(&mut self, which: PassSlot) -> Result<(), StopReason> {
        let started = Instant::now();
        let (last, both) = (self.last_position_of(which), self.are_both_due());
        // The other pass needs the same frame soon.
        let keep = if both { Keep::Yes } else { Keep::IfRoom };
        let pass = match which {
            PassSlot::InView => &mut self.pass,
            PassSlot::Compared => {
                let Some(pass) = &mut self.compared.pass else { return Ok(()) };
                pass
            }
        };
        let (position, learnt) = (pass.model.front(), pass.model.next_to_learn());
        let (pins, region_tuner) = (&mut self.pins, &mut self.region_tuner);
        let step = pass.advance(&mut self.frames, last, keep, |position, frame| {
            pins.push(position, frame);
            region_tuner.push(position, frame);
        });
        let front = pass.model.front();
        let to_learn = pass.model.to_learn();
        self.outbox.warnings.extend(self.frames.take_warnings());
        // The end of the sequence may have been found.
        self.outbox.timeline_grew = true;
        match step? {
            PassStep::Advanced => {}
            // After a change of settings, the new pass needs frames that a live source has lost.
            PassStep::FrameLost => return self.start_over_live(),
        }
        match which {
            PassSlot::InView => self.find_occlusion(position..front),
            PassSlot::Compared => self.outbox.compared_grew = true,
        }
        if let Some(learnt) = learnt {
            self.busy = Some(Progress {
                what: "learning background".to_owned(),
                done: learnt,
                total: Some(to_learn),
            });
        }
        if front > position {
            self.speed_meter.add(started.elapsed(), front - position);
            let total = if self.frames.is_complete() {
                Some(self.frames.numbers().len() as u32)
            } else {
                self.info.frames.map(|frames| frames.max(front))
            };
            let what = match which {
                PassSlot::InView if self.target_position >= front && !self.follow => {
                    format!("analysing up to frame {}", self.number_of(self.target_position))
                }
                _ if both => "analysing A and B".to_owned(),
                PassSlot::Compared => "analysing other settings".to_owned(),
                PassSlot::InView => "analysing".to_owned(),
            };
            self.busy = Some(Progress { what, done: front, total });
        }
        Ok(())
    }

    /// The last position for one step of a pass, if it is limited.
    fn last_position_of(&self, which: PassSlot) -> Option<u32> {
        let (pass, next) = self.pass.next_position();
        match (which, &self.compared.pass) {
            // The requested frame comes first.
            (PassSlot::InView, _) if !self.follow && pass > 0 && next <= self.target_position => {
                Some(self.target_position)
            }
            // No further than the cached frames reach until the other pass needs them.
            (PassSlot::InView, Some(compared)) if compared.next_position() <= (pass, next) => {
                Some(next.saturating_add(self.frames.room().saturating_sub(2) as u32))
            }
            (PassSlot::Compared, Some(compared))
                if compared.next_position().0 == pass && compared.next_position().1 < next =>
            {
                Some(next - 1)
            }
            _ => None,
        }
    }

    /// Whether both passes have frames left to analyse.
    fn are_both_due(&self) -> bool {
        self.is_due(&self.pass) && self.compared.pass.as_ref().is_some_and(|pass| self.is_due(pass))
    }

    /// The frame number of a position; extrapolated beyond the known frames.
    fn number_of(&self, position: u32) -> u32 {
        let numbers = self.frames.numbers();
        numbers.get(position as usize).copied().unwrap_or_else(|| {
            let beyond = position.saturating_sub(numbers.len() as u32).saturating_add(1);
            numbers.last().map_or(beyond, |last| last.saturating_add(beyond))
        })
    }
}
