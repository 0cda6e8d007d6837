//! Statistics of the pixel over all frames or a range.

use std::ops::Range;
use std::sync::Arc;

use eframe::egui::{Align2, DragValue, Label, Pos2, Rect, Sense, Ui, Vec2};

use super::action::InspectorAction;
use super::chosen_pixel::ChosenPixel;
use super::menu;
use super::style::{self, small};
use super::table::Table;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::statistics::Statistics;
use crate::explain::pixel::verdict::number;

/// The range of frames, and the cached statistics.
#[derive(Default)]
pub(super) struct StatisticsView {
    /// The positions; `None` for all.
    part: Option<Range<usize>>,
    cache: Option<(Arc<PixelHistory>, Range<usize>, Statistics)>,
}

impl StatisticsView {
    pub(super) fn ui(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>) -> Option<InspectorAction> {
        self.controls(ui, chosen);
        ui.add_space(4.0);
        let range = self.range(chosen);
        let statistics = self.statistics(chosen, range.clone());
        let gray = chosen.channels().len() == 1;
        let each = |values: [f32; 3]| {
            let values = values.map(|value| format!("{value:.1}"));
            if gray { values[0].clone() } else { values.join("   ") }
        };
        let seconds = |frames: f32| number(frames / chosen.times.fps.max(f32::MIN_POSITIVE));
        let alpha = chosen.history.parameters.alpha;
        let frames = statistics.frames;
        let channels = chosen.channels().join(", ");
        let rows = [
            (
                "frames",
                format!("{frames},  {} s", seconds(frames as f32)),
                "Number of frames in the statistics",
            ),
            ("mean", format!("{}  levels", each(statistics.mean)), "Mean of each channel"),
            (
                "variance",
                format!("{}  levels²", each(statistics.variance)),
                "Variance of each channel over these frames, over all components",
            ),
            (
                "std. dev.",
                format!("{}  levels", each(statistics.variance.map(f32::sqrt))),
                "Standard deviation of each channel",
            ),
            (
                "foreground",
                format!(
                    "{:.1} %,  {} of {frames} frames",
                    statistics.foreground_share() * 100.0,
                    statistics.foreground
                ),
                "Number of frames with a foreground verdict of the mixture, before post-processing",
            ),
            (
                "created",
                statistics.births.to_string(),
                "Number of components created while fewer than K were in use; the first frame creates the \
                 first",
            ),
            (
                "replaced",
                statistics.replacements.to_string(),
                "Number of replacements of the last component: no match while all K components were in use",
            ),
            (
                "background, B",
                format!("{:.2} on average,  at most {}", statistics.mean_modes, statistics.most_modes),
                "Number of background components",
            ),
            (
                "in use",
                format!("{} of {} components", statistics.used, chosen.history.parameters.k),
                "Number of components in use at the end of these frames",
            ),
            (
                "1/α",
                format!("{} frames,  {} s", number(1.0 / alpha), seconds(1.0 / alpha)),
                "Time constant of the weights: an old weight decays to 37 % in this time",
            ),
        ];
        let history = || Arc::clone(chosen.history);
        let counted = || Table::Statistics(history(), range.clone());
        let frames = || Table::History(history(), range.clone());
        let tables = |ui: &mut Ui| {
            menu::of_tables(ui, "the numbers", &[("statistics", &counted), ("frames", &frames)])
        };
        let asked = menu::row(ui, tables, |ui| {
            ui.label(style::aside(ui, &format!("Value {channels} and mixture statistics over these frames")));
        });
        for (at, (name, value, meaning)) in rows.iter().enumerate() {
            row(ui, at, name, value, meaning);
        }
        ui.add_space(8.0);
        asked
    }

    fn range(&self, chosen: &ChosenPixel<'_>) -> Range<usize> {
        let total = chosen.history.states.len();
        match &self.part {
            // Another video, or a repeated run, may be shorter.
            Some(part) if part.start < total => part.start..part.end.min(total),
            _ => 0..total,
        }
    }

    fn controls(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>) {
        let states = &chosen.history.states;
        let range = self.range(chosen);
        let (Some(first), Some(last)) = (states.first(), states.last()) else { return };
        let number_at = |position: usize| states.get(position).map_or(last.number, |state| state.number);
        let (mut from, mut to) = (number_at(range.start), number_at(range.end.saturating_sub(1)));
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 5.0;
            let label = ui.label(style::aside(ui, "frames from"));
            let whole = first.number..=last.number;
            let drag = ui.add(DragValue::new(&mut from).range(whole.clone())).labelled_by(label.id);
            let mut changed = drag.changed();
            let label = ui.label(style::aside(ui, "to"));
            let drag = ui.add(DragValue::new(&mut to).range(whole)).labelled_by(label.id);
            changed |= drag.changed();
            if changed {
                let start = states.partition_point(|state| state.number < from.min(to));
                let end = states.partition_point(|state| state.number <= from.max(to));
                self.part = Some(start..end.max(start + 1));
            }
            if ui.small_button("All").on_hover_text("Use all frames").clicked() {
                self.part = None;
            }
            if ui
                .small_button("Up to current")
                .on_hover_text("Use the frames up to the current one")
                .clicked()
            {
                self.part = Some(0..chosen.index + 1);
            }
        });
    }

    /// Drops the cached statistics.
    pub(super) fn forget(&mut self) {
        self.cache = None;
    }

    /// The statistics, recomputed only for another history or range.
    fn statistics(&mut self, chosen: &ChosenPixel<'_>, range: Range<usize>) -> Statistics {
        if let Some((of, frames, statistics)) = &mut self.cache
            && *frames == range
            && chosen.shares(of, range.end)
        {
            return *statistics;
        }
        let statistics = Statistics::new(chosen.history, range.clone());
        self.cache = Some((Arc::clone(chosen.history), range, statistics));
        statistics
    }
}

fn row(ui: &mut Ui, at: usize, name: &str, value: &str, meaning: &str) {
    let height = style::SMALL_TEXT + 8.0;
    let (area, response) = ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::hover());
    response.on_hover_text(meaning);
    if at.is_multiple_of(2) {
        ui.painter().rect_filled(area, 2.0, ui.visuals().faint_bg_color);
    }
    let place = Pos2::new(area.left() + 6.0, area.center().y);
    ui.painter().text(place, Align2::LEFT_CENTER, name, style::font(), style::muted(ui.visuals()));
    let left = if area.width() < 250.0 { 80.0 } else { 92.0 };
    let place = Rect::from_min_max(Pos2::new(area.left() + left, area.top()), area.right_bottom());
    let layout = eframe::egui::Layout::left_to_right(eframe::egui::Align::Center);
    let builder = eframe::egui::UiBuilder::new().max_rect(place).layout(layout).id_salt(name);
    ui.new_child(builder).add(Label::new(small(value)).truncate());
}
