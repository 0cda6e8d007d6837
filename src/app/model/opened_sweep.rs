//! A sweep that was opened from its table.

use std::path::PathBuf;

use crate::settings::Settings;
use crate::sweep::table::SweepTable;

/// The name of the table in the folder of a sweep.
pub(crate) const TABLE_NAME: &str = "sweep.csv";

/// A sweep.
#[derive(Clone, Debug)]
pub(crate) struct OpenedSweep {
    /// The file of the table.
    pub(crate) path: PathBuf,
    /// The measures.
    pub(crate) table: SweepTable,
    /// The settings that the grid changed; `None` if the folder has none.
    pub(crate) base: Option<Settings>,
}
