//! The timeline: zoom, marks, and the playback range.

use super::*;

fn wheel(harness: &mut Harness<'_, Window>, delta: egui::Vec2) {
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta,
        modifiers: Modifiers::NONE,
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
    });
    harness.run_steps(20);
}

#[test]
fn the_wheel_zooms_and_pans_and_a_key_shows_the_whole_video() {
    let (mut harness, scene) = ready(10);
    let rect = harness.get_by_label("Timeline").rect();
    let middle = rect.center();
    harness.hover_at(middle);
    wheel(&mut harness, vec2(0.0, 300.0));
    let (from, to) = harness.state().model.panels.timeline_span.unwrap();
    assert!(to - from < 40.0 && from > 30.0 && to < 90.0, "{from} to {to}");
    assert_eq!(harness.state().model.display.camera.magnification, 1.0, "the views' camera is unchanged");
    picture(&mut harness, "timeline-near");
    wheel(&mut harness, vec2(-200.0, 0.0));
    let moved = harness.state().model.panels.timeline_span.unwrap();
    assert!(moved.0 > from + 2.0 && (moved.1 - moved.0 - (to - from)).abs() < 0.01, "{moved:?}");
    // A click selects the position that is visible under the pointer.
    harness.event(egui::Event::PointerMoved(rect.left_center() + vec2(9.0, 20.0)));
    harness.step();
    for pressed in [true, false] {
        let pos = rect.left_center() + vec2(9.0, 20.0);
        let button = egui::PointerButton::Primary;
        harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
        harness.step();
    }
    let clicked = *shows(&scene).last().unwrap() as f32;
    assert!((clicked - moved.0).abs() <= 1.0, "{clicked} at {moved:?}");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::F);
    harness.run_steps(3);
    assert_eq!(harness.state().model.panels.timeline_span, None);
}

#[test]
fn a_playback_range_is_repeated() {
    let (mut harness, scene) = ready(40);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Home);
    harness.run_steps(3);
    harness.state_mut().model.playback.marks.toggle_end(43);
    picture(&mut harness, "timeline-part");
    harness.key_press(Key::Space);
    harness.run_steps(60);
    let played = shows(&scene);
    assert!(played.len() > 6, "{played:?}");
    assert!(played.iter().all(|position| (40..=43).contains(position)), "{played:?}");
    assert!(played.windows(2).any(|pair| pair == [43, 40]), "{played:?}");
}

#[test]
fn bookmarks_are_set_and_visited_by_key() {
    let (mut harness, scene) = ready(40);
    harness.key_press(Key::K);
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    harness.run_steps(3);
    harness.key_press(Key::K);
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::P);
    harness.run_steps(3);
    assert_eq!(shows(&scene), [50, 40]);
    picture(&mut harness, "timeline-bookmarks");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::N);
    harness.run_steps(3);
    assert_eq!(shows(&scene), [50, 40, 50]);
    harness.key_press(Key::K);
    harness.run_steps(3);
    assert_eq!(harness.state().model.playback.marks.bookmarks.len(), 1);
}
