//! `--scale`, `--every` and `--crop`: fewer and smaller frames, and results in the source's pixels.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use common::{TestFolder, fails, occluscope, text, works, write_images};
use serde_json::Value;

/// Boxes of a `tracks.csv` by frame and identity.
type Boxes = BTreeMap<(u32, u32), [f64; 4]>;

fn boxes(folder: &Path) -> Boxes {
    let rows = fs::read_to_string(folder.join("tracks.csv")).unwrap();
    let row = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
        ((numbers[0] as u32, numbers[1] as u32), [numbers[2], numbers[3], numbers[4], numbers[5]])
    };
    rows.lines().map(row).collect()
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn iou(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let side = |i: usize| ((a[i] + a[i + 2]).min(b[i] + b[i + 2]) - a[i].max(b[i])).max(0.0);
    let shared = side(0) * side(1);
    shared / (a[2] * a[3] + b[2] * b[3] - shared)
}

/// Renders the crossing with its truth, and returns the video and the truth.
fn crossing(place: &TestFolder) -> (PathBuf, PathBuf) {
    let scene = place.path("scene");
    works(&["synth", "crossing", "--noise", "4", "--size", "480x360", "--out", text(&scene), "--quiet"]);
    (scene.join("crossing.mp4"), scene)
}

fn run(video: &Path, out: &Path, flags: &[&str]) {
    works(&[&["run", text(video), "--out", text(out), "--masks", "--quiet"], flags].concat());
}

#[test]
fn a_scaled_run_has_the_boxes_and_masks_of_the_source() {
    let place = TestFolder::new();
    let (video, scene) = crossing(&place);
    let (whole, half) = (place.path("whole"), place.path("half"));
    run(&video, &whole, &[]);
    run(&video, &half, &["--scale", "0.5", "--plain-frames"]);

    // The two people, under any identity: each box of one run has its like in the other.
    let (of_whole, of_half) = (boxes(&whole), boxes(&half));
    let near = |frame: u32, bounds: &[f64; 4]| {
        let others = of_half.range((frame, 0)..=(frame, u32::MAX));
        others.map(|(_, other)| iou(bounds, other)).fold(0.0, f64::max)
    };
    let nearness: Vec<f64> = of_whole.iter().map(|((frame, _), bounds)| near(*frame, bounds)).collect();
    let mean = nearness.iter().sum::<f64>() / nearness.len() as f64;
    assert!(nearness.len() > 100 && mean > 0.75, "mean IoU {mean} of {}", nearness.len());

    let mask = image::open(half.join("masks/bin000100.png")).unwrap().into_luma8();
    assert_eq!(mask.dimensions(), (480, 360));
    for (x, y, level) in mask.enumerate_pixels() {
        assert_eq!(level, mask.get_pixel(x / 2 * 2, y / 2 * 2), "{x}, {y}");
    }
    let frame = image::open(half.join("plain-frames/000100.png")).unwrap();
    assert_eq!((frame.width(), frame.height()), (240, 180), "pictures are as analysed");

    let scores = |results: &Path| -> Value {
        serde_json::from_str(&works(&["score", text(results), "--truth", text(&scene), "--json"])).unwrap()
    };
    let (of_whole, of_half) = (scores(&whole), scores(&half));
    for (key, least) in [("/iou0.5/mota", 0.6), ("/masks/f_measure", 0.7)] {
        let value = |scores: &Value| scores.pointer(key).unwrap().as_f64().unwrap();
        assert!(value(&of_half) > least, "{key}: {} of {}", value(&of_half), value(&of_whole));
    }

    let input = &json(&half.join("summary.json"))["input"];
    assert_eq!(input["size"]["width"], 480);
    assert_eq!(input["analysed_size"]["width"], 240);
    assert_eq!(input["options"]["scale"], 0.5);
    let input = &json(&whole.join("summary.json"))["input"];
    assert!(input.get("analysed_size").is_none() && input.get("options").is_none());

    // Regions: area, box and centre are in the source's pixels, and agree.
    let mut rows = csv::Reader::from_path(half.join("regions.csv")).unwrap();
    let headers = rows.headers().unwrap().clone();
    let mut count = 0;
    for row in rows.records().map(Result::unwrap) {
        let value = |name: &str| -> f64 {
            row[headers.iter().position(|header| header == name).unwrap()].parse().unwrap()
        };
        let [x, y, w, h] = ["x", "y", "w", "h"].map(value);
        assert!(x % 2.0 == 0.0 && h % 2.0 == 0.0 && value("area") % 4.0 == 0.0, "{row:?}");
        assert!((value("area") / (w * h) - value("extent")).abs() < 1e-6, "{row:?}");
        assert!((x..x + w).contains(&value("cx")) && (y..y + h).contains(&value("cy")), "{row:?}");
        count += 1;
    }
    assert!(count > 50, "{count}");
}

#[test]
fn every_second_frame_keeps_its_number_and_is_scored_alone() {
    let place = TestFolder::new();
    let (video, scene) = crossing(&place);
    let out = place.path("out");
    run(&video, &out, &["--every", "2"]);
    let frames: Vec<u32> = boxes(&out).keys().map(|(frame, _)| *frame).collect();
    assert!(frames.len() > 100 && frames.iter().all(|frame| frame % 2 == 1), "{frames:?}");
    let masks = common::names(&out.join("masks"));
    assert_eq!(masks[..3], ["bin000001.png", "bin000003.png", "bin000005.png"]);
    let input = &json(&out.join("summary.json"))["input"];
    assert_eq!((input["fps"].as_f64(), &input["options"]["every"]), (Some(25.0), &2.into()));
    assert_eq!(input["frames"], masks.len());
    let scores: Value =
        serde_json::from_str(&works(&["score", text(&out), "--truth", text(&scene), "--json"])).unwrap();
    let recall = scores["iou0.5"]["recall"].as_f64().unwrap();
    assert!(recall > 0.7, "frames that were left out are not missed: {recall}");

    // Frames are counted from the source's first one, whatever the range.
    let part = place.path("part");
    run(&video, &part, &["--every", "10", "--range", "95..125"]);
    let names = common::names(&part.join("masks"));
    assert_eq!(names, ["bin000101.png", "bin000111.png", "bin000121.png"]);
    assert_eq!(json(&part.join("summary.json"))["warnings"], Value::Array(Vec::new()));
}

#[test]
fn a_crop_moves_results_by_whole_pixels() {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 60, 1);
    // The same part as images of its own.
    let part = place.path("part");
    fs::create_dir(&part).unwrap();
    for name in common::names(&video) {
        let image = image::open(video.join(&name)).unwrap();
        image.crop_imm(8, 16, 80, 48).save(part.join(&name)).unwrap();
    }
    let (of_part, cropped) = (place.path("of-part"), place.path("cropped"));
    run(&part, &of_part, &[]);
    run(&video, &cropped, &["--crop", "8,16,80,48"]);
    let (of_part_boxes, moved) = (boxes(&of_part), boxes(&cropped));
    assert!(!moved.is_empty());
    let expected: Boxes =
        of_part_boxes.iter().map(|(key, [x, y, w, h])| (*key, [x + 8.0, y + 16.0, *w, *h])).collect();
    assert_eq!(moved.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (key, bounds) in &moved {
        for (a, b) in bounds.iter().zip(expected[key]) {
            assert!((a - b).abs() < 1e-4, "{key:?}: {bounds:?}, not {:?}", expected[key]);
        }
    }
    let mask = |folder: &Path| image::open(folder.join("masks/bin000050.png")).unwrap().into_luma8();
    let (inner, outer) = (mask(&of_part), mask(&cropped));
    assert_eq!(outer.dimensions(), (96, 72));
    assert!(inner.pixels().any(|level| level.0[0] == 255));
    for (x, y, level) in outer.enumerate_pixels() {
        let within = (8..88).contains(&x) && (16..64).contains(&y);
        let expected = if within { inner.get_pixel(x - 8, y - 16).0[0] } else { 0 };
        assert_eq!(level.0[0], expected, "{x}, {y}");
    }
    let events = |folder: &Path| fs::read_to_string(folder.join("events.jsonl")).unwrap();
    let first =
        |folder: &Path| -> Value { serde_json::from_str(events(folder).lines().next().unwrap()).unwrap() };
    let (a, b) = (first(&of_part), first(&cropped));
    for (axis, by) in [("x", 8.0), ("y", 16.0)] {
        assert!((a[axis].as_f64().unwrap() + by - b[axis].as_f64().unwrap()).abs() < 1e-4, "{a} {b}");
    }

    // A pixel of the source is that pixel, whatever the crop.
    let pixel = |flags: &[&str]| works(&[&["pixel", text(&video), "--at", "20,30"], flags].concat());
    assert_eq!(pixel(&["--crop", "8,16,80,48"]), pixel(&[]));
    let error = fails(&["pixel", text(&video), "--at", "7,30", "--crop", "8,16,80,48"], 1);
    assert!(error.contains("pixel 7,30 is outside the crop") && error.contains("8–87"), "{error}");
    let error = fails(&["pixel", text(&video), "--at", "96,30", "--crop", "8,16,80,48"], 1);
    assert!(error.contains("is 96×72"), "{error}");
    // A block of 2×2 pixels, whichever of them is given.
    let half = |at: &str| works(&["pixel", text(&video), "--at", at, "--scale", "0.5", "--every", "3"]);
    assert_eq!(half("20,30"), half("21,31"));
    assert_ne!(half("20,30"), half("22,30"));
    let rows = half("20,30");
    assert!(rows.lines().nth(2).unwrap().starts_with("4,") && rows.lines().count() == 21, "{rows}");
}

/// The scores as JSON, and what is told of them.
fn scores(results: &Path, truth: &Path) -> (Value, String) {
    let output = occluscope(&["score", text(results), "--truth", text(truth), "--json"]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{told}");
    let mut scores: Value = serde_json::from_slice(&output.stdout).unwrap();
    scores.as_object_mut().unwrap().remove("truth_path");
    scores.as_object_mut().unwrap().remove("summary_sha256");
    (scores, told)
}

fn assert_agree(a: &Value, b: &Value) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            assert!(a.keys().eq(b.keys()), "{a:?} {b:?}");
            a.values().zip(b.values()).for_each(|(a, b)| assert_agree(a, b));
        }
        (Value::Number(a), Value::Number(b)) => {
            assert!((a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-6, "{a} {b}");
        }
        _ => assert_eq!(a, b),
    }
}

#[test]
fn a_crop_is_scored_as_the_same_part_in_a_video_of_its_own() {
    let place = TestFolder::new();
    let [video, part, masks, part_masks] =
        ["images", "part", "masks", "part-masks"].map(|name| place.path(name));
    write_images(&video, 60, 1);
    for folder in [&part, &masks, &part_masks] {
        fs::create_dir(folder).unwrap();
    }
    // The block, and an object and moving pixels above the crop 8,16,80,48, in which the block is cut at the left.
    let (mut boxes, mut part_boxes) = (Vec::new(), Vec::new());
    for t in 1..=60 {
        let name = format!("in{t:06}.png");
        image::open(video.join(&name)).unwrap().crop_imm(8, 16, 80, 48).save(part.join(&name)).unwrap();
        let (left, right) = ((i64::from(t) * 2 - 50).max(0), i64::from(t) * 2 - 40);
        boxes.push(format!("{t},2,30,2,9,9,1\n"));
        if right > 0 {
            boxes.push(format!("{t},1,{left},25,{},25,1\n", right - left));
        }
        let (cut, width) = (left.max(8), right - left.max(8));
        if width > 0 {
            // Less than half of a box is ignored.
            let conf = i32::from(2 * width >= right - left);
            part_boxes.push(format!("{t},1,{},9,{width},25,{conf}\n", cut - 8));
        }
        let level = |x: u32, y: u32| {
            let is_block = (left..right).contains(&i64::from(x)) && (25..50).contains(&y);
            image::Luma([if is_block || y < 12 { 255 } else { 0 }])
        };
        let mask = image::GrayImage::from_fn(96, 72, level);
        mask.save(masks.join(&name)).unwrap();
        image::imageops::crop_imm(&mask, 8, 16, 80, 48).to_image().save(part_masks.join(&name)).unwrap();
    }
    let [truth, part_truth] = ["gt.txt", "part.txt"].map(|name| place.path(name));
    fs::write(&truth, boxes.concat()).unwrap();
    fs::write(&part_truth, part_boxes.concat()).unwrap();
    let (of_part, cropped) = (place.path("of-part"), place.path("cropped"));
    run(&part, &of_part, &[]);
    run(&video, &cropped, &["--crop", "8,16,80,48"]);

    let (tracks, told) = scores(&cropped, &truth);
    assert!(tracks["mota"].as_f64().unwrap() > 0.5, "{tracks}");
    assert_agree(&tracks, &scores(&of_part, &part_truth).0);
    assert!(told.contains("boxes outside the crop 8,16,80,48 are left out"), "{told}");
    let (masks, told) = scores(&cropped, &masks);
    assert_agree(&masks, &scores(&of_part, &part_masks).0);
    assert!(told.contains("pixels outside the crop 8,16,80,48 do not count"), "{told}");

    // Without the crop in its summary, the same files miss what they do not show.
    let mut summary = json(&cropped.join("summary.json"));
    summary["input"]["options"] = serde_json::json!({});
    fs::write(cropped.join("summary.json"), summary.to_string()).unwrap();
    assert!(scores(&cropped, &truth).0["mota"].as_f64().unwrap() < 0.5);

    // Events are those of whole images.
    let (video, scene) = crossing(&place);
    let out = place.path("out");
    run(&video, &out, &["--crop", "100,0,380,360"]);
    let (score, told) = scores(&out, &scene);
    assert!(score.get("events").is_none() && score.get("episode_recall").is_none(), "{score}");
    assert!(told.contains("all events and episodes, are left out"), "{told}");
}

#[test]
fn the_analysed_frames_are_known_where_the_numbers_of_images_have_gaps() {
    let place = TestFolder::new();
    let (video, out) = (place.path("images"), place.path("out"));
    write_images(&video, 60, 1);
    fs::remove_file(video.join("in000031.png")).unwrap();
    run(&video, &out, &["--every", "2"]);
    assert_eq!(
        json(&out.join("summary.json"))["input"]["analysed"],
        serde_json::json!([[1, 29, 2], [32, 60, 2]])
    );
    // The tracks themselves as ground truth, and their objects in the other frames as well.
    let rows = fs::read_to_string(out.join("tracks.csv")).unwrap();
    let next = |row: &str| {
        let (frame, rest) = row.split_once(',').unwrap();
        format!("{},{rest}\n", frame.parse::<u32>().unwrap() + 1)
    };
    let truth = place.path("gt.txt");
    let later: Vec<String> = rows.lines().map(next).collect();
    fs::write(&truth, rows.clone() + &later.concat()).unwrap();
    assert!(rows.lines().count() > 10, "{rows}");
    let (score, told) = scores(&out, &truth);
    assert_eq!((&score["mota"], &score["iou0.5"]["recall"]), (&1.0.into(), &1.0.into()), "{score}");
    assert!(told.contains("30 frames are judged, 1 to 60"), "{told}");
}

#[test]
fn a_mask_of_the_source_or_of_the_frames_limits_the_analysis() {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 40, 1);
    let roi = |name: &str, (width, height): (u32, u32), first: u32| {
        let path = place.path(name);
        let level = |x: u32| image::Luma([if x >= first { 255 } else { 0 }]);
        image::GrayImage::from_fn(width, height, |x, _| level(x)).save(&path).unwrap();
        path
    };
    let whole = roi("whole.png", (96, 72), 48);
    let half = roi("half.png", (48, 36), 24);
    let tables = [&whole, &half].map(|roi| {
        let out = place.path("out");
        run(&video, &out, &["--scale", "0.5", "--roi", text(roi)]);
        let mask = image::open(out.join("masks/bin000040.png")).unwrap().into_luma8();
        assert!(mask.enumerate_pixels().all(|(x, _, level)| x >= 48 || level.0[0] == 0));
        assert_eq!(json(&out.join("summary.json"))["analysed_share"], 0.5);
        fs::read_to_string(out.join("regions.csv")).unwrap()
    });
    assert_eq!(tables[0], tables[1]);
    let out = place.path("refused");
    let run = |roi: &Path, flags: &[&str]| {
        fails(&[&["run", text(&video), "--out", text(&out), "--roi", text(roi)], flags].concat(), 1)
    };
    let wrong = roi("wrong.png", (50, 36), 24);
    assert!(run(&wrong, &["--scale", "0.5"]).contains("50×36"));
    assert!(run(&whole, &["--crop", "0,0,40,72"]).contains("within the crop"));
}

#[test]
fn bad_values_are_refused_in_one_line() {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 3, 1);
    let out = place.path("out");
    for (flag, value) in [
        ("--scale", "0"),
        ("--scale", "2"),
        ("--scale", "-0.5"),
        ("--scale", "half"),
        ("--every", "0"),
        ("--every", "1.5"),
        ("--every", "-2"),
        ("--crop", "1,2,3"),
        ("--crop", "1,2,0,5"),
        ("--crop", "-1,2,3,4"),
    ] {
        let error = fails(&["run", text(&video), "--out", text(&out), flag, value], 2);
        assert!(error.contains(&format!("{flag} cannot be `{value}`")), "{error}");
    }
    for crop in ["90,0,7,5", "96,0,1,1", "0,70,5,5"] {
        let error = fails(&["run", text(&video), "--out", text(&out), "--crop", crop], 1);
        assert!(error.contains(crop) && error.contains("96×72") && error.contains("images"), "{error}");
    }
    assert!(!out.exists());
}
