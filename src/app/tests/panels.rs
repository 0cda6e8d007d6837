//! Pictures of the panels that other tests do not compare.

use eframe::egui::Rect;

use super::*;

/// Compares the part of the window that contains all controls with these labels.
fn part_looks_as_before(harness: &mut Harness<'_, Window>, labels: &[&str], name: &str) {
    picture(harness, name);
    harness.state_mut().toasts.hide();
    harness.step();
    let rects = labels.iter().map(|label| harness.get_by_label(label).rect());
    let part = rects.reduce(Rect::union).unwrap().expand(4.0).intersect(harness.ctx.content_rect());
    looks_as_before(&harness.render().unwrap(), Some(part), name);
}

#[test]
fn the_timeline_and_the_playback_controls_look_as_before() {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(58))), (1024.0, 640.0), Theme::Dark);
    part_looks_as_before(&mut harness, &["First frame", "Speed", "Timeline"], "timeline");
}

#[test]
fn the_settings_panel_looks_as_before() {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(58))), (1024.0, 640.0), Theme::Dark);
    picture(&mut harness, "settings-panel");
    harness.state_mut().toasts.hide();
    harness.step();
    let views = ["Input view", "Tracks and occlusions view"].map(|view| harness.get_by_label(view).rect());
    let panel = Rect::from_min_max(egui::pos2(0.0, views[0].top()), views[1].left_bottom());
    looks_as_before(&harness.render().unwrap(), Some(panel), "settings-panel");
}

#[test]
fn the_window_without_a_video_looks_as_before() {
    let (mut harness, _) = window(None, (800.0, 560.0), Theme::Light);
    picture(&mut harness, "welcome");
    looks_as_before(&harness.render().unwrap(), None, "welcome");
}
