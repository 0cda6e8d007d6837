//! Execution of the commands that need the window: dialogs, messages, views, the clipboard and videos.

use std::sync::Arc;

use eframe::egui::{ColorImage, Context, Theme, ViewportCommand};

use crate::app::commands::action::{Action, UiScale};
use crate::app::commands::apply;
use crate::app::commands::availability::is_available;
use crate::app::commands::command::Command;
use crate::app::files::export_frame::FrameExport;
use crate::app::files::sample;
use crate::app::model::ab_settings::AbSettings;
use crate::app::model::areas::AreaEdit;
use crate::app::model::camera::ViewCamera;
use crate::app::model::pins::MAX_PINS;
use crate::app::model::videos::{Origin, file_name};
use crate::app::model::view::View;
use crate::app::views;
use crate::app::window::Window;
use crate::mixture::Quantity;
use crate::regions::Roi;
use crate::replay::Start;
use crate::source::{Options, name_of};

impl Window {
    /// Executes a command.
    pub(in crate::app) fn apply(&mut self, ctx: &Context, command: Command) {
        match command {
            Command::Act(action) => self.act(ctx, action),
            Command::Open(name, start) => self.open(ctx, &name, start),
            Command::Rate(fps) => {
                let options = self.model.videos.opened_options();
                self.set_options(ctx, Options { fps: Some(fps), ..options });
            }
            Command::Read(options) => self.set_options(ctx, options),
            Command::ReadTruth(path) => self.dialogs.read_truth(ctx, path),
            Command::ReadSweep(path) => self.dialogs.read_sweep(ctx, path),
            Command::OpenSample => self.open_sample(ctx),
            Command::Area(change) => self.change_areas(ctx, change),
            Command::Hover(_) => {
                apply::apply(&mut self.model, command);
                // The status line was drawn before the pointer position was read.
                ctx.request_repaint();
            }
            command => apply::apply(&mut self.model, command),
        }
    }

    fn act(&mut self, ctx: &Context, action: Action) {
        if !action.entry().is_some_and(|entry| is_available(&self.model, entry)) {
            return;
        }
        let model = &mut self.model;
        match action {
            Action::OpenVideo => self.dialogs.video(ctx),
            Action::OpenFolder => self.dialogs.folder(ctx),
            Action::OpenSample => self.open_sample(ctx),
            Action::ExportFrame => {
                if let Some(picture) = FrameExport::of(model) {
                    self.dialogs.export_frame(ctx, picture);
                }
            }
            Action::SourceOptions => {
                let name = model.videos.opened.as_deref().unwrap_or_default();
                self.source_options.open(name, model.videos.opened_options());
            }
            Action::CloseVideo => self.close(ctx),
            Action::CopyPlace => {
                if let Some(place) = model.frame_description() {
                    self.toasts.done(ctx, format!("Copied: {place}"));
                    ctx.copy_text(place);
                }
            }
            Action::CopyPicture => {
                if let Some(picture) = FrameExport::of(model) {
                    let frame = picture.drawn();
                    let size = [frame.size.width as usize, frame.size.height as usize];
                    ctx.copy_image(ColorImage::from_rgb(size, &frame.rgb));
                    self.toasts.done(ctx, format!("Copied frame {}", frame.number));
                }
            }
            Action::SaveSettings => self.dialogs.save_settings(ctx, model.edits.settings.clone()),
            Action::LoadSettings => self.dialogs.load_settings(ctx),
            Action::OpenSweep => self.dialogs.open_sweep(ctx),
            Action::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
            Action::AbSlot(slot) => {
                if model.edits.show_slot(slot) {
                    self.toasts.done(
                        ctx,
                        "Settings B start as a copy of A. Keys A and B switch between them; View, Layout, \
                         Compare shows both",
                    );
                }
            }
            Action::KeepSettings => {
                model.edits.change_slots(|slots, _| *slots = AbSettings::new());
                model.edits.held_slot = None;
                self.toasts.done(ctx, "The current settings are A; B is discarded");
            }
            Action::DrawArea(purpose) => {
                let draft = model.edits.areas.draft.as_ref();
                let again = draft.is_some_and(|draft| draft.purpose == purpose);
                self.change_areas(ctx, if again { AreaEdit::Cancel } else { AreaEdit::Begin(purpose) });
            }
            Action::CloseArea => self.change_areas(ctx, AreaEdit::Close),
            Action::UndoCorner => self.change_areas(ctx, AreaEdit::Back),
            Action::CancelArea => {
                let drawing = model.edits.areas.draft.is_some();
                self.change_areas(ctx, if drawing { AreaEdit::Cancel } else { AreaEdit::Choose(None) });
            }
            Action::DeleteArea => {
                if let Some(index) = model.edits.areas.chosen {
                    self.change_areas(ctx, AreaEdit::Delete(index));
                }
            }
            Action::ClearAreas => self.change_areas(ctx, AreaEdit::Clear),
            Action::LoadTruth => self.dialogs.load_truth(ctx),
            Action::LoadTruthFolder => self.dialogs.load_truth_folder(ctx),
            Action::LoadExternal => self.dialogs.load_external(ctx),
            Action::LoadExternalFolder => self.dialogs.load_external_folder(ctx),
            Action::LoadMask => self.dialogs.load_mask(ctx),
            Action::SaveMask => {
                // A file has the source's size.
                if let Some(roi) = &model.edits.areas.roi {
                    let placement = model.worker.placement();
                    let mask = placement
                        .map_or_else(|| roi.mask().clone(), |placement| placement.source_mask(roi.mask()));
                    self.dialogs.save_mask(ctx, mask);
                }
            }
            Action::Actual => {
                if let Some(fitted) = self.fitted {
                    model.display.camera.magnification = 1.0 / (ctx.pixels_per_point() * fitted);
                }
            }
            Action::Open(view) => {
                let open = views::is_open(&self.tree, view);
                views::set_open(&mut self.tree, view, !open);
            }
            Action::Arrange(layout) => {
                self.tree = views::tree_of(layout);
                (model.panels.settings, model.panels.inspector) = layout.panels();
                (model.display.maximised, model.display.camera) = (None, ViewCamera::FIT);
            }
            Action::Map(quantity) => self.show_map(quantity),
            Action::NextMap => {
                let all = Quantity::ALL.iter().cycle();
                let next = all.skip_while(|&&quantity| quantity != model.display.quantity).nth(1);
                // The first call shows the current quantity instead of the next one.
                let next = next.filter(|_| model.worker.sent.map.is_some()).copied();
                let next = next.unwrap_or(model.display.quantity);
                self.show_map(next);
            }
            Action::Pin => {
                if let Some(at) = model.selection.pixel
                    && !model.playback.marks.pins.toggle(at)
                {
                    let text = format!("{MAX_PINS} pixels are pinned, the maximum; unpin one first");
                    self.toasts.warn(ctx, text);
                }
            }
            Action::Scale(scale) => {
                let tenths = (ctx.zoom_factor() * 10.0).round();
                let tenths = match scale {
                    UiScale::Larger => tenths + 1.0,
                    UiScale::Smaller => tenths - 1.0,
                    UiScale::Usual => 10.0,
                };
                ctx.set_zoom_factor(tenths.clamp(5.0, 30.0) / 10.0);
            }
            Action::Theme => {
                let other = if ctx.theme() == Theme::Dark { Theme::Light } else { Theme::Dark };
                ctx.set_theme(other);
            }
            Action::Messages => self.toasts.messages.open = !self.toasts.messages.open,
            Action::About => self.about.open = true,
            Action::Help => self.help = !self.help,
            Action::Palette => self.command_palette.toggle(),
            action => apply::act(model, action, ctx.input(|input| input.time)),
        }
    }

    /// Shows the map of a per-pixel quantity and brings the map view to the front.
    fn show_map(&mut self, quantity: Quantity) {
        self.model.display.quantity = quantity;
        if self.model.display.maximised.is_some() {
            self.model.display.maximised = Some(View::Map);
        }
        views::set_open(&mut self.tree, View::Map, true);
    }

    fn open_sample(&mut self, ctx: &Context) {
        match sample::unpacked() {
            Ok(path) => {
                self.open(ctx, &name_of(path), Start::FirstOcclusion);
                self.model.videos.origin = Origin::Sample;
                self.model.choose_pixel(Some(sample::SAMPLE_PIXEL));
            }
            Err(why) => self.toasts.fail(ctx, why),
        }
    }

    /// Edits the areas, or shows why the edit is rejected.
    pub(super) fn change_areas(&mut self, ctx: &Context, change: AreaEdit) {
        let Some(size) = self.model.worker.size() else { return };
        let placement = self.model.worker.placement();
        let change = match change {
            AreaEdit::Load(mask) => match Roi::of_frames(&mask, size, placement.as_ref()) {
                Ok(mask) => AreaEdit::Load(mask),
                Err(error) => {
                    self.toasts.fail(ctx, error.to_string());
                    return;
                }
            },
            change => change,
        };
        match self.model.edits.change_areas(change, size) {
            Ok(false) => {}
            Ok(true) => self.model.send_roi(),
            Err(refused) => self.toasts.warn(ctx, refused.to_string()),
        }
    }

    /// Closes the video, or cancels opening it.
    fn close(&mut self, ctx: &Context) {
        self.pictures.clear();
        self.inspector.forget();
        self.model.close();
        ctx.send_viewport_cmd(ViewportCommand::Title("Occluscope".into()));
    }

    /// Reads the open video with these options. Restarts the analysis if they differ.
    fn set_options(&mut self, ctx: &Context, options: Options) {
        let model = &mut self.model;
        let Some(name) = model.videos.opened.clone() else { return };
        let before = model.videos.options_of(&name);
        if options == before {
            return;
        }
        let place = |options: Options| (options.crop, options.scale, options.stream);
        let is_same_place = place(options) == place(before);
        // Another stream may show something else in another size.
        let pixel = model.pixel_with(options).filter(|_| options.stream == before.stream);
        if !is_same_place && !model.edits.areas.is_empty() {
            model.edits.forget_areas();
            self.toasts
                .warn(ctx, "The areas were removed: they belong to the images as they were read before");
        }
        let model = &mut self.model;
        model.videos.set_options(&name, options);
        let (truth, camera) = (model.truth.clone(), model.display.camera);
        let external = model.external.as_ref().map(|loaded| Arc::clone(&loaded.results));
        let start = Start::Frame(model.worker.number(model.worker.position()));
        self.open(ctx, &name, start);
        if is_same_place {
            self.model.display.camera = camera;
        }
        self.model.choose_pixel(pixel);
        if let Some(truth) = truth {
            self.model.set_truth(truth);
        }
        if external.is_some() {
            self.model.set_external(external);
        }
    }

    /// Opens a video with a new worker, which replaces the present one.
    fn open(&mut self, ctx: &Context, name: &str, start: Start) {
        let roi = self.model.roi_of(name);
        let options = self.model.videos.options_of(name);
        let settings = self.model.edits.settings.clone();
        let player = (self.player_factory)(name, options, (settings, roi), start, ctx);
        self.pictures.clear();
        self.inspector.forget();
        self.model.open(name, player);
        self.dialogs.find_truth(ctx, name);
        ctx.send_viewport_cmd(ViewportCommand::Title(format!("{} - Occluscope", file_name(name))));
    }
}
