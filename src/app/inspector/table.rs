//! The numbers behind a plot, for export as CSV.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use crate::app::files::atomic_write;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::region_shares::RegionShares;
use crate::explain::tuning::{RegionTuning, Tuning};
use crate::export::{pixel_csv, shares_csv, statistics_csv, tuning_csv};

/// A table that can be copied or saved. It is written only on request.
#[derive(Clone, Debug, PartialEq)]
pub enum Table {
    /// These states of a pixel, one row a frame, as `occluscope pixel` writes them.
    History(Arc<PixelHistory>, Range<usize>),
    /// A tuning map of a pixel, one row a cell.
    Map(Arc<PixelHistory>, Box<Tuning>),
    /// The accuracy around a pixel, one row a cell.
    RegionAccuracy(Arc<PixelHistory>, Arc<RegionTuning>),
    /// The statistics over these states of a pixel, in one row.
    Statistics(Arc<PixelHistory>, Range<usize>),
    /// The foreground ratio around a pixel, one row a frame.
    Region(Arc<PixelHistory>, Arc<RegionShares>),
    /// Pinned pixels with their numbers, one row for each frame of each pixel.
    Pins(Vec<(u8, Arc<PixelHistory>)>),
}

impl Table {
    /// The number of rows without the header.
    pub fn rows(&self) -> usize {
        match self {
            Self::History(_, range) => range.len(),
            Self::Statistics(..) => 1,
            Self::Region(history, shares) => history.states.len().min(shares.cleaned.len()),
            Self::Pins(pins) => pins.iter().map(|(_, history)| history.states.len()).sum(),
            Self::Map(_, tuning) => tuning.map.axes.iter().map(|axis| axis.values.len()).product(),
            Self::RegionAccuracy(_, judged) => judged.cells.len(),
        }
    }

    /// A file name.
    pub fn name(&self) -> String {
        let (what, of) = match self {
            Self::History(of, _) => ("pixel", of),
            Self::Map(of, _) => ("tuning", of),
            Self::RegionAccuracy(of, _) => ("accuracy", of),
            Self::Statistics(of, _) => ("statistics", of),
            Self::Region(of, _) => ("region", of),
            Self::Pins(_) => return "pins.csv".to_owned(),
        };
        let (x, y) = of.source_pixel();
        format!("{what}-{x}-{y}.csv")
    }

    /// Writes the table as CSV.
    pub fn write(&self, out: &mut impl io::Write) -> io::Result<()> {
        match self {
            Self::History(history, range) => {
                pixel_csv::write_header(out, &history.parameters)?;
                let states = history.states.iter().take(range.end).skip(range.start);
                states.into_iter().try_for_each(|state| pixel_csv::write_row(out, &history.parameters, state))
            }
            Self::Statistics(history, range) => statistics_csv::write(out, history, range.clone()),
            Self::Region(history, shares) => shares_csv::write(out, history, shares),
            Self::Pins(pins) => pixel_csv::write_pins(out, &borrowed(pins)),
            Self::Map(_, tuning) => tuning_csv::write_map(out, &tuning.map),
            Self::RegionAccuracy(_, judged) => tuning_csv::write_decisions(out, &judged.axes, &judged.cells),
        }
    }

    /// The table as CSV text.
    pub fn csv(&self) -> io::Result<String> {
        let mut text = Vec::new();
        self.write(&mut text)?;
        String::from_utf8(text).map_err(io::Error::other)
    }

    /// Writes the table to a file, or returns an error in a sentence.
    pub(crate) fn save(&self, path: PathBuf) -> Result<PathBuf, String> {
        atomic_write::write(path, "csv", |at: &Path| {
            let mut out = io::BufWriter::new(fs::File::create(at)?);
            self.write(&mut out)?;
            io::Write::flush(&mut out)
        })
    }
}

/// Pinned pixels in the form that writers need.
pub(super) fn borrowed(pins: &[(u8, Arc<PixelHistory>)]) -> Vec<(u8, &PixelHistory)> {
    pins.iter().map(|(number, history)| (*number, &**history)).collect()
}
