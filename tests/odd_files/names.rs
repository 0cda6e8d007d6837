//! Names of files and folders with any characters.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

use crate::common::{TestFolder, occluscope, scene};
use crate::encoded::encode;
use crate::{Said, has_time};

/// Names that are hard to pass on: some with several difficulties, with time each by itself.
fn names() -> Vec<OsString> {
    let some = [
        "with blanks and  two: 100% sure",
        "%d%s%n%%",
        "camera:0",
        "-dash\n*?[x]{y}",
        "Straße – 日本語 \u{202e} 🎥",
        "#e\u{301}'\"`$HOME",
    ];
    let others = [
        " leading",
        "in%06d",
        "a:b:c",
        "http:x",
        "file:a",
        "concat:a|b",
        "--help",
        "new\nline",
        "tab\tand\rreturn",
        "back\\slash",
        "a..b",
        "~",
        ".hidden",
    ];
    let others = if has_time() { &others[..] } else { &[] };
    let mut names: Vec<OsString> = some.iter().chain(others).map(OsString::from).collect();
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStringExt as _;
        names.push(OsString::from_vec(b"caf\xe9 \xff\xfe\xc3\x28".to_vec()));
    }
    if has_time() {
        names.push("n".repeat(200).into());
    }
    names
}

fn write_images(folder: &Path, prefix: &str) {
    fs::create_dir(folder).unwrap();
    for t in 1..=3 {
        scene(t).save(folder.join(format!("{prefix}{t:03}.png"))).unwrap();
    }
}

/// The program in a working directory, given paths that need not be text.
fn program(place: &TestFolder, arguments: &[&str], paths: &[&Path]) -> Command {
    let mut command = occluscope(arguments);
    command.args(paths).current_dir(place.path("."));
    command
}

fn frames(out: &Path) -> u64 {
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    serde_json::from_str::<serde_json::Value>(&summary).unwrap()["input"]["frames"].as_u64().unwrap()
}

#[test]
fn folders_of_any_name_are_read_and_written() {
    let place = TestFolder::new();
    for (at, name) in names().iter().enumerate() {
        let inside = place.path(&format!("{at}"));
        fs::create_dir(&inside).unwrap();
        let (folder, mut out) = (inside.join(name), name.clone());
        write_images(&folder, "in");
        out.push(".out");
        let out = inside.join(out);
        Said::by(&mut program(&place, &["run", "--annotated", "--out"], &[&out, &folder])).warnings();
        assert_eq!(frames(&out), 3, "{name:?}");
        // A pattern in it, where the name has no other number.
        let pattern = folder.join("in%03d.png");
        let said = Said::by(&mut program(&place, &["run", "--out"], &[&out, &pattern]));
        said.warnings();
        assert_eq!(frames(&out), 3, "{name:?}");
        if !has_time() {
            continue;
        }
        // The score reads the name again.
        let truth = inside.join("gt.txt");
        fs::write(&truth, "1,1,0,0,9,9,1\n").unwrap();
        let scored = Said::by(&mut program(&place, &["score", "--json", "--truth"], &[&truth, &out]));
        assert!(scored.stdout.starts_with('{'), "{name:?}: {:?}", scored.lines);
    }
}

#[test]
fn videos_of_any_name_are_read() {
    let place = TestFolder::new();
    let video = place.path("video.mp4");
    assert!(encode(&video, "size=64x48:rate=25:duration=0.4", "libx264", ""));
    for (at, name) in names().iter().enumerate() {
        let inside = place.path(&format!("{at}"));
        fs::create_dir(&inside).unwrap();
        let mut name = name.clone();
        name.push(".mp4");
        let (path, out) = (inside.join(&name), inside.join("out"));
        fs::copy(&video, &path).unwrap();
        // Twice read, as pictures are drawn in a second pass; and by a name without a folder.
        Said::by(&mut program(&place, &["run", "--annotated", "--out"], &[&out, &path])).warnings();
        assert_eq!(frames(&out), 10, "{name:?}");
        let mut here = occluscope(&["run", "--out", "out", "--"]);
        Said::by(here.arg(&name).current_dir(&inside)).warnings();
    }
}

#[test]
fn images_of_any_name_are_frames() {
    for name in names() {
        let place = TestFolder::new();
        let folder = place.path("images");
        fs::create_dir(&folder).unwrap();
        for t in 1..=3 {
            let mut file = name.clone();
            file.push(format!("_{t}.png"));
            scene(t).save_with_format(folder.join(file), image::ImageFormat::Png).unwrap();
        }
        let out = place.path("out");
        let said = Said::by(&mut program(&place, &["run", "--out"], &[&out, &folder]));
        if name == ".hidden" {
            assert!(said.error().contains("no images"));
        } else {
            said.warnings();
            assert_eq!(frames(&out), 3, "{name:?}");
        }
    }
}

#[test]
fn a_missing_file_of_any_name_is_told_in_one_line() {
    let place = TestFolder::new();
    // The last ones are the worst.
    for name in names().into_iter().rev().take(if has_time() { 100 } else { 2 }) {
        let gone: PathBuf = place.path("gone").join(&name);
        for arguments in [
            &["run", "--out", "out"][..],
            &["pixel", "--at", "1,1"],
            &["bench"],
            &["score", "--truth", "gt.txt"],
            &["export", "--format", "coco", "--out", "o"],
        ] {
            let said = Said::by(&mut program(&place, arguments, &[&gone]));
            assert_eq!(said.lines.len(), 1, "{name:?} {arguments:?}: {:?}", said.lines);
            assert!(said.error().contains("gone"), "{:?}", said.lines);
        }
        for flag in ["--settings", "--roi"] {
            let mut command = occluscope(&["run", "video.mp4", "--out", "out", flag]);
            let said = Said::by(command.arg(&gone).current_dir(place.path(".")));
            assert!(said.error().contains("gone"), "{:?}", said.lines);
        }
    }
}

#[test]
fn data_sets_with_any_names_are_swept() {
    let place = TestFolder::new();
    let root = place.path("set");
    fs::create_dir(&root).unwrap();
    let names: Vec<OsString> = names().into_iter().filter(|name| name != ".hidden").collect();
    for name in &names {
        let sequence = root.join(name);
        fs::create_dir(&sequence).unwrap();
        write_images(&sequence.join("img1"), "");
        fs::create_dir(sequence.join("gt")).unwrap();
        fs::write(sequence.join("gt/gt.txt"), "1,1,0,0,9,9,1\n").unwrap();
    }
    let out = place.path("swept");
    let arguments = ["sweep", "--quiet", "--bootstrap", "0", "--dataset"];
    let sweep = || Said::by(program(&place, &arguments, &[&root]).arg("--out").arg(&out));
    assert_eq!(sweep().status, 0);
    let rows = csv::Reader::from_path(out.join("sweep.csv")).unwrap().records().count();
    assert_eq!(rows, names.len());
    // All rows are known the second time.
    let log = fs::read(out.join("rows.jsonl")).unwrap();
    assert_eq!(sweep().status, 0);
    assert_eq!(fs::read(out.join("rows.jsonl")).unwrap(), log);
}
