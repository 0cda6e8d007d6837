//! The scatter plot of all three channels.

use super::*;

#[test]
fn a_cube_is_turned_by_dragging_by_keys_and_by_buttons() {
    let (mut harness, _) = tall(Some(shown(430)));
    open(&mut harness, "Scatter");
    open(&mut harness, "3-D");
    let turned = |harness: &Harness<'_>| {
        let name =
            harness.get_by_label_contains("Scatter plot of R, G and B").accesskit_node().label().unwrap();
        name.split_once("rotated by ").unwrap().1.to_owned()
    };
    assert_eq!(turned(&harness), "34°, elevation 24°");
    harness.get_by_label("Rotate right").click();
    harness.run();
    harness.get_by_label("Increase elevation").click();
    harness.run();
    assert_eq!(turned(&harness), "44°, elevation 34°");
    harness.get_by_label("Reset").click();
    harness.run();

    // Half the view's width is a quarter turn.
    let area = harness.get_by_label_contains("Scatter plot of R, G and B").rect();
    let (start, end) = (area.center(), area.center() + Vec2::new(area.width() / 4.0, 0.0));
    harness.hover_at(start);
    harness.drag_at(start);
    harness.step();
    harness.hover_at(end);
    harness.step();
    harness.drop_at(end);
    harness.run();
    assert_eq!(turned(&harness), "79°, elevation 24°");
    picture(&mut harness, "cube-turned");

    // The cube has the focus now.
    for key in [egui::Key::ArrowLeft, egui::Key::ArrowLeft, egui::Key::ArrowDown] {
        harness.key_press(key);
        harness.run();
    }
    assert_eq!(turned(&harness), "59°, elevation 14°");
    for _ in 0..30 {
        harness.key_press(egui::Key::ArrowUp);
        harness.run();
    }
    assert_eq!(turned(&harness), "59°, elevation 90°", "the elevation stops at the pole");
    for by in ["verdict", "time"] {
        open(&mut harness, by);
        picture(&mut harness, &format!("cube-{by}"));
    }
    harness.get_by_label("fit values").click();
    harness.get_by_label("Reset").click();
    harness.run();
    picture(&mut harness, "cube-whole");
}
