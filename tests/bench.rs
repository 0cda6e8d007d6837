//! `bench`: the format of its output, and refused inputs. Speed itself is not tested.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{HEIGHT, TestFolder, WIDTH, fails, text, works, write_images};
use serde_json::Value;

const KEYS: [&str; 11] = [
    "frames",
    "width",
    "height",
    "k",
    "threads",
    "decode_mpx_s",
    "stream_mpx_s",
    "replay_mpx_s",
    "mog2_mpx_s",
    "knn_mpx_s",
    "pipeline_fps",
];

#[test]
fn results_are_printed_as_json_and_as_a_table() {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 40, 101);

    let json = works(&["bench", text(&video), "--json", "--k", "5", "--threads", "2"]);
    assert_eq!(json.lines().count(), 1);
    let figures: Value = serde_json::from_str(&json).unwrap();
    let object = figures.as_object().unwrap();
    assert_eq!(object.len(), KEYS.len(), "{json}");
    for key in KEYS {
        assert!(object[key].as_f64().is_some_and(|value| value > 0.0), "{key} in {json}");
    }
    for (key, value) in [("frames", 40), ("width", WIDTH), ("height", HEIGHT), ("k", 5), ("threads", 2)] {
        assert_eq!(object[key], value, "{key}");
    }

    let table = works(&["bench", text(&video), "--frames", "33", "--scale", "48x30"]);
    assert!(table.starts_with("33 frames of 48×30, K = 3"), "{table}");
    for row in ["decoding", "frame by frame", "replay", "MOG2", "KNN", "the whole analysis"] {
        assert!(table.contains(row), "{row} in {table}");
    }
}

#[test]
fn unmeasurable_inputs_fail_in_one_line() {
    let place = TestFolder::new();
    let video = place.path("images");
    write_images(&video, 5, 1);
    let line = fails(&["bench", text(&video)], 1);
    assert!(line.contains("5 frames") && line.contains("longer"), "{line}");
    assert!(fails(&["bench", text(&video), "--scale", "0x5"], 2).contains("--scale"));
    let vast = ["bench", text(&video), "--scale", "16384x16384", "--frames", "100000"];
    assert!(fails(&vast, 1).contains("memory"));
    assert!(fails(&["bench", text(&place.path("no.avi"))], 1).contains("no.avi"));
}
