//! Ground truth, and how far what was found agrees with it.
//!
//! [`boxes`] reads tracks as MOTChallenge has them, [`clear_mot`] and [`survival`] score them, [`summary`] by both;
//! [`masks`] scores masks as CDnet does; [`happenings`] scores events and episodes of made-up scenes.

pub mod boxes;
pub mod clear_mot;
pub mod happenings;
pub mod masks;
pub mod summary;
pub mod survival;

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A file of results or of truth that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be used: {why}", path.display())]
pub struct TruthError {
    /// The file or folder.
    pub path: PathBuf,
    /// Why, and what to do.
    pub why: String,
}

impl TruthError {
    fn new(path: &Path, why: impl Display) -> Self {
        Self { path: path.to_owned(), why: why.to_string() }
    }
}
