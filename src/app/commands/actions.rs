//! The table of actions, from which menus, command palette, shortcuts, tooltips and help are made.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use crate::app::commands::command::{Action, UiScale};
use crate::app::commands::entry::{ActionEntry, Menu, alt, ctrl, ctrl_shift, entry, key, shift};
use crate::app::commands::keys::FLIP_KEY;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::layout::ViewLayout;
use crate::app::model::overlays::TrackOverlay;
use crate::app::model::view::View;
use crate::mixture::Quantity;
use crate::regions::roi::Purpose;

/// All actions, in menu order.
pub(crate) static ACTIONS: &[ActionEntry] = &[
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
        Action::LoadMask,
        m::ICON_UPLOAD_FILE,
        "Load area mask…",
        &[],
        "Load an image of the frame size; only its bright pixels are analysed, as with --roi",
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
        Action::CloseVideo,
        m::ICON_EJECT,
        "Close video",
        &[ctrl(Key::W)],
        "Close the video, or cancel opening it",
    )
    .after_line()
    .always(),
    entry(Menu::File, Action::Quit, m::ICON_CLOSE, "Quit", &[ctrl(Key::Q)], "Exit the program").always(),
    entry(
        Menu::View,
        Action::Open(View::Input),
        m::ICON_VISIBILITY,
        "Input view",
        &[],
        "Show or hide the input view; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Background),
        m::ICON_VISIBILITY,
        "Background view",
        &[],
        "Show or hide the background view; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Foreground),
        m::ICON_VISIBILITY,
        "Foreground view",
        &[],
        "Show or hide the foreground mask view; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Regions),
        m::ICON_VISIBILITY,
        "Regions view",
        &[],
        "Show or hide the regions view; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Tracks),
        m::ICON_VISIBILITY,
        "Tracks view",
        &[],
        "Show or hide the tracks and occlusions view; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Difference),
        m::ICON_VISIBILITY,
        "Difference view",
        &[],
        "Show or hide the difference between input and background; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Map),
        m::ICON_VISIBILITY,
        "Map view",
        &[],
        "Show or hide the map of a per-pixel quantity; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::MaskErrors),
        m::ICON_VISIBILITY,
        "Mask errors view",
        &[],
        "Show or hide the mask errors (TP, FP, FN) against the ground truth; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Agreement),
        m::ICON_VISIBILITY,
        "A vs B difference view",
        &[],
        "Show or hide the difference between the masks of A and B; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::ComparedForeground),
        m::ICON_VISIBILITY,
        "Foreground (B) view",
        &[],
        "Show or hide the foreground mask under the other settings; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::ComparedTracks),
        m::ICON_VISIBILITY,
        "Tracks (B) view",
        &[],
        "Show or hide the tracks under the other settings; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::ComparedBackground),
        m::ICON_VISIBILITY,
        "Background (B) view",
        &[],
        "Show or hide the background model under the other settings; its position is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::All),
        m::ICON_GRID_VIEW,
        "Default layout",
        &[],
        "Reset all views and panels to their default positions",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Figure),
        m::ICON_VIEW_MODULE,
        "Paper figure",
        &[],
        "Six views of equal size without panels, for a figure in a paper",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Tuning),
        m::ICON_TUNE,
        "Tuning",
        &[],
        "Settings panel with input, foreground and tracks",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Compare),
        m::ICON_COMPARE,
        "Compare",
        &[],
        "Settings panel with masks and tracks under A and B",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(ViewLayout::Inspect),
        m::ICON_FRAME_INSPECT,
        "Inspect a pixel",
        &[],
        "Large input view with the pixel inspector",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Maximise(View::Input),
        m::ICON_FULLSCREEN,
        "Input alone",
        &[key(Key::Num1)],
        "Maximise the input view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Background),
        m::ICON_FULLSCREEN,
        "Background alone",
        &[key(Key::Num2)],
        "Maximise the background view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Foreground),
        m::ICON_FULLSCREEN,
        "Foreground alone",
        &[key(Key::Num3)],
        "Maximise the foreground view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Regions),
        m::ICON_FULLSCREEN,
        "Regions alone",
        &[key(Key::Num4)],
        "Maximise the regions view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Tracks),
        m::ICON_FULLSCREEN,
        "Tracks and occlusions alone",
        &[key(Key::Num5)],
        "Maximise the tracks view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Difference),
        m::ICON_FULLSCREEN,
        "Difference alone",
        &[key(Key::Num6)],
        "Maximise the difference view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Map),
        m::ICON_FULLSCREEN,
        "Map alone",
        &[key(Key::Num7)],
        "Maximise the map view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Agreement),
        m::ICON_FULLSCREEN,
        "A vs B difference alone",
        &[key(Key::Num8)],
        "Maximise the A vs B difference, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::MaskErrors),
        m::ICON_FULLSCREEN,
        "Mask errors alone",
        &[key(Key::Num9)],
        "Maximise the mask errors view, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::ComparedForeground),
        m::ICON_FULLSCREEN,
        "Foreground (B) alone",
        &[],
        "Maximise the foreground mask under the other settings, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::ComparedTracks),
        m::ICON_FULLSCREEN,
        "Tracks (B) alone",
        &[],
        "Maximise the tracks under the other settings, or restore all views",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::ComparedBackground),
        m::ICON_FULLSCREEN,
        "Background (B) alone",
        &[],
        "Maximise the background under the other settings, or restore all views",
    )
    .within("One view alone"),
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
    entry(
        Menu::View,
        Action::SettingsPanel,
        m::ICON_TUNE,
        "Settings panel",
        &[],
        "Show or hide the settings panel on the left",
    )
    .after_line()
    .always(),
    entry(
        Menu::View,
        Action::InspectorPanel,
        m::ICON_FRAME_INSPECT,
        "Inspector and events",
        &[],
        "Show or hide the panel on the right",
    )
    .always(),
    entry(
        Menu::View,
        Action::Scale(UiScale::Larger),
        m::ICON_TEXT_INCREASE,
        "Larger text",
        &[ctrl(Key::Plus), ctrl(Key::Equals)],
        "Increase the size of text and controls",
    )
    .within("Text and controls")
    .always()
    .repeats(),
    entry(
        Menu::View,
        Action::Scale(UiScale::Smaller),
        m::ICON_TEXT_DECREASE,
        "Smaller text",
        &[ctrl(Key::Minus)],
        "Decrease the size of text and controls",
    )
    .within("Text and controls")
    .always()
    .repeats(),
    entry(
        Menu::View,
        Action::Scale(UiScale::Usual),
        m::ICON_FORMAT_SIZE,
        "Default text size",
        &[ctrl(Key::Num0)],
        "Reset text and controls to the system's size",
    )
    .within("Text and controls")
    .always(),
    entry(
        Menu::View,
        Action::Theme,
        m::ICON_CONTRAST,
        "Dark or light theme",
        &[],
        "Switch between the dark and the light theme",
    )
    .always(),
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
        "Go to the last analysed frame",
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
    entry(
        Menu::Analysis,
        Action::Undo,
        m::ICON_UNDO,
        "Undo",
        &[ctrl(Key::Z)],
        "Undo the last change of settings or areas",
    )
    .after_line()
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Redo,
        m::ICON_REDO,
        "Redo",
        &[ctrl_shift(Key::Z), ctrl(Key::Y)],
        "Redo the last undone change",
    )
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::DefaultSettings,
        m::ICON_RESTART_ALT,
        "Reset all settings",
        &[],
        "Set all settings to the preset `default`",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::AbSlot(AbSlot::A),
        m::ICON_COMPARE,
        "Settings A",
        &[key(Key::A)],
        "Show results under settings A",
    )
    .after_line()
    .always(),
    entry(
        Menu::Analysis,
        Action::AbSlot(AbSlot::B),
        m::ICON_COMPARE,
        "Settings B",
        &[key(Key::B)],
        "Show results under settings B; B starts as a copy of A",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::FlipSettings,
        m::ICON_SYNC_ALT,
        "Swap A and B while held",
        &[key(FLIP_KEY)],
        "Show the other settings while the key is held",
    ),
    entry(
        Menu::Analysis,
        Action::CopySettings,
        m::ICON_CONTENT_COPY,
        "Copy to other settings",
        &[],
        "Set both A and B to the current settings",
    ),
    entry(
        Menu::Analysis,
        Action::SwapSettings,
        m::ICON_SWAP_HORIZ,
        "Swap A and B",
        &[],
        "Exchange A and B; the current slot stays",
    ),
    entry(
        Menu::Analysis,
        Action::KeepSettings,
        m::ICON_DONE,
        "Keep current settings only",
        &[],
        "Keep the current settings as A and discard the others",
    ),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Ignore),
        m::ICON_DRAW,
        "Draw ignore area",
        &[key(Key::I)],
        "Exclude an area from analysis: click corners or drag a rectangle in any view",
    )
    .within("Area")
    .after_line(),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Analyse),
        m::ICON_SELECT_ALL,
        "Draw analysis area",
        &[shift(Key::I)],
        "Restrict analysis to such areas",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::CloseArea,
        m::ICON_CHECK,
        "Close area outline",
        &[key(Key::Enter)],
        "Connect the last corner to the first",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::UndoCorner,
        m::ICON_BACKSPACE,
        "Remove last corner",
        &[key(Key::Backspace)],
        "Remove the last corner of the area being drawn",
    )
    .within("Area")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::CancelArea,
        m::ICON_CANCEL,
        "Cancel drawing",
        &[key(Key::Escape)],
        "Cancel the area being drawn and clear the area selection",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::DeleteArea,
        m::ICON_DELETE,
        "Delete selected area",
        &[key(Key::Delete)],
        "Delete the selected area; select one by clicking its outline or the list",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::ClearAreas,
        m::ICON_DELETE_SWEEP,
        "Clear all areas",
        &[],
        "Analyse the whole image again",
    )
    .within("Area"),
    entry(
        Menu::Help,
        Action::Palette,
        m::ICON_SEARCH,
        "Command palette…",
        &[ctrl(Key::K)],
        "Find an action or a setting by name",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Help,
        m::ICON_KEYBOARD,
        "Keyboard and mouse",
        &[key(Key::Questionmark), key(Key::F1)],
        "List all keyboard and mouse controls",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Messages,
        m::ICON_LIST_ALT,
        "Messages",
        &[],
        "All messages since the program started",
    )
    .always(),
    entry(
        Menu::Help,
        Action::About,
        m::ICON_INFO,
        "About Occluscope",
        &[],
        "Version, graphics card, OpenCV and threads, for bug reports",
    )
    .after_line()
    .always(),
];

impl Action {
    /// The action's entry in the table.
    pub(crate) fn entry(self) -> Option<&'static ActionEntry> {
        ACTIONS.iter().find(|entry| entry.action == self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use eframe::egui::Modifiers;

    use super::*;

    #[test]
    fn no_two_actions_share_a_shortcut_a_name_or_an_action() {
        for (i, a) in ACTIONS.iter().enumerate() {
            for b in &ACTIONS[i + 1..] {
                assert_ne!(a.action, b.action);
                assert_ne!(a.text, b.text);
                for shortcut in a.shortcuts {
                    assert!(
                        !b.shortcuts.contains(shortcut),
                        "{} of {} and {}",
                        shortcut.text(),
                        a.text,
                        b.text
                    );
                }
            }
        }
    }

    #[test]
    fn shift_and_ctrl_distinguish_shortcuts() {
        let press = |key, modifiers| {
            ACTIONS
                .iter()
                .filter(|entry| entry.shortcuts.iter().any(|shortcut| shortcut.matches(key, modifiers)))
                .map(|entry| entry.action)
                .collect::<Vec<_>>()
        };
        assert_eq!(press(Key::ArrowRight, Modifiers::NONE), [Action::Step(1)]);
        assert_eq!(press(Key::ArrowRight, Modifiers::SHIFT), [Action::Step(10)]);
        assert_eq!(press(Key::ArrowRight, Modifiers::COMMAND | Modifiers::CTRL), [Action::NextEvent]);
        assert_eq!(press(Key::Questionmark, Modifiers::SHIFT), [Action::Help]);
        assert_eq!(press(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT), [Action::Redo]);
        assert_eq!(press(Key::ArrowRight, Modifiers::ALT), [Action::MovePixel(1, 0)]);
        assert!(press(Key::F, Modifiers::ALT).is_empty());
    }

    /// The shortcuts in the first cell of a row of the README's table, written as in the menus.
    fn keys_of(cell: &str) -> Vec<String> {
        let mut keys: Vec<String> = Vec::new();
        let mut before = String::new();
        for part in cell.split("<kbd>").skip(1) {
            let (name, after) = part.split_once("</kbd>").unwrap();
            let name = match name {
                "←" => "Left",
                "→" => "Right",
                "↑" => "Up",
                "↓" => "Down",
                name => name,
            };
            if after == "+" {
                before = format!("{before}{name}+");
                continue;
            }
            if let Some(first) = keys.pop_if(|key| key.ends_with('–')) {
                let numbers = first.trim_end_matches('–').parse::<u32>().unwrap()..=name.parse().unwrap();
                keys.extend(numbers.map(|number| number.to_string()));
            } else {
                let range = if after == "–" { "–" } else { "" };
                keys.push(format!("{before}{name}{range}"));
            }
            before.clear();
        }
        keys
    }

    #[test]
    fn the_readme_lists_every_shortcut() {
        let rows = include_str!("../../../README.md").lines().filter(|line| line.starts_with("| <kbd>"));
        let listed: Vec<String> = rows.flat_map(|row| keys_of(row.split('|').nth(1).unwrap())).collect();
        let texts = |entry: &ActionEntry| entry.shortcuts.iter().map(|key| key.text()).collect::<Vec<_>>();
        for key in &listed {
            let does = ACTIONS.iter().filter(|entry| texts(entry).contains(key)).count();
            assert_eq!(does, 1, "{key} is in the README and calls {does} actions");
            assert_eq!(listed.iter().filter(|other| *other == key).count(), 1, "{key} is listed twice");
        }
        for entry in ACTIONS.iter().filter(|entry| !entry.shortcuts.is_empty()) {
            let texts = texts(entry);
            assert!(texts.iter().any(|key| listed.contains(key)), "{} {texts:?} is not listed", entry.text);
        }
    }

    #[test]
    fn every_action_of_the_keyboard_has_an_entry() {
        for action in [
            Action::Play,
            Action::Step(-10),
            Action::Maximise(View::Tracks),
            Action::AbSlot(AbSlot::B),
            Action::Palette,
        ] {
            assert_eq!(action.entry().unwrap().action, action);
        }
    }
}
