//! Several pixels beside one another: the pinned ones as small multiples, and the share of foreground around the chosen
//! one.

use std::ops::Range;
use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Align, Align2, Button, Color32, Label, Layout, Painter, Pos2, Rangef, Rect, Response, RichText, Sense, Shape,
    Stroke, Tooltip, Ui, UiBuilder, Visuals, WidgetInfo, vec2,
};
use egui_material_icons::icons as m;

use super::chart::{self, Axis, Columns, TICKS};
use super::style::{self, small};
use super::{Beside, InspectorAction, side};
use crate::app::{pins, theme};
use crate::mixture::pixel::luma;
use crate::mixture::{PixelHistory, PixelState};
use crate::replay::RegionShares;
use crate::settings::Space;

const SHARES: f32 = 64.0;
const SPARK: f32 = 34.0;
const STRIP: f32 = 5.0;

/// How large the region is, and the columns that were drawn last.
pub(super) struct Pixels {
    /// Pixels along a side of the region.
    pub(super) side: u32,
    cache: Vec<Cache>,
}

impl Default for Pixels {
    fn default() -> Self {
        Self { side: 5, cache: Vec::new() }
    }
}

/// Columns of one pin; made anew only for another history or width.
struct Cache {
    history: Arc<PixelHistory>,
    columns: usize,
    /// Of how many frames they are, of which the history may have fewer.
    frames: usize,
    sparks: Vec<Spark>,
}

/// Some consecutive frames of a pin, drawn as one column.
#[derive(Clone, Debug, Default, PartialEq)]
struct Spark {
    /// Positions of its frames.
    frames: Range<usize>,
    /// Least and greatest brightness.
    values: (f32, f32),
    /// μ ± λσ of each component that was background in the last frame, and whether it was the first.
    bands: Vec<(f32, f32, bool)>,
    /// The share of its frames that are foreground.
    foreground: f32,
}

const ON_THE_WAY: &str = "Its first frames are on the way …";
const LOST: &str = "It cannot be known: it begins with frames that this live source no longer has.";

/// Where the frame in view is.
#[derive(Clone, Copy)]
pub(super) struct Here {
    /// Its position.
    pub(super) index: usize,
    /// The source's frames a second.
    pub(super) fps: f32,
}

impl Pixels {
    pub(super) fn ui(&mut self, ui: &mut Ui, here: Here, beside: &Beside<'_>) -> Option<InspectorAction> {
        let region = self.region_ui(ui, here, beside.region);
        ui.add_space(10.0);
        self.pins_ui(ui, here, beside).or(region)
    }

    fn region_ui(
        &mut self,
        ui: &mut Ui,
        here: Here,
        shares: Option<&RegionShares>,
    ) -> Option<InspectorAction> {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 5.0;
            ui.label(RichText::new("Foreground around it").strong()).on_hover_text(
                "Which share of the pixels around the chosen one is foreground in each frame. A pixel alone flickers; \
                 its neighbours tell whether something is there.",
            );
            ui.add_space(4.0);
            side::choice(ui, &mut self.side);
        });
        let shares = shares.filter(|shares| shares.side == self.side);
        let asked = shares_ui(ui, here, shares);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let (rect, _) = ui.allocate_exact_size(vec2(12.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect.shrink2(vec2(0.0, 1.0)), 1.0, area_colour(ui.visuals()));
            ui.label(style::aside(ui, "after cleaning"));
            let (rect, _) = ui.allocate_exact_size(vec2(12.0, 10.0), Sense::hover());
            ui.painter().hline(rect.x_range(), rect.center().y, Stroke::new(1.5, style::ink(ui.visuals())));
            ui.label(style::aside(ui, "verdicts of the mixture"));
        });
        asked
    }

    /// The pins, one below the other.
    pub(super) fn pins_ui(
        &mut self,
        ui: &mut Ui,
        here: Here,
        beside: &Beside<'_>,
    ) -> Option<InspectorAction> {
        let mut asked = None;
        ui.label(RichText::new("Pinned pixels").strong()).on_hover_text(
            "Up to eight pixels, kept with the video. Brightness through all frames with the band μ ± λσ of each \
             background component, and the mixture's verdict below. Click a frame to go to it.",
        );
        if beside.pins.is_empty() {
            ui.label(style::aside(
                ui,
                "None yet. Pin the chosen pixel (D, or the pin beside its name) to compare it with others.",
            ));
            return None;
        }
        let frames = beside.histories.iter().map(|history| history.states.len()).max().unwrap_or(0);
        let known = |at| beside.histories.iter().find(|history| history.at == at);
        self.cache
            .retain(|cache| beside.histories.iter().any(|history| Arc::ptr_eq(&cache.history, history)));
        for &(number, at) in beside.pins {
            ui.add_space(4.0);
            let history = known(at);
            let state = history.and_then(|history| history.states.get(here.index));
            asked = pin_row(ui, number, at, state, beside.chosen == Some(at)).or(asked);
            let (area, response) =
                ui.allocate_exact_size(vec2(ui.available_width(), SPARK + STRIP + 3.0), Sense::click());
            let (x, y) = at;
            response.widget_info(|| {
                let name =
                    format!("Pinned pixel {number} at {x}, {y} through all frames; click one to go to it");
                WidgetInfo::labeled(Role::Image, true, name)
            });
            let axis = Axis::x(0.0, frames.max(1) as f64, area);
            match history {
                Some(history) if ui.is_rect_visible(area) => {
                    let sparks = self.sparks(history, area.width() as usize, frames);
                    draw(ui, area, sparks, pins::colour(number), axis, here);
                }
                Some(_) => {}
                None => {
                    let text = if beside.lost.contains(&at) { LOST } else { ON_THE_WAY };
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

    fn sparks(&mut self, history: &Arc<PixelHistory>, columns: usize, frames: usize) -> &[Spark] {
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
            cache.sparks = sparks(history, columns, frames);
        }
        &cache.sparks
    }
}

/// The columns of a history, of which `columns` stand for `frames`.
fn sparks(history: &PixelHistory, columns: usize, frames: usize) -> Vec<Spark> {
    let count = frames.min(columns.max(1));
    let edge = |column: usize| (frames * column / count.max(1)).min(history.states.len());
    let ranges =
        (0..count).map(|column| edge(column)..edge(column + 1)).take_while(|range| !range.is_empty());
    ranges.map(|range| spark(history, range)).collect()
}

fn spark(history: &PixelHistory, frames: Range<usize>) -> Spark {
    let states = &history.states[frames.clone()];
    let values = states.iter().map(|state| f32::from(luma(state.rgb)));
    let values = values
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let foreground = states.iter().filter(|state| state.outcome.foreground).count();
    let bands = states.last().map_or_else(Vec::new, |last| {
        let background = last.pixel.components().iter().take(usize::from(last.outcome.background_count));
        let band = |(rank, component): (usize, &crate::mixture::Component)| {
            let [r, g, b] = component.mean;
            let mean = match history.parameters.space {
                Space::Rgb => 0.299 * r + 0.587 * g + 0.114 * b,
                Space::Gray => r,
            };
            let reach = history.parameters.lambda * component.sigma();
            (mean - reach, mean + reach, rank == 0)
        };
        background.enumerate().map(band).collect()
    });
    Spark { frames, values, bands, foreground: foreground as f32 / states.len().max(1) as f32 }
}

const fn word(foreground: bool) -> &'static str {
    if foreground { "foreground" } else { "background" }
}

fn values(state: &PixelState) -> String {
    let [r, g, b] = state.rgb;
    format!("{r} {g} {b}")
}

/// Number, place and verdict of a pin, and what takes it away.
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
        let response = ui.add(place).on_hover_text("Choose this pixel: the other tabs are about it then");
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

fn draw(ui: &Ui, area: Rect, sparks: &[Spark], colour: Color32, axis: Axis, here: Here) {
    let (painter, visuals) = (ui.painter_at(area.expand(1.0)), ui.visuals());
    let plot = Rect::from_min_size(area.min, vec2(area.width(), SPARK));
    painter.rect_filled(plot, 2.0, visuals.faint_bg_color);
    let (low, high) = levels(sparks);
    let levels = Axis::y(low.into(), high.into(), plot.shrink2(vec2(0.0, 2.0)));
    let (mut bands, mut lines, mut verdicts) = (Columns::default(), Columns::default(), Columns::default());
    let strip = Rangef::new(plot.bottom() + 2.0, plot.bottom() + 2.0 + STRIP);
    for spark in sparks {
        let x = Rangef::new(axis.at(spark.frames.start as f64), axis.at(spark.frames.end as f64));
        for &(low, high, first) in &spark.bands {
            let (low, high) = (levels.clamped(low.into()), levels.clamped(high.into()));
            bands.add(x, low, high, colour.gamma_multiply(if first { 0.42 } else { 0.24 }));
        }
        let (low, high) = (levels.clamped(spark.values.0.into()), levels.clamped(spark.values.1.into()));
        lines.add(x, low + 0.7, high - 0.7, style::ink(visuals).gamma_multiply(0.9));
        verdicts.add(x, strip.min, strip.max, verdict_colour(visuals, spark.foreground));
    }
    bands.paint(&painter);
    lines.paint(&painter);
    verdicts.paint(&painter);
    mark(&painter, visuals, axis, here, plot.y_range());
}

/// The brightnesses that a pin is drawn between: all that occur with the bands around them, and no fewer than a few, so
/// that noise stays small.
fn levels(sparks: &[Spark]) -> (f32, f32) {
    const FEWEST: f32 = 48.0;
    let bands = |spark: &Spark| spark.bands.iter().map(|&(low, high, _)| (low, high)).collect::<Vec<_>>();
    let all = sparks.iter().flat_map(|spark| bands(spark).into_iter().chain([spark.values]));
    let (low, high) =
        all.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)));
    let (low, high) = (low.max(0.0), high.min(255.0));
    // A little more, so that the bands' edges are seen as such.
    let missing = ((FEWEST - (high - low)) / 2.0).max(0.14 * (high - low));
    if low <= high { (low - missing, high + missing) } else { (0.0, 255.0) }
}

/// As the strip under a history: a single foreground frame among a hundred must still be seen.
fn verdict_colour(visuals: &Visuals, share: f32) -> Color32 {
    if share > 0.0 {
        style::verdict_colour(visuals, true).gamma_multiply(0.45 + 0.55 * share)
    } else {
        style::verdict_colour(visuals, false).gamma_multiply(0.30)
    }
}

/// The frame in view.
fn mark(painter: &Painter, visuals: &Visuals, axis: Axis, here: Here, y: Rangef) {
    let x = axis.at(here.index as f64 + 0.5);
    painter.vline(x, y, Stroke::new(3.0, visuals.panel_fill.gamma_multiply(0.6)));
    painter.vline(x, y, Stroke::new(1.5, style::ink(visuals)));
}

/// What a click or the pointer on a plot means: the frame there, told in words and gone to.
fn go_to(
    ui: &Ui,
    response: &Response,
    axis: Axis,
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

/// The share of foreground in each frame: after cleaning as an area, before it as a line.
fn shares_ui(ui: &mut Ui, here: Here, shares: Option<&RegionShares>) -> Option<InspectorAction> {
    let size = vec2(ui.available_width(), SHARES + TICKS + 4.0);
    let (area, response) = ui.allocate_exact_size(size, Sense::click());
    let frames = shares.map_or(0, |shares| shares.model.len());
    response.widget_info(|| {
        let now = shares.and_then(|shares| shares.cleaned.get(here.index));
        let now =
            now.map_or_else(|| "not known yet".to_owned(), |share| format!("{:.0} % now", share * 100.0));
        WidgetInfo::labeled(Role::Image, true, format!("Share of foreground around the pixel, {now}"))
    });
    let plot = chart::inner(Rect::from_min_size(area.min + vec2(0.0, 4.0), vec2(area.width(), SHARES)));
    let (painter, visuals) = (ui.painter_at(area), ui.visuals());
    let axis = Axis::x(0.0, frames.max(1) as f64, plot);
    let share = Axis::y(0.0, 1.0, plot);
    if let Some(shares) = shares {
        let columns = (plot.width() as usize).min(frames).max(1);
        let (mut after, mut line) = (Columns::default(), Vec::new());
        for column in 0..columns {
            let range = frames * column / columns..frames * (column + 1) / columns;
            let x = Rangef::new(axis.at(range.start as f64), axis.at(range.end as f64));
            // Whatever is brief must be seen: the greatest of a column stands for it.
            let most = |shares: &[f32]| {
                let part = shares.get(range.clone()).unwrap_or_default();
                part.iter().copied().fold(0.0, f32::max)
            };
            after.add(x, share.at(most(&shares.cleaned).into()), plot.bottom(), area_colour(visuals));
            let y = share.at(most(&shares.model).into());
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
        ui.label(small(&format!("{after:.0} % of {} pixels, {before:.0} % before cleaning", shares.pixels)));
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    fn history(frames: u32) -> Arc<PixelHistory> {
        let colour = |n: u32| if n % 97 == 50 { [250, 240, 230] } else { [100 + (n % 7) as u8, 90, 80] };
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        Arc::new(PixelHistory::of_colours((0, 0), parameters, (0..frames).map(|n| (n + 1, colour(n)))))
    }

    #[test]
    fn columns_keep_what_is_brief_and_leave_room_for_frames_to_come() {
        let history = history(600);
        let all = sparks(&history, 60, 600);
        assert_eq!(all.len(), 60);
        for (column, spark) in all.iter().enumerate() {
            let flash = (column * 10..column * 10 + 10).any(|n| n % 97 == 50);
            assert_eq!(spark.values.1 > 200.0, flash, "{column}");
            assert_eq!(spark.foreground > 0.0, flash, "{column}");
            let last = &history.states[column * 10 + 9];
            assert_eq!(spark.bands.len(), usize::from(last.outcome.background_count));
        }
        let (low, high, first) = all[30].bands[0];
        assert!(first && low < 93.0 && high > 93.0, "{low} {high}");
        assert_eq!(sparks(&history, 60, 1200).len(), 30, "half of the frames are known");
        assert_eq!(sparks(&history, 900, 600).len(), 600, "a frame each");
        assert!(sparks(&self::history(0), 60, 100).is_empty());
    }

    #[test]
    fn columns_are_made_anew_only_for_another_history_or_width() {
        let (mut pixels, history) = (Pixels::default(), history(100));
        let first = pixels.sparks(&history, 50, 100).as_ptr();
        assert_eq!(pixels.sparks(&Arc::clone(&history), 50, 100).as_ptr(), first);
        assert_eq!(pixels.sparks(&history, 20, 100).len(), 20);
    }
}
