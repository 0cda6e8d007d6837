//! The content of each view, and the value of a pixel in it.

use super::agreement::AgreementContent;
use super::background::BackgroundContent;
use super::compared::{ComparedBackgroundContent, ComparedForegroundContent, ComparedTracksContent};
use super::difference::DifferenceContent;
use super::external_masks::{ExternalAgreementContent, ExternalErrorsContent};
use super::foreground::ForegroundContent;
use super::input::InputContent;
use super::map::MapContent;
use super::mask_errors::MaskErrorsContent;
use super::pane::ViewContent;
use super::regions::RegionsContent;
use super::tracks::TracksContent;
use crate::app::model::Model;
use crate::app::model::view::View;
use crate::replay::ShownFrame;

/// The content of a view.
pub(super) const fn content(view: View) -> &'static dyn ViewContent {
    match view {
        View::Input => &InputContent,
        View::Background => &BackgroundContent,
        View::Foreground => &ForegroundContent,
        View::Regions => &RegionsContent,
        View::Tracks => &TracksContent,
        View::Difference => &DifferenceContent,
        View::Map => &MapContent,
        View::ComparedBackground => &ComparedBackgroundContent,
        View::ComparedForeground => &ComparedForegroundContent,
        View::ComparedTracks => &ComparedTracksContent,
        View::Agreement => &AgreementContent,
        View::MaskErrors => &MaskErrorsContent,
        View::ExternalAgreement => &ExternalAgreementContent,
        View::ExternalErrors => &ExternalErrorsContent,
    }
}

/// The value of a pixel in a view, with parts separated by spaces.
pub(crate) fn pixel_value(view: View, model: &Model, shown: &ShownFrame, at: (u32, u32)) -> String {
    content(view).value(model, shown, at)
}
