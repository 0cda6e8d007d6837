//! Comparison of the settings A and B.

use super::panels::settings_panel;
use super::*;
use crate::app::commands::action::Action;
use crate::app::model::event_comparison::{ComparisonFilter, EventRef};
use crate::app::model::layout::ViewLayout;
use crate::app::views::{ViewCanvas, loupe_words};
use crate::replay::ComparedSequence;
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::clear_mot::ClearMot;
use crate::truth::hota::Hota;
use crate::truth::summary::{Score, TrackScore};
use crate::truth::survival::Survival;

/// The frame under settings with another K than the default: the third object is missing and events differ.
fn under(mut shown: ShownFrame, settings: &Settings) -> ShownFrame {
    shown.settings = Arc::new(settings.clone());
    if settings.k == Settings::default().k {
        return shown;
    }
    let mut analysis = Analysis::clone(&shown.analysis);
    let (mask, labels) = (Arc::make_mut(&mut analysis.mask), &shown.analysis.labels);
    for run in labels.runs.iter().filter(|run| run.label == 3) {
        mask.data[run.pixels()].fill(Mask::BACKGROUND);
    }
    Arc::make_mut(&mut analysis.tracks).retain(|track| track.id != 3);
    ShownFrame { analysis: Arc::new(analysis), ..shown }
}

fn timeline_under(settings: &Settings) -> Timeline {
    let mut timeline = timeline();
    let tracks = score(if settings.k == Settings::default().k { 0.9 } else { 0.4 });
    timeline.score = Some(Arc::new(Score { tracks: Some(tracks), masks: None }));
    if settings.k != Settings::default().k {
        timeline.events.retain(|(_, event)| event.objects != [3]);
        for (position, event) in &mut timeline.events {
            if event.kind == EventKind::Merge {
                (*position, event.frame) = (*position + 4, event.frame + 4);
            }
        }
        timeline.events.push(super::event(EventKind::Exit, 110, &[1], (150.0, 60.0)));
    }
    timeline
}

fn score(mota: f64) -> TrackScore {
    let of = ClearMot {
        mota,
        motp: 0.2,
        idf1: mota,
        precision: 1.0,
        recall: 1.0,
        num_switches: 2,
        num_fragmentations: 0,
        mostly_tracked: 3,
        num_unique_objects: 3,
    };
    let occlusion = Survival { episodes: 2, identities: 4, survived: 3, survival: Some(0.75) };
    let hota = Hota { hota: mota, deta: mota, assa: mota, loca: 0.8 };
    TrackScore { strict: of.clone(), loose: of, hota, occlusion }
}

/// The worker's published state after new settings.
pub(super) fn answer(state: &mut State, settings: &Settings, beside: Option<Settings>) {
    let Some(position) = state.shown.as_ref().map(|shown| shown.position) else { return };
    if beside.is_none() && state.compared.is_none() {
        return;
    }
    let mut shown = under(shown_at(position), settings);
    shown.compared = beside.as_ref().map(|other| Arc::new(under(shown_at(position), other)));
    state.shown = Some(Arc::new(shown));
    state.timeline = Arc::new(timeline_under(settings));
    let other = beside.filter(|other| other != settings);
    state.compared = other.map(|other| {
        let timeline = timeline_under(&other);
        Arc::new(ComparedSequence { settings: Arc::new(other), timeline })
    });
}

/// A scene with K = 2 as B, which is in view, in the comparison layout.
fn comparing() -> (Harness<'static, Window>, RecordingPlayer) {
    let (mut harness, scene) = ready(30);
    harness.key_press(Key::B);
    harness.run_steps(3);
    harness.state_mut().model.edits.settings.k = 2;
    harness.run_steps(3);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(Action::Arrange(ViewLayout::Compare)));
    settle(&mut harness);
    (harness, scene)
}

fn beside(scene: &RecordingPlayer) -> Option<Settings> {
    let asked = scene.asked.borrow();
    let last = asked.iter().rev().find_map(|asked| match asked {
        PlayerCall::Compare(beside) => Some(beside.clone()),
        _ => None,
    });
    last.flatten().map(|settings| *settings)
}

#[test]
fn both_slots_are_requested_and_shown_side_by_side() {
    let (mut harness, scene) = comparing();
    assert_eq!(given(&scene).unwrap().k, 2);
    assert_eq!(beside(&scene), Some(Settings::default()));
    picture(&mut harness, "compare");
    // Only A has the third object; both have the first.
    let picture = harness.render().unwrap();
    let at = |view: &str, pixel: (u32, u32)| {
        let rect = harness.get_by_label(view).rect();
        let canvas = super::super::views::ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
        let place = canvas.place_pixel(pixel).center();
        picture.get_pixel(place.x as u32, place.y as u32).0
    };
    let third = (120, 36);
    assert_eq!(at("Foreground view", third)[..3], [0, 0, 0]);
    assert_eq!(at("Foreground (A) view", third)[..3], [255, 255, 255]);
    let only_a = at("A vs B difference view", third);
    assert!(only_a[0] > 150 && only_a[2] < 60, "{only_a:?} is not the colour of A");
    let both = at("A vs B difference view", (50, 60));
    assert!(both[0] > 150 && both[2] > 150, "{both:?} is not the colour of both");
    harness.get_by_label("Foreground (B)");
    harness.get_by_label("Foreground (A)");
    harness.state_mut().model.display.camera.magnification = 30.0;
    super::picture(&mut harness, "compare-near");
}

#[test]
fn the_loupe_shows_the_verdict_of_the_settings_of_its_view() {
    let (mut harness, scene) = comparing();
    let (third, first, wall) = ((120, 36), (50, 60), (10, 10));
    // The pixel histories of A and B differ.
    {
        let mut state = scene.state.borrow_mut();
        let shown = state.shown.as_deref().unwrap();
        let history = |level: u8, shown: &ShownFrame| {
            let colours = (1..=FRAMES).map(|n| (n, if n == 31 { [level; 3] } else { [90; 3] }));
            Some(Arc::new(PixelHistory::of_colours(third, Parameters::new(&shown.settings), colours)))
        };
        let other = shown.compared.as_deref().unwrap();
        let other = ShownFrame { pixel: history(250, other), ..ShownFrame::clone(other) };
        let pixel = history(90, shown);
        let shown = ShownFrame { pixel, compared: Some(Arc::new(other)), ..ShownFrame::clone(shown) };
        state.shown = Some(Arc::new(shown));
    }
    settle(&mut harness);
    let words = |harness: &Harness<'_, Window>, view, pixel| {
        let model = &harness.state().model;
        loupe_words(view, model, model.worker.shown().unwrap(), pixel).map(|(text, _)| text)
    };
    let at = |(x, y): (u32, u32)| format!("{x}, {y}");
    for (view, pixel, value, verdict) in [
        (View::Foreground, third, "0", "background, rank 1"),
        (View::ComparedForeground, third, "255", "foreground, no match"),
        (View::Agreement, third, "255 0", "foreground in A only"),
        (View::Agreement, first, "255 255", "foreground in A and B"),
        (View::Agreement, wall, "0 0", "foreground in neither"),
    ] {
        assert_eq!(
            words(&harness, view, pixel),
            [at(pixel), value.to_owned(), verdict.to_owned()],
            "{view:?}"
        );
    }
    for view in [View::ComparedBackground, View::ComparedTracks] {
        assert_eq!(words(&harness, view, third)[2], "foreground, no match", "{view:?}");
    }
    let rect = harness.get_by_label("A vs B difference view").rect();
    let pointer =
        ViewCanvas::new(rect, SIZE, harness.state().model.display.camera).place_pixel(third).center();
    harness.hover_at(pointer);
    harness.run_steps(3);
    harness.get_by_label("A vs B difference  255 0");
    harness.key_press(Key::L);
    harness.run_steps(3);
    picture(&mut harness, "compare-loupe");
    // With A in view, A still comes first.
    harness.key_press(Key::A);
    harness.run_steps(5);
    settle(&mut harness);
    assert_eq!(words(&harness, View::Agreement, third)[1..], ["255 0", "foreground in A only"]);
}

#[test]
fn comparison_views_name_what_is_missing() {
    let (mut harness, scene) = ready(30);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(Action::Arrange(ViewLayout::Compare)));
    settle(&mut harness);
    picture(&mut harness, "compare-one");
    harness.key_press(Key::B);
    harness.run_steps(3);
    {
        let mut state = scene.state.borrow_mut();
        let alone = ShownFrame { compared: None, ..ShownFrame::clone(state.shown.as_ref().unwrap()) };
        state.shown = Some(Arc::new(alone));
    }
    settle(&mut harness);
    picture(&mut harness, "compare-waiting");
}

#[test]
fn the_other_slot_is_in_view_while_a_key_is_held() {
    let (mut harness, scene) = comparing();
    harness.event(egui::Event::Key {
        key: Key::X,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(5);
    assert_eq!(given(&scene).unwrap(), Settings::default());
    assert_eq!(beside(&scene).unwrap().k, 2);
    harness.event(egui::Event::Key {
        key: Key::X,
        physical_key: None,
        pressed: false,
        repeat: false,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(5);
    assert_eq!((given(&scene).unwrap().k, beside(&scene)), (2, Some(Settings::default())));
}

#[test]
fn copying_swapping_and_dropping_a_slot_can_be_undone() {
    let (mut harness, scene) = comparing();
    let ctx = harness.ctx.clone();
    let act = |harness: &mut Harness<'_, Window>, action| {
        harness.state_mut().apply(&ctx, Command::Act(action));
        harness.run_steps(3);
        (given(&scene).unwrap().k, beside(&scene).map(|settings| settings.k))
    };
    let k = Settings::default().k;
    assert_eq!(act(&mut harness, Action::SwapSettings), (k, Some(2)));
    assert_eq!(act(&mut harness, Action::Undo), (2, Some(k)));
    assert_eq!(act(&mut harness, Action::CopySettings), (2, Some(2)));
    assert_eq!(act(&mut harness, Action::Undo), (2, Some(k)));
    assert_eq!(act(&mut harness, Action::KeepSettings), (2, None));
    assert_eq!(harness.state().model.edits.ab_settings.in_view, AbSlot::A);
    assert_eq!(act(&mut harness, Action::Undo), (2, Some(k)));
    assert_eq!(harness.state().model.edits.ab_settings.in_view, AbSlot::B);
}

#[test]
fn events_are_filtered_by_slot() {
    let (mut harness, scene) = comparing();
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(Action::InspectorPanel));
    harness.run_steps(4);
    harness.get_by_label("Exit 1, frame 110, B".replace("Exit", "exit").as_str());
    harness.get_by_label("disappear 3, frame 41, A");
    harness.get_by_label("merge 1 + 2, frame 55, -4 in A");
    right_panel_looks_as_before(&mut harness, "compare-events");
    harness.get_by_label("Events under A only").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.events.filter, ComparisonFilter::OnlyCompared);
    assert!(harness.query_by_label_contains("exit 1").is_none());
    // An event of the compared settings is selected like any other.
    harness.get_by_label("disappear 3, frame 41, A").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.selection.event, Some(EventRef::Compared(2)));
    assert_eq!(shows(&scene).last(), Some(&40));
    harness.get_by_label("Evidence for disappear 3");
}

#[test]
fn both_slots_are_scored_against_the_ground_truth() {
    let (mut harness, scene) = comparing();
    let ctx = harness.ctx.clone();
    let boxes = Truth { boxes: Some(Boxes::new()), masks: None, ..Truth::default() };
    harness.state_mut().handle_result(&ctx, DialogResult::Truth(Ok(Arc::new(boxes))));
    settle(&mut harness);
    assert!(scene.asked.borrow().contains(&PlayerCall::Truth(true)));
    harness.get_all_by_label(".900").next().unwrap();
    harness.get_all_by_label(".400").next().unwrap();
    let end =
        harness.get_all_by_label("Registration").map(|node| node.rect().top()).reduce(f32::min).unwrap();
    let part = settings_panel(&harness).with_max_y(end);
    part_looks_as_before(&mut harness, part, "compare-scores");
}

#[test]
fn the_inspector_shows_the_mixtures_of_both_slots() {
    let (mut harness, scene) = comparing();
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(Action::InspectorPanel));
    {
        let mut state = scene.state.borrow_mut();
        let shown = ShownFrame::clone(state.shown.as_ref().unwrap());
        let history = |settings: &Settings| {
            let colours = (0..FRAMES)
                .map(|n| (n + 1, if n == 30 { [180, 60, 60] } else { [90, 90 + (n % 3) as u8, 95] }));
            Some(Arc::new(PixelHistory::of_colours((50, 60), Parameters::new(settings), colours)))
        };
        let other = shown.compared.as_ref().unwrap();
        let tight = Settings { match_sigmas: 9.0, ..Settings::default() };
        let other = ShownFrame { pixel: history(&tight), ..ShownFrame::clone(other) };
        state.shown = Some(Arc::new(ShownFrame {
            pixel: history(&shown.settings),
            compared: Some(Arc::new(other)),
            ..shown
        }));
    }
    settle(&mut harness);
    harness.run_steps(4);
    harness.get_by_label_contains("B: Foreground");
    harness.get_by_label_contains("A: Background");
    harness.get_by_label("Under A");
    right_panel_looks_as_before(&mut harness, "compare-pixel");
}
