//! Region of interest: pixels outside are never foreground, and a run records the region.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use common::{HEIGHT, TestFolder, WIDTH, fails, occluscope, scene, text, works, write_images};
use image::{GrayImage, Luma};
use occluscope::frame::{Frame, Mask, Size};
use occluscope::pipeline::{Pipeline, PipelineError};
use occluscope::regions::Roi;
use occluscope::settings::Settings;

const SIZE: Size = Size::new(WIDTH, HEIGHT);

/// The block moves through rows 25 to 49. Ignored are the right half and a window in the left half.
fn is_inside(x: u32, y: u32) -> bool {
    x < WIDTH / 2 && !((20..24).contains(&x) && (30..44).contains(&y))
}

fn roi() -> Roi {
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| is_inside(x, y)));
    Roi::new(Mask { size: SIZE, data: pixels.map(|inside| if inside { 255 } else { 0 }).collect() }).unwrap()
}

fn write_mask(path: &Path) -> PathBuf {
    GrayImage::from_fn(WIDTH, HEIGHT, |x, y| Luma([if is_inside(x, y) { 200 } else { 90 }]))
        .save(path)
        .unwrap();
    path.to_owned()
}

fn frames() -> impl Iterator<Item = Frame> {
    (1..=70).map(|t| Frame::new(t, SIZE, scene(t).into_raw()))
}

#[test]
fn pixels_outside_are_never_foreground_and_have_no_events() {
    let settings = Settings {
        median: 5,
        closing: 9,
        fill_holes: 500,
        min_area: 5,
        track_min_area: 0.2,
        alpha: 0.01,
        warm_up: 0,
        ..Settings::default()
    };
    let mut whole = Pipeline::new(&settings, SIZE, 25.0).unwrap();
    let mut part = Pipeline::new(&settings, SIZE, 25.0).unwrap();
    let roi = Arc::new(roi());
    part.set_roi(Some(Arc::clone(&roi))).unwrap();
    let (mut outside, mut inside, mut events) = (0, 0, 0);
    for frame in frames() {
        let (a, b) = (whole.step(&frame).unwrap(), part.step(&frame).unwrap());
        for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
            outside += u32::from(!roi.contains(x, y) && a.mask.is_foreground(x, y));
            inside += u32::from(b.mask.is_foreground(x, y));
            assert!(roi.contains(x, y) || !b.mask.is_foreground(x, y), "{x}, {y} of frame {}", frame.number);
        }
        for event in b.events.iter() {
            events += 1;
            assert!(event.x < (WIDTH / 2) as f32 + 6.0, "{event:?}");
        }
        for region in b.regions.iter() {
            assert!(region.shape.bbox.right() <= (WIDTH / 2) as f32, "{:?}", region.shape);
        }
        // The model still learns every pixel.
        assert_eq!(whole.background_image().unwrap(), part.background_image().unwrap());
    }
    assert!(outside > 1000 && inside > 1000 && events > 0, "{outside} {inside} {events}");
}

#[test]
fn a_mask_of_another_size_is_refused_before_any_frame() {
    let mut pipeline = Pipeline::new(&Settings::default(), Size::new(5, 5), 25.0).unwrap();
    assert!(matches!(pipeline.set_roi(Some(Arc::new(roi()))), Err(PipelineError::Roi(_))));
}

#[test]
fn a_run_writes_its_mask_for_repetition() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 60, 1);
    let mask = write_mask(&place.path("mask.png"));
    let run = |roi: &Path, out: &str| {
        let out = place.path(out);
        works(&[
            "run",
            text(&images),
            "--out",
            text(&out),
            "--roi",
            text(roi),
            "--masks",
            "--track-min-area",
            "0.5",
        ]);
        out
    };
    let first = run(&mask, "first");
    let copy = image::open(first.join("roi.png")).unwrap().into_luma8();
    assert!(copy.enumerate_pixels().all(|(x, y, level)| level.0 == [if is_inside(x, y) { 255 } else { 0 }]));
    let settings = fs::read_to_string(first.join("settings.toml")).unwrap();
    assert!(settings.lines().last().unwrap().contains("--roi roi.png"), "{settings}");
    works(&["settings", "--settings", text(&first.join("settings.toml"))]);
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(first.join("summary.json")).unwrap()).unwrap();
    let share = summary["analysed_share"].as_f64().unwrap();
    assert!((share - f64::from(roi().share())).abs() < 1e-6, "{share}");
    assert!(summary["foreground_share"].as_f64().unwrap() > 0.001);

    let again = run(&first.join("roi.png"), "again");
    for name in
        ["tracks.csv", "regions.csv", "events.jsonl", "episodes.csv", "roi.png", "masks/bin000045.png"]
    {
        assert_eq!(fs::read(first.join(name)).unwrap(), fs::read(again.join(name)).unwrap(), "{name}");
    }
    let found = image::open(first.join("masks/bin000045.png")).unwrap().into_luma8();
    assert!(found.enumerate_pixels().all(|(x, y, level)| is_inside(x, y) || level.0 == [0]));

    // A run of the whole image keeps the mask of an earlier run, with a note.
    let output = occluscope(&["run", text(&images), "--out", text(&first)]).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("roi.png is not from this run"), "{stderr}");
    let settings = fs::read_to_string(first.join("settings.toml")).unwrap();
    assert!(!settings.contains("roi.png"));
}

#[test]
fn an_unusable_mask_is_reported_and_leaves_no_output() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 3, 1);
    let (small, dark, text_file) = (place.path("small.png"), place.path("dark.png"), place.path("notes.png"));
    GrayImage::from_pixel(10, 20, Luma([255])).save(&small).unwrap();
    GrayImage::from_pixel(WIDTH, HEIGHT, Luma([127])).save(&dark).unwrap();
    fs::write(&text_file, "this is no picture").unwrap();
    let missing = place.path("nowhere.png");
    let before = place.names(".");
    for (mask, parts) in [
        (&small, ["10×20", "96×72", "as large as the frames"]),
        (&dark, ["dark.png", "dark everywhere", "white"]),
        (&text_file, ["notes.png", "cannot be read", "as large as the frames"]),
        (&missing, ["nowhere.png", "cannot be read", "as large as the frames"]),
    ] {
        let out = place.path("new/out");
        let run = fails(&["run", text(&images), "--out", text(&out), "--roi", text(mask)], 1);
        let pixel = fails(&["pixel", text(&images), "--at", "1,1", "--roi", text(mask)], 1);
        for part in parts {
            assert!(run.contains(part) && pixel.contains(part), "{part}: {run} {pixel}");
        }
        assert_eq!(place.names("."), before);
    }
}

#[test]
fn the_table_of_a_pixel_ignores_the_region_with_a_note() {
    let place = TestFolder::new();
    let images = place.path("images");
    write_images(&images, 40, 1);
    let mask = write_mask(&place.path("mask.png"));
    for (at, ignored) in [("60,30", true), ("21,35", true), ("30,30", false)] {
        let plain = works(&["pixel", text(&images), "--at", at]);
        let output =
            occluscope(&["pixel", text(&images), "--at", at, "--roi", text(&mask)]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), plain);
        let note = String::from_utf8(output.stderr).unwrap();
        assert_eq!(note.contains("outside the analysed area"), ignored, "{at}: {note}");
    }
}
