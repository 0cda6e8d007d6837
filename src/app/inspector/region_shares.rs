//! The foreground ratio in the region around the chosen pixel, over all frames.

use std::sync::Arc;

use eframe::egui::accesskit::Role;
use eframe::egui::{
    Color32, Pos2, Rangef, Rect, RichText, Sense, Shape, Stroke, Ui, Visuals, WidgetInfo, vec2,
};

use super::action::InspectorAction;
use super::chart::{self, ChartAxis, Columns, TICKS_HEIGHT};
use super::frame_axis::{FramePosition, go_to, mark};
use super::menu;
use super::plot::Plot;
use super::region_size;
use super::style::{self, small};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::RegionShares;
use crate::export::figure::region::{Peak, peaks};

/// Height of the plot, in points.
const SHARES_HEIGHT: f32 = 64.0;

/// The side of the region, and the cached columns.
pub(super) struct RegionSharesView {
    /// Side of the region, in pixels.
    pub(super) side: u32,
    cache: Option<CachedShares>,
}

/// Columns of the region, recomputed only for other ratios or another width.
struct CachedShares {
    shares: Arc<RegionShares>,
    columns: usize,
    peaks: Vec<Peak>,
}

impl Default for RegionSharesView {
    fn default() -> Self {
        Self { side: 5, cache: None }
    }
}

impl RegionSharesView {
    /// Drops the cached columns.
    pub(super) fn forget(&mut self) {
        self.cache = None;
    }

    /// Draws the choice of the region, and the plot.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        chosen: &Arc<PixelHistory>,
        here: FramePosition<'_>,
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
        let asked = self.shares_ui(ui, chosen, here, shares);
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

    /// The foreground ratio of each frame: after post-processing as an area, before it as a line.
    fn shares_ui(
        &mut self,
        ui: &mut Ui,
        chosen: &PixelHistory,
        here: FramePosition<'_>,
        shares: Option<&Arc<RegionShares>>,
    ) -> Option<InspectorAction> {
        let size = vec2(ui.available_width(), SHARES_HEIGHT + TICKS_HEIGHT + 4.0);
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
        let plot =
            chart::inner(Rect::from_min_size(area.min + vec2(0.0, 4.0), vec2(area.width(), SHARES_HEIGHT)));
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
            let Some(state) = chosen.states.get(frame) else { return };
            ui.label(format!("Frame {}, {} s", state.number, here.times.text(frame)));
            let (after, before) = (per_cent(&shares.cleaned), per_cent(&shares.model));
            ui.label(small(&format!(
                "{after:.0} % of {} pixels, {before:.0} % before post-processing",
                shares.pixels
            )));
        })
    }

    fn peaks(&mut self, shares: &Arc<RegionShares>, columns: usize) -> &[Peak] {
        let fits =
            self.cache.as_ref().is_some_and(|of| Arc::ptr_eq(&of.shares, shares) && of.columns == columns);
        if !fits {
            let peaks = peaks(shares, columns);
            self.cache = Some(CachedShares { shares: Arc::clone(shares), columns, peaks });
        }
        self.cache.as_ref().map_or(&[], |of| &of.peaks)
    }
}

fn area_colour(visuals: &Visuals) -> Color32 {
    style::verdict_colour(visuals, true).gamma_multiply(0.55)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn region_columns_are_recomputed_only_for_other_ratios_or_another_width() {
        let shares = |share: f32| {
            let (model, cleaned) = (vec![share; 90], vec![share / 2.0; 90]);
            Arc::new(RegionShares { at: (0, 0), side: 5, pixels: 25, model, cleaned })
        };
        let (mut view, one) = (RegionSharesView::default(), shares(0.5));
        let first = view.peaks(&one, 30).as_ptr();
        assert_eq!(view.peaks(&Arc::clone(&one), 30).as_ptr(), first, "the cached columns are reused");
        assert_eq!(view.peaks(&one, 20).len(), 20);
        assert_eq!(view.peaks(&shares(0.75), 20)[3].model, 0.75);
    }
}
