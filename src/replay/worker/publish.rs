//! Publishes the state to the window, growing results at most ten times a second.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Worker;
use crate::explain::pixel::PixelHistory;
use crate::replay::is_same;
use crate::replay::published::{ComparedSequence, ShownFrame, Timeline, WorkProgress};

/// Least interval between two publications of growing results.
const MIN_PUBLISH_INTERVAL: Duration = Duration::from_millis(100);

/// The changes that are to be published, and the time of the last publication.
pub(super) struct Outbox {
    pub(super) timeline_grew: bool,
    pub(super) compared_grew: bool,
    /// Whether the chosen pixel, a pinned one, or the share of a region has new data.
    pub(super) pixel_grew: bool,
    pub(super) warnings: Vec<String>,
    pub(super) warned: OnceWarnings,
    /// The last published history.
    pixel: Option<Arc<PixelHistory>>,
    /// Number of analysed frames in the timeline published last.
    pub(super) analysed: u32,
    /// The last published progress.
    busy: Option<WorkProgress>,
    published: Instant,
    publishing_took: Duration,
}

/// Warnings that are given once.
#[derive(Default)]
pub(super) struct OnceWarnings {
    /// Whether the warning of evicted frames was given.
    pub(super) gone: bool,
    /// Whether the warning that a live source cannot be compared was given.
    pub(super) live: bool,
}

impl Outbox {
    /// Nothing has been published.
    pub(super) fn new() -> Self {
        Self {
            timeline_grew: true,
            compared_grew: false,
            pixel_grew: false,
            warnings: Vec::new(),
            warned: OnceWarnings::default(),
            pixel: None,
            analysed: 0,
            busy: None,
            published: Instant::now(),
            publishing_took: Duration::ZERO,
        }
    }
}

impl Worker<'_> {
    pub(super) fn publish_counterfactual(&self) {
        let counterfactual = self.counterfactual_task.latest();
        self.shared.publish(|state| state.counterfactual = counterfactual);
    }

    pub(super) fn publish_external_score(&self) {
        let score = self.truth.as_ref().and_then(|truth| self.external.by(truth));
        self.shared.publish(|state| state.external_score = score);
    }

    pub(super) fn publish_region_tuning(&self) {
        let tuning = self.region_tuner.latest();
        self.shared.publish(|state| state.region_tuning = tuning);
    }

    /// Publishes a frame in view, and the timeline if the published one does not contain it.
    pub(super) fn show(&mut self, shown: ShownFrame) {
        let truth =
            self.truth.as_ref().and_then(|truth| truth.masks.as_ref()?.of(shown.frame.number).cloned());
        let external = self.external.mask(shown.frame.number).cloned();
        let compared = self.compared.frame_for(&shown);
        let shown = Arc::new(ShownFrame { truth, external, compared, ..shown });
        self.view.shown = Some(Arc::clone(&shown));
        let timeline = (shown.position >= self.outbox.analysed).then(|| self.timeline());
        // The compared sequence is published together with it.
        let compared = (timeline.is_some() && self.outbox.compared_grew).then(|| self.compared_sequence());
        if shown.pixel.is_some() || self.pixel.is_none() {
            self.outbox.pixel.clone_from(&shown.pixel);
        }
        let (pixel, pixel_progress) = (self.outbox.pixel.clone(), self.pixel_progress());
        self.shared.publish(|state| {
            state.shown = Some(shown);
            (state.pixel, state.pixel_progress) = (pixel, pixel_progress);
            state.analysis_fps = self.speed_meter.frames_a_second();
            if let Some(timeline) = timeline {
                state.timeline = timeline;
            }
            if let Some(compared) = compared {
                state.compared = compared;
            }
        });
    }

    /// The timeline to publish.
    pub(super) fn timeline(&mut self) -> Arc<Timeline> {
        self.outbox.timeline_grew = false;
        let timeline = self.pass.timeline(&self.frames, self.truth.as_ref());
        self.outbox.analysed = timeline.analysed;
        Arc::new(timeline)
    }

    /// The current sequence under the candidate settings.
    pub(super) fn compared_sequence(&mut self) -> Option<Arc<ComparedSequence>> {
        self.outbox.compared_grew = false;
        let pass = self.compared.pass.as_ref()?;
        let timeline = pass.timeline(&self.frames, self.truth.as_ref());
        Some(Arc::new(ComparedSequence { settings: Arc::clone(pass.settings()), timeline }))
    }

    /// Publishes the pixel's current history, with the frame in view if both have the same settings.
    pub(super) fn show_pixel(&mut self) {
        let pixel = self.pass.pixel_follower.latest();
        // While the frame in view waits for new settings, it keeps the history of the old ones.
        let shown = self.view.shown.as_ref().filter(|shown| {
            Arc::ptr_eq(&shown.settings, self.pass.settings())
                && !is_same(shown.pixel.as_ref(), pixel.as_ref())
                && pixel.as_ref().is_none_or(|history| history.states.len() as u32 > shown.position)
        });
        if let Some(shown) = shown {
            self.show(ShownFrame { pixel, ..ShownFrame::clone(shown) });
        } else if !is_same(self.outbox.pixel.as_ref(), pixel.as_ref()) {
            self.publish_pixel();
        }
    }

    /// Publishes only the pixel's history, before the frame in view.
    pub(super) fn publish_pixel(&mut self) {
        let pixel = self.pass.pixel_follower.latest();
        self.outbox.pixel.clone_from(&pixel);
        let pixel_progress = self.pixel_progress();
        self.shared.publish(|state| (state.pixel, state.pixel_progress) = (pixel, pixel_progress));
    }

    /// How far the chosen pixel has been followed, while its history does not cover the frame in view.
    fn pixel_progress(&self) -> Option<WorkProgress> {
        let shown = self.view.shown.as_ref()?;
        let (done, total) = self.pass.pixel_follower.progress_to(shown.position)?;
        Some(WorkProgress { what: "computing pixel history".to_owned(), done, total: Some(total) })
    }

    /// Publishes new results at a limited rate, and everything before the worker sleeps.
    pub(super) fn publish_in_time(&mut self, resting: bool) {
        let pace = MIN_PUBLISH_INTERVAL.max(self.outbox.publishing_took * 10);
        if self.stopped || !resting && self.outbox.published.elapsed() < pace {
            return;
        }
        if resting {
            self.busy = None;
        }
        // A request without effect must not wake the window, which might repeat it.
        let pixel_grew = std::mem::take(&mut self.outbox.pixel_grew);
        let grew = self.outbox.timeline_grew || self.outbox.compared_grew || pixel_grew;
        if self.busy == self.outbox.busy && !grew && self.outbox.warnings.is_empty() {
            return;
        }
        let started = Instant::now();
        // While the frame in view waits for new settings, so does the timeline.
        let view_lags =
            self.view.shown.as_ref().is_some_and(|shown| !Arc::ptr_eq(&shown.settings, self.pass.settings()));
        let timeline = (self.outbox.timeline_grew && !view_lags).then(|| self.timeline());
        let compared = (self.outbox.compared_grew && !view_lags).then(|| self.compared_sequence());
        let new_warnings = std::mem::take(&mut self.outbox.warnings);
        self.show_pixel();
        let (pins, region) = (Arc::new(self.pins.latest()), self.region.latest());
        let pixel_progress = self.pixel_progress();
        let lost = self.pass.pixel_follower.lost().into_iter().chain(self.pins.lost()).collect();
        self.shared.publish(|state| {
            (state.pins, state.region) = (pins, region);
            state.pixel_progress = pixel_progress;
            state.lost = lost;
            if let Some(timeline) = timeline {
                state.timeline = timeline;
            }
            if let Some(compared) = compared {
                state.compared = compared;
            }
            if !new_warnings.is_empty() {
                Arc::make_mut(&mut state.warnings).extend(new_warnings);
            }
            state.busy.clone_from(&self.busy);
            state.analysis_fps = self.speed_meter.frames_a_second();
        });
        self.outbox.busy.clone_from(&self.busy);
        self.outbox.published = Instant::now();
        self.outbox.publishing_took = started.elapsed();
    }
}
