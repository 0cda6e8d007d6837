//! The pixel inspector: one pixel's mixture in the frame in view and over time, with the evidence of its verdict.
//!
//! `mixture_view` draws the mixture of the frame in view, `history` its past, `scatter` the values in the space of the
//! channels, `tuning` the verdict under other settings, `statistics` counts over frames, `pixels` several pixels at
//! once. These modules only draw; the data are computed in [`crate::mixture`]. Each plot has a `menu` that exports it
//! as a [`crate::export::figure`], or its `table`.

mod chart;
mod components;
mod cube;
mod grid;
mod history;
mod menu;
mod mixture_view;
mod pixels;
mod plot;
mod region_accuracy;
mod region_size;
mod rows;
mod scatter;
mod statistics;
mod style;
mod table;
#[cfg(test)]
mod tests;
mod tuning;

use std::sync::Arc;

use eframe::egui;
use eframe::egui::{RichText, ScrollArea, Ui};
use egui_material_icons::icons;

use self::pixels::FramePosition;
pub use self::plot::{Format, Plot};
pub use self::table::Table;
use crate::app::model::pins;
use crate::explain::pixel::component_slots;
use crate::explain::pixel::verdict::{Verdict, overruled, verdict};
use crate::explain::pixel::{PixelHistory, PixelState};
use crate::explain::tuning::TunableSetting;
use crate::mixture::pixel::MAX_K;
use crate::replay::{RegionShares, RegionTuning, ShownFrame, Tuning};
use crate::settings::{BackgroundModel, Space};

/// An action that the inspector requests of the window.
#[derive(Clone, Debug, PartialEq)]
pub enum InspectorAction {
    /// Show the frame at this position of the sequence, from 0.
    GoTo(u32),
    /// Apply these values of these settings.
    Take([(TunableSetting, f32); 2]),
    /// Choose this pixel.
    Choose((u32, u32)),
    /// Pin the chosen pixel, or unpin it.
    Pin,
    /// Unpin the pixel of this number.
    Unpin(u8),
    /// Choose a folder of ground truth.
    LoadTruth,
    /// Copy the numbers behind a plot to the clipboard.
    Copy(Table),
    /// Write them to a file.
    Save(Table),
    /// Copy a plot to the clipboard as an image.
    CopyPicture(Box<Plot>),
    /// Write it to a file.
    SavePicture(Box<Plot>, Format),
}

/// The state of the panel: the open tab, and the state of its plots.
#[derive(Default)]
pub struct Inspector {
    tab: Tab,
    now: mixture_view::MixtureView,
    history: history::HistoryView,
    scatter: scatter::Scatter,
    tuning: tuning::TuningView,
    statistics: statistics::StatisticsView,
    pixels: pixels::PixelsView,
    /// The tab drawn since the last call of [`Self::asks`].
    drawn: Option<Tab>,
    followed: Option<SlottedHistory>,
    /// The state of the panel for the compared settings.
    other: Other,
    /// The names of the two slots, the one in view first.
    pub names: [&'static str; 2],
}

/// The panel's state for the pixel under the compared settings.
#[derive(Default)]
struct Other {
    now: mixture_view::MixtureView,
    followed: Option<SlottedHistory>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Tab {
    #[default]
    MixtureView,
    History,
    Scatter,
    Tuning,
    Statistics,
    PixelsView,
}

/// The data that the inspector shows besides the chosen pixel's history.
#[derive(Clone, Copy, Default)]
pub struct InspectorContext<'a> {
    /// The chosen pixel.
    pub chosen: Option<(u32, u32)>,
    /// The pinned pixels, with their numbers.
    pub pins: &'a [(u8, (u32, u32))],
    /// The available histories of the pinned pixels.
    pub histories: &'a [Arc<PixelHistory>],
    /// The pinned pixels whose history can never be computed.
    pub lost: &'a [(u32, u32)],
    /// The foreground ratio around the chosen pixel, if [`InspectorRequests::around`] requests it.
    pub region: Option<&'a Arc<RegionShares>>,
    /// The accuracy around the chosen pixel, by the ground truth.
    pub judged: RegionAccuracy<'a>,
}

/// Accuracy in the region around the chosen pixel, by the ground truth.
#[derive(Clone, Copy, Default)]
pub struct RegionAccuracy<'a> {
    /// Whether there are ground-truth masks.
    pub has_masks: bool,
    /// The tuning of the region, if [`InspectorRequests::judge`] requests it.
    pub tuning: Option<&'a Arc<RegionTuning>>,
}

/// The data that the visible tab requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InspectorRequests {
    /// The two settings of the tuning map.
    pub tune: Option<[TunableSetting; 2]>,
    /// The side in pixels of the region whose accuracy is requested.
    pub judge: Option<u32>,
    /// The side in pixels of the region whose foreground ratio is requested.
    pub around: Option<u32>,
}

/// A history with the slots of its components; recomputed only for another history.
#[derive(Clone, Debug, PartialEq)]
pub struct SlottedHistory {
    history: Arc<PixelHistory>,
    slots: Arc<Vec<[u8; MAX_K]>>,
}

/// The chosen pixel in the frame in view.
#[derive(Clone, Copy)]
struct Chosen<'a> {
    history: &'a Arc<PixelHistory>,
    /// Slots by rank, one set for each state; a component's slot determines its colour.
    slots: &'a Arc<Vec<[u8; MAX_K]>>,
    /// Index of the state of the frame in view.
    index: usize,
    state: &'a PixelState,
    /// The source's frame rate.
    fps: f32,
}

impl Chosen<'_> {
    /// The history with its slots, with shared ownership.
    fn followed(&self) -> SlottedHistory {
        SlottedHistory { history: Arc::clone(self.history), slots: Arc::clone(self.slots) }
    }

    /// Whether the first `end` states equal those of `made_of`, a history from which something was computed. If so,
    /// the present history replaces `made_of`.
    fn shares(&self, made_of: &mut Arc<PixelHistory>, end: usize) -> bool {
        if Arc::ptr_eq(made_of, self.history) {
            return true;
        }
        // A history only grows: many times a second during the analysis.
        let shares = end <= made_of.states.len() && self.history.extends(made_of);
        if shares {
            *made_of = Arc::clone(self.history);
        }
        shares
    }

    /// The names of the value's channels, as many as it has.
    fn channels(&self) -> &'static [&'static str] {
        self.history.parameters.channel_names()
    }
}

impl Inspector {
    /// Draws the panel of the pixel chosen in `shown`. Returns the requested action.
    ///
    /// `newest` is the pixel under the latest settings. It is drawn in place of the frame's own while the frame in
    /// view still waits for these settings. `fps` is the source's frame rate, to show times in seconds beside frame
    /// numbers. `tuning` is the result of a request of [`Self::asks`], and `beside` holds other pixels.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        shown: Option<&ShownFrame>,
        newest: Option<&Arc<PixelHistory>>,
        tuning: Option<&Tuning>,
        fps: f32,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        let Some(shown) = shown else {
            empty(ui, "No frame yet", "The inspector shows data after the first frame is analysed.");
            return None;
        };
        if shown.settings.background_model != BackgroundModel::Mixture {
            let model = match shown.settings.background_model {
                BackgroundModel::Knn => "KNN",
                _ => "MOG2",
            };
            empty(
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
        let ahead =
            newest.filter(|newest| !newest.parameters.are_of(&shown.settings) && newest.states.len() > index);
        let here = FramePosition { index, fps };
        let Some(history) = ahead.or(shown.pixel.as_ref()) else {
            return self.without_history(ui, here, context);
        };
        let Some(state) = history.states.get(index) else {
            let (x, y) = history.at;
            empty(
                ui,
                &format!("Pixel {x}, {y}"),
                &format!("The pixel history does not reach frame {} yet.", shown.frame.number),
            );
            return None;
        };

        let slots = followed(&mut self.followed, history);
        let chosen = Chosen { history, slots: &slots, index, state, fps };
        let mut words = verdict(history, index);
        let (x, y) = history.place(index);
        // There is no mask yet under settings that the frame still waits for.
        let mask = if ahead.is_some() { words.foreground } else { shown.analysis.mask.is_foreground(x, y) };
        let ignored = ahead.is_none() && shown.roi.as_ref().is_some_and(|roi| !roi.contains(x, y));
        words.details.splice(0..0, overruled(words.foreground, mask, ignored, &shown.settings));

        let other = shown.compared.as_deref().filter(|_| ahead.is_none());
        let other = other.and_then(|other| Some((other, other.pixel.as_ref()?)));
        let other = other.and_then(|(other, history)| Some((other, history, history.states.get(index)?)));
        let other_slots = other.map(|(_, history, _)| followed(&mut self.other.followed, history));
        let other = other.zip(other_slots.as_ref()).map(|((other, history, state), slots)| {
            let (x, y) = history.place(index);
            let mask = other.analysis.mask.is_foreground(x, y);
            let mut words = verdict(history, index);
            let ignored = other.roi.as_ref().is_some_and(|roi| !roi.contains(x, y));
            words.details.splice(0..0, overruled(words.foreground, mask, ignored, &other.settings));
            (Chosen { history, slots, index, state, fps }, words, mask)
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
        ui.horizontal_wrapped(|ui| {
            // All tabs must fit into one line of a narrow panel.
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.spacing_mut().button_padding.x = 6.0;
            for (tab, name) in [
                (Tab::MixtureView, "Mixture"),
                (Tab::History, "History"),
                (Tab::Scatter, "Scatter"),
                (Tab::Tuning, "Tuning"),
                (Tab::Statistics, "Statistics"),
                (Tab::PixelsView, "Pixels"),
            ] {
                ui.selectable_value(&mut self.tab, tab, name);
            }
        });
        ui.separator();
        let tab = self.tab;
        self.drawn = Some(tab);
        let scrolled = ScrollArea::vertical()
            .id_salt(("inspector", name_of(tab)))
            .auto_shrink(false)
            .min_scrolled_height(0.0);
        let asked = scrolled
            .show(ui, |ui| match tab {
                Tab::MixtureView => {
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
                Tab::Tuning => self.tuning.ui(ui, &chosen, tuning, &context.judged),
                Tab::Statistics => self.statistics.ui(ui, &chosen),
                Tab::PixelsView => self.pixels.ui(ui, history, here, context),
            })
            .inner;
        pin.or(asked)
    }

    /// The reason why the chosen pixel has no history, and the pinned pixels.
    fn without_history(
        &mut self,
        ui: &mut Ui,
        here: FramePosition,
        context: &InspectorContext<'_>,
    ) -> Option<InspectorAction> {
        let (title, text) = match context.chosen {
            Some((x, y)) if context.lost.contains(&(x, y)) => (format!("Pixel {x}, {y}"), LOST),
            Some((x, y)) => (format!("Pixel {x}, {y}"), COMPUTING_HISTORY),
            None if context.pins.is_empty() => ("No pixel selected".to_owned(), CLICK),
            None => ("No pixel selected".to_owned(), CLICK_OR_PIN),
        };
        if context.pins.is_empty() {
            empty(ui, &title, text);
            return None;
        }
        ui.label(RichText::new(title).size(15.0).strong());
        ui.label(style::aside(ui, text));
        ui.add_space(8.0);
        let scrolled =
            ScrollArea::vertical().id_salt("pins alone").auto_shrink(false).min_scrolled_height(0.0);
        scrolled.show(ui, |ui| self.pixels.pins_ui(ui, here, context)).inner
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
    pub fn asks(&mut self) -> InspectorRequests {
        match self.drawn.take() {
            Some(Tab::Tuning) => InspectorRequests {
                tune: Some(self.tuning.knobs),
                judge: Some(self.tuning.judged.side),
                around: None,
            },
            Some(Tab::PixelsView) => {
                InspectorRequests { around: Some(self.pixels.side), ..InspectorRequests::default() }
            }
            _ => InspectorRequests::default(),
        }
    }
}

const CLICK: &str = "Click a pixel in any view to inspect its mixture, its history and its verdict.";
const CLICK_OR_PIN: &str = "Click a pixel in any view, or a pinned one below, to inspect its mixture.";
const COMPUTING_HISTORY: &str = "Computing pixel history…";
const LOST: &str = "Pixel history not available: it needs the first frames, which this live source no \
     longer has. A changed mixture setting restarts it with the next frame; use a recording to keep all \
     frames.";

fn followed(known: &mut Option<SlottedHistory>, history: &Arc<PixelHistory>) -> Arc<Vec<[u8; MAX_K]>> {
    match known {
        // The old history is kept alive, so that equal addresses imply the same history.
        Some(followed) if Arc::ptr_eq(&followed.history, history) => Arc::clone(&followed.slots),
        Some(followed) if history.extends(&followed.history) => {
            component_slots::extend_slots(Arc::make_mut(&mut followed.slots), history);
            followed.history = Arc::clone(history);
            Arc::clone(&followed.slots)
        }
        _ => {
            let slots = Arc::new(component_slots::slots_by_rank(history));
            *known = Some(SlottedHistory { history: Arc::clone(history), slots: Arc::clone(&slots) });
            slots
        }
    }
}

const fn name_of(tab: Tab) -> &'static str {
    match tab {
        Tab::MixtureView => "now",
        Tab::History => "history",
        Tab::Scatter => "scatter",
        Tab::Tuning => "tuning",
        Tab::Statistics => "statistics",
        Tab::PixelsView => "pixels",
    }
}

fn empty(ui: &mut Ui, title: &str, text: &str) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.3).clamp(16.0, 160.0));
        ui.label(RichText::new(title).size(15.0).strong());
        ui.add_space(4.0);
        ui.set_max_width(300.0);
        ui.label(RichText::new(text).color(style::muted(ui.visuals())));
    });
}

/// Minimum width for the time beside the frame number.
const WITH_SECONDS: f32 = 104.0;

/// Value and position of the chosen pixel, with the pin button. Returns the requested action.
fn header(ui: &mut Ui, chosen: &Chosen<'_>, pinned: Option<u8>) -> Option<InspectorAction> {
    let mut pin = None;
    let state = chosen.state;
    let [r, g, b] = state.rgb;
    ui.horizontal(|ui| {
        style::swatch(ui, state.rgb, 34.0, &format!("colour {r}, {g}, {b}"));
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let (x, y) = chosen.history.at;
            ui.horizontal(|ui| {
                ui.label(RichText::new(format!("Pixel {x}, {y}")).size(15.0).strong());
                pin = pin_button(ui, pinned);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if ui.available_width() > WITH_SECONDS {
                        ui.label(style::aside(
                            ui,
                            &format!("{} s", style::seconds(chosen.index, chosen.fps)),
                        ));
                    }
                    ui.label(format!("frame {}", state.number));
                });
            });
            ui.label(match chosen.history.parameters.space {
                Space::Rgb => format!("R {r}   G {g}   B {b}"),
                Space::Gray => format!("luma {}   (R {r}  G {g}  B {b})", state.value[0]),
            });
        });
    });
    pin
}

fn pin_button(ui: &mut Ui, pinned: Option<u8>) -> Option<InspectorAction> {
    let icon = icons::ICON_KEEP.rich_text().size(16.0);
    let icon = pinned.map_or_else(|| icon.clone(), |number| icon.clone().color(pins::colour(number)));
    let (name, text) = match pinned {
        Some(_) => ("Unpin pixel", "Unpin this pixel (D)"),
        None => ("Pin pixel", "Pin this pixel to compare it under Pixels (D)"),
    };
    let button =
        egui::Button::new(icon).frame_when_inactive(pinned.is_some()).min_size(egui::vec2(20.0, 18.0));
    let response = ui.add(button).accessible_name(name).on_hover_text(text);
    response.clicked().then_some(InspectorAction::Pin)
}

/// The verdict in a sentence, with the name of the slot where there are two.
fn verdict_ui(ui: &mut Ui, words: &Verdict, mask: bool, name: Option<&str>) {
    let colour = style::verdict_colour(ui.visuals(), words.foreground);
    let frame = egui::Frame::new()
        .fill(colour.gamma_multiply(0.14))
        .inner_margin(egui::Margin { left: 10, right: 6, top: 5, bottom: 5 })
        .corner_radius(3);
    let response = frame
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.spacing_mut().item_spacing.y = 2.0;
            let headline = match name {
                Some(name) => format!("{name}: {}", words.headline),
                None => words.headline.clone(),
            };
            ui.label(RichText::new(headline).color(ui.visuals().strong_text_color()));
            if mask != words.foreground {
                let made = if mask { "foreground" } else { "background" };
                ui.label(style::small(&format!("After post-processing: {made}.")));
            }
        })
        .response;
    let mut rule = response.rect;
    rule.set_width(3.0);
    ui.painter().rect_filled(rule, 1.0, colour);
}
