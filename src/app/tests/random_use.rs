//! Random use of the window on a real session: no panic, and in every rest the frame in view is that of a single pass
//! under the settings in view.
//!
//! `OCCLUSCOPE_LONG=1` uses it for ten minutes, which seeds are printed; `OCCLUSCOPE_SEED` repeats one of them.

use std::cell::Cell;
use std::path::PathBuf;

use eframe::egui::{Event, MouseWheelUnit, PointerButton, Pos2, TouchPhase, Vec2, pos2};
use rand::seq::IndexedRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg32;
use tempfile::TempDir;

use super::truth::Dropped;
use super::*;
use crate::app::commands::action::Action;
use crate::app::commands::actions::ACTIONS;
use crate::app::model::edits::Edits;
use crate::app::model::undo_history::Direction;
use crate::replay::tests as replay;
use crate::replay::{AnalysisOptions, Session};
use crate::source::Options;

/// Memory for frames and models, in bytes: little, so that frames are evicted and models replayed.
const MEMORY: usize = 1 << 20;
/// The number of random inputs between two rests.
const BURST: u32 = 40;
const BUTTONS: [PointerButton; 3] = [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];
/// The longest time in which the window has to come to rest.
const REST: Duration = Duration::from_mins(1);

/// The window, and how the open video is read.
struct RandomUse {
    harness: Harness<'static, Window>,
    random: Pcg32,
    /// The last name and options that the window opened.
    opened: Rc<RefCell<(String, Options)>>,
    files: Files,
    pressed: Vec<(Key, Modifiers)>,
    pointer: Pos2,
    /// The longest time of this thread in a frame of the window.
    slowest: Rc<Cell<Duration>>,
}

/// Files that are dropped on the window.
struct Files {
    _folder: TempDir,
    scene: TempDir,
    dropped: Vec<PathBuf>,
}

impl Files {
    fn new() -> Self {
        let (folder, scene) = (tempfile::tempdir().unwrap(), replay::scene());
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("broken.mp4"), b"this is no video").unwrap();
        std::fs::write(at("gt.txt"), "110,1,20,20,30,50,1,1,1\n112,1,22,20,30,50,1,1,1\n").unwrap();
        std::fs::write(at("broken.csv"), "a,b\n1").unwrap();
        std::fs::create_dir(at("empty")).unwrap();
        let dropped = ["broken.mp4", "gt.txt", "broken.csv", "empty", "missing.avi"].map(at);
        let dropped = dropped.into_iter().chain([scene.path().to_owned()]).collect();
        Self { _folder: folder, scene, dropped }
    }
}

impl RandomUse {
    fn new(seed: u64) -> Self {
        let files = Files::new();
        let opened = Rc::<RefCell<(String, Options)>>::default();
        let factory_opened = Rc::clone(&opened);
        let name = replay::name(files.scene.path());
        let harness =
            Harness::builder().with_size(vec2(1280.0, 800.0)).with_max_steps(20).wgpu().build_eframe(
                move |creation| {
                    let open = move |name: &str,
                                     options: Options,
                                     (settings, roi): (Settings, Option<Arc<regions::Roi>>),
                                     start: Start,
                                     ctx: &egui::Context|
                          -> Box<dyn Player> {
                        *factory_opened.borrow_mut() = (name.to_owned(), options);
                        let (ctx, analysis) = (ctx.clone(), AnalysisOptions { settings, roi });
                        Box::new(Session::open(name, options, analysis, start, Some(MEMORY), move || {
                            ctx.request_repaint();
                        }))
                    };
                    let gpu = creation.wgpu_render_state.as_ref().unwrap();
                    let mut window =
                        Window::new(&creation.egui_ctx, gpu, replay::settings(), Box::new(open)).unwrap();
                    window.dialogs.refuse();
                    window.apply(&creation.egui_ctx, Command::Open(name, Start::First));
                    window
                },
            );
        Self {
            harness,
            random: Pcg32::seed_from_u64(seed),
            opened,
            files,
            pressed: Vec::new(),
            pointer: Pos2::ZERO,
            slowest: Rc::default(),
        }
    }

    /// One random input, and a frame of the window.
    fn act(&mut self) {
        match self.random.random_range(0..100) {
            0..30 => self.click_control(),
            30..45 => self.press_key(),
            45..65 => self.move_pointer(),
            65..75 => self.press_or_release(),
            75..82 => self.scroll(),
            82..88 => self.type_text(),
            88..91 => self.resize(),
            91..93 => self.drop_file(),
            93..97 => self.change_setting(),
            _ => self.call_action(),
        }
        self.step();
    }

    fn step(&mut self) {
        let before = thread_time();
        self.harness.step();
        let took = thread_time().saturating_sub(before);
        self.slowest.set(self.slowest.get().max(took));
    }

    fn somewhere(&mut self) -> Pos2 {
        let size = self.harness.ctx.content_rect().size();
        pos2(self.random.random_range(0.0..size.x), self.random.random_range(0.0..size.y))
    }

    fn point_at(&mut self, at: Pos2) {
        self.pointer = at;
        self.harness.event(Event::PointerMoved(at));
    }

    fn click_control(&mut self) {
        let controls: Vec<_> = {
            let root = self.harness.root();
            let all = root.query_all_by(|node| {
                let is_control = !matches!(node.role(), egui::Role::Label | egui::Role::Unknown);
                is_control && node.bounding_box().is_some()
            });
            all.map(|node| node.rect().center()).collect()
        };
        let Some(&at) = controls.choose(&mut self.random) else { return };
        let button =
            if self.random.random_bool(0.9) { PointerButton::Primary } else { PointerButton::Secondary };
        self.point_at(at);
        self.step();
        self.button(button, true);
        self.button(button, false);
    }

    fn button(&mut self, button: PointerButton, pressed: bool) {
        let modifiers = Modifiers::NONE;
        self.harness.event(Event::PointerButton { pos: self.pointer, button, pressed, modifiers });
        self.step();
    }

    fn press_or_release(&mut self) {
        let button = *BUTTONS.choose(&mut self.random).unwrap();
        self.button(button, !self.is_down(button));
    }

    fn is_down(&self, button: PointerButton) -> bool {
        self.harness.ctx.input(|input| input.pointer.button_down(button))
    }

    fn move_pointer(&mut self) {
        let at = if self.random.random_bool(0.5) {
            self.somewhere()
        } else {
            let near = -20.0..20.0;
            self.pointer + Vec2::new(self.random.random_range(near.clone()), self.random.random_range(near))
        };
        self.point_at(at);
    }

    fn scroll(&mut self) {
        let delta = Vec2::new(self.random.random_range(-60.0..60.0), self.random.random_range(-200.0..200.0));
        let modifiers =
            *[Modifiers::NONE, Modifiers::COMMAND, Modifiers::SHIFT].choose(&mut self.random).unwrap();
        let (unit, phase) = (MouseWheelUnit::Point, TouchPhase::Move);
        self.harness.event(Event::MouseWheel {
            unit,
            delta,
            phase,
            source: egui::MouseWheelSource::Unknown,
            modifiers,
        });
    }

    fn press_key(&mut self) {
        let modifiers = match self.random.random_range(0..10) {
            0 => Modifiers::COMMAND,
            1 => Modifiers::SHIFT,
            2 => Modifiers::COMMAND | Modifiers::SHIFT,
            3 => Modifiers::ALT,
            _ => Modifiers::NONE,
        };
        let key = *Key::ALL.choose(&mut self.random).unwrap();
        self.harness.event_modifiers(key_event(key, true, modifiers), modifiers);
        if self.random.random_bool(0.8) {
            self.harness.event_modifiers(key_event(key, false, modifiers), modifiers);
        } else {
            self.pressed.push((key, modifiers));
        }
    }

    fn type_text(&mut self) {
        let texts = ["7", "0", "-", ".", "1e9", "NaN", "merge", "µ", "9999999999", " "];
        self.harness.event(Event::Text((*texts.choose(&mut self.random).unwrap()).to_owned()));
    }

    fn resize(&mut self) {
        let size = Vec2::new(self.random.random_range(1.0..2200.0), self.random.random_range(1.0..1400.0));
        // The least size of the window, though not every system keeps to it.
        let size = if self.random.random_bool(0.8) { size.max(vec2(800.0, 560.0)) } else { size };
        self.harness.set_size(size);
    }

    fn drop_file(&mut self) {
        let path = self.files.dropped.choose(&mut self.random).unwrap().clone();
        self.harness.input_mut().dropped_files.push(Arc::new(Dropped(path)));
    }

    fn change_setting(&mut self) {
        let setting = SETTINGS.choose(&mut self.random).unwrap();
        let text =
            ["0", "1", "2", "0.05", "off", "on", "none", "12", "0.9"].choose(&mut self.random).unwrap();
        // Most texts are no value of most settings.
        let _ = self.harness.state_mut().model.edits.settings.set(setting.name, text);
    }

    fn call_action(&mut self) {
        let ctx = self.harness.ctx.clone();
        let action = ACTIONS.choose(&mut self.random).unwrap().action;
        // The bundled sample takes seconds to analyse.
        if action != Action::OpenSample {
            self.harness.state_mut().apply(&ctx, Command::Act(action));
        }
    }

    /// Releases everything, stops playback, closes dialogs and opens the scene again if it is not open.
    fn let_go(&mut self) {
        for button in BUTTONS {
            if self.is_down(button) {
                self.button(button, false);
            }
        }
        for (key, modifiers) in std::mem::take(&mut self.pressed) {
            self.harness.event_modifiers(key_event(key, false, modifiers), modifiers);
        }
        self.step();
        for _ in 0..4 {
            self.harness.key_press(Key::Escape);
            self.step();
        }
        self.harness.set_size(vec2(1280.0, 800.0));
        let scene = replay::name(self.files.scene.path());
        let (ctx, window) = (self.harness.ctx.clone(), self.harness.state_mut());
        window.model.playback.playing = false;
        window.model.edits.held_slot = None;
        let is_failed = window.model.worker.failure().is_some();
        if window.model.videos.opened.as_ref() != Some(&scene) || is_failed {
            window.apply(&ctx, Command::Open(scene, Start::First));
        }
        self.step();
    }

    /// Waits until the frame in view is that of the settings in view, and compares it with a single pass.
    fn rest(&mut self) {
        self.let_go();
        let started = Instant::now();
        while !self.is_at_rest() {
            let window = self.harness.state();
            let state = window.model.worker.state.as_ref();
            assert!(
                started.elapsed() < REST,
                "no rest: {:?}, {:?}, {:?}, {:?}",
                state.map(|state| &state.phase),
                state.map(|state| &state.busy),
                window.model.worker.requested_position,
                state.and_then(|state| state.shown.as_ref()).map(|shown| shown.position),
            );
            std::thread::sleep(Duration::from_millis(2));
            self.step();
        }
        let in_view = Arc::clone(self.harness.state().model.worker.in_view.as_ref().unwrap());
        let options = self.opened.borrow().1;
        let shown = &in_view.shown;
        let expected =
            replay::single_pass_of(self.files.scene.path(), &options, &shown.settings, shown.roi.as_ref());
        let mut expected_frame = expected[shown.position as usize].clone();
        let background = shown.background.number;
        if expected_frame.multi_mode.is_none() && background != shown.frame.number {
            // Of MOG2 and KNN the nearest stored image is shown, under the number of its frame.
            let stored = expected.iter().find(|it| it.frame.number == background).unwrap();
            expected_frame.background = Arc::clone(&stored.background);
        }
        replay::assert_same(shown, &expected_frame);
        self.undo_and_redo_everything();
    }

    fn is_at_rest(&self) -> bool {
        let window = self.harness.state();
        let (worker, edits) = (&window.model.worker, &window.model.edits);
        let (Some(state), Some(in_view)) = (&worker.state, &worker.in_view) else { return false };
        let is_shown = *in_view.shown.settings == edits.settings && in_view.shown.roi == edits.areas.roi;
        let is_newest = state.shown.as_ref().is_some_and(|shown| Arc::ptr_eq(shown, &in_view.shown));
        is_shown
            && is_newest
            && state.phase == Phase::Ready
            && worker.requested_position.is_none()
            && window.pictures.is_settled()
    }

    /// All edits undone and made again give the same settings and areas.
    fn undo_and_redo_everything(&mut self) {
        let mut edits = self.harness.state().model.edits.clone();
        while edits.history.can_redo() {
            edits.step(Direction::Redo);
        }
        let last = slots(&edits);
        while edits.history.can_undo() {
            edits.step(Direction::Undo);
        }
        while edits.history.can_redo() {
            edits.step(Direction::Redo);
        }
        assert_eq!(slots(&edits), last);
    }
}

/// The settings of both slots, and the region of interest. Which slot is in view is no edit.
fn slots(edits: &Edits) -> ([Option<Settings>; 2], Option<Arc<regions::Roi>>) {
    let (in_view, other) = (Some(edits.settings.clone()), edits.ab_settings.other.clone());
    let settings = match edits.ab_settings.in_view {
        AbSlot::A => [in_view, other],
        AbSlot::B => [other, in_view],
    };
    (settings, edits.areas.roi.clone())
}

fn key_event(key: Key, pressed: bool, modifiers: Modifiers) -> Event {
    Event::Key { key, physical_key: None, pressed, repeat: false, modifiers }
}

/// What this thread worked so far, apart from what it waited.
fn thread_time() -> Duration {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
    }
    #[cfg(not(unix))]
    {
        Duration::ZERO
    }
}

fn use_for(seed: u64, bursts: u32) -> Duration {
    let mut random_use = RandomUse::new(seed);
    for _ in 0..bursts {
        for _ in 0..BURST {
            random_use.act();
        }
        random_use.rest();
    }
    random_use.slowest.get()
}

#[test]
fn random_use_ends_in_the_state_of_a_single_pass() {
    if let Ok(seed) = std::env::var("OCCLUSCOPE_SEED") {
        use_for(seed.parse().unwrap(), 12);
    } else if std::env::var_os("OCCLUSCOPE_LONG").is_some() {
        let started = Instant::now();
        for seed in 1.. {
            if started.elapsed() > Duration::from_mins(10) {
                break;
            }
            let slowest = use_for(seed, 12);
            println!("seed {seed}: the slowest frame took {slowest:?} of this thread");
        }
    } else {
        use_for(1, 6);
    }
}
