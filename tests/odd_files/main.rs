//! Bad and odd input. Each test makes its files, and gives them to the program: it never panics, aborts or hangs, and a
//! failure is one line on stderr that names the file.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/encoded.rs"]
mod encoded;

mod data_sets;
mod faults;
mod images;
mod names;
mod quiet;
mod settings;
mod truth;
mod videos;

use std::path::Path;
use std::time::Duration;

use assert_cmd::Command;
use common::{TestFolder, occluscope, text};
use occluscope::source::{self, Options};

/// Longer than any of these inputs takes; only what hangs reaches it.
const PATIENCE: Duration = Duration::from_mins(2);

/// Whether there is time for all cases instead of some.
fn has_time() -> bool {
    std::env::var_os("OCCLUSCOPE_LONG").is_some()
}

/// Reads all frames of a source, which may fail in one line that names it. Returns their number and the warnings.
fn read_all(path: &Path) -> Result<(usize, Vec<String>), String> {
    let of = |error: source::SourceError| {
        let error = error.to_string();
        assert!(error.contains(text(path)) && !error.contains('\n'), "{error}");
        error
    };
    let mut source = source::open(text(path), Options::default()).map_err(of)?;
    let mut frames = 0;
    while source.next_frame().map_err(of)?.is_some() {
        frames += 1;
    }
    let warnings = source.take_warnings();
    assert!(warnings.iter().all(|line| !line.contains('\n')), "{warnings:?}");
    Ok((frames, warnings))
}

/// What a run of the program said.
struct Said {
    status: i32,
    stdout: String,
    /// The lines on stderr.
    lines: Vec<String>,
}

impl Said {
    /// Runs a command, which must end by itself with status 0, 1 or 2, without a panic, and with one error on stderr where
    /// it fails.
    fn by(command: &mut Command) -> Self {
        let output = command.timeout(PATIENCE).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        let shown = format!("{command:?}: {:?}\n{stderr}", output.status);
        let status = output.status.code().expect(&shown);
        let lines: Vec<String> = stderr.lines().map(ToOwned::to_owned).collect();
        assert!((0..=2).contains(&status) && !stderr.contains("bug in occluscope"), "{shown}");
        let errors = lines.iter().filter(|line| line.starts_with("error: ")).count();
        assert_eq!(errors, usize::from(status != 0), "{shown}");
        let ours = |line: &String| {
            ["error: ", "warning: ", "note: "].iter().any(|start| line.starts_with(start))
                || (status == 0 && line.contains("; written to "))
        };
        assert!(lines.iter().all(ours), "{shown}");
        Self { status, stdout: String::from_utf8_lossy(&output.stdout).into_owned(), lines }
    }

    /// Runs the program on these arguments, as [`Self::by`].
    fn of(arguments: &[&str]) -> Self {
        Self::by(&mut occluscope(arguments))
    }

    /// The error, the only line on stderr.
    fn error(&self) -> &str {
        assert!(self.status != 0 && self.lines.len() == 1, "{}: {:?}", self.status, self.lines);
        &self.lines[0]
    }

    /// The warnings and notes of a run that worked.
    fn warnings(&self) -> Vec<&str> {
        assert_eq!(self.status, 0, "{:?}", self.lines);
        let lines = self.lines.iter().map(String::as_str);
        lines.filter(|line| line.starts_with("warning: ")).collect()
    }
}

/// Runs `run` on a video into `out` in the place.
fn run(place: &TestFolder, video: &Path, flags: &[&str]) -> Said {
    let out = place.path("out");
    Said::of(&[&["run", text(video), "--out", text(&out), "--bootstrap", "0"], flags].concat())
}

/// Asserts that `run` refuses a video with status 1, naming it and these parts, and writes nothing.
#[track_caller]
fn assert_refused(place: &TestFolder, video: &Path, parts: &[&str]) {
    let said = run(place, video, &[]);
    let error = said.error();
    assert_eq!(said.status, 1, "{error}");
    let name = video.file_name().unwrap().to_str().unwrap();
    for part in parts.iter().copied().chain([name]) {
        assert!(error.contains(part), "{part} is not in: {error}");
    }
    assert!(!place.path("out").exists());
}

/// The numbers of the frames in the results of `run`, from `regions` or its summary.
fn frames_of(place: &TestFolder) -> (u64, u64, u64) {
    let summary = std::fs::read_to_string(place.path("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let of = |key: &str| summary["input"][key].as_u64().unwrap();
    (of("frames"), of("first_frame"), of("last_frame"))
}
