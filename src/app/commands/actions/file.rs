//! The File menu.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::action::Action;
use crate::app::commands::entry::{ActionEntry, Menu, entry};
use crate::app::commands::shortcut::{ctrl, ctrl_shift, key, shift};

/// The entries, in menu order.
pub(super) const ENTRIES: &[ActionEntry] = &[
    entry(
        Menu::File,
        Action::OpenVideo,
        m::ICON_VIDEO_FILE,
        "Open video…",
        &[ctrl(Key::O)],
        "Open a video file: mp4, avi, mkv, mov, webm",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenFolder,
        m::ICON_FOLDER_OPEN,
        "Open folder of images…",
        &[ctrl_shift(Key::O)],
        "Open a folder of images as frames, in natural order",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenSample,
        m::ICON_MOVIE,
        "Open sample",
        &[],
        "Open the bundled scene of two people crossing, at its occlusion",
    )
    .always(),
    entry(
        Menu::File,
        Action::SourceOptions,
        m::ICON_TUNE,
        "Source options…",
        &[],
        "Frame rate, frames left out, scale and part of the images of the open video",
    )
    .always(),
    entry(
        Menu::File,
        Action::ExportFrame,
        m::ICON_PHOTO_CAMERA,
        "Export frame…",
        &[key(Key::E)],
        "Save this frame as PNG, with boxes, identities and events",
    )
    .after_line(),
    entry(
        Menu::File,
        Action::CopyPicture,
        m::ICON_CONTENT_COPY,
        "Copy frame",
        &[shift(Key::C)],
        "Copy this frame with its overlays to the clipboard",
    ),
    entry(
        Menu::File,
        Action::CopyPlace,
        m::ICON_CONTENT_PASTE,
        "Copy frame and pixel info",
        &[key(Key::C)],
        "Copy video, frame, time and the selected pixel's value as a line of text",
    ),
    entry(
        Menu::File,
        Action::SaveSettings,
        m::ICON_SAVE,
        "Save settings…",
        &[ctrl(Key::S)],
        "Save the current settings as TOML, for --settings",
    )
    .after_line()
    .always(),
    entry(
        Menu::File,
        Action::LoadSettings,
        m::ICON_UPLOAD_FILE,
        "Load settings…",
        &[],
        "Load the settings of a TOML file; missing keys get their default",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenSweep,
        m::ICON_GRID_ON,
        "Open sweep…",
        &[],
        "Show the sweep.csv of a sweep as heat maps, and load settings from their cells",
    )
    .always(),
    entry(
        Menu::File,
        Action::LoadMask,
        m::ICON_UPLOAD_FILE,
        "Load area mask…",
        &[],
        "Load an image of the video's size; only its bright pixels are analysed, as with --roi",
    )
    .after_line(),
    entry(
        Menu::File,
        Action::SaveMask,
        m::ICON_SAVE,
        "Save area mask…",
        &[],
        "Save the analysed area as a PNG mask, for --roi",
    ),
    entry(
        Menu::File,
        Action::LoadTruth,
        m::ICON_FACT_CHECK,
        "Load ground truth…",
        &[],
        "Show the boxes of a MOTChallenge gt.txt over the tracks, and score against them",
    ),
    entry(
        Menu::File,
        Action::LoadTruthFolder,
        m::ICON_FACT_CHECK,
        "Load ground truth folder…",
        &[],
        "Score against the masks of a CDnet folder, or the boxes and masks of a scene written by synth",
    ),
    entry(
        Menu::File,
        Action::LoadExternal,
        m::ICON_COMPARE,
        "Load external results…",
        &[],
        "Compare with the tracks of another method: MOTChallenge text, CVAT or CAVIAR XML, COCO JSON",
    )
    .within("External results"),
    entry(
        Menu::File,
        Action::LoadExternalFolder,
        m::ICON_COMPARE,
        "Load external results folder…",
        &[],
        "Compare with a folder of masks or of label images, or with the output folder of another run",
    )
    .within("External results"),
    entry(
        Menu::File,
        Action::CloseExternal,
        m::ICON_LAYERS_CLEAR,
        "Close external results",
        &[],
        "Drop the results of the other method",
    )
    .within("External results"),
    entry(
        Menu::File,
        Action::CloseVideo,
        m::ICON_EJECT,
        "Close video",
        &[ctrl(Key::W)],
        "Close the video, or cancel opening it",
    )
    .after_line()
    .always(),
    entry(Menu::File, Action::Quit, m::ICON_CLOSE, "Quit", &[ctrl(Key::Q)], "Exit the program").always(),
];
