//! `sweep`: rows equal to those of `run` and `score`, stopping and going on, rows of runs, and refused inputs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{HEIGHT, TestFolder, WIDTH, fails, occluscope, text, works, write_images};
use image::{GrayImage, Luma};
use serde_json::Value;

/// The left edge of the block of [`common::scene`] and its width in a frame, if it is in it.
fn block(frame: u32) -> Option<(i64, i64)> {
    let left = i64::from(frame) * 2 - 50;
    let (from, to) = (left.max(0), (left + 10).min(i64::from(WIDTH)));
    (from < to).then_some((from, to - from))
}

/// A data set of two categories: masks in CDnet's layout, boxes in MOTChallenge's.
fn write_data_set(root: &Path, frames: u32) {
    let cdnet = root.join("masked/block");
    write_images(&cdnet.join("input"), frames, 1);
    fs::create_dir_all(cdnet.join("groundtruth")).unwrap();
    let mot = root.join("boxed/block");
    write_images(&mot.join("img1"), frames, 1);
    let mut rows = String::new();
    for frame in 1..=frames {
        let mut mask = GrayImage::new(WIDTH, HEIGHT);
        if let Some((left, width)) = block(frame) {
            for (x, y) in (left..left + width).flat_map(|x| (25..50).map(move |y| (x as u32, y))) {
                mask.put_pixel(x, y, Luma([255]));
            }
            writeln!(rows, "{frame},1,{left},25,{width},25,1,1,1").unwrap();
        }
        mask.save(cdnet.join(format!("groundtruth/gt{frame:06}.png"))).unwrap();
    }
    fs::create_dir_all(mot.join("gt")).unwrap();
    fs::write(mot.join("gt/gt.txt"), rows).unwrap();
}

/// The rows of `sweep.csv` as maps from column to text.
fn rows(out: &Path) -> Vec<std::collections::HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(out.join("sweep.csv")).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

/// The measures in `rows.jsonl` by sequence and settings.
fn logged(out: &Path) -> std::collections::HashMap<(String, String), Value> {
    let lines = fs::read_to_string(out.join("rows.jsonl")).unwrap();
    let row = |line: &str| {
        let row: Value = serde_json::from_str(line).unwrap();
        let of = |key: &str| row[key].as_str().unwrap().to_owned();
        ((of("sequence"), of("settings")), row["measures"].clone())
    };
    lines.lines().map(row).collect()
}

#[test]
fn rows_equal_those_of_run_and_score() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 60);
    for (at, options) in [&["--range", "5..55"][..], &["--scale", "0.5", "--every", "2"]].iter().enumerate() {
        let out = place.path(&format!("swept{at}"));
        let mut sweep =
            vec!["sweep", "--dataset", text(&root), "--grid", "k=2,3", "--grid", "min-area=10,30"];
        sweep.extend([
            "--grid",
            "measurement-noise=2,8",
            "--bootstrap",
            "10",
            "--quiet",
            "--out",
            text(&out),
        ]);
        sweep.extend(*options);
        let best = works(&sweep);
        assert!(best.contains("masked/block") && best.contains("overall"), "{best}");
        let logged = logged(&out);
        assert_eq!((logged.len(), rows(&out).len()), (16, 16));
        for k in ["2", "3"] {
            for (min_area, noise) in [("10", "2"), ("30", "8")] {
                for (name, truth) in
                    [("masked/block", "masked/block"), ("boxed/block", "boxed/block/gt/gt.txt")]
                {
                    let results = place.path("results");
                    let (video, truth) = (root.join(name), root.join(truth));
                    let mut run = vec!["run", text(&video), "--masks", "--out", text(&results), "--quiet"];
                    run.extend(["--k", k, "--min-area", min_area, "--measurement-noise", noise]);
                    run.extend(["--bootstrap", "10"]);
                    run.extend(*options);
                    works(&run);
                    let score =
                        works(&["score", text(&results), "--truth", text(&truth), "--json", "--quiet"]);
                    let score: Value = serde_json::from_str(&score).unwrap();
                    let settings = format!("k={k} min_area={min_area} measurement_noise={noise}");
                    let row = &logged[&(name.to_owned(), settings.clone())];
                    let measures = row.as_object().unwrap();
                    assert!(measures.len() > 4, "{row}");
                    for (measure, value) in measures {
                        assert_eq!(value, &score[measure], "{name} {settings} {measure}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_stopped_sweep_goes_on_and_a_larger_grid_computes_what_it_adds() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 60);
    let out = place.path("swept");
    let alphas = |count: u32| format!("alpha=log:0.001..0.1:{count}");
    let arguments = |count: u32, out: &Path| -> Vec<String> {
        let out = text(out).to_owned();
        let root = text(&root).to_owned();
        ["sweep", "--dataset", &root, "--grid", &alphas(count), "--threads", "1", "--out", &out]
            .map(ToOwned::to_owned)
            .to_vec()
    };
    let lines = |out: &Path| {
        fs::read_to_string(out.join("rows.jsonl"))
            .unwrap_or_default()
            .lines()
            .map(ToOwned::to_owned)
            .collect::<Vec<_>>()
    };
    let stopped_arguments = arguments(40, &out);
    let stopped_arguments: Vec<&str> = stopped_arguments.iter().map(String::as_str).collect();
    let child = occluscope(&stopped_arguments);
    let mut child = Command::new(child.get_program())
        .args(child.get_args())
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while lines(&out).is_empty() {
        assert!(started.elapsed() < Duration::from_mins(5), "no row in five minutes");
        thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let mut message = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut message).unwrap();
    assert!(message.contains("repeat the command to go on"), "{message}");
    let before = lines(&out);
    assert!((8..80).contains(&before.len()), "{} rows", before.len());
    assert!(!out.join("sweep.csv").exists());

    works(&stopped_arguments);
    let after = lines(&out);
    assert_eq!((after[..before.len()].to_vec(), after.len()), (before, 80));
    assert_eq!(rows(&out).len(), 80);

    // A grid that holds one of these values again, and another.
    let mut larger = arguments(40, &out);
    larger[4] = "alpha=0.001,0.7".to_owned();
    works(&larger.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!((lines(&out).len(), rows(&out).len()), (82, 4));
    assert_eq!(common::names(&out).iter().filter(|name| name.starts_with('.')).count(), 0);
}

#[test]
fn a_sweep_that_is_stopped_before_its_first_row_names_no_file() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 400);
    let out = place.path("swept");
    let child = occluscope(&["sweep", "--dataset", text(&root), "--threads", "1", "--out", text(&out)]);
    let child = Command::new(child.get_program())
        .args(child.get_args())
        .args(["--grid", "k=2,3,4,5", "--grid", "alpha=0.01,0.02"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !out.join("rows.jsonl").exists() {
        assert!(started.elapsed() < Duration::from_mins(5), "no file of rows in five minutes");
        thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && message.contains("repeat the command"), "{message}");
    let is_there = out.join("rows.jsonl").exists();
    assert_eq!(message.contains("rows.jsonl"), is_there, "{message}");
}

#[test]
fn rows_of_scored_runs_are_taken() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 40);
    let (video, truth) = (root.join("masked/block"), root.join("masked/block"));
    for k in ["2", "3"] {
        let results = place.path(&format!("runs/k{k}"));
        works(&["run", text(&video), "--masks", "--out", text(&results), "--k", k, "--quiet"]);
        let score = works(&["score", text(&results), "--truth", text(&truth), "--json", "--quiet"]);
        // A score that no analysis gives: so the row is from here.
        let mut score: Value = serde_json::from_str(&score).unwrap();
        score["f"] = 0.125.into();
        fs::write(results.join("score.json"), score.to_string()).unwrap();
    }
    let (runs, out) = (place.path("runs"), place.path("swept"));
    let arguments = ["sweep", text(&video), "--truth", text(&truth), "--results", text(&runs)];
    let rest = ["--out", text(&out), "--grid", "k=2,3,4"];
    let output = occluscope(&[&arguments[..], &rest].concat()).output().unwrap();
    let notes = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && notes.contains("2 rows are from 2 scored runs"), "{notes}");
    let values: Vec<_> = rows(&out).iter().map(|row| (row["k"].clone(), row["f"] == "0.125")).collect();
    assert_eq!(values, [("2", true), ("3", true), ("4", false)].map(|(k, of_run)| (k.to_owned(), of_run)));
    // Of another range they are not taken.
    let output = occluscope(&[&arguments[..], &rest, &["--range", "1..39"]].concat()).output().unwrap();
    assert!(String::from_utf8(output.stderr).unwrap().contains("0 rows are from 2"));
    // A score of an earlier run into the folder is not that of its settings; its row is computed.
    let results = place.path("runs/k2");
    works(&["run", text(&video), "--masks", "--out", text(&results), "--k", "5", "--quiet"]);
    let warned = || {
        let output = occluscope(&[&arguments[..], &rest].concat()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{stderr}");
        let warning = stderr.lines().find(|line| line.starts_with("warning: ")).unwrap_or_default();
        assert!(warning.contains("score again; its row is computed"), "{stderr}");
        warning.to_owned()
    };
    assert!(warned().contains("k2/score.json is not of the run"));
    fs::write(place.path("runs/k2/score.json"), "{}").unwrap();
    assert!(warned().contains("k2/score.json"));
}

#[test]
fn runs_without_a_measure_that_the_truth_permits_are_not_taken() {
    let place = TestFolder::new();
    let scene = place.path("scene");
    works(&["synth", "tree", "--frames", "90", "--size", "96x64", "--out", text(&scene), "--quiet"]);
    let (video, runs, out) = (scene.join("tree.mp4"), place.path("runs"), place.path("swept"));
    works(&["run", text(&video), "--out", text(&runs), "--quiet"]);
    let score = works(&["score", text(&runs), "--truth", text(&scene), "--json", "--quiet"]);
    fs::write(runs.join("score.json"), score).unwrap();
    let arguments =
        ["sweep", text(&video), "--truth", text(&scene), "--results", text(&runs), "--out", text(&out)];
    let output = occluscope(&arguments).output().unwrap();
    let notes = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && notes.contains("0 rows are from 1 scored runs"), "{notes}");
    let row = &rows(&out)[0];
    assert!(["f", "mota", "episode_recall"].iter().all(|measure| !row[*measure].is_empty()), "{row:?}");
}

#[test]
fn a_row_is_computed_again_where_anything_that_it_follows_from_differs() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 30);
    let (video, truth, out) =
        (root.join("boxed/block"), root.join("boxed/block/gt/gt.txt"), place.path("out"));
    let lines = || fs::read_to_string(out.join("rows.jsonl")).unwrap().lines().count();
    let sweep = |more: &[&str]| {
        let arguments = ["sweep", text(&video), "--truth", text(&truth), "--quiet", "--out", text(&out)];
        works(&[&arguments[..], more].concat());
        lines()
    };
    assert_eq!((sweep(&[]), sweep(&[])), (1, 1));
    let roi = place.path("roi.png");
    for (count, right) in [(2, 50), (3, 60)] {
        let inside = |x: u32| Luma([if (10..right).contains(&x) { 255 } else { 0 }]);
        GrayImage::from_fn(WIDTH, HEIGHT, |x, _| inside(x)).save(&roi).unwrap();
        assert_eq!(sweep(&["--roi", text(&roi)]), count);
    }
    let others: [&[&str]; 6] = [
        &["--range", "1..29"],
        &["--offset", "1"],
        &["--scale", "0.5"],
        &["--k", "4"],
        &["--gate", "0.98"],
        &["--crop", "0,0,50,50"],
    ];
    for (count, more) in (4..).zip(others) {
        assert_eq!((sweep(more), sweep(more)), (count, count), "{more:?}");
    }
    let rows = fs::read_to_string(&truth).unwrap();
    fs::write(&truth, rows.replacen("25,10,25", "26,10,25", 1)).unwrap();
    assert_eq!((sweep(&[]), sweep(&[])), (10, 10));
    fs::write(video.join("seqinfo.ini"), "[Sequence]\nframeRate=10\n").unwrap();
    assert_eq!((sweep(&[]), sweep(&[])), (11, 11));

    // With true masks alone nothing follows from tracking. The output can lie within the input.
    let masked = root.join("masked/block");
    let out = masked.join("swept");
    let sweep = |more: &[&str]| {
        let arguments = ["sweep", text(&masked), "--truth", text(&masked), "--quiet", "--out", text(&out)];
        works(&[&arguments[..], more].concat());
        fs::read_to_string(out.join("rows.jsonl")).unwrap().lines().count()
    };
    assert_eq!((sweep(&[]), sweep(&["--gate", "0.98"]), sweep(&["--opening", "3"])), (1, 1, 2));
}

#[test]
fn a_sequence_that_fails_does_not_end_the_others() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 30);
    let mask = GrayImage::new(7, 5);
    mask.save(root.join("masked/block/groundtruth/gt000020.png")).unwrap();
    let out = place.path("swept");
    let output =
        occluscope(&["sweep", "--dataset", text(&root), "--out", text(&out), "--quiet"]).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), error.lines().count()), (Some(1), 1), "{error}");
    assert!(
        error.contains("masked/block") && error.contains("gt000020.png") && error.contains("7×5"),
        "{error}"
    );
    let rows = rows(&out);
    assert_eq!((rows.len(), &*rows[0]["sequence"]), (1, "boxed/block"));
    assert!(fs::read_to_string(out.join("report.html")).unwrap().contains("gt000020.png"));
}

#[test]
fn without_a_terminal_only_details_are_printed() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 30);
    for (out, flags, lines) in [("silent", &[][..], 0), ("detailed", &["-v"], 2)] {
        let out = place.path(out);
        let arguments = ["sweep", "--dataset", text(&root), "--grid", "k=2,3", "--out", text(&out)];
        let output = occluscope(&[&arguments[..], flags].concat()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.success()
                && stderr.lines().filter(|line| line.contains("% of all")).count() == lines,
            "{stderr}"
        );
        assert!(lines > 0 || stderr.is_empty(), "{stderr}");
    }
}

#[test]
fn wrong_usage_and_truth_are_told_in_a_line_before_any_work() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root, 30);
    let (video, truth) = (root.join("boxed/block"), root.join("boxed/block/gt/gt.txt"));
    let (video, truth, out) = (text(&video), text(&truth), place.path("out"));
    let out = text(&out);
    let late = place.path("late.txt");
    fs::write(&late, "100,1,0,0,10,10,1,1,1\n").unwrap();
    fs::create_dir(place.path("empty")).unwrap();
    let empty = place.path("empty");
    for (arguments, status, part) in [
        (&["sweep", video, "--out", out][..], 2, "--truth"),
        (&["sweep", "--out", out], 2, "--dataset ROOT"),
        (&["sweep", video, "--truth", truth, "--dataset", video, "--out", out], 2, "--dataset ROOT"),
        (&["sweep", video, "--truth", truth, "--grid", "k=9", "--out", out], 2, "`9`"),
        (&["sweep", video, "--truth", truth, "--grid", "k", "--out", out], 2, "k=3,4,5"),
        (&["sweep", video, "--truth", truth, "--by", "best", "--out", out], 2, "mota"),
        (
            &["sweep", "--sequence", "a", video, truth, "--sequence", "a", video, truth, "--out", out],
            2,
            "name a",
        ),
        (&["sweep", "--dataset", text(&empty), "--out", out], 1, "no sequences"),
        (&["sweep", "camera:0", "--truth", truth, "--out", out], 1, "camera:0"),
        (&["sweep", "nothing.mp4", "--truth", truth, "--out", out], 1, "nothing.mp4"),
        (&["sweep", video, "--truth", "nothing.txt", "--out", out], 1, "nothing.txt"),
        (&["sweep", video, "--truth", text(&late), "--quiet", "--out", out], 1, "--offset"),
    ] {
        let error = fails(arguments, status);
        assert!(error.contains(part), "{arguments:?}: {error}");
        assert!(!Path::new(out).join("sweep.csv").exists());
    }
    let output = works(&["sweep", "--sequence", "a", video, truth, "--by", "mota", "--quiet", "--out", out]);
    assert!(output.contains("as they are"), "{output}");
    assert_eq!(rows(Path::new(out)).len(), 1);
}
