#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod cube;
mod export;

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use eframe::egui::{self, Pos2, Theme, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::super::golden::looks_as_before;
use super::{
    Format, FrameTimes, Inspector, InspectorAction, InspectorContext, SlottedHistory, Table,
    computing_history,
};
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_slots::{ComponentChange, component_change};
use crate::explain::pixel::region_shares::RegionShares;
use crate::explain::pixel::statistics::Statistics;
use crate::explain::pixel::verdict::{distance_in_sigmas, number, verdict};
use crate::explain::tuning::{TunableSetting, Tuning, flip, map};
use crate::frame::{Frame, Mask, Size};
use crate::mixture::Parameters;
use crate::occlusion::Counters;
use crate::pipeline::Analysis;
use crate::regions::Labels;
use crate::replay::{ShownFrame, WorkProgress};
use crate::settings::{BackgroundModel, Preset, Settings, Space};

const SIZE: Size = Size::new(8, 6);
const AT: (u32, u32) = (5, 4);

/// A noisy pixel that alternates between two surfaces, as under a swaying branch. From frame 420 a person in dark
/// clothes covers it for a while.
fn history_of(settings: &Settings, frames: u32) -> PixelHistory {
    let mut seed = 12_345_u32;
    let mut noise = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((seed >> 16) % 13) as i32 - 6
    };
    let colours = (0..frames).map(|n| {
        let swaying = (n / 9) % 3 == 0 || n % 23 == 5;
        let [r, g, b] = match n {
            420..450 => [58 + (n as i32 - 420), 44, 70],
            _ if swaying => [92, 128, 64],
            _ => [168, 160, 150],
        };
        let wobble = noise();
        let channel = |level: i32, own: i32| (level + wobble + own).clamp(0, 255) as u8;
        (n + 1, [channel(r, noise() / 3), channel(g, noise() / 3), channel(b, noise() / 3)])
    });
    PixelHistory::of_colours(AT, Parameters::new(settings), colours)
}

fn shown_of(settings: Settings, history: Option<PixelHistory>, position: u32) -> ShownFrame {
    let rgb = history.as_ref().and_then(|h| h.states.get(position as usize)).map_or([0; 3], |s| s.rgb);
    let foreground = history
        .as_ref()
        .and_then(|h| h.states.get(position as usize))
        .is_some_and(|state| state.outcome.foreground);
    let mut mask = Mask::empty(SIZE);
    mask.data[SIZE.index(AT.0, AT.1).unwrap()] = if foreground { Mask::FOREGROUND } else { Mask::BACKGROUND };
    let frame = Arc::new(Frame::new(position + 1, SIZE, rgb.repeat(SIZE.pixels())));
    ShownFrame {
        position,
        settings: Arc::new(settings),
        roi: None,
        frame: Arc::clone(&frame),
        analysis: Arc::new(Analysis {
            number: position + 1,
            time: f64::from(position) / 10.0,
            t: position + 1,
            mask: Arc::new(mask),
            labels: Arc::new(Labels::none(SIZE)),
            regions: Arc::default(),
            objects: Arc::default(),
            tracks: Arc::default(),
            tentative: Arc::default(),
            events: Arc::default(),
            settled: Arc::default(),
            counters: Counters::default(),
        }),
        background: frame,
        multi_mode: None,
        map: None,
        pixel: history.map(Arc::new),
        truth: None,
        external: None,
        compared: None,
    }
}

fn settings() -> Settings {
    Settings { t: 0.8, k: 4, alpha: 0.01, median: 5, ..Settings::preset(Preset::Plain) }
}

fn shown(position: u32) -> ShownFrame {
    let settings = settings();
    let history = history_of(&settings, 600);
    shown_of(settings, Some(history), position)
}

fn tuning_of(shown: &ShownFrame, settings: [TunableSetting; 2]) -> Option<Tuning> {
    let history = shown.pixel.as_ref()?;
    let states = history.states.get(..=shown.position as usize)?;
    // Other tests cover long histories.
    let values: Vec<_> = states.iter().take(1000).map(|state| state.value).collect();
    let parameters = history.parameters;
    Some(Tuning {
        at: history.at,
        position: shown.position,
        parameters,
        map: map(&values, &parameters, settings),
        flips: TunableSetting::ALL.iter().map(|&setting| flip(&values, &parameters, setting)).collect(),
    })
}

/// The panel of `shown` in a harness, with the actions that it requested.
fn harness(
    shown: Option<ShownFrame>,
    size: Vec2,
    theme: Theme,
) -> (Harness<'static>, Rc<RefCell<Vec<InspectorAction>>>) {
    let actions = Rc::new(RefCell::new(Vec::new()));
    let (asked, mut inspector) = (Rc::clone(&actions), Inspector::default());
    // The worker's result while the tab is open.
    let tuning =
        shown.as_ref().and_then(|shown| tuning_of(shown, [TunableSetting::Alpha, TunableSetting::T]));
    let mut harness = Harness::builder()
        .with_size(size)
        .with_theme(theme)
        .with_context_setup(crate::app::theme::install)
        .wgpu()
        .build_ui(move |ui| {
            egui::CentralPanel::default().show(ui, |ui| {
                asked.borrow_mut().extend(inspector.ui(
                    ui,
                    shown.as_ref(),
                    None,
                    tuning.as_ref(),
                    FrameTimes { fps: 10.0, times: &[] },
                    &InspectorContext::default(),
                ));
            });
        });
    harness.run();
    (harness, actions)
}

fn tall(shown: Option<ShownFrame>) -> (Harness<'static>, Rc<RefCell<Vec<InspectorAction>>>) {
    harness(shown, Vec2::new(380.0, 1000.0), Theme::Dark)
}

fn open(harness: &mut Harness<'_>, tab: &str) {
    harness.get_by_label(tab).click();
    harness.run();
}

/// Opens the menu of a plot and selects an entry.
fn choose(harness: &mut Harness<'_>, menu: &str, entry: &str) {
    harness.get_by_label(menu).click();
    harness.run();
    harness.get_by_label(entry).click();
    harness.run();
}

/// All texts and accessible names in the panel.
fn texts(harness: &Harness<'_>) -> Vec<String> {
    let mut texts = Vec::new();
    let mut waiting = vec![harness.root()];
    while let Some(node) = waiting.pop() {
        let accesskit = node.accesskit_node();
        texts.extend(accesskit.label());
        texts.extend(accesskit.value());
        waiting.extend(node.children());
    }
    texts
}

fn says(harness: &Harness<'_>, part: &str) -> bool {
    texts(harness).iter().any(|text| text.contains(part))
}

fn picture(harness: &mut Harness<'_>, name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/inspector");
    std::fs::create_dir_all(&folder).unwrap();
    harness.render().unwrap().save(folder.join(format!("{name}.png"))).unwrap();
}

#[test]
fn without_frame_pixel_mixture_or_state_a_message_names_what_is_missing() {
    let history = history_of(&settings(), 20);
    let knn = Settings { background_model: BackgroundModel::Knn, ..settings() };
    let mog2 = Settings { background_model: BackgroundModel::Mog2, ..settings() };
    let cases = [
        ("no-frame", None, "No frame yet"),
        ("no-pixel", Some(shown_of(settings(), None, 3)), "Click a pixel in any view"),
        ("knn", Some(shown_of(knn, None, 3)), "OpenCV's KNN"),
        ("mog2", Some(shown_of(mog2, None, 3)), "OpenCV's MOG2"),
        (
            "not-yet",
            Some(shown_of(settings(), Some(history), 20)),
            "The pixel history does not reach frame 21 yet",
        ),
    ];
    for (name, shown, words) in cases {
        let (mut harness, _) = harness(shown, Vec2::new(340.0, 400.0), Theme::Light);
        assert!(says(&harness, words), "{name}: {:?}", texts(&harness));
        picture(&mut harness, &format!("empty-{name}"));
    }
}

#[test]
fn every_tab_can_be_drawn_dark_and_light_narrow_and_wide() {
    for (theme, look) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        for (width, height) in [(240.0, 900.0), (340.0, 700.0), (500.0, 1000.0)] {
            let (mut harness, _) = harness(Some(shown(430)), Vec2::new(width, height), theme);
            for tab in ["Mixture", "both", "History", "Tuning", "Statistics", "Scatter", "3-D"] {
                open(&mut harness, tab);
                picture(&mut harness, &format!("{}-{look}-{width}", tab.to_lowercase()));
            }
        }
    }
}

#[test]
fn the_tabs_are_in_one_line_at_every_width() {
    // The least width of the panel leaves 200 points, as the margins of this harness do at 216.
    for width in [216.0, 260.0, 340.0, 500.0] {
        let (mut harness, _) = harness(Some(shown(430)), Vec2::new(width, 400.0), Theme::Dark);
        let tabs = ["Mixture", "History", "Scatter", "Tuning", "Statistics", "Pixels"];
        let rects = tabs.map(|tab| harness.get_by_label(tab).rect());
        assert!(rects.iter().all(|rect| rect.top() == rects[0].top()), "{width}: {rects:?}");
        assert!(rects.windows(2).all(|pair| pair[0].right() <= pair[1].left()), "{width}: {rects:?}");
        assert!(rects[5].right() <= width - 8.0, "{width}: {rects:?}");
        open(&mut harness, "Tuning");
        harness.get_by_label_contains("Tuning map");
    }
}

#[test]
fn every_tab_matches_its_golden_image() {
    for (theme, look) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        let (mut harness, _) = harness(Some(shown(430)), Vec2::new(340.0, 900.0), theme);
        for tab in ["Mixture", "both", "History", "Tuning", "Statistics", "Scatter", "3-D"] {
            open(&mut harness, tab);
            let picture = harness.render().unwrap();
            looks_as_before(&picture, None, &format!("{}-{look}", tab.to_lowercase()));
        }
    }
}

#[test]
fn one_channel_can_be_drawn() {
    let gray = Settings { space: Space::Gray, k: 8, min_sigma: 1.0, initial_sigma: 6.0, ..settings() };
    let history = history_of(&gray, 600);
    let state = history.states[330];
    let (mut harness, _) =
        harness(Some(shown_of(gray, Some(history), 330)), Vec2::new(340.0, 900.0), Theme::Light);
    assert!(says(&harness, &format!("luma {}", state.value[0])));
    for tab in ["Mixture", "History", "Tuning", "Statistics", "Scatter"] {
        open(&mut harness, tab);
        picture(&mut harness, &format!("gray-{}", tab.to_lowercase()));
    }
    assert!(says(&harness, "luma vs luma of the next frame"));
}

#[test]
fn the_last_value_of_one_channel_has_no_next_and_no_cross() {
    let gray = Settings { space: Space::Gray, ..settings() };
    let history = history_of(&gray, 600);
    let [value, next] = [330, 331].map(|at| history.states[at].value[0]);
    let cross = |position| {
        let shown = shown_of(gray.clone(), Some(history.clone()), position);
        let (mut harness, _) = harness(Some(shown), Vec2::new(340.0, 900.0), Theme::Dark);
        open(&mut harness, "Scatter");
        let name = harness.get_by_label_contains("Scatter plot of next vs luma").accesskit_node().label();
        picture(&mut harness, &format!("gray-scatter-{position}"));
        (name.unwrap().split_once("current value at ").map(|(_, at)| at.to_owned()), harness)
    };
    assert_eq!(cross(330).0, Some(format!("{value}, {next}")));
    let (at, harness) = cross(599);
    assert_eq!(at, None);
    assert!(says(&harness, "no cross: the next value"));
}

#[test]
fn a_selected_number_of_frames_is_retained_over_a_short_history() {
    let settings = settings();
    let (short, long) = (history_of(&settings, 40), history_of(&settings, 600));
    let shown = Rc::new(RefCell::new(shown_of(settings.clone(), Some(short), 39)));
    let (seen, mut inspector) = (Rc::clone(&shown), Inspector::default());
    let mut harness = Harness::builder()
        .with_size(Vec2::new(380.0, 1000.0))
        .with_context_setup(crate::app::theme::install)
        .build_ui(move |ui| {
            egui::CentralPanel::default().show(ui, |ui| {
                inspector.ui(
                    ui,
                    Some(&seen.borrow()),
                    None,
                    None,
                    FrameTimes { fps: 10.0, times: &[] },
                    &InspectorContext::default(),
                )
            });
        });
    open(&mut harness, "Scatter");
    let last =
        |harness: &Harness<'_>| harness.get_by_label("Frames up to the current one").accesskit_node().value();
    assert_eq!(last(&harness).as_deref(), Some("last 500"), "{:?}", texts(&harness));
    *shown.borrow_mut() = shown_of(settings, Some(long), 599);
    harness.run();
    assert_eq!(last(&harness).as_deref(), Some("last 500"), "the selection is unchanged");
}

#[test]
fn eight_components_where_nothing_matches_can_be_drawn() {
    let crowded = Settings { k: 8, t: 0.6, initial_sigma: 6.0, ..settings() };
    let colours = (0..400_u32).map(|n| {
        let surface = (n * n / 7) % 9;
        (n + 1, [20 + surface * 25, 240 - surface * 23, (surface * 71) % 250].map(|level| level as u8))
    });
    let mut history = PixelHistory::of_colours(AT, Parameters::new(&crowded), colours);
    history.push_colour(401, [250, 250, 250]);
    assert_eq!(history.states[400].pixel.used(), 8);
    let (mut harness, _) =
        harness(Some(shown_of(crowded, Some(history), 400)), Vec2::new(340.0, 960.0), Theme::Light);
    assert!(says(&harness, "no match; nearest is component"));
    for tab in ["Mixture", "History", "Tuning", "Statistics", "Scatter"] {
        open(&mut harness, tab);
        picture(&mut harness, &format!("crowded-{}", tab.to_lowercase()));
    }
    for by in ["verdict", "time"] {
        open(&mut harness, by);
        picture(&mut harness, &format!("crowded-scatter-{by}"));
    }
}

#[test]
fn a_low_panel_scrolls_under_the_verdict() {
    let (mut harness, _) = harness(Some(shown(430)), Vec2::new(340.0, 400.0), Theme::Light);
    let (headline, before) =
        (harness.get_by_label("Mixture").rect(), harness.get_by_label_contains("Weights 0").rect());
    harness.hover_at(Pos2::new(150.0, 300.0));
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: Vec2::new(0.0, -180.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    // Scrolling is animated over several frames.
    harness.run_steps(8);
    assert_eq!(harness.get_by_label("Mixture").rect(), headline, "tabs and verdict do not scroll");
    let after = harness.get_by_label_contains("Weights 0").rect();
    assert!(after.top() < before.top() - 100.0, "{before:?} to {after:?}");
    picture(&mut harness, "scrolled");
}

#[test]
fn the_first_frame_can_be_drawn() {
    let (mut harness, _) = tall(Some(shown(0)));
    assert!(says(&harness, "first frame of the model"));
    for tab in ["Mixture", "History", "Tuning", "Statistics", "Scatter"] {
        open(&mut harness, tab);
    }
}

#[test]
fn displayed_numbers_equal_the_state() {
    for position in [150, 425, 430, 560] {
        let shown = shown(position);
        let history = Arc::clone(shown.pixel.as_ref().unwrap());
        let (harness, _) = tall(Some(shown));
        let (state, words) = (history.states[position as usize], verdict(&history, position as usize));
        let [r, g, b] = state.rgb;
        for text in [
            format!("Pixel {}, {}", AT.0, AT.1),
            format!("frame {}", position + 1),
            format!("{:.1} s", position as f32 / 10.0),
            format!("R {r}   G {g}   B {b}"),
            words.headline.clone(),
            state.outcome.background_count.to_string(),
        ] {
            assert!(says(&harness, &text), "frame {position}: {text:?} in {:#?}", texts(&harness));
        }
        let all = texts(&harness);
        for detail in &words.details {
            assert!(all.contains(detail), "{detail}");
        }
        for component in state.pixel.components().iter().filter(|component| component.is_used()) {
            let [r, g, b] = component.mean;
            for text in [
                format!("{:.3}", component.weight),
                format!("{:.1}", component.sigma()),
                format!("{:.4}", component.rank_value()),
                format!("{r:.0}  {g:.0}  {b:.0}"),
            ] {
                assert!(all.contains(&text), "frame {position}: {text:?} in {all:#?}");
            }
        }
        if state.outcome.matched > 0 {
            let before = history.before(position as usize).unwrap();
            let matched = before.components()[usize::from(state.outcome.matched) - 1];
            assert!(all.contains(&format!("{:.1} σ", distance_in_sigmas(&matched, state.value))));
            assert!(all.iter().any(|text| text == "match") && !all.iter().any(|text| text == "new"));
        } else {
            assert!(all.iter().any(|text| text == "new") && !all.iter().any(|text| text == "match"));
        }
    }
}

#[test]
fn the_mixture_before_the_update_is_the_one_of_the_frame_before() {
    let shown = shown(430);
    let history = Arc::clone(shown.pixel.as_ref().unwrap());
    let (mut harness, _) = tall(Some(shown));
    harness.get_by_label("before").click();
    harness.run();
    let all = texts(&harness);
    for component in history.before(430).unwrap().components().iter().filter(|c| c.is_used()) {
        assert!(all.contains(&format!("{:.3}", component.weight)));
        assert!(all.contains(&format!("{:.4}", component.rank_value())));
    }
}

#[test]
fn both_mixtures_are_side_by_side_in_a_wide_panel() {
    for (width, context) in [(500.0, true), (240.0, false)] {
        let shown = shown(430);
        let history = Arc::clone(shown.pixel.as_ref().unwrap());
        let (mut harness, _) = harness(Some(shown), Vec2::new(width, 1400.0), Theme::Light);
        open(&mut harness, "both");
        let all = texts(&harness);
        for pixel in [history.before(430).unwrap(), &history.states[430].pixel] {
            for component in pixel.components().iter().filter(|component| component.is_used()) {
                assert!(all.contains(&format!("{:.3}", component.weight)));
                assert!(all.contains(&format!("{:.4}", component.rank_value())));
            }
        }
        let plots: Vec<_> =
            harness.get_all_by_label_contains("Densities of").map(|node| node.rect()).collect();
        assert_eq!(plots.len(), 2);
        assert_eq!(plots[1].left() > plots[0].right(), context);
        assert_eq!(plots[1].top() > plots[0].bottom(), !context);
    }
}

#[test]
fn component_changes_are_described_where_the_history_marks_them() {
    let shown = shown(430);
    let history = Arc::clone(shown.pixel.as_ref().unwrap());
    let (mut harness, _) = tall(Some(shown));
    open(&mut harness, "History");
    let mut changes = Vec::new();
    for index in (0..600).filter(|&index| component_change(&history, index).is_some()) {
        harness.hover_at(on_history(&harness, (index as f32 + 0.5) / 600.0));
        harness.run();
        let words = match component_change(&history, index).unwrap() {
            ComponentChange::Born => "was created",
            ComponentChange::Replaced => "replaced the last",
            ComponentChange::Rose { .. } => "It moved up from rank",
        };
        assert!(says(&harness, words), "frame {index}: {words:?} in {:?}", texts(&harness));
        changes.push(words);
    }
    assert!(
        changes.contains(&"was created") && changes.contains(&"It moved up from rank"),
        "the history must contain both changes: {changes:?}"
    );
}

#[test]
fn a_verdict_changed_by_post_processing_is_marked() {
    let mut shown = shown(425);
    let (harness, _) = tall(Some(shown.clone()));
    assert!(!says(&harness, "Changed by a later stage"));
    let mut analysis = (*shown.analysis).clone();
    analysis.mask = Arc::new(Mask::empty(SIZE));
    shown.analysis = Arc::new(analysis);
    let (harness, _) = tall(Some(shown));
    assert!(says(&harness, "After post-processing: background."));
    assert!(says(&harness, "post-processing (median 5) this pixel is background"));
}

/// The screen position of a fraction of the history's time axis.
fn on_history(harness: &Harness<'_>, share: f32) -> Pos2 {
    let plot = super::chart::inner(harness.get_by_label_contains("History of").rect());
    Pos2::new(plot.left() + plot.width() * share, plot.center().y)
}

fn click_history(harness: &mut Harness<'_>, share: f32) {
    let at = on_history(harness, share);
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run();
}

#[test]
fn new_settings_show_their_verdict_before_the_frame_is_analysed() {
    let shown = shown(300);
    let other = Settings { match_sigmas: 0.5, alpha: 0.2, ..settings() };
    let newest = Arc::new(history_of(&other, 600));
    let expected = verdict(&newest, 300).headline;
    assert_ne!(expected, verdict(shown.pixel.as_ref().unwrap(), 300).headline, "the verdicts must differ");
    let mut inspector = Inspector::default();
    let harness = Harness::builder()
        .with_size(Vec2::new(380.0, 1000.0))
        .with_context_setup(crate::app::theme::install)
        .build_ui(move |ui| {
            egui::CentralPanel::default().show(ui, |ui| {
                inspector.ui(
                    ui,
                    Some(&shown),
                    Some(&newest),
                    None,
                    FrameTimes { fps: 10.0, times: &[] },
                    &InspectorContext::default(),
                )
            });
        });
    assert!(texts(&harness).contains(&expected), "{expected}");
}

#[test]
fn a_click_in_the_history_goes_to_the_frame_under_it() {
    let (mut harness, actions) = tall(Some(shown(430)));
    open(&mut harness, "History");
    // 600 frames: the centre of frame 149 (from 0) is at 149.5 / 600.
    harness.hover_at(on_history(&harness, 149.5 / 600.0));
    harness.run();
    assert!(says(&harness, "Frame 150, 14.9 s"), "the tooltip names the frame: {:?}", texts(&harness));
    assert!(actions.borrow().is_empty(), "hovering requests nothing");
    picture(&mut harness, "history-hover");
    click_history(&mut harness, 149.5 / 600.0);
    assert_eq!(*actions.borrow(), [InspectorAction::GoTo(149)]);

    // Half as wide around frame 430: 300 frames from 215.25.
    harness.get_by_label("+").click();
    harness.run();
    actions.borrow_mut().clear();
    click_history(&mut harness, 0.25);
    assert_eq!(*actions.borrow(), [InspectorAction::GoTo(290)]);
    harness.get_by_label("All").click();
    harness.run();
    actions.borrow_mut().clear();
    click_history(&mut harness, 1.0);
    assert_eq!(*actions.borrow(), [InspectorAction::GoTo(599)], "the end of the axis is the last frame");
}

#[test]
fn dragging_pans_a_zoomed_history() {
    let (mut harness, actions) = tall(Some(shown(430)));
    open(&mut harness, "History");
    harness.get_by_label("+").click();
    harness.run();
    // 300 frames from 215.25; a drag to the right by a quarter shows 75 frames earlier.
    let (start, end) = (on_history(&harness, 0.5), on_history(&harness, 0.75));
    harness.hover_at(start);
    harness.drag_at(start);
    harness.step();
    harness.hover_at(end);
    harness.step();
    harness.drop_at(end);
    harness.run();
    assert!(actions.borrow().is_empty(), "a drag is not a click");
    click_history(&mut harness, 0.5);
    assert_eq!(*actions.borrow(), [InspectorAction::GoTo((215.25 - 75.0 + 150.0) as u32)]);
}

#[test]
fn a_zoomed_history_shows_single_frames_and_fits_its_values() {
    let (mut harness, _) = tall(Some(shown(430)));
    open(&mut harness, "History");
    for _ in 0..4 {
        harness.get_by_label("+").click();
        harness.run();
    }
    harness.get_by_label("fit values").click();
    harness.run();
    picture(&mut harness, "history-zoomed");
}

#[test]
fn component_slots_are_extended_from_the_end_of_the_previous_history() {
    let (settings, other) = (settings(), Settings { k: 3, ..settings() });
    let [short, long] = [300, 600].map(|frames| Arc::new(history_of(&settings, frames)));
    let expected = crate::explain::pixel::component_slots::slots_by_rank(&long);
    let mut followed = None;
    super::slotted(&mut followed, &short);
    assert_eq!(*super::slotted(&mut followed, &long), expected);
    // Slots that no computation would produce show which were reused.
    let marked = Arc::new(vec![[7; crate::mixture::MAX_K]; 300]);
    let mut followed = Some(SlottedHistory { history: Arc::clone(&short), slots: marked });
    let slots = super::slotted(&mut followed, &long);
    assert_eq!((slots.len(), slots[0], slots[299]), (600, [7; 8], [7; 8]));
    let another = Arc::new(history_of(&other, 600));
    assert_eq!(
        *super::slotted(&mut followed, &another),
        crate::explain::pixel::component_slots::slots_by_rank(&another)
    );
}

#[test]
fn a_long_history_is_drawn_with_few_vertices() {
    let settings = settings();
    let history = history_of(&settings, 100_000);
    let (mut harness, _) = tall(Some(shown_of(settings, Some(history), 50_000)));
    open(&mut harness, "History");
    picture(&mut harness, "history-long");
    let shapes = harness.output().shapes.clone();
    let painted = harness.ctx.tessellate(shapes, 1.0);
    let vertices = painted.iter().map(|it| match &it.primitive {
        egui::epaint::Primitive::Mesh(mesh) => mesh.vertices.len(),
        egui::epaint::Primitive::Callback(_) => 0,
    });
    let vertices: usize = vertices.sum();
    assert!(vertices < 100_000, "a repaint of 100 000 frames draws {vertices} vertices");
    open(&mut harness, "Scatter");
    harness.get_by_label("all").click();
    harness.run();
    picture(&mut harness, "scatter-long");
}

/// The screen position of a cell of the tuning map.
fn on_map(harness: &Harness<'_>, share: Vec2) -> Pos2 {
    let area = harness.get_by_label_contains("Tuning map, ").rect();
    let plot = egui::Rect::from_min_max(
        Pos2::new(area.left() + super::chart::GUTTER_WIDTH, area.top() + 6.0),
        Pos2::new(
            area.right() - super::chart::RIGHT_MARGIN,
            area.bottom() - super::chart::TICKS_HEIGHT - 15.0,
        ),
    );
    Pos2::new(plot.left() + plot.width() * share.x, plot.bottom() - plot.height() * share.y)
}

#[test]
fn a_click_in_the_tuning_map_applies_the_cell_named_in_its_tooltip() {
    let shown = shown(430);
    let tuning = tuning_of(&shown, [TunableSetting::Alpha, TunableSetting::T]).unwrap();
    let share = tuning.map.foreground_share();
    assert!(share > 0.05 && share < 0.95, "the map must contain both verdicts: {share}");
    let (mut harness, actions) = tall(Some(shown));
    open(&mut harness, "Tuning");
    assert!(says(&harness, &format!("foreground in {:.0} % of cells", share * 100.0)));
    for (column, row) in [(2, 20), (21, 3)] {
        let at = on_map(&harness, Vec2::new((column as f32 + 0.4) / 24.0, (row as f32 + 0.6) / 24.0));
        harness.hover_at(at);
        harness.run();
        let [alpha, t] = [tuning.map.axes[0].values[column], tuning.map.axes[1].values[row]];
        assert!(
            says(&harness, &format!("α = {},  T = {}", number(alpha), number(t))),
            "{:?}",
            texts(&harness)
        );
        let verdict = if tuning.map.is_foreground(column, row) { "Foreground" } else { "Background" };
        assert!(says(&harness, &format!("{verdict}. Click to apply")));
        picture(&mut harness, &format!("tuning-hover-{column}"));
        assert!(actions.borrow().is_empty(), "hovering requests nothing");
        harness.drag_at(at);
        harness.drop_at(at);
        harness.run();
        assert_eq!(
            actions.take(),
            [InspectorAction::Apply([(TunableSetting::Alpha, alpha), (TunableSetting::T, t)])]
        );
    }
}

#[test]
fn settings_that_flip_the_verdict_are_listed_and_applied() {
    let shown = shown(430);
    let tuning = tuning_of(&shown, [TunableSetting::Alpha, TunableSetting::T]).unwrap();
    let (mut harness, actions) = tall(Some(shown));
    open(&mut harness, "Tuning");
    let mut taken = 0;
    for flip in &tuning.flips {
        assert!(texts(&harness).contains(&flip.words()), "{} in {:?}", flip.words(), texts(&harness));
        let Some(value) = flip.value else { continue };
        harness.get_by_label(&flip.words()).click();
        harness.run();
        assert_eq!(actions.take(), [InspectorAction::Apply([(flip.setting, value); 2])]);
        taken += 1;
    }
    assert!(taken > 1, "several settings must flip the verdict: {:?}", tuning.flips);
}

#[test]
fn a_map_of_other_settings_is_requested_and_shown_when_computed() {
    let (shown, mut inspector) = (shown(430), Inspector::default());
    assert_eq!(inspector.requests().tuning_axes, None, "the tab is hidden");
    let asked = Rc::new(RefCell::new(None));
    let (noted, tuning) = (Rc::clone(&asked), tuning_of(&shown, [TunableSetting::Alpha, TunableSetting::T]));
    let mut harness = Harness::builder()
        .with_size(Vec2::new(380.0, 900.0))
        .with_context_setup(crate::app::theme::install)
        .build_ui(move |ui| {
            egui::CentralPanel::default().show(ui, |ui| {
                inspector.ui(
                    ui,
                    Some(&shown),
                    None,
                    tuning.as_ref(),
                    FrameTimes { fps: 10.0, times: &[] },
                    &InspectorContext::default(),
                );
                *noted.borrow_mut() = inspector.requests().tuning_axes;
            });
        });
    open(&mut harness, "Tuning");
    assert_eq!(*asked.borrow(), Some([TunableSetting::Alpha, TunableSetting::T]));
    // λ in the lower row of options: the y axis.
    harness.get_all_by_label("λ").last().unwrap().click();
    harness.run();
    assert_eq!(*asked.borrow(), Some([TunableSetting::Alpha, TunableSetting::Lambda]));
    assert!(says(&harness, "Tuning map, X axis α, Y axis λ, not computed yet"), "{:?}", texts(&harness));
    harness.get_all_by_label("α").last().unwrap().click();
    harness.run();
    assert_eq!(
        *asked.borrow(),
        Some([TunableSetting::Lambda, TunableSetting::Alpha]),
        "the axes are swapped"
    );
}

#[test]
fn statistics_cover_the_selected_frames_and_can_be_exported() {
    let shown = shown(430);
    let history = Arc::clone(shown.pixel.as_ref().unwrap());
    let (mut harness, actions) = tall(Some(shown));
    open(&mut harness, "Statistics");
    picture(&mut harness, "statistics");
    let check = |harness: &Harness<'_>, range: std::ops::Range<usize>| {
        let expected = Statistics::new(&history, range.clone());
        assert_eq!(expected.frames, range.len());
        let [r, g, b] = expected.variance;
        let share = expected.foreground_share() * 100.0;
        for text in [
            format!("{r:.1}   {g:.1}   {b:.1}  levels²"),
            format!("{share:.1} %,  {} of {} frames", expected.foreground, expected.frames),
            "100 frames,  10 s".to_owned(),
            expected.births.to_string(),
            expected.replacements.to_string(),
        ] {
            assert!(texts(harness).contains(&text), "{range:?}: {text:?} in {:?}", texts(harness));
        }
    };
    check(&harness, 0..600);
    harness.get_by_label("Up to current").click();
    harness.run();
    check(&harness, 0..431);
    choose(&mut harness, "Copy or save the numbers", "Copy CSV of frames");
    let [InspectorAction::Copy(table)] = &actions.take()[..] else { panic!("one table is requested") };
    assert_eq!(*table, Table::History(Arc::clone(&history), 0..431));
    let csv = table.csv().unwrap();
    assert_eq!((csv.lines().count(), table.rows()), (432, 431));
    let last = &history.states[430];
    let [r, g, b] = last.rgb;
    assert!(csv.lines().last().unwrap().starts_with(&format!("431,{r},{g},{b},{}", last.outcome.matched)));
    choose(&mut harness, "Copy or save the numbers", "Save CSV of statistics…");
    assert_eq!(actions.take(), [InspectorAction::Save(Table::Statistics(Arc::clone(&history), 0..431))]);
    harness.get_by_label("All").click();
    harness.run();
    check(&harness, 0..600);
}

#[test]
fn the_text_while_a_history_is_computed_has_the_percentage_where_it_is_known() {
    let text = |done, total| computing_history(Some(&WorkProgress { what: String::new(), done, total }));
    assert_eq!(text(37, Some(100)), "Computing pixel history… 37 %");
    assert_eq!(text(299, Some(300)), "Computing pixel history… 99 %", "rounded down");
    assert_eq!(text(0, Some(0)), "Computing pixel history…");
    assert_eq!((text(5, None), computing_history(None)), (text(0, Some(0)), text(0, Some(0))));
}
