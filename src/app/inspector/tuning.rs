//! The pixel under other settings: a map of the verdict over two settings, the values that flip the verdict, and, with
//! ground truth, the accuracy.

use std::time::Duration;

use eframe::egui::{Align2, Pos2, Rect, RichText, Sense, Ui, Vec2};

use super::action::InspectorAction;
use super::chosen_pixel::ChosenPixel;
use super::context::RegionAccuracy;
use super::grid::{self, Grid};
use super::menu;
use super::plot::Plot;
use super::region_accuracy::{PAIRED_MAP_ASPECT, RegionAccuracyView};
use super::style::{self, small};
use crate::explain::pixel::verdict::number;
use crate::explain::tuning::{TunableSetting, Tuning, VerdictFlip, VerdictMap};

/// Ratio of height to width of a single map, so that the list below it stays visible.
const SINGLE_MAP_ASPECT: f32 = 0.62;
/// Minimum width at which the accuracy map is beside the verdict map; below, it is under it.
const MIN_SIDE_BY_SIDE_WIDTH: f32 = 560.0;
/// A result that is outdated for this many seconds is drawn pale.
const STALE_AFTER_SECONDS: f64 = 0.15;

/// Opacities of background and foreground. A large area of either must not hide the cross.
const VERDICT_OPACITIES: [f32; 2] = [0.34, 0.72];

/// The settings of the map.
pub(super) struct TuningView {
    pub(super) axes: [TunableSetting; 2],
    pub(super) accuracy: RegionAccuracyView,
    /// The time since which the result is outdated, in seconds of the window's clock.
    late_since: Option<f64>,
}

impl Default for TuningView {
    fn default() -> Self {
        Self {
            axes: [TunableSetting::Alpha, TunableSetting::T],
            accuracy: RegionAccuracyView::default(),
            late_since: None,
        }
    }
}

impl TuningView {
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &ChosenPixel<'_>,
        tuning: Option<&Tuning>,
        accuracy: &RegionAccuracy<'_>,
    ) -> Option<InspectorAction> {
        let tuning = tuning.filter(|tuning| tuning.at == chosen.history.at);
        let of_axes =
            tuning.filter(|tuning| tuning.map.axes.each_ref().map(|axis| axis.setting) == self.axes);
        let current = tuning.filter(|tuning| {
            tuning.position as usize == chosen.index && tuning.parameters == chosen.history.parameters
        });
        let asked = self.controls(ui, chosen, of_axes.filter(|_| current.is_some()));
        // The settings selected in this frame have no map yet.
        let of_axes =
            of_axes.filter(|tuning| tuning.map.axes.each_ref().map(|axis| axis.setting) == self.axes);
        let pale = self.is_late(ui, of_axes.is_some() && current.is_none());
        let flat = if accuracy.has_masks { PAIRED_MAP_ASPECT } else { SINGLE_MAP_ASPECT };
        let map = |ui: &mut Ui| {
            let taken = map_ui(ui, chosen, self.axes, of_axes.map(|tuning| &tuning.map), pale, flat);
            ui.horizontal_wrapped(legend);
            taken
        };
        let flips = |ui: &mut Ui| flips_ui(ui, chosen, current.map(|tuning| &tuning.flips[..]));
        let mut of_truth = |ui: &mut Ui| self.accuracy.ui(ui, chosen, self.axes, accuracy);
        let taken = if ui.available_width() >= MIN_SIDE_BY_SIDE_WIDTH {
            let of_map = ui.columns(2, |columns| {
                let heading = |ui: &mut Ui| {
                    ui.label(RichText::new("This pixel in this frame").strong());
                };
                menu::row(&mut columns[0], |_| None, heading);
                let of_map = map(&mut columns[0]);
                of_map.or(of_truth(&mut columns[1]))
            });
            ui.add_space(6.0);
            of_map.or(flips(ui))
        } else {
            // The map comes first, then the values that flip the verdict.
            let of_map = map(ui);
            ui.add_space(6.0);
            let of_map = if accuracy.has_masks { of_map.or(of_truth(ui)) } else { of_map.or(flips(ui)) };
            ui.add_space(8.0);
            if accuracy.has_masks { of_map.or(flips(ui)) } else { of_map.or(of_truth(ui)) }
        };
        ui.add_space(8.0);
        taken.or(asked)
    }

    fn controls(
        &mut self,
        ui: &mut Ui,
        chosen: &ChosenPixel<'_>,
        map: Option<&Tuning>,
    ) -> Option<InspectorAction> {
        let mut asked = None;
        for (side, name) in ["X axis", "Y axis"].into_iter().enumerate() {
            let menu = |ui: &mut Ui| {
                let map = map.filter(|_| side == 0)?;
                menu::of_plot(ui, "the map", || Plot::Map(chosen.slotted_history(), Box::new(map.clone())))
            };
            asked = asked.or(menu::row(ui, menu, |ui| self.choose_axis(ui, side, name)));
        }
        asked
    }

    fn choose_axis(&mut self, ui: &mut Ui, side: usize, name: &str) {
        ui.spacing_mut().item_spacing.x = 2.0;
        let (rect, _) = ui.allocate_exact_size(Vec2::new(38.0, 16.0), Sense::hover());
        let (painter, visuals) = (ui.painter(), ui.visuals());
        painter.text(rect.left_center(), Align2::LEFT_CENTER, name, style::font(), style::muted(visuals));
        for setting in TunableSetting::ALL {
            let label = ui.selectable_label(self.axes[side] == setting, setting.symbol());
            let label = label.on_hover_text(format!("{}: {}, {name}", setting.symbol(), setting.name()));
            if label.clicked() && self.axes[side] != setting {
                // Selecting the other axis' setting swaps the axes.
                if self.axes[1 - side] == setting {
                    self.axes.swap(0, 1);
                } else {
                    self.axes[side] = setting;
                }
            }
        }
    }

    /// Whether the result has been outdated for long enough to be drawn pale. During playback it is outdated for a
    /// moment in every frame; drawing that pale would flicker.
    fn is_late(&mut self, ui: &Ui, behind: bool) -> bool {
        if !behind {
            self.late_since = None;
            return false;
        }
        let now = ui.input(|input| input.time);
        let since = *self.late_since.get_or_insert(now);
        ui.ctx().request_repaint_after(Duration::from_secs_f64(STALE_AFTER_SECONDS));
        now - since > STALE_AFTER_SECONDS
    }
}

/// The legend of the colours and the cross.
fn legend(ui: &mut Ui) {
    ui.spacing_mut().item_spacing.x = 4.0;
    for (foreground, name) in [(true, "foreground"), (false, "background")] {
        let (rect, _) = ui.allocate_exact_size(Vec2::new(12.0, 10.0), Sense::hover());
        let strength = VERDICT_OPACITIES[usize::from(foreground)];
        let colour = style::verdict_colour(ui.visuals(), foreground).gamma_multiply(strength);
        let plate = Rect::from_center_size(rect.center(), Vec2::new(12.0, 8.0));
        ui.painter().rect_filled(plate, 1.0, colour);
        ui.label(style::aside(ui, name));
    }
    grid::legend_of_cross(ui);
}

fn map_ui(
    ui: &mut Ui,
    chosen: &ChosenPixel<'_>,
    axes: [TunableSetting; 2],
    map: Option<&VerdictMap>,
    pale: bool,
    flat: f32,
) -> Option<InspectorAction> {
    let [across, up] = axes.map(TunableSetting::symbol);
    let share = map.map_or("not computed yet".to_owned(), |map| {
        format!("foreground in {:.0} % of cells", map.foreground_share() * 100.0)
    });
    let name = format!("Tuning map, X axis {across}, Y axis {up}, {share}");
    let strength = if pale { 0.4 } else { 1.0 };
    let colours = [false, true].map(|foreground| {
        style::verdict_colour(ui.visuals(), foreground)
            .gamma_multiply(VERDICT_OPACITIES[usize::from(foreground)] * strength)
    });
    let Some(map) = map else { return grid::ui(ui, &name, flat, None) };
    let colour = |column, row| colours[usize::from(map.is_foreground(column, row))];
    let words =
        |column, row| if map.is_foreground(column, row) { "Foreground." } else { "Background." }.to_owned();
    let parameters = &chosen.history.parameters;
    let grid = Grid { axes: &map.axes, parameters, colour: &colour, words: &words, marked: None };
    grid::ui(ui, &name, flat, Some(&grid))
}

/// For each setting alone, the nearest value that flips the verdict.
fn flips_ui(ui: &mut Ui, chosen: &ChosenPixel<'_>, flips: Option<&[VerdictFlip]>) -> Option<InspectorAction> {
    ui.label(RichText::new("Single changes that flip this pixel").strong()).on_hover_text(
        "For each setting, the nearest value at which the mixture's verdict for this pixel in this frame \
         is the other one. Computed by re-running the pixel from the first frame.",
    );
    let mut taken = None;
    for (at, setting) in TunableSetting::ALL.into_iter().enumerate() {
        let flip = flips.and_then(|flips| flips.iter().find(|flip| flip.setting == setting));
        let present = setting.get(&chosen.history.parameters);
        let height = style::SMALL_TEXT + 9.0;
        let (row, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::hover());
        if at % 2 == 0 {
            ui.painter().rect_filled(row, 2.0, ui.visuals().faint_bg_color);
        }
        let visuals = ui.visuals();
        let text = |x: f32, text: &str, colour| {
            let place = Pos2::new(row.left() + x, row.center().y);
            ui.painter().text(place, Align2::LEFT_CENTER, text, style::font(), colour);
        };
        // A narrow panel has no space for the name; the map shows it too.
        let name = if row.width() < 270.0 { "" } else { setting.name() };
        let left = if name.is_empty() { 26.0 } else { 124.0 };
        text(6.0, setting.symbol(), visuals.text_color());
        text(26.0, name, style::muted(visuals));
        text(left, &format!("now {}", number(present)), style::muted(visuals));
        let place = Rect::from_min_max(Pos2::new(row.left() + left + 72.0, row.top()), row.right_bottom());
        ui.scope_builder(eframe::egui::UiBuilder::new().max_rect(place), |ui| {
            ui.horizontal_centered(|ui| match flip {
                None => {
                    ui.label(style::aside(ui, "…"));
                }
                Some(flip @ VerdictFlip { value: Some(value), .. }) => {
                    let button = ui.small_button(small(&flip.words()));
                    let says = format!("Set {} to {value}", setting.symbol());
                    if button.on_hover_text(says).clicked() {
                        // The same setting twice, so that no other setting changes.
                        taken = Some(InspectorAction::Apply([(setting, *value); 2]));
                    }
                }
                Some(flip) => {
                    ui.label(style::aside(ui, &flip.words()));
                }
            });
        });
    }
    taken
}
