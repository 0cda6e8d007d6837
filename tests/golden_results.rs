//! Golden results: the tables and masks of some sequences are, bit by bit, those of `golden_results.txt`, with any number of
//! threads, any size of batches and any instruction set.
//!
//! Two groups: the sample videos through the program, and rendered scenes through the library. H.264 defines every bit of a
//! decoded picture, so the first group is the same everywhere. The frames of the second are drawn with the C library's sine, which
//! may differ between versions; their own hash is told first.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use common::{TestFolder, text};
use occluscope::export::tracks_json::TracksJson;
use occluscope::export::{episodes_csv, events_jsonl, regions_csv, tracks_csv};
use occluscope::frame::{Frame, Size};
use occluscope::pipeline::{Analysis, OfflineResult, Pipeline, offline_result};
use occluscope::registration::{CorrectionChoice, measure_all};
use occluscope::settings::{Preset, Settings};
use occluscope::synth::{Renderer, SceneParameters, catalogue};
use sha2::{Digest, Sha256};

/// Hashes by the names of what they are of.
type Hashes = BTreeMap<String, String>;

const UPDATE: &str = "UPDATE_SNAPSHOTS=1 cargo test --locked --test golden_results -- --test-threads=1";

fn hash(bytes: impl AsRef<[u8]>) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn golden_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden_results.txt")
}

/// The golden hashes of a group, without the group's name. In the file a line is a hash and `group/name`.
fn golden(group: &str) -> Hashes {
    let text = fs::read_to_string(golden_file()).unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.split_once("  "));
    let own = lines.filter_map(|(hash, name)| Some((name.strip_prefix(group)?.strip_prefix('/')?, hash)));
    own.map(|(name, hash)| (name.to_owned(), hash.to_owned())).collect()
}

/// Compares the hashes of a group with the golden ones, or writes them.
fn check(group: &str, found: &Hashes) {
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let text = fs::read_to_string(golden_file()).unwrap_or_default();
        let is_other = |line: &&str| !line.contains(&format!("  {group}/"));
        let mut lines: Vec<String> = text.lines().filter(is_other).map(str::to_owned).collect();
        lines.extend(found.iter().map(|(name, hash)| format!("{hash}  {group}/{name}")));
        lines.sort_by(|a, b| a[66..].cmp(&b[66..]));
        fs::write(golden_file(), lines.join("\n") + "\n").unwrap();
        return;
    }
    let golden = golden(group);
    let differ = |name: &&String| golden.get(*name) != found.get(*name);
    let names: BTreeSet<&String> = golden.keys().chain(found.keys()).filter(differ).collect();
    let frames = names.iter().find(|name| name.ends_with("/frames"));
    assert!(
        frames.is_none(),
        "{group}/{} are drawn differently here: another version of the C library, or a change of `synth`",
        frames.map_or("", |name| name)
    );
    assert!(
        names.is_empty(),
        "results changed: {names:?} of {group}. If that is meant, write the new hashes by\n    {UPDATE}\nand explain in the \
         commit why results change"
    );
}

/// The results of the program, run with these variables set.
fn run(video: &str, arguments: &[&str], variables: &[(&str, &str)]) -> Hashes {
    let folder = TestFolder::new();
    let out = folder.path("out");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_videos").join(video);
    let command = ["run", text(&path), "--out", text(&out), "--masks", "--labels"];
    let output =
        common::occluscope(&[&command, arguments].concat()).envs(variables.to_vec()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut hashes = Hashes::new();
    for table in ["tracks.csv", "tracks.json", "regions.csv", "events.jsonl", "episodes.csv"] {
        hashes.insert(format!("{video}/{table}"), hash(fs::read(out.join(table)).unwrap()));
    }
    for images in ["masks", "labels"] {
        let mut all = Sha256::new();
        for name in common::names(&out.join(images)) {
            // Not the files, which depend on the version of the encoder.
            let image = image::open(out.join(images).join(&name)).unwrap();
            all.update([name.as_bytes(), image.as_bytes()].concat());
        }
        hashes.insert(format!("{video}/{images}"), hash(all.finalize()));
    }
    hashes
}

#[test]
fn sample_videos_have_the_golden_results() {
    let mut found = Hashes::new();
    for (video, range) in [("crossing.mp4", "60..150"), ("tree.mp4", "75..150")] {
        let run = |threads: &str, variables: &[(&str, &str)]| {
            run(video, &["--range", range, "--threads", threads], variables)
        };
        let of_one = run("1", &[]);
        for threads in ["2", "5"] {
            assert_eq!(run(threads, &[]), of_one, "{video} with {threads} threads");
        }
        // OpenCV and the C library take the plainest code.
        let plain = [
            ("OPENCV_CPU_DISABLE", "SSE4.1,SSE4.2,AVX,FP16,FMA3,AVX2,AVX512-SKX"),
            ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-SSE4_1,-SSE4_2"),
        ];
        assert_eq!(run("2", &plain), of_one, "{video} on another processor");
        found.extend(of_one);
    }
    check("samples", &found);
}

/// The scenes, each with a preset: plain and with every addition, people and things in front of them, shake and light.
const SCENES: [(&str, Preset); 6] = [
    ("crossing", Preset::Plain),
    ("crossing", Preset::Default),
    ("meet-and-part", Preset::Paper),
    ("wall-edge", Preset::Default),
    ("jitter", Preset::Default),
    ("sudden-light", Preset::Default),
];

#[test]
fn rendered_scenes_have_the_golden_results() {
    let mut found = Hashes::new();
    for (name, preset) in SCENES {
        let parameters = SceneParameters {
            size: Size::new(96, 72),
            frames: Some(150),
            seed: 3,
            speed: 1.6,
            ..SceneParameters::default()
        };
        let scene = catalogue::scene(name, &parameters).unwrap();
        let renderer = Renderer::new(&scene);
        let frames: Vec<Frame> = (1..=scene.frames)
            .map(|number| renderer.frame(number).0.at_time(f64::from(number) / f64::from(scene.fps)))
            .collect();
        let settings = Settings::preset(preset);
        let analyse = |threads: usize, batch: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| analyse(&frames, &settings, scene.fps, batch))
        };
        let of_one = analyse(1, 16);
        for (threads, batch) in [(2, 1), (5, 7)] {
            assert_eq!(
                analyse(threads, batch),
                of_one,
                "{name} with {threads} threads, {batch} frames at a time"
            );
        }
        let prefix = format!("{name}-{}", preset.word());
        found.insert(
            format!("{prefix}/frames"),
            hash(frames.iter().flat_map(|frame| frame.rgb.clone()).collect::<Vec<u8>>()),
        );
        found.extend(of_one.into_iter().map(|(file, hash)| (format!("{prefix}/{file}"), hash)));
    }
    check("scenes", &found);
}

/// The hashes of all results of some frames, `batch` of them at a time.
fn analyse(frames: &[Frame], settings: &Settings, fps: f32, batch: usize) -> Hashes {
    let mut frames = frames.to_vec();
    measure_all(&mut frames, CorrectionChoice::new(settings));
    let frames: Vec<&Frame> = frames.iter().collect();
    let mut pipeline = Pipeline::new(settings, frames[0].size, fps).unwrap();
    let first = frames.len().min(settings.bootstrap.frames(fps) as usize);
    for some in frames[..first].chunks(batch) {
        pipeline.learn(some).unwrap();
    }
    let batches = frames.chunks(batch).flat_map(|some| pipeline.step_many(some).unwrap());
    let analyses: Vec<Analysis> = batches.collect();
    let OfflineResult { tracks, events, episodes, .. } = offline_result(&analyses, &pipeline);
    let rows = |analysis: &Analysis| regions_csv::FrameRows {
        number: analysis.number,
        rows: analysis.regions.iter().map(Into::into).collect(),
    };
    let rows: Vec<_> = analyses.iter().map(rows).collect();
    let times: Vec<_> = tracks.iter().map(|frame| (frame.number, frame.time)).collect();
    let masks: Vec<u8> = analyses.iter().flat_map(|analysis| analysis.mask.data.clone()).collect();
    Hashes::from([
        ("masks".to_owned(), hash(masks)),
        ("background".to_owned(), hash(pipeline.background_image().unwrap())),
        table("tracks.csv", |out| tracks.iter().try_for_each(|frame| tracks_csv::write_frame(out, frame))),
        table("tracks.json", |out| {
            let mut json = TracksJson::new(out)?;
            tracks.iter().try_for_each(|frame| json.write_frame(frame))?;
            json.finish()
        }),
        table("regions.csv", |out| {
            regions_csv::write_header(out)?;
            let mut frames = rows.iter().zip(&tracks);
            frames.try_for_each(|(rows, frame)| regions_csv::write_frame(out, rows, &frame.tracks))
        }),
        table("events.jsonl", |out| events_jsonl::write(out, &events, &times)),
        table("episodes.csv", |out| episodes_csv::write(out, &episodes)),
    ])
}

fn table(name: &str, write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> (String, String) {
    let mut bytes = Vec::new();
    write(&mut bytes).unwrap();
    (name.to_owned(), hash(bytes))
}
