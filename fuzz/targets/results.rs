//! `summary.json` and `tracks.json` of a run, which `export` and `score` read. A line `---` separates the two.

use occluscope::cli::{export, score};

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
    let out = out.to_str().unwrap();
    for format in ["coco", "cvat", "mot"] {
        let arguments = ["export", results, "--format", format, "--out", out, "--quiet"];
        let matches = export::command().try_get_matches_from(arguments).unwrap();
        if let Err(error) = export::run(&matches) {
            check_error(&error);
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

/// The program makes one line of it.
fn check_error(error: &anyhow::Error) {
    check_message(&format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" "));
}
