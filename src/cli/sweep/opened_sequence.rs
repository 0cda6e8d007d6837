//! A sequence whose source and ground truth can be read.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context as _, bail};
use sha2::{Digest, Sha256};

use super::arguments::SweepJob;
use crate::cli::run::hexadecimal;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::{self, SourceInfo, path_of};
use crate::sweep::data_set::Sequence;
use crate::sweep::pass::{ScoredKinds, settings_up_to};
use crate::sweep::scoring;
use crate::truth::masks::MaskFiles;
use crate::truth::sequence_truth::SequenceTruth;

/// Files beside a video or ground truth that change what is read of it.
const BESIDE: [&str; 8] = [
    "ROI.bmp",
    "ROI.jpg",
    "ROI.png",
    "temporalROI.txt",
    "seqinfo.ini",
    "labels.txt",
    "events.jsonl",
    "episodes.csv",
];

/// A sequence, its ground truth, and what a row depends on besides the settings.
pub(super) struct OpenedSequence {
    pub name: String,
    pub video: String,
    pub truth: SequenceTruth,
    pub info: SourceInfo,
    /// What is scored.
    pub kinds: ScoredKinds,
    /// The absolute paths of video and ground truth.
    pub real_paths: [PathBuf; 2],
    /// When the newest file of the video, and that of the ground truth, was changed.
    pub changed: [SystemTime; 2],
    /// The hash of the files, the options and the program's version, from which with equal settings equal rows follow.
    identity: String,
}

impl OpenedSequence {
    /// Reads the ground truth, and the first frame of the source.
    pub(super) fn new(sequence: &Sequence, job: &SweepJob) -> anyhow::Result<Self> {
        let truth = SequenceTruth::read(&sequence.truth, job.offset)?;
        let info = source::open(&sequence.video, job.options)?.info().clone();
        if info.live {
            bail!(
                "{} is a live source, which cannot be read for each setting; record it first",
                sequence.video
            );
        }
        let truth = match info.placement().and_then(|placement| placement.part()) {
            Some(part) => truth.within(part),
            None => truth,
        };
        if let Some(remark) = truth.masks.as_ref().and_then(MaskFiles::remark) {
            job.console.note(&format!("warning: {}: {remark}", sequence.name));
        }
        let Sequence { name, video, truth: truth_path } = sequence.clone();
        let (identity, changed) = identity(&video, &truth_path, job)?;
        Ok(Self {
            identity,
            changed,
            kinds: scoring::scored_kinds(&truth),
            real_paths: [&*path_of(&video), &truth_path].map(real_path),
            name,
            video,
            truth,
            info,
        })
    }

    /// What identifies a row of this sequence: its result follows from it.
    pub(super) fn row_key(&self, settings: &Settings) -> String {
        format!("{}\n{}", self.identity, settings_up_to(settings, self.kinds.last_stage()))
    }
}

/// The absolute path, or the path itself where nothing is there.
pub(super) fn real_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The hash of a region of interest.
pub(super) fn hash_of_roi(roi: &Roi) -> String {
    hexadecimal(&Sha256::digest(&roi.mask().data))
}

/// The hash of the version, the options, and the names, sizes and times of change of all files of a sequence; and the
/// newest times of change of the video and of the ground truth.
fn identity(video: &str, truth: &Path, job: &SweepJob) -> anyhow::Result<(String, [SystemTime; 2])> {
    let mut files = FileList { text: String::new(), newest: UNIX_EPOCH, left_out: real_path(&job.out) };
    let mut changed = [UNIX_EPOCH; 2];
    for (path, changed) in [&*path_of(video), truth].into_iter().zip(&mut changed) {
        let _ = writeln!(files.text, "{}", path.display());
        files.newest = UNIX_EPOCH;
        files.add_input(path)?;
        *changed = files.newest;
    }
    let version = env!("OCCLUSCOPE_VERSION");
    let roi = job.roi.as_deref().map(hash_of_roi);
    let options = format!("{:?} {:?} {} {roi:?}", job.options, job.range, job.offset);
    let hash = Sha256::digest(format!("{version}\n{options}\n{}", files.text));
    Ok((hexadecimal(&hash), changed))
}

/// Names, sizes and times of change of files.
struct FileList {
    text: String,
    /// The newest time of change.
    newest: SystemTime,
    /// The output folder, which can be in a folder of the input.
    left_out: PathBuf,
}

impl FileList {
    /// Adds a video or ground truth: a file, a folder, or a pattern of images, whose folder is added.
    fn add_input(&mut self, path: &Path) -> anyhow::Result<()> {
        let parent =
            path.parent().map(|parent| if parent.as_os_str().is_empty() { Path::new(".") } else { parent });
        match parent {
            Some(parent) if !path.exists() && parent.is_dir() => self.add(parent, 0)?,
            _ if path.exists() => self.add(path, 0)?,
            // A network address.
            _ => return Ok(()),
        }
        for file in parent.into_iter().flat_map(|parent| BESIDE.map(|name| parent.join(name))) {
            if file.is_file() {
                self.add(&file, 0)?;
            }
        }
        Ok(())
    }

    fn add(&mut self, path: &Path, depth: u32) -> anyhow::Result<()> {
        const MAX_DEPTH: u32 = 3;
        let unreadable = || format!("{} cannot be read; check its permissions", path.display());
        let metadata = fs::metadata(path).with_context(unreadable)?;
        if metadata.is_dir() {
            if depth >= MAX_DEPTH || real_path(path) == self.left_out {
                return Ok(());
            }
            let entries = fs::read_dir(path).with_context(unreadable)?;
            let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
            paths.sort();
            // A link to nothing is no file that is read.
            return paths.iter().filter(|path| path.exists()).try_for_each(|path| self.add(path, depth + 1));
        }
        let changed = metadata.modified().unwrap_or(UNIX_EPOCH);
        self.newest = self.newest.max(changed);
        let nanoseconds = changed.duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{} {} {nanoseconds}", path.display(), metadata.len());
        Ok(())
    }
}
