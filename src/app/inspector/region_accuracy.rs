//! Accuracy of the mixture in the region around the chosen pixel under other settings, against ground-truth masks.

use std::sync::Arc;

use eframe::egui::{Rangef, RichText, Sense, Ui, Vec2};

use super::action::InspectorAction;
use super::chart::Columns;
use super::chosen_pixel::ChosenPixel;
use super::context::RegionAccuracy;
use super::grid::{self, Grid};
use super::plot::Plot;
use super::style::{self, small};
use super::{menu, region_size};
use crate::app::theme;
use crate::explain::tuning::{RegionTuning, TunableSetting};
use crate::palette;
use crate::truth::decisions::{Decisions, Measure};

/// Ratio of height to width of each map where there are two.
pub(super) const PAIRED_MAP_ASPECT: f32 = 0.48;

/// The side of the region, and the displayed measure.
pub(super) struct RegionAccuracyView {
    /// Side of the region, in pixels.
    pub(super) side: u32,
    measure: Measure,
}

impl Default for RegionAccuracyView {
    fn default() -> Self {
        Self { side: 9, measure: Measure::Right }
    }
}

impl RegionAccuracyView {
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &ChosenPixel<'_>,
        axes: [TunableSetting; 2],
        accuracy: &RegionAccuracy<'_>,
    ) -> Option<InspectorAction> {
        if !accuracy.has_masks {
            return nothing(ui);
        }
        let parameters = &chosen.history.parameters;
        let is_of_axes = |tuning: &RegionTuning| tuning.axes.each_ref().map(|axis| axis.setting) == axes;
        let tuning = accuracy.tuning.filter(|tuning| is_of_axes(tuning) && tuning.at == chosen.history.at);
        let current = tuning.filter(|tuning| tuning.parameters == *parameters);
        let measure = self.measure;
        let menu = |ui: &mut Ui| {
            let tuning = current?;
            let plot = || Plot::RegionAccuracy(chosen.slotted_history(), Arc::clone(tuning), measure);
            menu::of_plot(ui, "the accuracy map", plot)
        };
        let asked = menu::row(ui, menu, |ui| self.controls(ui));
        let ends = tuning.map(|tuning| ends(tuning, self.measure));
        let [across, up] = axes.map(TunableSetting::symbol);
        let what = self.measure.name();
        let name = format!("Map of {what} against the ground truth; X axis {across}, Y axis {up}");
        let value = |tuning: &RegionTuning, column: usize, row: usize| {
            let cell = tuning.cells.get(row * tuning.axes[0].values.len() + column);
            cell.copied().unwrap_or_default()
        };
        let pale = if current.is_some() { 1.0 } else { 0.4 };
        let taken = match tuning.zip(ends) {
            None => grid::ui(ui, &name, PAIRED_MAP_ASPECT, None),
            Some((tuning, (low, high))) => {
                let colour = |column, row| {
                    let share = (self.measure.of(value(tuning, column, row)) - low) / (high - low).max(1e-9);
                    theme::rgb(palette::ramp(share as f32)).gamma_multiply(pale)
                };
                let words = |column, row| self.words(value(tuning, column, row));
                let grid = Grid {
                    axes: &tuning.axes,
                    parameters,
                    colour: &colour,
                    words: &words,
                    marked: best(tuning, self.measure),
                };
                grid::ui(ui, &name, PAIRED_MAP_ASPECT, Some(&grid))
            }
        };
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 5.0;
            if let Some((low, high)) = ends {
                ramp(ui, low, high);
            }
            grid::legend_of_ring(ui);
            grid::legend_of_cross(ui);
        });
        let best = current.and_then(|tuning| self.summary(ui, tuning));
        taken.or(best).or(asked)
    }

    fn controls(&mut self, ui: &mut Ui) {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.spacing_mut().button_padding.x = 5.0;
        ui.label(RichText::new("Accuracy in neighbourhood").strong()).on_hover_text(
            "Accuracy of the mixture's verdicts before post-processing under these settings, over the \
             neighbourhood of the selected pixel and all frames with a ground-truth mask. Each cell is \
             computed by re-running these pixels from the first frame.",
        );
        ui.add_space(4.0);
        region_size::choice(ui, &mut self.side);
        ui.add_space(6.0);
        for measure in Measure::ALL {
            let label = ui.selectable_label(self.measure == measure, small(measure.short()));
            if label.on_hover_text(measure.meaning()).clicked() {
                self.measure = measure;
            }
        }
    }

    /// The value of the measure, with the counts behind it.
    fn words(&self, decisions: Decisions) -> String {
        let Decisions { fp, fn_, .. } = decisions;
        let value = match self.measure {
            Measure::Right => format!("accuracy {:.2} % of {}", 100.0 * decisions.right(), decisions.all()),
            Measure::F => format!("F {:.4}", decisions.f_measure()),
        };
        format!("{value}: FP {fp}, FN {fn_}.")
    }

    /// The present and the best accuracy, with a button that applies the best settings.
    fn summary(&self, ui: &mut Ui, tuning: &RegionTuning) -> Option<InspectorAction> {
        if tuning.present.all() == 0 {
            ui.label(style::aside(ui, "The ground truth ignores all of these pixels."));
            return None;
        }
        ui.label(small(&format!("Current: {}", self.words(tuning.present))))
            .on_hover_text(format!("Over {} frames with a ground-truth mask", tuning.frames));
        let Some(at) = best(tuning, self.measure) else {
            ui.label(style::aside(ui, "None of these settings is better."));
            return None;
        };
        let values = grid::values(&tuning.axes, at)?;
        let decisions = tuning.cells.get(at.1 * tuning.axes[0].values.len() + at.0)?;
        let mut taken = None;
        ui.horizontal_wrapped(|ui| {
            ui.label(small(&format!("Best: {}", self.words(*decisions))));
            let button = ui.small_button(small(&grid::words(values)));
            if button.on_hover_text("Apply the best of these settings").clicked() {
                taken = Some(InspectorAction::Apply(values));
            }
        });
        taken
    }
}

/// The message where there are no ground-truth masks.
fn nothing(ui: &mut Ui) -> Option<InspectorAction> {
    ui.label(RichText::new("Accuracy in neighbourhood").strong());
    let text = "Requires ground-truth masks: maps the accuracy of each of these settings in the \
     neighbourhood of this pixel.";
    ui.label(style::aside(ui, text));
    let button = ui.small_button(small("Load ground truth folder…"));
    let button = button.on_hover_text("Load a CDnet folder or a scene written by synth");
    button.clicked().then_some(InspectorAction::LoadTruth)
}

/// Minimum and maximum over the map and the present settings.
fn ends(tuning: &RegionTuning, measure: Measure) -> (f64, f64) {
    let all = tuning.cells.iter().map(|&decisions| measure.of(decisions));
    all.fold((measure.of(tuning.present), measure.of(tuning.present)), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// The best cell, if it is better than the present settings. Of equal cells, the one nearest to them.
fn best(tuning: &RegionTuning, measure: Measure) -> Option<(usize, usize)> {
    let [x, y] = &tuning.axes;
    let here = [x, y].map(|axis| axis.share_of(axis.setting.get(&tuning.parameters)));
    let columns = x.values.len().max(1);
    let cells = tuning.cells.iter().enumerate().map(|(index, &decisions)| {
        let at = (index % columns, index / columns);
        let share = |axis: &crate::explain::tuning::SettingAxis, cell: usize| {
            (cell as f32 + 0.5) / axis.values.len().max(1) as f32
        };
        let away = (share(x, at.0) - here[0]).hypot(share(y, at.1) - here[1]);
        (at, measure.of(decisions), away)
    });
    let best = cells.max_by(|a, b| a.1.total_cmp(&b.1).then(b.2.total_cmp(&a.2)))?;
    (best.1 > measure.of(tuning.present)).then_some(best.0)
}

/// The colour scale, with the values at both ends.
fn ramp(ui: &mut Ui, low: f64, high: f64) {
    ui.label(style::aside(ui, &format!("{low:.3}")));
    let (rect, _) = ui.allocate_exact_size(Vec2::new(64.0, 10.0), Sense::hover());
    let mut columns = Columns::default();
    for step in 0..32_u8 {
        let at = |step: u8| rect.left() + rect.width() * f32::from(step) / 32.0;
        let colour = theme::rgb(palette::ramp(f32::from(step) / 31.0));
        columns.add(Rangef::new(at(step), at(step + 1)), rect.top(), rect.bottom(), colour);
    }
    columns.paint(ui.painter());
    ui.label(style::aside(ui, &format!("{high:.3}")));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::tuning::grid;
    use crate::mixture::Parameters;
    use crate::settings::Settings;

    #[test]
    fn the_best_cell_beats_the_present_settings_and_ties_go_to_the_nearest() {
        let parameters = Parameters::new(&Settings::default());
        let (axes, cells) = grid(&parameters, [TunableSetting::Alpha, TunableSetting::T]);
        let present = Decisions { tp: 5, fp: 1, fn_: 5, tn: 9 };
        let mut tuning = RegionTuning {
            at: (0, 0),
            side: 5,
            parameters,
            extent: [5, 5],
            frames: 1,
            present,
            axes,
            cells: vec![present; cells.len()],
        };
        assert_eq!(best(&tuning, Measure::Right), None);
        let better = Decisions { tp: 6, fn_: 4, ..present };
        let [x, y] = &tuning.axes;
        let near = (x.cell_at(x.share_of(parameters.alpha)), y.cell_at(y.share_of(parameters.t)));
        let columns = x.values.len();
        tuning.cells[near.1 * columns + near.0] = better;
        tuning.cells[0] = better;
        assert_eq!(best(&tuning, Measure::Right), Some(near));
        assert_eq!(best(&tuning, Measure::F), Some(near));
        let (low, high) = ends(&tuning, Measure::Right);
        assert_eq!((low, high), (0.7, 0.75));
    }
}
