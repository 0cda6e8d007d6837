//! The window.
//!
//! `model` is the window's state. `views`, `inspector` and `panels` show it and return commands; `commands` is the
//! table of everything that has a name or a shortcut, and executes them. `files` reads and writes files.

mod commands;
mod files;
mod icons;
pub mod inspector;
mod model;
mod panels;
mod views;

pub mod theme;

#[cfg(test)]
mod golden;
#[cfg(test)]
mod measure;
#[cfg(test)]
mod tests;

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, CentralPanel, Context, Frame, Id, Margin, Memory, Panel, Ui, vec2};
use eframe::egui_wgpu::RenderState;

use self::inspector::{Inspector, InspectorAction, InspectorContext, RegionAccuracy};
use self::views::{Layout, Pictures, View};
use crate::app::commands::command::{Action, Command};
use crate::app::files::dialogs::{DialogResult, Dialogs};
use crate::app::model::areas::{AreaEdit, Areas};
use crate::app::model::persisted_state::PersistedState;
use crate::app::model::{Model, Opener, Subject};
use crate::app::panels::about::About;
use crate::app::panels::command_palette::CommandPalette;
use crate::app::panels::status::FrameTiming;
use crate::app::panels::toasts::Toasts;
use crate::regions::Roi;
use crate::replay::{Request, Session, Start};
use crate::settings::Settings;
use crate::source::Options;
use crate::truth::Truth;

/// The program's icon.
const ICON: &[u8] = include_bytes!("../../assets/occluscope.png");

/// Minimum interval between settings sent to the worker while a slider is dragged.
const SETTLE: Duration = Duration::from_millis(60);

/// The initial state of the window.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    /// The video; `None` for the bundled sample at its first occlusion.
    pub video: Option<String>,
    /// The options of that video.
    pub options: Options,
    /// The initial settings.
    pub settings: Settings,
    /// The region of interest; `None` for the whole image.
    pub roi: Option<Arc<Roi>>,
    /// The path of the ground truth.
    pub truth: Option<PathBuf>,
    /// The memory limit for videos in bytes; `None` for a quarter of the machine's memory.
    pub memory: Option<usize>,
}

/// Opens the window and returns when it is closed.
/// Fails with a sentence when there is no display or no graphics adapter.
pub fn run(opening: Opening) -> anyhow::Result<()> {
    let Opening { video, options: of_video, settings, roi, truth, memory } = opening;
    let viewport = egui::ViewportBuilder::default()
        .with_title("Occluscope")
        .with_app_id("occluscope")
        .with_icon(eframe::icon_data::from_png_bytes(ICON).unwrap_or_default())
        .with_inner_size(vec2(1600.0, 1000.0))
        .with_min_inner_size(vec2(800.0, 560.0));
    let options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    let first = match video {
        Some(video) => Command::Open(video, Start::First),
        None => Command::OpenSample,
    };
    let create = move |creation: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        let gpu = creation.wgpu_render_state.as_ref().ok_or("no graphics adapter")?;
        let mut window = Window::new(&creation.egui_ctx, gpu, settings, open_sessions(memory))?;
        window.restore(&creation.egui_ctx, creation.storage);
        window.model.areas = Areas::of_mask(roi);
        if let (Command::Open(name, _), Some(fps)) = (&first, of_video.fps) {
            window.model.told_rate = Some((name.clone(), fps));
        }
        window.apply(&creation.egui_ctx, first);
        if let Some(truth) = truth {
            window.apply(&creation.egui_ctx, Command::ReadTruth(truth));
        }
        Ok(Box::new(window))
    };
    eframe::run_native("occluscope", options, Box::new(create)).map_err(|error| explain(&error))
}

/// An opener of sessions that stay within a memory limit in bytes.
fn open_sessions(memory: Option<usize>) -> Opener {
    Box::new(move |name, options, under, start, ctx| {
        let ctx = ctx.clone();
        Box::new(Session::open(name, options, under, start, memory, move || ctx.request_repaint()))
    })
}

/// The reason why the window cannot open, in one line. The libraries' messages name their source files.
fn explain(error: &eframe::Error) -> anyhow::Error {
    match error {
        eframe::Error::Wgpu(_) => anyhow::anyhow!(
            "the window cannot be opened: no usable graphics adapter; install a Vulkan or OpenGL driver \
             (mesa-vulkan-drivers works without a graphics card), or use a command that needs no window"
        ),
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => anyhow::anyhow!(
            "the window cannot be opened: no display is reachable; check DISPLAY or WAYLAND_DISPLAY, or \
             use a command that needs no window"
        ),
        other @ eframe::Error::AppCreation(_) => {
            anyhow::anyhow!("the window cannot be opened: {}", other.to_string().replace('\n', " "))
        }
    }
}

/// The window: the [`Model`], and the state of panels, views and dialogs.
struct Window {
    model: Model,
    tree: egui_tiles::Tree<View>,
    /// Points per pixel of the fitted image: in the view under the pointer, or the largest view.
    fitted: Option<f32>,
    pictures: Pictures,
    toasts: Toasts,
    dialogs: Dialogs,
    command_palette: CommandPalette,
    help: bool,
    about: About,
    opener: Opener,
    inspector: Inspector,
    sent_at: Option<Instant>,
    light: bool,
    /// Whether the failure of the drawing thread has been reported.
    lost: bool,
    /// The number of further frames in which a dialog keeps the focus.
    under_sheet: u8,
    /// The control that had the focus before the dialog.
    focused: Option<Id>,
    /// This thread's time for the previous frame, in seconds.
    worked: Option<f32>,
}

impl Window {
    /// A window without an open video. Fails if a thread cannot be started.
    fn new(ctx: &Context, gpu: &RenderState, settings: Settings, opener: Opener) -> io::Result<Self> {
        theme::install(ctx);
        Ok(Self {
            model: Model::new(settings),
            tree: Layout::All.tree(),
            fitted: None,
            pictures: Pictures::start(ctx, gpu)?,
            toasts: Toasts::default(),
            dialogs: Dialogs::default(),
            command_palette: CommandPalette::default(),
            help: false,
            about: About::on(&gpu.adapter.get_info()),
            opener,
            inspector: Inspector::default(),
            sent_at: None,
            light: false,
            lost: false,
            under_sheet: 0,
            focused: None,
            worked: None,
        })
    }

    /// Restores the persisted state. Unreadable parts have their initial values.
    fn restore(&mut self, ctx: &Context, storage: Option<&dyn eframe::Storage>) {
        let layout: Option<egui_tiles::Tree<View>> =
            storage.and_then(|storage| eframe::get_value(storage, LAYOUT));
        if let Some(tree) =
            layout.filter(|tree| View::ALL.iter().all(|view| tree.tiles.find_pane(view).is_some()))
        {
            self.tree = tree;
        }
        PersistedState::read(storage).restore(ctx, &mut self.model);
    }

    /// Takes new results of the worker, the dialogs and the clock. Draws nothing.
    fn advance(&mut self, ctx: &Context) {
        let failed = self.model.failure().is_some();
        for warning in self.model.take() {
            self.toasts.warn(ctx, warning);
        }
        if let Some(why) = self.model.failure().filter(|_| !failed) {
            self.toasts.note_failure(ctx, why);
        }
        self.ask_for_pictures();
        if self.pictures.turn() {
            self.model.in_view = self.pictures.in_view().map(|set| Arc::clone(set.moment()));
        }
        if self.pictures.is_dead() && !self.lost {
            self.lost = true;
            self.toasts.fail(ctx, "The graphics card accepts no more images; restart the program");
        }
        if let Some(answer) = self.dialogs.answer() {
            self.answered(ctx, answer);
        }
        if let Some(wait) = self.model.tick(ctx.input(|input| input.time)) {
            ctx.request_repaint_after(Duration::from_secs_f64(wait.clamp(0.0, 1.0)));
        }
    }

    fn ask_for_pictures(&mut self) {
        if let Some(newest) = &self.model.newest {
            self.pictures.ask(newest);
        }
    }

    /// Handles the result of a dialog.
    fn answered(&mut self, ctx: &Context, answer: DialogResult) {
        match answer {
            DialogResult::Open(path) => {
                self.apply(ctx, Command::Open(path.to_string_lossy().into_owned(), Start::First));
            }
            DialogResult::Drawn(Ok(picture)) => {
                ctx.copy_image(picture);
                self.toasts.done(ctx, "Copied the plot as an image");
            }
            DialogResult::Wrote(Ok(path)) => self.toasts.done(ctx, format!("Wrote {}", path.display())),
            DialogResult::Settings(Ok((path, settings))) => {
                self.apply(ctx, Command::Set(settings));
                self.toasts.done(ctx, format!("Settings of {}", path.display()));
            }
            DialogResult::Mask(Ok(mask)) => self.change_areas(ctx, AreaEdit::Load(mask)),
            DialogResult::Truth(Ok(truth)) => self.take_truth(ctx, truth),
            DialogResult::NoDialog => self.toasts.fail(
                ctx,
                "No file dialog available; install xdg-desktop-portal or zenity, drop a video on the \
                 window, or pass it on the command line",
            ),
            DialogResult::Tabled(Ok((text, rows))) => {
                ctx.copy_text(text);
                self.toasts.done(ctx, format!("Copied {rows} rows as CSV"));
            }
            DialogResult::Drawn(Err(why))
            | DialogResult::Tabled(Err(why))
            | DialogResult::Wrote(Err(why))
            | DialogResult::Settings(Err(why))
            | DialogResult::Mask(Err(why))
            | DialogResult::Truth(Err(why)) => {
                self.toasts.fail(ctx, why);
            }
        }
    }

    /// Sets the ground truth, shows a message about it, and opens the mask-error view if it has masks.
    fn take_truth(&mut self, ctx: &Context, truth: Arc<Truth>) {
        let boxes = truth
            .boxes
            .as_ref()
            .map(|boxes| format!("boxes of {} frames, shown over the tracks", boxes.len()));
        let masks = truth
            .masks
            .as_ref()
            .map(|masks| format!("masks of {} frames, shown in Mask errors", masks.frames()));
        let told: Vec<String> = boxes.into_iter().chain(masks).collect();
        if truth.masks.is_some() {
            views::set_open(&mut self.tree, View::MaskErrors, true);
        }
        self.model.take_truth(truth);
        self.toasts.done(ctx, format!("Ground truth: {}", told.join("; ")));
    }

    /// Sends the latest settings to the worker, and records them for undo once they stop changing.
    fn send_settings(&mut self, ctx: &Context) {
        let busy = ctx.input(|input| input.pointer.any_down()) || ctx.text_edit_focused();
        if !busy {
            self.model.history.note(&self.model.settings);
        }
        let (settings, beside) = &self.model.sent;
        if *settings == self.model.settings && *beside == self.model.ab_settings.other {
            return;
        }
        let waited = self.sent_at.is_none_or(|at| at.elapsed() >= SETTLE);
        if busy && !waited {
            ctx.request_repaint_after(SETTLE);
            return;
        }
        self.sent_at = Some(Instant::now());
        self.model.sent = (self.model.settings.clone(), self.model.ab_settings.other.clone());
        // Event indices are invalid under other settings.
        self.model.read(None);
        self.model.explained = None;
        if let Some(player) = &self.model.player {
            player.request(Request::Settings {
                in_view: Box::new(self.model.settings.clone()),
                candidate: self.model.ab_settings.other.clone().map(Box::new),
            });
        }
    }

    fn panels(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let model = &self.model;
        let pace = FrameTiming {
            worked: self.worked,
            pictures: self.pictures.in_view().map(|set| (set.took(), set.bytes())),
        };
        let bar = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 4));
        Panel::top("menus").frame(bar).show(ui, |ui| crate::app::panels::top_bar::ui(ui, model, commands));
        let bar = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 0));
        Panel::bottom("status")
            .frame(bar)
            .exact_size(theme::ROW)
            .show(ui, |ui| crate::app::panels::status::ui(ui, model, pace, commands));
        let screen = ui.ctx().content_rect().size();
        if model.shown().is_some() {
            let bar = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 6));
            Panel::bottom("timeline")
                .frame(bar)
                .resizable(true)
                .default_size((screen.y * 0.09).clamp(100.0, 180.0))
                .size_range((screen.y * 0.055).max(84.0)..=(screen.y * 0.32).max(84.0))
                .show(ui, |ui| {
                    ui.horizontal_top(|ui| {
                        ui.vertical(|ui| {
                            ui.set_width(TRANSPORT);
                            ui.horizontal(|ui| crate::app::panels::transport::buttons(ui, model, commands));
                            ui.add_space(theme::SPACE);
                            ui.horizontal(|ui| crate::app::panels::transport::place(ui, model, commands));
                        });
                        crate::app::panels::timeline::ui(ui, model, commands);
                    });
                });
        }
        let wide = screen.x;
        let side = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 8));
        if model.settings_panel {
            let size = (wide * 0.165).clamp(244.0, 360.0);
            let panel = Panel::left("settings").frame(side).resizable(true).default_size(size);
            // Panel sizes persist across windows of other sizes: the views must keep most of a smaller window, and
            // nothing may be lost in a larger one.
            panel
                .size_range((wide * 0.09).max(236.0)..=(wide * 0.3).max(236.0))
                .show(ui, |ui| crate::app::panels::settings_panel::ui(ui, model, commands));
        }
        if model.inspector_panel && model.shown().is_some() {
            let size = (wide * 0.235).clamp(232.0, 720.0);
            let panel = Panel::right("inspector").frame(side).resizable(true).default_size(size);
            let inspector = &mut self.inspector;
            let most = (wide * 0.36).min(ui.available_width() - VIEWS).max(220.0);
            panel.size_range((wide * 0.13).clamp(220.0, most)..=most).show(ui, |ui| {
                let third = ui.available_height() * 0.36;
                // The height of the list persists across windows; in a lower one, the pixel's plots must stay
                // readable.
                let least = if model.reading.is_some() { EVIDENCE } else { EVENTS };
                let most = (ui.available_height() - INSPECTED).clamp(least, 1.4 * third.max(least));
                let below = Frame::NONE.inner_margin(Margin { top: 8, ..Margin::ZERO });
                let list = Panel::bottom("events")
                    .frame(below)
                    .resizable(true)
                    .default_size(third.clamp(least, most));
                list.size_range((0.5 * third).clamp(least, most)..=most).show(ui, |ui| {
                    crate::app::panels::events_panel::ui(ui, model, commands);
                    // A panel shrinks to its content: a short list must not shrink it.
                    ui.take_available_space();
                });
                crate::app::panels::object_panel::choice(ui, model, commands);
                if model.subject == Subject::Object {
                    crate::app::panels::object_panel::ui(ui, model, commands);
                    return;
                }
                let slot = model.ab_settings.in_view;
                inspector.names = [slot.name(), slot.other().name()];
                let pins: Vec<_> = model.marks.pins.iter().collect();
                let state = model.state.as_ref();
                let context = InspectorContext {
                    chosen: model.chosen,
                    pins: &pins,
                    histories: state.map_or(&[], |state| &state.pins),
                    lost: state.map_or(&[], |state| &state.lost),
                    progress: state.and_then(|state| state.pixel_progress.as_ref()),
                    region: model.region_shares(),
                    judged: RegionAccuracy {
                        has_masks: model.has_true_masks(),
                        tuning: model.region_tuning(),
                    },
                };
                let (shown, newest, tuning) = (model.shown(), model.pixel(), model.tuning());
                let action = inspector.ui(ui, shown, newest, tuning, model.fps(), &context);
                match action {
                    Some(InspectorAction::GoTo(position)) => commands.push(Command::GoTo(position)),
                    Some(InspectorAction::Take(values)) => {
                        let mut settings = model.settings.clone();
                        // The map covers only values that the setting accepts.
                        if values.iter().all(|&(knob, value)| knob.set(&mut settings, value).is_ok()) {
                            commands.push(Command::Set(Box::new(settings)));
                        }
                    }
                    Some(InspectorAction::Choose(at)) => commands.push(Command::Choose(Some(at))),
                    Some(InspectorAction::Pin) => commands.push(Command::Act(Action::Pin)),
                    Some(InspectorAction::LoadTruth) => {
                        commands.push(Command::Act(Action::LoadTruthFolder));
                    }
                    Some(InspectorAction::Unpin(number)) => commands.push(Command::Unpin(number)),
                    Some(InspectorAction::Copy(table)) => commands.push(Command::CopyTable(table)),
                    Some(InspectorAction::Save(table)) => commands.push(Command::SaveTable(table)),
                    Some(InspectorAction::CopyPicture(plot)) => commands.push(Command::CopyPlot(plot)),
                    Some(InspectorAction::SavePicture(plot, format)) => {
                        commands.push(Command::SavePlot(plot, format));
                    }
                    None => {}
                }
            });
        }
        let (tree, pictures, fitted) = (&mut self.tree, &mut self.pictures, &mut self.fitted);
        CentralPanel::no_frame().show(ui, |ui| {
            if model.shown().is_some() {
                crate::app::panels::welcome::stopped(ui, model, commands);
                crate::app::panels::welcome::hint(ui, model, commands);
                *fitted = views::show(ui, tree, pictures, model, commands);
            } else {
                crate::app::panels::welcome::ui(ui, model, commands);
            }
        });
    }
}

/// Width of the transport buttons left of the timeline.
const TRANSPORT: f32 = 244.0;
/// Minimum width of the views, in points: below it, titles and buttons would overlap the panel beside them.
const VIEWS: f32 = 296.0;
/// Minimum height of the events panel: heading, filters, and two rows.
const EVENTS: f32 = 112.0;
/// Minimum height of the events panel with the evidence of an event, down to its first numbers.
const EVIDENCE: f32 = 236.0;
/// Minimum height of the inspector in a low window.
const INSPECTED: f32 = 330.0;
/// The storage key of the views' layout.
const LAYOUT: &str = "layout";

impl eframe::App for Window {
    fn logic(&mut self, ctx: &Context, _frame: &mut eframe::Frame) {
        self.advance(ctx);
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.worked = frame.info().cpu_usage;
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, LAYOUT, &self.tree);
        self.model.put_marks_away();
        PersistedState::of(&self.model, self.light).write(storage);
    }
}

impl Window {
    /// Whether a dialog is open over the window and takes all keys.
    const fn has_sheet(&self) -> bool {
        self.help || self.about.open || self.command_palette.is_open()
    }

    /// Restores the focus once no dialog is open. Controls under a dialog get no focus until one frame after it is
    /// closed.
    fn give_focus_back(&mut self, ctx: &Context) {
        if self.has_sheet() {
            self.under_sheet = 2;
            return;
        }
        match self.under_sheet {
            0 => self.focused = ctx.memory(Memory::focused),
            1 => {
                if let Some(id) = self.focused {
                    ctx.memory_mut(|memory| memory.request_focus(id));
                }
            }
            _ => ctx.request_repaint(),
        }
        self.under_sheet = self.under_sheet.saturating_sub(1);
    }

    /// Draws everything, then executes the commands.
    fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.light = ctx.theme() == egui::Theme::Light;
        self.model.open = View::ALL.map(|view| views::is_open(&self.tree, view));
        let mut commands = Vec::new();
        if !self.has_sheet() {
            crate::app::commands::keys::pressed(&ctx, &self.model, &mut commands);
        }
        self.panels(ui, &mut commands);
        let asks = self.inspector.asks();
        self.model.tune(asks.tune);
        self.model.judge(asks.judge);
        self.model.look_around(asks.around);
        self.model.explain();
        self.model.pin();
        self.model.map(self.pictures.shows_map().then_some(self.model.quantity));
        // Newly visible views may need more layers of the frame.
        self.ask_for_pictures();
        crate::app::panels::help::ui(&ctx, &mut self.help);
        self.about.ui(&ctx);
        self.command_palette.ui(&ctx, &self.model, &mut commands);
        crate::app::files::drop_files::ui(&ctx, &self.model, &mut commands);
        self.toasts.show(&ctx);
        for command in commands {
            self.apply(&ctx, command);
        }
        self.give_focus_back(&ctx);
        self.send_settings(&ctx);
    }
}
