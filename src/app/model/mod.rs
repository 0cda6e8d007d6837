//! The window's state and its requests to the worker: data only, without drawing.
//!
//! Panels and views read the [`Model`]; only commands change it.

pub(crate) mod ab_settings;
pub(crate) mod areas;
pub(crate) mod camera;
pub(crate) mod display;
pub(crate) mod edits;
pub(crate) mod event_comparison;
pub(crate) mod event_list;
pub(crate) mod external;
pub(crate) mod layout;
pub(crate) mod marks;
pub(crate) mod opened_sweep;
pub(crate) mod overlays;
pub(crate) mod persisted_state;
pub(crate) mod pins;
pub(crate) mod playback;
pub(crate) mod player;
pub(crate) mod selection;
pub(crate) mod timeline_span;
pub(crate) mod trails;
pub(crate) mod undo_history;
pub(crate) mod videos;
pub(crate) mod view;
pub(crate) mod worker;

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::model::areas::Areas;
use crate::app::model::camera::ViewCamera;
use crate::app::model::display::{Display, PanelState};
use crate::app::model::edits::Edits;
use crate::app::model::event_comparison::{EventComparison, EventRef};
use crate::app::model::event_list::EventList;
use crate::app::model::external::LoadedResults;
use crate::app::model::marks::Marks;
use crate::app::model::playback::Playback;
use crate::app::model::player::Player;
use crate::app::model::selection::{Selection, Subject};
use crate::app::model::videos::{Origin, Videos, file_name};
use crate::app::model::worker::WorkerLink;
use crate::placement::Placement;
use crate::regions::Roi;
use crate::replay::Request;
use crate::settings::Settings;
use crate::source::Options;
use crate::tracking::Identity;
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::external::ExternalResults;

/// The complete state of the window.
pub(crate) struct Model {
    /// The worker: its results, and the requests that were sent to it.
    pub(crate) worker: WorkerLink,
    /// The open video, and what is remembered of it and of others.
    pub(crate) videos: Videos,
    /// Settings and areas, with undo and redo.
    pub(crate) edits: Edits,
    /// Playback, and the marks in the open video.
    pub(crate) playback: Playback,
    /// The chosen pixel, object and event.
    pub(crate) selection: Selection,
    /// What the views show.
    pub(crate) display: Display,
    /// What the panels show.
    pub(crate) panels: PanelState,
    /// What the list of events shows.
    pub(crate) events: EventList,
    /// The ground truth.
    pub(crate) truth: Option<Arc<Truth>>,
    /// The results of another method, compared with ours.
    pub(crate) external: Option<LoadedResults>,
    /// The path of ground truth beside the video, until it is dismissed.
    pub(crate) offered_truth: Option<PathBuf>,
}

impl Model {
    /// A model without an open video.
    pub(crate) fn new(settings: Settings) -> Self {
        Self {
            worker: WorkerLink::new(settings.clone()),
            videos: Videos::new(),
            edits: Edits::new(settings),
            playback: Playback::new(),
            selection: Selection::NONE,
            display: Display::new(),
            panels: PanelState::new(),
            events: EventList::new(),
            truth: None,
            external: None,
            offered_truth: None,
        }
    }

    /// The region of interest of a video that is about to be opened: the one set at start, or the areas drawn over the
    /// same video.
    pub(crate) fn roi_of(&mut self, name: &str) -> Option<Arc<Roi>> {
        let same = self.videos.opened.as_deref() == Some(name) && self.worker.size().is_some();
        if self.videos.opened.is_some() && !same {
            self.edits.forget_areas();
        }
        self.edits.areas.roi.clone()
    }

    /// Replaces the open video by another.
    pub(crate) fn open(&mut self, name: &str, player: Box<dyn Player>) {
        self.worker.open(player, self.edits.settings.clone());
        self.store_marks();
        (self.videos.opened, self.videos.origin) = (Some(name.to_owned()), Origin::New);
        self.videos.read_with = self.videos.options_of(name);
        self.playback.marks = self.videos.stored_marks();
        self.playback.playing = false;
        (self.panels.timeline_span, self.truth, self.events.comparison) = (None, None, None);
        (self.external, self.offered_truth) = (None, None);
        self.selection = Selection::NONE;
        self.display.camera = ViewCamera::FIT;
    }

    /// Closes the video.
    pub(crate) fn close(&mut self) {
        self.store_marks();
        self.worker.close();
        self.playback.marks = Marks::default();
        self.playback.playing = false;
        (self.videos.opened, self.videos.origin) = (None, Origin::New);
        (self.panels.timeline_span, self.truth, self.offered_truth) = (None, None, None);
        self.external = None;
        self.selection = Selection::NONE;
        self.edits.forget_areas();
    }

    /// Stores the marks of the open video under its name.
    pub(crate) fn store_marks(&mut self) {
        self.videos.store_marks(&self.playback.marks);
    }

    /// Video, frame, time and the chosen pixel, in one line.
    pub(crate) fn frame_description(&self) -> Option<String> {
        let shown = self.worker.shown()?;
        let name = self.videos.opened.as_deref().map_or("", file_name);
        let seconds = shown.frame.time;
        let pixel = self.selection.pixel.and_then(|(x, y)| {
            let [r, g, b] = shown.frame.pixel(x, y)?;
            let (x, y) = self.worker.source_pixel((x, y));
            Some(format!(", pixel {x},{y} = {r} {g} {b}"))
        });
        Some(format!("{name}, frame {}, {seconds:.2} s{}", shown.frame.number, pixel.unwrap_or_default()))
    }

    /// Chooses a pixel.
    pub(crate) fn choose_pixel(&mut self, pixel: Option<(u32, u32)>) {
        self.selection.pixel = pixel;
        if let Some(player) = &self.worker.player {
            player.request(Request::Inspect(pixel));
        }
    }

    /// The chosen pixel in the frames of the open video read with `options`; `None` if it is not in them.
    pub(crate) fn pixel_with(&self, options: Options) -> Option<(u32, u32)> {
        let pixel = self.worker.source_pixel(self.selection.pixel?);
        let info = self.worker.state.as_ref()?.info.as_ref()?;
        Placement::new(info.source_size(), options.crop, options.scale)?.frame_pixel(pixel)
    }

    /// Reduces a mask of the source's size like the frames, once their place in the source is known.
    fn fit_mask(&mut self) {
        let Some((placement, mask)) = self.worker.placement().zip(self.edits.areas.mask.as_ref()) else {
            return;
        };
        if mask.mask().size == placement.source()
            && let Ok(mask) = Roi::of_frames(mask, placement.size(), Some(&placement))
        {
            self.edits.areas = Areas::of_mask(Some(mask));
        }
    }

    /// Shows the evidence of an event, or of none.
    pub(crate) fn choose_event(&mut self, event: Option<EventRef>) {
        self.selection.choose_event(&self.worker, event);
    }

    /// Requests the counterfactuals of the event whose evidence is shown, and the histories of the pinned pixels.
    pub(crate) fn request_evidence(&mut self) {
        self.worker.request_counterfactuals(self.selection.event_in_view());
        self.worker.request_pins(self.playback.marks.pins.iter().map(|(_, at)| at).collect());
    }

    /// Whether there are ground-truth masks of the video.
    pub(crate) fn has_true_masks(&self) -> bool {
        let masks = self.truth.as_ref().and_then(|truth| truth.masks.as_ref());
        let size = masks.map(|masks| masks.size());
        let source = self.worker.placement().map(|placement| placement.source());
        size.is_some() && (size == self.worker.size() || size == source)
    }

    /// Offers the ground truth that was found beside a video, if that is still open.
    pub(crate) fn offer_truth(&mut self, name: &str, truth: Option<PathBuf>) {
        if self.videos.opened.as_deref() == Some(name) {
            self.offered_truth = truth;
        }
    }

    /// Sets the ground truth.
    pub(crate) fn set_truth(&mut self, truth: Arc<Truth>) {
        if let Some(player) = &self.worker.player {
            player.request(Request::Truth(Some(Arc::clone(&truth))));
        }
        self.truth = Some(truth);
    }

    /// Sets the results to compare with ours, or none.
    pub(crate) fn set_external(&mut self, results: Option<Arc<ExternalResults>>) {
        if let Some(player) = &self.worker.player {
            player.request(Request::External(results.clone()));
        }
        self.external = results.map(LoadedResults::new);
    }

    /// The boxes of the results to compare with ours, if they have any.
    pub(crate) fn external_boxes(&self) -> Option<&Boxes> {
        self.external.as_ref()?.results.boxes.as_ref()
    }

    /// Sends the settings to the worker.
    pub(crate) fn send_settings(&mut self) {
        self.worker.sent.settings = (self.edits.settings.clone(), self.edits.ab_settings.other.clone());
        // Event indices are invalid under other settings.
        self.choose_event(None);
        self.worker.sent.event = None;
        if let Some(player) = &self.worker.player {
            player.request(Request::Settings {
                in_view: Box::new(self.edits.settings.clone()),
                candidate: self.edits.ab_settings.other.clone().map(Box::new),
            });
        }
    }

    /// Whether the settings differ from those sent last.
    pub(crate) fn has_unsent_settings(&self) -> bool {
        let (settings, other) = &self.worker.sent.settings;
        *settings != self.edits.settings || *other != self.edits.ab_settings.other
    }

    /// Sends the region of interest to the worker.
    pub(crate) fn send_roi(&mut self) {
        // Event indices are invalid after the change.
        self.choose_event(None);
        if let Some(player) = &self.worker.player {
            player.request(Request::Roi(self.edits.areas.roi.clone()));
        }
    }

    /// Zooms all views around the chosen pixel, or around the centre.
    pub(crate) fn zoom_by(&mut self, factor: f32) {
        let size = self.worker.shown().map(|shown| shown.frame.size);
        let around = self.selection.pixel.zip(size).map(|((x, y), size)| {
            [(x as f32 + 0.5) / size.width.max(1) as f32, (y as f32 + 0.5) / size.height.max(1) as f32]
        });
        self.display.camera = self.display.camera.zoomed(factor, around);
    }

    /// Takes the state that the worker published. Returns its new warnings.
    pub(crate) fn take(&mut self) -> Vec<String> {
        let Some(state) = self.worker.player.as_ref().map(|player| player.state()) else { return Vec::new() };
        if let Some((newest, shown)) = self.worker.newest.as_ref().zip(state.shown.as_ref())
            && !Arc::ptr_eq(&newest.shown, shown)
        {
            self.selection.find_object_again(&newest.shown, shown);
        }
        let compared = self.events.comparison.take();
        self.events.comparison = EventComparison::of(&state, self.worker.fps(), compared);
        let is_open = state.info.is_some();
        let mut warnings = self.worker.receive(state);
        if let Some((loaded, timeline)) = self.external.as_mut().zip(self.worker.timeline()) {
            warnings.extend(loaded.check(timeline));
        }
        self.fit_mask();
        self.selection.find_event_again(&self.worker);
        if is_open && self.videos.origin == Origin::New {
            self.videos.remember(self.worker.is_live());
        }
        warnings
    }

    /// Advances playback. Returns the seconds until the next call.
    pub(crate) fn tick(&mut self, now: f64) -> Option<f64> {
        self.playback.advance(&mut self.worker, now)
    }

    /// Chooses an object and shows it in the panel on the right; shows the chosen pixel for none.
    pub(crate) fn choose_object(&mut self, object: Option<Identity>) {
        self.selection.object = object;
        self.selection.subject = if object.is_some() { Subject::Object } else { Subject::Pixel };
    }
}
