//! Playback and navigation, in the Analysis menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{ctrl, key, shift};

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::Analysis,
        Action::Play,
        m::ICON_PLAY_ARROW,
        "Play or pause",
        &[key(Key::Space)],
        "Play at the video's frame rate times the speed, or pause",
    ),
    entry(
        Menu::Analysis,
        Action::Step(1),
        m::ICON_CHEVRON_RIGHT,
        "Next frame",
        &[key(Key::ArrowRight), key(Key::Period)],
        "Go one frame forward",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(-1),
        m::ICON_CHEVRON_LEFT,
        "Previous frame",
        &[key(Key::ArrowLeft), key(Key::Comma)],
        "Go one frame back",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(10),
        m::ICON_KEYBOARD_DOUBLE_ARROW_RIGHT,
        "Ten frames forward",
        &[shift(Key::ArrowRight)],
        "Go ten frames forward",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(-10),
        m::ICON_KEYBOARD_DOUBLE_ARROW_LEFT,
        "Ten frames back",
        &[shift(Key::ArrowLeft)],
        "Go ten frames back",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::NextEvent,
        m::ICON_FLAG,
        "Next event",
        &[ctrl(Key::ArrowRight), key(Key::N)],
        "Go to the next event of the listed kinds",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::PreviousEvent,
        m::ICON_FLAG,
        "Previous event",
        &[ctrl(Key::ArrowLeft), key(Key::P)],
        "Go to the previous event of the listed kinds",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::First,
        m::ICON_FIRST_PAGE,
        "First frame",
        &[key(Key::Home)],
        "Go to the first frame",
    ),
    entry(
        Menu::Analysis,
        Action::Last,
        m::ICON_LAST_PAGE,
        "Last frame",
        &[key(Key::End)],
        "Go to the last frame",
    ),
    entry(
        Menu::Analysis,
        Action::Slower,
        m::ICON_FAST_REWIND,
        "Slower",
        &[key(Key::OpenBracket)],
        "Halve the playback speed",
    ),
    entry(
        Menu::Analysis,
        Action::Faster,
        m::ICON_FAST_FORWARD,
        "Faster",
        &[key(Key::CloseBracket)],
        "Double the playback speed",
    ),
];
