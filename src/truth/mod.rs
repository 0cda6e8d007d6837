//! Ground truth, and how far what was found agrees with it.
//!
//! [`boxes`] reads tracks as MOTChallenge has them, [`clear_mot`] and [`survival`] score them, [`summary`] by both;
//! [`masks`] reads masks as CDnet has them, [`decisions`] and [`mask_score`] score pixels by them; [`event_scoring`]
//! scores events and episodes of rendered scenes.

pub mod boxes;
pub mod clear_mot;
pub mod decisions;
pub mod event_scoring;
pub mod mask_score;
pub mod masks;
pub mod summary;
pub mod survival;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::boxes::Boxes;
use self::masks::{MaskFiles, TrueMasks};

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

/// The kind of ground truth at a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TruthSource {
    /// A file of boxes.
    Boxes(PathBuf),
    /// A CDnet folder.
    Cdnet(PathBuf),
    /// The folder of truth of a scene that `synth` wrote.
    Scene(PathBuf),
}

impl TruthSource {
    /// Detects the kind.
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

/// The boxes of a scene's folder of truth.
pub fn boxes_of_scene(folder: &Path) -> Result<Boxes, TruthError> {
    boxes::read(&folder.join("gt.txt"))
}

/// The masks of a scene's folder of truth, if it has some.
pub fn masks_of_scene(folder: &Path) -> Result<Option<MaskFiles>, TruthError> {
    let identities = folder.join("identities");
    identities.is_dir().then(|| MaskFiles::of_identities(&identities)).transpose()
}

/// The ground truth of a sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Where objects are.
    pub boxes: Option<Boxes>,
    /// Which pixels are foreground.
    pub masks: Option<Arc<TrueMasks>>,
}

impl Truth {
    /// Reads whatever lies at `path`: a MOTChallenge file, a CDnet folder, or a scene written by `synth`.
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
}
