//! Maps of per-pixel quantities: their content, and when they are requested.

use super::*;
use crate::app::commands::action::Action;
use crate::app::model::camera::{Hover, ViewCamera};
use crate::app::views::pixel_value;

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    harness.run_steps(3);
    settle(harness);
}

fn maps_asked(scene: &RecordingPlayer) -> Vec<Option<Quantity>> {
    let asked = scene.asked.borrow();
    asked.iter().filter_map(|asked| if let PlayerCall::Map(of) = asked { Some(*of) } else { None }).collect()
}

#[test]
fn a_map_is_requested_only_while_it_is_visible() {
    let (mut harness, scene) = ready(58);
    assert!(maps_asked(&scene).is_empty(), "the map is behind another tab");
    act(&mut harness, Action::Map(Quantity::Used));
    assert_eq!(maps_asked(&scene), [Some(Quantity::Used)]);
    harness.get_by_label("Map view");
    harness.get_by_label("Map of Components in use");
    scene.show(59);
    settle(&mut harness);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::M);
    harness.run_steps(3);
    harness.key_press(Key::Num1);
    harness.run_steps(3);
    harness.key_press(Key::Num1);
    harness.run_steps(3);
    let b = Some(Quantity::BackgroundCount);
    assert_eq!(maps_asked(&scene), [Some(Quantity::Used), b, None, b]);
    // Showing a map ends the maximisation of another view.
    harness.key_press(Key::Num1);
    harness.run_steps(3);
    act(&mut harness, Action::NextMap);
    assert_eq!(harness.state().model.display.maximised, Some(View::Map));
    assert_eq!(harness.state().model.display.quantity, Quantity::BackgroundCount, "the quantity shown last");
    act(&mut harness, Action::NextMap);
    assert_eq!(harness.state().model.display.quantity, Quantity::Matched);
}

#[test]
fn each_value_has_its_colour_and_its_text() {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(58))), (1600.0, 1000.0), Theme::Dark);
    let view = "Map view";
    for quantity in Quantity::ALL {
        harness.state_mut().model.display.maximised = Some(View::Map);
        act(&mut harness, Action::Map(quantity));
        harness.state_mut().model.selection.hovered =
            Some(Hover { view: View::Map, pixel: (100, 60), scale: 5.0 });
        picture(&mut harness, &format!("map-{quantity:?}"));
        let rect = harness.get_by_label(view).rect();
        let canvas = crate::app::views::ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
        let picture = harness.render().unwrap();
        let colour = |at: (u32, u32)| {
            let middle = canvas.place_pixel(at).center();
            picture.get_pixel(middle.x as u32, middle.y as u32).0
        };
        let light = |[r, g, b, _]: [u8; 4]| 2 * u32::from(r) + 5 * u32::from(g) + u32::from(b);
        let row: Vec<_> = (0..8).map(|step| light(colour((step * 20 + 10, 60)))).collect();
        match quantity {
            Quantity::Sigma | Quantity::Weight => assert!(row.is_sorted() && row[7] > 2 * row[0], "{row:?}"),
            Quantity::SinceForeground => {
                assert!(row.is_sorted_by(|a, b| a > b), "{row:?}");
                assert!(light(colour((10, 5))) < row[7] && colour((10, 5)) == colour((150, 5)));
            }
            Quantity::Used | Quantity::BackgroundCount => {
                assert_eq!((row[0], row[2], row[4]), (row[1], row[3], row[5]));
                assert!(row[0] < row[2] && row[2] < row[4]);
            }
            Quantity::Matched => {
                assert_eq!(colour((10, 60)), [255; 4], "none");
                assert!(row[1] < row[2] && row[5] == row[7], "{row:?}");
            }
        }
    }
    let value = |window: &Window, pixel| {
        pixel_value(View::Map, &window.model, window.model.worker.shown().unwrap(), pixel)
    };
    assert_eq!(value(harness.state(), (10, 5)), "since=never");
    assert_eq!(value(harness.state(), (100, 60)), "since=500");
    act(&mut harness, Action::Map(Quantity::Sigma));
    assert_eq!(value(harness.state(), (10, 5)), "σ=6.50");
    harness.state_mut().model.display.camera = ViewCamera { magnification: 24.0, centre: [0.5, 0.5] };
    picture(&mut harness, "map-close-up");
}

#[test]
fn a_map_is_readable_in_small_windows_and_in_the_light_theme() {
    for (theme, name) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        for size in [(1024.0, 640.0), (1600.0, 1000.0)] {
            let (mut harness, _) = window(Some(state(Phase::Ready, Some(58))), size, theme);
            act(&mut harness, Action::Map(Quantity::SinceForeground));
            picture(&mut harness, &format!("map-{}-{name}", size.0));
            harness.get_by_label_contains("Map of").click();
            harness.run_steps(4);
            picture(&mut harness, &format!("map-menu-{}-{name}", size.0));
        }
    }
}

#[test]
fn a_model_without_a_mixture_shows_a_message() {
    let (mut harness, scene) = ready(58);
    harness.state_mut().model.display.maximised = Some(View::Map);
    settle(&mut harness);
    let settings =
        Settings { background_model: crate::settings::BackgroundModel::Knn, ..Settings::default() };
    let shown = ShownFrame { settings: Arc::new(settings), map: None, ..shown_at(58) };
    scene.state.borrow_mut().shown = Some(Arc::new(shown));
    settle(&mut harness);
    let empty = harness.render().unwrap();
    harness.state_mut().model.display.quantity = Quantity::SinceForeground;
    harness.step();
    scene.state.borrow_mut().shown.as_mut().map(|shown| Arc::make_mut(shown).map.take());
    settle(&mut harness);
    assert!(harness.render().unwrap() != empty, "the message covers only quantities of the mixture");
    picture(&mut harness, "map-no-mixture");
}

#[test]
fn the_background_of_another_frame_names_that_frame() {
    let state = state(Phase::Ready, Some(58));
    let mut shown = ShownFrame::clone(state.shown.as_ref().unwrap());
    shown.background = Arc::new(Frame::new(57, SIZE, shown.background.rgb.clone()));
    let other = State { shown: Some(Arc::new(shown.clone())), ..state.clone() };
    let [(own, place, value), (stored, ..)] = [state, other].map(|state| {
        let (mut harness, _) = window(Some(state), (1600.0, 1000.0), Theme::Dark);
        let place = harness.get_by_label("Background view").rect();
        let value = pixel_value(View::Background, &harness.state().model, &shown, (5, 5));
        picture(&mut harness, "background");
        (harness.render().unwrap(), place, value)
    });
    assert!(value.ends_with(", frame 57"), "{value}");
    assert!(different_pixels(&own, &stored, place) > 500, "the view has a note");
}
