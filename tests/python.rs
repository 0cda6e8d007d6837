//! The Python example of `docs/results.md`, run on real results: pandas, NumPy and Pillow read what the program writes.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use common::{TestFolder, text, works};
use serde_json::Value;

/// What the example computes, as JSON.
const PRINTED: &str = r#"
print(json.dumps({
    "boxes": len(boxes), "ids": sorted(set(int(id) for id in boxes["id"])),
    "columns": [float(boxes[name].sum()) for name in ["x", "y", "w", "h"]],
    "tracks": len(tracks), "occluded": len(occluded), "seconds": seconds.values.tolist(),
    "events": len(events), "merges": merges["frame"].tolist(), "episodes": episodes["kind"].tolist(),
    "labels": [str(labels.dtype), *labels.shape], "areas": dict(zip(map(str, ids.tolist()), areas.tolist())),
    "background": [str(background.dtype), *background.shape], "pixel": background[100, 50].tolist(),
    "deviation": float(deviation.mean()), "components": int(components.max()),
}))
"#;

const MISSING: &str = "python3 with pandas, NumPy and Pillow is needed: apt-get install python3-pandas python3-numpy python3-pil";

/// The Python code in the documentation.
fn documented_example() -> String {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results.md")).unwrap();
    let (_, rest) = page.split_once("```python\n").unwrap();
    rest.split_once("```").unwrap().0.to_owned()
}

/// Runs code with the first Python that has the libraries: one in PATH can be another than the system's.
fn python(code: &str, folder: &Path) -> Output {
    let has_libraries = |program: &&str| {
        let imports = Command::new(program).args(["-c", "import numpy, pandas, PIL"]).output();
        imports.is_ok_and(|output| output.status.success())
    };
    let program = ["python3", "/usr/bin/python3"].into_iter().find(has_libraries).expect(MISSING);
    Command::new(program).args(["-c", code]).current_dir(folder).output().unwrap()
}

#[test]
fn the_documented_example_reads_all_results() {
    let place = TestFolder::new();
    let video = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_videos/crossing.mp4");
    let (video, out) = (text(&video), place.path("results"));
    works(&["run", video, "--out", text(&out), "--labels", "--quiet"]);
    works(&["model", video, "--frame", "120", "--out", text(&place.path("model.npz")), "--quiet"]);
    let code = documented_example() + PRINTED;
    let output = python(&code, &place.path(""));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();

    let tracks: Vec<Value> =
        serde_json::from_str(&fs::read_to_string(out.join("tracks.json")).unwrap()).unwrap();
    let of = |key: &str| found[key].as_array().unwrap().clone();
    let rows: Vec<Vec<f64>> = fs::read_to_string(out.join("tracks.csv"))
        .unwrap()
        .lines()
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    assert!(rows.len() > 150);
    assert_eq!(found["boxes"], rows.len());
    for (column, sum) in (2..6).zip(of("columns")) {
        let ours: f64 = rows.iter().map(|row| row[column]).sum();
        assert!((sum.as_f64().unwrap() - ours).abs() < 1e-6 * ours.abs(), "column {column}");
    }
    assert_eq!((of("ids"), &found["tracks"]), (vec![1.into(), 2.into()], &Value::from(tracks.len())));
    let occluded = tracks.iter().filter(|track| track["state"] != "visible").count();
    assert!(occluded > 0 && found["occluded"] == occluded);
    assert_eq!(of("seconds").len(), 2);
    let events = fs::read_to_string(out.join("events.jsonl")).unwrap();
    assert_eq!((&found["events"], of("merges").len()), (&events.lines().count().into(), 1));
    assert!(of("episodes").contains(&"inter-object".into()), "{found}");

    let labels = image::open(out.join("labels/000120.png")).unwrap().into_luma16();
    // Older versions of Pillow have 32 bits.
    assert!(["uint16", "int32"].iter().any(|name| of("labels")[0] == *name), "{found}");
    assert_eq!(of("labels")[1..], [Value::from(240), 320.into()]);
    for identity in [1_u16, 2] {
        let ours = labels.pixels().filter(|pixel| pixel.0 == [identity]).count();
        let found = found["areas"].get(identity.to_string()).map_or(0, |area| area.as_u64().unwrap());
        assert_eq!(found, ours as u64, "identity {identity}");
    }
    assert_eq!(of("background"), ["uint8".into(), Value::from(240), 320.into(), 3.into()]);
    let run = place.path("with-background");
    works(&["run", video, "--out", text(&run), "--background", "--range", "1..120", "--quiet"]);
    let background = image::open(run.join("background/000120.png")).unwrap().into_rgb8();
    let ours = background.get_pixel(50, 100).0.map(i64::from);
    for (ours, theirs) in ours.into_iter().zip(of("pixel")) {
        assert!((theirs.as_i64().unwrap() - ours).abs() <= 1, "{found}");
    }
    let components = found["components"].as_i64().unwrap();
    assert!((1..=8).contains(&components) && found["deviation"].as_f64().unwrap() > 0.0);
}
