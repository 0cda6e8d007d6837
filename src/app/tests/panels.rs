//! Pictures of the panels and dialogs that other tests do not compare.
//!
//! The About dialog has none: it names the graphics card and the versions of this machine.

use eframe::egui::{Id, Rect, pos2};
use egui_material_icons::icons as m;

use super::*;
use crate::app::commands::action::Action;
use crate::app::model::areas::AreaEdit;
use crate::app::model::videos::Origin;
use crate::app::theme;
use crate::regions::roi::Purpose;

/// A small window on frame 59.
fn small(theme: Theme) -> Harness<'static, Window> {
    window(Some(state(Phase::Ready, Some(58))), (1024.0, 640.0), theme).0
}

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    harness.run_steps(4);
}

/// The rectangle of all controls with these labels.
fn rect_of(harness: &Harness<'_, Window>, labels: &[&str]) -> Rect {
    let rects = labels.iter().map(|label| harness.get_by_label(label).rect());
    rects.reduce(Rect::union).unwrap().expand(4.0)
}

/// The settings panel, from its heading to the end of the views.
pub(super) fn settings_panel(harness: &Harness<'_, Window>) -> Rect {
    let top = harness.get_by_label("Settings").rect().top() - 4.0;
    Rect::from_min_max(pos2(0.0, top), views(harness).left_bottom())
}

/// Checks the open dialog of this id.
pub(super) fn dialog_looks_as_before(harness: &mut Harness<'_, Window>, id: &str, name: &str) {
    // The cursor would blink.
    harness.ctx.all_styles_mut(|style| style.visuals.text_cursor.blink = false);
    harness.run_steps(2);
    let dialog = harness.ctx.memory(|memory| memory.area_rect(Id::unique(id))).unwrap();
    part_looks_as_before(harness, dialog.expand(4.0), name);
}

/// Checks the whole window.
fn window_looks_as_before(harness: &mut Harness<'_, Window>, name: &str) {
    let whole = harness.ctx.content_rect();
    part_looks_as_before(harness, whole, name);
}

#[test]
fn the_timeline_and_the_playback_controls_look_as_before() {
    let mut harness = small(Theme::Dark);
    let part = rect_of(&harness, &["First frame", "Speed", "Timeline"]);
    part_looks_as_before(&mut harness, part, "timeline");
}

#[test]
fn the_settings_panel_looks_as_before() {
    let mut harness = small(Theme::Dark);
    let part = settings_panel(&harness);
    part_looks_as_before(&mut harness, part, "settings-panel");
}

#[test]
fn the_help_on_a_setting_looks_as_before() {
    let mut harness = small(Theme::Dark);
    // The name is left of the typed value.
    let typed = harness.get_by_label("learning rate").rect();
    harness.hover_at(pos2(harness.get_by_label("Settings").rect().left() + 14.0, typed.center().y));
    harness.run_steps(10);
    let lines = ["alpha  α", "Learning rate of", "The model learns faster", "Command-line flag"];
    let lines = lines.map(|text| harness.get_by_label_contains(text).rect());
    let part = lines.into_iter().reduce(Rect::union).unwrap().expand(8.0);
    part_looks_as_before(&mut harness, part, "setting-help");
}

#[test]
fn the_areas_look_as_before() {
    let mut harness = small(Theme::Dark);
    let ctx = harness.ctx.clone();
    for (purpose, from, to) in
        [(Purpose::Analyse, [0.0, 0.0], [140.0, 110.0]), (Purpose::Ignore, [5.0, 5.0], [40.0, 40.0])]
    {
        harness.state_mut().apply(&ctx, Command::Act(Action::DrawArea(purpose)));
        harness.state_mut().apply(&ctx, Command::Area(AreaEdit::Rectangle(from, to)));
    }
    settle(&mut harness);
    // The settings of the mixture are above the areas and fill the panel.
    harness.get_all_by_label("Mixture").next_back().unwrap().click_accesskit();
    harness.run_steps(12);
    let top = harness.get_by_label_contains("% analysed").rect().top();
    let bottom = harness.get_by_label("Delete Ignore 2").rect().bottom();
    let part = settings_panel(&harness).with_min_y(top - 4.0).with_max_y(bottom + 4.0);
    part_looks_as_before(&mut harness, part, "areas");
}

#[test]
fn an_open_menu_looks_as_before() {
    let mut harness = small(Theme::Dark);
    harness.get_by_label("File").click();
    harness.run_steps(4);
    let part = rect_of(&harness, &["File", "Open video…", "Quit"]);
    part_looks_as_before(&mut harness, part, "menu");
}

#[test]
fn the_help_looks_as_before() {
    let (mut harness, _) = window(None, (1024.0, 1400.0), Theme::Light);
    act(&mut harness, Action::Help);
    dialog_looks_as_before(&mut harness, "help", "help");
}

#[test]
fn the_command_palette_looks_as_before_without_and_with_a_query() {
    let mut harness = small(Theme::Dark);
    act(&mut harness, Action::Palette);
    dialog_looks_as_before(&mut harness, "command palette", "command-palette");
    harness.get_by_label("Command palette").type_text("occl");
    harness.run_steps(4);
    dialog_looks_as_before(&mut harness, "command palette", "command-palette-query");
    harness.get_by_label("Command palette").type_text("xyz");
    harness.run_steps(4);
    harness.get_by_label("No matching action or setting.");
}

#[test]
fn the_messages_look_as_before() {
    let (mut harness, _) = window(None, (800.0, 560.0), Theme::Light);
    let messages = &mut harness.state_mut().toasts.messages;
    messages.add(4.0, "Wrote settings.toml", m::ICON_CHECK_CIRCLE, |colours| colours.good);
    messages
        .add(65.0, "in000007.jpg cannot be read and was skipped", m::ICON_WARNING, |colours| colours.warn);
    messages.add(99.0, "other.mp4 cannot be opened: no such file", m::ICON_ERROR, |colours| colours.bad);
    act(&mut harness, Action::Messages);
    window_looks_as_before(&mut harness, "messages");
}

#[test]
fn the_status_bar_looks_as_before() {
    let mut busy = state(Phase::Ready, Some(58));
    busy.busy = Some(WorkProgress { what: "analysing".into(), done: 70, total: Some(FRAMES) });
    Arc::make_mut(&mut busy.timeline).analysed = 70;
    let (mut harness, _) = window(Some(busy), (1024.0, 640.0), Theme::Dark);
    let whole = harness.ctx.content_rect();
    let part = whole.with_min_y(whole.bottom() - theme::ROW_HEIGHT);
    part_looks_as_before(&mut harness, part, "status");
}

#[test]
fn a_frame_rate_is_asked_for_where_none_is_given() {
    let mut state = state(Phase::Ready, Some(58));
    let info = SourceInfo { fps_from: FpsFrom::Assumed, ..SourceInfo::clone(state.info.as_ref().unwrap()) };
    state.info = Some(Arc::new(info));
    let (mut harness, _) = window(Some(state), (1024.0, 640.0), Theme::Dark);
    harness.run_steps(4);
    let part = rect_of(
        &harness,
        &["No frame rate is given, 25 fps are assumed. Choose it:", "50", "or type it above"],
    );
    let views = views(&harness);
    part_looks_as_before(&mut harness, part.with_min_x(views.left()).with_max_x(views.right()), "ask-rate");
    harness.get_by_label("14").click();
    harness.run_steps(4);
    let options = harness.state().model.videos.options_of("/videos/walk.mp4");
    assert_eq!(options.fps, Some(14.0));
}

#[test]
fn the_bars_over_the_views_look_as_before() {
    let why = "frame 60 of walk.mp4 cannot be decoded";
    let (mut harness, _) =
        window(Some(state(Phase::Failed(why.into()), Some(58))), (1024.0, 640.0), Theme::Dark);
    harness.state_mut().model.videos.origin = Origin::Sample;
    harness.run_steps(4);
    let hint = harness.get_by_label_contains("Two people cross").rect().expand(4.0);
    let part = rect_of(&harness, &[why, "Open again", "Hide hint"]).union(hint);
    let views = views(&harness);
    part_looks_as_before(&mut harness, part.with_min_x(views.left()).with_max_x(views.right()), "notices");
}

#[test]
fn the_window_without_a_video_looks_as_before() {
    let (mut harness, _) = window(None, (800.0, 560.0), Theme::Light);
    window_looks_as_before(&mut harness, "welcome");
}

#[test]
fn the_window_with_a_video_that_cannot_be_opened_looks_as_before() {
    let why = "/videos/walk.mp4 cannot be opened: no such file";
    let (mut harness, _) = window(Some(state(Phase::Failed(why.into()), None)), (800.0, 560.0), Theme::Light);
    window_looks_as_before(&mut harness, "welcome-failed");
}

#[test]
fn the_window_under_a_dragged_file_looks_as_before() {
    let (mut harness, _) = window(None, (800.0, 560.0), Theme::Light);
    harness.input_mut().hovered_files.push(egui::HoveredFile::default());
    harness.run_steps(2);
    window_looks_as_before(&mut harness, "drop-files");
}
