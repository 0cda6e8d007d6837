//! Pinned pixels and the region around the chosen pixel: shortcuts, display, and requests to the worker.

use super::inspector::copied_text;
use super::*;
use crate::app::commands::action::Action;
use crate::app::model::camera::ViewCamera;

const AT: (u32, u32) = (80, 60);
const PINNED: [(u32, u32); 3] = [(80, 60), (30, 40), (120, 50)];

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    apply(harness, Command::Act(action));
}

fn apply(harness: &mut Harness<'_, Window>, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, command);
    harness.run_steps(3);
}

/// A scene with a chosen pixel.
fn inspected(size: (f32, f32), theme: Theme) -> (Harness<'static, Window>, RecordingPlayer) {
    let history = Some(history_of(AT));
    let shown = ShownFrame { pixel: history.clone(), ..shown_at(58) };
    let state = State { shown: Some(Arc::new(shown)), pixel: history, ..state(Phase::Ready, Some(58)) };
    let (mut harness, scene) = window(Some(state), size, theme);
    apply(&mut harness, Command::Choose(Some(AT)));
    (harness, scene)
}

fn pins_asked(scene: &RecordingPlayer) -> Vec<Vec<(u32, u32)>> {
    let asked = scene.asked.borrow();
    asked
        .iter()
        .filter_map(|asked| if let PlayerCall::Pin(pins) = asked { Some(pins.clone()) } else { None })
        .collect()
}

fn regions_asked(scene: &RecordingPlayer) -> Vec<Option<((u32, u32), u32)>> {
    let asked = scene.asked.borrow();
    asked
        .iter()
        .filter_map(|asked| if let PlayerCall::Region(region) = asked { Some(*region) } else { None })
        .map(|region| region.map(|region| (region.centre, region.side)))
        .collect()
}

#[test]
fn pixels_are_pinned_listed_chosen_and_unpinned() {
    let (mut harness, scene) = inspected((1600.0, 1000.0), Theme::Dark);
    assert!(pins_asked(&scene).is_empty());
    harness.get_by_label("Pin pixel").click();
    harness.run_steps(3);
    for at in &PINNED[1..] {
        apply(&mut harness, Command::Choose(Some(*at)));
        harness.key_press(Key::D);
        harness.run_steps(3);
    }
    assert_eq!(
        pins_asked(&scene),
        [PINNED[..1].to_vec(), PINNED[..2].to_vec(), PINNED.to_vec()],
        "once each"
    );
    harness.get_by_label("Pixels").click();
    harness.run_steps(4);
    harness.get_by_label("30, 40").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.selection.pixel, Some((30, 40)));
    harness.get_by_label("Unpin 1").click();
    harness.run_steps(3);
    assert_eq!(pins_asked(&scene).last().unwrap()[..], PINNED[1..]);
    // A click in a small multiple goes to the frame under it.
    let spark = harness.get_by_label_contains("Pinned pixel 3 at 120, 50");
    let place = spark.rect();
    assert!(place.height() < 60.0, "{place}");
    spark.click();
    harness.run_steps(3);
    assert_eq!(shows(&scene).last(), Some(&60), "the middle of 120 frames");

    act(&mut harness, Action::ClearPins);
    assert_eq!(pins_asked(&scene).last().unwrap(), &[]);
    for x in 0..9 {
        apply(&mut harness, Command::Choose(Some((x, 1))));
        act(&mut harness, Action::Pin);
    }
    assert_eq!(pins_asked(&scene).last().unwrap().len(), 8);
    act(&mut harness, Action::Messages);
    harness.get_by_label("8 pixels are pinned, the maximum; unpin one first");
}

#[test]
fn pins_belong_to_their_video() {
    let (mut harness, scene) = inspected((1600.0, 1000.0), Theme::Dark);
    act(&mut harness, Action::Pin);
    apply(&mut harness, Command::Open("/videos/other.mp4".into(), Start::First));
    assert!(harness.state().model.playback.marks.pins.is_empty());
    apply(&mut harness, Command::Open("/videos/walk.mp4".into(), Start::First));
    assert_eq!(pins_asked(&scene), [vec![AT], vec![AT]], "requested of the new worker, too");
    // Without a chosen pixel, the pins are listed to choose from.
    scene.state.borrow_mut().pixel = None;
    scene.state.borrow_mut().shown = Some(Arc::new(shown_at(58)));
    settle(&mut harness);
    harness.get_by_label("No pixel selected");
    harness.get_by_label("80, 60").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.selection.pixel, Some(AT));
}

#[test]
fn pixels_without_their_first_frames_are_reported_as_unavailable() {
    let (mut harness, scene) = inspected((1600.0, 1000.0), Theme::Dark);
    for at in &PINNED[..2] {
        apply(&mut harness, Command::Choose(Some(*at)));
        act(&mut harness, Action::Pin);
    }
    // As with a long-running camera: one history is lost, the other is not computed yet.
    {
        let mut state = scene.state.borrow_mut();
        (state.pixel, state.pins, state.lost) = (None, Arc::default(), vec![AT]);
        state.shown = Some(Arc::new(shown_at(58)));
    }
    apply(&mut harness, Command::Choose(Some(AT)));
    settle(&mut harness);
    harness.run_steps(2);
    assert!(harness.query_by_label("No pixel selected").is_none());
    harness.get_by_label("Pixel 80, 60");
    harness.get_by_label_contains("Pixel history not available: it needs the first frames");
    harness.get_by_label_contains("Not available");
    harness.get_by_label("Computing history…");
    picture(&mut harness, "pixels-lost");
    apply(&mut harness, Command::Choose(Some(PINNED[1])));
    harness.run_steps(2);
    harness.get_by_label("Pixel 30, 40");
    harness.get_by_label("Computing pixel history…");
    scene.state.borrow_mut().pixel_progress =
        Some(WorkProgress { what: "computing pixel history".into(), done: 37, total: Some(100) });
    settle(&mut harness);
    harness.get_by_label("Computing pixel history… 37 %");
    act(&mut harness, Action::ClearPins);
    apply(&mut harness, Command::Choose(Some(AT)));
    harness.run_steps(2);
    harness.get_by_label_contains("Pixel history not available");
    picture(&mut harness, "pixel-lost");
    apply(&mut harness, Command::Choose(None));
    harness.run_steps(2);
    harness.get_by_label("No pixel selected");
}

#[test]
fn plots_of_several_pixels_can_be_exported() {
    let (mut harness, scene) = inspected((1600.0, 1000.0), Theme::Dark);
    for at in PINNED.into_iter().rev() {
        apply(&mut harness, Command::Choose(Some(at)));
        act(&mut harness, Action::Pin);
    }
    harness.get_by_label("Pixels").click();
    harness.run_steps(4);
    harness.get_by_label("Copy or save the foreground ratio").click();
    harness.run_steps(4);
    picture(&mut harness, "pixels-menu");
    harness.get_by_label("Copy CSV").click();
    let copied = copied_text(&mut harness);
    let shares = scene.state.borrow().region.clone().unwrap();
    assert_eq!(copied.lines().count() as u32, FRAMES + 1);
    let share = |share: f32| crate::export::number::significant(share);
    let row = format!("50,{},{}", share(shares.model[49]), share(shares.cleaned[49]));
    assert!(copied.starts_with("frame,model,cleaned\n") && copied.lines().nth(50) == Some(&row), "{copied}");

    harness.get_by_label("Copy or save the pinned pixels").click();
    harness.run_steps(4);
    harness.get_by_label("Copy CSV").click();
    let copied = copied_text(&mut harness);
    assert_eq!(copied.lines().count() as u32, 3 * FRAMES + 1);
    assert!(copied.starts_with("pin,x,y,frame,value_r,"));
    assert!(copied.lines().nth(1).unwrap().starts_with("1,120,50,1,"), "the pin's number");
}

#[test]
fn the_region_is_requested_only_while_its_tab_is_visible() {
    let (mut harness, scene) = inspected((1600.0, 1000.0), Theme::Dark);
    assert!(regions_asked(&scene).is_empty());
    harness.get_by_label("Pixels").click();
    harness.run_steps(4);
    harness.get_by_label("15×15").click();
    harness.run_steps(4);
    assert_eq!(regions_asked(&scene), [Some((AT, 5)), Some((AT, 15))]);
    let curve = harness.get_by_label_contains("Foreground ratio in neighbourhood, ");
    curve.click();
    harness.run_steps(3);
    assert!((50..70).contains(shows(&scene).last().unwrap()), "near the middle");
    harness.get_all_by_label("Mixture").last().unwrap().click();
    harness.run_steps(4);
    assert_eq!(regions_asked(&scene).last(), Some(&None));
}

#[test]
fn several_pixels_can_be_compared_in_both_themes_and_all_window_sizes() {
    for (theme, name) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        for size in [(1024.0, 640.0), (1600.0, 1000.0)] {
            let (mut harness, _) = inspected(size, theme);
            for at in PINNED.into_iter().rev() {
                apply(&mut harness, Command::Choose(Some(at)));
                act(&mut harness, Action::Pin);
            }
            harness.get_by_label("Pixels").click();
            harness.run_steps(4);
            picture(&mut harness, &format!("pixels-{}-{name}", size.0));
            harness.state_mut().model.display.camera = ViewCamera { magnification: 30.0, centre: [0.5, 0.5] };
            picture(&mut harness, &format!("pixels-close-up-{}-{name}", size.0));
        }
    }
}
