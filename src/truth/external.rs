//! Results of another method on the same video, to compare and score beside ours.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::boxes::{self, Boxes};
use super::decisions::Decisions;
use super::formats::{self, Role};
use super::ignored::without_ignored;
use super::mask_score::{self, MaskScore};
use super::masks::{TrueMask, TrueMasks};
use super::result_source::ResultSource;
use super::run_summary::{MasksOfRun, RunSummary};
use super::summary::{self, Score};
use super::{Truth, TruthError};
use crate::placement::Placement;

/// Results of another method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExternalResults {
    /// The name of their file or folder.
    pub name: String,
    /// The boxes, if they have any.
    pub boxes: Option<Boxes>,
    /// The masks, if they have any: foreground and background, without ignored pixels.
    pub masks: Option<Arc<TrueMasks>>,
    /// What was left out or changed while reading, a clause each.
    pub remarks: Vec<String>,
}

impl ExternalResults {
    /// Reads the results at `path`, of any kind of [`ResultSource`]. Fails with the file that cannot be read, or if there
    /// are neither tracks nor masks.
    pub fn read(path: &Path) -> Result<Self, TruthError> {
        let mut remarks = Vec::new();
        let (tracks, masks): (Option<PathBuf>, Option<PathBuf>) = match ResultSource::of(path)? {
            ResultSource::Tracks(path) => (Some(path), None),
            ResultSource::Masks(folder) => (None, Some(folder)),
            ResultSource::Run(folder) => {
                let tracks = folder.join("tracks.csv");
                let masks = match MasksOfRun::find(&folder, RunSummary::read(&folder)?.as_ref()) {
                    MasksOfRun::None => None,
                    MasksOfRun::Of(masks) => Some(masks),
                    MasksOfRun::OfEarlierRun(_) => {
                        remarks.push("its masks are of an earlier run and left out".to_owned());
                        None
                    }
                };
                (tracks.is_file().then_some(tracks), masks)
            }
        };
        let file = tracks.map(|path| formats::read(&path, Role::Results)).transpose()?;
        let masks = masks.map(|folder| masks_in(&folder)).transpose()?.flatten();
        if file.is_none() && masks.is_none() {
            let why = "no tracks or masks found in it; use a file of tracks, a folder of masks or of label \
                       images, or the output folder of `run`";
            return Err(TruthError::new(path, why));
        }
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let boxes = file.map(|file| {
            remarks.extend(file.remarks);
            file.boxes
        });
        Ok(Self { name, boxes, masks: masks.map(Arc::new), remarks })
    }

    /// The results of frames that are placed in the source's images: boxes in their pixels, and masks of the source's
    /// size with the value at the centre of each of their pixels.
    #[must_use]
    pub fn in_frames(&self, placement: &Placement) -> Self {
        let boxes = self.boxes.as_ref().map(|boxes| boxes::in_frames(boxes, placement));
        let masks = self.masks.as_ref().map(|masks| masks.fitted(placement));
        Self { boxes, masks, ..self.clone() }
    }

    /// The mask of a frame.
    pub fn mask(&self, number: u32) -> Option<&Arc<TrueMask>> {
        self.masks.as_ref()?.of(number)
    }

    /// Whether there is a box or a mask of a frame.
    pub fn has_frame(&self, number: u32) -> bool {
        self.boxes.as_ref().is_some_and(|boxes| boxes.contains_key(&number)) || self.mask(number).is_some()
    }

    /// The numbers of the first and the last frame with a box or a mask.
    pub fn span(&self) -> Option<(u32, u32)> {
        let of_boxes = self.boxes.as_ref().and_then(boxes::span);
        let of_masks = self.masks.as_ref().map(|masks| (masks.first(), masks.last()));
        let spans = of_boxes.into_iter().chain(of_masks);
        spans.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1)))
    }

    /// Scores them against `truth` in the frames of the numbers in `analysed`, as ours are scored: masks in those frames
    /// that have one here and there. Where the sequence `leaves_out` frames, objects in these are not missed.
    pub fn score(&self, truth: &Truth, analysed: &BTreeSet<u32>, leaves_out: bool) -> Score {
        let tracks = truth.boxes.as_ref().zip(self.boxes.as_ref()).map(|(boxes, found)| {
            let of_frames = found.iter().filter(|(number, _)| analysed.contains(number));
            let found: Boxes = of_frames.map(|(number, boxes)| (*number, boxes.clone())).collect();
            let found = without_ignored(boxes, &truth.ignored, &found);
            if leaves_out {
                summary::score_of_frames(boxes, &found, |number| analysed.contains(&number))
            } else {
                summary::score(boxes, &found)
            }
        });
        let masks = truth.masks.as_ref().zip(self.masks.as_ref());
        let masks = masks.filter(|(masks, found)| masks.size() == found.size());
        let masks = masks.map(|(masks, found)| {
            let pairs = analysed.iter().filter_map(|&number| Some((masks.of(number)?, found.of(number)?)));
            let decisions: Vec<Decisions> = pairs.map(|(mask, found)| mask.score_labels(found)).collect();
            MaskScore::new(decisions.len(), decisions.into_iter().sum())
        });
        Score { tracks, masks: masks.filter(|score| score.frames > 0) }
    }
}

/// The masks of a folder; `None` if there are none.
fn masks_in(folder: &Path) -> Result<Option<TrueMasks>, TruthError> {
    let paths = mask_score::results_in(folder)?;
    let masks = paths.par_iter().map(|(&number, path)| {
        let mask = mask_score::read_result(path)?;
        Ok((number, Arc::new(TrueMask::of_identities(mask.size, &mask.data))))
    });
    let masks = masks.collect::<Result<BTreeMap<_, _>, TruthError>>()?;
    TrueMasks::of_files(masks, &paths)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use image::GrayImage;

    use super::*;
    use crate::frame::Size;
    use crate::placement::Crop;
    use crate::truth::boxes::Bounds;
    use crate::truth::masks::Label;

    const SIZE: Size = Size::new(4, 2);

    fn write_mask(folder: &Path, name: &str, levels: [u8; 8]) {
        std::fs::create_dir_all(folder).unwrap();
        GrayImage::from_raw(4, 2, levels.to_vec()).unwrap().save(folder.join(name)).unwrap();
    }

    /// An object that walks by ten pixels per frame in frames 1 to 4.
    fn walk() -> Boxes {
        let place = |number: u32| Bounds([f64::from(10 * number), 0.0, 10.0, 20.0]);
        (1..=4).map(|number| (number, BTreeMap::from([(1, place(number))]))).collect()
    }

    #[test]
    fn tracks_masks_and_output_folders_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let tracker = folder.path().join("tracker.txt");
        std::fs::write(&tracker, "1,7,2,3,10,20,1,-1,-1,-1\n3,7,4,3,10,20,1,-1,-1,-1\n").unwrap();
        let read = ExternalResults::read(&tracker).unwrap();
        assert_eq!(
            (read.name.as_str(), read.span(), read.masks.is_none()),
            ("tracker.txt", Some((1, 3)), true)
        );
        assert_eq!(read.boxes.as_ref().unwrap()[&3][&7], Bounds([4.0, 3.0, 10.0, 20.0]));
        assert_eq!([1, 2, 3].map(|number| read.has_frame(number)), [true, false, true]);

        let masks = folder.path().join("masks of x");
        write_mask(&masks, "bin000002.png", [0, 255, 255, 0, 0, 0, 0, 255]);
        write_mask(&masks, "bin000005.png", [0, 1, 0, 0, 0, 0, 0, 0]);
        let read = ExternalResults::read(&masks).unwrap();
        assert_eq!(
            (read.name.as_str(), read.span(), read.boxes.is_none()),
            ("masks of x", Some((2, 5)), true)
        );
        let mask = read.mask(2).unwrap();
        assert_eq!(
            (mask.at(2, 0), mask.at(3, 1), mask.at(0, 0)),
            (Some(Label::Foreground), Some(Label::Foreground), Some(Label::Background))
        );

        // The output of `run`: both, or one of them.
        let run = folder.path().join("run");
        write_mask(&run.join("masks"), "bin000001.png", [0; 8]);
        let read = ExternalResults::read(&run).unwrap();
        assert!(read.boxes.is_none() && read.mask(1).is_some());
        std::fs::copy(&tracker, run.join("tracks.csv")).unwrap();
        let read = ExternalResults::read(&run).unwrap();
        assert!(read.boxes.is_some_and(|boxes| boxes.len() == 2) && read.masks.is_some());
        // A later run into the same folder that wrote no masks.
        let summary = r#"{"input":{"frames":3,"first_frame":1,"last_frame":3},"large_files":[]}"#;
        std::fs::write(run.join("summary.json"), summary).unwrap();
        let read = ExternalResults::read(&run).unwrap();
        assert!(read.boxes.is_some() && read.masks.is_none());
        assert_eq!(read.remarks, ["its masks are of an earlier run and left out"]);

        let labels = folder.path().join("labels");
        std::fs::create_dir(&labels).unwrap();
        let image = image::ImageBuffer::from_fn(4, 2, |x, _| image::Luma([if x == 2 { 9_u16 } else { 0 }]));
        image.save(labels.join("000004.png")).unwrap();
        let read = ExternalResults::read(&labels).unwrap();
        assert_eq!(read.boxes.unwrap()[&4][&9], Bounds([2.0, 0.0, 1.0, 2.0]));
    }

    #[test]
    fn what_cannot_be_read_is_an_error_of_one_line_with_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let why = |path: &Path| ExternalResults::read(path).unwrap_err().to_string();
        let names = |path: &Path, word: &str| {
            let why = why(path);
            assert!(why.contains(word) && !why.contains('\n'), "{why}");
        };
        names(&folder.path().join("none"), "none cannot be used: it does not exist");
        names(folder.path(), "no tracks or masks");
        let masks = folder.path().join("m");
        write_mask(&masks, "bin000001.png", [0; 8]);
        write_mask(&masks, "bin000002.png", [0, 127, 0, 0, 0, 0, 0, 0]);
        names(&masks, "bin000002.png cannot be used: it has the level 127");
        GrayImage::new(5, 2).save(masks.join("bin000002.png")).unwrap();
        names(&masks, "5×2");
        let text = folder.path().join("notes.txt");
        std::fs::write(&text, "1,1,a,b,c,d\n").unwrap();
        names(&text, "notes.txt cannot be used");
    }

    #[test]
    fn boxes_are_scored_in_the_analysed_frames() {
        let truth = Truth { boxes: Some(walk()), ..Truth::default() };
        // The identity changes in frame 3, frame 4 is missed, and frame 9 is none of the video's.
        let mut boxes = walk();
        let third = boxes[&3][&1];
        boxes.insert(3, BTreeMap::from([(2, third)]));
        boxes.remove(&4);
        boxes.insert(9, BTreeMap::from([(5, third)]));
        let found = ExternalResults { boxes: Some(boxes.clone()), ..ExternalResults::default() };
        let score = found.score(&truth, &(1..=4).collect(), false);
        let tracks = score.tracks.unwrap();
        // One of four boxes is missed, and there is one switch: 1 − (1 + 0 + 1)/4.
        assert_eq!((tracks.strict.mota, tracks.strict.num_switches), (0.5, 1));
        assert_eq!((tracks.strict.precision, tracks.strict.recall), (1.0, 0.75));
        // IDTP 2, IDFP 1, IDFN 2.
        assert_eq!(tracks.strict.idf1, 4.0 / 7.0);
        boxes.remove(&9);
        assert_eq!(tracks, summary::score(&walk(), &boxes), "as ours");
        assert_eq!(score.masks, None);

        let score = found.score(&truth, &[1, 2, 3].into(), true).tracks.unwrap();
        assert_eq!((score.strict.mota, score.strict.recall), (1.0 - 1.0 / 3.0, 1.0), "frame 4 was left out");
        let none = found.score(&Truth::default(), &(1..=4).collect(), false);
        assert_eq!(none, Score { tracks: None, masks: None });
    }

    #[test]
    fn masks_are_scored_where_both_have_one() {
        let folder = tempfile::tempdir().unwrap();
        let (masks, truth) = (folder.path().join("m"), folder.path().join("t"));
        let levels = [255, 255, 0, 50, 85, 170, 0, 255];
        for number in 1..=3 {
            write_mask(&truth.join("groundtruth"), &format!("gt{number:06}.png"), levels);
        }
        for number in 2..=4 {
            write_mask(&masks, &format!("bin{number:06}.png"), [255, 0, 255, 0, 255, 255, 0, 255]);
        }
        let (found, truth_data) = (ExternalResults::read(&masks).unwrap(), Truth::read(&truth).unwrap());
        let score = found.score(&truth_data, &(1..=9).collect(), false).masks.unwrap();
        let Decisions { tp, fp, fn_, tn } = score.decisions;
        assert_eq!((score.frames, [tp, fp, fn_, tn]), (2, [4, 2, 2, 4]));
        // The same as `occluscope score`.
        let files = crate::truth::masks::MaskFiles::of_cdnet(&truth).unwrap();
        assert_eq!(score, mask_score::score(&masks, &files).unwrap());
        assert_eq!(found.score(&truth_data, &[3].into(), false).masks.unwrap().frames, 1);
        assert_eq!(found.score(&truth_data, &[9].into(), false).masks, None);
    }

    #[test]
    fn results_move_into_the_pixels_of_reduced_frames() {
        let crop = Crop { x: 2, y: 0, width: 2, height: 2 };
        let placement = Placement::new(SIZE, Some(crop), None).unwrap();
        let mask = Arc::new(TrueMask::of_identities(SIZE, &[0, 0, 1, 0, 0, 0, 0, 1]));
        let results = ExternalResults {
            name: "x".into(),
            boxes: Some(walk()),
            masks: TrueMasks::new(BTreeMap::from([(1, mask)])).map(Arc::new),
            remarks: Vec::new(),
        };
        let moved = results.in_frames(&placement);
        assert_eq!(moved.boxes.as_ref().unwrap()[&2][&1], Bounds([18.0, 0.0, 10.0, 20.0]));
        let [background, foreground] = [Label::Background, Label::Foreground];
        assert_eq!(moved.mask(1).unwrap().labels(), [foreground, background, background, foreground]);
        // Masks of the frames' own size stay as they are.
        assert_eq!(moved.in_frames(&placement).masks, moved.masks);
    }
}
