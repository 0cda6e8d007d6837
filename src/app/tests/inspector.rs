//! Inspector requests and their execution by the window.

use super::*;
use crate::app::commands::action::Action;
use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::{Tuning, flip, map};
use crate::mixture::Parameters;

const AT: (u32, u32) = (80, 60);

/// A scene with a chosen pixel and its tuning map.
pub(super) fn inspected_state(position: u32) -> State {
    let parameters = Parameters::new(&Settings::default());
    let colour = |n: u32| if n > position - 10 { [40, 50, 60] } else { [100 + (n % 5) as u8, 90, 110] };
    let history = PixelHistory::of_colours(AT, parameters, (1..=FRAMES).map(|n| (n, colour(n))));
    let values: Vec<_> = history.states[..=position as usize].iter().map(|state| state.value).collect();
    let tuning = Tuning {
        at: AT,
        position,
        parameters,
        map: map(&values, &parameters, [TunableSetting::Alpha, TunableSetting::T]),
        flips: TunableSetting::ALL.iter().map(|&setting| flip(&values, &parameters, setting)).collect(),
    };
    let history = Some(Arc::new(history));
    let shown = ShownFrame { pixel: history.clone(), ..shown_at(position) };
    State {
        shown: Some(Arc::new(shown)),
        pixel: history,
        tuning: Some(Arc::new(tuning)),
        ..state(Phase::Ready, Some(position))
    }
}

fn inspected(position: u32) -> (Harness<'static, Window>, RecordingPlayer) {
    window(Some(inspected_state(position)), (1600.0, 1000.0), Theme::Dark)
}

fn tuned(scene: &RecordingPlayer) -> Vec<Option<[TunableSetting; 2]>> {
    let asked = scene.asked.borrow();
    asked
        .iter()
        .filter_map(|asked| if let PlayerCall::Tune(settings) = asked { Some(*settings) } else { None })
        .collect()
}

#[test]
fn a_visible_tuning_map_is_requested_and_a_cell_becomes_the_settings() {
    let (mut harness, scene) = inspected(60);
    assert!(tuned(&scene).is_empty());
    harness.get_by_label("Tuning").click();
    harness.run_steps(4);
    picture(&mut harness, "tuning");
    assert_eq!(tuned(&scene), [Some([TunableSetting::Alpha, TunableSetting::T])], "one request in total");

    let at = harness.get_by_label_contains("Tuning map, ").rect().center();
    harness.hover_at(at);
    harness.run_steps(2);
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(8);
    let settings = given(&scene).expect("no cell was applied");
    let cell = harness.state().model.worker.tuning().unwrap().map.clone();
    assert!(cell.axes[0].values.contains(&settings.alpha) && cell.axes[1].values.contains(&settings.t));
    assert_eq!(Settings { alpha: settings.alpha, t: settings.t, ..Settings::default() }, settings);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(8);
    assert_eq!(given(&scene), Some(Settings::default()), "the change can be undone");

    harness.get_all_by_label("Mixture").last().unwrap().click();
    harness.run_steps(4);
    assert_eq!(tuned(&scene).last(), Some(&None), "the tab is no longer visible");
}

#[test]
fn a_copied_table_is_on_the_clipboard() {
    let (mut harness, _) = inspected(60);
    harness.get_by_label("Statistics").click();
    harness.run_steps(4);
    picture(&mut harness, "statistics");
    harness.get_by_label("Copy or save the numbers").click();
    harness.run_steps(4);
    harness.get_by_label("Copy CSV of frames").click();
    let copied = copied_text(&mut harness);
    assert_eq!(copied.lines().count() as u32, FRAMES + 1);
    assert!(copied.starts_with("frame,value_r,value_g,value_b,matched,"));
}

/// Waits for a table on the clipboard.
pub(super) fn copied_text(harness: &mut Harness<'_, Window>) -> String {
    given_to_clipboard(harness, |command| {
        if let egui::OutputCommand::CopyText(text) = command { Some(text.clone()) } else { None }
    })
}

#[test]
fn closing_a_video_frees_its_histories() {
    let (mut harness, scene) = inspected(60);
    let act = |harness: &mut Harness<'_, Window>, command| {
        let ctx = harness.ctx.clone();
        harness.state_mut().apply(&ctx, command);
        harness.run_steps(3);
    };
    act(&mut harness, Command::Choose(Some(AT)));
    act(&mut harness, Command::Act(Action::Pin));
    for tab in ["History", "Scatter", "Statistics", "Pixels"] {
        harness.get_by_label(tab).click();
        harness.run_steps(4);
    }
    let kept = {
        let mut state = scene.state.borrow_mut();
        let pixel = Arc::downgrade(&state.pixel.take().unwrap());
        let (pin, shares) = (Arc::downgrade(&state.pins[0]), Arc::downgrade(&state.region.take().unwrap()));
        state.pins = Arc::default();
        state.shown = Some(Arc::new(shown_at(3)));
        (pixel, pin, shares)
    };
    settle(&mut harness);
    assert!(kept.0.upgrade().is_some(), "the plots' caches hold the history");
    act(&mut harness, Command::Act(Action::CloseVideo));
    assert!(kept.0.upgrade().is_none(), "the chosen pixel's history is freed");
    assert!(kept.1.upgrade().is_none(), "the pinned pixel's history is freed");
    assert!(kept.2.upgrade().is_none(), "the foreground ratio is freed");
}

/// Waits for the thread that prepares the clipboard's content.
fn given_to_clipboard<T>(
    harness: &mut Harness<'_, Window>,
    find: impl Fn(&egui::OutputCommand) -> Option<T>,
) -> T {
    draw_until(harness, |harness| harness.output().platform_output.commands.iter().find_map(&find))
}

#[test]
fn a_copied_plot_is_on_the_clipboard_as_an_image() {
    let (mut harness, _) = inspected(60);
    harness.get_by_label("Copy or save the densities").click();
    harness.run_steps(4);
    picture(&mut harness, "plot-menu");
    harness.get_by_label("Copy image").click();
    let image = given_to_clipboard(&mut harness, |command| {
        if let egui::OutputCommand::CopyImage(image) = command { Some(image.clone()) } else { None }
    });
    // 88 mm at 300 pixels an inch.
    assert_eq!(image.size[0], 1042);
    assert_eq!(image.pixels[0], egui::Color32::WHITE);
    assert!(image.pixels.iter().any(|pixel| pixel.r() < 60 && pixel.g() < 60), "the image is not empty");
}
