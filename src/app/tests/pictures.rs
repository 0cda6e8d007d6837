//! The content of the views, pixel by pixel, and when it changes.

use eframe::egui::{Pos2, pos2};
use image::{Rgba, RgbaImage};

use super::*;
use crate::app::commands::action::Action;
use crate::app::model::camera::ViewCamera;
use crate::app::model::view::BackgroundDisplay;
use crate::app::views::ViewCanvas;
use crate::palette::identity_colour;

/// One maximised view, with an integer number of screen pixels per image pixel.
fn alone(view: View, position: u32) -> (Harness<'static, Window>, RecordingPlayer, ViewCanvas) {
    let (mut harness, scene) =
        window(Some(state(Phase::Ready, Some(position))), (1600.0, 1000.0), Theme::Dark);
    harness.state_mut().model.display.maximised = Some(view);
    settle(&mut harness);
    let canvas = whole_scale(&mut harness, view);
    (harness, scene, canvas)
}

fn whole_scale(harness: &mut Harness<'_, Window>, view: View) -> ViewCanvas {
    let fitted = canvas(harness, view);
    let magnification = fitted.scale.floor() / fitted.scale;
    harness.state_mut().model.display.camera = ViewCamera { magnification, centre: [0.5, 0.5] };
    settle(harness);
    canvas(harness, view)
}

fn canvas(harness: &Harness<'_, Window>, view: View) -> ViewCanvas {
    let rect = harness.get_by_label(&format!("{} view", view.title())).rect();
    let model = &harness.state().model;
    ViewCanvas::new(rect, model.worker.shown().unwrap().frame.size, model.display.camera)
}

fn at(picture: &RgbaImage, at: Pos2) -> [u8; 3] {
    let Rgba([r, g, b, _]) = *picture.get_pixel(at.x as u32, at.y as u32);
    [r, g, b]
}

/// The expected colour of a pixel of a frame in a view.
type Expected = fn(&ShownFrame, (u32, u32)) -> [u8; 3];

/// Checks that pixels all over the image have the colour of `expected`, within two levels.
fn compare(
    harness: &mut Harness<'_, Window>,
    canvas: &ViewCanvas,
    expected: impl Fn(&ShownFrame, (u32, u32)) -> [u8; 3],
) {
    settle(harness);
    let picture = harness.render().unwrap();
    let shown = harness.state().model.worker.shown().unwrap().clone();
    let mut seen = 0;
    for y in (1..SIZE.height).step_by(3) {
        for x in (1..SIZE.width).step_by(3) {
            let middle = canvas.place_pixel((x, y)).center();
            let (there, wanted) = (at(&picture, middle), expected(&shown, (x, y)));
            let apart = there.iter().zip(wanted).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            if apart > 2 {
                // Boxes, tags, trails and hatching cover part of the image.
                continue;
            }
            seen += 1;
        }
    }
    let all = SIZE.pixels() / 9;
    assert!(seen * 100 > all * 90, "{seen} of {all} pixels have their colour");
}

#[test]
fn each_view_shows_its_layer() {
    let pixel = |frame: &Frame, (x, y)| frame.pixel(x, y).unwrap();
    let views: [(View, Expected); 5] = [
        (View::Input, |shown, (x, y)| shown.frame.pixel(x, y).unwrap()),
        (View::Background, |shown, (x, y)| shown.background.pixel(x, y).unwrap()),
        (
            View::Foreground,
            |shown, (x, y)| if shown.analysis.mask.is_foreground(x, y) { [255; 3] } else { [0; 3] },
        ),
        (View::Regions, |shown, (x, y)| {
            let gray = crate::mixture::pixel::luma(shown.frame.pixel(x, y).unwrap());
            match shown.analysis.labels.at(x, y).unwrap() {
                0 => [gray / 4; 3],
                label => identity_colour(label)
                    .map(|channel| (f32::from(channel) * (0.55 + 0.45 * f32::from(gray) / 255.0)) as u8),
            }
        }),
        (View::Difference, |shown, (x, y)| {
            let (a, b) = (shown.frame.pixel(x, y).unwrap(), shown.background.pixel(x, y).unwrap());
            [a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap().saturating_mul(2); 3]
        }),
    ];
    for (view, expected) in views {
        let (mut harness, _, canvas) = alone(view, 10);
        compare(&mut harness, &canvas, expected);
    }
    let (mut harness, _, canvas) = alone(View::Tracks, 10);
    compare(&mut harness, &canvas, |shown, at| {
        pixel(&shown.frame, at).map(|channel| (f32::from(channel) * 205.0 / 255.0).round() as u8)
    });
}

#[test]
fn pixels_that_are_not_square_are_drawn_in_their_shape() {
    let mut state = state(Phase::Ready, Some(10));
    let info = SourceInfo { pixel_aspect: Some((3, 2)), ..SourceInfo::clone(state.info.as_ref().unwrap()) };
    state.info = Some(Arc::new(info));
    let (mut harness, _) = window(Some(state), (1600.0, 1000.0), Theme::Dark);
    harness.state_mut().model.display.maximised = Some(View::Input);
    settle(&mut harness);
    let rect = harness.get_by_label("Input view").rect();
    let canvas = ViewCanvas::of_aspect(rect, SIZE, 1.5, harness.state().model.display.camera);
    compare(&mut harness, &canvas, |shown, (x, y)| shown.frame.pixel(x, y).unwrap());
}

#[test]
fn the_background_view_shows_the_kind_that_is_chosen() {
    let (mut harness, scene, canvas) = alone(View::Background, 10);
    let modes = Arc::new(Frame::new(11, SIZE, [40, 90, 200].repeat(SIZE.pixels())));
    let shown = ShownFrame { multi_mode: Some(modes), ..shown_at(10) };
    scene.state.borrow_mut().shown = Some(Arc::new(shown));
    harness.state_mut().model.display.background = BackgroundDisplay::MultiMode;
    compare(&mut harness, &canvas, |_, _| [40, 90, 200]);
    let shown = ShownFrame { multi_mode: None, ..shown_at(10) };
    scene.state.borrow_mut().shown = Some(Arc::new(shown));
    settle(&mut harness);
    picture(&mut harness, "no-mixture");
}

#[test]
fn the_mask_overlay_has_the_requested_opacity() {
    let (mut harness, _, canvas) = alone(View::Input, 10);
    harness.key_press(Key::O);
    harness.run_steps(2);
    let over = |opacity: f32| {
        move |shown: &ShownFrame, (x, y): (u32, u32)| {
            let under = shown.frame.pixel(x, y).unwrap();
            if !shown.analysis.mask.is_foreground(x, y) {
                return under;
            }
            let mix = |under: u8, over: u8| f32::from(under) * (1.0 - opacity) + f32::from(over) * opacity;
            [mix(under[0], 255).round(), mix(under[1], 45).round(), mix(under[2], 149).round()]
                .map(|c| c as u8)
        }
    };
    compare(&mut harness, &canvas, over(0.5));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::O);
    harness.run_steps(2);
    compare(&mut harness, &canvas, over(0.75));
    picture(&mut harness, "mask-over-input");
    harness.get_by_label("Mask overlay").click();
    harness.run_steps(2);
    assert!(!harness.state().model.display.overlay.on);
    compare(&mut harness, &canvas, over(0.0));
}

#[test]
fn zooming_panning_and_the_mask_overlay_upload_nothing() {
    let (mut harness, _) = ready(58);
    let set = |harness: &Harness<'_, Window>| Arc::clone(harness.state().pictures.in_view().unwrap());
    let before = set(&harness);
    assert!(before.bytes() > 0);
    let model = |harness: &mut Harness<'_, Window>, change: fn(&mut crate::app::model::Model)| {
        change(&mut harness.state_mut().model);
        settle(harness);
    };
    model(&mut harness, |model| model.display.camera = ViewCamera { magnification: 7.0, centre: [0.3, 0.4] });
    model(&mut harness, |model| model.display.overlay.on = true);
    model(&mut harness, |model| model.display.overlay.opacity = 80);
    model(&mut harness, |model| model.display.maximised = Some(View::Regions));
    model(&mut harness, |model| model.display.maximised = Some(View::Difference));
    model(&mut harness, |model| model.display.maximised = None);
    assert!(Arc::ptr_eq(&before, &set(&harness)));
}

#[test]
fn only_changed_layers_of_visible_views_are_uploaded() {
    let (mut harness, scene) = ready(10);
    let bytes = |harness: &mut Harness<'_, Window>| {
        settle(harness);
        harness.state().pictures.in_view().unwrap().bytes()
    };
    // Rows are padded to multiples of 256 bytes.
    let (colour, mask, labels) = (768 * 120, 256 * 120, 512 * 120);
    let palette = 1024 * 3;
    scene.show(11);
    assert_eq!(bytes(&mut harness), 2 * colour + mask + labels + palette);
    // The same frame with another pixel history.
    let same = ShownFrame::clone(scene.state.borrow().shown.as_ref().unwrap());
    scene.state.borrow_mut().shown = Some(Arc::new(same.clone()));
    assert_eq!(bytes(&mut harness), 0);
    // Under other settings the input is unchanged.
    scene.state.borrow_mut().shown = Some(Arc::new(ShownFrame { frame: same.frame, ..shown_at(11) }));
    assert_eq!(bytes(&mut harness), colour + mask + labels + palette);
    harness.state_mut().model.display.maximised = Some(View::Foreground);
    settle(&mut harness);
    scene.show(12);
    assert_eq!(bytes(&mut harness), mask);
    harness.state_mut().model.display.maximised = Some(View::Tracks);
    assert_eq!(bytes(&mut harness), colour, "a layer is uploaded when its view becomes visible");
}

/// The first column of a row whose colour `is` accepts.
fn columns(picture: &RgbaImage, canvas: &ViewCanvas, y: u32, is: impl Fn([u8; 3]) -> bool) -> Option<u32> {
    (0..SIZE.width).find(|&x| is(at(picture, canvas.place_pixel((x, y)).center())))
}

#[test]
fn all_views_change_frame_at_the_same_time() {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(0))), (1600.0, 1000.0), Theme::Dark);
    harness.state_mut().model.playback.speed = 7;
    harness.key_press(Key::Space);
    let mut positions = Vec::new();
    for _ in 0..60 {
        harness.step();
        let picture = harness.render().unwrap();
        let shown = harness.state().model.worker.shown().unwrap();
        let (input, foreground) = (canvas(&harness, View::Input), canvas(&harness, View::Foreground));
        // The first person, in red, is at 20 + t, 9 pixels wide to either side.
        let wanted = Some(20 + shown.position - 9);
        let y = 60;
        assert_eq!(columns(&picture, &input, y, |[r, g, b]| r > 150 && g < 110 && b < 100), wanted);
        assert_eq!(columns(&picture, &foreground, y, |colour| colour[1] > 128), wanted);
        assert_eq!(harness.state().pictures.in_view().unwrap().frame().shown.position, shown.position);
        positions.push(shown.position);
    }
    assert!(positions.is_sorted(), "{positions:?}");
    positions.dedup();
    assert!(positions.len() > 5, "{positions:?}");
}

#[test]
fn a_frame_of_the_previous_video_is_never_shown() {
    let (mut harness, scene) = ready(10);
    scene.show(30);
    harness.step();
    scene.state.borrow_mut().shown = None;
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Open("/videos/other.mp4".into(), Start::First));
    for _ in 0..10 {
        std::thread::sleep(Duration::from_millis(5));
        harness.step();
        assert!(harness.state().model.worker.shown().is_none());
    }
    scene.show(3);
    settle(&mut harness);
    assert_eq!(harness.state().model.worker.shown().unwrap().position, 3);
}

#[test]
fn trails_belong_to_their_frame_and_restart_under_other_settings() {
    let (mut harness, scene) = ready(10);
    for position in [11, 12, 13] {
        scene.show(position);
        harness.step();
    }
    settle(&mut harness);
    let trails = |harness: &Harness<'_, Window>| {
        let moment = harness.state().model.worker.in_view.clone().unwrap();
        moment.trails.keys().copied().collect::<Vec<_>>()
    };
    assert_eq!(trails(&harness), [10, 11, 12, 13]);
    let settings = Arc::new(Settings { t: 0.9, ..Settings::default() });
    scene.state.borrow_mut().shown = Some(Arc::new(ShownFrame { settings, ..shown_at(13) }));
    settle(&mut harness);
    assert_eq!(trails(&harness), [13]);
}

/// A frame of another size with foreground where `is` holds.
fn shown_with_mask(size: Size, is: impl Fn(u32, u32) -> bool) -> ShownFrame {
    let shown = shown_at(0);
    let pixels = || (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let data = pixels().map(|(x, y)| if is(x, y) { Mask::FOREGROUND } else { Mask::BACKGROUND }).collect();
    let frame = Arc::new(Frame::new(1, size, vec![90; size.pixels() * 3]));
    let analysis = Analysis {
        mask: Arc::new(Mask { size, data }),
        labels: Arc::new(Labels::none(size)),
        ..Analysis::clone(&shown.analysis)
    };
    ShownFrame { frame: frame.clone(), background: frame, analysis: Arc::new(analysis), ..shown }
}

/// The total brightness of a row of the foreground view, in image pixels.
fn brightness(harness: &mut Harness<'_, Window>) -> f32 {
    let canvas = canvas(harness, View::Foreground);
    let picture = harness.render().unwrap();
    let y = canvas.rect.center().y;
    let row = canvas.whole().intersect(canvas.rect);
    let columns = row.left().ceil() as u32..row.right().floor() as u32;
    let sum: u32 = columns.map(|x| u32::from(at(&picture, pos2(x as f32, y))[1])).sum();
    sum as f32 / 255.0 / canvas.scale
}

#[test]
fn a_line_one_pixel_wide_neither_vanishes_nor_flickers_in_a_small_view() {
    for size in [Size::new(1900, 1200), Size::new(4000, 3000)] {
        let mut first = state(Phase::Ready, Some(0));
        first.shown = Some(Arc::new(shown_with_mask(size, |x, _| x % 400 == 200)));
        let (mut harness, _) = window(Some(first), (1024.0, 640.0), Theme::Dark);
        let lines = (size.width as f32 / 400.0).round();
        for step in 0..8 {
            let across = 0.5 + step as f32 * 0.13 / size.width as f32;
            harness.state_mut().model.display.camera =
                ViewCamera { magnification: 1.0, centre: [across, 0.5] };
            settle(&mut harness);
            let seen = brightness(&mut harness);
            assert!((seen - lines).abs() < 0.1 * lines, "{seen} of {lines} lines in step {step}");
        }
    }
}

#[test]
fn an_image_larger_than_the_texture_limit_is_shown() {
    let size = Size::new(20_000, 40);
    let mut first = state(Phase::Ready, Some(0));
    first.shown = Some(Arc::new(shown_with_mask(size, |x, _| x >= 10_000)));
    let (mut harness, _) = window(Some(first), (1024.0, 640.0), Theme::Dark);
    harness.state_mut().model.display.maximised = Some(View::Foreground);
    harness.state_mut().model.display.camera = ViewCamera { magnification: 20.0, centre: [0.5, 0.5] };
    settle(&mut harness);
    let canvas = canvas(&harness, View::Foreground);
    let picture = harness.render().unwrap();
    for (x, colour) in [(9_900, [0; 3]), (9_990, [0; 3]), (10_010, [255; 3]), (10_100, [255; 3])] {
        assert_eq!(at(&picture, canvas.place_pixel((x, 20)).center()), colour, "{x}");
    }
}

#[test]
fn the_last_opacity_is_followed_by_the_first() {
    let (mut harness, _) = ready(10);
    let ctx = harness.ctx.clone();
    let mut opacities = Vec::new();
    for _ in 0..4 {
        harness.state_mut().apply(&ctx, Command::Act(Action::OverlayOpacity));
        assert!(harness.state().model.display.overlay.on);
        opacities.push(harness.state().model.display.overlay.opacity);
    }
    assert_eq!(opacities, [75, 100, 25, 50]);
}
