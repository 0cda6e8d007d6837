//! The one place where what was asked for is done.

use std::sync::Arc;

use eframe::egui::{Context, Theme, ViewportCommand};

use super::Window;
use super::areas::Change;
use super::command::{Action, Command};
use super::export_frame::Picture;
use super::state::{Camera, Overlay, SPEEDS};
use super::{sample, views};
use crate::replay::Start;
use crate::settings::Settings;

impl Window {
    /// Does what was asked for.
    pub(super) fn apply(&mut self, ctx: &Context, command: Command) {
        let model = &mut self.model;
        match command {
            Command::Act(action) => self.act(ctx, action),
            Command::Open(name, start) => self.open(ctx, &name, start),
            Command::OpenSample => self.open_sample(ctx),
            Command::GoTo(position) => model.go_to(position),
            Command::GoToNumber(number) => model.go_to(model.position_of(number)),
            Command::Speed(place) => model.playback.speed = place.min(SPEEDS.len() - 1),
            Command::Set(settings) => model.settings = *settings,
            Command::Choose(pixel) => {
                model.chosen = pixel;
                if let Some(player) = &model.player {
                    player.inspect(pixel);
                }
            }
            Command::Look(camera) => model.camera = camera,
            Command::Hover(hover) => {
                model.hovered = hover;
                // The status line was drawn before the pointer was looked at.
                ctx.request_repaint();
            }
            Command::ShowBackground(kind) => model.background = kind,
            Command::Overlay(opacity) => model.overlay.opacity = opacity.min(100),
            Command::Area(change) => self.change_areas(ctx, change),
            Command::Read(event) => model.reading = event,
            Command::FilterEvents(place, listed) => {
                if let Some(kind) = model.listed.get_mut(place) {
                    *kind = listed;
                }
            }
        }
    }

    fn act(&mut self, ctx: &Context, action: Action) {
        if !action.entry().is_some_and(|entry| super::top_bar::allowed(&self.model, entry)) {
            return;
        }
        let model = &mut self.model;
        match action {
            Action::OpenVideo => self.dialogs.video(ctx),
            Action::OpenFolder => self.dialogs.folder(ctx),
            Action::OpenSample => self.open_sample(ctx),
            Action::ExportFrame => {
                if let Some(picture) = Picture::of(model) {
                    self.dialogs.export_frame(ctx, picture);
                }
            }
            Action::SaveSettings => self.dialogs.save_settings(ctx, model.settings.clone()),
            Action::LoadSettings => self.dialogs.load_settings(ctx),
            Action::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
            Action::Undo => {
                if let Some((slot, before)) = model.history.undo() {
                    model.slots.show(slot, &mut model.settings);
                    model.settings = before;
                }
            }
            Action::Redo => {
                if let Some((slot, after)) = model.history.redo() {
                    model.slots.show(slot, &mut model.settings);
                    model.settings = after;
                }
            }
            Action::Slot(slot) => {
                if model.show_slot(slot) {
                    self.toasts.done(ctx, "Settings B begin as a copy of A; the keys A and B flip");
                }
            }
            Action::DefaultSettings => model.settings = Settings::default(),
            Action::DrawArea(purpose) => {
                let again = model.areas.draft.as_ref().is_some_and(|draft| draft.purpose == purpose);
                self.change_areas(ctx, if again { Change::Cancel } else { Change::Begin(purpose) });
            }
            Action::CloseArea => self.change_areas(ctx, Change::Close),
            Action::UndoCorner => self.change_areas(ctx, Change::Back),
            Action::CancelArea => {
                let drawing = model.areas.draft.is_some();
                self.change_areas(ctx, if drawing { Change::Cancel } else { Change::Choose(None) });
            }
            Action::DeleteArea => {
                if let Some(place) = model.areas.chosen {
                    self.change_areas(ctx, Change::Delete(place));
                }
            }
            Action::ClearAreas => self.change_areas(ctx, Change::Clear),
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
                    model.reading = Some(event);
                    model.go_to(position);
                }
            }
            Action::First => model.go_to(0),
            Action::Last => model.go_to(model.frames().saturating_sub(1)),
            Action::Slower => model.playback.speed = model.playback.speed.saturating_sub(1),
            Action::Faster => model.playback.speed = (model.playback.speed + 1).min(SPEEDS.len() - 1),
            Action::Maximise(view) => {
                model.maximised = if model.maximised == Some(view) { None } else { Some(view) };
            }
            Action::Fit => model.camera = Camera::FIT,
            Action::ZoomIn => model.zoom_by(1.25),
            Action::ZoomOut => model.zoom_by(0.8),
            Action::Background => model.background = model.background.next(),
            Action::Overlay => model.overlay.on = !model.overlay.on,
            Action::OverlayOpacity => {
                model.overlay = Overlay { on: true, opacity: model.overlay.next() };
            }
            Action::ClearPixel => self.apply(ctx, Command::Choose(None)),
            Action::SettingsPanel => model.settings_panel = !model.settings_panel,
            Action::InspectorPanel => model.inspector_panel = !model.inspector_panel,
            Action::ResetLayout => {
                self.tree = views::default_tree();
                (model.maximised, model.settings_panel, model.inspector_panel) = (None, true, true);
                model.camera = Camera::FIT;
            }
            Action::Theme => {
                let other = if ctx.theme() == Theme::Dark { Theme::Light } else { Theme::Dark };
                ctx.set_theme(other);
            }
            Action::Help => self.help = !self.help,
            Action::Palette => self.finder.toggle(),
        }
    }

    fn open_sample(&mut self, ctx: &Context) {
        match sample::unpacked() {
            Ok(path) => {
                self.open(ctx, &path.to_string_lossy(), Start::FirstOcclusion);
                self.apply(ctx, Command::Choose(Some(sample::PIXEL)));
            }
            Err(why) => self.toasts.fail(ctx, why),
        }
    }

    /// Changes what is analysed, or tells why not.
    pub(super) fn change_areas(&mut self, ctx: &Context, change: Change) {
        let model = &mut self.model;
        let Some(size) = model.size() else { return };
        if let Change::Load(mask) = &change
            && let Err(error) = mask.check(size)
        {
            self.toasts.fail(ctx, error.to_string());
            return;
        }
        match model.areas.change(change, size) {
            Ok(false) => {}
            Ok(true) => {
                // Other events stand at its place.
                model.reading = None;
                if let Some(player) = &model.player {
                    player.set_roi(model.areas.roi.clone());
                }
            }
            Err(refused) => self.toasts.warn(ctx, refused.to_string()),
        }
    }

    /// Starts a worker on a video in place of the one that is there.
    fn open(&mut self, ctx: &Context, name: &str, start: Start) {
        let roi = self.model.areas_for(name);
        let player = (self.opener)(name, self.model.settings.clone(), roi, start, ctx);
        self.pictures.clear();
        self.model.opened(name, player);
        let short = std::path::Path::new(name)
            .file_name()
            .map_or_else(|| name.into(), |short| short.to_string_lossy());
        ctx.send_viewport_cmd(ViewportCommand::Title(format!("{short} - Occluscope")));
    }
}
