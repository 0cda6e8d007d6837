//! Colours of objects and regions, prepared once to be compared with many others.

use crate::regions::colour::delta_e;
use crate::regions::{Histogram, Rgb, SmoothedHistogram};
use crate::settings::{ColourMemory, Settings};

/// The colours of an object or a region.
#[derive(Clone, Debug)]
pub(crate) struct ComparableColours {
    dominant: Vec<Rgb>,
    /// Empty where the settings compare dominant colours only.
    smoothed: SmoothedHistogram,
}

impl ComparableColours {
    pub(crate) fn new(histogram: &Histogram, settings: &Settings) -> Self {
        let smoothed = match settings.colour_memory {
            ColourMemory::Frame => SmoothedHistogram::default(),
            ColourMemory::Clear => histogram.smoothed(),
        };
        Self { dominant: dominant_colours(histogram, settings), smoothed }
    }

    /// Their similarity, 0..=1.2, and the least ΔE between two of their dominant colours.
    pub(crate) fn similarity(&self, other: &Self, settings: &Settings) -> (f32, f32) {
        let pairs = self.dominant.iter().flat_map(|&a| other.dominant.iter().map(move |&b| delta_e(a, b)));
        let least = pairs.fold(f32::INFINITY, f32::min);
        let same = if least <= settings.same_colour { 1.0 } else { 0.0 };
        let similarity = match settings.colour_memory {
            ColourMemory::Frame => same,
            // Several objects often share one dominant colour, such as dark trousers; the whole histogram measures
            // the degree of similarity.
            ColourMemory::Clear => self.smoothed.likeness(&other.smoothed) + 0.2 * same,
        };
        (similarity, least)
    }
}

/// The dominant colours that the settings compare.
pub(crate) fn dominant_colours(histogram: &Histogram, settings: &Settings) -> Vec<Rgb> {
    match settings.colour_memory {
        ColourMemory::Frame => histogram.dominant().into_iter().collect(),
        ColourMemory::Clear => histogram.dominant_at_least(0.5),
    }
}
