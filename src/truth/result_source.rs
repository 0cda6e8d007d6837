//! The kinds of results that can be scored: the output of `run`, or anybody's tracks or masks.

use std::path::{Path, PathBuf};

use super::formats::label_images;
use super::{TruthError, mask_score, masks};

/// The kind of results at a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ResultSource {
    /// The output folder of `run`.
    Run(PathBuf),
    /// A file of tracks, or a folder of label images.
    Tracks(PathBuf),
    /// A folder of masks.
    Masks(PathBuf),
}

impl ResultSource {
    /// Detects the kind of the results at `path`. Fails if there is nothing of a known kind, or numbers in a folder occur
    /// twice.
    pub fn of(path: &Path) -> Result<Self, TruthError> {
        if path.is_file() {
            return Ok(Self::Tracks(path.to_owned()));
        }
        if !path.is_dir() {
            return Err(TruthError::new(path, "it does not exist; check the path"));
        }
        let of_run = ["summary.json", "tracks.csv", "masks"].iter().any(|name| path.join(name).exists());
        Ok(match () {
            () if of_run => Self::Run(path.to_owned()),
            () if label_images::is_folder_of_labels(path) => Self::Tracks(path.to_owned()),
            () if !mask_score::results_in(path)?.is_empty() => Self::Masks(path.to_owned()),
            () => {
                let why = masks::remark_on_jpegs(path).unwrap_or(
                    "no tracks or masks of a known kind found in it; give the output folder of `run`, with its tracks.csv or \
                     the masks of --masks, a file of tracks, or a folder of masks of 0 and 255 or of label images",
                );
                return Err(TruthError::new(path, why));
            }
        })
    }
}
