//! Which actions are available, and which switches are on.

use crate::app::commands::action::Action;
use crate::app::commands::entry::ActionEntry;
use crate::app::model::Model;
use crate::app::model::overlays::TrackOverlay;

/// Whether a switch is on; `None` for actions that are not switches.
pub(crate) fn switch_state(model: &Model, action: Action) -> Option<bool> {
    match action {
        Action::Open(view) => Some(model.display.open[view.index()]),
        Action::Maximise(view) => Some(model.display.maximised == Some(view)),
        Action::Draw(what) => Some(model.display.track_overlays.has(what)),
        Action::Map(quantity) => Some(model.worker.sent.map.is_some() && model.display.quantity == quantity),
        Action::Overlay => Some(model.display.overlay.on),
        Action::Loupe => Some(model.display.loupe),
        Action::StartHere => Some(model.playback.marks.start == Some(model.worker.position())),
        Action::EndHere => Some(model.playback.marks.end == Some(model.worker.position())),
        Action::Bookmark => Some(model.playback.marks.bookmarks.contains(&model.worker.position())),
        Action::Pin => {
            Some(model.selection.pixel.is_some_and(|at| model.playback.marks.pins.number_of(at).is_some()))
        }
        Action::SettingsPanel => Some(model.panels.settings),
        Action::InspectorPanel => Some(model.panels.inspector),
        Action::AbSlot(slot) => Some(model.edits.ab_settings.in_view == slot),
        Action::DrawArea(purpose) => {
            Some(model.edits.areas.draft.as_ref().is_some_and(|draft| draft.purpose == purpose))
        }
        _ => None,
    }
}

/// Whether an action is available.
pub(crate) fn is_available(model: &Model, entry: &ActionEntry) -> bool {
    match entry.action {
        Action::Undo => model.edits.history.can_undo(),
        Action::Redo => model.edits.history.can_redo(),
        Action::AbSlot(slot) => model.edits.ab_settings.in_view != slot,
        Action::FlipSettings => model.edits.ab_settings.other.is_some() && model.edits.held_slot.is_none(),
        Action::CopySettings | Action::SwapSettings => {
            model.edits.ab_settings.other.as_ref().is_some_and(|other| *other != model.edits.settings)
        }
        Action::KeepSettings => model.edits.ab_settings.other.is_some(),
        Action::ClearPixel | Action::Pin => model.selection.pixel.is_some(),
        Action::ClearPins => !model.playback.marks.pins.is_empty(),
        Action::ClearObject => model.selection.object.is_some(),
        Action::Draw(TrackOverlay::Truth) => model.truth.as_ref().is_some_and(|truth| truth.boxes.is_some()),
        Action::Draw(TrackOverlay::External) => model.external_boxes().is_some(),
        Action::CloseExternal => model.external.is_some(),
        Action::CloseVideo | Action::SourceOptions => model.worker.player.is_some(),
        // The last open view cannot be closed.
        Action::Open(view) => {
            let more = model.display.open.iter().filter(|open| **open).count() > 1;
            model.worker.shown().is_some() && (more || !model.display.open[view.index()])
        }
        Action::CloseArea | Action::UndoCorner => model.edits.areas.draft.is_some(),
        Action::CancelArea => model.edits.areas.draft.is_some() || model.edits.areas.chosen.is_some(),
        Action::DeleteArea => model.edits.areas.chosen.is_some(),
        Action::NextBookmark => {
            model.playback.marks.adjacent_bookmark(model.worker.position(), true).is_some()
        }
        Action::PreviousBookmark => {
            model.playback.marks.adjacent_bookmark(model.worker.position(), false).is_some()
        }
        Action::WholeTimeline | Action::ZoomTimeline(false) => model.panels.timeline_span.is_some(),
        Action::AnalyseAhead => {
            model.worker.shown().is_some() && (model.worker.is_busy() || !model.worker.is_all_analysed())
        }
        Action::ClearAreas => !model.edits.areas.is_empty(),
        Action::SaveMask => model.edits.areas.roi.is_some(),
        _ => entry.always || model.worker.shown().is_some(),
    }
}
