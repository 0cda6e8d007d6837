//! Data sets and sweeps with damaged parts.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::common::{TestFolder, text, works, write_images};
use crate::{Said, has_time};

/// Data sets of four sequences in MOTChallenge's layout.
fn write_data_set(root: &Path) {
    for name in ["a", "b", "c", "d"] {
        write_images(&root.join(name).join("img1"), 30, 1);
        fs::create_dir(root.join(name).join("gt")).unwrap();
        fs::write(root.join(name).join("gt/gt.txt"), "30,1,10,25,10,25,1\n").unwrap();
    }
}

fn sweep(place: &TestFolder, flags: &[&str]) -> Said {
    let (root, out) = (place.path("set"), place.path("swept"));
    let arguments = ["sweep", "--dataset", text(&root), "--out", text(&out), "--bootstrap", "0"];
    let mut command = crate::common::occluscope(&[&arguments, flags].concat());
    let output = command.timeout(crate::PATIENCE).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<String> = stderr.lines().map(ToOwned::to_owned).collect();
    Said { status: output.status.code().unwrap(), stdout: String::from_utf8(output.stdout).unwrap(), lines }
}

/// The sequences of the table of a sweep.
fn swept(place: &TestFolder) -> Vec<String> {
    let mut reader = csv::Reader::from_path(place.path("swept/sweep.csv")).unwrap();
    reader.records().map(|row| row.unwrap()[0].to_owned()).collect()
}

#[test]
fn a_damaged_sequence_costs_no_other() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root);
    fs::write(root.join("b/gt/gt.txt"), "this is no truth\n").unwrap();
    for t in 1..=30 {
        fs::write(root.join(format!("c/img1/in{t:06}.png")), "no image").unwrap();
    }
    let said = sweep(&place, &[]);
    assert_eq!(said.status, 1);
    assert_eq!(swept(&place), ["a", "d"]);
    for (name, file) in [("b", "gt.txt"), ("c", "img1")] {
        let of = format!("warning: {name}: ");
        let told: Vec<_> = said.lines.iter().filter(|line| line.starts_with(&of)).collect();
        assert!(told.len() == 1 && told[0].contains(file), "{:?}", said.lines);
    }
    let errors: Vec<_> = said.lines.iter().filter(|line| line.starts_with("error: ")).collect();
    assert!(
        errors.len() == 1 && errors[0].contains("b: ") && errors[0].contains("1 more failed"),
        "{errors:?}"
    );
    let report = fs::read_to_string(place.path("swept/report.html")).unwrap();
    assert!(report.contains("gt.txt cannot be used"));
    // Mended, only what was missing is computed.
    fs::copy(root.join("a/gt/gt.txt"), root.join("b/gt/gt.txt")).unwrap();
    fs::remove_dir_all(root.join("c")).unwrap();
    assert_eq!(sweep(&place, &[]).status, 0);
    assert_eq!(swept(&place), ["a", "b", "d"]);
}

#[test]
fn a_data_set_without_a_usable_sequence_is_an_error() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root);
    for name in ["a", "b", "c", "d"] {
        fs::write(root.join(name).join("gt/gt.txt"), "this is no truth\n").unwrap();
    }
    let said = sweep(&place, &[]);
    assert!(said.status == 1 && said.error().contains("no sequence can be opened"), "{:?}", said.lines);
    assert!(said.error().contains("a/gt/gt.txt"), "{:?}", said.lines);
    assert!(!place.path("swept").exists());
}

#[test]
fn folders_that_are_left_out_are_told() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root);
    fs::remove_dir_all(root.join("a/gt")).unwrap();
    fs::create_dir_all(root.join("scene/truth")).unwrap();
    fs::write(root.join("scene/truth/gt.txt"), "").unwrap();
    fs::write(root.join("scene/scene.json"), "{\"video\": \"sc").unwrap();
    let said = sweep(&place, &[]);
    assert_eq!((said.status, swept(&place).len()), (0, 3));
    for (name, part) in [("a", "neither groundtruth/ nor gt/gt.txt"), ("scene", "scene.json is damaged")] {
        let told = |line: &String| line.contains(&format!("{name} below")) && line.contains(part);
        assert!(said.lines.iter().any(told), "{:?}", said.lines);
    }
}

#[test]
fn damaged_scores_of_runs_are_computed_again() {
    let place = TestFolder::new();
    let root = place.path("set");
    write_data_set(&root);
    let results = place.path("results");
    for name in ["a", "b", "c", "d"] {
        let (video, out) = (root.join(name), results.join(name));
        works(&["run", text(&video), "--out", text(&out), "--bootstrap", "0", "--quiet"]);
        let truth = root.join(name).join("gt/gt.txt");
        let score = works(&["score", text(&out), "--truth", text(&truth), "--json", "--quiet"]);
        let score = match name {
            // Half-written, impossible, and of another kind.
            "a" => score[..score.len() / 2].to_owned(),
            "b" => {
                let mut value: Value = serde_json::from_str(&score).unwrap();
                value["hota"] = json!(7.5);
                value.to_string()
            }
            "c" => "[1, 2, 3]".to_owned(),
            _ => score,
        };
        fs::write(out.join("score.json"), score).unwrap();
    }
    let said = sweep(&place, &["--results", text(&results)]);
    assert_eq!((said.status, swept(&place).len()), (0, 4), "{:?}", said.lines);
    for name in ["a", "b", "c"] {
        let told = |line: &&String| {
            line.starts_with("warning: ") && line.contains(&format!("results/{name}/score.json"))
        };
        assert_eq!(said.lines.iter().filter(told).count(), 1, "{:?}", said.lines);
    }
    assert!(said.lines.iter().any(|line| line.contains("1 rows are from 1 scored runs")), "{:?}", said.lines);
    let table = fs::read_to_string(place.path("swept/sweep.csv")).unwrap();
    assert!(!table.contains("7.5"), "{table}");
}

#[test]
fn damaged_rows_are_computed_again() {
    let place = TestFolder::new();
    write_data_set(&place.path("set"));
    assert_eq!(sweep(&place, &[]).status, 0);
    let table = |place: &TestFolder| -> Vec<String> {
        let text = fs::read_to_string(place.path("swept/sweep.csv")).unwrap();
        // The last column is time.
        text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect()
    };
    let expected = table(&place);
    let log = place.path("swept/rows.jsonl");
    let whole = fs::read_to_string(&log).unwrap();
    let edited = |key: &str, value: Value| {
        let mut lines: Vec<Value> = whole.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        lines[0]["measures"][key] = value;
        lines.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    for content in [
        edited("hota", json!(5.0)),
        edited("mota", json!(1e300)),
        edited("idf1", json!(-3)),
        edited("idf1", json!("high")),
        whole.replacen("\"seconds\":", "\"seconds\":-", 1),
        whole[..whole.len() / 2].to_owned(),
        "\u{0}\u{0}\u{0}\n".repeat(100),
        String::new(),
        format!("{}\n{whole}", "[".repeat(10_000)),
    ]
    .into_iter()
    .step_by(if has_time() { 1 } else { 3 })
    {
        fs::write(&log, content).unwrap();
        assert_eq!(sweep(&place, &[]).status, 0);
        assert_eq!(table(&place), expected);
    }
}
