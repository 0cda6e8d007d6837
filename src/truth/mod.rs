//! Ground truth, and the scores of results against it.
//!
//! [`boxes`] reads tracks in MOTChallenge's format, [`clear_mot`] and [`survival`] score them, [`summary`] by both;
//! [`masks`] reads masks in CDnet's format, [`mask_score`] and [`mixture_score`] score pixels against them in counts of
//! [`decisions`]; [`event_scoring`] scores events and episodes of rendered scenes.

pub mod boxes;
pub mod clear_mot;
pub mod decisions;
pub mod event_scoring;
pub mod mask_score;
pub mod masks;
pub mod mixture_score;
mod share;
pub mod summary;
pub mod survival;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::boxes::Boxes;
use self::masks::{MaskFiles, TrueMasks};
use crate::placement::Placement;

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
        Self { path: path.to_owned(), why: why.to_string() }
    }
}

/// The kind of ground truth at a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TruthSource {
    /// A file of boxes.
    Boxes(PathBuf),
    /// A CDnet folder.
    Cdnet(PathBuf),
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
        let scene = [path.join("truth"), path.to_owned()];
        match scene.into_iter().find(|folder| folder.join("gt.txt").is_file()) {
            Some(scene) => Ok(Self::Scene(scene)),
            None if !path.exists() => Err(TruthError::new(path, "it does not exist; check the path")),
            None => Err(TruthError::new(
                path,
                "unknown ground truth format; use a MOTChallenge file, a CDnet folder with groundtruth/, \
                 or a scene written by `synth`",
            )),
        }
    }
}

/// Reads the boxes of a scene's folder of ground truth.
pub fn boxes_of_scene(folder: &Path) -> Result<Boxes, TruthError> {
    boxes::read(&folder.join("gt.txt"))
}

/// The masks of a scene's folder of ground truth, if it has any.
pub fn masks_of_scene(folder: &Path) -> Result<Option<MaskFiles>, TruthError> {
    let identities = folder.join("identities");
    identities.is_dir().then(|| MaskFiles::of_identities(&identities)).transpose()
}

/// The ground truth of a sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The true boxes.
    pub boxes: Option<Boxes>,
    /// The true masks.
    pub masks: Option<Arc<TrueMasks>>,
}

impl Truth {
    /// Reads the ground truth at `path`: a MOTChallenge file, a CDnet folder, or a scene written by `synth`.
    pub fn read(path: &Path) -> Result<Self, TruthError> {
        let truth = match TruthSource::of(path)? {
            TruthSource::Boxes(file) => Self { boxes: Some(boxes::read(&file)?), masks: None },
            TruthSource::Cdnet(folder) => {
                Self { boxes: None, masks: MaskFiles::of_cdnet(&folder)?.read_all()?.map(Arc::new) }
            }
            TruthSource::Scene(folder) => {
                let masks = masks_of_scene(&folder)?;
                let masks = masks.map(|files| files.read_all()).transpose()?.flatten();
                Self { boxes: Some(boxes_of_scene(&folder)?), masks: masks.map(Arc::new) }
            }
        };
        if truth.boxes.is_none() && truth.masks.is_none() {
            let why = "no masks groundtruth/gt000001.png … found in it, or none within temporalROI.txt";
            return Err(TruthError::new(path, why));
        }
        Ok(truth)
    }

    /// The truth of frames that are placed in the source's images: boxes in their pixels, and masks of the source's size
    /// with the label at the centre of each of their pixels.
    #[must_use]
    pub fn in_frames(&self, placement: &Placement) -> Self {
        let boxes = self.boxes.as_ref().map(|boxes| boxes::in_frames(boxes, placement));
        let masks = self.masks.as_ref().map(|masks| {
            if masks.size() == placement.source() {
                Arc::new(masks.in_frames(placement))
            } else {
                Arc::clone(masks)
            }
        });
        Self { boxes, masks }
    }
}
