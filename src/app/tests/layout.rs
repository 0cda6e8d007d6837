//! Open views and their layout, overlays, and the persisted state.

use std::collections::HashMap;

use super::*;
use crate::app::commands::action::Action;
use crate::app::model::layout::ViewLayout;
use crate::app::model::overlays::TrackOverlay;

pub(super) fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    harness.run_steps(3);
}

fn is_seen(harness: &Harness<'_, Window>, view: View) -> bool {
    harness.query_by_label(&format!("{} view", view.title())).is_some()
}

#[test]
fn a_view_can_be_closed_and_reopened_except_the_last() {
    let (mut harness, _) = ready(10);
    harness.get_by_label("Close: Regions").click();
    harness.run_steps(3);
    assert!(!is_seen(&harness, View::Regions) && is_seen(&harness, View::Foreground));
    picture(&mut harness, "regions-closed");
    harness.get_by_label("View").click();
    harness.run_steps(4);
    harness.get_by_label_contains("Views").click();
    harness.run_steps(4);
    harness.get_by_label("Regions view").click();
    harness.run_steps(4);
    assert!(is_seen(&harness, View::Regions));
    for view in View::ALL.into_iter().filter(|view| view.is_open_at_first()) {
        act(&mut harness, Action::Open(view));
    }
    let open = View::ALL.into_iter().filter(|&view| is_seen(&harness, view)).count();
    assert_eq!((open, harness.state().model.display.open.iter().filter(|open| **open).count()), (1, 1));
}

#[test]
fn layouts_arrange_views_and_panels() {
    let (mut harness, _) = ready(58);
    for (layout, name, seen) in [
        (ViewLayout::Figure, "figure", &View::ALL[..6]),
        (ViewLayout::Tuning, "tuning", &[View::Input, View::Foreground, View::Tracks]),
        (
            ViewLayout::Compare,
            "compare",
            &[
                View::Foreground,
                View::Tracks,
                View::Agreement,
                View::ComparedForeground,
                View::ComparedTracks,
            ],
        ),
        (ViewLayout::Inspect, "inspect", &[View::Input, View::Background, View::Foreground]),
        (
            ViewLayout::All,
            "all",
            &[View::Input, View::Background, View::Foreground, View::Regions, View::Tracks],
        ),
    ] {
        act(&mut harness, Action::Arrange(layout));
        for &view in seen {
            assert!(is_seen(&harness, view), "{view:?} in {layout:?}");
        }
        let panels =
            (harness.query_by_label("Settings").is_some(), harness.query_by_label("Events").is_some());
        assert_eq!(panels, layout.panels(), "{layout:?}");
        picture(&mut harness, &format!("layout-{name}"));
    }
}

#[test]
fn overlays_of_the_tracks_view_can_be_hidden() {
    let (mut harness, _) = ready(58);
    harness.state_mut().model.display.maximised = Some(View::Tracks);
    settle(&mut harness);
    let full = harness.render().unwrap();
    let mut plain = full.clone();
    for what in TrackOverlay::ALL {
        act(&mut harness, Action::Draw(what));
        let less = harness.render().unwrap();
        // A single frame has no trails and no events, and neither ground truth nor external results are loaded.
        let nothing = matches!(
            what,
            TrackOverlay::Trails | TrackOverlay::Events | TrackOverlay::Truth | TrackOverlay::External
        );
        assert_eq!(less == plain, nothing, "{what:?}");
        plain = less;
    }
    picture(&mut harness, "boxes-alone");
    harness.key_press(Key::T);
    harness.key_press(Key::G);
    harness.run_steps(3);
    let drawn = harness.state().model.display.track_overlays;
    assert!(
        drawn.has(TrackOverlay::Trails) && drawn.has(TrackOverlay::Gates) && !drawn.has(TrackOverlay::Names)
    );
}

#[test]
fn ground_truth_boxes_are_drawn_over_the_tracks_of_their_frame() {
    let (mut harness, _) = ready(58);
    harness.state_mut().model.display.maximised = Some(View::Tracks);
    settle(&mut harness);
    let without = harness.render().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gt.txt");
    std::fs::write(&path, "59,1,20,20,30,50,1,1,1\n60,2,90,20,30,50,1,1,1\n").unwrap();
    let truth = crate::truth::Truth::read(&path).unwrap();
    let ctx = harness.ctx.clone();
    harness.state_mut().handle_result(&ctx, DialogResult::Truth(Ok(Arc::new(truth))));
    // The toast about the ground truth would change the image.
    harness.state_mut().toasts = crate::app::panels::toasts::Toasts::default();
    harness.run_steps(2);
    let with = harness.render().unwrap();
    let rect = harness.get_by_label("Tracks and occlusions view").rect();
    let canvas = crate::app::views::ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    let differs = |place: Rect| different_pixels(&with, &without, canvas.place(&place));
    assert!(differs(Rect::new(18.0, 18.0, 34.0, 54.0)) > 200);
    assert_eq!(differs(Rect::new(100.0, 80.0, 30.0, 30.0)), 0, "boxes of other frames are not drawn");
    picture(&mut harness, "ground-truth");
    harness.state_mut().apply(&ctx, Command::Open("/videos/other.mp4".into(), Start::First));
    assert!(harness.state().model.truth.is_none());
}

#[test]
fn actual_size_draws_each_pixel_as_one_screen_pixel() {
    let (mut harness, _) = ready(10);
    act(&mut harness, Action::Actual);
    let rect = harness.get_by_label("Tracks and occlusions view").rect();
    let canvas = crate::app::views::ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    assert!((canvas.scale - 1.0).abs() < 1e-3, "{}", canvas.scale);
}

#[derive(Default)]
pub(super) struct Storage(pub(super) HashMap<String, String>);

impl eframe::Storage for Storage {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }

    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }

    fn flush(&mut self) {}
}

#[test]
fn the_window_state_survives_a_restart() {
    use eframe::App as _;
    let (mut harness, _) = ready(10);
    act(&mut harness, Action::Arrange(ViewLayout::Compare));
    act(&mut harness, Action::Open(View::Difference));
    act(&mut harness, Action::Draw(TrackOverlay::Gates));
    act(&mut harness, Action::OverlayOpacity);
    act(&mut harness, Action::Faster);
    act(&mut harness, Action::Bookmark);
    act(&mut harness, Action::Theme);
    let mut storage = Storage::default();
    harness.state_mut().save(&mut storage);

    let (mut next, _) = window(None, (1600.0, 1000.0), Theme::Dark);
    let ctx = next.ctx.clone();
    next.state_mut().restore(&ctx, Some(&storage));
    next.run_steps(2);
    let (was, is) = (&harness.state().model, &next.state().model);
    assert_eq!(is.display.open, was.display.open);
    assert!(!is.display.open[View::Difference.index()] && is.panels.settings && !is.panels.inspector);
    assert_eq!(is.display.track_overlays, was.display.track_overlays);
    assert_eq!((is.display.overlay, is.playback.speed), (was.display.overlay, was.playback.speed));
    assert!(!is.display.track_overlays.has(TrackOverlay::Gates));
    assert_eq!(is.videos.recent, ["/videos/walk.mp4"]);
    assert!(next.state().light);
    next.state_mut().apply(&ctx, Command::Open("/videos/walk.mp4".into(), Start::First));
    assert!(next.state().model.playback.marks.bookmarks.contains(&10));
    next.state_mut().apply(&ctx, Command::Open("/videos/other.mp4".into(), Start::First));
    assert!(next.state().model.playback.marks.is_empty());

    // An unreadable state gives the initial values.
    storage.0.insert("window".into(), "(light: 7".into());
    storage.0.insert("layout".into(), "nothing".into());
    let (mut fresh, _) = window(None, (1600.0, 1000.0), Theme::Dark);
    fresh.state_mut().restore(&ctx, Some(&storage));
    assert_eq!(fresh.state().model.display.open, View::ALL.map(View::is_open_at_first));
    assert!(fresh.state().model.videos.recent.is_empty());
}

#[test]
fn an_events_evidence_can_be_read_in_a_small_window() {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(50))), (1600.0, 1000.0), Theme::Dark);
    harness.get_by_label("merge 1 + 2, frame 51").click();
    harness.run_steps(3);
    harness.set_size(vec2(1024.0, 640.0));
    settle(&mut harness);
    harness.run_steps(4);
    picture(&mut harness, "evidence-small");
    let [row, why, because] = ["enter 2, frame 1", "Evidence for merge 1 + 2", "merge because region 4 grew"]
        .map(|label| harness.get_by_label(label).rect());
    assert!(row.bottom() <= why.top(), "the list covers the evidence: {row} {why}");
    let below = harness.get_by_label("Tracks and occlusions view").rect().bottom();
    assert!(because.bottom() + 30.0 < below, "no space for numbers below {because}, above {below}");
}
