//! What `score` scores: the output folder of `run`, a file of tracks, or a folder of masks or label images.

use std::fs;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use anyhow::bail;
use serde::Deserialize;

use crate::source::Options;
use crate::truth::boxes::{Boxes, span};
use crate::truth::formats::{self, Role, TrackFile, label_images};
use crate::truth::mask_score;

/// The results at a path.
#[derive(Debug)]
pub(super) enum ScoredResults {
    /// The output folder of `run`.
    Folder(PathBuf),
    /// A file of tracks, or a folder of label images.
    Tracks(PathBuf),
    /// A folder of masks.
    Masks(PathBuf),
}

impl ScoredResults {
    pub(super) fn of(path: &Path) -> anyhow::Result<Self> {
        if path.is_file() {
            return Ok(Self::Tracks(path.to_owned()));
        }
        if !path.is_dir() {
            bail!(
                "{} is not there; give the output folder of `run --out`, a file of tracks, or a folder of masks",
                path.display()
            );
        }
        let of_run = ["summary.json", "tracks.csv", "masks"].iter().any(|name| path.join(name).exists());
        Ok(match () {
            () if of_run => Self::Folder(path.to_owned()),
            () if label_images::is_folder_of_labels(path) => Self::Tracks(path.to_owned()),
            () if !mask_score::results_in(path)?.is_empty() => Self::Masks(path.to_owned()),
            () => Self::Folder(path.to_owned()),
        })
    }

    /// The output folder of `run`, if it is one.
    pub(super) fn folder(&self) -> Option<&Path> {
        match self {
            Self::Folder(folder) => Some(folder),
            Self::Tracks(_) | Self::Masks(_) => None,
        }
    }

    pub(super) fn tracks(&self) -> anyhow::Result<TrackFile> {
        match self {
            Self::Folder(folder) => Ok(formats::read(&folder.join("tracks.csv"), Role::Results)?),
            Self::Tracks(path) => Ok(formats::read(path, Role::Results)?),
            Self::Masks(path) => bail!(
                "{} has masks, and the ground truth has boxes; give a file of tracks, or ground truth of masks",
                path.display()
            ),
        }
    }

    /// The folder of the masks, which need not exist.
    pub(super) fn masks(&self) -> anyhow::Result<PathBuf> {
        match self {
            Self::Folder(folder) => Ok(folder.join("masks")),
            Self::Masks(folder) => Ok(folder.clone()),
            Self::Tracks(path) => bail!(
                "{} has tracks, and the ground truth has masks; give a folder of masks, or ground truth of boxes",
                path.display()
            ),
        }
    }

    /// The analysed frames: from the summary of a run, else those from the first to the last with a box in `found`; all
    /// where there is none.
    pub(super) fn analysed(&self, found: &Boxes) -> AnalysedFrames {
        let of_summary = self.folder().and_then(AnalysedFrames::of_summary);
        of_summary.unwrap_or_else(|| {
            let (first, last) = span(found).unwrap_or((0, u32::MAX));
            AnalysedFrames { first, last, every: NonZeroU32::MIN, is_told: false }
        })
    }
}

/// The numbers of the frames that were analysed.
pub(super) struct AnalysedFrames {
    pub(super) first: u32,
    pub(super) last: u32,
    every: NonZeroU32,
    /// Whether a summary states them.
    pub(super) is_told: bool,
}

impl AnalysedFrames {
    fn of_summary(folder: &Path) -> Option<Self> {
        #[derive(Deserialize)]
        struct Summary {
            input: Input,
        }
        #[derive(Deserialize)]
        struct Input {
            frames: u32,
            first_frame: u32,
            last_frame: u32,
            #[serde(default)]
            options: Options,
        }
        let text = fs::read_to_string(folder.join("summary.json")).ok()?;
        let Summary { input } = serde_json::from_str(&text).ok()?;
        let Input { frames, first_frame: first, last_frame: last, options } = input;
        let every = options.every.unwrap_or(NonZeroU32::MIN);
        (frames > 0 && first <= last).then_some(Self { first, last, every, is_told: true })
    }

    /// Whether a frame is in the range, analysed or left out between others.
    pub(super) fn covers(&self, number: u32) -> bool {
        (self.first..=self.last).contains(&number)
    }

    /// Whether a frame was analysed.
    pub(super) fn contains(&self, number: u32) -> bool {
        self.covers(number) && (number - self.first).is_multiple_of(self.every.get())
    }

    /// Number of frames.
    pub(super) fn count(&self) -> u64 {
        u64::from(self.last - self.first) / u64::from(self.every.get()) + 1
    }
}
