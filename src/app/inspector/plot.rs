//! Plots that can be exported.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use super::chosen_pixel::SlottedHistory;
use super::table::{Table, borrowed};
use crate::app::files::atomic_write;
use crate::explain::pixel::region_shares::RegionShares;
use crate::explain::pixel::{PixelHistory, scatter_points};
use crate::explain::tuning::{RegionTuning, Tuning};
use crate::export::figure::cube::{self, Look};
use crate::export::figure::mixture::{self, UpdateSide};
use crate::export::figure::{Figure, pdf, pins, raster, region, scatter, svg, through_time, tuning};
use crate::frame::Frame;
use crate::truth::decisions::Measure;

/// A plot as drawn in the window. Its figure is made only on request, on another thread.
#[derive(Clone, Debug, PartialEq)]
pub enum Plot {
    /// The densities at a position.
    Densities(SlottedHistory, usize, UpdateSide),
    /// The weights at a position.
    Weights(SlottedHistory, usize, UpdateSide),
    /// Values and mixture through time.
    History(SlottedHistory, through_time::HistorySelection),
    /// A plane of the channels, with the frame in view.
    Scatter(SlottedHistory, scatter_points::ScatterSelection, usize),
    /// All three channels, with the frame in view.
    Cube(SlottedHistory, scatter_points::ScatterSelection, usize, Look),
    /// The tuning map.
    Map(SlottedHistory, Box<Tuning>),
    /// The accuracy around the pixel under other settings.
    RegionAccuracy(SlottedHistory, Arc<RegionTuning>, Measure),
    /// The foreground ratio around a pixel, with the frame in view.
    Region(Arc<PixelHistory>, Arc<RegionShares>, usize),
    /// Pinned pixels with their numbers, with the frame in view.
    Pins(Vec<(u8, Arc<PixelHistory>)>, usize),
}

/// The file format of a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A raster image.
    Png,
    /// A vector drawing.
    Svg,
    /// A page as large as the plot, for a paper.
    Pdf,
}

impl Format {
    /// The file extension.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Svg => "svg",
            Self::Pdf => "pdf",
        }
    }

    /// The name in dialogs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG image",
            Self::Svg => "SVG image",
            Self::Pdf => "PDF document",
        }
    }
}

impl Plot {
    /// Makes the figure. This may be slow.
    pub fn figure(&self) -> Figure {
        match self {
            Self::Densities(of, index, moment) => mixture::densities(&of.history, &of.slots, *index, *moment),
            Self::Weights(of, index, moment) => mixture::weights(&of.history, &of.slots, *index, *moment),
            Self::History(of, choice) => through_time::figure(&of.history, &of.slots, choice),
            Self::Scatter(of, choice, index) => scatter::figure(&of.history, &of.slots, choice, *index),
            Self::Cube(of, choice, index, look) => {
                cube::figure(&of.history, &of.slots, choice, *index, *look)
            }
            Self::Map(of, map) => tuning::figure(&of.history, &map.map, map.position as usize),
            Self::RegionAccuracy(of, judged, measure) => {
                let [width, height] = judged.extent;
                let about = format!("{width}×{height} pixels, {} frames", judged.frames);
                tuning::of_decisions(&of.history, &about, (&judged.axes, &judged.cells), *measure)
            }
            Self::Region(of, shares, index) => region::figure(of, shares, *index),
            Self::Pins(pins, index) => pins::figure(&borrowed(pins), *index),
        }
    }

    /// The numbers behind the plot.
    pub fn table(&self) -> Table {
        match self {
            Self::Densities(of, index, moment) | Self::Weights(of, index, moment) => {
                // The mixture before the update is the mixture after the previous frame's update.
                let sides = moment.sides().iter().map(|&before| index.saturating_sub(usize::from(before)));
                let (from, to) = sides.fold((usize::MAX, 0), |(from, to), at| (from.min(at), to.max(at + 1)));
                Table::History(Arc::clone(&of.history), from.min(to)..to)
            }
            Self::History(of, through_time::HistorySelection { frames, .. })
            | Self::Scatter(of, scatter_points::ScatterSelection { frames, .. }, _)
            | Self::Cube(of, scatter_points::ScatterSelection { frames, .. }, ..) => {
                Table::History(Arc::clone(&of.history), frames.clone())
            }
            Self::Map(of, tuning) => Table::Map(Arc::clone(&of.history), tuning.clone()),
            Self::RegionAccuracy(of, judged, _) => {
                Table::RegionAccuracy(Arc::clone(&of.history), Arc::clone(judged))
            }
            Self::Region(of, shares, _) => Table::Region(Arc::clone(of), Arc::clone(shares)),
            Self::Pins(pins, _) => Table::Pins(pins.clone()),
        }
    }

    /// A file name.
    pub fn name(&self, format: Format) -> String {
        let (what, of) = match self {
            Self::Densities(of, ..) => ("densities", &of.history),
            Self::Weights(of, ..) => ("weights", &of.history),
            Self::History(of, _) => ("history", &of.history),
            Self::Scatter(of, ..) => ("scatter", &of.history),
            Self::Cube(of, ..) => ("scatter-3d", &of.history),
            Self::Map(of, _) => ("tuning", &of.history),
            Self::RegionAccuracy(of, ..) => ("accuracy", &of.history),
            Self::Region(of, ..) => ("region", of),
            Self::Pins(..) => return format!("pins.{}", format.ending()),
        };
        let (x, y) = of.source_pixel();
        format!("{what}-{x}-{y}.{}", format.ending())
    }

    /// Draws the plot as an image, or returns an error in a sentence.
    pub(crate) fn drawn(&self) -> Result<Frame, String> {
        let failed = |error| format!("the image cannot be rendered: {error}; save it as SVG instead");
        raster::picture(&self.figure()).map_err(failed)
    }

    /// Writes the plot to a file, or returns an error in a sentence.
    pub(crate) fn save(&self, path: PathBuf, format: Format) -> Result<PathBuf, String> {
        atomic_write::write(path, format.ending(), |at: &Path| match format {
            Format::Svg => fs::write(at, svg::write(&self.figure())),
            Format::Pdf => fs::write(at, pdf::write(&self.figure())?),
            Format::Png => raster::write_png(at, &self.drawn().map_err(io::Error::other)?),
        })
    }
}
