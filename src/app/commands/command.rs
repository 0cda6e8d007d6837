//! Commands, which panels and views return.

use std::path::PathBuf;

use crate::app::commands::action::Action;
use crate::app::model::ab_settings::AbSlot;
use crate::app::model::areas::AreaEdit;
use crate::app::model::camera::{Hover, ViewCamera};
use crate::app::model::event_comparison::{ComparisonFilter, EventRef};
use crate::app::model::selection::Subject;
use crate::app::model::view::BackgroundDisplay;
use crate::replay::Start;
use crate::settings::Settings;
use crate::source::Options;
use crate::tracking::Identity;

/// A command of a panel.
#[derive(Clone, Debug)]
pub(crate) enum Command {
    /// Execute an action of the table.
    Act(Action),
    /// Open this video at this position.
    Open(String, Start),
    /// Set the video's frame rate.
    Rate(f32),
    /// Read the open video with these options.
    Read(Options),
    /// Read ground truth from this file or folder.
    ReadTruth(PathBuf),
    /// Read a sweep from its table or folder.
    ReadSweep(PathBuf),
    /// Dismiss the offer of ground truth.
    DismissTruth,
    /// Open the bundled sample at its first occlusion.
    OpenSample,
    /// Show the frame at this position, from 0.
    GoTo(u32),
    /// Show the frame of this number, or the nearest existing one.
    GoToNumber(u32),
    /// Show these positions in the timeline, from and to; `None` for all.
    Span(Option<(f32, f32)>),
    /// Play at the speed of this index.
    Speed(usize),
    /// Analyse with these settings.
    Set(Box<Settings>),
    /// Analyse with these settings in a slot.
    SetSlot(AbSlot, Box<Settings>),
    /// Choose a pixel.
    Choose(Option<(u32, u32)>),
    /// Choose an object by its identity.
    ChooseObject(Option<Identity>),
    /// Show this subject in the panel on the right.
    ShowSubject(Subject),
    /// Unpin the pixel of this number.
    Unpin(u8),
    /// Set the camera of all views.
    SetCamera(ViewCamera),
    /// The pointer moved to this pixel, or left the views.
    Hover(Option<Hover>),
    /// Show this kind of background.
    ShowBackground(BackgroundDisplay),
    /// Set the opacity of the mask over the input, in per cent.
    Overlay(u8),
    /// Edit the areas to analyse or ignore.
    Area(AreaEdit),
    /// Scroll the setting of this name into view.
    RevealSetting(&'static str),
    /// That setting was scrolled into view.
    SettingRevealed,
    /// Dismiss the hint.
    HideHint,
    /// Show the evidence of an event.
    OpenEvent(Option<EventRef>),
    /// The key that showed the other slot was released: bring this slot back into view.
    ReleaseSlot(AbSlot),
    /// List these events while settings are compared.
    FilterComparison(ComparisonFilter),
    /// Show or hide a kind of event, by its index in [`crate::occlusion::EventKind::ALL`].
    FilterEvents(usize, bool),
}
