//! Rows from output folders of `run` that were scored: each with the output of `score --json` in it.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::{Context as _, anyhow, bail};
use serde::Deserialize;

use super::arguments::SweepJob;
use super::opened_sequence::{OpenedSequence, hash_of_roi, real_path};
use crate::cli::score::hash_of_summary;
use crate::regions::Roi;
use crate::settings::{Settings, Stage};
use crate::source::{Options, path_of};
use crate::sweep::pass::settings_up_to;
use crate::truth::measures::Measures;

/// The name of the file with the output of `score --json`.
const SCORE: &str = "score.json";

/// How deep below the folder runs are looked for.
const MAX_DEPTH: usize = 8;

/// The rows of scored runs.
pub(super) struct RunResults {
    rows: HashMap<String, ScoredRun>,
    /// Number of scored runs that were found.
    pub count: usize,
    /// Why others cannot be used, a sentence each.
    pub unusable: Vec<String>,
}

/// A run that was scored.
struct ScoredRun {
    seconds: f64,
    measures: Measures,
    /// When its summary and its score were written.
    written: [SystemTime; 2],
}

#[derive(Deserialize)]
struct Summary {
    version: String,
    input: Input,
    #[serde(default)]
    analysed_share: Option<f32>,
    timing: Timing,
}

#[derive(Deserialize)]
struct Input {
    path: String,
    #[serde(default)]
    options: Options,
    #[serde(default)]
    range: Option<String>,
}

#[derive(Deserialize)]
struct Timing {
    seconds: f64,
}

#[derive(Deserialize)]
struct Score {
    #[serde(flatten)]
    measures: Measures,
    truth_path: String,
    #[serde(default)]
    offset: i64,
    #[serde(default)]
    summary_sha256: Option<String>,
}

impl RunResults {
    /// Reads the scored runs below `folder`. Fails if it cannot be read; a run or a folder below that cannot is left out.
    pub(super) fn below(folder: &Path) -> anyhow::Result<Self> {
        let mut results = Self { rows: HashMap::new(), count: 0, unusable: Vec::new() };
        results.search(folder, 0)?;
        Ok(results)
    }

    fn search(&mut self, folder: &Path, depth: usize) -> anyhow::Result<()> {
        if folder.join("summary.json").is_file() && folder.join(SCORE).is_file() {
            let (key, row) = read(folder)?;
            self.rows.insert(key, row);
            self.count += 1;
            return Ok(());
        }
        let unreadable = || format!("{} cannot be read; check its permissions", folder.display());
        let entries = fs::read_dir(folder).with_context(unreadable)?;
        let mut folders: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        folders.retain(|path| depth < MAX_DEPTH && path.is_dir());
        folders.sort();
        for path in folders {
            if let Err(error) = self.search(&path, depth + 1) {
                self.unusable.push(format!("{error:#}"));
            }
        }
        Ok(())
    }

    /// The seconds and measures of a sequence under these settings, if there is such a run with all measures that the
    /// ground truth permits.
    pub(super) fn row(
        &self,
        job: &SweepJob,
        sequence: &OpenedSequence,
        settings: &Settings,
    ) -> Option<(f64, Measures)> {
        let range = job.range.map(|range| range.to_string());
        let roi = job.roi.as_deref().map(hash_of_roi);
        let kinds = sequence.kinds;
        let key = key(
            env!("CARGO_PKG_VERSION"),
            &sequence.real_paths,
            &(job.options, range, job.offset, roi),
            &settings_up_to(settings, kinds.last_stage()),
        );
        let run = self.rows.get(&key)?;
        let is_whole = run.measures.is_of(kinds.masks, kinds.has_box);
        // The video is older than the run, and the ground truth older than the score.
        let is_current =
            sequence.changed.iter().zip(&run.written).all(|(changed, written)| changed <= written);
        (is_whole && is_current).then_some((run.seconds, run.measures))
    }
}

/// Options of the source, range of frames, offset of the ground truth, hash of the region of interest.
type Conditions = (Options, Option<String>, i64, Option<String>);

fn key(version: &str, [video, truth]: &[PathBuf; 2], conditions: &Conditions, settings: &str) -> String {
    format!("{version}\n{}\n{}\n{conditions:?}\n{settings}", video.display(), truth.display())
}

fn read(folder: &Path) -> anyhow::Result<(String, ScoredRun)> {
    let text = |name: &str| {
        let path = folder.join(name);
        fs::read_to_string(&path)
            .with_context(|| format!("{} cannot be read; check its permissions", path.display()))
    };
    let damaged = |name: &str, error: serde_json::Error| {
        anyhow!("{} is not from this program ({error}); run and score again", folder.join(name).display())
    };
    let summary: Summary =
        serde_json::from_str(&text("summary.json")?).map_err(|error| damaged("summary.json", error))?;
    let score: Score = serde_json::from_str(&text(SCORE)?).map_err(|error| damaged(SCORE, error))?;
    if score.summary_sha256 != hash_of_summary(folder) {
        bail!("{} is not of the run in its folder; score again", folder.join(SCORE).display());
    }
    if !score.measures.is_possible() || !summary.timing.seconds.is_finite() {
        bail!("{} has measures that cannot be; score again", folder.join(SCORE).display());
    }
    let mut settings = Settings::default();
    settings.apply_toml(&text("settings.toml")?, &folder.join("settings.toml"))?;
    let Summary { version, input, analysed_share, timing } = summary;
    let last = if score.measures.are_of_tracks() { Stage::Occlusion } else { Stage::Cleaning };
    let roi = analysed_share.map(|_| Roi::read(&folder.join("roi.png"))).transpose()?;
    let conditions = (input.options, input.range, score.offset, roi.as_ref().map(hash_of_roi));
    let settings = settings_up_to(&settings, last);
    let paths = [&*path_of(&input.path), &*path_of(&score.truth_path)].map(real_path);
    let key = key(&version, &paths, &conditions, &settings);
    let written = |name: &str| {
        let time = fs::metadata(folder.join(name)).and_then(|metadata| metadata.modified());
        time.unwrap_or(SystemTime::UNIX_EPOCH)
    };
    let written = [written("summary.json"), written(SCORE)];
    Ok((key, ScoredRun { seconds: timing.seconds, measures: score.measures, written }))
}
