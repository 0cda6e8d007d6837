//! Accessibility: every control has a name and is reached by keys.

use std::collections::{BTreeMap, BTreeSet};

use egui_kittest::kittest::{AccessKitNode, NodeT as _};

use super::inspector::inspected_state;
use super::*;
use crate::app::commands::action::Action;
use crate::app::commands::actions::ACTIONS;
use crate::app::commands::entry::Menu;

type Nodes<'a> = Box<dyn Iterator<Item = AccessKitNode<'a>> + 'a>;

fn nodes<'a>(harness: &'a Harness<'_, Window>) -> Nodes<'a> {
    Box::new(harness.root().children_recursive().map(|node| node.accesskit_node()))
}

fn is_icon(letter: char) -> bool {
    matches!(letter, '\u{e000}'..='\u{f8ff}' | '\u{f0000}'..)
}

/// The text that a screen reader reads for a node. Icon glyphs do not count.
fn said(node: &AccessKitNode<'_>) -> Option<String> {
    let text = [node.label(), node.value(), node.data().placeholder().map(str::to_owned)];
    text.into_iter()
        .flatten()
        .find(|text| text.chars().any(|letter| !letter.is_whitespace() && !is_icon(letter)))
}

/// Whether a node is a control that supports an action. Text can be selected, and scroll bars and the dividers between
/// views can be dragged; these are not controls. Layouts, which have names, arrange views without dragging.
fn takes(node: &AccessKitNode<'_>, action: egui::accesskit::Action) -> bool {
    let plain = matches!(node.role(), egui::Role::Label | egui::Role::ScrollBar) || is_line(node);
    !plain && node.data().supports_action(action) && !node.is_disabled() && !node.is_hidden()
}

fn takes_focus(node: &AccessKitNode<'_>) -> bool {
    takes(node, egui::accesskit::Action::Focus)
}

/// Whether a node is the divider between two views.
fn is_line(node: &AccessKitNode<'_>) -> bool {
    let thin = node.raw_bounds().is_some_and(|bounds| bounds.width().min(bounds.height()) < 8.0);
    node.role() == egui::Role::Unknown && thin
}

/// Checks that every control that can be clicked or focused has a name.
fn all_named(harness: &Harness<'_, Window>, place: &str) {
    let mut controls = 0;
    for node in nodes(harness) {
        if takes_focus(&node) || takes(&node, egui::accesskit::Action::Click) {
            controls += 1;
            assert!(
                said(&node).is_some(),
                "{place}: {:?} at {:?} has no name",
                node.role(),
                node.raw_bounds()
            );
        }
    }
    assert!(controls > 3, "{place}");
}

fn inspected() -> Harness<'static, Window> {
    window(Some(inspected_state(58)), (1600.0, 1000.0), Theme::Dark).0
}

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    harness.run_steps(4);
}

#[test]
fn every_control_has_a_name_in_every_state() {
    let failed = Phase::Failed("clip.mp4 does not exist; check the path".into());
    for (name, state) in [
        ("empty", None),
        ("opening", Some(state(Phase::Opening, None))),
        ("failed", Some(state(failed, None))),
    ] {
        all_named(&window(state, (1600.0, 1000.0), Theme::Dark).0, name);
    }
    let mut harness = inspected();
    all_named(&harness, "ready");
    for stage in ["Post-processing", "Regions", "Tracking", "Occlusion"] {
        let left = |node: &egui_kittest::Node<'_>| node.rect().left() < 60.0;
        harness.get_all_by_label_contains(stage).rfind(left).unwrap().click_accesskit();
        harness.run_steps(12);
        all_named(&harness, stage);
    }
    // All tabs present: they share a line with the first tab.
    let tabs: Vec<String> = {
        let first = harness.get_all_by_label("Mixture").last().unwrap().rect();
        let line = |node: &AccessKitNode<'_>| {
            let at = node.raw_bounds().map_or(f64::NAN, |bounds| f64::midpoint(bounds.y0, bounds.y1));
            let right = node.raw_bounds().is_some_and(|bounds| bounds.x0 as f32 >= first.left() - 1.0);
            right && (at as f32 - first.center().y).abs() < 60.0
        };
        nodes(&harness)
            .filter(|node| takes_focus(node) && line(node))
            .filter_map(|node| said(&node))
            .collect()
    };
    assert!(tabs.len() >= 5, "{tabs:?}");
    for tab in tabs {
        let Some(node) = harness.query_all_by_label(&tab).next() else { continue };
        node.click_accesskit();
        harness.run_steps(4);
        all_named(&harness, &tab);
    }
    harness.get_by_label("merge 1 + 2, frame 51").click();
    harness.run_steps(4);
    all_named(&harness, "evidence");
}

#[test]
fn every_control_has_a_name_in_menus_and_sheets() {
    let mut harness = inspected();
    for menu in Menu::ALL {
        harness.get_by_label(menu.name()).click();
        harness.run_steps(4);
        all_named(&harness, menu.name());
        let first = ACTIONS.iter().find(|entry| entry.menu == menu && entry.submenu.is_none()).unwrap();
        assert!(harness.query_by_label(first.text).is_some(), "{} is open", menu.name());
        harness.key_press(Key::Escape);
        harness.run_steps(4);
    }
    for (action, place) in [
        (Action::Palette, "Command palette"),
        (Action::Help, "Close"),
        (Action::About, "Close"),
        (Action::Messages, "Messages"),
    ] {
        act(&mut harness, action);
        assert!(harness.query_all_by_label(place).next().is_some(), "{action:?}");
        if action == Action::Messages {
            // The scroll area's background can be dragged.
            harness.check_accessibility();
        } else {
            all_named(&harness, place);
            harness.key_press(Key::Escape);
            harness.run_steps(4);
        }
    }
}

#[test]
fn the_tab_key_reaches_every_control_and_wraps_around() {
    let mut harness = inspected();
    let wanted: BTreeMap<String, String> = nodes(&harness)
        .filter(takes_focus)
        .map(|node| (format!("{:?}", node.id()), said(&node).unwrap_or_default()))
        .collect();
    let mut order: Vec<String> = Vec::new();
    let mut names = Vec::new();
    for _ in 0..2 * wanted.len() {
        harness.key_press(Key::Tab);
        harness.step();
        let focused = nodes(&harness).find(AccessKitNode::is_focused);
        let Some(node) = focused.filter(|node| node.role() != egui::accesskit::Role::Window) else {
            continue;
        };
        let id = format!("{:?}", node.id());
        if order.first() == Some(&id) {
            break;
        }
        names.push(said(&node).unwrap_or_default());
        order.push(id);
    }
    let reached: BTreeSet<&String> = order.iter().collect();
    let missed: Vec<_> =
        wanted.iter().filter(|(id, _)| !reached.contains(id)).map(|(_, name)| name).collect();
    assert!(missed.is_empty(), "Tab does not reach {missed:?}; it reaches {names:?}");
    // Menus first, then each row's controls together.
    assert_eq!(&names[..4], ["File", "View", "Analysis", "Help"]);
    let place = |name: &str| names.iter().position(|other| other == name).unwrap();
    assert_eq!(place("Next frame"), place("Play") + 1);
    assert_eq!(names[place("History") - 1], "Mixture");
}

#[test]
fn closing_a_dialog_restores_the_focus() {
    let mut harness = inspected();
    for (action, inside) in
        [(Action::Palette, "Command palette"), (Action::Help, "Close"), (Action::About, "Copy")]
    {
        harness.get_by_label("Play").focus();
        harness.run_steps(2);
        act(&mut harness, action);
        harness.get_all_by_label(inside).next().unwrap();
        // Tab stays within the dialog.
        for _ in 0..4 {
            harness.key_press(Key::Tab);
            harness.run_steps(2);
            assert!(!harness.get_by_label("Play").is_focused(), "{action:?}");
        }
        harness.key_press(Key::Escape);
        harness.run_steps(3);
        if harness.query_all_by_label(inside).next().is_some() {
            // The first Esc removed the focus from a control in the dialog.
            harness.key_press(Key::Escape);
            harness.run_steps(3);
        }
        assert!(harness.query_all_by_label(inside).next().is_none(), "{action:?} is closed");
        assert!(harness.get_by_label("Play").is_focused(), "{action:?}");
    }
}

#[test]
fn focused_views_and_timeline_handle_arrow_keys_and_show_the_focus() {
    let (mut harness, scene) = ready(58);
    settle(&mut harness);
    let before = harness.render().unwrap();
    harness.get_by_label("Foreground view").focus();
    harness.run_steps(2);
    let edge = harness.get_by_label("Foreground view").rect();
    let after = harness.render().unwrap();
    let at = |picture: &image::RgbaImage| *picture.get_pixel(edge.center().x as u32, edge.top() as u32);
    assert_ne!(at(&before), at(&after), "the focus has an outline");
    for key in [Key::ArrowDown, Key::ArrowDown, Key::ArrowRight] {
        harness.key_press(key);
        harness.run_steps(2);
    }
    assert_eq!(harness.state().model.selection.pixel, Some((81, 61)), "the selection starts at the centre");
    assert!(harness.get_by_label("Foreground view").is_focused());

    harness.get_by_label("Timeline").focus();
    harness.run_steps(2);
    for key in [Key::ArrowRight, Key::ArrowRight, Key::ArrowLeft] {
        harness.key_press(key);
        harness.run_steps(3);
    }
    assert_eq!(shows(&scene), [59, 60, 59]);
    assert!(harness.get_by_label("Timeline").is_focused());
}

#[test]
fn the_error_that_ended_the_analysis_is_in_the_messages() {
    let (mut harness, scene) = ready(58);
    scene.state.borrow_mut().phase = Phase::Failed("the disk is gone; plug it in and open it again".into());
    harness.run_steps(3);
    act(&mut harness, Action::CloseVideo);
    assert!(harness.query_by_label_contains("the disk is gone").is_none());
    act(&mut harness, Action::Messages);
    harness.get_by_label_contains("the disk is gone");
}
