//! The pixel history: values, components, weights, B, ρ, component changes and verdict over time.

use std::ops::Range;
use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align2, Pos2, Rangef, Rect, Response, Sense, Shape, Stroke, Tooltip, Ui, Vec2, WidgetInfo,
};

use super::action::InspectorAction;
use super::chart::{self, ChartAxis, Columns, TICKS_HEIGHT};
use super::chosen_pixel::ChosenPixel;
use super::menu;
use super::plot::Plot;
use super::rows::{LANE_HEIGHT, changes_plot, channel_plot, count_plot, rates_plot, weights_plot, x_range};
use super::style::{self, small};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_slots::{ComponentChange, component_change};
use crate::explain::pixel::downsampled_history::{HistoryColumn, downsample, value_range};
use crate::explain::pixel::verdict::{number, verdict};
use crate::export::figure::through_time::HistorySelection;

/// Minimum number of visible frames.
const MIN_SHOWN_FRAMES: f64 = 8.0;
// Heights of the parts, in points, from top to bottom.
const CAPTION_HEIGHT: f32 = 15.0;
const GAP_HEIGHT: f32 = 5.0;
const CHANNEL_HEIGHT: f32 = 62.0;
const WEIGHTS_HEIGHT: f32 = 60.0;
const COUNT_HEIGHT: f32 = 26.0;
const RATE_HEIGHT: f32 = 34.0;
const VERDICT_HEIGHT: f32 = 10.0;

/// The visible frames, and the cached columns.
#[derive(Default)]
pub(super) struct HistoryView {
    /// First and last visible position; `None` for all.
    view: Option<(f64, f64)>,
    /// Whether the value axes fit the visible values instead of 0..255.
    fit: bool,
    /// The previous frame in view, to detect when it leaves the visible range.
    index: usize,
    cache: Option<CachedColumns>,
}

/// Cached columns, recomputed only for another history, range or width.
struct CachedColumns {
    history: Arc<PixelHistory>,
    frames: Range<usize>,
    columns: usize,
    bins: Vec<HistoryColumn>,
}

impl HistoryView {
    pub(super) fn ui(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>) -> Option<InspectorAction> {
        let total = chosen.history.states.len();
        let asked = self.controls(ui, chosen);
        legend(ui, chosen);

        let channels = chosen.channels().len() as f32;
        let rows = CHANNEL_HEIGHT * channels
            + WEIGHTS_HEIGHT
            + COUNT_HEIGHT
            + RATE_HEIGHT
            + 3.0 * LANE_HEIGHT
            + VERDICT_HEIGHT;
        let height = (CAPTION_HEIGHT + GAP_HEIGHT) * (channels + 5.0) + rows + TICKS_HEIGHT;
        let size = Vec2::new(ui.available_width(), height);
        let (area, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        response.widget_info(|| {
            WidgetInfo::labeled(
                Role::Image,
                true,
                format!("History of {total} frames; click to go to a frame"),
            )
        });
        let plot = chart::inner(area);
        self.look_around(ui, &response, plot, chosen);

        let (from, to) = self.range(total);
        let axis = ChartAxis::x(from, to, plot);
        let frame_at = |x: f32| (axis.value(x).max(0.0) as usize).min(total.saturating_sub(1));
        if ui.is_rect_visible(area) {
            self.draw(ui, chosen, area, axis);
        }
        let hovered = response.hover_pos().filter(|_| !response.dragged()).map(|pointer| frame_at(pointer.x));
        let clicked = response.interact_pointer_pos().filter(|_| response.clicked());
        if let Some(frame) = hovered {
            let x = axis.at(frame as f64 + 0.5);
            ui.painter().with_clip_rect(area).vline(x, area.y_range(), style::faint(ui.visuals()));
            Tooltip::for_widget(&response).at_pointer().show(|ui| frame_words(ui, chosen, frame));
        }
        ui.add_space(8.0);
        let clicked = clicked.map(|pointer| InspectorAction::GoTo(frame_at(pointer.x) as u32));
        clicked.or(asked)
    }

    fn range(&self, total: usize) -> (f64, f64) {
        self.view.unwrap_or((0.0, total.max(1) as f64))
    }

    /// The figure's selection of the visible frames.
    fn choice(&self, chosen: &ChosenPixel<'_>) -> HistorySelection {
        let total = chosen.history.states.len();
        let (from, to) = self.range(total);
        let frames = from.floor() as usize..(to.ceil() as usize).min(total);
        HistorySelection { frames, index: chosen.index, fit: self.fit }
    }

    fn controls(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>) -> Option<InspectorAction> {
        let total = chosen.history.states.len();
        let choice = self.choice(chosen);
        let plot = || Plot::History(chosen.slotted_history(), choice.clone());
        menu::row(
            ui,
            |ui| menu::of_plot(ui, "the frames in view", plot),
            |ui| {
                ui.spacing_mut().item_spacing.x = 5.0;
                ui.label(style::aside(ui, "Zoom"));
                let centre = chosen.index as f64 + 0.5;
                if ui
                    .small_button("+")
                    .on_hover_text("Zoom in at the current frame (or Ctrl + scroll)")
                    .clicked()
                {
                    self.zoom(0.5, centre, total);
                }
                if ui.small_button("–").on_hover_text("Zoom out (or Ctrl + scroll)").clicked() {
                    self.zoom(2.0, centre, total);
                }
                if ui.small_button("All").on_hover_text("Show all frames").clicked() {
                    self.view = None;
                }
                ui.checkbox(&mut self.fit, small("fit values"))
                    .on_hover_text("Fit the value axes to the values in view, instead of 0 to 255");
            },
        )
    }

    /// Widens (factor over 1) or narrows the visible range around `centre`.
    fn zoom(&mut self, factor: f64, centre: f64, total: usize) {
        let (from, to) = self.range(total);
        let centre = centre.clamp(from, to);
        let width = (to - from) * factor;
        if width < MIN_SHOWN_FRAMES && factor < 1.0 {
            return;
        }
        let from = centre - (centre - from) * factor;
        self.set(from, from + width, total);
    }

    fn set(&mut self, from: f64, to: f64, total: usize) {
        let (all, width) = (total as f64, to - from);
        let from = from.min(all - width).max(0.0);
        self.view = (width < all).then_some((from, from + width));
    }

    /// Pans and zooms by the pointer, and scrolls to the frame in view when it leaves the visible range.
    fn look_around(&mut self, ui: &Ui, response: &Response, plot: Rect, chosen: &ChosenPixel<'_>) {
        let total = chosen.history.states.len();
        if let Some((from, to)) = self.view {
            // Another video, or a repeated run, may be shorter.
            self.set(from, to, total);
            let here = chosen.index as f64 + 0.5;
            if chosen.index != self.index && !(from..=to).contains(&here) {
                self.set(here - (to - from) / 2.0, here + (to - from) / 2.0, total);
            }
        }
        self.index = chosen.index;
        let (from, to) = self.range(total);
        let frames_per_point = (to - from) / f64::from(plot.width());
        let mut shift = 0.0;
        if response.dragged() {
            shift -= f64::from(response.drag_delta().x) * frames_per_point;
        }
        if let Some(pointer) = response.hover_pos() {
            let (zoom, scroll) = ui.input(|input| (input.zoom_delta(), input.smooth_scroll_delta().x));
            shift -= f64::from(scroll) * frames_per_point;
            if zoom != 1.0 {
                let centre = ChartAxis::x(from, to, plot).value(pointer.x);
                self.zoom(f64::from(1.0 / zoom), centre, total);
                return;
            }
        }
        if shift != 0.0 && self.view.is_some() {
            self.set(from + shift, to + shift, total);
        }
    }

    fn draw(&mut self, ui: &Ui, chosen: &ChosenPixel<'_>, area: Rect, axis: ChartAxis) {
        let frames = axis.min.floor() as usize..axis.max.ceil() as usize;
        let plot = chart::inner(area);
        let fit = self.fit;
        let bins = self.bins(chosen, frames, plot.width() as usize);
        let fit = fit.then(|| value_range(bins, chosen.channels().len()));
        let (low, high) = fit.unwrap_or((0.0, 255.0));

        let (painter, visuals) = (ui.painter_at(area), ui.visuals());
        let mut y = area.top();
        let mut rows = Vec::new();
        let mut row = |caption: &str, height: f32| {
            let place = Pos2::new(plot.left(), y + CAPTION_HEIGHT - 2.0);
            painter.text(place, Align2::LEFT_BOTTOM, caption, style::font(), style::muted(visuals));
            let top = y + CAPTION_HEIGHT;
            y = top + height + GAP_HEIGHT;
            let rect = Rect::from_x_y_ranges(plot.x_range(), Rangef::new(top, top + height));
            rows.push(rect.y_range());
            rect
        };
        let names: &[&str] = if chosen.channels().len() == 1 { &["luma"] } else { &["red", "green", "blue"] };
        for (channel, name) in names.iter().enumerate() {
            let rect = row(name, CHANNEL_HEIGHT);
            let values = ChartAxis::y(low, high, rect);
            channel_plot(
                &painter.with_clip_rect(rect.expand2(Vec2::new(0.0, 1.0)).intersect(painter.clip_rect())),
                visuals,
                bins,
                channel,
                axis,
                values,
            );
            chart::frame(&painter, rect, visuals);
            let labels: Vec<_> = if fit.is_some() {
                chart::ticks(low, high, 5)
                    .into_iter()
                    .map(|tick| (values.at(tick), format!("{tick}")))
                    .collect()
            } else {
                [0.0, 128.0, 255.0].map(|tick| (values.at(tick), format!("{tick}"))).to_vec()
            };
            chart::y_labels(&painter, rect.left(), &labels, visuals);
        }

        let t = chosen.history.parameters.t;
        let rect = row("weights, stacked by rank", WEIGHTS_HEIGHT);
        weights_plot(&painter, visuals, bins, axis, rect, t);

        let k = chosen.history.parameters.k;
        let rect = row("B, number of background components", COUNT_HEIGHT);
        count_plot(&painter, visuals, bins, axis, rect, k);

        let rect = row("ρ, update rate", RATE_HEIGHT);
        rates_plot(&painter, visuals, bins, axis, rect);

        let rect = row("components created, replaced, moved up in rank", 3.0 * LANE_HEIGHT);
        changes_plot(&painter, visuals, bins, axis, rect);

        let rect = row("mixture verdict", VERDICT_HEIGHT);
        let mut columns = Columns::default();
        for bin in bins {
            let colour = style::verdict_share(visuals, bin.foreground_share());
            columns.add(x_range(bin, axis), rect.top(), rect.bottom(), colour);
        }
        columns.paint(&painter.with_clip_rect(rect.intersect(painter.clip_rect())));

        let last =
            Rect::from_x_y_ranges(plot.x_range(), Rangef::new(area.top() + CAPTION_HEIGHT, rect.bottom()));
        let states = &chosen.history.states;
        let labels: Vec<_> = chart::ticks(axis.min, axis.max, (plot.width() / 60.0) as usize)
            .into_iter()
            .filter_map(|tick| {
                // Ticks use positions from 1, which equal the frame numbers of most videos.
                let position = (tick as usize).max(1) - 1;
                let state = states.get(position)?;
                Some((axis.at(position as f64 + 0.5), state.number.to_string()))
            })
            .filter(|(x, _)| last.x_range().contains(*x))
            .collect();
        chart::x_labels(&painter, last, &labels, visuals);

        let here = axis.at(chosen.index as f64 + 0.5);
        if last.x_range().contains(here) {
            for row in rows {
                painter.vline(here, row, Stroke::new(1.5, style::ink(visuals)));
            }
            let tip = Pos2::new(here, last.top() - 1.0);
            let shape = vec![tip, tip + Vec2::new(-4.0, -6.0), tip + Vec2::new(4.0, -6.0)];
            painter.add(Shape::convex_polygon(shape, style::ink(visuals), Stroke::NONE));
        }
    }

    /// Drops all cached columns.
    pub(super) fn forget(&mut self) {
        self.cache = None;
    }

    fn bins(&mut self, chosen: &ChosenPixel<'_>, frames: Range<usize>, columns: usize) -> &[HistoryColumn] {
        let fits = self.cache.as_mut().is_some_and(|cache| {
            let same = (&cache.frames, cache.columns) == (&frames, columns);
            same && chosen.shares(&mut cache.history, frames.end)
        });
        if !fits {
            let bins = downsample(chosen.history, chosen.slots, frames.clone(), columns);
            self.cache = Some(CachedColumns { history: Arc::clone(chosen.history), frames, columns, bins });
        }
        self.cache.as_ref().map_or(&[], |cache| &cache.bins)
    }
}

/// The legend of component colours in the frame in view.
fn legend(ui: &mut Ui, chosen: &ChosenPixel<'_>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = Vec2::new(4.0, 1.0);
        let lambda = number(chosen.history.parameters.lambda);
        ui.label(style::aside(ui, &format!("Bands μ ± {lambda}σ, current rank:"))).on_hover_text(
            "A component keeps its colour when its rank changes. A new component takes the colour of \
                 the replaced one. Strong bands: background; pale bands: foreground.",
        );
        let slots = chosen.slots[chosen.index];
        for (rank, slot) in slots.iter().enumerate().take(chosen.state.pixel.used()) {
            let (rect, _) = ui.allocate_exact_size(Vec2::new(12.0, 10.0), Sense::hover());
            let colour = style::component(ui.visuals(), *slot);
            let plate = Rect::from_center_size(rect.center(), Vec2::new(12.0, 8.0));
            ui.painter().rect_filled(plate, 1.0, colour.gamma_multiply(0.4));
            ui.painter().hline(plate.x_range(), plate.center().y, Stroke::new(1.5, colour));
            ui.label(small(&(rank + 1).to_string()));
        }
        ui.label(style::aside(ui, "pale: foreground"));
    });
}

/// The tooltip of the frame under the pointer.
fn frame_words(ui: &mut Ui, chosen: &ChosenPixel<'_>, frame: usize) {
    let Some(state) = chosen.history.states.get(frame) else { return };
    let words = verdict(chosen.history, frame);
    ui.set_max_width(260.0);
    ui.label(format!("Frame {}, {} s", state.number, chosen.times.text(frame)));
    let values = chosen.channels().iter().zip(state.value);
    let values: Vec<_> = values.map(|(name, value)| format!("{name} {value}")).collect();
    ui.label(small(&format!("{}, B = {}", values.join("  "), state.outcome.background_count)));
    ui.label(small(&words.headline));
    let rank = state.outcome.rank;
    let changed = match component_change(chosen.history, frame) {
        None => return,
        Some(ComponentChange::Born) => format!("Component {rank} was created."),
        Some(ComponentChange::Replaced) => format!("Component {rank} replaced the last one."),
        Some(ComponentChange::Rose { from, to }) => format!("It moved up from rank {from} to {to}."),
    };
    ui.label(small(&changed));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::app::inspector::FrameTimes;
    use crate::explain::pixel::component_slots::slots_by_rank;
    use crate::mixture::Parameters;
    use crate::settings::Settings;

    fn of_level(level: u8) -> Arc<PixelHistory> {
        let colours = (1..=50).map(|number| (number, [level; 3]));
        Arc::new(PixelHistory::of_colours((1, 2), Parameters::new(&Settings::default()), colours))
    }

    #[test]
    fn columns_are_recomputed_only_for_another_history_range_or_width() {
        let mut view = HistoryView::default();
        let mut made = |history: &Arc<PixelHistory>, frames: Range<usize>, columns: usize| {
            let slots = Arc::new(slots_by_rank(history));
            let chosen = ChosenPixel {
                history,
                slots: &slots,
                index: 3,
                state: &history.states[3],
                times: FrameTimes { fps: 25.0, times: &[] },
            };
            let bins = view.bins(&chosen, frames, columns);
            (bins.as_ptr(), bins.len(), bins[0].value[0].0)
        };
        let (one, other) = (of_level(10), of_level(200));
        let first = made(&one, 0..50, 20);
        assert_eq!(first, made(&Arc::clone(&one), 0..50, 20), "the cached columns are reused");
        assert_eq!(made(&one, 10..50, 5).1, 5);
        assert_eq!(made(&other, 10..50, 5).2, 200.0);
        // A copy with equal states, as after the history has grown.
        assert_eq!(made(&of_level(10), 10..50, 5).2, 10.0);
        let zoomed = made(&one, 10..40, 5);
        let mut grown = PixelHistory::clone(&one);
        (51..=60).for_each(|number| grown.push_colour(number, [77; 3]));
        let grown = Arc::new(grown);
        assert_eq!(made(&grown, 10..40, 5), zoomed, "new frames do not change the visible columns");
        assert_eq!(made(&grown, 0..60, 20).1, 20);
    }

    #[test]
    fn zooming_keeps_the_centre_and_stays_within_the_history() {
        let mut view = HistoryView::default();
        view.zoom(0.5, 75.0, 100);
        assert_eq!(view.view, Some((37.5, 87.5)));
        view.zoom(2.0, 75.0, 100);
        assert_eq!(view.view, None, "the whole history is visible");
        for _ in 0..20 {
            view.zoom(0.5, 0.0, 100);
        }
        let (from, to) = view.range(100);
        assert!(from == 0.0 && to - from >= MIN_SHOWN_FRAMES);
        view.set(95.0, 105.0, 100);
        assert_eq!(view.range(100), (90.0, 100.0));
        view.set(-10.0, 0.0, 100);
        assert_eq!(view.range(100), (0.0, 10.0));
    }
}
