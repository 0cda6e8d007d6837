//! The window at every size, scale and theme: nothing is cut off and nothing overlaps.

use super::inspector::inspected_state;
use super::*;

/// Sizes in points with the pixels per point: small, usual, large, and 3840×2160 pixels at a scale of two.
const SCREENS: [((f32, f32), f32); 7] = [
    ((1024.0, 640.0), 1.0),
    ((1024.0, 640.0), 1.5),
    ((1024.0, 640.0), 2.0),
    ((1600.0, 1000.0), 1.0),
    ((1600.0, 1000.0), 1.5),
    ((1920.0, 1080.0), 2.0),
    ((3840.0, 2160.0), 1.0),
];

/// The states of the window, by name.
fn states() -> [(&'static str, Option<State>); 4] {
    let mut opening = state(Phase::Opening, None);
    opening.busy = Some(WorkProgress { what: "reading".into(), done: 3, total: Some(40) });
    let mut working = inspected_state(58);
    working.busy = Some(WorkProgress { what: "analysing".into(), done: 58, total: Some(120) });
    working.analysis_fps = 84.0;
    working.warnings = Arc::new(vec!["in000007.jpg cannot be read and was skipped".into()]);
    let failed = Phase::Failed("clip.mp4 does not exist; check the path".into());
    [
        ("empty", None),
        ("opening", Some(opening)),
        ("failed", Some(state(failed, None))),
        ("ready", Some(working)),
    ]
}

/// The controls that must be entirely visible without scrolling, by state.
fn fixed(name: &str) -> &'static [&'static str] {
    match name {
        "empty" => &["Open video…", "Open folder of images…", "Open sample", "Settings"],
        "opening" => &["Cancel", "Opening walk.mp4"],
        "failed" => &["clip.mp4 does not exist; check the path", "Open video…", "Open sample"],
        _ => &[
            "First frame",
            "Play",
            "Last frame",
            "Timeline",
            "Speed",
            "Warnings",
            "Pause analysis",
            "Input view",
            "Background view",
            "Foreground view",
            "Regions view",
            "Tracks and occlusions view",
            "Show alone: Input",
            "Track overlays",
            "Scatter",
            "History",
            "Tuning",
            "Statistics",
            "Events",
            "Show merge events",
            "Redo",
        ],
    }
}

#[test]
fn every_state_fits_every_size_and_scale_in_both_themes() {
    for (theme, theme_name) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        for ((width, height), scale) in SCREENS {
            // Rendering the largest size takes as long as all others together.
            if width > 2000.0 && theme == Theme::Light {
                continue;
            }
            for (name, state) in states() {
                let (mut harness, _) = window_at(state, (width, height), scale, theme);
                harness.run_steps(4);
                let whole = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(width, height));
                let mut seen: Vec<(&str, egui::Rect)> = Vec::new();
                for &label in fixed(name) {
                    let rect = harness.get_all_by_label(label).next().unwrap().rect();
                    let at = format!("{label} at {width}×{height}, {name}");
                    assert!(whole.contains_rect(rect) && rect.is_positive(), "{at}: {rect}");
                    for (other, taken) in &seen {
                        let common = taken.intersect(rect.shrink(0.5));
                        assert!(!common.is_positive(), "{at} overlaps {other}: {rect}, {taken}");
                    }
                    seen.push((label, rect));
                }
                picture(&mut harness, &format!("{name}-{width}-{scale}-{theme_name}"));
            }
        }
    }
}

#[test]
fn every_state_is_drawn_in_a_window_without_room() {
    // Some window managers allow any size. egui refuses negative sizes.
    for (width, height) in [(40.0, 30.0), (40.0, 640.0), (300.0, 200.0), (1024.0, 30.0)] {
        for (_, state) in states() {
            let (mut harness, _) = window(state, (1024.0, 640.0), Theme::Dark);
            harness.set_size(vec2(width, height));
            harness.run_steps(4);
            harness.key_press(egui::Key::F1);
            harness.run_steps(4);
        }
    }
}

#[test]
fn shrinking_the_window_shrinks_every_panel() {
    let (mut harness, _) = window(Some(inspected_state(58)), (1600.0, 1400.0), Theme::Dark);
    harness.run_steps(4);
    let large = harness.get_by_label("Events").rect();
    harness.set_size(vec2(1024.0, 640.0));
    harness.run_steps(4);
    let small = harness.get_by_label("Events").rect();
    // Between tabs and events there is space for a readable plot, and several events remain visible.
    let space = small.top() - harness.get_by_label("History").rect().bottom();
    assert!(space > 120.0, "{space} points are left to the inspector's tab");
    assert!(harness.get_by_label("Timeline").rect().top() - small.top() > 100.0, "{small} leaves no list");
    assert!(small.left() > 1024.0 * 0.6, "{small} leaves no space for the views");
    assert!(large.top() > 0.38 * 1400.0, "{large}");
    picture(&mut harness, "made-smaller");
    harness.set_size(vec2(3840.0, 2160.0));
    harness.run_steps(4);
    let events = harness.get_by_label("Events").rect();
    assert!(events.left() < 3840.0 * 0.9 && events.top() < 2160.0 * 0.9, "{events}");
}

#[test]
fn in_the_smallest_window_no_view_overlaps_a_panel() {
    let (mut harness, _) = window(Some(inspected_state(58)), (1600.0, 1000.0), Theme::Dark);
    harness.run_steps(4);
    harness.set_size(vec2(800.0, 560.0));
    harness.run_steps(6);
    let panel = harness.get_by_label("Events").rect().left();
    for view in ["Regions", "Background", "Tracks and occlusions"] {
        let button = harness.get_by_label(&format!("Show alone: {view}")).rect();
        assert!(button.right() <= panel, "{view}: {button} overlaps the panel at {panel}");
    }
    picture(&mut harness, "smallest");
}

#[test]
fn in_the_smallest_window_the_views_do_not_cover_the_panel_on_the_right() {
    // Without a chosen pixel the panel has an explanation, which must not be wider than the panel.
    for (name, state) in [("no-pixel", state(Phase::Ready, Some(58))), ("pixel", inspected_state(58))] {
        let (mut harness, _) = window(Some(state), (1600.0, 1000.0), Theme::Dark);
        harness.run_steps(4);
        harness.set_size(vec2(800.0, 560.0));
        harness.run_steps(6);
        let views = views(&harness).right();
        let window = harness.ctx.content_rect();
        for label in ["Events", "Show exit events", "Show merge events"] {
            let rect = harness.get_by_label(label).rect();
            assert!(views <= rect.left(), "the views end at {views} and cover {label} at {rect}");
        }
        if let Some(text) = harness.query_by_label_contains("Click a pixel in any view to inspect its") {
            let rect = text.rect();
            assert!(views <= rect.left() && rect.right() <= window.right(), "{rect} beside {views}");
        }
        picture(&mut harness, &format!("smallest-right-panel-{name}"));
    }
}

#[test]
fn text_and_controls_can_be_made_larger_and_smaller() {
    let (mut harness, _) = ready(58);
    for (key, factor) in
        [(Key::Plus, 1.1), (Key::Plus, 1.2), (Key::Minus, 1.1), (Key::Num0, 1.0), (Key::Minus, 0.9)]
    {
        harness.key_press_modifiers(Modifiers::COMMAND, key);
        harness.run_steps(3);
        assert!((harness.ctx.zoom_factor() - factor).abs() < 0.01, "{key:?}: {}", harness.ctx.zoom_factor());
    }
    for _ in 0..40 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Minus);
        harness.step();
    }
    assert!(harness.ctx.zoom_factor() > 0.4, "the text remains readable");
}

#[test]
fn a_window_smaller_than_it_should_be_is_drawn() {
    let (mut harness, _) = ready(58);
    for width in [1.0, 40.0, 120.0, 254.0, 270.0, 300.0, 500.0] {
        for height in [1.0, 40.0, 150.0, 400.0] {
            harness.set_size(vec2(width, height));
            harness.run_steps(2);
        }
    }
    harness.set_size(vec2(1600.0, 1000.0));
    harness.run_steps(2);
    harness.get_by_label("Timeline");
}
