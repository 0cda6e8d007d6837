//! The frame in view and the pointer on a plot over all frames.

use eframe::egui::{Painter, Rangef, Response, Stroke, Tooltip, Ui, Visuals};

use super::action::InspectorAction;
use super::chart::ChartAxis;
use super::frame_times::FrameTimes;
use super::style;

/// The frame in view.
#[derive(Clone, Copy)]
pub(super) struct FramePosition<'a> {
    /// Its position, from 0.
    pub(super) index: usize,
    /// The times of the frames.
    pub(super) times: FrameTimes<'a>,
}

/// A line at the frame in view.
pub(super) fn mark(
    painter: &Painter,
    visuals: &Visuals,
    axis: ChartAxis,
    here: FramePosition<'_>,
    y: Rangef,
) {
    let x = axis.at(here.index as f64 + 0.5);
    painter.vline(x, y, Stroke::new(3.0, visuals.panel_fill.gamma_multiply(0.6)));
    painter.vline(x, y, Stroke::new(1.5, style::ink(visuals)));
}

/// The pointer on a plot: shows the frame under it, and goes to it on a click.
pub(super) fn go_to(
    ui: &Ui,
    response: &Response,
    axis: ChartAxis,
    frames: usize,
    words: impl FnOnce(&mut Ui, usize),
) -> Option<InspectorAction> {
    let frame_at = |x: f32| (axis.value(x).max(0.0) as usize).min(frames.saturating_sub(1));
    if let Some(pointer) = response.hover_pos().filter(|_| frames > 0) {
        let frame = frame_at(pointer.x);
        ui.painter().vline(axis.at(frame as f64 + 0.5), response.rect.y_range(), style::faint(ui.visuals()));
        Tooltip::for_widget(response).at_pointer().show(|ui| words(ui, frame));
    }
    let clicked = response.interact_pointer_pos().filter(|_| response.clicked() && frames > 0);
    clicked.map(|pointer| InspectorAction::GoTo(frame_at(pointer.x) as u32))
}
