//! Calls of the system that fail, and a program that is killed: files are whole, and nothing older is lost.
//!
//! All calls in turn where `OCCLUSCOPE_LONG` is set, else some.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../common/mod.rs"]
mod common;
mod layer;
mod work;

use std::ops::RangeInclusive;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use common::{TestFolder, fails, text, works, write_images};
use layer::{EIO, ENOSPC, Fault, run};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg32;
use rayon::prelude::*;
use work::{Inputs, Work, files, hidden};

/// All calls that write.
const WRITING: &str = "open,write,sync,close,rename,link,mkdir";
/// The calls that need room on a disk.
const GROWING: &str = "open,write,sync,link,mkdir";

fn is_long() -> bool {
    std::env::var_os("OCCLUSCOPE_LONG").is_some()
}

/// The works of all tests.
fn all_works() -> &'static [Work] {
    static WORKS: OnceLock<(Inputs, Vec<Work>)> = OnceLock::new();
    let (_, works) = WORKS.get_or_init(|| {
        let inputs = Inputs::new();
        let works = inputs.works();
        (inputs, works)
    });
    works
}

/// The calls of a work that are counted, all or `some` of them.
fn moments(work: &Work, calls: &'static str, some: usize) -> Vec<u32> {
    let all = all_moments(work, calls);
    if is_long() {
        return all.collect();
    }
    let mut random = Pcg32::seed_from_u64(19);
    (0..some).map(|_| random.random_range(all.clone())).collect()
}

/// All calls of a work that are counted.
fn all_moments(work: &Work, calls: &'static str) -> RangeInclusive<u32> {
    let place = work.place();
    let none = Fault { calls, at: 0, lasts: false, error: Some(EIO) };
    let (output, count) = run(&work.arguments(place.path()), place.path(), none);
    assert!(output.status.success(), "{}", said(&output));
    let count = count.unwrap();
    assert!(count > 5, "{}: {count} calls", work.name);
    1..=count
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The work with a fault: either it is done in full, or it fails in one line that names a file, and nothing has changed.
fn check(work: &Work, fault: Fault) -> Result<bool, String> {
    let place = work.place();
    let (output, count) = run(&work.arguments(place.path()), place.path(), fault);
    let said = said(&output);
    let found = files(place.path());
    let reached = count.is_some_and(|count| count >= fault.at);
    let faults = match output.status.code() {
        Some(0) if said.is_empty() => work.faults(&found),
        Some(1) => {
            let is_told = said.lines().count() == 1
                && said.starts_with("error: ")
                && said.contains(text(place.path()))
                && !said.contains(".occluscope-");
            let is_full = fault.error != Some(ENOSPC) || said.contains("the disk is full");
            let mut faults = work.changes(&found);
            if !is_told || !is_full {
                faults.push("the message does not tell it".to_owned());
            }
            faults
        }
        _ => vec![format!("{}", output.status)],
    };
    if faults.is_empty() {
        return Ok(reached && !output.status.success());
    }
    Err(format!("{} with {fault:?}: {faults:?}; it said: {said}", work.name))
}

/// Checks all works with faults of these kinds.
fn check_all(calls: &'static str, lasts: bool, error: i32, some: usize) {
    for work in all_works() {
        let faults = moments(work, calls, some);
        let faults = faults.into_par_iter().map(|at| Fault { calls, at, lasts, error: Some(error) });
        let results: Vec<_> = faults.map(|fault| check(work, fault)).collect();
        let wrong: Vec<_> = results.iter().filter_map(|result| result.as_ref().err()).collect();
        assert!(wrong.is_empty(), "{} of {}: {wrong:#?}", wrong.len(), results.len());
        let failed = results.iter().filter(|result| matches!(result, Ok(true))).count();
        assert!(failed > 0, "no fault of {} was noticed", work.name);
        println!("{}: {} faults, {failed} of them ended the work", work.name, results.len());
    }
}

#[test]
fn an_error_of_the_disk_at_any_call_leaves_everything_as_it_was() {
    check_all(WRITING, false, EIO, 3);
}

/// Other writes follow and succeed, so that no later error tells of it.
#[test]
fn a_single_failed_write_of_synth_is_told() {
    let works: Vec<&Work> = all_works().iter().filter(|work| work.name.starts_with("synth")).collect();
    assert_eq!(works.len(), 2);
    for work in works {
        let fault = |at| Fault { calls: "write", at, lasts: false, error: Some(EIO) };
        let moments = all_moments(work, "write").into_par_iter();
        let results: Vec<_> = moments.map(|at| check(work, fault(at))).collect();
        for result in results {
            assert_eq!(result, Ok(true), "{}", work.name);
        }
    }
}

#[test]
fn a_disk_that_becomes_full_at_any_call_leaves_everything_as_it_was() {
    check_all(GROWING, true, ENOSPC, 2);
}

/// The program is killed at a call; files are whole, and the next run succeeds.
#[test]
fn killed_at_any_moment_it_leaves_whole_files() {
    let mut random = Pcg32::seed_from_u64(5);
    let mut kills = Vec::new();
    for work in all_works() {
        let calls = moments(work, WRITING, 2);
        let some = if is_long() { 40 } else { 2 };
        kills.extend((0..some).map(|_| (work, calls[random.random_range(0..calls.len())])));
    }
    let results: Vec<_> = kills.par_iter().map(|(work, at)| killed(work, *at)).collect();
    let wrong: Vec<_> = results.iter().filter_map(|result| result.as_ref().err()).collect();
    assert!(wrong.is_empty(), "{} of {}: {wrong:#?}", wrong.len(), results.len());
    let left = results.iter().filter(|result| matches!(result, Ok(true))).count();
    assert!(left > 0, "no kill left anything");
    println!("{} kills, {left} of them left temporary files", results.len());
}

/// Kills the program; whether it left something that the next run removed.
fn killed(work: &Work, at: u32) -> Result<bool, String> {
    let place = work.place();
    let fault = Fault { calls: WRITING, at, lasts: false, error: None };
    let (output, _) = run(&work.arguments(place.path()), place.path(), fault);
    let is_killed = output.status.signal() == Some(9);
    let found = files(place.path());
    check_after_kill(work, place.path(), is_killed).map_err(|why| format!("{} at {at}: {why}", work.name))?;
    Ok(!hidden(&found).is_empty())
}

fn check_after_kill(work: &Work, place: &Path, is_killed: bool) -> Result<(), String> {
    let found = files(place);
    let broken = if is_killed { work.broken(&found) } else { work.faults(&found) };
    if !broken.is_empty() {
        return Err(format!("{broken:?}"));
    }
    let arguments = work.arguments(place);
    let output = Command::new(env!("CARGO_BIN_EXE_occluscope")).args(&arguments).output().unwrap();
    let faults = work.faults(&files(place));
    if !output.status.success() || !faults.is_empty() {
        return Err(format!("the next run: {faults:?} {}", said(&output)));
    }
    Ok(())
}

/// The program is killed at a time, as by the user.
#[test]
fn killed_at_any_time_it_leaves_whole_files() {
    let mut random = Pcg32::seed_from_u64(7);
    let some = if is_long() { 30 } else { 1 };
    let mut kills = 0;
    for work in all_works() {
        for _ in 0..some {
            let place = work.place();
            let mut command = Command::new(env!("CARGO_BIN_EXE_occluscope"));
            command.args(work.arguments(place.path())).stderr(Stdio::null()).stdout(Stdio::null());
            let mut child = command.spawn().unwrap();
            std::thread::sleep(Duration::from_micros(random.random_range(1_000..900_000)));
            child.kill().unwrap();
            let status = child.wait().unwrap();
            kills += u32::from(status.signal() == Some(9));
            let checked = check_after_kill(work, place.path(), status.signal() == Some(9));
            checked.unwrap_or_else(|why| panic!("{}: {why}", work.name));
        }
    }
    println!("{kills} kills");
}

/// An error of reading is told, or what was read in spite of it is right.
#[test]
fn an_error_of_reading_is_told() {
    let place = TestFolder::new();
    let scene = place.path("scene");
    works(&["synth", "empty", "--frames", "9", "--size", "64x64", "--quiet", "--out", text(&scene)]);
    let images = place.path("images");
    write_images(&images, 6, 1);
    let out = tempfile::tempdir().unwrap();
    for (input, under) in [(scene.join("empty.mp4"), &scene), (images.clone(), &images)] {
        let tables = |fault: Fault| {
            let folder = tempfile::tempdir_in(&out).unwrap();
            let words = ["run", text(&input), "--masks", "--out", text(folder.path())].map(str::to_owned);
            let (output, count) = run(&words, under, fault);
            let tables: Vec<_> =
                files(folder.path()).into_iter().filter(|(name, _)| name != "summary.json").collect();
            (output, count, tables)
        };
        let fault = |at: u32| Fault { calls: "read", at, lasts: false, error: Some(EIO) };
        let (_, count, expected) = tables(fault(0));
        let count = count.unwrap();
        assert!(count > 3, "{count}");
        let mut random = Pcg32::seed_from_u64(3);
        let moments: Vec<u32> = if is_long() {
            (1..=count).collect()
        } else {
            (0..8).map(|_| random.random_range(1..=count)).collect()
        };
        for at in moments {
            let (output, _, found) = tables(fault(at));
            let said = said(&output);
            let is_named = said.contains(text(under));
            match output.status.code() {
                Some(0) if found == expected => {}
                Some(0) => assert!(said.contains("warning: ") && is_named, "read {at}: {said}"),
                Some(1) => {
                    assert!(said.lines().count() == 1 && is_named && found.is_empty(), "read {at}: {said}");
                }
                _ => panic!("read {at}: {} {said}", output.status),
            }
        }
    }
}

/// Without a file there is nothing to name but the output itself.
#[test]
fn a_full_standard_output_is_told() {
    let told = "error: standard output cannot be written: the disk is full; free some space, or choose another place\n";
    for arguments in ["settings", "synth --list", "--help", "run --help", "--version"] {
        let line = format!("exec \"$0\" {arguments} >/dev/full");
        let mut command = Command::new("sh");
        let output = command.args(["-c", &line, env!("CARGO_BIN_EXE_occluscope")]).output().unwrap();
        assert_eq!((output.status.code(), said(&output).as_str()), (Some(1), told), "{arguments}");
    }
}

/// The operating system ends every file at some KiB (the unit differs from shell to shell), with the signal that ends a process.
#[test]
fn a_limit_of_files_is_told_and_leaves_nothing() {
    for work in all_works() {
        let place = work.place();
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -f 4; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_occluscope")]);
        let output = command.args(work.arguments(place.path())).output().unwrap();
        let said = said(&output);
        if output.status.success() {
            assert_eq!(work.faults(&files(place.path())), [""; 0], "{}", work.name);
            continue;
        }
        assert_eq!(output.status.code(), Some(1), "{}: {said}", work.name);
        assert!(said.lines().count() == 1 && said.contains(text(place.path())), "{}: {said}", work.name);
        assert!(said.contains("exceeds the largest size of a file"), "{}: {said}", work.name);
        assert_eq!(work.changes(&files(place.path())), [""; 0], "{}", work.name);
    }
}

/// A target that cannot be replaced is found before the work, and nothing is changed.
#[test]
fn a_folder_in_place_of_a_file_is_told_before_the_work() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 3, 1);
    for (name, flags) in
        [("events.jsonl", ""), ("annotated.mp4", "--annotated"), ("masks/bin000002.png", "--masks")]
    {
        std::fs::create_dir_all(out.join(name)).unwrap();
        let before = files(&out);
        let mut arguments = vec!["run", text(&images), "--out", text(&out)];
        arguments.extend(flags.split_whitespace());
        let line = fails(&arguments, 1);
        let told = format!("error: {} cannot be written: it is a folder", text(&out.join(name)));
        assert!(line.starts_with(&told), "{line}");
        assert_eq!(files(&out), before);
        std::fs::remove_dir_all(&out).unwrap();
    }
}

/// Two sweeps into one folder would write the same rows.
#[test]
fn a_second_sweep_into_a_folder_is_refused() {
    let place = TestFolder::new();
    let (scene, out) = (place.path("scene"), place.path("out"));
    works(&["synth", "empty", "--frames", "3", "--size", "64x64", "--quiet", "--out", text(&scene)]);
    std::fs::create_dir(&out).unwrap();
    let rows = std::fs::File::create(out.join("rows.jsonl")).unwrap();
    rows.lock().unwrap();
    let video = scene.join("empty.mp4");
    let arguments = ["sweep", text(&video), "--truth", text(&scene), "--quiet", "--out", text(&out)];
    let line = fails(&arguments, 1);
    let told = format!("error: another sweep writes into {}; wait until it is done", text(&out));
    assert!(line.starts_with(&told), "{line}");
    assert_eq!(place.names("out"), ["rows.jsonl"]);
    drop(rows);
    works(&arguments);
}

/// Ctrl+C once stops at the next frame, twice at once; both leave nothing.
#[test]
fn stopped_twice_it_leaves_nothing() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    // So many frames are not done before the signals arrive.
    write_images(&images, 1500, 1);
    let mut command = Command::new(env!("CARGO_BIN_EXE_occluscope"));
    command.args(["run", text(&images), "--out", text(&out), "--masks", "--quiet"]).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let is_begun = || std::fs::read_dir(&out).is_ok_and(|mut entries| entries.next().is_some());
    while !is_begun() {
        assert_eq!(child.try_wait().unwrap(), None, "it ended before it wrote anything");
        std::thread::sleep(Duration::from_millis(1));
    }
    for _ in 0..2 {
        // The shell's own, as the test has no other way to send a signal.
        let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).output();
        // The first one can have ended it already.
        sent.unwrap();
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(!out.exists() || files(&out).is_empty(), "{:?}", files(&out).keys());
}

/// What another command or the user has put there is not replaced.
#[test]
fn inputs_and_pictures_of_others_are_not_replaced() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("images/out"));
    write_images(&images.join("frames"), 3, 1);
    let (inputs, target) = (images.join("frames"), out.join("masks"));
    let before = files(&images);
    for arguments in [
        vec!["run", text(&inputs), "--out", text(&images), "--frames"],
        vec!["pixel", text(&inputs), "--at", "1,1", "--out", text(&inputs.join("in000002.png"))],
        vec!["model", text(&inputs), "--frame", "2", "--out", text(&inputs.join("in000002.png"))],
    ] {
        let line = fails(&arguments, 1);
        assert!(line.contains("is an input of this command"), "{line}");
        assert_eq!(files(&images), before);
    }
    std::fs::create_dir_all(&target).unwrap();
    std::fs::write(target.join("bin000002.png"), "mine").unwrap();
    let line = fails(&["run", text(&inputs), "--out", text(&out), "--masks"], 1);
    assert!(line.contains("pictures that this program did not write"), "{line}");
    assert_eq!(std::fs::read_to_string(target.join("bin000002.png")).unwrap(), "mine");

    let results = place.path("results");
    works(&["run", text(&inputs), "--quiet", "--out", text(&results)]);
    let before = files(&results);
    let table = results.join("tracks.json");
    let line = fails(&["export", text(&results), "--format", "coco", "--out", text(&table)], 1);
    assert!(line.contains("is an input of this command"), "{line}");
    assert_eq!(files(&results), before);
}

/// A file of the name of a sweep's rows that is none is left alone.
#[test]
fn foreign_rows_are_left_alone() {
    let place = TestFolder::new();
    let (scene, out) = (place.path("scene"), place.path("out"));
    works(&["synth", "empty", "--frames", "3", "--size", "64x64", "--quiet", "--out", text(&scene)]);
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("rows.jsonl"), "my own notes").unwrap();
    let video = scene.join("empty.mp4");
    let line = fails(&["sweep", text(&video), "--truth", text(&scene), "--quiet", "--out", text(&out)], 1);
    assert!(line.contains("rows.jsonl is not of a sweep"), "{line}");
    assert_eq!(std::fs::read_to_string(out.join("rows.jsonl")).unwrap(), "my own notes");
}
