//! The numbers behind a plot, to take along as CSV.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use crate::app::atomic_write;
use crate::export::{pixel_csv, shares_csv, statistics_csv, tuning_csv};
use crate::mixture::PixelHistory;
use crate::replay::{RegionShares, RegionTuning, Tuning};

/// What can be copied or saved. It is written only when it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Table {
    /// These states of a pixel, a frame a row, as `occluscope pixel` writes them.
    History(Arc<PixelHistory>, Range<usize>),
    /// A tuning map, a cell a row.
    Map(Box<Tuning>),
    /// How right the pixels around one would be, a cell a row.
    RegionAccuracy(Arc<RegionTuning>),
    /// What is counted over these states of a pixel, in one row.
    Statistics(Arc<PixelHistory>, Range<usize>),
    /// The share of foreground around a pixel, a frame a row.
    Region(Arc<PixelHistory>, Arc<RegionShares>),
    /// Pinned pixels with their numbers, a frame of each a row.
    Pins(Vec<(u8, Arc<PixelHistory>)>),
}

impl Table {
    /// How many rows it has without its header.
    pub fn rows(&self) -> usize {
        match self {
            Self::History(_, range) => range.len(),
            Self::Statistics(..) => 1,
            Self::Region(history, shares) => history.states.len().min(shares.cleaned.len()),
            Self::Pins(pins) => pins.iter().map(|(_, history)| history.states.len()).sum(),
            Self::Map(tuning) => tuning.map.axes.iter().map(|axis| axis.values.len()).product(),
            Self::RegionAccuracy(judged) => judged.cells.len(),
        }
    }

    /// A name for its file.
    pub fn name(&self) -> String {
        match self {
            Self::History(history, _) => format!("pixel-{}-{}.csv", history.at.0, history.at.1),
            Self::Map(tuning) => format!("tuning-{}-{}.csv", tuning.at.0, tuning.at.1),
            Self::RegionAccuracy(judged) => format!("right-{}-{}.csv", judged.at.0, judged.at.1),
            Self::Statistics(history, _) => format!("statistics-{}-{}.csv", history.at.0, history.at.1),
            Self::Region(history, _) => format!("region-{}-{}.csv", history.at.0, history.at.1),
            Self::Pins(_) => "pins.csv".to_owned(),
        }
    }

    /// Writes it as CSV.
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
            Self::Map(tuning) => tuning_csv::write_map(out, &tuning.map),
            Self::RegionAccuracy(judged) => tuning_csv::write_decisions(out, &judged.axes, &judged.cells),
        }
    }

    /// As text.
    pub fn csv(&self) -> io::Result<String> {
        let mut text = Vec::new();
        self.write(&mut text)?;
        String::from_utf8(text).map_err(io::Error::other)
    }

    /// Writes it to a file, or says why it could not be.
    pub(crate) fn save(&self, path: PathBuf) -> Result<PathBuf, String> {
        atomic_write::write(path, "csv", |at: &Path| {
            let mut out = io::BufWriter::new(fs::File::create(at)?);
            self.write(&mut out)?;
            io::Write::flush(&mut out)
        })
    }
}

/// Pinned pixels as writers take them.
pub(super) fn borrowed(pins: &[(u8, Arc<PixelHistory>)]) -> Vec<(u8, &PixelHistory)> {
    pins.iter().map(|(number, history)| (*number, &**history)).collect()
}
