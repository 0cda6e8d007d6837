//! What the window gets to see, and when.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Worker;
use crate::mixture::PixelHistory;
use crate::replay::{Beside, Progress, Shown, Timeline, same};

/// Growing things are published at most so often.
const PACE: Duration = Duration::from_millis(100);

/// What waits to be published, and when that was last done.
pub(super) struct Outbox {
    pub(super) timeline_grew: bool,
    pub(super) beside_grew: bool,
    /// The chosen pixel, a pinned one, or the share of a region.
    pub(super) pixel_grew: bool,
    pub(super) warnings: Vec<String>,
    pub(super) told_of: Told,
    /// As last published.
    pixel: Option<Arc<PixelHistory>>,
    /// How far the timeline reached that was last published.
    pub(super) analysed: u32,
    /// As last published.
    busy: Option<Progress>,
    published: Instant,
    publishing_took: Duration,
}

/// What is told once.
#[derive(Default)]
pub(super) struct Told {
    /// That frames are no longer kept.
    pub(super) gone: bool,
    /// That a live source cannot be compared.
    pub(super) live: bool,
}

impl Outbox {
    /// Everything is to be published.
    pub(super) fn new() -> Self {
        Self {
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
        }
    }
}

impl Worker<'_> {
    pub(super) fn publish_what_if(&self) {
        let what_if = self.asker.latest();
        self.shared.publish(|state| state.what_if = what_if);
    }

    pub(super) fn publish_region_tuning(&self) {
        let tuning = self.region_tuner.latest();
        self.shared.publish(|state| state.region_tuning = tuning);
    }

    /// Publishes a frame in view, and the timeline with it where that did not reach so far yet.
    pub(super) fn show(&mut self, shown: Shown) {
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
    pub(super) fn timeline(&mut self) -> Arc<Timeline> {
        self.outbox.timeline_grew = false;
        let timeline = self.lane.timeline(&self.frames, self.truth.as_ref());
        self.outbox.analysed = timeline.analysed;
        Arc::new(timeline)
    }

    /// What is known of the sequence under the settings that are compared with those in view.
    pub(super) fn beside(&mut self) -> Option<Arc<Beside>> {
        self.outbox.beside_grew = false;
        let lane = self.rival.lane.as_ref()?;
        let timeline = lane.timeline(&self.frames, self.truth.as_ref());
        Some(Arc::new(Beside { settings: Arc::clone(lane.settings()), timeline }))
    }

    /// Publishes the pixel's history as it is now, and the frame in view with it where both are of
    /// the same settings.
    pub(super) fn show_pixel(&mut self) {
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
    pub(super) fn publish_pixel(&mut self) {
        let pixel = self.lane.inspector.latest();
        self.outbox.pixel.clone_from(&pixel);
        self.shared.publish(|state| state.pixel = pixel);
    }

    /// Publishes what grows, not too often, and whatever is left before resting.
    pub(super) fn publish_in_time(&mut self, resting: bool) {
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
