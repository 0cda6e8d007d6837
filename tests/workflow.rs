//! The workflow in `workflow/`, run by Snakemake: killed in the middle and run again, it does the rest.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs::{self, File};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, SystemTime};

use common::{TABLES, TestFolder, names, text, works};

const SEQUENCES: [&str; 2] = ["crossing", "tree"];
const SETTINGS: [&str; 4] = ["k=3_t=0.6", "k=3_t=0.8", "k=4_t=0.6", "k=4_t=0.8"];

/// A workflow in a folder of its own.
struct Workflow {
    place: TestFolder,
}

impl Workflow {
    /// With this configuration of sequences and settings.
    fn new(config: &str) -> Self {
        let place = TestFolder::new();
        let program = env!("CARGO_BIN_EXE_occluscope");
        fs::write(place.path("config.yaml"), format!("program: {program:?}\n{config}")).unwrap();
        Self { place }
    }

    /// The two samples under four settings.
    fn of_samples() -> Self {
        let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_videos");
        let sequences = SEQUENCES.map(|name| {
            let (video, truth) = (samples.join(format!("{name}.mp4")), samples.join("truth").join(name));
            format!("  {name}: {{video: {:?}, truth: {:?}}}\n", text(&video), text(&truth))
        });
        let sequences = sequences.concat();
        Self::new(&format!(
            "sequences:\n{sequences}grid: [\"k=3,4\", \"t=0.6..0.8:2\"]\noptions: --range 90..140\n"
        ))
    }

    /// Snakemake in the folder, in a process group of its own, with what it prints in a file.
    fn snakemake(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new("snakemake");
        let log = File::create(self.place.path("snakemake.log")).unwrap();
        command
            .args(["--snakefile", concat!(env!("CARGO_MANIFEST_DIR"), "/workflow/Snakefile")])
            .args(["--configfile", "config.yaml", "--cores", "2"])
            .args(arguments)
            .current_dir(self.place.path(""))
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .process_group(0);
        command
    }

    fn works(&self, arguments: &[&str]) {
        let status = self.snakemake(arguments).status().expect(MISSING);
        assert!(status.success(), "{}", self.log());
    }

    /// What Snakemake printed.
    fn log(&self) -> String {
        fs::read_to_string(self.place.path("snakemake.log")).unwrap()
    }

    /// The folders of all runs.
    fn runs(&self) -> Vec<PathBuf> {
        let runs = self.place.path("results/runs");
        let of_sequence = |sequence| SETTINGS.map(|setting| runs.join(sequence).join(setting));
        SEQUENCES.into_iter().flat_map(of_sequence).collect()
    }

    /// Checks that the table has this number of lines, none of which was computed again.
    fn check_sweep(&self, lines: usize) {
        let file = |name: &str| fs::read_to_string(self.place.path("results/sweep").join(name)).unwrap();
        assert_eq!(file("sweep.csv").lines().count(), lines, "{}", file("sweep.csv"));
        assert!(!self.place.path("results/sweep/rows.jsonl").exists(), "rows were computed again");
        assert!(file("report.html").trim_end().ends_with("</html>"));
    }

    /// The files of scores that exist.
    fn scores(&self) -> Vec<PathBuf> {
        self.runs().iter().map(|run| run.join("score.json")).filter(|path| path.exists()).collect()
    }
}

const MISSING: &str =
    "the program `snakemake` is needed: apt-get install snakemake, or pip install snakemake";

/// When each table and the score of a run were written.
fn times(run: &Path) -> Vec<SystemTime> {
    let files = TABLES.into_iter().chain(["score.json"]);
    files.map(|name| run.join(name).metadata().unwrap().modified().unwrap()).collect()
}

fn check_json(path: &Path) {
    let content = fs::read_to_string(path).unwrap();
    assert!(serde_json::from_str::<serde_json::Value>(&content).is_ok(), "{}: {content}", path.display());
}

#[test]
fn a_killed_workflow_goes_on_where_it_was() {
    let workflow = Workflow::of_samples();
    let mut first = workflow.snakemake(&[]).spawn().expect(MISSING);
    let mut finished = Vec::new();
    while workflow.scores().len() < 4 {
        assert!(first.try_wait().unwrap().is_none(), "{}", workflow.log());
        // Of those that were there before two more were scored, Snakemake knows that they are complete.
        if finished.len() < 2 {
            finished = workflow.scores();
        }
        thread::sleep(Duration::from_millis(20));
    }
    let group = format!("-{}", first.id());
    assert!(Command::new("kill").args(["-KILL", "--", &group]).status().unwrap().success());
    first.wait().unwrap();
    assert!(workflow.scores().len() < workflow.runs().len(), "it was over before it was killed");
    // Whatever has its final name is complete.
    for run in workflow.runs() {
        for name in ["summary.json", "tracks.json", "score.json"].map(|name| run.join(name)) {
            if name.exists() {
                check_json(&name);
            }
        }
    }
    let finished: Vec<_> = finished.iter().filter_map(|score| score.parent()).collect();
    let before: Vec<_> = finished.iter().map(|run| times(run)).collect();

    workflow.works(&["--unlock"]);
    workflow.works(&["--rerun-incomplete"]);
    let after: Vec<_> = finished.iter().map(|run| times(run)).collect();
    assert_eq!(before, after, "{}", workflow.log());
    for run in workflow.runs() {
        let expected: Vec<_> = ["episodes.csv", "events.jsonl", "regions.csv", "score.json"]
            .into_iter()
            .chain(["settings.toml", "summary.json", "tracks.csv", "tracks.json"])
            .collect();
        assert_eq!(names(&run), expected, "{}", run.display());
        check_json(&run.join("score.json"));
    }
    let table = fs::read_to_string(workflow.place.path("results/runs.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..4], ["sequence", "setting", "version", "sha256"]);
    let keys: Vec<_> = rows[1..].iter().map(|row| (row[0], row[1])).collect();
    let expected: Vec<_> =
        SEQUENCES.into_iter().flat_map(|name| SETTINGS.map(|setting| (name, setting))).collect();
    assert_eq!(keys, expected);
    assert!(rows[1..].iter().all(|row| row[2] == env!("CARGO_PKG_VERSION") && row[3].len() == 64), "{table}");
    workflow.check_sweep(1 + SEQUENCES.len() * SETTINGS.len());

    // Equal options need no run, other options need all.
    workflow.works(&["--dry-run"]);
    assert!(workflow.log().contains("Nothing to be done"), "{}", workflow.log());
    workflow.works(&["--dry-run", "--config", "options=--range 90..150"]);
    assert!(workflow.log().contains("arams have changed"), "{}", workflow.log());
}

#[test]
fn a_wrong_configuration_is_told() {
    let workflow = Workflow::of_samples();
    for (config, why) in [
        ("dataset=nowhere", "either `sequences` or `dataset`"),
        ("program=nowhere/occluscope", "`program` in the configuration"),
        ("grid=['k']", "k=3,4,5"),
        ("grid=['t=0.5..0.9']", "FIRST..LAST:COUNT"),
        ("grid=['rate=density..weight:2']", "no setting rate that has ranges"),
        ("grid=['k=3..5:9']", "twice"),
    ] {
        let status = workflow.snakemake(&["--dry-run", "--config", config]).status().expect(MISSING);
        let log = workflow.log();
        assert!(!status.success() && log.contains(why), "{config}: {log}");
    }
}

#[test]
fn a_data_set_is_scored_under_the_values_that_sweep_has_and_its_masks_are_removed() {
    let workflow = Workflow::new(
        "dataset: data\noptions: --range 5..20\ngrid: [\"alpha=log:0.0007..0.03:3\", min-area=log:10..50:3]\n",
    );
    let scene = workflow.place.path("data/night/tree");
    works(&["synth", "tree", "--frames", "20", "--out", text(&scene), "--quiet"]);
    workflow.works(&[]);
    workflow.check_sweep(1 + 9);
    let run = workflow.place.path("results/runs/night/tree/alpha=0.0007_min-area=22");
    let score = fs::read_to_string(run.join("score.json")).unwrap();
    let score: serde_json::Value = serde_json::from_str(&score).unwrap();
    assert_eq!(score["masks"]["frames"], 16, "{score}");
    assert!(!run.join("masks").exists());
    workflow.works(&["--dry-run"]);
    assert!(workflow.log().contains("Nothing to be done"), "{}", workflow.log());
}
