//! Several pixels at once: the pinned pixels as small multiples, and the foreground ratio around the chosen pixel.

use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align, Align2, Button, Color32, Label, Layout, Painter, Pos2, Rangef, Rect, Response, RichText, Sense,
    Shape, Stroke, Tooltip, Ui, UiBuilder, Visuals, WidgetInfo, vec2,
};
use egui_material_icons::icons as m;

use super::chart::{self, ChartAxis, Columns, TICKS};
use super::menu;
use super::plot::Plot;
use super::style::{self, small};
use super::{InspectorAction, InspectorContext, region_size};
use crate::app::model::pins;
use crate::app::theme;
use crate::explain::pixel::sparklines::{SparklineColumn, level_range, sparkline};
use crate::explain::pixel::{PixelHistory, PixelState};
use crate::export::figure::region::{Peak, peaks};
use crate::replay::RegionShares;

const SHARES: f32 = 64.0;
const SPARK: f32 = 34.0;
const STRIP: f32 = 5.0;

/// The side of the region, and the cached columns.
pub(super) struct PixelsView {
    /// Side of the region, in pixels.
    pub(super) side: u32,
    cache: Vec<Cache>,
    curve: Option<Curve>,
}

/// Columns of the region, recomputed only for other ratios or another width.
struct Curve {
    shares: Arc<RegionShares>,
    columns: usize,
    peaks: Vec<Peak>,
}

impl Default for PixelsView {
    fn default() -> Self {
        Self { side: 5, cache: Vec::new(), curve: None }
    }
}

/// Columns of one pin, recomputed only for another history or width.
struct Cache {
    history: Arc<PixelHistory>,
    columns: usize,
    /// The number of frames on the axis; the history may have fewer.
    frames: usize,
    sparks: Vec<SparklineColumn>,
}

const COMPUTING_HISTORY: &str = "Computing history…";
const LOST: &str = "Not available: this live source no longer has the first frames.";

/// The frame in view.
#[derive(Clone, Copy)]
pub(super) struct FramePosition {
    /// Its position, from 0.
    pub(super) index: usize,
    /// The source's frame rate.
    pub(super) fps: f32,
}

impl PixelsView {
    /// Draws the region around `chosen` and the pins.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &Arc<PixelHistory>,
        here: FramePosition,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        let region = self.region_ui(ui, chosen, here, context.region);
        ui.add_space(10.0);
        self.pins_ui(ui, here, context).or(region)
    }

    /// Drops all cached columns.
    pub(super) fn forget(&mut self) {
        self.cache.clear();
        self.curve = None;
    }

    fn region_ui(
        &mut self,
        ui: &mut Ui,
        chosen: &Arc<PixelHistory>,
        here: FramePosition,
        shares: Option<&Arc<RegionShares>>,
    ) -> Option<InspectorAction> {
        let shares = shares.filter(|shares| shares.side == self.side && shares.at == chosen.at);
        let taken = |ui: &mut Ui| {
            let shares = shares?;
            let plot = || Plot::Region(Arc::clone(chosen), Arc::clone(shares), here.index);
            menu::of_plot(ui, "the foreground ratio", plot)
        };
        let taken = menu::row(ui, taken, |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 5.0;
            ui.label(RichText::new("Foreground ratio in neighbourhood").strong()).on_hover_text(
                "Ratio of foreground pixels in the neighbourhood of the selected pixel, per frame. It is \
                 less noisy than the verdict of a single pixel.",
            );
            ui.add_space(4.0);
            region_size::choice(ui, &mut self.side);
        });
        let asked = self.shares_ui(ui, here, shares);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let (rect, _) = ui.allocate_exact_size(vec2(12.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect.shrink2(vec2(0.0, 1.0)), 1.0, area_colour(ui.visuals()));
            ui.label(style::aside(ui, "after post-processing"));
            let (rect, _) = ui.allocate_exact_size(vec2(12.0, 10.0), Sense::hover());
            ui.painter().hline(rect.x_range(), rect.center().y, Stroke::new(1.5, style::ink(ui.visuals())));
            ui.label(style::aside(ui, "mixture verdicts"));
        });
        asked.or(taken)
    }

    /// The pins, stacked.
    pub(super) fn pins_ui(
        &mut self,
        ui: &mut Ui,
        here: FramePosition,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        self.cache
            .retain(|cache| context.histories.iter().any(|history| Arc::ptr_eq(&cache.history, history)));
        let known = |at| context.histories.iter().find(|history| history.at == at);
        let taken = |ui: &mut Ui| {
            let pins =
                || context.pins.iter().filter_map(|&(number, at)| Some((number, Arc::clone(known(at)?))));
            pins().next()?;
            menu::of_plot(ui, "the pinned pixels", || Plot::Pins(pins().collect(), here.index))
        };
        let mut asked = menu::row(ui, taken, |ui| {
            ui.label(RichText::new("Pinned pixels").strong()).on_hover_text(
                "Up to eight pixels, saved with the video. Brightness over all frames with the band μ ± λσ \
                 of each background component, and the mixture verdict below. Click to go to a frame.",
            );
        });
        if context.pins.is_empty() {
            ui.label(style::aside(
                ui,
                "No pinned pixels. Pin the selected pixel (D, or the pin icon above) to compare it with \
                 others.",
            ));
            return None;
        }
        let frames = context.histories.iter().map(|history| history.states.len()).max().unwrap_or(0);
        for &(number, at) in context.pins {
            ui.add_space(4.0);
            let history = known(at);
            let state = history.and_then(|history| history.states.get(here.index));
            asked = pin_row(ui, number, at, state, context.chosen == Some(at)).or(asked);
            let (area, response) =
                ui.allocate_exact_size(vec2(ui.available_width(), SPARK + STRIP + 3.0), Sense::click());
            let (x, y) = at;
            response.widget_info(|| {
                let name =
                    format!("Pinned pixel {number} at {x}, {y} over all frames; click to go to a frame");
                WidgetInfo::labeled(Role::Image, true, name)
            });
            let axis = ChartAxis::x(0.0, frames.max(1) as f64, area);
            match history {
                Some(history) if ui.is_rect_visible(area) => {
                    let sparks = self.sparks(history, area.width() as usize, frames);
                    draw(ui, area, sparks, pins::colour(number), axis, here);
                }
                Some(_) => {}
                None => {
                    let text = if context.lost.contains(&at) { LOST } else { COMPUTING_HISTORY };
                    let text = Label::new(style::aside(ui, text)).wrap();
                    ui.new_child(UiBuilder::new().max_rect(area)).add(text);
                }
            }
            asked = go_to(ui, &response, axis, frames, |ui, frame| {
                let state = history.and_then(|history| history.states.get(frame));
                let Some(state) = state else { return };
                ui.label(format!("Frame {}, {} s", state.number, style::seconds(frame, here.fps)));
                ui.label(small(&format!("{}: {}", values(state), word(state.outcome.foreground))));
            })
            .or(asked);
        }
        ui.add_space(8.0);
        asked
    }

    /// The foreground ratio of each frame: after post-processing as an area, before it as a line.
    fn shares_ui(
        &mut self,
        ui: &mut Ui,
        here: FramePosition,
        shares: Option<&Arc<RegionShares>>,
    ) -> Option<InspectorAction> {
        let size = vec2(ui.available_width(), SHARES + TICKS + 4.0);
        let (area, response) = ui.allocate_exact_size(size, Sense::click());
        let frames = shares.map_or(0, |shares| shares.model.len());
        response.widget_info(|| {
            let now = shares.and_then(|shares| shares.cleaned.get(here.index));
            let now = now.map_or_else(
                || "not computed yet".to_owned(),
                |share| format!("{:.0} % in this frame", share * 100.0),
            );
            WidgetInfo::labeled(Role::Image, true, format!("Foreground ratio in neighbourhood, {now}"))
        });
        let plot = chart::inner(Rect::from_min_size(area.min + vec2(0.0, 4.0), vec2(area.width(), SHARES)));
        let (painter, visuals) = (ui.painter_at(area), ui.visuals());
        let axis = ChartAxis::x(0.0, frames.max(1) as f64, plot);
        let share = ChartAxis::y(0.0, 1.0, plot);
        if let Some(shares) = shares {
            let (mut after, mut line) = (Columns::default(), Vec::new());
            for peak in self.peaks(shares, plot.width() as usize) {
                let x = Rangef::new(axis.at(peak.frames.start as f64), axis.at(peak.frames.end as f64));
                after.add(x, share.at(peak.cleaned.into()), plot.bottom(), area_colour(visuals));
                let y = share.at(peak.model.into());
                line.extend([Pos2::new(x.min, y), Pos2::new(x.max, y)]);
            }
            after.paint(&painter);
            painter.add(Shape::line(line, Stroke::new(1.2, style::ink(visuals))));
        }
        chart::frame(&painter, plot, visuals);
        chart::y_labels(
            &painter,
            plot.left(),
            &[0.0, 0.5, 1.0].map(|at| (share.at(at), format!("{:.0} %", at * 100.0))),
            visuals,
        );
        let labels: Vec<_> = chart::ticks(0.0, frames as f64, (plot.width() / 60.0) as usize)
            .into_iter()
            .filter(|_| frames > 0)
            .map(|tick| (axis.at(tick.max(1.0) - 0.5), format!("{}", tick.max(1.0))))
            .collect();
        chart::x_labels(&painter, plot, &labels, visuals);
        if here.index < frames {
            mark(&painter, visuals, axis, here, plot.y_range());
        }
        go_to(ui, &response, axis, frames, |ui, frame| {
            let Some(shares) = shares else { return };
            let per_cent = |shares: &[f32]| shares.get(frame).copied().unwrap_or(0.0) * 100.0;
            ui.label(format!("Position {}, {} s", frame + 1, style::seconds(frame, here.fps)));
            let (after, before) = (per_cent(&shares.cleaned), per_cent(&shares.model));
            ui.label(small(&format!(
                "{after:.0} % of {} pixels, {before:.0} % before post-processing",
                shares.pixels
            )));
        })
    }

    fn peaks(&mut self, shares: &Arc<RegionShares>, columns: usize) -> &[Peak] {
        let fits =
            self.curve.as_ref().is_some_and(|of| Arc::ptr_eq(&of.shares, shares) && of.columns == columns);
        if !fits {
            let peaks = peaks(shares, columns);
            self.curve = Some(Curve { shares: Arc::clone(shares), columns, peaks });
        }
        self.curve.as_ref().map_or(&[], |of| &of.peaks)
    }

    fn sparks(&mut self, history: &Arc<PixelHistory>, columns: usize, frames: usize) -> &[SparklineColumn] {
        let fits = |cache: &Cache| Arc::ptr_eq(&cache.history, history);
        let known = self.cache.iter().position(fits);
        let at = known.unwrap_or_else(|| {
            self.cache.push(Cache {
                history: Arc::clone(history),
                columns: 0,
                frames: 0,
                sparks: Vec::new(),
            });
            self.cache.len() - 1
        });
        let cache = &mut self.cache[at];
        if (cache.columns, cache.frames) != (columns, frames) {
            (cache.columns, cache.frames) = (columns, frames);
            cache.sparks = sparkline(history, columns, frames);
        }
        &cache.sparks
    }
}

const fn word(foreground: bool) -> &'static str {
    if foreground { "foreground" } else { "background" }
}

fn values(state: &PixelState) -> String {
    let [r, g, b] = state.rgb;
    format!("{r} {g} {b}")
}

/// Number, position and verdict of a pin, with the button that unpins it.
fn pin_row(
    ui: &mut Ui,
    number: u8,
    (x, y): (u32, u32),
    state: Option<&PixelState>,
    chosen: bool,
) -> Option<InspectorAction> {
    let mut asked = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let (rect, _) = ui.allocate_exact_size(vec2(22.0, 16.0), Sense::hover());
        let colour = pins::colour(number);
        ui.painter().rect_filled(rect, 3.0, colour);
        let (middle, ink) = (rect.center(), theme::ink_on(colour));
        ui.painter().text(middle, Align2::CENTER_CENTER, pins::name(number), style::font(), ink);
        let place = Button::selectable(chosen, small(&format!("{x}, {y}")));
        let response = ui.add(place).on_hover_text("Select this pixel for the other tabs");
        if response.clicked() {
            asked = Some(InspectorAction::Choose((x, y)));
        }
        if let Some(state) = state {
            style::swatch(ui, state.rgb, 12.0, &format!("colour {}", values(state)));
            let foreground = state.outcome.foreground;
            let colour = style::verdict_colour(ui.visuals(), foreground);
            ui.label(small(word(foreground)).color(colour));
            ui.label(style::aside(
                ui,
                &match state.outcome.matched {
                    0 => "no match".to_owned(),
                    rank => format!("rank {rank}"),
                },
            ));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = Button::new(m::ICON_CLOSE.rich_text().size(14.0)).frame_when_inactive(false);
            let response =
                ui.add(close.min_size(vec2(20.0, 18.0))).accessible_name(format!("Unpin {number}"));
            if response.on_hover_text("Unpin").clicked() {
                asked = Some(InspectorAction::Unpin(number));
            }
        });
    });
    asked
}

fn draw(
    ui: &Ui,
    area: Rect,
    sparks: &[SparklineColumn],
    colour: Color32,
    axis: ChartAxis,
    here: FramePosition,
) {
    let (painter, visuals) = (ui.painter_at(area.expand(1.0)), ui.visuals());
    let plot = Rect::from_min_size(area.min, vec2(area.width(), SPARK));
    painter.rect_filled(plot, 2.0, visuals.faint_bg_color);
    let (low, high) = level_range(sparks);
    let levels = ChartAxis::y(low.into(), high.into(), plot.shrink2(vec2(0.0, 2.0)));
    let (mut bands, mut lines, mut verdicts) = (Columns::default(), Columns::default(), Columns::default());
    let strip = Rangef::new(plot.bottom() + 2.0, plot.bottom() + 2.0 + STRIP);
    for spark in sparks {
        let x = Rangef::new(axis.at(spark.frames.start as f64), axis.at(spark.frames.end as f64));
        for (rank, &(low, high)) in spark.bands.iter().enumerate() {
            let (low, high) = (levels.clamped(low.into()), levels.clamped(high.into()));
            bands.add(x, low, high, colour.gamma_multiply(if rank == 0 { 0.42 } else { 0.24 }));
        }
        let (low, high) = (levels.clamped(spark.values.0.into()), levels.clamped(spark.values.1.into()));
        lines.add(x, low + 0.7, high - 0.7, style::ink(visuals).gamma_multiply(0.9));
        verdicts.add(x, strip.min, strip.max, style::verdict_share(visuals, spark.foreground));
    }
    bands.paint(&painter);
    lines.paint(&painter);
    verdicts.paint(&painter);
    mark(&painter, visuals, axis, here, plot.y_range());
}

/// A line at the frame in view.
fn mark(painter: &Painter, visuals: &Visuals, axis: ChartAxis, here: FramePosition, y: Rangef) {
    let x = axis.at(here.index as f64 + 0.5);
    painter.vline(x, y, Stroke::new(3.0, visuals.panel_fill.gamma_multiply(0.6)));
    painter.vline(x, y, Stroke::new(1.5, style::ink(visuals)));
}

/// The pointer on a plot: shows the frame under it, and goes to it on a click.
fn go_to(
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

fn area_colour(visuals: &Visuals) -> Color32 {
    style::verdict_colour(visuals, true).gamma_multiply(0.55)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    fn history(frames: u32) -> Arc<PixelHistory> {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        Arc::new(PixelHistory::of_colours((0, 0), parameters, (0..frames).map(|n| (n + 1, [90; 3]))))
    }

    #[test]
    fn region_columns_are_recomputed_only_for_other_ratios_or_another_width() {
        let shares = |share: f32| {
            let (model, cleaned) = (vec![share; 90], vec![share / 2.0; 90]);
            Arc::new(RegionShares { at: (0, 0), side: 5, pixels: 25, model, cleaned })
        };
        let (mut pixels, one) = (PixelsView::default(), shares(0.5));
        let first = pixels.peaks(&one, 30).as_ptr();
        assert_eq!(pixels.peaks(&Arc::clone(&one), 30).as_ptr(), first, "the cached columns are reused");
        assert_eq!(pixels.peaks(&one, 20).len(), 20);
        assert_eq!(pixels.peaks(&shares(0.75), 20)[3].model, 0.75);
    }

    #[test]
    fn columns_are_recomputed_only_for_another_history_or_width() {
        let (mut pixels, history) = (PixelsView::default(), history(100));
        let first = pixels.sparks(&history, 50, 100).as_ptr();
        assert_eq!(pixels.sparks(&Arc::clone(&history), 50, 100).as_ptr(), first);
        assert_eq!(pixels.sparks(&history, 20, 100).len(), 20);
    }
}
