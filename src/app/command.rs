//! What can be asked for: actions by name or key, and the commands that panels hand to [`super::apply`].

use std::path::PathBuf;

use super::ab_settings::AbSlot;
pub(crate) use super::actions::ACTIONS;
use super::areas::AreaEdit;
pub(crate) use super::entry::{Entry, Menu};
use super::event_comparison::{ComparisonFilter, EventRef};
use super::inspector::{Format, Plot, Table};
use super::overlays::Drawn;
use super::state::{Camera, Hover, Subject};
use super::views::{Background, Layout, View};
use crate::mixture::Quantity;
use crate::regions::roi::Purpose;
use crate::replay::Start;
use crate::settings::Settings;
use crate::tracking::Identity;

/// A change of the size of everything in the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Scale {
    /// By a tenth up.
    Larger,
    /// By a tenth down.
    Smaller,
    /// As the system has it.
    Usual,
}

/// Something that a person can ask for by name or key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Action {
    /// Choose a video file.
    OpenVideo,
    /// Choose a folder of images.
    OpenFolder,
    /// Open the bundled scene.
    OpenSample,
    /// Close the video, or give up opening it.
    CloseVideo,
    /// Write the annotated frame as a picture.
    ExportFrame,
    /// The frame's number and the chosen pixel, as text.
    CopyPlace,
    /// The annotated frame, as a picture.
    CopyPicture,
    /// Write the settings as a file.
    SaveSettings,
    /// Read the settings from a file.
    LoadSettings,
    /// End the program.
    Quit,
    /// Take back the last change of settings.
    Undo,
    /// Make it again.
    Redo,
    /// All settings to their defaults.
    DefaultSettings,
    /// Analyse under the settings of this slot.
    AbSlot(AbSlot),
    /// Analyse under the settings of the other slot while a key is held.
    VerdictFlip,
    /// The other slot gets a copy of the settings in view.
    CopySettings,
    /// The settings of the two slots change places.
    SwapSettings,
    /// Only the settings in view are left.
    KeepSettings,
    /// Draw an area over the views.
    DrawArea(Purpose),
    /// The area that is being drawn is whole.
    CloseArea,
    /// Take back its last corner.
    UndoCorner,
    /// Give up drawing, or choose no area any more.
    CancelArea,
    /// Take the chosen area away.
    DeleteArea,
    /// Take all areas away.
    ClearAreas,
    /// Take what is analysed from a picture.
    LoadMask,
    /// Write what is analysed as a picture.
    SaveMask,
    /// Take boxes that are known to be right from a file.
    LoadTruth,
    /// Take masks, or boxes and masks, that are known to be right from a folder.
    LoadTruthFolder,
    /// Stop the analysis beyond the frame in view, or go on with it.
    AnalyseAhead,
    /// Start or stop playing.
    Play,
    /// Go so many frames on, or back.
    Step(i32),
    /// Show a shorter part of the timeline around the frame in view, or a longer one.
    ZoomTimeline(bool),
    /// Go to the next event.
    NextEvent,
    /// Go to the event before.
    PreviousEvent,
    /// Go to the first frame.
    First,
    /// Go to the last frame that is known.
    Last,
    /// Playing begins here, or at the first frame again.
    StartHere,
    /// Playing ends here, or at the last frame again.
    EndHere,
    /// A bookmark at this frame, or none.
    Bookmark,
    /// Go to the next bookmark.
    NextBookmark,
    /// Go to the bookmark before.
    PreviousBookmark,
    /// The timeline shows the whole video.
    WholeTimeline,
    /// Play slower.
    Slower,
    /// Play faster.
    Faster,
    /// One view alone, or all again.
    Maximise(View),
    /// A view is there, or is not.
    Open(View),
    /// Views and panels in places for a purpose.
    Arrange(Layout),
    /// The whole image in each view.
    Fit,
    /// A pixel of the image takes one of the screen.
    Actual,
    /// Nearer.
    ZoomIn,
    /// Farther.
    ZoomOut,
    /// What the background view shows.
    Background,
    /// The map shows this number.
    Map(Quantity),
    /// The map shows the next number.
    NextMap,
    /// The mask over the input, or none.
    Overlay,
    /// Another opacity of the mask over the input.
    OverlayOpacity,
    /// Choose the pixel so many columns and rows away.
    MovePixel(i32, i32),
    /// No pixel chosen any more.
    ClearPixel,
    /// No object chosen any more.
    ClearObject,
    /// A loupe beside the pointer, or none.
    Loupe,
    /// The chosen pixel is pinned, or is not.
    Pin,
    /// No pixel is pinned any more.
    ClearPins,
    /// The panel with the settings.
    SettingsPanel,
    /// The panel with the inspector and the events.
    InspectorPanel,
    /// Something drawn over the tracks is there, or is not.
    Draw(Drawn),
    /// Everything in the window larger, smaller, or as large as at first.
    Scale(Scale),
    /// Dark or light.
    Theme,
    /// All that was told.
    Messages,
    /// Version, graphics card and the like.
    About,
    /// The list of keys.
    Help,
    /// Find an action by its name.
    Palette,
}

/// Something that a panel asks for.
#[derive(Clone, Debug)]
pub(crate) enum Command {
    /// Put a table on the clipboard.
    CopyTable(Table),
    /// Choose a file for a table.
    SaveTable(Table),
    /// Put a plot on the clipboard.
    CopyPlot(Box<Plot>),
    /// Choose a file for a plot.
    SavePlot(Box<Plot>, Format),
    /// An action of the table.
    Act(Action),
    /// Open this video at this place.
    Open(String, Start),
    /// The video has so many frames a second.
    Rate(f32),
    /// Take what is known to be right from this file or folder.
    ReadTruth(PathBuf),
    /// Open the bundled scene at its first occlusion.
    OpenSample,
    /// Show the frame at a position from 0.
    GoTo(u32),
    /// Show the frame of this number, or the nearest that there is.
    GoToNumber(u32),
    /// The timeline shows these positions, from and to, or all.
    Span(Option<(f32, f32)>),
    /// Play at the speed of this place in the list.
    Speed(usize),
    /// Analyse under these settings.
    Set(Box<Settings>),
    /// Choose a pixel.
    Choose(Option<(u32, u32)>),
    /// Choose an object by its identity.
    ChooseObject(Option<Identity>),
    /// Explain this in the panel on the right.
    Explain(Subject),
    /// Unpin the pixel of this number.
    Unpin(u8),
    /// Look elsewhere in all views.
    SetCamera(Camera),
    /// The pointer is on this pixel.
    Hover(Option<Hover>),
    /// Show this kind of background.
    ShowBackground(Background),
    /// The mask over the input covers so much of it, in per cent.
    Overlay(u8),
    /// Change the areas that are analysed or ignored.
    Area(AreaEdit),
    /// Bring the setting of this name into sight.
    RevealSetting(&'static str),
    /// That setting has been seen.
    SettingRevealed,
    /// The line on what to try first has been read.
    HideHint,
    /// Read an event's evidence.
    OpenEvent(Option<EventRef>),
    /// The key that brought the other settings into view was let go: these are in view again.
    LetGo(AbSlot),
    /// List these events while settings are compared.
    List(ComparisonFilter),
    /// Show or hide a kind of events, by its place in [`crate::occlusion::EventKind::ALL`].
    FilterEvents(usize, bool),
}
