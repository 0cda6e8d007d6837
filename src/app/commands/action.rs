//! Actions: what can be called by name or shortcut.

use crate::app::model::ab_settings::AbSlot;
use crate::app::model::layout::ViewLayout;
use crate::app::model::overlays::TrackOverlay;
use crate::app::model::view::View;
use crate::mixture::Quantity;
use crate::regions::roi::Purpose;

/// A change of the user interface's scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum UiScale {
    /// Larger by a tenth.
    Larger,
    /// Smaller by a tenth.
    Smaller,
    /// The scale of the system.
    Usual,
}

/// An action of the table, called by name or shortcut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Action {
    /// Choose a video file.
    OpenVideo,
    /// Choose a folder of images.
    OpenFolder,
    /// Open the bundled scene.
    OpenSample,
    /// Change how the source is read.
    SourceOptions,
    /// Close the video, or cancel opening it.
    CloseVideo,
    /// Write the annotated frame to a file.
    ExportFrame,
    /// Copy video, frame, time and chosen pixel as text.
    CopyPlace,
    /// Copy the annotated frame as an image.
    CopyPicture,
    /// Write the settings to a file.
    SaveSettings,
    /// Read the settings from a file.
    LoadSettings,
    /// Read the table of a sweep and show its maps.
    OpenSweep,
    /// End the program.
    Quit,
    /// Undo the last edit.
    Undo,
    /// Redo the last undone edit.
    Redo,
    /// Reset all settings to their defaults.
    DefaultSettings,
    /// Bring the settings of this slot into view.
    AbSlot(AbSlot),
    /// Show the other slot while a key is held.
    FlipSettings,
    /// Copy the settings in view to the other slot.
    CopySettings,
    /// Swap the settings of the two slots.
    SwapSettings,
    /// Keep only the settings in view.
    KeepSettings,
    /// Start drawing an area.
    DrawArea(Purpose),
    /// Complete the area that is being drawn.
    CloseArea,
    /// Remove its last corner.
    UndoCorner,
    /// Cancel drawing, or clear the selection of an area.
    CancelArea,
    /// Delete the selected area.
    DeleteArea,
    /// Delete all areas.
    ClearAreas,
    /// Read the region of interest from an image.
    LoadMask,
    /// Write the region of interest as an image.
    SaveMask,
    /// Read ground-truth boxes from a file.
    LoadTruth,
    /// Read ground-truth masks, or boxes and masks, from a folder.
    LoadTruthFolder,
    /// Read external tracks from a file.
    LoadExternal,
    /// Read external masks, label images or the output of a run from a folder.
    LoadExternalFolder,
    /// Drop the external results.
    CloseExternal,
    /// Pause the analysis beyond the frame in view, or resume it.
    AnalyseAhead,
    /// Start or stop playing.
    Play,
    /// Go this many frames forward, or back if negative.
    Step(i32),
    /// Zoom the timeline around the frame in view: in if true, else out.
    ZoomTimeline(bool),
    /// Go to the next event.
    NextEvent,
    /// Go to the previous event.
    PreviousEvent,
    /// Go to the first frame.
    First,
    /// Go to the last known frame.
    Last,
    /// Set the start of playback at this frame, or clear it.
    StartHere,
    /// Set the end of playback at this frame, or clear it.
    EndHere,
    /// Add or remove a bookmark at this frame.
    Bookmark,
    /// Go to the next bookmark.
    NextBookmark,
    /// Go to the previous bookmark.
    PreviousBookmark,
    /// Show the whole video in the timeline.
    WholeTimeline,
    /// Play slower.
    Slower,
    /// Play faster.
    Faster,
    /// Maximise a view, or restore all views.
    Maximise(View),
    /// Open or close a view.
    Open(View),
    /// Arrange views and panels in a layout.
    Arrange(ViewLayout),
    /// Fit the whole image into each view.
    Fit,
    /// Draw each image pixel as one screen pixel.
    Actual,
    /// Zoom in.
    ZoomIn,
    /// Zoom out.
    ZoomOut,
    /// Show the next kind of background.
    Background,
    /// Show the map of this quantity.
    Map(Quantity),
    /// Show the map of the next quantity.
    NextMap,
    /// Show or hide the mask over the input.
    Overlay,
    /// Use the next opacity of the mask over the input.
    OverlayOpacity,
    /// Move the chosen pixel by columns and rows.
    MovePixel(i32, i32),
    /// Clear the choice of a pixel.
    ClearPixel,
    /// Clear the choice of an object.
    ClearObject,
    /// Show or hide the loupe beside the pointer.
    Loupe,
    /// Pin or unpin the chosen pixel.
    Pin,
    /// Unpin all pixels.
    ClearPins,
    /// Show or hide the settings panel.
    SettingsPanel,
    /// Show or hide the panel with inspector and events.
    InspectorPanel,
    /// Show or hide an overlay of the tracks view.
    Draw(TrackOverlay),
    /// Change the scale of the user interface.
    Scale(UiScale),
    /// Switch between the dark and the light theme.
    Theme,
    /// Show or hide the messages.
    Messages,
    /// Show or hide the About dialog.
    About,
    /// Show or hide the list of shortcuts.
    Help,
    /// Open or close the command palette.
    Palette,
}
