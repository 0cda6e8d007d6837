#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use image::{Rgb, RgbImage};

use super::*;
use crate::explain::pixel::PixelHistory;
use crate::explain::tuning::{self, TunableSetting};
use crate::frame::{Frame, Mask, Size};
use crate::mixture::Parameters;
use crate::pipeline::Pipeline;
use crate::regions::Roi;
use crate::registration::{CorrectionChoice, Registered, corrected};
use crate::replay::tasks::gather::frame_consumer::FrameConsumer as _;
use crate::replay::tasks::gather::pixel_follower::PixelFollower;
use crate::settings::{BackgroundModel, Preset, Settings, Span};
use crate::source::cache::FrameCache;
use crate::source::{self, FpsFrom, Options, Source, SourceError, SourceInfo};
use crate::tracking::TrackState;

mod compare;
mod counterfactual;
mod maps;
mod pins;
mod reduced;
mod truth;

pub(super) const FRAMES: u32 = 60;
pub(super) const WIDTH: u32 = 96;
pub(super) const HEIGHT: u32 = 64;
/// The first frame number; others are the position plus this.
pub(super) const FIRST: u32 = 101;
/// Number of first frames that are learned from before classification.
pub(super) const LEARNT: u32 = 25;
/// A pixel that both squares pass over.
pub(super) const PIXEL: (u32, u32) = (48, 32);

/// What is known of a source of frames of this size at 25 frames a second.
pub(super) fn info_of(size: Size) -> SourceInfo {
    SourceInfo {
        name: "scene".into(),
        size,
        pixel_aspect: None,
        fps: 25.0,
        fps_from: FpsFrom::Video,
        frames: None,
        live: false,
        reduction: None,
    }
}

/// Writes two squares that cross in front of a noisy texture, with a stationary camera.
fn write_scene(folder: &Path) {
    write_scene_from(folder, |_| (0, 0), |_| 1.0);
}

/// The same scene with the camera at these positions, in other light.
fn write_scene_from(folder: &Path, camera: impl Fn(u32) -> (u32, u32), light: impl Fn(u32) -> f32) {
    for index in 0..FRAMES {
        let (red, blue) = (4 + index * 3 / 2, 84_u32.saturating_sub(index * 3 / 2));
        let (right, down) = camera(index);
        let image = RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
            let (x, y) = (x + right, y + down);
            let lit = |rgb: [u32; 3]| Rgb(rgb.map(|level| (level as f32 * light(index)) as u8));
            let inside = |left: u32, top: u32| (left..left + 9).contains(&x) && (top..top + 14).contains(&y);
            if inside(red, 26) && index > 4 {
                return lit([220, 40, 30]);
            }
            if inside(blue, 28) && index > 4 {
                return lit([30, 40, 220]);
            }
            let noise = (x * 7919 + y * 104_729 + index * 1_299_709) % 1009 % 9;
            lit([x * 2 % 60 + 60, y * 3 % 50 + 80, (x + y) % 40 + 70].map(|level| level + noise))
        });
        image.save(folder.join(format!("in{:06}.png", FIRST + index))).unwrap();
    }
}

pub(crate) fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_scene(folder.path());
    folder
}

pub(crate) fn name(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

pub(crate) fn settings() -> Settings {
    let bootstrap = Span::Frames(LEARNT);
    Settings { track_min_area: 0.3, warm_up: 0, alpha: 0.02, bootstrap, ..Settings::preset(Preset::Default) }
}

/// A session that reports changes of its state.
struct WatchedSession {
    session: Session,
    woken: Receiver<()>,
}

impl WatchedSession {
    fn open(video: &Path, settings: Settings, start: Start, budget: usize) -> Self {
        let video = name(video);
        let path = video.clone();
        Self::start(
            &video,
            move || FrameCache::open(&path, Options::default(), budget / 2),
            budget / 2,
            settings,
            start,
        )
    }

    fn start(
        name: &str,
        open: impl FnOnce() -> Result<FrameCache, SourceError> + Send + 'static,
        model_budget: usize,
        settings: Settings,
        start: Start,
    ) -> Self {
        let (wake, woken) = channel();
        let analysis = AnalysisOptions { settings, roi: None };
        let session = Session::start(name, open, model_budget, analysis, start, move || {
            let _ = wake.send(());
        });
        Self { session, woken }
    }

    /// Waits until `is_reached` holds for a published state.
    fn wait_until(&self, mut is_reached: impl FnMut(&State) -> bool) -> State {
        let deadline = Instant::now() + Duration::from_mins(1);
        loop {
            let state = self.session.state();
            if let Some(shown) = &state.shown {
                let number = state.timeline.numbers.get(shown.position as usize);
                assert!(number.is_none_or(|&number| number == shown.frame.number));
            }
            if is_reached(&state) {
                return state;
            }
            let left = deadline.saturating_duration_since(Instant::now());
            assert!(self.woken.recv_timeout(left).is_ok(), "timed out: {:?} {:?}", state.phase, state.busy);
        }
    }

    fn request(&self, request: Request) {
        self.session.request(request);
    }

    fn request_and_wait(&self, request: Request, is_reached: impl FnMut(&State) -> bool) -> State {
        self.request(request);
        self.wait_until(is_reached)
    }

    fn wait_until_analysed(&self) -> State {
        self.wait_until(|state| {
            state.timeline.complete && state.timeline.analysed == FRAMES && state.busy.is_none()
        })
    }

    fn show_and_wait(&self, position: u32) -> Arc<ShownFrame> {
        self.request_and_wait(Request::Show(position), |state| shows(state, position)).shown.unwrap()
    }
}

/// The request for these settings in view, and the candidate settings to compare with them.
fn settings_request(in_view: Settings, candidate: Option<Settings>) -> Request {
    Request::Settings { in_view: Box::new(in_view), candidate: candidate.map(Box::new) }
}

fn shows(state: &State, position: u32) -> bool {
    state.shown.as_ref().is_some_and(|shown| shown.position == position)
}

/// The frames of a single pass, without cache or replay.
pub(super) fn single_pass(video: &Path, settings: &Settings) -> Vec<ShownFrame> {
    single_pass_within(video, settings, None)
}

/// All frames of a video, and the number of first ones that are learned from before classification.
pub(super) fn decoded(video: &Path, settings: &Settings) -> (SourceInfo, Vec<Frame>, usize) {
    decoded_with(video, &Options::default(), settings)
}

fn decoded_with(video: &Path, options: &Options, settings: &Settings) -> (SourceInfo, Vec<Frame>, usize) {
    let mut source = Registered::new(source::open(&name(video), *options).unwrap());
    let info = source.info().clone();
    let frames: Vec<_> = std::iter::from_fn(|| source.next_frame().unwrap()).collect();
    let learnt = frames.len().min(info.bootstrap(settings) as usize);
    (info, frames, learnt)
}

/// The stages after learning from `first`.
pub(super) fn learned_pipeline(settings: &Settings, info: &SourceInfo, first: &[Frame]) -> Pipeline {
    let mut pipeline = Pipeline::new(settings, info.size, info.fps).unwrap();
    for frame in first {
        pipeline.learn(&[frame]).unwrap();
    }
    pipeline
}

/// The history of a pixel before the first classified frame.
pub(super) fn learned_history(at: (u32, u32), settings: &Settings, first: &[Frame]) -> PixelHistory {
    let mut history = PixelHistory::new(at, Parameters::new(settings));
    for frame in first {
        history.learn(frame);
    }
    history
}

/// The same for a region of interest.
pub(super) fn single_pass_within(
    video: &Path,
    settings: &Settings,
    roi: Option<&Arc<Roi>>,
) -> Vec<ShownFrame> {
    single_pass_of(video, &Options::default(), settings, roi)
}

/// The same of a video that is read with options.
pub(crate) fn single_pass_of(
    video: &Path,
    options: &Options,
    settings: &Settings,
    roi: Option<&Arc<Roi>>,
) -> Vec<ShownFrame> {
    let (info, frames, first) = decoded_with(video, options, settings);
    let mut pipeline = learned_pipeline(settings, &info, &frames[..first]);
    pipeline.set_roi(roi.cloned()).unwrap();
    let shared = Arc::new(settings.clone());
    let mut history = learned_history(PIXEL, settings, &frames[..first]);
    let mut all = Vec::new();
    for frame in frames {
        let analysis = pipeline.step(&frame).unwrap();
        history.push(&frame);
        let picture = |rgb| Arc::new(Frame::new(frame.number, frame.size, rgb));
        let mixture = pipeline.mixture();
        all.push(ShownFrame {
            position: all.len() as u32,
            settings: Arc::clone(&shared),
            roi: roi.cloned(),
            analysis: Arc::new(analysis),
            background: picture(pipeline.background_image().unwrap()),
            multi_mode: mixture.map(|mixture| picture(mixture.background_images().multi_mode)),
            map: None,
            pixel: mixture.is_some().then(|| Arc::new(history.clone())),
            frame: Arc::new(frame),
            truth: None,
            external: None,
            compared: None,
        });
    }
    all
}

pub(crate) fn assert_same(got: &ShownFrame, expected: &ShownFrame) {
    let position = expected.position;
    assert_eq!(got.position, position);
    assert_eq!((&got.settings, &got.roi), (&expected.settings, &expected.roi));
    assert_eq!(got.frame, expected.frame, "frame at {position}");
    let (a, b) = (&got.analysis, &expected.analysis);
    assert_eq!((a.number, a.t, &a.counters), (b.number, b.t, &b.counters));
    assert_eq!(a.mask, b.mask, "mask at {position}");
    assert!(a.labels == b.labels, "labels at {position}");
    assert_eq!(a.regions, b.regions, "regions at {position}");
    assert_eq!((&a.tracks, &a.tentative), (&b.tracks, &b.tentative), "tracks at {position}");
    assert_eq!((&a.objects, &a.events), (&b.objects, &b.events), "events at {position}");
    assert_eq!(got.background, expected.background, "background at {position}");
    assert_eq!(got.multi_mode, expected.multi_mode, "multi-mode at {position}");
}

/// Pseudo-random positions, some beyond the end, with single steps among the jumps.
fn seek_positions() -> impl Iterator<Item = u32> {
    let mut position = 0_u32;
    (0..60_u32).map(move |step| {
        position = match step % 5 {
            0 | 3 => (position * 31 + step * 17) % (FRAMES + 8),
            1 | 2 => position.saturating_sub(1),
            _ => position + 1,
        };
        position
    })
}

#[test]
fn frames_in_any_order_equal_those_of_a_single_pass() {
    let folder = scene();
    let frame_bytes = (WIDTH * HEIGHT * 3) as usize;
    // Budgets for everything, for few frames and checkpoints, and for almost nothing. The model learns from the whole
    // clip, a part of it, or nothing.
    for (budget, learnt) in [(1 << 30, LEARNT), (frame_bytes * 160, 1000), (0, 0), (0, LEARNT)] {
        let settings = Settings { bootstrap: Span::Frames(learnt), ..settings() };
        let expected = single_pass(folder.path(), &settings);
        assert!(expected.iter().any(|shown| shown.analysis.regions.len() >= 2));
        assert_any_order_equals(folder.path(), &settings, &expected, budget);
    }
}

#[test]
fn frames_in_any_order_equal_those_of_a_single_pass_with_camera_shake_and_changing_light() {
    let folder = tempfile::tempdir().unwrap();
    let camera = |index: u32| (2 + index * 7 % 5, 2 + index * 11 % 3);
    write_scene_from(folder.path(), camera, |index| if index > 30 { 0.7 } else { 1.0 });
    let settings = Settings {
        stabilise: crate::settings::Stabilise::Similarity,
        light: crate::settings::LightCorrection::Gain,
        ..settings()
    };
    let expected = single_pass(folder.path(), &settings);
    let corrected = |shown: &&ShownFrame| corrected(&shown.frame, CorrectionChoice::new(&settings)).is_some();
    assert!(expected.iter().filter(corrected).count() > 20, "the frames need correction");
    for budget in [1 << 30, 0] {
        assert_any_order_equals(folder.path(), &settings, &expected, budget);
    }
}

fn assert_any_order_equals(folder: &Path, settings: &Settings, expected: &[ShownFrame], budget: usize) {
    let watched = WatchedSession::open(folder, settings.clone(), Start::First, budget);
    watched.request(Request::Inspect(Some(PIXEL)));
    for position in seek_positions() {
        watched.request(Request::Show(position));
        let position = position.min(FRAMES - 1);
        let shown = watched
            .wait_until(|state| {
                let shown = state.shown.as_ref().filter(|shown| shown.position == position);
                shown.is_some_and(|shown| shown.pixel.is_some())
            })
            .shown
            .unwrap();
        let expected = &expected[position as usize];
        assert_same(&shown, expected);
        let (history, single_pass) = (shown.pixel.as_ref().unwrap(), expected.pixel.as_ref().unwrap());
        assert_eq!(history.at, PIXEL);
        assert_eq!(history.states[..=position as usize], single_pass.states[..], "history at {position}");
    }
    let done = watched.wait_until_analysed();
    let history = done.shown.as_ref().unwrap().pixel.clone().unwrap();
    assert_eq!(history, expected.last().unwrap().pixel.clone().unwrap());
    let timeline = &done.timeline;
    assert_eq!(timeline.numbers, (FIRST..FIRST + FRAMES).collect::<Vec<_>>());
    let shares: Vec<_> = expected.iter().map(|shown| shown.analysis.mask.foreground_share()).collect();
    assert_eq!(timeline.foreground_share, shares);
    assert_eq!((&done.phase, done.warnings.len()), (&Phase::Ready, 0));
    assert!(done.analysis_fps > 0.0);
    watched.request(Request::Inspect(None));
    watched.wait_until(|state| state.shown.as_ref().unwrap().pixel.is_none());
}

#[test]
fn frames_never_mix_results_of_different_settings() {
    let folder = scene();
    let mixture = Settings { k: 4, alpha: 0.05, bootstrap: Span::Frames(7), ..settings() };
    let cleaning = Settings { median: 0, min_area: 3, ..mixture.clone() };
    let tracking = Settings { gate: 0.9, process_noise: 3.0, ..cleaning.clone() };
    let choices = [settings(), mixture, cleaning, tracking];
    let expected = choices.each_ref().map(|settings| single_pass(folder.path(), settings));
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.request(Request::Inspect(Some(PIXEL)));
    watched.request(Request::Show(40));
    watched.wait_until(|state| shows(state, 40));
    let check = |state: &State| {
        let shown = state.shown.as_ref().unwrap();
        let choice = choices.iter().position(|settings| *settings == *shown.settings).unwrap();
        assert_same(shown, &expected[choice][shown.position as usize]);
        if let Some(history) = &shown.pixel {
            assert!(history.parameters.equal_settings(&shown.settings));
        }
        let shares = expected[choice].iter().map(|shown| shown.analysis.mask.foreground_share());
        let analysed = state.timeline.foreground_share.len();
        assert!(analysed > shown.position as usize, "the timeline holds the frame in view");
        assert!(state.timeline.foreground_share.iter().copied().eq(shares.take(analysed)));
        // The pixel's history may be newer than the frame in view.
        if let Some(history) = &state.pixel {
            let settings = |settings: &&Settings| history.parameters.equal_settings(settings);
            let choice = choices.iter().position(|choice| settings(&choice)).unwrap();
            let single_pass = expected[choice].last().unwrap().pixel.as_ref().unwrap();
            assert_eq!(history.states[..], single_pass.states[..history.states.len()]);
        }
        shown.settings.clone()
    };
    for (round, settings) in choices.iter().cycle().skip(1).take(9).enumerate() {
        // A request that is replaced at once has no effect.
        watched.request(settings_request(choices[(round + 2) % 4].clone(), None));
        watched.request(settings_request(settings.clone(), None));
        if round % 3 == 1 {
            watched.request(Request::Show(10 + round as u32));
        }
        watched.wait_until(|state| *check(state) == *settings);
    }
    let last = watched.wait_until_analysed();
    check(&last);
    for position in [59, 3, 30] {
        watched.request(Request::Show(position));
        watched.wait_until(|state| {
            check(state);
            shows(state, position)
        });
    }
}

/// The left or right half of the image.
pub(super) fn half_roi(left: bool) -> Arc<Roi> {
    let size = Size::new(WIDTH, HEIGHT);
    let inside = |at: usize| (at as u32 % WIDTH < WIDTH / 2) == left;
    let data = (0..size.pixels()).map(|at| if inside(at) { 255 } else { 0 }).collect();
    Arc::new(Roi::new(Mask { size, data }).unwrap())
}

#[test]
fn a_new_region_of_interest_equals_a_single_pass_and_does_not_run_the_model_again() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.request(Request::Inspect(Some(PIXEL)));
    watched.wait_until_analysed();
    let areas = [Some(half_roi(true)), Some(half_roi(false)), None];
    let other = Settings { gate: 0.95, ..settings() };
    for (area, settings) in areas.iter().zip([settings(), settings(), other]) {
        let expected = single_pass_within(folder.path(), &settings, area.as_ref());
        watched.request(Request::Roi(area.clone()));
        watched.request(settings_request(settings.clone(), None));
        let state = watched.wait_until(|state| {
            let shown = state.shown.as_ref().unwrap();
            shown.roi == *area && *shown.settings == settings
        });
        let shown = state.shown.unwrap();
        assert_same(&shown, &expected[shown.position as usize]);
        for position in seek_positions().take(20) {
            let position = position.min(FRAMES - 1);
            assert_same(&watched.show_and_wait(position), &expected[position as usize]);
        }
        let done = watched.wait_until_analysed();
        let shares: Vec<_> = expected.iter().map(|shown| shown.analysis.mask.foreground_share()).collect();
        assert_eq!(done.timeline.foreground_share, shares);
    }
    assert!(single_pass(folder.path(), &settings()).iter().any(|shown| shown.analysis.regions.len() > 1));
}

#[test]
fn a_region_of_another_size_fails_and_a_valid_one_continues() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.wait_until(|state| state.shown.is_some());
    let small = Roi::new(Mask { size: Size::new(2, 1), data: vec![255, 0] }).map(Arc::new);
    watched.request(Request::Roi(small));
    let failed = watched.wait_until(|state| matches!(state.phase, Phase::Failed(_))).phase;
    assert!(
        matches!(&failed, Phase::Failed(why) if why.contains("2×1") && why.contains("96×64")),
        "{failed:?}"
    );
    watched.request(Request::Roi(Some(half_roi(true))));
    let expected = single_pass_within(folder.path(), &settings(), Some(&half_roi(true)));
    watched.wait_until(|state| state.shown.as_ref().unwrap().roi.is_some());
    assert_same(&watched.show_and_wait(50), &expected[50]);
}

#[test]
fn the_history_of_the_chosen_pixel_needs_no_frames_under_new_settings() {
    let folder = scene();
    let expected = single_pass(folder.path(), &settings());
    let other = Settings { k: 2, alpha: 0.2, bootstrap: Span::Frames(40), ..settings() };
    let mut pixel_follower = PixelFollower::default();
    let (info, ..) = decoded(folder.path(), &settings());
    pixel_follower.choose(Some(PIXEL), &settings(), &info);
    for shown in &expected {
        pixel_follower.push(shown.position, &shown.frame);
    }
    assert_eq!(pixel_follower.latest(), expected.last().unwrap().pixel);
    pixel_follower.choose(Some(PIXEL), &other, &info);
    let single_pass = single_pass(folder.path(), &other);
    assert_eq!(pixel_follower.latest(), single_pass.last().unwrap().pixel);
    pixel_follower.choose(Some((3, 4)), &other, &info);
    assert_eq!(pixel_follower.frames(), Some(0));
    pixel_follower.choose(None, &other, &info);
    assert_eq!((pixel_follower.frames(), pixel_follower.latest()), (None, None));
}

#[test]
fn tracking_again_equals_a_complete_run() {
    let folder = scene();
    let other = Settings { gate: 0.95, size_step: 0.4, ..settings() };
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.wait_until_analysed();
    watched.request(settings_request(other.clone(), None));
    watched.wait_until(|state| *state.shown.as_ref().unwrap().settings == other);
    let again = watched.wait_until_analysed();
    let fresh = WatchedSession::open(folder.path(), other, Start::First, 1 << 30);
    let fresh = fresh.wait_until_analysed();
    assert!(!fresh.timeline.events.is_empty());
    assert_eq!(again.timeline.events, fresh.timeline.events);
    assert_eq!(again.timeline.track_timelines, fresh.timeline.track_timelines);
    assert_eq!(again.timeline.foreground_share, fresh.timeline.foreground_share);
}

#[test]
fn seeking_in_videos_equals_seeking_in_images() {
    use opencv::core::{CV_8UC3, Mat, Scalar, Size as CvSize};
    use opencv::prelude::*;
    use opencv::videoio::{CAP_FFMPEG, VideoWriter};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.avi");
    source::silence_libraries();
    let fourcc = VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
    let size = CvSize::new(64, 48);
    let mut writer =
        VideoWriter::new_with_backend(path.to_str().unwrap(), CAP_FFMPEG, fourcc, 10.0, size, true).unwrap();
    for index in 0..FRAMES as i32 {
        let mut picture = Mat::new_rows_cols_with_default(48, 64, CV_8UC3, Scalar::all(90.0)).unwrap();
        let square = opencv::core::Rect::new(index % 50, 20, 10, 12);
        let colour = Scalar::new(30.0, 60.0, 220.0, 0.0);
        opencv::imgproc::rectangle(&mut picture, square, colour, -1, 8, 0).unwrap();
        writer.write(&picture).unwrap();
    }
    writer.release().unwrap();
    let expected = single_pass(&path, &settings());
    assert_eq!(expected.len() as u32, FRAMES);
    let watched = WatchedSession::open(&path, settings(), Start::First, 64 * 48 * 3 * 40);
    for position in seek_positions() {
        watched.request(Request::Show(position));
        let position = position.min(FRAMES - 1);
        let state = watched.wait_until(|state| shows(state, position));
        assert_same(&state.shown.unwrap(), &expected[position as usize]);
    }
}

#[test]
fn opencv_models_show_the_background_of_each_frame_within_the_budget() {
    let folder = scene();
    for model in [BackgroundModel::Mog2, BackgroundModel::Knn] {
        let settings = Settings { background_model: model, ..settings() };
        let expected = single_pass(folder.path(), &settings);
        let watched = WatchedSession::open(folder.path(), settings, Start::First, 1 << 30);
        watched.request(Request::Inspect(Some(PIXEL)));
        watched.wait_until_analysed();
        for position in [59, 20, 41, 0] {
            let shown = watched.show_and_wait(position);
            assert_same(&shown, &expected[position as usize]);
            assert!(shown.pixel.is_none() && shown.multi_mode.is_none());
        }
    }
}

#[test]
fn the_first_frame_is_shown_before_the_requested_one() {
    let folder = scene();
    for (start, position) in [(FIRST + 30, 30), (0, 0), (FIRST + 1000, FRAMES - 1)] {
        let mut seen = Vec::new();
        let watched = WatchedSession::open(folder.path(), settings(), Start::Frame(start), 1 << 30);
        watched.wait_until(|state| {
            if let Some(shown) = &state.shown {
                seen.push(shown.position);
            }
            shows(state, position) && (position > 0 || state.timeline.analysed > 0)
        });
        seen.dedup();
        assert!(seen == [0, position] || seen == [position], "{seen:?}");
    }
}

#[test]
fn an_unreadable_source_fails_with_a_sentence() {
    let watched = WatchedSession::open(Path::new("/nowhere/at/all.avi"), settings(), Start::First, 1 << 20);
    let state = watched.wait_until(|state| matches!(state.phase, Phase::Failed(_)));
    let expected = "/nowhere/at/all.avi does not exist; check the path".to_owned();
    assert_eq!(state.phase, Phase::Failed(expected));
    watched.request(Request::Show(3));
    watched.request(settings_request(settings(), None));
}

#[test]
fn a_skipped_frame_causes_a_warning() {
    let folder = scene();
    std::fs::write(folder.path().join(format!("in{:06}.png", FIRST + 7)), "broken").unwrap();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    let state = watched.wait_until(|state| state.timeline.complete && state.busy.is_none());
    assert_eq!(state.timeline.numbers.len() as u32, FRAMES - 1);
    assert!(!state.timeline.numbers.contains(&(FIRST + 7)));
    assert_eq!(state.warnings.len(), 1);
    assert!(state.warnings[0].contains(&format!("frame {} is skipped", FIRST + 7)), "{:?}", state.warnings);
}

#[test]
fn a_panic_in_the_worker_becomes_a_failure() {
    let folder = scene();
    let once = AtomicBool::new(true);
    let (wake, woken) = channel();
    let session = Session::open(
        &name(folder.path()),
        Options::default(),
        AnalysisOptions { settings: settings(), roi: None },
        Start::First,
        None,
        move || {
            assert!(!once.swap(false, Ordering::Relaxed), "the panic of this test");
            let _ = wake.send(());
        },
    );
    woken.recv_timeout(Duration::from_secs(20)).unwrap();
    let Phase::Failed(why) = session.state().phase else { panic!("{:?}", session.state().phase) };
    assert!(why.contains("the panic of this test") && !why.contains('\n'), "{why}");
}

/// A source whose reader panics at a frame.
struct BrokenReader(Box<dyn Source>);

impl Source for BrokenReader {
    fn info(&self) -> &SourceInfo {
        self.0.info()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let frame = self.0.next_frame()?;
        assert!(frame.as_ref().is_none_or(|frame| frame.number < FIRST + 50), "the reader broke");
        Ok(frame)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.0.take_warnings()
    }
}

#[test]
fn a_panic_of_the_reader_becomes_a_failure_and_the_window_goes_on() {
    let folder = scene();
    let video = name(folder.path());
    let path = video.clone();
    let open = move || -> Result<Box<dyn Source>, SourceError> {
        Ok(Box::new(BrokenReader(source::open(&path, Options::default())?)))
    };
    let cache = move || FrameCache::new(open, 1 << 24);
    // Nothing reads far ahead, so that frames are shown before the panic.
    let plain = Settings {
        bootstrap: Span::Frames(0),
        stabilise: crate::settings::Stabilise::Off,
        light: crate::settings::LightCorrection::Off,
        ..settings()
    };
    let broken = WatchedSession::start(&video, cache, 1 << 24, plain.clone(), Start::First);
    let state = broken.wait_until(|state| matches!(state.phase, Phase::Failed(_)));
    let Phase::Failed(why) = state.phase else { panic!("no failure") };
    let told =
        format!("{video} cannot be analysed further: internal error (the reader broke); open it again");
    assert_eq!(why, told);
    // What was shown stays, and requests are taken without an answer.
    assert_eq!(state.shown.unwrap().position, 0);
    broken.request(Request::Show(5));
    broken.request(settings_request(Settings { alpha: 0.1, ..plain.clone() }, None));
    assert!(matches!(broken.session.state().phase, Phase::Failed(_)));
    let again = WatchedSession::open(folder.path(), plain, Start::First, 1 << 24);
    again.wait_until_analysed();
}

#[test]
fn dropping_a_session_ends_its_worker() {
    let folder = scene();
    let (wake, woken) = channel::<()>();
    let session = Session::open(
        &name(folder.path()),
        Options::default(),
        AnalysisOptions { settings: settings(), roi: None },
        Start::First,
        None,
        move || {
            let _ = wake.send(());
        },
    );
    woken.recv_timeout(Duration::from_secs(20)).unwrap();
    drop(session);
    // The worker owns the sender, so the channel closes when it ends.
    while woken.try_recv().is_ok() {}
    assert_eq!(woken.recv(), Err(std::sync::mpsc::RecvError));
}

#[test]
fn a_session_can_start_at_the_first_occlusion() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::FirstOcclusion, 1 << 30);
    let first = watched.wait_until(|state| state.shown.is_some());
    let state = watched.wait_until(|state| !shows(state, 0) && state.shown.is_some());
    let tracks = state.shown.as_ref().unwrap().analysis.tracks.clone();
    assert!(tracks.iter().any(|track| track.state != TrackState::Visible), "{tracks:?}");
    let done = watched.wait_until_analysed();
    let merged =
        done.timeline.events.iter().find(|(_, event)| event.kind == crate::occlusion::EventKind::Merge);
    let (position, event) = merged.expect("the squares cross");
    assert_eq!(event.frame, done.timeline.numbers[*position as usize]);
    assert!(done.timeline.track_timelines.len() >= 2);
    for life in &done.timeline.track_timelines {
        assert!(life.spans.windows(2).all(|pair| pair[0].1 < pair[1].0), "{life:?}");
    }
    assert!(!first.timeline.complete || first.timeline.analysed == FRAMES);
    // A requested frame stays in view.
    let watched = WatchedSession::open(folder.path(), settings(), Start::FirstOcclusion, 1 << 30);
    watched.show_and_wait(2);
    assert_eq!(watched.wait_until_analysed().shown.unwrap().position, 2);
}

/// A camera that sees the scene repeatedly until it is unplugged.
struct LoopingCamera {
    info: SourceInfo,
    scene: Vec<Arc<Frame>>,
    next: u32,
    length: u32,
}

impl Source for LoopingCamera {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        std::thread::sleep(Duration::from_millis(2));
        self.next += 1;
        let seen = &self.scene[(self.next - 1) as usize % self.scene.len()];
        Ok((self.next <= self.length).then(|| Frame::new(self.next, seen.size, seen.rgb.clone())))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}

fn camera(length: u32, frames_kept: usize) -> WatchedSession {
    let folder = scene();
    let scene: Vec<_> =
        single_pass(folder.path(), &settings()).into_iter().map(|shown| shown.frame).collect();
    let frame_bytes = scene[0].rgb.len();
    let info = SourceInfo {
        name: "camera:7".into(),
        size: scene[0].size,
        pixel_aspect: None,
        fps: 25.0,
        fps_from: crate::source::FpsFrom::Video,
        frames: None,
        live: true,
        reduction: None,
    };
    let open = move || -> Result<Box<dyn Source>, SourceError> {
        Ok(Box::new(LoopingCamera { info: info.clone(), scene: scene.clone(), next: 0, length }))
    };
    WatchedSession::start(
        "camera:7",
        move || FrameCache::new(open, frames_kept * frame_bytes),
        1 << 28,
        settings(),
        Start::First,
    )
}

#[test]
fn a_camera_is_followed_until_an_earlier_frame_is_requested() {
    let watched = camera(400, 1000);
    let newest = watched.wait_until(|state| state.shown.as_ref().is_some_and(|shown| shown.position > 30));
    let newest_shown = newest.shown.unwrap();
    assert_eq!(newest_shown.frame.number, newest_shown.position + 1);
    assert!(newest.timeline.numbers.len() as u32 > newest_shown.position);
    let earlier = watched.show_and_wait(12);
    assert_eq!(earlier.frame.number, 13);
    let later = watched.wait_until(|state| state.timeline.analysed > 100);
    assert_eq!(later.shown.unwrap().position, 12, "the frame stays in view");
    watched.request(settings_request(Settings { alpha: 0.1, ..settings() }, None));
    let state =
        watched.wait_until(|state| state.shown.as_ref().is_some_and(|shown| shown.settings.alpha == 0.1));
    assert_eq!(
        state.shown.unwrap().position,
        12,
        "all frames are cached, so the analysis restarts at the first"
    );
}

#[test]
fn old_frames_of_a_camera_are_evicted() {
    let watched = camera(u32::MAX, 20);
    watched.request(Request::Inspect(Some(PIXEL)));
    watched.wait_until(|state| state.timeline.analysed > 60);
    watched.request(Request::Show(3));
    let state = watched.wait_until(|state| !state.warnings.is_empty());
    assert!(state.warnings[0].contains("no longer kept"), "{:?}", state.warnings);
    watched.request(settings_request(Settings { alpha: 0.1, ..settings() }, None));
    let state = watched.wait_until(|state| {
        let shown = state.shown.as_ref().unwrap();
        shown.settings.alpha == 0.1 && shown.position > 5 && shown.pixel.is_some()
    });
    let shown = state.shown.unwrap();
    assert!(shown.frame.number > 60 && shown.analysis.t == shown.position + 1);
    let history = shown.pixel.clone().unwrap();
    assert_eq!(history.states[shown.position as usize].number, shown.frame.number);
    watched.request(settings_request(Settings { gate: 0.95, alpha: 0.1, ..settings() }, None));
    watched.wait_until(|state| state.shown.as_ref().unwrap().settings.gate == 0.95);
}

#[test]
fn pixels_without_the_first_frames_of_a_camera_are_reported() {
    let watched = camera(u32::MAX, 20);
    watched.wait_until(|state| state.timeline.analysed > 60);
    watched.request(Request::Inspect(Some(PIXEL)));
    watched.request(Request::Pin(vec![(30, 30), PIXEL]));
    let state = watched.wait_until(|state| state.lost.len() == 3);
    assert_eq!(state.lost, [PIXEL, (30, 30), PIXEL]);
    assert!(state.pixel.is_none() && state.pins.is_empty());
    // The model starts with an available frame under other settings.
    watched.request(settings_request(Settings { alpha: 0.1, ..settings() }, None));
    let known = |state: &State| state.lost.is_empty() && state.pins.len() == 2 && state.pixel.is_some();
    watched.wait_until(known);
}

#[test]
fn a_request_without_effect_does_not_wake_the_window() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.wait_until_analysed();
    while watched.woken.recv_timeout(Duration::from_millis(300)).is_ok() {}
    watched.request(Request::Show(0));
    watched.request(settings_request(settings(), None));
    watched.request(Request::Inspect(None));
    assert!(watched.woken.recv_timeout(Duration::from_millis(500)).is_err());
}

#[test]
fn a_tuning_equals_runs_of_the_pixel_under_other_settings() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.request(Request::Inspect(Some(PIXEL)));
    for (tuned_settings, position, settings) in [
        ([TunableSetting::Alpha, TunableSetting::T], 31, settings()),
        ([TunableSetting::Lambda, TunableSetting::K], 33, settings()),
        ([TunableSetting::Lambda, TunableSetting::K], 33, Settings { alpha: 0.1, ..settings() }),
    ] {
        watched.request(Request::Tune(Some(tuned_settings)));
        watched.request(settings_request(settings.clone(), None));
        watched.request(Request::Show(position));
        let state = watched.wait_until(|state| {
            let tuning = state.tuning.as_ref().filter(|tuning| tuning.position == position);
            tuning.is_some_and(|tuning| {
                let of = tuning.map.axes.each_ref().map(|axis| axis.setting);
                of == tuned_settings && tuning.parameters.equal_settings(&settings)
            })
        });
        let tuning = state.tuning.unwrap();
        let history = state.pixel.unwrap();
        let seen = LEARNT as usize + position as usize + 1;
        let colours = (0..LEARNT).chain(0..FRAMES).map(|at| history.states[at as usize].value);
        let values: Vec<_> = colours.take(seen).collect();
        assert_eq!(tuning.at, PIXEL);
        assert_eq!(tuning.map, tuning::map(&values, &tuning.parameters, tuned_settings));
        for flip in &tuning.flips {
            assert_eq!(*flip, tuning::flip(&values, &tuning.parameters, flip.setting));
        }
    }
    watched.request(Request::Tune(None));
    watched.wait_until(|state| state.tuning.is_none());
}

#[test]
fn a_stopped_session_analyses_only_requested_frames() {
    let folder = scene();
    let (open, opened) = channel::<()>();
    let path = name(folder.path());
    let video = path.clone();
    let opens = move || {
        opened.recv().unwrap();
        FrameCache::open(&path, Options::default(), 1 << 20)
    };
    let watched = WatchedSession::start(&video, opens, 1 << 20, settings(), Start::FirstOcclusion);
    watched.request(Request::Show(50));
    watched.request(Request::AnalyseAhead(false));
    open.send(()).unwrap();
    watched.wait_until(|state| shows(state, 0));
    for position in [1, 2, 3, 20, 21, 10, 22] {
        let state = watched.request_and_wait(Request::Show(position), |state| shows(state, position));
        let most = if position == 10 { 22 } else { position + 1 };
        assert_eq!(state.timeline.analysed, most, "analysed beyond the requested position {position}");
    }
    // Under other settings the frame in view is analysed again, and nothing beyond it.
    let changed = Settings { t: 0.6, ..settings() };
    let state = watched.request_and_wait(settings_request(changed.clone(), None), |state| {
        state.shown.as_ref().is_some_and(|shown| *shown.settings == changed)
    });
    assert_eq!((state.shown.unwrap().position, state.timeline.analysed), (22, 23));
    watched.request(Request::AnalyseAhead(true));
    assert!(shows(&watched.wait_until_analysed(), 22), "the frame stays in view");
}

#[test]
fn stopping_has_no_effect_when_all_frames_are_analysed() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.wait_until_analysed();
    watched.request(Request::AnalyseAhead(false));
    // Processed by the worker before the settings are requested.
    watched.show_and_wait(30);
    let changed = Settings { t: 0.6, ..settings() };
    watched.request(settings_request(changed.clone(), None));
    let of_changed = |state: &State| state.shown.as_ref().is_some_and(|shown| *shown.settings == changed);
    watched.wait_until(|state| of_changed(state) && state.timeline.analysed == FRAMES);
}
