//! The arrangement of panels and views in the window.

use eframe::egui::{CentralPanel, Frame, Margin, Panel, Rect, Ui};

use crate::app::commands::command::Command;
use crate::app::inspector::{FrameTimes, Inspector, InspectorAction, InspectorContext, RegionAccuracy};
use crate::app::model::Model;
use crate::app::model::selection::Subject;
use crate::app::panels::status::FrameTiming;
use crate::app::panels::{
    events_panel, notices, object_panel, settings_panel, status, subject_choice, timeline, top_bar,
    transport, welcome,
};
use crate::app::theme;
use crate::app::views::{self, pixel_value};
use crate::app::window::Window;

/// Minimum width of the views, in points: below it, titles and buttons would overlap the panel beside them.
const MIN_VIEWS_WIDTH: f32 = 296.0;
/// Minimum width of the settings panel, in points.
const MIN_SETTINGS_WIDTH: f32 = 236.0;
/// Minimum width of the inspector panel, in points.
const MIN_INSPECTOR_WIDTH: f32 = 220.0;
/// Minimum height of the timeline panel, in points.
const MIN_TIMELINE_HEIGHT: f32 = 84.0;
/// Minimum height of the events panel, in points: heading, filters, and two rows.
const MIN_EVENTS_HEIGHT: f32 = 112.0;
/// Minimum height of the events panel with the evidence of an event, in points: down to its first numbers.
const MIN_EVIDENCE_HEIGHT: f32 = 236.0;
/// Minimum height of the inspector in a low window, in points.
const MIN_INSPECTOR_HEIGHT: f32 = 330.0;

impl Window {
    /// Draws the panels, and the views between them.
    pub(super) fn panels(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let screen = ui.ctx().content_rect();
        self.bars(ui, commands);
        let model = &self.model;
        if model.worker.shown().is_some() {
            timeline_panel(ui, model, screen, commands);
        }
        if model.panels.settings {
            left_panel(ui, model, screen, commands);
        }
        let mut action = None;
        if model.panels.inspector && model.worker.shown().is_some() {
            action = right_panel(ui, model, &mut self.inspector, screen, commands);
        }
        CentralPanel::no_frame().show(ui, |ui| {
            if model.worker.shown().is_some() {
                notices::ui(ui, model, commands);
                self.fitted = views::show(ui, &mut self.tree, &mut self.pictures, model, commands);
            } else {
                welcome::ui(ui, model, commands);
            }
        });
        if let Some(action) = action {
            self.inspector_action(ui.ctx(), action, commands);
        }
    }

    /// The menus at the top, and the status bar at the bottom.
    fn bars(&self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let model = &self.model;
        let bar = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(8, 4));
        Panel::top("menus").frame(bar).show(ui, |ui| top_bar::ui(ui, model, commands));
        let timing = FrameTiming {
            frame_seconds: self.frame_seconds,
            upload: self.pictures.in_view().map(|set| (set.duration(), set.bytes())),
        };
        let hovered = model.selection.hovered.zip(model.worker.shown());
        let value = hovered.map(|(hover, shown)| pixel_value(hover.view, model, shown, hover.pixel));
        let bar = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 0));
        Panel::bottom("status")
            .frame(bar)
            .exact_size(theme::ROW_HEIGHT)
            .show(ui, |ui| status::ui(ui, model, value, timing, commands));
    }
}

fn timeline_panel(ui: &mut Ui, model: &Model, screen: Rect, commands: &mut Vec<Command>) {
    let height = screen.height();
    let bar = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 6));
    Panel::bottom("timeline")
        .frame(bar)
        .resizable(true)
        .default_size((height * 0.09).clamp(100.0, 180.0))
        .size_range((height * 0.055).max(MIN_TIMELINE_HEIGHT)..=(height * 0.32).max(MIN_TIMELINE_HEIGHT))
        .show(ui, |ui| {
            ui.horizontal_top(|ui| {
                transport::ui(ui, model, commands);
                timeline::ui(ui, model, commands);
            });
        });
}

fn left_panel(ui: &mut Ui, model: &Model, screen: Rect, commands: &mut Vec<Command>) {
    let width = screen.width();
    let side = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 8));
    let panel = Panel::left("settings").frame(side).resizable(true);
    // Panel sizes persist across windows of other sizes: the views must keep most of a smaller window, and nothing may
    // be lost in a larger one.
    panel
        .default_size((width * 0.165).clamp(244.0, 360.0))
        .size_range((width * 0.09).max(MIN_SETTINGS_WIDTH)..=(width * 0.3).max(MIN_SETTINGS_WIDTH))
        .show(ui, |ui| settings_panel::ui(ui, model, commands));
}

/// The chosen pixel or object, above the list of events. Returns the requested action of the inspector.
fn right_panel(
    ui: &mut Ui,
    model: &Model,
    inspector: &mut Inspector,
    screen: Rect,
    commands: &mut Vec<Command>,
) -> Option<InspectorAction> {
    let width = screen.width();
    let side = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 8));
    let most = (width * 0.36).min(ui.available_width() - MIN_VIEWS_WIDTH).max(MIN_INSPECTOR_WIDTH);
    let panel = Panel::right("inspector")
        .frame(side)
        .resizable(true)
        .default_size((width * 0.235).clamp(232.0, 720.0))
        .size_range((width * 0.13).clamp(MIN_INSPECTOR_WIDTH, most)..=most);
    panel
        .show(ui, |ui| {
            events_list(ui, model, commands);
            subject_choice::ui(ui, model, commands);
            if model.selection.subject == Subject::Object {
                object_panel::ui(ui, model, commands);
                return None;
            }
            inspect(ui, model, inspector)
        })
        .inner
}

fn events_list(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    let third = ui.available_height() * 0.36;
    // The height of the list persists across windows; in a lower one, the pixel's plots must stay readable.
    let least = if model.selection.event.is_some() { MIN_EVIDENCE_HEIGHT } else { MIN_EVENTS_HEIGHT };
    let most = (ui.available_height() - MIN_INSPECTOR_HEIGHT).clamp(least, 1.4 * third.max(least));
    let below = Frame::NONE.inner_margin(Margin { top: 8, ..Margin::ZERO });
    Panel::bottom("events")
        .frame(below)
        .resizable(true)
        .default_size(third.clamp(least, most))
        .size_range((0.5 * third).clamp(least, most)..=most)
        .show(ui, |ui| {
            events_panel::ui(ui, model, commands);
            // A panel shrinks to its content: a short list must not shrink it.
            ui.take_available_space();
        });
}

fn inspect(ui: &mut Ui, model: &Model, inspector: &mut Inspector) -> Option<InspectorAction> {
    let slot = model.edits.ab_settings.in_view;
    inspector.names = [slot.name(), slot.other().name()];
    let pins: Vec<_> = model.playback.marks.pins.iter().collect();
    let worker = &model.worker;
    let state = worker.state.as_ref();
    let context = InspectorContext {
        chosen: model.selection.pixel,
        placement: worker.placement(),
        pins: &pins,
        histories: state.map_or(&[], |state| &state.pins),
        lost: state.map_or(&[], |state| &state.lost),
        progress: state.and_then(|state| state.pixel_progress.as_ref()),
        shares: worker.region_shares(model.selection.pixel),
        accuracy: RegionAccuracy { has_masks: model.has_true_masks(), tuning: worker.region_tuning() },
    };
    let times =
        FrameTimes { fps: worker.fps(), times: worker.timeline().map_or(&[], |timeline| &timeline.times) };
    inspector.ui(ui, worker.shown(), worker.pixel(), worker.tuning(), times, &context)
}
