//! Long videos: memory hardly grows with their length, and any frame of a long record is reached.
//!
//! With `OCCLUSCOPE_LONG=1` the video has two hours of 720p, and the record a hundred thousand frames.

#![allow(clippy::expect_used, clippy::unwrap_used)]

mod common;
#[path = "common/encoded.rs"]
mod encoded;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use common::{TestFolder, text, works};
use occluscope::pipeline::{Analysis, Pipeline};
use occluscope::registration::Registered;
use occluscope::replay::{AnalysisOptions, Request, Session, Start};
use occluscope::settings::{Settings, Span};
use occluscope::source::{self, Options, Source as _};

fn is_long() -> bool {
    std::env::var_os("OCCLUSCOPE_LONG").is_some()
}

/// A video of passers-by that repeat, with this number of frames.
fn passers_by(folder: &TestFolder, size: &str, frames: u32) -> PathBuf {
    let rendered = folder.path("rendered");
    works(&["synth", "passers-by", "--size", size, "--frames", "800", "--out", text(&rendered)]);
    let video = folder.path("passers-by.mp4");
    let repeated = format!("-stream_loop {}", frames.div_ceil(800) - 1);
    encoded::remux(&rendered.join("passers-by.mp4"), &repeated, &format!("-frames:v {frames}"), &video);
    video
}

/// The memory of a process in bytes, without what is swapped out or shared with files.
#[cfg(target_os = "linux")]
fn memory(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
    line.trim().trim_end_matches(" kB").parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

#[cfg(target_os = "linux")]
#[test]
fn the_memory_of_run_does_not_grow_with_the_length_of_the_video() {
    let folder = TestFolder::new();
    let (size, frames) = if is_long() { ("1280x720", 180_000) } else { ("96x72", 16_000) };
    let video = passers_by(&folder, size, frames);
    let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_occluscope"))
        .args(["run", text(&video), "--quiet", "--out", text(&folder.path("out"))])
        .spawn()
        .unwrap();
    let mut samples = Vec::new();
    while run.try_wait().unwrap().is_none() {
        samples.extend(memory(run.id()));
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(run.wait().unwrap().success());
    let tracks = std::fs::read_to_string(folder.path("out/tracks.csv")).unwrap();
    assert!(tracks.lines().count() > frames as usize / 4, "there are objects in many frames");

    // After warm-up, in the middle, and at the end with the writing of the tables.
    let most = |from: f64, to: f64| {
        let at = |share: f64| (samples.len() as f64 * share) as usize;
        samples[at(from)..at(to)].iter().copied().max().expect("it ran long enough")
    };
    let (middle, end) = (most(0.3, 0.5), most(0.5, 1.0));
    // Numbers and times of frames, and the events, stay in memory; the rest is what other threads happen to hold.
    let most_growth = (4 << 20) + 100 * u64::from(frames);
    assert!(end < middle + most_growth, "{} KiB, then {} KiB", middle >> 10, end >> 10);
    println!("{} KiB in the middle, {} KiB at the end", middle >> 10, end >> 10);
}

/// The analyses of some frames in a single pass.
fn single_pass(video: &Path, settings: &Settings, wanted: &[u32]) -> BTreeMap<u32, Analysis> {
    let mut source = Registered::new(source::open(text(video), Options::default()).unwrap());
    let info = source.info().clone();
    let mut pipeline = Pipeline::new(settings, info.size, info.fps).unwrap();
    let mut analyses = BTreeMap::new();
    let mut position = 0;
    while let Some(frame) = source.next_frame().unwrap() {
        let analysis = pipeline.step(&frame).unwrap();
        if wanted.contains(&position) {
            analyses.insert(position, analysis);
        }
        position += 1;
    }
    analyses
}

#[test]
fn any_frame_of_a_long_record_is_reached_and_equals_a_single_pass() {
    let folder = TestFolder::new();
    let frames = if is_long() { 100_000 } else { 4_000 };
    let video = passers_by(&folder, "64x64", frames);
    let settings = Settings { bootstrap: Span::Frames(0), ..Settings::default() };
    let wanted: Vec<u32> = (0..40)
        .map(|step| (step * 7_919_u32).wrapping_mul(104_729) % frames)
        .chain([0, frames - 1])
        .collect();
    let expected = single_pass(&video, &settings, &wanted);

    let (wake, woken) = std::sync::mpsc::channel();
    let analysis = AnalysisOptions { settings, roi: None };
    let session =
        Session::open(text(&video), Options::default(), analysis, Start::First, Some(64 << 20), move || {
            let _ = wake.send(());
        });
    let wait = |is_reached: &dyn Fn(&occluscope::replay::State) -> bool| loop {
        let state = session.state();
        if is_reached(&state) {
            return state;
        }
        woken.recv_timeout(Duration::from_mins(5)).expect("the session goes on");
    };
    wait(&|state| state.timeline.complete && state.timeline.analysed == frames);
    for position in wanted {
        session.request(Request::Show(position));
        let state = wait(&|state| state.shown.as_ref().is_some_and(|shown| shown.position == position));
        let (shown, expected) = (state.shown.unwrap(), &expected[&position]);
        assert_eq!(shown.analysis.mask, expected.mask, "{position}");
        assert_eq!(shown.analysis.regions, expected.regions, "{position}");
        assert_eq!(shown.analysis.tracks, expected.tracks, "{position}");
    }
}
