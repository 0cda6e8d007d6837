//! Messages for wrong usage and for unusable inputs, which leave no output.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{TestFolder, fails, occluscope, scene, text, works, write_images};

#[test]
fn settings_out_of_range_or_unknown_are_wrong_usage() {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 2, 1);
    let out = place.path("out");
    let run = ["run", text(&video), "--out", text(&out)];
    let refused = |more: &[&str]| fails(&[&run[..], more].concat(), 2);

    let alpha = refused(&["--alpha", "1"]);
    assert!(alpha.contains("alpha") && alpha.contains("0 < α < 1"), "{alpha}");
    assert!(refused(&["--alpha", "-0.5"]).contains("`-0.5`"));
    assert!(refused(&["--k", "9"]).contains("1–8"));
    assert!(refused(&["--rate", "fast"]).contains("density | weight | constant"));
    assert!(refused(&["--max-hidden", "99999999s"]).contains("max_hidden"));
    assert!(refused(&["--background-model", "median"]).contains("mixture | mog2 | knn"));
    assert!(refused(&["--preset", "best"]).contains("opencv-mog"));
    for range in ["5", "9..3", "a..b", "-1..3"] {
        assert!(refused(&["--range", range]).contains("--range"), "{range}");
    }

    let file = place.path("my.toml");
    for (content, part) in
        [("alfa = 0.1", "alfa"), ("alpha = 2.0", "0 < α < 1"), ("alpha = [1]", "alpha"), ("alpha", "my.toml")]
    {
        fs::write(&file, content).unwrap();
        let line = refused(&["--settings", text(&file)]);
        assert!(line.contains(part) && line.contains("my.toml"), "{content}: {line}");
    }
    assert!(!out.exists());
}

#[test]
fn the_command_line_itself_is_checked() {
    for arguments in [
        &["run", "video.avi", "--out", "there", "--threads", "0"][..],
        &["run", "video.avi", "--out", "there", "--alfa", "0.1"],
        &["run", "video.avi"],
        &["run", "--out", "there"],
        &["pixel", "video.avi"],
        &["one.avi", "two.avi"],
        &["one.avi", "--memory", "5"],
        &["score", "results"],
        &["bench", "one.avi", "--frames", "3"],
        &["settings", "--quiet", "-v"],
    ] {
        let output = occluscope(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
    }
    for at in ["5", "a,b", "5,", "-1,3", "5,5,5", "99999999999,1"] {
        assert!(fails(&["pixel", "video.avi", "--at", at], 2).contains("--at"), "{at}");
    }
}

#[test]
fn help_and_version_are_printed() {
    let version = works(&["--version"]);
    // A release build also prints its commit.
    assert_eq!(version.trim(), format!("occluscope {}", env!("OCCLUSCOPE_VERSION")));
    assert!(version.starts_with(concat!("occluscope ", env!("CARGO_PKG_VERSION"))));
    let short = works(&["run", "-h"]);
    let long = works(&["run", "--help"]);
    for part in ["--out", "--masks", "--range", "--threads", "--preset", "tracks.csv"] {
        assert!(short.contains(part) && long.contains(part), "{part}");
    }
    for part in ["--match-sigmas", "λ", "0.5–10", "Mixture:", "Occlusion:"] {
        assert!(long.contains(part) && !short.contains(part), "{part}");
    }
    let help = works(&["--help"]);
    assert!(["run", "pixel", "score", "bench", "settings", "synth"].iter().all(|name| help.contains(name)));
    assert!(!help.contains("sweep"));
}

#[test]
fn unusable_inputs_fail_in_one_line_and_leave_no_output() {
    let place = TestFolder::new();
    let file = |name: &str, content: &str| {
        fs::write(place.path(name), content).unwrap();
        place.path(name)
    };
    let missing = place.path("nowhere.avi");
    let no_video = file("notes.txt", "this is no video");
    let empty_file = file("empty.avi", "");
    let empty = place.path("empty");
    fs::create_dir(&empty).unwrap();
    let mixed = place.path("mixed");
    write_images(&mixed, 3, 1);
    image::RgbImage::new(20, 20).save(mixed.join("in000002.png")).unwrap();
    let before = place.names(".");

    for input in [&missing, &no_video, &empty_file, &empty, &mixed] {
        let out = place.path("new/out");
        let line = fails(&["run", text(input), "--out", text(&out), "--masks"], 1);
        assert!(line.contains(text(input)), "{line}");
        let line = fails(&["pixel", text(input), "--at", "1,1", "--out", text(&place.path("p.csv"))], 1);
        assert!(line.contains(text(input)), "{line}");
        assert_eq!(place.names("."), before, "after {}", input.display());
    }
}

#[test]
fn a_range_beyond_the_end_leaves_no_output() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 4, 10);
    let images = place.path("images");
    let out = place.path("out");
    let line = fails(&["run", text(&images), "--out", text(&out), "--range", "14..20"], 1);
    assert!(line.contains("14..20") && line.contains("13"), "{line}");
    assert_eq!(place.names("."), ["images"]);
}

#[test]
fn the_error_of_a_pixel_outside_the_image_names_the_size() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 2, 1);
    let images = place.path("images");
    let line = fails(&["pixel", text(&images), "--at", "96,0"], 1);
    assert!(line.contains("96×72") && line.contains("0–95"), "{line}");
    for model in ["mog2", "knn"] {
        let line = fails(&["pixel", text(&images), "--at", "1,1", "--background-model", model], 2);
        assert!(line.contains("no mixture"), "{line}");
    }
}

#[test]
fn unwritable_results_fail_in_one_line() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 2, 1);
    let images = place.path("images");
    fs::write(place.path("taken"), "a file").unwrap();
    let taken = place.path("taken");
    assert!(fails(&["run", text(&images), "--out", text(&taken)], 1).contains("taken"));
    assert!(fails(&["pixel", text(&images), "--at", "1,1", "--out", text(&images)], 1).contains("images"));
    assert_eq!(fs::read_to_string(taken).unwrap(), "a file");
}

#[test]
fn printed_settings_read_back_as_the_same() {
    let place = TestFolder::new();
    let toml = works(&["settings", "--preset", "paper", "--k", "5"]);
    assert!(toml.contains("\nk = 5\n") && toml.contains("\nrate = \"density\"\n"));
    fs::write(place.path("s.toml"), &toml).unwrap();
    assert_eq!(works(&["settings", "--settings", text(&place.path("s.toml"))]), toml);
}

#[test]
fn a_closed_pipe_is_not_a_failure() {
    let place = TestFolder::new();
    let images = place.path("images");
    fs::create_dir(&images).unwrap();
    scene(1).save(images.join("1.png")).unwrap();
    for number in 2..400 {
        fs::hard_link(images.join("1.png"), images.join(format!("{number}.png"))).unwrap();
    }
    let mut child = Command::new(env!("CARGO_BIN_EXE_occluscope"))
        .args(["pixel", text(&images), "--at", "5,5", "--k", "8"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("frame,value_r"), "{line}");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[cfg(unix)]
#[test]
fn a_stopped_run_leaves_no_output() {
    let place = TestFolder::new();
    let images = place.path("images");
    fs::create_dir(&images).unwrap();
    scene(1).save(images.join("1.png")).unwrap();
    for number in 2..3000 {
        fs::hard_link(images.join("1.png"), images.join(format!("{number}.png"))).unwrap();
    }
    let out = place.path("out");
    let child = Command::new(env!("CARGO_BIN_EXE_occluscope"))
        .args(["run", text(&images), "--out", text(&out), "--masks", "--plain-frames", "--background"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let patience = Instant::now() + Duration::from_secs(30);
    let at_work =
        || out.is_dir() && common::names(&out).iter().any(|name| out.join(name).join("masks").is_dir());
    while !at_work() {
        assert!(Instant::now() < patience, "the run did not start");
        thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.lines().count() == 1 && stderr.contains("stopped"), "{stderr}");
    assert_eq!(place.names("."), ["images"]);
}

#[cfg(not(feature = "gui"))]
#[test]
fn a_build_without_the_window_reports_it() {
    assert!(fails(&["video.avi"], 1).contains("no window"));
    assert!(fails(&[], 1).contains("occluscope run"));
}

#[test]
fn missing_truth_is_reported_before_the_window_opens() {
    let why = fails(&["video.avi", "--truth", "no/such/truth"], 1);
    assert!(why.contains("no/such/truth") && why.contains("does not exist"), "{why}");
    let place = TestFolder::new();
    fs::create_dir(place.path("empty")).unwrap();
    assert!(
        fails(&["video.avi", "--truth", text(&place.path("empty"))], 1)
            .contains("unknown ground truth format")
    );
}
