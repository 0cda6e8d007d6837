//! The mixture in the frame in view: densities, weights, components, and the numbers of the update.

use eframe::egui;
use eframe::egui::accesskit::Role;
use eframe::egui::{Align2, Button, Painter, Pos2, Rangef, Rect, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};

use super::action::InspectorAction;
use super::chart::{self, ChartAxis, Columns, TICKS_HEIGHT};
use super::chosen_pixel::ChosenPixel;
use super::components::{numbers, table};
use super::menu;
use super::plot::Plot;
use super::style::{self, small};
use crate::explain::pixel::component_states::{ComponentState, component_states, t_at};
use crate::explain::pixel::verdict::{Verdict, number};
use crate::export::figure::mixture::UpdateSide;

/// Minimum width at which both mixtures are side by side.
const MIN_SIDE_BY_SIDE_WIDTH: f32 = 330.0;

/// Which mixture is shown.
#[derive(Default)]
pub(super) struct MixtureView {
    side: UpdateSide,
}

/// A mixture before or after the update, as shown.
struct MixtureSide {
    before: bool,
    rows: Vec<ComponentState>,
    /// The number of background components, B.
    count: usize,
}

impl MixtureView {
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &ChosenPixel<'_>,
        words: &Verdict,
    ) -> Option<InspectorAction> {
        details(ui, words);
        let side = self.choose_side(ui, chosen);
        ui.add_space(2.0);
        let sides: Vec<MixtureSide> = side
            .sides()
            .iter()
            .map(|&before| {
                let (rows, count) = component_states(chosen.history, chosen.slots, chosen.index, before);
                MixtureSide { before, rows, count }
            })
            .collect();

        let lambda = number(chosen.history.parameters.lambda);
        let caption = format!("Densities w·η, bars μ ± {lambda}σ");
        let densities_asked = menu::caption(ui, &caption, DENSITIES_MEANING, "the densities", || {
            Plot::Densities(chosen.slotted_history(), chosen.index, side)
        });
        let peaks = sides.iter().flat_map(|side| side.rows.iter().map(ComponentState::peak));
        let top = peaks.fold(f64::MIN_POSITIVE, f64::max) * 1.08;
        side_by_side(ui, &sides, |ui, side| densities(ui, chosen, side, top));
        ui.add_space(6.0);

        let counts: Vec<_> = sides.iter().map(|side| side.count.to_string()).collect();
        let caption = format!("B = {}: cumulative weights until they exceed T", counts.join(", then "));
        let weights_asked = menu::caption(ui, &caption, WEIGHTS_MEANING, "the weights", || {
            Plot::Weights(chosen.slotted_history(), chosen.index, side)
        });
        side_by_side(ui, &sides, |ui, side| weights(ui, chosen, side));
        ui.add_space(8.0);

        for side in &sides {
            if sides.len() > 1 {
                ui.label(style::aside(ui, name_of(side)));
            }
            table(ui, chosen, &side.rows);
            ui.add_space(8.0);
        }
        numbers(ui, chosen);
        ui.add_space(8.0);
        densities_asked.or(weights_asked)
    }

    /// Selects the displayed mixture. The first frame of the model has none before the update.
    fn choose_side(&mut self, ui: &mut Ui, chosen: &ChosenPixel<'_>) -> UpdateSide {
        let first = chosen.history.before(chosen.index).is_none();
        let shown = |side| if first { UpdateSide::After } else { side };
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.spacing_mut().button_padding.x = 6.0;
            ui.label("Show").on_hover_text("Mixture before this frame's update, after it, or both");
            for (side, name, meaning) in [
                (
                    UpdateSide::Before,
                    "before",
                    "Mixture of the previous frame, with which the value is compared",
                ),
                (UpdateSide::After, "after", "Mixture updated with this frame's value, which determines B"),
                (
                    UpdateSide::Both,
                    "both",
                    "Mixtures before and after the update, side by side if space permits",
                ),
            ] {
                let button = Button::selectable(shown(self.side) == side, name);
                let button = ui.add_enabled(!first || side == UpdateSide::After, button);
                if button.on_hover_text(meaning).clicked() {
                    self.side = side;
                }
            }
        });
        shown(self.side)
    }
}

const DENSITIES_MEANING: &str = "Each curve is the marginal density of a component in one channel, with variance \
     σ². σ² is the squared distance summed over the channels, so with three channels a curve is wider than \
     the data of one channel. A value matches if its distance over all channels is at most λσ; lying \
     inside the bar of one channel is necessary, not sufficient. Filled: background. Dashed: foreground.";

const WEIGHTS_MEANING: &str = "Each bar is a weight, placed at the cumulative sum Σ of the weights above it. B is \
     the first rank at which the sum exceeds T: components 1 to B are background, the others foreground.";

/// Draws each mixture, side by side where the panel is wide enough.
fn side_by_side(ui: &mut Ui, sides: &[MixtureSide], mut draw: impl FnMut(&mut Ui, &MixtureSide)) {
    let named = |ui: &mut Ui, side: &MixtureSide, draw: &mut dyn FnMut(&mut Ui, &MixtureSide)| {
        ui.label(style::aside(ui, name_of(side)));
        draw(ui, side);
    };
    match sides {
        [one] => draw(ui, one),
        _ if ui.available_width() >= MIN_SIDE_BY_SIDE_WIDTH => ui.columns(sides.len(), |columns| {
            for (ui, side) in columns.iter_mut().zip(sides) {
                named(ui, side, &mut draw);
            }
        }),
        _ => sides.iter().for_each(|side| named(ui, side, &mut draw)),
    }
}

const fn name_of(side: &MixtureSide) -> &'static str {
    if side.before { "before the update" } else { "after the update" }
}

/// The details of the verdict, one sentence a line.
fn details(ui: &mut Ui, words: &Verdict) {
    ui.spacing_mut().item_spacing.y = 2.0;
    for detail in &words.details {
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 5.0;
            ui.label(small("·"));
            ui.add(egui::Label::new(small(detail)).wrap());
        });
    }
    ui.add_space(6.0);
    ui.spacing_mut().item_spacing.y = 3.0;
}

/// A small plot for each channel, stacked on a common axis 0..255.
fn densities(ui: &mut Ui, chosen: &ChosenPixel<'_>, side: &MixtureSide, top: f64) {
    const CURVES_HEIGHT: f32 = 50.0;
    let rows = &side.rows;
    let lane = if rows.len() > 4 { 6.0 } else { 10.0 };
    let lanes = lane * rows.len() as f32;
    let channels = chosen.channels();
    let height = (CURVES_HEIGHT + lanes + 8.0) * channels.len() as f32 + TICKS_HEIGHT + 2.0;
    let lambda = chosen.history.parameters.lambda;

    let (area, response) = ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::hover());
    let summary = channels
        .iter()
        .zip(chosen.state.value)
        .map(|(name, value)| format!("{name} = {value}"))
        .collect::<Vec<_>>()
        .join(", ");
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Image, true, format!("Densities of {} components at {summary}", rows.len()))
    });
    if !ui.is_rect_visible(area) {
        return;
    }
    let (painter, visuals) = (ui.painter_at(area), ui.visuals());
    let mut y = area.top();
    let mut last = area;
    for (channel, name) in channels.iter().enumerate() {
        let row = Rect::from_min_size(Pos2::new(area.left(), y), Vec2::new(area.width(), CURVES_HEIGHT));
        let plot = chart::inner(row);
        let (x_axis, y_axis) = (ChartAxis::x(0.0, 255.0, plot), ChartAxis::y(0.0, top, plot));
        chart::frame(&painter, plot, visuals);
        painter.text(
            Pos2::new(plot.left() - 6.0, plot.center().y),
            Align2::RIGHT_CENTER,
            name,
            style::font(),
            visuals.text_color(),
        );
        for row in rows.iter().rev() {
            let colour = style::component(visuals, row.slot);
            curve(&painter, plot, x_axis, y_axis, row, channel, colour);
        }
        let strip =
            Rect::from_min_size(Pos2::new(plot.left(), plot.bottom() + 2.0), Vec2::new(plot.width(), lanes));
        for (at, row) in rows.iter().enumerate() {
            let colour = style::component(visuals, row.slot);
            let mean = f64::from(row.component.mean[channel]);
            let reach = f64::from(row.component.reach(lambda));
            let top = strip.top() + at as f32 * lane;
            let range = Rangef::new(x_axis.clamped(mean - reach), x_axis.clamped(mean + reach));
            let bar = Rect::from_x_y_ranges(range, Rangef::new(top + 1.0, top + lane - 1.0));
            painter.rect_filled(bar, 1.0, colour.gamma_multiply(if row.background { 0.55 } else { 0.28 }));
            painter.vline(x_axis.clamped(mean), bar.y_range(), Stroke::new(2.0, colour));
            if lane > 8.0 {
                let place = Pos2::new(plot.left() - 6.0, bar.center().y);
                let text = row.rank.to_string();
                painter.text(place, Align2::RIGHT_CENTER, text, style::tick_font(), style::muted(visuals));
            }
        }
        let value = chosen.state.value[channel];
        let at = x_axis.at(f64::from(value));
        let line = Stroke::new(1.5, style::ink(visuals));
        painter.vline(at, Rangef::new(plot.top(), strip.bottom()), line);
        let (anchor, shift) =
            if at > plot.right() - 30.0 { (Align2::RIGHT_TOP, -4.0) } else { (Align2::LEFT_TOP, 4.0) };
        let place = Pos2::new(at + shift, plot.top() - 1.0);
        let galley = painter.layout_no_wrap(value.to_string(), style::font(), style::ink(visuals));
        let rect = anchor.anchor_size(place, galley.size());
        painter.rect_filled(rect, 2.0, visuals.panel_fill.gamma_multiply(0.7));
        painter.galley(rect.min, galley, style::ink(visuals));
        y += CURVES_HEIGHT + lanes + 8.0;
        last = Rect::from_x_y_ranges(plot.x_range(), Rangef::new(plot.top(), strip.bottom()));
    }
    let axis = ChartAxis::x(0.0, 255.0, last);
    painter.hline(last.x_range(), last.bottom() + 1.0, style::faint(visuals));
    let labels = [0.0, 64.0, 128.0, 192.0, 255.0].map(|tick| (axis.at(tick), format!("{tick}")));
    chart::x_labels(&painter, last, &labels, visuals);
}

/// One component's w·η: filled if background, dashed if foreground.
fn curve(
    painter: &Painter,
    plot: Rect,
    x_axis: ChartAxis,
    y_axis: ChartAxis,
    row: &ComponentState,
    channel: usize,
    colour: egui::Color32,
) {
    let steps = (plot.width() * 1.5) as usize;
    let points: Vec<Pos2> = (0..=steps)
        .map(|step| {
            let x = plot.left() + plot.width() * step as f32 / steps.max(1) as f32;
            Pos2::new(x, y_axis.at(row.marginal(channel, x_axis.value(x))))
        })
        .collect();
    let fill = colour.gamma_multiply(if row.background { 0.38 } else { 0.10 });
    let mut columns = Columns::default();
    for pair in points.windows(2) {
        let y = f32::midpoint(pair[0].y, pair[1].y);
        if y < plot.bottom() - 0.2 {
            columns.add(Rangef::new(pair[0].x, pair[1].x), y, plot.bottom(), fill);
        }
    }
    columns.paint(painter);
    // Where the density is zero, a line would only hide the axis.
    let rising: Vec<&[Pos2]> = points
        .chunk_by(|a, b| (a.y < plot.bottom() - 0.3) == (b.y < plot.bottom() - 0.3))
        .filter(|run| run[0].y < plot.bottom() - 0.3)
        .collect();
    for run in rising {
        if row.background {
            painter.add(Shape::line(run.to_vec(), Stroke::new(1.5, colour)));
        } else {
            painter.extend(Shape::dashed_line(run, Stroke::new(1.2, colour), 4.0, 3.0));
        }
    }
}

/// The weights as stacked bars, each starting at the sum of those above it, with T and the B cut.
fn weights(ui: &mut Ui, chosen: &ChosenPixel<'_>, side: &MixtureSide) {
    const BAR_HEIGHT: f32 = 13.0;
    let MixtureSide { before, rows, count } = side;
    let t = t_at(chosen.history, chosen.index, *before);
    let height = 14.0 + BAR_HEIGHT * rows.len() as f32 + 2.0 + TICKS_HEIGHT;
    let (area, response) = ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::hover());
    let listed = rows.iter().map(|row| format!("{:.3}", row.component.weight)).collect::<Vec<_>>().join(", ");
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Image, true, format!("Weights {listed}; T = {}; B = {count}", number(t)))
    });
    let (painter, visuals) = (ui.painter_at(area), ui.visuals());
    let bars = Rect::from_min_size(
        Pos2::new(area.left(), area.top() + 14.0),
        Vec2::new(area.width(), BAR_HEIGHT * rows.len() as f32),
    );
    let mut plot = chart::inner(bars);
    // Numbers have their own columns, clear of bars and T.
    let columns: &[f32] = if area.width() < 170.0 { &[26.0] } else { &[26.0, 58.0] };
    plot.max.x -= columns.last().copied().unwrap_or(0.0);
    for (name, right) in ["w", "Σ"].into_iter().zip(columns) {
        let place = Pos2::new(plot.right() + 8.0 + right, plot.top() - 1.0);
        painter.text(place, Align2::RIGHT_BOTTOM, name, style::font(), style::muted(visuals));
    }
    let axis = ChartAxis::x(0.0, 1.0, plot);
    chart::frame(&painter, plot, visuals);
    let mut sum = 0.0;
    for (at, row) in rows.iter().enumerate() {
        let colour = style::component(visuals, row.slot);
        let y = Rangef::new(
            plot.top() + at as f32 * BAR_HEIGHT + 1.5,
            plot.top() + (at + 1) as f32 * BAR_HEIGHT - 1.5,
        );
        let from = axis.at(sum);
        sum += f64::from(row.component.weight);
        let to = axis.clamped(sum).max(from + 1.0);
        let bar = Rect::from_x_y_ranges(Rangef::new(from, to), y);
        painter.rect_filled(bar, 1.0, colour.gamma_multiply(if row.background { 0.75 } else { 0.25 }));
        if !row.background {
            hatch(&painter, bar, colour);
        }
        if at + 1 < rows.len() {
            painter.vline(to, Rangef::new(y.max, y.max + 3.0), style::faint(visuals));
        }
        let centre = y.center();
        let name = Pos2::new(plot.left() - 6.0, centre);
        painter.text(name, Align2::RIGHT_CENTER, row.rank.to_string(), style::font(), visuals.text_color());
        for (value, right) in [f64::from(row.component.weight), sum].into_iter().zip(columns) {
            let place = Pos2::new(plot.right() + 8.0 + right, centre);
            let label = format!("{value:.3}");
            painter.text(place, Align2::RIGHT_CENTER, label, style::font(), visuals.text_color());
        }
    }
    let x = axis.at(f64::from(t));
    painter.extend(Shape::dashed_line(
        &[Pos2::new(x, plot.top() - 2.0), plot_bottom(plot, x)],
        Stroke::new(1.2, style::ink(visuals)),
        3.0,
        2.0,
    ));
    let text = format!("T = {}", number(t));
    let half = 24.0;
    // A plot narrower than the text has no such position.
    let place = Pos2::new(x.min(plot.right() - half).max(plot.left() + half), plot.top() - 3.0);
    painter.text(place, Align2::CENTER_BOTTOM, text, style::font(), visuals.text_color());
    if *count < rows.len() {
        let y = plot.top() + *count as f32 * BAR_HEIGHT;
        let stroke = Stroke::new(1.0, style::muted(visuals));
        painter.hline(Rangef::new(area.left(), plot.right()), y, stroke);
    }
    let labels = [0.0, 0.25, 0.5, 0.75, 1.0].map(|tick| (axis.at(tick), format!("{tick}")));
    chart::x_labels(&painter, plot, &labels, visuals);
}

fn plot_bottom(plot: Rect, x: f32) -> Pos2 {
    Pos2::new(x, plot.bottom())
}

/// Oblique lines across a bar: they mark foreground without colour.
fn hatch(painter: &Painter, bar: Rect, colour: egui::Color32) {
    let painter = painter.with_clip_rect(bar.intersect(painter.clip_rect()));
    let mut x = bar.left() - bar.height();
    while x < bar.right() {
        let (foot, head) = (Pos2::new(x, bar.bottom()), Pos2::new(x + bar.height(), bar.top()));
        painter.line_segment([foot, head], Stroke::new(1.0, colour.gamma_multiply(0.8)));
        x += 5.0;
    }
}
