//! Execution of the commands that change only the model. The window executes the others.

use crate::app::commands::action::Action;
use crate::app::commands::command::Command;
use crate::app::model::Model;
use crate::app::model::camera::ViewCamera;
use crate::app::model::event_comparison::EventRef;
use crate::app::model::overlays::MaskOverlay;
use crate::app::model::playback::SPEEDS;
use crate::app::model::timeline_span::zoomed_span;
use crate::app::model::undo_history::Direction;
use crate::settings::Settings;

/// The factor of a zoom by one key press.
const ZOOM_FACTOR: f32 = 1.25;

/// Executes a command.
pub(crate) fn apply(model: &mut Model, command: Command) {
    match command {
        Command::GoTo(position) => model.worker.go_to(position),
        Command::GoToNumber(number) => model.worker.go_to(model.worker.position_of(number)),
        Command::Span(span) => model.panels.timeline_span = span,
        Command::Speed(index) => model.playback.speed = index.min(SPEEDS.len() - 1),
        Command::Set(settings) => model.edits.settings = *settings,
        Command::SetSlot(slot, settings) => model.edits.set_slot(slot, *settings),
        Command::Choose(pixel) => model.choose_pixel(pixel),
        Command::ChooseObject(object) => model.choose_object(object),
        Command::ShowSubject(subject) => model.selection.subject = subject,
        Command::Unpin(number) => model.playback.marks.pins.remove(number),
        Command::SetCamera(camera) => model.display.camera = camera,
        Command::Hover(hover) => model.selection.hovered = hover,
        Command::ShowBackground(kind) => model.display.background = kind,
        Command::Overlay(opacity) => model.display.overlay.opacity = opacity.min(100),
        Command::RevealSetting(setting) => {
            model.panels.settings = true;
            model.panels.revealed_setting = Some(setting);
        }
        Command::SettingRevealed => model.panels.revealed_setting = None,
        Command::HideHint => model.panels.hint = false,
        Command::DismissTruth => model.offered_truth = None,
        Command::OpenEvent(event) => model.choose_event(event),
        Command::ReleaseSlot(slot) => {
            model.edits.held_slot = None;
            model.edits.show_slot(slot);
        }
        Command::FilterComparison(filter) => model.events.filter = filter,
        Command::FilterEvents(index, listed) => {
            if let Some(kind) = model.events.listed_kinds.get_mut(index) {
                *kind = listed;
            }
        }
        // These need the window.
        Command::Act(_)
        | Command::Open(..)
        | Command::Rate(_)
        | Command::Read(_)
        | Command::ReadTruth(_)
        | Command::ReadSweep(_)
        | Command::OpenSample
        | Command::Area(_) => {}
    }
}

/// Executes an action at a time of the window's clock, in seconds.
pub(crate) fn act(model: &mut Model, action: Action, now: f64) {
    match action {
        Action::Undo => step(model, Direction::Undo),
        Action::Redo => step(model, Direction::Redo),
        Action::FlipSettings => {
            let in_view = model.edits.ab_settings.in_view;
            model.edits.held_slot = Some(in_view);
            model.edits.show_slot(in_view.other());
        }
        Action::CopySettings => {
            model.edits.change_slots(|slots, settings| slots.other = Some(settings.clone()));
        }
        Action::SwapSettings => model.edits.change_slots(|slots, settings| {
            if let Some(other) = &mut slots.other {
                std::mem::swap(other, settings);
            }
        }),
        Action::DefaultSettings => model.edits.settings = Settings::default(),
        Action::Play => model.playback.toggle(&mut model.worker, now),
        Action::Step(by) => {
            model.playback.playing = false;
            model.worker.go_to(model.worker.position().saturating_add_signed(by));
        }
        Action::NextEvent | Action::PreviousEvent => {
            let forward = action == Action::NextEvent;
            if let Some((event, position)) = model.events.adjacent_event(&model.worker, forward) {
                model.playback.playing = false;
                model.choose_event(Some(EventRef::InView(event)));
                model.worker.go_to(position);
            }
        }
        Action::First => model.worker.go_to(0),
        Action::Last => model.worker.go_to(model.worker.frames().saturating_sub(1)),
        Action::StartHere => model.playback.marks.toggle_start(model.worker.position()),
        Action::EndHere => model.playback.marks.toggle_end(model.worker.position()),
        Action::Bookmark => model.playback.marks.toggle_bookmark(model.worker.position()),
        Action::NextBookmark | Action::PreviousBookmark => {
            let forward = action == Action::NextBookmark;
            let bookmark = model.playback.marks.adjacent_bookmark(model.worker.position(), forward);
            if let Some(position) = bookmark {
                model.playback.playing = false;
                model.worker.go_to(position);
            }
        }
        Action::WholeTimeline => model.panels.timeline_span = None,
        Action::ZoomTimeline(into) => model.panels.timeline_span = zoomed_span(model, into),
        Action::AnalyseAhead => model.worker.toggle_analysis(),
        Action::Slower => model.playback.speed = model.playback.speed.saturating_sub(1),
        Action::Faster => model.playback.speed = (model.playback.speed + 1).min(SPEEDS.len() - 1),
        Action::Maximise(view) => {
            let maximised = model.display.maximised == Some(view);
            model.display.maximised = if maximised { None } else { Some(view) };
        }
        Action::Fit => model.display.camera = ViewCamera::FIT,
        Action::Draw(what) => model.display.track_overlays.toggle(what),
        Action::ZoomIn => model.zoom_by(ZOOM_FACTOR),
        Action::ZoomOut => model.zoom_by(1.0 / ZOOM_FACTOR),
        Action::Background => model.display.background = model.display.background.next(),
        Action::Overlay => model.display.overlay.on = !model.display.overlay.on,
        Action::OverlayOpacity => {
            model.display.overlay = MaskOverlay { on: true, opacity: model.display.overlay.next() };
        }
        Action::MovePixel(columns, rows) => {
            let size = model.worker.shown().map(|shown| shown.frame.size);
            let pixel = size.map(|size| model.selection.adjacent_pixel(size, columns, rows));
            model.choose_pixel(pixel);
        }
        Action::ClearPixel => model.choose_pixel(None),
        Action::ClearObject => model.choose_object(None),
        Action::Loupe => model.display.loupe = !model.display.loupe,
        Action::CloseExternal => model.set_external(None),
        Action::ClearPins => model.playback.marks.pins.clear(),
        Action::SettingsPanel => model.panels.settings = !model.panels.settings,
        Action::InspectorPanel => model.panels.inspector = !model.panels.inspector,
        // These need the window.
        Action::OpenVideo
        | Action::OpenFolder
        | Action::OpenSample
        | Action::SourceOptions
        | Action::CloseVideo
        | Action::ExportFrame
        | Action::CopyPlace
        | Action::CopyPicture
        | Action::SaveSettings
        | Action::LoadSettings
        | Action::OpenSweep
        | Action::Quit
        | Action::AbSlot(_)
        | Action::KeepSettings
        | Action::DrawArea(_)
        | Action::CloseArea
        | Action::UndoCorner
        | Action::CancelArea
        | Action::DeleteArea
        | Action::ClearAreas
        | Action::LoadMask
        | Action::SaveMask
        | Action::LoadTruth
        | Action::LoadTruthFolder
        | Action::LoadExternal
        | Action::LoadExternalFolder
        | Action::Open(_)
        | Action::Arrange(_)
        | Action::Actual
        | Action::Map(_)
        | Action::NextMap
        | Action::Pin
        | Action::Scale(_)
        | Action::Theme
        | Action::Messages
        | Action::About
        | Action::Help
        | Action::Palette => {}
    }
}

/// Undoes or redoes an edit.
fn step(model: &mut Model, direction: Direction) {
    if model.edits.step(direction) {
        model.send_roi();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_outside_their_range_are_clamped_or_ignored() {
        let mut model = Model::new(Settings::default());
        apply(&mut model, Command::Overlay(200));
        apply(&mut model, Command::Speed(99));
        apply(&mut model, Command::FilterEvents(99, false));
        assert_eq!((model.display.overlay.opacity, model.playback.speed), (100, SPEEDS.len() - 1));
        assert!(model.events.listed_kinds.iter().all(|listed| *listed));
        apply(&mut model, Command::FilterEvents(1, false));
        assert!(!model.events.listed_kinds[1]);
    }

    #[test]
    fn revealing_a_setting_opens_its_panel() {
        let mut model = Model::new(Settings::default());
        act(&mut model, Action::SettingsPanel, 0.0);
        assert!(!model.panels.settings);
        apply(&mut model, Command::RevealSetting("alpha"));
        assert_eq!((model.panels.settings, model.panels.revealed_setting), (true, Some("alpha")));
    }

    #[test]
    fn swapped_settings_are_undone_and_redone() {
        let (start, five) = (Settings::default(), Settings { k: 5, ..Settings::default() });
        let mut model = Model::new(start.clone());
        act(&mut model, Action::CopySettings, 0.0);
        apply(&mut model, Command::Set(Box::new(five.clone())));
        act(&mut model, Action::SwapSettings, 0.0);
        assert_eq!((&model.edits.settings, model.edits.ab_settings.other.as_ref()), (&start, Some(&five)));
        act(&mut model, Action::Undo, 0.0);
        assert_eq!((&model.edits.settings, model.edits.ab_settings.other.as_ref()), (&five, Some(&start)));
        act(&mut model, Action::Redo, 0.0);
        assert_eq!((&model.edits.settings, model.edits.ab_settings.other.as_ref()), (&start, Some(&five)));
    }
}
