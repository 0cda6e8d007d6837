//! The loupe beside the pointer.

use super::*;
use crate::app::views::{ViewCanvas, loupe_picture, loupe_place};

#[test]
fn the_loupe_magnifies_the_pixel_under_the_pointer_and_changes_nothing_else() {
    for (view, name) in [(View::Input, "input"), (View::Regions, "regions"), (View::Map, "map")] {
        for (theme, size) in [(Theme::Dark, (1600.0, 1000.0)), (Theme::Light, (1024.0, 640.0))] {
            let (mut harness, _) = window(Some(state(Phase::Ready, Some(58))), size, theme);
            if view == View::Map {
                let ctx = harness.ctx.clone();
                let action = crate::app::commands::action::Action::Map(Quantity::Matched);
                harness.state_mut().apply(&ctx, Command::Act(action));
                harness.run_steps(3);
                settle(&mut harness);
            }
            let rect = harness.get_by_label(&format!("{} view", view.title())).rect();
            let canvas = ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
            // Away from the edges of the map's steps: a small view blends adjacent colours.
            let pixel = if view == View::Map { (90, 60) } else { (80, 60) };
            let pointer = canvas.place_pixel(pixel).center();
            // The pointer is drawn, too.
            let before = harness.render().unwrap();
            harness.hover_at(pointer);
            harness.run_steps(3);
            let without = harness.render().unwrap();
            harness.key_press(Key::L);
            harness.run_steps(3);
            let with = harness.render().unwrap();
            picture(&mut harness, &format!("loupe-{name}-{}", size.0));

            let window = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(size.0, size.1));
            let place = loupe_place(pointer, window);
            let middle = loupe_picture(place).center();
            let at =
                |picture: &image::RgbaImage, at: egui::Pos2| picture.get_pixel(at.x as u32, at.y as u32).0;
            let (here, there) = (at(&before, pointer), at(&with, middle));
            let apart = here.iter().zip(there).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(apart < 12, "{name}: {here:?} became {there:?}");
            // The composition of the view does not change: the loupe has its own uniforms.
            let mut changed = 0;
            for y in (rect.top() as u32..rect.bottom() as u32).step_by(3) {
                for x in (rect.left() as u32..rect.right() as u32).step_by(3) {
                    let here = egui::pos2(x as f32, y as f32);
                    changed +=
                        u32::from(!place.expand(2.0).contains(here) && at(&with, here) != at(&without, here));
                }
            }
            assert_eq!(changed, 0, "{name}");
            harness.key_press(Key::L);
            harness.run_steps(3);
            assert!(harness.render().unwrap() == without);
        }
    }
}

#[test]
fn holding_alt_shows_the_loupe() {
    let (mut harness, _) = ready(58);
    let rect = harness.get_by_label("Tracks and occlusions view").rect();
    harness.hover_at(rect.center());
    harness.run_steps(3);
    let without = harness.render().unwrap();
    harness.event(egui::Event::ModifiersChanged(Modifiers::ALT));
    harness.run_steps(2);
    assert!(harness.render().unwrap() != without);
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(2);
    assert!(harness.render().unwrap() == without);
}
