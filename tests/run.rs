//! `run` from images to files: the format of every file, frame numbers, reproducibility.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use common::{HEIGHT, TABLES, TestFolder, WIDTH, fails, occluscope, scene, text, works, write_images};
use opencv::core::{Mat, Vector};
use opencv::prelude::*;
use opencv::{imgcodecs, videoio};
use serde_json::Value;

/// Settings with which the small scene's block is an object.
const SMALL: [&str; 8] = ["--median", "0", "--min-area", "10", "--track-min-area", "0.5", "--alpha", "0.01"];

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&read(path)).unwrap()
}

fn run(video: &Path, out: &Path, more: &[&str]) -> String {
    works(&[&["run", text(video), "--out", text(out)], &SMALL[..], more].concat())
}

/// All files in a folder with their bytes; the summary without its timing.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for name in common::names(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            all.extend(contents(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else if name == "summary.json" {
            let mut summary = json(&path);
            assert!(summary.as_object_mut().unwrap().remove("timing").is_some());
            all.insert(name, summary.to_string().into_bytes());
        } else {
            all.insert(name, fs::read(&path).unwrap());
        }
    }
    all
}

fn numbered(prefix: &str, numbers: std::ops::RangeInclusive<u32>) -> Vec<String> {
    numbers.map(|number| format!("{prefix}{number:06}.png")).collect()
}

#[test]
fn every_file_has_its_documented_format() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("results/deep"));
    write_images(&images, 60, 1);
    let stdout = run(
        &images,
        &out,
        &[
            "--masks",
            "--labels",
            "--frames",
            "--annotated",
            "--background",
            "--plain-frames",
            "--bootstrap",
            "0",
        ],
    );
    assert!(stdout.is_empty());
    let mut expected: Vec<_> = TABLES.to_vec();
    expected.extend(["annotated.mp4", "background", "frames", "labels", "masks", "plain-frames"]);
    expected.sort_unstable();
    assert_eq!(common::names(&out), expected);

    let summary = json(&out.join("summary.json"));
    assert_eq!(summary["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(summary["input"]["path"], text(&images));
    assert_eq!(summary["input"]["size"], serde_json::json!({"width": WIDTH, "height": HEIGHT}));
    assert_eq!(summary["input"]["frames"], 60);
    assert_eq!(summary["input"]["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(summary["settings"]["min_area"], 10);
    assert!(summary["timing"]["frames_per_second"].as_f64().unwrap() > 0.0);

    // Images: numbered like the frames, masks of 0 and 255, whose share of foreground is in the summary.
    assert_eq!(common::names(&out.join("masks")), numbered("bin", 1..=60));
    for folder in ["frames", "background", "labels", "plain-frames"] {
        assert_eq!(common::names(&out.join(folder)), numbered("", 1..=60));
    }
    let mut foreground = 0;
    for name in numbered("bin", 1..=60) {
        let mask = image::open(out.join("masks").join(name)).unwrap();
        assert_eq!(mask.color(), image::ColorType::L8);
        let mask = mask.into_luma8();
        assert_eq!(mask.dimensions(), (WIDTH, HEIGHT));
        assert!(mask.pixels().all(|pixel| pixel.0 == [0] || pixel.0 == [255]));
        foreground += mask.pixels().filter(|pixel| pixel.0 == [255]).count();
    }
    let share = foreground as f64 / f64::from(60 * WIDTH * HEIGHT);
    assert!(
        (summary["foreground_share"].as_f64().unwrap() - share).abs() < 1e-12 && share > 0.005,
        "{share}"
    );
    let picture = |folder: &str, number: u32| {
        image::open(out.join(folder).join(format!("{number:06}.png"))).unwrap().into_rgb8()
    };
    assert_eq!(picture("plain-frames", 45), scene(45));
    assert_ne!(picture("frames", 45), scene(45));
    assert_eq!(picture("background", 1), scene(1), "the first frame is the first background");
    let mut video = videoio::VideoCapture::from_file(out.join("annotated.mp4"), videoio::CAP_ANY).unwrap();
    let (mut image, mut frames, mut sides) = (Mat::default(), 0, (0, 0));
    while video.read(&mut image).unwrap() {
        frames += 1;
        sides = (image.cols(), image.rows());
    }
    assert_eq!((frames, sides), (60, (WIDTH as i32, HEIGHT as i32)));

    // Regions: one row each, integer boxes that contain the centroid, the block among them.
    let regions = read(&out.join("regions.csv"));
    let mut lines = regions.lines();
    assert_eq!(
        lines.next().unwrap(),
        "frame,label,area,x,y,w,h,cx,cy,mu20,mu11,mu02,orientation,eccentricity,extent,r,g,b,object"
    );
    let mut red = 0;
    for line in lines {
        let cells: Vec<_> = line.split(',').collect();
        assert_eq!(cells.len(), 19, "{line}");
        let number = |index: usize| cells[index].parse::<f64>().unwrap();
        assert!(number(2) >= 10.0 && number(14) <= 1.0);
        assert!(number(3) <= number(7) && number(7) <= number(3) + number(5), "{line}");
        red += u32::from(number(15) > 150.0 && number(16) < 60.0);
    }
    assert!(red > 20, "the block is found in {red} frames only:\n{regions}");

    // The settings file equals the settings in the summary.
    let toml = read(&out.join("settings.toml"));
    assert!(toml.contains("\nmin_area = 10\n") && toml.contains("\ntrack_min_area = 0.5\n"));
    assert_eq!(works(&["settings", "--settings", text(&out.join("settings.toml"))]), toml);
}

#[test]
fn tracks_events_and_regions_agree() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 70, 1);
    run(&images, &out, &[]);
    assert_eq!(common::names(&out), TABLES);

    let tracks = json(&out.join("tracks.json"));
    let tracks = tracks.as_array().unwrap();
    let csv = read(&out.join("tracks.csv"));
    assert!(!tracks.is_empty(), "the block is an object");
    assert_eq!(csv.lines().count(), tracks.len());
    for (line, track) in csv.lines().zip(tracks) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let of = |key: &str| track[key].as_f64().unwrap();
        assert_eq!(cells[7..], [-1.0; 3]);
        for (cell, key) in cells.iter().zip(["frame", "id", "x", "y", "w", "h", "conf"]) {
            assert!((cell - of(key)).abs() < 1e-6 * cell.abs().max(1.0), "{line}: {key}");
        }
        assert_eq!(of("conf"), if track["state"] == "visible" { 1.0 } else { 0.5 });
        for key in ["visible_share", "velocity", "fitness", "colours"] {
            assert!(track.get(key).is_some(), "{key}");
        }
    }
    // The block is one object to the end, and its colour is red.
    let last = tracks.last().unwrap();
    assert!(last["frame"].as_u64().unwrap() >= 65, "{last}");
    assert!(last["colours"][0][0].as_u64().unwrap() > 150, "{last}");

    // The objects of a region are those that the tracks assign to its label.
    for line in read(&out.join("regions.csv")).lines().skip(1) {
        let cells: Vec<_> = line.split(',').collect();
        let owners: Vec<_> = tracks
            .iter()
            .filter(|track| track["frame"].as_u64() == cells[0].parse().ok())
            .filter(|track| {
                track["regions"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .any(|label| label.as_u64() == cells[1].parse().ok())
            })
            .map(|track| track["id"].to_string())
            .collect();
        assert_eq!(cells[18], owners.join("+"), "{line}");
    }

    let summary = json(&out.join("summary.json"));
    let mut counts = BTreeMap::new();
    let mut frame = 0;
    for line in read(&out.join("events.jsonl")).lines() {
        let event: Value = serde_json::from_str(line).unwrap();
        for key in ["frame", "time", "kind", "objects", "becomes", "x", "y", "front", "evidence"] {
            assert!(event.get(key).is_some(), "{key} in {line}");
        }
        assert!(event["frame"].as_u64().unwrap() >= frame, "events are in order");
        frame = event["frame"].as_u64().unwrap();
        *counts.entry(event["kind"].as_str().unwrap().to_owned()).or_insert(0) += 1;
    }
    for (kind, count) in summary["events"].as_object().unwrap() {
        assert_eq!(count.as_u64().unwrap(), counts.get(kind).copied().unwrap_or(0), "{kind}");
    }
    let episodes = read(&out.join("episodes.csv"));
    assert_eq!(
        episodes.lines().next().unwrap(),
        "kind,objects,start,end,least_visible,front,identities_kept"
    );
    assert_eq!(summary["episodes"].as_u64().unwrap() as usize, episodes.lines().count() - 1);
}

#[test]
fn results_are_independent_of_threads_and_reruns() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 50, 1);
    let bulky = ["--masks", "--labels", "--frames", "--background", "--annotated"];
    let folder = |name: &str, more: &[&str]| {
        let out = place.path(name);
        run(&images, &out, &[&bulky[..], more].concat());
        contents(&out)
    };
    let one = folder("one", &["--threads", "1"]);
    let three = folder("three", &["--threads", "3"]);
    let again = folder("one", &[]);
    assert_eq!(one.keys().collect::<Vec<_>>(), three.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(three[name] == *bytes, "{name} differs between 1 and 3 threads");
        assert!(again[name] == *bytes, "{name} differs between two runs");
    }
}

/// The content of a file without the times of tracks and events.
fn without_times(bytes: &[u8]) -> Vec<u8> {
    let mut rest = bytes;
    let mut left = Vec::new();
    while let Some(at) = rest.windows(7).position(|window| window == b"\"time\":") {
        left.extend_from_slice(&rest[..at]);
        let end = rest[at..].iter().position(|&byte| byte == b',').unwrap();
        rest = &rest[at + end..];
    }
    [&left[..], rest].concat()
}

#[test]
fn a_range_keeps_the_source_s_numbers_and_starts_the_model_there() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 40, 470);
    let out = place.path("out");
    run(&images, &out, &["--masks", "--range", "490..500"]);
    assert_eq!(common::names(&out.join("masks")), numbered("bin", 490..=500));

    // The same frames on their own give the same files.
    let part = place.path("part");
    fs::create_dir(&part).unwrap();
    for number in 490..=500 {
        let name = format!("in{number:06}.png");
        fs::copy(images.join(&name), part.join(&name)).unwrap();
    }
    let alone = place.path("alone");
    run(&part, &alone, &["--masks"]);
    let (out_files, alone_files) = (contents(&out), contents(&alone));
    for (name, bytes) in &out_files {
        let same = without_times(&alone_files[name]) == without_times(bytes);
        assert!(name == "summary.json" || same, "{name}");
    }
    // Times are those in the whole sequence.
    let first_times = [&out, &alone].map(|out| json(&out.join("tracks.json"))[0]["time"].as_f64().unwrap());
    assert!((first_times[0] - first_times[1] - 20.0 / 25.0).abs() < 1e-9, "{first_times:?}");
    let input = json(&out.join("summary.json"))["input"].clone();
    assert_eq!(
        (&input["frames"], &input["first_frame"], &input["last_frame"]),
        (&11.into(), &490.into(), &500.into())
    );
    assert_eq!(input["sha256"], json(&alone.join("summary.json"))["input"]["sha256"]);

    // An end beyond the last frame is clamped, with a note unless quiet.
    let beyond = place.path("beyond");
    let arguments = ["run", text(&images), "--out", text(&beyond), "--range", "505..600"];
    let output = occluscope(&arguments).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && stderr.contains("warning") && stderr.contains("509"), "{stderr}");
    assert_eq!(json(&beyond.join("summary.json"))["input"]["frames"], 5);
    let output = occluscope(&[&arguments[..], &["--quiet"]].concat()).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
}

#[test]
fn a_rerun_replaces_only_its_own_files() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 12, 1);
    run(&images, &out, &["--masks"]);
    fs::write(out.join("notes.txt"), "mine").unwrap();
    fs::write(out.join("masks/notes.txt"), "mine").unwrap();
    run(&images, &out, &["--masks", "--range", "3..7"]);
    assert_eq!(read(&out.join("notes.txt")), "mine");
    let mut expected = numbered("bin", 3..=7);
    expected.push("notes.txt".to_owned());
    assert_eq!(common::names(&out.join("masks")), expected);

    // A failed run does not change existing results.
    let before = contents(&out);
    fails(&["run", text(&images), "--out", text(&out), "--masks", "--range", "90..99"], 1);
    assert!(contents(&out) == before);
}

#[test]
fn an_unreadable_image_is_skipped_with_its_number_and_a_warning() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 8, 1);
    fs::write(images.join("in000004.png"), "broken").unwrap();
    let output =
        occluscope(&["run", text(&images), "--out", text(&out), "--masks", "--frames"]).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && stderr.contains("in000004.png"), "{stderr}");
    let names = common::names(&out.join("masks"));
    assert_eq!(names.len(), 7);
    assert!(!names.contains(&"bin000004.png".to_owned()));
    assert_eq!(common::names(&out.join("frames")).len(), 7);
}

fn write_video(path: &Path, frames: u32) {
    let fourcc = videoio::VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
    let size = opencv::core::Size::new(WIDTH as i32, HEIGHT as i32);
    let mut video = videoio::VideoWriter::new(path, fourcc, 12.5, size, true).unwrap();
    for t in 1..=frames {
        let mut png = std::io::Cursor::new(Vec::new());
        scene(t).write_to(&mut png, image::ImageFormat::Png).unwrap();
        let png = Vector::<u8>::from_iter(png.into_inner());
        video.write(&imgcodecs::imdecode(&png, imgcodecs::IMREAD_COLOR).unwrap()).unwrap();
    }
    video.release().unwrap();
}

#[test]
fn a_truncated_video_is_analysed_to_its_end() {
    let place = TestFolder::new();
    let (whole, broken) = (place.path("whole.avi"), place.path("broken.avi"));
    write_video(&whole, 30);
    let bytes = fs::read(&whole).unwrap();
    fs::write(&broken, &bytes[..bytes.len() * 6 / 10]).unwrap();

    let out = place.path("out");
    run(&whole, &out, &[]);
    let input = json(&out.join("summary.json"))["input"].clone();
    assert_eq!((&input["frames"], &input["fps"]), (&30.into(), &12.5.into()));
    let sum = std::process::Command::new("sha256sum").arg(&whole).output().unwrap();
    let sum = String::from_utf8(sum.stdout).unwrap();
    assert_eq!(input["sha256"].as_str(), sum.split_whitespace().next());

    let output = occluscope(&["run", text(&broken), "--out", text(&out), "--annotated"]).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && stderr.contains("warning: "), "{stderr}");
    let frames = json(&out.join("summary.json"))["input"]["frames"].as_u64().unwrap();
    assert!((5..30).contains(&frames), "{frames}");
}

#[test]
fn opencv_s_models_go_through_the_same_stages() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 40, 1);
    for model in ["mog2", "knn"] {
        let out = place.path(model);
        run(&images, &out, &["--background-model", model, "--masks", "--background"]);
        assert_eq!(common::names(&out.join("masks")).len(), 40);
        assert_eq!(common::names(&out.join("background")).len(), 40);
        assert_eq!(json(&out.join("summary.json"))["settings"]["background_model"], model);
    }
}

/// The tutorial's claim about the bundled scene: with T = 0.95 a shirt becomes background, and its walker is split
/// into two objects; with T = 0.88 both walkers keep their identities.
#[test]
fn the_tutorials_identity_depends_on_t() {
    let place = TestFolder::new();
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_videos/crossing.mp4");
    let events = |t: &str| -> Vec<(String, u64)> {
        let out = place.path(&format!("t{t}"));
        works(&["run", text(&sample), "--out", text(&out), "--t", t]);
        let events = read(&out.join("events.jsonl"));
        let events = events.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        events
            .map(|event| (event["kind"].as_str().unwrap().to_owned(), event["frame"].as_u64().unwrap()))
            .collect()
    };
    let lost = events("0.95");
    assert_eq!(lost.len(), 9, "{lost:?}");
    let third = |(kind, frame): &(String, u64)| (kind.as_str(), *frame) == ("appear", 152);
    assert_eq!(lost.iter().filter(|event| third(event)).count(), 1, "{lost:?}");
    let kinds: Vec<String> = events("0.88").into_iter().map(|(kind, _)| kind).collect();
    assert_eq!(kinds, ["enter", "enter", "merge", "demerge", "exit", "exit"]);
    // The tutorial's pixel: background under one T, foreground under the other.
    let foreground = |t: &str| {
        let out = place.path(&format!("pixel{t}.csv"));
        works(&["pixel", text(&sample), "--at", "160,137", "--t", t, "--out", text(&out)]);
        let table = read(&out);
        let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let column = names.iter().position(|name| *name == "foreground").unwrap();
        let row = table.lines().find(|line| line.starts_with("124,")).unwrap();
        row.split(',').nth(column).unwrap() == "1"
    };
    assert_eq!((foreground("0.95"), foreground("0.88")), (false, true));
}

/// The share of foreground in a frame at the position of the next test's block.
fn share_at_the_block(out: &Path, number: u32) -> f64 {
    let mask = image::open(out.join("masks").join(format!("bin{number:06}.png"))).unwrap().into_luma8();
    let at = (30..40).flat_map(|x| (25..50).map(move |y| (x, y)));
    at.filter(|&(x, y)| mask.get_pixel(x, y).0 == [255]).count() as f64 / 250.0
}

#[test]
fn an_object_in_the_first_frame_is_foreground_and_leaves_no_ghost() {
    let place = TestFolder::new();
    let images = place.path("images");
    fs::create_dir(&images).unwrap();
    for t in 1..=80 {
        // The block stands for twenty frames and moves away to the right.
        let left = 30 + 4 * 20_u32.max(t) - 80;
        let wall = scene(1);
        let picture = image::RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
            let inside = (left..left + 10).contains(&x) && (25..50).contains(&y);
            let colour = if inside { [200, 30, 30] } else { wall.get_pixel(x, y).0 };
            image::Rgb(colour.map(|level| level + common::noise(x, y, t) / 64))
        });
        picture.save(images.join(format!("in{t:06}.png"))).unwrap();
    }
    let of = |name: &str, bootstrap: &str, more: &[&str]| {
        let out = place.path(name);
        run(&images, &out, &[&["--masks", "--bootstrap", bootstrap], more].concat());
        out
    };
    let without = of("without", "0", &[]);
    assert_eq!(share_at_the_block(&without, 1), 0.0);
    assert!(share_at_the_block(&without, 40) > 0.9, "the block leaves a ghost");
    for (name, bootstrap) in [("frames", "60"), ("seconds", "2.4s"), ("all", "20s")] {
        let out = of(name, bootstrap, &[]);
        for t in [1, 2, 10, 20] {
            let share = share_at_the_block(&out, t);
            assert!(share > 0.95, "{name}, frame {t}: {share}");
        }
        for t in [30, 31, 50, 80] {
            let share = share_at_the_block(&out, t);
            assert!(share < 0.02, "{name}, frame {t}: {share}");
        }
        let tracks = read(&out.join("tracks.csv"));
        assert!(
            tracks.starts_with("1,1,30,25,10,25,1,"),
            "{name}: the track is confirmed after three frames and starts at the first: {tracks}"
        );
    }
    let (frames, seconds) = (contents(&place.path("frames")), contents(&place.path("seconds")));
    for (file, bytes) in &frames {
        let says_how = file == "summary.json" || file == "settings.toml";
        assert!(says_how || seconds[file] == *bytes, "{file}");
    }
    // Neither the number of threads nor images of the model, which need single frames, change the results.
    let one = contents(&of("one", "60", &["--threads", "1", "--background", "--frames"]));
    for (file, bytes) in &frames {
        assert!(file == "summary.json" || one[file] == *bytes, "{file}");
    }
    let [mut summary, mut of_one] =
        [&frames, &one].map(|files| serde_json::from_slice::<Value>(&files["summary.json"]).unwrap());
    let lists = [&mut summary, &mut of_one].map(|it| it.as_object_mut().unwrap().remove("large_files"));
    assert_eq!(
        lists.map(Option::unwrap),
        [serde_json::json!(["masks"]), serde_json::json!(["masks", "frames", "background"])]
    );
    assert_eq!(of_one, summary);
}

#[test]
fn images_at_the_videos_rate_are_analysed_as_the_video() {
    let place = TestFolder::new();
    let (video, out) = (place.path("video.avi"), place.path("out"));
    write_video(&video, 60);
    // The number of frames in which the block is visible at 12.5 frames per second.
    let flags = ["--min-track", "1.8s", "--max-hidden", "1s"];
    run(&video, &out, &[&flags[..], &["--plain-frames"]].concat());
    assert_eq!(json(&out.join("summary.json"))["input"]["fps_from"], "video");
    let images = place.path("sequence/img1");
    fs::create_dir_all(&images).unwrap();
    for name in common::names(&out.join("plain-frames")) {
        fs::copy(out.join("plain-frames").join(&name), images.join(&name)).unwrap();
    }
    let expected = contents(&out);
    assert!(!expected["tracks.csv"].is_empty());
    let analysed = |more: &[&str]| {
        let again = place.path("again");
        let arguments =
            [&["run", text(&images), "--out", text(&again)], &SMALL[..], &flags[..], more].concat();
        let output = occluscope(&arguments).output().unwrap();
        assert!(output.status.success());
        let told = String::from_utf8(output.stderr).unwrap();
        let input = json(&again.join("summary.json"))["input"].clone();
        (
            contents(&again),
            (input["fps"].as_f64().unwrap(), input["fps_from"].as_str().unwrap().to_owned()),
            told,
        )
    };
    let same = |files: &BTreeMap<String, Vec<u8>>| {
        TABLES.iter().filter(|name| **name != "summary.json").all(|name| files[*name] == expected[*name])
    };
    let (files, rate, told) = analysed(&[]);
    assert!(!same(&files) && files["tracks.csv"].is_empty(), "the block is visible for too few seconds");
    assert_eq!(rate, (25.0, "assumed".to_owned()));
    assert!(told.contains("25 frames per second are assumed"), "{told}");
    let (files, rate, told) = analysed(&["--fps", "12.5"]);
    assert!(same(&files) && !told.contains("assumed"), "{told}");
    assert_eq!(rate, (12.5, "--fps".to_owned()));

    let ini = place.path("sequence/seqinfo.ini");
    fs::write(&ini, "\u{feff}[Sequence]\r\nname=block\r\nframeRate = 12.5\r\nseqLength=60\r\n").unwrap();
    let (files, rate, told) = analysed(&[]);
    assert!(same(&files) && !told.contains("assumed"), "{told}");
    assert_eq!(rate, (12.5, "seqinfo.ini".to_owned()));
    // A given rate also overrides that of a video.
    let slow = place.path("slow");
    run(&video, &slow, &["--fps", "5"]);
    let input = json(&slow.join("summary.json"))["input"].clone();
    assert_eq!((&input["fps"], &input["options"]), (&5.0.into(), &serde_json::json!({ "fps": 5.0 })));
    run(&video, &slow, &["--deinterlace", "--stream", "0"]);
    let options = json(&slow.join("summary.json"))["input"]["options"].clone();
    assert_eq!(options, serde_json::json!({ "deinterlace": true, "stream": 0 }));

    for content in ["frameRate=none\n", "[Sequence]\nname=block\n", "frameRate=0\n"] {
        fs::write(&ini, content).unwrap();
        let (_, rate, told) = analysed(&[]);
        assert_eq!(rate, (25.0, "assumed".to_owned()), "{content}");
        assert!(told.contains("warning: ") && told.contains("seqinfo.ini is ignored"), "{content}: {told}");
        assert_eq!(analysed(&["--fps", "12.5"]).1, (12.5, "--fps".to_owned()));
    }
}

#[test]
fn an_invalid_rate_is_refused() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 3, 1);
    for fps in ["0", "-25", "NaN", "inf", "1e9", "0.001", "fast", ""] {
        for command in [
            &["run", text(&images), "--out", text(&place.path("out"))][..],
            &["pixel", text(&images), "--at", "1,1"],
            &["bench", text(&images)],
            &[text(&images)],
        ] {
            let refused = fails(&[command, &["--fps", fps]].concat(), 2);
            assert!(refused.contains("--fps") && refused.contains("0.05–1000"), "{refused}");
        }
    }
    assert!(!place.path("out").exists());
}

#[test]
fn gaps_in_the_numbers_of_images_are_gaps_in_time() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 80, 101);
    for missing in 150..158 {
        fs::remove_file(images.join(format!("in{missing:06}.png"))).unwrap();
    }
    run(&images, &out, &["--fps", "10"]);
    let tracks = json(&out.join("tracks.json"));
    let tracks = tracks.as_array().unwrap();
    for track in tracks {
        let (frame, time) = (track["frame"].as_u64().unwrap(), track["time"].as_f64().unwrap());
        assert_eq!(time, (frame - 101) as f64 / 10.0);
    }
    for number in [149, 158] {
        let ids: Vec<_> =
            tracks.iter().filter(|track| track["frame"] == number).map(|track| &track["id"]).collect();
        assert_eq!(ids, [1], "the block has one identity before and after the gap, frame {number}");
    }
    let events = read(&out.join("events.jsonl"));
    let first: Value = serde_json::from_str(events.lines().next().unwrap()).unwrap();
    let frame = first["frame"].as_f64().unwrap();
    assert!((first["time"].as_f64().unwrap() - (frame - 101.0) / 10.0).abs() < 1e-9);
}

#[test]
fn the_folder_of_a_sequence_is_analysed_as_its_images_and_its_truth_is_named() {
    let place = TestFolder::new();
    let (scene, out) = (place.path("scene"), place.path("out"));
    write_images(&scene.join("img1"), 12, 1);
    run(&scene.join("img1"), &out, &[]);
    let expected = contents(&out);
    let analysed = |more: &[&str]| {
        let arguments = [&["run", text(&scene), "--out", text(&out)], &SMALL[..], more].concat();
        let output = occluscope(&arguments).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let told = analysed(&[]);
    assert!(!told.contains("ground truth"), "{told}");
    for (file, bytes) in contents(&out) {
        assert!(file == "summary.json" || bytes == expected[&file], "{file}");
    }
    let input = json(&out.join("summary.json"))["input"].clone();
    let of_images: Value = serde_json::from_slice(&expected["summary.json"]).unwrap();
    assert_eq!((&input["path"], &input["sha256"]), (&text(&scene).into(), &of_images["input"]["sha256"]));

    fs::create_dir(scene.join("gt")).unwrap();
    fs::write(scene.join("gt/gt.txt"), "1,1,2,2,9,9,1,1,1\n").unwrap();
    let truth = scene.join("gt/gt.txt");
    let told = analysed(&[]);
    assert!(told.contains(&format!("score {} --truth {}", text(&out), text(&truth))), "{told}");
    assert!(!told.contains("--masks"), "{told}");
    works(&["score", text(&out), "--truth", text(&truth)]);
    assert_eq!(analysed(&["--quiet"]), "");
    fs::create_dir(scene.join("groundtruth")).unwrap();
    let told = analysed(&[]);
    assert!(told.contains("need --masks") && told.contains(&format!("--truth {}\n", text(&scene))), "{told}");
    assert!(!analysed(&["--masks"]).contains("need --masks"));
}

#[test]
fn levels_are_kept_in_the_summary_and_invalid_ones_are_refused() {
    let place = TestFolder::new();
    let (images, out) = (place.path("images"), place.path("out"));
    write_images(&images, 5, 1);
    run(&images, &out, &["--levels", "10..200"]);
    assert_eq!(json(&out.join("summary.json"))["input"]["options"]["levels"], "10..200");
    for levels in ["", "5", "9..3", "3..3", "a..b", "0..inf", "automatic"] {
        for command in [&["run", text(&images), "--out", text(&place.path("no"))][..], &[text(&images)]] {
            let refused = fails(&[command, &["--levels", levels]].concat(), 2);
            assert!(refused.contains("--levels") && refused.contains("0..4095"), "{refused}");
        }
    }
    assert!(!place.path("no").exists());
}
