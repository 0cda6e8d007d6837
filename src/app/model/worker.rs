//! The link to the worker: the results that it published, and the requests that were sent to it.

use std::sync::Arc;
use std::time::Instant;

use eframe::egui::Context;

use crate::app::model::event_comparison::EventRef;
use crate::app::model::player::Player;
use crate::app::model::trails::FrameWithTrails;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::{PixelRegion, RegionShares};
use crate::explain::tuning::TunableSetting;
use crate::explain::tuning::{RegionTuning, Tuning};
use crate::frame::Size;
use crate::mixture::Quantity;
use crate::occlusion::Event;
use crate::placement::Placement;
use crate::regions::Roi;
use crate::replay::{Phase, Request, ShownFrame, Start, State, Timeline};
use crate::settings::Settings;
use crate::source::Options;

/// Starts a worker for a video name.
pub(crate) type PlayerFactory =
    Box<dyn Fn(&str, Options, (Settings, Option<Arc<Roi>>), Start, &Context) -> Box<dyn Player>>;

/// The requests that were sent last, so that none is sent twice.
#[derive(Clone, Debug)]
pub(crate) struct SentRequests {
    /// The settings in view, and those to compare with.
    pub(crate) settings: (Settings, Option<Settings>),
    /// The axes of the tuning map.
    pub(crate) tuning_axes: Option<[TunableSetting; 2]>,
    /// The pinned pixels whose histories were requested.
    pub(crate) pins: Vec<(u32, u32)>,
    /// The region whose foreground ratio was requested.
    pub(crate) shares_region: Option<PixelRegion>,
    /// The region whose accuracy was requested.
    pub(crate) accuracy_region: Option<PixelRegion>,
    /// The quantity whose maps were requested.
    pub(crate) map: Option<Quantity>,
    /// The event whose counterfactuals were requested.
    pub(crate) event: Option<Event>,
}

impl SentRequests {
    /// The requests known to a new worker: only the settings in view.
    pub(super) const fn new(settings: Settings) -> Self {
        Self {
            settings: (settings, None),
            tuning_axes: None,
            pins: Vec::new(),
            shares_region: None,
            accuracy_region: None,
            map: None,
            event: None,
        }
    }
}

/// The worker of the open video.
pub(crate) struct WorkerLink {
    /// The worker, once a video was opened.
    pub(crate) player: Option<Box<dyn Player>>,
    /// The latest state that the worker published. Its frame may not be in view yet.
    pub(crate) state: Option<State>,
    /// The latest frame that the worker published.
    pub(crate) newest: Option<Arc<FrameWithTrails>>,
    /// The frame in view: the latest whose layers are uploaded.
    pub(crate) in_view: Option<Arc<FrameWithTrails>>,
    /// The time of the request to open the video, if any.
    pub(crate) opened_at: Option<Instant>,
    /// Whether the worker analyses frames beyond the frame in view.
    pub(crate) analyses_ahead: bool,
    /// The requested position that has not arrived yet.
    pub(crate) requested_position: Option<u32>,
    /// The requests that were sent last.
    pub(crate) sent: SentRequests,
}

impl WorkerLink {
    /// A link without a worker.
    pub(super) const fn new(settings: Settings) -> Self {
        Self {
            player: None,
            state: None,
            newest: None,
            in_view: None,
            opened_at: None,
            analyses_ahead: true,
            requested_position: None,
            sent: SentRequests::new(settings),
        }
    }

    /// Replaces the worker by one that was started with these settings.
    pub(super) fn open(&mut self, player: Box<dyn Player>, settings: Settings) {
        let state = Some(player.state());
        self.leave();
        *self = Self { player: Some(player), state, opened_at: Some(Instant::now()), ..Self::new(settings) };
    }

    /// Ends the worker and drops its results.
    pub(super) fn close(&mut self) {
        self.leave();
        (self.state, self.newest, self.in_view, self.requested_position) = (None, None, None, None);
    }

    fn leave(&mut self) {
        if let Some(player) = self.player.take() {
            player.leave();
        }
    }

    /// Takes a published state. Returns its new warnings.
    pub(super) fn receive(&mut self, state: State) -> Vec<String> {
        let known = self.state.as_ref().map_or(0, |before| before.warnings.len());
        let warnings = state.warnings.iter().skip(known).cloned().collect();
        if let Some(shown) = &state.shown {
            if state.timeline.complete {
                // The last frame answers a request beyond the end.
                let last = (state.timeline.numbers.len() as u32).saturating_sub(1);
                self.requested_position = self.requested_position.map(|requested| requested.min(last));
            }
            if self.requested_position == Some(shown.position) {
                self.requested_position = None;
            }
            if self.newest.as_ref().is_none_or(|newest| !Arc::ptr_eq(&newest.shown, shown)) {
                self.newest = Some(Arc::new(FrameWithTrails::after(self.newest.as_deref(), shown)));
            }
        }
        self.state = Some(state);
        warnings
    }

    /// Requests the frame at a position.
    pub(crate) fn go_to(&mut self, position: u32) {
        let frames = self.frames();
        let position = if frames > 0 { position.min(frames - 1) } else { position };
        if let Some(player) = &self.player {
            player.request(Request::Show(position));
            let here = self.newest.as_ref().is_some_and(|newest| newest.shown.position == position);
            if !here || self.requested_position.is_some() {
                self.requested_position = Some(position);
            }
        }
    }

    /// Pauses the analysis beyond the frame in view, or resumes it.
    pub(crate) fn toggle_analysis(&mut self) {
        let Some(player) = &self.player else { return };
        self.analyses_ahead = !self.analyses_ahead && !self.is_busy();
        player.request(Request::AnalyseAhead(self.analyses_ahead));
        if !self.analyses_ahead {
            self.requested_position = None;
        }
    }

    /// Requests the tuning map of these axes, once.
    pub(crate) fn request_tuning(&mut self, axes: Option<[TunableSetting; 2]>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.sent.tuning_axes != axes) {
            player.request(Request::Tune(axes));
            self.sent.tuning_axes = axes;
        }
    }

    /// Requests the histories of these pixels, once.
    pub(crate) fn request_pins(&mut self, pins: Vec<(u32, u32)>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.sent.pins != pins) {
            player.request(Request::Pin(pins.clone()));
            self.sent.pins = pins;
        }
    }

    /// Requests the foreground ratio in a region, once.
    pub(crate) fn request_shares(&mut self, region: Option<PixelRegion>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.sent.shares_region != region) {
            player.request(Request::CountRegion(region));
            self.sent.shares_region = region;
        }
    }

    /// Requests the accuracy in a region, once.
    pub(crate) fn request_accuracy(&mut self, region: Option<PixelRegion>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.sent.accuracy_region != region) {
            player.request(Request::TuneRegion(region));
            self.sent.accuracy_region = region;
        }
    }

    /// Requests the maps of this quantity, once.
    pub(crate) fn request_map(&mut self, quantity: Option<Quantity>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.sent.map != quantity) {
            player.request(Request::Map(quantity));
            self.sent.map = quantity;
        }
    }

    /// Requests the counterfactuals of an event, once.
    pub(crate) fn request_counterfactuals(&mut self, event: Option<&Event>) {
        let is_sent = match (event, &self.sent.event) {
            (Some(event), Some(sent)) => event.is_same(sent),
            (event, sent) => event.is_none() && sent.is_none(),
        };
        if let Some(player) = self.player.as_ref().filter(|_| !is_sent) {
            player.request(Request::Explain(event.cloned().map(Box::new)));
            self.sent.event = event.cloned();
        }
    }

    /// The frame in view.
    pub(crate) fn shown(&self) -> Option<&ShownFrame> {
        self.in_view.as_ref().map(|frame| &*frame.shown)
    }

    /// The chosen pixel under the latest settings. The frame in view may still wait for these settings.
    pub(crate) fn pixel(&self) -> Option<&Arc<PixelHistory>> {
        self.state.as_ref()?.pixel.as_ref()
    }

    /// The chosen pixel under other settings, if computed.
    pub(crate) fn tuning(&self) -> Option<&Tuning> {
        self.state.as_ref()?.tuning.as_deref()
    }

    /// The foreground ratio around a pixel, if computed.
    pub(crate) fn region_shares(&self, pixel: Option<(u32, u32)>) -> Option<&Arc<RegionShares>> {
        let shares = self.state.as_ref()?.region.as_ref();
        shares.filter(|shares| Some(shares.at) == pixel)
    }

    /// The accuracy in the region that was requested last, if computed.
    pub(crate) fn region_tuning(&self) -> Option<&Arc<RegionTuning>> {
        let tuning = self.state.as_ref()?.region_tuning.as_ref();
        let region = |tuning: &RegionTuning| PixelRegion { centre: tuning.at, side: tuning.side };
        tuning.filter(|tuning| Some(region(tuning)) == self.sent.accuracy_region)
    }

    /// The sequence's timeline under the settings in view.
    pub(crate) fn timeline(&self) -> Option<&Timeline> {
        self.state.as_ref().map(|state| &*state.timeline)
    }

    /// The sequence's timeline under the settings of the other slot.
    pub(crate) fn compared_timeline(&self) -> Option<&Timeline> {
        self.state.as_ref()?.compared.as_ref().map(|compared| &compared.timeline)
    }

    /// An event of either timeline, with its position.
    pub(crate) fn event(&self, event: EventRef) -> Option<&(u32, Event)> {
        match event {
            EventRef::InView(index) => self.timeline()?.events.get(index),
            EventRef::Compared(index) => self.compared_timeline()?.events.get(index),
        }
    }

    /// The worker's error, if it has failed.
    pub(crate) fn failure(&self) -> Option<&str> {
        match &self.state.as_ref()?.phase {
            Phase::Failed(why) => Some(why),
            Phase::Opening | Phase::Ready => None,
        }
    }

    /// Whether there is a frame to show.
    pub(crate) fn is_ready(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.phase == Phase::Ready)
    }

    /// Whether the worker is busy.
    pub(crate) fn is_busy(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.busy.is_some())
    }

    /// Whether all frames have been analysed.
    pub(crate) fn is_all_analysed(&self) -> bool {
        self.timeline()
            .is_some_and(|timeline| timeline.complete && timeline.analysed as usize >= timeline.numbers.len())
    }

    /// Whether the source delivers each frame only once.
    pub(crate) fn is_live(&self) -> bool {
        self.state.as_ref().and_then(|state| state.info.as_ref()).is_some_and(|info| info.live)
    }

    /// The frame size, once it is known.
    pub(crate) fn size(&self) -> Option<Size> {
        self.state.as_ref()?.info.as_ref().map(|info| info.size)
    }

    /// Where the frames lie in the source's images, if they are not these images.
    pub(crate) fn placement(&self) -> Option<Placement> {
        self.state.as_ref()?.info.as_ref()?.placement()
    }

    /// The pixel of the source's images for one of the frames. The user sees the former.
    pub(crate) fn source_pixel(&self, at: (u32, u32)) -> (u32, u32) {
        self.placement().map_or(at, |placement| placement.source_pixel(at))
    }

    /// The width of a pixel relative to its height; 1 until it is known.
    pub(crate) fn pixel_aspect(&self) -> f32 {
        let info = self.state.as_ref().and_then(|state| state.info.as_ref());
        let aspect = info.and_then(|info| info.pixel_aspect);
        aspect.map_or(1.0, |(width, height)| width as f32 / height.max(1) as f32)
    }

    /// The video's frame rate; 25 until it is known.
    pub(crate) fn fps(&self) -> f32 {
        let info = self.state.as_ref().and_then(|state| state.info.as_ref());
        info.map_or(25.0, |info| if info.fps.is_finite() && info.fps > 0.0 { info.fps } else { 25.0 })
    }

    /// The number of frames, or its estimate.
    pub(crate) fn frames(&self) -> u32 {
        let Some(state) = &self.state else { return 0 };
        let known = state.timeline.numbers.len() as u32;
        if state.timeline.complete {
            return known;
        }
        state.info.as_ref().and_then(|info| info.frames).unwrap_or(0).max(known)
    }

    /// The position from which steps count: the requested one, else that of the latest frame.
    pub(crate) fn position(&self) -> u32 {
        self.requested_position
            .or_else(|| self.newest.as_ref().map(|newest| newest.shown.position))
            .unwrap_or(0)
    }

    /// The number of the frame at a position.
    pub(crate) fn number(&self, position: u32) -> u32 {
        let known = self.timeline().and_then(|timeline| timeline.numbers.get(position as usize));
        known.copied().unwrap_or(position + 1)
    }

    /// Seconds from the frame before this position to the frame there; the average where their times are not known.
    pub(crate) fn seconds_to(&self, position: u32) -> f64 {
        let times = self.timeline().map_or(&[][..], |timeline| &timeline.times);
        let at = |position: Option<u32>| times.get(position? as usize).copied();
        let known = at(Some(position)).zip(at(position.checked_sub(1)));
        known.map_or(1.0 / f64::from(self.fps()), |(time, before)| time - before)
    }

    /// The position of the frame of this number, or of the next existing one.
    pub(crate) fn position_of(&self, number: u32) -> u32 {
        let numbers = self.timeline().map_or(&[][..], |timeline| &timeline.numbers);
        match numbers.binary_search(&number) {
            Ok(position) => position as u32,
            Err(position) if position < numbers.len() => position as u32,
            // Beyond the known frames, numbers are assumed to be consecutive.
            Err(_) => {
                let (last, count) = (numbers.last().copied().unwrap_or(0), numbers.len() as u32);
                (count + number.saturating_sub(last)).saturating_sub(1)
            }
        }
    }
}
