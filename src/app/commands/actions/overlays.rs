//! Overlays and loupe, in the View menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{key, shift};
use crate::app::model::overlays::TrackOverlay;

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::View,
        Action::Overlay,
        m::ICON_MASKED_TRANSITIONS,
        "Mask overlay",
        &[key(Key::O)],
        "Show or hide the foreground mask over the input view",
    ),
    entry(
        Menu::View,
        Action::OverlayOpacity,
        m::ICON_OPACITY,
        "Next mask opacity",
        &[shift(Key::O)],
        "Mask opacity of 25, 50, 75 or 100 %",
    ),
    entry(
        Menu::View,
        Action::Loupe,
        m::ICON_LOUPE,
        "Loupe",
        &[key(Key::L)],
        "Magnify the pixels around the pointer, with value and verdict; hold Alt to show it temporarily",
    ),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Trails),
        m::ICON_TIMELINE,
        "Trails",
        &[key(Key::T)],
        "Past positions of each object",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Gates),
        m::ICON_SCATTER_PLOT,
        "Gates",
        &[key(Key::G)],
        "Association gate of each object (dotted)",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Groups),
        m::ICON_WORKSPACES,
        "Groups",
        &[],
        "Objects that share a region (white)",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Occlusions),
        m::ICON_TEXTURE,
        "Occlusions",
        &[],
        "Objects occluded by another object or by the scene (hatched)",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Names),
        m::ICON_TAG,
        "Identities",
        &[],
        "Identity of each object, and its state while merged or occluded",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Events),
        m::ICON_FLAG,
        "Events",
        &[],
        "Events of this frame",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::Truth),
        m::ICON_FACT_CHECK,
        "Ground truth",
        &[],
        "Boxes of the loaded ground truth (white, dotted)",
    )
    .within("Track overlays"),
    entry(
        Menu::View,
        Action::Draw(TrackOverlay::External),
        m::ICON_COMPARE,
        "External results",
        &[],
        "Boxes of the loaded external results (black and white), with # before each identity",
    )
    .within("Track overlays"),
];
