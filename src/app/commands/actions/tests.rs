#![allow(clippy::unwrap_used)]

use eframe::egui::{Key, Modifiers};

use super::*;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::view::View;

#[test]
fn no_two_actions_share_a_shortcut_a_name_or_an_action() {
    for (i, a) in ACTIONS.iter().enumerate() {
        for b in &ACTIONS[i + 1..] {
            assert_ne!(a.action, b.action);
            assert_ne!(a.text, b.text);
            for shortcut in a.shortcuts {
                assert!(!b.shortcuts.contains(shortcut), "{} of {} and {}", shortcut.text(), a.text, b.text);
            }
        }
    }
}

#[test]
fn shift_and_ctrl_distinguish_shortcuts() {
    let press = |key, modifiers| {
        ACTIONS
            .iter()
            .filter(|entry| entry.shortcuts.iter().any(|shortcut| shortcut.matches(key, modifiers)))
            .map(|entry| entry.action)
            .collect::<Vec<_>>()
    };
    assert_eq!(press(Key::ArrowRight, Modifiers::NONE), [Action::Step(1)]);
    assert_eq!(press(Key::ArrowRight, Modifiers::SHIFT), [Action::Step(10)]);
    assert_eq!(press(Key::ArrowRight, Modifiers::COMMAND | Modifiers::CTRL), [Action::NextEvent]);
    assert_eq!(press(Key::Questionmark, Modifiers::SHIFT), [Action::Help]);
    assert_eq!(press(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT), [Action::Redo]);
    assert_eq!(press(Key::ArrowRight, Modifiers::ALT), [Action::MovePixel(1, 0)]);
    assert!(press(Key::F, Modifiers::ALT).is_empty());
}

/// The shortcuts in the first cell of a row of the README's table, written as in the menus.
fn keys_of(cell: &str) -> Vec<String> {
    let mut keys: Vec<String> = Vec::new();
    let mut before = String::new();
    for part in cell.split("<kbd>").skip(1) {
        let (name, after) = part.split_once("</kbd>").unwrap();
        let name = match name {
            "←" => "Left",
            "→" => "Right",
            "↑" => "Up",
            "↓" => "Down",
            name => name,
        };
        if after == "+" {
            before = format!("{before}{name}+");
            continue;
        }
        if let Some(first) = keys.pop_if(|key| key.ends_with('–')) {
            let numbers = first.trim_end_matches('–').parse::<u32>().unwrap()..=name.parse().unwrap();
            keys.extend(numbers.map(|number| number.to_string()));
        } else {
            let range = if after == "–" { "–" } else { "" };
            keys.push(format!("{before}{name}{range}"));
        }
        before.clear();
    }
    keys
}

#[test]
fn the_readme_lists_every_shortcut() {
    let rows = include_str!("../../../../README.md").lines().filter(|line| line.starts_with("| <kbd>"));
    let listed: Vec<String> = rows.flat_map(|row| keys_of(row.split('|').nth(1).unwrap())).collect();
    let texts = |entry: &ActionEntry| entry.shortcuts.iter().map(|key| key.text()).collect::<Vec<_>>();
    for key in &listed {
        let does = ACTIONS.iter().filter(|entry| texts(entry).contains(key)).count();
        assert_eq!(does, 1, "{key} is in the README and calls {does} actions");
        assert_eq!(listed.iter().filter(|other| *other == key).count(), 1, "{key} is listed twice");
    }
    for entry in ACTIONS.iter().filter(|entry| !entry.shortcuts.is_empty()) {
        let texts = texts(entry);
        assert!(texts.iter().any(|key| listed.contains(key)), "{} {texts:?} is not listed", entry.text);
    }
}

#[test]
fn every_action_of_the_keyboard_has_an_entry() {
    for action in [
        Action::Play,
        Action::Step(-10),
        Action::Maximise(View::Tracks),
        Action::AbSlot(AbSlot::B),
        Action::Palette,
    ] {
        assert_eq!(action.entry().unwrap().action, action);
    }
}

#[test]
fn every_view_has_entries_and_the_first_nine_have_a_number_key() {
    for (index, view) in View::ALL.into_iter().enumerate() {
        assert!(Action::Open(view).entry().unwrap().text.starts_with(view.title()));
        let keys: Vec<_> =
            Action::Maximise(view).entry().unwrap().shortcuts.iter().map(|key| key.text()).collect();
        let expected = if index < 9 { vec![(index + 1).to_string()] } else { Vec::new() };
        assert_eq!(keys, expected, "{view:?}");
    }
}
