//! Two choices of settings on the same frames.

use super::*;
use crate::pipeline::offline_result;
use crate::truth::Truth;
use crate::truth::boxes::Boxes;
use crate::truth::summary::{self, Score};

pub(super) fn other() -> Settings {
    Settings { k: 4, alpha: 0.06, match_sigmas: 1.8, bootstrap: Span::Frames(12), ..settings() }
}

/// The frames under both settings at a position.
fn shown_under_both(watched: &WatchedSession, position: u32) -> (Arc<ShownFrame>, Arc<ShownFrame>) {
    watched.request(Request::Show(position));
    let shown = watched
        .wait_until(|state| shows(state, position) && state.shown.as_ref().unwrap().compared.is_some())
        .shown
        .unwrap();
    let candidate = shown.compared.clone().unwrap();
    (shown, candidate)
}

/// Waits until all frames are analysed under both settings.
fn wait_until_both_analysed(watched: &WatchedSession) -> State {
    watched.wait_until(|state| {
        let candidate =
            state.compared.as_ref().is_some_and(|candidate| candidate.timeline.analysed == FRAMES);
        candidate && state.timeline.complete && state.timeline.analysed == FRAMES && state.busy.is_none()
    })
}

fn boxes(video: &Path, settings: &Settings) -> Boxes {
    let (info, frames, first) = decoded(video, settings);
    let mut pipeline = learned_pipeline(settings, &info, &frames[..first]);
    let all: Vec<_> = frames.iter().map(|frame| pipeline.step(frame).unwrap()).collect();
    summary::boxes_of(&offline_result(all.iter(), &pipeline))
}

#[test]
fn compared_passes_equal_single_passes() {
    let folder = scene();
    let (a, b) = (settings(), other());
    let expected = [single_pass(folder.path(), &a), single_pass(folder.path(), &b)];
    let differ = |(a, b): &(ShownFrame, ShownFrame)| a.analysis.mask != b.analysis.mask;
    assert!(expected[0].iter().cloned().zip(expected[1].iter().cloned()).filter(differ).count() > 20);
    let frame_bytes = (WIDTH * HEIGHT * 3) as usize;
    for budget in [1 << 30, frame_bytes * 160, 0] {
        let watched = WatchedSession::open(folder.path(), a.clone(), Start::First, budget);
        watched.request(settings_request(a.clone(), Some(b.clone())));
        for (step, position) in seek_positions().map(|position| position.min(FRAMES - 1)).take(30).enumerate()
        {
            if step == 10 {
                watched.request(Request::Inspect(Some(PIXEL)));
            }
            let (shown, candidate) = shown_under_both(&watched, position);
            assert_same(&shown, &expected[0][position as usize]);
            assert_same(&candidate, &expected[1][position as usize]);
        }
        let last = wait_until_both_analysed(&watched);
        let candidate = last.compared.unwrap();
        for (got, expected) in [(&*last.timeline, &expected[0]), (&candidate.timeline, &expected[1])] {
            let shares: Vec<_> =
                expected.iter().map(|shown| shown.analysis.mask.foreground_share()).collect();
            assert_eq!(got.foreground_share, shares);
        }
        let with_pixel = |state: &State| {
            let shown = state.shown.as_ref().unwrap();
            shown.pixel.is_some() && shown.compared.as_ref().unwrap().pixel.is_some()
        };
        let shown = watched.wait_until(with_pixel).shown.unwrap();
        for (shown, expected) in [(&shown, &expected[0]), (shown.compared.as_ref().unwrap(), &expected[1])] {
            let (history, single_pass) = (shown.pixel.as_ref().unwrap(), &expected[shown.position as usize]);
            let single_pass = single_pass.pixel.as_ref().unwrap();
            assert_eq!(history.parameters, single_pass.parameters);
            assert_eq!(history.states[..=shown.position as usize], single_pass.states[..]);
        }
        watched.request(Request::Inspect(Some((1, 1))));
        watched.wait_until(|state| {
            with_pixel(state)
                && state.shown.as_ref().unwrap().compared.as_ref().unwrap().pixel.as_ref().unwrap().at
                    == (1, 1)
        });
        watched.request(settings_request(a.clone(), None));
        watched
            .wait_until(|state| state.shown.as_ref().unwrap().compared.is_none() && state.compared.is_none());
    }
}

#[test]
fn swapping_the_compared_settings_runs_nothing_again() {
    let folder = scene();
    let (a, b) = (settings(), other());
    let expected = [single_pass(folder.path(), &a), single_pass(folder.path(), &b)];
    let watched = WatchedSession::open(folder.path(), a.clone(), Start::First, 1 << 30);
    watched.request(Request::Show(30));
    watched.wait_until_analysed();
    // The first copy shares the run.
    watched.request(settings_request(a.clone(), Some(a.clone())));
    let equal = watched.wait_until(|state| state.shown.as_ref().unwrap().compared.is_some());
    assert_same(equal.shown.unwrap().compared.as_ref().unwrap(), &expected[0][30]);
    assert!(equal.compared.is_none());
    // The previous settings in view become those to compare with.
    watched.request(settings_request(b.clone(), Some(a.clone())));
    watched.wait_until(|state| {
        let shown = state.shown.as_ref().unwrap();
        let kept = state.compared.as_ref().is_none_or(|candidate| candidate.timeline.analysed == FRAMES);
        assert!(kept, "the analysed frames are kept");
        *shown.settings == b && shown.compared.is_some()
    });
    wait_until_both_analysed(&watched);
    for (in_view, candidate, at) in [(&a, &b, 0), (&b, &a, 1), (&a, &b, 0)] {
        watched.request(settings_request(in_view.clone(), Some(candidate.clone())));
        let state = watched.wait_until(|state| {
            assert_eq!(state.timeline.analysed, FRAMES, "no frame is analysed again");
            let shown = state.shown.as_ref().unwrap();
            *shown.settings == *in_view
                && shown.compared.as_ref().is_some_and(|shown| *shown.settings == *candidate)
                && state.compared.as_ref().is_some_and(|now| *now.settings == *candidate)
        });
        let shown = state.shown.unwrap();
        assert_same(&shown, &expected[at][30]);
        assert_same(shown.compared.as_ref().unwrap(), &expected[1 - at][30]);
    }
    // Settings that affect neither mask nor regions, for either side.
    let (late, area) = (Settings { gate: 0.9, ..a.clone() }, half_roi(true));
    watched.request(settings_request(a.clone(), Some(late.clone())));
    watched.request(Request::Roi(Some(Arc::clone(&area))));
    let [expected_a, expected_late] =
        [&a, &late].map(|settings| single_pass_within(folder.path(), settings, Some(&area)));
    wait_until_both_analysed(&watched);
    for position in [50, 20] {
        let (shown, candidate) = shown_under_both(&watched, position);
        assert_same(&shown, &expected_a[position as usize]);
        assert_same(&candidate, &expected_late[position as usize]);
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
    let truth = Arc::new(Truth { boxes: Some(boxes_of_a), masks: None, ..Truth::default() });
    let watched = WatchedSession::open(folder.path(), a.clone(), Start::First, 1 << 30);
    watched.request(settings_request(a, Some(b)));
    watched.request(Request::Truth(Some(truth)));
    let state = watched.wait_until(|state| {
        let candidate = state.compared.as_ref();
        state.timeline.score.is_some()
            && candidate.is_some_and(|candidate| candidate.timeline.score.is_some())
    });
    let score = |timeline: &Timeline| Score::clone(timeline.score.as_ref().unwrap());
    assert_eq!(score(&state.timeline).tracks.unwrap().strict.mota, 1.0);
    assert_eq!(score(&state.compared.unwrap().timeline), Score { tracks: Some(expected), masks: None });
    watched.request(Request::Truth(None));
    watched.wait_until(|state| state.timeline.score.is_none());
}
