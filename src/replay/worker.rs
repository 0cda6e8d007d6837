//! The scheduler of a session: executes one short step of work after another, the most urgent first.
//!
//! The order is: the frame to show, under both settings where two are compared; the tuning of the chosen pixel in it;
//! the histories of the chosen and the pinned pixels, and the region around the chosen one; the analysis ahead, both
//! passes in turn; then scores, counterfactuals, and the tuning of the region. `view` seeks the frame to show,
//! `analyse` advances the passes, `gather` and `explain` the other tasks; `change` applies other settings, `publish`
//! publishes the state. Requests are read between two steps. A step takes some milliseconds, or the time to decode or
//! analyse one frame if that is longer.

mod analyse;
mod change;
mod explain;
mod gather;
mod publish;
mod speed_meter;
#[cfg(test)]
mod tests;
mod view;

use std::sync::Arc;

use self::change::SettingsChange;
use self::publish::Outbox;
use self::speed_meter::SpeedMeter;
use super::published::{Phase, Start, WorkProgress};
use super::requests::Request;
use super::session::AnalysisOptions;
use super::shared::Shared;
use super::tasks::analyse::PassInputs;
use super::tasks::analyse::analysis_pass::AnalysisPass;
use super::tasks::analyse::compared_pass::ComparedPass;
use super::tasks::explain::CounterfactualTask;
use super::tasks::gather::pin_follower::PinFollower;
use super::tasks::gather::region_shares::RegionShareCounter;
use super::tasks::score_external::ExternalScorer;
use super::tasks::show::FrameInView;
use super::tasks::tune::pixel_tuner::PixelTuner;
use super::tasks::tune::region_tuner::RegionTuner;
use crate::regions::Roi;
use crate::source::cache::FrameCache;
use crate::source::{SourceError, SourceInfo};
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
    /// The frame in view, and the one to show next.
    view: FrameInView,
    ahead: AheadMode,
    pixel: Option<(u32, u32)>,
    pins: PinFollower,
    region: RegionShareCounter,
    pixel_tuner: PixelTuner,
    region_tuner: RegionTuner,
    counterfactual_task: CounterfactualTask,
    /// The ground truth for scores.
    truth: Option<Arc<Truth>>,
    /// The external results and their score.
    external: ExternalScorer,
    stopped: bool,
    busy: Option<WorkProgress>,
    speed_meter: SpeedMeter,
    outbox: Outbox,
}

/// How far the analysis goes beyond the requested frame.
#[derive(PartialEq)]
enum AheadMode {
    All,
    Nothing,
}

impl<'a> Worker<'a> {
    /// Opens the source and works until the session ends.
    pub(super) fn open_and_run(
        shared: &'a Shared,
        open: impl FnOnce() -> Result<FrameCache, SourceError>,
        analysis: AnalysisOptions,
        start: Start,
        model_budget: usize,
    ) {
        match Self::open(shared, open, analysis, start, model_budget) {
            Ok(mut worker) => worker.work(),
            Err(StopReason(why)) => shared.fail(why),
        }
    }

    fn open(
        shared: &'a Shared,
        open: impl FnOnce() -> Result<FrameCache, SourceError>,
        AnalysisOptions { settings, roi }: AnalysisOptions,
        start: Start,
        model_budget: usize,
    ) -> Result<Self, StopReason> {
        let frames = open()?;
        let info = Arc::clone(frames.info());
        let settings = Arc::new(settings);
        let placement = info.placement();
        let roi = roi.map(|roi| Roi::of_frames(&roi, info.size, placement.as_ref())).transpose()?;
        let inputs = PassInputs { settings, roi, info: Arc::clone(&info), budget: model_budget };
        let pass = AnalysisPass::new(inputs)?;
        shared.publish(|state| {
            state.phase = Phase::Ready;
            state.info = Some(Arc::clone(&info));
        });
        Ok(Self {
            shared,
            frames,
            view: FrameInView::new(start, info.live),
            ahead: AheadMode::All,
            info,
            model_budget,
            pass,
            compared: ComparedPass::default(),
            pixel: None,
            pins: PinFollower::default(),
            region: RegionShareCounter::default(),
            pixel_tuner: PixelTuner::default(),
            region_tuner: RegionTuner::default(),
            counterfactual_task: CounterfactualTask::default(),
            truth: None,
            external: ExternalScorer::default(),
            stopped: false,
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

    fn apply_requests(&mut self, requests: Vec<Request>) -> Result<(), StopReason> {
        // Settings and region of interest come last and together: they decide which stages run again.
        let mut change: Option<SettingsChange> = None;
        for request in requests {
            match request {
                Request::Show(position) => {
                    self.view.request(position, self.pass.model.analysed(), self.info.live);
                }
                Request::Settings { in_view, candidate } => {
                    let change = change.get_or_insert_with(|| self.present_settings());
                    (change.in_view, change.candidate) = (*in_view, candidate.map(|settings| *settings));
                }
                Request::Roi(roi) => change.get_or_insert_with(|| self.present_settings()).roi = roi,
                Request::Truth(truth) => self.set_truth_data(truth),
                Request::External(results) => self.set_external(results),
                Request::AnalyseAhead(ahead) => self.analyse_ahead(ahead),
                Request::Inspect(pixel) => self.inspect(pixel),
                Request::Pin(pixels) => self.pin(pixels),
                Request::Map(quantity) => self.view.map = quantity,
                Request::CountRegion(region) => {
                    self.region.choose(region, self.info.size);
                    self.outbox.pixel_grew = true;
                }
                Request::Tune(tuned_settings) => {
                    self.pixel_tuner.choose(tuned_settings);
                    self.region_tuner.tune(tuned_settings);
                }
                Request::TuneRegion(region) => {
                    self.region_tuner.choose(region, self.info.size);
                    self.region_tuner.set_settings(self.pass.settings(), &self.info);
                    self.publish_region_tuning();
                }
                Request::Explain(event) => {
                    self.counterfactual_task.set_event(event.map(|event| *event));
                    self.publish_counterfactual();
                }
            }
        }
        change.map_or(Ok(()), |change| self.apply_settings(change))
    }

    /// Executes the most urgent step of work; returns whether there was any.
    fn work_once(&mut self) -> Result<bool, StopReason> {
        if self.stopped {
            return Ok(false);
        }
        self.view.resolve_start(&self.pass, &self.frames);
        let ahead = self.ahead == AheadMode::All;
        self.view.update_target(self.pass.model.analysed(), ahead, &self.frames);
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
                || self.advance_external_score()
                || self.advance_counterfactual()
                || self.advance_region_tuning());
        }
        Ok(true)
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
