//! Commands that write files, each with the files of an earlier run in its output folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{text, works, write_images};

/// The bytes of all files below a folder, by path; a folder has none.
pub(crate) type Files = BTreeMap<String, Option<Vec<u8>>>;

/// The beginning of the names of temporary folders.
const HIDDEN: &str = ".occluscope-";

/// The files that are complete only with all others of their command.
const LAST: [&str; 3] = ["summary.json", "scene.json", "sweep.csv"];

/// A command that writes into a folder, and what it does without faults.
pub(crate) struct Work {
    pub(crate) name: &'static str,
    arguments: Vec<String>,
    /// The files in its folder before it.
    pub(crate) before: Files,
    /// The files in its folder after it.
    pub(crate) after: Files,
}

/// The inputs of all commands.
pub(crate) struct Inputs(TempDir);

impl Inputs {
    pub(crate) fn new() -> Self {
        // It stays until the next build: nothing drops what is kept for all tests.
        let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        write_images(&folder.path().join("images"), 26, 1);
        let scene = folder.path().join("scene");
        works(&["synth", "empty", "--frames", "4", "--size", "64x64", "--quiet", "--out", text(&scene)]);
        let results = folder.path().join("results");
        works(&["run", &Self::path(&folder, "images"), "--quiet", "--out", text(&results)]);
        Self(folder)
    }

    fn path(folder: &TempDir, name: &str) -> String {
        text(&folder.path().join(name)).to_owned()
    }

    /// All commands. `OUT` in their arguments is the folder; the earlier command has other ones.
    pub(crate) fn works(&self) -> Vec<Work> {
        let images = Self::path(&self.0, "images");
        let truth = Self::path(&self.0, "scene");
        let results = Self::path(&self.0, "results");
        let work = |name: &'static str, line: &str, earlier: &str| {
            let fill = |line: &str| -> Vec<String> {
                let words = line.split_whitespace().map(|word| match word {
                    "IMAGES" => images.clone(),
                    "TRUTH" => truth.clone(),
                    "RESULTS" => results.clone(),
                    "VIDEO" => format!("{truth}/empty.mp4"),
                    word => word.to_owned(),
                });
                words.chain(["--quiet".to_owned()]).collect()
            };
            Work::new(name, fill(line), &fill(earlier))
        };
        vec![
            work(
                "run",
                "run IMAGES --out OUT --masks --labels --frames --annotated --range 15..26 --min-area 20",
                "run IMAGES --out OUT --masks --annotated --range 13..20 --alpha 0.03",
            ),
            work("pixel", "pixel IMAGES --at 3,4 --out OUT/a.csv", "pixel IMAGES --at 9,9 --out OUT/a.csv"),
            work("model", "model IMAGES --frame 9 --out OUT/a.npz", "model IMAGES --frame 3 --out OUT/a.npz"),
            work(
                "export",
                "export RESULTS --format mot --out OUT/a.zip",
                "export RESULTS --format coco --out OUT/a.zip",
            ),
            work(
                "sweep",
                "sweep VIDEO --truth TRUTH --grid k=3,4 --grid t=0.6,0.8 --out OUT",
                "sweep VIDEO --truth TRUTH --grid k=2,4 --grid t=0.6,0.7 --out OUT",
            ),
            work(
                "synth",
                "synth empty --frames 3 --size 64x64 --out OUT",
                "synth empty --frames 5 --size 64x64 --seed 2 --out OUT",
            ),
            work(
                "synth lossless",
                "synth empty --frames 3 --size 64x64 --lossless --out OUT",
                "synth empty --frames 2 --size 64x64 --seed 2 --lossless --out OUT",
            ),
        ]
    }
}

impl Work {
    fn new(name: &'static str, arguments: Vec<String>, earlier: &[String]) -> Self {
        let mut work = Self { name, arguments, before: Files::new(), after: Files::new() };
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("mine.txt"), "mine").unwrap();
        Self::run_plainly(earlier, place.path());
        work.before = files(place.path());
        let arguments = work.arguments.clone();
        Self::run_plainly(&arguments, place.path());
        work.after = files(place.path());
        assert!(work.before.len() > 1 && hidden(&work.after).is_empty(), "{name}");
        work
    }

    fn run_plainly(arguments: &[String], folder: &Path) {
        let arguments = filled(arguments, folder);
        works(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    }

    /// The arguments with this output folder.
    pub(crate) fn arguments(&self, folder: &Path) -> Vec<String> {
        filled(&self.arguments, folder)
    }

    /// A folder with the files of the earlier run.
    pub(crate) fn place(&self) -> TempDir {
        let place = tempfile::tempdir().unwrap();
        for (path, bytes) in &self.before {
            let path = place.path().join(path);
            match bytes {
                Some(bytes) => fs::write(path, bytes).unwrap(),
                None => fs::create_dir(path).unwrap(),
            }
        }
        place
    }

    /// How the files differ from those before the run; nothing where they are the same. Complete rows of a sweep may have been
    /// added.
    pub(crate) fn changes(&self, found: &Files) -> Vec<String> {
        differences(&self.before, found, |path, before, found| {
            path == "rows.jsonl" && found.starts_with(before) && are_rows(found)
        })
    }

    /// How the files differ from those of the run without faults, apart from times.
    pub(crate) fn faults(&self, found: &Files) -> Vec<String> {
        differences(&self.after, found, is_equal_but_for_times)
    }

    /// The files that are neither of before nor of after the run, apart from temporary ones.
    pub(crate) fn broken(&self, found: &Files) -> Vec<String> {
        let is_whole = |path: &str, bytes: &Option<Vec<u8>>| {
            let after = self.after.get(path);
            let is_new = match (after, bytes) {
                (Some(Some(after)), Some(bytes)) => is_equal_but_for_times(path, after, bytes),
                (after, _) => after == Some(bytes),
            };
            // A row that is being added is cut off by the next sweep.
            let before = self.before.get(path).and_then(Option::as_ref);
            let is_log = path == "rows.jsonl"
                && before.zip(bytes.as_ref()).is_some_and(|(before, bytes)| bytes.starts_with(before));
            is_new || is_log || self.before.get(path) == Some(bytes)
        };
        let found_here = found.iter().filter(|(path, _)| !path.starts_with(HIDDEN));
        let broken = found_here.filter(|(path, bytes)| !is_whole(path, bytes)).map(|(path, _)| path.clone());
        // The last file is taken away before the others are replaced, so that it never stands beside half of them.
        let lost = self.before.keys().filter(|path| {
            !LAST.contains(&path.as_str()) && self.after.contains_key(*path) && !found.contains_key(*path)
        });
        broken.chain(lost.map(|path| format!("{path} is lost"))).collect()
    }
}

fn filled(arguments: &[String], folder: &Path) -> Vec<String> {
    arguments.iter().map(|word| word.replace("OUT", text(folder))).collect()
}

fn differences(
    expected: &Files,
    found: &Files,
    is_allowed: impl Fn(&str, &[u8], &[u8]) -> bool,
) -> Vec<String> {
    let mut differences = Vec::new();
    for (path, bytes) in expected {
        match (bytes, found.get(path)) {
            (Some(expected), Some(Some(found))) if expected == found || is_allowed(path, expected, found) => {
            }
            (None, Some(None)) => {}
            (_, None) => differences.push(format!("{path} is missing")),
            _ => differences.push(format!("{path} differs")),
        }
    }
    let new = found.keys().filter(|path| !expected.contains_key(*path));
    differences.extend(new.map(|path| format!("{path} is new")));
    differences
}

/// The temporary files.
pub(crate) fn hidden(files: &Files) -> Vec<String> {
    files.keys().filter(|path| path.contains(HIDDEN)).cloned().collect()
}

/// The bytes of all files below a folder.
pub(crate) fn files(folder: &Path) -> Files {
    fn add(root: &Path, folder: &Path, files: &mut Files) {
        for entry in fs::read_dir(folder).unwrap() {
            let path: PathBuf = entry.unwrap().path();
            let name = text(path.strip_prefix(root).unwrap()).to_owned();
            if path.is_dir() {
                files.insert(name, None);
                add(root, &path, files);
            } else {
                files.insert(name, Some(fs::read(&path).unwrap()));
            }
        }
    }
    let mut all = Files::new();
    add(folder, folder, &mut all);
    all
}

fn are_rows(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    text.ends_with('\n') && text.lines().all(|line| serde_json::from_str::<Value>(line).is_ok())
}

/// Whether two files of the same run differ in nothing but the seconds that it took.
fn is_equal_but_for_times(path: &str, a: &[u8], b: &[u8]) -> bool {
    let [a, b] = [a, b].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    match path {
        "summary.json" => {
            let [a, b] = [a, b].map(|text| {
                serde_json::from_str::<Value>(&text).map(|mut value| {
                    value["timing"].take();
                    value
                })
            });
            matches!((a, b), (Ok(a), Ok(b)) if a == b)
        }
        "sweep.csv" => {
            let [a, b] = [&a, &b].map(|text| {
                text.lines().map(|line| line.rsplit_once(',').map(|(row, _)| row)).collect::<Vec<_>>()
            });
            a == b
        }
        "rows.jsonl" => are_rows(b.as_bytes()) && a.lines().count() == b.lines().count(),
        "report.html" => b.trim_end().ends_with("</html>"),
        _ => a.as_bytes() == b.as_bytes() && a == b,
    }
}
