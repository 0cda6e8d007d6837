//! Ground truth and results that are damaged.

use std::fs;
use std::path::{Path, PathBuf};

use occluscope::truth::formats::{self, Role};
use occluscope::truth::sequence_truth::Occlusions;
use occluscope::truth::{Truth, event_scoring};

use crate::common::{TestFolder, text, works, write_images};
use crate::{Said, has_time};

const MOT: &str = "1,1,10,20,5,6,1,1,0.5\n2,1,11,20,5,6,1,1,1\n2,2,40,20,5,6,0,7,1\n";
const HEADER: &str = "frame;id;x;y;w;h\n1;1;10,5;20;5;6\n";
const CVAT: &str = "<?xml version=\"1.0\"?><annotations><track id=\"0\" label=\"a\">\
    <box frame=\"0\" outside=\"0\" xtl=\"1\" ytl=\"2\" xbr=\"3\" ybr=\"4\"/>\
    <polygon frame=\"1\" points=\"1,2;3,4;5,1\"/></track></annotations>";
const CAVIAR: &str = "<dataset><frame number=\"0\"><objectlist><object id=\"1\">\
    <box xc=\"5\" yc=\"6\" w=\"3\" h=\"4\"/></object></objectlist></frame></dataset>";
const COCO: &str = r#"{"images":[{"id":1,"frame_id":0,"file_name":"a/0001.png"}],
    "annotations":[{"id":1,"image_id":1,"track_id":2,"bbox":[1,2,3.5,4],"iscrowd":0}]}"#;
const EVENTS: &str = "{\"frame\":3,\"kind\":\"merge\",\"objects\":[1,2]}\n";
const EPISODES: &str = "kind,objects,start,end\ninter-object,1+2,10,20\n";

/// Contents that differ from a whole one in a bit or a byte of another kind, and beginnings of it; with time, all.
fn changed(whole: &str) -> Vec<Vec<u8>> {
    let bytes = whole.as_bytes();
    let mut all = Vec::new();
    for at in (0..bytes.len()).step_by(if has_time() { 1 } else { 3 }) {
        all.push(bytes[..at].to_vec());
        let others = (0..8).map(|bit| bytes[at] ^ (1 << bit)).chain(*b"-9e,<\"\0\n\xff");
        all.extend(others.map(|other| {
            let mut changed = bytes.to_vec();
            changed[at] = other;
            changed
        }));
    }
    all
}

fn assert_one_line(error: &str, path: &Path) {
    assert!(error.contains(text(path)) && !error.contains('\n'), "{error}");
}

#[test]
fn no_change_or_cut_of_a_file_of_tracks_is_a_panic() {
    let place = TestFolder::new();
    for (name, whole) in
        [("gt.txt", MOT), ("h.csv", HEADER), ("cvat.xml", CVAT), ("cvml.xml", CAVIAR), ("coco.json", COCO)]
    {
        let path = place.path(name);
        fs::write(&path, whole).unwrap();
        assert!(formats::read(&path, Role::Truth).unwrap().count() > 0, "{name}");
        for content in changed(whole) {
            fs::write(&path, content).unwrap();
            for role in [Role::Truth, Role::Results] {
                if let Err(error) = formats::read(&path, role) {
                    assert_one_line(&error.to_string(), &path);
                }
            }
        }
    }
}

#[test]
fn no_change_or_cut_of_events_and_episodes_is_a_panic() {
    let place = TestFolder::new();
    let (events, episodes) = (place.path("events.jsonl"), place.path("episodes.csv"));
    fs::write(&events, EVENTS).unwrap();
    fs::write(&episodes, EPISODES).unwrap();
    let read = Occlusions::read(&place.path(".")).unwrap();
    assert_eq!((read.events.len(), read.episodes.len()), (1, 1));
    for content in changed(EVENTS) {
        fs::write(&events, content).unwrap();
        if let Err(error) = event_scoring::read_events(&events) {
            assert_one_line(&error.to_string(), &events);
        }
    }
    for content in changed(EPISODES) {
        fs::write(&episodes, content).unwrap();
        if let Err(error) = event_scoring::read_episodes(&episodes) {
            assert_one_line(&error.to_string(), &episodes);
        }
    }
}

#[test]
fn extreme_numbers_and_depths_are_refused_or_read() {
    let place = TestFolder::new();
    let path = place.path("truth");
    let nested =
        |open: &str, close: &str, count: usize| format!("{}{}", open.repeat(count), close.repeat(count));
    let laughs = "<!DOCTYPE a [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;\">\
        <!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;\"><!ENTITY d \"&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;\">\
        <!ENTITY e \"&d;&d;&d;&d;&d;&d;&d;&d;&d;&d;\"><!ENTITY f \"&e;&e;&e;&e;&e;&e;&e;&e;&e;&e;\">\
        <!ENTITY g \"&f;&f;&f;&f;&f;&f;&f;&f;&f;&f;\"><!ENTITY h \"&g;&g;&g;&g;&g;&g;&g;&g;&g;&g;\">]>\
        <annotations><track id=\"0\">&h;</track></annotations>";
    for content in [
        "4294967295,4294967295,1e308,-1e308,1e308,1e308,1\n1,1,0,0,5,5,1\n".to_owned(),
        "0,0,0,0,0,0,0\n".to_owned(),
        "1,1,nan,0,5,5,1\n".to_owned(),
        "1,1,0,0,5,5,nan\n".to_owned(),
        "1e300,1,0,0,5,5,1\n".to_owned(),
        nested("<annotations>", "</annotations>", 100_000),
        nested("[", "]", 100_000),
        nested("{\"images\":", "}", 100_000),
        laughs.to_owned(),
        format!(
            "{{\"images\":[],\"annotations\":[{{\"id\":1,\"image_id\":9,\"bbox\":[{},1,1,1]}}]}}",
            "9".repeat(400)
        ),
        ",".repeat(1_000_000),
        "1 ".repeat(500_000),
        "\n".repeat(1_000_000),
    ] {
        fs::write(&path, &content).unwrap();
        if let Err(error) = formats::read(&path, Role::Truth) {
            let error = error.to_string();
            assert!(error.len() < 1000, "{error}");
            assert_one_line(&error, &path);
        }
    }
}

/// The results of a run on a few images.
fn results(place: &TestFolder) -> PathBuf {
    let (images, out) = (place.path("images"), place.path("results"));
    write_images(&images, 40, 1);
    works(&["run", text(&images), "--out", text(&out), "--masks", "--quiet", "--bootstrap", "0"]);
    out
}

#[test]
fn malformed_truth_is_told_by_the_program() {
    let place = TestFolder::new();
    let out = results(&place);
    let truth = place.path("truth.txt");
    for (content, part) in [
        (&b""[..], ""),
        (b"\n\n", ""),
        (b"no numbers here\n", "line 1"),
        (b"1,1,0,0,5,5,1\n1,2,0\n", "line 2"),
        (b"1,1,0,0,5,5,1\n1,1,0,0,5,5,1\n", "line 2"),
        (b"1,1,0,0,nan,5,1\n", "line 1"),
        (b"<annotations", "XML"),
        (b"<html></html>", "XML"),
        (b"{\"images\": 3}", "COCO"),
        (b"{\"images\": [", "COCO"),
        (b"PK\x03\x04rest", "zip"),
        (b"\xff\xfe1\0,\0", "UTF-16"),
        (b"1,1,0\0,0,5,5,1\n", "no text"),
    ] {
        fs::write(&truth, content).unwrap();
        let said = Said::of(&["score", text(&out), "--truth", text(&truth)]);
        if said.status == 0 {
            assert!(content.trim_ascii().is_empty(), "{}", content.escape_ascii());
        } else {
            let error = said.error();
            assert!(error.contains("truth.txt") && error.contains(part), "{error}");
        }
        assert!(said.status < 2);
    }
}

#[test]
fn damaged_masks_are_told_with_their_file() {
    let place = TestFolder::new();
    let out = results(&place);
    let truth = place.path("scene/groundtruth");
    fs::create_dir_all(&truth).unwrap();
    let mask = |number: u32| truth.join(format!("gt{number:06}.png"));
    let write = |number: u32, width: u32| {
        image::GrayImage::from_pixel(width, 72, image::Luma([0])).save(mask(number)).unwrap();
    };
    for number in 1..=40 {
        write(number, 96);
    }
    let score = |part: &str| {
        let said = Said::of(&["score", text(&out), "--truth", text(&place.path("scene"))]);
        let error = said.error().to_owned();
        assert!(said.status == 1 && error.contains(part), "{error}");
        assert_eq!(
            Truth::read(&place.path("scene")).map(|_| ()).map_err(|error| error.to_string().contains('\n')),
            Err(false)
        );
    };
    let whole = fs::read(mask(7)).unwrap();
    for content in [&b""[..], b"text", &whole[..30]] {
        fs::write(mask(7), content).unwrap();
        score("gt000007.png");
    }
    write(7, 50);
    score("000007.png");
    write(7, 96);
    for content in ["9 3", "a b", "", "5", "-1 5", "1 2 3 4"].into_iter().take(if has_time() { 6 } else { 2 })
    {
        fs::write(place.path("scene/temporalROI.txt"), content).unwrap();
        let said = Said::of(&["score", text(&out), "--truth", text(&place.path("scene"))]);
        assert!(said.status == 0 || said.error().contains("temporalROI.txt"), "{content}: {:?}", said.lines);
    }
    fs::remove_file(place.path("scene/temporalROI.txt")).unwrap();
    fs::write(place.path("scene/ROI.bmp"), "no image").unwrap();
    score("ROI.bmp");
}

#[test]
fn damaged_results_are_told_with_their_file() {
    let place = TestFolder::new();
    let out = results(&place);
    let truth = place.path("gt.txt");
    fs::write(&truth, "30,1,10,25,10,25,1\n").unwrap();
    let exported = place.path("exported");
    let score = ["score", text(&out), "--truth", text(&truth)];
    let export = ["export", text(&out), "--format", "coco", "--out", text(&exported)];
    let (places, changes) = if has_time() { (200, 4) } else { (3, 2) };
    for (name, readers) in [
        ("summary.json", &[&score[..], &export][..]),
        ("tracks.csv", &[&score[..]]),
        ("tracks.json", &[&export[..]]),
    ] {
        let path = out.join(name);
        let whole = fs::read(&path).unwrap();
        for at in (0..whole.len()).step_by(whole.len() / places + 1) {
            for change in [None, Some(b'9'), Some(b'-'), Some(b'"')].into_iter().take(changes) {
                let mut content = whole.clone();
                match change {
                    Some(other) => content[at] = other,
                    None => content.truncate(at),
                }
                fs::write(&path, content).unwrap();
                for said in
                    readers.iter().map(|arguments| Said::of(arguments)).filter(|said| said.status != 0)
                {
                    assert!(said.error().contains("results"), "{name}: {:?}", said.lines);
                }
            }
        }
        fs::write(&path, whole).unwrap();
    }
    // Numbers of frames that no run has.
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    for (from, to) in
        [("\"last_frame\": 40", "\"last_frame\": 4294967295"), ("\"frames\": 40", "\"frames\": 4294967295")]
    {
        assert!(summary.contains(from));
        fs::write(out.join("summary.json"), summary.replace(from, to)).unwrap();
        Said::of(&export);
        Said::of(&score);
    }
    let mut huge: serde_json::Value = serde_json::from_str(&summary).unwrap();
    huge["input"]["last_frame"] = u32::MAX.into();
    huge["input"]["frames"] = u32::MAX.into();
    huge["input"]["analysed"] = serde_json::json!([[1, u32::MAX]]);
    fs::write(out.join("summary.json"), huge.to_string()).unwrap();
    Said::of(&export).error();
    Said::of(&score);
}
