//! `score`: agreement with motmetrics, a rendered scene from video to scores, and refused inputs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;

use common::{TestFolder, fails, text, works};
use serde_json::Value;

/// Three walkers, two of whom cross, and tracks of them with false negatives, shifted boxes, identity switches, and
/// false positives.
fn tracks() -> (String, String) {
    let (mut truth, mut found) = (String::new(), String::new());
    for f in 1..=60_i32 {
        for (i, x, y) in [(1, 10 + 4 * f, 50), (2, 250 - 4 * f, 54), (3, 20 + 2 * f, 120 + f / 3)] {
            if i == 3 && f > 50 {
                continue;
            }
            writeln!(truth, "{f},{i},{x},{y},20,40,1,-1,-1,-1").unwrap();
            if (f * 7 + i * 5) % 11 == 0 {
                continue;
            }
            let identity = match i {
                2 if f > 33 => 14,
                3 if (41..46).contains(&f) => 15,
                i => 10 + i,
            };
            let (x, y) = (x + (f * 3 + i) % 7 - 2, y + (f + i * 2) % 5 - 2);
            writeln!(found, "{f},{identity},{x},{y},{},{},1,-1,-1,-1", 20 + f % 4, 40 - f % 3).unwrap();
        }
        if f % 9 == 0 {
            writeln!(found, "{f},20,{},10,15,15,0.5,-1,-1,-1", 300 - f).unwrap();
        }
    }
    (truth, found)
}

#[test]
fn scores_of_tracks_equal_those_of_motmetrics() {
    let place = TestFolder::new();
    let (truth, found) = tracks();
    let results = place.path("results");
    fs::create_dir(&results).unwrap();
    fs::write(place.path("gt.txt"), truth).unwrap();
    fs::write(results.join("tracks.csv"), found).unwrap();
    let (results, truth) = (text(&results).to_owned(), place.path("gt.txt"));
    let json: Value =
        serde_json::from_str(&works(&["score", &results, "--truth", text(&truth), "--json"])).unwrap();
    // The results of motmetrics 1.4 for the same files, rounded to four places.
    let expected = [
        ("mota", 0.8529),
        ("motp", 0.2427),
        ("idf1", 0.7576),
        ("precision", 0.9625),
        ("recall", 0.9059),
        ("num_switches", 3.0),
        ("num_fragmentations", 15.0),
        ("mostly_tracked", 3.0),
        ("num_unique_objects", 3.0),
    ];
    for (key, value) in expected {
        let ours = json["iou0.5"][key].as_f64().unwrap();
        assert!((ours - value).abs() <= 0.000_05, "{key}: {ours}, where motmetrics has {value}");
    }
    let occlusion = &json["occlusion"];
    assert_eq!((&occlusion["episodes"], &occlusion["survived"]), (&1.into(), &1.into()));
    assert!(json.get("masks").is_none() && json.get("events").is_none());
    let table = works(&["score", &results, "--truth", text(&truth)]);
    assert!(table.contains("MOTA 0.853") && table.contains("1 of 2 identities kept"), "{table}");
}

#[test]
fn a_rendered_scene_is_scored_from_video_to_masks() {
    let place = TestFolder::new();
    let (scene, results) = (place.path("scene"), place.path("results"));
    works(&["synth", "crossing", "--noise", "6", "--out", text(&scene), "--quiet"]);
    let video = scene.join("crossing.mp4");
    works(&["run", text(&video), "--out", text(&results), "--masks", "--quiet"]);
    let json: Value =
        serde_json::from_str(&works(&["score", text(&results), "--truth", text(&scene), "--json"])).unwrap();
    for kind in ["enter", "exit", "merge", "demerge"] {
        let found = &json["events"][kind];
        assert_eq!((&found["precision"], &found["recall"]), (&1.0.into(), &1.0.into()), "{kind}: {found}");
    }
    assert_eq!(json["episodes"]["inter-object"]["matched"], 1);
    assert_eq!(json["occlusion"]["survival"], 1.0);
    assert!(json["iou0.5"]["mota"].as_f64().unwrap() > 0.8, "{json}");
    assert!(json["masks"]["f_measure"].as_f64().unwrap() > 0.85, "{json}");
}

#[test]
fn unusable_inputs_of_score_fail_in_one_line() {
    let place = TestFolder::new();
    let results = place.path("results");
    fs::create_dir(&results).unwrap();
    let truth = place.path("gt.txt");
    fs::write(&truth, "1,1,0,0,5,five,1\n").unwrap();
    let score = |truth: &str| fails(&["score", text(&results), "--truth", truth], 1);
    let line = score(text(&truth));
    assert!(line.contains("gt.txt") && line.contains("line 1") && line.contains("five"), "{line}");
    for row in [
        "4294967295,1,0,0,5,5,1",
        "1,4294967295,0,0,5,5,1",
        "-3,1,0,0,5,5,1",
        "1,1,nan,0,5,5,1",
        "1,1,0,0,-5,5,1",
    ] {
        fs::write(&truth, format!("1,1,0,0,5,5,1\n{row}\n")).unwrap();
        let line = score(text(&truth));
        assert!(line.contains("line 2"), "{row}: {line}");
    }
    fs::write(&truth, "1,1,0,0,5,5,1\n").unwrap();
    assert!(score(text(&truth)).contains("tracks.csv"));
    assert!(score("nowhere").contains("nowhere"));
    assert!(score(text(&results)).contains("unknown ground truth"));
    assert!(fails(&["score", "nowhere", "--truth", text(&truth)], 1).contains("nowhere"));
    fs::create_dir_all(results.join("groundtruth")).unwrap();
    assert!(score(text(&results)).contains("--masks"));
}
