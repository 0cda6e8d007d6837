//! The pixel inspector: one pixel's mixture in the frame in view and over time, with the evidence of its verdict.
//!
//! `mixture_view` draws the mixture of the frame in view, `history` its past, `scatter` the values in the space of the
//! channels, `tuning` the verdict under other settings, `statistics` counts over frames, `pixels` several pixels at
//! once. These modules only draw; the data are computed in [`crate::mixture`]. Each plot has a `menu` that exports it
//! as a [`crate::export::figure`], or its `table`.

mod action;
mod chart;
mod chosen_pixel;
mod components;
mod context;
mod cube;
mod frame_axis;
mod frame_times;
mod grid;
mod header;
mod history;
mod menu;
mod mixture_view;
mod pinned_pixels;
mod pixels;
mod plot;
mod region_accuracy;
mod region_shares;
mod region_size;
mod rows;
mod scatter;
mod statistics;
mod style;
mod table;
mod tabs;
#[cfg(test)]
mod tests;
mod tuning;

use std::sync::Arc;

use eframe::egui::{RichText, ScrollArea, Ui};

pub use self::action::InspectorAction;
pub use self::chosen_pixel::SlottedHistory;
use self::chosen_pixel::{ChosenPixel, slotted};
pub use self::context::{InspectorContext, InspectorRequests, RegionAccuracy};
use self::frame_axis::FramePosition;
pub use self::frame_times::FrameTimes;
use self::header::{header, message, verdict_ui};
pub use self::plot::{Format, Plot};
pub use self::table::Table;
use self::tabs::Tab;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::verdict::{overruled, verdict};
use crate::explain::tuning::Tuning;
use crate::replay::{ShownFrame, WorkProgress};
use crate::settings::BackgroundModel;

/// The state of the panel: the open tab, and the state of its plots.
#[derive(Default)]
pub struct Inspector {
    tab: Tab,
    now: mixture_view::MixtureView,
    history: history::HistoryView,
    scatter: scatter::ScatterView,
    tuning: tuning::TuningView,
    statistics: statistics::StatisticsView,
    pixels: pixels::PixelsView,
    /// The tab drawn since the last call of [`Self::requests`].
    drawn: Option<Tab>,
    followed: Option<SlottedHistory>,
    /// The state of the panel for the compared settings.
    other: ComparedPanel,
    /// The names of the two slots, the one in view first.
    pub names: [&'static str; 2],
}

/// The panel's state for the pixel under the compared settings.
#[derive(Default)]
struct ComparedPanel {
    now: mixture_view::MixtureView,
    followed: Option<SlottedHistory>,
}

impl Inspector {
    /// Draws the panel of the pixel chosen in `shown`. Returns the requested action.
    ///
    /// `newest` is the pixel under the latest settings. It is drawn in place of the frame's own while the frame in
    /// view still waits for these settings. `times` gives times in seconds beside frame numbers. `tuning` is the result of a request of [`Self::requests`], and `context` holds other pixels.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        shown: Option<&ShownFrame>,
        newest: Option<&Arc<PixelHistory>>,
        tuning: Option<&Tuning>,
        times: FrameTimes<'_>,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        let Some(shown) = shown else {
            message(ui, "No frame yet", "The inspector shows data after the first frame is analysed.");
            return None;
        };
        if shown.settings.background_model != BackgroundModel::Mixture {
            let model = match shown.settings.background_model {
                BackgroundModel::Knn => "KNN",
                _ => "MOG2",
            };
            message(
                ui,
                "No mixture",
                &format!(
                    "The background model is OpenCV's {model}, whose state is not accessible. Select the \
                     background model mixture to inspect a pixel."
                ),
            );
            return None;
        }
        let index = shown.position as usize;
        let ahead = newest.filter(|newest| {
            !newest.parameters.equal_settings(&shown.settings) && newest.states.len() > index
        });
        let here = FramePosition { index, times };
        let Some(history) = ahead.or(shown.pixel.as_ref()) else {
            return self.without_history(ui, here, context);
        };
        let Some(state) = history.states.get(index) else {
            let (x, y) = history.source_pixel();
            message(
                ui,
                &format!("Pixel {x}, {y}"),
                &format!("The pixel history does not reach frame {} yet.", shown.frame.number),
            );
            return None;
        };

        let slots = slotted(&mut self.followed, history);
        let chosen = ChosenPixel { history, slots: &slots, index, state, times };
        let mut words = verdict(history, index);
        let (x, y) = history.place(index);
        // There is no mask yet under settings that the frame still waits for.
        let mask = if ahead.is_some() { words.foreground } else { shown.analysis.mask.is_foreground(x, y) };
        let ignored = ahead.is_none() && shown.roi.as_ref().is_some_and(|roi| !roi.contains(x, y));
        words.details.splice(0..0, overruled(words.foreground, mask, ignored, &shown.settings));

        let other = shown.compared.as_deref().filter(|_| ahead.is_none());
        let other = other.and_then(|other| Some((other, other.pixel.as_ref()?)));
        let other = other.and_then(|(other, history)| Some((other, history, history.states.get(index)?)));
        let other_slots = other.map(|(_, history, _)| slotted(&mut self.other.followed, history));
        let other = other.zip(other_slots.as_ref()).map(|((other, history, state), slots)| {
            let (x, y) = history.place(index);
            let mask = other.analysis.mask.is_foreground(x, y);
            let mut words = verdict(history, index);
            let ignored = other.roi.as_ref().is_some_and(|roi| !roi.contains(x, y));
            words.details.splice(0..0, overruled(words.foreground, mask, ignored, &other.settings));
            (ChosenPixel { history, slots, index, state, times }, words, mask)
        });

        let pinned = context.pins.iter().find(|(_, at)| *at == history.at).map(|&(number, _)| number);
        let pin = header(ui, &chosen, pinned);
        ui.add_space(4.0);
        let names = self.names;
        verdict_ui(ui, &words, mask, other.as_ref().map(|_| names[0]));
        ui.add_space(4.0);
        if let Some((_, words, mask)) = &other {
            verdict_ui(ui, words, *mask, Some(names[1]));
            ui.add_space(4.0);
        }
        self.tab.choose(ui);
        ui.separator();
        let tab = self.tab;
        self.drawn = Some(tab);
        let scrolled = ScrollArea::vertical()
            .id_salt(("inspector", tab.scroll_key()))
            .auto_shrink(false)
            .min_scrolled_height(0.0);
        let asked = scrolled
            .show(ui, |ui| match tab {
                Tab::Mixture => {
                    let asked = self.now.ui(ui, &chosen, &words);
                    let Some((chosen, words, _)) = &other else { return asked };
                    ui.add_space(8.0);
                    ui.separator();
                    ui.label(RichText::new(format!("Under {}", names[1])).size(15.0).strong());
                    let now = &mut self.other.now;
                    asked.or(ui.push_id("other", |ui| now.ui(ui, chosen, words)).inner)
                }
                Tab::History => self.history.ui(ui, &chosen),
                Tab::Scatter => self.scatter.ui(ui, &chosen),
                Tab::Tuning => self.tuning.ui(ui, &chosen, tuning, &context.accuracy),
                Tab::Statistics => self.statistics.ui(ui, &chosen),
                Tab::Pixels => self.pixels.ui(ui, history, here, context),
            })
            .inner;
        pin.or(asked)
    }

    /// The reason why the chosen pixel has no history, and the pinned pixels.
    fn without_history(
        &mut self,
        ui: &mut Ui,
        here: FramePosition<'_>,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        let (title, text) = match context.chosen {
            Some(at) => {
                let (x, y) = context.source_pixel(at);
                let is_lost = context.lost.contains(&at);
                let why = if is_lost { LOST_HISTORY.to_owned() } else { computing_history(context.progress) };
                (format!("Pixel {x}, {y}"), why)
            }
            None if context.pins.is_empty() => ("No pixel selected".to_owned(), CLICK_PIXEL.to_owned()),
            None => ("No pixel selected".to_owned(), CLICK_PIXEL_OR_PIN.to_owned()),
        };
        if context.pins.is_empty() {
            message(ui, &title, &text);
            return None;
        }
        ui.label(RichText::new(title).size(15.0).strong());
        ui.label(style::aside(ui, &text));
        ui.add_space(8.0);
        let scrolled =
            ScrollArea::vertical().id_salt("pins alone").auto_shrink(false).min_scrolled_height(0.0);
        scrolled.show(ui, |ui| self.pixels.pins.ui(ui, here, context)).inner
    }

    /// Drops all cached drawings, when their video is closed.
    pub fn forget(&mut self) {
        (self.followed, self.other.followed) = (None, None);
        self.history.forget();
        self.scatter.forget();
        self.statistics.forget();
        self.pixels.forget();
    }

    /// The data that the visible tab requests. Empty if no tab was drawn since the last call.
    pub fn requests(&mut self) -> InspectorRequests {
        match self.drawn.take() {
            Some(Tab::Tuning) => InspectorRequests {
                tuning_axes: Some(self.tuning.axes),
                accuracy_side: Some(self.tuning.accuracy.side),
                shares_side: None,
            },
            Some(Tab::Pixels) => InspectorRequests {
                shares_side: Some(self.pixels.region.side),
                ..InspectorRequests::default()
            },
            _ => InspectorRequests::default(),
        }
    }
}

const CLICK_PIXEL: &str = "Click a pixel in any view to inspect its mixture, its history and its verdict.";
const CLICK_PIXEL_OR_PIN: &str = "Click a pixel in any view, or a pinned one below, to inspect its mixture.";
const LOST_HISTORY: &str = "Pixel history not available: it needs the first frames, which this live source no \
     longer has. A changed mixture setting restarts it with the next frame; use a recording to keep all \
     frames.";

/// The text while the chosen pixel's history is computed, with the percentage where it is known.
fn computing_history(progress: Option<&WorkProgress>) -> String {
    let share =
        progress.and_then(|progress| Some((progress.done, progress.total.filter(|&total| total > 0)?)));
    let percent = share.map(|(done, total)| u64::from(done) * 100 / u64::from(total));
    percent.map_or_else(
        || "Computing pixel history…".to_owned(),
        |percent| format!("Computing pixel history… {percent} %"),
    )
}
