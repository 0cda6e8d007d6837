//! The window, driven by its controls and accessible names.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, Key, Modifiers, Theme, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::app::Window;
use crate::app::commands::command::Command;
use crate::app::files::dialogs::DialogResult;
use crate::app::files::settings_file;
use crate::app::golden::looks_as_before;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::player::Player;
use crate::app::model::view::View;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::{PixelRegion, RegionShares};
use crate::explain::tuning::TunableSetting;
use crate::frame::{Frame, Mask, Size};
use crate::mixture::{Parameters, Quantity, QuantityMap};
use crate::occlusion::{Counters, Event, EventKind, Evidence};
use crate::pipeline::Analysis;
use crate::regions::{self, LabelRun, Labels, Rect};
use crate::replay::{Phase, Request, ShownFrame, Start, State, Timeline, TrackTimeline, WorkProgress};
use crate::settings::{SETTINGS, Settings};
use crate::source::{FpsFrom, SourceInfo};
use crate::tracking::{HypothesisSummary, Track, TrackState};
use crate::truth::Truth;
use crate::truth::external::ExternalResults;
use crate::truth::masks::TrueMask;

mod access;
mod altered_state;
mod areas;
mod around;
mod compare;
mod external;
mod inspector;
mod layout;
mod loupe;
mod maps;
mod object;
mod panels;
mod pictures;
mod pixels;
mod random_use;
mod sizes;
mod source_options;
mod sweep;
mod timeline;
mod truth;

const SIZE: Size = Size::new(160, 120);
const FRAMES: u32 = 120;

/// A recorded request to the worker.
#[derive(Clone, Debug, PartialEq)]
enum PlayerCall {
    Show(u32),
    Settings(Box<Settings>),
    Compare(Option<Box<Settings>>),
    Truth(bool),
    External(bool),
    Explain(Option<Box<Event>>),
    Roi(Option<Arc<regions::Roi>>),
    Inspect(Option<(u32, u32)>),
    Tune(Option<[TunableSetting; 2]>),
    Ahead(bool),
    Leave,
    Map(Option<Quantity>),
    Pin(Vec<(u32, u32)>),
    Region(Option<PixelRegion>),
    TuneRegion(Option<PixelRegion>),
}

/// A worker that answers at once and records requests.
#[derive(Clone)]
struct RecordingPlayer {
    state: Rc<RefCell<State>>,
    asked: Rc<RefCell<Vec<PlayerCall>>>,
    truth: Rc<RefCell<Option<Arc<Truth>>>>,
    external: Rc<RefCell<Option<Arc<ExternalResults>>>>,
}

impl Player for RecordingPlayer {
    fn state(&self) -> State {
        self.state.borrow().clone()
    }

    fn request(&self, request: Request) {
        let calls = match &request {
            Request::Show(position) => vec![PlayerCall::Show(*position)],
            Request::Settings { in_view, candidate } => {
                vec![PlayerCall::Settings(in_view.clone()), PlayerCall::Compare(candidate.clone())]
            }
            Request::Roi(roi) => vec![PlayerCall::Roi(roi.clone())],
            Request::Truth(truth) => vec![PlayerCall::Truth(truth.is_some())],
            Request::External(results) => vec![PlayerCall::External(results.is_some())],
            Request::AnalyseAhead(ahead) => vec![PlayerCall::Ahead(*ahead)],
            Request::Inspect(at) => vec![PlayerCall::Inspect(*at)],
            Request::Pin(pixels) => vec![PlayerCall::Pin(pixels.clone())],
            Request::Map(quantity) => vec![PlayerCall::Map(*quantity)],
            Request::CountRegion(region) => vec![PlayerCall::Region(*region)],
            Request::Tune(settings) => vec![PlayerCall::Tune(*settings)],
            Request::TuneRegion(region) => vec![PlayerCall::TuneRegion(*region)],
            Request::Explain(event) => vec![PlayerCall::Explain(event.clone())],
        };
        self.asked.borrow_mut().extend(calls);
        self.answer(request);
    }

    fn leave(self: Box<Self>) {
        self.asked.borrow_mut().push(PlayerCall::Leave);
    }
}

impl RecordingPlayer {
    fn show(&self, position: u32) {
        self.request(Request::Show(position));
    }

    /// Publishes the result of a request, where the tests need it.
    fn answer(&self, request: Request) {
        match request {
            Request::Show(position) => {
                let shown = shown_at(position.min(FRAMES - 1));
                let (map, truth) = (self.asked_map().map(map_of), self.truth_of(&shown));
                let external = self.external_of(&shown);
                self.state.borrow_mut().shown = Some(Arc::new(ShownFrame { map, truth, external, ..shown }));
            }
            Request::Settings { in_view, candidate } => {
                let candidate = candidate.map(|settings| *settings);
                compare::answer(&mut self.state.borrow_mut(), &in_view, candidate);
            }
            Request::Roi(roi) => {
                let mut state = self.state.borrow_mut();
                let shown = state.shown.as_ref().map(|shown| within(shown_at(shown.position), roi));
                state.shown = shown.map(Arc::new);
            }
            Request::Truth(truth) => {
                *self.truth.borrow_mut() = truth;
                let shown = self.state.borrow().shown.clone();
                self.state.borrow_mut().shown = shown.map(|shown| {
                    Arc::new(ShownFrame { truth: self.truth_of(&shown), ..ShownFrame::clone(&shown) })
                });
            }
            Request::External(results) => {
                *self.external.borrow_mut() = results;
                let shown = self.state.borrow().shown.clone();
                self.state.borrow_mut().shown = shown.map(|shown| {
                    Arc::new(ShownFrame { external: self.external_of(&shown), ..ShownFrame::clone(&shown) })
                });
            }
            Request::Map(quantity) => {
                let mut state = self.state.borrow_mut();
                let shown = state.shown.as_deref().cloned();
                state.shown = shown.map(|shown| Arc::new(ShownFrame { map: quantity.map(map_of), ..shown }));
            }
            Request::Pin(pixels) => {
                self.state.borrow_mut().pins = Arc::new(pixels.iter().map(|&at| history_of(at)).collect());
            }
            Request::CountRegion(region) => {
                let shares = |region: PixelRegion| Arc::new(shares_of(region.centre, region.side));
                self.state.borrow_mut().region = region.map(shares);
            }
            Request::AnalyseAhead(_)
            | Request::Inspect(_)
            | Request::Tune(_)
            | Request::TuneRegion(_)
            | Request::Explain(_) => {}
        }
    }

    /// The ground-truth mask of a frame, if any.
    fn truth_of(&self, shown: &ShownFrame) -> Option<Arc<TrueMask>> {
        self.truth.borrow().as_ref()?.masks.as_ref()?.of(shown.frame.number).cloned()
    }

    /// The external mask of a frame, if any.
    fn external_of(&self, shown: &ShownFrame) -> Option<Arc<TrueMask>> {
        self.external.borrow().as_ref()?.mask(shown.frame.number).cloned()
    }

    /// The quantity of the latest request for maps.
    fn asked_map(&self) -> Option<Quantity> {
        let asked = self.asked.borrow();
        let last =
            asked.iter().rev().find_map(|asked| if let PlayerCall::Map(q) = asked { Some(*q) } else { None });
        last.flatten()
    }
}

/// The history of a wall pixel that is occluded at intervals, later for pixels farther right.
fn history_of(at: (u32, u32)) -> Arc<PixelHistory> {
    let colour = |n: u32| {
        let passed = (n + FRAMES - at.0 / 2) % 50 < 9;
        let wall = 60 + (at.0 / 2) as u8 + (n * 37 % 7) as u8;
        if passed { [200, 70, 60] } else { [wall, wall + (at.1 / 2) as u8, 110] }
    };
    let parameters = Parameters::new(&Settings { warm_up: 0, ..Settings::default() });
    Arc::new(PixelHistory::of_colours(at, parameters, (0..FRAMES).map(|n| (n + 1, colour(n)))))
}

fn shares_of(at: (u32, u32), side: u32) -> RegionShares {
    let share = |n: u32| (1.6 * (n as f32 / 14.0).sin() - 0.4).clamp(0.0, 1.0);
    let model = (0..FRAMES).map(|n| (share(n) + if n % 7 == 0 { 0.12 } else { 0.0 }).min(1.0));
    RegionShares {
        at,
        side,
        pixels: side * side,
        model: model.collect(),
        cleaned: (0..FRAMES).map(share).collect(),
    }
}

/// A map whose values increase from left to right, with some special values.
fn map_of(quantity: Quantity) -> Arc<QuantityMap> {
    let value = |at: usize| {
        let (x, y) = (at % 160, at / 160);
        match quantity {
            Quantity::Sigma => 4.0 + x as f32 / 4.0,
            Quantity::Weight => x as f32 / 159.0,
            Quantity::Used | Quantity::BackgroundCount => 1.0 + (x / 40) as f32,
            Quantity::Matched => (x / 20) as f32,
            Quantity::SinceForeground if y < 20 => f32::INFINITY,
            Quantity::SinceForeground => (x * x / 20) as f32,
        }
    };
    Arc::new(QuantityMap { quantity, values: (0..SIZE.pixels()).map(value).collect() })
}

/// The hypotheses of an object at a position: a match and a null match, none while it is occluded.
fn competing([x, y]: [f32; 2], state: TrackState) -> Vec<HypothesisSummary> {
    let each = |centre, probability, matched| HypothesisSummary {
        centre,
        gate: [16.0, 10.0, 0.3],
        fitness: 0.4 * probability,
        probability,
        matched,
    };
    match state {
        TrackState::Hidden => Vec::new(),
        _ => vec![each([x, y], 0.8, true), each([x + 7.0, y - 3.0], 0.2, false)],
    }
}

/// Two people approach each other and cross between frames 50 and 70. A third is occluded from 40 to 90.
fn tracks_at(position: u32) -> Vec<Track> {
    let t = position as f32;
    let merged = (50..70).contains(&position);
    let hidden = (40..90).contains(&position);
    let track = |id: u32, x: f32, y: f32, state, group: &[u32]| {
        let bbox = Rect::around([x, y], 18.0, 40.0);
        Track {
            state,
            bbox,
            centre: [x, y],
            gate: [16.0, 10.0, 0.3],
            hypotheses: competing([x, y], state).into(),
            regions: if state == TrackState::Hidden { vec![] } else { vec![if merged { 1 } else { id }] },
            group: group.to_vec(),
            ..crate::export::tests::track(id, bbox.x, bbox.y)
        }
    };
    let (state, group): (_, &[u32]) =
        if merged { (TrackState::Merged, &[1, 2]) } else { (TrackState::Visible, &[]) };
    let third = if hidden { TrackState::Hidden } else { TrackState::Visible };
    vec![
        track(1, 20.0 + t, 60.0, state, group),
        track(2, 140.0 - t, 66.0, state, group),
        track(3, 120.0, 30.0 + t * 0.2, third, &[]),
    ]
}

fn shown_at(position: u32) -> ShownFrame {
    let tracks = tracks_at(position);
    let mut rgb = Vec::with_capacity(SIZE.pixels() * 3);
    let (mut mask, mut labels) = (Mask::empty(SIZE), Labels::none(SIZE));
    let mut background = Vec::with_capacity(SIZE.pixels() * 3);
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let wall = [(60 + x / 2) as u8, (80 + y / 2) as u8, 110];
            background.extend(wall);
            let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
            let inside = tracks.iter().filter(|track| track.state != TrackState::Hidden).find(|track| {
                let (dx, dy) = ((px - track.centre[0]) / 9.0, (py - track.centre[1]) / 20.0);
                dx * dx + dy * dy < 1.0
            });
            match inside {
                Some(track) => {
                    let at = SIZE.index(x, y).unwrap();
                    mask.data[at] = Mask::FOREGROUND;
                    labels.runs.push(LabelRun { start: at as u32, length: 1, label: track.regions[0] });
                    rgb.extend([[200, 70, 60], [70, 90, 200], [80, 170, 90]][track.id as usize - 1]);
                }
                None => rgb.extend(wall),
            }
        }
    }
    let regions = tracks
        .iter()
        .filter(|track| track.regions == [track.id])
        .map(|track| regions::Region {
            label: track.id,
            shape: regions::Shape {
                area: 565,
                bbox: track.bbox,
                centroid: track.centre,
                ..regions::Shape::default()
            },
            colour: [[200, 70, 60], [70, 90, 200], [80, 170, 90]][track.id as usize - 1],
            histogram: regions::colour::tests::histogram(&[([200, 70, 60], 424), ([70, 90, 200], 141)]),
            mosaic: Arc::default(),
        })
        .collect();
    let time = f64::from(position) / 25.0;
    let frame = Arc::new(Frame::new(position + 1, SIZE, rgb).at_time(time));
    let background = Arc::new(Frame::new(position + 1, SIZE, background));
    ShownFrame {
        position,
        settings: Arc::new(Settings::default()),
        roi: None,
        frame,
        analysis: Arc::new(Analysis {
            number: position + 1,
            time,
            t: position + 1,
            mask: Arc::new(mask),
            labels: Arc::new(labels),
            regions: Arc::new(regions),
            tracks: Arc::new(tracks),
            tentative: Arc::default(),
            objects: Arc::default(),
            events: Arc::default(),
            settled: Arc::default(),
            counters: Counters::default(),
        }),
        background: background.clone(),
        multi_mode: Some(background),
        map: None,
        pixel: None,
        truth: None,
        external: None,
        compared: None,
    }
}

/// The frame as analysed with a region of interest.
fn within(shown: ShownFrame, roi: Option<Arc<regions::Roi>>) -> ShownFrame {
    let Some(roi) = roi else { return shown };
    let mut analysis = Analysis::clone(&shown.analysis);
    roi.clear_outside(Arc::make_mut(&mut analysis.mask));
    Arc::make_mut(&mut analysis.regions).retain(|region| {
        let [x, y] = region.shape.centroid;
        roi.contains(x as u32, y as u32)
    });
    ShownFrame { analysis: Arc::new(analysis), roi: Some(roi), ..shown }
}

/// Number of pixels within a part of the window that differ between two pictures of it.
fn different_pixels(a: &image::RgbaImage, b: &image::RgbaImage, place: egui::Rect) -> usize {
    let pixels = (place.left() as u32..place.right() as u32)
        .flat_map(|x| (place.top() as u32..place.bottom() as u32).map(move |y| (x, y)));
    pixels.filter(|&(x, y)| a.get_pixel(x, y) != b.get_pixel(x, y)).count()
}

fn event(kind: EventKind, frame: u32, objects: &[u32], at: (f32, f32)) -> (u32, Event) {
    let mut evidence =
        Evidence { branch: format!("{} because region 4 grew", kind.name()), ..Evidence::default() };
    evidence.at_least("size change", 0.41, 0.2);
    evidence.note("ΔE of 1 with fragment 2", 12.5);
    let becomes = if kind == EventKind::Demerge { vec![1, 4] } else { objects.to_vec() };
    let (objects, pieces) = (objects.to_vec(), Vec::new());
    let event = Event { frame, kind, objects, becomes, pieces, x: at.0, y: at.1, front: None, evidence };
    (frame - 1, event)
}

fn timeline() -> Timeline {
    use EventKind::{Demerge, Disappear, Enter, Merge, Reappear};
    use TrackState::{Hidden, Merged, Visible};
    let life = |id, spans: &[(u32, u32, TrackState)]| TrackTimeline { id, spans: spans.to_vec() };
    let crossing = [(0, 49, Visible), (50, 69, Merged), (70, 119, Visible)];
    Timeline {
        numbers: (1..=FRAMES).collect(),
        times: (0..FRAMES).map(|position| f64::from(position) / 25.0).collect(),
        complete: true,
        analysed: FRAMES,
        decoded: vec![(0, 30), (50, FRAMES - 1)],
        alignments: Vec::new(),
        foreground_share: (0..FRAMES).map(|n| 0.05 + 0.03 * (n as f32 / 9.0).sin()).collect(),
        events: vec![
            event(Enter, 1, &[1], (20.0, 60.0)),
            event(Enter, 1, &[2], (140.0, 66.0)),
            event(Disappear, 41, &[3], (120.0, 38.0)),
            event(Merge, 51, &[1, 2], (80.0, 62.0)),
            event(Demerge, 71, &[1, 2], (80.0, 62.0)),
            event(Reappear, 91, &[3], (120.0, 48.0)),
        ],
        track_timelines: vec![
            life(1, &crossing),
            life(2, &crossing),
            life(3, &[(0, 39, Visible), (40, 89, Hidden), (90, 119, Visible)]),
        ],
        score: None,
    }
}

fn state(phase: Phase, shown: Option<u32>) -> State {
    State {
        phase,
        info: shown.map(|_| {
            Arc::new(SourceInfo {
                name: "walk.mp4".into(),
                size: SIZE,
                pixel_aspect: None,
                fps: 25.0,
                fps_from: FpsFrom::Video,
                frames: Some(FRAMES),
                live: false,
                reduction: None,
            })
        }),
        shown: shown.map(|position| Arc::new(shown_at(position))),
        timeline: if shown.is_some() { Arc::new(timeline()) } else { Arc::default() },
        ..State::default()
    }
}

/// A window on a scene; without a state nothing is open.
fn window(
    state: Option<State>,
    size: (f32, f32),
    theme: Theme,
) -> (Harness<'static, Window>, RecordingPlayer) {
    window_at(state, size, 1.0, theme)
}

/// A window on a scene, at a scale in screen pixels per point.
fn window_at(
    state: Option<State>,
    size: (f32, f32),
    pixels_per_point: f32,
    theme: Theme,
) -> (Harness<'static, Window>, RecordingPlayer) {
    let asked = Rc::<RefCell<Vec<PlayerCall>>>::default();
    let first = state.clone().unwrap_or_else(|| self::state(Phase::Opening, None));
    let state_of_player = Rc::new(RefCell::new(first));
    let scene =
        RecordingPlayer { state: state_of_player, asked, truth: Rc::default(), external: Rc::default() };
    let player = scene.clone();
    let mut harness = Harness::builder()
        .with_size(vec2(size.0, size.1))
        .with_pixels_per_point(pixels_per_point)
        .with_theme(theme)
        .with_max_steps(20)
        .wgpu()
        .build_eframe(move |creation| {
            creation.egui_ctx.set_theme(theme);
            let opener = move |_: &str,
                               _: crate::source::Options,
                               _: (Settings, Option<Arc<regions::Roi>>),
                               _: Start,
                               _: &egui::Context|
                  -> Box<dyn Player> { Box::new(player.clone()) };
            let gpu = creation.wgpu_render_state.as_ref().unwrap();
            let mut window =
                Window::new(&creation.egui_ctx, gpu, Settings::default(), Box::new(opener)).unwrap();
            if state.is_some() {
                window.apply(&creation.egui_ctx, Command::Open("/videos/walk.mp4".into(), Start::First));
            }
            window
        });
    settle(&mut harness);
    (harness, scene)
}

/// Runs frames until the worker's latest frame is in view.
fn settle(harness: &mut Harness<'_, Window>) {
    let started = Instant::now();
    harness.step();
    while !harness.state().pictures.is_settled() {
        assert!(started.elapsed() < Duration::from_secs(20), "no frame comes into view");
        std::thread::sleep(Duration::from_millis(2));
        harness.step();
    }
    harness.step();
}

/// Draws frames until `found` gives something that a thread prepares.
fn draw_until<T>(harness: &mut Harness<'_, Window>, found: impl Fn(&Harness<'_, Window>) -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        harness.step();
        if let Some(found) = found(harness) {
            return found;
        }
        assert!(started.elapsed() < Duration::from_mins(1), "it does not come");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn ready(position: u32) -> (Harness<'static, Window>, RecordingPlayer) {
    window(Some(state(Phase::Ready, Some(position))), (1600.0, 1000.0), Theme::Dark)
}

fn shows(scene: &RecordingPlayer) -> Vec<u32> {
    let asked = scene.asked.borrow();
    asked
        .iter()
        .filter_map(|asked| if let PlayerCall::Show(position) = asked { Some(*position) } else { None })
        .collect()
}

/// The settings last sent to the worker.
fn given(scene: &RecordingPlayer) -> Option<Settings> {
    let asked = scene.asked.borrow();
    asked
        .iter()
        .rev()
        .find_map(|asked| if let PlayerCall::Settings(s) = asked { Some((**s).clone()) } else { None })
}

/// Checks that the rendered image is not uniform, and writes it to the folder in `OCCLUSCOPE_PICTURES`, if set.
fn picture(harness: &mut Harness<'_, Window>, name: &str) {
    settle(harness);
    let Ok(picture) = harness.render() else { return };
    let first = picture.get_pixel(0, 0);
    assert!(picture.pixels().any(|pixel| pixel != first), "{name} is uniform");
    if let Some(folder) = std::env::var_os("OCCLUSCOPE_PICTURES") {
        picture.save(Path::new(&folder).join(format!("{name}.png"))).unwrap();
    }
}

/// The part of the window with the views.
fn views(harness: &Harness<'_, Window>) -> egui::Rect {
    let slots = &harness.state().model.edits.ab_settings;
    let view = |view: &View| {
        harness.query_by_label(&format!("{} view", view.label(slots))).map(|found| found.rect())
    };
    View::ALL.iter().filter_map(view).reduce(egui::Rect::union).unwrap()
}

/// Checks a part of the window against its golden image.
fn part_looks_as_before(harness: &mut Harness<'_, Window>, part: egui::Rect, name: &str) {
    picture(harness, name);
    harness.state_mut().toasts.hide();
    harness.step();
    let part = part.intersect(harness.ctx.content_rect());
    looks_as_before(&harness.render().unwrap(), Some(part), name);
}

/// Checks the part of the window right of the views against its golden image.
fn right_panel_looks_as_before(harness: &mut Harness<'_, Window>, name: &str) {
    let views = views(harness);
    let corner = egui::pos2(harness.ctx.content_rect().right(), views.bottom());
    part_looks_as_before(harness, egui::Rect::from_two_pos(views.right_top(), corner), name);
}

#[test]
fn buttons_and_keys_request_the_frames_they_name() {
    let (mut harness, scene) = ready(10);
    harness.get_by_label("Next frame").click();
    harness.run_steps(3);
    harness.get_by_label("Previous frame").click();
    harness.run_steps(3);
    assert_eq!(shows(&scene), [11, 10]);
    for (modifiers, key) in [
        (Modifiers::NONE, Key::ArrowRight),
        (Modifiers::NONE, Key::Comma),
        (Modifiers::SHIFT, Key::ArrowRight),
        (Modifiers::SHIFT, Key::ArrowLeft),
        (Modifiers::NONE, Key::End),
        (Modifiers::NONE, Key::Home),
        (Modifiers::COMMAND, Key::ArrowRight),
        (Modifiers::NONE, Key::N),
        (Modifiers::NONE, Key::P),
    ] {
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(3);
    }
    assert_eq!(shows(&scene)[2..], [11, 10, 20, 10, 119, 0, 40, 50, 40]);
}

#[test]
fn playback_requests_consecutive_frames_and_stops_at_the_end() {
    let (mut harness, scene) = ready(115);
    harness.key_press(Key::Space);
    harness.run_steps(60);
    assert_eq!(shows(&scene), [116, 117, 118, 119]);
    harness.get_by_label("Play");
}

#[test]
fn the_space_key_stops_playback() {
    let (mut harness, scene) = ready(10);
    harness.key_press(Key::Space);
    harness.run_steps(12);
    harness.key_press(Key::Space);
    harness.run_steps(3);
    let so_far = shows(&scene);
    assert!(!so_far.is_empty());
    harness.run_steps(30);
    assert_eq!(shows(&scene), so_far);
}

#[test]
fn typing_a_frame_number_goes_to_the_frame_and_triggers_no_shortcut() {
    let (mut harness, scene) = ready(10);
    harness.get_by_role_and_label(egui::Role::SpinButton, "Frame").focus();
    harness.run_steps(2);
    // As shortcuts, 5 would maximise a view and F would fit the image.
    harness.get_by_role_and_label(egui::Role::SpinButton, "Frame").type_text("57");
    harness.run_steps(2);
    assert_eq!(harness.state().model.display.maximised, None);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(shows(&scene).last(), Some(&56));
}

#[test]
fn every_setting_has_a_control_and_sliders_change_them() {
    let (mut harness, scene) = ready(10);
    harness.state_mut().model.panels.settings = true;
    harness.run_steps(2);
    for stage in ["Registration", "Post-processing", "Regions", "Tracking", "Occlusion"] {
        // The regions view has the same name; the settings are left of it.
        let left = |node: &egui_kittest::Node<'_>| node.rect().left() < 60.0;
        let header = harness.get_all_by_label_contains(stage).rfind(left).unwrap();
        header.click_accesskit();
        harness.run_steps(12);
    }
    for setting in SETTINGS {
        let name = setting.label();
        assert!(harness.query_all_by_label(&name).next().is_some(), "{name} has no control");
    }
    harness.get_by_label("background ratio slider").set_value_accesskit(0.9);
    harness.run_steps(8);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(0.9));
    harness.get_by_label("median slider").set_value_accesskit(2.0);
    harness.run_steps(8);
    assert_eq!(given(&scene).map(|settings| settings.median), Some(5));

    harness.get_by_label("Reset background ratio").click();
    harness.run_steps(8);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(Settings::default().t));
}

#[test]
fn settings_can_be_undone_and_redone() {
    let (mut harness, scene) = ready(10);
    harness.get_by_label("background ratio slider").set_value_accesskit(0.9);
    harness.run_steps(8);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(8);
    assert_eq!(given(&scene), Some(Settings::default()));
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(8);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(0.9));
}

#[test]
fn a_click_in_the_event_list_jumps_and_shows_the_evidence() {
    let (mut harness, scene) = ready(10);
    harness.get_by_label("merge 1 + 2, frame 51").click();
    harness.run_steps(4);
    assert_eq!(shows(&scene), [50]);
    harness.get_by_label("Evidence for merge 1 + 2");
    harness.get_by_label("merge because region 4 grew");
    harness.get_by_label("size change");
    // Under other settings another event may have the same index.
    harness.get_by_label("background ratio slider").set_value_accesskit(0.9);
    harness.run_steps(8);
    assert!(harness.query_by_label("Evidence for merge 1 + 2").is_none());
}

#[test]
fn unlisted_kinds_of_events_are_skipped_by_keys() {
    let (mut harness, scene) = ready(10);
    harness.get_by_label("Show disappear events").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("disappear 3, frame 41").is_none());
    harness.key_press(Key::N);
    harness.run_steps(3);
    assert_eq!(shows(&scene), [50]);
}

#[test]
fn a_click_in_a_view_chooses_the_pixel_and_the_wheel_zooms_all_views() {
    let (mut harness, scene) = ready(10);
    let view = harness.get_by_label("Input view").rect();
    harness.get_by_label("Input view").click();
    harness.run_steps(20);
    assert!(matches!(scene.asked.borrow().last(), Some(PlayerCall::Inspect(Some((79..=80, 59..=60))))));
    harness.hover_at(view.center());
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: vec2(0.0, 200.0),
        modifiers: Modifiers::NONE,
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
    });
    harness.run_steps(20);
    assert!(harness.state().model.display.camera.magnification > 1.5);
    harness.key_press(Key::F);
    harness.run_steps(3);
    assert_eq!(harness.state().model.display.camera.magnification, 1.0);
}

#[test]
fn number_keys_maximise_and_restore_a_view() {
    let (mut harness, _) = ready(58);
    harness.key_press(Key::Num5);
    harness.run_steps(3);
    assert_eq!(harness.state().model.display.maximised, Some(View::Tracks));
    assert!(harness.query_by_label("Input view").is_none());
    picture(&mut harness, "tracks-alone");
    harness.key_press(Key::Num4);
    harness.run_steps(3);
    picture(&mut harness, "regions-alone");
    harness.key_press(Key::Num4);
    harness.run_steps(3);
    harness.get_by_label("Input view");
}

#[test]
fn magnified_pixels_show_their_values() {
    let (mut harness, _) = ready(58);
    harness.state_mut().model.display.camera =
        crate::app::model::camera::ViewCamera { magnification: 30.0, centre: [0.5, 0.5] };
    harness.state_mut().model.selection.pixel = Some((80, 60));
    harness.run_steps(3);
    picture(&mut harness, "close-up");
}

#[test]
fn the_palette_finds_an_action_and_help_lists_the_keys() {
    let (mut harness, _) = ready(10);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::K);
    harness.run_steps(4);
    harness.get_by_label("Command palette").type_text("occlusions alone");
    harness.run_steps(3);
    picture(&mut harness, "finder");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().model.display.maximised, Some(View::Tracks));
    harness.key_press(Key::Questionmark);
    harness.run_steps(4);
    assert!(harness.query_by_label("Double click").is_some());
    picture(&mut harness, "help");
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert!(harness.query_by_label("Double click").is_none());
}

#[test]
fn a_and_b_have_separate_settings_and_undo_applies_to_the_edited_slot() {
    let (mut harness, scene) = ready(10);
    assert!(harness.query_by_label("Settings B").is_none());
    harness.get_by_label("background ratio slider").set_value_accesskit(0.8);
    harness.run_steps(8);
    let press = |harness: &mut Harness<'_, Window>, key| {
        harness.key_press(key);
        harness.run_steps(8);
    };
    press(&mut harness, Key::A);
    press(&mut harness, Key::B);
    assert_eq!(harness.state().model.edits.ab_settings.in_view, AbSlot::B);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(0.8), "a copy has equal settings");
    harness.get_by_label("background ratio slider").set_value_accesskit(0.9);
    harness.run_steps(8);
    picture(&mut harness, "slot-b");
    press(&mut harness, Key::A);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(0.8));
    harness.get_by_label("Settings B").click();
    harness.run_steps(8);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(0.9));

    press(&mut harness, Key::A);
    let undo = |harness: &mut Harness<'_, Window>, more| {
        harness.key_press_modifiers(Modifiers::COMMAND | more, Key::Z);
        harness.run_steps(8);
        (harness.state().model.edits.ab_settings.in_view, harness.state().model.edits.settings.t)
    };
    let first = Settings::default().t;
    assert_eq!(undo(&mut harness, Modifiers::NONE), (AbSlot::B, 0.8));
    assert_eq!(undo(&mut harness, Modifiers::NONE), (AbSlot::A, first));
    assert_eq!(given(&scene).map(|settings| settings.t), Some(first));
    assert_eq!(undo(&mut harness, Modifiers::SHIFT), (AbSlot::A, 0.8));
    assert_eq!(undo(&mut harness, Modifiers::SHIFT), (AbSlot::B, 0.9));
    press(&mut harness, Key::A);
    assert_eq!(given(&scene).map(|settings| settings.t), Some(0.8));
}

#[test]
fn a_settings_file_replaces_all_settings_and_an_invalid_file_changes_nothing() {
    let (mut harness, scene) = ready(10);
    let folder = tempfile::tempdir().unwrap();
    let wanted = Settings { k: 6, t: 0.9, ..Settings::default() };
    let path = settings_file::write(folder.path().join("mine"), &wanted).unwrap();
    let load = |harness: &mut Harness<'_, Window>, path: &Path| {
        let answer = settings_file::read(path).map(|settings| (path.to_owned(), Box::new(settings)));
        let ctx = harness.ctx.clone();
        harness.state_mut().handle_result(&ctx, DialogResult::Settings(answer));
        harness.run_steps(8);
    };
    load(&mut harness, &path);
    assert_eq!(given(&scene).as_ref(), Some(&wanted));
    std::fs::write(&path, "k = 4\nt = 7").unwrap();
    load(&mut harness, &path);
    assert_eq!(given(&scene).as_ref(), Some(&wanted));
    assert_eq!(harness.state().model.edits.settings, wanted);
    picture(&mut harness, "bad-settings-file");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(8);
    assert_eq!(given(&scene), Some(Settings::default()));
}
