//! `summary.json` and `tracks.json` of a run, which `export` and `score` read. A line `---` separates the two. What is exported
//! can be read as results.

use std::path::Path;

use occluscope::cli::{export, score};
use occluscope::truth::formats::{self, Role};

use super::check_message;
use super::folder::Folder;

const SEPARATOR: &[u8] = b"\n---\n";

pub fn run(data: &[u8]) {
    let folder = Folder::new();
    let at = data.windows(SEPARATOR.len()).position(|window| window == SEPARATOR);
    let (summary, tracks) = at.map_or((data, &[][..]), |at| (&data[..at], &data[at + SEPARATOR.len()..]));
    // Tables of many frames take long.
    let parsed: serde_json::Value = serde_json::from_slice(summary).unwrap_or_default();
    if parsed["input"]["frames"].as_u64().is_some_and(|frames| (10_000..1 << 26).contains(&frames)) {
        return;
    }
    folder.write("summary.json", summary);
    folder.write("tracks.json", tracks);
    let results = folder.path().to_str().unwrap();
    let out = folder.path().join("out");
    let boxes = serde_json::from_slice::<Vec<serde_json::Value>>(tracks).map(|boxes| boxes.len());
    for format in ["coco", "cvat", "mot"] {
        let arguments = ["export", results, "--format", format, "--out", out.to_str().unwrap(), "--quiet"];
        let matches = export::command().try_get_matches_from(arguments).unwrap();
        match (export::run(&matches), &boxes) {
            (Ok(()), Ok(boxes)) => check_file(&out, *boxes),
            (Ok(()), Err(_)) => {}
            (Err(error), _) => check_error(&error),
        }
    }
    // Without tracks it fails before it prints scores, but after it has read what was analysed.
    let truth = folder.write("truth.txt", b"1,1,0,0,5,5\n");
    let arguments = ["score", results, "--truth", truth.to_str().unwrap()];
    let matches = score::command().try_get_matches_from(arguments).unwrap();
    if let Err(error) = score::run(&matches) {
        check_error(&error);
    }
}

/// An exported file has these many boxes. CVAT's without any is refused.
fn check_file(path: &Path, boxes: usize) {
    match formats::read(path, Role::Results) {
        Ok(file) => assert_eq!(file.count(), boxes),
        Err(error) => assert_eq!(boxes, 0, "{error}"),
    }
}

/// The program makes one line of it.
fn check_error(error: &anyhow::Error) {
    check_message(&format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" "));
}
