//! The selected pixel and object, in the View menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{alt, key};

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::View,
        Action::MovePixel(-1, 0),
        m::ICON_ARROW_BACK,
        "Pixel to the left",
        &[alt(Key::ArrowLeft)],
        "Select the pixel to the left; the image centre if none is selected",
    )
    .within("Select a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::MovePixel(1, 0),
        m::ICON_ARROW_FORWARD,
        "Pixel to the right",
        &[alt(Key::ArrowRight)],
        "Select the pixel to the right",
    )
    .within("Select a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::MovePixel(0, -1),
        m::ICON_ARROW_UPWARD,
        "Pixel above",
        &[alt(Key::ArrowUp)],
        "Select the pixel above",
    )
    .within("Select a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::MovePixel(0, 1),
        m::ICON_ARROW_DOWNWARD,
        "Pixel below",
        &[alt(Key::ArrowDown)],
        "Select the pixel below",
    )
    .within("Select a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::ClearPixel,
        m::ICON_LOCATION_OFF,
        "Clear pixel selection",
        &[],
        "Deselect the pixel and remove its cross from the views",
    )
    .within("Select a pixel"),
    entry(
        Menu::View,
        Action::ClearObject,
        m::ICON_DESELECT,
        "Clear object selection",
        &[],
        "Deselect the object and close its panel",
    ),
    entry(
        Menu::View,
        Action::Pin,
        m::ICON_KEEP,
        "Pin selected pixel",
        &[key(Key::D)],
        "Pin or unpin the selected pixel; up to eight are saved with the video and compared under Pixels",
    ),
    entry(Menu::View, Action::ClearPins, m::ICON_KEEP_OFF, "Unpin all pixels", &[], "Remove all pins"),
];
