//! Areas drawn over the views.

use eframe::egui::{PointerButton, Pos2};

use super::*;
use crate::app::model::areas::AreaEdit;
use crate::app::views::ViewCanvas;
use crate::regions::Roi;

fn canvas(harness: &Harness<'_, Window>) -> ViewCanvas {
    let rect = harness.get_by_label("Input view").rect();
    ViewCanvas::new(rect, SIZE, harness.state().model.display.camera)
}

fn button(harness: &mut Harness<'_, Window>, at: Pos2, pressed: bool) {
    let button = PointerButton::Primary;
    harness.event(egui::Event::PointerMoved(at));
    harness.step();
    harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
    harness.step();
}

fn click(harness: &mut Harness<'_, Window>, [x, y]: [f32; 2]) {
    let at = canvas(harness).screen([x, y]);
    button(harness, at, true);
    button(harness, at, false);
    // Two clicks at once would be a double click.
    harness.run_steps(40);
}

/// The region of interest last sent to the worker.
fn asked(scene: &RecordingPlayer) -> Option<Arc<Roi>> {
    let asked = scene.asked.borrow();
    let mut rois = asked.iter().rev();
    rois.find_map(|asked| if let PlayerCall::Roi(roi) = asked { Some(roi.clone()) } else { None })
        .expect("no region of interest was sent")
}

fn how_often(scene: &RecordingPlayer) -> usize {
    scene.asked.borrow().iter().filter(|asked| matches!(asked, PlayerCall::Roi(_))).count()
}

#[test]
fn an_ignored_polygon_removes_the_regions_inside_it() {
    let (mut harness, scene) = ready(10);
    assert_eq!(harness.state().model.worker.shown().unwrap().analysis.regions.len(), 3);
    harness.key_press(Key::I);
    harness.run_steps(3);
    for corner in [[5.0, 20.0], [60.0, 20.0], [60.0, 110.0], [5.0, 110.0]] {
        click(&mut harness, corner);
    }
    assert_eq!(how_often(&scene), 0, "an open draft ignores nothing");
    picture(&mut harness, "area-drawn");
    harness.key_press(Key::Enter);
    settle(&mut harness);
    let roi = asked(&scene).unwrap();
    assert!(!roi.contains(30, 60) && roi.contains(130, 60) && roi.contains(2, 2));
    let shown = harness.state().model.worker.shown().unwrap().clone();
    // The first person is at 30, 60.
    assert_eq!(shown.analysis.regions.iter().map(|region| region.label).collect::<Vec<_>>(), [2, 3]);
    assert!(!shown.analysis.mask.is_foreground(30, 60));
    assert_eq!(harness.state().model.selection.pixel, None, "a drawing click chooses no pixel");
    // Ignored pixels are darker in every view; analysed pixels are unchanged.
    let picture = harness.render().unwrap();
    let at = |pixel| {
        let place = canvas(&harness).place_pixel(pixel).center();
        picture.get_pixel(place.x as u32, place.y as u32).0
    };
    for pixel in [(20, 100), (40, 30), (50, 90)] {
        let before = shown.frame.pixel(pixel.0, pixel.1).unwrap();
        assert!(at(pixel)[0] < before[0] && at(pixel)[2] < before[2], "{pixel:?}");
    }
    assert_eq!(at((100, 100))[..3], shown.frame.pixel(100, 100).unwrap());
    super::picture(&mut harness, "area-ignored");
}

#[test]
fn dragging_draws_a_rectangle_and_pixels_outside_analysis_areas_are_ignored() {
    let (mut harness, scene) = ready(10);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::I);
    harness.run_steps(3);
    let camera = harness.state().model.display.camera;
    let canvas = canvas(&harness);
    button(&mut harness, canvas.screen([100.0, 10.0]), true);
    harness.event(egui::Event::PointerMoved(canvas.screen([130.0, 60.0])));
    harness.run_steps(2);
    button(&mut harness, canvas.screen([150.0, 110.0]), false);
    settle(&mut harness);
    let roi = asked(&scene).unwrap();
    assert!(roi.contains(125, 60) && roi.contains(101, 11) && !roi.contains(98, 60) && !roi.contains(30, 60));
    assert_eq!(harness.state().model.display.camera, camera, "a drawing drag does not pan");
    assert!(harness.state().model.edits.areas.draft.is_none());
    picture(&mut harness, "area-analysed");
}

#[test]
fn areas_are_cancelled_selected_deleted_and_cleared() {
    let (mut harness, scene) = ready(10);
    harness.key_press(Key::I);
    harness.run_steps(2);
    for corner in [[5.0, 5.0], [40.0, 5.0]] {
        click(&mut harness, corner);
    }
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(harness.state().model.edits.areas.draft.is_some(), "two corners do not make an area");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.state().model.edits.areas.draft.is_none() && how_often(&scene) == 0);

    let ctx = harness.ctx.clone();
    for (a, b) in [([5.0, 5.0], [40.0, 40.0]), ([60.0, 60.0], [90.0, 90.0])] {
        harness.state_mut().apply(
            &ctx,
            Command::Act(crate::app::commands::action::Action::DrawArea(
                crate::regions::roi::Purpose::Ignore,
            )),
        );
        harness.state_mut().apply(&ctx, Command::Area(AreaEdit::Rectangle(a, b)));
    }
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert_eq!(harness.state().model.edits.areas.chosen, None);
    click(&mut harness, [40.0, 20.0]);
    assert_eq!(
        (harness.state().model.edits.areas.chosen, harness.state().model.selection.pixel),
        (Some(0), None)
    );
    harness.key_press(Key::Delete);
    settle(&mut harness);
    let roi = asked(&scene).unwrap();
    assert!(roi.contains(20, 20) && !roi.contains(75, 75));
    // The button may be outside the visible part of the panel.
    harness.get_by_label("Clear all areas").click_accesskit();
    harness.run_steps(3);
    assert_eq!(asked(&scene), None);
    harness.get_by_label("The whole image is analysed.");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    assert_eq!(asked(&scene), Some(roi));
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(asked(&scene), None);
}

#[test]
fn a_mask_of_another_size_is_rejected_and_one_of_equal_size_is_loaded() {
    let (mut harness, scene) = ready(10);
    let mask = |width, height| {
        let size = Size::new(width, height);
        let data = (0..size.pixels()).map(|at| if at as u32 % width < width / 2 { 255 } else { 0 }).collect();
        Arc::new(Roi::new(Mask { size, data }).unwrap())
    };
    let ctx = harness.ctx.clone();
    harness.state_mut().handle_result(&ctx, DialogResult::Mask(Ok(mask(20, 10))));
    harness.run_steps(3);
    assert_eq!(how_often(&scene), 0);
    harness.state_mut().handle_result(&ctx, DialogResult::Mask(Ok(mask(160, 120))));
    settle(&mut harness);
    assert_eq!(asked(&scene), Some(mask(160, 120)));
    picture(&mut harness, "area-mask");
    // Another video has no areas.
    harness.state_mut().apply(&ctx, Command::Open("/videos/other.mp4".into(), Start::First));
    assert!(harness.state().model.edits.areas.is_empty());
}

#[test]
fn escape_is_free_for_menus_while_no_area_is_drawn() {
    let (mut harness, _) = ready(10);
    harness.get_by_label("View").click();
    harness.run_steps(4);
    harness.get_by_label("Fit image");
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert!(harness.query_by_label("Fit image").is_none());
}

#[test]
fn escape_closes_an_open_menu_before_it_deselects_an_area() {
    let (mut harness, _) = ready(10);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(
        &ctx,
        Command::Act(crate::app::commands::action::Action::DrawArea(crate::regions::roi::Purpose::Ignore)),
    );
    harness.state_mut().apply(&ctx, Command::Area(AreaEdit::Rectangle([5.0, 5.0], [40.0, 40.0])));
    harness.run_steps(3);
    assert_eq!(harness.state().model.edits.areas.chosen, Some(0));
    harness.get_by_label("View").click();
    harness.run_steps(4);
    harness.get_by_label("Fit image");
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert!(harness.query_by_label("Fit image").is_none());
    assert_eq!(harness.state().model.edits.areas.chosen, Some(0));
    harness.key_press(Key::Escape);
    harness.run_steps(4);
    assert_eq!(harness.state().model.edits.areas.chosen, None);
}
