//! Ground truth, and the scores of results against it.
//!
//! [`formats`] reads [`boxes`] of several formats, [`ignored`] drops what is not judged, [`clear_mot`], [`hota`] and
//! [`survival`] score tracks, [`summary`] by all; [`masks`] reads masks of CDnet's levels, [`mask_score`] and
//! [`mixture_score`] score pixels against them in counts of [`decisions`]; [`alignment`] finds frame numbers that fit better;
//! [`event_scoring`] scores events and episodes of rendered scenes, [`meetings`] episodes where only boxes are known. [`result_source`] finds the kind of results that are
//! scored, [`run_summary`] reads what a run states of its
//! input, [`external`] reads the results of another method. [`sequence_truth`] is all of a sequence, of which [`comparison`] judges
//! the frames that were [analysed](analysed_frames). [`measures`] are the main results of all under short names, and
//! [`mask_measures`] those of masks with their means over a data set.

pub mod alignment;
pub mod analysed_frames;
mod assignment;
pub mod boxes;
pub mod clear_mot;
pub mod comparison;
pub mod decisions;
pub mod event_scoring;
pub mod external;
pub mod formats;
pub mod hota;
pub mod ignored;
pub mod mask_measures;
pub mod mask_score;
pub mod masks;
pub mod measures;
pub mod meetings;
pub mod mixture_score;
pub mod result_source;
pub mod run_summary;
pub mod sequence_truth;
mod share;
pub mod summary;
pub mod survival;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::boxes::{Bounds, Boxes};
use self::formats::{Role, TrackFile, label_images};
use self::ignored::Ignored;
use self::masks::{MaskFiles, TrueMasks};
use crate::placement::Placement;

/// A number and what it counts, in words for one and for several.
pub fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// An error of a file of results or of ground truth.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be used: {why}", path.display())]
pub struct TruthError {
    /// The file or folder.
    pub path: PathBuf,
    /// The cause and a remedy.
    pub why: String,
}

impl TruthError {
    fn new(path: &Path, why: impl Display) -> Self {
        // Messages of libraries may contain line breaks; ours are one line.
        let why = why.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        Self { path: path.to_owned(), why }
    }

    #[allow(clippy::needless_pass_by_value, reason = "fits `map_err`")]
    fn unreadable(path: &Path, error: std::io::Error) -> Self {
        Self::new(path, format!("{error}; check its path and permissions"))
    }
}

/// The kind of ground truth at a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TruthSource {
    /// A file of boxes, or a folder of label images.
    Boxes(PathBuf),
    /// A CDnet folder.
    Cdnet(PathBuf),
    /// A folder of masks.
    Masks(PathBuf),
    /// The folder of ground truth of a scene written by `synth`.
    Scene(PathBuf),
}

impl TruthSource {
    /// Detects the kind of the ground truth at `path`. Fails if there is none of a known kind.
    pub fn of(path: &Path) -> Result<Self, TruthError> {
        if path.is_file() {
            return Ok(Self::Boxes(path.to_owned()));
        }
        if path.join("groundtruth").is_dir() {
            return Ok(Self::Cdnet(path.to_owned()));
        }
        if let Some(folder) = path.parent().filter(|_| path.is_dir() && path.ends_with("groundtruth")) {
            return Ok(Self::Cdnet(
                if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.to_owned(),
            ));
        }
        // The folder of a scene, then that of a MOTChallenge sequence.
        let folders = [path.join("truth"), path.to_owned(), path.join("gt")];
        match folders.into_iter().find(|folder| folder.join("gt.txt").is_file()) {
            Some(folder) if folder.join("events.jsonl").is_file() || folder.join("identities").is_dir() => {
                Ok(Self::Scene(folder))
            }
            Some(folder) => Ok(Self::Boxes(folder.join("gt.txt"))),
            None if !path.exists() => Err(TruthError::new(path, "it does not exist; check the path")),
            None if label_images::is_folder_of_labels(path) => Ok(Self::Boxes(path.to_owned())),
            None if masks::is_folder_of_masks(path) => Ok(Self::Masks(path.to_owned())),
            None => {
                let why = masks::remark_on_jpegs(path).unwrap_or(
                    "unknown ground truth format; use MOTChallenge text or its sequence folder, CVAT or CAVIAR XML, COCO JSON, \
                     a zip that CVAT exports, a CDnet folder with groundtruth/, a folder of masks of 0 and 255 or of label \
                     images, or a scene written by `synth`",
                );
                Err(TruthError::new(path, why))
            }
        }
    }

    /// The masks, if it has such; of a scene only where they were rendered.
    pub fn masks(&self) -> Result<Option<MaskFiles>, TruthError> {
        match self {
            Self::Boxes(_) => Ok(None),
            Self::Cdnet(folder) => MaskFiles::of_cdnet(folder).map(Some),
            Self::Masks(folder) => MaskFiles::of_folder(folder).map(Some),
            Self::Scene(folder) => masks_of_scene(folder),
        }
    }

    /// The tracks, if it has such.
    pub fn tracks(&self) -> Result<Option<TrackFile>, TruthError> {
        match self {
            Self::Boxes(path) => formats::read(path, Role::Truth).map(Some),
            Self::Scene(folder) => formats::read(&folder.join("gt.txt"), Role::Truth).map(Some),
            Self::Cdnet(_) | Self::Masks(_) => Ok(None),
        }
    }
}

/// The masks of a scene's folder of ground truth, if it has any.
fn masks_of_scene(folder: &Path) -> Result<Option<MaskFiles>, TruthError> {
    let identities = folder.join("identities");
    identities.is_dir().then(|| MaskFiles::of_identities(&identities)).transpose()
}

/// The ground truth of a sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The true boxes.
    pub boxes: Option<Boxes>,
    /// The boxes that are neither found nor missed.
    pub ignored: Ignored,
    /// The true masks.
    pub masks: Option<Arc<TrueMasks>>,
    /// What was left out of the masks, a clause.
    pub remark: Option<String>,
}

impl Truth {
    /// Reads the ground truth at `path`, of any kind of [`TruthSource`].
    pub fn read(path: &Path) -> Result<Self, TruthError> {
        let source = TruthSource::of(path)?;
        let files = source.masks()?;
        let remark = files.as_ref().and_then(|files| files.remark().map(ToOwned::to_owned));
        let masks = files.map(|files| files.read_all()).transpose()?.flatten().map(Arc::new);
        let (boxes, ignored) = source.tracks()?.map(|file| (file.boxes, file.ignored)).unzip();
        let truth = Self { boxes, ignored: ignored.unwrap_or_default(), masks, remark };
        if truth.boxes.is_none() && truth.masks.is_none() {
            let why = "no masks groundtruth/gt000001.png … found in it, or none within temporalROI.txt";
            return Err(TruthError::new(path, why));
        }
        Ok(truth)
    }

    /// The truth of frames that are placed in the source's images: boxes in their pixels, as [`ignored::crop`] cuts them,
    /// and masks of the source's size with the label at the centre of each of their pixels.
    #[must_use]
    pub fn in_frames(&self, placement: &Placement) -> Self {
        let (mut boxes, mut ignored) = (self.boxes.clone(), self.ignored.clone());
        if let Some((boxes, part)) = boxes.as_mut().zip(placement.part()) {
            ignored::crop(boxes, &mut ignored, &part);
        }
        let boxes = boxes.map(|boxes| boxes::in_frames(&boxes, placement));
        for place in ignored.values_mut().flatten() {
            *place = Bounds(placement.frame_box(place.0));
        }
        let masks = self.masks.as_ref().map(|masks| masks.fitted(placement));
        Self { boxes, ignored, masks, remark: self.remark.clone() }
    }
}
