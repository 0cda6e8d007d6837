//! The window: the model with all panels, views and dialogs, and the execution of commands.

mod apply;
mod panels;
mod results;

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, Context, Id, Memory, Ui};
use eframe::egui_wgpu::RenderState;
use egui_tiles::Tree;

use crate::app::commands::keys;
use crate::app::files::dialogs::Dialogs;
use crate::app::files::kept_state;
use crate::app::inspector::Inspector;
use crate::app::model::Model;
use crate::app::model::layout::ViewLayout;
use crate::app::model::persisted_state::PersistedState;
use crate::app::model::view::View;
use crate::app::model::worker::PlayerFactory;
use crate::app::panels::about::About;
use crate::app::panels::command_palette::CommandPalette;
use crate::app::panels::source_options::SourceOptions;
use crate::app::panels::sweep_maps::SweepMaps;
use crate::app::panels::toasts::Toasts;
use crate::app::panels::{drop_files, help};
use crate::app::theme;
use crate::app::views::{self, FrameUploads};
use crate::explain::pixel::region_shares::PixelRegion;
use crate::settings::Settings;

/// Minimum interval between settings sent to the worker while a slider is dragged.
const MIN_SETTINGS_INTERVAL: Duration = Duration::from_millis(60);

/// The storage key of the views' layout.
const LAYOUT_KEY: &str = "layout";

/// The window: the [`Model`], and the state of panels, views and dialogs.
pub(super) struct Window {
    pub(super) model: Model,
    pub(super) tree: Tree<View>,
    /// Points per pixel of the fitted image: in the view under the pointer, or the largest view.
    fitted: Option<f32>,
    pub(super) pictures: FrameUploads,
    pub(super) toasts: Toasts,
    pub(super) dialogs: Dialogs,
    pub(super) command_palette: CommandPalette,
    pub(super) help: bool,
    pub(super) about: About,
    pub(super) source_options: SourceOptions,
    pub(super) sweep_maps: SweepMaps,
    player_factory: PlayerFactory,
    pub(super) inspector: Inspector,
    settings_sent_at: Option<Instant>,
    pub(super) light: bool,
    /// Whether the failure of the drawing thread has been reported.
    upload_failed: bool,
    /// The number of further frames in which a dialog keeps the focus.
    frames_without_focus: u8,
    /// The control that had the focus before the dialog.
    focused: Option<Id>,
    /// This thread's time for the previous frame, in seconds.
    frame_seconds: Option<f32>,
    /// The folder in which the state that survives a restart is stored.
    pub(super) state_folder: Option<PathBuf>,
}

impl Window {
    /// A window without an open video. Fails if a thread cannot be started.
    pub(super) fn new(
        ctx: &Context,
        gpu: &RenderState,
        settings: Settings,
        player_factory: PlayerFactory,
    ) -> io::Result<Self> {
        theme::install(ctx);
        Ok(Self {
            model: Model::new(settings),
            tree: views::tree_of(ViewLayout::All),
            fitted: None,
            pictures: FrameUploads::start(ctx, gpu)?,
            toasts: Toasts::default(),
            dialogs: Dialogs::default(),
            command_palette: CommandPalette::default(),
            help: false,
            about: About::on(&gpu.adapter.get_info()),
            source_options: SourceOptions::default(),
            sweep_maps: SweepMaps::default(),
            player_factory,
            inspector: Inspector::default(),
            settings_sent_at: None,
            light: false,
            upload_failed: false,
            frames_without_focus: 0,
            focused: None,
            frame_seconds: None,
            state_folder: None,
        })
    }

    /// Restores the persisted state. Unreadable parts have their initial values.
    pub(super) fn restore(&mut self, ctx: &Context, storage: Option<&dyn eframe::Storage>) {
        let layout: Option<Tree<View>> = storage.and_then(|storage| eframe::get_value(storage, LAYOUT_KEY));
        if let Some(tree) = layout.and_then(views::restored) {
            self.tree = tree;
        }
        PersistedState::read(storage).restore(ctx, &mut self.model);
    }

    /// Takes new results of the worker, the dialogs and the clock. Draws nothing.
    pub(super) fn advance(&mut self, ctx: &Context) {
        let failed = self.model.worker.failure().is_some();
        for warning in self.model.take() {
            self.toasts.warn(ctx, warning);
        }
        if let Some(why) = self.model.worker.failure().filter(|_| !failed) {
            self.toasts.note_failure(ctx, why);
        }
        self.request_pictures();
        if self.pictures.show_latest() {
            self.model.worker.in_view = self.pictures.in_view().map(|set| Arc::clone(set.frame()));
        }
        if self.pictures.has_failed() && !self.upload_failed {
            self.upload_failed = true;
            self.toasts.fail(ctx, "The graphics card accepts no more images; restart the program");
        }
        if let Some(result) = self.dialogs.answer() {
            self.handle_result(ctx, result);
        }
        if let Some(wait) = self.model.tick(ctx.input(|input| input.time)) {
            ctx.request_repaint_after(Duration::from_secs_f64(wait.clamp(0.0, 1.0)));
        }
    }

    fn request_pictures(&mut self) {
        if let Some(newest) = &self.model.worker.newest {
            self.pictures.request(newest);
        }
    }

    /// Sends the latest settings to the worker, and records them for undo once they stop changing.
    fn send_settings(&mut self, ctx: &Context) {
        let busy = ctx.input(|input| input.pointer.any_down()) || ctx.text_edit_focused();
        if !busy {
            self.model.edits.history.record(&self.model.edits.settings);
        }
        if !self.model.has_unsent_settings() {
            return;
        }
        let waited = self.settings_sent_at.is_none_or(|at| at.elapsed() >= MIN_SETTINGS_INTERVAL);
        if busy && !waited {
            ctx.request_repaint_after(MIN_SETTINGS_INTERVAL);
            return;
        }
        self.settings_sent_at = Some(Instant::now());
        self.model.send_settings();
    }

    /// Requests from the worker what the visible tab of the inspector and the views show.
    fn send_requests(&mut self) {
        let requests = self.inspector.requests();
        let pixel = self.model.selection.pixel;
        let worker = &mut self.model.worker;
        worker.request_tuning(requests.tuning_axes);
        let region = |side: Option<u32>| Some(PixelRegion { centre: pixel?, side: side? });
        worker.request_accuracy(region(requests.accuracy_side));
        worker.request_shares(region(requests.shares_side));
        self.model.request_evidence();
        let map = self.pictures.shows_map().then_some(self.model.display.quantity);
        self.model.worker.request_map(map);
    }

    /// Whether a dialog is open over the window and takes all keys.
    const fn has_dialog(&self) -> bool {
        self.help
            || self.about.open
            || self.source_options.is_open()
            || self.sweep_maps.is_open()
            || self.command_palette.is_open()
    }

    /// Restores the focus once no dialog is open. Controls under a dialog get no focus until one frame after it is
    /// closed.
    fn restore_focus(&mut self, ctx: &Context) {
        if self.has_dialog() {
            self.frames_without_focus = 2;
            return;
        }
        match self.frames_without_focus {
            0 => self.focused = ctx.memory(Memory::focused),
            1 => {
                if let Some(id) = self.focused {
                    ctx.memory_mut(|memory| memory.request_focus(id));
                }
            }
            _ => ctx.request_repaint(),
        }
        self.frames_without_focus = self.frames_without_focus.saturating_sub(1);
    }

    /// Draws everything, then executes the commands.
    pub(super) fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.light = ctx.theme() == egui::Theme::Light;
        self.model.display.open = View::ALL.map(|view| views::is_open(&self.tree, view));
        let mut commands = Vec::new();
        if !self.has_dialog() {
            keys::pressed(&ctx, &self.model, &mut commands);
        }
        self.panels(ui, &mut commands);
        self.send_requests();
        // Newly visible views may need more layers of the frame.
        self.request_pictures();
        help::ui(&ctx, &mut self.help);
        self.about.ui(&ctx);
        self.source_options.ui(&ctx, &self.model, &mut commands);
        self.sweep_maps.ui(&ctx, &self.model, &mut commands);
        self.command_palette.ui(&ctx, &self.model, &mut commands);
        drop_files::ui(&ctx, &self.model, &mut commands);
        self.toasts.show(&ctx);
        for command in commands {
            self.apply(&ctx, command);
        }
        self.restore_focus(&ctx);
        self.send_settings(&ctx);
    }
}

impl eframe::App for Window {
    fn logic(&mut self, ctx: &Context, _frame: &mut eframe::Frame) {
        self.advance(ctx);
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.frame_seconds = frame.info().cpu_usage;
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        if let Some(folder) = &self.state_folder {
            kept_state::keep(folder);
        }
        eframe::set_value(storage, LAYOUT_KEY, &self.tree);
        self.model.store_marks();
        PersistedState::of(&self.model, self.light).write(storage);
    }
}
