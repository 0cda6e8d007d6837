//! The rows of the history. Each draws one quantity over the frames, from columns.

use eframe::egui::{Color32, Painter, Pos2, Rangef, Rect, Shape, Stroke, Visuals};

use super::chart::{self, ChartAxis, Columns};
use super::style;
use crate::explain::pixel::downsampled_history::{
    HistoryColumn, LEVELS_PER_BIN, MAX_FRAMES_WITHOUT_LEVELS, rate_range,
};
use crate::explain::pixel::verdict::number;
use crate::export::figure::axis::power_of_ten;

/// Height of a lane of component changes; each kind of change has a lane.
pub(super) const LANE_HEIGHT: f32 = 9.0;

/// The horizontal range of a column.
pub(super) fn x_range(bin: &HistoryColumn, axis: ChartAxis) -> Rangef {
    Rangef::new(axis.at(bin.frames.start as f64), axis.at(bin.frames.end as f64))
}

/// The values of a channel over each component's μ ± λσ.
pub(super) fn channel_plot(
    painter: &Painter,
    visuals: &Visuals,
    bins: &[HistoryColumn],
    channel: usize,
    axis: ChartAxis,
    values: ChartAxis,
) {
    let (mut columns, mut means) = (Columns::default(), Columns::default());
    for bin in bins {
        let x = x_range(bin, axis);
        for (slot, band) in bin.bands.iter().enumerate() {
            let Some(band) = band else { continue };
            let colour = style::component(visuals, slot as u8);
            let (low, high) = band.range[channel];
            let strength = if band.background { 0.32 } else { 0.12 };
            let (low, high) = (values.clamped(f64::from(low)), values.clamped(f64::from(high)));
            columns.add(x, low, high, colour.gamma_multiply(strength));
            let mean = values.at(f64::from(band.mean[channel]));
            let strength = if band.background { 1.0 } else { 0.45 };
            means.add(x, mean - 0.6, mean + 0.6, colour.gamma_multiply(strength));
        }
    }
    columns.paint(painter);
    let ink = style::ink(visuals);
    let mut levels = Columns::default();
    for bin in bins {
        for &(step, count) in &bin.levels[channel] {
            // A single frame among a thousand stays visible.
            let share = count as f32 / bin.frames.len() as f32;
            let low = f64::from(step) * f64::from(LEVELS_PER_BIN);
            let (low, high) = (values.at(low), values.at(low + f64::from(LEVELS_PER_BIN)));
            levels.add(x_range(bin, axis), low, high, ink.gamma_multiply(0.12 + 0.88 * share.sqrt()));
        }
    }
    levels.paint(painter);
    means.paint(painter);
    if bins.iter().any(|bin| bin.frames.len() > MAX_FRAMES_WITHOUT_LEVELS) {
        return;
    }

    let mut line = Vec::with_capacity(bins.len() * 2);
    for bin in bins {
        let (low, high) = bin.value[channel];
        let x = x_range(bin, axis).center();
        line.push(Pos2::new(x, values.at(f64::from(low))));
        if high > low {
            line.push(Pos2::new(x, values.at(f64::from(high))));
        }
    }
    painter.add(Shape::line(line, Stroke::new(1.0, ink.gamma_multiply(0.9))));
    // With enough space between frames, each value is a point.
    for bin in bins.iter().filter(|bin| bin.frames.len() == 1) {
        let x = x_range(bin, axis);
        if x.span() >= 6.0 {
            let colour: Color32 = if bin.foreground > 0 { style::verdict_colour(visuals, true) } else { ink };
            painter.circle_filled(
                Pos2::new(x.center(), values.at(f64::from(bin.value[channel].0))),
                2.2,
                colour,
            );
        }
    }
}

/// The stacked weights in rank order, with T.
pub(super) fn weights_plot(
    painter: &Painter,
    visuals: &Visuals,
    bins: &[HistoryColumn],
    axis: ChartAxis,
    rect: Rect,
    t: f32,
) {
    let clipped = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let share = ChartAxis::y(0.0, 1.0, rect);
    let mut columns = Columns::default();
    for bin in bins {
        let mut sum = 0.0;
        for (rank, (slot, weight)) in bin.weights.iter().enumerate() {
            let strength = if rank < usize::from(bin.background_count) { 0.75 } else { 0.28 };
            let colour = style::component(visuals, *slot).gamma_multiply(strength);
            let next = sum + f64::from(*weight);
            columns.add(x_range(bin, axis), share.clamped(sum), share.clamped(next), colour);
            sum = next;
        }
    }
    columns.paint(&clipped);
    chart::frame(painter, rect, visuals);
    let y = share.at(f64::from(t));
    let ends = [Pos2::new(rect.left(), y), Pos2::new(rect.right(), y)];
    painter.extend(Shape::dashed_line(&ends, Stroke::new(1.2, style::ink(visuals)), 4.0, 3.0));
    let mut labels = vec![(y, format!("T {}", number(t)))];
    let ends = [0.0, 1.0].map(|tick| (share.at(tick), format!("{tick}")));
    labels.extend(ends.into_iter().filter(|(end, _)| (end - y).abs() > 10.0));
    chart::y_labels(painter, rect.left(), &labels, visuals);
}

/// ρ on a logarithmic scale, in frames where a component matched.
pub(super) fn rates_plot(
    painter: &Painter,
    visuals: &Visuals,
    bins: &[HistoryColumn],
    axis: ChartAxis,
    rect: Rect,
) {
    let (low, high) = rate_range(bins);
    let scale = ChartAxis::y(low.log10(), high.log10(), rect);
    let at = |rho: f32| scale.clamped(f64::from(rho).max(f64::MIN_POSITIVE).log10());
    let clipped = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let colour = style::ink(visuals).gamma_multiply(0.8);
    let mut columns = Columns::default();
    for bin in bins {
        if let Some((least, most)) = bin.rho {
            columns.add(x_range(bin, axis), at(most) - 0.7, at(least) + 0.7, colour);
        }
    }
    columns.paint(&clipped);
    chart::frame(painter, rect, visuals);
    let ends = [low, high].map(|rate| (scale.at(rate.log10()), rate_words(rate)));
    chart::y_labels(painter, rect.left(), &ends, visuals);
}

/// The label of a power of ten beside its axis.
fn rate_words(rate: f64) -> String {
    power_of_ten(rate.log10().round() as i32)
}

/// A stroke in the component's colour for each that was created, replaced or moved up, in one lane each.
pub(super) fn changes_plot(
    painter: &Painter,
    visuals: &Visuals,
    bins: &[HistoryColumn],
    axis: ChartAxis,
    rect: Rect,
) {
    let clipped = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let mut labels = Vec::new();
    for (lane, name) in ["new", "repl.", "up"].into_iter().enumerate() {
        let top = rect.top() + LANE_HEIGHT * lane as f32;
        for bin in bins {
            let Some(slot) = bin.changes[lane] else { continue };
            // A single frame among a hundred thousand stays visible.
            let x = x_range(bin, axis);
            let half = (x.span() / 2.0).clamp(0.8, 2.5);
            let stroke = Rangef::new(x.center() - half, x.center() + half);
            let rect = Rect::from_x_y_ranges(stroke, Rangef::new(top + 1.0, top + LANE_HEIGHT - 1.0));
            clipped.rect_filled(rect, 0.0, style::component(visuals, slot));
        }
        if lane > 0 {
            painter.hline(rect.x_range(), top, Stroke::new(0.5, style::faint(visuals).color));
        }
        labels.push((top + LANE_HEIGHT / 2.0, name.to_owned()));
    }
    chart::frame(painter, rect, visuals);
    chart::y_labels(painter, rect.left(), &labels, visuals);
}

/// The number of background components, B.
pub(super) fn count_plot(
    painter: &Painter,
    visuals: &Visuals,
    bins: &[HistoryColumn],
    axis: ChartAxis,
    rect: Rect,
    k: usize,
) {
    let count = ChartAxis::y(0.0, k as f64, rect);
    let clipped = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let colour = visuals.text_color().gamma_multiply(0.45);
    let mut columns = Columns::default();
    for bin in bins {
        let top = count.at(f64::from(bin.most_background));
        columns.add(x_range(bin, axis), top, rect.bottom(), colour);
    }
    columns.paint(&clipped);
    chart::frame(painter, rect, visuals);
    chart::y_labels(
        painter,
        rect.left(),
        &[(count.at(0.0), "0".to_owned()), (count.at(k as f64), k.to_string())],
        visuals,
    );
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Color32, Context, RawInput};

    use super::*;
    use crate::explain::pixel::PixelHistory;
    use crate::explain::pixel::component_slots::slots_by_rank;
    use crate::explain::pixel::downsampled_history::downsample;
    use crate::mixture::Parameters;
    use crate::settings::{Preset, Settings};

    #[test]
    fn every_rate_label_fits_beside_its_axis() {
        // The range of the paper's own ρ: a surface with many observed values, then far outliers.
        let parameters = Parameters::new(&Settings::preset(Preset::Paper));
        let colours = (1..=200).map(|n| (n, if n % 9 == 0 { [124, 131, 119] } else { [100; 3] }));
        let history = PixelHistory::of_colours((0, 0), parameters, colours);
        let (low, _) = rate_range(&downsample(&history, &slots_by_rank(&history), 0..200, 50));
        assert!(low < 1e-4, "the input must produce low rates: {low}");
        let rates = (-12..=0).map(|power| 10_f64.powi(power)).chain([low]);
        let ctx = Context::default();
        let mut output = ctx.run_ui(RawInput::default(), |ui| {
            for rate in rates.clone() {
                let words = rate_words(rate);
                let width =
                    ui.painter().layout_no_wrap(words.clone(), style::tick_font(), Color32::WHITE).size().x;
                assert!(width <= chart::GUTTER_WIDTH - chart::LABEL_GAP, "{words} takes {width}");
            }
        });
        output.textures_delta.clear();
    }
}
