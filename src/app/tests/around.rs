//! Opening and closing videos, messages, copying, the hint, and help on settings.

use super::*;
use crate::app::commands::action::Action;

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    harness.run_steps(3);
}

/// The clipboard commands of the last frame.
fn copied(harness: &Harness<'_, Window>) -> Vec<egui::OutputCommand> {
    harness.output().platform_output.commands.clone()
}

#[test]
fn opening_can_be_cancelled_and_a_video_closed() {
    let (mut harness, _) = window(Some(state(Phase::Opening, None)), (1600.0, 1000.0), Theme::Dark);
    harness.get_by_label("Cancel").click();
    harness.run_steps(3);
    assert!(harness.state().model.worker.player.is_none());
    harness.get_by_label("Open a video");

    let (mut harness, _) = ready(10);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::W);
    harness.run_steps(3);
    harness.get_by_label("Open a video");
    // The closed video is among the recent videos.
    harness.get_by_label("walk.mp4").click();
    harness.run_steps(3);
    settle(&mut harness);
    assert_eq!(harness.state().model.videos.opened.as_deref(), Some("/videos/walk.mp4"));
    assert!(harness.state().model.worker.shown().is_some());
}

#[test]
fn frame_and_pixel_are_copied_as_text_and_the_frame_as_a_picture() {
    let (mut harness, _) = ready(10);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Choose(Some((30, 60))));
    harness.state_mut().apply(&ctx, Command::Act(Action::CopyPlace));
    harness.step();
    let text = copied(&harness).into_iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text),
        _ => None,
    });
    let [r, g, b] = shown_at(10).frame.pixel(30, 60).unwrap();
    assert_eq!(text, Some(format!("walk.mp4, frame 11, 0.40 s, pixel 30,60 = {r} {g} {b}")));
    harness.state_mut().apply(&ctx, Command::Act(Action::CopyPicture));
    harness.step();
    let picture = copied(&harness).into_iter().find_map(|command| match command {
        egui::OutputCommand::CopyImage(image) => Some(image),
        _ => None,
    });
    assert_eq!(picture.unwrap().size, [160, 120]);
}

#[test]
fn the_message_log_lists_past_messages() {
    let (mut harness, scene) = ready(10);
    scene.state.borrow_mut().warnings = Arc::new(vec!["in000007.jpg cannot be read and was skipped".into()]);
    harness.run_steps(3);
    harness.get_by_label("Warnings").click();
    harness.run_steps(4);
    assert!(harness.query_all_by_label("in000007.jpg cannot be read and was skipped").next().is_some());
    picture(&mut harness, "messages");
    harness.get_by_label("Copy all").click();
    harness.run_steps(2);
}

#[test]
fn the_about_dialog_shows_version_and_graphics_adapter() {
    let (mut harness, _) = ready(10);
    act(&mut harness, Action::About);
    harness.get_by_label(env!("OCCLUSCOPE_VERSION"));
    picture(&mut harness, "about");
    // Shortcuts do not act on what is under the dialog.
    harness.key_press(Key::Num5);
    harness.run_steps(2);
    assert_eq!(harness.state().model.display.maximised, None);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label(env!("OCCLUSCOPE_VERSION")).is_none());
}

#[test]
fn the_sample_shows_a_hint_until_it_is_dismissed() {
    let (mut harness, _) = ready(58);
    assert!(harness.query_by_label("Hide hint").is_none(), "only the sample has a hint");
    act(&mut harness, Action::OpenSample);
    settle(&mut harness);
    assert_eq!(
        harness.state().model.videos.recent,
        ["/videos/walk.mp4"],
        "the sample is not among the recent videos"
    );
    picture(&mut harness, "hint");
    harness.get_by_label("Hide hint").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("Hide hint").is_none() && !harness.state().model.panels.hint);
}

#[test]
fn a_settings_tooltip_shows_its_equation_and_the_effect_of_a_larger_value() {
    let (mut harness, _) = ready(58);
    // The name is left of the typed value.
    let typed = harness.get_by_label("learning rate").rect();
    harness.hover_at(egui::pos2(harness.get_by_label("Settings").rect().left() + 14.0, typed.center().y));
    harness.run_steps(10);
    picture(&mut harness, "setting-help");
    harness.get_by_label_contains("w_k");
    harness.get_by_label_contains("The model learns faster");
}

#[test]
fn a_setting_is_found_by_name_and_scrolled_into_view() {
    let (mut harness, _) = ready(58);
    assert!(harness.query_by_label("colour threshold").is_none(), "its stage is collapsed");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::K);
    harness.run_steps(4);
    harness.get_by_label("Command palette").type_text("same col");
    harness.run_steps(3);
    harness.key_press(Key::Enter);
    harness.run_steps(40);
    let place = harness.get_by_label("colour threshold").rect();
    let panel = harness.get_by_label("Settings").rect();
    assert!(place.top() > panel.bottom() && place.bottom() < 860.0, "{place}");
    picture(&mut harness, "setting-found");
    // After that the panel stays at the user's scroll offset.
    harness.get_by_label("Input view").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.panels.revealed_setting, None);
}

#[test]
fn the_analysis_can_be_paused_and_resumed_beside_its_progress() {
    let (mut harness, scene) = ready(58);
    assert!(harness.query_by_label("Pause analysis").is_none(), "the analysis is idle");
    let asked = |scene: &RecordingPlayer| scene.asked.borrow().last().cloned();
    {
        let mut state = scene.state.borrow_mut();
        state.busy = Some(WorkProgress { what: "analysing".into(), done: 70, total: Some(FRAMES) });
        Arc::make_mut(&mut state.timeline).analysed = 70;
    }
    harness.run_steps(3);
    picture(&mut harness, "analysing");
    harness.get_by_label("Pause analysis").click();
    harness.run_steps(3);
    assert_eq!(asked(&scene), Some(PlayerCall::Ahead(false)));
    scene.state.borrow_mut().busy = None;
    harness.run_steps(3);
    harness.get_by_label("paused  70 / 120");
    picture(&mut harness, "paused");
    // A frame beyond the analysed ones is requested; a pause drops the request.
    harness.key_press(Key::End);
    harness.step();
    scene.state.borrow_mut().busy =
        Some(WorkProgress { what: "analysing".into(), done: 80, total: Some(FRAMES) });
    harness.run_steps(3);
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Space);
    harness.run_steps(3);
    assert_eq!(asked(&scene), Some(PlayerCall::Ahead(false)));
    assert_eq!(harness.state().model.worker.requested_position, None);
    scene.state.borrow_mut().busy = None;
    harness.run_steps(3);
    harness.get_by_label("Resume analysis").click();
    harness.run_steps(3);
    assert_eq!(asked(&scene), Some(PlayerCall::Ahead(true)));
    assert!(harness.query_by_label_contains("paused").is_none());
}

#[test]
fn closing_a_video_does_not_wait_for_its_worker() {
    let (mut harness, scene) = ready(58);
    let ctx = harness.ctx.clone();
    let left = |scene: &RecordingPlayer| {
        scene.asked.borrow().iter().filter(|asked| **asked == PlayerCall::Leave).count()
    };
    harness.state_mut().apply(&ctx, Command::Open("/videos/other.mp4".into(), Start::First));
    assert_eq!(left(&scene), 1);
    act(&mut harness, Action::CloseVideo);
    assert_eq!(left(&scene), 2);
}

#[test]
fn opening_shows_its_progress() {
    let mut opening = state(Phase::Opening, None);
    opening.busy = Some(WorkProgress { what: "reading".into(), done: 3, total: Some(40) });
    let (harness, _) = window(Some(opening), (1600.0, 1000.0), Theme::Dark);
    harness.get_by_role_and_label(egui::Role::ProgressIndicator, "Opening walk.mp4");
    harness.get_by_label("reading: 3 of 40");
}

#[test]
fn pixels_and_the_timeline_have_shortcuts() {
    let (mut harness, scene) = ready(58);
    let chosen = |harness: &mut Harness<'_, Window>, modifiers, key| {
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(2);
        harness.state().model.selection.pixel
    };
    assert_eq!(chosen(&mut harness, Modifiers::ALT, Key::ArrowLeft), Some((80, 60)), "the centre at first");
    assert_eq!(chosen(&mut harness, Modifiers::ALT, Key::ArrowLeft), Some((79, 60)));
    assert_eq!(chosen(&mut harness, Modifiers::ALT, Key::ArrowDown), Some((79, 61)));
    assert_eq!(scene.asked.borrow().last(), Some(&PlayerCall::Inspect(Some((79, 61)))));
    harness.state_mut().model.selection.pixel = Some((159, 0));
    assert_eq!(chosen(&mut harness, Modifiers::ALT, Key::ArrowRight), Some((159, 0)), "at the edge");
    assert_eq!(chosen(&mut harness, Modifiers::ALT, Key::ArrowUp), Some((159, 0)));

    harness.key_press_modifiers(Modifiers::ALT, Key::Plus);
    harness.run_steps(2);
    let (from, to) = harness.state().model.panels.timeline_span.unwrap();
    assert!((to - from - 60.0).abs() < 0.1 && (from..to).contains(&58.5), "{from} to {to}");
    harness.key_press_modifiers(Modifiers::ALT, Key::Minus);
    harness.run_steps(2);
    assert_eq!(harness.state().model.panels.timeline_span, None);
}

#[test]
fn an_unknown_frame_rate_is_labelled_as_assumed_and_can_be_typed() {
    let (harness, _) = ready(10);
    assert!(harness.query_by_label_contains("assumed").is_none(), "the video specifies its rate");
    let mut unsaid = state(Phase::Ready, Some(10));
    let info = SourceInfo { fps_from: FpsFrom::Assumed, ..SourceInfo::clone(unsaid.info.as_ref().unwrap()) };
    unsaid.info = Some(Arc::new(info));
    let (mut harness, scene) = window(Some(unsaid), (1600.0, 1000.0), Theme::Dark);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Choose(Some((30, 60))));
    let field = (egui::Role::SpinButton, "fps, assumed");
    harness.get_by_role_and_label(field.0, field.1).focus();
    harness.run_steps(2);
    harness.get_by_role_and_label(field.0, field.1).type_text("12.5");
    harness.run_steps(2);
    assert!(harness.state().model.videos.options.is_empty(), "no rate is applied while typing");
    let said = scene.asked.borrow().len();
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let model = &harness.state().model;
    assert_eq!(model.videos.options_of("/videos/walk.mp4").fps, Some(12.5));
    assert_eq!(model.selection.pixel, Some((30, 60)), "the chosen pixel is retained");
    assert!(
        scene.asked.borrow()[said..].iter().any(|asked| matches!(asked, PlayerCall::Inspect(Some((30, 60)))))
    );
}
