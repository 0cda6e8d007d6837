//! Sources that are read with fewer and smaller frames.

use std::collections::BTreeMap;
use std::num::NonZeroU32;

use super::*;
use crate::export::source_pixels;
use crate::pipeline::{Analysis, offline_result};
use crate::placement::Placement;
use crate::truth::Truth;
use crate::truth::masks::{Label, TrueMask, TrueMasks};
use crate::truth::summary;

const OPTIONS: Options = Options { scale: Some(0.5), every: NonZeroU32::new(2), ..Options::AS_IS };

/// The analysis of the reduced frames in a single pass, and their place in the source.
fn analysed(video: &Path, settings: &Settings) -> (Vec<Analysis>, Pipeline, Placement) {
    let mut source = Registered::new(source::open(&name(video), OPTIONS).unwrap());
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
    let (analyses, pipeline, placement) = analysed(folder.path(), &settings());
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
    // Masks of neither size are still refused.
    let mask = Arc::new(TrueMask::of_identities(Size::new(4, 3), &[1; 12]));
    let masks = TrueMasks::new(BTreeMap::from([(FIRST, mask)])).map(Arc::new);
    watched.request(Request::Truth(Some(Arc::new(Truth { boxes: None, masks, ..Truth::default() }))));
    let state = watched.wait_until(|state| !state.warnings.is_empty());
    assert!(state.warnings[0].contains("4×3") && state.warnings[0].contains("96×64"), "{:?}", state.warnings);
}
