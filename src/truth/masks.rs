//! True masks: CDnet's ground truth, or the identity at each pixel of a scene of `synth`.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::GrayImage;
use rayon::prelude::*;

use super::TruthError;
use super::boxes;
use super::decisions::Decisions;
use crate::frame::{Mask, Size};
use crate::placement::{Crop, Placement};

/// CDnet's gray level of pixels outside the region of interest, which are ignored.
const OUTSIDE: u8 = 85;
/// CDnet's gray level of unknown pixels, which are ignored.
const UNKNOWN: u8 = 170;
/// CDnet's gray level of moving pixels; shadow (50) and static (0) are background.
const MOTION: u8 = 255;

/// All of CDnet's levels.
const LEVELS: [u8; 5] = [0, 50, OUTSIDE, UNKNOWN, MOTION];

/// The true label of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Label {
    /// Background.
    Background,
    /// Foreground.
    Foreground,
    /// Ignored: unknown or outside the region of interest; not scored.
    Uncounted,
}

/// The true label of each pixel of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrueMask {
    size: Size,
    /// The runs of all labels except background, in row order.
    runs: Vec<TruthRun>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct TruthRun {
    pixels: Range<u32>,
    counts: bool,
}

impl TrueMask {
    /// A mask from the label of each pixel, in row order.
    pub fn new(size: Size, labels: impl IntoIterator<Item = Label>) -> Self {
        let mut runs: Vec<TruthRun> = Vec::new();
        for (at, label) in (0..size.pixels() as u32).zip(labels) {
            let counts = label == Label::Foreground;
            match runs.last_mut() {
                _ if label == Label::Background => {}
                Some(run) if run.pixels.end == at && run.counts == counts => run.pixels.end = at + 1,
                _ => runs.push(TruthRun { pixels: at..at + 1, counts }),
            }
        }
        Self { size, runs }
    }

    /// A mask from the identity at each pixel of a rendered scene, 0 being background.
    pub fn of_identities(size: Size, identities: &[u8]) -> Self {
        Self::new(size, identities.iter().map(|&identity| label_of_identity(identity)))
    }

    /// Width and height.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The label at (x, y); `None` outside the image.
    pub fn at(&self, x: u32, y: u32) -> Option<Label> {
        let at = self.size.index(x, y)? as u32;
        let run = self.runs.get(self.runs.partition_point(|run| run.pixels.end <= at));
        Some(match run {
            Some(run) if run.pixels.start <= at && run.counts => Label::Foreground,
            Some(run) if run.pixels.start <= at => Label::Uncounted,
            _ => Label::Background,
        })
    }

    /// The label of each pixel, in row order.
    pub fn labels(&self) -> Vec<Label> {
        let mut labels = vec![Label::Background; self.size.pixels()];
        for run in &self.runs {
            let label = if run.counts { Label::Foreground } else { Label::Uncounted };
            labels[run.pixels.start as usize..run.pixels.end as usize].fill(label);
        }
        labels
    }

    /// The part within these columns and rows, which must be inside the image.
    pub fn cut(&self, columns: &Range<u32>, rows: &Range<u32>) -> Self {
        let size = Size::new(columns.len() as u32, rows.len() as u32);
        let mut runs = Vec::new();
        for row in rows.clone() {
            let start = row * self.size.width;
            let (from, to) = (start + columns.start, start + columns.end);
            let first = self.runs.partition_point(|run| run.pixels.end <= from);
            let moved = |at: u32| (row - rows.start) * size.width + at.clamp(from, to) - from;
            runs.extend(self.runs[first..].iter().take_while(|run| run.pixels.start < to).map(|run| {
                TruthRun { pixels: moved(run.pixels.start)..moved(run.pixels.end), counts: run.counts }
            }));
        }
        Self { size, runs }
    }

    /// The same labels in a part of the image, [`Label::Uncounted`] outside.
    #[must_use]
    pub fn within(&self, part: &Crop) -> Self {
        let width = self.size.width;
        let is_inside = |at: u32| part.contains(at % width, at / width);
        let labels = (0..).zip(self.labels());
        Self::new(self.size, labels.map(|(at, label)| if is_inside(at) { label } else { Label::Uncounted }))
    }

    /// The mask of a frame that is placed in an image of this size: the label at the centre of each of its pixels.
    #[must_use]
    pub fn in_frame(&self, placement: &Placement) -> Self {
        let labels = self.labels();
        Self::new(placement.size(), placement.centres().map(|at| labels[at]))
    }

    /// Scores a mask of the same size.
    pub fn score(&self, mask: &Mask) -> Decisions {
        let mut judge = self.judge();
        mask.runs().for_each(|run| judge.take(run));
        judge.decisions()
    }

    /// Scores a mask of the same size that is given by its labels.
    pub fn score_labels(&self, found: &Self) -> Decisions {
        let mut judge = self.judge();
        let foreground = found.runs.iter().filter(|run| run.counts);
        foreground.for_each(|run| judge.take(run.pixels.start as usize..run.pixels.end as usize));
        judge.decisions()
    }

    /// Starts to score a mask of the same size, run by run.
    pub fn judge(&self) -> Judge<'_> {
        Judge { mask: self, at: 0, found: 0, right: 0, uncounted: 0 }
    }

    /// Number of foreground pixels and of ignored pixels.
    fn totals(&self) -> [u64; 2] {
        let mut totals = [0; 2];
        for run in &self.runs {
            totals[usize::from(!run.counts)] += run.pixels.len() as u64;
        }
        totals
    }
}

const fn label_of_identity(identity: u8) -> Label {
    if identity > 0 { Label::Foreground } else { Label::Background }
}

/// Compares a mask with the true one, run by run.
pub struct Judge<'a> {
    mask: &'a TrueMask,
    /// The first run of the truth that the next run can intersect.
    at: usize,
    found: u64,
    right: u64,
    uncounted: u64,
}

impl Judge<'_> {
    /// Adds the next run of foreground, in row order.
    pub fn take(&mut self, found: Range<usize>) {
        let runs = &self.mask.runs;
        self.found += found.len() as u64;
        while runs.get(self.at).is_some_and(|run| run.pixels.end as usize <= found.start) {
            self.at += 1;
        }
        for run in runs[self.at..].iter().take_while(|run| (run.pixels.start as usize) < found.end) {
            let shared = found.end.min(run.pixels.end as usize) - found.start.max(run.pixels.start as usize);
            *(if run.counts { &mut self.right } else { &mut self.uncounted }) += shared as u64;
        }
    }

    /// The counts after all runs have been added.
    pub fn decisions(self) -> Decisions {
        let [foreground, uncounted] = self.mask.totals();
        let wrong = self.found - self.right - self.uncounted;
        Decisions {
            tp: self.right,
            fp: wrong,
            fn_: foreground - self.right,
            tn: self.mask.size.pixels() as u64 - foreground - uncounted - wrong,
        }
    }
}

/// The true masks of a sequence, all of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueMasks {
    size: Size,
    masks: BTreeMap<u32, Arc<TrueMask>>,
}

impl TrueMasks {
    /// True masks by frame number; `None` if there are none, or their sizes differ.
    pub fn new(masks: BTreeMap<u32, Arc<TrueMask>>) -> Option<Self> {
        let size = masks.values().next()?.size;
        masks.values().all(|mask| mask.size == size).then_some(Self { size, masks })
    }

    /// Masks that were read from the files at `paths`; `None` if there are none. Fails with the file of one whose size
    /// differs from that of the first.
    pub(super) fn of_files(
        masks: BTreeMap<u32, Arc<TrueMask>>,
        paths: &BTreeMap<u32, PathBuf>,
    ) -> Result<Option<Self>, TruthError> {
        let Some(size) = masks.values().next().map(|mask| mask.size) else { return Ok(None) };
        if let Some((number, mask)) = masks.iter().find(|(_, mask)| mask.size != size) {
            let why = format!("it is {} and the first one is {size}; all must have the same size", mask.size);
            return Err(TruthError::new(&paths[number], why));
        }
        Ok(Self::new(masks))
    }

    /// The masks of frames that are placed in images of this size.
    #[must_use]
    pub fn in_frames(&self, placement: &Placement) -> Self {
        let masks = self.masks.par_iter().map(|(&number, mask)| (number, Arc::new(mask.in_frame(placement))));
        Self { size: placement.size(), masks: masks.collect() }
    }

    /// Masks of the source's size as those of frames that are placed in its images; others as they are.
    #[must_use]
    pub(super) fn fitted(self: &Arc<Self>, placement: &Placement) -> Arc<Self> {
        if self.size == placement.source() { Arc::new(self.in_frames(placement)) } else { Arc::clone(self) }
    }

    /// Width and height of each.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Number of frames with a mask.
    pub fn frames(&self) -> usize {
        self.masks.len()
    }

    /// The mask of a frame.
    pub fn of(&self, number: u32) -> Option<&Arc<TrueMask>> {
        self.masks.get(&number)
    }

    /// The number of the first frame with a mask.
    pub fn first(&self) -> u32 {
        self.masks.first_key_value().map_or(0, |(&number, _)| number)
    }

    /// The number of the last frame with a mask.
    pub fn last(&self) -> u32 {
        self.masks.last_key_value().map_or(0, |(&number, _)| number)
    }
}

/// Files of true masks, one per frame.
pub struct MaskFiles {
    paths: BTreeMap<u32, PathBuf>,
    label: fn(u8) -> Label,
    /// Whether levels that no mask has are an error, and those of a mask of 0 and 1 are accepted.
    is_strict: bool,
    /// What was added to the numbers.
    offset: i64,
    /// The region of interest, dark outside, and its file.
    roi: Option<(PathBuf, GrayImage)>,
    /// What was left out, a clause.
    remark: Option<String>,
    /// The part of the images outside of which pixels are ignored.
    part: Option<Crop>,
}

impl MaskFiles {
    /// The masks of a CDnet folder: `groundtruth/gt000001.png` …, and, if they exist, `ROI.bmp` or `ROI.jpg` and
    /// `temporalROI.txt`.
    pub fn of_cdnet(folder: &Path) -> Result<Self, TruthError> {
        Self::within_rois(folder, numbered(&folder.join("groundtruth"), "gt")?, false)
    }

    /// The masks of a folder of numbered images of CDnet's levels, of 0 and 255, or of 0 and 1, and, if they are in it,
    /// `ROI.bmp` or `ROI.jpg` and `temporalROI.txt`. The last number in a name is the frame's.
    pub fn of_folder(folder: &Path) -> Result<Self, TruthError> {
        Self::within_rois(folder, numbered_images(folder)?, true)
    }

    fn within_rois(
        folder: &Path,
        mut paths: BTreeMap<u32, PathBuf>,
        is_strict: bool,
    ) -> Result<Self, TruthError> {
        let roi = ["ROI.bmp", "ROI.jpg", "ROI.png"].map(|name| folder.join(name));
        let roi = roi.into_iter().find(|path| path.is_file());
        let mut roi = roi.map(|path| read(&path).map(|image| (path, image))).transpose()?;
        let mut remark = None;
        let size_of_masks = paths.values().next().and_then(|path| image::image_dimensions(path).ok());
        // A sequence of CDnet has a region of interest of another size; its masks mark what is outside, too.
        if !is_strict
            && let Some((width, height)) = size_of_masks
            && let Some((path, image)) = roi.take_if(|(_, image)| image.dimensions() != (width, height))
        {
            let name = path.file_name().unwrap_or_default().display();
            let (other_width, other_height) = image.dimensions();
            remark = Some(format!(
                "{name} is {other_width}×{other_height} and the masks are {width}×{height}: it is not applied, only \
                 level {OUTSIDE} of the masks is outside"
            ));
        }
        let (first, last) = temporal_roi(&folder.join("temporalROI.txt"))?;
        paths.retain(|number, _| (first..=last).contains(number));
        let label = |level| match level {
            OUTSIDE | UNKNOWN => Label::Uncounted,
            MOTION => Label::Foreground,
            _ => Label::Background,
        };
        Ok(Self { paths, label, is_strict, offset: 0, roi, remark, part: None })
    }

    /// The masks of a folder of identity images by `synth`: `000001.png` ….
    pub fn of_identities(folder: &Path) -> Result<Self, TruthError> {
        let paths = numbered(folder, "")?;
        Ok(Self {
            paths,
            label: label_of_identity,
            is_strict: false,
            offset: 0,
            roi: None,
            remark: None,
            part: None,
        })
    }

    /// The same masks with `offset` added to their numbers.
    #[must_use]
    pub fn shifted(self, offset: i64) -> Self {
        Self { paths: boxes::shifted(&self.paths, offset), offset: self.offset + offset, ..self }
    }

    /// The same masks with the pixels outside a part of the images ignored.
    #[must_use]
    pub fn within(self, part: Crop) -> Self {
        Self { part: Some(part), ..self }
    }

    /// The part of the images outside of which pixels are ignored; `None` if it is all of them.
    pub fn part(&self) -> Option<Crop> {
        self.part
    }

    /// What was left out of what is there, a clause.
    pub fn remark(&self) -> Option<&str> {
        self.remark.as_deref()
    }

    /// What [`Self::shifted`] added to the numbers.
    pub fn offset(&self) -> i64 {
        self.offset
    }

    /// The error that no frame from `first` to `last`, of the results in `path`, has a mask here.
    pub fn without_common_frame(&self, path: &Path, (first, last): (u32, u32)) -> TruthError {
        let numbers = self.numbers().next().zip(self.numbers().last());
        let Some((true_first, true_last)) = numbers else {
            let why = "no mask for a frame of the ground truth, which has none itself; check its folder and \
                       temporalROI.txt, and run with --masks";
            return TruthError::new(path, why);
        };
        let offset = self.offset + i64::from(first) - i64::from(true_first);
        let why = format!(
            "no mask for a frame of the ground truth: it has {true_first} to {true_last}, the masks {first} to \
             {last}; run with --masks and a range that includes these frames, or, if its numbers begin elsewhere, score \
             with --offset {offset}, which makes the first numbers equal"
        );
        TruthError::new(path, why)
    }

    /// Fails if there is no decision, as no pixel of the frames that the results in `path` and the ground truth have counts.
    pub fn check_decisions(&self, decisions: Decisions, path: &Path) -> Result<(), TruthError> {
        if decisions.all() > 0 {
            return Ok(());
        }
        let region = self.roi.as_ref().map(|_| ", outside ROI.bmp").unwrap_or_default();
        let part = self.part.map(|part| format!(", outside the crop {part}")).unwrap_or_default();
        let why = format!(
            "no pixel of its frames with a true mask counts, so that no measure is defined: all are unknown ({UNKNOWN}), \
             outside ({OUTSIDE}){region}{part} in the ground truth; give frames with judged pixels"
        );
        Err(TruthError::new(path, why))
    }

    /// The frame numbers in ascending order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.paths.keys().copied()
    }

    /// Reads the mask of a frame; `None` if there is none.
    pub fn read(&self, number: u32) -> Result<Option<TrueMask>, TruthError> {
        let Some(path) = self.paths.get(&number) else { return Ok(None) };
        let image = read(path)?;
        let (width, height) = image.dimensions();
        let label = if self.is_strict { strict_label(self.label, path, &image)? } else { self.label };
        let levels = image.iter();
        let mask = match &self.roi {
            None => TrueMask::new(Size::new(width, height), levels.map(|&level| label(level))),
            Some((path, roi)) => {
                if roi.dimensions() != (width, height) {
                    let why = format!("its size differs from the ground truth, {width}×{height}");
                    return Err(TruthError::new(path, why));
                }
                let counted = |(&level, &inside): (&u8, &u8)| {
                    if inside == 0 { Label::Uncounted } else { label(level) }
                };
                TrueMask::new(Size::new(width, height), levels.zip(roi.iter()).map(counted))
            }
        };
        Ok(Some(match &self.part {
            Some(part) => mask.within(part),
            None => mask,
        }))
    }

    /// Reads the mask of a frame, which must have this size; `None` if there is none.
    pub fn read_of_size(&self, number: u32, size: Size) -> Result<Option<TrueMask>, TruthError> {
        let mask = self.read(number)?;
        match (&mask, self.paths.get(&number)) {
            (Some(mask), Some(path)) if mask.size != size => {
                let why =
                    format!("it is {} and the video is {size}; both must have the same size", mask.size);
                Err(TruthError::new(path, why))
            }
            _ => Ok(mask),
        }
    }

    /// Reads all masks; `None` if there is no file.
    pub fn read_all(&self) -> Result<Option<TrueMasks>, TruthError> {
        let numbers: Vec<u32> = self.numbers().collect();
        let masks = numbers.par_iter().map(|&number| Ok((number, self.read(number)?)));
        let masks: Vec<_> = masks.collect::<Result<_, TruthError>>()?;
        let masks = masks.into_iter().filter_map(|(number, mask)| Some((number, Arc::new(mask?))));
        TrueMasks::of_files(masks.collect(), &self.paths)
    }
}

/// Reads an image as gray levels.
pub(super) fn read(path: &Path) -> Result<GrayImage, TruthError> {
    image::open(path).map(|image| image.to_luma8()).map_err(|error| {
        let why = error.to_string();
        TruthError::new(path, format!("{}; check that it is complete", why.trim_end_matches('.')))
    })
}

/// The function from the levels of an image to labels: `label` for CDnet's levels, another one for 0 and 1.
fn strict_label(
    label: fn(u8) -> Label,
    path: &Path,
    image: &GrayImage,
) -> Result<fn(u8) -> Label, TruthError> {
    if image.iter().all(|level| *level <= 1) {
        return Ok(label_of_identity);
    }
    match image.iter().find(|level| !LEVELS.contains(level)) {
        None => Ok(label),
        Some(level) => {
            let why = format!("it has the level {level}; masks have 0 and 255, or CDnet's {LEVELS:?}");
            Err(TruthError::new(path, why))
        }
    }
}

/// Whether masks have this level: CDnet's, and 1 as foreground.
pub(super) fn is_mask_level(level: u8) -> bool {
    level == 1 || LEVELS.contains(&level)
}

/// Whether the images of a folder are masks, by the levels of the first and the middle one.
pub(super) fn is_folder_of_masks(folder: &Path) -> bool {
    let Ok(paths) = numbered_images(folder) else { return false };
    let paths: Vec<_> = paths.into_values().collect();
    let is_mask =
        |path: &PathBuf| read(path).is_ok_and(|image| image.iter().all(|level| is_mask_level(*level)));
    !paths.is_empty() && is_mask(&paths[0]) && is_mask(&paths[paths.len() / 2])
}

/// What to do where the numbered images of a folder are JPEGs, which are not read; `None` if there are none.
pub(super) fn remark_on_jpegs(folder: &Path) -> Option<&'static str> {
    let is_jpeg = |path: &Path| {
        let ending = path.extension().unwrap_or_default();
        ["jpg", "jpeg"].iter().any(|it| ending.eq_ignore_ascii_case(it))
            && path.file_stem().is_some_and(|stem| last_number(&stem.to_string_lossy()).is_some())
    };
    let has_one = std::fs::read_dir(folder).ok()?.flatten().any(|entry| is_jpeg(&entry.path()));
    has_one.then_some(
        "its images are JPEGs, whose compression changes the levels; masks and label images are read from PNG, BMP, TIFF \
         and PGM",
    )
}

/// The images of a folder without loss (PNG, BMP, TIFF, PGM) by the last number in their names. Fails if two have the same
/// number.
pub(super) fn numbered_images(folder: &Path) -> Result<BTreeMap<u32, PathBuf>, TruthError> {
    let entries = std::fs::read_dir(folder).map_err(|error| TruthError::unreadable(folder, error))?;
    let mut paths: BTreeMap<u32, PathBuf> = BTreeMap::new();
    for entry in entries {
        let path = entry.map_err(|error| TruthError::unreadable(folder, error))?.path();
        let ending = path.extension().unwrap_or_default();
        let is_image = ["png", "bmp", "tif", "tiff", "pgm"].iter().any(|it| ending.eq_ignore_ascii_case(it));
        let number = path.file_stem().and_then(|stem| last_number(&stem.to_string_lossy()));
        let Some(number) = number.filter(|_| is_image) else { continue };
        if let Some(other) = paths.insert(number, path.clone()) {
            let why = format!("{} has the number {number} too; leave one of them", other.display());
            return Err(TruthError::new(&path, why));
        }
    }
    Ok(paths)
}

/// The last number in a name without its ending.
pub(super) fn last_number(stem: &str) -> Option<u32> {
    let end = stem.rfind(|it: char| it.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|it: char| !it.is_ascii_digit());
    // The character before can have several bytes.
    let start = start.map_or(0, |at| at + stem[at..].chars().next().map_or(0, char::len_utf8));
    stem[start..end].parse().ok()
}

/// The files with names such as `gt000001.png`, by number.
fn numbered(folder: &Path, prefix: &str) -> Result<BTreeMap<u32, PathBuf>, TruthError> {
    let entries = std::fs::read_dir(folder).map_err(|error| TruthError::unreadable(folder, error))?;
    let paths = entries.filter_map(|entry| {
        let entry = entry.ok()?;
        let name = entry.file_name().into_string().ok()?;
        let number = name.strip_prefix(prefix)?.strip_suffix(".png")?.parse().ok()?;
        Some((number, entry.path()))
    });
    Ok(paths.collect())
}

/// The first and last frame of interest; all frames if the file does not exist.
fn temporal_roi(path: &Path) -> Result<(u32, u32), TruthError> {
    if !path.is_file() {
        return Ok((0, u32::MAX));
    }
    let text = std::fs::read_to_string(path).map_err(|error| TruthError::unreadable(path, error))?;
    let mut ends = text.split_whitespace().map(str::parse);
    match (ends.next(), ends.next()) {
        (Some(Ok(first)), Some(Ok(last))) => Ok((first, last)),
        _ => Err(TruthError::new(path, "expected two frame numbers, the first and the last to evaluate")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use proptest::prelude::*;

    use super::*;

    const SIZE: Size = Size::new(9, 7);

    fn label(level: u8) -> Label {
        [Label::Background, Label::Foreground, Label::Uncounted][usize::from(level) % 3]
    }

    proptest! {
        #[test]
        fn each_pixel_is_scored_once(
            truth in prop::collection::vec(0_u8..3, SIZE.pixels()),
            found in prop::collection::vec(prop::bool::weighted(0.4), SIZE.pixels()),
            columns in 0_u32..8,
            rows in 0_u32..6,
        ) {
            let labels: Vec<_> = truth.iter().copied().map(label).collect();
            let mask = TrueMask::new(SIZE, labels.iter().copied());
            prop_assert_eq!(&mask.labels(), &labels);
            let found = Mask { size: SIZE, data: found.iter().map(|&found| if found { 255 } else { 0 }).collect() };
            let (columns, rows) = (columns..columns + 2, rows..rows + 2);
            let places = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
            let count = |places: &[(u32, u32)], found_one: bool, of: Label| {
                let is = |&&(x, y): &&(u32, u32)| found.is_foreground(x, y) == found_one && mask.at(x, y) == Some(of);
                places.iter().filter(is).count() as u64
            };
            let expected = |places: &[(u32, u32)]| Decisions {
                tp: count(places, true, Label::Foreground),
                fp: count(places, true, Label::Background),
                fn_: count(places, false, Label::Foreground),
                tn: count(places, false, Label::Background),
            };
            let all: Vec<_> = places.collect();
            prop_assert_eq!(mask.score(&found), expected(&all));

            let part: Vec<_> =
                all.iter().copied().filter(|(x, y)| columns.contains(x) && rows.contains(y)).collect();
            let cut = mask.cut(&columns, &rows);
            let of_part: Vec<_> = part.iter().map(|&(x, y)| mask.at(x, y).unwrap()).collect();
            prop_assert_eq!(cut.labels(), of_part);
            let data = part.iter().map(|&(x, y)| if found.is_foreground(x, y) { 255 } else { 0 }).collect();
            prop_assert_eq!(cut.score(&Mask { size: cut.size(), data }), expected(&part));
            let crop = Crop { x: columns.start, y: rows.start, width: 2, height: 2 };
            prop_assert_eq!(mask.within(&crop).score(&found), expected(&part));
        }
    }

    #[test]
    fn a_folder_of_masks_has_levels_of_masks() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, levels: [u8; 4]| {
            GrayImage::from_raw(4, 1, levels.to_vec()).unwrap().save(folder.path().join(name)).unwrap();
        };
        let labels = |number: u32| {
            let masks = MaskFiles::of_folder(folder.path()).unwrap();
            masks.read(number).map(|mask| mask.unwrap().labels())
        };
        let [background, foreground, uncounted] = [Label::Background, Label::Foreground, Label::Uncounted];
        write("cam2_mask-0007.png", [0, 50, 170, 255]);
        assert_eq!(labels(7).unwrap(), [background, background, uncounted, foreground]);
        write("cam2_mask-0008.png", [0, 1, 1, 0]);
        assert_eq!(labels(8).unwrap(), [background, foreground, foreground, background]);
        assert!(is_folder_of_masks(folder.path()));
        write("ROI.bmp", [255, 0, 255, 255]);
        std::fs::write(folder.path().join("temporalROI.txt"), "8 9").unwrap();
        assert_eq!(labels(8).unwrap(), [background, uncounted, foreground, background]);
        assert_eq!(
            MaskFiles::of_folder(folder.path()).unwrap().shifted(-3).numbers().collect::<Vec<_>>(),
            [5]
        );
        let right = Crop { x: 2, y: 0, width: 2, height: 1 };
        let mask = MaskFiles::of_folder(folder.path()).unwrap().within(right).read(8).unwrap().unwrap();
        assert_eq!(mask.labels(), [uncounted, uncounted, foreground, background]);
        write("cam2_mask-0009.png", [0, 37, 255, 0]);
        assert!(labels(9).unwrap_err().to_string().contains("37"));
        write("other-9.png", [0; 4]);
        assert!(numbered_images(folder.path()).unwrap_err().to_string().contains("number 9"));
        assert_eq!(
            (last_number("é12é"), last_number("no"), last_number("99999999999")),
            (Some(12), None, None)
        );
    }

    #[test]
    fn the_error_of_another_size_names_the_mask() {
        let folder = tempfile::tempdir().unwrap();
        GrayImage::new(4, 3).save(folder.path().join("000001.png")).unwrap();
        GrayImage::new(4, 3).save(folder.path().join("000002.png")).unwrap();
        let files = MaskFiles::of_identities(folder.path()).unwrap();
        let masks = files.read_all().unwrap().unwrap();
        assert_eq!((masks.frames(), masks.size(), masks.last()), (2, Size::new(4, 3), 2));
        GrayImage::new(5, 3).save(folder.path().join("000002.png")).unwrap();
        let why = files.read_all().unwrap_err().to_string();
        assert!(why.contains("000002.png") && why.contains("5×3"), "{why}");
        std::fs::write(folder.path().join("000002.png"), b"no picture").unwrap();
        assert!(files.read_all().unwrap_err().to_string().contains("000002.png"));
    }
}
