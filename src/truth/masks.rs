//! Masks against CDnet's ground truth: its seven measures, over the region and frames of interest.

use std::path::{Path, PathBuf};

use image::GrayImage;
use rayon::prelude::*;
use serde::Serialize;

use super::TruthError;

/// CDnet's grey levels of pixels that do not count.
const OUTSIDE: u8 = 85;
const UNKNOWN: u8 = 170;
/// And of moving ones; shadow (50) and static (0) are negative.
const MOTION: u8 = 255;

/// Counts of pixels, and what follows from them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MaskScore {
    /// Frames that were scored.
    pub frames: usize,
    /// Foreground that was found.
    pub tp: u64,
    /// Background that was taken for foreground.
    pub fp: u64,
    /// Foreground that was missed.
    #[serde(rename = "fn")]
    pub fn_: u64,
    /// Background that was left alone.
    pub tn: u64,
    /// tp / (tp + fn).
    pub recall: f64,
    /// tn / (tn + fp).
    pub specificity: f64,
    /// fp / (fp + tn).
    pub fpr: f64,
    /// fn / (tp + fn).
    pub fnr: f64,
    /// Per cent of wrong decisions.
    pub pwc: f64,
    /// 2·precision·recall / (precision + recall).
    pub f_measure: f64,
    /// tp / (tp + fp).
    pub precision: f64,
}

impl MaskScore {
    fn of_counts(frames: usize, [tp, fp, fn_, tn]: [u64; 4]) -> Self {
        let share = |part: u64, whole: u64| part as f64 / whole.max(1) as f64;
        Self {
            frames,
            tp,
            fp,
            fn_,
            tn,
            recall: share(tp, tp + fn_),
            specificity: share(tn, tn + fp),
            fpr: share(fp, fp + tn),
            fnr: share(fn_, tp + fn_),
            pwc: 100.0 * share(fn_ + fp, tp + fp + fn_ + tn),
            f_measure: share(2 * tp, 2 * tp + fp + fn_),
            precision: share(tp, tp + fp),
        }
    }
}

/// Scores `masks/bin000001.png` … of a run against a CDnet folder: `groundtruth/gt000001.png` …,
/// and, where they are there, `ROI.bmp` or `ROI.jpg` and `temporalROI.txt`.
pub fn score_cdnet(masks: &Path, truth: &Path) -> Result<MaskScore, TruthError> {
    let roi = ["ROI.bmp", "ROI.jpg", "ROI.png"]
        .map(|name| truth.join(name))
        .into_iter()
        .find(|path| path.is_file());
    let roi = roi.map(|path| read(&path)).transpose()?;
    let (first, last) = temporal_roi(&truth.join("temporalROI.txt"))?;
    let folder = truth.join("groundtruth");
    let numbers = numbers(&folder, "gt")?.into_iter().filter(|number| (first..=last).contains(number));
    let decide = |level: u8| match level {
        OUTSIDE | UNKNOWN => None,
        level => Some(level == MOTION),
    };
    score(numbers.collect(), masks, |number| folder.join(format!("gt{number:06}.png")), decide, roi.as_ref())
}

/// Scores masks against a scene of `synth`, whose truth tells who is seen at each pixel.
pub fn score_scene(masks: &Path, identities: &Path) -> Result<MaskScore, TruthError> {
    let numbers = numbers(identities, "")?;
    score(numbers, masks, |number| identities.join(format!("{number:06}.png")), |level| Some(level > 0), None)
}

/// Adds up the frames of which there is a mask.
fn score(
    numbers: Vec<u32>,
    masks: &Path,
    truth: impl Fn(u32) -> PathBuf + Sync,
    decide: impl Fn(u8) -> Option<bool> + Sync,
    roi: Option<&GrayImage>,
) -> Result<MaskScore, TruthError> {
    let pairs: Vec<_> = numbers
        .into_iter()
        .map(|number| (truth(number), masks.join(format!("bin{number:06}.png"))))
        .filter(|(_, mask)| mask.is_file())
        .collect();
    if pairs.is_empty() {
        let why = "it has no mask of a frame that the truth has; analyse with --masks, and without a range that leaves them out";
        return Err(TruthError::new(masks, why));
    }
    let count = |(truth_path, mask_path): &(PathBuf, PathBuf)| {
        let (truth, mask) = (read(truth_path)?, read(mask_path)?);
        for (path, image) in [(mask_path, Some(&mask)), (truth_path, roi)] {
            if image.is_some_and(|image| image.dimensions() != truth.dimensions()) {
                let (width, height) = truth.dimensions();
                return Err(TruthError::new(
                    path,
                    format!("its size is not that of the truth, {width}×{height}"),
                ));
            }
        }
        let mut counts = [0; 4];
        for (index, (truth, mask)) in truth.iter().zip(mask.iter()).enumerate() {
            if roi.is_some_and(|roi| roi.as_raw()[index] == 0) {
                continue;
            }
            match (decide(*truth), *mask > 0) {
                (None, _) => {}
                (Some(true), true) => counts[0] += 1,
                (Some(false), true) => counts[1] += 1,
                (Some(true), false) => counts[2] += 1,
                (Some(false), false) => counts[3] += 1,
            }
        }
        Ok(counts)
    };
    let counts = pairs
        .par_iter()
        .map(count)
        .try_reduce(|| [0; 4], |a, b| Ok(std::array::from_fn(|index| a[index] + b[index])))?;
    Ok(MaskScore::of_counts(pairs.len(), counts))
}

fn read(path: &Path) -> Result<GrayImage, TruthError> {
    image::open(path)
        .map(|image| image.to_luma8())
        .map_err(|error| TruthError::new(path, format!("{error}; check that it is whole")))
}

/// The numbers in names such as `gt000001.png`, in order.
fn numbers(folder: &Path, prefix: &str) -> Result<Vec<u32>, TruthError> {
    let entries = std::fs::read_dir(folder).map_err(|error| TruthError::new(folder, error))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut numbers: Vec<u32> =
        names.filter_map(|name| name.strip_prefix(prefix)?.strip_suffix(".png")?.parse().ok()).collect();
    numbers.sort_unstable();
    Ok(numbers)
}

/// The first and last frame of interest; all where the file is not there.
fn temporal_roi(path: &Path) -> Result<(u32, u32), TruthError> {
    if !path.is_file() {
        return Ok((0, u32::MAX));
    }
    let text = std::fs::read_to_string(path).map_err(|error| TruthError::new(path, error))?;
    let mut ends = text.split_whitespace().map(str::parse);
    match (ends.next(), ends.next()) {
        (Some(Ok(first)), Some(Ok(last))) => Ok((first, last)),
        _ => Err(TruthError::new(path, "it takes two frame numbers, the first and the last of interest")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn measures_follow_from_counts() {
        let score = MaskScore::of_counts(1, [6, 2, 4, 88]);
        assert_eq!((score.recall, score.precision, score.pwc), (0.6, 0.75, 6.0));
        assert!((score.f_measure - 2.0 * 0.6 * 0.75 / 1.35).abs() < 1e-12);
        assert!((score.specificity - 88.0 / 90.0).abs() < 1e-12 && (score.fnr - 0.4).abs() < 1e-12);
    }

    #[test]
    fn unknown_pixels_and_those_outside_do_not_count_and_shadow_is_negative() {
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
        let score = score_cdnet(&masks, &truth).unwrap();
        assert_eq!((score.frames, [score.tp, score.fp, score.fn_, score.tn]), (2, [2, 4, 2, 2]));
        std::fs::write(truth.join("temporalROI.txt"), "8 9").unwrap();
        assert!(score_cdnet(&masks, &truth).unwrap_err().to_string().contains("--masks"));
    }
}
