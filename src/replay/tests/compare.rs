//! Two choices of settings on the same frames.

use super::*;
use crate::pipeline::offline_result;
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::summary;

pub(super) fn other() -> Settings {
    Settings { k: 4, alpha: 0.06, match_sigmas: 1.8, bootstrap: Span::Frames(12), ..settings() }
}

/// The frames under both settings at a position.
fn both(watched: &Watched, position: u32) -> (Arc<ShownFrame>, Arc<ShownFrame>) {
    watched.session.show(position);
    let shown = watched
        .until(|state| shows(state, position) && state.shown.as_ref().unwrap().compared.is_some())
        .shown
        .unwrap();
    let beside = shown.compared.clone().unwrap();
    (shown, beside)
}

/// Waits until all frames are analysed under both settings.
fn until_both_done(watched: &Watched) -> State {
    watched.until(|state| {
        let beside = state.compared.as_ref().is_some_and(|beside| beside.timeline.analysed == FRAMES);
        beside && state.timeline.complete && state.timeline.analysed == FRAMES && state.busy.is_none()
    })
}

fn boxes(video: &Path, settings: &Settings) -> Boxes {
    let (info, frames, first) = decoded(video, settings);
    let mut pipeline = begun(settings, &info, &frames[..first]);
    let all: Vec<_> = frames.iter().map(|frame| pipeline.step(frame).unwrap()).collect();
    summary::boxes_of(&offline_result(all.iter(), &pipeline))
}

#[test]
fn compared_passes_equal_single_passes() {
    let folder = scene();
    let (a, b) = (settings(), other());
    let expected = [straight(folder.path(), &a), straight(folder.path(), &b)];
    let differ = |(a, b): &(ShownFrame, ShownFrame)| a.analysis.mask != b.analysis.mask;
    assert!(expected[0].iter().cloned().zip(expected[1].iter().cloned()).filter(differ).count() > 20);
    let frame_bytes = (WIDTH * HEIGHT * 3) as usize;
    for budget in [1 << 30, frame_bytes * 160, 0] {
        let watched = Watched::open(folder.path(), a.clone(), Start::First, budget);
        watched.session.compare(a.clone(), Some(b.clone()));
        for (step, position) in walk().map(|position| position.min(FRAMES - 1)).take(30).enumerate() {
            if step == 10 {
                watched.session.inspect(Some(PIXEL));
            }
            let (shown, beside) = both(&watched, position);
            assert_same(&shown, &expected[0][position as usize]);
            assert_same(&beside, &expected[1][position as usize]);
        }
        let last = until_both_done(&watched);
        let beside = last.compared.unwrap();
        for (got, expected) in [(&*last.timeline, &expected[0]), (&beside.timeline, &expected[1])] {
            let shares: Vec<_> =
                expected.iter().map(|shown| shown.analysis.mask.foreground_share()).collect();
            assert_eq!(got.foreground_share, shares);
        }
        let with_pixel = |state: &State| {
            let shown = state.shown.as_ref().unwrap();
            shown.pixel.is_some() && shown.compared.as_ref().unwrap().pixel.is_some()
        };
        let shown = watched.until(with_pixel).shown.unwrap();
        for (shown, expected) in [(&shown, &expected[0]), (shown.compared.as_ref().unwrap(), &expected[1])] {
            let (history, straight) = (shown.pixel.as_ref().unwrap(), &expected[shown.position as usize]);
            let straight = straight.pixel.as_ref().unwrap();
            assert_eq!(history.parameters, straight.parameters);
            assert_eq!(history.states[..=shown.position as usize], straight.states[..]);
        }
        watched.session.inspect(Some((1, 1)));
        watched.until(|state| {
            with_pixel(state)
                && state.shown.as_ref().unwrap().compared.as_ref().unwrap().pixel.as_ref().unwrap().at
                    == (1, 1)
        });
        watched.session.compare(a.clone(), None);
        watched.until(|state| state.shown.as_ref().unwrap().compared.is_none() && state.compared.is_none());
    }
}

#[test]
fn swapping_the_compared_settings_runs_nothing_again() {
    let folder = scene();
    let (a, b) = (settings(), other());
    let expected = [straight(folder.path(), &a), straight(folder.path(), &b)];
    let watched = Watched::open(folder.path(), a.clone(), Start::First, 1 << 30);
    watched.session.show(30);
    watched.until_done();
    // The first copy shares the run.
    watched.session.compare(a.clone(), Some(a.clone()));
    let equal = watched.until(|state| state.shown.as_ref().unwrap().compared.is_some());
    assert_same(equal.shown.unwrap().compared.as_ref().unwrap(), &expected[0][30]);
    assert!(equal.compared.is_none());
    // The previous settings in view become those to compare with.
    watched.session.compare(b.clone(), Some(a.clone()));
    watched.until(|state| {
        let shown = state.shown.as_ref().unwrap();
        let kept = state.compared.as_ref().is_none_or(|beside| beside.timeline.analysed == FRAMES);
        assert!(kept, "the analysed frames are kept");
        *shown.settings == b && shown.compared.is_some()
    });
    until_both_done(&watched);
    for (in_view, beside, at) in [(&a, &b, 0), (&b, &a, 1), (&a, &b, 0)] {
        watched.session.compare(in_view.clone(), Some(beside.clone()));
        let state = watched.until(|state| {
            assert_eq!(state.timeline.analysed, FRAMES, "no frame is analysed again");
            let shown = state.shown.as_ref().unwrap();
            *shown.settings == *in_view
                && shown.compared.as_ref().is_some_and(|shown| *shown.settings == *beside)
                && state.compared.as_ref().is_some_and(|now| *now.settings == *beside)
        });
        let shown = state.shown.unwrap();
        assert_same(&shown, &expected[at][30]);
        assert_same(shown.compared.as_ref().unwrap(), &expected[1 - at][30]);
    }
    // Settings that affect neither mask nor regions, for either side.
    let (late, area) = (Settings { gate: 0.9, ..a.clone() }, half(true));
    watched.session.compare(a.clone(), Some(late.clone()));
    watched.session.set_roi(Some(Arc::clone(&area)));
    let [expected_a, expected_late] =
        [&a, &late].map(|settings| straight_within(folder.path(), settings, Some(&area)));
    until_both_done(&watched);
    for position in [50, 20] {
        let (shown, beside) = both(&watched, position);
        assert_same(&shown, &expected_a[position as usize]);
        assert_same(&beside, &expected_late[position as usize]);
    }
}

#[test]
fn both_passes_are_scored_against_the_truth() {
    let folder = scene();
    let (a, b) = (settings(), other());
    let boxes_of_a = boxes(folder.path(), &a);
    assert!(boxes_of_a.len() > 30);
    let expected = summary::score(&boxes_of_a, &boxes(folder.path(), &b));
    assert!(expected.strict.mota < 1.0);
    let truth = Arc::new(Truth { boxes: Some(boxes_of_a), masks: None });
    let watched = Watched::open(folder.path(), a.clone(), Start::First, 1 << 30);
    watched.session.compare(a, Some(b));
    watched.session.set_truth(Some(truth));
    let state = watched.until(|state| {
        let beside = state.compared.as_ref();
        state.timeline.score.is_some() && beside.is_some_and(|beside| beside.timeline.score.is_some())
    });
    let score = |timeline: &Timeline| Score::clone(timeline.score.as_ref().unwrap());
    assert_eq!(score(&state.timeline).tracks.unwrap().strict.mota, 1.0);
    assert_eq!(score(&state.compared.unwrap().timeline), Score { tracks: Some(expected), masks: None });
    watched.session.set_truth(None);
    watched.until(|state| state.timeline.score.is_none());
}
