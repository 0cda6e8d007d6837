//! The object panel.

use super::*;
use crate::app::commands::action::Action;
use crate::app::model::event_comparison::EventRef;
use crate::app::model::selection::Subject;
use crate::app::views::ViewCanvas;

/// Clicks on a place of the image in a view.
fn click(harness: &mut Harness<'_, Window>, view: &str, at: [f32; 2]) {
    let rect = harness.get_by_label(view).rect();
    let canvas = ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    click_at(harness, canvas.screen(at));
    // Two clicks at once would be a double click.
    harness.run_steps(40);
}

/// A window that shows the whole panel.
fn tall() -> (Harness<'static, Window>, RecordingPlayer) {
    window(Some(state(Phase::Ready, Some(30))), (1600.0, 1700.0), Theme::Dark)
}

#[test]
fn a_click_on_an_object_explains_it_with_its_numbers() {
    let (mut harness, scene) = tall();
    click(&mut harness, "Tracks and occlusions view", [50.5, 60.5]);
    assert_eq!(
        (harness.state().model.selection.object, harness.state().model.selection.subject),
        (Some(1), Subject::Object)
    );
    assert_eq!(harness.state().model.selection.pixel, Some((50, 60)), "the click chooses the pixel, too");
    harness.get_by_label("Associated with region 1; 100 % of its full size is visible.");
    assert_eq!(harness.query_all_by_label("50.0, 60.0 px").count(), 2, "centre and centroid");
    harness.get_by_label("+1.00, +0.00 px/frame");
    // 25 frames a second.
    harness.get_by_label("25.0 px/s");
    harness.get_by_label("0.80");
    harness.get_by_label("0.20");
    harness.get_by_label("565 px");
    harness.get_by_label_contains("dominant colour R 200 G 70 B 60, 75 %");
    // The object's own colour is 200, 10, 10.
    let apart = regions::colour::delta_e([200, 10, 10], [200, 70, 60]);
    harness.get_by_label_contains(&format!("ΔE {apart:.1} to the dominant colour"));
    harness.get_by_label("frames 1–120, 4.8 s: 100 visible, 20 merged, 0 occluded");
    right_panel_looks_as_before(&mut harness, "object");
    harness.get_by_label("#51  merge 1 + 2").click();
    settle(&mut harness);
    assert_eq!(harness.state().model.selection.event, Some(EventRef::InView(3)));
    assert_eq!(shows(&scene), [50]);
    right_panel_looks_as_before(&mut harness, "object-merged");
    harness.get_by_label_contains("Shares region 1 with 2;");
    harness.get_by_label("Explain pixel 50, 60").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.selection.subject, Subject::Pixel);
    harness.get_by_label("Explain object 1").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.selection.subject, Subject::Object);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(Action::ClearObject));
    harness.run_steps(3);
    assert!(harness.query_by_label("Explain object 1").is_none());
}

#[test]
fn clicking_a_region_chooses_its_object_and_an_absent_object_is_reported() {
    let (mut harness, scene) = tall();
    // Where two boxes overlap, the region determines the object.
    click(&mut harness, "Regions view", [110.0, 66.0]);
    assert_eq!(harness.state().model.selection.object, Some(2));
    click(&mut harness, "Input view", [110.0, 66.0]);
    assert_eq!(
        (harness.state().model.selection.object, harness.state().model.selection.subject),
        (Some(2), Subject::Pixel)
    );
    click(&mut harness, "Tracks and occlusions view", [120.0, 30.0]);
    assert_eq!(harness.state().model.selection.object, Some(3));
    let life = harness.get_by_label("Frame in track timeline").rect();
    click_at(&mut harness, life.lerp_inside(vec2(0.5, 0.5)));
    assert_eq!(shows(&scene).last(), Some(&60));
    settle(&mut harness);
    harness.get_by_label_contains("Occluded: no associated region.");
    harness.get_by_label("No hypotheses: no associated region.");
    picture(&mut harness, "object-hidden");
    harness.state_mut().model.selection.object = Some(9);
    harness.run_steps(3);
    harness.get_by_label("No box in this frame.");
    picture(&mut harness, "object-away");
}

fn click_at(harness: &mut Harness<'_, Window>, at: egui::Pos2) {
    harness.event(egui::Event::PointerMoved(at));
    harness.step();
    for pressed in [true, false] {
        let (button, modifiers) = (egui::PointerButton::Primary, Modifiers::NONE);
        harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
        harness.step();
    }
    harness.run_steps(3);
}

#[test]
fn the_panel_fits_a_small_window_in_the_light_theme() {
    for (size, theme, name) in
        [((1024.0, 640.0), Theme::Dark, "object-small"), ((1600.0, 1000.0), Theme::Light, "object-light")]
    {
        let (mut harness, _) = window(Some(state(Phase::Ready, Some(30))), size, theme);
        let ctx = harness.ctx.clone();
        harness.state_mut().apply(&ctx, Command::ChooseObject(Some(1)));
        picture(&mut harness, name);
        harness.get_by_label("Object 1");
    }
}

#[test]
fn counterfactuals_of_an_event_are_requested_shown_and_applied() {
    use crate::explain::events::counterfactual::{Counterfactual, Prevention};
    use crate::settings::Value;
    let (mut harness, scene) = tall();
    harness.get_by_label("merge 1 + 2, frame 51").click();
    harness.run_steps(4);
    let (_, merge) = timeline().events[3].clone();
    assert!(scene.asked.borrow().contains(&PlayerCall::Explain(Some(Box::new(merge.clone())))));
    let prevention = |setting, value, above| Prevention { setting, value, above };
    let preventions = vec![
        prevention("size_step", Value::Real(0.42), Some(true)),
        prevention("placing", Value::Choice("predicted"), None),
    ];
    let answer = |tried, done| {
        let (event, preventions) = (merge.clone(), preventions.clone());
        Some(Arc::new(Counterfactual { event, preventions, tried, happens: true, done, until: 143 }))
    };
    scene.state.borrow_mut().counterfactual = answer((12, 40), false);
    harness.run_steps(4);
    harness.get_by_label("Tested 12 of 40 values…");
    right_panel_looks_as_before(&mut harness, "prevented");
    scene.state.borrow_mut().counterfactual = answer((40, 40), true);
    harness.run_steps(4);
    harness.get_by_label("Apply placing = predicted");
    harness.get_by_label("Tested up to frame 143.");
    harness.get_by_label("Apply size_step ≥ 0.42").click();
    harness.run_steps(8);
    assert_eq!(given(&scene).unwrap().size_step, 0.42);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(8);
    assert_eq!(given(&scene), Some(Settings::default()));
}

#[test]
fn the_selected_event_stays_the_same_when_events_are_inserted_before_it() {
    let (mut harness, scene) = tall();
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::OpenEvent(Some(EventRef::InView(3))));
    settle(&mut harness);
    harness.get_by_label("Evidence for merge 1 + 2");
    let explained = |scene: &RecordingPlayer| {
        scene.asked.borrow().iter().filter(|asked| matches!(asked, PlayerCall::Explain(Some(_)))).count()
    };
    assert_eq!(explained(&scene), 1);
    // A late event with a known occluder.
    let mut later = timeline();
    later.events[3].1.front = Some(2);
    later.events.insert(2, event(EventKind::Appear, 20, &[3], (120.0, 38.0)));
    scene.state.borrow_mut().timeline = Arc::new(later.clone());
    settle(&mut harness);
    assert_eq!(harness.state().model.selection.event, Some(EventRef::InView(4)));
    harness.get_by_label("Evidence for merge 1 + 2");
    harness.get_by_label("Occluder: 2");
    assert_eq!(explained(&scene), 1, "the same event is requested once");
    // A counterfactual result is shown although the occluder was unknown when it was requested.
    let mut asked = timeline().events[3].1.clone();
    asked.front = None;
    scene.state.borrow_mut().counterfactual =
        Some(Arc::new(crate::explain::events::counterfactual::Counterfactual {
            event: asked,
            happens: true,
            preventions: Vec::new(),
            tried: (3, 3),
            done: true,
            until: 143,
        }));
    settle(&mut harness);
    harness.get_by_label("Settings that would prevent this event");
    later.events.remove(4);
    scene.state.borrow_mut().timeline = Arc::new(later);
    settle(&mut harness);
    assert_eq!(harness.state().model.selection.event, None, "the event was removed");
    harness.state_mut().apply(&ctx, Command::OpenEvent(Some(EventRef::InView(3))));
    settle(&mut harness);
    assert_eq!(explained(&scene), 2);
}

#[test]
fn the_chosen_object_is_matched_by_position_under_other_settings() {
    let (mut harness, scene) = tall();
    click(&mut harness, "Tracks and occlusions view", [50.5, 60.5]);
    assert_eq!(harness.state().model.selection.object, Some(1));
    let renamed = |names: [u32; 3], alpha: f32| {
        let shown = shown_at(30);
        let mut analysis = Analysis::clone(&shown.analysis);
        for track in Arc::make_mut(&mut analysis.tracks) {
            track.id = names[track.id as usize - 1];
        }
        let settings = Arc::new(Settings { alpha, ..Settings::default() });
        ShownFrame { analysis: Arc::new(analysis), settings, ..shown }
    };
    scene.state.borrow_mut().shown = Some(Arc::new(renamed([2, 7, 1], 0.01)));
    settle(&mut harness);
    assert_eq!(harness.state().model.selection.object, Some(2), "identity 1 is another object");
    let mut gone = renamed([2, 7, 1], 0.02);
    Arc::make_mut(&mut Arc::make_mut(&mut gone.analysis).tracks).retain(|track| track.id != 2);
    scene.state.borrow_mut().shown = Some(Arc::new(gone));
    settle(&mut harness);
    assert_eq!(harness.state().model.selection.object, None, "no object is at that position");
}
