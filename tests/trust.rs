//! What the program is made of, and what it touches: dependencies, `unsafe` code, the network, files.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::env;
use std::fs;
use std::io::ErrorKind;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{TestFolder, text, write_images};
use serde::Deserialize;
use spdx::{Expression, ParseMode};

/// The files with `unsafe` code, and how many places each has. A new one needs a reason that holds, in the attribute that
/// permits it, and a comment on each place that says why it is sound.
const UNSAFE: [(&str, usize); 3] = [
    // The signal of a file that is too large.
    ("src/cli/file_limit.rs", 1),
    // FFmpeg's log level for OpenCV can be set in the environment only.
    ("src/source/quiet.rs", 1),
    // Fields of FFmpeg's structures, and its log.
    ("src/source/video/raw.rs", 7),
];

/// The parts of `.deny.toml` that are checked here.
#[derive(Deserialize)]
struct Policy {
    licenses: Licences,
    bans: Bans,
    sources: Sources,
}

#[derive(Deserialize)]
struct Licences {
    allow: Vec<String>,
    exceptions: Vec<Exception>,
}

#[derive(Deserialize)]
struct Exception {
    #[serde(rename = "crate")]
    name: String,
    allow: Vec<String>,
}

#[derive(Deserialize)]
struct Bans {
    deny: Vec<Ban>,
}

#[derive(Deserialize)]
struct Ban {
    #[serde(rename = "crate")]
    name: String,
    reason: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Sources {
    allow_registry: Vec<String>,
}

/// A package of `Cargo.lock`.
#[derive(Deserialize)]
struct Locked {
    name: String,
    source: Option<String>,
    checksum: Option<String>,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn policy() -> Policy {
    toml::from_str(&fs::read_to_string(root().join(".deny.toml")).unwrap()).unwrap()
}

/// All packages of `Cargo.lock`, of every platform.
fn locked() -> Vec<Locked> {
    #[derive(Deserialize)]
    struct Lock {
        package: Vec<Locked>,
    }
    let lock: Lock = toml::from_str(&fs::read_to_string(root().join("Cargo.lock")).unwrap()).unwrap();
    lock.package
}

#[test]
fn every_package_is_of_a_known_source_and_unchanged() {
    let registries = policy().sources.allow_registry;
    let packages = locked();
    assert!(packages.len() > 100, "{}", packages.len());
    for Locked { name, source, checksum } in packages {
        match source {
            None => assert_eq!(name, env!("CARGO_PKG_NAME"), "{name} is a package of this folder"),
            Some(source) => {
                let registry = source.strip_prefix("registry+").unwrap_or(&source).to_owned();
                assert!(registries.contains(&registry), "{name} is from {source}");
                assert!(checksum.is_some(), "{name} has no checksum");
            }
        }
    }
}

#[test]
fn no_package_opens_the_network() {
    let names: BTreeSet<String> = locked().into_iter().map(|package| package.name).collect();
    let bans = policy().bans.deny;
    assert!(bans.len() > 10);
    for Ban { name, reason } in bans {
        assert!(!names.contains(&name), "{name} is a dependency: {reason}");
    }
    for (path, code) in sources() {
        // Tests serve streams.
        assert!(!path.starts_with("src") || !code.contains("std::net"), "{}", path.display());
    }
}

#[test]
fn every_package_has_a_permitted_licence() {
    let packages = packages();
    let Licences { allow, exceptions } = policy().licenses;
    let exceptions: BTreeMap<String, Vec<String>> =
        exceptions.into_iter().map(|exception| (exception.name, exception.allow)).collect();
    assert!(packages.len() > 100, "{}", packages.len());
    for (name, licence) in &packages {
        let licence = licence.as_deref().unwrap_or_else(|| panic!("{name} has no licence"));
        let licence = Expression::parse_mode(licence, ParseMode::LAX).unwrap();
        let more = exceptions.get(name).map_or(&[][..], Vec::as_slice);
        let is_permitted = |licence: String| allow.contains(&licence) || more.contains(&licence);
        assert!(licence.evaluate(|one| is_permitted(one.to_string())), "{name}: {licence}");
    }
    for name in exceptions.keys() {
        assert!(packages.iter().any(|(other, _)| other == name), "the exception for {name} is of no use");
    }
}

/// The names and licences of the packages on this platform, the window and the tests included.
fn packages() -> Vec<(String, Option<String>)> {
    #[derive(Deserialize)]
    struct Metadata {
        packages: Vec<Package>,
    }
    #[derive(Deserialize)]
    struct Package {
        name: String,
        license: Option<String>,
    }
    let cargo = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO")).current_dir(root()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let version = cargo(&["--version", "--verbose"]);
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let metadata = cargo(&[
        "metadata",
        "--locked",
        "--offline",
        "--all-features",
        "--format-version=1",
        "--filter-platform",
        host,
    ]);
    let Metadata { packages } = serde_json::from_str(&metadata).unwrap();
    packages.into_iter().map(|package| (package.name, package.license)).collect()
}

/// The paths of all Rust files of the project, and what is in them without comments.
fn sources() -> Vec<(PathBuf, String)> {
    let mut folders: Vec<PathBuf> =
        ["src", "tests", "benches", "fuzz/targets", "fuzz/fuzz_targets"].map(PathBuf::from).to_vec();
    let mut files = vec![PathBuf::from("build.rs")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = folder.join(entry.file_name());
            match path.extension() {
                _ if entry.path().is_dir() => folders.push(path),
                Some(ending) if ending == "rs" => files.push(path),
                _ => {}
            }
        }
    }
    let code = |path: &PathBuf| {
        let text = fs::read_to_string(root().join(path)).unwrap();
        let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        code.fold(String::new(), |code, line| code + line + "\n")
    };
    files.into_iter().map(|path| (path.clone(), code(&path))).collect()
}

#[test]
fn unsafe_code_is_where_it_has_a_reason() {
    let mut found = Vec::new();
    for (path, code) in sources() {
        // This file is about it.
        if path == Path::new("tests/trust.rs") {
            continue;
        }
        let places = ["unsafe {", "unsafe fn", "unsafe extern", "unsafe impl", "unsafe trait"];
        let count: usize = places.iter().map(|place| code.matches(place).count()).sum();
        assert!(!code.contains("allow(unsafe_code"), "{}: expect it with a reason", path.display());
        if count == 0 {
            continue;
        }
        let reasons = code.matches("expect(unsafe_code, reason = \"").count();
        assert!(reasons > 0, "{}: no reason for unsafe code", path.display());
        // The signature of a callback is no place where anything unsafe is done.
        let text = fs::read_to_string(root().join(&path)).unwrap();
        let sound = text.matches("// SAFETY: ").count();
        let done = code.matches("unsafe {").count();
        assert_eq!(sound, done, "{}: a place without its SAFETY", path.display());
        found.push((path.to_str().unwrap().replace('\\', "/"), count));
    }
    found.sort();
    let expected: Vec<_> = UNSAFE.iter().map(|(path, count)| ((*path).to_owned(), *count)).collect();
    assert_eq!(found, expected);
}

/// A local file that names an address is no address that the user gave.
#[test]
fn a_file_opens_no_connection() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = format!("http://{}/a", listener.local_addr().unwrap());
    let folder = TestFolder::new();
    let playlist = format!("#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXTINF:5,\n{address}.ts\n#EXT-X-ENDLIST\n");
    let key = format!(
        "#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXT-X-KEY:METHOD=AES-128,URI=\"{address}\"\n#EXTINF:5,\na.ts\n#EXT-X-ENDLIST\n"
    );
    let manifest = format!(
        "<?xml version=\"1.0\"?><MPD xmlns=\"urn:mpeg:dash:schema:mpd:2011\" type=\"static\" \
         mediaPresentationDuration=\"PT5S\"><Period><AdaptationSet mimeType=\"video/mp4\"><Representation id=\"1\" \
         bandwidth=\"1\"><BaseURL>{address}.mp4</BaseURL><SegmentBase indexRange=\"0-9\"/></Representation>\
         </AdaptationSet></Period></MPD>"
    );
    fs::write(folder.path("a.ts"), [0x47; 188 * 4]).unwrap();
    for (name, content) in [
        ("list.m3u8", playlist),
        ("key.m3u8", key),
        ("list.ffconcat", format!("ffconcat version 1.0\nfile {address}.mp4\n")),
        ("manifest.mpd", manifest),
        ("list.asx", format!("<asx version=\"3.0\"><entry><ref href=\"{address}\"/></entry></asx>")),
        (
            "stream.sdp",
            "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=a\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 5004 RTP/AVP 96\n".into(),
        ),
    ] {
        let path = folder.path(name);
        fs::write(&path, content).unwrap();
        for command in [
            &["pixel", text(&path), "--at", "0,0"][..],
            &["run", text(&path), "--out", text(&folder.path("out"))],
        ] {
            let output = common::occluscope(command).output().unwrap();
            assert_eq!(output.status.code(), Some(1), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        }
    }
    let connection = listener.accept().map(|(_, from)| from);
    assert_eq!(connection.unwrap_err().kind(), ErrorKind::WouldBlock, "a file was fetched");
    // The address itself is opened.
    let mut command = Command::new(env!("CARGO_BIN_EXE_occluscope"));
    let mut running = command
        .args(["pixel", &format!("{address}.mp4"), "--at", "0,0"])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    listener.set_nonblocking(false).unwrap();
    drop(listener.accept().unwrap());
    running.wait().unwrap();
}

/// All files below a folder, by their paths in it.
fn files_below(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path.clone());
            }
            found.insert(path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned());
        }
    }
    found
}

#[test]
fn only_what_the_user_names_is_written() {
    let place = TestFolder::new();
    let root = place.path("");
    let variables = [
        "HOME",
        "XDG_CONFIG_HOME",
        "XDG_CACHE_HOME",
        "XDG_DATA_HOME",
        "XDG_STATE_HOME",
        "XDG_RUNTIME_DIR",
        "TMPDIR",
    ];
    for name in variables.iter().chain(&["cwd"]) {
        fs::create_dir(place.path(name)).unwrap();
    }
    write_images(&place.path("input"), 40, 1);
    fs::write(place.path("gt.txt"), "1,1,10,25,10,25\n30,1,10,25,10,25\n").unwrap();
    fs::write(place.path("my.toml"), "k = 4\n").unwrap();
    fs::write(place.path("broken.toml"), "k = 99\n").unwrap();
    let [input, truth, toml, broken] =
        ["input", "gt.txt", "my.toml", "broken.toml"].map(|name| place.path(name));
    let [input, truth, toml, broken] = [&input, &truth, &toml, &broken].map(|path| text(path));
    let out = |name: &str| place.path(name).to_str().unwrap().to_owned();
    let (run, swept, scene) = (out("run"), out("swept"), out("scene"));
    let (model, coco, pixel) = (out("model.npz"), out("coco.json"), out("pixel.csv"));
    let all = ["--masks", "--labels", "--frames", "--annotated", "--background", "--plain-frames"];
    let analyse = [&["run", input, "--out", &run, "--settings", toml][..], &all].concat();
    for (arguments, status, named) in [
        (&analyse[..], 0, &["run"][..]),
        (&["pixel", input, "--at", "20,30"], 0, &[]),
        (&["pixel", input, "--at", "20,30", "--out", &pixel], 0, &["pixel.csv"]),
        (&["model", input, "--frame", "30", "--out", &model], 0, &["model.npz"]),
        (&["score", &run, "--truth", truth], 0, &[]),
        (&["score", &run, "--truth", truth, "--json"], 0, &[]),
        (&["export", &run, "--format", "coco", "--out", &coco], 0, &["coco.json"]),
        (&["sweep", input, "--truth", truth, "--grid", "k=3,4", "--out", &swept], 0, &["swept"]),
        (&["bench", input, "--frames", "32"], 0, &[]),
        (&["synth", "crossing", "--out", &scene, "--size", "96x72", "--frames", "10"], 0, &["scene"]),
        (&["settings"], 0, &[]),
        (&["--help"], 0, &[]),
        // What fails leaves nothing.
        (&["run", "nothing.mp4", "--out", &out("none")], 1, &[]),
        (&["run", truth, "--out", &out("none")], 1, &[]),
        (&["run", input, "--out", &out("none"), "--settings", broken], 2, &[]),
        (&["run", input, "--out", &out("none"), "--what"], 2, &[]),
        (&["export", input, "--format", "coco", "--out", &out("none")], 1, &[]),
    ] {
        let before = files_below(&root);
        let mut command = common::occluscope(arguments);
        command.env_clear().current_dir(place.path("cwd"));
        for name in ["PATH", "LD_LIBRARY_PATH"] {
            if let Some(value) = env::var_os(name) {
                command.env(name, value);
            }
        }
        for name in variables {
            command.env(name, place.path(name));
        }
        let output = command.output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {stderr}");
        let after = files_below(&root);
        let is_named = |path: &&String| {
            named.iter().any(|name| {
                path.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
            })
        };
        let unnamed: Vec<_> = after.difference(&before).filter(|path| !is_named(path)).collect();
        assert!(unnamed.is_empty(), "{arguments:?} wrote {unnamed:?}");
        assert!(before.is_subset(&after), "{arguments:?} removed {:?}", before.difference(&after));
        for name in named {
            assert!(after.contains(*name), "{arguments:?} wrote no {name}");
        }
        let hidden = after.iter().find(|path| path.split('/').any(|part| part.starts_with('.')));
        assert_eq!(hidden, None, "{arguments:?}");
    }
}
