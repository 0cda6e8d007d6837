//! Zoom, background and map, in the View menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{key, shift};
use crate::mixture::Quantity;

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::View,
        Action::Fit,
        m::ICON_FIT_SCREEN,
        "Fit image",
        &[key(Key::F)],
        "Fit the whole image into each view",
    )
    .after_line(),
    entry(
        Menu::View,
        Action::Actual,
        m::ICON_CROP_FREE,
        "Actual size (1:1)",
        &[key(Key::Num0)],
        "One image pixel per screen pixel, in the view under the pointer or the largest view",
    ),
    entry(
        Menu::View,
        Action::ZoomIn,
        m::ICON_ZOOM_IN,
        "Zoom in",
        &[key(Key::Plus), key(Key::Equals)],
        "Zoom in at the selected pixel or the image centre",
    )
    .repeats(),
    entry(
        Menu::View,
        Action::ZoomOut,
        m::ICON_ZOOM_OUT,
        "Zoom out",
        &[key(Key::Minus)],
        "Zoom out at the selected pixel or the image centre",
    )
    .repeats(),
    entry(
        Menu::View,
        Action::Background,
        m::ICON_LAYERS,
        "Next background display",
        &[key(Key::M)],
        "Show the mean of component 1, or the mean of all background components",
    ),
    entry(
        Menu::View,
        Action::Map(Quantity::Sigma),
        m::ICON_GRADIENT,
        "σ of component 1",
        &[],
        "Standard deviation of component 1 per pixel; large in moving leaves and water",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::Weight),
        m::ICON_GRADIENT,
        "w of component 1",
        &[],
        "Weight of component 1 per pixel: its share of recent frames",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::Used),
        m::ICON_GRADIENT,
        "Components in use",
        &[],
        "Number of the K components in use per pixel",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::BackgroundCount),
        m::ICON_GRADIENT,
        "B",
        &[],
        "Number of background components B per pixel",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::Matched),
        m::ICON_GRADIENT,
        "Matched rank",
        &[],
        "Rank of the component that this frame's value matches per pixel, or none",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::SinceForeground),
        m::ICON_GRADIENT,
        "Frames since foreground",
        &[],
        "Frames since each pixel was last foreground, before post-processing",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::NextMap,
        m::ICON_GRADIENT,
        "Next map",
        &[shift(Key::M)],
        "Map the next quantity: σ, w, components in use, B, matched rank, frames since foreground",
    ),
];
