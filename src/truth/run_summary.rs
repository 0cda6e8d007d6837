//! The summary of a run, as it is read again: to score its results, to convert them, or to compare with them.

use std::fs;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::TruthError;
use super::analysed_frames::AnalysedFrames;
use crate::frame::Size;
use crate::placement::{Crop, Placement};
use crate::source::Options;

/// The name of the file in the output folder of `run`.
pub const FILE: &str = "summary.json";

/// The file of tracks in the output folder of `run`.
pub const TRACKS: &str = "tracks.csv";

/// The folder of masks in the output folder of `run`.
pub const MASKS: &str = "masks";

/// Largest number of frames that is believed, a month at 25 per second: their numbers are kept in memory.
const MAX_FRAMES: u32 = 1 << 26;

/// What is read of the summary of a run.
#[derive(Clone, Debug, Deserialize)]
pub struct RunSummary {
    /// The input.
    pub input: RunInput,
    /// The share of the image that was analysed, if there was a region of interest.
    #[serde(default)]
    pub analysed_share: Option<f32>,
    /// The large files and folders that the run wrote. Older summaries do not have them.
    #[serde(default)]
    pub large_files: Option<Vec<String>>,
}

/// The input of a run.
#[derive(Clone, Debug, Deserialize)]
pub struct RunInput {
    /// The name given by the user; empty where the summary has none.
    #[serde(default)]
    pub path: String,
    /// Width and height of the source's images.
    pub size: Option<Size>,
    /// Frames per second of the source.
    pub fps: Option<f32>,
    /// Number of analysed frames.
    pub frames: u32,
    /// The first frame number.
    pub first_frame: u32,
    /// The last frame number.
    pub last_frame: u32,
    /// The numbers of all analysed frames. Older summaries do not have them.
    pub analysed: Option<AnalysedFrames>,
    /// The options with which it was read.
    #[serde(default)]
    pub options: Options,
}

impl RunSummary {
    /// Reads the summary in the output folder of a run; `None` if there is none. Fails if it is damaged or states what
    /// cannot be.
    pub fn read(folder: &Path) -> Result<Option<Self>, TruthError> {
        let path = folder.join(FILE);
        if !path.is_file() {
            return Ok(None);
        }
        let damaged = |why: &str| TruthError::new(&path, format!("{why}; run again"));
        let text = fs::read_to_string(&path).map_err(|error| TruthError::unreadable(&path, error))?;
        let summary: Self =
            serde_json::from_str(&text).map_err(|error| damaged(&format!("it is damaged: {error}")))?;
        let RunInput { size, fps, frames, first_frame, last_frame, analysed, options, .. } = &summary.input;
        if last_frame < first_frame {
            return Err(damaged(&format!(
                "the last frame, {last_frame}, is before the first, {first_frame}"
            )));
        }
        let is_of_run = *frames <= MAX_FRAMES
            && options.is_valid()
            && size.is_none_or(|size| size.pixels() > 0)
            && fps.is_none_or(|fps| fps.is_finite() && fps > 0.0)
            && analysed.as_ref().is_none_or(|analysed| analysed.span() == (*first_frame, *last_frame));
        if !is_of_run {
            return Err(damaged("it has numbers that no run has"));
        }
        Ok(Some(summary))
    }

    /// Whether the run wrote this large file or folder; where the summary does not list them, it may have.
    pub fn lists(&self, name: &str) -> bool {
        self.large_files.as_ref().is_none_or(|files| files.iter().any(|file| file == name))
    }
}

impl RunInput {
    /// The numbers of the analysed frames, as far as they are known; `None` without frames.
    pub fn analysed_frames(&self) -> Option<AnalysedFrames> {
        let step = self.options.every.map_or(1, NonZeroU32::get);
        let counted = || AnalysedFrames::at_steps(self.first_frame, self.last_frame, step);
        self.analysed.clone().or_else(counted).filter(|_| self.frames > 0)
    }

    /// The part of the images that was analysed; `None` where it is all of them, or not known.
    pub fn part(&self) -> Option<Crop> {
        Placement::new(self.size?, self.options.crop, self.options.scale)?.part()
    }
}

/// Where the masks of a run are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MasksOfRun {
    /// There are none.
    None,
    /// There are some of an earlier run only.
    OfEarlierRun(PathBuf),
    /// There are some of this run, as far as is known.
    Of(PathBuf),
}

impl MasksOfRun {
    /// The masks in the output folder of the run with this summary.
    pub fn find(folder: &Path, summary: Option<&RunSummary>) -> Self {
        let masks = folder.join(MASKS);
        match summary {
            _ if !masks.is_dir() => Self::None,
            Some(summary) if !summary.lists(MASKS) => Self::OfEarlierRun(masks),
            _ => Self::Of(masks),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn with_summary(text: &str) -> (tempfile::TempDir, Result<Option<RunSummary>, TruthError>) {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), text).unwrap();
        let read = RunSummary::read(folder.path());
        (folder, read)
    }

    #[test]
    fn a_folder_without_a_summary_has_none_and_a_damaged_one_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(RunSummary::read(folder.path()).unwrap().is_none());
        let input = |text: &str| format!(r#"{{"input":{{{text}}}}}"#);
        for (text, word) in [
            ("[]".to_owned(), "damaged"),
            (input(r#""frames":5,"first_frame":3,"last_frame":2"#), "before the first, 3"),
            (input(r#""frames":99999999,"first_frame":3,"last_frame":4"#), "numbers that no run has"),
            (
                input(r#""frames":5,"first_frame":3,"last_frame":7,"options":{"fps":-1.0}"#),
                "numbers that no run has",
            ),
            (
                input(r#""frames":1,"first_frame":5,"last_frame":5,"analysed":[[0,0]]"#),
                "numbers that no run has",
            ),
            (input(r#""frames":1,"first_frame":5,"last_frame":5,"fps":0.0"#), "numbers that no run has"),
            (
                input(r#""frames":1,"first_frame":5,"last_frame":5,"size":{"width":0,"height":9}"#),
                "numbers that no run has",
            ),
        ] {
            let line = with_summary(&text).1.unwrap_err().to_string();
            assert!(line.contains(FILE) && line.contains(word) && line.ends_with("run again"), "{line}");
        }
    }

    #[test]
    fn the_masks_of_an_earlier_run_are_distinguished_from_those_of_this_one() {
        let text = |large: &str| {
            format!(r#"{{"input":{{"frames":5,"first_frame":3,"last_frame":7}},"large_files":{large}}}"#)
        };
        for (large, is_of_this) in
            [(r#"["frames","masks"]"#, true), (r#"["frames"]"#, false), ("[]", false), ("null", true)]
        {
            let (folder, summary) = with_summary(&text(large));
            let summary = summary.unwrap().unwrap();
            assert_eq!(MasksOfRun::find(folder.path(), Some(&summary)), MasksOfRun::None);
            let masks = folder.path().join(MASKS);
            fs::create_dir(&masks).unwrap();
            let found = MasksOfRun::find(folder.path(), Some(&summary));
            let expected = if is_of_this { MasksOfRun::Of(masks) } else { MasksOfRun::OfEarlierRun(masks) };
            assert_eq!(found, expected, "{large}");
        }
    }
}
