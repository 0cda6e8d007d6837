//! Execution of commands; the only place where they change the window's state.

use std::sync::Arc;

use eframe::egui::{ColorImage, Context, Theme, ViewportCommand};

use crate::app::Window;
use crate::app::commands::command::{Action, Command, Scale};
use crate::app::files::export_frame::FrameExport;
use crate::app::files::sample;
use crate::app::model::ab_settings::AbSettings;
use crate::app::model::areas::{AreaEdit, Areas};
use crate::app::model::event_comparison::EventRef;
use crate::app::model::overlays::Overlay;
use crate::app::model::undo_history::RestoredState;
use crate::app::model::{Camera, Origin, SPEEDS, Subject};
use crate::app::panels::timeline;
use crate::app::views;
use crate::app::views::View;
use crate::mixture::Quantity;
use crate::replay::{Request, Start};
use crate::settings::Settings;

impl Window {
    /// Executes a command.
    pub(crate) fn apply(&mut self, ctx: &Context, command: Command) {
        let model = &mut self.model;
        match command {
            Command::Act(action) => self.act(ctx, action),
            Command::Open(name, start) => self.open(ctx, &name, start),
            Command::Rate(fps) => self.set_rate(ctx, fps),
            Command::ReadTruth(path) => self.dialogs.read_truth(ctx, path),
            Command::OpenSample => self.open_sample(ctx),
            Command::CopyTable(table) => self.dialogs.write_table(ctx, table),
            Command::SaveTable(table) => self.dialogs.save_table(ctx, table),
            Command::CopyPlot(plot) => self.dialogs.draw_plot(ctx, plot),
            Command::SavePlot(plot, format) => self.dialogs.save_plot(ctx, plot, format),
            Command::GoTo(position) => model.go_to(position),
            Command::GoToNumber(number) => model.go_to(model.position_of(number)),
            Command::Span(span) => model.span = span,
            Command::Speed(place) => model.playback.speed = place.min(SPEEDS.len() - 1),
            Command::Set(settings) => model.settings = *settings,
            Command::Choose(pixel) => {
                model.chosen = pixel;
                if let Some(player) = &model.player {
                    player.request(Request::Inspect(pixel));
                }
            }
            Command::ChooseObject(object) => {
                model.object = object;
                model.subject = if object.is_some() { Subject::Object } else { Subject::Pixel };
            }
            Command::Explain(subject) => model.subject = subject,
            Command::Unpin(number) => model.marks.pins.remove(number),
            Command::SetCamera(camera) => model.camera = camera,
            Command::Hover(hover) => {
                model.hovered = hover;
                // The status line was drawn before the pointer position was read.
                ctx.request_repaint();
            }
            Command::ShowBackground(kind) => model.background = kind,
            Command::Overlay(opacity) => model.overlay.opacity = opacity.min(100),
            Command::Area(change) => self.change_areas(ctx, change),
            Command::RevealSetting(setting) => {
                model.settings_panel = true;
                model.looked_at = Some(setting);
            }
            Command::SettingRevealed => model.looked_at = None,
            Command::HideHint => model.hint = false,
            Command::OpenEvent(event) => model.read(event),
            Command::LetGo(slot) => {
                model.held = None;
                model.show_slot(slot);
            }
            Command::List(listing) => model.listing = listing,
            Command::FilterEvents(place, listed) => {
                if let Some(kind) = model.listed.get_mut(place) {
                    *kind = listed;
                }
            }
        }
    }

    fn act(&mut self, ctx: &Context, action: Action) {
        if !action.entry().is_some_and(|entry| crate::app::panels::top_bar::allowed(&self.model, entry)) {
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
            Action::CloseVideo => self.close(ctx),
            Action::CopyPlace => {
                if let Some(place) = model.place() {
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
            Action::SaveSettings => self.dialogs.save_settings(ctx, model.settings.clone()),
            Action::LoadSettings => self.dialogs.load_settings(ctx),
            Action::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
            Action::Undo => {
                let again = model.history.undo();
                self.again(again);
            }
            Action::Redo => {
                let again = model.history.redo();
                self.again(again);
            }
            Action::AbSlot(slot) => {
                if model.show_slot(slot) {
                    self.toasts.done(
                        ctx,
                        "Settings B start as a copy of A. Keys A and B switch between them; View, Layout, \
                         Compare shows both",
                    );
                }
            }
            Action::FlipSettings => {
                let other = model.ab_settings.in_view.other();
                model.held = Some(model.ab_settings.in_view);
                model.show_slot(other);
            }
            Action::CopySettings => {
                model.change_slots(|slots, settings| slots.other = Some(settings.clone()));
            }
            Action::SwapSettings => model.change_slots(|slots, settings| {
                if let Some(other) = &mut slots.other {
                    std::mem::swap(other, settings);
                }
            }),
            Action::KeepSettings => {
                model.change_slots(|slots, _| *slots = AbSettings::new());
                model.held = None;
                self.toasts.done(ctx, "The current settings are A; B is discarded");
            }
            Action::DefaultSettings => model.settings = Settings::default(),
            Action::DrawArea(purpose) => {
                let again = model.areas.draft.as_ref().is_some_and(|draft| draft.purpose == purpose);
                self.change_areas(ctx, if again { AreaEdit::Cancel } else { AreaEdit::Begin(purpose) });
            }
            Action::CloseArea => self.change_areas(ctx, AreaEdit::Close),
            Action::UndoCorner => self.change_areas(ctx, AreaEdit::Back),
            Action::CancelArea => {
                let drawing = model.areas.draft.is_some();
                self.change_areas(ctx, if drawing { AreaEdit::Cancel } else { AreaEdit::Choose(None) });
            }
            Action::DeleteArea => {
                if let Some(place) = model.areas.chosen {
                    self.change_areas(ctx, AreaEdit::Delete(place));
                }
            }
            Action::ClearAreas => self.change_areas(ctx, AreaEdit::Clear),
            Action::LoadTruth => self.dialogs.load_truth(ctx),
            Action::LoadTruthFolder => self.dialogs.load_truth_folder(ctx),
            Action::LoadMask => self.dialogs.load_mask(ctx),
            Action::SaveMask => {
                if let Some(roi) = &model.areas.roi {
                    self.dialogs.save_mask(ctx, Arc::clone(roi));
                }
            }
            Action::Play => {
                model.playback.playing = !model.playback.playing;
                model.playback.next_at = ctx.input(|input| input.time);
                let at_end = model.timeline().is_some_and(|timeline| timeline.complete)
                    && model.position() + 1 >= model.frames();
                if model.playback.playing && at_end {
                    model.go_to(0);
                }
            }
            Action::Step(by) => {
                model.playback.playing = false;
                model.go_to(model.position().saturating_add_signed(by));
            }
            Action::NextEvent | Action::PreviousEvent => {
                if let Some((event, position)) = model.event_beside(action == Action::NextEvent) {
                    model.playback.playing = false;
                    model.read(Some(EventRef::InView(event)));
                    model.go_to(position);
                }
            }
            Action::First => model.go_to(0),
            Action::Last => model.go_to(model.frames().saturating_sub(1)),
            Action::StartHere => model.marks.toggle_start(model.position()),
            Action::EndHere => model.marks.toggle_end(model.position()),
            Action::Bookmark => model.marks.toggle_bookmark(model.position()),
            Action::NextBookmark | Action::PreviousBookmark => {
                if let Some(place) =
                    model.marks.adjacent_bookmark(model.position(), action == Action::NextBookmark)
                {
                    model.playback.playing = false;
                    model.go_to(place);
                }
            }
            Action::WholeTimeline => model.span = None,
            Action::ZoomTimeline(into) => model.span = timeline::zoomed(model, into),
            Action::AnalyseAhead => model.stop_or_go_on(),
            Action::Slower => model.playback.speed = model.playback.speed.saturating_sub(1),
            Action::Faster => model.playback.speed = (model.playback.speed + 1).min(SPEEDS.len() - 1),
            Action::Maximise(view) => {
                model.maximised = if model.maximised == Some(view) { None } else { Some(view) };
            }
            Action::Fit => model.camera = Camera::FIT,
            Action::Actual => {
                if let Some(fitted) = self.fitted {
                    model.camera.magnification = 1.0 / (ctx.pixels_per_point() * fitted);
                }
            }
            Action::Open(view) => {
                let open = views::is_open(&self.tree, view);
                views::set_open(&mut self.tree, view, !open);
            }
            Action::Arrange(layout) => {
                self.tree = layout.tree();
                (model.settings_panel, model.inspector_panel) = layout.panels();
                (model.maximised, model.camera) = (None, Camera::FIT);
            }
            Action::Draw(what) => model.drawn.toggle(what),
            Action::ZoomIn => model.zoom_by(1.25),
            Action::ZoomOut => model.zoom_by(0.8),
            Action::Background => model.background = model.background.next(),
            Action::Map(quantity) => self.show_map(quantity),
            Action::NextMap => {
                let all = Quantity::ALL.iter().cycle();
                let next = all.skip_while(|&&quantity| quantity != model.quantity).nth(1);
                // The first call shows the current quantity instead of the next one.
                let next = next.filter(|_| model.mapped.is_some()).copied();
                let next = next.unwrap_or(model.quantity);
                self.show_map(next);
            }
            Action::Overlay => model.overlay.on = !model.overlay.on,
            Action::OverlayOpacity => {
                model.overlay = Overlay { on: true, opacity: model.overlay.next() };
            }
            Action::MovePixel(columns, rows) => {
                let pixel = model.pixel_beside(columns, rows);
                self.apply(ctx, Command::Choose(pixel));
            }
            Action::ClearPixel => self.apply(ctx, Command::Choose(None)),
            Action::ClearObject => self.apply(ctx, Command::ChooseObject(None)),
            Action::Loupe => model.loupe = !model.loupe,
            Action::Pin => {
                if let Some(at) = model.chosen
                    && !model.marks.pins.toggle(at)
                {
                    let text = format!(
                        "{} pixels are pinned, the maximum; unpin one first",
                        crate::app::model::pins::MAX_PINS
                    );
                    self.toasts.warn(ctx, text);
                }
            }
            Action::ClearPins => model.marks.pins.clear(),
            Action::SettingsPanel => model.settings_panel = !model.settings_panel,
            Action::InspectorPanel => model.inspector_panel = !model.inspector_panel,
            Action::Scale(scale) => {
                let tenths = (ctx.zoom_factor() * 10.0).round();
                let tenths = match scale {
                    Scale::Larger => tenths + 1.0,
                    Scale::Smaller => tenths - 1.0,
                    Scale::Usual => 10.0,
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
        }
    }

    /// Shows the map of a per-pixel quantity and brings the map view to the front.
    fn show_map(&mut self, quantity: Quantity) {
        self.model.quantity = quantity;
        if self.model.maximised.is_some() {
            self.model.maximised = Some(View::Map);
        }
        views::set_open(&mut self.tree, View::Map, true);
    }

    fn open_sample(&mut self, ctx: &Context) {
        match sample::unpacked() {
            Ok(path) => {
                self.open(ctx, &path.to_string_lossy(), Start::FirstOcclusion);
                self.model.origin = Origin::Sample;
                self.apply(ctx, Command::Choose(Some(sample::PIXEL)));
            }
            Err(why) => self.toasts.fail(ctx, why),
        }
    }

    /// Edits the areas, or shows why the edit is rejected.
    pub(crate) fn change_areas(&mut self, ctx: &Context, change: AreaEdit) {
        let model = &mut self.model;
        let Some(size) = model.size() else { return };
        if let AreaEdit::Load(mask) = &change
            && let Err(error) = mask.check(size)
        {
            self.toasts.fail(ctx, error.to_string());
            return;
        }
        let before = model.areas.clone();
        match model.areas.change(change, size) {
            Ok(false) => {}
            Ok(true) => {
                model.history.note_areas(Areas { draft: None, ..before }, model.areas.clone());
                self.send_areas();
            }
            Err(refused) => self.toasts.warn(ctx, refused.to_string()),
        }
    }

    /// Restores the state of an undo or redo.
    fn again(&mut self, again: Option<RestoredState>) {
        let model = &mut self.model;
        match again {
            Some(RestoredState::Settings(slot, settings)) => {
                model.ab_settings.show(slot, &mut model.settings);
                model.settings = *settings;
            }
            Some(RestoredState::AbSettings(slots, settings)) => {
                (model.ab_settings, model.settings) = (slots, *settings);
            }
            Some(RestoredState::Areas(areas)) => {
                model.areas = areas;
                self.send_areas();
            }
            None => {}
        }
    }

    /// Sends the region of interest to the worker.
    fn send_areas(&mut self) {
        // Event indices are invalid after the change.
        self.model.read(None);
        if let Some(player) = &self.model.player {
            player.request(Request::Roi(self.model.areas.roi.clone()));
        }
    }

    /// Closes the video, or cancels opening it.
    fn close(&mut self, ctx: &Context) {
        self.pictures.clear();
        self.inspector.forget();
        self.model.closed();
        ctx.send_viewport_cmd(ViewportCommand::Title("Occluscope".into()));
    }

    /// Sets the video's frame rate. Restarts the analysis if the rate differs, because settings in seconds depend on
    /// it.
    fn set_rate(&mut self, ctx: &Context, fps: f32) {
        let model = &mut self.model;
        let Some(name) = model.opened.clone() else { return };
        if model.options_of(&name).fps == Some(fps) {
            return;
        }
        model.told_rate = None;
        model.rates.insert(name.clone(), fps);
        let (chosen, truth, camera) = (model.chosen, model.truth.clone(), model.camera);
        let start = Start::Frame(model.number(model.position()));
        self.open(ctx, &name, start);
        self.model.camera = camera;
        self.apply(ctx, Command::Choose(chosen));
        if let Some(truth) = truth {
            self.model.take_truth(truth);
        }
    }

    /// Opens a video with a new worker, which replaces the present one.
    fn open(&mut self, ctx: &Context, name: &str, start: Start) {
        let roi = self.model.areas_for(name);
        let options = self.model.options_of(name);
        let player = (self.opener)(name, options, (self.model.settings.clone(), roi), start, ctx);
        self.pictures.clear();
        self.inspector.forget();
        self.model.opened(name, player);
        let short = std::path::Path::new(name)
            .file_name()
            .map_or_else(|| name.into(), |short| short.to_string_lossy());
        ctx.send_viewport_cmd(ViewportCommand::Title(format!("{short} - Occluscope")));
    }
}
