//! The pinned pixels, one above the other, over all frames.

use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align, Align2, Button, Color32, Label, Layout, Rangef, Rect, RichText, Sense, Ui, UiBuilder, WidgetInfo,
    vec2,
};
use egui_material_icons::icons as m;

use super::action::InspectorAction;
use super::chart::{ChartAxis, Columns};
use super::context::InspectorContext;
use super::frame_axis::{FramePosition, go_to, mark};
use super::menu;
use super::plot::Plot;
use super::style::{self, small};
use crate::app::model::pins;
use crate::app::theme;
use crate::explain::pixel::sparklines::{SparklineColumn, level_range, sparkline};
use crate::explain::pixel::{PixelHistory, PixelState};

/// Height of the brightness of a pixel, in points.
const SPARKLINE_HEIGHT: f32 = 34.0;
/// Height of the verdicts below it, in points.
const VERDICT_STRIP_HEIGHT: f32 = 5.0;

const COMPUTING_HISTORY: &str = "Computing history…";
const LOST_HISTORY: &str = "Not available: this live source no longer has the first frames.";

/// The cached columns of each pixel.
#[derive(Default)]
pub(super) struct PinnedPixelsView {
    cache: Vec<CachedSparkline>,
}

/// Columns of one pin, recomputed only for another history or width.
struct CachedSparkline {
    history: Arc<PixelHistory>,
    columns: usize,
    /// The number of frames on the axis; the history may have fewer.
    frames: usize,
    sparks: Vec<SparklineColumn>,
}

impl PinnedPixelsView {
    /// Drops the cached columns.
    pub(super) fn forget(&mut self) {
        self.cache.clear();
    }

    /// Draws the pins.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        here: FramePosition<'_>,
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
            let place = (at, context.source_pixel(at));
            asked = pin_row(ui, number, place, state, context.chosen == Some(at)).or(asked);
            let (area, response) = ui.allocate_exact_size(
                vec2(ui.available_width(), SPARKLINE_HEIGHT + VERDICT_STRIP_HEIGHT + 3.0),
                Sense::click(),
            );
            let (x, y) = context.source_pixel(at);
            response.widget_info(|| {
                let name =
                    format!("Pinned pixel {number} at {x}, {y} over all frames; click to go to a frame");
                WidgetInfo::labeled(Role::Image, true, name)
            });
            let axis = ChartAxis::x(0.0, frames.max(1) as f64, area);
            match history {
                Some(history) if ui.is_rect_visible(area) => {
                    let sparks = self.sparks(history, area.width() as usize, frames);
                    draw(ui, area, sparks, theme::pin_colour(number), axis, here);
                }
                Some(_) => {}
                None => {
                    let text = if context.lost.contains(&at) { LOST_HISTORY } else { COMPUTING_HISTORY };
                    let text = Label::new(style::aside(ui, text)).wrap();
                    ui.new_child(UiBuilder::new().max_rect(area)).add(text);
                }
            }
            asked = go_to(ui, &response, axis, frames, |ui, frame| {
                let state = history.and_then(|history| history.states.get(frame));
                let Some(state) = state else { return };
                ui.label(format!("Frame {}, {} s", state.number, here.times.text(frame)));
                ui.label(small(&format!("{}: {}", values(state), word(state.outcome.foreground))));
            })
            .or(asked);
        }
        ui.add_space(8.0);
        asked
    }

    fn sparks(&mut self, history: &Arc<PixelHistory>, columns: usize, frames: usize) -> &[SparklineColumn] {
        let fits = |cache: &CachedSparkline| Arc::ptr_eq(&cache.history, history);
        let known = self.cache.iter().position(fits);
        let at = known.unwrap_or_else(|| {
            self.cache.push(CachedSparkline {
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

/// Number, position and verdict of a pin at a pixel of the frames and of the source, with the button that unpins it.
fn pin_row(
    ui: &mut Ui,
    number: u8,
    (at, (x, y)): ((u32, u32), (u32, u32)),
    state: Option<&PixelState>,
    chosen: bool,
) -> Option<InspectorAction> {
    let mut asked = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let (rect, _) = ui.allocate_exact_size(vec2(22.0, 16.0), Sense::hover());
        let colour = theme::pin_colour(number);
        ui.painter().rect_filled(rect, 3.0, colour);
        let (middle, ink) = (rect.center(), theme::ink_on(colour));
        ui.painter().text(middle, Align2::CENTER_CENTER, pins::name(number), style::font(), ink);
        let place = Button::selectable(chosen, small(&format!("{x}, {y}")));
        let response = ui.add(place).on_hover_text("Select this pixel for the other tabs");
        if response.clicked() {
            asked = Some(InspectorAction::Choose(at));
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
    here: FramePosition<'_>,
) {
    let (painter, visuals) = (ui.painter_at(area.expand(1.0)), ui.visuals());
    let plot = Rect::from_min_size(area.min, vec2(area.width(), SPARKLINE_HEIGHT));
    painter.rect_filled(plot, 2.0, visuals.faint_bg_color);
    let (low, high) = level_range(sparks);
    let levels = ChartAxis::y(low.into(), high.into(), plot.shrink2(vec2(0.0, 2.0)));
    let (mut bands, mut lines, mut verdicts) = (Columns::default(), Columns::default(), Columns::default());
    let strip = Rangef::new(plot.bottom() + 2.0, plot.bottom() + 2.0 + VERDICT_STRIP_HEIGHT);
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
    fn columns_are_recomputed_only_for_another_history_or_width() {
        let (mut pixels, history) = (PinnedPixelsView::default(), history(100));
        let first = pixels.sparks(&history, 50, 100).as_ptr();
        assert_eq!(pixels.sparks(&Arc::clone(&history), 50, 100).as_ptr(), first);
        assert_eq!(pixels.sparks(&history, 20, 100).len(), 20);
    }
}
