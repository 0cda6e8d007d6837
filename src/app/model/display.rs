//! What the views and the panels show.

use crate::app::model::camera::ViewCamera;
use crate::app::model::overlays::{MaskOverlay, TrackOverlays};
use crate::app::model::view::{BackgroundDisplay, View};
use crate::mixture::Quantity;

/// What the views show.
#[derive(Clone, Debug)]
pub(crate) struct Display {
    /// The camera of all views.
    pub(crate) camera: ViewCamera,
    /// The maximised view.
    pub(crate) maximised: Option<View>,
    /// Which views are open, in the order of [`View::ALL`].
    pub(crate) open: [bool; View::ALL.len()],
    /// What the background view shows.
    pub(crate) background: BackgroundDisplay,
    /// The quantity that the map view shows.
    pub(crate) quantity: Quantity,
    /// The mask over the input.
    pub(crate) overlay: MaskOverlay,
    /// The overlays of the tracks view.
    pub(crate) track_overlays: TrackOverlays,
    /// Whether the loupe is on.
    pub(crate) loupe: bool,
}

impl Display {
    /// The initial state.
    pub(super) fn new() -> Self {
        Self {
            camera: ViewCamera::FIT,
            maximised: None,
            open: [true; View::ALL.len()],
            background: BackgroundDisplay::Mean,
            // Under the defaults σ is at its floor nearly everywhere, and its map would be uniform.
            quantity: Quantity::Weight,
            overlay: MaskOverlay { on: false, opacity: 50 },
            track_overlays: TrackOverlays::default(),
            loupe: false,
        }
    }
}

/// What the panels show.
#[derive(Clone, Debug)]
pub(crate) struct PanelState {
    /// Whether the settings panel is open.
    pub(crate) settings: bool,
    /// Whether the inspector panel is open.
    pub(crate) inspector: bool,
    /// Whether the hint is still to be shown.
    pub(crate) hint: bool,
    /// The setting to scroll into view.
    pub(crate) revealed_setting: Option<&'static str>,
    /// The visible positions of the timeline, from and to; `None` for all.
    pub(crate) timeline_span: Option<(f32, f32)>,
}

impl PanelState {
    /// The initial state.
    pub(super) const fn new() -> Self {
        Self { settings: true, inspector: true, hint: true, revealed_setting: None, timeline_span: None }
    }
}
