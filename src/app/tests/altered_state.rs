//! A window whose stored state was cut, altered or written by another version.

use eframe::App as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg32;

use super::layout::{Storage, act};
use super::*;
use crate::app::commands::action::Action;
use crate::app::model::layout::ViewLayout;

/// What a number in the state becomes.
const NUMBERS: [&str; 10] =
    ["0", "1", "2", "7", "-1", "255", "NaN", "-inf", "3.4028235e38", "18446744073709551615"];

/// The state of a window in which most was used.
fn stored() -> Storage {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(50))), (1600.0, 1000.0), Theme::Dark);
    for action in [
        Action::Arrange(ViewLayout::Compare),
        Action::Open(View::Difference),
        Action::Bookmark,
        Action::StartHere,
        Action::Faster,
    ] {
        act(&mut harness, action);
    }
    let mut storage = Storage::default();
    harness.state_mut().save(&mut storage);
    storage
}

/// Where the numbers of a text are.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(start) = text[at..].find(|c: char| c.is_ascii_digit()) {
        let start = at + start;
        let end = text[start..].find(|c| !is_part(c)).map_or(text.len(), |length| start + length);
        found.push(start..end);
        at = end;
    }
    found
}

fn altered(text: &str, random: &mut Pcg32) -> String {
    let mut text = text.to_owned();
    for _ in 0..random.random_range(1..4) {
        let numbers = numbers(&text);
        match random.random_range(0..8) {
            0 => text.truncate(text.floor_char_boundary(random.random_range(0..=text.len()))),
            1 => text = text.replacen("true", "false", 1),
            2 => {
                let start = text.floor_char_boundary(random.random_range(0..=text.len()));
                let end = text.floor_char_boundary((start + random.random_range(0..20)).min(text.len()));
                let part = text[start..end].to_owned();
                text.insert_str(start, &part);
            }
            // Most alterations can be read.
            _ if !numbers.is_empty() => {
                let at = numbers[random.random_range(0..numbers.len())].clone();
                let other = numbers[random.random_range(0..numbers.len())].clone();
                let number = if random.random_bool(0.6) {
                    text[other].to_owned()
                } else {
                    NUMBERS[random.random_range(0..NUMBERS.len())].to_owned()
                };
                text.replace_range(at, &number);
            }
            _ => {}
        }
    }
    text
}

#[test]
fn an_altered_state_leaves_a_window_that_works() {
    let whole = stored();
    let mut random = Pcg32::seed_from_u64(19);
    let times = if std::env::var_os("OCCLUSCOPE_LONG").is_some() { 4000 } else { 80 };
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(50))), (1600.0, 1000.0), Theme::Dark);
    let ctx = harness.ctx.clone();
    for number in 0..times {
        let mut storage = Storage::default();
        for (key, text) in &whole.0 {
            let alter = random.random_bool(0.7);
            storage.0.insert(key.clone(), if alter { altered(text, &mut random) } else { text.clone() });
        }
        let worked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            harness.state_mut().restore(&ctx, Some(&storage));
            harness.run_steps(2);
            act(&mut harness, Action::Faster);
            harness.state_mut().save(&mut Storage::default());
            // Whatever the layout is, another one can be chosen.
            act(&mut harness, Action::Arrange(ViewLayout::All));
            harness.run_steps(1);
            assert_eq!(harness.state().model.display.open, View::ALL.map(View::is_open_at_first));
        }));
        if let Err(bug) = worked {
            eprintln!("state {number}: {:?}", storage.0);
            std::panic::resume_unwind(bug);
        }
    }
}
