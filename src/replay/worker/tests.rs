#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use super::*;
use crate::explain::pixel::region_shares::PixelRegion;
use crate::explain::tuning::TunableSetting;
use crate::frame::Frame;
use crate::occlusion::EventKind;
use crate::replay::published::{ShownFrame, Timeline};
use crate::replay::tests::{
    FIRST, FRAMES, HEIGHT, LEARNT, PIXEL, WIDTH, assert_same, half_roi, name, scene, settings, single_pass,
    single_pass_within,
};
use crate::settings::{BackgroundModel, Settings, Span};
use crate::source::{Options, Source};
use crate::tracking::{Identity, Track, TrackState};
use crate::truth::Truth;
use crate::truth::boxes::{Bounds, Boxes};
use crate::truth::masks::{Label, TrueMask, TrueMasks};

const ROOM: usize = 1 << 30;
const FRAME_BYTES: usize = (WIDTH * HEIGHT * 3) as usize;

/// Different settings of the mixture.
fn other() -> Settings {
    Settings { k: 4, alpha: 0.06, match_sigmas: 1.8, bootstrap: Span::Frames(12), ..settings() }
}

fn shared() -> Shared {
    Shared::new(|| {})
}

fn succeed<T>(result: Result<T, StopReason>) -> T {
    result.map_err(|StopReason(why)| why).unwrap()
}

/// A worker that executes steps on demand.
fn worker<'a>(shared: &'a Shared, video: &Path, settings: Settings) -> Worker<'a> {
    worker_from(shared, video, settings, Start::First)
}

fn worker_from<'a>(shared: &'a Shared, video: &Path, settings: Settings, start: Start) -> Worker<'a> {
    let video = name(video);
    succeed(Worker::open(
        shared,
        || FrameCache::open(&video, Options::default(), ROOM),
        AnalysisOptions { settings, roi: None },
        start,
        ROOM,
    ))
}

fn request(worker: &mut Worker<'_>, request: Request) {
    succeed(worker.apply_requests(vec![request]));
}

fn compare(worker: &mut Worker<'_>, settings: Settings, candidate: Option<Settings>) {
    let (in_view, candidate) = (Box::new(settings), candidate.map(Box::new));
    request(worker, Request::Settings { in_view, candidate });
}

fn show(worker: &mut Worker<'_>, position: u32) {
    request(worker, Request::Show(position));
}

/// Works until nothing is left, or `enough` holds.
fn work_until(worker: &mut Worker<'_>, mut enough: impl FnMut(&Worker<'_>) -> bool) {
    while !enough(worker) && succeed(worker.work_once()) {}
}

fn work_until_idle(worker: &mut Worker<'_>) {
    work_until(worker, |_| false);
    worker.publish_in_time(true);
}

fn compared<'a>(worker: &'a Worker<'_>) -> &'a AnalysisPass {
    worker.compared.pass.as_ref().unwrap()
}

/// Both timelines, and some of the frames of both, are equal to those of a single pass.
fn assert_both_passes(worker: &mut Worker<'_>, expected: &[Vec<ShownFrame>; 2]) {
    work_until_idle(worker);
    for (pass, expected) in [(&worker.pass, &expected[0]), (compared(worker), &expected[1])] {
        assert_eq!(pass.model.analysed(), FRAMES);
        for shown in expected {
            let analysis = pass.model.analysis(shown.position).unwrap();
            assert!(analysis.mask == shown.analysis.mask && analysis.tracks == shown.analysis.tracks);
        }
    }
    for position in [59, 3, 40, 33, 58] {
        show(worker, position);
        work_until_idle(worker);
        let shown = worker.view.shown.clone().unwrap();
        assert_same(&shown, &expected[0][position as usize]);
        assert_same(shown.compared.as_ref().unwrap(), &expected[1][position as usize]);
    }
}

#[test]
fn the_compared_pass_can_be_stopped() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    work_until_idle(&mut worker);
    compare(&mut worker, settings(), Some(other()));
    work_until(&mut worker, |worker| compared(worker).model.analysed() > 0);
    request(&mut worker, Request::AnalyseAhead(false));
    work_until_idle(&mut worker);
    assert!(compared(&worker).model.analysed() < FRAMES / 2, "only the frame in view is analysed");
    request(&mut worker, Request::AnalyseAhead(true));
    work_until_idle(&mut worker);
    assert_eq!(compared(&worker).model.analysed(), FRAMES);
}

#[test]
fn a_region_of_interest_does_not_run_the_model_again_while_both_settings_are_equal() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    compare(&mut worker, settings(), Some(settings()));
    work_until_idle(&mut worker);
    request(&mut worker, Request::Roi(Some(half_roi(true))));
    assert_eq!((worker.pass.model.classified(), worker.pass.model.analysed()), (FRAMES, 0));
    assert!(worker.compared.pass.is_none());
    work_until_idle(&mut worker);
    let expected = single_pass_within(folder.path(), &settings(), Some(&half_roi(true)));
    for shown in &expected {
        let analysis = worker.pass.model.analysis(shown.position).unwrap();
        assert!(analysis.mask == shown.analysis.mask && analysis.tracks == shown.analysis.tracks);
    }
    assert_same(worker.view.shown.as_ref().unwrap(), &expected[0]);
}

#[test]
fn a_setting_of_a_later_stage_does_not_run_the_model_again() {
    let folder = scene();
    for late in [Settings { gate: 0.9, ..settings() }, Settings { median: 0, min_area: 3, ..settings() }] {
        let expected = [&late, &settings()].map(|settings| single_pass(folder.path(), settings));
        // Once when half is analysed, and once when all is.
        for analysed in [20, FRAMES] {
            let shared = shared();
            let mut worker = worker(&shared, folder.path(), settings());
            request(&mut worker, Request::Inspect(Some(PIXEL)));
            work_until(&mut worker, |worker| worker.pass.model.analysed() >= analysed);
            let classified = worker.pass.model.classified();
            assert!(classified >= analysed && (classified < FRAMES) == (analysed < FRAMES));
            compare(&mut worker, settings(), Some(settings()));
            compare(&mut worker, late.clone(), Some(settings()));
            assert_eq!((worker.pass.model.classified(), worker.pass.model.analysed()), (classified, 0));
            let before = &compared(&worker).model;
            assert_eq!(
                (before.classified(), before.analysed()),
                (classified, classified),
                "the analysed frames are kept"
            );
            assert_both_passes(&mut worker, &expected);
        }
        // The same for the compared settings.
        let shared = shared();
        let mut worker = worker(&shared, folder.path(), settings());
        work_until(&mut worker, |worker| worker.pass.model.analysed() >= 20);
        let classified = worker.pass.model.classified();
        compare(&mut worker, settings(), Some(late));
        assert_eq!(
            (compared(&worker).model.classified(), compared(&worker).model.analysed()),
            (classified, 0)
        );
        assert_both_passes(&mut worker, &[expected[1].clone(), expected[0].clone()]);
    }
}

#[test]
fn a_model_that_cannot_be_copied_runs_again_for_the_compared_pass_only() {
    let (folder, shared) = (scene(), shared());
    let knn = Settings { background_model: BackgroundModel::Knn, ..settings() };
    let late = Settings { gate: 0.9, ..knn.clone() };
    let expected = [&late, &knn].map(|settings| single_pass(folder.path(), settings));
    let mut worker = worker(&shared, folder.path(), knn.clone());
    work_until_idle(&mut worker);
    compare(&mut worker, knn.clone(), Some(knn.clone()));
    compare(&mut worker, late, Some(knn));
    assert_eq!((worker.pass.model.classified(), compared(&worker).model.classified()), (FRAMES, 0));
    assert_both_passes(&mut worker, &expected);
}

#[test]
fn the_settings_in_view_are_never_compared_with_themselves() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    compare(&mut worker, settings(), Some(other()));
    show(&mut worker, 30);
    work_until_idle(&mut worker);
    for (in_view, candidate) in [(other(), settings()), (settings(), other()), (other(), settings())] {
        compare(&mut worker, in_view.clone(), Some(candidate.clone()));
        let mut pieces = 0;
        loop {
            worker.publish_in_time(true);
            let state = shared.state();
            let now = state.compared.unwrap();
            assert_ne!(now.settings, state.shown.as_ref().unwrap().settings, "after {pieces} pieces");
            pieces += 1;
            if !succeed(worker.work_once()) {
                break;
            }
        }
        let state = shared.state();
        assert_eq!(
            (&*state.shown.unwrap().settings, &*state.compared.unwrap().settings),
            (&in_view, &candidate)
        );
    }
}

#[test]
fn the_status_names_the_current_work() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    work_until_idle(&mut worker);
    let timeline = shared.state().timeline;
    let (_, merge) =
        timeline.events.iter().find(|(_, event)| event.kind == EventKind::Merge).unwrap().clone();
    let is_seeking = |worker: &Worker<'_>| {
        worker.busy.as_ref().is_some_and(|busy| busy.what.starts_with("computing frame"))
    };
    show(&mut worker, 20);
    work_until(&mut worker, is_seeking);
    assert!(is_seeking(&worker));
    request(&mut worker, Request::Explain(Some(Box::new(merge))));
    let mut statuses = Vec::new();
    work_until(&mut worker, |worker| {
        if worker.counterfactual_task.latest().is_some_and(|answer| !answer.done) {
            statuses.push(worker.busy.clone().unwrap());
        }
        false
    });
    assert!(!statuses.is_empty());
    for busy in &statuses {
        assert_eq!(busy.what, "computing counterfactuals");
        assert!(busy.total.is_some_and(|total| busy.done <= total && total > 0), "{busy:?}");
    }

    show(&mut worker, 7);
    work_until(&mut worker, is_seeking);
    assert!(is_seeking(&worker));
    let truth = Truth { boxes: Some(Boxes::new()), masks: None, ..Truth::default() };
    request(&mut worker, Request::Truth(Some(Arc::new(truth))));
    while !worker.is_view_current() {
        assert!(succeed(worker.work_once()));
    }
    assert!(
        succeed(worker.work_once()) && worker.busy.is_none(),
        "scoring does not seek back: {:?}",
        worker.busy
    );
}

#[test]
fn a_session_starts_in_the_middle_of_the_first_occlusion() {
    let (folder, shared) = (scene(), shared());
    let expected = single_pass(folder.path(), &settings());
    let (decided, objects) = expected
        .iter()
        .find_map(|shown| {
            let mut events = shown.analysis.events.iter();
            let event = events.find(|event| matches!(event.kind, EventKind::Merge | EventKind::Disappear))?;
            Some((shown.position, event.objects.clone()))
        })
        .unwrap();
    let is_occluded = |shown: &&ShownFrame| {
        let mut tracks = shown.analysis.tracks.iter();
        tracks.any(|track| objects.contains(&track.id) && track.state != TrackState::Visible)
    };
    let after = expected[decided as usize..].iter().skip_while(|shown| !is_occluded(shown));
    let occluded: Vec<_> = after.take_while(is_occluded).map(|shown| shown.position).collect();
    assert!(occluded.last().is_some_and(|last| *last < decided + 10), "short: {decided} {occluded:?}");
    let mut worker = worker_from(&shared, folder.path(), settings(), Start::FirstOcclusion);
    work_until_idle(&mut worker);
    assert_eq!(worker.view.shown.as_ref().unwrap().position, occluded[occluded.len() / 2]);
}

#[test]
fn a_session_without_an_occlusion_under_newer_settings_stays_at_the_first_frame() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker_from(&shared, folder.path(), settings(), Start::FirstOcclusion);
    work_until(&mut worker, |worker| {
        let mut outlines = worker.pass.model.record().outlines();
        outlines.any(|analysis| analysis.events.iter().any(|event| event.kind == EventKind::Merge))
    });
    compare(&mut worker, Settings { min_area: 2000, ..settings() }, None);
    work_until_idle(&mut worker);
    assert_eq!((worker.pass.model.analysed(), shared.state().timeline.events.len()), (FRAMES, 0));
    assert_eq!(worker.view.shown.as_ref().unwrap().position, 0);
}

#[test]
fn stopping_keeps_the_frame_in_view_or_shows_the_last_one_under_new_settings() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    work_until_idle(&mut worker);
    show(&mut worker, 50);
    work_until_idle(&mut worker);
    show(&mut worker, 7);
    request(&mut worker, Request::AnalyseAhead(false));
    work_until_idle(&mut worker);
    assert_eq!(worker.view.shown.as_ref().unwrap().position, 50);
    request(&mut worker, Request::AnalyseAhead(true));
    let changed = Settings { k: 2, ..settings() };
    compare(&mut worker, changed.clone(), None);
    work_until(&mut worker, |worker| worker.pass.model.analysed() > 0);
    request(&mut worker, Request::AnalyseAhead(false));
    work_until_idle(&mut worker);
    let (shown, analysed) = (worker.view.shown.clone().unwrap(), worker.pass.model.analysed());
    assert!(analysed < 50, "{analysed}");
    assert_eq!((shown.position, &*shown.settings), (analysed - 1, &changed));
}

/// The last progress of each kind of work in a row, until nothing is left.
fn statuses(worker: &mut Worker<'_>) -> Vec<WorkProgress> {
    let mut all: Vec<WorkProgress> = Vec::new();
    work_until(worker, |worker| {
        if let Some(busy) = &worker.busy {
            all.pop_if(|last| last.what == busy.what);
            all.push(busy.clone());
        }
        false
    });
    all
}

#[test]
fn the_status_of_an_analysis_counts_its_frames_up_to_the_requested_one_and_to_the_end() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    show(&mut worker, 40);
    let all = statuses(&mut worker);
    let [learning, requested, .., rest] = &all[..] else { panic!("{all:?}") };
    assert_eq!((&*learning.what, learning.total), ("learning background", Some(LEARNT)));
    assert!(learning.done < LEARNT, "{learning:?}");
    assert_eq!(requested.what, format!("analysing up to frame {}", FIRST + 40));
    assert!(requested.done <= 40, "{requested:?}");
    assert_eq!((&*rest.what, rest.done, rest.total), ("analysing", FRAMES, Some(FRAMES)));

    compare(&mut worker, settings(), Some(other()));
    let all = statuses(&mut worker);
    let [learning, .., candidate] = &all[..] else { panic!("{all:?}") };
    assert_eq!((&*learning.what, learning.total), ("learning background", Some(12)));
    assert_eq!(
        (&*candidate.what, candidate.done, candidate.total),
        ("analysing other settings", FRAMES, Some(FRAMES))
    );
    // Other settings of the mixture on both sides.
    compare(&mut worker, Settings { k: 2, ..settings() }, Some(Settings { k: 2, ..other() }));
    assert!(statuses(&mut worker).iter().any(|busy| busy.what == "analysing A and B"));
}

type TrackAt = (u32, Identity, TrackState);

/// The tracks at each position by the spans of a timeline, which are as long as possible.
fn tracks_of(timeline: &Timeline) -> Vec<TrackAt> {
    let mut all = Vec::new();
    for track in &timeline.track_timelines {
        let is_split = |pair: &[(u32, u32, TrackState)]| pair[0].1 + 1 == pair[1].0 && pair[0].2 == pair[1].2;
        assert!(!track.spans.windows(2).any(is_split), "{track:?}");
        for &(first, last, state) in &track.spans {
            all.extend((first..=last).map(|position| (position, track.id, state)));
        }
    }
    all.sort_by_key(|&(position, id, _)| (position, id));
    all
}

fn tracks_in<'a>(frames: impl Iterator<Item = &'a [Track]>) -> Vec<TrackAt> {
    let of = |(position, tracks): (u32, &'a [Track])| {
        tracks.iter().map(move |track| (position, track.id, track.state))
    };
    let mut all: Vec<_> = (0..).zip(frames).flat_map(of).collect();
    all.sort_by_key(|&(position, id, _)| (position, id));
    all
}

#[test]
fn a_part_of_the_sequence_has_online_results_and_no_score() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    request(&mut worker, Request::AnalyseAhead(false));
    let truth = Truth { boxes: Some(Boxes::new()), masks: None, ..Truth::default() };
    request(&mut worker, Request::Truth(Some(Arc::new(truth))));
    show(&mut worker, 40);
    work_until_idle(&mut worker);
    let timeline = shared.state().timeline;
    let frames = &single_pass(folder.path(), &settings())[..=40];
    let online: Vec<_> = frames.iter().flat_map(|shown| shown.analysis.events.iter().cloned()).collect();
    let found: Vec<_> = timeline.events.iter().map(|(_, event)| event.clone()).collect();
    assert!(timeline.analysed == 41 && !timeline.complete && timeline.score.is_none());
    assert_eq!(found, online);
    assert_eq!(tracks_of(&timeline), tracks_in(frames.iter().map(|shown| &shown.analysis.tracks[..])));
    request(&mut worker, Request::AnalyseAhead(true));
    work_until_idle(&mut worker);
    let (timeline, offline) = (shared.state().timeline, worker.pass.model.offline_result());
    assert!(timeline.score.is_some());
    assert_eq!(tracks_of(&timeline), tracks_in(offline.tracks.iter().map(|frame| &frame.tracks[..])));
}

#[test]
fn scores_are_against_the_newest_truth() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    work_until_idle(&mut worker);
    let truths = [0, 1, 2].map(|count| {
        let boxes = (0..count).map(|at| (FIRST + 20 + at, [(1, Bounds([34.0, 26.0, 9.0, 14.0]))].into()));
        Some(Arc::new(Truth { boxes: Some(boxes.collect()), masks: None, ..Truth::default() }))
    });
    let mut score_against = |truth: &Option<Arc<Truth>>, pieces: bool| {
        request(&mut worker, Request::Truth(truth.clone()));
        if pieces {
            succeed(worker.work_once());
        } else {
            work_until_idle(&mut worker);
        }
        shared.state().timeline.score.clone()
    };
    let alone = truths.each_ref().map(|truth| score_against(truth, false).unwrap());
    assert!(alone[0] != alone[1] && alone[1] != alone[2] && alone[0] != alone[2]);
    for last in [1, 0, 2, 1, 2] {
        for at in 0..truths.len() {
            // Another truth is requested before the score is available, or just as it becomes available.
            score_against(&truths[(last + 1 + at) % truths.len()], true);
        }
        assert_eq!(score_against(&truths[last], false).as_ref(), Some(&alone[last]));
    }
}

/// The decoded scene, with a count of decoded frames.
struct CountingSource {
    info: SourceInfo,
    frames: Arc<Vec<Arc<Frame>>>,
    next: usize,
    decoded: Arc<AtomicU32>,
}

impl Source for CountingSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let frame = self.frames.get(self.next).map(|frame| Frame::clone(frame));
        self.next += 1;
        self.decoded.fetch_add(u32::from(frame.is_some()), Ordering::Relaxed);
        Ok(frame)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}

#[test]
fn frames_are_decoded_once_for_both_passes() {
    let folder = scene();
    let expected = [&settings(), &other()].map(|settings| single_pass(folder.path(), settings));
    let frames: Arc<Vec<_>> = Arc::new(expected[0].iter().map(|shown| Arc::clone(&shown.frame)).collect());
    for room in [1000, 24, 0] {
        let decoded = Arc::new(AtomicU32::new(0));
        let (count, frames) = (Arc::clone(&decoded), Arc::clone(&frames));
        let info = SourceInfo {
            name: "counted".into(),
            size: frames[0].size,
            pixel_aspect: None,
            fps: 25.0,
            fps_from: crate::source::FpsFrom::Video,
            frames: None,
            live: false,
            reduction: None,
        };
        let open = move || -> Result<Box<dyn Source>, SourceError> {
            let (info, frames, decoded) = (info.clone(), Arc::clone(&frames), Arc::clone(&count));
            Ok(Box::new(CountingSource { info, frames, next: 0, decoded }))
        };
        let cache = || FrameCache::new(open, room * FRAME_BYTES);
        let shared = shared();
        let analysis = AnalysisOptions { settings: settings(), roi: None };
        let mut worker = succeed(Worker::open(&shared, cache, analysis, Start::First, ROOM));
        compare(&mut worker, settings(), Some(other()));
        work_until_idle(&mut worker);
        // Frames that were learned from and not cached are decoded again, for each of both passes where nothing is
        // cached.
        let again = decoded.swap(0, Ordering::Relaxed) - FRAMES;
        let most = match room {
            1000 => 0,
            0 => 2 * LEARNT,
            _ => LEARNT,
        };
        assert!(again <= most, "room for {room}: {again}");
        // A pixel that is chosen later needs at most one more pass.
        request(&mut worker, Request::Inspect(Some(PIXEL)));
        work_until_idle(&mut worker);
        let again = decoded.load(Ordering::Relaxed);
        assert!(again <= FRAMES, "room for {room}: {again}");
        let shown = worker.view.shown.clone().unwrap();
        for (shown, expected) in [&shown, shown.compared.as_ref().unwrap()].into_iter().zip(&expected) {
            let (history, single_pass) = (shown.pixel.as_ref().unwrap(), expected.last().unwrap());
            assert_eq!(Some(history), single_pass.pixel.as_ref());
        }
        assert_eq!(compared(&worker).model.analysed(), FRAMES);
    }
}

#[test]
fn the_progress_of_a_pixel_is_published_until_its_history_covers_the_frame_in_view() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    show(&mut worker, 40);
    work_until_idle(&mut worker);
    assert_eq!(shared.state().pixel_progress, None);
    request(&mut worker, Request::Inspect(Some(PIXEL)));
    let progress = shared.state().pixel_progress.unwrap();
    assert_eq!((progress.done, progress.total), (0, Some(41)), "the first frames up to position 40");
    work_until_idle(&mut worker);
    let state = shared.state();
    assert!(state.pixel_progress.is_none() && state.shown.unwrap().pixel.is_some());
}

#[test]
fn every_published_history_of_a_pixel_begins_as_that_of_a_single_pass() {
    let (folder, shared) = (scene(), shared());
    let expected = single_pass(folder.path(), &settings()).pop().unwrap().pixel.unwrap();
    let mut worker = worker(&shared, folder.path(), settings());
    request(&mut worker, Request::Inspect(Some(PIXEL)));
    loop {
        let worked = succeed(worker.work_once());
        (worker.outbox.pixel_grew, worker.outbox.timeline_grew) = (true, true);
        worker.publish_in_time(true);
        let history = shared.state().pixel.unwrap();
        assert_eq!(history.states[..], expected.states[..history.states.len()]);
        if !worked {
            assert_eq!(history, expected);
            break;
        }
    }
}

#[test]
fn a_region_is_tuned_where_the_truth_is_longer_than_the_sequence() {
    let (folder, shared) = (scene(), shared());
    let mut worker = worker(&shared, folder.path(), settings());
    let size = worker.info.size;
    let mask = |number| (number, Arc::new(TrueMask::new(size, vec![Label::Background; size.pixels()])));
    let masks = TrueMasks::new([mask(FIRST + 40), mask(FIRST + 4000)].into()).map(Arc::new);
    request(&mut worker, Request::Truth(Some(Arc::new(Truth { masks, ..Truth::default() }))));
    request(&mut worker, Request::Tune(Some([TunableSetting::K, TunableSetting::T])));
    request(&mut worker, Request::TuneRegion(Some(PixelRegion { centre: PIXEL, side: 1 })));
    let mut steps = 0;
    work_until(&mut worker, |_| {
        steps += 1;
        steps > 20_000
    });
    assert!(steps <= 20_000, "the work ends");
    let tuning = shared.state().region_tuning.unwrap();
    assert_eq!((tuning.frames, tuning.present.all()), (1, 1));
}

#[test]
fn new_results_are_published_once() {
    let (folder, count) = (scene(), Arc::new(AtomicU32::new(0)));
    let counted = Arc::clone(&count);
    let shared = Shared::new(move || {
        counted.fetch_add(1, Ordering::Relaxed);
    });
    let mut worker = worker(&shared, folder.path(), settings());
    work_until_idle(&mut worker);
    (worker.outbox.timeline_grew, worker.outbox.pixel_grew) = (true, true);
    count.store(0, Ordering::Relaxed);
    for _ in 0..3 {
        worker.publish_in_time(true);
    }
    assert_eq!(count.load(Ordering::Relaxed), 1);
}
