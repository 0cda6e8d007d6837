//! Ground truth of masks.

use std::collections::BTreeMap;

use super::*;
use crate::explain::pixel::region_shares::{PixelRegion, region_bounds};
use crate::truth::Truth;
use crate::truth::boxes::{Bounds, Boxes};
use crate::truth::decisions::Decisions;
use crate::truth::external::ExternalResults;
use crate::truth::mask_score::MaskScore;
use crate::truth::masks::{Label, TrueMask, TrueMasks};
use crate::truth::mixture_score::of_mixture;
use crate::truth::summary;

/// The resulting masks of some frames as truth, with the first row ignored.
fn masks_of(single_pass: &[ShownFrame]) -> Arc<TrueMasks> {
    let masks = single_pass.iter().step_by(3).map(|shown| {
        let mask = &shown.analysis.mask;
        let label = |(at, &level): (usize, &u8)| match level {
            _ if at < WIDTH as usize => Label::Uncounted,
            Mask::FOREGROUND => Label::Foreground,
            _ => Label::Background,
        };
        (shown.frame.number, Arc::new(TrueMask::new(mask.size, mask.data.iter().enumerate().map(label))))
    });
    Arc::new(TrueMasks::new(masks.collect()).unwrap())
}

fn truth_of_masks(masks: &Arc<TrueMasks>) -> Arc<Truth> {
    Arc::new(Truth { boxes: None, masks: Some(Arc::clone(masks)), ..Truth::default() })
}

#[test]
fn masks_are_scored_and_shown_with_their_frames() {
    let folder = scene();
    let (a, b) = (settings(), compare::other());
    let [of_a, of_b] = [&a, &b].map(|settings| single_pass(folder.path(), settings));
    let truth = masks_of(&of_a);
    let decisions: Decisions = of_b
        .iter()
        .filter_map(|shown| {
            let mut judge = truth.of(shown.frame.number)?.judge();
            shown.analysis.mask.runs().for_each(|run| judge.take(run));
            Some(judge.decisions())
        })
        .sum();
    assert!(decisions.fn_ > 100 && decisions.tp > 100, "{decisions:?}");

    let watched = WatchedSession::open(folder.path(), a.clone(), Start::First, 1 << 30);
    watched.wait_until_analysed();
    watched.request(settings_request(a, Some(b)));
    watched.request(Request::Truth(Some(truth_of_masks(&truth))));
    let state = watched.wait_until(|state| {
        let candidate = state.compared.as_ref().is_some_and(|candidate| candidate.timeline.score.is_some());
        candidate && state.timeline.score.is_some() && state.shown.as_ref().unwrap().truth.is_some()
    });
    let score = |timeline: &Timeline| timeline.score.as_ref().unwrap().masks.unwrap();
    let of_view = score(&state.timeline);
    assert_eq!((of_view.f_measure, of_view.pwc, of_view.frames), (1.0, 0.0, 20));
    assert_eq!(score(&state.compared.unwrap().timeline), MaskScore::new(20, decisions));
    assert_eq!(watched.show_and_wait(30).truth.as_ref(), truth.of(FIRST + 30));
    assert_eq!(watched.show_and_wait(31).truth, None);
    assert!(watched.show_and_wait(33).truth.is_some());
    watched.request(Request::Truth(None));
    watched
        .wait_until(|state| state.shown.as_ref().unwrap().truth.is_none() && state.timeline.score.is_none());
}

#[test]
fn a_region_is_scored_under_other_settings() {
    let folder = scene();
    let settings = settings();
    let truth = masks_of(&single_pass(folder.path(), &settings));
    let frames: Vec<_> = (0..FRAMES).filter(|position| FIRST + position <= truth.last()).collect();
    let (columns, rows) = region_bounds(PIXEL, 9, Size::new(WIDTH, HEIGHT));
    let mut source = source::open(&name(folder.path()), Options::default()).unwrap();
    let part: Vec<_> =
        frames.iter().map(|_| source.next_frame().unwrap().unwrap().cut(&columns, &rows)).collect();
    let labels: Vec<_> =
        part.iter().map(|frame| Some(truth.of(frame.number)?.cut(&columns, &rows))).collect();

    let watched = WatchedSession::open(folder.path(), settings.clone(), Start::First, 0);
    watched.request(Request::Tune(Some([TunableSetting::K, TunableSetting::T])));
    watched.request(Request::TuneRegion(Some(PixelRegion { centre: PIXEL, side: 9 })));
    watched.request(Request::Truth(Some(truth_of_masks(&truth))));
    let tuned = |settings: &Settings| {
        let learnt = FRAMES.min(decoded(folder.path(), settings).2 as u32);
        let parameters = Parameters { learnt, ..Parameters::new(settings) };
        let state = watched.wait_until(|state| {
            state.region_tuning.as_ref().is_some_and(|tuning| tuning.parameters == parameters)
        });
        let tuning = state.region_tuning.unwrap();
        assert_eq!((tuning.at, tuning.side, tuning.frames), (PIXEL, 9, 20));
        assert_eq!(tuning.present, of_mixture(&part, &labels, parameters));
        tuning
    };
    let first = tuned(&settings);
    assert!(first.present.all() == 20 * 81 && first.present.tp > 50, "{:?}", first.present);
    watched.request(settings_request(compare::other(), None));
    assert_ne!(tuned(&compare::other()).present, first.present);
    // Each one after the result of the previous one.
    for side in [1, 3, 5, 1, 3] {
        watched.request(Request::TuneRegion(Some(PixelRegion { centre: PIXEL, side })));
        watched.wait_until(|state| state.region_tuning.as_ref().is_some_and(|tuning| tuning.side == side));
    }
    watched.request(Request::TuneRegion(None));
    watched.request(Request::Truth(None));
    watched.wait_until(|state| state.region_tuning.is_none());
}

#[test]
fn external_results_are_scored_and_their_masks_shown() {
    let folder = scene();
    let of_a = single_pass(folder.path(), &settings());
    let truth = masks_of(&of_a);
    // The results of another method: masks without their left half, and boxes in some frames.
    let mask = |shown: &ShownFrame| {
        let is_left = |at: usize| at as u32 % WIDTH < WIDTH / 2;
        let data = shown.analysis.mask.data.iter().enumerate();
        let levels: Vec<u8> = data.map(|(at, &level)| if is_left(at) { 0 } else { level }).collect();
        Arc::new(TrueMask::of_identities(shown.analysis.mask.size, &levels))
    };
    let masks = of_a.iter().map(|shown| (shown.frame.number, mask(shown))).collect();
    let place = |number: u32| BTreeMap::from([(4, Bounds([f64::from(number), 5.0, 10.0, 20.0]))]);
    let boxes: Boxes = (FIRST + 2..FIRST + 9).map(|number| (number, place(number))).collect();
    let results = Arc::new(ExternalResults {
        name: "theirs".into(),
        boxes: Some(boxes.clone()),
        masks: TrueMasks::new(masks).map(Arc::new),
        remarks: Vec::new(),
    });
    let true_boxes: Boxes = (FIRST..FIRST + 9).map(|number| (number, place(number))).collect();
    let truth = Arc::new(Truth { boxes: Some(true_boxes.clone()), masks: Some(truth), ..Truth::default() });

    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.request(Request::External(Some(Arc::clone(&results))));
    let state = watched.wait_until_analysed();
    assert_eq!(state.external_score, None, "there is no ground truth");
    watched.request(Request::Truth(Some(Arc::clone(&truth))));
    let state = watched.wait_until(|state| state.external_score.is_some());
    let score = state.external_score.unwrap();
    let analysed = (FIRST..FIRST + FRAMES).collect();
    assert_eq!(*score, results.score(&truth, &analysed, false));
    assert_eq!(score.tracks, Some(summary::score(&true_boxes, &boxes)));
    assert_eq!(score.tracks.as_ref().unwrap().strict.recall, 7.0 / 9.0);
    let of_masks = score.masks.unwrap();
    assert_eq!((of_masks.frames, of_masks.decisions.fp), (20, 0));
    assert!(of_masks.decisions.fn_ > 100 && of_masks.decisions.tp > 100, "{of_masks:?}");
    let shown = watched.show_and_wait(30);
    assert_eq!(shown.external.as_ref(), results.mask(FIRST + 30));
    assert!(state.warnings.is_empty(), "{:?}", state.warnings);

    watched.request(Request::External(None));
    watched.wait_until(|state| {
        state.external_score.is_none() && state.shown.as_ref().unwrap().external.is_none()
    });
    // Masks of another size are ignored with a warning, and the boxes are scored.
    let small = Arc::new(TrueMask::of_identities(Size::new(4, 3), &[1; 12]));
    let masks = TrueMasks::new(BTreeMap::from([(FIRST, small)])).map(Arc::new);
    watched.request(Request::External(Some(Arc::new(ExternalResults {
        masks,
        ..ExternalResults::clone(&results)
    }))));
    // A score is published at once, a warning at a limited rate.
    let state = watched.wait_until(|state| state.external_score.is_some() && !state.warnings.is_empty());
    assert_eq!(state.external_score.unwrap().masks, None);
    assert!(state.warnings[0].starts_with("the masks of theirs are 4×3"), "{:?}", state.warnings);
}

#[test]
fn masks_of_another_size_are_refused_with_a_warning() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    let mask = TrueMask::of_identities(Size::new(4, 3), &[1; 12]);
    let masks = Arc::new(TrueMasks::new(BTreeMap::from([(FIRST, Arc::new(mask))])).unwrap());
    watched.request(Request::Truth(Some(truth_of_masks(&masks))));
    let state = watched.wait_until(|state| !state.warnings.is_empty());
    assert!(state.warnings[0].contains("4×3") && state.warnings[0].contains("96×64"), "{:?}", state.warnings);
    let state = watched.wait_until_analysed();
    assert_eq!(state.shown.unwrap().truth, None);
}
