//! The dialog of the source's options, and frames that are not the source's images.

use std::num::NonZeroU32;

use egui_kittest::kittest::NodeT as _;

use super::*;
use crate::app::commands::action::Action;
use crate::placement::{Crop, Placement};
use crate::source::{Options, Reduction};
use crate::truth::boxes::Bounds;

const VIDEO: &str = "/videos/walk.mp4";
/// The frames are the left upper part of these images at half the size.
const SOURCE: Size = Size::new(400, 300);
const OPTIONS: Options = Options {
    scale: Some(0.5),
    every: NonZeroU32::new(5),
    crop: Some(Crop { x: 10, y: 20, width: 320, height: 240 }),
    ..Options::AS_IS
};

/// A window on a scene that was read with [`OPTIONS`].
fn reduced() -> (Harness<'static, Window>, RecordingPlayer) {
    let mut state = state(Phase::Ready, Some(58));
    let placement = Placement::new(SOURCE, OPTIONS.crop, OPTIONS.scale).unwrap();
    assert_eq!(placement.size(), SIZE);
    let reduction = Some(Reduction { placement, every: 5, fps: 125.0 });
    state.info = Some(Arc::new(SourceInfo { reduction, ..SourceInfo::clone(state.info.as_ref().unwrap()) }));
    let (mut harness, scene) = window(None, (1280.0, 800.0), Theme::Dark);
    *scene.state.borrow_mut() = state;
    let ctx = harness.ctx.clone();
    harness.state_mut().model.videos.set_options(VIDEO, OPTIONS);
    harness.state_mut().apply(&ctx, Command::Open(VIDEO.into(), Start::First));
    settle(&mut harness);
    settle(&mut harness);
    (harness, scene)
}

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    harness.run_steps(4);
}

fn type_into(harness: &mut Harness<'_, Window>, label: &str, text: &str) {
    let field = (egui::Role::SpinButton, label);
    harness.get_by_role_and_label(field.0, field.1).focus();
    harness.run_steps(2);
    harness.get_by_role_and_label(field.0, field.1).type_text(text);
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}

#[test]
fn the_dialog_looks_as_before() {
    let (mut harness, _) = reduced();
    act(&mut harness, Action::SourceOptions);
    panels::dialog_looks_as_before(&mut harness, "source options", "source-options");
}

#[test]
fn applied_options_read_the_video_again() {
    let (mut harness, scene) = reduced();
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Choose(Some((30, 60))));
    act(&mut harness, Action::SourceOptions);
    assert!(harness.get_by_label("Apply").accesskit_node().is_disabled(), "nothing was changed");
    type_into(&mut harness, "Every N-th frame", "2");
    harness.get_by_label("Apply").click();
    harness.run_steps(3);
    let two = Options { every: NonZeroU32::new(2), ..OPTIONS };
    assert_eq!(harness.state().model.videos.options_of(VIDEO), two);
    assert!(!harness.state().source_options.is_open());
    assert_eq!(harness.state().model.selection.pixel, Some((30, 60)));

    // The same pixel of the source is elsewhere in whole images.
    act(&mut harness, Action::SourceOptions);
    harness.get_by_label("Reset").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.videos.options_of(VIDEO), two, "not applied yet");
    let asked = scene.asked.borrow().len();
    harness.get_by_label("Apply").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.videos.options_of(VIDEO), Options::default());
    let at = PlayerCall::Inspect(Some((10 + 61, 20 + 121)));
    assert!(scene.asked.borrow()[asked..].contains(&at), "{:?}", &scene.asked.borrow()[asked..]);
}

#[test]
fn a_part_beyond_the_images_cannot_be_applied() {
    let (mut harness, _) = reduced();
    act(&mut harness, Action::SourceOptions);
    let crop = Some(Crop { x: 200, y: 0, width: 320, height: 240 });
    harness.state_mut().source_options.open(VIDEO, Options { crop, ..OPTIONS });
    harness.run_steps(3);
    assert!(
        harness.query_by_label_contains("The part reaches beyond the images, which are 400×300").is_some()
    );
    assert!(harness.get_by_label("Apply").accesskit_node().is_disabled());
    harness.get_by_label("Cancel").click();
    harness.run_steps(3);
    assert!(!harness.state().source_options.is_open());
    assert_eq!(harness.state().model.videos.options_of(VIDEO), OPTIONS);
}

#[test]
fn the_user_sees_the_pixels_of_the_source() {
    let (mut harness, _) = reduced();
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Choose(Some((30, 60))));
    harness.run_steps(3);
    let place = harness.state().model.frame_description().unwrap();
    assert!(place.contains("pixel 71,141"), "{place}");
    assert!(harness.query_by_label_contains("160×120 of 400×300").is_some());
    assert!(harness.query_by_label_contains("125 fps").is_some(), "the rate of the source");
    assert!(harness.query_by_label_contains("1 of 5").is_some());
    assert!(harness.query_by_label_contains("Pixel 71, 141").is_some());
}

#[test]
fn true_boxes_of_the_source_are_drawn_where_the_objects_are() {
    let (mut harness, _) = reduced();
    let of_source = Bounds([50.0, 60.0, 240.0, 160.0]);
    let boxes = BTreeMap::from([(59, BTreeMap::from([(1, of_source)]))]);
    let placement = harness.state().model.worker.placement().unwrap();
    let truth = Truth { boxes: Some(boxes), masks: None, ..Truth::default() };
    let in_frames = truth.in_frames(&placement).boxes.unwrap();
    assert_eq!(in_frames[&59][&1], Bounds([20.0, 20.0, 120.0, 80.0]));
    let ctx = harness.ctx.clone();
    harness.state_mut().handle_result(&ctx, DialogResult::Truth(Ok(Arc::new(truth))));
    harness.state_mut().model.display.maximised = Some(View::Tracks);
    settle(&mut harness);
    let picture = harness.render().unwrap();
    // The upper edge has white dashes from column 20 to 140, in row 20.
    let rect = harness.get_by_label(&format!("{} view", View::Tracks.title())).rect();
    let canvas = crate::app::views::ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    let (from, to) = (canvas.screen([22.0, 20.0]), canvas.screen([138.0, 20.0]));
    let is_white = |x: u32, y: u32| picture.get_pixel(x, y).0[..3].iter().all(|&level| level > 200);
    let row = |y: u32| (from.x as u32..to.x as u32).filter(|&x| is_white(x, y)).count();
    let y = from.y as u32;
    let white = (y - 1..=y + 1).map(row).max().unwrap();
    assert!(white as f32 > 0.2 * (to.x - from.x), "{white} of {}", to.x - from.x);
}
