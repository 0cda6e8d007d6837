//! What `score` scores: the output folder of `run`, a file of tracks, or a folder of masks or label images.

use std::fs;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use serde::Deserialize;

use crate::frame::Size;
use crate::placement::{Crop, Placement};
use crate::source::Options;
use crate::truth::analysed_frames::AnalysedFrames;
use crate::truth::boxes::{Boxes, span};
use crate::truth::formats::{self, Role, TrackFile};
use crate::truth::result_source::ResultSource;

/// The results at a path.
#[derive(Debug)]
pub(super) struct ScoredResults {
    source: ResultSource,
    /// The input of the run, from its summary.
    input: Option<Input>,
    /// Whether the run was limited to a region of interest.
    pub(super) has_roi: bool,
}

impl ScoredResults {
    /// Finds the kind of the results, and reads the summary of a run. Fails if it is damaged.
    pub(super) fn of(path: &Path) -> anyhow::Result<Self> {
        if !path.is_file() && !path.is_dir() {
            bail!(
                "{} is not there; give the output folder of `run --out`, a file of tracks, or a folder of masks",
                path.display()
            );
        }
        let source = ResultSource::of(path)?;
        let summary = match &source {
            ResultSource::Run(folder) => Summary::read(folder)?,
            ResultSource::Tracks(_) | ResultSource::Masks(_) => None,
        };
        let has_roi = summary.as_ref().is_some_and(|summary| summary.analysed_share.is_some());
        Ok(Self { source, input: summary.map(|summary| summary.input), has_roi })
    }

    /// The output folder of `run`, if it is one.
    pub(super) fn folder(&self) -> Option<&Path> {
        match &self.source {
            ResultSource::Run(folder) => Some(folder),
            ResultSource::Tracks(_) | ResultSource::Masks(_) => None,
        }
    }

    /// Whether there are tracks and no masks.
    pub(super) fn has_only_tracks(&self) -> bool {
        matches!(self.source, ResultSource::Tracks(_))
    }

    /// Whether there are masks and no tracks.
    pub(super) fn has_only_masks(&self) -> bool {
        matches!(self.source, ResultSource::Masks(_))
    }

    pub(super) fn tracks(&self) -> anyhow::Result<TrackFile> {
        match &self.source {
            ResultSource::Run(folder) => Ok(formats::read(&folder.join("tracks.csv"), Role::Results)?),
            ResultSource::Tracks(path) => Ok(formats::read(path, Role::Results)?),
            ResultSource::Masks(path) => bail!(
                "{} has masks, and the ground truth has boxes; give a file of tracks, or ground truth of masks",
                path.display()
            ),
        }
    }

    /// The folder of the masks, which need not exist.
    pub(super) fn masks(&self) -> anyhow::Result<PathBuf> {
        match &self.source {
            ResultSource::Run(folder) => Ok(folder.join("masks")),
            ResultSource::Masks(folder) => Ok(folder.clone()),
            ResultSource::Tracks(path) => bail!(
                "{} has tracks, and the ground truth has masks; give a folder of masks, or ground truth of boxes",
                path.display()
            ),
        }
    }

    /// The analysed frames: from the summary of a run, else those from the first to the last with a box in `found`; all
    /// where there is none.
    pub(super) fn analysed(&self, found: &Boxes) -> AnalysedFrames {
        let of_summary = self.input.as_ref().and_then(Input::frames);
        of_summary.unwrap_or_else(|| AnalysedFrames::of_results(span(found)))
    }

    /// The part of the images that was analysed; `None` where it is all of them, or not known.
    pub(super) fn part(&self) -> Option<Crop> {
        let Input { size, options, .. } = self.input.as_ref()?;
        Placement::new((*size)?, options.crop, options.scale)?.part()
    }
}

/// What is read of the summary of a run.
#[derive(Deserialize)]
struct Summary {
    input: Input,
    /// The share of the region of interest, if there is one.
    #[serde(default)]
    analysed_share: Option<f32>,
}

/// The input as the summary of a run has it.
#[derive(Debug, Deserialize)]
struct Input {
    size: Option<Size>,
    frames: u32,
    first_frame: u32,
    last_frame: u32,
    /// Older summaries do not have it.
    analysed: Option<AnalysedFrames>,
    #[serde(default)]
    options: Options,
}

impl Summary {
    /// Reads the summary in a folder; `None` if there is none.
    fn read(folder: &Path) -> anyhow::Result<Option<Self>> {
        let path = folder.join("summary.json");
        if !path.is_file() {
            return Ok(None);
        }
        let text = fs::read_to_string(&path)
            .with_context(|| format!("{} cannot be read; check its permissions", path.display()))?;
        let damaged = || format!("{} is damaged; run again", path.display());
        let summary: Self = serde_json::from_str(&text).with_context(damaged)?;
        if !summary.input.options.is_valid() {
            bail!(damaged());
        }
        Ok(Some(summary))
    }
}

impl Input {
    fn frames(&self) -> Option<AnalysedFrames> {
        let step = self.options.every.map_or(1, NonZeroU32::get);
        let counted = || AnalysedFrames::at_steps(self.first_frame, self.last_frame, step);
        self.analysed.clone().or_else(counted).filter(|_| self.frames > 0)
    }
}
