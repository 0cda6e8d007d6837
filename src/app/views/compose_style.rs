//! The kinds of composition of a view from the layers of a frame, and their parameters.

use super::layer::ViewLayer;
use crate::regions::Rgb;

/// The kind of composition, in the order of the shader's constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Compose {
    /// The input.
    Input,
    /// The input under the mask overlay.
    Masked,
    /// The mean of component 1.
    Mean,
    /// The mean of the background components.
    Modes,
    /// A per-pixel quantity in the colours of its scale.
    Map,
    /// The mask.
    Mask,
    /// The regions in their colours over a dark input.
    Regions,
    /// The difference of the input from the mean.
    Difference,
    /// The mean of component 1 under the compared settings.
    ComparedMean,
    /// The mask of the compared settings.
    ComparedMask,
    /// Both masks in two colours over a dark input.
    Agreement,
    /// False decisions of the mask, in two colours over a dark input.
    MaskErrors,
    /// The mask and that of the external results in two colours over a dark input.
    ExternalAgreement,
    /// False decisions of the external mask, in two colours over a dark input.
    ExternalErrors,
}

impl Compose {
    /// All kinds in order.
    pub(super) const ALL: [Self; 14] = [
        Self::Input,
        Self::Masked,
        Self::Mean,
        Self::Modes,
        Self::Map,
        Self::Mask,
        Self::Regions,
        Self::Difference,
        Self::ComparedMean,
        Self::ComparedMask,
        Self::Agreement,
        Self::MaskErrors,
        Self::ExternalAgreement,
        Self::ExternalErrors,
    ];

    /// The layers that it needs.
    pub(crate) const fn layers(self) -> &'static [ViewLayer] {
        match self {
            Self::Input => &[ViewLayer::Input],
            Self::Masked => &[ViewLayer::Input, ViewLayer::Mask],
            Self::Mean => &[ViewLayer::Mean],
            Self::Modes => &[ViewLayer::Modes],
            Self::Map => &[ViewLayer::Map, ViewLayer::Palette],
            Self::Mask => &[ViewLayer::Mask],
            Self::Regions => &[ViewLayer::Input, ViewLayer::Labels, ViewLayer::Palette],
            Self::Difference => &[ViewLayer::Input, ViewLayer::Mean],
            Self::ComparedMean => &[ViewLayer::ComparedMean],
            Self::ComparedMask => &[ViewLayer::ComparedMask],
            Self::Agreement => &[ViewLayer::Input, ViewLayer::Mask, ViewLayer::ComparedMask],
            Self::MaskErrors => &[ViewLayer::Input, ViewLayer::Mask, ViewLayer::Truth],
            Self::ExternalAgreement => &[ViewLayer::Input, ViewLayer::Mask, ViewLayer::External],
            Self::ExternalErrors => &[ViewLayer::Input, ViewLayer::External, ViewLayer::Truth],
        }
    }
}

/// The parameters of a composition.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComposeStyle {
    /// The kind of composition.
    pub(crate) what: Compose,
    /// A factor of all colours.
    pub(crate) tint: f32,
    /// The colour over foreground in [`Compose::Masked`], and of pixels that are foreground only in the first mask of two:
    /// red, green, blue and opacity, each 0..=1.
    pub(crate) overlay: [f32; 4],
    /// The colour of pixels that are foreground only in the other mask, or only in the ground truth.
    pub(crate) other_colour: [f32; 4],
    /// The parameters of the colour scale of [`Compose::Map`].
    pub(crate) scale: [f32; 4],
}

impl ComposeStyle {
    /// Without tint, overlay or scale.
    pub(crate) const fn plain(what: Compose) -> Self {
        Self { what, tint: 1.0, overlay: [0.0; 4], other_colour: [0.0; 4], scale: [0.0; 4] }
    }

    /// With opaque colours for pixels of the first and of the other kind.
    pub(crate) fn in_two_colours(what: Compose, overlay: Rgb, other: Rgb) -> Self {
        let opaque = |[r, g, b]: Rgb| [r, g, b, 255].map(|channel| f32::from(channel) / 255.0);
        Self { overlay: opaque(overlay), other_colour: opaque(other), ..Self::plain(what) }
    }
}
