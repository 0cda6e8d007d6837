//! The icons of events and controls.

use eframe::egui::{Color32, RichText};
pub(crate) use egui_material_icons::MaterialIcon as Icon;
use egui_material_icons::icons as m;

use crate::app::theme;
use crate::occlusion::EventKind;

/// The icon of a kind of event.
pub(crate) const fn of_event(kind: EventKind) -> Icon {
    match kind {
        EventKind::Exit => m::ICON_LOGOUT,
        EventKind::Demerge => m::ICON_CALL_SPLIT,
        EventKind::Merge => m::ICON_CALL_MERGE,
        EventKind::Disappear => m::ICON_VISIBILITY_OFF,
        EventKind::Reappear => m::ICON_VISIBILITY,
        EventKind::Enter => m::ICON_LOGIN,
        EventKind::Appear => m::ICON_ADD_CIRCLE,
    }
}

/// An icon in a line of text.
pub(crate) fn text(icon: Icon) -> RichText {
    icon.rich_text().size(theme::ICON_SIZE)
}

/// An icon in a line of text, in a colour.
pub(crate) fn coloured(icon: Icon, colour: Color32) -> RichText {
    text(icon).color(colour)
}
