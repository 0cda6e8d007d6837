//! Results for other tools: label images, the formats of `export`, and the arrays of `model`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use common::{TestFolder, fails, occluscope, text, works};
use image::{ImageBuffer, Luma};
use roxmltree::Document;
use serde_json::{Value, json};

/// The bundled scene: two people, one of whom passes in front of the other.
fn sample() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_videos/crossing.mp4")
}

fn run(out: &Path, more: &[&str]) {
    works(&[&["run", text(&sample()), "--out", text(out), "--quiet"], more].concat());
}

/// The rows of a table by the names of their columns.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

type LabelImage = ImageBuffer<Luma<u16>, Vec<u16>>;

fn labels(out: &Path, number: u32) -> LabelImage {
    let image = image::open(out.join("labels").join(format!("{number:06}.png"))).unwrap();
    assert_eq!(image.color(), image::ColorType::L16);
    image.into_luma16()
}

/// Number of pixels of each identity.
fn areas(image: &LabelImage) -> BTreeMap<u16, usize> {
    let mut areas = BTreeMap::new();
    for pixel in image.pixels().filter(|pixel| pixel.0 != [0]) {
        *areas.entry(pixel.0[0]).or_default() += 1;
    }
    areas
}

#[test]
fn label_images_have_the_identities_of_the_tables() {
    let place = TestFolder::new();
    let out = place.path("out");
    run(&out, &["--labels", "--masks"]);
    let names = common::names(&out.join("labels"));
    let of_masks = common::names(&out.join("masks"));
    assert!(names.iter().eq(of_masks.iter().map(|name| name.strip_prefix("bin").unwrap())));

    // The episode with a person in front, and the regions of each frame with their objects.
    let episodes = rows(&out.join("episodes.csv"));
    let episode = episodes.iter().find(|row| !row["front"].is_empty()).unwrap();
    let front: u16 = episode["front"].parse().unwrap();
    let merged = episode["start"].parse::<u32>().unwrap()..=episode["end"].parse().unwrap();
    let mut regions: BTreeMap<u32, Vec<(BTreeSet<u16>, usize)>> = BTreeMap::new();
    for row in rows(&out.join("regions.csv")) {
        let objects = row["object"].split('+').filter_map(|id| id.parse().ok()).collect();
        let frame = regions.entry(row["frame"].parse().unwrap()).or_default();
        frame.push((objects, row["area"].parse().unwrap()));
    }
    let (mut alone, mut in_front) = (0, 0);
    for (number, name) in (1..).zip(&of_masks) {
        let image = labels(&out, number);
        let mask = image::open(out.join("masks").join(name)).unwrap().into_luma8();
        assert_eq!(image.dimensions(), mask.dimensions());
        assert!(image.pixels().zip(mask.pixels()).all(|(label, mask)| label.0 == [0] || mask.0 == [255]));
        let areas = areas(&image);
        let regions = regions.remove(&number).unwrap_or_default();
        let of_all: usize = regions.iter().filter(|(ids, _)| !ids.is_empty()).map(|(_, area)| area).sum();
        assert_eq!(areas.values().sum::<usize>(), of_all, "frame {number}");
        for id in areas.keys() {
            assert!(regions.iter().any(|(objects, _)| objects.contains(id)), "frame {number}: {id}");
        }
        let shared = regions.iter().any(|(objects, _)| objects.len() > 1);
        if !shared {
            for (&id, &area) in &areas {
                let own = regions.iter().filter(|(objects, _)| objects.contains(&id)).map(|(_, area)| area);
                assert_eq!(area, own.sum::<usize>(), "frame {number}: {id}");
                alone += 1;
            }
        } else if merged.contains(&number) && regions.len() == 1 {
            assert_eq!(areas.keys().collect::<Vec<_>>(), [&front], "frame {number}");
            in_front += 1;
        }
    }
    assert!(alone > 100 && in_front > 3, "{alone}, {in_front}");

    // A second run without them says that they are not its own; the tables do not depend on them.
    let tables = ["tracks.csv", "tracks.json", "events.jsonl"].map(|name| fs::read(out.join(name)).unwrap());
    let output = occluscope(&["run", text(&sample()), "--out", text(&out)]).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.lines().any(|line| line.contains("labels is not from this run")), "{told}");
    let again = ["tracks.csv", "tracks.json", "events.jsonl"].map(|name| fs::read(out.join(name)).unwrap());
    assert!(tables == again);
}

#[test]
fn label_images_of_smaller_frames_have_the_size_of_the_source() {
    let place = TestFolder::new();
    let out = place.path("out");
    run(&out, &["--labels", "--masks", "--crop", "20,10,280,220", "--scale", "0.5", "--every", "4"]);
    let names = common::names(&out.join("labels"));
    assert_eq!(names[..2], ["000001.png", "000005.png"]);
    let mut labelled = 0;
    for name in names {
        let image = labels(&out, name[..6].parse().unwrap());
        let mask = image::open(out.join(format!("masks/bin{name}"))).unwrap().into_luma8();
        assert_eq!((image.dimensions(), mask.dimensions()), ((320, 240), (320, 240)));
        for ((x, y, label), mask) in image.enumerate_pixels().zip(mask.pixels()) {
            assert!(label.0 == [0] || mask.0 == [255], "{name}: {x}, {y}");
            assert_eq!(label, image.get_pixel(x / 2 * 2, y / 2 * 2), "{name}: {x}, {y}");
            labelled += usize::from(label.0 != [0]);
        }
    }
    assert!(labelled > 1000, "{labelled}");
}

/// Writes what `export` reads of a results folder: four frames with the given numbers, and one object in the first.
fn write_results(folder: &Path, [first, last]: [u32; 2], options: &Value) {
    fs::create_dir_all(folder).unwrap();
    let size = json!({ "width": 64, "height": 48 });
    let input = json!({
        "path": "street.mp4", "size": size, "fps": 25.0, "frames": 4,
        "first_frame": first, "last_frame": last, "options": options,
    });
    fs::write(folder.join("summary.json"), json!({ "input": input }).to_string()).unwrap();
    write_tracks(folder, &json!([track(first)]));
}

fn write_tracks(folder: &Path, tracks: &Value) {
    fs::write(folder.join("tracks.json"), tracks.to_string()).unwrap();
}

fn track(frame: u32) -> Value {
    json!({
        "frame": frame, "id": 1, "state": "visible", "x": 1.0, "y": 2.0, "w": 8.0, "h": 16.0, "visible_share": 1.0,
    })
}

fn read_json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// The rows of `tracks.csv`.
fn tracks(out: &Path) -> Vec<Vec<f64>> {
    let rows = fs::read_to_string(out.join("tracks.csv")).unwrap();
    rows.lines().map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn every_format_has_all_boxes_of_a_run() {
    let place = TestFolder::new();
    let out = place.path("out");
    run(&out, &[]);
    let tracks = tracks(&out);
    assert!(tracks.len() > 200 && tracks.iter().any(|row| row[6] == 0.5));
    for format in ["coco", "cvat", "mot"] {
        works(&["export", text(&out), "--format", format]);
    }

    let coco = read_json(&out.join("coco.json"));
    assert_eq!(coco["images"].as_array().unwrap().len(), 226);
    let annotations = coco["annotations"].as_array().unwrap();
    assert_eq!(annotations.len(), tracks.len());
    for (annotation, row) in annotations.iter().zip(&tracks) {
        let image = &coco["images"][row[0] as usize - 1];
        assert_eq!((&annotation["image_id"], image["frame_id"].as_f64()), (&image["id"], Some(row[0] - 1.0)));
        assert_eq!(annotation["track_id"].as_f64(), Some(row[1]));
        let sides = annotation["bbox"].as_array().unwrap().iter().map(|side| side.as_f64().unwrap());
        assert!(sides.zip(&row[2..6]).all(|(side, cell)| (side - cell).abs() < 1e-4), "{annotation}");
        assert_eq!(annotation["attributes"]["occluded"], row[6] == 0.5);
    }

    let xml = fs::read_to_string(out.join("cvat.xml")).unwrap();
    let xml = Document::parse(&xml).unwrap();
    let mut boxes = Vec::new();
    for track in xml.descendants().filter(|node| node.has_tag_name("track")) {
        for shape in track.children().filter(|node| node.attribute("outside") == Some("0")) {
            let number = |name: &str| shape.attribute(name).unwrap().parse::<f64>().unwrap();
            let id: f64 = track.attribute("id").unwrap().parse().unwrap();
            boxes.push((number("frame") as u32, id, number("xtl"), number("ybr"), number("occluded")));
        }
    }
    boxes.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap());
    assert_eq!(boxes.len(), tracks.len());
    for ((frame, id, left, bottom, occluded), row) in boxes.into_iter().zip(&tracks) {
        assert_eq!((f64::from(frame) + 1.0, id, occluded == 1.0), (row[0], row[1], row[6] == 0.5));
        assert!((left - row[2]).abs() < 1e-4 && (bottom - row[3] - row[5]).abs() < 1e-4, "{row:?}");
    }

    // The rows are stored in the ZIP file as they are.
    let zip = fs::read(out.join("mot.zip")).unwrap();
    let zip = String::from_utf8_lossy(&zip);
    let start = zip.find("gt/gt.txt").unwrap() + "gt/gt.txt".len();
    let rows: Vec<_> = zip[start..].lines().take(tracks.len()).collect();
    for (line, row) in rows.iter().zip(&tracks) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!((cells.len(), &cells[..6], &cells[6..8]), (9, &row[..6], &[1.0, 1.0][..]), "{line}");
    }
}

#[test]
fn frames_of_an_export_are_those_that_were_analysed() {
    let place = TestFolder::new();
    let (folder, file) = (place.path("results"), place.path("street.json"));
    let numbers = |more: &[&str]| -> Vec<[u64; 2]> {
        works(&[&["export", text(&folder), "--format", "coco", "--out", text(&file)], more].concat());
        let images = read_json(&file)["images"].as_array().unwrap().clone();
        images.iter().map(|image| ["id", "frame_id"].map(|key| image[key].as_u64().unwrap())).collect()
    };
    write_results(&folder, [470, 473], &json!({}));
    assert_eq!(numbers(&["--first", "470"]), [[470, 0], [471, 1], [472, 2], [473, 3]]);
    write_results(&folder, [1, 11], &json!({ "every": 3 }));
    assert_eq!(numbers(&[]), [[1, 0], [4, 3], [7, 6], [10, 9]], "the last frame may be left out");
    assert_eq!(common::names(&folder), ["summary.json", "tracks.json"]);

    // Which numbers are missing is not known.
    write_results(&folder, [1, 9], &json!({}));
    write_tracks(&folder, &json!([track(1), track(4)]));
    let output = occluscope(&["export", text(&folder), "--format", "coco"]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && told.starts_with("note: ") && told.contains("gaps"), "{told}");
    assert_eq!(numbers(&["--quiet"]), [[1, 0], [4, 3], [9, 8]]);
    // A newer summary has them.
    let mut summary = read_json(&folder.join("summary.json"));
    summary["input"]["analysed"] = json!([[1, 4, 3], [8, 9]]);
    fs::write(folder.join("summary.json"), summary.to_string()).unwrap();
    assert_eq!(numbers(&[]), [[1, 0], [4, 3], [8, 7], [9, 8]]);
}

#[test]
fn what_is_no_results_folder_is_refused_in_one_line() {
    let place = TestFolder::new();
    let folder = place.path("results");
    let refused = |more: &[&str]| {
        let line = fails(&[&["export", text(&folder), "--format", "cvat"], more].concat(), 1);
        assert!(!folder.join("cvat.xml").exists());
        line
    };
    assert!(refused(&[]).contains("not a results folder"));
    fs::create_dir(&folder).unwrap();
    assert!(refused(&[]).contains("summary.json"));
    write_results(&folder, [470, 473], &json!({}));
    let line = refused(&["--first", "471"]);
    assert!(line.contains("frame 470") && line.contains("--first 471"), "{line}");
    write_results(&folder, [3, 0], &json!({}));
    let line = refused(&[]);
    assert!(line.contains("summary.json") && line.contains("before the first, 3"), "{line}");
    write_results(&folder, [470, 473], &json!({}));
    write_tracks(&folder, &json!([track(470), track(474)]));
    let line = refused(&[]);
    assert!(line.contains("frame 474") && line.contains("same run"), "{line}");
    write_tracks(&folder, &json!([track(470), track(470)]));
    let line = refused(&[]);
    assert!(line.contains("tracks.json: object 1 has two boxes in frame 470"), "{line}");
    for broken in [json!({}), json!([{ "frame": 470 }])] {
        write_tracks(&folder, &broken);
        let line = refused(&[]);
        assert!(line.contains("tracks.json") && line.contains("cannot be read"), "{line}");
    }
    let mut object = track(471);
    object["w"] = json!(-1.0);
    write_tracks(&folder, &json!([object]));
    let line = refused(&[]);
    assert!(line.contains("frame 471") && line.contains("invalid"), "{line}");
    for arguments in [&["--format", "yolo"][..], &["--format", "coco", "--first", "-1"], &[]] {
        let output = occluscope(&[&["export", text(&folder)], arguments].concat()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}

/// The shape and the values of an array in an `.npz` file of stored files.
fn array(npz: &[u8], name: &str) -> (String, Vec<f32>) {
    let at = npz.windows(name.len()).position(|window| window == name.as_bytes()).unwrap() + name.len();
    let length = usize::from(npz[at + 8]) + 256 * usize::from(npz[at + 9]);
    let header = std::str::from_utf8(&npz[at + 10..at + 10 + length]).unwrap();
    let shape = header.split_once("'shape': (").unwrap().1.split_once(", )").unwrap().0;
    let sides = shape.split(", ").map(|side| side.parse::<usize>().unwrap());
    let values = npz[at + 10 + length..].chunks(4).take(sides.product());
    (shape.to_owned(), values.map(|value| f32::from_le_bytes(value.try_into().unwrap())).collect())
}

#[test]
fn the_arrays_of_the_model_are_the_model_of_the_run() {
    let place = TestFolder::new();
    let (video, out, file) = (sample(), place.path("out"), place.path("model.npz"));
    run(&out, &["--background", "--range", "20..60"]);
    let model = |more: &[&str]| {
        let arguments = ["model", text(&video), "--out", text(&file), "--range", "20..60", "--quiet"];
        works(&[&arguments[..], more].concat());
        fs::read(&file).unwrap()
    };
    for number in [20, 57, 60] {
        let npz = model(&["--frame", &number.to_string()]);
        let (shape, mean) = array(&npz, "mean.npy");
        let background = image::open(out.join(format!("background/{number:06}.png"))).unwrap().into_rgb8();
        let rounded: Vec<u8> = mean[..320 * 240 * 3].iter().map(|level| level.round() as u8).collect();
        assert!(shape.ends_with(", 240, 320, 3") && rounded == background.into_raw(), "frame {number}");
        let (shape, weight) = array(&npz, "weight.npy");
        assert_eq!(shape.matches(", ").count(), 2);
        let sums = (0..320 * 240).map(|at| weight.iter().skip(at).step_by(320 * 240).sum::<f32>());
        assert!(sums.into_iter().all(|sum| (sum - 1.0).abs() < 1e-3));
    }
    let gray = model(&["--frame", "21", "--space", "gray", "--scale", "0.5", "--k", "2"]);
    assert_eq!(array(&gray, "mean.npy").0, "2, 120, 160, 1");
    assert_eq!(array(&gray, "variance.npy").0, "2, 120, 160");

    fs::remove_file(&file).unwrap();
    let refused = |more: &[&str], status: i32| {
        let line = fails(&[&["model", text(&video), "--out", text(&file)], more].concat(), status);
        assert!(!file.exists());
        line
    };
    assert!(refused(&["--frame", "61", "--range", "20..60"], 2).contains("frame 61"));
    let beyond = refused(&["--frame", "500"], 1);
    assert!(beyond.contains("no frame 500") && beyond.contains("226"), "{beyond}");
    assert!(refused(&["--frame", "3", "--background-model", "knn"], 2).contains("knn"));
    let skipped = refused(&["--frame", "4", "--every", "2"], 1);
    assert!(skipped.contains("no frame 4") && skipped.contains("is 3"), "{skipped}");
}
