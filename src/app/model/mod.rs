//! The window's state and its requests to the worker: data only, without drawing.

pub(crate) mod ab_settings;
pub(crate) mod areas;
pub(crate) mod event_comparison;
pub(crate) mod marks;
pub(crate) mod overlays;
pub(crate) mod persisted_state;
pub(crate) mod pins;
pub(crate) mod player;
pub(crate) mod undo_history;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use eframe::egui::Context;

use crate::app::model::ab_settings::{AbSettings, AbSlot};
use crate::app::model::areas::Areas;
use crate::app::model::event_comparison::{ComparisonFilter, EventComparison, EventRef};
use crate::app::model::marks::Marks;
use crate::app::model::overlays::{Overlay, Overlays};
use crate::app::model::player::Player;
use crate::app::model::undo_history::UndoHistory;
use crate::app::views::{Background, View};
use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::TunableSetting;
use crate::frame::Size;
use crate::mixture::Quantity;
use crate::occlusion::{Event, EventKind};
use crate::regions::Roi;
use crate::replay::{Phase, RegionShares, RegionTuning, ShownFrame, Start, State, Timeline, Tuning};
use crate::settings::Settings;
use crate::source::Options;
use crate::tracking::{Identity, Track};
use crate::truth::Truth;

/// Starts a worker for a video name.
pub(crate) type Opener =
    Box<dyn Fn(&str, Options, (Settings, Option<Arc<Roi>>), Start, &Context) -> Box<dyn Player>>;

/// The playback speeds.
pub(crate) const SPEEDS: [f32; 8] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];
/// The index of ×1 in [`SPEEDS`].
pub(crate) const NORMAL_SPEED: usize = 4;

/// Maximum number of recent videos.
const MAX_RECENT_VIDEOS: usize = 10;

/// Minimum IoU of two boxes of the same object.
const MIN_SAME_OBJECT_IOU: f32 = 0.3;

/// Length of a trail, in frames.
const TRAIL_FRAMES: u32 = 60;

/// Playback by the window's clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Playback {
    /// Whether it runs.
    pub(crate) playing: bool,
    /// The index of its speed in [`SPEEDS`].
    pub(crate) speed: usize,
    /// When the next frame is due, in seconds of the window's clock.
    pub(crate) next_at: f64,
}

/// Requests that remain valid for the worker's lifetime.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    /// The time of the request to open the video, if any.
    pub(crate) since: Option<Instant>,
    /// Whether the worker analyses frames beyond the frame in view.
    pub(crate) ahead: bool,
}

/// The camera of all views, independent of their sizes, so that the views stay linked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Camera {
    /// The magnification relative to the fitted image.
    pub(crate) magnification: f32,
    /// The image point at the centre of each view, as fractions of width and height.
    pub(crate) centre: [f32; 2],
}

impl Camera {
    /// The whole image.
    pub(crate) const FIT: Self = Self { magnification: 1.0, centre: [0.5, 0.5] };
}

/// The subject of the panel on the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// The chosen pixel.
    Pixel,
    /// The chosen object.
    Object,
}

/// The pixel under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hover {
    /// The view.
    pub(crate) view: View,
    /// The pixel, as column and row.
    pub(crate) pixel: (u32, u32),
    /// Points per image pixel in that view.
    pub(crate) scale: f32,
}

/// The number and the objects of each analysed frame near the frame in view, by position.
pub(crate) type Trails = BTreeMap<u32, (u32, Arc<Vec<Track>>)>;

/// A frame with the trails of its objects.
#[derive(Clone, Debug)]
pub(crate) struct FrameWithTrails {
    /// The frame.
    pub(crate) shown: Arc<ShownFrame>,
    /// Past positions of its objects.
    pub(crate) trails: Arc<Trails>,
}

impl FrameWithTrails {
    /// The frame with its trails. `before` is the previously published frame, which need not be adjacent.
    fn after(before: Option<&Self>, shown: &Arc<ShownFrame>) -> Self {
        let mut trails = before.map(|before| Arc::clone(&before.trails)).unwrap_or_default();
        let kept = Arc::make_mut(&mut trails);
        let other = |before: &Self| {
            let roi = |shown: &ShownFrame| shown.roi.as_ref().map(Arc::as_ptr);
            before.shown.settings != shown.settings || roi(&before.shown) != roi(shown)
        };
        if before.is_some_and(other) {
            kept.clear();
        }
        kept.insert(shown.position, (shown.frame.number, shown.analysis.tracks.clone()));
        let near = shown.position.saturating_sub(TRAIL_FRAMES)..=shown.position + TRAIL_FRAMES;
        kept.retain(|position, _| near.contains(position));
        Self { shown: Arc::clone(shown), trails }
    }
}

/// The relation of the open video to the list of recent videos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// The video is added to the list once it has opened.
    New,
    /// The video is in the list.
    Listed,
    /// The bundled sample, which is never listed.
    Sample,
}

/// The complete state of the window.
// Each `bool` is a separate switch with its own shortcut.
#[allow(clippy::struct_excessive_bools)]
pub(crate) struct Model {
    /// The worker, once a video was opened.
    pub(crate) player: Option<Box<dyn Player>>,
    /// The latest state that the worker published. Its frame may not be in view yet.
    pub(crate) state: Option<State>,
    /// The latest frame that the worker published.
    pub(crate) newest: Option<Arc<FrameWithTrails>>,
    /// The frame in view: the latest whose layers are uploaded.
    pub(crate) in_view: Option<Arc<FrameWithTrails>>,
    /// Further requests to the worker.
    pub(crate) work: Work,
    /// The name of the open video.
    pub(crate) opened: Option<String>,
    /// The relation of that video to the list of recent videos.
    pub(crate) origin: Origin,
    /// The requested settings: those of the slot in view.
    pub(crate) settings: Settings,
    /// The slot in view, and the settings of the other slot.
    pub(crate) ab_settings: AbSettings,
    /// The settings last sent to the worker: those in view, and those to compare with.
    pub(crate) sent: (Settings, Option<Settings>),
    /// The axes of the tuning map last requested.
    pub(crate) tuned: Option<[TunableSetting; 2]>,
    /// The pinned pixels whose histories were last requested.
    pub(crate) pinned: Vec<(u32, u32)>,
    /// The pixel and the side of the region whose foreground ratio was last requested.
    pub(crate) region: Option<((u32, u32), u32)>,
    /// The pixel and the side of the region whose accuracy was last requested.
    pub(crate) judged: Option<((u32, u32), u32)>,
    /// The quantity whose maps were last requested.
    pub(crate) mapped: Option<Quantity>,
    /// Edits, for undo and redo.
    pub(crate) history: UndoHistory,
    /// The requested position that has not arrived yet.
    pub(crate) requested_position: Option<u32>,
    /// The region of interest, and the areas that define it.
    pub(crate) areas: Areas,
    /// Playback.
    pub(crate) playback: Playback,
    /// The marks in this video.
    pub(crate) marks: Marks,
    /// The marks in other videos, by name.
    pub(crate) marks_of: BTreeMap<String, Marks>,
    /// Typed frame rates of videos, by name.
    pub(crate) rates: BTreeMap<String, f32>,
    /// The video whose frame rate the command line sets, for this run only, with that rate.
    pub(crate) told_rate: Option<(String, f32)>,
    /// The visible positions of the timeline, from and to; `None` for all.
    pub(crate) span: Option<(f32, f32)>,
    /// The chosen pixel.
    pub(crate) chosen: Option<(u32, u32)>,
    /// The chosen object.
    pub(crate) object: Option<Identity>,
    /// The subject of the panel on the right.
    pub(crate) subject: Subject,
    /// The pixel under the pointer.
    pub(crate) hovered: Option<Hover>,
    /// The camera of all views.
    pub(crate) camera: Camera,
    /// The maximised view.
    pub(crate) maximised: Option<View>,
    /// What the background view shows.
    pub(crate) background: Background,
    /// The quantity that the map view shows.
    pub(crate) quantity: Quantity,
    /// The mask over the input.
    pub(crate) overlay: Overlay,
    /// Whether the loupe is on.
    pub(crate) loupe: bool,
    /// The ground truth.
    pub(crate) truth: Option<Arc<Truth>>,
    /// The overlays of the tracks view.
    pub(crate) drawn: Overlays,
    /// Which views are open, in the order of [`View::ALL`].
    pub(crate) open: [bool; View::ALL.len()],
    /// Recent videos, latest first.
    pub(crate) recent: Vec<String>,
    /// The kinds of events that are listed and visited by key, in the order of [`EventKind::ALL`].
    pub(crate) listed: [bool; EventKind::ALL.len()],
    /// The event whose evidence is shown, by its current index.
    pub(crate) reading: Option<EventRef>,
    /// That event, to find it again when its index changes.
    read: Option<Event>,
    /// The comparison of events, `None` where nothing is compared.
    pub(crate) compared: Option<EventComparison>,
    /// The event whose counterfactuals were requested last.
    pub(crate) explained: Option<Event>,
    /// The filter of that comparison.
    pub(crate) listing: ComparisonFilter,
    /// The slot to return to when a key is released.
    pub(crate) held: Option<AbSlot>,
    /// The setting to scroll into view.
    pub(crate) looked_at: Option<&'static str>,
    /// Whether the hint is still to be shown.
    pub(crate) hint: bool,
    /// Whether the settings panel is open.
    pub(crate) settings_panel: bool,
    /// Whether the inspector panel is open.
    pub(crate) inspector_panel: bool,
}

impl Model {
    /// A model without an open video.
    pub(crate) fn new(settings: Settings) -> Self {
        Self {
            player: None,
            state: None,
            newest: None,
            in_view: None,
            opened: None,
            origin: Origin::New,
            history: UndoHistory::new(settings.clone()),
            sent: (settings.clone(), None),
            tuned: None,
            mapped: None,
            pinned: Vec::new(),
            region: None,
            judged: None,
            settings,
            ab_settings: AbSettings::new(),
            requested_position: None,
            work: Work { since: None, ahead: true },
            areas: Areas::default(),
            marks: Marks::default(),
            marks_of: BTreeMap::new(),
            rates: BTreeMap::new(),
            told_rate: None,
            span: None,
            playback: Playback { playing: false, speed: NORMAL_SPEED, next_at: 0.0 },
            chosen: None,
            object: None,
            subject: Subject::Pixel,
            hovered: None,
            camera: Camera::FIT,
            maximised: None,
            background: Background::Mean,
            // Under the defaults σ is at its floor nearly everywhere, and its map would be uniform.
            quantity: Quantity::Weight,
            overlay: Overlay { on: false, opacity: 50 },
            loupe: false,
            truth: None,
            drawn: Overlays::default(),
            open: [true; View::ALL.len()],
            recent: Vec::new(),
            listed: [true; EventKind::ALL.len()],
            reading: None,
            read: None,
            compared: None,
            explained: None,
            listing: ComparisonFilter::All,
            held: None,
            looked_at: None,
            hint: true,
            settings_panel: true,
            inspector_panel: true,
        }
    }

    /// The region of interest of a video that is about to be opened: the one set at start, or the areas drawn over the
    /// same video.
    pub(crate) fn areas_for(&mut self, name: &str) -> Option<Arc<Roi>> {
        let same = self.opened.as_deref() == Some(name) && self.size().is_some();
        if self.opened.is_some() && !same {
            self.areas = Areas::default();
            self.history.forget_areas();
        }
        self.areas.roi.clone()
    }

    /// The options of a video.
    pub(crate) fn options_of(&self, name: &str) -> Options {
        let told = self.told_rate.as_ref().filter(|(of, _)| of == name).map(|(_, fps)| *fps);
        Options { fps: told.or_else(|| self.rates.get(name).copied()) }
    }

    /// The frame size, once it is known.
    pub(crate) fn size(&self) -> Option<Size> {
        self.state.as_ref()?.info.as_ref().map(|info| info.size)
    }

    /// Replaces the open video by another.
    pub(crate) fn opened(&mut self, name: &str, player: Box<dyn Player>) {
        self.state = Some(player.state());
        self.leave();
        self.player = Some(player);
        self.work = Work { since: Some(Instant::now()), ahead: true };
        (self.newest, self.in_view) = (None, None);
        self.put_marks_away();
        self.marks = self.marks_of.get(name).cloned().unwrap_or_default();
        self.span = None;
        self.opened = Some(name.to_owned());
        (self.origin, self.truth) = (Origin::New, None);
        // A new worker has only the settings in view.
        (self.sent, self.tuned, self.mapped) = ((self.settings.clone(), None), None, None);
        (self.compared, self.explained) = (None, None);
        (self.pinned, self.region, self.judged) = (Vec::new(), None, None);
        (self.requested_position, self.chosen, self.hovered) = (None, None, None);
        self.read(None);
        (self.object, self.subject) = (None, Subject::Pixel);
        self.playback.playing = false;
        self.camera = Camera::FIT;
    }

    /// Closes the video.
    pub(crate) fn closed(&mut self) {
        self.put_marks_away();
        self.leave();
        (self.state, self.newest, self.in_view, self.opened) = (None, None, None, None);
        (self.requested_position, self.chosen, self.hovered) = (None, None, None);
        self.read(None);
        (self.object, self.subject) = (None, Subject::Pixel);
        (self.marks, self.span, self.areas) = (Marks::default(), None, Areas::default());
        self.history.forget_areas();
        (self.origin, self.truth) = (Origin::New, None);
        self.playback.playing = false;
    }

    fn leave(&mut self) {
        if let Some(player) = self.player.take() {
            player.leave();
        }
    }

    /// Pauses the analysis beyond the frame in view, or resumes it.
    pub(crate) fn stop_or_go_on(&mut self) {
        let Some(player) = &self.player else { return };
        self.work.ahead = !self.work.ahead && !self.is_busy();
        player.analyse_ahead(self.work.ahead);
        if !self.work.ahead {
            self.requested_position = None;
        }
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

    /// Video, frame, time and the chosen pixel, in one line.
    pub(crate) fn place(&self) -> Option<String> {
        let shown = self.shown()?;
        let name = self.opened.as_deref().map_or("", crate::app::panels::top_bar::short);
        let seconds = shown.position as f32 / self.fps();
        let pixel = self.chosen.and_then(|(x, y)| {
            let [r, g, b] = shown.frame.pixel(x, y)?;
            Some(format!(", pixel {x},{y} = {r} {g} {b}"))
        });
        Some(format!("{name}, frame {}, {seconds:.2} s{}", shown.frame.number, pixel.unwrap_or_default()))
    }

    /// Stores the marks under the video's name.
    pub(crate) fn put_marks_away(&mut self) {
        let Some(name) = &self.opened else { return };
        if self.marks.is_empty() {
            self.marks_of.remove(name);
        } else {
            self.marks_of.insert(name.clone(), self.marks.clone());
        }
    }

    /// Brings the settings of a slot into view. Returns whether the slot is new.
    pub(crate) fn show_slot(&mut self, slot: AbSlot) -> bool {
        // An uncommitted edit belongs to the slot that is left.
        self.history.note(&self.settings);
        let first = self.ab_settings.other.is_none() && slot != self.ab_settings.in_view;
        self.ab_settings.show(slot, &mut self.settings);
        self.history.look(slot, &self.settings);
        first
    }

    /// Requests the counterfactuals of the event whose evidence is shown, once.
    pub(crate) fn explain(&mut self) {
        let read = self.read.as_ref().filter(|_| matches!(self.reading, Some(EventRef::InView(_))));
        let asked = match (read, &self.explained) {
            (Some(read), Some(explained)) => read.is_same(explained),
            (read, explained) => read.is_none() && explained.is_none(),
        };
        if let Some(player) = self.player.as_ref().filter(|_| !asked) {
            player.explain(read.cloned());
            self.explained = read.cloned();
        }
    }

    /// Changes both slots as one edit.
    pub(crate) fn change_slots(&mut self, change: impl FnOnce(&mut AbSettings, &mut Settings)) {
        self.history.note(&self.settings);
        let before = (self.ab_settings.clone(), self.settings.clone());
        change(&mut self.ab_settings, &mut self.settings);
        self.history.note_slots(before, (self.ab_settings.clone(), self.settings.clone()));
    }

    /// The chosen pixel under other settings, if computed.
    pub(crate) fn tuning(&self) -> Option<&Tuning> {
        self.state.as_ref()?.tuning.as_deref()
    }

    /// Requests the tuning map of these axes, once.
    pub(crate) fn tune(&mut self, knobs: Option<[TunableSetting; 2]>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.tuned != knobs) {
            player.tune(knobs);
            self.tuned = knobs;
        }
    }

    /// Requests the histories of the pinned pixels, once.
    pub(crate) fn pin(&mut self) {
        let pins: Vec<_> = self.marks.pins.iter().map(|(_, at)| at).collect();
        if let Some(player) = self.player.as_ref().filter(|_| self.pinned != pins) {
            player.pin(pins.clone());
            self.pinned = pins;
        }
    }

    /// Requests the foreground ratio around the chosen pixel, in a region of this `side` in pixels, once.
    pub(crate) fn look_around(&mut self, side: Option<u32>) {
        let region = self.chosen.zip(side);
        if let Some(player) = self.player.as_ref().filter(|_| self.region != region) {
            player.region(region);
            self.region = region;
        }
    }

    /// The foreground ratio around the chosen pixel, if computed.
    pub(crate) fn region_shares(&self) -> Option<&Arc<RegionShares>> {
        let shares = self.state.as_ref()?.region.as_ref();
        shares.filter(|shares| Some(shares.at) == self.chosen)
    }

    /// Requests the maps of this quantity, once.
    pub(crate) fn map(&mut self, quantity: Option<Quantity>) {
        if let Some(player) = self.player.as_ref().filter(|_| self.mapped != quantity) {
            player.map(quantity);
            self.mapped = quantity;
        }
    }

    /// Requests the accuracy around the chosen pixel, in a region of this `side` in pixels, once.
    pub(crate) fn judge(&mut self, side: Option<u32>) {
        let region = self.chosen.zip(side);
        if let Some(player) = self.player.as_ref().filter(|_| self.judged != region) {
            player.tune_region(region);
            self.judged = region;
        }
    }

    /// The accuracy around the chosen pixel, if computed.
    pub(crate) fn region_tuning(&self) -> Option<&Arc<RegionTuning>> {
        let tuning = self.state.as_ref()?.region_tuning.as_ref();
        tuning.filter(|tuning| Some((tuning.at, tuning.side)) == self.judged)
    }

    /// Whether there are ground-truth masks of the video.
    pub(crate) fn has_true_masks(&self) -> bool {
        let masks = self.truth.as_ref().and_then(|truth| truth.masks.as_ref());
        masks.is_some_and(|masks| Some(masks.size()) == self.size())
    }

    /// Sets the ground truth.
    pub(crate) fn take_truth(&mut self, truth: Arc<Truth>) {
        if let Some(player) = &self.player {
            player.set_truth(Some(Arc::clone(&truth)));
        }
        self.truth = Some(truth);
    }

    /// Zooms all views around the chosen pixel, or around the centre.
    pub(crate) fn zoom_by(&mut self, factor: f32) {
        let magnification = (self.camera.magnification * factor).clamp(0.5, 400.0);
        let at_pixel = self.chosen.zip(self.shown().map(|shown| shown.frame.size));
        if let Some(((x, y), size)) = at_pixel {
            let target =
                [(x as f32 + 0.5) / size.width.max(1) as f32, (y as f32 + 0.5) / size.height.max(1) as f32];
            let part = 1.0 - self.camera.magnification / magnification;
            for (centre, target) in self.camera.centre.iter_mut().zip(target) {
                *centre = (*centre + (target - *centre) * part).clamp(0.0, 1.0);
            }
        }
        self.camera.magnification = magnification;
    }

    /// The pixel at an offset from the chosen one, clamped to the image; the centre pixel where none is chosen.
    pub(crate) fn pixel_beside(&self, columns: i32, rows: i32) -> Option<(u32, u32)> {
        let size = self.shown()?.frame.size;
        let Some((x, y)) = self.chosen else { return Some((size.width / 2, size.height / 2)) };
        let within = |at: u32, by: i32, all: u32| at.saturating_add_signed(by).min(all.saturating_sub(1));
        Some((within(x, columns, size.width), within(y, rows, size.height)))
    }

    /// The frame in view.
    pub(crate) fn shown(&self) -> Option<&ShownFrame> {
        self.in_view.as_ref().map(|moment| &*moment.shown)
    }

    /// The chosen pixel under the latest settings. The frame in view may still wait for these settings.
    pub(crate) fn pixel(&self) -> Option<&Arc<PixelHistory>> {
        self.state.as_ref()?.pixel.as_ref()
    }

    /// The sequence's timeline under the settings in view.
    pub(crate) fn timeline(&self) -> Option<&Timeline> {
        self.state.as_ref().map(|state| &*state.timeline)
    }

    /// The sequence's timeline under the settings of the other slot.
    pub(crate) fn compared_timeline(&self) -> Option<&Timeline> {
        self.state.as_ref()?.compared.as_ref().map(|beside| &beside.timeline)
    }

    /// Shows the evidence of an event, or of none.
    pub(crate) fn read(&mut self, read: Option<EventRef>) {
        self.reading = read;
        self.read = read.and_then(|read| Some(self.event(read)?.1.clone()));
    }

    /// Updates the index of the event whose evidence is shown. Late decisions insert events before it, and may remove
    /// it.
    fn find_read_again(&mut self) {
        let (Some(reading), Some(event)) = (self.reading, &self.read) else { return };
        if self.event(reading).is_some_and(|(_, other)| other.is_same(event)) {
            return;
        }
        let (timeline, at): (_, fn(usize) -> EventRef) = match reading {
            EventRef::InView(_) => (self.timeline(), EventRef::InView),
            EventRef::Compared(_) => (self.compared_timeline(), EventRef::Compared),
        };
        let found = timeline
            .and_then(|timeline| timeline.events.iter().position(|(_, other)| other.is_same(event)).map(at));
        self.read(found);
    }

    /// Updates the chosen object after a change of settings. The same object may have another identity: the object
    /// with the largest IoU is chosen.
    fn find_object_again(&mut self, now: &ShownFrame) {
        let Some((id, newest)) = self.object.zip(self.newest.as_ref()) else { return };
        let before = &newest.shown;
        if before.settings == now.settings {
            return;
        }
        let place = before.analysis.tracks.iter().find(|track| track.id == id).map(|track| track.bbox);
        let place = place.filter(|_| before.position == now.position);
        self.object = place.and_then(|place| {
            let nearest = now.analysis.tracks.iter().max_by(|a, b| {
                let iou = |track: &Track| track.bbox.iou(&place);
                iou(a).total_cmp(&iou(b))
            });
            nearest.filter(|track| track.bbox.iou(&place) >= MIN_SAME_OBJECT_IOU).map(|track| track.id)
        });
    }

    /// An event of either timeline, with its position.
    pub(crate) fn event(&self, read: EventRef) -> Option<&(u32, Event)> {
        match read {
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

    /// Whether events of this kind are listed.
    pub(crate) fn lists(&self, kind: EventKind) -> bool {
        EventKind::ALL.iter().zip(self.listed).any(|(&each, listed)| each == kind && listed)
    }

    /// Takes the state that the worker published. Returns its new warnings.
    pub(crate) fn take(&mut self) -> Vec<String> {
        let Some(player) = &self.player else { return Vec::new() };
        let state = player.state();
        let before = self.state.as_ref();
        let warned = before.map_or(0, |before| before.warnings.len());
        let news = state.warnings.iter().skip(warned).cloned().collect();
        if let Some(shown) = &state.shown {
            if state.timeline.complete {
                // The last frame answers a request beyond the end.
                let last = (state.timeline.numbers.len() as u32).saturating_sub(1);
                self.requested_position =
                    self.requested_position.map(|requested_position| requested_position.min(last));
            }
            if self.requested_position == Some(shown.position) {
                self.requested_position = None;
            }
            if self.newest.as_ref().is_none_or(|newest| !Arc::ptr_eq(&newest.shown, shown)) {
                self.find_object_again(shown);
                self.newest = Some(Arc::new(FrameWithTrails::after(self.newest.as_deref(), shown)));
            }
        }
        let is_open = state.info.is_some();
        self.compared = EventComparison::of(&state, self.fps(), self.compared.take());
        self.state = Some(state);
        self.find_read_again();
        if is_open && self.origin == Origin::New {
            self.remember();
        }
        news
    }

    /// Moves the open video to the front of the recent videos.
    fn remember(&mut self) {
        let live = self.state.as_ref().and_then(|state| state.info.as_ref()).is_some_and(|info| info.live);
        self.origin = Origin::Listed;
        let Some(name) = self.opened.as_ref().filter(|_| !live) else { return };
        // A relative name from the command line depends on the working directory.
        let whole = std::path::absolute(name).ok().filter(|path| path.exists());
        let name = whole.map_or_else(|| name.clone(), |path| path.to_string_lossy().into_owned());
        self.recent.retain(|other| *other != name);
        self.recent.insert(0, name);
        self.recent.truncate(MAX_RECENT_VIDEOS);
    }

    /// Requests the frame at a position.
    pub(crate) fn go_to(&mut self, position: u32) {
        let frames = self.frames();
        let position = if frames > 0 { position.min(frames - 1) } else { position };
        if let Some(player) = &self.player {
            player.show(position);
            let here = self.newest.as_ref().is_some_and(|newest| newest.shown.position == position);
            if !here || self.requested_position.is_some() {
                self.requested_position = Some(position);
            }
        }
    }

    /// Index and position of the next or the previous listed event.
    pub(crate) fn event_beside(&self, forward: bool) -> Option<(usize, u32)> {
        let here = self.position();
        let events = &self.timeline()?.events;
        let mut listed = events
            .iter()
            .enumerate()
            .filter(|(_, (_, event))| self.lists(event.kind))
            .map(|(index, (position, _))| (index, *position));
        if forward {
            listed.filter(|(_, position)| *position > here).min_by_key(|(_, position)| *position)
        } else {
            let before = listed.by_ref().filter(|(_, position)| *position < here).collect::<Vec<_>>();
            let nearest = before.iter().map(|(_, position)| *position).max()?;
            before.into_iter().find(|(_, position)| *position == nearest)
        }
    }

    /// Advances playback: requests the next frame when it is due and the previous one has arrived. Returns the seconds
    /// until the next call.
    pub(crate) fn tick(&mut self, now: f64) -> Option<f64> {
        if !self.playback.playing {
            return None;
        }
        let position = self.newest.as_ref()?.shown.position;
        let at_end = self
            .timeline()
            .is_some_and(|timeline| timeline.complete && position + 1 >= timeline.numbers.len() as u32);
        let again = self.marks.loop_restart(position, at_end);
        if at_end && again.is_none() && self.requested_position.is_none() {
            self.playback.playing = false;
            return None;
        }
        // The worker wakes the window when the frame is published.
        if self.requested_position.is_some() {
            return None;
        }
        if now < self.playback.next_at {
            return Some(self.playback.next_at - now);
        }
        let period = 1.0 / f64::from(self.fps() * SPEEDS[self.playback.speed]);
        let behind = now - self.playback.next_at > period;
        self.playback.next_at = if behind { now + period } else { self.playback.next_at + period };
        self.go_to(again.unwrap_or(position + 1));
        Some(period)
    }
}
