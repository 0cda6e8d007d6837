//! What `score` scores: the output folder of `run`, a file of tracks, or a folder of masks or label images.

use std::path::Path;

use anyhow::bail;

use crate::placement::Crop;
use crate::truth::analysed_frames::{AnalysedFrames, Origin};
use crate::truth::boxes::{Boxes, span};
use crate::truth::formats::{self, Role, TrackFile};
use crate::truth::result_source::ResultSource;
use crate::truth::run_summary::{self, MasksOfRun, RunInput, RunSummary};
use crate::truth::sequence_truth::SequenceTruth;

/// The results at a path.
#[derive(Debug)]
pub(super) struct ScoredResults {
    source: ResultSource,
    /// The summary of the run: of its output folder, or of that of its file of tracks.
    summary: Option<RunSummary>,
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
            ResultSource::Run(folder) => RunSummary::read(folder)?,
            // One that cannot be read may be of anything.
            ResultSource::Tracks(path) if path.ends_with(run_summary::TRACKS) => {
                let beside = path.parent().map(RunSummary::read);
                beside.and_then(Result::ok).flatten()
            }
            ResultSource::Tracks(_) | ResultSource::Masks(_) => None,
        };
        Ok(Self { source, summary })
    }

    fn input(&self) -> Option<&RunInput> {
        self.summary.as_ref().map(|summary| &summary.input)
    }

    /// Whether the run was limited to a region of interest.
    pub(super) fn has_roi(&self) -> bool {
        self.summary.as_ref().is_some_and(|summary| summary.analysed_share.is_some())
    }

    /// Where they are.
    pub(super) fn path(&self) -> &Path {
        match &self.source {
            ResultSource::Run(path) | ResultSource::Tracks(path) | ResultSource::Masks(path) => path,
        }
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

    /// The folder of the masks. Fails if they cannot be scored.
    pub(super) fn masks(&self) -> anyhow::Result<MasksOfRun> {
        match &self.source {
            ResultSource::Run(folder) => Ok(MasksOfRun::find(folder, self.summary.as_ref())),
            ResultSource::Masks(folder) => Ok(MasksOfRun::Of(folder.clone())),
            ResultSource::Tracks(path) => bail!(
                "{} has tracks, and the ground truth has masks; give a folder of masks, or ground truth of boxes",
                path.display()
            ),
        }
    }

    /// The analysed frames: from the summary of a run; of other tracks those of the sequence of `truth`, where its length is
    /// known, else those from the first to the last with a box in `found`; all where there is none.
    pub(super) fn analysed(&self, found: &Boxes, truth: &SequenceTruth) -> AnalysedFrames {
        let is_file = self.has_only_tracks();
        let of_summary = self.input().and_then(RunInput::analysed_frames);
        let of_summary =
            of_summary.map(|frames| if is_file { frames.known_by(Origin::RecordBeside) } else { frames });
        let of_truth = || truth.frames().filter(|_| is_file);
        of_summary.or_else(of_truth).unwrap_or_else(|| AnalysedFrames::of_results(span(found)))
    }

    /// The part of the images that was analysed; `None` where it is all of them, or not known.
    pub(super) fn part(&self) -> Option<Crop> {
        self.input()?.part()
    }
}
