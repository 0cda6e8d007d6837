//! Marks, timeline and progress, in the Analysis menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{alt, key, shift};

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::Analysis,
        Action::StartHere,
        m::ICON_START,
        "Set loop start",
        &[shift(Key::Home)],
        "Loop playback from this frame; repeat to clear",
    )
    .within("Marks")
    .after_line(),
    entry(
        Menu::Analysis,
        Action::EndHere,
        m::ICON_KEYBOARD_TAB,
        "Set loop end",
        &[shift(Key::End)],
        "Loop playback up to this frame; repeat to clear",
    )
    .within("Marks"),
    entry(
        Menu::Analysis,
        Action::Bookmark,
        m::ICON_BOOKMARK,
        "Bookmark",
        &[key(Key::K)],
        "Add or remove a bookmark at this frame",
    )
    .within("Marks"),
    entry(
        Menu::Analysis,
        Action::NextBookmark,
        m::ICON_BOOKMARKS,
        "Next bookmark",
        &[shift(Key::N)],
        "Go to the next bookmark",
    )
    .within("Marks")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::PreviousBookmark,
        m::ICON_BOOKMARKS,
        "Previous bookmark",
        &[shift(Key::P)],
        "Go to the previous bookmark",
    )
    .within("Marks")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::WholeTimeline,
        m::ICON_ZOOM_OUT_MAP,
        "Whole timeline",
        &[shift(Key::F)],
        "Show all frames in the timeline; the wheel zooms, Shift with the wheel pans",
    ),
    entry(
        Menu::Analysis,
        Action::ZoomTimeline(true),
        m::ICON_ZOOM_IN,
        "Zoom in on timeline",
        &[alt(Key::Plus), alt(Key::Equals)],
        "Show half as many frames around the current one",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::ZoomTimeline(false),
        m::ICON_ZOOM_OUT,
        "Zoom out of timeline",
        &[alt(Key::Minus)],
        "Show twice as many frames",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::AnalyseAhead,
        m::ICON_STOP_CIRCLE,
        "Pause or resume analysis",
        &[shift(Key::Space)],
        "Analyse the whole video in the background, or only the displayed frames",
    )
    .after_line(),
];
