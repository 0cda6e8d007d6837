//! Sources that are read with fewer and smaller frames.

use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroU32;
use std::path::PathBuf;

use image::GrayImage;
use serde::Serialize;
use serde_json::Value;

use super::*;
use crate::export::{source_pixels, tracks_csv};
use crate::pipeline::{Analysis, offline_result};
use crate::placement::{Crop, Placement};
use crate::truth::analysed_frames::AnalysedFrames;
use crate::truth::comparison::Comparison;
use crate::truth::external::ExternalResults;
use crate::truth::formats::{self, Role};
use crate::truth::masks::{Label, TrueMask, TrueMasks};
use crate::truth::sequence_truth::SequenceTruth;
use crate::truth::{Truth, mask_score, summary};

const OPTIONS: Options = Options { scale: Some(0.5), every: NonZeroU32::new(2), ..Options::AS_IS };

/// The analysis of the reduced frames in a single pass, and their place in the source.
fn analysed(video: &Path, settings: &Settings, options: Options) -> (Vec<Analysis>, Pipeline, Placement) {
    let mut source = Registered::new(source::open(&name(video), options).unwrap());
    let info = source.info().clone();
    let frames: Vec<_> = std::iter::from_fn(|| source.next_frame().unwrap()).collect();
    let mut pipeline = learned_pipeline(settings, &info, &frames[..info.bootstrap(settings) as usize]);
    let analyses = frames.iter().map(|frame| pipeline.step(frame).unwrap()).collect();
    (analyses, pipeline, info.placement().unwrap())
}

/// The result as ground truth in the source's pixels: its masks, and its boxes in all frames of the source.
fn truth_of(analyses: &[Analysis], pipeline: &Pipeline, placement: &Placement) -> Truth {
    let mut result = offline_result(analyses, pipeline);
    source_pixels::move_tracks(&mut result.tracks, placement);
    let mut boxes = summary::boxes_of(&result);
    for (number, of_frame) in boxes.clone() {
        boxes.insert(number + 1, of_frame);
    }
    let mask = |analysis: &Analysis| {
        let mask = placement.source_mask(&analysis.mask);
        let label = |&level| if level == Mask::FOREGROUND { Label::Foreground } else { Label::Background };
        Arc::new(TrueMask::new(mask.size, mask.data.iter().map(label)))
    };
    let masks: BTreeMap<_, _> = analyses.iter().map(|analysis| (analysis.number, mask(analysis))).collect();
    Truth { boxes: Some(boxes), masks: TrueMasks::new(masks).map(Arc::new), ..Truth::default() }
}

#[test]
fn ground_truth_of_the_source_is_compared_with_reduced_frames() {
    let folder = scene();
    let (analyses, pipeline, placement) = analysed(folder.path(), &settings(), OPTIONS);
    let truth = truth_of(&analyses, &pipeline, &placement);
    assert!(truth.boxes.as_ref().unwrap().len() > 20, "there are tracks");

    let path = name(folder.path());
    let open = move || FrameCache::open(&path, OPTIONS, 1 << 20);
    let watched = WatchedSession::start(&name(folder.path()), open, 1 << 20, settings(), Start::First);
    watched.request(Request::Truth(Some(Arc::new(truth.clone()))));
    watched.request(Request::Inspect(Some((7, 9))));
    let state = watched.wait_until(|state| state.timeline.score.is_some() && state.pixel.is_some());
    let numbers: Vec<u32> = (FIRST..FIRST + FRAMES).step_by(2).collect();
    assert_eq!(state.timeline.numbers, numbers);
    let score = state.timeline.score.clone().unwrap();
    let masks = score.masks.unwrap();
    assert_eq!((masks.f_measure, masks.pwc, masks.frames), (1.0, 0.0, numbers.len()));
    let tracks = &score.tracks.as_ref().unwrap().strict;
    assert_eq!((tracks.mota, tracks.recall, tracks.precision), (1.0, 1.0, 1.0));
    assert_eq!(state.warnings, Arc::new(Vec::new()));
    assert_eq!(state.pixel.unwrap().source_pixel(), (15, 19), "of columns 14 and 15, rows 18 and 19");

    for position in [9, 3, 20] {
        let shown = watched.show_and_wait(position);
        let analysis = &analyses[position as usize];
        assert_eq!(shown.analysis.mask, analysis.mask);
        let of_source = truth.masks.as_ref().unwrap().of(analysis.number).unwrap();
        assert_eq!(shown.truth.as_deref(), Some(&of_source.in_frame(&placement)));
    }
    // The same as results of another method: they are as good, and in the frames' pixels.
    let boxes = truth.boxes.as_ref().unwrap().iter().filter(|(number, _)| numbers.contains(number));
    let boxes = boxes.map(|(number, boxes)| (*number, boxes.clone())).collect();
    let results =
        ExternalResults { boxes: Some(boxes), masks: truth.masks.clone(), ..ExternalResults::default() };
    watched.request(Request::External(Some(Arc::new(results))));
    let state = watched.wait_until(|state| state.external_score.is_some());
    let external = state.external_score.unwrap();
    assert_eq!(external.masks, score.masks);
    assert!(agree(&external.tracks, &score.tracks), "{external:?} {score:?}");
    let shown = watched.show_and_wait(5);
    assert!(shown.external.is_some() && shown.external == shown.truth);

    // Masks of neither size are still refused.
    let mask = Arc::new(TrueMask::of_identities(Size::new(4, 3), &[1; 12]));
    let masks = TrueMasks::new(BTreeMap::from([(FIRST, mask)])).map(Arc::new);
    watched.request(Request::Truth(Some(Arc::new(Truth { boxes: None, masks, ..Truth::default() }))));
    let state = watched.wait_until(|state| !state.warnings.is_empty());
    assert!(state.warnings[0].contains("4×3") && state.warnings[0].contains("96×64"), "{:?}", state.warnings);
}

/// The true boxes and masks of the scene as files of the source, and the masks' folder.
fn write_truth(place: &Path) -> (PathBuf, PathBuf) {
    let (boxes, masks) = (place.join("gt.txt"), place.join("masks"));
    fs::create_dir(&masks).unwrap();
    let mut rows = Vec::new();
    for index in 0..FRAMES {
        let squares = [(4 + index * 3 / 2, 26), (84_u32.saturating_sub(index * 3 / 2), 28)];
        let squares = squares.into_iter().filter(|_| index > 4);
        for ((left, top), id) in squares.clone().zip(1..) {
            rows.push(format!("{},{id},{left},{top},9,14,1\n", FIRST + index));
        }
        let is_in = |x: u32, y: u32| {
            let holds = |(left, top)| (left..left + 9).contains(&x) && (top..top + 14).contains(&y);
            squares.clone().any(holds)
        };
        let mask = GrayImage::from_fn(WIDTH, HEIGHT, |x, y| [if is_in(x, y) { 255 } else { 0 }].into());
        mask.save(masks.join(format!("{:06}.png", FIRST + index))).unwrap();
    }
    fs::write(&boxes, rows.concat()).unwrap();
    (boxes, masks)
}

/// Whether all numbers of two scores are equal, up to the rounding of boxes.
fn agree(a: &impl Serialize, b: &impl Serialize) -> bool {
    fn equal(a: &Value, b: &Value) -> bool {
        match (a, b) {
            (Value::Object(a), Value::Object(b)) => {
                a.len() == b.len()
                    && a.iter().zip(b).all(|((key, a), (other, b))| key == other && equal(a, b))
            }
            (Value::Number(a), Value::Number(b)) => (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-6,
            _ => a == b,
        }
    }
    equal(&serde_json::to_value(a).unwrap(), &serde_json::to_value(b).unwrap())
}

#[test]
fn what_is_outside_the_crop_is_judged_neither_here_nor_by_score() {
    let (folder, place) = (scene(), tempfile::tempdir().unwrap());
    let part = Crop { x: 20, y: 30, width: 44, height: 30 };
    let options = Options { crop: Some(part), ..Options::AS_IS };
    let (analyses, pipeline, placement) = analysed(folder.path(), &settings(), options);
    let (boxes, masks) = write_truth(place.path());

    // The results as files, in the source's pixels.
    let results = place.path().join("results");
    fs::create_dir(&results).unwrap();
    let mut result = offline_result(&analyses, &pipeline);
    source_pixels::move_tracks(&mut result.tracks, &placement);
    let tracks = place.path().join("tracks.csv");
    let mut file = fs::File::create(&tracks).unwrap();
    result.tracks.iter().try_for_each(|frame| tracks_csv::write_frame(&mut file, frame)).unwrap();
    for analysis in &analyses {
        let Mask { size, data } = placement.source_mask(&analysis.mask);
        let mask = GrayImage::from_raw(size.width, size.height, data).unwrap();
        mask.save(results.join(format!("bin{:06}.png", analysis.number))).unwrap();
    }
    let found = formats::read(&tracks, Role::Results).unwrap();
    let numbers = AnalysedFrames::of_numbers(analyses.iter().map(|analysis| analysis.number)).unwrap();
    let scores = |part: Option<Crop>| {
        let read = |path: &Path| {
            let truth = SequenceTruth::read(path, 0).unwrap();
            match part {
                Some(part) => truth.within(part),
                None => truth,
            }
        };
        let (of_boxes, of_masks) = (read(&boxes).tracks.unwrap(), read(&masks).masks.unwrap());
        let tracks = Comparison::new(&of_boxes, &found, &numbers, 0).score();
        (tracks, mask_score::score(&results, &of_masks).unwrap())
    };
    let (of_tracks, of_masks) = scores(Some(part));
    let (whole_tracks, whole_masks) = scores(None);
    assert!(of_tracks.strict.recall > whole_tracks.strict.recall + 0.1, "{of_tracks:?} {whole_tracks:?}");
    assert!(of_masks.recall > whole_masks.recall + 0.1, "{of_masks:?} {whole_masks:?}");
    assert_eq!(of_masks.decisions.all(), u64::from(part.width * part.height * FRAMES));

    let truth = Truth { masks: Truth::read(&masks).unwrap().masks, ..Truth::read(&boxes).unwrap() };
    let path = name(folder.path());
    let open = move || FrameCache::open(&path, options, 1 << 20);
    let watched = WatchedSession::start(&name(folder.path()), open, 1 << 20, settings(), Start::First);
    watched.request(Request::Truth(Some(Arc::new(truth))));
    let state = watched.wait_until(|state| state.timeline.score.is_some());
    let score = state.timeline.score.clone().unwrap();
    assert_eq!(score.masks, Some(of_masks));
    let tracks = score.tracks.as_ref().unwrap();
    assert!(agree(tracks, &of_tracks), "{tracks:?}, not {of_tracks:?}");
}
