//! The one table of actions, from which menus, palette, keys, tooltips and help are made.

use eframe::egui::Key;
use egui_material_icons::icons as m;

use super::ab_settings::AbSlot;
use super::command::{Action, Scale};
use super::entry::{Entry, Menu, alt, ctrl, ctrl_shift, entry, key, shift};
use super::keys::FLIP;
use super::overlays::Drawn;
use super::views::{Layout, View};
use crate::mixture::Quantity;
use crate::regions::roi::Purpose;

/// Every action, in the order of the menus.
pub(crate) static ACTIONS: &[Entry] = &[
    entry(
        Menu::File,
        Action::OpenVideo,
        m::ICON_VIDEO_FILE,
        "Open video…",
        &[ctrl(Key::O)],
        "Choose a video file: mp4, avi, mkv, mov, webm",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenFolder,
        m::ICON_FOLDER_OPEN,
        "Open folder of images…",
        &[ctrl_shift(Key::O)],
        "Choose a folder whose images are the frames, in natural order",
    )
    .always(),
    entry(
        Menu::File,
        Action::OpenSample,
        m::ICON_MOVIE,
        "Open sample",
        &[],
        "Two people cross: a bundled scene, opened at its occlusion",
    )
    .always(),
    entry(
        Menu::File,
        Action::ExportFrame,
        m::ICON_PHOTO_CAMERA,
        "Export frame…",
        &[key(Key::E)],
        "Write this frame with boxes, identities and events drawn on, as a PNG",
    )
    .after_line(),
    entry(
        Menu::File,
        Action::CopyPicture,
        m::ICON_CONTENT_COPY,
        "Copy frame",
        &[shift(Key::C)],
        "The same, to paste elsewhere",
    ),
    entry(
        Menu::File,
        Action::CopyPlace,
        m::ICON_CONTENT_PASTE,
        "Copy place",
        &[key(Key::C)],
        "Video, frame, time, and the chosen pixel with its value, as a line of text",
    ),
    entry(
        Menu::File,
        Action::SaveSettings,
        m::ICON_SAVE,
        "Save settings…",
        &[ctrl(Key::S)],
        "Write the settings in view as TOML, which --settings reads",
    )
    .after_line()
    .always(),
    entry(
        Menu::File,
        Action::LoadSettings,
        m::ICON_UPLOAD_FILE,
        "Load settings…",
        &[],
        "Take the settings of a TOML file; what it does not name has its default",
    )
    .always(),
    entry(
        Menu::File,
        Action::LoadMask,
        m::ICON_UPLOAD_FILE,
        "Load area mask…",
        &[],
        "Analyse where a picture as large as the frames is bright, as --roi does",
    )
    .after_line(),
    entry(
        Menu::File,
        Action::SaveMask,
        m::ICON_SAVE,
        "Save area mask…",
        &[],
        "Write what is analysed as a PNG, which --roi reads",
    ),
    entry(
        Menu::File,
        Action::LoadTruth,
        m::ICON_FACT_CHECK,
        "Load ground truth…",
        &[],
        "Lay the boxes of a MOTChallenge gt.txt over the tracks, and score by them",
    ),
    entry(
        Menu::File,
        Action::LoadTruthFolder,
        m::ICON_FACT_CHECK,
        "Load ground truth folder…",
        &[],
        "Score by the masks of a CDnet folder, or by boxes and masks of a scene written by synth",
    ),
    entry(
        Menu::File,
        Action::CloseVideo,
        m::ICON_EJECT,
        "Close video",
        &[ctrl(Key::W)],
        "Close the video, or give up opening it",
    )
    .after_line()
    .always(),
    entry(Menu::File, Action::Quit, m::ICON_CLOSE, "Quit", &[ctrl(Key::Q)], "End the program").always(),
    entry(
        Menu::View,
        Action::Open(View::Input),
        m::ICON_VISIBILITY,
        "Input view",
        &[],
        "Open or close the view of the input; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Background),
        m::ICON_VISIBILITY,
        "Background view",
        &[],
        "Open or close the view of the background; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Foreground),
        m::ICON_VISIBILITY,
        "Foreground view",
        &[],
        "Open or close the view of the foreground mask; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Regions),
        m::ICON_VISIBILITY,
        "Regions view",
        &[],
        "Open or close the view of the regions; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Tracks),
        m::ICON_VISIBILITY,
        "Tracks view",
        &[],
        "Open or close the view of tracks and occlusions; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Difference),
        m::ICON_VISIBILITY,
        "Difference view",
        &[],
        "Open or close the view of the difference between input and background; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Map),
        m::ICON_VISIBILITY,
        "Map view",
        &[],
        "Open or close the view that maps a number of each pixel; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::MaskErrors),
        m::ICON_VISIBILITY,
        "Right and wrong view",
        &[],
        "Open or close the view of where the mask is right by the ground truth; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::Agreement),
        m::ICON_VISIBILITY,
        "A against B view",
        &[],
        "Open or close the view of where the masks of A and B agree; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::ComparedForeground),
        m::ICON_VISIBILITY,
        "Other foreground view",
        &[],
        "Open or close the view of the mask under the settings that are not in view; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::ComparedTracks),
        m::ICON_VISIBILITY,
        "Other tracks view",
        &[],
        "Open or close the view of the objects under the settings that are not in view; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Open(View::ComparedBackground),
        m::ICON_VISIBILITY,
        "Other background view",
        &[],
        "Open or close the view of the background model under the settings that are not in view; its place is kept",
    )
    .within("Views"),
    entry(
        Menu::View,
        Action::Arrange(Layout::All),
        m::ICON_GRID_VIEW,
        "Everything",
        &[],
        "All views and panels in their first places",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(Layout::Figure),
        m::ICON_VIEW_MODULE,
        "Paper figure",
        &[],
        "Six pictures of one size, without panels: for a figure of a paper",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(Layout::Tuning),
        m::ICON_TUNE,
        "Tuning",
        &[],
        "The settings beside input, foreground and tracks",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(Layout::Compare),
        m::ICON_COMPARE,
        "Compare",
        &[],
        "The settings beside what A and B make of a frame: masks and tracks",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Arrange(Layout::Inspect),
        m::ICON_FRAME_INSPECT,
        "Inspect a pixel",
        &[],
        "A large input beside the pixel's mixture",
    )
    .within("Layout")
    .always(),
    entry(
        Menu::View,
        Action::Maximise(View::Input),
        m::ICON_FULLSCREEN,
        "Input alone",
        &[key(Key::Num1)],
        "Show the input alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Background),
        m::ICON_FULLSCREEN,
        "Background alone",
        &[key(Key::Num2)],
        "Show the background model alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Foreground),
        m::ICON_FULLSCREEN,
        "Foreground alone",
        &[key(Key::Num3)],
        "Show the foreground mask alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Regions),
        m::ICON_FULLSCREEN,
        "Regions alone",
        &[key(Key::Num4)],
        "Show the regions alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Tracks),
        m::ICON_FULLSCREEN,
        "Tracks and occlusions alone",
        &[key(Key::Num5)],
        "Show tracks and occlusions alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Difference),
        m::ICON_FULLSCREEN,
        "Difference alone",
        &[key(Key::Num6)],
        "Show how far the input is from the background alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Map),
        m::ICON_FULLSCREEN,
        "Map alone",
        &[key(Key::Num7)],
        "Show the map of a number of each pixel alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::Agreement),
        m::ICON_FULLSCREEN,
        "A against B alone",
        &[key(Key::Num8)],
        "Show where the masks of A and B agree alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::MaskErrors),
        m::ICON_FULLSCREEN,
        "Right and wrong alone",
        &[key(Key::Num9)],
        "Show where the mask is right by the ground truth alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::ComparedForeground),
        m::ICON_FULLSCREEN,
        "Other foreground alone",
        &[],
        "Show the mask under the settings that are not in view alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::ComparedTracks),
        m::ICON_FULLSCREEN,
        "Other tracks alone",
        &[],
        "Show the objects under the settings that are not in view alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Maximise(View::ComparedBackground),
        m::ICON_FULLSCREEN,
        "Other background alone",
        &[],
        "Show the background model under the settings that are not in view alone, or all views again",
    )
    .within("One view alone"),
    entry(
        Menu::View,
        Action::Fit,
        m::ICON_FIT_SCREEN,
        "Fit image",
        &[key(Key::F)],
        "Show the whole image in each view",
    )
    .after_line(),
    entry(
        Menu::View,
        Action::Actual,
        m::ICON_CROP_FREE,
        "Actual size (1:1)",
        &[key(Key::Num0)],
        "A pixel of the image takes one of the screen: in the view under the pointer, or the largest",
    ),
    entry(
        Menu::View,
        Action::ZoomIn,
        m::ICON_ZOOM_IN,
        "Zoom in",
        &[key(Key::Plus), key(Key::Equals)],
        "Nearer, at the chosen pixel or the middle",
    )
    .repeats(),
    entry(Menu::View, Action::ZoomOut, m::ICON_ZOOM_OUT, "Zoom out", &[key(Key::Minus)], "Farther").repeats(),
    entry(
        Menu::View,
        Action::Background,
        m::ICON_LAYERS,
        "Next kind of background",
        &[key(Key::M)],
        "The mean of component 1, or the mean of all background components",
    ),
    entry(
        Menu::View,
        Action::Map(Quantity::Sigma),
        m::ICON_GRADIENT,
        "σ of component 1",
        &[],
        "How far values lie around the mean of component 1 at each pixel: shaking leaves and water are wide",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::Weight),
        m::ICON_GRADIENT,
        "w of component 1",
        &[],
        "Which share of the recent frames component 1 stands for",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::Used),
        m::ICON_GRADIENT,
        "Components in use",
        &[],
        "How many of its K components each pixel has used",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::BackgroundCount),
        m::ICON_GRADIENT,
        "B",
        &[],
        "How many components are background at each pixel",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::Matched),
        m::ICON_GRADIENT,
        "Rank that matched",
        &[],
        "Which component the value of this frame matched at each pixel, or none",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::Map(Quantity::SinceForeground),
        m::ICON_GRADIENT,
        "Frames since foreground",
        &[],
        "How long ago each pixel was foreground, before cleaning: where people walk",
    )
    .within("Map of"),
    entry(
        Menu::View,
        Action::NextMap,
        m::ICON_GRADIENT,
        "Next map",
        &[shift(Key::M)],
        "Map the next number of each pixel: σ, w, components in use, B, rank that matched, frames since foreground",
    ),
    entry(
        Menu::View,
        Action::Overlay,
        m::ICON_MASKED_TRANSITIONS,
        "Mask over the input",
        &[key(Key::O)],
        "Lay the foreground over the input view, or take it off",
    ),
    entry(
        Menu::View,
        Action::OverlayOpacity,
        m::ICON_OPACITY,
        "Next opacity of the mask",
        &[shift(Key::O)],
        "Cover a quarter of the input, half, three quarters, or all",
    ),
    entry(
        Menu::View,
        Action::Loupe,
        m::ICON_LOUPE,
        "Loupe",
        &[key(Key::L)],
        "Enlarge what is around the pointer, with value and verdict; for a moment while Alt is held",
    ),
    entry(
        Menu::View,
        Action::Draw(Drawn::Trails),
        m::ICON_TIMELINE,
        "Trails",
        &[key(Key::T)],
        "Where each object has been in the frames before",
    )
    .within("Over the tracks"),
    entry(
        Menu::View,
        Action::Draw(Drawn::Gates),
        m::ICON_SCATTER_PLOT,
        "Gates",
        &[key(Key::G)],
        "Where a region may lie to belong to an object (dotted)",
    )
    .within("Over the tracks"),
    entry(
        Menu::View,
        Action::Draw(Drawn::Groups),
        m::ICON_WORKSPACES,
        "Groups",
        &[],
        "Which objects share a region (white)",
    )
    .within("Over the tracks"),
    entry(
        Menu::View,
        Action::Draw(Drawn::Occlusions),
        m::ICON_TEXTURE,
        "Occlusions",
        &[],
        "Where one object hides another, or something hides one (hatched)",
    )
    .within("Over the tracks"),
    entry(
        Menu::View,
        Action::Draw(Drawn::Names),
        m::ICON_TAG,
        "Identities",
        &[],
        "The number of each object, and its state where it is not seen",
    )
    .within("Over the tracks"),
    entry(Menu::View, Action::Draw(Drawn::Events), m::ICON_FLAG, "Events", &[], "What happens in this frame")
        .within("Over the tracks"),
    entry(
        Menu::View,
        Action::Draw(Drawn::Truth),
        m::ICON_FACT_CHECK,
        "Ground truth",
        &[],
        "The boxes of the ground truth that was loaded (white, dotted)",
    )
    .within("Over the tracks"),
    entry(
        Menu::View,
        Action::MovePixel(-1, 0),
        m::ICON_ARROW_BACK,
        "Pixel to the left",
        &[alt(Key::ArrowLeft)],
        "The pixel to the left of the chosen one; the middle of the image where none is chosen",
    )
    .within("Choose a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::MovePixel(1, 0),
        m::ICON_ARROW_FORWARD,
        "Pixel to the right",
        &[alt(Key::ArrowRight)],
        "The pixel to the right of the chosen one",
    )
    .within("Choose a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::MovePixel(0, -1),
        m::ICON_ARROW_UPWARD,
        "Pixel above",
        &[alt(Key::ArrowUp)],
        "The pixel above the chosen one",
    )
    .within("Choose a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::MovePixel(0, 1),
        m::ICON_ARROW_DOWNWARD,
        "Pixel below",
        &[alt(Key::ArrowDown)],
        "The pixel below the chosen one",
    )
    .within("Choose a pixel")
    .repeats(),
    entry(
        Menu::View,
        Action::ClearPixel,
        m::ICON_LOCATION_OFF,
        "Clear chosen pixel",
        &[],
        "Take the cross off the views",
    )
    .within("Choose a pixel"),
    entry(
        Menu::View,
        Action::ClearObject,
        m::ICON_DESELECT,
        "Choose no object",
        &[],
        "Close the panel about the chosen object",
    ),
    entry(
        Menu::View,
        Action::Pin,
        m::ICON_KEEP,
        "Pin chosen pixel",
        &[key(Key::D)],
        "Pin the chosen pixel, or unpin it: up to eight, kept with the video and compared under Pixels",
    ),
    entry(
        Menu::View,
        Action::ClearPins,
        m::ICON_KEEP_OFF,
        "Unpin all pixels",
        &[],
        "Take all pins off the views",
    ),
    entry(
        Menu::View,
        Action::SettingsPanel,
        m::ICON_TUNE,
        "Settings panel",
        &[],
        "Show or hide the settings on the left",
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
        Action::Scale(Scale::Larger),
        m::ICON_TEXT_INCREASE,
        "Larger text",
        &[ctrl(Key::Plus), ctrl(Key::Equals)],
        "All text and controls larger, for a fine screen or from afar",
    )
    .within("Text and controls")
    .always()
    .repeats(),
    entry(
        Menu::View,
        Action::Scale(Scale::Smaller),
        m::ICON_TEXT_DECREASE,
        "Smaller text",
        &[ctrl(Key::Minus)],
        "All text and controls smaller",
    )
    .within("Text and controls")
    .always()
    .repeats(),
    entry(
        Menu::View,
        Action::Scale(Scale::Usual),
        m::ICON_FORMAT_SIZE,
        "Usual size of text",
        &[ctrl(Key::Num0)],
        "All text and controls as large as the system has them",
    )
    .within("Text and controls")
    .always(),
    entry(
        Menu::View,
        Action::Theme,
        m::ICON_CONTRAST,
        "Dark or light",
        &[],
        "Change between dark and light colours",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::Play,
        m::ICON_PLAY_ARROW,
        "Play or pause",
        &[key(Key::Space)],
        "Play at the video's frame rate times the speed, or stop",
    ),
    entry(
        Menu::Analysis,
        Action::Step(1),
        m::ICON_CHEVRON_RIGHT,
        "Next frame",
        &[key(Key::ArrowRight), key(Key::Period)],
        "One frame on",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(-1),
        m::ICON_CHEVRON_LEFT,
        "Previous frame",
        &[key(Key::ArrowLeft), key(Key::Comma)],
        "One frame back",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(10),
        m::ICON_KEYBOARD_DOUBLE_ARROW_RIGHT,
        "Ten frames on",
        &[shift(Key::ArrowRight)],
        "Ten frames on",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::Step(-10),
        m::ICON_KEYBOARD_DOUBLE_ARROW_LEFT,
        "Ten frames back",
        &[shift(Key::ArrowLeft)],
        "Ten frames back",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::NextEvent,
        m::ICON_FLAG,
        "Next event",
        &[ctrl(Key::ArrowRight), key(Key::N)],
        "To the next event of the kinds that the list shows",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::PreviousEvent,
        m::ICON_FLAG,
        "Previous event",
        &[ctrl(Key::ArrowLeft), key(Key::P)],
        "To the event before",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::First,
        m::ICON_FIRST_PAGE,
        "First frame",
        &[key(Key::Home)],
        "To the first frame",
    ),
    entry(
        Menu::Analysis,
        Action::Last,
        m::ICON_LAST_PAGE,
        "Last frame",
        &[key(Key::End)],
        "To the last frame that is known",
    ),
    entry(
        Menu::Analysis,
        Action::Slower,
        m::ICON_FAST_REWIND,
        "Slower",
        &[key(Key::OpenBracket)],
        "Play at half the speed",
    ),
    entry(
        Menu::Analysis,
        Action::Faster,
        m::ICON_FAST_FORWARD,
        "Faster",
        &[key(Key::CloseBracket)],
        "Play at twice the speed",
    ),
    entry(
        Menu::Analysis,
        Action::StartHere,
        m::ICON_START,
        "Play from here",
        &[shift(Key::Home)],
        "Playing begins at this frame; the same again takes that back",
    )
    .within("Marks")
    .after_line(),
    entry(
        Menu::Analysis,
        Action::EndHere,
        m::ICON_KEYBOARD_TAB,
        "Play up to here",
        &[shift(Key::End)],
        "Playing begins again after this frame; the same again takes that back",
    )
    .within("Marks"),
    entry(
        Menu::Analysis,
        Action::Bookmark,
        m::ICON_BOOKMARK,
        "Bookmark",
        &[key(Key::K)],
        "Set a bookmark at this frame, or take it away",
    )
    .within("Marks"),
    entry(
        Menu::Analysis,
        Action::NextBookmark,
        m::ICON_BOOKMARKS,
        "Next bookmark",
        &[shift(Key::N)],
        "To the next bookmark",
    )
    .within("Marks")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::PreviousBookmark,
        m::ICON_BOOKMARKS,
        "Previous bookmark",
        &[shift(Key::P)],
        "To the bookmark before",
    )
    .within("Marks")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::WholeTimeline,
        m::ICON_ZOOM_OUT_MAP,
        "Whole timeline",
        &[shift(Key::F)],
        "Show all frames in the timeline; the wheel over it zooms, Shift and the wheel pan",
    ),
    entry(
        Menu::Analysis,
        Action::ZoomTimeline(true),
        m::ICON_ZOOM_IN,
        "Zoom into the timeline",
        &[alt(Key::Plus), alt(Key::Equals)],
        "Half as many frames, around the one in view",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::ZoomTimeline(false),
        m::ICON_ZOOM_OUT,
        "Zoom out of the timeline",
        &[alt(Key::Minus)],
        "Twice as many frames",
    )
    .repeats(),
    entry(
        Menu::Analysis,
        Action::AnalyseAhead,
        m::ICON_STOP_CIRCLE,
        "Stop the analysis, or go on",
        &[shift(Key::Space)],
        "Analyse the whole video in the background, or only what is looked at",
    )
    .after_line(),
    entry(
        Menu::Analysis,
        Action::Undo,
        m::ICON_UNDO,
        "Undo",
        &[ctrl(Key::Z)],
        "Take the last change of settings or areas back",
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
        "Make it again",
    )
    .always()
    .repeats(),
    entry(
        Menu::Analysis,
        Action::DefaultSettings,
        m::ICON_RESTART_ALT,
        "All settings to defaults",
        &[],
        "Take the preset `default`",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::AbSlot(AbSlot::A),
        m::ICON_COMPARE,
        "Settings A",
        &[key(Key::A)],
        "Analyse under the first of two sets of settings",
    )
    .after_line()
    .always(),
    entry(
        Menu::Analysis,
        Action::AbSlot(AbSlot::B),
        m::ICON_COMPARE,
        "Settings B",
        &[key(Key::B)],
        "Analyse under the second; it begins as a copy of A",
    )
    .always(),
    entry(
        Menu::Analysis,
        Action::VerdictFlip,
        m::ICON_SYNC_ALT,
        "Flip A and B while held",
        &[key(FLIP)],
        "Hold the key to look at the other settings, let go to come back",
    ),
    entry(
        Menu::Analysis,
        Action::CopySettings,
        m::ICON_CONTENT_COPY,
        "Copy settings to the other slot",
        &[],
        "A and B become equal to what is in view",
    ),
    entry(
        Menu::Analysis,
        Action::SwapSettings,
        m::ICON_SWAP_HORIZ,
        "Swap A and B",
        &[],
        "What was A is B and the other way round; the slot in view stays",
    ),
    entry(
        Menu::Analysis,
        Action::KeepSettings,
        m::ICON_DONE,
        "Keep the settings in view alone",
        &[],
        "They become A; the others are given up",
    ),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Ignore),
        m::ICON_DRAW,
        "Draw area to ignore",
        &[key(Key::I)],
        "Foreground inside is taken away: click corners, or drag a rectangle, over any view",
    )
    .within("Area")
    .after_line(),
    entry(
        Menu::Analysis,
        Action::DrawArea(Purpose::Analyse),
        m::ICON_SELECT_ALL,
        "Draw area to analyse",
        &[shift(Key::I)],
        "Foreground outside of all such areas is taken away",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::CloseArea,
        m::ICON_CHECK,
        "Close the area that is drawn",
        &[key(Key::Enter)],
        "Join its last corner to the first",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::UndoCorner,
        m::ICON_BACKSPACE,
        "Take back the last corner",
        &[key(Key::Backspace)],
        "One corner less of the area that is drawn",
    )
    .within("Area")
    .repeats(),
    entry(
        Menu::Analysis,
        Action::CancelArea,
        m::ICON_CANCEL,
        "Give up the area that is drawn",
        &[key(Key::Escape)],
        "Draw no area, and choose none",
    )
    .within("Area"),
    entry(
        Menu::Analysis,
        Action::DeleteArea,
        m::ICON_DELETE,
        "Delete chosen area",
        &[key(Key::Delete)],
        "An area is chosen by a click on its outline, or in the list",
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
        "Find an action…",
        &[ctrl(Key::K)],
        "Find an action by its name",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Help,
        m::ICON_KEYBOARD,
        "Keys and pointer",
        &[key(Key::Questionmark), key(Key::F1)],
        "All keys, and what the pointer does",
    )
    .always(),
    entry(
        Menu::Help,
        Action::Messages,
        m::ICON_LIST_ALT,
        "Messages",
        &[],
        "All that was told since the start",
    )
    .always(),
    entry(
        Menu::Help,
        Action::About,
        m::ICON_INFO,
        "About Occluscope",
        &[],
        "Version, graphics card, OpenCV, threads: for a report",
    )
    .after_line()
    .always(),
];

impl Action {
    /// All that is said of it.
    pub(crate) fn entry(self) -> Option<&'static Entry> {
        ACTIONS.iter().find(|entry| entry.action == self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use eframe::egui::Modifiers;

    use super::*;

    #[test]
    fn no_two_actions_share_a_key_a_name_or_a_meaning() {
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
    fn shift_and_ctrl_tell_shortcuts_apart() {
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

    /// The keys in the first cell of a row of the README's table, written as in the menus.
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
    fn the_readme_lists_the_keys_that_there_are() {
        let rows = include_str!("../../README.md").lines().filter(|line| line.starts_with("| <kbd>"));
        let listed: Vec<String> = rows.flat_map(|row| keys_of(row.split('|').nth(1).unwrap())).collect();
        let texts = |entry: &Entry| entry.shortcuts.iter().map(|key| key.text()).collect::<Vec<_>>();
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
