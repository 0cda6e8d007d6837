//! Messages for wrong usage and for unusable inputs, which leave no output.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{TestFolder, fails, occluscope, scene, text, works, write_images};

/// The message of a run with these arguments, which has to be refused as wrong usage and to write nothing.
fn refusal(arguments: &[&str]) -> String {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 2, 1);
    let out = place.path("out");
    let line = fails(&[&["run", text(&video), "--out", text(&out)], arguments].concat(), 2);
    assert!(!out.exists(), "{arguments:?}");
    line
}

/// The message of a run with a settings file of this content, which has to be refused and to name the file.
fn refusal_of_file(content: &str) -> String {
    let place = TestFolder::new();
    let file = place.path("my.toml");
    fs::write(&file, content).unwrap();
    let line = refusal(&["--settings", text(&file)]);
    assert!(line.contains("my.toml"), "{content}: {line}");
    line
}

#[test]
fn a_video_in_place_of_a_settings_file_is_refused() {
    let place = TestFolder::new();
    let (video, file) = (place.path("images"), place.path("street.mp4"));
    write_images(&video, 2, 1);
    fs::write(&file, [0_u8, 0, 0, 0x20, 0xff, 0xfe].repeat(1 << 19)).unwrap();
    let line = fails(&["run", text(&video), "--out", text(&place.path("out")), "--settings", text(&file)], 1);
    assert!(line.contains("street.mp4 cannot be read: it is not a text file"), "{line}");
}

#[test]
fn a_setting_out_of_range_is_refused_with_its_range() {
    let alpha = refusal(&["--alpha", "1"]);
    assert!(alpha.contains("alpha") && alpha.contains("0 < α < 1"), "{alpha}");
    let k = refusal(&["--k", "9"]);
    assert!(k.contains("1–8"), "{k}");
}

#[test]
fn a_negative_number_is_refused_as_the_value_of_its_setting() {
    let line = refusal(&["--alpha", "-0.5"]);
    assert!(line.contains("`-0.5`"), "{line}");
}

#[test]
fn options_of_video_files_are_refused_for_images() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 2, 1);
    for flags in [&["--deinterlace"][..], &["--stream", "0"]] {
        let line = fails(&[&["run", text(&images), "--out", text(&out)], flags].concat(), 1);
        assert!(line.contains(flags[0]) && line.contains("for video files, not for images"), "{line}");
        assert!(!out.exists());
    }
    let line = fails(&["run", text(&images), "--out", text(&out), "--stream", "first"], 2);
    assert!(line.contains("--stream cannot be `first`"), "{line}");
}

#[test]
fn a_duration_out_of_range_is_refused() {
    let line = refusal(&["--max-hidden", "99999999s"]);
    assert!(line.contains("max_hidden"), "{line}");
}

#[test]
fn an_unknown_choice_is_refused_with_the_known_ones() {
    for (flag, word, known) in [
        ("--rate", "fast", "density | weight | constant"),
        ("--background-model", "median", "mixture | mog2 | knn"),
    ] {
        let line = refusal(&[flag, word]);
        assert!(line.contains(known), "{flag}: {line}");
    }
}

#[test]
fn an_unknown_preset_is_refused_with_the_known_ones() {
    let line = refusal(&["--preset", "best"]);
    assert!(line.contains("opencv-mog"), "{line}");
}

#[test]
fn a_range_that_is_not_two_numbers_in_order_is_refused() {
    for range in ["5", "9..3", "a..b", "-1..3"] {
        let line = refusal(&["--range", range]);
        assert!(line.contains("--range"), "{range}: {line}");
    }
}

#[test]
fn a_settings_file_with_an_unknown_setting_is_refused() {
    let line = refusal_of_file("alfa = 0.1");
    assert!(line.contains("alfa"), "{line}");
}

#[test]
fn a_settings_file_with_a_value_out_of_range_is_refused() {
    let line = refusal_of_file("alpha = 2.0");
    assert!(line.contains("0 < α < 1"), "{line}");
}

#[test]
fn a_settings_file_with_a_value_of_another_type_is_refused() {
    let line = refusal_of_file("alpha = [1]");
    assert!(line.contains("alpha"), "{line}");
}

#[test]
fn a_settings_file_that_is_not_toml_is_refused() {
    refusal_of_file("alpha");
}

/// Asserts that the command line is refused: status 2, a message on stderr and nothing on stdout.
fn assert_wrong_usage(arguments: &[&str]) {
    let output = occluscope(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
}

#[test]
fn an_option_out_of_range_is_refused() {
    assert_wrong_usage(&["run", "video.avi", "--out", "there", "--threads", "0"]);
    assert_wrong_usage(&["one.avi", "--memory", "5"]);
    assert_wrong_usage(&["bench", "one.avi", "--frames", "3"]);
}

#[test]
fn an_unknown_flag_is_refused() {
    assert_wrong_usage(&["run", "video.avi", "--out", "there", "--alfa", "0.1"]);
    assert_wrong_usage(&["settings", "--quiet", "-v"]);
}

#[test]
fn a_missing_argument_is_refused() {
    assert_wrong_usage(&["run", "video.avi"]);
    assert_wrong_usage(&["run", "--out", "there"]);
    assert_wrong_usage(&["pixel", "video.avi"]);
    assert_wrong_usage(&["score", "results"]);
}

#[test]
fn a_second_video_is_refused() {
    assert_wrong_usage(&["one.avi", "two.avi"]);
}

#[test]
fn a_pixel_that_is_not_two_numbers_is_refused() {
    for at in ["5", "a,b", "5,", "-1,3", "5,5,5", "99999999999,1"] {
        let line = fails(&["pixel", "video.avi", "--at", at], 2);
        assert!(line.contains("--at"), "{at}: {line}");
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
    let names = ["run", "pixel", "model", "score", "export", "sweep", "bench", "settings", "synth"];
    assert!(names.iter().all(|name| help.contains(&format!("\n  {name} "))), "{help}");
}

#[test]
fn wrong_usage_is_told_in_one_line_with_the_help_to_read() {
    for (arguments, parts) in [
        (&["run"][..], &["--out <DIR>, <VIDEO>", "see occluscope run --help"][..]),
        (&["run", "x", "--out", "y", "--threads", "0"], &["'0' for '--threads <N>'", "1..=1024"]),
        (&["run", "x", "--out", "y", "--k"], &["a value is required for '--k <N>'"]),
        (
            &["run", "x", "--out", "y", "--bogus"],
            &["unexpected argument '--bogus' found; see occluscope run --help"],
        ),
        (&["run", "x", "--out", "y", "--mask"], &["'--mask' found; a similar argument exists: '--masks'"]),
        (&["run", "x", "y", "--out", "z"], &["unexpected argument 'y'"]),
        (&["sweep", "--sequence", "a", "b", "--out", "z"], &["3 values required", "sweep --help"]),
        (&["score"], &["--truth <PATH>, <DIR>"]),
        (&["--bogus"], &["'--bogus' found; see occluscope --help"]),
    ] {
        let line = fails(arguments, 2);
        assert!(line.starts_with("error: ") && parts.iter().all(|part| line.contains(part)), "{line}");
    }
}

/// Asserts that `run` and `pixel` fail on `input` in one line that names it, and write nothing into `place`.
fn assert_unusable(place: &TestFolder, input: &Path) {
    let before = place.names(".");
    let out = place.path("new/out");
    let line = fails(&["run", text(input), "--out", text(&out), "--masks"], 1);
    assert!(line.contains(text(input)), "{line}");
    let line = fails(&["pixel", text(input), "--at", "1,1", "--out", text(&place.path("p.csv"))], 1);
    assert!(line.contains(text(input)), "{line}");
    assert_eq!(place.names("."), before);
}

#[test]
fn a_missing_video_leaves_no_output() {
    let place = TestFolder::new();
    assert_unusable(&place, &place.path("nowhere.avi"));
}

#[test]
fn a_file_that_is_no_video_leaves_no_output() {
    let place = TestFolder::new();
    fs::write(place.path("notes.txt"), "this is no video").unwrap();
    assert_unusable(&place, &place.path("notes.txt"));
}

#[test]
fn an_empty_file_leaves_no_output() {
    let place = TestFolder::new();
    fs::write(place.path("empty.avi"), "").unwrap();
    assert_unusable(&place, &place.path("empty.avi"));
}

#[test]
fn an_empty_folder_leaves_no_output() {
    let place = TestFolder::new();
    fs::create_dir(place.path("empty")).unwrap();
    assert_unusable(&place, &place.path("empty"));
}

#[test]
fn images_of_different_sizes_leave_no_output() {
    let place = TestFolder::new();
    let mixed = place.path("mixed");
    write_images(&mixed, 3, 1);
    image::RgbImage::new(20, 20).save(mixed.join("in000002.png")).unwrap();
    assert_unusable(&place, &mixed);
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
}

#[test]
fn a_pixel_of_a_model_without_mixture_is_refused() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 2, 1);
    let images = place.path("images");
    for model in ["mog2", "knn"] {
        let line = fails(&["pixel", text(&images), "--at", "1,1", "--background-model", model], 2);
        assert!(line.contains("no mixture"), "{model}: {line}");
    }
}

#[test]
fn a_file_in_place_of_the_output_folder_stays() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 2, 1);
    let images = place.path("images");
    fs::write(place.path("taken"), "a file").unwrap();
    let taken = place.path("taken");
    assert!(fails(&["run", text(&images), "--out", text(&taken)], 1).contains("taken"));
    assert_eq!(fs::read_to_string(taken).unwrap(), "a file");
}

#[test]
fn a_folder_in_place_of_the_output_file_is_reported() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 2, 1);
    let images = place.path("images");
    assert!(fails(&["pixel", text(&images), "--at", "1,1", "--out", text(&images)], 1).contains("images"));
}

#[cfg(unix)]
#[test]
fn an_output_that_cannot_be_made_is_reported_with_a_remedy() {
    let place = TestFolder::new();
    write_images(&place.path("images"), 2, 1);
    let images = place.path("images");
    let link = place.path("link");
    std::os::unix::fs::symlink(place.path("gone"), &link).unwrap();
    let line = fails(&["run", text(&images), "--out", text(&link)], 1);
    assert!(line.contains("link cannot be written: it is a link to a place that does not exist"), "{line}");
    let long = place.path(&"n".repeat(300));
    let line = fails(&["run", text(&images), "--out", text(&long)], 1);
    assert!(line.contains("its name is too long") && line.contains("choose another name"), "{line}");
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
        || out.is_dir() && common::names(&out).iter().any(|name| out.join(name).join("new/masks").is_dir());
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
}

#[test]
fn unknown_truth_is_reported_before_the_window_opens() {
    let place = TestFolder::new();
    fs::create_dir(place.path("empty")).unwrap();
    assert!(
        fails(&["video.avi", "--truth", text(&place.path("empty"))], 1)
            .contains("unknown ground truth format")
    );
}
