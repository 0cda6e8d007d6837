//! The dialog of a sweep.

use super::truth::Dropped;
use super::*;
use crate::app::commands::action::Action;
use crate::app::model::opened_sweep::OpenedSweep;
use crate::export::report::tests::{Data, table};

const AXES: &[&str] = &["k=3,4,5,6", "alpha=0.0005,0.002,0.01,0.05", "t=0.6,0.7,0.8,0.9"];

/// A window with an open sweep, of settings that differ from the present ones where it has its own.
fn with_sweep(size: (f32, f32), theme: Theme, base: Option<Settings>) -> Harness<'static, Window> {
    let (mut harness, _) = window(Some(state(Phase::Ready, Some(58))), size, theme);
    let mut table = table(&Data { axes: AXES, sequences: 3, ..Data::default() });
    // The cells of α = 0.05 with T = 0.9 and every K.
    table.rows.retain(|row| table.grid.indices(row.combination)[1..] != [3, 3]);
    let sweep = OpenedSweep { path: "/results/sweep.csv".into(), table, base };
    let ctx = harness.ctx.clone();
    harness.state_mut().handle_result(&ctx, DialogResult::Sweep(Ok(Arc::new(sweep))));
    harness.run_steps(4);
    harness
}

fn base() -> Settings {
    Settings { median: 9, ..Settings::default() }
}

/// Presses Enter with these modifiers on the cell whose name begins with this.
fn press(harness: &mut Harness<'_, Window>, name: &str, modifiers: Modifiers) {
    harness.get_by(|node| node.label().is_some_and(|label| label.starts_with(name))).focus();
    harness.run_steps(2);
    harness.key_press_modifiers(modifiers, Key::Enter);
    harness.run_steps(3);
}

#[test]
fn the_dialog_looks_as_before() {
    let mut harness = with_sweep((1280.0, 800.0), Theme::Dark, Some(base()));
    panels::dialog_looks_as_before(&mut harness, "sweep", "sweep");
    let mut harness = with_sweep((800.0, 560.0), Theme::Light, None);
    picture(&mut harness, "sweep-smallest-light");
    let dialog = harness.ctx.memory(|memory| memory.area_rect(egui::Id::unique("sweep"))).unwrap();
    assert!(harness.ctx.content_rect().contains_rect(dialog), "{dialog}");
    assert!(dialog.contains_rect(harness.get_by_label("Close").rect()));
}

#[test]
fn a_cell_is_loaded_into_a_or_b() {
    let mut harness = with_sweep((1280.0, 800.0), Theme::Dark, Some(base()));
    let cell = harness.state().model.edits.settings.clone();
    press(&mut harness, "k=5 alpha=0.01 ", Modifiers::NONE);
    let settings = |harness: &Harness<'_, Window>| harness.state().model.edits.settings.clone();
    let ours = settings(&harness);
    assert_eq!((ours.k, ours.alpha, ours.median), (5, 0.01, 9), "the rest is from settings.toml");
    assert_eq!(harness.state().model.edits.ab_settings.other, None);
    press(&mut harness, "k=4 alpha=0.002 ", Modifiers::SHIFT);
    let other = harness.state().model.edits.ab_settings.other.clone().unwrap();
    assert_eq!((other.k, other.alpha, other.median), (4, 0.002, 9));
    assert_eq!((settings(&harness), harness.state().model.edits.ab_settings.in_view), (ours, AbSlot::A));
    harness.get_by_label("Close").click();
    harness.run_steps(3);
    assert!(!harness.state().sweep_maps.is_open());
    let ctx = harness.ctx.clone();
    for _ in 0..2 {
        harness.state_mut().apply(&ctx, Command::Act(Action::Undo));
    }
    assert_eq!((settings(&harness), &harness.state().model.edits.ab_settings.other), (cell, &None));
}

#[test]
fn without_its_settings_a_sweep_changes_the_present_ones() {
    let mut harness = with_sweep((1280.0, 800.0), Theme::Light, None);
    assert!(harness.query_by_label_contains("No settings.toml beside the table").is_some());
    assert!(harness.query_by_label_contains("12 rows are missing").is_some());
    harness.state_mut().model.edits.settings.median = 11;
    harness.run_steps(2);
    harness.get_by_label("Load into B").click();
    harness.run_steps(3);
    let other = harness.state().model.edits.ab_settings.other.clone().unwrap();
    assert_eq!(other.median, 11);
}

#[test]
fn sequence_and_axes_are_chosen() {
    let mut harness = with_sweep((1280.0, 800.0), Theme::Dark, Some(base()));
    let choose = |harness: &mut Harness<'_, Window>, list: &str, entry: &str| {
        harness.get_by_role_and_label(egui::Role::ComboBox, list).click();
        harness.run_steps(3);
        harness.get_by_role_and_label(egui::Role::Button, entry).click();
        harness.run_steps(3);
    };
    choose(&mut harness, "X axis", "background ratio T");
    choose(&mut harness, "Measure", "MOTA");
    assert!(harness.query_by_label_contains("Best: MOTA ").is_some());
    let cells = |harness: &Harness<'_, Window>| {
        harness.query_all_by(|node| node.label().is_some_and(|label| label.contains(": MOTA "))).count()
    };
    // Y is α, so the cell of T = 0.9 and α = 0.05 has no value.
    assert_eq!(cells(&harness), 15);
    choose(&mut harness, "Y axis", "components K");
    assert_eq!(cells(&harness), 16);
}

#[test]
fn the_folder_of_a_sweep_can_be_dropped() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("sweep.csv"),
        "sequence,k,f,precision,recall,pwc,seconds\na,3,0.5,1,1,1,1\n",
    )
    .unwrap();
    let (mut harness, _) = ready(58);
    harness.input_mut().dropped_files.push(Arc::new(Dropped(folder.path().into())));
    draw_until(&mut harness, |harness| harness.state().sweep_maps.is_open().then_some(()));
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("1 sequence, 1 combination of settings").is_some());
    harness.get_by_label("k=3: F 0.500");
}
