//! Scores masks against ground truth by CDnet's seven measures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use image::GrayImage;
use rayon::prelude::*;
use serde::Serialize;

use super::TruthError;
use super::boxes::span;
use super::decisions::Decisions;
use super::masks::{self, MaskFiles};
use super::share::share_or_zero;
use crate::frame::{Mask, Size};

/// The confusion matrix of all pixels, and the measures computed from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MaskScore {
    /// Number of scored frames.
    pub frames: usize,
    /// The confusion matrix.
    #[serde(flatten)]
    pub decisions: Decisions,
    /// tp / (tp + fn).
    pub recall: f64,
    /// tn / (tn + fp).
    pub specificity: f64,
    /// fp / (fp + tn).
    pub fpr: f64,
    /// fn / (tp + fn).
    pub fnr: f64,
    /// Percentage of wrong classifications.
    pub pwc: f64,
    /// 2·precision·recall / (precision + recall).
    pub f_measure: f64,
    /// tp / (tp + fp).
    pub precision: f64,
}

impl MaskScore {
    /// The measures from the confusion matrix of this number of frames.
    pub fn new(frames: usize, decisions: Decisions) -> Self {
        let Decisions { tp, fp, fn_, tn } = decisions;
        Self {
            frames,
            decisions,
            recall: share_or_zero(tp, tp + fn_),
            specificity: share_or_zero(tn, tn + fp),
            fpr: share_or_zero(fp, fp + tn),
            fnr: share_or_zero(fn_, tp + fn_),
            pwc: 100.0 * share_or_zero(fn_ + fp, decisions.all()),
            f_measure: decisions.f_measure(),
            precision: share_or_zero(tp, tp + fp),
        }
    }
}

/// The masks of results by frame number.
pub type MaskResults = BTreeMap<u32, PathBuf>;

/// The masks of a folder, `bin000001.png` … of a run or other names with numbers.
pub fn results_in(folder: &Path) -> Result<MaskResults, TruthError> {
    if folder.is_dir() { masks::numbered_images(folder) } else { Ok(MaskResults::new()) }
}

/// Scores the masks in `folder` for the frames with truth. Fails if no pixel of them counts.
pub fn score(folder: &Path, truth: &MaskFiles) -> Result<MaskScore, TruthError> {
    let found = results_in(folder)?;
    let pairs: Vec<_> = truth.numbers().filter_map(|number| Some((number, found.get(&number)?))).collect();
    if pairs.is_empty() {
        let Some(span) = span(&found) else {
            let why = "it has no masks for the ground truth; run with --masks";
            return Err(TruthError::new(folder, why));
        };
        return Err(truth.without_common_frame(folder, span));
    }
    let decisions = pairs.par_iter().map(|(number, path)| decide(truth, *number, path));
    let decisions: Vec<Decisions> = decisions.collect::<Result<_, TruthError>>()?;
    let decisions = decisions.into_iter().sum();
    truth.check_decisions(decisions, folder)?;
    Ok(MaskScore::new(pairs.len(), decisions))
}

/// Compares the mask in a file with the true one of the frame `number`. Fails if it has other levels than those of
/// foreground and background.
pub(super) fn decide(truth: &MaskFiles, number: u32, path: &Path) -> Result<Decisions, TruthError> {
    let (Some(truth), found) = (truth.read(number)?, masks::read(path)?) else {
        return Ok(Decisions::default());
    };
    let (width, height) = found.dimensions();
    if Size::new(width, height) != truth.size() {
        let why = format!(
            "it is {} and the true mask is {}; give masks of the size of the ground truth, scaled without new levels \
             (nearest neighbour)",
            Size::new(width, height),
            truth.size()
        );
        return Err(TruthError::new(path, why));
    }
    Ok(truth.score(&mask_of(path, &found)?))
}

/// Reads the mask of a result. Fails if it has other levels than those of foreground and background.
pub(super) fn read_result(path: &Path) -> Result<Mask, TruthError> {
    mask_of(path, &masks::read(path)?)
}

/// The mask in an image, which was read from `path`.
fn mask_of(path: &Path, image: &GrayImage) -> Result<Mask, TruthError> {
    if let Some(level) = image.iter().find(|level| !matches!(level, 0 | 1 | 255)) {
        let why = format!("it has the level {level}; results are masks of 0 and 255, so apply a threshold");
        return Err(TruthError::new(path, why));
    }
    let data = image.iter().map(|&level| if level > 0 { Mask::FOREGROUND } else { Mask::BACKGROUND });
    let (width, height) = image.dimensions();
    Ok(Mask { size: Size::new(width, height), data: data.collect() })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn measures_follow_from_counts() {
        let score = MaskScore::new(1, Decisions { tp: 6, fp: 2, fn_: 4, tn: 88 });
        assert_eq!((score.recall, score.precision, score.pwc), (0.6, 0.75, 6.0));
        assert!((score.f_measure - 2.0 * 0.6 * 0.75 / 1.35).abs() < 1e-12);
        assert!((score.specificity - 88.0 / 90.0).abs() < 1e-12 && (score.fnr - 0.4).abs() < 1e-12);
    }

    #[test]
    fn unknown_and_outside_pixels_are_ignored_and_shadow_is_negative() {
        let folder = tempfile::tempdir().unwrap();
        let (masks, truth) = (folder.path().join("masks"), folder.path().join("truth"));
        std::fs::create_dir_all(&masks).unwrap();
        std::fs::create_dir_all(truth.join("groundtruth")).unwrap();
        let write = |path: PathBuf, levels: [u8; 8]| {
            GrayImage::from_raw(8, 1, levels.to_vec()).unwrap().save(path).unwrap();
        };
        for number in 1..=3 {
            let levels = [255, 255, 0, 50, 50, 85, 170, 255];
            write(truth.join(format!("groundtruth/gt{number:06}.png")), levels);
            write(masks.join(format!("bin{number:06}.png")), [255, 0, 255, 255, 0, 255, 255, 0]);
        }
        write(truth.join("ROI.bmp"), [255, 255, 255, 255, 255, 255, 255, 0]);
        std::fs::write(truth.join("temporalROI.txt"), "2 9\n").unwrap();
        let score_all = || score(&masks, &MaskFiles::of_cdnet(&truth).unwrap());
        let scored = score_all().unwrap();
        let Decisions { tp, fp, fn_, tn } = scored.decisions;
        assert_eq!((scored.frames, [tp, fp, fn_, tn]), (2, [2, 4, 2, 2]));
        // Where no pixel counts, no measure is defined.
        write(truth.join("ROI.bmp"), [0; 8]);
        let line = score_all().unwrap_err().to_string();
        assert!(line.contains("no pixel") && line.contains("ROI.bmp"), "{line}");
        write(truth.join("ROI.bmp"), [255, 255, 255, 255, 255, 255, 255, 0]);
        std::fs::write(truth.join("temporalROI.txt"), "8 9").unwrap();
        assert!(score_all().unwrap_err().to_string().contains("--masks"));
        std::fs::write(truth.join("temporalROI.txt"), "2 9\n").unwrap();
        // One of another size, which a sequence of CDnet has, is left out with a warning.
        GrayImage::new(4, 2).save(truth.join("ROI.bmp")).unwrap();
        let files = MaskFiles::of_cdnet(&truth).unwrap();
        assert!(files.remark().is_some_and(|remark| remark.contains("ROI.bmp is 4×2 and the masks are 8×1")));
        let Decisions { tp, fp, fn_, tn } = score(&masks, &files).unwrap().decisions;
        assert_eq!([tp, fp, fn_, tn], [2, 4, 4, 2], "the last pixel counts");
        // In a folder of masks without levels of their own for it, it is an error.
        let folder = truth.join("groundtruth");
        GrayImage::new(4, 2).save(folder.join("ROI.bmp")).unwrap();
        let files = MaskFiles::of_folder(&folder).unwrap();
        assert!(files.read(2).unwrap_err().to_string().contains("ROI.bmp"));
    }
}
