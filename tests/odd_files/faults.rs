//! Files that cannot be read, go away or grow while they are read.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

use occluscope::source::{self, Options};

use crate::common::{TestFolder, occluscope, scene, text, write_images};
use crate::encoded::encode;
use crate::{Said, assert_refused, run};

/// The program as a user without rights, if there is a way to be one.
#[cfg(unix)]
fn unprivileged(place: &TestFolder, arguments: &[&str]) -> Option<assert_cmd::Command> {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    use std::os::unix::process::CommandExt as _;

    const NOBODY: u32 = 65534;
    let is_root = fs::metadata(place.path(".")).unwrap().uid() == 0;
    if !is_root {
        return Some(occluscope(arguments));
    }
    fs::set_permissions(place.path("."), fs::Permissions::from_mode(0o777)).unwrap();
    // The program may be in a folder of root's.
    let program = place.path("occluscope");
    if !program.exists() {
        let built = occluscope(&[]).get_program().to_owned();
        fs::hard_link(&built, &program).or_else(|_| fs::copy(&built, &program).map(drop)).unwrap();
    }
    let mut command = std::process::Command::new(program);
    command.args(arguments).uid(NOBODY).gid(NOBODY).env("HOME", place.path("."));
    let mut attempt = std::process::Command::new(command.get_program());
    let works = attempt.arg("--version").uid(NOBODY).gid(NOBODY).stdout(Stdio::null()).status();
    if !works.is_ok_and(|status| status.success()) {
        println!("left out: the program cannot be run as another user");
        return None;
    }
    Some(assert_cmd::Command::from_std(command))
}

#[cfg(unix)]
#[test]
fn what_may_not_be_read_is_told() {
    use std::os::unix::fs::PermissionsExt as _;

    let forbid = |path: &Path| fs::set_permissions(path, fs::Permissions::from_mode(0o000)).unwrap();
    let place = TestFolder::new();
    let out = place.path("out");
    let (video, folder, inside) = (place.path("video.mp4"), place.path("images"), place.path("some"));
    assert!(encode(&video, "size=64x48:rate=25:duration=1", "libx264", ""));
    write_images(&folder, 3, 1);
    write_images(&inside, 3, 1);
    for path in [&video, &folder, &inside.join("in000002.png")] {
        forbid(path);
    }
    for path in [&video, &folder, &folder.join("in%06d.png"), &folder.join("in000001.png")] {
        let Some(mut command) = unprivileged(&place, &["run", text(path), "--out", text(&out)]) else {
            return;
        };
        let said = Said::by(&mut command);
        let error = said.error();
        assert!(said.status == 1 && error.contains("ermission") && !out.exists(), "{error}");
    }
    let said = Said::by(&mut unprivileged(&place, &["run", text(&inside), "--out", text(&out)]).unwrap());
    let [warning] = said.warnings()[..] else { panic!("{:?}", said.lines) };
    assert!(warning.contains("frame 2 is skipped") && warning.contains("ermission"), "{warning}");
    // Other files.
    let file = place.path("file");
    fs::write(&file, "k = 3\n").unwrap();
    forbid(&file);
    let truth = place.path("gt.txt");
    fs::write(&truth, "1,1,0,0,5,5,1\n").unwrap();
    for arguments in [
        &["run", text(&inside), "--out", text(&out), "--settings", text(&file)][..],
        &["run", text(&inside), "--out", text(&out), "--roi", text(&file)],
        &["score", text(&out), "--truth", text(&file)],
        &["score", text(&file), "--truth", text(&truth)],
        &["sweep", text(&inside), "--truth", text(&file), "--out", text(&place.path("swept"))],
    ] {
        let said = Said::by(&mut unprivileged(&place, arguments).unwrap());
        let error = said.error();
        assert!(said.status > 0 && error.contains("ermission") && error.contains(text(&file)), "{error}");
    }
    for path in [&folder, &video] {
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused() {
    let place = TestFolder::new();
    let pipe = place.path("pipe.mp4");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert_refused(&place, &pipe, &["neither a file nor a folder"]);
    let socket = place.path("socket.mp4");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    assert_refused(&place, &socket, &["neither a file nor a folder"]);
    let circle = place.path("circle.mp4");
    std::os::unix::fs::symlink("circle.mp4", &circle).unwrap();
    assert_refused(&place, &circle, &[]);
    // A pipe among images is no frame, and a file is no folder.
    let folder = place.path("images");
    write_images(&folder, 3, 1);
    assert!(
        std::process::Command::new("mkfifo").arg(folder.join("in000002a.png")).status().unwrap().success()
    );
    run(&place, &folder, &[]).warnings();
    fs::remove_dir_all(place.path("out")).unwrap();
    assert_refused(&place, &folder.join("in000001.png/in000001.png"), &["does not exist"]);
}

#[test]
fn images_that_vanish_are_skipped() {
    let place = TestFolder::new();
    let folder = place.path("images");
    write_images(&folder, 6, 1);
    let mut source = source::open(text(&folder), Options::default()).unwrap();
    assert_eq!(source.next_frame().unwrap().unwrap().number, 1);
    fs::remove_file(folder.join("in000003.png")).unwrap();
    fs::remove_file(folder.join("in000005.png")).unwrap();
    let numbers: Vec<_> =
        std::iter::from_fn(|| source.next_frame().unwrap()).map(|frame| frame.number).collect();
    assert_eq!(numbers, [2, 4, 6]);
    let warnings = source.take_warnings();
    assert!(warnings.len() == 2 && warnings[0].contains("frame 3") && warnings[1].contains("frame 5"));
    // All of them, and then what was read before.
    let mut source = source::open(text(&folder), Options::default()).unwrap();
    let mut again = source.random_access().unwrap();
    fs::remove_dir_all(&folder).unwrap();
    assert!(source.next_frame().unwrap().is_some(), "the first one is read at opening");
    assert!(source.next_frame().unwrap().is_none());
    assert_eq!(source.take_warnings().len(), 3);
    let error = again.step(0, 0, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("images") && error.contains("changed while being read"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_video_that_vanishes_is_read_on_or_told() {
    let place = TestFolder::new();
    let video = place.path("video.mp4");
    assert!(encode(&video, "size=64x48:rate=25:duration=4", "libx264", "-g 10"));
    let mut source = source::open(text(&video), Options::default()).unwrap();
    source.next_frame().unwrap().unwrap();
    fs::remove_file(&video).unwrap();
    // An open file stays there for who reads it.
    assert_eq!(std::iter::from_fn(|| source.next_frame().unwrap()).count(), 99);
    let mut again = source.random_access().unwrap();
    let error = again.step(0, 5, &[]).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("video.mp4") && error.contains("changed while being read"), "{error}");
}

#[test]
fn a_growing_video_is_read_as_far_as_it_is_there_or_told() {
    let place = TestFolder::new();
    for (name, options) in [
        ("a.ts", "-g 10"),
        ("a.mkv", "-g 10"),
        ("a.mp4", "-g 10 -movflags frag_keyframe+empty_moov"),
        ("b.mp4", "-g 10"),
    ] {
        let whole = place.path("whole").with_extension(name.rsplit_once('.').unwrap().1);
        assert!(encode(&whole, "size=96x72:rate=25:duration=6", "libx264", options));
        let bytes = fs::read(&whole).unwrap();
        let path = place.path(name);
        let (start, rest) = bytes.split_at(bytes.len() / 3);
        fs::write(&path, start).unwrap();
        let (growing, rest) = (path.clone(), rest.to_vec());
        let writer = thread::spawn(move || {
            let mut file = File::options().append(true).open(growing).unwrap();
            for part in rest.chunks(rest.len() / 40 + 1) {
                file.write_all(part).unwrap();
                thread::sleep(Duration::from_millis(10));
            }
        });
        let said = run(&place, &path, &["--annotated"]);
        writer.join().unwrap();
        if said.status != 0 {
            assert!(said.error().contains(name), "{:?}", said.lines);
            assert!(!place.path("out/summary.json").exists());
        }
        let _ = fs::remove_dir_all(place.path("out"));
    }
}

#[test]
fn a_growing_folder_is_read_as_it_was_at_first() {
    let place = TestFolder::new();
    let folder = place.path("images");
    write_images(&folder, 20, 1);
    let mut source = source::open(text(&folder), Options::default()).unwrap();
    for t in 21..=30 {
        scene(t).save(folder.join(format!("in{t:06}.png"))).unwrap();
    }
    // One that is being written.
    fs::write(folder.join("in000031.png"), b"\x89PNG\r\n\x1a\n").unwrap();
    assert_eq!(std::iter::from_fn(|| source.next_frame().unwrap()).count(), 20);
    assert!(source.take_warnings().is_empty());
}
