//! `score`: agreement with motmetrics and TrackEval, a rendered scene from video to scores, and refused inputs.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;

use common::{TestFolder, fails, occluscope, text, works};
use image::{GrayImage, Luma};
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
fn scores_of_tracks_equal_those_of_motmetrics_and_trackeval() {
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
    // The results of TrackEval 1.3 for the same files.
    let expected = [
        ("hota", 0.576_553_392_319_447_4),
        ("deta", 0.642_275_317_481_741),
        ("assa", 0.517_604_943_409_107_6),
        ("loca", 0.800_369_464_077_102_3),
    ];
    for (short, long) in [("mota", "mota"), ("idf1", "idf1"), ("switches", "num_switches")] {
        assert_eq!(json[short], json["iou0.5"][long], "{short}");
    }
    for (key, value) in expected {
        let ours = json[key].as_f64().unwrap();
        assert!((ours - value).abs() <= 1e-12, "{key}: {ours}, where TrackEval has {value}");
    }
    let occlusion = &json["occlusion"];
    assert_eq!((&occlusion["episodes"], &occlusion["survived"]), (&1.into(), &1.into()));
    assert_eq!(json["identities_kept"], 0.5);
    assert!(
        ["masks", "events", "f", "precision", "episode_recall"].iter().all(|key| json.get(key).is_none())
    );
    let table = works(&["score", &results, "--truth", text(&truth)]);
    assert!(table.contains("MOTA 0.853") && table.contains("1 of 2 identities kept"), "{table}");
    assert!(table.contains("HOTA 0.577  DetA 0.642  AssA 0.518  LocA 0.800"), "{table}");
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
    let masks = [
        ("f", "f_measure"),
        ("precision", "precision"),
        ("recall", "recall"),
        ("pwc", "pwc"),
        ("specificity", "specificity"),
        ("fpr", "fpr"),
        ("fnr", "fnr"),
    ];
    for (short, long) in masks {
        assert_eq!(json[short], json["masks"][long], "{short}");
    }
    assert_eq!((&json["episode_recall"], &json["episode_precision"]), (&1.0.into(), &1.0.into()));
    assert_eq!(json["identities_kept"], 1.0);
    let table = works(&["score", text(&results), "--truth", text(&scene)]);
    assert!(
        table.contains("  all           TP 1, GT 1, reported 1: precision 1.000  recall 1.000"),
        "{table}"
    );
}

#[test]
fn unusable_inputs_of_score_fail_in_one_line() {
    let place = TestFolder::new();
    let results = place.path("results");
    fs::create_dir(&results).unwrap();
    let truth = place.path("gt.txt");
    fs::write(&truth, "1,1,0,0,5,five,1\n").unwrap();
    let tracks = results.join("tracks.csv");
    fs::write(&tracks, "").unwrap();
    let score = |truth: &str| fails(&["score", text(&results), "--truth", truth], 1);
    let line = score(text(&truth));
    assert!(line.contains("gt.txt") && line.contains("line 1") && line.contains("five"), "{line}");
    for row in [
        "4294967296,1,0,0,5,5,1",
        "1,4294967296,0,0,5,5,1",
        "-3,1,0,0,5,5,1",
        "1,1,nan,0,5,5,1",
        "1,1,0,0,-5,5,1",
    ] {
        fs::write(&truth, format!("1,1,0,0,5,5,1\n{row}\n")).unwrap();
        let line = score(text(&truth));
        assert!(line.contains("line 2"), "{row}: {line}");
    }
    fs::write(&truth, "1,1,0,0,5,5,1\n").unwrap();
    fs::remove_file(&tracks).unwrap();
    let line = score(text(&truth));
    assert!(line.contains("results cannot be used") && line.contains("its tracks.csv"), "{line}");
    fs::write(&tracks, "").unwrap();
    assert!(score("nowhere").contains("nowhere"));
    let other = place.path("other");
    fs::create_dir(&other).unwrap();
    assert!(score(text(&other)).contains("unknown ground truth"));
    GrayImage::new(4, 4).save(other.join("fg1.jpg")).unwrap();
    assert!(score(text(&other)).contains("JPEGs"));
    assert!(fails(&["score", text(&other), "--truth", text(&truth)], 1).contains("JPEGs"));
    for (name, word) in [("seqinfo.ini", "folder of the sequence"), ("tracks.json", "tracks.csv")] {
        fs::write(other.join(name), "[Sequence]\n").unwrap();
        assert!(score(text(&other.join(name))).contains(word));
    }
    let line = fails(&["score", text(&other.join("seqinfo.ini")), "--truth", text(&truth)], 1);
    assert!(line.contains("give a file of tracks"), "{line}");
    assert!(fails(&["score", "nowhere", "--truth", text(&truth)], 1).contains("nowhere"));
    fs::create_dir_all(results.join("groundtruth")).unwrap();
    assert!(score(text(&results)).contains("--masks"));
}

/// A folder with a file of true tracks and a results folder with those of [`tracks`].
struct Scored {
    place: TestFolder,
    results: String,
    truth: String,
}

impl Scored {
    fn new(truth: &str, found: &str) -> Self {
        let place = TestFolder::new();
        fs::create_dir(place.path("results")).unwrap();
        fs::write(place.path("gt.txt"), truth).unwrap();
        fs::write(place.path("results/tracks.csv"), found).unwrap();
        let (results, truth) =
            (text(&place.path("results")).to_owned(), text(&place.path("gt.txt")).to_owned());
        Self { place, results, truth }
    }

    /// The scores of the results, and stderr.
    fn score(&self, more: &[&str]) -> (Value, String) {
        scores(&self.results, &self.truth, more)
    }
}

/// The scores, without the path and offset of the ground truth that they state, and the notes.
fn scores(results: &str, truth: &str, more: &[&str]) -> (Value, String) {
    let mut arguments = vec!["score", results, "--truth", truth, "--json"];
    arguments.extend(more);
    let output = common::occluscope(&arguments).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {told}");
    let mut scores: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(scores.as_object_mut().unwrap().remove("truth_path"), Some(truth.into()));
    scores.as_object_mut().unwrap().remove("summary_sha256");
    assert!(scores.as_object_mut().unwrap().remove("offset").is_some_and(|offset| offset.is_i64()));
    (scores, told)
}

fn mota(scores: &Value) -> f64 {
    scores["iou0.5"]["mota"].as_f64().unwrap()
}

/// The rows of one walker by `step` pixels a frame in these frames, with an addition to the numbers.
fn walker(frames: std::ops::RangeInclusive<i64>, step: i64, addition: i64) -> String {
    let rows: Vec<_> = frames.map(|f| format!("{},1,{},50,20,40,1\n", f + addition, 10 + step * f)).collect();
    rows.concat()
}

#[test]
fn separators_and_headers_do_not_change_scores() {
    let (truth, found) = tracks();
    let plain = Scored::new(&truth, &found).score(&[]).0;
    assert!(mota(&plain) > 0.8);
    for (from, to) in [(",", " "), (",", "\t"), (",", ";"), (",", ", "), ("\n", "\r\n"), ("\n", "\r")] {
        let other = Scored::new(&truth.replace(from, to), &found.replace(from, to)).score(&[]).0;
        assert_eq!(other, plain, "{to:?}");
    }
    let header = "frame,id,bb_left,bb_top,bb_width,bb_height,conf,x,y,z\n";
    let headed = Scored::new(&format!("\u{feff}{header}{truth}"), &format!("{header}{found}"));
    assert_eq!(headed.score(&[]).0, plain);
    let wide: Vec<u8> = truth.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let wider: Vec<u8> = truth.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    for (start, bytes, name) in [
        (&[0xFF, 0xFE][..], &wide, "UTF-16"),
        (&[], &wide, "UTF-16"),
        (&[0xFF, 0xFE, 0, 0], &wider, "UTF-32"),
        (&[], &wider, "UTF-32"),
    ] {
        fs::write(&headed.truth, [start, bytes].concat()).unwrap();
        let line = fails(&["score", &headed.results, "--truth", &headed.truth], 1);
        assert!(line.contains("gt.txt") && line.contains(name), "{line}");
    }
}

#[test]
fn what_is_found_at_an_ignored_box_is_neither_right_nor_wrong() {
    let truth = walker(1..=20, 4, 0)
        + &walker(1..=20, 4, 0).replace(",1,", ",2,").replace(",50,20,40,1", ",150,20,40,0");
    let found = truth.replace(",40,0\n", ",40,1\n");
    let (score, told) = Scored::new(&truth, &found).score(&[]);
    assert_eq!((mota(&score), &score["iou0.5"]["precision"]), (1.0, &1.0.into()), "{score}");
    assert!(told.contains("20 boxes of confidence 0") && told.lines().count() == 1, "{told}");
}

#[test]
fn only_analysed_frames_are_judged() {
    let scored = Scored::new(&walker(1..=60, 4, 0), &walker(31..=40, 4, 0));
    let (score, told) = scored.score(&[]);
    assert_eq!(mota(&score), 1.0);
    assert!(
        told.contains("10 frames are judged, 31 to 40") && told.contains("50 frames of the ground"),
        "{told}"
    );
    // A summary states what was analysed, with or without objects.
    let summary = r#"{"input":{"frames":20,"first_frame":21,"last_frame":40}}"#;
    fs::write(scored.place.path("results/summary.json"), summary).unwrap();
    let (score, told) = scored.score(&[]);
    assert_eq!((mota(&score), &score["iou0.5"]["recall"]), (0.5, &0.5.into()));
    assert!(told.contains("20 frames are judged, 21 to 40;"), "{told}");
}

#[test]
fn a_file_of_tracks_is_judged_in_the_frames_of_its_run_or_sequence() {
    let scored = Scored::new(&walker(1..=60, 4, 0), &walker(11..=40, 4, 0));
    let tracks = scored.place.path("results/tracks.csv");
    let summary = r#"{"input":{"frames":50,"first_frame":1,"last_frame":50}}"#;
    fs::write(scored.place.path("results/summary.json"), summary).unwrap();
    let (of_file, told) = scores(text(&tracks), &scored.truth, &[]);
    assert_eq!((&of_file, mota(&of_file)), (&scored.score(&[]).0, 0.6), "as its folder");
    assert!(
        told.contains("50 frames are judged, 1 to 50, those in summary.json beside the tracks"),
        "{told}"
    );
    // Of another tracker the length of the sequence is what is known.
    let other = scored.place.path("results/other.txt");
    fs::rename(&tracks, &other).unwrap();
    let (score, told) = scores(text(&other), &scored.truth, &[]);
    assert!(mota(&score) == 1.0 && told.contains("the first to the last with a result"), "{told}");
    let sequence = scored.place.path("MOT-01");
    fs::create_dir_all(sequence.join("gt")).unwrap();
    fs::rename(&scored.truth, sequence.join("gt/gt.txt")).unwrap();
    fs::write(sequence.join("seqinfo.ini"), "[Sequence]\nseqLength=60\n").unwrap();
    for truth in [sequence.clone(), sequence.join("gt"), sequence.join("gt/gt.txt")] {
        let (score, told) = scores(text(&other), text(&truth), &[]);
        assert!(
            mota(&score) == 0.5 && told.contains("60 frames are judged, 1 to 60, the sequence's"),
            "{told}"
        );
    }
}

#[test]
fn ground_truth_without_a_judged_box_is_an_error() {
    let ignored = walker(1..=20, 4, 0).replace(",40,1\n", ",40,0\n");
    for truth in ["", "\n", &*ignored] {
        let scored = Scored::new(truth, &walker(1..=20, 4, 0));
        let line = fails(&["score", &scored.results, "--truth", &scored.truth], 1);
        assert!(line.contains("gt.txt") && line.contains("no box of it is judged"), "{line}");
        assert_eq!(line.contains("20 boxes of confidence 0"), truth == ignored, "{line}");
    }
    // Boxes in other frames than those that were analysed, which are within their range.
    let truth = walker(1..=3, 4, 0) + &walker(30..=33, 4, 0);
    let scored = Scored::new(&truth, &walker(10..=20, 4, 0));
    let line = fails(&["score", &scored.results, "--truth", &scored.truth], 1);
    assert!(line.contains("not among those that were analysed, 10 to 20"), "{line}");
    let summary = r#"{"input":{"frames":3,"first_frame":2,"last_frame":10,"analysed":[[2,10,4]]}}"#;
    fs::write(scored.place.path("results/summary.json"), summary).unwrap();
    fs::write(&scored.truth, walker(3..=4, 4, 0)).unwrap();
    let line = fails(&["score", &scored.results, "--truth", &scored.truth], 1);
    assert!(line.contains("no box in the analysed frames"), "{line}");
}

#[test]
fn other_frame_numbers_are_told_with_the_offset_that_mends_them() {
    for (addition, mend) in [(-1, "--offset 1"), (3, "--offset -3"), (-30, "--offset 30")] {
        let truth = walker(31..=60, 9, addition);
        let scored = Scored::new(&truth, &walker(31..=60, 9, 0));
        let line = if addition == -30 {
            fails(&["score", &scored.results, "--truth", &scored.truth], 1)
        } else {
            scored.score(&[]).1
        };
        assert!(line.contains(mend), "{line}");
        let offset = mend.trim_start_matches("--offset ");
        let (score, told) = scored.score(&["--offset", offset]);
        assert!(mota(&score) == 1.0 && !told.contains("warning"), "{score} {told}");
    }
    // Slow objects off by one match nearly as well: the frame 0 gives it away, or the last frame.
    let scored = Scored::new(&walker(0..=29, 1, 0), &walker(0..=29, 1, 1));
    assert!(scored.score(&[]).1.contains("--offset 1"));
    let summary = r#"{"input":{"frames":30,"first_frame":1,"last_frame":30}}"#;
    for (truth, mend) in [(walker(1..=30, 1, 3), "--offset -3"), (walker(1..=30, 1, 1), "--offset -1")] {
        let scored = Scored::new(&truth, &walker(1..=30, 1, 0));
        fs::write(scored.place.path("results/summary.json"), summary).unwrap();
        assert!(scored.score(&[]).1.contains(mend), "{mend}");
        assert!(!scored.score(&["--offset", mend.trim_start_matches("--offset ")]).1.contains("warning"));
    }
}

#[test]
fn masks_with_other_numbers_are_told_with_an_offset() {
    let place = TestFolder::new();
    let (truth, found) = (place.path("truth"), place.path("found"));
    fs::create_dir(&truth).unwrap();
    fs::create_dir(&found).unwrap();
    let mask = |number: u32| GrayImage::from_fn(40, 10, |x, _| Luma([if x / 3 == number { 255 } else { 0 }]));
    for number in 1..=9 {
        mask(number).save(truth.join(format!("{number:04}.png"))).unwrap();
        mask(number).save(found.join(format!("fg_{}.png", number + 2))).unwrap();
    }
    let (score, told) = scores(text(&found), text(&truth), &[]);
    assert_eq!(score["masks"]["f_measure"], 0.0);
    assert!(told.contains("7 frames are judged") && told.contains("--offset 2"), "{told}");
    let (score, told) = scores(text(&found), text(&truth), &["--offset", "2"]);
    assert_eq!((&score["masks"]["f_measure"], &score["masks"]["frames"]), (&1.0.into(), &9.into()));
    assert!(!told.contains("warning"), "{told}");
    // Large objects off by one match nearly as well.
    for number in 1..=9 {
        let large = |x: u32, _| Luma([if (number..number + 24).contains(&x) { 255 } else { 0 }]);
        GrayImage::from_fn(40, 10, large).save(truth.join(format!("{number:04}.png"))).unwrap();
        GrayImage::from_fn(40, 10, large).save(found.join(format!("fg_{}.png", number + 2))).unwrap();
    }
    let (score, told) = scores(text(&found), text(&truth), &["--offset", "1"]);
    assert!(score["masks"]["f_measure"].as_f64().unwrap() > 0.95 && told.contains("--offset 2"), "{told}");
    assert!(!scores(text(&found), text(&truth), &["--offset", "2"]).1.contains("warning"));
    let line = fails(&["score", text(&found), "--truth", text(&truth), "--offset", "-100"], 1);
    assert!(line.contains("no mask"), "{line}");
    let line = fails(&["score", text(&found), "--truth", text(&truth), "--offset", "100"], 1);
    assert!(line.contains("101 to 109") && line.contains("--offset 2"), "{line}");
    GrayImage::from_pixel(40, 10, Luma([127])).save(found.join("fg_3.png")).unwrap();
    let line = fails(&["score", text(&found), "--truth", text(&truth)], 1);
    assert!(line.contains("fg_3.png") && line.contains("127"), "{line}");
}

#[test]
fn folders_of_sequences_and_tracks_of_others_are_scored() {
    let (truth, found) = tracks();
    let scored = Scored::new(&truth, &found);
    let (expected, _) = scored.score(&[]);
    let sequence = scored.place.path("MOT-02");
    fs::create_dir_all(sequence.join("gt")).unwrap();
    fs::create_dir_all(sequence.join("img1")).unwrap();
    fs::copy(&scored.truth, sequence.join("gt/gt.txt")).unwrap();
    let tracks = scored.place.path("tracker.txt");
    fs::write(&tracks, found.replace(',', " ")).unwrap();
    for folder in [sequence.clone(), sequence.join("gt")] {
        assert_eq!(scores(&scored.results, text(&folder), &[]).0, expected);
        assert_eq!(scores(text(&tracks), text(&folder), &[]).0, expected);
    }
    // Of the wrong kind.
    let masks = scored.place.path("groundtruth");
    fs::create_dir(&masks).unwrap();
    GrayImage::new(4, 4).save(masks.join("gt000001.png")).unwrap();
    assert!(fails(&["score", text(&tracks), "--truth", text(&masks)], 1).contains("masks"));
    assert!(fails(&["score", text(&masks), "--truth", &scored.truth], 1).contains("boxes"));
}

#[test]
fn tracks_in_xml_json_and_label_images_are_ground_truth() {
    let place = TestFolder::new();
    let found = place.path("found.txt");
    fs::write(&found, walker(1..=8, 4, 0)).unwrap();
    let boxes = |f: i64| (f, 10 + 4 * f);
    let cvat: Vec<_> = (1..=8)
        .map(boxes)
        .map(|(f, x)| {
            format!(r#"<box frame="{}" outside="0" xtl="{x}" ytl="50" xbr="{}" ybr="90"/>"#, f - 1, x + 20)
        })
        .collect();
    let cvat =
        format!(r#"<annotations><track id="0" label="person">{}</track></annotations>"#, cvat.concat());
    let caviar: Vec<_> = (1..=8)
        .map(boxes)
        .map(|(f, x)| {
            let object = format!(r#"<object id="4"><box xc="{}" yc="70" w="20" h="40"/></object>"#, x + 10);
            format!(r#"<frame number="{}"><objectlist>{object}</objectlist></frame>"#, f - 1)
        })
        .collect();
    let caviar = format!(r#"<dataset name="a">{}</dataset>"#, caviar.concat());
    let images: Vec<_> = (1..=8).map(|f| format!(r#"{{"id":{f},"frame_id":{f}}}"#)).collect();
    let annotations: Vec<_> = (1..=8)
        .map(boxes)
        .map(|(f, x)| format!(r#"{{"id":{f},"image_id":{f},"track_id":2,"bbox":[{x},50,20,40]}}"#))
        .collect();
    let coco = format!(r#"{{"images":[{}],"annotations":[{}]}}"#, images.join(","), annotations.join(","));
    for (name, content) in [("cvat.xml", cvat), ("caviar.xml", caviar), ("coco.json", coco)] {
        let truth = place.path(name);
        fs::write(&truth, content).unwrap();
        let (score, told) = scores(text(&found), text(&truth), &[]);
        assert_eq!((mota(&score), &score["iou0.5"]["motp"]), (1.0, &0.0.into()), "{name}: {score} {told}");
    }
    let labels = place.path("labels");
    fs::create_dir(&labels).unwrap();
    for (f, left) in (1..=8).map(boxes) {
        let level = |x: u32, y: u32| {
            Luma([if (left..left + 20).contains(&i64::from(x)) && (50..90).contains(&y) {
                300_u16
            } else {
                0
            }])
        };
        let image = image::ImageBuffer::from_fn(80, 100, level);
        image.save(labels.join(format!("{f:06}.png"))).unwrap();
    }
    for (results, truth) in [(&found, &labels), (&labels, &found)] {
        let (score, told) = scores(text(results), text(truth), &[]);
        assert_eq!(mota(&score), 1.0, "{told}");
    }
    let zip = place.path("mot.zip");
    fs::write(&zip, b"PK\x03\x04rest").unwrap();
    assert!(fails(&["score", text(&found), "--truth", text(&zip)], 1).contains("unpack"));
    // The archives of `export`, which are those of CVAT, but stored.
    let archived = [("gt/gt.txt", walker(1..=8, 4, 0)), ("gt/labels.txt", "car\n".to_owned())];
    let archived: Vec<_> = archived.iter().map(|(name, content)| (*name, content.as_bytes())).collect();
    occluscope::export::zip::write(&mut fs::File::create(&zip).unwrap(), &archived).unwrap();
    let (score, told) = scores(text(&found), text(&zip), &[]);
    assert!(mota(&score) == 1.0 && told.contains("MOTChallenge text, 8 boxes in 8 frames"), "{told}");
}

/// A run into the folder of an earlier one that wrote masks: they are not of its settings.
#[test]
fn masks_of_an_earlier_run_are_not_scored() {
    let place = TestFolder::new();
    let (video, results) = (place.path("video"), place.path("results"));
    works(&["synth", "crossing", "--frames", "12", "--size", "96x72", "--out", text(&video)]);
    let run = |more: &[&str]| {
        let input = video.join("crossing.mp4");
        works(&[&["run", text(&input), "--out", text(&results), "--quiet"], more].concat())
    };
    let score = |truth: &str| {
        let output = occluscope(&["score", text(&results), "--truth", truth, "--json"]).output().unwrap();
        assert!(output.status.success());
        let score: Value = serde_json::from_slice(&output.stdout).unwrap();
        (!score["f"].is_null(), String::from_utf8(output.stderr).unwrap())
    };
    run(&["--masks"]);
    let (has_masks, told) = score(text(&video));
    assert!(has_masks && !told.contains("earlier run"), "{told}");
    run(&[]);
    assert!(results.join("masks/bin000001.png").is_file(), "they are kept");
    let (has_masks, told) = score(text(&video));
    assert!(!has_masks && told.contains("masks is of an earlier run"), "{told}");
    // Of ground truth of masks alone nothing is left to judge.
    let truth = place.path("masks of another");
    fs::rename(results.join("masks"), &truth).unwrap();
    let line = fails(&["score", text(&results), "--truth", text(&truth)], 1);
    assert!(line.contains("results has no masks; run again with --masks"), "{line}");
    fs::create_dir(results.join("masks")).unwrap();
    let line = fails(&["score", text(&results), "--truth", text(&truth)], 1);
    assert!(line.contains("earlier run") && line.contains("--masks"), "{line}");
}

/// Of boxes alone the meetings of true objects follow from their overlap.
#[test]
fn episodes_are_scored_against_true_boxes() {
    let place = TestFolder::new();
    let (video, results) = (place.path("video"), place.path("results"));
    works(&["synth", "crossing", "--out", text(&video)]);
    works(&["run", text(&video.join("crossing.mp4")), "--out", text(&results), "--quiet"]);
    let truth = place.path("gt.txt");
    fs::copy(video.join("truth/gt.txt"), &truth).unwrap();
    let (score, told) = scores(text(&results), text(&truth), &[]);
    let meetings = &score["meetings"];
    let counts = ["truth", "found", "reported", "right"].map(|name| meetings[name].as_u64().unwrap());
    assert_eq!(counts, [1; 4], "{score} {told}");
    assert_eq!([&score["episode_recall"], &score["episode_precision"]], [1.0, 1.0]);
    let printed = works(&["score", text(&results), "--truth", text(&truth)]);
    assert!(printed.contains("1 of 1 true meeting found: recall 1.000  1 of 1 reported right"), "{printed}");
    // Without the files of a run there is nothing to judge.
    let (score, _) = scores(text(&results.join("tracks.csv")), text(&truth), &[]);
    assert!(score["meetings"].is_null() && score["episode_recall"].is_null(), "{score}");
}
